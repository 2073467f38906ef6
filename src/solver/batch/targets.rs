//! The velocities that the rows of a sub-step should have, what hits in it, and how precisely it is solved.

use crate::bodies::solver_body::SolverBody;
use crate::solver::batch::Batch;
use crate::solver::batch::sweeps::SweepKind;
use crate::solver::graph::indices::LaneSlot;
use crate::solver::wide::block::{Point, vector};
use crate::solver::wide::pass::Pass;
use crate::threads::team::Team;

/// Rebounds are solved until no row changes by more than this share of the fastest one.
const REBOUND_TOLERANCE: f32 = 1e-5;

/// Share of the fastest body's speed that a sub-step need not be more precise than.
const MOVING_TOLERANCE: f32 = 0.01;

/// The same where bodies hit each other that may pass through each other in the step: what is left of their speeds is large.
const FAST_TOLERANCE: f32 = 1e-4;

/// Whether bodies hit each other in a sub-step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Hits {
    /// Any.
    pub(crate) any: bool,
    /// Any that may pass through each other in the step.
    pub(crate) any_fast: bool,
}

/// What the sweeps of a sub-step are told.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Targets {
    /// How they begin: the first one may set the target velocities on the way.
    pub(crate) solve: SweepKind,
    /// Largest velocity change that a sweep may still make when they end, m/s.
    pub(crate) tolerance: Option<f32>,
    /// Whether bodies hit each other.
    pub(crate) hits: Hits,
}

impl Batch {
    /// Sets the target velocities or, where nothing hits anything and nothing is bonded, leaves it to the first sweep.
    pub(crate) fn set_targets(&mut self, is_first: bool, team: Option<&Team>) -> Targets {
        let (bias, softness) = (self.settings.bias(), self.settings.softness());
        let update = Pass::UpdateBias { bias, is_first };
        if !self.is_calm() {
            self.pass(update, team);
            let fastest = self.set_all_rebounds();
            let hits = self.note_impacts(self.settings.restitution_threshold);
            let share = if hits.any_fast {
                FAST_TOLERANCE
            } else {
                MOVING_TOLERANCE
            };
            return Targets {
                solve: SweepKind::Solve(softness),
                tolerance: self.tolerance(share, fastest),
                hits,
            };
        }
        let mut solve = SweepKind::SolveFrom {
            bias,
            is_first,
            softness,
        };
        if self.settings.sweeps == 0 || self.bonds.any() {
            self.pass(update, team);
            solve = SweepKind::Solve(softness);
        }
        Targets {
            solve,
            tolerance: self.tolerance(MOVING_TOLERANCE, 0.0),
            hits: Hits::default(),
        }
    }

    /// Whether nothing hits anything in this sub-step, so that targets need not be known before the warm start.
    fn is_calm(&self) -> bool {
        let threshold = self.settings.restitution_threshold;
        let may_hit = || self.impacts.has_restitution || self.any_closes(threshold);
        !(self.settings.is_exact() || self.impacts.can_hit() && may_hit())
    }

    /// Finds all points that rebound; returns the fastest rebound, scaled to a size of 1 m, m/s.
    fn set_all_rebounds(&mut self) -> f32 {
        let mut fastest = 0.0_f32;
        if self.impacts.has_restitution {
            for i in 0..self.layout.places.len() {
                let (_, place) = self.layout.places[i];
                let block = &self.contacts.blocks[place.block as usize];
                if block.restitution.0[place.lane as usize] > 0.0 {
                    fastest = fastest.max(self.set_rebounds(place));
                }
            }
        }
        fastest
    }

    /// The tolerance of a sub-step, m/s: the user's or, where bodies move, a `share` of the speed of the fastest, whichever
    /// island is the strictest; or that of rebounds, the fastest of which has the speed `rebound`.
    fn tolerance(&self, share: f32, rebound: f32) -> Option<f32> {
        let asked = self.settings.tolerance.map(|tolerance| {
            let islands = self.bodies.fastest.iter().zip(&self.bodies.extents);
            let of_islands =
                islands.map(|(square, extent)| tolerance.max(share * (square / extent).sqrt()));
            of_islands.fold(f32::INFINITY, f32::min)
        });
        let of_rebounds = (rebound > 0.0).then_some(REBOUND_TOLERANCE * rebound);
        match (asked, of_rebounds) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        }
    }

    /// Finds the points of a manifold that hit in this sub-step, and how fast they leave; returns the fastest,
    /// scaled to a size of 1 m, m/s.
    ///
    /// A point hits if the free motion closes its gap `s` within the sub-step. The speed at that moment follows from
    /// energy: `v^2 = v_0^2 + 2 a s` with the acceleration `a` of the gap. It leaves with `e v` from where the gap is closed.
    fn set_rebounds(&mut self, place: LaneSlot) -> f32 {
        let settings = &self.settings;
        let (gravity, h) = (settings.gravity, settings.substep_dt);
        let (block, lane) = (
            &self.contacts.blocks[place.block as usize],
            place.lane as usize,
        );
        let (normal, restitution) = (vector(&block.normal, lane), block.restitution.0[lane]);
        let [a, b] = block
            .pair(lane)
            .map(|b| &self.bodies.velocities[b as usize]);
        let falls = |body: &SolverBody| f32::from(u8::from(body.inverse_mass > 0.0));
        let acceleration = -normal.dot(gravity) * (falls(b) - falls(a));
        let gap = |point: &Point| (-point.target_velocity.0[lane] * h).max(0.0);
        let speed = |point: &Point| -point.normal_velocity(lane, normal, [a, b]);
        let hits = |point: &Point, h: f32| {
            let speed = speed(point);
            speed > settings.restitution_threshold && speed * h > gap(point)
        };
        let first = block.points.start;
        let range = first..first + place.count as usize;
        let (points, impacts) = (
            &mut self.contacts.points[range.clone()],
            &mut self.impacts.points[range],
        );
        // Corners of a face that all but lie at one height hit together, or the face would start to rock.
        let reach = if points.iter().any(|point| hits(point, h)) {
            2.0 * h
        } else {
            0.0
        };
        let mut fastest = 0.0_f32;
        for (point, impact) in points.iter_mut().zip(impacts) {
            impact.rebound.0[lane] = 0.0;
            if hits(point, reach) {
                let before = speed(point) - acceleration * h;
                let squared = before * before + 2.0 * acceleration * gap(point);
                let rebound = restitution * squared.max(0.0).sqrt();
                impact.rebound.0[lane] = rebound;
                fastest = fastest.max(rebound * block.speed_scale.0[lane]);
                if settings.relax_sweeps == 0 {
                    point.target_velocity.0[lane] = point.target_velocity.0[lane].max(rebound);
                }
            }
        }
        fastest
    }
}
