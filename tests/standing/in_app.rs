//! The same in an app: kinds and anchors of the entities, and what is said of those that cannot break.

use bevy_app::prelude::*;
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use glam::Vec3;
use std::time::Duration;

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((TimePlugin, CleavePlugin::default()));
    let step = Duration::from_secs_f64(1.0 / 60.0);
    app.insert_resource(bevy_time::Time::<bevy_time::Fixed>::from_duration(step));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(step));
    app.finish();
    app.update();
    app
}

fn wall() -> ConvexMesh {
    ConvexMesh::cuboid(3.0, 2.0, 0.2).expect("valid size")
}

#[test]
fn pieces_are_entities_of_their_kind_and_keep_their_anchors() {
    let mut app = app();
    let world = app.world_mut();
    let shot = Fracturable {
        pattern: FracturePattern::Voronoi {
            cells: 20,
            focus: 0.5,
        },
        ..Fracturable::with_strength(50.0)
    };
    // Twice as large as its shape; anchored at both ends.
    let anchors = Anchors::none()
        .and_within(Vec3::new(-1.5, -1.0, -0.1), Vec3::new(-1.2, 1.0, 0.1))
        .and_within(Vec3::new(1.2, -1.0, -0.1), Vec3::new(1.5, 1.0, 0.1));
    let wall = world
        .spawn((
            RigidBody::Static,
            wall(),
            shot,
            anchors,
            Transform::from_xyz(0.0, 5.0, 0.0).with_scale(Vec3::splat(2.0)),
        ))
        .id();
    world.spawn((
        RigidBody::Dynamic,
        ConvexMesh::icosphere(0.2, 2).expect("valid"),
        Transform::from_xyz(0.0, 5.0, 3.0),
        LinearVelocity(-30.0 * Vec3::Z),
    ));
    (0..60).for_each(|_| app.update());
    let world = app.world_mut();
    assert!(world.get_entity(wall).is_err(), "it broke");
    let mut pieces = world
        .query_filtered::<(&RigidBody, &Transform, Has<Anchors>, &MassProperties), With<PieceOf>>();
    let (mut held, mut fallen, mut mass) = (0, 0, 0.0);
    for (kind, transform, has_anchors, properties) in pieces.iter(world) {
        assert_eq!(*kind == RigidBody::Static, has_anchors);
        mass += properties.mass;
        if *kind == RigidBody::Static {
            held += 1;
            assert!(
                transform.translation.x.abs() > 1.0,
                "{}",
                transform.translation
            );
        } else {
            // Some lie on what is held.
            fallen += usize::from(transform.translation.y < 4.0);
        }
    }
    assert!(held >= 2 && fallen >= 5, "{held} stay, {fallen} fall");
    assert!((mass - 9600.0).abs() < 1.0, "{mass} kg");
    assert!(world.query::<&BodyIssues>().iter(world).next().is_none());
}

#[test]
fn what_hung_on_a_post_becomes_dynamic_with_its_entity() {
    let mut app = app();
    let world = app.world_mut();
    world.spawn((RigidBody::Static, HalfSpaceShape { normal: Vec3::Y }));
    let block = |size: Vec3, y: f32| {
        (
            RigidBody::Static,
            ConvexMesh::cuboid(size.x, size.y, size.z).expect("valid"),
            Fracturable::with_strength(1e6),
            Transform::from_xyz(0.0, y, 0.0),
        )
    };
    let post = world.spawn(block(Vec3::new(0.3, 2.0, 0.3), 1.0)).id();
    let beam = world.spawn(block(Vec3::new(3.0, 0.3, 0.3), 2.15)).id();
    app.update();
    app.world_mut()
        .commands()
        .slice(post, Plane::through(Vec3::Y, Vec3::Y));
    (0..30).for_each(|_| app.update());
    let world = app.world();
    assert_eq!(world.get::<RigidBody>(beam), Some(&RigidBody::Dynamic));
    let handle = world.get::<BodyHandle>(beam).and_then(BodyHandle::get);
    let (slot, _) = handle.expect("it is a body");
    assert_eq!(world.resource::<Bodies>().kind(slot), RigidBody::Dynamic);
}

fn issue(app: &App, entity: Entity) -> String {
    let issues = app.world().get::<BodyIssues>(entity);
    let problems = issues.map(|issues| issues.iter().map(ToString::to_string).collect::<Vec<_>>());
    problems.unwrap_or_default().join("; ")
}

#[test]
fn what_cannot_break_says_so() {
    let mut app = app();
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    let open = TriMesh::new(positions, vec![[0, 1, 2]]).expect("a mesh");
    let hull = wall().hull().clone();
    let world = app.world_mut();
    let mut spawn = |shape: ConvexMesh, fracturable: Fracturable| {
        world
            .spawn((RigidBody::Static, shape, fracturable, Transform::default()))
            .id()
    };
    let hollow = spawn(
        ConvexMesh::from_parts(hull, Some(open)),
        Fracturable::default(),
    );
    let one_piece = spawn(
        wall(),
        Fracturable {
            max_pieces: 1,
            ..Default::default()
        },
    );
    let lone_cell = spawn(
        wall(),
        Fracturable {
            pattern: FracturePattern::Voronoi {
                cells: 1,
                focus: 0.0,
            },
            ..Default::default()
        },
    );
    let well = spawn(wall(), Fracturable::default());
    let floor = world
        .spawn((
            RigidBody::Static,
            HalfSpaceShape { normal: Vec3::Y },
            Fracturable::default(),
        ))
        .id();
    let loose = world
        .spawn((
            RigidBody::Dynamic,
            wall(),
            Anchors::touching(),
            Transform::default(),
        ))
        .id();
    app.update();
    app.update();
    for (entity, part) in [
        (hollow, "cannot be cut"),
        (one_piece, "no two pieces"),
        (lone_cell, "no two pieces"),
        (floor, "half-space"),
        (loose, "Dynamic"),
    ] {
        assert!(
            issue(&app, entity).contains(part),
            "{part}: {}",
            issue(&app, entity)
        );
    }
    assert_eq!(issue(&app, well), "");
    app.world_mut().entity_mut(loose).insert(RigidBody::Static);
    app.world_mut()
        .entity_mut(one_piece)
        .insert(Fracturable::default());
    app.update();
    app.update();
    assert_eq!(
        [loose, one_piece].map(|entity| issue(&app, entity)),
        [""; 2]
    );
}
