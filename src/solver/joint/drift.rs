//! Where the bodies of joints go in a sub-step, and the impulses that have them joined there.
//!
//! What the rows know of the end of a sub-step is where it would be if nothing turned. Where the bodies would really be is seen by
//! moving them; what is amiss there becomes impulses along the rows as they are, and the bodies are moved anew. Each round gains a
//! factor of about `h omega`.

use crate::bodies::free_rotation::{FreeRotation, FreeRotations, SPINS};
use crate::math::rotate_by;
use crate::simd::dispatch::run;
use crate::simd::lanes::{Kernel, LaneWidth, Lanes};
use crate::solver::joint::measure::{Frames, Place};
use crate::solver::joint::rounds::Move;
use crate::solver::joint::row::{EPSILON, RowState};
use crate::solver::joint::rows::{measure_of, position_of};
use crate::solver::joint::system::{JointEndpoint, JointSystem};
use crate::solver::joint::vector6::{Vector6, split};
use glam::Vec3;

/// Most rounds: two or three as a rule; limbs that are thrown at a wall ask for ten, and what searches along the rows of the end for more.
const ROUNDS: usize = 24;

/// What may be amiss, as a share of the joint's levers, or rad: a few roundings of a rotation.
const TOLERANCE: f64 = 2e-7;

/// Farthest way of a body that is pushed, over that by which what is apart comes together.
const MOST_PUSH: f64 = 2.0;

/// Where bodies are after a motion.
#[derive(Debug, Default)]
pub(crate) struct Drift {
    pub(crate) bodies: Vec<Moved>,
}

/// A body after the motion.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moved {
    pub(crate) place: Place,
    pub(crate) spin: FreeRotation,
    /// Angular velocity, rad/s.
    pub(crate) angular: Vec3,
}

impl JointSystem {
    /// Changes velocities and impulses so that the joints hold where the bodies are `h` seconds later, which `drift` says then. Pushes
    /// together what is apart for another reason than motion.
    pub(crate) fn keep_together(&mut self, drift: &mut Drift, h: f64, width: LaneWidth) {
        self.pushes.clear();
        self.rounds.begin(self.components.len());
        let mut has_retreated = false;
        drift.bodies.resize(self.bodies.len(), Moved::default());
        for round in 0..ROUNDS {
            drift.follow(self, h, width);
            let system = &mut *self;
            run(width, FindMisses { system, drift, h });
            let [goes_on, retreats] = self.rounds.judge();
            has_retreated = retreats;
            if goes_on || retreats {
                let system = &mut *self;
                run(width, StepBack { system, h });
            }
            if round + 1 == ROUNDS || !goes_on {
                break;
            }
            for (component, number) in self.components.iter_mut().zip(0..) {
                component.is_asked = self.rounds.next(number) == Move::Step;
            }
            self.apply_missing();
            self.take_back_slips();
        }
        self.forget_curves_of_open();
        let is_pushed = self.rows.iter().any(|row| row.push != 0.0);
        if is_pushed {
            self.find_pushes(h);
        }
        if is_pushed || has_retreated {
            drift.follow(self, h, width);
        }
        self.note_borrowed_spin(1.0);
    }

    /// Whether for some joints no motion was found at whose end they hold.
    pub(crate) fn is_lost(&self) -> bool {
        self.rounds.any_lost()
    }

    /// Takes a sub-step back whose motion was not found, once the velocities are what they were: the rows are where the bodies are again, for
    /// sub-steps of `h` seconds.
    pub(crate) fn take_back(&mut self, h: f64) {
        self.linearise(h);
        self.is_bent = false;
    }

