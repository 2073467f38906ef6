//! Volume, first and second moments of a solid, as sums over its surface.
//!
//! The sums are exact for the polyhedron given, up to rounding in `f64`. They belong to a point, the apex, and are sums
//! over signed tetrahedra between the apex and the triangles of the surface, so those of a part of the surface can be
//! added and taken away.
//!
//! # References
//! - F. Tonon, "Explicit Exact Formulas for the 3-D Tetrahedron Inertia Tensor in Terms of its Vertex Coordinates",
//!   Journal of Mathematics and Statistics 1(1), 2004.
//! - B. Mirtich, "Fast and Accurate Computation of Polyhedral Mass Properties", Journal of Graphics Tools 1(2), 1996.

use crate::geometry::face::Face;
use crate::geometry::triangle_corners::TrianglesOf;
use crate::simd::dispatch::run;
use crate::simd::lanes::{Kernel, LaneWidth, Lanes};
use glam::{DMat3, DVec3, Vec3};
use std::ops::{Add, Neg, Sub};

/// Sums over the tetrahedra between the origin and triangles `(a, b, c)`, with `d = a . (b x c)`, six times the volume of
/// one, and `s = a + b + c`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Moments {
    /// `sum of d`: six volumes, m3.
    pub(crate) six_volumes: f64,
    /// `sum of d s`: 24 times the first moments, m4.
    pub(crate) first: DVec3,
    /// Diagonal of `sum of d (s s^T + a a^T + b b^T + c c^T)`: 120 times the second moments, m5.
    diagonal: DVec3,
    /// Entries (y, z), (z, x) and (x, y) of the same.
    products: DVec3,
}

impl Moments {
    /// Adds the tetrahedron between the origin and a triangle.
    pub(crate) fn add_triangle(&mut self, a: DVec3, b: DVec3, c: DVec3) {
        let d = a.dot(b.cross(c));
        let s = a + b + c;
        let turned = |v: DVec3| DVec3::new(v.y * v.z, v.z * v.x, v.x * v.y);
        self.six_volumes += d;
        self.first += d * s;
        self.diagonal += d * (s * s + a * a + b * b + c * c);
        self.products += d * (turned(s) + turned(a) + turned(b) + turned(c));
    }

    /// From the point that the sums are about to the centroid, m.
    pub(crate) fn arm(&self) -> DVec3 {
        self.first / (4.0 * self.six_volumes)
    }

    /// From the volume, first and second moments themselves.
    pub(crate) fn of_integrals(volume: f64, first: DVec3, second: DMat3) -> Self {
        let (x, y, z) = (second.x_axis, second.y_axis, second.z_axis);
        Self {
            six_volumes: 6.0 * volume,
            first: 24.0 * first,
            diagonal: 120.0 * DVec3::new(x.x, y.y, z.z),
            products: 120.0 * DVec3::new(y.z, z.x, x.y),
        }
    }

    /// 120 times the second moments, m5.
    pub(crate) fn second(&self) -> DMat3 {
        let (d, p) = (self.diagonal, self.products);
        DMat3::from_cols(
            DVec3::new(d.x, p.z, p.y),
            DVec3::new(p.z, d.y, p.x),
            DVec3::new(p.y, p.x, d.z),
        )
    }
}

impl Add for Moments {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            six_volumes: self.six_volumes + other.six_volumes,
            first: self.first + other.first,
            diagonal: self.diagonal + other.diagonal,
            products: self.products + other.products,
        }
    }
}

impl Sub for Moments {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self {
            six_volumes: self.six_volumes - other.six_volumes,
            first: self.first - other.first,
            diagonal: self.diagonal - other.diagonal,
            products: self.products - other.products,
        }
    }
}

impl Neg for Moments {
    type Output = Self;

    /// Those of the same surface with its other side out.
    fn neg(self) -> Self {
        Self::default() - self
    }
}

/// Triangles that are summed up side by side: as many `f64` as fit in the widest register. The order of the sums is the
/// same where registers are narrower.
const LANES: usize = 4;

/// One number of each triangle.
type F64x4 = [f64; LANES];

/// Polygons as triangles, whose moments are to be summed up.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fans {
    /// The triangles, and behind them room.
    triangles: Vec<[u32; 3]>,
    filled: usize,
}

