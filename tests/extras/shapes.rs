//! Shapes that wait for meshes, one by one and for a whole scene.

use crate::{all_with, mesh_app};
use bevy_app::App;
use bevy_asset::{AssetServer, Assets, Handle, RenderAssetUsages};
use bevy_cleave::geometry::primitives;
use bevy_cleave::prelude::*;
use bevy_ecs::entity_disabling::Disabled;
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

/// Bodies that wait for a mesh: by each of the wishes, as a part of a compound, and below a scene that is loaded. The joint of the first
/// of them to the world is the last.
fn waiting(app: &mut App, mesh: &Handle<Mesh>) -> Vec<Entity> {
    let wishes = [
        ShapeFromMesh::Hull,
        ShapeFromMesh::HullWithVisual,
        ShapeFromMesh::Static {
            is_two_sided: false,
        },
        ShapeFromMesh::Compound(Default::default()),
    ];
    let mesh = Mesh3d(mesh.clone());
    let world = app.world_mut();
    let wishes = wishes.map(|wish| {
        let kind = match wish {
            ShapeFromMesh::Static { .. } => RigidBody::Static,
            _ => RigidBody::Dynamic,
        };
        world.spawn((kind, wish, mesh.clone())).id()
    });
    let at = |x: f32| Transform::from_xyz(x, 0.0, 0.0);
    let part = (ShapeFromMesh::Hull, mesh.clone(), at(2.0));
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a box");
    let compound = (RigidBody::Dynamic, CompoundOfChildren, at(50.0));
    let compound = world
        .spawn((compound, children![(cube, at(0.0)), part]))
        .id();
    let ask = ShapesOfScene {
        body: RigidBody::Static,
        shape: ShapeFromMesh::Hull,
    };
    let node = world.spawn((mesh, at(5.0))).id();
    world.spawn((ask, Transform::default())).add_child(node);
    let joint = world.spawn((Joint::fixed(), JointB(wishes[0]))).id();
    let mut all = wishes.to_vec();
    all.extend([compound, node, joint]);
    all
}

/// Which of them have something wrong.
fn complaining(app: &App, entities: &[Entity]) -> Vec<bool> {
    let of = |&entity: &Entity| {
        let entity = app.world().entity(entity);
        entity.contains::<BodyIssues>() || entity.contains::<JointProblem>()
    };
    entities.iter().map(of).collect()
}

#[test]
fn what_waits_for_a_mesh_is_no_issue() {
    let mut app = mesh_app();
    let handle = reserve(&app);
    let entities = waiting(&mut app, &handle);
    let told = |app: &App| app.world().resource::<Messages<BodyWarning>>().len();
    for _ in 0..5 {
        app.update();
        assert_eq!(complaining(&app, &entities), [false; 7]);
        assert_eq!(told(&app), 0);
    }
    assert_eq!(app.world().resource::<Bodies>().len(), 0);
    load(&mut app, &handle, ball());
    (0..4).for_each(|_| app.update());
    assert_eq!(complaining(&app, &entities), [false; 7]);
    assert_eq!(told(&app), 0);
    assert_eq!(app.world().resource::<Bodies>().len(), 6);
    assert_eq!(all_with::<ShapeAwaited>(&mut app), []);
    let parts = app
        .world()
        .get::<Compound>(entities[4])
        .map(|c| c.parts().len());
    assert_eq!(parts, Some(2));
}

