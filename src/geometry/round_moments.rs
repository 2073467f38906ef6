//! Volume, first and second moments of round shapes, exactly.
//!
//! All within a radius `r` of a hull falls apart into the hull, a prism on each face, a sector of a cylinder along each edge and a
//! sector of a ball at each corner, as in Steiner's formula for the volume. The sector at a corner is the spherical polygon of all
//! normals there. With `U` an integral over it, `W` its area, `e` the unit vectors along the edges that leave the corner and `t` the
//! angles between the normals of their two faces, Green's formula on the sphere, where `u_i` and `u_i u_j` are eigenfunctions of
//! the Laplacian but for a constant (`-2` and `-6`), leaves sums over its sides, great circles whose outward conormals are the `e`:
//!
//! - `W = 2 pi - sum of the angles of the faces at the corner`, the corner's angular defect,
//! - `integral of u = - sum of e t / 2`,
//! - `integral of u u^T = W / 3 1 - sum of (e S^T + S e^T) / 6` with `S` the integral of `u` along the side.
//!
//! A sphere is one corner with all directions, a capsule two with half of them each and one edge.
//!
//! # References
//! - R. Schneider, *Convex Bodies: The Brunn-Minkowski Theory*, 2nd ed., section 4.1 (local parallel sets, Steiner's formula).

use crate::geometry::ConvexHull;
use crate::geometry::frustum::Frustum;
use crate::geometry::moments::{Moments, SolidMoments};
use crate::geometry::round_core::RoundCore;
use crate::math::{atan2, outer};
use glam::{DMat3, DVec3};
use std::f64::consts::{PI, TAU};

/// Integrals of 1, `x` and `x x^T`.
#[derive(Clone, Copy, Debug)]
struct Integrals {
    volume: f64,
    first: DVec3,
    second: DMat3,
}

impl Integrals {
    /// Of nothing.
    const ZERO: Self = Self {
        volume: 0.0,
        first: DVec3::ZERO,
        second: DMat3::ZERO,
    };

    fn add(&mut self, volume: f64, first: DVec3, second: DMat3) {
        self.volume += volume;
        self.first += first;
        self.second += second;
    }
}

/// `a b^T + b a^T`.
fn both(a: DVec3, b: DVec3) -> DMat3 {
    outer(a, b) + outer(b, a)
}

/// Of all within `radius` (m) of a core.
pub(crate) fn of(core: &RoundCore, radius: f64) -> SolidMoments {
    let found = match core {
        RoundCore::Point => of_capsule(0.0, radius),
        RoundCore::Segment(half) => of_capsule(f64::from(*half), radius),
        RoundCore::Frustum(frustum) => of_frustum(frustum),
        RoundCore::Hull(hull) => of_hull(hull, radius),
    };
    let apex = found.first / found.volume;
    let second = found.second - found.volume * outer(apex, apex);
    let sums = Moments::of_integrals(found.volume, DVec3::ZERO, second);
    SolidMoments {
        apex,
        sums,
        root: sums.six_volumes,
    }
}

/// Of a cylinder along y with half balls at its ends.
fn of_capsule(half: f64, r: f64) -> Integrals {
    let (cylinder, ball) = (TAU * half * r * r, 4.0 / 3.0 * PI * r * r * r);
    // Of a half ball: its center of mass is 3/8 of the radius from the middle of the ball.
    let along = cylinder * half * half / 3.0 + ball * (r * r / 5.0 + half * half + 0.75 * half * r);
    let across = cylinder * r * r / 4.0 + ball * r * r / 5.0;
    Integrals {
        volume: cylinder + ball,
        first: DVec3::ZERO,
        second: DMat3::from_diagonal(DVec3::new(across, along, across)),
    }
}

/// Of a stack of discs whose radius is linear along y.
fn of_frustum(frustum: &Frustum) -> Integrals {
    let [low, _] = frustum.levels.map(f64::from);
    let [a, b] = frustum.radii.map(f64::from);
    let (h, d) = (frustum.height(), b - a);
    // With s from 0 to 1 along the axis: integrals of s^k (a + d s)^2, and of (a + d s)^4.
    let moment = |k: f64| a * a / (k + 1.0) + 2.0 * a * d / (k + 2.0) + d * d / (k + 3.0);
    let [m0, m1, m2] = [0.0, 1.0, 2.0].map(moment);
    let (aa, bb) = (a * a, b * b);
    let quartic = (aa * aa + aa * a * b + aa * bb + a * b * bb + bb * bb) / 5.0;
    let volume = PI * h * m0;
    let first = PI * h * (low * m0 + h * m1);
    let along = PI * h * (low * low * m0 + 2.0 * low * h * m1 + h * h * m2);
    let across = PI * h * quartic / 4.0;
    Integrals {
        volume,
        first: first * DVec3::Y,
        second: DMat3::from_diagonal(DVec3::new(across, along, across)),
    }
}

