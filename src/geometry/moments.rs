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

/// Triangles that wait to be summed up.
const BLOCK: usize = 32;

/// Triangles that are summed up side by side: as many `f64` as fit in a vector register of every processor.
const PAIR: usize = 2;

/// Sums up moments over triangles of a list of vertices, two at a time: there is no order between the two, so that the
/// compiler makes vector instructions of them.
#[derive(Clone, Debug)]
pub(crate) struct MomentSum<'v> {
    vertices: &'v [Vec3],
    apex: [f64; 3],
    /// Corners of the triangles that are not in the sums yet.
    block: [[u32; 3]; BLOCK],
    filled: usize,
    /// Six volumes, first moments, diagonal and products, as [`Moments`] has them, for each of a pair.
    sums: [[f64; PAIR]; 10],
}

impl<'v> MomentSum<'v> {
    /// Of nothing, about `apex` (m).
    pub(crate) fn about(apex: DVec3, vertices: &'v [Vec3]) -> Self {
        Self {
            vertices,
            apex: apex.to_array(),
            block: [[0; 3]; BLOCK],
            filled: 0,
            sums: [[0.0; PAIR]; 10],
        }
    }

    /// Adds a face as a triangle fan about its first corner.
    #[inline]
    pub(crate) fn add_face(&mut self, corners: &[u32]) {
        match *corners {
            // By far the most common one in a hull with many faces.
            [a, b, c] => self.add_triangle([a, b, c]),
            [a, b, ref rest @ ..] => {
                let mut last = b;
                for &next in rest {
                    self.add_triangle([a, last, next]);
                    last = next;
                }
            }
            _ => {}
        }
    }

    #[inline]
    fn add_triangle(&mut self, corners: [u32; 3]) {
        if self.filled >= BLOCK {
            self.add_block();
        }
        self.block[self.filled] = corners;
        self.filled += 1;
    }

    /// The sums.
    pub(crate) fn finish(mut self) -> Moments {
        if !self.filled.is_multiple_of(PAIR) {
            // The volume of a triangle with three equal corners is zero exactly.
            let [corner, ..] = self.block[0];
            self.block[self.filled] = [corner; 3];
            self.filled += 1;
        }
        self.add_block();
        let [six_volumes, x, y, z, xx, yy, zz, yz, zx, xy] = self.sums.map(|[a, b]| a + b);
        Moments {
            six_volumes,
            first: DVec3::new(x, y, z),
            diagonal: DVec3::new(xx, yy, zz),
            products: DVec3::new(yz, zx, xy),
        }
    }

    fn add_block(&mut self) {
        let filled = std::mem::take(&mut self.filled);
        let mut sums = self.sums;
        for pair in self.block[..filled].as_chunks::<PAIR>().0 {
            let corner = |k: usize| {
                let [p, q] = [pair[0][k], pair[1][k]].map(|v| self.vertices[v as usize]);
                let [x, y, z] = self.apex;
                [
                    [f64::from(p.x) - x, f64::from(q.x) - x],
                    [f64::from(p.y) - y, f64::from(q.y) - y],
                    [f64::from(p.z) - z, f64::from(q.z) - z],
                ]
            };
            add_pair(&mut sums, corner(0), corner(1), corner(2));
        }
        self.sums = sums;
    }
}

/// Adds what each triangle of a pair adds to the sums.
///
/// With the sums of two corners each, `p = a + b`, `q = b + c` and `r = c + a`, the second moments are shorter:
/// `s s^T + a a^T + b b^T + c c^T = p p^T + q q^T + r r^T`.
#[inline]
fn add_pair(
    sums: &mut [[f64; PAIR]; 10],
    [ax, ay, az]: [[f64; PAIR]; 3],
    [bx, by, bz]: [[f64; PAIR]; 3],
    [cx, cy, cz]: [[f64; PAIR]; 3],
) {
    for i in 0..PAIR {
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
const LEAST_SHARE: f64 = 1.0 / 64.0;

impl SolidMoments {
    /// Sums over the whole surface, given by `faces`, about the first vertex, which keeps rounding small far from the
    /// frame's origin.
    pub(crate) fn of_faces<'f>(vertices: &[Vec3], faces: impl Iterator<Item = &'f [u32]>) -> Self {
        let apex = vertices.first().map_or(DVec3::ZERO, |v| v.as_dvec3());
        let mut sum = MomentSum::about(apex, vertices);
        faces.for_each(|corners| sum.add_face(corners));
        let sums = sum.finish();
        Self {
            apex,
            sums,
            root: sums.six_volumes,
        }
    }

    /// The same with other sums about the same apex; nothing if those would be too inexact.
    pub(crate) fn with_sums(&self, sums: Moments) -> Option<Self> {
        let is_exact = sums.six_volumes >= LEAST_SHARE * self.root;
        is_exact.then_some(Self { sums, ..*self })
    }

    /// Volume, m3.
    pub(crate) fn volume(&self) -> f64 {
        self.sums.six_volumes / 6.0
    }
}
