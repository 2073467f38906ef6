//! Blows to bodies whose parts are held by bonds.

use crate::bodies::breaking::{Blow, ImpactLoad};
use crate::bodies::store::Bodies;
use crate::cluster::blow::BlowOutcome;
use crate::cluster::hit::{Hit, Striker};
use crate::contact::manifolds::{ManifoldRef, Manifolds};
use crate::geometry::groups_of;
use crate::math::rotate;
use crate::solver::batch::Batch;
use crate::solver::rows::contact_rows::RowBody;
use crate::solver::wide::block::vector;
use glam::Vec3;

/// How much more energy than a blow that broke nothing another one must have to be tried in the same step.
const RETRIED: f32 = 1.5;

/// Bonds of a cluster that broke without anything coming off.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Crack {
    pub(crate) slot: u32,
    /// How many bonds it had, and which of them are broken.
    pub(crate) of: usize,
    pub(crate) bonds: Vec<u32>,
}

/// Bonds of a cluster that a blow left whole, and wears.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Strain {
    pub(crate) slot: u32,
    /// How many bonds it had, which of them were loaded beyond their endurance, and the most that each bore, as a share of what it can.
    pub(crate) of: usize,
    pub(crate) bonds: Vec<(u32, f32)>,
    /// Of the blow, J.
    pub(crate) energy: f32,
}

impl Batch {
    /// At the end of the step: which bonds of clusters that wear out its blows have strained.
    pub(super) fn note_strains(&mut self, manifolds: &Manifolds, bodies: &Bodies) {
        if bodies.wearing.is_empty() {
            return;
        }
        for index in 0..self.impacts.limits.len() {
            let number = self.impacts.limits[index].body;
            let energy = self.impacts.loads[number as usize].energy;
            let slot = self.layout.slots[number as usize];
            let (Some(state), Some(fatigue)) = (bodies.cluster(slot), bodies.fatigue(slot)) else {
                continue;
            };
            let network = &state.network;
            if energy <= network.least_strain(fatigue.endurance) {
                continue;
            }
            let strikers = self.strikers(number, manifolds, bodies);
            let hit = Hit::of(&strikers);
            let left = &mut self.impacts.follow_left;
            let is_held = |part| state.holds(part);
            let bonds = network.strained(hit, fatigue.endurance, is_held, &[], left);
            if !bonds.is_empty() {
                self.impacts.strains.push(Strain {
                    slot,
                    of: network.bonds.len(),
                    bonds,
                    energy,
                });
            }
        }
    }

    /// What a load does to the bonds of a body: a blow if something comes off, or a note of what cracked. `limit`: by index.
    pub(crate) fn judge_bonds(
        &mut self,
        limit: usize,
        load: ImpactLoad,
        manifolds: &Manifolds,
        bodies: &Bodies,
    ) -> Option<Blow> {
        let number = self.impacts.limits[limit].body;
        let slot = self.layout.slots[number as usize];
        let state = bodies.cluster(slot)?;
        let strikers = self.strikers(number, manifolds, bodies);
        let left = &mut self.impacts.follow_left;
        let hit = Hit::of(&strikers);
        let outcome: BlowOutcome = (state.network).blow(hit, |part| state.holds(part), left);
        if outcome.broken.is_empty() {
            self.impacts.limits[limit].bond_energy = RETRIED * load.energy;
            return None;
        }
        let bonds = &state.network.bonds;
        let groups = groups_of(state.network.nodes.len(), bonds, |bond| {
            outcome.broken.binary_search(&(bond as u32)).is_ok()
        });
        if groups.iter().all(|&group| group == 0) {
            self.impacts.limits[limit].bond_energy = RETRIED * load.energy;
            self.impacts.cracks.retain(|crack| crack.slot != slot);
            self.impacts.cracks.push(Crack {
                slot,
                of: bonds.len(),
                bonds: outcome.broken,
            });
            return None;
        }
        let strained = bodies.fatigue(slot).map_or_else(Vec::new, |fatigue| {
            let (network, broken) = (&state.network, &outcome.broken);
            let is_held = |part| state.holds(part);
            let left = &mut self.impacts.follow_left;
            network.strained(hit, fatigue.endurance, is_held, broken, left)
        });
        Some(Blow {
            bonds: outcome.broken,
            bond_work: outcome.work,
            strained,
            ..self.blow_to(number, load, manifolds)
        })
    }

    /// All that pushes a body, frame of its shape.
    fn strikers(&self, number: u32, manifolds: &Manifolds, bodies: &Bodies) -> Vec<Striker> {
        let mut strikers = Vec::new();
        for (at, &pair) in self.layout.pairs.iter().enumerate() {
            let Some(side) = pair.iter().position(|body| body.0 == number) else {
                continue;
            };
            let (index, place) = self.layout.places[at];
            let lane = place.lane as usize;
            let block = &self.contacts.blocks[place.block as usize];
            let normal = vector(&block.normal, lane);
            let start = pair.map(|body| &self.impacts.start[body.index()]);
            let points = &self.contacts.points[block.points.clone()];
            let pushes = points[..place.count as usize].iter().map(|point| {
                let impulse = point.total_normal_impulse.0[lane] + point.impulse[0].0[lane];
                let speed = -point.normal_velocity(lane, normal, start);
                (impulse.max(0.0), speed)
            });
            let total: f32 = pushes.clone().map(|(impulse, _)| impulse).sum();
            if total > 0.0 {
                let manifold = manifolds.at(index.index());
                for (point, (impulse, speed)) in pushes.enumerate() {
                    let share = impulse / total;
                    if share > 0.0 {
                        let way = self.way_to_strike((at, point), &manifold, side);
                        let own = striker(&manifold, (side, point), way, bodies);
                        strikers.push(Striker {
                            speed,
                            // The points of a contact share the mass behind it.
                            inverse_mass: own.inverse_mass / share,
                            ..own
                        });
                    }
                }
            }
        }
        strikers
    }
}

/// What pushes the body on one side of a manifold at one of its points, with the whole mass of the other body and no speed; `way`: from the
/// point to where it does, world axes, m.
fn striker(
    manifold: &ManifoldRef,
    (side, point): (usize, usize),
    way: Vec3,
    bodies: &Bodies,
) -> Striker {
    let point = &manifold.points()[point];
    let slots = [manifold.a, manifold.b];
    let anchors = [point.anchor_a, point.anchor_b];
    let (own, other) = (slots[side], slots[1 - side]);
    let direction = if side == 0 {
        -manifold.normal
    } else {
        manifold.normal
    };
    let striker = RowBody::of(bodies, other as usize);
    let lever = anchors[1 - side].cross(direction);
    let to_body = bodies.pose(own).rotation.inverse();
    let place = rotate(to_body, anchors[side] + way) + bodies.mass(own).center;
    let compound = bodies.compound(own);
    Striker {
        part: compound.map_or(0, |compound| compound.part_at(place)),
        point: place,
        direction: rotate(to_body, direction),
        speed: 0.0,
        inverse_mass: striker.inverse_mass_at(lever),
    }
}
