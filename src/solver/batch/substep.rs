//! One step of one island: forces, rows, motion, as many times as there are sub-steps.
//!
//! Contact geometry is found once per step. Within it, a point's gap follows the motion of the two bodies along the
//! frozen normal, `s = s_0 + J q` with the displacements `q`; where bodies move fast against each other, or turn, the rows
//! are pointed anew at each sub-step.
//!
//! ```text
//! for each sub-step of h seconds:
//!   v += h g
//!   warm start                 the impulses of the sub-step before
//!   solve                      s -> target velocities, compliance, rebounds; then impulses
//!   q += h v
//!   relax                      takes the velocity that pushed overlap out from the bodies again; impacts rebound
//!   passive                    where that was not all, no energy stays
//! ```

use crate::bodies::solver_body::SolverBody;
use crate::contact::manifolds::Manifolds;
use crate::solver::adaptivity::SweepBudget;
use crate::solver::batch::layout::Layout;
use crate::solver::batch::parallel_pass::ParallelPass;
use crate::solver::batch::subdomain_slices::{each_part, parts_of_blocks};
use crate::solver::batch::{Batch, BatchScratch};
use crate::solver::config::{Method, SolverConfig};
use crate::solver::graph::indices::LaneSlot;
use crate::solver::graph::partition;
use crate::solver::rows::soft_step::Bias;
use crate::solver::rows::soft_step::Softness;
use crate::solver::settings::SubstepSettings;
use crate::solver::wide::block::{Point, vector};
use crate::solver::wide::contacts::{ContactBlocks, cells};
use crate::solver::wide::pass::Pass;
use crate::threads::parts::front_mut;
use crate::threads::team::{Shared, Team};
use std::sync::atomic::{AtomicU32, Ordering};

/// Rebounds are solved until no row changes by more than this share of the fastest one.
const REBOUND_TOLERANCE: f32 = 1e-5;

/// Share of the fastest body's speed that a sub-step need not be more precise than.
const MOVING_TOLERANCE: f32 = 0.01;

/// The same where bodies hit each other that may pass through each other in the step: what is left of their speeds is large.
const FAST_TOLERANCE: f32 = 1e-4;

/// Turn within a sub-step, rad, up to which rows that have been solved may be pointed anew.
const MAX_TURN: f32 = 0.05;

/// Bytes that a core's second-level cache keeps of what is gone through again and again; most have 512 KiB to 2 MiB.
const NEAR_CACHE: usize = 1 << 19;

/// What one sweep does.
#[derive(Clone, Copy, Debug)]
enum SweepKind {
    /// With position bias.
    Solve(Softness),
    /// The same, where target velocities are to be set on the way.
    SolveFrom {
        bias: Bias,
        first: bool,
        softness: Softness,
    },
    /// Without.
    Relax,
}

impl Batch {
    /// Advances the batch by a step, or gives up when a body of it breaks.
    pub fn solve(&mut self, manifolds: &Manifolds, team: Option<&Team>) {
        let settings = &{ self.settings };
        let mut effort = self.effort;
        let effort = &mut effort;
        self.forget_contact_velocity_changes();
        for substep in 0..settings.config.substeps {
            if substep > 0 {
                self.reanchor_with_contact_velocity_changes(team);
            }
            effort.begin(settings.config.substeps - substep);
            self.apply_gravity(settings, team);
            if self.is_calm() {
                self.solve_calm_substep(substep == 0, manifolds, effort, team);
            } else {
                self.solve_substep(substep == 0, manifolds, effort, team);
            }
            self.turn_bodies(settings.h, team);
            let is_last = substep + 1 == settings.config.substeps;
            if (is_last || self.may_break && self.can_hit()) && self.find_overloaded() {
                self.is_broken = self.may_break;
            }
            if self.is_broken {
                break;
            }
        }
        self.effort = *effort;
    }

    /// Whether bodies may hit each other.
    fn can_hit(&self) -> bool {
        !self.impacts.is_empty()
    }

    /// Whether nothing hits anything in this sub-step, so that targets need not be known before the warm start.
    fn is_calm(&self) -> bool {
        let config = &self.settings.config;
        let may_hit = || self.has_restitution || self.any_closes(config.restitution_threshold);
        config.method != Method::Exact && !(self.can_hit() && may_hit())
    }

    /// Does a pass over all contacts, several subdomains at a time if there is a team; returns the largest velocity change if it
    /// measures.
    pub fn pass(&mut self, pass: Pass, team: Option<&Team>) -> f32 {
        let is_far = self.is_far();
        let Some(team) = team else {
            let mut contacts = ContactBlocks {
                blocks: &self.blocks,
                points: &mut self.points,
                first_point: 0,
                impacts: &self.impacts,
                bodies: cells(&mut self.bodies),
                displacements: cells(&mut self.displacements),
                friction: self.settings.config.friction_model,
                width: self.settings.config.lane_width,
                is_far,
            };
            let last = &mut self.scratch.last_impulses;
            return if self.bond_constraints.is_empty() {
                contacts.pass(pass, last)
            } else {
                contacts.pass_bonded(pass, last, &mut self.bond_constraints)
            };
        };
        self.pass_with(pass, team, is_far)
    }