fn of_hull(hull: &ConvexHull, r: f64) -> Integrals {
    let mut sum = Integrals::ZERO;
    add_hull(&mut sum, hull);
    let mut corners = vec![Corner::NONE; hull.vertices().len()];
    for face in hull.faces() {
        let outline = hull.face_loop(face);
        let at = |k: usize| hull.vertices()[outline[k % outline.len()] as usize].as_dvec3();
        add_prism(&mut sum, outline.len(), at, face.plane.normal.as_dvec3(), r);
        for k in 0..outline.len() {
            let [before, here, after] = [k + outline.len() - 1, k, k + 1].map(at);
            let (u, v) = (before - here, after - here);
            corners[outline[k] as usize].angles += atan2(u.cross(v).length(), u.dot(v));
        }
    }
    for edge in hull.edges() {
        let ends = edge
            .vertices
            .map(|v| hull.vertices()[v as usize].as_dvec3());
        let normals = edge
            .faces
            .map(|f| hull.faces()[f as usize].plane.normal.as_dvec3());
        let Some(arc) = Arc::between(normals) else {
            continue;
        };
        add_sector(&mut sum, ends, &arc, r);
        let along = (ends[1] - ends[0]).normalize_or_zero();
        for (vertex, outward) in edge.vertices.into_iter().zip([along, -along]) {
            let corner = &mut corners[vertex as usize];
            corner.first -= 0.5 * arc.angle * outward;
            corner.second -= both(outward, arc.integral) * (1.0 / 6.0);
        }
    }
    for (corner, at) in corners.iter().zip(hull.vertices()) {
        corner.add(&mut sum, at.as_dvec3(), r);
    }
    sum
}

fn add_hull(sum: &mut Integrals, hull: &ConvexHull) {
    let SolidMoments { apex, sums, .. } = hull.moments;
    let (volume, arm) = (sums.six_volumes / 6.0, sums.first / 24.0);
    let second = sums.second() * (1.0 / 120.0) + both(arm, apex) + volume * outer(apex, apex);
    sum.add(volume, arm + volume * apex, second);
}

/// What is up to `r` above a face.
fn add_prism(sum: &mut Integrals, count: usize, at: impl Fn(usize) -> DVec3, n: DVec3, r: f64) {
    for k in 1..count - 1 {
        let [a, b, c] = [at(0), at(k), at(k + 1)];
        let area = 0.5 * (b - a).cross(c - a).dot(n);
        let all = a + b + c;
        let (first, second) = (
            area / 3.0 * all,
            (outer(all, all) + outer(a, a) + outer(b, b) + outer(c, c)) * (area / 12.0),
        );
        sum.add(
            area * r,
            r * first + 0.5 * r * r * area * n,
            second * r + both(first, n) * (0.5 * r * r) + outer(n, n) * (area * r * r * r / 3.0),
        );
    }
}

/// The great circle from one unit vector to another.
struct Arc {
    angle: f64,
    /// Integrals of `u` and `u u^T` along it.
    integral: DVec3,
    second: DMat3,
}

impl Arc {
    fn between([a, b]: [DVec3; 2]) -> Option<Self> {
        let (sine, cosine) = (a.cross(b).length(), a.dot(b));
        let angle = atan2(sine, cosine);
        let middle = (a + b).try_normalize()?;
        let side = (b - a).try_normalize()?;
        Some(Self {
            angle,
            integral: (a + b) * (sine / (1.0 + cosine)),
            second: outer(middle, middle) * (0.5 * (angle + sine))
                + outer(side, side) * (0.5 * (angle - sine)),
        })
    }
}

/// What is within `r` of an edge, beside the prisms.
fn add_sector(sum: &mut Integrals, [p, q]: [DVec3; 2], arc: &Arc, r: f64) {
    let (along, middle) = (q - p, 0.5 * (p + q));
    let length = along.length();
    let area = 0.5 * arc.angle * r * r;
    let first = r * r * r / 3.0 * arc.integral;
    let line = (outer(middle, middle) + outer(along, along) * (1.0 / 12.0)) * length;
    sum.add(
        length * area,
        length * (area * middle + first),
        line * area + both(middle, first) * length + arc.second * (length * r * r * r * r / 4.0),
    );
}

/// What is known of the directions of a corner.
#[derive(Clone, Copy, Debug)]
struct Corner {
    /// Of its faces.
    angles: f64,
    first: DVec3,
    second: DMat3,
}

impl Corner {
    /// Of no faces and edges.
    const NONE: Self = Self {
        angles: 0.0,
        first: DVec3::ZERO,
        second: DMat3::ZERO,
    };

    /// Adds what is within `r` of the corner, beside all else.
    fn add(&self, sum: &mut Integrals, at: DVec3, r: f64) {
        let directions = TAU - self.angles;
        let second = self.second + DMat3::from_diagonal(DVec3::splat(directions / 3.0));
        let volume = directions * r * r * r / 3.0;
        let arm = self.first * (r * r * r * r / 4.0);
        sum.add(
            volume,
            volume * at + arm,
            outer(at, at) * volume + both(at, arm) + second * (r * r * r * r * r / 5.0),
        );
    }
}
