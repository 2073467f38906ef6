//! Explosions, and impulses at points: clusters are pushed part by part, which may break them.

use crate::bodies::body::RigidBody;
use crate::bodies::pushes::PointPush;
use crate::bodies::store::Bodies;
use crate::cluster::blow::FOLLOWED_PER_STEP;
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
        for explosion in std::mem::take(&mut bodies.pushes.explosions) {
            let mut reached: Vec<(BodyId, u32)> = (bodies.iter())
                .filter(|&slot| bodies.is_active(slot))
                .map(|slot| (bodies.id(slot), slot))
                .collect();
            reached.sort_unstable();
            for (_, slot) in reached {
                if bodies.cluster(slot).is_some() {
                    let pushes = explosion.pushes_on(bodies, slot);
                    let cause = (&pushes[..], explosion.center);
                    self.push_parts(bodies, slot, (bonds, budget), cause);
                } else {
                    self.press(bodies, slot, (bonds, budget), &explosion);
                }
            }
        }
    }

    /// Lets impulses act at points of clusters, by the ids of these.
    pub(super) fn push_at_points(
        &mut self,
        bodies: &mut Bodies,
        bonds: &mut Bonds,
        budget: &FractureBudget,
    ) {
        let mut impulses = std::mem::take(&mut bodies.pushes.impulses);
        impulses.retain(|push| bodies.is_current(push.slot, push.id));
        impulses.sort_by_key(|push| push.id);
        for own in impulses.chunk_by(|a, b| a.id == b.id) {
            let slot = own[0].slot;
            let known = bodies.cluster(slot).zip(bodies.compound(slot));
            let Some((state, compound)) = known.filter(|_| bodies.is_active(slot)) else {
                continue;
            };
            let mut pushes: Vec<Push> = Vec::new();
            for &PointPush { place, amount, .. } in own {
                let part = compound.part_at(place);
                let arm = place - state.network.nodes[part as usize].center.as_vec3();
                let angular_impulse = arm.cross(amount);
                match pushes.iter_mut().find(|push| push.part == part) {
                    Some(push) => {
                        push.impulse += amount;
                        push.angular_impulse += angular_impulse;
                    }
                    None => pushes.push(Push {
                        part,
                        impulse: amount,
                        angular_impulse,
                    }),
                }
            }
            let point = bodies.pose(slot).transform_point(own[0].place);
            self.push_parts(bodies, slot, (bonds, budget), (&pushes, point));
        }
        impulses.clear();
        bodies.pushes.impulses = impulses;
    }

    /// Lets impulses act on parts of a cluster; `point`: where they come from, world, m.
    fn push_parts(
        &mut self,
        bodies: &mut Bodies,
        slot: u32,
        (bonds, budget): (&mut Bonds, &FractureBudget),
        (pushes, point): (&[Push], Vec3),
    ) {
        let Some(state) = bodies.cluster(slot).filter(|_| !pushes.is_empty()) else {
            return;
        };
        let network = state.network.clone();
        let energy = network.push_energy(pushes, |part| state.holds(part));
        let hit = Hit::of_pushes(pushes);
        let is_enough = energy >= network.least_energy;
        let is_held = |part| state.holds(part);
        // An explosion strikes each once.
        let mut follow = FOLLOWED_PER_STEP;
        let outcome = is_enough.then(|| network.blow(hit, is_held, &mut follow));
        let outcome = outcome.unwrap_or_default();
        bodies.wake(slot);
        let left = self.state.left(budget);
        let mut broken = BrokenBonds {
            of: network.bonds.len(),
            bonds: outcome.broken,
        };
        // What is worn out is gone.
        let worn_out = wear(bodies, slot, &network, (hit, energy), &broken.bonds);
        broken.bonds.extend(worn_out);
        broken.bonds.sort_unstable();
        let division = Groups::of(bodies, slot, &broken.bonds);
        let Some(groups) = division.filter(|_| left >= MIN_PIECES) else {
            bodies.push_whole(slot, pushes);
            self.state.break_later(bodies, slot, broken);
            return;
        };
        let groups = groups.limited(left);
        let is_free = bodies.kind(slot) == RigidBody::Dynamic;
        let work = f64::from(outcome.work);
        let given = network.pushed(&groups.pieces, pushes, (is_free, work));
        let turn = bodies.pose(slot).rotation;
        let report = report(bodies, slot, pushes, (point, energy, outcome.work));
        let is_joined = groups.is_joined;
        let division = Division::Groups(groups);
        let Ok(fracture) = self.replace(bodies, bonds, slot, division, budget) else {
            return bodies.push_whole(slot, pushes);
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

/// Wears those bonds of a body that pushes leave whole, if blows do; those that are worn out.
fn wear(
    bodies: &mut Bodies,
    slot: u32,
    network: &Network,
    (hit, energy): (Hit, f32),
    broken: &[u32],
) -> Vec<u32> {
    let (Some(state), Some(fatigue)) = (bodies.cluster(slot), bodies.fatigue(slot).copied()) else {
        return Vec::new();
    };
    if energy <= network.least_strain(fatigue.endurance) {
        return Vec::new();
    }
    let is_held = |part| state.holds(part);
    let mut follow = FOLLOWED_PER_STEP;
    let strained = network.strained(hit, fatigue.endurance, is_held, broken, &mut follow);
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
    (point, energy, work): (Vec3, f32, f32),
) -> BreakingImpact {
    let sum: Vec3 = pushes.iter().map(|push| push.impulse).sum();
    let sizes = pushes.iter().map(|push| push.impulse.length());
    BreakingImpact {
        impulse: sizes.sum(),
        energy,
        withstood: 1.0 - (1.0 - work / energy).max(0.0).sqrt(),
        by: None,
        point,
        direction: rotate(bodies.pose(slot).rotation, sum).normalize_or(Vec3::Y),
    }
}
