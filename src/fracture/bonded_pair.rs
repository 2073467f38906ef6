//! A bond and its two bodies: where they are to be to each other, and what of it their contact bears.

use crate::bodies::store::Bodies;
use crate::collide::narrow_phase::relative_pose;
use crate::contact::body_id::BodyId;
use crate::contact::point::{ContactPoint, MAX_POINTS};
use crate::fracture::bond::{Bond, BondError};
use crate::fracture::neighbors::{can_move, smaller_extent};
use crate::math::{Pose, rotate};
use crate::solver::graph::indices::ManifoldIndex;
use crate::solver::wide::bond::BondedManifold;
use glam::Vec3;

/// How far a point may be off, as a share of the same extent, until the bond is broken whatever it bears. A blow may tear bodies
/// farther apart than sweeps can tell in a step; to pull them back from there would be energy out of nothing.
pub(crate) const TEARING_SHARE: f32 = 0.01;

/// A bond that is no more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrokenBond {
    /// Its bodies, by id.
    pub bodies: (BodyId, BodyId),
    /// Their slots, in the same order.
    pub slots: [u32; 2],
    /// What it was.
    pub bond: Bond,
}

/// A bond with its bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BondedPair {
    /// Ascending.
    pub(super) bodies: (BodyId, BodyId),
    pub(super) slots: [u32; 2],
    pub(super) bond: Bond,
    /// Pose of B in A's frame when the bond was made.
    pub(super) b_in_a: Pose,
    /// Whether no step has seen the joint yet.
    pub(super) is_new: bool,
    /// Loosened joints wait for the next contacts of their pair, whose impulses from the step before may still pull.
    pub(super) is_loose: bool,
}

impl BondedPair {
    pub(super) fn new(bodies: &Bodies, a: u32, b: u32, bond: Bond) -> Result<Self, BondError> {
        bond.check()?;
        if !(bodies.contains(a) && bodies.contains(b)) {
            return Err(BondError::NoBody);
        }
        if a == b {
            return Err(BondError::SameBody);
        }
        if !can_move(bodies, a, b) {
            return Err(BondError::NothingMoves);
        }
        let (a, b) = if bodies.id(a) < bodies.id(b) {
            (a, b)
        } else {
            (b, a)
        };
        Ok(Self {
            bodies: (bodies.id(a), bodies.id(b)),
            slots: [a, b],
            bond,
            b_in_a: relative_pose(bodies, a, b),
            is_new: true,
            is_loose: false,
        })
    }

    /// A pose of one body in the other's frame, if that is the one in this slot, or its inverse.
    pub(super) fn seen_from(&self, slot: u32, pose: Pose) -> Pose {
        if slot == self.slots[0] {
            pose
        } else {
            pose.inverse()
        }
    }

    pub(super) fn is_alive(&self, bodies: &Bodies) -> bool {
        let [a, b] = self.slots;
        bodies.is_current(a, self.bodies.0) && bodies.is_current(b, self.bodies.1)
    }

    /// Whether the pair has no manifold because one of the bodies takes no part in the step.
    pub(super) fn is_out_of_sight(&self, bodies: &Bodies) -> bool {
        let is_out = |slot: u32| bodies.is_asleep(slot) || !bodies.is_active(slot);
        self.slots.into_iter().any(is_out)
    }

    pub(super) fn broken(&self) -> BrokenBond {
        BrokenBond {
            bodies: self.bodies,
            slots: self.slots,
            bond: self.bond,
        }
    }

    /// Makes the contact of the pair one that holds: gaps are counted from where the bond was made.
    pub(super) fn hold(
        &self,
        bodies: &Bodies,
        index: u32,
        normal: Vec3,
        points: &mut [ContactPoint],
    ) -> BondedManifold {
        let mut displacement = [Vec3::ZERO; MAX_POINTS];
        for (off, point) in displacement.iter_mut().zip(points.iter_mut()) {
            *off = self.displacement(bodies, [point.anchor_a, point.anchor_b]);
            point.separation = normal.dot(*off);
        }
        let share = self.bond.area / points.len().max(1) as f32;
        BondedManifold {
            manifold: ManifoldIndex(index),
            bodies: self.bodies,
            tension: self.bond.strength * share,
            shear: self.bond.shear_strength * share,
            is_new: self.is_new,
            slip: Vec3::ZERO,
            displacement,
            yielded: 0.0,
        }
    }

    /// Whether a point of the contact is farther from where it was than any bond reaches.
    pub(super) fn is_torn(&self, bodies: &Bodies, points: &[ContactPoint]) -> bool {
        let most = TEARING_SHARE * smaller_extent(bodies, self.slots);
        let off = |point: &ContactPoint| {
            let anchors = [point.anchor_a, point.anchor_b];
            self.displacement(bodies, anchors).length()
        };
        points.iter().any(|point| off(point) > most)
    }

    /// How far what is now at the ends of the anchors of B has moved against what is there of A, world axes, m.
    fn displacement(&self, bodies: &Bodies, anchors: [Vec3; 2]) -> Vec3 {
        let slots = self.slots.map(|slot| slot as usize);
        let [at_a, at_b] = [0, 1].map(|k| {
            let to_body = bodies.rotation[slots[k]].inverse();
            rotate(to_body, anchors[k]) + bodies.mass[slots[k]].center
        });
        let before = self.b_in_a.transform_point(at_b);
        rotate(bodies.rotation[slots[0]], at_a - before)
    }
}
