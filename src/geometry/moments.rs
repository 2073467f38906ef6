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

use super::convex::{Face, only_triangles};
use super::lanes::wide::{Avx2, Loop, run};
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

/// Triangles that wait to be summed up; there may be a few more.
const BLOCK: usize = 32;

/// Triangles that are summed up side by side: as many `f64` as fit in the widest register. The order of the sums is the
/// same where registers are narrower.
const LANES: usize = 4;

/// One number of each triangle.
type Lanes = [f64; LANES];

/// Sums up moments over triangles of a list of vertices, four at a time: there is no order between the four, so that the
/// compiler makes vector instructions of them.
#[derive(Clone, Debug)]
pub(crate) struct MomentSum<'v> {
    vertices: &'v [Vec3],
    apex: [f64; 3],
    wide: Option<Avx2>,
    /// Corners of the triangles that are not in the sums yet.
    block: [[u32; 3]; BLOCK + LANES],
    filled: usize,
    /// Six volumes, first moments, diagonal and products, as [`Moments`] has them, in each lane.
    sums: [Lanes; 10],
}

impl<'v> MomentSum<'v> {
    /// Of nothing, about `apex` (m).
    pub(crate) fn about(apex: DVec3, vertices: &'v [Vec3], wide: Option<Avx2>) -> Self {
        Self {
            vertices,
            apex: apex.to_array(),
            wide,
            block: [[0; 3]; BLOCK + LANES],
            filled: 0,
            sums: [[0.0; LANES]; 10],
        }
    }

    /// Adds faces whose loops stand one after the other in `loops`.
    pub(crate) fn add_faces(&mut self, faces: &[Face], loops: &[u32]) {
        let ([first, ..], [.., last]) = (faces, faces) else {
            return;
        };
        let corners = &loops[first.range().start..last.range().end];
        match only_triangles(faces.len(), corners) {
            Some(triangles) => self.add_triangles(triangles),
            None => faces.iter().for_each(|face| self.add_face(face, loops)),
        }
    }

    /// Adds a face, whose loop is in `loops`, as a triangle fan about its first corner.
    #[inline]
    pub(crate) fn add_face(&mut self, face: &Face, loops: &[u32]) {
        let corners = face.range();
        if let (Some(&[a, b, c, d]), 3..=4) = (loops[corners.start..].first_chunk(), face.count) {
            // No branch between three corners and four, because there is no guessing: the next face writes over what is too
            // much.
            if self.filled >= BLOCK {
                self.add_block();
            }
            self.block[self.filled] = [a, b, c];
            self.block[self.filled + 1] = [a, c, d];
            self.filled += face.count as usize - 2;
        } else if let [a, b, ref rest @ ..] = loops[corners] {
            let mut last = b;
            for &next in rest {
                self.add_triangles(&[[a, last, next]]);
                last = next;
            }
        }
    }

    fn add_triangles(&mut self, mut triangles: &[[u32; 3]]) {
        while !triangles.is_empty() {
            if self.filled >= BLOCK {
                self.add_block();
            }
            let room = &mut self.block[self.filled..BLOCK];
            let (now, later) = triangles.split_at(triangles.len().min(room.len()));
            for (room, triangle) in room.iter_mut().zip(now) {
                *room = *triangle;
            }
            self.filled += now.len();
            triangles = later;
        }
    }

    /// The sums.
    pub(crate) fn finish(&mut self) -> Moments {
        let rest = self.filled % LANES;
        if rest != 0 {
            // The volume of a triangle with three equal corners is zero exactly.
            let [corner, ..] = self.block[0];
            self.block[self.filled..][..LANES - rest].fill([corner; 3]);
            self.filled += LANES - rest;
        }
        self.add_block();
        let [six_volumes, x, y, z, xx, yy, zz, yz, zx, xy] =
            self.sums.map(|[a, b, c, d]| (a + b) + (c + d));
        Moments {
            six_volumes,
            first: DVec3::new(x, y, z),
            diagonal: DVec3::new(xx, yy, zz),
            products: DVec3::new(yz, zx, xy),
        }
    }

    /// Adds as many triangles of the block as there are whole fours, and keeps the rest.
    fn add_block(&mut self) {
        let (fours, rest) = self.block[..self.filled].as_chunks();
        let block = Block {
            vertices: self.vertices,
            apex: self.apex,
            triangles: fours,
            sums: &mut self.sums,
        };
        run(self.wide, block);
        let rest = self.filled - rest.len()..self.filled;
        self.filled = rest.len();
        self.block.copy_within(rest, 0);
    }
}

/// Triangles to be added to sums.
struct Block<'a> {
    vertices: &'a [Vec3],
    apex: [f64; 3],
    triangles: &'a [[[u32; 3]; LANES]],
    sums: &'a mut [Lanes; 10],
}

impl Loop for Block<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let mut sums = *self.sums;
        for four in self.triangles {
            let (a, b, c) = (
                self.corners(four, 0),
                self.corners(four, 1),
                self.corners(four, 2),
            );
            add_four(&mut sums, a, b, c);
        }
        *self.sums = sums;
    }
}

impl Block<'_> {
    /// Corner `k` of four triangles, seen from the apex.
    #[inline(always)]
    fn corners(&self, four: &[[u32; 3]; LANES], k: usize) -> [Lanes; 3] {
        let mut points = [[0.0; LANES]; 3];
        for l in 0..LANES {
            let point = self.vertices[four[l][k] as usize];
            (points[0][l], points[1][l], points[2][l]) = (point.x, point.y, point.z);
        }
        let mut corners = [[0.0; LANES]; 3];
        for l in 0..LANES {
            corners[0][l] = f64::from(points[0][l]) - self.apex[0];
            corners[1][l] = f64::from(points[1][l]) - self.apex[1];
            corners[2][l] = f64::from(points[2][l]) - self.apex[2];
        }
        corners
    }
}

/// Adds what each of four triangles adds to the sums.
///
/// With the sums of two corners each, `p = a + b`, `q = b + c` and `r = c + a`, the second moments are shorter:
/// `s s^T + a a^T + b b^T + c c^T = p p^T + q q^T + r r^T`.
#[inline(always)]
fn add_four(
    sums: &mut [Lanes; 10],
    [ax, ay, az]: [Lanes; 3],
    [bx, by, bz]: [Lanes; 3],
    [cx, cy, cz]: [Lanes; 3],
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
const LEAST_SHARE: f64 = 1.0 / 64.0;

impl SolidMoments {
    /// Sums over the whole surface, of faces whose loops stand one after the other, about the first vertex, which keeps rounding small far from the
    /// frame's origin.
    pub(crate) fn of_faces(
        vertices: &[Vec3],
        faces: &[Face],
        loops: &[u32],
        wide: Option<Avx2>,
    ) -> Self {
        let apex = vertices.first().map_or(DVec3::ZERO, |v| v.as_dvec3());
        let mut sum = MomentSum::about(apex, vertices, wide);
        sum.add_faces(faces, loops);
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
