//! Entities from descriptions of bodies, for scenes that are made as data.

use crate::bodies::body::{BodyDesc, Shape};
use crate::contact::material::Density;
use crate::ecs::components::*;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;

/// Spawning a body from its description.
pub trait SpawnBody {
    /// Spawns an entity with all components that `desc` stands for.
    fn spawn_body(&mut self, desc: BodyDesc) -> Entity;
}

impl SpawnBody for World {
    fn spawn_body(&mut self, desc: BodyDesc) -> Entity {
        let entity = self.spawn_empty().id();
        insert_body(self, entity, desc);
        entity
    }
}

impl SpawnBody for Commands<'_, '_> {
    fn spawn_body(&mut self, desc: BodyDesc) -> Entity {
        let entity = self.spawn_empty().id();
        self.queue(move |world: &mut World| insert_body(world, entity, desc));
        entity
    }
}

/// Does nothing if the entity is gone by now.
fn insert_body(world: &mut World, entity: Entity, desc: BodyDesc) {
    let Ok(mut entity) = world.get_entity_mut(entity) else {
        return;
    };
    let transform = Transform {
        translation: desc.pose.position,
        rotation: desc.pose.rotation,
        ..Transform::IDENTITY
    };
    let motion = (
        transform,
        LinearVelocity(desc.linear_velocity),
        AngularVelocity(desc.angular_velocity),
    );
    let material = (Density(desc.density), desc.friction, desc.restitution);
    match desc.shape {
        Shape::Convex(mesh) => entity.insert(mesh),
        Shape::HalfSpace(half_space) => entity.insert(half_space),
        Shape::Level(mesh) => entity.insert(mesh),
        Shape::Compound(compound) => entity.insert(compound),
    };
    if let Some(mass) = desc.mass {
        entity.insert(MassOverride(mass));
    }
    if let Some(surfaces) = desc.surfaces {
        entity.insert(surfaces);
    }
    if let Some(fracturable) = desc.fracturable {
        entity.insert(fracturable);
    }
    entity.insert((motion, material, desc.layers, desc.kind));
}
