//! Light with shadows: a sun, and a sky made of a few weak suns so that hollows and contacts are dark.

use super::raster::{fill_triangle, parallel};
use super::render::Triangle;
use bevy_cleave::testing::math::tangents;
use glam::{Vec2, Vec3};

/// Number of directions that stand for the sky, and the pixels along one side of their depth pictures.
const SKY_DIRECTIONS: usize = 24;
const SKY_RESOLUTION: usize = 512;
const SUN_RESOLUTION: usize = 2048;
/// Half the width of a blurred shadow edge, in pixels of the depth picture.
const SUN_BLUR: usize = 2;
const SKY_BLUR: usize = 1;
const SUN_COLOR: Vec3 = Vec3::new(2.5, 2.25, 1.9);
const SKY_COLOR: Vec3 = Vec3::new(0.66, 0.73, 0.85);
/// What the ground throws back at faces that look down.
const BOUNCE_COLOR: Vec3 = Vec3::new(0.17, 0.16, 0.14);

/// Edge of the blocks of a depth picture whose maximum tells at one glance that nothing is in the way.
const BLOCK: usize = 8;

/// Parallel light from one direction, and what it sees of the scene: the nearest depth for each pixel.
struct Light {
    /// Two axes across the light, then the direction towards it.
    axes: [Vec3; 3],
    /// Lower corner of the depth picture along the two axes, and its pixels per metre.
    corner: Vec2,
    scale: f32,
    resolution: usize,
    /// Coordinate towards the light of the nearest surface.
    nearest: Vec<f32>,
    /// The largest entry of `nearest` that a look-up may use whose corner is in a block of `BLOCK` pixels squared.
    blocks: Vec<f32>,
}

impl Light {
    fn new(towards: Vec3, resolution: usize, triangles: &[Triangle]) -> Self {
        let [u, v] = tangents(towards);
        let across = |p: Vec3| Vec2::new(p.dot(u), p.dot(v));
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for &p in triangles.iter().flat_map(|t| &t.positions) {
            low = low.min(across(p));
            high = high.max(across(p));
        }
        // A border of 4 pixels keeps the blur inside.
        let scale = (resolution as f32 - 8.0) / (high - low).max_element().max(1e-6);
        let mut light = Self {
            axes: [u, v, towards],
            corner: low - 4.0 / scale,
            scale,
            resolution,
            nearest: vec![f32::NEG_INFINITY; resolution * resolution],
            blocks: Vec::new(),
        };
        for t in triangles {
            let seen = t.positions.map(|p| light.project(p));
            let nearest = &mut light.nearest;
            fill_triangle(&seen, resolution, 0..resolution, |x, y, z| {
                let old = &mut nearest[y * resolution + x];
                *old = old.max(z);
            });
        }
        light.blocks = light.block_maxima();
        light
    }

    fn block_maxima(&self) -> Vec<f32> {
        let (side, count) = (self.resolution, self.resolution / BLOCK);
        let reach = BLOCK + 2 * SUN_BLUR.max(SKY_BLUR) + 1;
        let maximum = |i: usize| {
            let (x, y) = (i % count * BLOCK, i / count * BLOCK);
            (y..(y + reach).min(side))
                .flat_map(|row| &self.nearest[row * side..][x..(x + reach).min(side)])
                .fold(f32::NEG_INFINITY, |a, &b| a.max(b))
        };
        (0..count * count).map(maximum).collect()
    }

    /// Pixel coordinates, and metres towards the light.
    fn project(&self, p: Vec3) -> Vec3 {
        let [u, v, towards] = self.axes;
        let pixel = (Vec2::new(p.dot(u), p.dot(v)) - self.corner) * self.scale;
        pixel.extend(p.dot(towards))
    }

