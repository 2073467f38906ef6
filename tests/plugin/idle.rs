//! What does nothing says so on its entity, as long as it does nothing, in whatever order things come and go.

use crate::app::app;
use bevy_app::{App, Plugin};
use bevy_cleave::prelude::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_transform::components::Transform;

fn cube() -> ConvexMesh {
    bevy_cleave::cuboid!(1.0, 1.0, 1.0)
}

fn level() -> StaticMesh {
    StaticMesh::from_heights(&[0.0; 4], 2, 1.0).expect("a grid")
}

fn halves(strength: Option<f32>) -> Compound {
    let half = |x: f32| (Pose::from_position(x * Vec3::X), cube());
    let halves = Compound::new([-0.5, 0.5].map(half)).expect("usable");
    match strength {
        Some(strength) => halves.bonded(strength).expect("they touch"),
        None => halves,
    }
}

fn tough() -> Fracturable {
    Fracturable::with_strength(1e9)
}

fn weightless() -> App {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    app
}

fn issues(app: &App, entity: Entity) -> Vec<BodyProblem> {
    let issues = app.world().get::<BodyIssues>(entity);
    issues.map_or(vec![], |issues| issues.iter().cloned().collect())
}

fn steps(app: &mut App) {
    (0..3).for_each(|_| app.update());
}

/// Something of a body: how it is given to an entity, and taken away.
type Part = (fn(&mut EntityWorldMut), fn(&mut EntityWorldMut));

macro_rules! parts {
    ($($type:ty: $value:expr,)*) => {
        vec![$((
            |entity| { entity.insert($value); },
            |entity| { entity.remove_with_requires::<$type>(); },
        )),*]
    };
}

/// All that a body may be made of and that does nothing without one.
fn parts() -> Vec<Part> {
    parts! {
        ConvexMesh: cube(),
        Compound: halves(None),
        HalfSpaceShape: HalfSpaceShape { normal: Vec3::Y },
        StaticMesh: level(),
        Fracturable: tough(),
        Anchors: Anchors::none(),
        Fatigue: Fatigue::new(1.0),
        SurfaceMaterials: SurfaceMaterials::default(),
        Sensor: Sensor,
        CollisionEvents: CollisionEvents,
        ContactForceEvents: ContactForceEvents { threshold: 1.0 },
        Mass: Mass(1.0),
        MassOverride: MassOverride(MassProperties::default()),
        GravityScale: GravityScale(0.5),
        ConstantForce: ConstantForce(Vec3::X),
        ConstantTorque: ConstantTorque(Vec3::X),
        LinearDamping: LinearDamping(0.1),
        AngularDamping: AngularDamping(0.1),
        MaxSpeed: MaxSpeed::default(),
        LockedAxes: LockedAxes::ROTATION,
        SurfaceVelocity: SurfaceVelocity(Vec3::X),
    }
}

// Only shapes were looked at, only when they came, and not when a body was no more.
#[test]
fn what_makes_a_body_is_an_issue_where_there_is_none() {
    for (number, (give, take)) in parts().into_iter().enumerate() {
        let mut app = weightless();
        let mut alone = app.world_mut().spawn_empty();
        give(&mut alone);
        let alone = alone.id();
        let mut left = app.world_mut().spawn((RigidBody::Static, cube()));
        give(&mut left);
        let left = left.id();
        steps(&mut app);
        app.world_mut().entity_mut(left).remove::<RigidBody>();
        steps(&mut app);
        for entity in [alone, left] {
            let idle = [BodyProblem::Body(BodyError::NoRigidBody)];
            assert_eq!(issues(&app, entity), idle, "part {number}");
        }
        take(&mut app.world_mut().entity_mut(alone));
        let mut left = app.world_mut().entity_mut(left);
        take(&mut left);
        left.remove::<ConvexMesh>();
        let left = left.id();
        steps(&mut app);
        for entity in [alone, left] {
            assert_eq!(issues(&app, entity), [], "part {number}");
        }
        // A body that comes later is one.
        give(&mut app.world_mut().entity_mut(alone));
        steps(&mut app);
        app.world_mut()
            .entity_mut(alone)
            .insert((RigidBody::Static, cube()));
        steps(&mut app);
        let idle = BodyProblem::Body(BodyError::NoRigidBody);
        assert!(!issues(&app, alone).contains(&idle), "part {number}");
    }
}

