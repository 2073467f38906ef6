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

/// Triangles that are summed up at once.
const BLOCK: usize = 8;

/// Sums up moments over triangles, a block at a time: a loop over a block has no order between triangles, so that the
/// compiler makes vector instructions of it.
#[derive(Clone, Debug)]
pub(crate) struct MomentSum {
    apex: [f64; 3],
    /// Coordinates of the three corners of the triangles that are not in the sums yet.
    block: [[f32; BLOCK]; 9],
    filled: usize,
    /// Six volumes, first moments, diagonal and products, as [`Moments`] has them, for each place in the block.
    sums: [[f64; BLOCK]; 10],
}

impl MomentSum {
    /// Of nothing, about `apex` (m).
    pub(crate) fn about(apex: DVec3) -> Self {
        Self {
            apex: apex.to_array(),
            block: [[0.0; BLOCK]; 9],
            filled: 0,
            sums: [[0.0; BLOCK]; 10],
        }
    }

    /// Adds a face as a triangle fan about its first corner.
    #[inline]
    pub(crate) fn add_face(&mut self, vertices: &[Vec3], corners: &[u32]) {
        let place = |vertex: u32| vertices[vertex as usize];
        match *corners {
            // By far the most common one in a hull with many faces.
            [a, b, c] => self.add_triangle(place(a), place(b), place(c)),
            [a, b, ref rest @ ..] => {
                let (a, mut last) = (place(a), place(b));
                for &c in rest {
                    let next = place(c);
                    self.add_triangle(a, last, next);
                    last = next;
                }
            }
            _ => {}
        }
    }

    #[inline]
    fn add_triangle(&mut self, a: Vec3, b: Vec3, c: Vec3) {
        if self.filled >= BLOCK {
            self.add_block();
        }
        let at = self.filled;
        let [ax, ay, az, bx, by, bz, cx, cy, cz] = &mut self.block;
        (ax[at], ay[at], az[at]) = (a.x, a.y, a.z);
        (bx[at], by[at], bz[at]) = (b.x, b.y, b.z);
        (cx[at], cy[at], cz[at]) = (c.x, c.y, c.z);
        self.filled = at + 1;
    }

    /// The sums.
    pub(crate) fn finish(mut self) -> Moments {
        self.add_block();
        let [six_volumes, x, y, z, xx, yy, zz, yz, zx, xy] =
            self.sums.map(|lanes| lanes.iter().sum());
        Moments {
            six_volumes,
            first: DVec3::new(x, y, z),
            diagonal: DVec3::new(xx, yy, zz),
            products: DVec3::new(yz, zx, xy),
        }
    }

    fn add_block(&mut self) {
        let filled = std::mem::take(&mut self.filled);
        for lanes in &mut self.block {
            // The volume of a triangle with three equal corners is zero exactly.
            lanes[filled.min(BLOCK)..].fill(0.0);
        }
        let terms = terms_of(&self.block, self.apex);
        for (sums, terms) in self.sums.iter_mut().zip(&terms) {
            for (sum, term) in sums.iter_mut().zip(terms) {
                *sum += term;
            }
        }
    }
}

/// What each triangle of a block adds to the sums.
#[inline]
fn terms_of(block: &[[f32; BLOCK]; 9], [ox, oy, oz]: [f64; 3]) -> [[f64; BLOCK]; 10] {
    let [ax, ay, az, bx, by, bz, cx, cy, cz] = block;
    let mut terms = [[0.0; BLOCK]; 10];
    for i in 0..BLOCK {
        let arm =
            |x: f32, y: f32, z: f32| [f64::from(x) - ox, f64::from(y) - oy, f64::from(z) - oz];
        let [ax, ay, az] = arm(ax[i], ay[i], az[i]);
        let [bx, by, bz] = arm(bx[i], by[i], bz[i]);
        let [cx, cy, cz] = arm(cx[i], cy[i], cz[i]);
        let d = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx);
        let [sx, sy, sz] = [ax + bx + cx, ay + by + cy, az + bz + cz];
        terms[0][i] = d;
        terms[1][i] = d * sx;
        terms[2][i] = d * sy;
        terms[3][i] = d * sz;
        terms[4][i] = d * (sx * sx + ax * ax + bx * bx + cx * cx);
        terms[5][i] = d * (sy * sy + ay * ay + by * by + cy * cy);
        terms[6][i] = d * (sz * sz + az * az + bz * bz + cz * cz);
        terms[7][i] = d * (sy * sz + ay * az + by * bz + cy * cz);
        terms[8][i] = d * (sz * sx + az * ax + bz * bx + cz * cx);
        terms[9][i] = d * (sx * sy + ax * ay + bx * by + cx * cy);
    }
    terms
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
        let mut sum = MomentSum::about(apex);
        faces.for_each(|corners| sum.add_face(vertices, corners));
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
