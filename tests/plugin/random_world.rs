//! Random apps: a few names, each of which may stand for an entity, and a random story of what users do to them between frames.
//!
//! Every deed has a seed of its own, so that a story that fails fails as well without the deeds that do not matter.
#![allow(dead_code, reason = "each test program uses some of it")]

use crate::app::app;
use crate::common::dice::Dice;
use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_time::{Fixed, Time, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use glam::{Quat, Vec3};
use std::collections::HashSet;

/// Names of entities.
pub(crate) const NAMES: usize = 10;

/// Names of joints.
const JOINTS: usize = 4;

/// One thing that is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Deed {
    /// So many steps in one frame.
    Frame(u32),
    /// Something that is done to somebody, by the seed.
    Act(u64),
}

/// A random story.
pub(crate) fn story(seed: u64, deeds: usize) -> Vec<Deed> {
    let mut dice = Dice::new(seed);
    let early = (0..6).map(|i| Deed::Act(seed.wrapping_mul(1_000_003) + i));
    let late = (6..deeds as u64).map(|i| match dice.below(4) {
        0 => Deed::Frame([1, 1, 1, 1, 2, 0, 5][dice.below(7)]),
        _ => Deed::Act(seed.wrapping_mul(1_000_003) + i),
    });
    early.chain(late.collect::<Vec<_>>()).collect()
}

/// An app, and who is in it.
pub(crate) struct RandomWorld {
    pub(crate) app: App,
    pub(crate) names: Vec<Option<Entity>>,
    joints: Vec<Option<Entity>>,
    /// Whether what is done may be unusable.
    pub(crate) is_rough: bool,
    /// All that ever were.
    pub(crate) everyone: Vec<Entity>,
    /// Entities that stopped to ask for their contacts once: what was told of them has no end.
    pub(crate) unsure: HashSet<Entity>,
    /// Whether entities are cloned, and those that came of it: of a piece they are pieces of which nobody tells.
    pub(crate) clones: bool,
    pub(crate) cloned: HashSet<Entity>,
    /// What was done, in words.
    pub(crate) said: Vec<String>,
}

/// A number that is mostly usable.
fn number(dice: &mut Dice, is_rough: bool) -> f32 {
    let bad = [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e30];
    match dice.below(6) {
        0 if is_rough => bad[dice.below(bad.len())],
        _ => dice.in_range(0.1, 0.9),
    }
}

fn vector(dice: &mut Dice, size: f32, is_rough: bool) -> Vec3 {
    let mut vector = dice.vector(-size, size);
    if dice.below(6) == 0 && is_rough {
        vector[dice.below(3)] = f32::NAN;
    }
    vector
}

fn place(dice: &mut Dice) -> Vec3 {
    dice.vector(-1.5, 1.5) + 1.5 * Vec3::Y
}

pub(crate) fn convex(dice: &mut Dice) -> ConvexMesh {
    let size = dice.vector(0.3, 1.2);
    let shape = match dice.below(5) {
        0 => ConvexMesh::sphere(0.5 * size.x),
        1 => ConvexMesh::capsule(0.3 * size.x, size.y),
        2 => ConvexMesh::regular_prism(5, 0.5 * size.x, size.y),
        _ => ConvexMesh::cuboid(size.x, size.y, size.z),
    };
    shape.expect("these have a volume")
}

fn compound(dice: &mut Dice) -> Compound {
    let size = 0.5 * dice.vector(0.5, 1.5);
    let cube = ConvexMesh::cuboid(size.x, size.y, size.z).expect("a box");
    let halves = [-0.5, 0.5].map(|x| (Pose::from_position(x * size.x * Vec3::X), cube.clone()));
    let halves = Compound::new(halves).expect("usable");
    match dice.below(2) {
        0 => halves,
        _ => halves
            .bonded([1e3, 1e6][dice.below(2)])
            .expect("they touch"),
    }
}

fn level(dice: &mut Dice) -> StaticMesh {
    let heights: Vec<f32> = (0..16).map(|_| dice.in_range(-0.2, 0.2)).collect();
    StaticMesh::from_heights(&heights, 4, 2.0).expect("a grid")
}

