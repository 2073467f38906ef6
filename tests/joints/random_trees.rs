//! Random trees of bodies on joints of every kind: any size, shape, mass, rate and gravity, held by the world or free, at rest or thrown.
//!
//! Left out is what has no answer, or none that steps of this length see (measured on 1000 members each, 2026-11-29):
//!
//! - loops, whose random members are often stiff or cannot move at all;
//! - what falls by more than a tenth of its size in a step: of trees of 1 to 2 cm at 30 Hz and 30 m/s2 two came open, by as much as a heavy load falls
//!   on when a light link whips;
//! - sliders without ends: at a distance of 1000 sizes rounding of an angle is a gap of 1e-4 sizes;
//! - swings beyond half a turn: limits, springs and a held twist mean something only as long as the first axes do not point against each other,
//!   and jump there. Three of four trees that came open had a ball with one of its swings limited and the other one free.

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use crate::members::between;
use bevy_cleave::prelude::*;
use glam::Vec3;
use std::f32::consts::TAU;

/// What may be in a scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ask {
    /// Whether nothing pulls and nothing holds it.
    pub(crate) is_free: bool,
    pub(crate) has_motors: bool,
    /// Whether some are a kilometer away from the origin.
    pub(crate) is_far: bool,
}

/// A joint between two bodies by their place in the list, or the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    pub(crate) a: Option<usize>,
    pub(crate) b: usize,
    pub(crate) joint: Joint,
}

/// A scene that is drawn and not built yet.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    /// Hz
    pub(crate) rate: f32,
    /// Of bodies, m.
    pub(crate) size: f32,
    pub(crate) gravity: Vec3,
    pub(crate) bodies: Vec<BodyDesc>,
    pub(crate) masses: Vec<MassProperties>,
    pub(crate) links: Vec<Link>,
    ask: Ask,
}

/// A shape and its volume, m3.
fn shape(dice: &mut Dice, size: f32) -> (ConvexMesh, f32) {
    let s = size * dice.vector(0.2, 1.0);
    let shape = match dice.below(4) {
        0 => ConvexMesh::wedge(s.x, s.y, s.z),
        1 => ConvexMesh::regular_prism(6, 0.5 * s.x, s.y),
        2 => ConvexMesh::icosphere(0.5 * s.x, 1),
        _ => ConvexMesh::cuboid(s.x, s.y, s.z),
    };
    let shape = shape.expect("valid size");
    let mass = MassProperties::of_shape(&shape, 1.0).expect("solid");
    (shape, mass.mass)
}

impl Tree {
    pub(crate) fn draw(seed: u64, ask: Ask) -> Self {
        let mut dice = Dice::new(seed);
        let dice = &mut dice;
        let size = between(dice, 0.01, 10.0);
        let rate = [30.0, 60.0, 120.0, 240.0, dice.in_range(30.0, 240.0)][dice.below(5)];
        let strength = [0.0, 9.81, between(dice, 0.3, 30.0)][dice.below(3)];
        let strength = strength.min(0.1 * size * rate * rate);
        let mut tree = Self {
            rate,
            size,
            gravity: f32::from(u8::from(!ask.is_free)) * strength * dice.direction(),
            bodies: Vec::new(),
            masses: Vec::new(),
            links: Vec::new(),
            ask,
        };
        let is_far = ask.is_far && size > 0.3 && dice.below(3) == 0;
        let origin = f32::from(u8::from(is_far)) * 1000.0 * dice.direction();
        tree.grow(dice, origin);
        tree
    }

    fn grow(&mut self, dice: &mut Dice, origin: Vec3) {
        let count = 1 + dice.below(10) + usize::from(self.ask.is_free);
        let mass = between(dice, 1e-3, 1e3);
        let kind = dice.below(3);
        // In a step, rad and sizes.
        let turn = [0.0, 0.03, 0.3][dice.below(3)];
        let is_held = !self.ask.is_free && dice.below(4) > 0;
        for i in 0..count {
            let parent = match kind {
                _ if i == 0 => None,
                0 => Some(i - 1),
                1 => Some(dice.below(i)),
                _ => Some(dice.below(i.min(2))),
            };
            let near = parent.map_or(origin, |parent| self.bodies[parent].pose.position);
            let at = near + self.size * dice.vector(-0.6, 0.6);
            let own_size = between(dice, 0.3, 1.0) * self.size;
            let (shape, volume) = shape(dice, own_size);
            let density = mass * between(dice, 1.0, 1e3) / volume;
            let own_mass = MassProperties::of_shape(&shape, density).expect("solid");
            let place = at + self.size * dice.vector(-0.6, 0.6);
            let mut body = BodyDesc::dynamic(shape, place);
            body.density = density;
            body.pose.rotation = dice.rotation();
            body.layers = CollisionLayers::NONE;
            body.angular_velocity = self.rate * turn * dice.unit() * dice.direction();
            body.linear_velocity = self.rate * turn * self.size * dice.vector(-0.5, 0.5);
            self.bodies.push(body);
            self.masses.push(own_mass);
            if parent.is_some() || is_held {
                self.link(dice, parent, i, at);
            }
        }
    }

    /// Joins two bodies as they are.
    fn link(&mut self, dice: &mut Dice, a: Option<usize>, b: usize, at: Vec3) {
        let poses = [a, Some(b)].map(|i| i.map_or(Pose::IDENTITY, |i| self.bodies[i].pose));
        let joint = match dice.below(10) {
            0 => Joint::fixed(),
            1 => Joint::ball(),
            2 => Joint::hinge(),
            3 => Joint::slider(),
            4 => Joint::cylindrical(),
            5 => Joint::cone_twist(dice.in_range(0.2, 1.5), dice.in_range(0.2, 1.5)),
            6 => six_axis(dice),
            number => return self.tie(dice, number, (a, b), (at, poses)),
        };
        let frame = Pose::new(at, dice.rotation());
        let joint = self.dress(dice, joint).with_frame(frame, poses);
        self.links.push(Link { a, b, joint });
    }

