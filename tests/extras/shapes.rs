//! Shapes that wait for meshes, one by one and for a whole scene.

use crate::{all_with, mesh_app};
use bevy_app::App;
use bevy_asset::{Assets, Handle, RenderAssetUsages};
use bevy_cleave::geometry::primitives;
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_mesh::{Mesh, Mesh3d, PrimitiveTopology};
use bevy_transform::components::Transform;

fn ball() -> Mesh {
    Mesh::from(&primitives::icosphere(0.5, 2).expect("a ball").to_mesh())
}

fn reserve(app: &App) -> Handle<Mesh> {
    app.world().resource::<Assets<Mesh>>().reserve_handle()
}

fn load(app: &mut App, handle: &Handle<Mesh>, mesh: Mesh) {
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    meshes.insert(handle.id(), mesh).expect("a place");
}

#[test]
fn a_shape_waits_until_its_mesh_is_loaded() {
    for wish in [ShapeFromMesh::Hull, ShapeFromMesh::HullWithVisual] {
        let mut app = mesh_app();
        let handle = reserve(&app);
        let body = (RigidBody::Dynamic, wish, Mesh3d(handle.clone()));
        let body = app.world_mut().spawn(body).id();
        (0..5).for_each(|_| app.update());
        assert!(!app.world().entity(body).contains::<ConvexMesh>());
        load(&mut app, &handle, ball());
        (0..3).for_each(|_| app.update());
        let entity = app.world().entity(body);
        let shape = entity.get::<ConvexMesh>().expect("the mesh is there");
        assert!(!entity.contains::<ShapeFromMesh>());
        assert_eq!(
            shape.visual().is_some(),
            wish == ShapeFromMesh::HullWithVisual
        );
        let volume = shape.hull().volume();
        assert!((0.4..0.53).contains(&volume), "{volume}");
        assert!(
            entity.get::<Transform>().expect("a body").translation.y < 0.0,
            "it falls"
        );
    }
}

#[test]
fn what_is_no_shape_is_said_on_the_entity() {
    let mut app = mesh_app();
    let lines = Mesh::new(PrimitiveTopology::LineList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0_f32; 3]; 4]);
    let flat = Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(
        Mesh::ATTRIBUTE_POSITION,
        vec![[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    );
    for mesh in [lines, flat] {
        let handle = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
        for wish in [ShapeFromMesh::Hull, ShapeFromMesh::HullWithVisual] {
            let body = (RigidBody::Dynamic, wish, Mesh3d(handle.clone()));
            let body = app.world_mut().spawn(body).id();
            (0..2).for_each(|_| app.update());
            let entity = app.world().entity(body);
            assert!(entity.contains::<ShapeRefused>());
            assert!(!entity.contains::<ConvexMesh>());
            // Mended by another mesh.
            let good = app.world_mut().resource_mut::<Assets<Mesh>>().add(ball());
            app.world_mut()
                .entity_mut(body)
                .insert((Mesh3d(good), wish));
            (0..2).for_each(|_| app.update());
            let entity = app.world().entity(body);
            assert!(!entity.contains::<ShapeRefused>());
            assert!(entity.contains::<ConvexMesh>());
        }
    }
}

#[test]
fn a_scene_that_is_loaded_late_becomes_bodies() {
    let mut app = mesh_app();
    let handle = app.world_mut().resource_mut::<Assets<Mesh>>().add(ball());
    let ask = ShapesOfScene {
        body: RigidBody::Static,
        shape: ShapeFromMesh::Static {
            is_two_sided: false,
        },
    };
    let early = app.world_mut().spawn(Transform::default()).id();
    let is_there = Mesh3d(handle.clone());
    app.world_mut().spawn((is_there.clone(), ChildOf(early)));
    app.world_mut().entity_mut(early).insert(ask);
    app.update();
    // Deeper down, and later.
    let node = (Transform::from_xyz(0.0, 5.0, 0.0), ChildOf(early));
    let node = app.world_mut().spawn(node).id();
    app.world_mut().spawn((is_there.clone(), ChildOf(node)));
    // Not of the scene, and with a body of its own.
    app.world_mut().spawn(is_there.clone());
    let own = (
        RigidBody::Kinematic,
        ShapeFromMesh::Hull,
        is_there,
        ChildOf(node),
    );
    let own = app.world_mut().spawn(own).id();
    (0..3).for_each(|_| app.update());
    assert_eq!(all_with::<StaticMesh>(&mut app).len(), 2);
    assert_eq!(all_with::<ConvexMesh>(&mut app), [own]);
    assert_eq!(app.world().resource::<Bodies>().len(), 3);
}

#[test]
fn a_ball_rests_on_a_level_that_is_loaded() {
    let mut app = mesh_app();
    let ground = primitives::cuboid(8.0, 1.0, 8.0).expect("a box").to_mesh();
    let handle = app
        .world_mut()
        .resource_mut::<Assets<Mesh>>()
        .add(Mesh::from(&ground));
    let wish = ShapeFromMesh::Static { is_two_sided: true };
    app.world_mut()
        .spawn((RigidBody::Static, wish, Mesh3d(handle)));
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a box");
    let at = Transform::from_translation(1.05 * Vec3::Y);
    let cube = app.world_mut().spawn((RigidBody::Dynamic, cube, at)).id();
    (0..60).for_each(|_| app.update());
    let at = app
        .world()
        .get::<Transform>(cube)
        .expect("a body")
        .translation;
    assert!((at.y - 1.0).abs() < 0.02, "{at}");
}