impl Fans {
    /// Takes all polygons away, and keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.filled = 0;
    }

    /// Adds polygons as triangle fans about their first corners. Of a polygon there is a list of corners that begins with
    /// its own, and how many it has; one with two corners has no triangles.
    #[inline]
    pub(crate) fn add<'c>(&mut self, polygons: impl Iterator<Item = (&'c [u32], usize)>) {
        let mut filled = self.filled;
        for (from, count) in polygons {
            if let (Some(&[a, b, c, d]), 2..=4) = (from.first_chunk(), count)
                && let Some(room) = self.triangles.get_mut(filled..filled + 2)
            {
                // No branch between three corners and four, because there is no guessing: the next polygon writes over what
                // is too much.
                room.copy_from_slice(&[[a, b, c], [a, c, d]]);
                filled += count - 2;
            } else {
                filled = self.add_fan(filled, &from[..count]);
            }
        }
        self.filled = filled;
    }

    /// Adds those triangles of a list that have these indices.
    #[inline(never)]
    pub(crate) fn add_some(&mut self, all: &[[u32; 3]], indices: &[u32]) {
        let filled = self.filled + indices.len();
        if self.triangles.len() < filled {
            self.triangles.resize(filled, [0; 3]);
        }
        let room = &mut self.triangles[self.filled..];
        for (&index, triangle) in indices.iter().zip(room) {
            *triangle = all[index as usize];
        }
        self.filled = filled;
    }

    /// Adds triangles.
    fn add_all(&mut self, triangles: &[[u32; 3]]) {
        let filled = self.filled + triangles.len();
        if self.triangles.len() < filled {
            self.triangles.resize(filled, [0; 3]);
        }
        self.triangles[self.filled..filled].copy_from_slice(triangles);
        self.filled = filled;
    }

    /// Adds a polygon with many corners, or one for which there is no room yet, and says how many triangles there are.
    #[inline(never)]
    fn add_fan(&mut self, filled: usize, corners: &[u32]) -> usize {
        let [a, rest @ ..] = corners else {
            return filled;
        };
        let needed = filled + corners.len();
        if self.triangles.len() < needed {
            self.triangles.resize(2 * needed, [0; 3]);
        }
        let fan = rest.windows(2).zip(&mut self.triangles[filled..]);
        fan.for_each(|(side, triangle)| *triangle = [*a, side[0], side[1]]);
        filled + rest.len().saturating_sub(1)
    }

    /// The sums over these triangles and all that were added, about `apex` (m).
    pub(crate) fn sum(
        &mut self,
        triangles: &[[u32; 3]],
        apex: DVec3,
        vertices: &[Vec3],
        width: LaneWidth,
    ) -> Moments {
        let (fours, rest) = triangles.as_chunks();
        self.add_all(rest);
        let summing = FanSum {
            vertices,
            apex: apex.to_array(),
            lists: [fours, self.fours()],
        };
        let [six_volumes, x, y, z, xx, yy, zz, yz, zx, xy] =
            run(width, summing).map(|[a, b, c, d]| (a + b) + (c + d));
        Moments {
            six_volumes,
            first: DVec3::new(x, y, z),
            diagonal: DVec3::new(xx, yy, zz),
            products: DVec3::new(yz, zx, xy),
        }
    }

    /// All triangles, filled up with ones whose volume is zero exactly: those with three equal corners.
    fn fours(&mut self) -> &[[[u32; 3]; LANES]] {
        let whole = self.filled.next_multiple_of(LANES);
        if self.triangles.len() < whole {
            self.triangles.resize(whole, [0; 3]);
        }
        self.triangles[self.filled..whole].fill([0; 3]);
        self.triangles[..whole].as_chunks().0
    }
}

/// Sums up moments over triangles of a list of vertices, four at a time: there is no order between the four, so that the
/// compiler makes vector instructions of them.
struct FanSum<'a> {
    vertices: &'a [Vec3],
    apex: [f64; 3],
    lists: [&'a [[[u32; 3]; LANES]]; 2],
}

impl Kernel for FanSum<'_> {
    /// Six volumes, first moments, diagonal and products, as [`Moments`] has them, in each lane.
    type Output = [F64x4; 10];
    const NEEDS_32_REGISTERS: bool = false;

    #[inline(always)]
    fn run<L: Lanes>(self) -> [F64x4; 10] {
        let mut sums = [[0.0; LANES]; 10];
        for fours in self.lists {
            let triangles = TrianglesOf::new(self.vertices, fours);
            for four in 0..triangles.len() {
                let a = seen_from(self.apex, triangles.columns(four, 0));
                let b = seen_from(self.apex, triangles.columns(four, 1));
                let c = seen_from(self.apex, triangles.columns(four, 2));
                add_four(&mut sums, a, b, c);
            }
        }
        sums
    }
}

