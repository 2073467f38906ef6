//! What joints say that they bear is what statics says, from the first step on, and they break where that says.

use crate::common::dice::Dice;
use crate::members::{Carrier, Effort, Member, Rig, across, between};
use crate::scene::{gap, heavy};
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// Ways in which a body rests on one joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Rest {
    Fixed,
    Ball,
    /// Below its axis.
    Hinge,
    /// Along what is level.
    Slider,
    Cylindrical,
    Cone,
    Rod,
    Rope,
    Spring,
    /// At the end of its range.
    HingeAtLimit,
    SliderAtLimit,
    /// By a motor that stands still.
    HingeOfMotor,
    SliderOfMotor,
    /// By friction, a tenth more than is asked.
    HingeOfFriction,
    SliderOfFriction,
}

pub(crate) const RESTS: [Rest; 15] = [
    Rest::Fixed,
    Rest::Ball,
    Rest::Hinge,
    Rest::Slider,
    Rest::Cylindrical,
    Rest::Cone,
    Rest::Rod,
    Rest::Rope,
    Rest::Spring,
    Rest::HingeAtLimit,
    Rest::SliderAtLimit,
    Rest::HingeOfMotor,
    Rest::SliderOfMotor,
    Rest::HingeOfFriction,
    Rest::SliderOfFriction,
];

/// A body at rest on one joint.
pub(crate) struct Resting {
    pub(crate) rig: Rig,
    pub(crate) body: u32,
    pub(crate) id: JointId,
    /// From the anchor on the body to its center of mass, m.
    pub(crate) arm: Vec3,
}

/// A rotation whose first axis is along a direction, random about it.
pub(crate) fn along(dice: &mut Dice, axis: Vec3) -> Quat {
    let about = Quat::from_axis_angle(axis, dice.in_range(-3.0, 3.0));
    (about * Quat::from_rotation_arc(Vec3::X, axis)).normalize()
}

/// A sign.
fn sign(dice: &mut Dice) -> f32 {
    [-1.0, 1.0][dice.below(2)]
}

/// Axis and arm of a rest, and how far the anchors are apart.
fn place(rest: Rest, member: &Member, dice: &mut Dice) -> (Vec3, Vec3, Vec3) {
    let (up, size) = (member.up(), member.size);
    let length = size * dice.in_range(0.2, 1.0);
    let side = size * dice.in_range(-1.0, 1.0);
    match rest {
        Rest::Fixed => (dice.direction(), size * dice.vector(-1.0, 1.0), Vec3::ZERO),
        Rest::Slider => (across(dice, up), size * dice.vector(-1.0, 1.0), Vec3::ZERO),
        Rest::Ball | Rest::Cone => (dice.direction(), -length * up, Vec3::ZERO),
        Rest::Hinge => {
            let level = across(dice, up);
            let axis = (level + dice.in_range(-1.0, 1.0) * up).normalize();
            let down = -(up - up.dot(axis) * axis).normalize();
            (axis, length * down + side * axis, Vec3::ZERO)
        }
        Rest::Cylindrical => {
            let axis = across(dice, up);
            (axis, -length * up + side * axis, Vec3::ZERO)
        }
        Rest::Rod | Rest::Rope | Rest::Spring => {
            let apart = size * dice.in_range(0.2, 1.0);
            (dice.direction(), -length * up, -apart * up)
        }
        Rest::HingeAtLimit | Rest::HingeOfMotor | Rest::HingeOfFriction => {
            let axis = across(dice, up);
            let arm = axis.cross(up) * sign(dice) * length + side * axis + 0.5 * side * up;
            (axis, arm, Vec3::ZERO)
        }
        Rest::SliderAtLimit | Rest::SliderOfMotor | Rest::SliderOfFriction => {
            let axis = (across(dice, up) + dice.in_range(0.3, 2.0) * sign(dice) * up).normalize();
            (axis, size * dice.vector(-1.0, 1.0), Vec3::ZERO)
        }
    }
}

