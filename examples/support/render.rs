//! Shaded pictures of bodies on the ground, drawn by the processor: what a stranger looks at to see what happened.

use super::light::Lights;
use super::picture::Picture;
use super::raster::{fill_triangle, parallel};
use bevy_cleave::geometry::TriMesh;
use bevy_cleave::math::Pose;
use glam::{Vec2, Vec3};

/// Samples per pixel along each axis; edges are smooth because a pixel is the mean of its samples.
const SAMPLES: usize = 2;
/// Rows of pixels that are drawn at a time.
const STRIP: usize = 8;
/// Sample owners that are not triangles.
const SKY: u32 = u32::MAX;
const GROUND: u32 = u32::MAX - 1;

const HORIZON_COLOR: Vec3 = Vec3::new(1.15, 1.27, 1.38);
const ZENITH_COLOR: Vec3 = Vec3::new(0.30, 0.56, 1.05);
const GROUND_COLORS: [Vec3; 2] = [Vec3::new(0.30, 0.295, 0.285), Vec3::new(0.355, 0.35, 0.34)];

/// Where the picture is taken from.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    eye: Vec3,
    /// Rightwards, downwards, forwards in the picture; unit vectors.
    axes: [Vec3; 3],
    /// Distance of the picture plane, in pixels.
    focal: f32,
    width: usize,
    height: usize,
    /// Distance from the eye to the target, m: the measure for how far away haze begins.
    reach: f32,
}

impl Camera {
    /// A camera at `eye` that looks at `target`; `fov_deg` is the angle from the lower to the upper edge.
    pub fn look_at(
        eye: Vec3,
        target: Vec3,
        up: Vec3,
        fov_deg: f32,
        width: usize,
        height: usize,
    ) -> Self {
        let forward = (target - eye).normalize_or(Vec3::NEG_Z);
        let right = forward.cross(up).normalize_or(Vec3::X);
        Self {
            eye,
            axes: [right, forward.cross(right), forward],
            focal: 0.5 * height as f32 / (0.5 * fov_deg.to_radians()).tan(),
            width,
            height,
            reach: eye.distance(target),
        }
    }

    fn center(&self) -> Vec2 {
        0.5 * Vec2::new(self.width as f32, self.height as f32)
    }

    /// Pixel and inverse depth (1/m) of a point; the inverse depth is not positive behind the camera.
    fn project(&self, point: Vec3) -> Vec3 {
        let [x, y, z] = self.axes.map(|axis| axis.dot(point - self.eye));
        (Vec2::new(x, y) * (self.focal / z) + self.center()).extend(1.0 / z)
    }

    /// Direction through a pixel, its part along the view axis one, so that depth is the distance measured in it.
    fn ray(&self, pixel: Vec2) -> Vec3 {
        let p = (pixel - self.center()) / self.focal;
        self.axes[0] * p.x + self.axes[1] * p.y + self.axes[2]
    }
}

/// A triangle in the world, ready to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    pub positions: [Vec3; 3],
    normals: [Vec3; 3],
    colors: [Vec3; 3],
}

/// Everything that will be in a picture. The ground is a checkerboard, one square per `cell`.
#[derive(Clone, Debug)]
pub struct Scene {
    triangles: Vec<Triangle>,
    /// Height of the ground, m; `None` for no ground.
    pub ground: Option<f32>,
    /// Edge length of a square on the ground, m.
    pub cell: f32,
    /// Direction towards the sun.
    pub towards_sun: Vec3,
}

impl Default for Scene {
    /// An empty scene on a ground at height zero with squares of one metre.
    fn default() -> Self {
        Self {
            triangles: Vec::new(),
            ground: Some(0.0),
            cell: 1.0,
            towards_sun: Vec3::new(-0.55, 1.0, 0.45),
        }
    }
}

impl Scene {
    /// Adds a body. `color` (linear RGB) is multiplied with the colors of the mesh where it has them.
    pub fn draw(&mut self, mesh: &TriMesh, pose: Pose, color: Vec3) {
        let world: Vec<Vec3> = mesh
            .positions()
            .iter()
            .map(|&p| pose.transform_point(p))
            .collect();
        self.triangles
            .extend(mesh.triangles().iter().map(|corners| {
                let positions = corners.map(|v| world[v as usize]);
                let [a, b, c] = positions;
                let flat = (b - a).cross(c - a).normalize_or(Vec3::Y);
                let normal = |v: u32| mesh.normals().get(v as usize).map(|&n| pose.rotation * n);
                let tint = |v: u32| mesh.colors().get(v as usize).map(|c| c.truncate());
                Triangle {
                    positions,
                    normals: corners.map(|v| normal(v).unwrap_or(flat)),
                    colors: corners.map(|v| color * tint(v).unwrap_or(Vec3::ONE)),
                }
            }));
    }

