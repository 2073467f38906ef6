//! Motors, friction, springs and limits move bodies as closed forms say, along and about each of the six axes.

use crate::common::dice::Dice;
use crate::members::{Carrier, Effort, Member, Rig, across, inertia, mirrored};
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};
use std::f32::consts::TAU;

/// Members of each test.
const SEEDS: u64 = 36;

/// A body that one axis of a joint lets move.
struct OnAxis {
    rig: Rig,
    body: u32,
    id: JointId,
    /// Which of the six.
    number: usize,
    axis: Vec3,
    /// Along or about the axis, kg or kg m2.
    mass: f32,
    /// What gravity does along or about it at first, N or N m.
    pull: f32,
    start: Pose,
    /// From the joint to its center of mass, m.
    arm: Vec3,
}

impl OnAxis {
    /// On axis `number` of the six, which points along `axis`. Where it turns gravity has as long a lever as it can.
    fn new(member: Member, number: usize, axis: Vec3, dice: &mut Dice) -> Self {
        let mut rig = Rig::new(member, dice);
        let at = member.size * dice.vector(-3.0, 3.0);
        let size = member.size * dice.vector(0.3, 1.0);
        let length = member.size * dice.in_range(0.3, 1.0);
        let level = axis.cross(member.up());
        let side = if level.length() > 1e-3 {
            level.normalize()
        } else {
            across(dice, axis)
        };
        let arm = length * side + dice.in_range(-1.0, 1.0) * member.size * axis;
        let start = Pose::new(at + arm, dice.rotation());
        let body = rig.add(size, start, member.mass);
        let unit = [Vec3::X, Vec3::Y, Vec3::Z][number % 3];
        let about = Quat::from_axis_angle(axis, dice.in_range(-3.0, 3.0));
        let turn = (about * Quat::from_rotation_arc(unit, axis)).normalize();
        let mut joint = Joint::fixed();
        *axis_of(&mut joint, number) = JointAxis::FREE;
        let id = rig.join(None, body, joint, [Pose::new(at, turn); 2]);
        let weight = member.weight();
        let (mass, pull) = if number < 3 {
            (member.mass, weight.dot(axis))
        } else {
            let own = inertia(size, member.mass, start.rotation, axis);
            let own = own + member.mass * length * length;
            (own, arm.cross(weight).dot(axis))
        };
        Self {
            rig,
            body,
            id,
            number,
            axis,
            mass,
            pull,
            start,
            arm,
        }
    }

    fn is_angular(&self) -> bool {
        self.number >= 3
    }

    /// How far it has moved, m or rad, and how fast it is.
    fn state(&self) -> [f64; 2] {
        let (v, omega) = self.rig.velocity(self.body);
        if !self.is_angular() {
            let moved = (self.rig.place(self.body) - self.start.position).dot(self.axis);
            return [moved.into(), v.dot(self.axis).into()];
        }
        let now = self.rig.simulation.bodies.pose(self.body).rotation;
        let turn = now.as_dquat() * self.start.rotation.as_dquat().inverse();
        let half = turn.xyz().dot(self.axis.as_dvec3());
        let angle = 2.0 * phase(half * turn.w.signum(), turn.w.abs());
        [angle, omega.dot(self.axis).into()]
    }

    /// Gives the body a speed along the axis or about it, m/s or rad/s, as seen from what carries it.
    fn throw(&mut self, speed: f32) {
        let (linear, angular) = if self.is_angular() {
            (speed * self.axis.cross(self.arm), speed * self.axis)
        } else {
            (speed * self.axis, Vec3::ZERO)
        };
        let carried = self.rig.member.carrier_velocity();
        let bodies = &mut self.rig.simulation.bodies;
        let set = bodies.set_velocity(self.body, carried + linear, angular);
        set.expect("finite");
    }

    /// Changes the axis.
    fn set(&mut self, change: impl FnOnce(&mut JointAxis)) {
        let (number, is_swapped) = (self.number, self.rig.is_swapped());
        self.rig.change(self.id, |joint| {
            let seen = |joint| if is_swapped { mirrored(joint) } else { joint };
            let mut straight = seen(*joint);
            change(axis_of(&mut straight, number));
            *joint = seen(straight);
        });
    }

    fn drive(&mut self, drive: BodyDrive) {
        let bodies = &mut self.rig.simulation.bodies;
        bodies.set_drive(self.body, drive).expect("usable");
    }
}

fn axis_of(joint: &mut Joint, number: usize) -> &mut JointAxis {
    match number {
        0..3 => &mut joint.linear[number],
        _ => &mut joint.angular[number - 3],
    }
}