fn fracturable(dice: &mut Dice, is_rough: bool) -> Fracturable {
    let pattern = match dice.below(4) {
        0 => FracturePattern::SinglePlane,
        1 => FracturePattern::RandomPlane,
        2 => FracturePattern::Slabs { count: 3 },
        _ => FracturePattern::Planes([].into()),
    };
    let strength = [1.0, 300.0, 1e9, number(dice, is_rough)][dice.below(4)];
    Fracturable::with_strength(strength).with_pattern(pattern)
}

pub(crate) fn kind(dice: &mut Dice) -> RigidBody {
    [
        RigidBody::Dynamic,
        RigidBody::Dynamic,
        RigidBody::Kinematic,
        RigidBody::Static,
    ][dice.below(4)]
}

fn joint(dice: &mut Dice, is_rough: bool) -> Joint {
    let joint = match dice.below(5) {
        0 => Joint::hinge(),
        1 => Joint::ball(),
        2 => Joint::rope(2.0),
        3 => Joint::slider(),
        _ => Joint::fixed(),
    };
    let anchored = joint.with_anchors(vector(dice, 1.0, is_rough), Vec3::ZERO);
    match dice.below(4) {
        0 => anchored.with_strength(50.0, 50.0),
        1 => anchored.with_strength(number(dice, is_rough), 1e9),
        _ => anchored,
    }
}

/// A pose that is set, and a scale.
fn transform(dice: &mut Dice, is_rough: bool) -> Transform {
    let mut transform = Transform::from_translation(place(dice));
    if dice.below(2) == 0 {
        transform.rotation = dice.rotation();
    }
    match dice.below(10) {
        0 => transform.scale = Vec3::splat(dice.in_range(0.5, 1.5)),
        1 => transform.scale = dice.vector(0.5, 1.5),
        2 if is_rough => transform.scale = Vec3::splat(number(dice, true)),
        3 if is_rough => transform.translation = vector(dice, 1.0, true),
        4 if is_rough => transform.rotation = Quat::from_xyzw(0.0, 0.0, 0.0, 0.0),
        5 if is_rough => transform.scale.y = [0.0, -1.0, 1e30][dice.below(3)],
        _ => {}
    }
    transform
}

impl RandomWorld {
    pub(crate) fn new(is_rough: bool) -> Self {
        Self::in_app(app(), is_rough)
    }

    /// One in an app of another kind.
    pub(crate) fn in_app(app: App, is_rough: bool) -> Self {
        Self {
            app,
            names: vec![None; NAMES],
            joints: vec![None; JOINTS],
            is_rough,
            clones: true,
            cloned: HashSet::new(),
            everyone: Vec::new(),
            unsure: HashSet::new(),
            said: Vec::new(),
        }
    }

    /// A floor that nothing is done to.
    pub(crate) fn lay_floor(&mut self) {
        let slab = ConvexMesh::cuboid(30.0, 1.0, 30.0).expect("a slab");
        let below = Transform::from_xyz(0.0, -0.5, 0.0);
        let floor = self.app.world_mut().spawn((RigidBody::Static, slab, below));
        self.everyone.push(floor.id());
    }

    /// The entity that a name stands for, if it is there.
    pub(crate) fn entity(&self, name: usize) -> Option<Entity> {
        let entity = self.names[name]?;
        self.app
            .world()
            .get_entity(entity)
            .is_ok()
            .then_some(entity)
    }

    /// Does what is told.
    pub(crate) fn run(&mut self, deed: Deed) {
        match deed {
            Deed::Frame(steps) => {
                self.said.push(format!("-- {steps} steps"));
                self.app
                    .insert_resource(TimeUpdateStrategy::FixedTimesteps(steps));
                self.app.update();
                self.name_pieces();
            }
            Deed::Act(seed) => self.act(&mut Dice::new(seed)),
        }
    }

    /// Names that stand for nobody get pieces.
    fn name_pieces(&mut self) {
        let world = self.app.world_mut();
        let mut pieces = world.query_filtered::<Entity, With<PieceOf>>();
        let mut pieces: Vec<Entity> = pieces.iter(world).collect();
        pieces.sort_unstable();
        self.everyone.extend(&pieces);
        pieces.retain(|piece| !self.names.contains(&Some(*piece)));
        for name in 0..NAMES {
            if self.entity(name).is_none()
                && let Some(piece) = pieces.pop()
            {
                self.names[name] = Some(piece);
            }
        }
    }