    /// Takes the picture.
    pub fn render(&self, camera: &Camera) -> Picture {
        // A piece that flew far away must not stretch the shadow pictures; from here its shadow is a dot.
        let near = |t: &&Triangle| t.positions[0].distance(camera.eye) < 4.0 * camera.reach;
        let casters: Vec<Triangle> = self.triangles.iter().filter(near).copied().collect();
        let lights = Lights::new(self.towards_sun, &casters);
        let seen: Vec<[Vec3; 3]> = self
            .triangles
            .iter()
            .map(|t| t.positions.map(|p| camera.project(p)))
            .collect();
        let strips = camera.height.div_ceil(STRIP);
        let bins = self.bins(&seen, strips);
        let painter = Painter {
            scene: self,
            camera,
            lights,
            seen,
        };
        let rows = parallel(strips, |strip| painter.paint_strip(strip, &bins[strip]));
        Picture {
            width: camera.width,
            height: camera.height,
            pixels: rows.concat(),
        }
    }

    /// For each strip of rows the triangles that touch it. A triangle that reaches behind the camera is left out.
    fn bins(&self, seen: &[[Vec3; 3]], strips: usize) -> Vec<Vec<u32>> {
        let mut bins = vec![Vec::new(); strips];
        for (i, [a, b, c]) in seen.iter().enumerate() {
            let (low, high) = (a.min(*b).min(*c), a.max(*b).max(*c));
            if low.z > 0.0 && high.y >= 0.0 {
                let first = (low.y.max(0.0) / STRIP as f32) as usize;
                let last = (high.y / STRIP as f32) as usize;
                for bin in bins.iter_mut().take(last + 1).skip(first) {
                    bin.push(i as u32);
                }
            }
        }
        bins
    }
}

/// Color `i` of an endless row of colors that differ well (linear RGB): the hue turns by the golden angle each time,
/// lightness and chroma stay (Oklch, Ottosson 2020).
pub fn palette(i: usize) -> Vec3 {
    let hue = 0.7 + i as f32 * 2.399_963_2;
    let lightness = [0.70, 0.62, 0.77][i % 3];
    let (a, b) = (0.115 * hue.cos(), 0.115 * hue.sin());
    let l = lightness + 0.396_337_78 * a + 0.215_803_76 * b;
    let m = lightness - 0.105_561_346 * a - 0.063_854_17 * b;
    let s = lightness - 0.089_484_18 * a - 1.291_485_5 * b;
    let [l, m, s] = [l, m, s].map(|x| x * x * x);
    let rgb = Vec3::new(
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_38 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    );
    rgb.clamp(Vec3::splat(0.01), Vec3::ONE)
}

struct Painter<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    lights: Lights,
    /// The triangles in the picture: pixel and inverse depth of the corners.
    seen: Vec<[Vec3; 3]>,
}