#[expect(
    clippy::disallowed_methods,
    reason = "a test may differ in the last bit"
)]
fn phase(y: f64, x: f64) -> f64 {
    y.atan2(x)
}

#[expect(
    clippy::disallowed_methods,
    reason = "a test may differ in the last bit"
)]
fn logarithm(x: f64) -> f64 {
    x.ln()
}

#[expect(
    clippy::disallowed_methods,
    reason = "a test may differ in the last bit"
)]
fn cosine(x: f64) -> f64 {
    x.cos()
}

/// Without contacts, which are of first order in time, and with next to no gravity.
fn weightless(member: Member) -> Member {
    Member {
        gravity: 1e-6 * member.gravity,
        ..held(member)
    }
}

fn held(member: Member) -> Member {
    let is_standing = member.carrier == Carrier::Standing;
    Member {
        carrier: if is_standing {
            Carrier::Held
        } else {
            member.carrier
        },
        ..member
    }
}

/// What pulls a body against friction.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pull {
    Weight,
    Force,
    /// Half of each.
    Both,
}

/// Where a body is that is pulled against friction, and how fast.
fn slide(on: &OnAxis, friction: f32, t: f64) -> [f64; 2] {
    let (pull, friction) = (f64::from(on.pull), f64::from(friction));
    let acceleration = |x: f64| {
        let lever = if on.is_angular() { cosine(x) } else { 1.0 };
        (lever * pull - friction * pull.signum()) / f64::from(on.mass)
    };
    let (mut x, mut v) = (0.0, 0.0);
    let h = t / 1000.0;
    for _ in 0..1000 {
        let half = v + 0.5 * h * acceleration(x);
        x += h * half;
        v = half + 0.5 * h * acceleration(x);
    }
    [x, v]
}

/// A body on an axis with friction, pulled.
fn against_friction(seed: u64, pull: Pull, k: f32) -> (OnAxis, f32) {
    let mut dice = Dice::new(seed);
    let member = Member::draw(&mut dice);
    // What stands holds by its weight.
    let member = if pull == Pull::Force {
        held(member)
    } else {
        member
    };
    let number = dice.below(6);
    let level = across(&mut dice, member.up());
    let axis = if number < 3 {
        (level + dice.in_range(0.3, 2.0) * member.up()).normalize()
    } else {
        level
    };
    let mut on = OnAxis::new(member, number, axis, &mut dice);
    let friction = on.pull.abs() / k;
    on.set(|axis| axis.friction = friction);
    let share = match pull {
        Pull::Weight => 1.0,
        Pull::Force => 0.0,
        Pull::Both => 0.5,
    };
    on.drive(BodyDrive {
        force: (1.0 - share) * member.weight(),
        gravity_scale: share,
        ..BodyDrive::default()
    });
    (on, friction)
}

#[test]
fn friction_holds_a_tenth_less_and_lets_a_tenth_more_go_as_it_is_pulled() {
    for seed in 0..SEEDS {
        for pull in [Pull::Weight, Pull::Force, Pull::Both] {
            let (mut on, _) = against_friction(seed, pull, 0.9);
            let member = on.rig.member;
            // A second for each of sizes and efforts, five for some.
            let seconds = if seed % 4 == 0 { 5.0 } else { 1.0 };
            for _ in 0..(seconds * member.rate) as usize {
                on.rig.step();
            }
            let scale = if on.is_angular() {
                1.0
            } else {
                f64::from(member.size)
            };
            let [crept, _] = on.state();
            assert!(
                crept.abs() < 1e-3 * scale,
                "{seed} {pull:?}: {crept} {member:?}"
            );

            let (mut on, friction) = against_friction(seed, pull, 1.1);
            let acceleration = (on.pull.abs() - friction) / on.mass;
            let far = 0.3 * scale as f32;
            let steps = (2.0 * far / acceleration).sqrt() * member.rate;
            let steps = steps.clamp(2.0, 300.0) as u16;
            (0..steps).for_each(|_| on.rig.step());
            let t = f64::from(member.step()) * f64::from(steps);
            let [x, v] = slide(&on, friction, t);
            let off = (on.state()[1] - v).abs();
            // Small bodies at low rates have fallen too far in two steps.
            let is_right = x.abs() > 0.6 * scale || off < 0.02 * v.abs();
            assert!(
                is_right,
                "{seed} {pull:?}: {:?}, not {v} {member:?}",
                on.state()
            );
        }
    }
}