#[test]
fn parts_of_a_compound_and_what_is_despawned_are_no_issues() {
    let mut app = weightless();
    let table = (RigidBody::Dynamic, CompoundOfChildren, children![cube()]);
    let table = app.world_mut().spawn(table).id();
    let gone = app
        .world_mut()
        .spawn((RigidBody::Static, cube(), tough()))
        .id();
    steps(&mut app);
    app.world_mut().entity_mut(gone).despawn();
    steps(&mut app);
    let mut all = app.world_mut().query::<&BodyIssues>();
    assert_eq!(all.iter(app.world()).count(), 0);
    assert!(app.world().get::<Compound>(table).is_some());
}

// A sensor among the parts of a compound was solid, a shape of another kind was not there, and neither said so.
#[test]
fn what_a_part_of_a_compound_has_no_use_for_is_an_issue() {
    for (number, (give, take)) in parts().into_iter().enumerate() {
        let mut app = weightless();
        let mut part = app.world_mut().spawn(Transform::default());
        give(&mut part);
        let part = part.id();
        let table = (RigidBody::Dynamic, CompoundOfChildren, children![cube()]);
        let table = app.world_mut().spawn(table).add_child(part).id();
        steps(&mut app);
        let is_shape = number == 0;
        let idle = [BodyProblem::Body(BodyError::IdlePart)];
        let expected = &idle[..usize::from(!is_shape)];
        assert_eq!(issues(&app, part), expected, "part {number}");
        assert_eq!(issues(&app, table), [], "part {number}");
        take(&mut app.world_mut().entity_mut(part));
        steps(&mut app);
        assert_eq!(issues(&app, part), [], "part {number}");
    }
}

// What a body leaves behind when it is none any more says nothing.
#[test]
fn materials_that_are_chosen_for_a_part_of_a_compound_are_an_issue() {
    let idle = [BodyProblem::Body(BodyError::IdlePart)];
    let choices: Vec<Part> = parts! {
        Density: Density(500.0),
        Friction: Friction::new(0.9),
        Restitution: Restitution::new(0.3),
        CollisionLayers: CollisionLayers::new(2, 2),
    };
    for (number, (give, _)) in choices.into_iter().enumerate() {
        let mut app = weightless();
        let former = app.world_mut().spawn((RigidBody::Dynamic, cube())).id();
        steps(&mut app);
        app.world_mut().entity_mut(former).remove::<RigidBody>();
        let table = (RigidBody::Dynamic, CompoundOfChildren, children![cube()]);
        let table = app.world_mut().spawn(table).add_child(former).id();
        steps(&mut app);
        assert_eq!(issues(&app, former), [], "material {number}");
        give(&mut app.world_mut().entity_mut(former));
        steps(&mut app);
        assert_eq!(issues(&app, former), idle, "material {number}");
        assert_eq!(issues(&app, table), [], "material {number}");
        app.world_mut().entity_mut(table).insert(Disabled);
        steps(&mut app);
        assert_eq!(issues(&app, former), [], "material {number}");
        app.world_mut().entity_mut(table).remove::<Disabled>();
        steps(&mut app);
        assert_eq!(issues(&app, former), idle, "material {number}");
        app.world_mut()
            .entity_mut(table)
            .remove::<CompoundOfChildren>();
        steps(&mut app);
        let lone = [BodyProblem::Body(BodyError::NoRigidBody)];
        assert_eq!(issues(&app, former), lone, "material {number}");
    }
}

// Only what came or went with the part itself was looked at.
#[test]
fn what_is_no_part_any_more_is_an_issue() {
    let idle = [BodyProblem::Body(BodyError::NoRigidBody)];
    let mut app = weightless();
    let at = |x: f32| Transform::from_xyz(x, 0.0, 0.0);
    let node = (at(2.0), children![(cube(), at(1.0))]);
    let table = (RigidBody::Dynamic, CompoundOfChildren, at(0.0));
    let table = app
        .world_mut()
        .spawn((table, children![cube(), (cube(), at(1.0)), node]))
        .id();
    steps(&mut app);
    let below = |app: &App, entity: Entity| {
        let children = app.world().get::<Children>(entity).expect("children");
        children.to_vec()
    };
    let parts = below(&app, table);
    let leaf = below(&app, parts[2])[0];
    for part in [parts[0], parts[1], leaf] {
        assert_eq!(issues(&app, part), []);
    }
    // Alone, or with what is above it.
    for (moved, part) in [(parts[1], parts[1]), (parts[2], leaf)] {
        app.world_mut().entity_mut(moved).remove::<ChildOf>();
        steps(&mut app);
        assert_eq!(issues(&app, part), idle);
        assert_eq!(issues(&app, table), []);
        app.world_mut().entity_mut(table).add_child(moved);
        steps(&mut app);
        assert_eq!(issues(&app, part), []);
    }
    // Beneath a body that has a shape of its own.
    let block = app.world_mut().spawn((RigidBody::Static, cube())).id();
    app.world_mut().entity_mut(table).add_child(block);
    app.world_mut().entity_mut(block).add_child(parts[1]);
    steps(&mut app);
    assert_eq!(issues(&app, parts[1]), idle);
    // All at once.
    app.world_mut()
        .entity_mut(table)
        .remove::<CompoundOfChildren>();
    steps(&mut app);
    for part in [parts[0], leaf] {
        assert_eq!(issues(&app, part), idle);
    }
    // What makes a compound and is no body says so too.
    let mut lone = app.world_mut().spawn((CompoundOfChildren, at(9.0)));
    let lone = lone.add_child(parts[0]).id();
    steps(&mut app);
    assert_eq!(issues(&app, lone), idle);
    assert_eq!(issues(&app, parts[0]), []);
}