    /// Joins two bodies by a rod, a rope or a spring.
    fn tie(
        &mut self,
        dice: &mut Dice,
        number: usize,
        (a, b): (Option<usize>, usize),
        (at, poses): (Vec3, [Pose; 2]),
    ) {
        let apart = self.size * dice.vector(-0.6, 0.6);
        let length = apart.length();
        let joint = match number {
            7 => Joint::rod(length),
            8 => Joint::rope(length * dice.in_range(1.0, 1.5)),
            _ => Joint::spring(length * dice.in_range(0.5, 1.5), self.spring(dice, 1.0)),
        };
        let anchors = [
            poses[0].inverse_transform_point(at + apart),
            poses[1].inverse_transform_point(at),
        ];
        let joint = joint.with_anchors(anchors[0], anchors[1]);
        self.links.push(Link { a, b, joint });
    }

    /// Gives limits, friction, motors and springs to some axes that are not locked.
    fn dress(&self, dice: &mut Dice, mut joint: Joint) -> Joint {
        let is_open = |axis: &JointAxis| axis.range != AxisRange::Locked;
        let swings_about_both = joint.angular[1..].iter().all(is_open);
        let has_twist = is_open(&joint.angular[0]);
        // A held twist has no meaning after half a turn of both swings.
        let ends_swings = swings_about_both && !has_twist || dice.below(2) == 0;
        for i in 0..6 {
            let (axis, scale) = match i {
                0..3 => (&mut joint.linear[i], self.size),
                _ => (&mut joint.angular[i - 3], 1.0),
            };
            if axis.range == AxisRange::Locked {
                continue;
            }
            let is_swing = i > 3;
            let ends = i < 3 || is_swing && ends_swings || i == 3 && dice.below(2) == 0;
            if ends && axis.range == AxisRange::Free {
                let [min, max] = [0; 2].map(|_| scale * dice.in_range(0.05, 1.5));
                axis.range = AxisRange::Limited { min: -min, max };
                axis.restitution = [0.0, 0.0, dice.unit()][dice.below(3)];
            }
            let is_angular = i >= 3;
            self.drive(dice, axis, is_angular, !is_swing || ends_swings);
        }
        joint
    }

    fn drive(&self, dice: &mut Dice, axis: &mut JointAxis, is_angular: bool, may_pull: bool) {
        let lever = if is_angular { self.size } else { 1.0 };
        let scale = if is_angular { 1.0 } else { self.size };
        let force = self.last_mass() * lever * (self.gravity.length() + self.size);
        if dice.below(4) == 0 {
            axis.friction = force * between(dice, 0.01, 10.0);
        }
        if self.ask.has_motors && dice.below(4) == 0 {
            let speed = scale * dice.in_range(-0.1, 0.1) * self.rate;
            axis.drive = Some(JointDrive::velocity(
                speed,
                force * between(dice, 0.1, 100.0),
            ));
        } else if may_pull && dice.below(4) == 0 {
            let lever = if is_angular {
                0.1 * self.size * self.size
            } else {
                1.0
            };
            let spring = self.spring(dice, lever);
            axis.drive = Some(JointDrive::spring(scale * dice.in_range(-0.5, 0.5), spring));
        }
    }

    fn last_mass(&self) -> f32 {
        self.masses.last().map_or(1.0, |mass| mass.mass)
    }

    /// By force: a frequency is that of two bodies as they are to each other now, and no law of energy holds while that changes.
    fn spring(&self, dice: &mut Dice, lever: f32) -> JointSpring {
        let mass = self.last_mass() * lever;
        let omega = TAU * between(dice, 0.1, 30.0);
        let ratio = [0.0, dice.unit(), between(dice, 0.1, 10.0)][dice.below(3)];
        JointSpring::Coefficients {
            stiffness: mass * omega * omega,
            damping: 2.0 * ratio * omega * mass,
        }
    }

    /// Length of a step, s.
    pub(crate) fn h(&self) -> f32 {
        self.rate.recip()
    }

    pub(crate) fn mass(&self) -> f64 {
        self.masses.iter().map(|mass| f64::from(mass.mass)).sum()
    }

    pub(crate) fn build(&self) -> Built<'_> {
        let mut simulation = awake();
        simulation.gravity.0 = self.gravity;
        let bodies = self.bodies.iter().cloned();
        let slots: Vec<u32> = bodies
            .map(|body| simulation.bodies.insert(body).expect("usable"))
            .collect();
        let links = self.links.iter();
        let ids = links.map(|link| {
            let a = link.a.map(|a| slots[a]);
            let id = simulation.join(a, slots[link.b], link.joint);
            id.expect("usable")
        });
        let ids = ids.collect();
        Built {
            tree: self,
            simulation,
            slots,
            ids,
        }
    }
}

/// Some of its axes locked, the others free: one turn at most, or all.
fn six_axis(dice: &mut Dice) -> Joint {
    let mut draw = || [JointAxis::LOCKED, JointAxis::FREE][usize::from(dice.below(5) > 2)];
    Joint::six_axis([(); 3].map(|()| draw()), [(); 3].map(|()| draw()))
}

/// A scene that was built.
pub(crate) struct Built<'a> {
    pub(crate) tree: &'a Tree,
    pub(crate) simulation: Simulation,
    pub(crate) slots: Vec<u32>,
    pub(crate) ids: Vec<JointId>,
}

impl Built<'_> {
    pub(crate) fn step(&mut self) {
        self.simulation.step(self.tree.h());
    }
}