/// Frequency and damping ratio of a spring, as shares of the frequency, from where it turns in the plane of place and velocity.
fn measure(on: &mut OnAxis, [rest, omega, ratio]: [f64; 3], steps: u16) -> [f64; 2] {
    let root = (1.0 - ratio * ratio).sqrt();
    let at = |[x, v]: [f64; 2]| [omega * root * (x - rest), v + ratio * omega * (x - rest)];
    let first = at(on.state());
    let (mut last, mut turned) = (first, 0.0);
    for _ in 0..steps {
        on.rig.step();
        let now = at(on.state());
        let sine = last[0] * now[1] - last[1] * now[0];
        turned -= phase(sine, last[0] * now[0] + last[1] * now[1]);
        last = now;
    }
    let t = f64::from(on.rig.member.step()) * f64::from(steps);
    let length = |[a, b]: [f64; 2]| (a * a + b * b).sqrt();
    let decay = logarithm(length(first) / length(last)) / t;
    [turned / t / root / omega, decay / omega]
}

/// By frequency as by coefficients: with the mass that swings, which is that of all that turns about a hinge.
#[test]
fn springs_swing_at_their_frequency_and_decay_by_their_ratio() {
    for seed in 0..SEEDS {
        let mut dice = Dice::new(seed);
        let member = weightless(Member::draw(&mut dice));
        let (number, axis) = (dice.below(6), dice.direction());
        let period = dice.in_range(12.0, 60.0);
        let (hertz, damping_ratio) = (member.rate / period, dice.in_range(0.0, 0.3));
        let mut on = OnAxis::new(member, number, axis, &mut dice);
        let omega = TAU * hertz;
        let spring = if dice.below(2) == 0 {
            JointSpring::Coefficients {
                stiffness: on.mass * omega * omega,
                damping: 2.0 * damping_ratio * on.mass * omega,
            }
        } else {
            JointSpring::Frequency {
                hertz,
                damping_ratio,
            }
        };
        let rest = if number < 3 { member.size } else { 0.5 };
        on.set(|axis| axis.drive = Some(JointDrive::spring(rest, spring)));
        let expected = [rest, omega, damping_ratio].map(f64::from);
        let [frequency, ratio] = measure(&mut on, expected, (2.0 * period) as u16);
        // With twelve sub-steps a turn.
        let off = (frequency - 1.0).abs().max((ratio - expected[2]).abs());
        assert!(
            off < 0.01,
            "{seed}: {frequency} {ratio} {spring:?} {member:?}"
        );
    }
}

/// A body that falls on an end of its range: how high it comes back, over the height from which it fell, and where and how fast it ends.
fn fall(on: &mut OnAxis, far: f32, restitution: f32) -> [f64; 3] {
    let down = on.pull.signum();
    let ends = [down * far, -2.0 * down * far];
    let [min, max] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
    on.set(|axis| {
        axis.range = AxisRange::Limited { min, max };
        axis.restitution = restitution;
    });
    let acceleration = on.pull.abs() / on.mass;
    let steps = 10.0 * (2.0 * far / acceleration).sqrt() * on.rig.member.rate;
    let (mut has_hit, mut is_back, mut highest) = (false, false, 0.0_f64);
    for _ in 0..steps as usize {
        on.rig.step();
        let [x, v] = on.state().map(|now| f64::from(down) * now);
        // It has fallen until it rises, or rests.
        has_hit |= v <= 0.0;
        if has_hit && !is_back {
            highest = highest.max(1.0 - x / f64::from(far));
            // From the second fall on.
            is_back = v > 0.0 && highest > 0.02;
        }
    }
    let [x, v] = on.state().map(|now| f64::from(down) * now);
    [highest, x, v]
}

