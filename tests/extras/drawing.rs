//! `Mesh3d` in step with the shapes of bodies and pieces.

use crate::{all_with, app, mesh_app};
use bevy_app::App;
use bevy_asset::Assets;
use bevy_cleave::geometry::primitives;
use bevy_cleave::prelude::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::query::Allow;
use bevy_math::Vec3;
use bevy_mesh::{Mesh, Mesh3d};
use bevy_transform::components::Transform;

/// In place of a material, which needs a renderer.
#[derive(Clone, Component, Debug, PartialEq)]
struct Paint(&'static str);

const CUT: u16 = 1;

fn spawn_body(app: &mut App, draw: DrawShape) -> Entity {
    let hull = primitives::cuboid(1.0, 1.0, 1.0).expect("a box");
    let visual = hull.to_mesh();
    let slots = vec![0; visual.triangles().len()];
    let shape = ConvexMesh::from_parts(hull, visual.with_materials(slots).ok());
    let fracturable = Fracturable {
        cut_material: Some(CUT),
        ..Fracturable::default()
    };
    let body = (
        RigidBody::Dynamic,
        shape,
        fracturable,
        Paint("outside"),
        draw,
    );
    app.world_mut().spawn(body).id()
}

fn drawn(app: &App, entity: Entity) -> TriMesh {
    let handle = app.world().get::<Mesh3d>(entity).expect("it is drawn");
    let meshes = app.world().resource::<Assets<Mesh>>();
    TriMesh::try_from(meshes.get(&handle.0).expect("the mesh is there")).expect("readable")
}

/// Of the tetrahedra between the origin and the triangles: those of the parts of a closed surface add up.
fn swept_volume(mesh: &TriMesh) -> f64 {
    let corners = mesh.triangles().iter();
    let corners = corners.map(|t| t.map(|v| mesh.positions()[v as usize].as_dvec3()));
    corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

/// Children that draw slots.
fn slots_of(app: &App, entity: Entity) -> Vec<Entity> {
    let world = app.world();
    let children = world.get::<Children>(entity).into_iter().flatten();
    let slots = children.filter(|&&child| world.entity(child).contains::<SlotMesh>());
    slots.copied().collect()
}

#[test]
fn pieces_of_pieces_are_drawn_whole_and_inside_out() {
    let mut app = mesh_app();
    let draw = DrawShape::new().with_slot(CUT, Paint("inside"));
    let body = spawn_body(&mut app, draw);
    app.update();
    assert_eq!(drawn(&app, body).triangles().len(), 12);
    assert!(slots_of(&app, body).is_empty());
    for (round, normal) in [Vec3::X, Vec3::new(0.3, 1.0, 0.2), Vec3::Z]
        .into_iter()
        .enumerate()
    {
        for body in all_with::<RigidBody>(&mut app) {
            // Through where it is now, for all fall.
            let at = app
                .world()
                .get::<bevy_transform::components::Transform>(body);
            let at = at.expect("a body").translation;
            let plane = Plane::through(at, normal);
            app.world_mut().commands().slice(body, plane);
        }
        app.update();
        let pieces = all_with::<RigidBody>(&mut app);
        assert_eq!(pieces.len(), 2 << round);
        for piece in pieces {
            let shape = app
                .world()
                .get::<ConvexMesh>(piece)
                .expect("a body")
                .clone();
            let slots = slots_of(&app, piece);
            assert_eq!(slots.len(), 1, "one child for all cut faces");
            assert_eq!(app.world().get::<Paint>(piece), Some(&Paint("outside")));
            assert_eq!(app.world().get::<Paint>(slots[0]), Some(&Paint("inside")));
            let parts = [piece, slots[0]].map(|entity| drawn(&app, entity));
            let of_piece = parts.iter().map(swept_volume).sum::<f64>();
            let volume = swept_volume(&shape.render_mesh());
            assert!(
                (of_piece - volume).abs() < 1e-5 * volume,
                "{of_piece} of {volume}"
            );
        }
        assert_eq!(
            all_with::<SlotMesh>(&mut app).len(),
            2 << round,
            "none is left over"
        );
    }
}

#[test]
fn what_is_whole_again_is_drawn_as_it_was() {
    let mut app = app();
    app.add_plugins((CleaveMeshPlugin, RewindPlugin::default()));
    app.finish();
    app.cleanup();
    let draw = DrawShape::new().with_slot(CUT, Paint("inside"));
    let body = spawn_body(&mut app, draw);
    (0..3).for_each(|_| app.update());
    for normal in [Vec3::X, Vec3::Z] {
        for piece in all_with::<RigidBody>(&mut app) {
            let at = app
                .world()
                .get::<Transform>(piece)
                .expect("a body")
                .translation;
            let plane = Plane::through(at, normal);
            app.world_mut().commands().slice(piece, plane);
        }
        app.update();
    }
    assert_eq!(all_with::<RigidBody>(&mut app).len(), 4);
    assert_eq!(
        all_with::<Mesh3d>(&mut app).len(),
        8,
        "each has a child for cut faces"
    );
    app.world_mut().commands().rewind(3);
    app.update();
    assert_eq!(all_with::<RigidBody>(&mut app), [body]);
    assert_eq!(all_with::<Mesh3d>(&mut app), [body]);
    assert_eq!(app.world().get::<Paint>(body), Some(&Paint("outside")));
    assert!((swept_volume(&drawn(&app, body)) - 1.0).abs() < 1e-6);
}

#[test]
fn without_looks_of_slots_all_is_on_the_entity() {
    let mut app = mesh_app();
    let body = spawn_body(&mut app, DrawShape::new());
    app.update();
    let plane = Plane::through(Vec3::ZERO, Vec3::X);
    app.world_mut().commands().slice(body, plane);
    app.update();
    let pieces = all_with::<RigidBody>(&mut app);
    assert_eq!(pieces.len(), 2);
    for piece in pieces {
        drawn(&app, piece).check_closed().expect("closed");
    }
}

#[test]
fn tangents_are_made_anew_where_there_were_some() {
    let mut app = mesh_app();
    let body = spawn_body(&mut app, DrawShape::new());
    let textured = primitives::cuboid(1.0, 1.0, 1.0).expect("a box").to_mesh();
    let uvs = textured.positions().iter().map(|p| p.truncate()).collect();
    let textured = textured.with_uvs(uvs).expect("fits");
    let mut mesh = Mesh::from(&textured);
    mesh.generate_tangents().expect("it has all that is needed");
    let handle = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
    let shape = ConvexMesh::from_mesh(textured).expect("a shape");
    app.world_mut()
        .entity_mut(body)
        .insert((shape, Mesh3d(handle)));
    app.update();
    app.world_mut()
        .commands()
        .slice(body, Plane::through(Vec3::ZERO, Vec3::X));
    (0..2).for_each(|_| app.update());
    for piece in all_with::<RigidBody>(&mut app) {
        let handle = app.world().get::<Mesh3d>(piece).expect("drawn");
        let mesh = app.world().resource::<Assets<Mesh>>().get(&handle.0);
        assert!(
            mesh.expect("there")
                .contains_attribute(Mesh::ATTRIBUTE_TANGENT)
        );
    }
}

/// All entities with a component, disabled ones too.
fn even_disabled<C: Component>(app: &mut App) -> Vec<Entity> {
    let world = app.world_mut();
    let mut all = world.query_filtered::<Entity, (With<C>, Allow<Disabled>)>();
    all.iter(world).collect()
}

/// Of the bounds of what an entity is drawn as, m.
fn size(app: &App, entity: Entity) -> f32 {
    drawn(app, entity).aabb().diagonal()
}

// What had become of its shape meanwhile was never drawn.
#[test]
fn who_was_disabled_is_drawn_as_it_is() {
    let mut app = mesh_app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let cube = |size: f32| ConvexMesh::cuboid(size, size, size).expect("a box");
    let body = (RigidBody::Dynamic, cube(1.0), DrawShape::new(), Disabled);
    let body = app.world_mut().spawn(body).id();
    (0..2).for_each(|_| app.update());
    app.world_mut().entity_mut(body).remove::<Disabled>();
    app.update();
    assert!((size(&app, body) - 3.0_f32.sqrt()).abs() < 1e-5);
    app.world_mut().entity_mut(body).insert(Disabled);
    app.update();
    app.world_mut().entity_mut(body).insert(cube(2.0));
    (0..2).for_each(|_| app.update());
    app.world_mut().entity_mut(body).remove::<Disabled>();
    app.update();
    assert!((size(&app, body) - 12.0_f32.sqrt()).abs() < 1e-5);
    // Pieces that somebody disables as they are born.
    app.world_mut()
        .add_observer(|born: On<Add<PieceOf>>, mut commands: Commands| {
            commands.entity(born.entity).insert(Disabled);
        });
    let plane = Plane::through(Vec3::ZERO, Vec3::X);
    app.world_mut().commands().slice(body, plane);
    (0..2).for_each(|_| app.update());
    let pieces = even_disabled::<PieceOf>(&mut app);
    assert_eq!(pieces.len(), 2);
    for piece in pieces {
        app.world_mut().entity_mut(piece).remove::<Disabled>();
        app.update();
        assert!((size(&app, piece) - 3.0).abs() < 1e-5);
    }
}

// The cut faces of what was disabled hung in the air.
#[test]
fn slots_are_seen_when_their_body_is() {
    let mut app = mesh_app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let draw = DrawShape::new().with_slot(CUT, Paint("inside"));
    let body = spawn_body(&mut app, draw);
    app.update();
    let plane = Plane::through(Vec3::ZERO, Vec3::X);
    app.world_mut().commands().slice(body, plane);
    app.update();
    let piece = all_with::<PieceOf>(&mut app)[0];
    for is_seen in [false, true, false, true] {
        let mut entity = app.world_mut().entity_mut(piece);
        if is_seen {
            entity.remove::<Disabled>();
        } else {
            entity.insert(Disabled);
        }
        app.update();
        let seen = all_with::<SlotMesh>(&mut app).len();
        assert_eq!(seen, 1 + usize::from(is_seen));
    }
    // Cut anew while nobody sees it.
    app.world_mut().entity_mut(piece).insert(Disabled);
    let shape = ConvexMesh::clone(app.world().get(piece).expect("a body"));
    app.world_mut().entity_mut(piece).insert(shape);
    app.update();
    assert_eq!(all_with::<SlotMesh>(&mut app).len(), 1);
    app.world_mut().entity_mut(piece).remove::<Disabled>();
    app.update();
    assert_eq!(all_with::<SlotMesh>(&mut app).len(), 2);
    // Pieces that are not to be drawn do not keep what drew the cut faces of what they were.
    app.world_mut()
        .resource_mut::<PieceRules>()
        .drop_component::<DrawShape>();
    let plane = Plane::through(Vec3::ZERO, Vec3::Y);
    app.world_mut().commands().slice(piece, plane);
    (0..2).for_each(|_| app.update());
    assert_eq!(all_with::<RigidBody>(&mut app).len(), 3);
    assert_eq!(even_disabled::<SlotMesh>(&mut app).len(), 1);
}
