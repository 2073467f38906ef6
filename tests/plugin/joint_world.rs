//! Random apps of bodies and joints, and a random story of what users do to both between frames.
//!
//! As in `random_world.rs`, every deed has a seed of its own.

use crate::app::app;
use crate::common::dice::Dice;
use crate::random_world::Deed;
use bevy_app::{App, FixedPostUpdate};
use bevy_cleave::prelude::*;
use bevy_ecs::entity::EntityCloner;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::query::Allow;
use bevy_time::TimeUpdateStrategy;
use bevy_transform::components::Transform;
use glam::Vec3;

/// Names of bodies.
pub(crate) const BODIES: usize = 6;

/// Names of joints.
const JOINTS: usize = 6;

/// What was told of joints since the last look.
#[derive(Resource, Default)]
pub(crate) struct Heard {
    pub(crate) messages: Vec<JointBroken>,
    pub(crate) events: Vec<JointBroken>,
}

fn listen(mut broken: MessageReader<JointBroken>, mut heard: ResMut<Heard>) {
    heard.messages.extend(broken.read());
}

/// What is done in a story.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Manner {
    /// Anything.
    Rough,
    /// Nothing that lets go of what is joined for good.
    Faithful,
}

/// An app, and who is in it.
pub(crate) struct JointWorld {
    pub(crate) app: App,
    manner: Manner,
    bodies: Vec<Option<Entity>>,
    joints: Vec<Option<Entity>>,
    /// What was done, in words.
    pub(crate) said: Vec<String>,
}

fn cube() -> ConvexMesh {
    ConvexMesh::cuboid(0.6, 0.6, 0.6).expect("a cube")
}

fn kind_of_joint(dice: &mut Dice) -> Joint {
    match dice.below(7) {
        0 => Joint::hinge(),
        1 => Joint::slider(),
        2 => Joint::fixed(),
        3 => Joint::cylindrical(),
        4 => Joint::rope(1.5),
        5 => Joint::cone_twist(0.5, 0.5),
        _ => Joint::ball(),
    }
}

/// A joint that is not usable, mostly.
fn spoilt(dice: &mut Dice, joint: Joint) -> Joint {
    match dice.below(5) {
        0 => joint.with_anchors(Vec3::NAN, Vec3::ZERO),
        1 => joint.with_axes(Vec3::ZERO, Vec3::X),
        2 => joint.with_angular_limits(1.0, -1.0),
        3 => joint.with_strength(f32::NAN, 1.0),
        _ => joint.with_angular_drive(JointDrive::velocity(f32::INFINITY, 1.0)),
    }
}

impl JointWorld {
    pub(crate) fn new(manner: Manner) -> Self {
        let mut app = app();
        app.init_resource::<Heard>();
        app.add_systems(FixedPostUpdate, listen);
        app.add_observer(|broken: On<JointBroken>, mut heard: ResMut<Heard>| {
            heard.events.push(*broken);
        });
        Self {
            app,
            manner,
            bodies: vec![None; BODIES],
            joints: vec![None; JOINTS],
            said: Vec::new(),
        }
    }

    fn lives(&self, entity: Option<Entity>) -> Option<Entity> {
        entity.filter(|&it| self.app.world().get_entity(it).is_ok())
    }

    /// The body that a name stands for.
    pub(crate) fn body(&self, name: usize) -> Option<Entity> {
        self.lives(self.bodies[name])
    }

    /// All joints that are there, disabled or not, in order.
    pub(crate) fn all_joints(&mut self) -> Vec<Entity> {
        let world = self.app.world_mut();
        let mut joints = world.query_filtered::<Entity, (With<JointHandle>, Allow<Disabled>)>();
        let mut joints: Vec<Entity> = joints.iter(world).collect();
        joints.sort_unstable();
        joints
    }

    /// All that may be bodies, in order.
    pub(crate) fn all_bodies(&mut self) -> Vec<Entity> {
        let world = self.app.world_mut();
        let mut bodies = world.query_filtered::<Entity, (With<Transform>, Allow<Disabled>)>();
        let mut bodies: Vec<Entity> = bodies.iter(world).collect();
        bodies.sort_unstable();
        bodies
    }

    pub(crate) fn run(&mut self, deed: Deed) {
        match deed {
            Deed::Frame(steps) => {
                self.said.push(format!("-- {steps} steps"));
                let steps = TimeUpdateStrategy::FixedTimesteps(steps);
                self.app.insert_resource(steps);
                self.app.update();
                self.name_pieces();
            }
            Deed::Act(seed) => self.act(&mut Dice::new(seed)),
        }
    }

    /// Names that stand for nobody get pieces.
    fn name_pieces(&mut self) {
        let world = self.app.world_mut();
        let mut pieces = world.query_filtered::<Entity, (With<PieceOf>, Allow<Disabled>)>();
        let mut pieces: Vec<Entity> = pieces.iter(world).collect();
        pieces.sort_unstable();
        pieces.retain(|piece| !self.bodies.contains(&Some(*piece)));
        for name in 0..BODIES {
            if self.body(name).is_none()
                && let Some(piece) = pieces.pop()
            {
                self.bodies[name] = Some(piece);
            }
        }
    }