#[test]
fn what_falls_on_the_end_of_its_range_comes_back_or_rests() {
    for seed in 0..SEEDS {
        for is_elastic in [false, true] {
            let mut dice = Dice::new(seed);
            let member = held(Member::draw(&mut dice));
            let number = dice.below(6);
            let axis = if number < 3 {
                member.up()
            } else {
                across(&mut dice, member.up())
            };
            let elastic = dice.in_range(0.3, 0.9);
            let restitution = if is_elastic { elastic } else { 0.0 };
            let steps = dice.in_range(16.0, 40.0);
            let mut on = OnAxis::new(member, number, axis, &mut dice);
            let acceleration = on.pull.abs() / on.mass;
            let most = if on.is_angular() { 0.4 } else { f32::INFINITY };
            let t = member.step() * steps;
            let far = (0.5 * acceleration * t * t).min(most);
            let t = (2.0 * far / acceleration).sqrt();
            let [highest, x, v] = fall(&mut on, far, restitution);
            // It hits within a sub-step, which takes it to the end: off by a share of that in the time that it falls.
            let share = f64::from(member.substep() / t);
            let wanted = f64::from(restitution * restitution);
            if is_elastic {
                // A bounce of eight steps or less is none.
                let is_bounce = 2.0 * restitution * t > 9.0 * member.step();
                let is_right = (highest - wanted).abs() < 4.0 * share * wanted + 0.03;
                assert!(
                    !is_bounce || is_right,
                    "{seed}: {highest}, not {wanted} {member:?}"
                );
                continue;
            }
            assert!(highest < 0.02, "{seed}: {highest} {member:?}");
            let speed = f64::from(acceleration * t);
            let is_there = (x / f64::from(far) - 1.0).abs() < 1e-3 && v.abs() < 1e-3 * speed;
            assert!(is_there, "{seed}: {x} of {far}, {v} {member:?}");
            let force = on.rig.load(on.id).force + member.weight();
            let off = force.length() / member.weight().length();
            assert!(off < 0.01, "{seed}: {off} {member:?}");
        }
    }
}

/// Fastest speed at which a body goes back that is thrown at the end of its range, `far` away (m or rad), with a speed.
fn thrown_at_end(on: &mut OnAxis, far: f32, speed: f32, steps: usize) -> f64 {
    on.set(|axis| {
        axis.range = AxisRange::Limited {
            min: -2.0 * far,
            max: far,
        }
    });
    on.throw(speed);
    let mut fastest = 0.0_f64;
    for _ in 0..steps {
        on.rig.step();
        fastest = fastest.max(-on.state()[1]);
    }
    fastest
}

/// What brakes it may not act otherwise on the way back than on the way there: friction, and a motor that was fast enough and is to turn it again.
#[test]
fn what_is_braked_comes_back_with_its_share_of_the_speed() {
    for (seed, has_motor) in (0..SEEDS).flat_map(|seed| [(seed, false), (seed, true)]) {
        let mut dice = Dice::new(seed);
        let member = weightless(Member::draw(&mut dice));
        let (number, axis) = (dice.below(6), dice.direction());
        let mut on = OnAxis::new(member, number, axis, &mut dice);
        let far = if number < 3 { member.size } else { 0.4 };
        let steps = dice.in_range(5.0, 20.0);
        let speed = far / (steps * member.step());
        let lost = dice.in_range(0.05, 0.5);
        let restitution = dice.in_range(0.2, 0.9);
        // Of the energy, on the way to the end.
        let force = 0.5 * on.mass * speed * speed * lost / far;
        on.set(|axis| {
            axis.restitution = restitution;
            if has_motor {
                axis.drive = Some(JointDrive::velocity(speed, force));
            } else {
                axis.friction = force;
            }
        });
        let kept = if has_motor { 1.0 } else { 1.0 - lost };
        let wanted = f64::from(restitution * speed * kept.sqrt());
        let fastest = thrown_at_end(&mut on, far, speed, (2.0 * steps) as usize);
        let braked = f64::from(force / on.mass * member.step());
        let told = format!("{seed}: {fastest}, not {wanted} {has_motor} {number} {member:?}");
        assert!(fastest < 1.03 * wanted, "{told}");
        assert!(fastest > 0.97 * wanted - 1.5 * braked, "{told}");
    }
}

#[test]
fn soft_ends_of_a_range_do_not_brake_before_they_are_reached() {
    for seed in 0..SEEDS {
        let mut dice = Dice::new(seed);
        let member = weightless(Member::draw(&mut dice));
        let (number, axis) = (dice.below(6), dice.direction());
        let mut on = OnAxis::new(member, number, axis, &mut dice);
        let far = if number < 3 { member.size } else { 0.5 };
        let steps = dice.in_range(5.0, 20.0);
        let speed = far / (steps * member.step());
        let spring = JointSpring::Frequency {
            hertz: member.rate / dice.in_range(10.0, 30.0),
            damping_ratio: dice.in_range(0.0, 1.0),
        };
        on.set(|axis| {
            *axis = JointAxis {
                softness: Some(spring),
                ..JointAxis::limited(-far, far)
            };
        });
        on.throw(speed);
        (0..(steps - 1.0) as usize).for_each(|_| on.rig.step());
        let [_, now] = on.state();
        let off = (now / f64::from(speed) - 1.0).abs();
        assert!(off < 1e-3, "{seed}: {now} of {speed} {spring:?} {member:?}");
    }
}

