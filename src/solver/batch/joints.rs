//! The joints of a batch within its sub-steps: around the sweeps over contacts, and where the bodies go.
//!
//! Where joints are alone, forces act in two halves, before and after the motion, and each half is solved once and to rounding.
//! Where contacts join in, all of a sub-step's forces act before the motion, as contacts expect, and each sweep is followed by an
//! exact solution for the joints.

use crate::bodies::free_rotation::FreeRotation;
use crate::bodies::solver_body::SolverBody;
use crate::bodies::store::Bodies;
use crate::joints::store::JointRecord;
use crate::solver::batch::{Batch, TurningBody};
use crate::solver::graph::indices::BodyNumber;
use crate::solver::joint::body::{FixedBody, JointedBody};
use crate::solver::joint::drift::Drift;
use crate::solver::joint::measure::Place;
use crate::solver::joint::rows::HalfSettings;
use crate::solver::joint::system::{JointEndpoint, JointSystem};
use crate::solver::joint::vector6::{Vector6, join, split};
use crate::solver::settings::ELASTIC;
use glam::{DVec3, Mat3, Vec3};

/// Marks a body that has no number among the jointed ones.
const NONE: u32 = u32::MAX;

/// Rounding of a coordinate, as a share of it: half a unit in the last place of a center and of an anchor.
const ROUNDING: f32 = 1.2e-7;

/// Softness of rows that push what is far apart together, of joints alone and beside contacts. Where joints cannot be met, as those of a straight
/// chain that is to be shorter, rigid rows would move bodies by any amount, to where others stand; so soft that a link gives way, they do not lift
/// a thousand times its mass either.
const PUSH_SOFTNESS: [f64; 2] = [1e-4, 1e-2];

/// A jointed body within its batch.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointedNumber {
    /// Its number.
    pub(super) body: BodyNumber,
    /// Its place among those that turn.
    turning: u32,
    /// Center of mass at the start of the step, m.
    start: DVec3,
}

/// Joints within a batch: empty where there are none.
#[derive(Debug, Default)]
pub struct BatchJoints {
    pub(super) system: JointSystem,
    drift: Drift,
    /// By jointed body.
    pub(super) numbers: Vec<JointedNumber>,
    /// By number of a body: its end of joints.
    ends: Vec<Option<JointEndpoint>>,
    /// By jointed body: what joints and free rotation have added to its velocities in the sub-step.
    pub(super) given: Vec<SolverBody>,
    /// Whether impulses of contacts have been changed since joints were solved.
    pub(super) is_disturbed: bool,
    /// Impulses of rows, and what was given, before the last sweep.
    last_impulses: Vec<f64>,
    last_given: Vec<SolverBody>,
    /// Whether there are contacts too.
    has_contacts: bool,
    /// Velocities at the start of the sub-step, where joints are alone.
    pub(super) start: Vec<SolverBody>,
    /// How often the sub-step has been halved.
    pub(super) halvings: u32,
    /// Whether that was of no use in this step.
    pub(super) halving_fails: bool,
}

impl BatchJoints {
    /// Whether there are any.
    pub(crate) fn any(&self) -> bool {
        !self.system.joints.is_empty()
    }

    /// Whether there are joints, and no contacts.
    pub(crate) fn are_alone(&self) -> bool {
        self.any() && !self.has_contacts
    }

    /// Whether joints move a body.
    pub(crate) fn hold(&self, body: BodyNumber) -> bool {
        self.any() && matches!(self.ends[body.index()], Some(JointEndpoint::Jointed(_)))
    }

    /// Shares of the forces of a sub-step that act before and after the motion.
    pub(super) fn shares(&self) -> [f32; 2] {
        if self.are_alone() {
            [0.5; 2]
        } else {
            [1.0, 0.0]
        }
    }

    /// Remembers the impulses of joints as they are before a sweep.
    pub(crate) fn remember(&mut self) {
        let BatchJoints {
            system,
            given,
            last_impulses,
            last_given,
            ..
        } = self;
        last_impulses.clear();
        last_impulses.extend(system.rows.iter().map(|row| row.impulse));
        last_given.clone_from(given);
    }

    /// Moves the impulses of joints on in the direction of their last change.
    pub(crate) fn extrapolate(&mut self, weight: f32) {
        let BatchJoints {
            system,
            given,
            last_impulses,
            last_given,
            ..
        } = self;
        let rows = system.rows.iter_mut().map(|row| &mut row.impulse);
        for (now, last) in rows.zip(last_impulses) {
            let change = *now - *last;
            *last = *now;
            *now += f64::from(weight) * change;
        }
        for (now, last) in given.iter_mut().zip(last_given) {
            let before = *now;
            now.linear += weight * (before.linear - last.linear);
            now.angular += weight * (before.angular - last.angular);
            *last = before;
        }
    }
}