    fn spawn(&mut self, name: usize, dice: &mut Dice) {
        let is_rough = self.is_rough;
        let at = transform(dice, is_rough);
        let kind = kind(dice);
        let mut entity = self.app.world_mut().spawn(at);
        match dice.below(8) {
            0 => drop(entity.insert((compound(dice), kind))),
            1 => drop(entity.insert((level(dice), RigidBody::Static))),
            2 => drop(entity.insert((HalfSpaceShape { normal: Vec3::Y }, RigidBody::Static))),
            _ => drop(entity.insert((convex(dice), kind))),
        }
        if dice.below(2) == 0 {
            entity.insert(CollisionEvents);
        }
        if dice.below(5) == 0 {
            entity.insert(fracturable(dice, is_rough));
        }
        let id = entity.id();
        self.said
            .push(format!("spawn {name}: {id} {kind:?} {at:?}"));
        self.names[name] = Some(id);
        self.everyone.push(id);
    }

    fn act(&mut self, dice: &mut Dice) {
        let (a, b) = (dice.below(NAMES), dice.below(NAMES));
        let Some(entity) = self.entity(a) else {
            return self.spawn(a, dice);
        };
        let other = self.entity(b);
        match dice.below(16) {
            0 => {
                self.said.push(format!("despawn {a}"));
                self.app.world_mut().despawn(entity);
            }
            1 | 2 => self.join(entity, other, dice),
            3 => self.bond(entity, other, dice),
            4 => self.relate(entity, other, dice),
            5 => {
                let plane = Plane::through(place(dice), dice.direction());
                self.said.push(format!("slice {entity}"));
                self.app.world_mut().commands().slice(entity, plane);
            }
            6 => self.push(entity, dice),
            7 => {
                self.said.push(format!("clone {a} as {b}"));
                if other.is_none() && self.clones {
                    let clone = self.app.world_mut().entity_mut(entity).clone_and_spawn();
                    self.names[b] = Some(clone);
                    self.everyone.push(clone);
                    self.cloned.insert(clone);
                }
            }
            _ => {
                let is_rough = self.is_rough;
                let did_ask = self.app.world().get::<CollisionEvents>(entity).is_some();
                let said = change(&mut self.app.world_mut().entity_mut(entity), dice, is_rough);
                self.said.push(format!("{a} {entity}: {said}"));
                if did_ask && self.app.world().get::<CollisionEvents>(entity).is_none() {
                    self.unsure.insert(entity);
                }
            }
        }
        self.app.world_mut().flush();
    }

    fn join(&mut self, entity: Entity, other: Option<Entity>, dice: &mut Dice) {
        let name = dice.below(JOINTS);
        let known = self.joints[name].filter(|&it| self.app.world().get_entity(it).is_ok());
        let joint = joint(dice, self.is_rough);
        let world = self.app.world_mut();
        let Some(known) = known else {
            self.said
                .push(format!("join {entity} {other:?} {:?}", joint.break_force));
            let made = world.commands().join(other, entity, joint);
            world.flush();
            self.joints[name] = Some(made);
            self.everyone.push(made);
            return;
        };
        let deed = dice.below(9);
        self.said
            .push(format!("joint {name} {known}: {deed} {entity} {other:?}"));
        let mut known = world.entity_mut(known);
        match deed {
            0 => drop(known.insert(joint)),
            1 => drop(known.remove::<Joint>()),
            2 => drop(known.remove::<JointA>()),
            3 => drop(known.remove::<JointB>()),
            4 => drop(known.insert(JointB(entity))),
            5 => drop(known.insert(JointA(entity))),
            6 => drop(known.insert(Disabled)),
            7 => drop(known.remove::<Disabled>()),
            _ => known.despawn(),
        }
    }

    fn bond(&mut self, entity: Entity, other: Option<Entity>, dice: &mut Dice) {
        let Some(other) = other else {
            return;
        };
        self.said.push(format!("bond {entity} {other}"));
        let mut commands = self.app.world_mut().commands();
        match dice.below(3) {
            0 => commands.unbond(entity, other),
            1 => commands.bond(entity, other, Bond::new(1e3, 0.1)),
            _ => commands.bond(entity, other, Bond::new(1e9, 0.1)),
        }
    }