    /// Whether blocks and points are more than a near cache keeps from one pass to the next.
    fn is_far(&self) -> bool {
        size_of_val(&self.blocks[..]) + size_of_val(&self.points[..]) > NEAR_CACHE
    }

    fn pass_with(&mut self, pass: Pass, team: &Team, is_far: bool) -> f32 {
        let config = &self.settings.config;
        let work = ParallelPass {
            pass,
            blocks: &self.blocks,
            points: Shared::new(&mut self.points),
            has_bonds: !self.bond_constraints.is_empty(),
            bond_constraints: Shared::new(&mut self.bond_constraints),
            impacts: &self.impacts,
            bodies: Shared::new(&mut self.bodies),
            displacements: Shared::new(&mut self.displacements),
            last: Shared::new(&mut self.scratch.last_impulses),
            friction: config.friction_model,
            width: config.lane_width,
            is_far,
            change: AtomicU32::new(0),
        };
        let mut first = 0;
        for count in partition::stages(self.layout.subdomains.len()) {
            let stage = &self.layout.subdomains[first..first + count];
            team.run(count, &|subdomain| {
                let blocks = stage[subdomain].clone();
                // Half of what a separator joins was written by another thread.
                if first > 0 {
                    work.prefetch_bodies(blocks.clone());
                }
                work.run(blocks);
            });
            first += count;
        }
        f32::from_bits(work.change.load(Ordering::Relaxed))
    }

    /// A sub-step in which nothing hits anything.
    fn solve_calm_substep(
        &mut self,
        first: bool,
        manifolds: &Manifolds,
        effort: &mut SweepBudget,
        team: Option<&Team>,
    ) {
        let settings = &{ self.settings };
        let config = &settings.config;
        let tolerance = self.tolerance(config, MOVING_TOLERANCE, 0.0);
        let bias = settings.bias();
        let softness = settings.softness();
        let mut solve = SweepKind::SolveFrom {
            bias,
            first,
            softness,
        };
        if config.sweeps == 0 || !self.bond_constraints.is_empty() {
            self.pass(Pass::UpdateBias { bias, first }, team);
            solve = SweepKind::Solve(softness);
        }
        self.warm_start(team);
        self.sweep(config.sweeps, solve, tolerance, effort, team);
        self.move_bodies(settings, manifolds, team);
        self.relax(settings, tolerance, effort, team);
        self.note_contact_velocity_changes(team);
    }

    /// From targets to the relaxed velocities of a sub-step.
    fn solve_substep(
        &mut self,
        first: bool,
        manifolds: &Manifolds,
        effort: &mut SweepBudget,
        team: Option<&Team>,
    ) {
        let settings = &{ self.settings };
        let config = &settings.config;
        let fastest = self.set_targets(settings, first, team);
        let hits = self.note_impacts(settings.config.restitution_threshold);
        let share = if hits.any_fast {
            FAST_TOLERANCE
        } else {
            MOVING_TOLERANCE
        };
        let tolerance = self.tolerance(config, share, fastest);
        if config.method == Method::Exact {
            self.keep_free_velocities();
            self.solve_exactly(config, effort);
        } else {
            self.warm_start(team);
            let solve = SweepKind::Solve(settings.softness());
            self.sweep(config.sweeps, solve, tolerance, effort, team);
        }
        self.move_bodies(settings, manifolds, team);
        if hits.any {
            // What follows acts where the bodies are now: impacts are large enough to matter for the angular momentum.
            self.reanchor(MAX_TURN / settings.h, team);
        }
        self.relax(settings, tolerance, effort, team);
        self.note_contact_velocity_changes(team);
        if hits.any {
            self.restore_warm_start(config.restitution_threshold);
            self.forget_contact_velocity_changes();
        }
    }

    /// Fills the target velocities; returns the fastest rebound, scaled to a size of 1 m, m/s.
    fn set_targets(&mut self, settings: &SubstepSettings, first: bool, team: Option<&Team>) -> f32 {
        let bias = settings.bias();
        self.pass(Pass::UpdateBias { bias, first }, team);
        let mut fastest = 0.0_f32;
        if self.has_restitution {
            for i in 0..self.layout.places.len() {
                let (_, place) = self.layout.places[i];
                let block = &self.blocks[place.block as usize];
                if block.restitution.0[place.lane as usize] > 0.0 {
                    fastest = fastest.max(self.set_rebounds(place, settings));
                }
            }
        }
        fastest
    }

