//! With the feature `reflect`, inspectors and scene files find the plugin's components and resources.

#[path = "../plugin/app.rs"]
mod app;
#[path = "../common/mod.rs"]
mod common;
#[path = "../plugin/random_world.rs"]
mod random_world;
mod saving;
mod scene_file;
#[path = "../plugin/twins.rs"]
mod twins;

use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::component::ComponentCloneBehavior;
use bevy_ecs::prelude::*;
use bevy_ecs::reflect::{ReflectComponent, ReflectResource};
use bevy_math::{Quat, Vec3};
use bevy_reflect::std_traits::ReflectDefault;
use bevy_reflect::{FromReflect, Reflect};
use std::any::TypeId;
use std::path::Path;

/// Components that a scene file cannot hold, or need not: what is computed from others or names what is in memory.
const COMPUTED: [&str; 13] = [
    // Described by constructors.
    "ConvexMesh",
    "Compound",
    "StaticMesh",
    "DrawShape",
    // Written by the plugin.
    "AppliedForces",
    "BodyHandle",
    "BodyIssues",
    "Fading",
    "JointHandle",
    "JointProblem",
    "ShapeRefused",
    "SlotMesh",
    "Walking",
];

/// Components that name entities, and so have no default.
const RELATED: [&str; 4] = ["JointA", "JointB", "PieceOf", "Remains"];

/// Resources that are no settings: what is simulated, which entities describe, and rules that are functions.
const STATE: [&str; 9] = [
    "Bodies",
    "Bonds",
    "ContactCache",
    "Contacts",
    "Fractures",
    "Joints",
    "PhysicsHistory",
    "PieceRules",
    "QueryIndex",
];

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((CleavePlugin::default(), InterpolationPlugin));
    #[cfg(feature = "mesh")]
    app.add_plugins(CleaveMeshPlugin);
    app
}

/// Names of the public types in a folder that derive `derive`.
fn deriving(derive: &str, folder: &Path, found: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("readable").path();
        if path.is_dir() {
            deriving(derive, &path, found);
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("a source");
        let items = text.split("#[derive(").skip(1);
        let of = items.filter_map(|item| {
            let (derived, rest) = item.split_once(")]")?;
            let is_of_kind = derived.split(", ").any(|name| name == derive);
            let mut lines = rest.lines().map(str::trim_start);
            let line = lines.find(|line| !(line.is_empty() || line.starts_with("#[")))?;
            let name = ["pub struct ", "pub enum "]
                .iter()
                .find_map(|start| line.strip_prefix(start));
            let name = name.filter(|_| is_of_kind)?;
            let end = name.find(|c: char| !c.is_alphanumeric());
            Some(name[..end.unwrap_or(name.len())].to_string())
        });
        found.extend(of);
    }
}

/// Of a type that derives `Component`: one that a scene file may hold.
fn is_data(name: &str) -> bool {
    let is_drawn = matches!(name, "ShapeFromMesh" | "ShapesOfScene");
    !COMPUTED.contains(&name) && (cfg!(feature = "mesh") || !is_drawn)
}

// Some were not, among them the relations of joints and `NoInterpolation`, which was registered as a type alone.
#[test]
fn every_component_and_setting_is_registered_with_a_default() {
    let (mut names, mut resources) = (Vec::new(), Vec::new());
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    deriving("Component", &sources, &mut names);
    deriving("Resource", &sources, &mut resources);
    assert!(names.len() > 50, "{names:?}");
    assert!(resources.len() > STATE.len(), "{resources:?}");
    let mut app = app();
    let registry = app.world().resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    for name in names.iter().filter(|name| is_data(name)) {
        let known = registry.get_with_short_type_path(name);
        let known = known.unwrap_or_else(|| panic!("{name} is not registered"));
        assert!(known.contains::<ReflectComponent>(), "{name}");
        let has_default = known.contains::<ReflectDefault>();
        assert!(has_default || RELATED.contains(&name.as_str()), "{name}");
        let component = known.data::<ReflectComponent>().expect("seen above");
        let id = component.register_component(app.world_mut());
        let info = app.world().components().get_info(id);
        let behavior = info.expect("registered").clone_behavior();
        // Bevy's scene files are read without those.
        assert!(
            !matches!(behavior, ComponentCloneBehavior::Ignore),
            "{name}"
        );
    }
    let settings = resources.iter().map(String::as_str);
    for name in settings.filter(|name| !STATE.contains(name)) {
        let known = registry.get_with_short_type_path(name).expect(name);
        assert!(known.contains::<ReflectResource>() && known.contains::<ReflectDefault>());
    }
    assert!(registry.contains(TypeId::of::<FracturePattern>()));
    assert!(registry.contains(TypeId::of::<Ledger>()));
}

/// What is read from an entity without knowing the type, and written to one of another world, as a scene file does.
fn carry(component: impl Component + Reflect, to: &mut App) -> Entity {
    let id = component.type_id();
    let mut from = app();
    // Whom a relation names is there in both.
    from.world_mut().spawn_empty();
    let entity = from.world_mut().spawn(component).id();
    let data = read_by_reflection(from.world(), id, entity);
    let data = data.to_dynamic().expect("plain data");
    let entity = to.world_mut().spawn_empty().id();
    let registry = to.world().resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let component = registry.get_type_data::<ReflectComponent>(id);
    let component = component.expect("registered");
    component.insert(&mut to.world_mut().entity_mut(entity), &*data, &registry);
    to.world_mut().flush();
    entity
}