    /// What a surface receives, as a share of what one that faces the light in the open does.
    fn received<const BLUR: usize>(&self, point: Vec3, normal: Vec3) -> f32 {
        let facing = normal.dot(self.axes[2]);
        if facing > 0.0 {
            facing * self.reaches::<BLUR>(point, normal)
        } else {
            0.0
        }
    }

    /// The share of light, 0 to 1, that reaches a surface: the mean over `2 BLUR + 1` pixels each way.
    fn reaches<const BLUR: usize>(&self, point: Vec3, normal: Vec3) -> f32 {
        // A surface must not shade itself through the steps of the depth picture: look from a little above it.
        let pixel = 1.0 / self.scale;
        let seen = self.project(point + normal * (1.5 + BLUR as f32) * pixel);
        let limit = seen.z + 0.5 * pixel;
        let corner = Vec2::new(seen.x, seen.y) - (0.5 + BLUR as f32);
        let taps = 2 * BLUR + 2;
        let last = (self.resolution - taps) as f32;
        if corner.min_element() < 0.0 || corner.max_element() >= last {
            return 1.0;
        }
        let (x, y) = (corner.x as usize, corner.y as usize);
        if self.blocks[y / BLOCK * (self.resolution / BLOCK) + x / BLOCK] <= limit {
            return 1.0;
        }
        let (fx, fy) = (corner.x - x as f32, corner.y - y as f32);
        // A box that slides smoothly: full weight inside, the two rims share one pixel.
        let mut lit = 0.0;
        for j in 0..taps {
            let start = (y + j) * self.resolution + x;
            let row = &self.nearest[start..start + taps];
            let open = |i: usize| if row[i] <= limit { 1.0 } else { 0.0 };
            let inside: f32 = (1..taps - 1).map(open).sum();
            let sum = inside + (1.0 - fx) * open(0) + fx * open(taps - 1);
            lit += match j {
                0 => (1.0 - fy) * sum,
                j if j == taps - 1 => fy * sum,
                _ => sum,
            };
        }
        lit / ((taps - 1) * (taps - 1)) as f32
    }
}

/// Sun and sky over a scene.
pub struct Lights {
    sun: Light,
    sky: Vec<Light>,
}

impl Lights {
    /// Light from the sun in direction `towards_sun` and from a hemisphere about the y axis.
    pub fn new(towards_sun: Vec3, triangles: &[Triangle]) -> Self {
        let mut lights = parallel(SKY_DIRECTIONS + 1, |i| match i {
            0 => Light::new(towards_sun.normalize_or(Vec3::Y), SUN_RESOLUTION, triangles),
            _ => Light::new(sky_direction(i - 1), SKY_RESOLUTION, triangles),
        });
        let sky = lights.split_off(1);
        let sun = lights.pop().expect("the first is the sun");
        Self { sun, sky }
    }

    /// Light that a matt surface of `albedo` sends out.
    pub fn shade(&self, point: Vec3, normal: Vec3, albedo: Vec3) -> Vec3 {
        let sun = self.sun.received::<SUN_BLUR>(point, normal);
        let sky = self
            .sky
            .iter()
            .map(|light| light.received::<SKY_BLUR>(point, normal));
        // The mean of the cosine over the hemisphere is 1/2, so twice the mean is 1 under an open sky.
        let sky = sky.sum::<f32>() * 2.0 / self.sky.len() as f32;
        albedo * (SUN_COLOR * sun + SKY_COLOR * sky + BOUNCE_COLOR * (0.5 - 0.5 * normal.y))
    }
}

/// Point `i` of a spiral that covers the upper hemisphere evenly (a Fibonacci lattice).
fn sky_direction(i: usize) -> Vec3 {
    const GOLDEN_ANGLE: f32 = 2.399_963_2;
    let y = (i as f32 + 0.5) / SKY_DIRECTIONS as f32;
    let (sin, cos) = (i as f32 * GOLDEN_ANGLE).sin_cos();
    let radius = (1.0 - y * y).sqrt();
    Vec3::new(radius * cos, y, radius * sin)
}
