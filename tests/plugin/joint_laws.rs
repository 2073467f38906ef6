//! Joints hold what their entities say, whatever was done before to them and to their bodies; nothing of them is left over, what broke
//! is told of once, and what changes nothing changes no bit.

use crate::app::app;
use crate::common::dice::Dice;
use crate::joint_world::{BODIES, Heard, JointWorld, Manner, do_nothing};
use crate::random_world::Deed;
use crate::twins::{body_of, texts};
use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::Vec3;
use std::collections::HashSet;
use std::ops::Range;

/// A random story of so many deeds.
fn story(seed: u64, deeds: u64) -> Vec<Deed> {
    let mut dice = Dice::new(seed);
    let deeds = (0..deeds).map(|i| match dice.below(4) {
        0 if i > 4 => Deed::Frame([1, 1, 1, 2, 0, 5][dice.below(6)]),
        _ => Deed::Act(seed.wrapping_mul(1_000_003) + i),
    });
    deeds.collect()
}

fn handle(world: &World, joint: Entity) -> Option<JointId> {
    world.get::<JointHandle>(joint)?.get()
}

fn problem(world: &World, joint: Entity) -> Option<String> {
    let problem = world.get::<JointProblem>(joint);
    problem.map(|problem| problem.0.to_string())
}

/// The entities that a joint relates to.
fn ends(world: &World, joint: Entity) -> [Option<Entity>; 2] {
    let a = world.get::<JointA>(joint).map(|a| a.0);
    [a, world.get::<JointB>(joint).map(|b| b.0)]
}

fn is_on(world: &World, entity: Entity) -> bool {
    !world.entity(entity).contains::<Disabled>()
}

/// Whether a joint is one, and takes part.
fn asks(world: &World, joint: Entity) -> bool {
    is_on(world, joint) && world.entity(joint).contains::<Joint>()
}

/// Entities and joints of the simulation know each other.
fn look(scene: &mut JointWorld) -> Result<(), String> {
    let all = scene.all_joints();
    let world = scene.app.world();
    let joints = world.resource::<Joints>();
    let mut known = HashSet::new();
    for joint in all {
        if let Some(end) = ends(world, joint)
            .into_iter()
            .flatten()
            .find(|it| world.get_entity(*it).is_err())
        {
            return Err(format!("{joint} is of {end}, which is gone"));
        }
        let Some(id) = handle(world, joint) else {
            let is_end_off =
                |end: Entity| !is_on(world, end) || world.get::<ShapeAwaited>(end).is_some();
            let waits = ends(world, joint).into_iter().flatten().any(is_end_off);
            if asks(world, joint) && problem(world, joint).is_none() && !waits {
                return Err(format!("{joint} does not hold and says nothing"));
            }
            if !asks(world, joint) && problem(world, joint).is_some() {
                return Err(format!(
                    "{joint} asks for nothing and says {:?}",
                    problem(world, joint)
                ));
            }
            continue;
        };
        if !known.insert(id) {
            return Err(format!("{joint} and another are both {id:?}"));
        }
        let slots = ends(world, joint).map(|end| end.map(|end| body_of(world, end)));
        let held = joints
            .bodies(id)
            .map(|slots| slots.map(|slot| slot.map(Some)));
        let lies = [
            (!joints.contains(id), "holds as none"),
            (!asks(world, joint), "holds and does not ask to"),
            (problem(world, joint).is_some(), "holds and says why not"),
            (
                joints.get(id) != world.get::<Joint>(joint),
                "is another one",
            ),
            (held != Some(slots), "holds others"),
        ];
        if let Some((_, lie)) = lies.into_iter().find(|(is_so, _)| *is_so) {
            return Err(format!("{joint} {lie}: {held:?} {slots:?}"));
        }
    }
    match joints.len() == known.len() {
        true => Ok(()),
        false => Err(format!("{} joints, {} entities", joints.len(), known.len())),
    }
}