/// The joint of a rest; `down`: along or about its first axis, N or N m.
fn joint_of(rest: Rest, down: f32, apart: f32, weight: f32, dice: &mut Dice) -> Joint {
    let wide = dice.in_range(0.1, 1.0);
    let ends = if down < 0.0 {
        [0.0, wide]
    } else {
        [-wide, 0.0]
    };
    let still = JointDrive::velocity(0.0, 3.0 * down.abs());
    match rest {
        Rest::Fixed => Joint::fixed(),
        Rest::Ball => Joint::ball(),
        Rest::Hinge => Joint::hinge(),
        Rest::Slider => Joint::slider(),
        Rest::Cylindrical => Joint::cylindrical(),
        Rest::Cone => Joint::cone_twist(0.7, 0.3),
        Rest::Rod => Joint::rod(apart),
        Rest::Rope => Joint::rope(apart),
        Rest::Spring => {
            let share = dice.in_range(0.05, 0.5);
            let stiffness = weight / (share * apart);
            let spring = JointSpring::Coefficients {
                stiffness,
                damping: 0.0,
            };
            Joint::spring((1.0 - share) * apart, spring)
        }
        Rest::HingeAtLimit => Joint::hinge().with_angular_limits(ends[0], ends[1]),
        Rest::SliderAtLimit => Joint::slider().with_linear_limits(ends[0], ends[1]),
        Rest::HingeOfMotor => Joint::hinge().with_angular_drive(still),
        Rest::SliderOfMotor => Joint::slider().with_linear_drive(still),
        Rest::HingeOfFriction => {
            let mut joint = Joint::hinge();
            joint.angular[0].friction = 1.1 * down.abs();
            joint
        }
        Rest::SliderOfFriction => {
            let mut joint = Joint::slider();
            joint.linear[0].friction = 1.1 * down.abs();
            joint
        }
    }
}

impl Resting {
    pub(crate) fn new(rest: Rest, member: Member, dice: &mut Dice) -> Self {
        let mut rig = Rig::new(member, dice);
        let (axis, arm, apart) = place(rest, &member, dice);
        let at = member.size * dice.vector(-3.0, 3.0);
        let size = member.size * dice.vector(0.3, 1.0);
        let pose = Pose::new(at + apart + arm, dice.rotation());
        let body = rig.add(size, pose, member.mass);
        let turn = along(dice, axis);
        let frames = [at, at + apart].map(|at| Pose::new(at, turn));
        let is_slider = matches!(
            rest,
            Rest::SliderAtLimit | Rest::SliderOfMotor | Rest::SliderOfFriction
        );
        let down = if is_slider {
            member.weight().dot(axis)
        } else {
            arm.cross(member.weight()).dot(axis)
        };
        // A force along the axis goes to the end of the range that it points to.
        let joint = joint_of(rest, down, apart.length(), member.weight().length(), dice);
        let id = rig.join(None, body, joint, frames);
        Self { rig, body, id, arm }
    }

    /// What statics says: force on the body, and torque about its anchor.
    pub(crate) fn expected(&self) -> [Vec3; 2] {
        let weight = self.rig.member.weight();
        [-weight, -self.arm.cross(weight)]
    }

    /// How far what the joint says is from that, over the weight and its moment at the arm of a body.
    pub(crate) fn error(&self) -> [f32; 2] {
        let load = self.rig.load(self.id);
        let [force, torque] = self.expected();
        let weight = force.length();
        let moment = weight * self.rig.member.size;
        [
            (load.force - force).length() / weight,
            (load.torque - torque).length() / moment,
        ]
    }
}

/// Members of each test and kind of rest.
const SEEDS: u64 = 8;

/// Largest part of a load that is not told: contacts of what stands give way when they are first loaded.
fn tolerance(member: &Member, step: usize) -> f32 {
    match member.carrier {
        Carrier::Standing if step <= 5 => 0.1,
        _ => 0.01,
    }
}

fn rests() -> impl Iterator<Item = (Rest, u64)> {
    let seeds = |rest| (0..SEEDS).map(move |seed| (rest, 1000 * rest as u64 + seed));
    RESTS.into_iter().flat_map(seeds)
}