impl Batch {
    /// Takes over the joints of its islands; `joints`: those of the step.
    pub(crate) fn load_joints(&mut self, joints: &[JointRecord], bodies: &Bodies) {
        self.joints.system.clear();
        if self.layout.joints.is_empty() {
            return;
        }
        self.joints.has_contacts = !self.layout.places.is_empty();
        self.joints.halving_fails = false;
        self.joints.system.push_softness = PUSH_SOFTNESS[usize::from(self.joints.has_contacts)];
        self.joints.numbers.clear();
        self.joints.ends.clear();
        self.joints.ends.resize(self.bodies.velocities.len(), None);
        self.joints.system.width = self.settings.lane_width;
        // The world.
        self.joints.system.fixed.push(FixedBody::default());
        for at in 0..self.layout.joints.len() {
            let (index, numbers) = self.layout.joints[at];
            let record = &joints[index as usize];
            let ends = numbers.map(|number| match number {
                Some(number) => self.end_of(number, bodies),
                None => JointEndpoint::Fixed(0),
            });
            let frames = [record.joint.frame_a, record.joint.frame_b];
            let centers = numbers.map(|number| number.map(|n| self.layout.slots[n.index()]));
            let anchors = [0, 1].map(|side| {
                let center = centers[side].map_or(Vec3::ZERO, |slot| bodies.mass(slot).center);
                frames[side].position.as_dvec3() - center.as_dvec3()
            });
            let angle = record.load.angle.into();
            let system = &mut self.joints.system;
            system.add_joint(record.joint, ends, anchors, angle);
            let far = centers.map(|slot| {
                slot.map_or(0.0, |slot| bodies.center[slot as usize].abs().max_element())
            });
            if let Some(joint) = system.joints.last_mut() {
                joint.slack = (ROUNDING * far[0].max(far[1])).into();
            }
        }
        self.load_tensions(joints);
        self.joints.system.analyse();
        self.load_jointed_turning(bodies);
        self.joints.given.clear();
        let count = self.joints.numbers.len();
        self.joints.given.resize(count, SolverBody::default());
    }

    /// What a joint holds on to of a body.
    fn end_of(&mut self, number: BodyNumber, bodies: &Bodies) -> JointEndpoint {
        if let Some(end) = self.joints.ends[number.index()] {
            return end;
        }
        let slot = self.layout.slots[number.index()];
        let i = slot as usize;
        let velocity = &self.bodies.velocities[number.index()];
        let system = &mut self.joints.system;
        let end = if velocity.inverse_mass > 0.0 {
            let mass = bodies.mass(slot);
            let center = bodies.center[i].as_dvec3();
            self.joints.numbers.push(JointedNumber {
                body: number,
                turning: NONE,
                start: center,
            });
            let locks = bodies.locks(slot).map(|axes| axes.as_dvec3());
            let spin = match locks[1] == DVec3::ZERO {
                true => FreeRotation::new(bodies.rotation[i], mass),
                false => FreeRotation::steady(bodies.rotation[i]),
            };
            system.bodies.push(JointedBody {
                spin,
                center,
                locks,
                mass: f64::from(velocity.inverse_mass).recip(),
                principal: mass.principal.as_dvec3(),
                frame: mass.principal_frame.as_dquat().normalize(),
                ..JointedBody::default()
            });
            system.velocities.push(velocity_of(velocity));
            JointEndpoint::Jointed(system.bodies.len() as u32 - 1)
        } else {
            system.fixed.push(FixedBody {
                place: Place {
                    center: bodies.center[i].as_dvec3(),
                    rotation: bodies.rotation[i].as_dquat().normalize(),
                },
                velocity: velocity_of(velocity),
            });
            JointEndpoint::Fixed(system.fixed.len() as u32 - 1)
        };
        self.joints.ends[number.index()] = Some(end);
        end
    }

    /// Has all jointed bodies among those that turn.
    fn load_jointed_turning(&mut self, bodies: &Bodies) {
        let turning = &mut self.bodies.turning;
        for (number, body) in self.joints.numbers.iter().zip(&self.joints.system.bodies) {
            let known = turning.binary_search_by_key(&number.body.0, |turning| turning.body);
            let at = known.unwrap_or_else(|at| {
                let slot = self.layout.slots[number.body.index()];
                turning.insert(
                    at,
                    TurningBody {
                        body: number.body.0,
                        start: body.spin.rotation,
                        spin: body.spin,
                        inverse_inertia: bodies.mass(slot).inverse_inertia(),
                        is_jointed: true,
                        is_round: false,
                        followed: Vec3::ZERO,
                    },
                );
                at
            });
            turning[at].is_jointed = true;
        }
        for number in &mut self.joints.numbers {
            let known = turning.binary_search_by_key(&number.body.0, |turning| turning.body);
            number.turning = known.map_or(NONE, |at| at as u32);
        }
    }