    /// Finds the points of a manifold that hit in this sub-step, and how fast they leave; returns the fastest,
    /// scaled to a size of 1 m, m/s.
    ///
    /// A point hits if the free motion closes its gap `s` within the sub-step. The speed at that moment follows from
    /// energy: `v^2 = v_0^2 + 2 a s` with the acceleration `a` of the gap. It leaves with `e v` from where the gap is closed.
    fn set_rebounds(&mut self, place: LaneSlot, settings: &SubstepSettings) -> f32 {
        let SubstepSettings {
            config, gravity, h, ..
        } = settings;
        let (block, lane) = (&self.blocks[place.block as usize], place.lane as usize);
        let (normal, restitution) = (vector(&block.normal, lane), block.restitution.0[lane]);
        let [a, b] = block.pair(lane).map(|b| &self.bodies[b as usize]);
        let falls = |body: &SolverBody| f32::from(u8::from(body.inverse_mass > 0.0));
        let acceleration = -normal.dot(*gravity) * (falls(b) - falls(a));
        let gap = |point: &Point| (-point.target_velocity.0[lane] * h).max(0.0);
        let speed = |point: &Point| -point.normal_velocity(lane, normal, [a, b]);
        let hits = |point: &Point, h: f32| {
            let speed = speed(point);
            speed > config.restitution_threshold && speed * h > gap(point)
        };
        let first = block.points.start;
        let range = first..first + place.count as usize;
        let (points, impacts) = (&mut self.points[range.clone()], &mut self.impacts[range]);
        // Corners of a face that all but lie at one height hit together, or the face would start to rock.
        let reach = if points.iter().any(|point| hits(point, *h)) {
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
                if config.relax_sweeps == 0 {
                    point.target_velocity.0[lane] = point.target_velocity.0[lane].max(rebound);
                }
            }
        }
        fastest
    }

    fn relax(
        &mut self,
        settings: &SubstepSettings,
        tolerance: Option<f32>,
        effort: &mut SweepBudget,
        team: Option<&Team>,
    ) {
        let config = &settings.config;
        if config.relax_sweeps == 0 {
            return;
        }
        if config.method == Method::Exact {
            return self.relax_exactly(settings, effort);
        }
        self.sweep(
            config.relax_sweeps,
            SweepKind::Relax,
            tolerance,
            effort,
            team,
        );
    }

    /// Sweeps `least` times, then with [`momentum`](crate::solver::rows::acceleration) until a sweep changes no velocity by more than
    /// `tolerance`, but not more often than the configuration allows, nor than is left for the step.
    fn sweep(
        &mut self,
        least: u32,
        kind: SweepKind,
        tolerance: Option<f32>,
        effort: &mut SweepBudget,
        team: Option<&Team>,
    ) {
        let config = self.settings.config;
        let most = config.max_sweeps.min(least + effort.share());
        let (mut change, mut done) = (0.0, 0);
        self.scratch.acceleration.restart();
        while done < least || tolerance.is_some_and(|t| change > t) && done < most {
            let is_extra = done >= least;
            if is_extra {
                self.go_on(team);
            }
            done += 1;
            let measure = tolerance.is_some() && done >= least;
            let pass = match kind {
                SweepKind::SolveFrom {
                    bias,
                    first,
                    softness,
                } if done == 1 => Pass::SolveFirst {
                    bias,
                    first,
                    softness,
                    measure,
                },
                SweepKind::Solve(softness) | SweepKind::SolveFrom { softness, .. } => {
                    Pass::Solve { softness, measure }
                }
                SweepKind::Relax => Pass::Relax { measure },
            };
            change = self.pass(pass, team);
            if is_extra {
                self.scratch.acceleration.note(change);
            }
        }
        effort.note(done, done - least, tolerance.is_some_and(|t| change > t));
    }

    /// Moves impulses and velocities on in the direction of their last change, or remembers them for the next time.
    fn go_on(&mut self, team: Option<&Team>) {
        let BatchScratch {
            acceleration,
            last_impulses,
            last_bodies,
            ..
        } = &mut self.scratch;
        let Layout {
            cuts, subdomains, ..
        } = &self.layout;
        last_bodies.resize(self.bodies.len(), SolverBody::default());
        let bodies = (&mut self.bodies[..], &mut last_bodies[..]);
        let Some(weight) = acceleration.weight() else {
            each_part(cuts, team, bodies, |now, last| last.copy_from_slice(now));
            last_impulses.resize(self.points.len(), Default::default());
            let mut last = &mut last_impulses[..];
            let parts = parts_of_blocks(&mut self.blocks, &mut self.points, subdomains, team);
            let parts = parts.map(|(_, points)| (front_mut(&mut last, points.len()), points));
            Team::each(team, parts, |(last, now)| {
                for (last, now) in last.iter_mut().zip(now) {
                    *last = now.impulse;
                }
            });
            return;
        };
        each_part(cuts, team, bodies, |now, last| {
            for (body, last) in now.iter_mut().zip(last) {
                let now = *body;
                body.linear = now.linear + weight * (now.linear - last.linear);
                body.angular = now.angular + weight * (now.angular - last.angular);
                *last = now;
            }
        });
        self.pass(Pass::Extrapolate { weight }, team);
    }

    /// The tolerance of a sub-step, m/s: the user's or, where bodies move, a `share` of the speed of the fastest, whichever
    /// island is the strictest; or that of rebounds, the fastest of which has the speed `rebound`.
    fn tolerance(&self, config: &SolverConfig, share: f32, rebound: f32) -> Option<f32> {
        let asked = config.tolerance.map(|tolerance| {
            let islands = self.scratch.fastest.iter().zip(&self.extents);
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
}