#[test]
fn a_mesh_that_does_not_come_is_an_issue() {
    let mut app = mesh_app();
    let server = app.world().resource::<AssetServer>();
    let lost = server.load::<Mesh>("there/is/no.such");
    let entities = waiting(&mut app, &lost);
    for _ in 0..200 {
        app.update();
        std::thread::sleep(std::time::Duration::from_millis(5));
        if !all_with::<ShapeRefused>(&mut app).is_empty() {
            break;
        }
    }
    (0..3).for_each(|_| app.update());
    // The compound is made of what there is; the part that is missing says so.
    let expected = [true, true, true, true, false, true, true];
    assert_eq!(complaining(&app, &entities), expected);
    let refused = all_with::<ShapeRefused>(&mut app);
    assert_eq!(refused.len(), 6);
    for entity in refused {
        let why = app.world().get::<ShapeRefused>(entity).map(|why| &why.0);
        assert!(
            matches!(why, Some(ShapeFromMeshError::NotLoaded(_))),
            "{why:?}"
        );
    }
    // Mended by another mesh; who takes the wish away mends it with a shape of their own.
    let good = app.world_mut().resource_mut::<Assets<Mesh>>().add(ball());
    app.world_mut().entity_mut(entities[0]).insert(Mesh3d(good));
    let mut own = app.world_mut().entity_mut(entities[1]);
    own.remove::<ShapeFromMesh>();
    own.insert(ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a box"));
    (0..4).for_each(|_| app.update());
    let complaining = complaining(&app, &entities);
    assert_eq!([complaining[0], complaining[1], complaining[6]], [false; 3]);
    assert!(!app.world().entity(entities[0]).contains::<ShapeRefused>());
}

#[test]
fn a_wish_without_a_mesh_is_an_issue() {
    let mut app = mesh_app();
    let body = (RigidBody::Dynamic, ShapeFromMesh::Hull);
    let body = app.world_mut().spawn(body).id();
    (0..3).for_each(|_| app.update());
    assert_eq!(complaining(&app, &[body]), [true]);
    let why = app.world().get::<ShapeRefused>(body).map(|why| &why.0);
    assert_eq!(why, Some(&ShapeFromMeshError::NoMesh));
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(ball());
    app.world_mut().entity_mut(body).insert(Mesh3d(mesh));
    (0..4).for_each(|_| app.update());
    assert_eq!(complaining(&app, &[body]), [false]);
    assert!(!app.world().entity(body).contains::<ShapeRefused>());
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

// Nothing became of nodes that were disabled as they came, or put below later; and what drew cut faces became bodies.
#[test]
fn whatever_comes_below_a_scene_becomes_bodies_and_nothing_else() {
    let mut app = mesh_app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let handle = app.world_mut().resource_mut::<Assets<Mesh>>().add(ball());
    let mesh = || (Mesh3d(handle.clone()), Transform::default());
    let world = app.world_mut();
    let scene = (ShapesOfScene::default(), Transform::default(), Disabled);
    let scene = world.spawn(scene).id();
    let disabled = world.spawn((mesh(), Disabled, ChildOf(scene))).id();
    (0..2).for_each(|_| app.update());
    for entity in [scene, disabled] {
        app.world_mut().entity_mut(entity).remove::<Disabled>();
    }
    let branch = app.world_mut().spawn(Transform::default()).id();
    let leaf = app.world_mut().spawn((mesh(), ChildOf(branch))).id();
    let late = app.world_mut().spawn(mesh()).id();
    (0..2).for_each(|_| app.update());
    assert_eq!(all_with::<ConvexMesh>(&mut app), [disabled]);
    for entity in [branch, late] {
        app.world_mut().entity_mut(entity).insert(ChildOf(scene));
    }
    (0..2).for_each(|_| app.update());
    let mut all = vec![disabled, leaf, late];
    all.sort_unstable();
    assert_eq!(all_with::<ConvexMesh>(&mut app), all);
    let cut = Fracturable {
        cut_material: Some(1),
        ..Fracturable::default()
    };
    let draw = DrawShape::new().with_slot(1, Name::new("inside"));
    app.world_mut().entity_mut(late).insert((cut, draw));
    app.update();
    let plane = Plane::through(Vec3::ZERO, Vec3::X);
    app.world_mut().commands().slice(late, plane);
    (0..3).for_each(|_| app.update());
    assert_eq!(all_with::<SlotMesh>(&mut app).len(), 2);
    assert_eq!(all_with::<RigidBody>(&mut app).len(), 4);
    assert_eq!(all_with::<ShapeAwaited>(&mut app), []);
}

// A compound of children that were yet to come was an issue, and they became bodies of their own.
#[test]
fn a_scene_that_is_loaded_is_one_compound() {
    for is_below in [false, true] {
        let mut app = mesh_app();
        let handle = app.world_mut().resource_mut::<Assets<Mesh>>().add(ball());
        let body = (RigidBody::Dynamic, CompoundOfChildren, Transform::default());
        let body = app.world_mut().spawn(body).id();
        let scene = if is_below {
            let node = (Transform::default(), ChildOf(body));
            app.world_mut().spawn(node).id()
        } else {
            body
        };
        let ask = ShapesOfScene::default();
        app.world_mut().entity_mut(scene).insert(ask);
        (0..3).for_each(|_| app.update());
        assert_eq!(complaining(&app, &[body]), [false]);
        for i in 0..3 {
            let at = Transform::from_xyz(i as f32, 0.0, 0.0);
            let node = app.world_mut().spawn((at, ChildOf(scene))).id();
            let mesh = (Mesh3d(handle.clone()), ChildOf(node));
            app.world_mut().spawn((mesh, Transform::default()));
        }
        (0..4).for_each(|_| app.update());
        assert_eq!(all_with::<RigidBody>(&mut app), [body]);
        let parts = app.world().get::<Compound>(body).map(Compound::len);
        assert_eq!(parts, Some(3));
        assert_eq!(all_with::<BodyIssues>(&mut app), []);
        assert_eq!(all_with::<ShapeAwaited>(&mut app), []);
    }
}

#[test]
fn a_mesh_that_is_not_convex_becomes_a_compound() {
    let mut app = mesh_app();
    let slab = |at: Vec3, size: Vec3| {
        let slab = primitives::cuboid(size.x, size.y, size.z).expect("a box");
        slab.to_mesh().transformed(&Pose::from_position(at))
    };
    // A table: one mesh of parts that overlap.
    let legs = [[-0.4, -0.4], [0.4, -0.4], [-0.4, 0.4], [0.4, 0.4]];
    let legs = legs.map(|[x, z]| slab(Vec3::new(x, -0.5, z), Vec3::new(0.1, 1.0, 0.1)));
    let top = slab(Vec3::ZERO, Vec3::new(1.0, 0.1, 1.0));
    let mut positions: Vec<Vec3> = Vec::new();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for part in legs.iter().chain([&top]) {
        let first = positions.len() as u32;
        positions.extend(part.positions());
        triangles.extend(part.triangles().iter().map(|t| t.map(|v| v + first)));
    }
    let mesh = TriMesh::new(positions, triangles).expect("five boxes");
    let mesh = app
        .world_mut()
        .resource_mut::<Assets<Mesh>>()
        .add(Mesh::from(&mesh));
    let wish = ShapeFromMesh::Compound(Default::default());
    let table = (RigidBody::Dynamic, wish, Mesh3d(mesh));
    let table = app.world_mut().spawn(table).id();
    (0..3).for_each(|_| app.update());
    assert_eq!(complaining(&app, &[table]), [false]);
    let compound = app.world().get::<Compound>(table).expect("a table");
    assert!((5..9).contains(&compound.len()), "{}", compound.len());
    assert!(compound.visual().is_some());
    // What is open and cannot be closed says so.
    let sheet = StaticMesh::from_heights(&[0.0; 4], 2, 1.0).expect("a grid");
    let sheet = Mesh::from(&sheet.to_mesh());
    let sheet = app.world_mut().resource_mut::<Assets<Mesh>>().add(sheet);
    let sheet = (RigidBody::Dynamic, wish, Mesh3d(sheet));
    let sheet = app.world_mut().spawn(sheet).id();
    (0..3).for_each(|_| app.update());
    assert!(app.world().entity(sheet).contains::<ShapeRefused>());
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
