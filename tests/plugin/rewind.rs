//! What is taken back is what it was, and goes on as it did.

use crate::app::app_of;
use crate::common::dice::Dice;
use crate::common::states::bits;
use crate::random_world::{Deed, RandomWorld, story};
use crate::twins::texts;
use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::query::Allow;
use bevy_time::{Fixed, Time};
use bevy_transform::components::Transform;
use glam::Vec3;
use std::collections::BTreeMap;

fn rewinding_app() -> App {
    app_of((CleavePlugin::default(), RewindPlugin::default()))
}

/// What a body or a joint is, in words, by its name in the simulation.
type States = BTreeMap<(bool, u32), (String, Entity)>;

fn states(world: &mut World) -> States {
    let mut states = States::new();
    let mut handles = world.query_filtered::<(Entity, &BodyHandle), Allow<Disabled>>();
    let bodies = world.resource::<Bodies>();
    let current = handles.iter(world).filter_map(|(entity, handle)| {
        let (slot, id) = handle.get()?;
        let is_current = bodies.contains(slot) && bodies.id(slot) == id;
        is_current.then_some((entity, slot, id))
    });
    for (entity, slot, id) in current {
        let (linear, angular) = bodies.velocity(slot);
        let place = world.get::<Transform>(entity);
        let velocities = (
            world.get::<LinearVelocity>(entity),
            world.get::<AngularVelocity>(entity),
        );
        let text = format!(
            "{:?} active {} asleep {} marked {} {:?} {place:?} {velocities:?} mass {:?} damage {:?} of {} parent {:?} {:?}",
            bodies.kind(slot),
            bodies.is_active(slot),
            bodies.is_asleep(slot),
            world.get::<Sleeping>(entity).is_some(),
            bits(&bodies.pose(slot), linear, angular),
            bodies.mass(slot).mass,
            bodies.fatigue(slot).map(|it| it.damage),
            world.get::<PieceOf>(entity).is_some(),
            world.get::<ChildOf>(entity).is_some(),
            texts(world, entity),
        );
        states.insert((false, id.0), (text, entity));
    }
    let mut joints = world.query_filtered::<(Entity, &JointHandle, &JointLoad), Allow<Disabled>>();
    for (entity, handle, load) in joints.iter(world) {
        if let Some(id) = handle.get() {
            states.insert((true, id.0), (format!("{load:?}"), entity));
        }
    }
    states
}

/// The first that is not as it was.
fn difference(was: &States, is: &States, with_entities: bool) -> Option<String> {
    let names: Vec<_> = was.keys().chain(is.keys()).collect();
    let different = names
        .into_iter()
        .find(|name| match (was.get(name), is.get(name)) {
            (Some(a), Some(b)) => a.0 != b.0 || with_entities && a.1 != b.1,
            _ => true,
        })?;
    Some(format!(
        "{different:?}: {:?}\nnot {:?}",
        is.get(different),
        was.get(different)
    ))
}

/// Steps, and what came of each.
fn record(scene: &mut RandomWorld, steps: usize) -> Vec<States> {
    let step = |_| {
        scene.run(Deed::Frame(1));
        states(scene.app.world_mut())
    };
    (0..steps).map(step).collect()
}

fn rewind(app: &mut App, steps: u64) -> Rewound {
    let world = app.world_mut();
    world.resource_mut::<Messages<Rewound>>().clear();
    world.commands().rewind(steps);
    world.flush();
    let rewound = world.resource_mut::<Messages<Rewound>>().drain().next();
    rewound.expect("there are moments")
}

/// Settings are no part of what is taken back.
fn settings(world: &World) -> (Gravity, SolverConfig, f64) {
    let fixed = world.resource::<Time<Fixed>>();
    (
        *world.resource(),
        *world.resource(),
        fixed.timestep().as_secs_f64(),
    )
}

