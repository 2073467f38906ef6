//! Contacts in lanes: blocks of eight manifolds that share no body which contacts move.
//!
//! The rows of a point are those of [`rows`](crate::solver::rows::contact_rows), but only what a sweep needs is kept: with the velocity of B
//! against A at the point, `dv`, and `K = sum 1/m - r^ I^-1 r^` of both bodies, an impulse `P` at the point changes it by
//! `K P`. A point's friction and normal are solved from one `dv`; the normal sees what friction did through the couplings
//! `t . K n`, and the bodies get the sum of both. That is what solving one row after the other comes to, in half the work.
//!
//! Manifolds are put into blocks so that those which share a body keep their order ([`schedule`](crate::solver::graph::ordered_packing)): the sweep
//! over blocks does exactly what the sweep over manifolds in their order would do, whatever the number of lanes. Coloring,
//! which fills blocks better in narrow structures by giving up the order, lets a pyramid of 30 rows creep by 18 cm where this
//! one moves by 3 cm (4 sub-steps): an order from the ground up carries support through a whole stack in one sweep.

use crate::bodies::solver_body::SolverBody;
use crate::contact::point::ContactPoint;
use crate::simd::lanes::{F8, Lanes, WIDTH};
use crate::simd::vec3::V3;
use crate::solver::rows::contact_rows::RowBody;
use glam::{Mat3, Vec3};
use std::ops::Range;

/// Marks a lane without a manifold.
pub(crate) const NO_MANIFOLD: u32 = u32::MAX;

/// Gap of points that are not there, m: far more than anything closes in a step.
pub(crate) const FAR: f32 = 1e18;

/// What the points of eight manifolds share.
#[derive(Clone, Debug)]
pub struct Block {
    /// Numbers of the bodies A and B.
    pub bodies: [[u32; WIDTH]; 2],
    /// Its points: each is the same one of all eight manifolds.
    pub points: Range<usize>,
    /// Indices of the manifolds.
    pub manifolds: [u32; WIDTH],
    /// Lanes in use, which are the first ones.
    pub used: usize,
    /// Unit normal from A to B.
    pub normal: [F8; 3],
    /// The two tangents.
    pub tangents: [[F8; 3]; 2],
    /// Coefficient of friction.
    pub friction: F8,
    /// Coefficient of restitution.
    pub restitution: F8,
    /// 1 / mass of A and B, 1/kg.
    pub inverse_mass: [F8; 2],
    /// Inverse inertia of A and B, world axes: xx, yy, zz, xy, xz, yz, 1/(kg m2).
    pub inverse_inertia: [[F8; 6]; 2],
    /// Overlap that is left alone, m.
    pub slop: F8,
    /// See [`PointRows::speed_scale`](crate::solver::rows::contact_rows::PointRows::speed_scale).
    pub speed_scale: F8,
}

/// One point of each manifold of a block. Unused lanes have no mass and get no impulse.
#[derive(Clone, Copy, Debug, Default)]
pub struct Point {
    /// From the centers of mass of A and B to the point, world axes, m.
    pub anchors: [[F8; 3]; 2],
    /// Gap along the normal less what displacements of the bodies add to it, m.
    pub separation: F8,
    /// `1 / (n . K n)`, kg.
    pub normal_mass: F8,
    /// The lesser of `1 / (t . K t)`, kg.
    pub tangent_mass: F8,
    /// `t . K n`, 1/kg.
    pub coupling: [F8; 2],
    /// Along the normal and both tangents, N s.
    pub impulse: [F8; 3],
    /// Normal velocity that the point should have, m/s.
    pub target_velocity: F8,
    /// Sum of the normal impulses of the sub-steps that are over, N s.
    pub total_normal_impulse: F8,
}

/// What a point needs where bodies hit each other.
#[derive(Clone, Copy, Debug, Default)]
pub struct PointImpact {
    /// Normal velocity after the bodies have moved, m/s. Not positive if the point does not rebound: what is then added to the
    /// least that it may have.
    pub rebound: F8,
    /// Twice the energy that the rebound gives, less what stopping the point took, J.
    pub spare: F8,
    /// Impulses before the impact, N s.
    pub before: [F8; 3],
}

impl Default for Block {
    fn default() -> Self {
        Self {
            bodies: [[0; WIDTH]; 2],
            points: 0..0,
            manifolds: [NO_MANIFOLD; WIDTH],
            used: 0,
            normal: Default::default(),
            tangents: Default::default(),
            friction: F8::default(),
            restitution: F8::default(),
            inverse_mass: Default::default(),
            inverse_inertia: Default::default(),
            slop: F8::default(),
            speed_scale: F8::default(),
        }
    }
}

/// A vector of one lane.
pub(crate) fn vector(lanes: &[F8; 3], lane: usize) -> Vec3 {
    let [x, y, z] = lanes;
    Vec3::new(x.0[lane], y.0[lane], z.0[lane])
}

/// Sets a vector of one lane.
#[cfg(test)]
pub(crate) fn set_vector(lanes: &mut [F8; 3], lane: usize, value: Vec3) {
    for (lanes, value) in lanes.iter_mut().zip(value.to_array()) {
        lanes.0[lane] = value;
    }
}

