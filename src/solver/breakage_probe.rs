//! Large islands: which of their bodies break, found from the neighborhood of the impacts before the whole is solved.
//!
//! An island in which a body breaks is solved once for nothing, and again with the pieces. For a wall of a thousand bricks
//! that is the step twice over, for the sake of a few bricks. So where it matters, what may break is solved alone first, with
//! the bodies around it and without the rest: how hard an impact is decides itself in its neighborhood. Its impulses say what
//! breaks, and how much of the impact that bears; the island is solved as a whole when no probe breaks anything any more.

use crate::bodies::breaking::{Blow, ImpactLoad};
use crate::bodies::store::Bodies;
use crate::contact::manifolds::{ManifoldRef, Manifolds};
use crate::solver::batch::Batch;
use crate::solver::graph::islands::{Island, Islands};
use crate::solver::rows::contact_rows::{Row, RowBody};
use crate::solver::settings::SubstepSettings;
use crate::tuning::PROBED_MANIFOLDS;

/// How many contacts away from an impact bodies take part.
const RINGS: usize = 2;

/// How much harder an impact may be than one between its two bodies alone: others may stand behind the one that is hit.
const BACKING: f32 = 2.0;

/// Marks a slot of no island that takes part.
pub(crate) const NONE: u32 = u32::MAX;

/// Buffers.
#[derive(Debug, Default)]
pub(crate) struct BreakageProbe {
    /// By slot: the large island in whose probe the body takes part.
    pub(crate) participants: Vec<u32>,
    /// Those that join with the next ring.
    pub(crate) joining: Vec<u32>,
    pub(crate) islands: Islands,
    pub(crate) batch: Batch,
    /// What bodies were hit with that break.
    pub(crate) overloaded: Vec<Blow>,
}

/// Whether an island is rehearsed.
pub(crate) fn is_large(island: &Island) -> bool {
    // What joints hold reaches farther than a neighborhood.
    island.manifolds.len() >= PROBED_MANIFOLDS && island.joints.is_empty()
}

impl BreakageProbe {
    /// Chooses who takes part: the bodies of contacts that may break one, and those around them; whether there is anybody.
    pub(crate) fn choose(
        &mut self,
        islands: &Islands,
        manifolds: &Manifolds,
        bodies: &Bodies,
        settings: &SubstepSettings,
    ) -> bool {
        self.participants.clear();
        self.participants.resize(bodies.slots(), NONE);
        let mut anybody = false;
        let large = (0..)
            .zip(&islands.list)
            .filter(|(_, island)| is_large(island));
        for (number, island) in large {
            let of_island = || {
                let indices = &islands.manifolds[island.manifolds.clone()];
                indices.iter().map(|&index| manifolds.at(index.index()))
            };
            let impacts = of_island().filter(|m| may_break(m, bodies, settings.step_dt()));
            self.joining.clear();
            self.joining.extend(impacts.flat_map(|m| [m.a, m.b]));
            anybody |= !self.joining.is_empty();
            for _ in 0..=RINGS {
                for slot in self.joining.drain(..) {
                    // Nothing gets from one side of a fixed body to the other.
                    if bodies.velocity[slot as usize].inverse_mass > 0.0 {
                        self.participants[slot as usize] = number;
                    }
                }
                let participants = &self.participants;
                let takes_part = |slot: u32| participants[slot as usize] != NONE;
                let rim = of_island().filter(|m| takes_part(m.a) != takes_part(m.b));
                self.joining.extend(rim.flat_map(|m| [m.a, m.b]));
            }
        }
        anybody
    }
}

/// Whether an impact at one of the points of a manifold may be more than one of its bodies bears.
fn may_break(manifold: &ManifoldRef, bodies: &Bodies, step: f32) -> bool {
    let slots = [manifold.a, manifold.b];
    let limits = slots.map(|slot| bodies.limit(slot));
    if limits == [None; 2] {
        return false;
    }
    let slots = slots.map(|slot| slot as usize);
    let [a, b] = slots.map(|i| &bodies.velocity[i]);
    let sides = slots.map(|i| RowBody::of(bodies, i));
    let mut impact = ImpactLoad::default();
    for point in manifold.points() {
        let on_a = a.linear + a.angular.cross(point.anchor_a);
        let on_b = b.linear + b.angular.cross(point.anchor_b);
        let speed = manifold.normal.dot(on_a - on_b);
        if speed * step > point.separation {
            let row = Row::new(manifold.normal, [point.anchor_a, point.anchor_b], sides);
            let impulse = BACKING * speed / row.diagonal;
            // The points of a contact share its impact.
            if impulse > impact.impulse {
                impact = ImpactLoad {
                    impulse,
                    energy: 0.0,
                };
                impact.add_energy(impulse, speed);
            }
        }
    }
    let mut limits = limits.iter().flatten();
    limits.any(|limit| limit.is_exceeded_by(&impact))
}