    fn relate(&mut self, entity: Entity, other: Option<Entity>, dice: &mut Dice) {
        let world = self.app.world_mut();
        let is_above = other.is_some_and(|mut at| {
            loop {
                if at == entity {
                    return true;
                }
                match world.get::<ChildOf>(at) {
                    Some(up) => at = up.parent(),
                    None => return false,
                }
            }
        });
        match other.filter(|_| !is_above && dice.below(3) != 0) {
            Some(other) => {
                self.said.push(format!("{entity} child of {other}"));
                world.entity_mut(entity).insert(ChildOf(other));
            }
            None => {
                self.said.push(format!("{entity} child of none"));
                world.entity_mut(entity).remove::<ChildOf>();
            }
        }
    }

    /// Pushes bodies, or changes how all go on.
    fn push(&mut self, entity: Entity, dice: &mut Dice) {
        let explosion = Explosion {
            center: place(dice),
            radius: 2.0,
            impulse: [10.0, 1e3][dice.below(2)],
        };
        let gravity = [Vec3::ZERO, -9.81 * Vec3::Y][dice.below(2)];
        let world = self.app.world_mut();
        let hertz = [30.0, 60.0, 120.0][dice.below(3)];
        match dice.below(7) {
            1 => {
                self.said.push(format!("{hertz} Hz"));
                world.resource_mut::<Time<Fixed>>().set_timestep_hz(hertz);
            }
            0 => {
                self.said.push(format!("explode {explosion:?}"));
                world.commands().explode(explosion);
            }
            2 => {
                use SolverConfig as Config;
                let other = [Config::default(), Config::fast(), Config::precise()][dice.below(3)];
                self.said.push(format!("{:?}", other.method));
                world.resource_mut::<Config>().method = other.method;
            }
            3 => {
                let push = vector(dice, 5.0, self.is_rough);
                self.said.push(format!("{entity} pushed by {push}"));
                let mut forces = world.query::<Forces>();
                if let Ok(mut forces) = forces.get_mut(world, entity) {
                    forces.apply_impulse(push);
                    forces.apply_torque(10.0 * push);
                }
            }
            _ => {
                self.said.push(format!("gravity {gravity}"));
                world.insert_resource(Gravity(gravity));
            }
        }
    }
}

/// Gives an entity a component; what that was.
fn put<C: Component + std::fmt::Debug>(entity: &mut EntityWorldMut, component: C) -> String {
    let said = format!("{component:?}");
    entity.insert(component);
    said.chars().take(160).collect()
}

/// Takes a component away; what that was.
fn take<C: Component>(entity: &mut EntityWorldMut) -> String {
    entity.remove::<C>();
    format!("without {}", std::any::type_name::<C>())
}

/// Changes a component, or takes some away; what that was.
fn change(entity: &mut EntityWorldMut, dice: &mut Dice, is_rough: bool) -> String {
    match dice.below(12) {
        0 | 1 => put(entity, kind(dice)),
        2 => change_shape(entity, dice, is_rough),
        3 => change_breaking(entity, dice, is_rough),
        4 => change_telling(entity, dice, is_rough),
        5 => match dice.below(2) {
            0 => put(entity, Disabled),
            _ => take::<Disabled>(entity),
        },
        6 => put(entity, transform(dice, is_rough)),
        7 => match dice.below(4) {
            0 => put(entity, LinearVelocity(vector(dice, 3.0, is_rough))),
            1 => put(entity, AngularVelocity(vector(dice, 3.0, is_rough))),
            2 => put(entity, Sleeping),
            _ => take::<Sleeping>(entity),
        },
        8 => change_material(entity, dice, is_rough),
        9 => change_drive(entity, dice, is_rough),
        10 if is_rough => change_parts(entity, dice),
        _ => match entity.get::<RigidBody>().copied() {
            None => put(entity, kind(dice)),
            Some(_) if dice.below(3) == 0 => take::<RigidBody>(entity),
            Some(kind) => {
                entity.remove::<RigidBody>();
                format!("anew {}", put(entity, kind))
            }
        },
    }
}