/// Copies the first of two lanes, of other vectors, to the second.
fn copy_lane(to: &mut F8, from: &F8, [source, lane]: [usize; 2]) {
    to.0[lane] = from.0[source];
}

fn copy_lanes(to: &mut [F8], from: &[F8], lanes: [usize; 2]) {
    for (to, from) in to.iter_mut().zip(from) {
        copy_lane(to, from, lanes);
    }
}

impl Block {
    /// Empties the lanes: all refer to a body that nothing happens to.
    pub fn clear(&mut self, dummy: u32, points: Range<usize>) {
        self.bodies = [[dummy; WIDTH]; 2];
        self.manifolds = [NO_MANIFOLD; WIDTH];
        self.points = points;
        self.used = 0;
    }

    /// Names manifold and bodies of the next lane.
    pub fn put(&mut self, lane: usize, manifold: u32, [a, b]: [u32; 2]) {
        self.manifolds[lane] = manifold;
        (self.bodies[0][lane], self.bodies[1][lane]) = (a, b);
        self.used += 1;
    }

    /// Copies what sweeps read of the first of two lanes, which is of another block, to the second; bodies, and the points, are no
    /// part of it.
    pub(crate) fn copy_lane(&mut self, from: &Self, lanes: [usize; 2]) {
        let copy = |to: &mut F8, from: &F8| copy_lane(to, from, lanes);
        let each = |to: &mut [F8], from: &[F8]| copy_lanes(to, from, lanes);
        each(&mut self.normal, &from.normal);
        each(
            self.tangents.as_flattened_mut(),
            from.tangents.as_flattened(),
        );
        each(&mut self.inverse_mass, &from.inverse_mass);
        each(
            self.inverse_inertia.as_flattened_mut(),
            from.inverse_inertia.as_flattened(),
        );
        copy(&mut self.friction, &from.friction);
        copy(&mut self.speed_scale, &from.speed_scale);
    }

    /// Numbers of the two bodies of a lane.
    pub fn pair(&self, lane: usize) -> [u32; 2] {
        self.bodies.map(|side| side[lane])
    }

    /// Masses and inertias of a lane.
    pub fn sides(&self, lane: usize) -> [RowBody; 2] {
        [0, 1].map(|k| {
            let [xx, yy, zz, xy, xz, yz] = self.inverse_inertia[k].map(|lanes| lanes.0[lane]);
            RowBody {
                inverse_mass: self.inverse_mass[k].0[lane],
                inverse_inertia: Mat3::from_cols(
                    Vec3::new(xx, xy, xz),
                    Vec3::new(xy, yy, yz),
                    Vec3::new(xz, yz, zz),
                ),
            }
        })
    }
}

impl Point {
    /// Velocity of B against A along the normal of a lane, or another direction, m/s. Of displacements, how far B moved
    /// against A, m.
    pub fn normal_velocity(&self, lane: usize, normal: Vec3, [a, b]: [&SolverBody; 2]) -> f32 {
        let [to_a, to_b] = [0, 1].map(|k| vector(&self.anchors[k], lane));
        normal.dot(b.linear - a.linear) + to_b.cross(normal).dot(b.angular)
            - to_a.cross(normal).dot(a.angular)
    }

    /// Copies what sweeps read of the first of two lanes, which is of another block, to the second.
    pub(crate) fn copy_lane(&mut self, from: &Self, lanes: [usize; 2]) {
        let copy = |to: &mut F8, from: &F8| copy_lane(to, from, lanes);
        let each = |to: &mut [F8], from: &[F8]| copy_lanes(to, from, lanes);
        each(self.anchors.as_flattened_mut(), from.anchors.as_flattened());
        each(&mut self.coupling, &from.coupling);
        each(&mut self.impulse, &from.impulse);
        copy(&mut self.normal_mass, &from.normal_mass);
        copy(&mut self.tangent_mass, &from.tangent_mass);
        copy(&mut self.target_velocity, &from.target_velocity);
    }

    /// Writes what the last sub-step found back into the contact point: as impulses of a whole step.
    pub fn store(&self, lane: usize, block: &Block, point: &mut ContactPoint, substeps: u32) {
        let n = substeps as f32;
        let [normal, t1, t2] = vector(&self.impulse, lane).to_array();
        let [d1, d2] = &block.tangents;
        point.normal_impulse = n * normal;
        point.friction_impulse = n * (vector(d1, lane) * t1 + vector(d2, lane) * t2);
        point.total_impulse = self.total_normal_impulse.0[lane] + normal;
    }
}

#[inline(always)]
pub(crate) fn load_anchors<L: Lanes>(point: &Point) -> [V3<L>; 2] {
    [V3::load(&point.anchors[0]), V3::load(&point.anchors[1])]
}

/// Where the points of some blocks lie.
pub(crate) fn points_of(blocks: &[Block]) -> Range<usize> {
    match (blocks.first(), blocks.last()) {
        (Some(first), Some(last)) => first.points.start..last.points.end,
        _ => 0..0,
    }
}