#[test]
fn a_joint_tells_from_the_first_step_on_what_statics_says() {
    for (rest, seed) in rests() {
        let mut dice = Dice::new(seed);
        let member = Member::draw(&mut dice);
        let mut resting = Resting::new(rest, member, &mut dice);
        for step in 1..=60 {
            resting.rig.step();
            let error = resting.error();
            let is_right = error.into_iter().all(|off| off < tolerance(&member, step));
            assert!(
                is_right,
                "{rest:?} {seed}, step {step}: {error:?} {member:?}"
            );
        }
    }
}

/// A part of a cantilever: its joint, where that is, the part's center and mass.
type Part = (JointId, Vec3, Vec3, f32);

/// Boxes one after the other out from the carrier, by fixed joints.
fn cantilever(rig: &mut Rig, dice: &mut Dice) -> Vec<Part> {
    let member = rig.member;
    let out = dice.direction();
    let mut at = member.size * dice.vector(-3.0, 3.0);
    let (mut last, mut parts) = (None, Vec::new());
    for _ in 0..2 + dice.below(5) {
        let length = member.size * dice.in_range(0.3, 1.0);
        let mass = member.mass * between(dice, 0.1, 1.0);
        let center = at + 0.5 * length * out + 0.2 * length * dice.vector(-1.0, 1.0);
        let size = length * dice.vector(0.2, 1.0);
        let body = rig.add(size, Pose::new(center, dice.rotation()), mass);
        let frame = Pose::new(at, dice.rotation());
        let id = rig.join(last, body, Joint::fixed(), [frame; 2]);
        parts.push((id, at, center, mass));
        last = Some(body);
        at += length * out;
    }
    parts
}

#[test]
fn each_joint_of_a_cantilever_bears_what_is_farther_out() {
    for seed in 0..40 {
        let mut dice = Dice::new(seed);
        let member = Member::draw(&mut dice);
        let mut rig = Rig::new(member, &mut dice);
        let parts = cantilever(&mut rig, &mut dice);
        for step in 1..=30 {
            rig.step();
            for (k, &(id, at, ..)) in parts.iter().enumerate() {
                let (mut force, mut torque, mut scale) = (Vec3::ZERO, Vec3::ZERO, 0.0);
                for &(_, _, center, mass) in &parts[k..] {
                    let weight = mass * member.gravity;
                    force -= weight;
                    torque -= (center - at).cross(weight);
                    scale += weight.length() * (center - at).length();
                }
                let load = rig.simulation.joints.load(id).expect("there");
                // Only the first one may hold on to the world.
                let is_swapped = member.is_swapped && (k > 0 || rig.carrier.is_some());
                let sign = if is_swapped { -1.0 } else { 1.0 };
                let off = (sign * load.force - force).length() / force.length();
                let off = off.max((sign * load.torque - torque).length() / scale);
                let most = tolerance(&member, step);
                assert!(
                    off < most,
                    "{seed}, joint {k}, step {step}: {off} {member:?}"
                );
            }
        }
    }
}

#[test]
fn a_turntable_holds_its_bodies_inward() {
    for seed in 0..40 {
        let mut dice = Dice::new(seed);
        let member = Member {
            carrier: Carrier::Moving(Vec3::ZERO),
            ..Member::draw(&mut dice)
        };
        let mut rig = Rig::new(member, &mut dice);
        let carrier = rig.carrier.expect("one that moves");
        let center = rig.simulation.bodies.pose(carrier).position;
        let spin = dice.in_range(0.01, 0.1) * member.rate * dice.direction();
        let at = center + member.size * dice.vector(-3.0, 3.0);
        let arm = member.size * dice.vector(-1.0, 1.0);
        let size = member.size * dice.vector(0.3, 1.0);
        let body = rig.add(size, Pose::new(at + arm, dice.rotation()), member.mass);
        let frame = Pose::new(at, dice.rotation());
        let id = rig.join(None, body, Joint::fixed(), [frame; 2]);
        let bodies = &mut rig.simulation.bodies;
        let v = spin.cross(at + arm - center);
        for (slot, v) in [(carrier, Vec3::ZERO), (body, v)] {
            bodies.set_velocity(slot, v, spin).expect("finite");
        }
        for step in 1..=60 {
            let before = rig.simulation.bodies.center_of_mass(body) - center;
            rig.step();
            let after = rig.simulation.bodies.center_of_mass(body) - center;
            // The mean of the step is that of its middle, but for a share of the square of the turn.
            let inward = spin.cross(spin.cross(0.5 * (before + after)));
            let force = member.mass * (inward - member.gravity);
            let off = (rig.load(id).force - force).length() / force.length();
            assert!(off < 0.01, "{seed}, step {step}: {off} {spin} {member:?}");
        }
    }
}