#[test]
fn what_pushes_a_body_that_forces_do_not_move_is_an_issue_and_what_bounds_it_is_none() {
    let pushes: Vec<Part> = parts! {
        ConstantForce: ConstantForce(Vec3::X),
        ConstantTorque: ConstantTorque(Vec3::X),
    };
    let harmless: Vec<Part> = parts! {
        ConstantForce: ConstantForce::default(),
        ConstantTorque: ConstantTorque::default(),
        GravityScale: GravityScale(0.5),
        LinearDamping: LinearDamping(0.1),
        AngularDamping: AngularDamping(0.1),
        MaxSpeed: MaxSpeed { linear: 1.0, angular: 1.0 },
        LockedAxes: LockedAxes::ROTATION,
        SurfaceVelocity: SurfaceVelocity(Vec3::X),
        Mass: Mass(3.0),
    };
    let all = pushes.into_iter().map(|part| (part, true));
    let all = all.chain(harmless.into_iter().map(|part| (part, false)));
    for (number, ((give, take), is_push)) in all.enumerate() {
        for kind in [RigidBody::Static, RigidBody::Kinematic] {
            let idle = [BodyProblem::Body(BodyError::IdleForce)];
            let expected = |is_idle: bool| &idle[..usize::from(is_idle)];
            let mut app = weightless();
            let mut body = app.world_mut().spawn((kind, cube()));
            give(&mut body);
            let body = body.id();
            steps(&mut app);
            assert_eq!(issues(&app, body), expected(is_push), "{number} {kind:?}");
            let at = app.world().get::<Transform>(body).copied();
            assert_eq!(at, Some(Transform::default()), "{number} {kind:?}");
            app.world_mut().entity_mut(body).insert(RigidBody::Dynamic);
            steps(&mut app);
            assert_eq!(issues(&app, body), [], "{number} {kind:?}");
            app.world_mut().entity_mut(body).insert(kind);
            steps(&mut app);
            assert_eq!(issues(&app, body), expected(is_push), "{number} {kind:?}");
            take(&mut app.world_mut().entity_mut(body));
            steps(&mut app);
            // It may have kept a velocity from when it was dynamic.
            let issues = issues(&app, body);
            assert!(!issues.contains(&idle[0]), "{number} {kind:?}");
        }
    }
}

/// A body that something is wrong with, and what mends that.
type Spoiled = (fn(&mut World) -> Entity, fn(&mut EntityWorldMut));

fn spoiled() -> Vec<Spoiled> {
    use RigidBody::{Dynamic, Kinematic, Static};
    vec![
        // Another component comes.
        (
            |world| world.spawn((Dynamic, cube(), Fatigue::new(1.0))).id(),
            |entity| {
                entity.insert(tough());
            },
        ),
        (
            |world| world.spawn((Dynamic, halves(None), Fatigue::new(1.0))).id(),
            |entity| {
                entity.insert(halves(Some(1e6)));
            },
        ),
        (
            |world| {
                world
                    .spawn((Dynamic, cube(), tough(), Anchors::none()))
                    .id()
            },
            |entity| {
                entity.insert(Static);
            },
        ),
        (
            |world| world.spawn((Static, cube(), LinearVelocity(Vec3::X))).id(),
            |entity| {
                entity.insert(Kinematic);
            },
        ),
        // One goes.
        (
            |world| world.spawn((Static, cube(), Sensor, tough())).id(),
            |entity| {
                entity.remove::<Sensor>();
            },
        ),
        (
            |world| world.spawn((Static, cube(), level())).id(),
            |entity| {
                entity.remove::<StaticMesh>();
            },
        ),
        (
            |world| {
                let shape = ShapeConstructor::Cuboid { size: Vec3::ZERO };
                world.spawn((Static, cube(), shape)).id()
            },
            |entity| {
                entity.remove::<ShapeConstructor>();
            },
        ),
        (
            |world| world.spawn((Dynamic, cube(), GravityScale(f32::NAN))).id(),
            |entity| {
                entity.remove::<GravityScale>();
            },
        ),
        (
            |world| world.spawn((Dynamic, cube(), Density(-1.0))).id(),
            |entity| {
                entity.remove::<(RigidBody, ConvexMesh)>();
            },
        ),
    ]
}