    /// A chain of bodies that touch nothing, which hangs on the world; its joints.
    pub(crate) fn lay_chain(&mut self, dice: &mut Dice) -> Vec<Entity> {
        let mut last = None;
        for name in 0..4 {
            let at = Transform::from_xyz(0.0, -0.8 * name as f32, 0.0);
            let world = self.app.world_mut();
            let parts = (at, RigidBody::Dynamic, cube(), CollisionLayers::NONE);
            let body = world.spawn(parts).id();
            let joint = self.fitting(last, body, dice);
            let world = self.app.world_mut();
            let made = world.commands().join(last, body, joint);
            world.flush();
            (self.bodies[name], self.joints[name]) = (Some(body), Some(made));
            last = Some(body);
        }
        self.joints.iter().flatten().copied().collect()
    }

    /// Everybody is there, dynamic and at rest.
    pub(crate) fn release(&mut self) {
        for joint in self.all_joints() {
            self.app.world_mut().entity_mut(joint).remove::<Disabled>();
        }
        for body in self.all_bodies() {
            let mut it = self.app.world_mut().entity_mut(body);
            it.remove::<Disabled>();
            if it.contains::<ConvexMesh>() {
                let rest = (LinearVelocity::default(), AngularVelocity::default());
                it.insert((RigidBody::Dynamic, CollisionLayers::NONE, rest));
            }
        }
    }

    fn act(&mut self, dice: &mut Dice) {
        let name = dice.below(BODIES);
        let is_of_joint = dice.below(2) == 0;
        match self.body(name) {
            None => self.spawn(name, dice),
            Some(_) if is_of_joint => self.act_on_joint(name, dice),
            Some(body) => self.act_on_body(name, body, dice),
        }
        self.app.world_mut().flush();
    }

    fn spawn(&mut self, name: usize, dice: &mut Dice) {
        let at = Vec3::new(0.8 * name as f32, 0.0, 0.0) + dice.vector(-0.1, 0.1);
        let at = Transform::from_translation(at);
        let kinds = [RigidBody::Static, RigidBody::Kinematic, RigidBody::Dynamic];
        let kind = kinds[dice.below(6).min(2)];
        let way = dice.below(6);
        let world = self.app.world_mut();
        let body = match way {
            // Is to become a body.
            0 => world.spawn(at),
            1 => world.spawn((at, kind, ShapeAwaited)),
            _ => world.spawn((at, kind, cube())),
        };
        let body = body.id();
        self.said
            .push(format!("spawn {name}: {body} {kind:?} {way}"));
        self.bodies[name] = Some(body);
    }

    fn act_on_body(&mut self, name: usize, body: Entity, dice: &mut Dice) {
        let other = dice.below(BODIES);
        let is_rough = self.manner == Manner::Rough;
        let deed = dice.below(12);
        self.said.push(format!("body {name} {body}: {deed}"));
        let mut it = self.app.world_mut().entity_mut(body);
        match deed {
            0 | 1 => drop(it.insert(Disabled)),
            2 | 3 => drop(it.remove::<Disabled>()),
            4 if is_rough => it.despawn(),
            5 => {
                if let Some(kind) = it.take::<RigidBody>()
                    && !(is_rough && dice.below(3) == 0)
                {
                    it.insert(kind);
                }
            }
            6 => {
                let kinds = [RigidBody::Static, RigidBody::Kinematic, RigidBody::Dynamic];
                it.insert(kinds[dice.below(6).min(2)]);
            }
            7 => {
                let at = Transform::from_translation(dice.vector(-1.0, 1.0));
                it.insert(at);
            }
            8 if is_rough => {
                if self.body(other).is_none() {
                    let is_linked = dice.below(2) == 0;
                    self.clone_body(body, other, is_linked);
                }
            }
            9 => {
                if !is_rough {
                    // A joint that takes no part when its body breaks goes with it.
                    self.release();
                    self.run(Deed::Frame(1));
                }
                let Some(it) = self.lives(Some(body)) else {
                    return;
                };
                let it = self.app.world().entity(it);
                let at = it.get::<Transform>().expect("it has one").translation;
                let plane = Plane::through(at, dice.direction());
                self.app.world_mut().commands().slice(body, plane);
                if !is_rough {
                    self.app.world_mut().flush();
                    self.run(Deed::Frame(1));
                }
            }
            10 => drop(it.remove::<ShapeAwaited>().insert(cube())),
            _ => drop(it.insert((RigidBody::Dynamic, cube()))),
        }
    }

    fn clone_body(&mut self, body: Entity, name: usize, is_linked: bool) {
        self.said
            .push(format!("clone {body} as {name}, linked {is_linked}"));
        let world = self.app.world_mut();
        let mut builder = EntityCloner::build_opt_out(world);
        builder.linked_cloning(is_linked);
        let clone = builder.finish().spawn_clone(world, body);
        self.bodies[name] = Some(clone);
    }