/// Steps a body on a joint that may break: in which steps that was told.
fn told(resting: &mut Resting, steps: usize, before: impl Fn(&mut Resting, usize)) -> Vec<usize> {
    let mut told = Vec::new();
    for step in 1..=steps {
        before(resting, step);
        resting.rig.step();
        let broken = resting.rig.simulation.joints.broken.len();
        told.extend(std::iter::repeat_n(step, broken));
    }
    told
}

#[test]
fn a_joint_holds_a_tenth_less_than_its_strength_and_breaks_at_once_by_a_tenth_more() {
    for (rest, seed) in rests() {
        for (which, k) in [(0, 1.1), (0, 0.9), (1, 1.1), (1, 0.9)] {
            let mut dice = Dice::new(seed);
            let member = Member::draw(&mut dice);
            let mut resting = Resting::new(rest, member, &mut dice);
            let expected = resting.expected();
            let borne = expected[which].length();
            if which == 1 && borne < 0.05 * expected[0].length() * member.size {
                continue;
            }
            let mut strength = [f32::INFINITY; 2];
            strength[which] = k * borne;
            let id = resting.id;
            resting.rig.change(id, |joint| {
                *joint = joint.with_strength(strength[0], strength[1]);
            });
            let told = told(&mut resting, 60, |_, _| ());
            let expected: &[usize] = if k > 1.0 { &[] } else { &[1] };
            assert_eq!(told, expected, "{rest:?} {seed} {which} {member:?}");
        }
    }
}

/// Has a body pushed by a force from step 11 on: one that lasts, or one of each step.
fn push(resting: &mut Resting, step: usize, (force, lasts): (Vec3, bool)) {
    let bodies = &mut resting.rig.simulation.bodies;
    if step == 11 && lasts {
        let drive = BodyDrive {
            force,
            ..BodyDrive::default()
        };
        bodies.set_drive(resting.body, drive).expect("usable");
    } else if step >= 11 && !lasts {
        let forces = StepForces {
            force,
            ..StepForces::default()
        };
        bodies.apply(resting.body, &forces).expect("usable");
    }
}

/// Motors and friction bear forces as they bear weight, and strengths are asked in the step in which a force begins.
#[test]
fn what_a_force_adds_is_borne_and_breaks_as_weight_does() {
    // A spring gives way.
    for (rest, seed) in rests().filter(|&(rest, _)| rest != Rest::Spring) {
        for (lasts, k) in [(false, 1.1), (false, 0.9), (true, 1.1), (true, 0.9)] {
            let mut dice = Dice::new(seed);
            let member = Member::draw(&mut dice);
            let mut resting = Resting::new(rest, member, &mut dice);
            let more = dice.in_range(1.0, 4.0);
            let id = resting.id;
            let weight = member.weight().length();
            resting.rig.change(id, |joint| {
                *joint = joint.with_strength(k * (1.0 + more) * weight, f32::INFINITY);
                for axis in joint.linear.iter_mut().chain(&mut joint.angular) {
                    axis.friction *= 1.0 + more;
                    if let Some(drive) = &mut axis.drive {
                        drive.max_force *= 1.0 + more;
                    }
                }
            });
            let force = more * member.weight();
            let told = told(&mut resting, 40, |resting, step| {
                push(resting, step, (force, lasts));
            });
            let expected: &[usize] = if k > 1.0 { &[] } else { &[11] };
            assert_eq!(told, expected, "{rest:?} {seed} {lasts} {member:?}");
            let speed = resting.rig.velocity(resting.body).0.length();
            let natural = (member.size * member.gravity.length()).sqrt();
            let is_still = k < 1.0 || speed < 1e-3 * natural;
            assert!(is_still, "{rest:?} {seed} {lasts}: {speed} {member:?}");
        }
    }
}