// Whether a body wears out was asked only when `Fatigue` came, and what no description says any more stayed.
#[test]
fn what_another_component_mends_is_no_issue_any_more() {
    for (number, (spawn, mend)) in spoiled().into_iter().enumerate() {
        let mut app = weightless();
        let entity = spawn(app.world_mut());
        steps(&mut app);
        assert_eq!(issues(&app, entity).len(), 1, "case {number}");
        mend(&mut app.world_mut().entity_mut(entity));
        steps(&mut app);
        assert_eq!(issues(&app, entity), [], "case {number}");
    }
}

/// Walkers that do not walk, and why.
fn walkers(world: &mut World) -> Vec<(Entity, WalkerError)> {
    use RigidBody::{Dynamic, Kinematic, Static};
    let walker = Walker::default();
    let lost = Walker {
        velocity: Vec3::NAN,
        ..walker
    };
    let leaps = Walker {
        jump: f32::INFINITY,
        ..walker
    };
    let mut sinks = walker;
    sinks.settings.step_height = -1.0;
    let at = |x: f32| Transform::from_xyz(5.0 * x, 0.0, 0.0);
    let parent = world.spawn(Transform::default()).id();
    vec![
        (world.spawn(walker).id(), WalkerError::NotKinematic),
        (
            world.spawn((Dynamic, cube(), at(1.0), walker)).id(),
            WalkerError::NotKinematic,
        ),
        (
            world.spawn((Static, cube(), at(2.0), walker)).id(),
            WalkerError::NotKinematic,
        ),
        (
            world.spawn((Kinematic, level(), at(3.0), walker)).id(),
            WalkerError::Shape,
        ),
        (
            world
                .spawn((Kinematic, cube(), at(4.0), walker, ChildOf(parent)))
                .id(),
            WalkerError::Child,
        ),
        (
            world.spawn((Kinematic, cube(), at(5.0), lost)).id(),
            WalkerError::NotFinite,
        ),
        (
            world.spawn((Kinematic, cube(), at(6.0), leaps)).id(),
            WalkerError::NotFinite,
        ),
        (
            world.spawn((Kinematic, cube(), at(7.0), sinks)).id(),
            WalkerError::Settings,
        ),
    ]
}

// They stood still and said nothing; one that was told to walk to NaN was lost for good.
#[test]
fn walkers_that_cannot_walk_say_why_until_they_can() {
    let mut app = weightless();
    WalkerPlugin.build(&mut app);
    let walkers = walkers(app.world_mut());
    steps(&mut app);
    for &(entity, error) in &walkers {
        assert!(
            issues(&app, entity).contains(&BodyProblem::Walker(error)),
            "{error}"
        );
    }
    for &(entity, _) in &walkers {
        let mut entity = app.world_mut().entity_mut(entity);
        entity.remove::<(StaticMesh, ChildOf)>();
        let ahead = Walker {
            velocity: Vec3::Z,
            ..Walker::default()
        };
        entity.insert((RigidBody::Kinematic, cube(), ahead));
    }
    (0..60).for_each(|_| app.update());
    for &(entity, error) in &walkers {
        assert_eq!(issues(&app, entity), [], "{error}");
        let place = app.world().get::<Transform>(entity);
        assert!(
            place.is_some_and(|at| at.translation.z > 0.1),
            "{error}: {place:?}"
        );
    }
}

#[test]
fn a_walker_in_an_app_without_their_plugin_is_an_issue() {
    let mut app = weightless();
    let walker = app
        .world_mut()
        .spawn((RigidBody::Kinematic, cube(), Walker::default()))
        .id();
    steps(&mut app);
    let nobody = BodyProblem::Walker(WalkerError::NoPlugin);
    assert_eq!(issues(&app, walker), [nobody]);
    WalkerPlugin.build(&mut app);
    steps(&mut app);
    assert_eq!(issues(&app, walker), []);
}