    /// Finds the impulses that rows miss for what is amiss after a motion.
    #[inline(always)]
    fn find_misses(&mut self, drift: &Drift, h: f64) {
        self.missing.clear();
        for joint in &self.joints {
            let Some(progress) = self.rounds.going_on(joint.component) else {
                self.missing.resize(joint.rows.end, 0.0);
                continue;
            };
            let place = |side: usize| match joint.ends[side] {
                JointEndpoint::Jointed(body) => drift.bodies[body as usize].place,
                JointEndpoint::Fixed(body) => self.fixed[body as usize].after(h),
            };
            let (a, b) = (place(0), place(1));
            let frames = Frames::of([&a, &b], joint.anchors, joint.frames, joint.has_angles);
            let [linear, angular] = [TOLERANCE * joint.levers + joint.slack, TOLERANCE];
            let along_end = progress
                .is_along_end()
                .then(|| frames.measure(&joint.joint, joint.angle));
            let is_stale = &mut self.components[joint.component as usize].is_stale;
            for row in &mut self.rows[joint.rows.clone()] {
                let tolerance = if row.is_angular { angular } else { linear };
                if row.push != 0.0 {
                    progress.note_push();
                }
                // What is pushed is followed nowhere: an angle that is far off may jump to the other side.
                let position = if row.is_position() && row.push == 0.0 {
                    position_of(&joint.joint, &frames, joint.angle, row)
                } else {
                    None
                };
                let amiss = position.map_or(0.0, |position| row.goal - position);
                let is_off = amiss.abs() > tolerance;
                if row.state != RowState::Free && is_off && row.side * amiss > 0.0 {
                    // A limit that turns out to be reached.
                    row.state = RowState::Free;
                    *is_stale = true;
                    progress.forget();
                }
                if row.state != RowState::Free {
                    let slips = !row.is_position();
                    self.missing.push(if slips {
                        row.missing_impulse(|| 0.0)
                    } else {
                        0.0
                    });
                    continue;
                }
                if let (Some(measures), Some(_)) = (&along_end, position)
                    && let Some(measure) = measure_of(measures, row)
                {
                    row.jacobian = measure.jacobian;
                    *is_stale = true;
                }
                progress.note(amiss.abs() / tolerance);
                self.missing.push(row.stiffness * amiss / h);
            }
        }
    }

    /// Takes note of velocities and impulses of the components that take a step, and goes back by a share of the last one with those that
    /// retreat; only the first are given what they miss.
    #[inline(always)]
    fn step_back_or_remember(&mut self, h: f64) {
        let Self {
            rounds,
            sparsity,
            velocities,
            rows,
            joints,
            missing,
            ..
        } = self;
        rounds.velocities.resize(velocities.len(), [0.0; 6]);
        rounds.impulses.resize(rows.len(), 0.0);
        for (body, &component) in sparsity.components.iter().enumerate() {
            let next = rounds.next(component);
            let (now, before) = (&mut velocities[body], &mut rounds.velocities[body]);
            match next {
                Move::Step => *before = *now,
                Move::Retreat(share) => {
                    for (now, before) in now.iter_mut().zip(before) {
                        *now = step_back(*now, *before, share);
                    }
                }
                Move::Stop => {}
            }
        }
        for joint in joints.iter() {
            let component = joint.component;
            let (next, is_along_end) = (rounds.next(component), rounds.is_along_end(component));
            for number in joint.rows.clone() {
                let (row, missing) = (&mut rows[number], &mut missing[number]);
                let (now, before) = (&mut row.impulse, &mut rounds.impulses[number]);
                match next {
                    Move::Step => *before = *now,
                    Move::Retreat(share) => *now = step_back(*now, *before, share),
                    Move::Stop => {}
                }
                if next != Move::Step {
                    *missing = 0.0;
                }
                if next != Move::Stop && row.always_acts() {
                    let is_curve = !is_along_end && row.stiffness > 0.0;
                    row.curve = if is_curve {
                        row.curve + *missing / (row.stiffness * h)
                    } else {
                        0.0
                    };
                }
            }
        }
    }

    /// Friction and drives that a step would have bear more than they can slip instead: such steps are not taken, and the next ones know.
    fn take_back_slips(&mut self) {
        if !self.has_bounds {
            return;
        }
        for joint in &self.joints {
            let component = joint.component;
            if self.rounds.next(component) != Move::Step {
                continue;
            }
            let rows = self.rows[joint.rows.clone()].iter_mut();
            for row in rows.filter(|row| row.state == RowState::Free && !row.is_position()) {
                row.state = row.state_at(|| 0.0);
                if row.state != RowState::Free {
                    self.components[component as usize].is_stale = true;
                    self.rounds.take_back(component);
                }
            }
        }
        let Self {
            rounds,
            velocities,
            rows,
            ..
        } = self;
        for (body, &component) in self.sparsity.components.iter().enumerate() {
            if rounds.is_taken_back(component) {
                velocities[body] = rounds.velocities[body];
            }
        }
        for joint in &self.joints {
            if rounds.is_taken_back(joint.component) {
                for number in joint.rows.clone() {
                    rows[number].impulse = rounds.impulses[number];
                }
            }
        }
    }

