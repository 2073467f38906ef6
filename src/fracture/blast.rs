//! Explosions: bodies are pushed, and clusters part by part, which may break them.

use crate::bodies::body::RigidBody;
use crate::bodies::explosion::Explosion;
use crate::bodies::store::Bodies;
use crate::cluster::elastic::Wrench;
use crate::cluster::hit::{Hit, Push};
use crate::cluster::network::Network;
use crate::contact::body_id::BodyId;
use crate::fracture::budget::FractureBudget;
use crate::fracture::cluster::{BrokenBonds, Groups};
use crate::fracture::pending::Division;
use crate::fracture::{Bonds, BreakingImpact, Fractures, MIN_PIECES};
use crate::math::rotate;
use glam::Vec3;

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
                    && let Some(push) = explosion.push_on(bodies, slot)
                {
                    bodies.push(slot, push);
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
        bodies.wake(slot);
        let left = self.state.left(budget);
        let mut broken = BrokenBonds {
            of: network.bonds.len(),
            bonds: outcome.broken,
        };
        let division = Groups::of(bodies, slot, &broken.bonds);
        let Some(groups) = division.filter(|_| left >= MIN_PIECES) else {
            bodies.push_whole(slot, &pushes);
            // What is worn out is gone.
            broken
                .bonds
                .extend(wear(bodies, slot, &network, (hit, energy)));
            broken.bonds.sort_unstable();
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
        for (&piece, &number) in pieces {
            let Wrench { force, torque } = given[number as usize];
            bodies.push(piece, [force, torque].map(|v| rotate(turn, v.as_vec3())));
        }
        if is_joined {
            self.await_rest(bodies, Some(report));
        }
    }
}

/// Wears the bonds of a body by an explosion that leaves it whole, if blows do; those that are worn out.
fn wear(bodies: &mut Bodies, slot: u32, network: &Network, (hit, energy): (Hit, f32)) -> Vec<u32> {
    let (Some(state), Some(fatigue)) = (bodies.cluster(slot), bodies.fatigue(slot).copied()) else {
        return Vec::new();
    };
    if energy <= network.least_strain(fatigue.endurance) {
        return Vec::new();
    }
    let strained = network.strained(hit, fatigue.endurance, |part| state.holds(part));
    if strained.is_empty() {
        return Vec::new();
    }
    bodies.wear_bonds(slot, &strained, energy / fatigue.energy)
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
