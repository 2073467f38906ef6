//! With the feature `reflect`, inspectors and scene files find the plugin's components and resources.

use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::{AppTypeRegistry, World};
use bevy_ecs::reflect::{ReflectComponent, ReflectResource};
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
