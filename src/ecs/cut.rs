//! Cuts that commands ask for, and what became of those that were not made.

use crate::bodies::anchors::Anchors;
use crate::bodies::body::RigidBody;
use crate::bodies::store::Bodies;
use crate::ecs::components::*;
use crate::ecs::set_aside::leave;
use crate::ecs::state::{PluginState, SliceRequests};
use crate::fracture::{CutError, CutRequest, ExpiredPiece, FadingPiece, Fracture, Fractures};
use crate::math::Plane;
use bevy_ecs::prelude::*;

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
        self.queue(
            move |world: &mut World| match world.get_resource_mut::<PluginState>() {
                Some(mut state) => state.slice_requests.0.push((entity, plane)),
                None => log::warn!("{entity} is not cut: the app has no CleavePlugin"),
            },
        );
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

/// Despawns the entities of pieces whose time was over, and says which are to go.
pub(super) fn despawn_expired(
    commands: &mut Commands,
    fractures: &Fractures,
    entities: &BodyEntities,
    duration: f32,
    messages: &mut Messages<DebrisRemoved>,
) {
    for &FadingPiece {
        slot,
        body,
        remaining,
    } in &fractures.fading
    {
        if let Some(entity) = entities.of(slot, body) {
            commands.entity(entity).try_insert(Fading {
                remaining,
                duration,
            });
        }
    }
    for &ExpiredPiece { slot, body, mass } in &fractures.expired {
        if let Some(entity) = entities.of(slot, body) {
            commands.queue(move |world: &mut World| leave(world, entity));
            messages.write(DebrisRemoved { entity, mass });
        }
    }
}

/// Entities of bodies that stood become dynamic with their bodies, because they hung on what broke.
pub(super) fn let_fall(world: &mut World, done: &[Fracture]) {
    for &slot in done.iter().flat_map(|fracture| &fracture.fallen) {
        let id = world.resource::<Bodies>().id(slot);
        let entity = world.resource::<PluginState>().entities.of(slot, id);
        let entity = entity.and_then(|entity| world.get_entity_mut(entity).ok());
        if let Some(mut entity) = entity {
            entity.remove::<Anchors>().insert(RigidBody::Dynamic);
        }
    }
}
