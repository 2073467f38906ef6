//! Questions are asked by entity, in systems, and an app that asks none keeps no index.

use crate::app::stepping_app;
use bevy_app::{App, Update};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::Vec3;

#[derive(Resource, Default)]
struct Seen(Vec<Option<Entity>>);

fn look(spatial: SpatialQuery, mut seen: ResMut<Seen>) {
    let ray = Ray::new(10.0 * Vec3::Y, Vec3::NEG_Y, 20.0).expect("usable");
    let all = QueryFilter::all();
    let first = spatial.cast_ray(&ray, &all).map(|hit| hit.body);
    assert_eq!(spatial.is_ray_blocked(&ray, &all), first.is_some());
    let behind = spatial.cast_ray_all(&ray, &all);
    assert_eq!(behind.first().map(|hit| hit.body), first);
    if let Some(first) = first {
        let but_first = [first];
        let second = spatial.cast_ray(&ray, &QueryFilter::all().excluding(&but_first));
        assert_eq!(second, behind.get(1).copied());
        let near = spatial
            .closest_point(behind[0].point, 0.1, &all)
            .expect("usable");
        assert_eq!(near.map(|hit| hit.body), Some(first));
    }
    seen.0.push(first);
}

fn app() -> App {
    let mut app = stepping_app();
    app.init_resource::<Seen>();
    app
}

#[test]
fn systems_ask_by_entity() {
    let mut app = app();
    app.add_systems(Update, look);
    let world = app.world_mut();
    let floor = HalfSpaceShape { normal: Vec3::Y };
    let floor = world.spawn((RigidBody::Static, floor)).id();
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid");
    let above = Transform::from_xyz(0.0, 2.0, 0.0);
    let cube = world.spawn((RigidBody::Dynamic, cube, above)).id();
    (0..20).for_each(|_| app.update());
    app.world_mut().despawn(cube);
    (0..3).for_each(|_| app.update());
    let seen = &app.world().resource::<Seen>().0;
    assert_eq!(seen[2..20], [Some(cube); 18]);
    assert_eq!(seen[22..], [Some(floor)]);
}

#[test]
fn an_app_that_asks_nothing_keeps_no_index() {
    let mut app = app();
    app.update();
    assert!(!app.world().contains_resource::<QueryIndex>());
    app.add_systems(Update, look);
    app.update();
    assert!(app.world().contains_resource::<QueryIndex>());
}
