//! Cuts into entities: requests from commands, pieces spawned, parents despawned.

use crate::bodies::body::RigidBody;
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::contact::material::Density;
use crate::ecs::components::*;
use crate::ecs::joint::{JointsOfA, JointsOfB, follow_pieces};
use crate::ecs::state::PluginState;
use crate::ecs::state::SliceRequests;
use crate::fracture::{CutError, CutRequest, Fracture, Fractures};
use crate::geometry::ConvexMesh;
use crate::mass::MassProperties;
use crate::math::Plane;
use crate::slice::fracturable::Fracturable;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use smallvec::SmallVec;

/// Cutting on request.
pub trait SliceCommands {
    /// Cuts the body of `entity` by `plane` (world frame) in the next step, as the body lies before that step.
    ///
    /// The pieces are new entities with the parent's other components; [`Fractured`] names them. Several cuts of one
    /// body in one step are made one after the other, each through all pieces that are there by then. A cut that
    /// cannot be made leaves the body as it is and sends a [`BodyWarning`] with the reason.
    fn slice(&mut self, entity: Entity, plane: Plane);
}

impl SliceCommands for Commands<'_, '_> {
    fn slice(&mut self, entity: Entity, plane: Plane) {
        self.queue(move |world: &mut World| {
            if let Some(mut state) = world.get_resource_mut::<PluginState>() {
                state.slice_requests.0.push((entity, plane));
            }
        });
    }
}

/// Finds the bodies that are to be cut, before they move on from where the planes were chosen.
pub(crate) fn gather_requests(
    requests: &mut SliceRequests,
    bodies: &Bodies,
    fractures: &mut Fractures,
    warnings: &mut Messages<BodyWarning>,
    handles: &Query<&BodyHandle>,
) {
    for (entity, plane) in requests.0.drain(..) {
        let handle = handles.get(entity).ok().and_then(|handle| handle.0);
        let body = handle.filter(|&(slot, id)| bodies.is_current(slot, id));
        let request = body.map(|(slot, _)| CutRequest::in_world(bodies, slot, plane));
        match request.unwrap_or(Err(CutError::NoBody)) {
            Ok(request) => fractures.requests.push(request),
            Err(error) => warn(warnings, entity, error),
        }
    }
}

/// Warns about cuts that were not made.
pub(super) fn report_refusals(
    fractures: &Fractures,
    entities: &BodyEntities,
    warnings: &mut Messages<BodyWarning>,
) {
    for (request, error) in &fractures.refused {
        if let Some(entity) = entities.of(request.slot, request.body) {
            warn(warnings, entity, error.clone());
        }
    }
}

/// Command: spawns an entity for every piece, despawns the parents, tells what happened.
///
/// A piece that broke again in the same step never was an entity: its pieces are told of as those of the first parent.
/// Pieces of a body without an entity stay bodies without entities.
pub(super) fn spawn_pieces(world: &mut World) {
    let done = std::mem::take(&mut world.resource_mut::<Fractures>().done);
    let families = families(world, &done).into_iter();
    let families: Vec<_> = families
        .map(|(message, pieces)| {
            let pieces = pieces.into_iter();
            let pieces = pieces
                .map(|slot| spawn_piece(world, message.parent, slot))
                .collect();
            Fractured { pieces, ..message }
        })
        .collect();
    follow_pieces(world);
    for message in families {
        world.despawn(message.parent);
        world.write_message(message);
    }
    world.resource_mut::<Fractures>().done = done;
}

/// Despawns the entities of pieces whose time was over.
pub(super) fn despawn_expired(
    commands: &mut Commands,
    fractures: &Fractures,
    entities: &BodyEntities,
) {
    for &(slot, id) in &fractures.expired {
        if let Some(entity) = entities.of(slot, id) {
            commands.entity(entity).try_despawn();
        }
    }
}

/// The messages to send, without the pieces, and the slots of these.
fn families(world: &World, done: &[Fracture]) -> Vec<(Fractured, Vec<u32>)> {
    let bodies = world.resource::<Bodies>();
    let entities = &world.resource::<PluginState>().entities;
    let mut families: Vec<(Fractured, Vec<u32>)> = Vec::new();
    // By id of a piece: which of the families it belongs to. Ids only grow.
    let mut family_of: Vec<(BodyId, usize)> = Vec::new();
    for fracture in done {
        let known = family_of.binary_search_by_key(&fracture.parent, |&(id, _)| id);
        let family = match known {
            Ok(at) => family_of[at].1,
            Err(_) => {
                let parent = entities.of(fracture.parent_slot, fracture.parent);
                let Some(parent) = parent.filter(|&p| world.get_entity(p).is_ok()) else {
                    continue;
                };
                let message = Fractured {
                    parent,
                    pieces: Vec::new(),
                    planes: SmallVec::new(),
                    ledger: fracture.ledger,
                };
                families.push((message, Vec::new()));
                families.len() - 1
            }
        };
        let (message, slots) = &mut families[family];
        message.planes.extend_from_slice(&fracture.planes);
        for (&slot, &id) in fracture.pieces.iter().zip(&fracture.ids) {
            family_of.push((id, family));
            if bodies.is_current(slot, id) {
                slots.push(slot);
            }
        }
    }
    families
}

/// One piece: a clone of the parent with shape, motion and mass of its own.
fn spawn_piece(world: &mut World, parent: Entity, slot: u32) -> Entity {
    let bodies = world.resource::<Bodies>();
    let (id, pose) = (bodies.id(slot), bodies.pose(slot));
    let (v, omega) = bodies.velocity(slot);
    let transform = Transform {
        translation: pose.position,
        rotation: pose.rotation,
        ..Transform::IDENTITY
    };
    let mesh = bodies.convex(slot).expect("pieces are convex").clone();
    let motion = (
        transform,
        LinearVelocity(v),
        AngularVelocity(omega),
        Density(bodies.density(slot)),
        *bodies.mass(slot),
        BodyHandle(Some((slot, id))),
    );
    let fracturable = bodies.fracturable(slot).cloned();
    // What is cloned must not carry the parent's body, or observers would take the clone for the parent.
    let piece = world
        .entity_mut(parent)
        .clone_and_spawn_with_opt_out(|builder| {
            builder.deny::<(
                RigidBody,
                BodyHandle,
                ConvexMesh,
                MassProperties,
                MassOverride,
                Fracturable,
                Sleeping,
                Children,
                (JointsOfA, JointsOfB),
            )>();
        });
    let mut entity = world.entity_mut(piece);
    entity.insert((RigidBody::Dynamic, mesh, motion));
    if let Some(fracturable) = fracturable {
        entity.insert(fracturable);
    }
    world
        .resource_mut::<PluginState>()
        .entities
        .set(slot, id, piece, transform);
    piece
}
