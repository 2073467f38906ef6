//! Worlds as scene files: what `DynamicWorld` of `bevy_world_serialization` 0.20 keeps of entities, and how it spawns them again. That
//! crate itself would be built for every test of this one, with sixty more.

use bevy_ecs::component::ComponentCloneBehavior;
use bevy_ecs::entity::{EntityHashMap, SceneEntityMapper};
use bevy_ecs::prelude::*;
use bevy_ecs::reflect::ReflectComponent;
use bevy_ecs::relationship::RelationshipHookMode;
use bevy_reflect::PartialReflect;
use std::any::TypeId;

/// A component as plain data.
type Data = (TypeId, Box<dyn PartialReflect>);

/// Entities, and their registered components.
pub(crate) struct SceneFile(Vec<(Entity, Vec<Data>)>);

impl SceneFile {
    pub(crate) fn of(world: &World, entities: impl IntoIterator<Item = Entity>) -> Self {
        let registry = world.resource::<AppTypeRegistry>().read();
        let entities = entities.into_iter().map(|entity| {
            let entity = world.entity(entity);
            let kept = entity.archetype().components().iter().filter_map(|&id| {
                let id = world.components().get_info(id)?.type_id()?;
                let component = registry.get_type_data::<ReflectComponent>(id)?;
                let data = component.reflect(entity)?.to_dynamic();
                Some((id, data.expect("plain data")))
            });
            (entity.id(), kept.collect())
        });
        Self(entities.collect())
    }

    /// Spawns them; which is which.
    pub(crate) fn spawn(&self, world: &mut World) -> EntityHashMap<Entity> {
        let registry = world.resource::<AppTypeRegistry>().clone();
        let registry = registry.read();
        let spawned = (self.0.iter()).map(|(entity, _)| (*entity, world.spawn_empty().id()));
        let mut spawned: EntityHashMap<Entity> = spawned.collect();
        for (entity, components) in &self.0 {
            let entity = spawned[entity];
            for (id, data) in components {
                let component = registry.get_type_data::<ReflectComponent>(*id);
                let component = component.expect("registered in both worlds");
                let id = component.register_component(world);
                let info = world.components().get_info(id).expect("registered");
                if matches!(info.clone_behavior(), ComponentCloneBehavior::Ignore) {
                    continue;
                }
                SceneEntityMapper::world_scope(&mut spawned, world, |world, mapper| {
                    component.apply_or_insert_mapped(
                        &mut world.entity_mut(entity),
                        &**data,
                        &registry,
                        mapper,
                        RelationshipHookMode::Skip,
                    );
                });
            }
        }
        world.flush();
        spawned
    }
}