    /// Where joints stay open, what the rounds found is no motion that comes again.
    fn forget_curves_of_open(&mut self) {
        for joint in &self.joints {
            if self.rounds.leave_open(joint.component) {
                for row in &mut self.rows[joint.rows.clone()] {
                    row.curve = 0.0;
                }
            }
        }
    }

    /// Finds velocities that push the bodies to where they belong and move no other joint.
    fn find_pushes(&mut self, h: f64) {
        self.missing.clear();
        let mut farthest = 0.0_f64;
        for row in &mut self.rows {
            // An angle goes by its arc at a lever of 1 m.
            farthest = farthest.max(row.push.abs());
            if row.is_rigid() {
                row.stiffness *= EPSILON / self.push_softness;
            }
            let acts = row.state == RowState::Free;
            let missing = if acts {
                row.stiffness * row.push / h
            } else {
                0.0
            };
            self.missing.push(missing);
        }
        // The rows are written anew before they are solved again.
        for component in &mut self.components {
            component.is_asked = true;
            component.is_stale = true;
        }
        self.find_changes();
        let speed = |change: &Vector6| split(change)[0].length();
        let fastest = self.changes.iter().map(speed).fold(0.0, f64::max);
        // A chain that is straight cannot become shorter but by much to the side, where others stand.
        let share = (MOST_PUSH * farthest / (h * fastest)).min(1.0);
        let position = &self.sparsity.position;
        let changes = position.iter().map(|&at| &self.changes[at as usize]);
        self.pushes
            .extend(changes.map(|change| change.map(|x| share * x)));
    }
}

/// Finds what rows miss.
struct FindMisses<'a> {
    system: &'a mut JointSystem,
    drift: &'a Drift,
    h: f64,
}

impl Kernel for FindMisses<'_> {
    type Output = ();
    const NEEDS_32_REGISTERS: bool = false;

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.system.find_misses(self.drift, self.h);
    }
}

/// Takes note of what is before a step, or goes back by a share of the last one.
struct StepBack<'a> {
    system: &'a mut JointSystem,
    h: f64,
}

impl Kernel for StepBack<'_> {
    type Output = ();
    const NEEDS_32_REGISTERS: bool = false;

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.system.step_back_or_remember(self.h);
    }
}

/// Goes back by a share of the way from `before`; by all of it, to the bit.
fn step_back(now: f64, before: f64, share: f64) -> f64 {
    if share < 1.0 {
        now + share * (before - now)
    } else {
        before
    }
}

impl Drift {
    /// Moves the bodies from where they are, unless they go where they have gone.
    fn follow(&mut self, system: &JointSystem, h: f64, width: LaneWidth) {
        let is_pushed = !system.pushes.is_empty();
        let moves = |&component: &u32| is_pushed || system.rounds.moves(component);
        let components = system.sparsity.components.chunks(SPINS);
        let bodies = system.bodies.chunks(SPINS).zip(components);
        let to = self.bodies.chunks_mut(SPINS);
        for (((bodies, components), velocities), to) in
            bodies.zip(system.velocities.chunks(SPINS)).zip(to)
        {
            if !components.iter().any(moves) {
                continue;
            }
            let mut spins = FreeRotations::default();
            for (body, velocity) in bodies.iter().zip(velocities) {
                spins.push(body.spin, split(velocity)[1].as_vec3());
            }
            spins.advance(h as f32, width);
            let moved = bodies.iter().zip(velocities).zip(spins.iter());
            for (to, ((body, velocity), (spin, angular))) in to.iter_mut().zip(moved) {
                *to = Moved {
                    place: Place {
                        center: body.center + h * split(velocity)[0],
                        rotation: spin.rotation.as_dquat().normalize(),
                    },
                    spin: *spin,
                    angular,
                };
            }
        }
        for (moved, push) in self.bodies.iter_mut().zip(&system.pushes) {
            let [linear, angular] = split(push);
            moved.place.center += h * linear;
            moved.spin.rotation = rotate_by(moved.spin.rotation, angular.as_vec3(), h as f32);
            moved.place.rotation = moved.spin.rotation.as_dquat().normalize();
        }
    }
}