/// The shape that comes of a description which was carried over.
fn rebuilt<S: Component + Clone>(description: impl Component + Reflect) -> S {
    let mut to = app();
    let entity = carry(description, &mut to);
    to.world().get::<S>(entity).cloned().expect("built")
}

/// Carries one over and compares.
fn check_carried<C: Component + Reflect + Clone + PartialEq + std::fmt::Debug>(component: C) {
    let mut to = app();
    let entity = carry(component.clone(), &mut to);
    assert_eq!(to.world().get::<C>(entity), Some(&component));
}

// The planes of a pattern were left out.
#[test]
fn what_is_carried_over_is_the_same() {
    let planes = FracturePattern::Planes(vec![Plane::through(Vec3::X, Vec3::Y)]);
    check_carried(Fracturable::with_strength(3.0).with_pattern(planes));
    check_carried(
        Fracturable::with_strength(3.0).with_pattern(FracturePattern::Star { planes: 3 }),
    );
    check_carried(Walker {
        velocity: Vec3::X,
        ..Walker::default()
    });
    check_carried(SurfaceMaterials::default());
    check_carried(Anchors::none());
    check_carried(Joint::hinge());
    check_carried(LockedAxes::ROTATION);
    check_carried(Fatigue::new(0.3));
    check_carried(CollisionLayers::default());
    check_carried(HalfSpaceShape::default());
    check_carried(MaxSpeed::default());
    let entity = app().world_mut().spawn_empty().id();
    let mut to = app();
    to.world_mut().spawn_empty();
    let joint = carry(JointB(entity), &mut to);
    assert_eq!(to.world().get::<JointB>(joint), Some(&JointB(entity)));
}

fn shapes() -> Vec<ConvexMesh> {
    let round = [
        ConvexMesh::sphere(0.4),
        ConvexMesh::capsule(0.3, 1.0),
        ConvexMesh::cylinder(0.3, 1.0),
        ConvexMesh::cone(0.3, 1.0),
        ConvexMesh::cuboid(1.0, 2.0, 3.0).and_then(|cube| cube.rounded(0.1)),
        ConvexMesh::sphere(0.4).and_then(|ball| ball.with_resolution(12)),
        ConvexMesh::cylinder(0.3, 1.0).and_then(|it| it.scaled(Vec3::new(2.0, 3.0, 2.0))),
    ];
    let ball = ConvexMesh::icosphere(0.5, 1).expect("a ball");
    let cup = ConvexMesh::from_mesh(ball.hull().to_mesh()).expect("closed");
    let hulls = [ball, cup.with_mass_of_visual()];
    let round = round.into_iter().map(|shape| shape.expect("a shape"));
    round.chain(hulls).collect()
}

/// What is to be the same of two shapes.
fn look(shape: &ConvexMesh) -> (ShapeConstructor, Vec<Vec3>, bool) {
    let corners = shape.hull().vertices().to_vec();
    (ShapeConstructor::of(shape), corners, shape.is_round())
}

// What was round came back as its polyhedron; compounds and levels could not be described.
#[test]
fn shapes_survive_as_data() {
    for shape in shapes() {
        let again: ConvexMesh = rebuilt(ShapeConstructor::of(&shape));
        assert_eq!(look(&again), look(&shape));
    }
    let beside = |i: usize| Pose::new(i as f32 * Vec3::X, Quat::from_rotation_x(0.1));
    let parts = shapes().into_iter().enumerate();
    let loose = Compound::new(parts.map(|(i, shape)| (beside(i), shape))).expect("parts");
    let cube = || ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a cube");
    let row = (0..4).map(|i| (Pose::new(i as f32 * Vec3::X, Quat::IDENTITY), cube()));
    let bonded = Compound::new(row).and_then(|row| row.bonded(1e5));
    let bonded = bonded.expect("common faces");
    let drawn = bonded.clone().with_visual(cube().hull().to_mesh());
    for compound in [loose, bonded, drawn] {
        let described = CompoundConstructor::of(&compound);
        let again: Compound = rebuilt(described.clone());
        assert_eq!(CompoundConstructor::of(&again), described);
        assert_eq!(again.is_bonded(), compound.is_bonded());
    }
    let ground = StaticMesh::from_heights(&[0.0, 1.0, 2.0, 0.0, 3.0, 0.0], 3, 1.0);
    let ground = ground.expect("a terrain");
    let slots = ground.with_materials(vec![0, 1, 2, 3]).expect("four");
    for level in [ground.clone(), ground.two_sided(), slots] {
        let described = LevelConstructor::of(&level);
        let again: StaticMesh = rebuilt(described.clone());
        assert_eq!(LevelConstructor::of(&again), described);
        assert_eq!(again.len(), level.len());
    }
}

#[test]
fn component_read_through_reflection_is_the_component() {
    let mut app = App::new();
    app.add_plugins(CleavePlugin::default());
    let fracturable = Fracturable {
        pattern: FracturePattern::Star { planes: 3 },
        generations: 7,
        ..Default::default()
    };
    let entity = app.world_mut().spawn(fracturable.clone()).id();
    let read = read_by_reflection(app.world(), TypeId::of::<Fracturable>(), entity);
    assert_eq!(Fracturable::from_reflect(read), Some(fracturable));
}

fn read_by_reflection(world: &World, id: TypeId, entity: Entity) -> &dyn Reflect {
    let registry = world.resource::<AppTypeRegistry>().read();
    let component = registry.get_type_data::<ReflectComponent>(id);
    component
        .and_then(|data| data.reflect(world.entity(entity)))
        .expect("registered and there")
}
