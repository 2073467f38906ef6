//! Who broke in a step, and which pieces take its place; and bodies that go on with fewer parts or bonds.

use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::ecs::components::*;
use crate::ecs::forces::Mass;
use crate::ecs::parents::{local_of, parent_of};
use crate::ecs::piece_children::move_without_children;
use crate::ecs::state::PluginState;
use crate::fracture::Fracture;
use crate::mass::MassProperties;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_transform::components::Transform;
use smallvec::SmallVec;

/// Who broke in a step.
pub(super) struct Families {
    /// The events to send, without the pieces, and the slots of these.
    pub(super) told: Vec<(Fractured, Vec<u32>)>,
    /// Slots of the pieces of entities that went in the same step: with a parent that was debris, say.
    pub(super) orphans: Vec<u32>,
}

/// Who broke in a step, and the pieces of each. Those of bodies that were put into `Bodies` without entities are not among them.
pub(super) fn families(world: &World, done: &[Fracture]) -> Families {
    let bodies = world.resource::<Bodies>();
    let entities = &world.resource::<PluginState>().entities;
    let (mut told, mut orphans) = (Vec::new(), Vec::new());
    // By id of a piece: which of those told of it belongs to, none for an orphan. Ids only grow.
    let mut family_of: Vec<(BodyId, Option<usize>)> = Vec::new();
    for fracture in done {
        let known = family_of.binary_search_by_key(&fracture.parent, |&(id, _)| id);
        let count = told.len();
        let family = match known {
            Ok(at) => family_of[at].1,
            Err(_) => {
                let Some(parent) = entities.of(fracture.parent_slot, fracture.parent) else {
                    continue;
                };
                let is_there = has_body(world, parent, fracture);
                is_there.then(|| family_of_entity(&mut told, parent, fracture, entities))
            }
        };
        let slots = match family {
            Some(family) => {
                let (event, slots) = &mut told[family];
                if known.is_err() {
                    event.goes_on = fracture.goes_on;
                }
                if family < count {
                    event.ledger.go_on(&fracture.ledger);
                }
                event.planes.extend_from_slice(&fracture.planes);
                slots
            }
            None => &mut orphans,
        };
        for (&slot, &id) in fracture.pieces.iter().zip(&fracture.ids) {
            family_of.push((id, family));
            if bodies.is_current(slot, id) {
                slots.push(slot);
            }
        }
    }
    Families { told, orphans }
}

/// Whether an entity is there, and has the body that broke.
fn has_body(world: &World, entity: Entity, fracture: &Fracture) -> bool {
    let handle = world.get::<BodyHandle>(entity).and_then(|handle| handle.0);
    handle == Some((fracture.parent_slot, fracture.parent))
}

/// The family of an entity whose body broke, which may be known: what goes on may break again in the same step.
fn family_of_entity(
    told: &mut Vec<(Fractured, Vec<u32>)>,
    parent: Entity,
    fracture: &Fracture,
    entities: &BodyEntities,
) -> usize {
    let known = told.iter().position(|(event, _)| event.parent == parent);
    known.unwrap_or_else(|| {
        told.push((event_of(fracture, parent, entities), Vec::new()));
        told.len() - 1
    })
}

/// What is told of a fracture, but for planes and pieces.
fn event_of(fracture: &Fracture, parent: Entity, entities: &BodyEntities) -> Fractured {
    let cause = match fracture.blow.as_ref().or(fracture.waited.as_ref()) {
        None if fracture.is_load => FractureCause::Load,
        None => FractureCause::Cut,
        Some(blow) => FractureCause::Impact {
            by: blow.by.and_then(|(slot, id)| entities.of(slot, id)),
            point: blow.point,
            direction: blow.direction,
            impulse: blow.impulse,
            energy: blow.energy,
        },
    };
    Fractured {
        parent,
        pieces: Vec::new(),
        cause,
        planes: SmallVec::new(),
        ledger: fracture.ledger,
        goes_on: fracture.goes_on,
    }
}

/// Gives the entities of bodies that have lost parts or bonds, and go on, what is left of their shapes.
pub(super) fn sync_cracked(world: &mut World) {
    let cracked = std::mem::take(&mut world.resource_mut::<Bodies>().cracked);
    for (slot, id) in cracked {
        let bodies = world.resource::<Bodies>();
        let Some(shape) = bodies.is_current(slot, id).then(|| bodies.compound(slot)) else {
            continue;
        };
        let (Some(shape), mass) = (shape.cloned(), *bodies.mass(slot)) else {
            continue;
        };
        let entity = world.resource::<PluginState>().entities.of(slot, id);
        let Some(entity) = entity.filter(|&entity| world.get_entity(entity).is_ok()) else {
            continue;
        };
        unscale(world, entity, slot);
        let mut entity = world.entity_mut(entity);
        entity.insert(shape);
        if entity.contains::<Mass>() {
            entity.insert(Mass(mass.mass));
        }
        // What the mass phase of the next step finds is too late for who reads of the fracture.
        if let Some(mut own) = entity.get_mut::<MassProperties>() {
            own.set_if_neq(mass);
        }
    }
}

/// The shape of a body is as large as it is in the world: an entity that was scaled is not any more, but its children are.
fn unscale(world: &mut World, entity: Entity, slot: u32) {
    let above = parent_of(world, entity);
    let pose = world.resource::<Bodies>().pose(slot);
    let Some(own) = world.get::<Transform>(entity).copied() else {
        return;
    };
    let scaled = match above {
        None => Transform {
            scale: Vec3::ONE,
            ..own
        },
        Some(above) => {
            let (scale, ..) = above.to_scale_rotation_translation();
            local_of(&above, pose, scale.recip())
        }
    };
    if scaled.scale != own.scale && scaled.is_finite() {
        move_without_children(world, entity, scaled);
    }
}
