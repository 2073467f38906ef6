//! What joints in loops bear together is what statics says, whichever way impulses could balance each other.

use crate::common::dice::Dice;
use crate::members::{Carrier, Member, Rig, across};
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// A body at rest that several joints hold to one carrier.
struct Hung {
    rig: Rig,
    /// Each joint and where it is, m.
    joints: Vec<(JointId, Vec3)>,
    center: Vec3,
}

impl Hung {
    /// With two to four joints of a kind along a line; the center of mass is where the weight has no lever about the line.
    fn along_a_line(member: Member, joint: Joint, dice: &mut Dice) -> Self {
        let mut rig = Rig::new(member, dice);
        let line = dice.direction();
        let first = member.size * dice.vector(-3.0, 3.0);
        let beside = member.gravity - member.gravity.dot(line) * line;
        let length = member.size * dice.in_range(0.3, 1.0);
        let out = dice.in_range(0.1, 1.0) * length * beside.normalize_or_zero();
        let center = first + dice.in_range(0.0, 1.0) * length * line + out;
        let size = member.size * dice.vector(0.2, 1.0);
        let body = rig.add(size, Pose::new(center, dice.rotation()), member.mass);
        let count = 2 + dice.below(3);
        let turn = Quat::from_rotation_arc(Vec3::X, line).normalize();
        let turn = turn * Quat::from_rotation_x(dice.in_range(-3.0, 3.0));
        let joints = (0..count).map(|k| {
            let at = first + length * k as f32 / (count - 1) as f32 * line;
            let frame = Pose::new(at, turn);
            (rig.join(None, body, joint, [frame; 2]), at)
        });
        Self {
            joints: joints.collect(),
            rig,
            center,
        }
    }

    /// By two to four fixed joints anywhere.
    fn fixed(member: Member, dice: &mut Dice) -> Self {
        let mut rig = Rig::new(member, dice);
        let center = member.size * dice.vector(-3.0, 3.0);
        let size = member.size * dice.vector(0.2, 1.0);
        let body = rig.add(size, Pose::new(center, dice.rotation()), member.mass);
        let joints = (0..2 + dice.below(3)).map(|_| {
            let along = dice.direction();
            let at = center + member.size * dice.in_range(0.1, 1.0) * across(dice, along);
            let frame = Pose::new(at, dice.rotation());
            (rig.join(None, body, Joint::fixed(), [frame; 2]), at)
        });
        Self {
            joints: joints.collect(),
            rig,
            center,
        }
    }

    /// What all joints give less than what holds the body, as shares of its weight and of the weight's torque at the levers' length, and the
    /// largest force and torque of one, as shares of the same.
    fn errors(&self) -> [f32; 3] {
        let member = &self.rig.member;
        let weight = member.weight();
        let reach = self.joints.iter().map(|(_, at)| at.distance(self.center));
        let reach = reach.fold(0.1 * member.size, f32::max);
        let (mut force, mut torque, mut most) = (weight, Vec3::ZERO, 0.0_f32);
        for &(id, at) in &self.joints {
            let load = self.rig.load(id);
            force += load.force;
            torque += load.torque + (at - self.center).cross(load.force);
            let share = load.force.length().max(load.torque.length() / reach);
            most = most.max(share / weight.length());
        }
        let scale = weight.length();
        [
            force.length() / scale,
            torque.length() / (scale * reach),
            most,
        ]
    }
}

/// What is borne is measured by what bodies have got, whose velocities and places are single precision: small ones that move are off by a few
/// hundredths. Beside contacts it is measured by the rows themselves, which balance each other with a million times as much.
fn tolerance(member: &Member) -> f32 {
    match member.carrier {
        Carrier::Standing => 0.2,
        _ => 0.1,
    }
}

#[test]
fn several_joints_bear_the_weight_together_and_none_bears_more_than_its_levers_ask() {
    for seed in 0..120 {
        let mut dice = Dice::new(seed);
        let member = Member::draw(&mut dice);
        let mut hung = match seed % 3 {
            0 => Hung::along_a_line(member, Joint::hinge(), &mut dice),
            1 => Hung::along_a_line(member, Joint::ball(), &mut dice),
            _ => Hung::fixed(member, &mut dice),
        };
        for step in 1..=30 {
            hung.rig.step();
            let [force, torque, most] = hung.errors();
            let told = format!("{seed}, step {step}: {force} {torque} {most} {member:?}");
            let bound = tolerance(&member);
            assert!(force < bound && torque < bound, "{told}");
            // Balls a third of the body apart hold a lever of all of it.
            assert!(most < 6.0, "{told}");
        }
    }
}

#[test]
fn a_door_on_two_hinges_keeps_its_strength() {
    for seed in 0..24 {
        for strength in [6.0, 0.3] {
            let mut dice = Dice::new(seed);
            let member = Member::draw(&mut dice);
            let mut hung = Hung::along_a_line(member, Joint::hinge(), &mut dice);
            let weight = member.weight().length();
            for (id, _) in hung.joints.clone() {
                hung.rig.change(id, |joint| {
                    *joint = joint.with_strength(strength * weight, f32::INFINITY);
                });
            }
            let mut broken = 0;
            for _ in 0..60 {
                hung.rig.step();
                broken += hung.rig.simulation.joints.broken.len();
            }
            let told = format!("{seed}: {broken} of {} {member:?}", hung.joints.len());
            if strength > 1.0 {
                assert_eq!(broken, 0, "{told}");
            } else if hung.joints.len() < 4 {
                // Two or three of 0.3 each bear less than all of it.
                assert_eq!(broken, hung.joints.len(), "{told}");
            }
        }
    }
}