    fn half(&self, share: f32) -> HalfSettings {
        let settings = &self.settings;
        let speeds = settings.rebound_speeds(self.fastest_acceleration());
        HalfSettings {
            substep_dt: settings.substep_dt.into(),
            kick: (share * settings.substep_dt).into(),
            push_out_speed: settings.push_out_speed.into(),
            restitution_threshold: settings.restitution_threshold.into(),
            short_and_rest: speeds.map(f64::from),
            elastic: ELASTIC.into(),
        }
    }

    /// Begins a sub-step, after gravity.
    pub(crate) fn begin_joints(&mut self, is_first: bool) {
        if !self.joints.any() {
            return;
        }
        self.joints.given.fill(SolverBody::default());
        self.fetch_velocities();
        let half = self.half(self.joints.shares()[0]);
        let system = &mut self.joints.system;
        if is_first {
            system.begin_step(half.substep_dt);
        }
        system.begin_ahead(&half);
        self.return_velocities();
    }

    /// Gives the joints the velocities that satisfy them.
    pub(crate) fn solve_joints(&mut self) {
        if !self.joints.any() {
            return;
        }
        self.fetch_velocities();
        self.joints.system.solve();
        self.return_velocities();
    }

    /// Before the bodies move: has the joints hold at the end of the motion.
    pub(crate) fn keep_joints_together(&mut self) {
        if !self.joints.any() {
            return;
        }
        self.fetch_velocities();
        let (h, width) = (self.settings.substep_dt.into(), self.settings.lane_width);
        let BatchJoints { system, drift, .. } = &mut self.joints;
        system.keep_together(drift, h, width);
        self.return_velocities();
    }

    /// After the bodies have moved: turns those of joints, and has the rows be where they are now. Where it is
    /// the last motion of the step, that is where the next one will find them.
    pub(crate) fn turn_jointed_bodies(&mut self, is_last: bool) {
        if !self.joints.any() {
            return;
        }
        let share = self.joints.shares()[1];
        let half = self.half(share);
        let BatchJoints {
            system,
            drift,
            numbers,
            given,
            ..
        } = &mut self.joints;
        let gravity = share * self.settings.substep_dt * self.settings.gravity;
        for (number, push) in numbers.iter().zip(&system.pushes) {
            let [linear, angular] = split(push).map(|v| (half.substep_dt * v).as_vec3());
            let moved = &mut self.bodies.displacements[number.body.index()];
            moved.linear += linear;
            moved.angular += angular;
        }
        let jointed = system.bodies.iter_mut().zip(&drift.bodies);
        let jointed = jointed.zip(numbers.iter()).zip(given);
        for (((body, moved), number), given) in jointed {
            let i = number.body.index();
            let velocity = &mut self.bodies.velocities[i];
            given.angular += moved.angular - velocity.angular;
            velocity.angular = moved.angular;
            velocity.linear += gravity;
            body.spin = moved.spin;
            let shift = self.bodies.displacements[i].linear;
            body.center = if is_last {
                (number.start.as_vec3() + shift).as_dvec3()
            } else {
                number.start + shift.as_dvec3()
            };
            let turning = &mut self.bodies.turning[number.turning as usize];
            turning.spin = moved.spin;
            // What does not turn about some axes is as hard to turn as it was when the step began.
            if body.locks[1] == DVec3::ZERO {
                let r = Mat3::from_quat(moved.spin.rotation);
                let inertia = r * turning.inverse_inertia * r.transpose();
                self.bodies.masses[i].set_inverse_inertia(&inertia);
            }
        }
        if share > 0.0 {
            self.drive_for(share * self.settings.substep_dt);
            self.joints.system.note_impulses(true);
        }
        self.note_tensions();
        let system = &mut self.joints.system;
        let moving = |body: &&mut FixedBody| body.velocity != Vector6::default();
        for body in system.fixed.iter_mut().filter(moving) {
            body.place = body.after(half.substep_dt);
        }
        system.linearise(half.substep_dt);
        self.fetch_velocities();
        self.joints.system.begin_along(&half);
    }

    pub(super) fn fetch_velocities(&mut self) {
        let BatchJoints {
            system, numbers, ..
        } = &mut self.joints;
        for (velocity, number) in system.velocities.iter_mut().zip(numbers) {
            *velocity = velocity_of(&self.bodies.velocities[number.body.index()]);
        }
    }

    fn return_velocities(&mut self) {
        let BatchJoints {
            system,
            numbers,
            given,
            ..
        } = &mut self.joints;
        let jointed = numbers.iter().zip(&system.velocities).zip(given);
        for ((number, velocity), given) in jointed {
            let body = &mut self.bodies.velocities[number.body.index()];
            let [linear, angular] = split(velocity).map(|v| v.as_vec3());
            given.linear += linear - body.linear;
            given.angular += angular - body.angular;
            (body.linear, body.angular) = (linear, angular);
        }
    }
}

pub(super) fn velocity_of(body: &SolverBody) -> Vector6 {
    join(body.linear.as_dvec3(), body.angular.as_dvec3())
}