    /// A joint of two bodies where they are.
    fn fitting(&self, a: Option<Entity>, b: Entity, dice: &mut Dice) -> Joint {
        let pose = |entity: Entity| {
            let at = self.app.world().get::<Transform>(entity);
            at.map_or(Pose::IDENTITY, |at| Pose::new(at.translation, at.rotation))
        };
        let [pose_a, pose_b] = [a.map_or(Pose::IDENTITY, pose), pose(b)];
        let at = pose_a.position.lerp(pose_b.position, dice.unit());
        let joint = kind_of_joint(dice).with_anchor(at, dice.direction(), [pose_a, pose_b]);
        match dice.below(5) {
            0 if self.manner == Manner::Rough => joint.with_strength(5.0, 5.0),
            _ => joint,
        }
    }

    fn act_on_joint(&mut self, name: usize, dice: &mut Dice) {
        let number = dice.below(JOINTS);
        let b = self.body(name).expect("looked for before");
        let a = self.body(dice.below(BODIES)).filter(|&a| a != b);
        let joint = self.fitting(a, b, dice);
        let Some(known) = self.lives(self.joints[number]) else {
            if self.manner == Manner::Faithful {
                return;
            }
            let spoil = dice.below(6) == 0;
            let joint = if spoil { spoilt(dice, joint) } else { joint };
            let world = self.app.world_mut();
            let made = world.commands().join(a, b, joint);
            world.flush();
            self.said
                .push(format!("join {number}: {made} {a:?} {b} spoilt {spoil}"));
            self.joints[number] = Some(made);
            return;
        };
        let deed = dice.below(16);
        self.said
            .push(format!("joint {number} {known}: {deed} {a:?} {b}"));
        if self.manner == Manner::Rough {
            self.change_joint(known, deed, (joint, a, b), dice);
        } else if deed < 4 {
            let mut it = self.app.world_mut().entity_mut(known);
            match deed {
                0 | 1 => drop(it.insert(Disabled)),
                _ => drop(it.remove::<Disabled>()),
            }
        } else {
            do_nothing(&mut self.app.world_mut().entity_mut(known), deed);
        }
    }

    fn change_joint(
        &mut self,
        known: Entity,
        deed: usize,
        (joint, a, b): (Joint, Option<Entity>, Entity),
        dice: &mut Dice,
    ) {
        let spoilt = spoilt(dice, joint);
        let world = self.app.world_mut();
        let mut it = world.entity_mut(known);
        match deed {
            0 | 1 => drop(it.insert(joint)),
            2 => drop(it.insert(spoilt)),
            3 => drop(it.remove::<Joint>()),
            4 => drop(it.remove::<JointA>()),
            5 => drop(it.remove::<JointB>()),
            6 => drop(it.insert(JointB(b))),
            7 => {
                if let Some(a) = a {
                    it.insert(JointA(a));
                }
            }
            8 => drop(it.insert(Disabled)),
            9 => drop(it.remove::<Disabled>()),
            10 => it.despawn(),
            11 => {
                let clone = it.clone_and_spawn();
                self.said.push(format!("clone {known} as {clone}"));
            }
            12 => {
                if let Some(mut joint) = it.get_mut::<Joint>() {
                    joint.contacts = !joint.contacts;
                }
            }
            13 => drop(it.remove_with_requires::<Joint>().insert(joint)),
            14 => drop(it.remove::<(JointA, JointB)>().insert((JointB(b), joint))),
            _ => do_nothing(&mut it, dice.below(8)),
        }
    }
}

/// Sets a component anew as it is, if the entity has it.
fn again<C: Component + Clone>(entity: &mut EntityWorldMut) {
    if let Some(value) = entity.get::<C>().cloned() {
        entity.insert(value);
    }
}

/// Does something to a joint that changes nothing.
pub(crate) fn do_nothing(it: &mut EntityWorldMut, deed: usize) {
    let is_on = !it.contains::<Disabled>();
    match deed % 8 {
        0 => again::<Joint>(it),
        1 => again::<JointA>(it),
        2 => again::<JointB>(it),
        3 => {
            if let Some(mut joint) = it.get_mut::<Joint>() {
                joint.set_changed();
            }
        }
        4 if is_on => drop(it.insert(Disabled).remove::<Disabled>()),
        4 => drop(it.remove::<Disabled>().insert(Disabled)),
        5 => {
            if let Some(joint) = it.take::<Joint>() {
                it.insert(joint);
            }
        }
        6 => {
            if let Some(joint) = it.get::<Joint>().copied() {
                it.remove_with_requires::<Joint>().insert(joint);
            }
        }
        _ => {
            let ends = (it.get::<JointA>().copied(), it.get::<JointB>().copied());
            it.remove::<(JointA, JointB)>();
            if let Some(b) = ends.1 {
                it.insert(b);
            }
            if let Some(a) = ends.0 {
                it.insert(a);
            }
        }
    }
}