#[test]
fn motors_hold_their_speed_below_their_bound_and_give_way_beyond() {
    for seed in 0..SEEDS {
        for k in [0.9, 1.1] {
            let mut dice = Dice::new(seed);
            let member = held(Member::draw(&mut dice));
            let number = dice.below(6);
            let level = across(&mut dice, member.up());
            let axis = if number < 3 {
                (member.up() + dice.in_range(0.0, 2.0) * level).normalize()
            } else {
                level
            };
            let mut on = OnAxis::new(member, number, axis, &mut dice);
            let acceleration = on.pull / on.mass;
            let steps = dice.in_range(1.0, 20.0);
            // Against the pull; what its bound leaves takes it there in these steps.
            let speed = -(1.0 / 0.9 - 1.0) * acceleration * member.step() * steps;
            let bound = on.pull.abs() / k;
            on.set(|axis| axis.drive = Some(JointDrive::velocity(speed, bound)));
            for step in 1..=40_u8 {
                on.rig.step();
                let [x, v] = on.state();
                // A lever that has turned by more bears less.
                if on.is_angular() && x.abs() > 0.05 {
                    break;
                }
                let t = f32::from(step) * member.step();
                let expected = f64::from(if k > 1.0 {
                    (1.0 - 1.0 / k) * acceleration * t
                } else {
                    speed
                });
                let is_early = k < 1.0 && f32::from(step) < steps + 2.0;
                let most = if k > 1.0 { 0.02 } else { 1e-3 };
                // What rows make good in a sub-step of how round places are, some sizes from the origin, may be more than the bound leaves.
                let arm = if on.is_angular() {
                    0.3 * member.size
                } else {
                    1.0
                };
                let round = f64::from(5e-7 * member.size / member.substep() / arm);
                let is_right = (v - expected).abs() < most * expected.abs() + round;
                assert!(
                    is_early || is_right,
                    "{seed} {k}, step {step}: {v}, not {expected} {member:?}"
                );
            }
        }
    }
}

/// Gravity that is scaled is gravity: what is weightless stays.
#[test]
fn sliders_fall_by_their_share_of_gravity() {
    for (seed, scale) in (0..SEEDS).zip([0.0_f32, 0.5, 2.0].into_iter().cycle()) {
        let mut dice = Dice::new(seed);
        let member = held(Member::draw(&mut dice));
        let number = dice.below(3);
        let mut on = OnAxis::new(member, number, member.up(), &mut dice);
        on.drive(BodyDrive {
            gravity_scale: scale,
            ..BodyDrive::default()
        });
        (0..60).for_each(|_| on.rig.step());
        let t = 60.0 * f64::from(member.step());
        let fall = 0.5 * f64::from(member.gravity.length()) * t * t;
        let [x, _] = on.state();
        let off = (x / fall + f64::from(scale)).abs();
        assert!(off < 2e-4, "{seed}, {scale}: {x} of {fall} {member:?}");
    }
}

/// Undamped springs towards places about all three axes of a ball keep what energy they have.
#[test]
fn springs_about_three_axes_give_no_energy() {
    for seed in 0..SEEDS {
        let mut dice = Dice::new(seed);
        let member = Member {
            carrier: Carrier::World,
            effort: Effort::Default,
            ..weightless(Member::draw(&mut dice))
        };
        let mut rig = Rig::new(member, &mut dice);
        let pose = Pose::new(member.size * dice.vector(-1.0, 1.0), dice.rotation());
        let size = member.size * dice.vector(0.3, 1.0);
        let body = rig.add(size, pose, member.mass);
        let omega = TAU * member.rate / 60.0;
        let mut joint = Joint::ball();
        for axis in &mut joint.angular {
            let spring = JointSpring::Coefficients {
                stiffness: dice.in_range(0.2, 1.0)
                    * member.mass
                    * member.size
                    * member.size
                    * omega
                    * omega,
                damping: 0.0,
            };
            axis.drive = Some(JointDrive::spring(dice.in_range(-0.5, 0.5), spring));
        }
        rig.join(
            None,
            body,
            joint,
            [Pose::new(pose.position, dice.rotation()); 2],
        );
        let mut highest = [0.0_f64; 2];
        for step in 0..1200 {
            rig.step();
            let part = usize::from(step >= 600);
            let energy = rig.simulation.bodies.kinetic_energy(body);
            highest[part] = highest[part].max(energy);
        }
        let gain = highest[1] / highest[0];
        // Before springs knew how a swing changes with a turn about the twist, some had a thousand times as much.
        assert!(gain < 1.02, "{seed}: {gain} {member:?}");
    }
}
