//! Explosions: bodies are pushed, and clusters part by part, which may break them.

use crate::bodies::body::RigidBody;
use crate::bodies::drive::StepForces;
use crate::bodies::explosion::Explosion;
use crate::bodies::store::Bodies;
use crate::cluster::elastic::Wrench;
use crate::cluster::hit::{Hit, Push};
use crate::contact::body_id::BodyId;
use crate::fracture::budget::FractureBudget;
use crate::fracture::cluster::{BrokenBonds, Groups};
use crate::fracture::pending::Division;
use crate::fracture::{Bonds, BreakingImpact, Fractures, MIN_PIECES};
use crate::math::rotate;
use glam::{Quat, Vec3};

impl Fractures {
    /// Lets the explosions of the step act.
    pub(super) fn explode(
        &mut self,
        bodies: &mut Bodies,
        bonds: &mut Bonds,
        budget: &FractureBudget,
    ) {
        for explosion in std::mem::take(&mut bodies.explosions) {
            let mut reached: Vec<(BodyId, u32)> = (bodies.iter())
                .filter(|&slot| bodies.is_active(slot))
                .map(|slot| (bodies.id(slot), slot))
                .collect();
            reached.sort_unstable();
            for (_, slot) in reached {
                if bodies.cluster(slot).is_some() {
                    self.push_parts(bodies, slot, (bonds, budget), &explosion);
                } else if bodies.kind(slot) == RigidBody::Dynamic
                    && let Some(forces) = explosion.forces_on(bodies, slot)
                {
                    // Of finite numbers, but their product may not be.
                    let _ = bodies.apply(slot, &forces);
                }
            }
        }
    }

    /// Lets an explosion act on a cluster.
    fn push_parts(
        &mut self,
        bodies: &mut Bodies,
        slot: u32,
        (bonds, budget): (&mut Bonds, &FractureBudget),
        explosion: &Explosion,
    ) {
        let pushes = explosion.pushes_on(bodies, slot);
        let Some(state) = bodies.cluster(slot).filter(|_| !pushes.is_empty()) else {
            return;
        };
        let network = state.network.clone();
        let energy = network.push_energy(&pushes, |part| state.holds(part));
        let hit = Hit::of_pushes(&pushes);
        let is_enough = energy >= network.least_energy;
        let outcome = is_enough.then(|| network.blow(hit, |part| state.holds(part)));
        let outcome = outcome.unwrap_or_default();
        let wears = bodies.fatigue(slot).copied();
        let wears = wears.filter(|it| energy > network.least_strain(it.endurance));
        let strained = wears.map(|it| {
            let strained = network.strained(hit, it.endurance, |part| state.holds(part));
            (strained, energy / it.energy)
        });
        bodies.wake(slot);
        let left = self.state.left(budget);
        let broken = BrokenBonds {
            of: network.bonds.len(),
            bonds: outcome.broken,
        };
        let division = Groups::of(bodies, slot, &broken.bonds);
        let Some(groups) = division.filter(|_| left >= MIN_PIECES) else {
            bodies.push_whole(slot, &pushes);
            if let Some((strained, share)) = strained {
                bodies.wear_bonds(slot, &strained, share);
            }
            self.state.break_later(bodies, slot, broken);
            return;
        };
        let groups = groups.limited(left);
        let is_free = bodies.kind(slot) == RigidBody::Dynamic;
        let work = f64::from(outcome.work);
        let given = network.pushed(&groups.pieces, &pushes, (is_free, work));
        let turn = bodies.pose(slot).rotation;
        let report = report(bodies, slot, &pushes, (explosion, energy, outcome.work));
        let is_joined = groups.is_joined;
        let division = Division::Groups(groups);
        let Ok(fracture) = self.replace(bodies, bonds, slot, division, budget) else {
            return bodies.push_whole(slot, &pushes);
        };
        fracture.blow = Some(report);
        let pieces = fracture.pieces.iter().zip(&fracture.numbers);
        pieces.for_each(|(&piece, &number)| push(bodies, piece, turn, given[number as usize]));
        if is_joined {
            self.await_rest(bodies, Some(report));
        }
    }
}

/// Gives a piece impulse and angular impulse about its center, in the frame of what it was part of, which is turned so.
fn push(bodies: &mut Bodies, piece: u32, turn: Quat, given: Wrench) {
    let forces = StepForces {
        impulse: rotate(turn, given.force.as_vec3()),
        angular_impulse: rotate(turn, given.torque.as_vec3()),
        ..StepForces::default()
    };
    // Of finite numbers, but their product may not be.
    let _ = bodies.apply(piece, &forces);
}

/// What the fracture is reported with.
fn report(
    bodies: &Bodies,
    slot: u32,
    pushes: &[Push],
    (explosion, energy, work): (&Explosion, f32, f32),
) -> BreakingImpact {
    let sum: Vec3 = pushes.iter().map(|push| push.impulse).sum();
    let sizes = pushes.iter().map(|push| push.impulse.length());
    BreakingImpact {
        impulse: sizes.sum(),
        energy,
        withstood: 1.0 - (1.0 - work / energy).max(0.0).sqrt(),
        by: None,
        point: explosion.center,
        direction: rotate(bodies.pose(slot).rotation, sum).normalize_or(Vec3::Y),
    }
}