/// What broke is told once by each way, and is as it is told.
fn hear(
    scene: &mut JointWorld,
    told: &mut HashSet<(Entity, u64)>,
    frame: u64,
) -> Result<(), String> {
    let heard = std::mem::take(&mut *scene.app.world_mut().resource_mut::<Heard>());
    if heard.messages != heard.events {
        return Err(format!(
            "messages {:?}, events {:?}",
            heard.messages, heard.events
        ));
    }
    let world = scene.app.world();
    for broken in &heard.messages {
        let joint = broken.entity;
        if !told.insert((joint, frame)) {
            return Err(format!("{joint} broke twice"));
        }
        let alive = |end: &Entity| world.get_entity(*end).is_ok();
        let should_live = broken.bodies.iter().flatten().all(alive);
        if should_live && world.get_entity(joint).is_err() {
            return Err(format!("{joint} broke and is gone, its bodies are there"));
        }
        if world.get_entity(joint).is_ok() {
            if world.entity(joint).contains::<Joint>() {
                return Err(format!("{joint} broke and is still a joint"));
            }
            if ends(world, joint) != broken.bodies {
                return Err(format!(
                    "{joint} is of {:?}, told {:?}",
                    ends(world, joint),
                    broken.bodies
                ));
            }
        }
    }
    Ok(())
}

/// Another app with the same bodies and joints.
fn afresh(scene: &mut JointWorld) -> (App, EntityHashMap<Entity>) {
    let (bodies, joints) = (scene.all_bodies(), scene.all_joints());
    let mut other = app();
    let world = scene.app.world();
    let mut twins = EntityHashMap::default();
    for &body in &bodies {
        let it = world.entity(body);
        let mut to = other.world_mut().spawn_empty();
        macro_rules! copy {
            ($($part:ty),*) => {$(
                if let Some(part) = it.get::<$part>() {
                    to.insert(part.clone());
                }
            )*};
        }
        copy!(
            ShapeAwaited,
            ConvexMesh,
            Transform,
            RigidBody,
            LinearVelocity,
            AngularVelocity,
            Disabled
        );
        twins.insert(body, to.id());
    }
    for &joint in &joints {
        let mut to = other.world_mut().spawn_empty();
        let it = world.entity(joint);
        let [a, b] = ends(world, joint);
        if let Some(a) = a {
            to.insert(JointA(twins[&a]));
        }
        if let Some(b) = b {
            to.insert(JointB(twins[&b]));
        }
        if let Some(part) = it.get::<Joint>() {
            to.insert(*part);
        }
        if let Some(part) = it.get::<Disabled>() {
            to.insert(part.clone());
        }
        twins.insert(joint, to.id());
    }
    (other, twins)
}

/// Whether joints say what they would say in another app.
fn compare_afresh(scene: &mut JointWorld) -> Result<(), String> {
    let (mut other, twins) = afresh(scene);
    other.update();
    let joints = scene.all_joints();
    let (world, fresh) = (scene.app.world(), other.world());
    for joint in joints {
        let copy = twins[&joint];
        let breaks = world.get::<Joint>(joint).is_some() != fresh.get::<Joint>(copy).is_some();
        // A body that is not usable any more is still held.
        let is_sound = |end: Entity| texts(world, end).is_empty();
        if breaks || !ends(world, joint).into_iter().flatten().all(is_sound) {
            continue;
        }
        let says = [problem(world, joint), problem(fresh, copy)];
        // Of a body that was disabled later it is known what it is; of one that is not there yet it is not.
        let is_known_longer = says[1].is_none()
            && ends(world, joint)
                .into_iter()
                .flatten()
                .any(|end| !is_on(world, end) && body_of(world, end).is_some());
        if says[0] != says[1] && !is_known_longer {
            return Err(format!("{joint} says {:?}, afresh {:?}", says[0], says[1]));
        }
        let is_end_off = |end: Entity| !is_on(world, end);
        let off = ends(world, joint).into_iter().flatten().any(is_end_off);
        let holds = [handle(world, joint), handle(fresh, copy)].map(|id| id.is_some());
        if !off && holds[0] != holds[1] {
            return Err(format!(
                "{joint} holds {:?}, afresh {:?}",
                holds[0], holds[1]
            ));
        }
    }
    Ok(())
}

pub(crate) fn joints_are_what_they_say(seed: u64) -> Result<(), String> {
    let mut scene = JointWorld::new(Manner::Rough);
    let mut told = HashSet::new();
    let deeds = story(seed, 60);
    for (frame, &deed) in (0..).zip(&deeds) {
        scene.run(deed);
        if let Deed::Frame(1..) = deed {
            let looked = look(&mut scene).and_then(|()| hear(&mut scene, &mut told, frame));
            looked.map_err(|error| format!("{error}\n{:#?}", scene.said))?;
        }
    }
    // What breaks is read with the next step.
    (0..2).for_each(|_| scene.run(Deed::Frame(1)));
    compare_afresh(&mut scene).map_err(|error| format!("{error}\n{:#?}", scene.said))
}