/// Four points, one axis after the other, seen from the apex.
#[inline(always)]
fn seen_from(apex: [f64; 3], points: [[f32; LANES]; 3]) -> [F64x4; 3] {
    let mut seen = [[0.0; LANES]; 3];
    for l in 0..LANES {
        seen[0][l] = f64::from(points[0][l]) - apex[0];
        seen[1][l] = f64::from(points[1][l]) - apex[1];
        seen[2][l] = f64::from(points[2][l]) - apex[2];
    }
    seen
}

/// Adds what each of four triangles adds to the sums.
///
/// With the sums of two corners each, `p = a + b`, `q = b + c` and `r = c + a`, the second moments are shorter:
/// `s s^T + a a^T + b b^T + c c^T = p p^T + q q^T + r r^T`.
#[inline(always)]
fn add_four(
    sums: &mut [F64x4; 10],
    [ax, ay, az]: [F64x4; 3],
    [bx, by, bz]: [F64x4; 3],
    [cx, cy, cz]: [F64x4; 3],
) {
    for i in 0..LANES {
        let [ax, ay, az] = [ax[i], ay[i], az[i]];
        let [bx, by, bz] = [bx[i], by[i], bz[i]];
        let [cx, cy, cz] = [cx[i], cy[i], cz[i]];
        let d = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx);
        let [px, py, pz] = [ax + bx, ay + by, az + bz];
        let [qx, qy, qz] = [bx + cx, by + cy, bz + cz];
        let [rx, ry, rz] = [cx + ax, cy + ay, cz + az];
        sums[0][i] += d;
        sums[1][i] += d * (px + cx);
        sums[2][i] += d * (py + cy);
        sums[3][i] += d * (pz + cz);
        sums[4][i] += d * (px * px + qx * qx + rx * rx);
        sums[5][i] += d * (py * py + qy * qy + ry * ry);
        sums[6][i] += d * (pz * pz + qz * qz + rz * rz);
        sums[7][i] += d * (py * pz + qy * qz + ry * rz);
        sums[8][i] += d * (pz * px + qz * qx + rz * rx);
        sums[9][i] += d * (px * py + qx * qy + rx * ry);
    }
}

/// The moments of a solid, with what a later cut needs to find those of its parts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SolidMoments {
    /// The point that the sums are about, m.
    pub(crate) apex: DVec3,
    /// Sums over the whole surface.
    pub(crate) sums: Moments,
    /// Six volumes of the solid whose surface was summed up when the apex was chosen, m3. The sums of parts that were
    /// found from it by addition and subtraction are off by a few roundings of numbers of its size.
    pub(crate) root: f64,
}

/// Parts with less than this share of the volume that their apex was chosen for get an apex of their own.
///
/// A part that is a share `q` of a body of length `l` is at least `q l` thick, so its smallest second moment is at least
/// about `q^3 / 12` of the body's, 3e-7: with `u = 1.1e-16` and some tens of roundings it is right to 1e-8, and the
/// moments of inertia, which have the larger ones in them, to `q^2 / 12`, 2e-4: to 1e-11.
const MIN_SHARE: f64 = 1.0 / 64.0;

impl SolidMoments {
    /// Sums over the whole surface, about the first vertex, which keeps rounding small far from the frame's origin.
    pub(crate) fn of_faces(
        vertices: &[Vec3],
        faces: &[Face],
        loops: &[u32],
        fans: &mut Fans,
        width: LaneWidth,
    ) -> Self {
        let apex = vertices.first().map_or(DVec3::ZERO, |v| v.as_dvec3());
        fans.clear();
        fans.add(faces.iter().map(|face| face.polygon(loops)));
        let sums = fans.sum(&[], apex, vertices, width);
        Self {
            apex,
            sums,
            root: sums.six_volumes,
        }
    }

    /// The same with other sums about the same apex; nothing if those would be too inexact.
    pub(crate) fn with_sums(&self, sums: Moments) -> Option<Self> {
        let is_exact = sums.six_volumes >= MIN_SHARE * self.root;
        is_exact.then_some(Self { sums, ..*self })
    }

    /// Volume, m3.
    pub(crate) fn volume(&self) -> f64 {
        self.sums.six_volumes / 6.0
    }

    /// Centroid, m.
    pub(crate) fn centroid(&self) -> DVec3 {
        self.apex + self.sums.arm()
    }
}
