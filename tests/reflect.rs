//! With the feature `reflect`, inspectors and scene files find the plugin's components and resources.

use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::{AppTypeRegistry, World};
use bevy_ecs::reflect::{ReflectComponent, ReflectResource};
use bevy_reflect::std_traits::ReflectDefault;
use bevy_reflect::{FromReflect, Reflect};
use std::any::TypeId;

#[test]
fn components_and_resources_are_registered_as_such() {
    let mut app = App::new();
    app.add_plugins(CleavePlugin::default());
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let components = [
        TypeId::of::<RigidBody>(),
        TypeId::of::<HalfSpaceShape>(),
        TypeId::of::<LinearVelocity>(),
        TypeId::of::<AngularVelocity>(),
        TypeId::of::<Density>(),
        TypeId::of::<MassOverride>(),
        TypeId::of::<MassProperties>(),
        TypeId::of::<Friction>(),
        TypeId::of::<Restitution>(),
        TypeId::of::<CollisionLayers>(),
        TypeId::of::<Fracturable>(),
    ];
    for id in components {
        assert!(registry.get_type_data::<ReflectComponent>(id).is_some());
    }
    let resources = [
        TypeId::of::<Gravity>(),
        TypeId::of::<SolverConfig>(),
        TypeId::of::<StepReport>(),
    ];
    for id in resources {
        assert!(registry.get_type_data::<ReflectResource>(id).is_some());
    }
    assert!(registry.contains(TypeId::of::<FracturePattern>()));
    assert!(registry.contains(TypeId::of::<Ledger>()));
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

fn read_by_reflection(world: &World, id: TypeId, entity: bevy_ecs::entity::Entity) -> &dyn Reflect {
    let registry = world.resource::<AppTypeRegistry>().read();
    let component = registry.get_type_data::<ReflectComponent>(id);
    component
        .and_then(|data| data.reflect(world.entity(entity)))
        .expect("registered and there")
}

#[test]
fn a_shape_survives_as_data() {
    let mut app = App::new();
    app.add_plugins(CleavePlugin::default());
    let ball = ConvexMesh::icosphere(0.5, 1).expect("a ball");
    let described = ShapeConstructor::of(&ball);
    let entity = app.world_mut().spawn(described.clone()).id();
    let id = TypeId::of::<ShapeConstructor>();
    // As a scene file does: read without knowing the type, written to an entity of another world.
    let data = read_by_reflection(app.world(), id, entity)
        .to_dynamic()
        .expect("plain data");
    let mut other = App::new();
    other.add_plugins(CleavePlugin::default());
    let entity = other.world_mut().spawn(RigidBody::Dynamic).id();
    let registry = other.world().resource::<AppTypeRegistry>().clone();
    let registry = registry.read();
    let component = registry.get_type_data::<ReflectComponent>(id);
    let component = component.expect("registered");
    component.insert(&mut other.world_mut().entity_mut(entity), &*data, &registry);
    other.world_mut().flush();
    let shape = other.world().get::<ConvexMesh>(entity).expect("built");
    assert_eq!(shape.hull().vertices(), ball.hull().vertices());
}

#[test]
fn components_can_be_made_from_nothing() {
    let mut app = App::new();
    app.add_plugins(CleavePlugin::default());
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let defaults = [
        TypeId::of::<ShapeConstructor>(),
        TypeId::of::<Joint>(),
        TypeId::of::<JointLoad>(),
        TypeId::of::<RigidBody>(),
        TypeId::of::<Fracturable>(),
    ];
    for id in defaults {
        assert!(registry.get_type_data::<ReflectDefault>(id).is_some());
    }
}