/// By default: with few sub-steps contacts that are first loaded bear up to half more than the weight.
#[test]
fn what_lies_on_a_plank_is_borne_by_its_joint() {
    for seed in 0..30 {
        for k in [1.1, 0.9] {
            let mut dice = Dice::new(seed);
            let drawn = Member::draw(&mut dice);
            let member = Member {
                carrier: Carrier::World,
                effort: Effort::Default,
                ..drawn
            };
            let mut rig = Rig::new(member, &mut dice);
            let (size, up) = (member.size, member.up());
            let turn = Quat::from_rotation_arc(Vec3::Y, up).normalize();
            let at = size * dice.vector(-3.0, 3.0);
            let mut plank = heavy(size * Vec3::new(2.0, 0.2, 2.0), at, member.mass);
            plank.pose.rotation = turn;
            let ratio = between(&mut dice, 0.1, 30.0);
            let edge = size * dice.in_range(0.2, 0.8);
            let aside = 0.4 * size * dice.vector(-1.0, 1.0) * Vec3::new(1.0, 0.0, 1.0);
            let center = at + turn * aside + (0.1 * size + 0.5 * edge) * up;
            let mut load = heavy(Vec3::splat(edge), center, ratio * member.mass);
            load.pose.rotation = turn;
            let bodies = &mut rig.simulation.bodies;
            let [plank, _] = [plank, load].map(|body| bodies.insert(body).expect("usable"));
            let end = at - turn * (size * Vec3::X);
            let frame = Pose::new(end, dice.rotation());
            let id = rig.join(None, plank, Joint::fixed(), [frame; 2]);
            let weight = member.weight();
            let force = (1.0 + ratio) * weight.length();
            let torque = (at - end).cross(weight) + (center - end).cross(ratio * weight);
            let is_by_force = dice.below(2) == 0;
            rig.change(id, |joint| {
                *joint = if is_by_force {
                    joint.with_strength(k * force, f32::INFINITY)
                } else {
                    joint.with_strength(f32::INFINITY, k * torque.length())
                };
            });
            (0..60).for_each(|_| rig.step());
            let holds = rig.simulation.joints.contains(id);
            assert_eq!(holds, k > 1.0, "{seed}, ratio {ratio} {member:?}");
        }
    }
}

/// What does not turn, or moves in a plane only, is held by that too.
#[test]
fn what_is_locked_hangs_on_joints_as_it_is() {
    for seed in 0..30 {
        let mut dice = Dice::new(seed);
        let locked = [LockedAxes::ROTATION, LockedAxes::PLANE_XY][dice.below(2)];
        let mut member = Member {
            carrier: Carrier::World,
            ..Member::draw(&mut dice)
        };
        let free = if locked == LockedAxes::PLANE_XY {
            Vec3::new(1.0, 1.0, 0.0)
        } else {
            Vec3::ONE
        };
        member.gravity *= free;
        let mut rig = Rig::new(member, &mut dice);
        let at = member.size * dice.vector(-1.0, 1.0);
        let arm = member.size * free * dice.vector(-1.0, 1.0);
        let pose = Pose::new(at + arm, dice.rotation());
        let body = rig.add(member.size * dice.vector(0.3, 1.0), pose, member.mass);
        let drive = BodyDrive {
            locked,
            ..BodyDrive::default()
        };
        rig.simulation
            .bodies
            .set_drive(body, drive)
            .expect("usable");
        let frame = Pose::new(at, dice.rotation());
        let id = rig.join(None, body, Joint::ball(), [frame; 2]);
        for step in 1..=60 {
            rig.step();
            let apart = gap(&rig.simulation, id) as f32;
            assert!(
                apart < 1e-5 * member.size.max(1.0),
                "{seed}: {apart} {member:?}"
            );
            let force = rig.load(id).force + member.weight();
            let is_held =
                locked != LockedAxes::ROTATION || force.length() < 0.01 * member.weight().length();
            assert!(is_held, "{seed}, step {step}: {force} {member:?}");
        }
        let turned = rig.simulation.bodies.pose(body).rotation * pose.rotation.inverse();
        let aside = if locked == LockedAxes::PLANE_XY {
            turned.xyz().truncate().length()
        } else {
            turned.xyz().length()
        };
        assert!(aside < 1e-5, "{seed}: {turned} {member:?}");
    }
}