fn change_shape(entity: &mut EntityWorldMut, dice: &mut Dice, is_rough: bool) -> String {
    let normal = vector(dice, 1.0, is_rough);
    match dice.below(9) {
        0..=2 => put(entity, convex(dice)),
        3 => put(entity, compound(dice)),
        4 => put(entity, level(dice)),
        5 => put(entity, HalfSpaceShape { normal }),
        6 => take::<ConvexMesh>(entity),
        7 => take::<Compound>(entity),
        _ => match dice.below(2) {
            0 => take::<StaticMesh>(entity),
            _ => take::<HalfSpaceShape>(entity),
        },
    }
}

fn change_breaking(entity: &mut EntityWorldMut, dice: &mut Dice, is_rough: bool) -> String {
    match dice.below(8) {
        0 | 1 => put(entity, fracturable(dice, is_rough)),
        2 => take::<Fracturable>(entity),
        3 => put(entity, Anchors::touching()),
        4 => put(entity, Anchors::none().with_reach(number(dice, is_rough))),
        5 => take::<Anchors>(entity),
        6 => put(entity, Fatigue::new(number(dice, is_rough))),
        _ => take::<Fatigue>(entity),
    }
}

fn change_telling(entity: &mut EntityWorldMut, dice: &mut Dice, is_rough: bool) -> String {
    let threshold = number(dice, is_rough);
    match dice.below(6) {
        0 => put(entity, Sensor),
        1 => take::<Sensor>(entity),
        2 => put(entity, CollisionEvents),
        3 => take::<CollisionEvents>(entity),
        4 => put(entity, ContactForceEvents { threshold }),
        _ => take::<ContactForceEvents>(entity),
    }
}

fn change_material(entity: &mut EntityWorldMut, dice: &mut Dice, is_rough: bool) -> String {
    let number = number(dice, is_rough);
    match dice.below(8) {
        0 => put(entity, Density(1000.0 * number)),
        1 => put(entity, Friction::new(number)),
        2 => put(entity, Restitution::new(number)),
        3 => put(entity, Mass(number)),
        4 => take::<Mass>(entity),
        5 => put(entity, MassOverride(MassProperties::default())),
        6 => take::<MassOverride>(entity),
        _ => {
            let filters = [1, u32::MAX][dice.below(2)];
            put(entity, CollisionLayers::new(1 << dice.below(2), filters))
        }
    }
}

fn change_drive(entity: &mut EntityWorldMut, dice: &mut Dice, is_rough: bool) -> String {
    let number = number(dice, is_rough);
    let speed = MaxSpeed {
        linear: number,
        angular: 1.0,
    };
    match dice.below(12) {
        0 => put(entity, GravityScale(number)),
        1 => put(entity, ConstantForce(vector(dice, 10.0, is_rough))),
        2 => put(entity, LinearDamping(number)),
        3 => put(entity, LockedAxes::PLANE_XY),
        4 => put(entity, speed),
        5 => put(entity, ConstantTorque(vector(dice, 10.0, is_rough))),
        6 => take::<GravityScale>(entity),
        7 => take::<ConstantForce>(entity),
        8 => take::<LinearDamping>(entity),
        9 => take::<LockedAxes>(entity),
        10 => take::<MaxSpeed>(entity),
        _ => take::<ConstantTorque>(entity),
    }
}

/// What a body cannot be without, and what its shape comes of.
fn change_parts(entity: &mut EntityWorldMut, dice: &mut Dice) -> String {
    let size = 0.5 * Vec3::splat(number(dice, true));
    match dice.below(13) {
        0 => take::<Transform>(entity),
        1 => take::<LinearVelocity>(entity),
        2 => take::<Density>(entity),
        3 => take::<CollisionLayers>(entity),
        4 => put(entity, Transform::from_translation(place(dice))),
        5 => put(entity, LinearVelocity::default()),
        6 => put(entity, Density::default()),
        7 => put(entity, CompoundOfChildren),
        8 => take::<CompoundOfChildren>(entity),
        9 => put(entity, ShapeConstructor::Cuboid { size }),
        10 => take::<ShapeConstructor>(entity),
        11 => put(entity, ShapeAwaited),
        _ => take::<ShapeAwaited>(entity),
    }
}
