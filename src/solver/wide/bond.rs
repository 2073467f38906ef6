//! Bonds as rows: points at which two bodies hold each other until their load reaches a strength.
//!
//! A bonded point has the three rows of a contact with other bounds, `lambda_n >= -adhesion` and
//! `|lambda_t| <= mu max(lambda_n, 0) + shear`, and wants to be where it was when the bond was made: along the normal and the
//! tangents, what it has moved by goes back as softly as overlap does; see [`soft_step`](crate::solver::rows::soft_step). A sweep after
//! the motion holds it still. So a bond below its strength is a fixed edge of up to four points.
//!
//! A point that bears all it can gives way at that load, and has given way for good once it is farther off than what the
//! maker of the bond allows: a cohesive zone of constant stress. What an iteration on its way to the solution does to a bond
//! for a sub-step does not break it.
//!
//! Where bonded bodies turn about each other, going back to the circle that they leave along its tangents in each sub-step
//! takes half as much impulse as staying on it, so such a bond needs 1.5 times the strength that its load alone would. With a
//! reserve for position bias beyond the strength, walls near their strength crept instead.
//!
//! # References
//! Dugdale, "Yielding of steel sheets containing slits", J. Mech. Phys. Solids 8, 1960 (the cohesive zone); Catto, "Soft
//! Constraints", GDC 2011.

use crate::bodies::solver_body::SolverBody;
use crate::contact::body_id::BodyId;
use crate::contact::point::MAX_POINTS;
use crate::simd::lanes::{F8, Lanes};
use crate::solver::config::FrictionModel;
use crate::solver::graph::indices::ManifoldIndex;
use crate::solver::wide::block::{Block, Point, vector};
use glam::{Vec2, Vec3};

/// Rate at which bonded points go back to their places, as a share of that of soft rows. At the full
/// rate walls of bricks never come to rest: after 10 s one of 64 bricks moves at 2 mm/s, with half of it at 1 um/s.
pub(crate) const BOND_RATE: f32 = 0.5;

/// Damping ratio of bonds. With 3 a beam that a blow breaks gains 15 % of its energy.
pub(crate) const BOND_DAMPING: f32 = 10.0;

/// Share of its bound from which an impulse counts as being at it.
const AT_BOUND: f32 = 0.999;

/// A manifold whose bodies are bonded, or slide on each other's [running surfaces](crate::bodies::BodyDrive::surface_velocity).
#[derive(Clone, Copy, Debug, Default)]
pub struct BondedManifold {
    /// Index of the manifold.
    pub manifold: ManifoldIndex,
    /// Its bodies.
    pub bodies: (BodyId, BodyId),
    /// Largest tension of each point, N.
    pub tension: f32,
    /// Largest shear force of each point without pressure, N.
    pub shear: f32,
    /// Whether the bond was made since the last step: nobody knows yet what it will bear.
    pub is_new: bool,
    /// Velocity of B against A at which friction lets it be, of which only what is along the tangents counts; zero if they are bonded. World
    /// axes, m/s.
    pub slip: Vec3,
    /// How far B has moved against A at each point since the bond was made, world axes, m.
    pub displacement: [Vec3; MAX_POINTS],
    /// How far the point that is farthest off, of those that bear all they can, has opened or slid at the end of the step, m.
    pub yielded: f32,
}

/// Whether a manifold is in the list, which is sorted by manifolds.
pub(crate) fn is_bonded(bonded: &[BondedManifold], manifold: ManifoldIndex) -> bool {
    bonded
        .binary_search_by_key(&manifold, |bond| bond.manifold)
        .is_ok()
}

/// Whether a manifold is in the list, which is sorted by manifolds, with a bond that was made since the last step.
pub(crate) fn is_new_bond(bonded: &[BondedManifold], manifold: ManifoldIndex) -> bool {
    let found = bonded.binary_search_by_key(&manifold, |bond| bond.manifold);
    found.is_ok_and(|at| bonded[at].is_new)
}

/// What a point needs where manifolds are bonded; all zero in lanes of those that are not.
#[derive(Clone, Copy, Debug, Default)]
pub struct BondConstraint {
    /// Largest tensile impulse of a sub-step, N s.
    pub adhesion: F8,
    /// What friction may be beyond `mu lambda_n` in a sub-step, N s.
    pub shear: F8,
    /// How far B was off along the tangents at the start of the step, m.
    pub start: [F8; 2],
    /// How far B is off along the tangents, less what displacements of the bodies add to it, m.
    pub slide: [F8; 2],
    /// Velocities along the tangents that the point should have, m/s; those of lanes that are not bonded stay as they were loaded.
    pub target_velocity: [F8; 2],
}