impl Painter<'_> {
    /// Pixels of strip number `strip`, in which `triangles` can be seen.
    fn paint_strip(&self, strip: usize, triangles: &[u32]) -> Vec<[u8; 3]> {
        let first = strip * STRIP;
        let rows = STRIP.min(self.camera.height - first);
        let (mut depths, mut owners) = self.background(first, rows);
        let width = self.camera.width * SAMPLES;
        for &triangle in triangles {
            let samples = self.seen[triangle as usize].map(|p| {
                let y = p.y - first as f32;
                (Vec2::new(p.x, y) * SAMPLES as f32).extend(p.z)
            });
            fill_triangle(&samples, width, 0..rows * SAMPLES, |x, y, z| {
                let i = y * width + x;
                if z > depths[i] {
                    depths[i] = z;
                    owners[i] = triangle;
                }
            });
        }
        (0..rows * self.camera.width)
            .map(|i| self.paint_pixel(i % self.camera.width, i / self.camera.width, first, &owners))
            .collect()
    }

    /// Inverse depth and owner of each sample while no body is drawn.
    fn background(&self, first: usize, rows: usize) -> (Vec<f32>, Vec<u32>) {
        let width = self.camera.width * SAMPLES;
        (0..width * rows * SAMPLES)
            .map(|i| self.ground_inverse_depth(sample_position(i % width, i / width, first)))
            .map(|z| if z > 0.0 { (z, GROUND) } else { (0.0, SKY) })
            .unzip()
    }

    /// Not positive where the ground is not seen.
    fn ground_inverse_depth(&self, pixel: Vec2) -> f32 {
        let below_eye = self
            .scene
            .ground
            .map_or(0.0, |height| height - self.camera.eye.y);
        if below_eye < 0.0 {
            self.camera.ray(pixel).y / below_eye
        } else {
            0.0
        }
    }

    /// Shades each owner of the pixel once, at the mean of its samples, and mixes by their number.
    fn paint_pixel(&self, x: usize, y: usize, first: usize, owners: &[u32]) -> [u8; 3] {
        const COUNT: usize = SAMPLES * SAMPLES;
        let width = self.camera.width * SAMPLES;
        let samples: [(u32, Vec2); COUNT] = std::array::from_fn(|i| {
            let (sx, sy) = (x * SAMPLES + i % SAMPLES, y * SAMPLES + i / SAMPLES);
            (owners[sy * width + sx], sample_position(sx, sy, first))
        });
        let mut color = Vec3::ZERO;
        for (i, &(owner, _)) in samples.iter().enumerate() {
            if samples[..i].iter().any(|s| s.0 == owner) {
                continue;
            }
            let own = samples[i..].iter().filter(|s| s.0 == owner);
            let (count, sum) = own.fold((0.0, Vec2::ZERO), |(n, sum), s| (n + 1.0, sum + s.1));
            color += tone(self.shade(owner, sum / count)) * (count / COUNT as f32);
        }
        color.to_array().map(|c| (c * 255.0).round() as u8)
    }

    /// Light that comes from what `owner` shows at `pixel`.
    fn shade(&self, owner: u32, pixel: Vec2) -> Vec3 {
        let ray = self.camera.ray(pixel);
        match owner {
            SKY => sky(ray.normalize().y),
            GROUND => self.shade_ground(pixel, ray),
            _ => self.shade_triangle(&self.scene.triangles[owner as usize], ray),
        }
    }

    fn shade_ground(&self, pixel: Vec2, ray: Vec3) -> Vec3 {
        let hit = |pixel: Vec2| {
            let depth = 1.0 / self.ground_inverse_depth(pixel).max(1e-6);
            self.camera.eye + depth * self.camera.ray(pixel)
        };
        let point = hit(pixel);
        let flat = |p: Vec3| Vec2::new(p.x, p.z) / self.scene.cell;
        let beside = (flat(hit(pixel + Vec2::X)) - flat(point)).abs();
        let below = (flat(hit(pixel + Vec2::Y)) - flat(point)).abs();
        let light = checker(flat(point), beside.max(below));
        let albedo = GROUND_COLORS[0].lerp(GROUND_COLORS[1], light);
        let haze = point.distance(self.camera.eye) / (8.0 * self.camera.reach);
        let clear = (-haze * haze).exp();
        sky(ray.normalize().y.max(0.0)).lerp(self.lights.shade(point, Vec3::Y, albedo), clear)
    }

    fn shade_triangle(&self, triangle: &Triangle, ray: Vec3) -> Vec3 {
        let [a, b, c] = triangle.positions;
        let (ab, ac, from_a) = (b - a, c - a, self.camera.eye - a);
        let area = ab.cross(ac);
        // Möller and Trumbore 1997: weights of b and c where the ray meets the plane.
        let facing = -ray.dot(area);
        let turned = from_a.cross(ray);
        let wb = (ac.dot(turned) / facing).clamp(0.0, 1.0);
        let wc = (-ab.dot(turned) / facing).clamp(0.0, 1.0 - wb);
        let wa = 1.0 - wb - wc;
        let mix = |[p, q, r]: [Vec3; 3]| p * wa + q * wb + r * wc;
        // The inside of an open shell is lit as if it were an outside.
        let normal = mix(triangle.normals).normalize_or(Vec3::Y) * facing.signum();
        self.lights
            .shade(mix(triangle.positions), normal, mix(triangle.colors))
    }
}

/// Position, in pixels of the picture, of a sample of a strip that begins at row `first`.
fn sample_position(x: usize, y: usize, first: usize) -> Vec2 {
    (Vec2::new(x as f32, y as f32) + 0.5) / SAMPLES as f32 + Vec2::new(0.0, first as f32)
}

/// 0 or 1 like a checkerboard with squares of edge one, averaged over a box of edges `size` around `p`.
///
/// The product of two square waves, each the difference of its integral, a triangle wave, across the box.
fn checker(p: Vec2, size: Vec2) -> f32 {
    let integral = |x: Vec2| 2.0 * ((0.5 * x).fract_gl() - 0.5).abs();
    let size = size.max(Vec2::splat(1e-4));
    let wave = (integral(p - 0.5 * size) - integral(p + 0.5 * size)) / size;
    0.5 - 0.5 * wave.x * wave.y
}

/// Color of the sky at the sine of the height angle.
fn sky(height: f32) -> Vec3 {
    HORIZON_COLOR.lerp(ZENITH_COLOR, height.clamp(0.0, 1.0).sqrt())
}

/// From light to sRGB, 0 to 1: a shoulder that keeps bright faces from clipping, then the transfer curve.
fn tone(light: Vec3) -> Vec3 {
    let x = light.max(Vec3::ZERO) * 0.8;
    // Reinhard's curve with white at 2.5.
    let x = x * (1.0 + x / 6.25) / (1.0 + x);
    x.min(Vec3::ONE).map(|c| {
        if c <= 0.003_130_8 {
            12.92 * c
        } else {
            1.055 * c.powf(1.0 / 2.4) - 0.055
        }
    })
}