/// A story, of which the last steps are taken back, with what more was done in them, or without; whether nobody was lost.
pub(crate) fn check(seed: u64, does_more: bool) -> Result<bool, String> {
    let mut scene = RandomWorld::in_app(rewinding_app(), seed.is_multiple_of(3));
    scene.lay_floor();
    scene.clones = false;
    story(seed, 30).into_iter().for_each(|deed| scene.run(deed));
    let mut dice = Dice::new(seed);
    // What was done last is read in the first of these.
    record(&mut scene, 1);
    let past = record(&mut scene, 1 + dice.below(12));
    let before = settings(scene.app.world());
    let future = record(&mut scene, 1 + dice.below(12));
    let after = if does_more { 1 + dice.below(8) } else { 0 };
    let mut extra = 0;
    if does_more {
        let names = scene.names.clone();
        for deed in story(seed ^ 0xabcd, 6 + after) {
            extra += match deed {
                Deed::Frame(steps) => steps as usize,
                Deed::Act(_) => 0,
            };
            scene.run(deed);
        }
        scene.names = names;
    }
    let said = |text: String| format!("seed {seed}: {text}\n{:#?}", scene.said);
    let steps = future.len() + extra;
    let rewound = rewind(&mut scene.app, steps as u64);
    if rewound.steps != steps as u64 {
        return Err(said(format!(
            "{} steps back instead of {steps}",
            rewound.steps
        )));
    }
    let world = scene.app.world_mut();
    world.insert_resource(before.0);
    world.insert_resource(before.1);
    world
        .resource_mut::<Time<Fixed>>()
        .set_timestep_seconds(before.2);
    if !rewound.lost.is_empty() {
        // What the app took away changes all that follows.
        return Ok(false);
    }
    let was = past.last().expect("some steps");
    if let Some(text) = difference(was, &states(world), true) {
        return Err(said(format!("taken back {text}")));
    }
    for (step, was) in future.iter().enumerate() {
        scene.run(Deed::Frame(1));
        if let Some(text) = difference(was, &states(scene.app.world_mut()), false) {
            return Err(format!(
                "seed {seed}: step {step} {text}\n{:#?}",
                scene.said
            ));
        }
    }
    Ok(true)
}

#[test]
fn a_story_taken_back_goes_on_as_it_did() {
    for seed in 0..40 {
        assert!(check(seed, false).unwrap(), "nobody was despawned: {seed}");
    }
}

#[test]
fn whatever_was_done_since_is_undone() {
    let is_complete = |seed| check(seed, true).unwrap();
    let complete = (0..40).filter(|&seed| is_complete(seed)).count();
    assert!(complete > 20, "{complete}");
}

/// Something of the app's.
#[derive(Clone, Component, Debug, PartialEq)]
struct Health(u32);

#[test]
fn who_comes_back_and_who_does_not_is_told() {
    let mut app = rewinding_app();
    app.rewind_component::<Health>();
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a box");
    let body = |x: f32| {
        (
            RigidBody::Dynamic,
            cube.clone(),
            Transform::from_xyz(x, 0.0, 0.0),
        )
    };
    let world = app.world_mut();
    let lamp = world.spawn(Health(7)).id();
    let vase = world
        .spawn((body(0.0), Health(3), children![Health(1)]))
        .id();
    let bullet = world.spawn(body(9.0)).id();
    let hinge = world.commands().join(None, vase, Joint::ball());
    (0..3).for_each(|_| app.update());

    let world = app.world_mut();
    world
        .commands()
        .slice(vase, Plane::through(Vec3::ZERO, Vec3::X));
    world.despawn(bullet);
    for mut health in world.query::<&mut Health>().iter_mut(world) {
        health.0 += 10;
    }
    let ball = world.spawn(body(5.0)).id();
    (0..2).for_each(|_| app.update());
    let world = app.world_mut();
    assert!(world.query::<(&RigidBody, &PieceOf)>().iter(world).count() == 2);
    assert!(world.get::<Disabled>(vase).is_some(), "set aside");

    let rewound = rewind(&mut app, 2);
    assert_eq!((rewound.returned, rewound.lost), (vec![vase], vec![bullet]));
    assert!(rewound.removed.contains(&ball) && rewound.removed.len() == 3);
    let world = app.world_mut();
    let mut health = world.query::<(Entity, &Health)>();
    let mut health: Vec<_> = health.iter(world).map(|(_, it)| it.0).collect();
    health.sort_unstable();
    assert_eq!(health, [1, 3, 7]);
    assert_eq!(world.get::<Health>(lamp), Some(&Health(7)));
    assert!(world.get::<Disabled>(vase).is_none());
    assert_eq!(world.get::<JointB>(hinge), Some(&JointB(vase)));
    assert_eq!(world.query::<&RigidBody>().iter(world).count(), 1);
    app.update();
    assert_eq!(
        app.world().resource::<Bodies>().len(),
        1,
        "the bullet's is gone"
    );
    assert_eq!(app.world().resource::<Joints>().len(), 1);

    // What can not come back any more goes.
    let world = app.world_mut();
    world
        .commands()
        .slice(vase, Plane::through(Vec3::ZERO, Vec3::X));
    app.update();
    app.world_mut().resource_mut::<PhysicsHistory>().clear();
    app.update();
    assert!(app.world().get_entity(vase).is_err());
}
