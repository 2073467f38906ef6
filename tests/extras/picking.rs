//! Bodies under the pointer.

use crate::app;
use bevy_app::PreUpdate;
use bevy_camera::Camera;
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_math::{Dir3, Vec3};
use bevy_picking::Pickable;
use bevy_picking::backend::PointerHits;
use bevy_picking::backend::ray::{RayId, RayMap};
use bevy_picking::pointer::PointerId;
use bevy_shape::Ray3d;
use bevy_transform::components::Transform;

/// Hits of a ray along -z at cubes that stand one behind the other at z = 0, -3, -6, the first two with what they have.
fn hits(first: Option<Pickable>, second: Option<Pickable>) -> Vec<(usize, f32)> {
    let mut app = app();
    app.add_plugins(CleavePickingPlugin)
        .add_message::<PointerHits>()
        .init_resource::<RayMap>();
    app.finish();
    app.cleanup();
    let cubes = [first, second, None];
    let cubes: Vec<Entity> = (0..)
        .zip(cubes)
        .map(|(i, pickable)| {
            let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a box");
            let at = Transform::from_xyz(0.0, 0.0, -3.0 * i as f32);
            let mut cube = app.world_mut().spawn((RigidBody::Static, cube, at));
            if let Some(pickable) = pickable {
                cube.insert(pickable);
            }
            cube.id()
        })
        .collect();
    let camera = app.world_mut().spawn(Camera::default()).id();
    (0..3).for_each(|_| app.update());
    let ray = Ray3d::new(5.0 * Vec3::Z, Dir3::NEG_Z);
    let id = RayId::new(camera, PointerId::Mouse);
    app.world_mut().resource_mut::<RayMap>().map.insert(id, ray);
    app.world_mut().run_schedule(PreUpdate);
    let mut messages = app.world_mut().resource_mut::<Messages<PointerHits>>();
    let mut found = Vec::new();
    for message in messages.drain() {
        for (entity, hit) in message.picks {
            assert_eq!(hit.camera, camera);
            assert_eq!(hit.normal, Some(Vec3::Z));
            let number = cubes.iter().position(|&cube| cube == entity);
            found.push((number.expect("one of the cubes"), hit.depth));
        }
    }
    found
}

#[test]
fn the_nearest_body_hides_the_others_unless_it_says_not() {
    let through = Pickable {
        should_block_lower: false,
        is_hoverable: true,
    };
    assert_eq!(hits(None, None), [(0, 4.5)]);
    assert_eq!(hits(Some(Pickable::IGNORE), None), [(1, 7.5)]);
    assert_eq!(hits(Some(through), None), [(0, 4.5), (1, 7.5)]);
    assert_eq!(
        hits(Some(through), Some(through)),
        [(0, 4.5), (1, 7.5), (2, 10.5)]
    );
    assert_eq!(
        hits(Some(Pickable::IGNORE), Some(Pickable::IGNORE)),
        [(2, 10.5)]
    );
}