/// What is seen of a scene, as text.
fn seen(scene: &mut JointWorld) -> String {
    let mut text = String::new();
    for name in 0..BODIES {
        let Some(slot) = scene
            .body(name)
            .and_then(|it| body_of(scene.app.world(), it))
        else {
            continue;
        };
        let bodies = scene.app.world().resource::<Bodies>();
        text += &format!(
            "{name} {:?} {:?}\n",
            bodies.pose(slot),
            bodies.velocity(slot)
        );
    }
    for joint in scene.all_joints() {
        let world = scene.app.world();
        let id = handle(world, joint);
        let load = id.map(|id| world.resource::<Joints>().load(id));
        text += &format!("{joint} {id:?} {:?} {load:?}\n", problem(world, joint));
    }
    text
}

pub(crate) fn what_is_nothing_changes_nothing(seed: u64) -> Result<(), String> {
    let mut scenes = [(); 2].map(|()| JointWorld::new(Manner::Rough));
    let mut dice = Dice::new(seed);
    for deed in story(seed, 60) {
        if let Deed::Frame(_) = deed {
            let [_, other] = &mut scenes;
            for joint in other.all_joints() {
                let deed = dice.below(16);
                // The order in which joints arrive is theirs for good.
                if deed < 8 && handle(other.app.world(), joint).is_some() {
                    do_nothing(&mut other.app.world_mut().entity_mut(joint), deed);
                }
            }
        }
        scenes.iter_mut().for_each(|scene| scene.run(deed));
        // What was set is read with the next step.
        if !matches!(deed, Deed::Frame(1..)) {
            continue;
        }
        let [a, b] = scenes.each_mut().map(seen);
        if a != b {
            return Err(format!("{a}\nother\n{b}\n{:#?}", scenes[0].said));
        }
    }
    Ok(())
}

pub(crate) fn what_is_joined_stays_joined(seed: u64) -> Result<(), String> {
    let mut dice = Dice::new(seed);
    let mut scene = JointWorld::new(Manner::Faithful);
    scene
        .app
        .insert_resource(Gravity(Vec3::new(0.0, -9.81, 0.0)));
    let joints = scene.lay_chain(&mut dice);
    for deed in story(seed, 40) {
        scene.run(deed);
        look(&mut scene)
            .map_err(|error| format!("{error}\n{:#?}", scene.said))
            .or_else(|error| match deed {
                Deed::Frame(1..) => Err(error),
                _ => Ok(()),
            })?;
    }
    scene.release();
    (0..180).for_each(|_| scene.run(Deed::Frame(1)));
    let world = scene.app.world();
    for joint in joints {
        let Ok(it) = world.get_entity(joint) else {
            return Err(format!("{joint} is gone\n{:#?}", scene.said));
        };
        let error = it.get::<JointLoad>().map(|load| load.error[0]);
        if handle(world, joint).is_none() || error.is_none_or(|error| error > 1e-3) {
            return Err(format!(
                "{joint} {:?} {error:?}\n{:#?}",
                problem(world, joint),
                scene.said
            ));
        }
    }
    Ok(())
}

#[test]
pub(crate) fn who_hears_of_a_broken_joint_can_mend_it() {
    let mut app = app();
    app.add_observer(|broken: On<JointBroken>, mut commands: Commands| {
        let mended = broken.joint.with_strength(f32::INFINITY, f32::INFINITY);
        commands.entity(broken.entity).insert(mended);
    });
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a cube");
    let parts = (RigidBody::Dynamic, cube, Transform::default());
    let body = app.world_mut().spawn(parts).id();
    let weak = Joint::fixed().with_strength(1.0, 1.0);
    let joint = app.world_mut().commands().join(None, body, weak);
    (0..3).for_each(|_| app.update());
    assert!(handle(app.world(), joint).is_some());
}

#[test]
fn joints_hold_what_their_entities_say_whatever_was_done_before() {
    check(joints_are_what_they_say, 0..300);
    // Clones of joints whose other body goes in the same frame.
    check(joints_are_what_they_say, 2660..2661);
    check(joints_are_what_they_say, 2861..2862);
}

#[test]
fn what_is_set_anew_of_a_joint_as_it_is_changes_no_bit() {
    check(what_is_nothing_changes_nothing, 0..200);
}

#[test]
fn what_is_joined_stays_joined_whatever_becomes_of_the_bodies() {
    check(what_is_joined_stays_joined, 0..120);
}

fn check(law: fn(u64) -> Result<(), String>, seeds: Range<u64>) {
    for seed in seeds {
        if let Err(error) = law(seed) {
            panic!("seed {seed}: {error}");
        }
    }
}