impl BondConstraint {
    /// Bonds a lane; `substep_dt` is the length of a sub-step, s.
    pub(crate) fn load(
        &mut self,
        lane: usize,
        block: &Block,
        bond: &BondedManifold,
        off: Vec3,
        substep_dt: f32,
    ) {
        self.adhesion.0[lane] = substep_dt * bond.tension;
        self.shear.0[lane] = substep_dt * bond.shear;
        for (k, tangent) in block.tangents.iter().enumerate() {
            self.start[k].0[lane] = vector(tangent, lane).dot(off);
            self.slide[k].0[lane] = self.start[k].0[lane];
            self.target_velocity[k].0[lane] = vector(tangent, lane).dot(bond.slip);
        }
    }

    /// Whether a lane slides on a running surface.
    pub(crate) fn is_running(&self, lane: usize) -> bool {
        let slips = |velocity: &F8| velocity.0[lane] != 0.0;
        self.adhesion.0[lane] == 0.0 && self.target_velocity.iter().any(slips)
    }

    /// Has the bond of a lane hold still, where it was to go back; returns the largest change of a target velocity, m/s.
    /// `normal`: the one along the normal.
    pub fn relax(&mut self, lane: usize, normal: &mut f32) -> f32 {
        let [t1, t2] = self
            .target_velocity
            .each_mut()
            .map(|target_velocity| std::mem::take(&mut target_velocity.0[lane]).abs());
        std::mem::take(normal).abs().max(t1).max(t2)
    }

    /// How far the point has opened or slid where it bears all it can; 0 where it bears less, m.
    pub(crate) fn yielded(
        &self,
        lane: usize,
        block: &Block,
        point: &Point,
        displacements: [&SolverBody; 2],
        model: FrictionModel,
    ) -> f32 {
        let shift = |direction| point.normal_velocity(lane, direction, displacements);
        let [normal, t1, t2] = point.impulse.map(|lanes| lanes.0[lane]);
        let mut yielded = 0.0_f32;
        if -normal >= AT_BOUND * self.adhesion.0[lane] {
            let opening = point.separation.0[lane] + shift(vector(&block.normal, lane));
            yielded = yielded.max(opening);
        }
        let radius = block.friction.0[lane] * normal.max(0.0) + self.shear.0[lane];
        let friction = match model {
            FrictionModel::Disc => Vec2::new(t1, t2).length(),
            FrictionModel::Box => t1.abs().max(t2.abs()),
        };
        if friction >= AT_BOUND * radius {
            let slide =
                [0, 1].map(|k| self.slide[k].0[lane] + shift(vector(&block.tangents[k], lane)));
            yielded = yielded.max(Vec2::from(slide).length());
        }
        yielded
    }
}

/// What the impulses of a point are kept within, in each lane. Without `BONDED` there are no bonds, and nothing of them is computed.
pub(crate) struct ImpulseBounds<L, const BONDED: bool> {
    friction: L,
    adhesion: L,
    shear: L,
    /// Along the tangents, m/s.
    pub(crate) target_velocity: [L; 2],
}

impl<L: Lanes, const BONDED: bool> ImpulseBounds<L, BONDED> {
    #[inline(always)]
    pub(crate) fn load(friction: L, constraint: Option<&BondConstraint>) -> Self {
        let zero = L::splat(0.0);
        match constraint.filter(|_| BONDED) {
            Some(constraint) => Self {
                friction,
                adhesion: L::load(&constraint.adhesion),
                shear: L::load(&constraint.shear),
                target_velocity: [
                    L::load(&constraint.target_velocity[0]),
                    L::load(&constraint.target_velocity[1]),
                ],
            },
            None => Self {
                friction,
                adhesion: zero,
                shear: zero,
                target_velocity: [zero; 2],
            },
        }
    }

    /// The nearest normal impulse to `unbounded`.
    #[inline(always)]
    pub(crate) fn normal(&self, unbounded: L) -> L {
        let zero = L::splat(0.0);
        if BONDED {
            unbounded.max(zero - self.adhesion)
        } else {
            unbounded.max(zero)
        }
    }

    /// Bound of friction with a normal impulse.
    #[inline(always)]
    pub(crate) fn radius(&self, normal: L) -> L {
        if BONDED {
            self.friction * normal.max(L::splat(0.0)) + self.shear
        } else {
            self.friction * normal
        }
    }

    /// `yes` in bonded lanes, else `no`.
    #[inline(always)]
    pub(crate) fn if_bonded(&self, yes: L, no: L) -> L {
        if BONDED {
            self.adhesion.if_above(L::splat(0.0), yes, no)
        } else {
            no
        }
    }
}
