//! Components into flat arrays: new bodies, removed bodies, and what the user changed since the last step.

use super::components::*;
use crate::contact::material::{Density, Friction, Restitution};
use crate::contact::{BodyId, CollisionLayers};
use crate::geometry::{ConvexMesh, HalfSpace};
use crate::mass::MassProperties;
use crate::math::Pose;
use crate::slice::fracturable::Fracturable;
use crate::solver::bodies::{Bodies, BodyDesc, BodyError, RigidBody, Shape};
use crate::solver::body;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_ecs::system::SystemParam;
use bevy_math::Vec3;
use bevy_transform::components::Transform;

/// Entities whose `RigidBody` came or went since the last step, in the order in which that happened.
///
/// The order of commands decides body ids, not tables or entity numbers: results do not depend on how entities are
/// stored.
#[derive(Debug, Default, Resource)]
pub(crate) struct BodyQueue {
    arrived: Vec<Entity>,
    left: Vec<(u32, BodyId)>,
    /// Entities that could not become bodies, with the reason; tried again each step, warned about once.
    refused: Vec<(Entity, BodyError)>,
}

/// Everything a body is made from.
#[derive(QueryData)]
pub(crate) struct BodyParts {
    kind: &'static RigidBody,
    convex: Option<&'static ConvexMesh>,
    half_space: Option<&'static HalfSpace>,
    transform: &'static Transform,
    linear: &'static LinearVelocity,
    angular: &'static AngularVelocity,
    density: &'static Density,
    mass: Option<&'static MassOverride>,
    friction: &'static Friction,
    restitution: &'static Restitution,
    layers: &'static CollisionLayers,
    fracturable: Option<&'static Fracturable>,
}

/// Observer: an entity got a `RigidBody`. Pieces of a fracture already have their slot.
pub(crate) fn on_body_inserted(
    insert: On<Insert<RigidBody>>,
    handles: Query<&BodyHandle>,
    mut queue: ResMut<BodyQueue>,
) {
    if handles.get(insert.entity).is_ok_and(|h| h.0.is_none()) {
        queue.arrived.push(insert.entity);
    }
}

/// Observer: a `RigidBody` is replaced, removed, or despawned with its entity.
pub(crate) fn on_body_discarded(
    discard: On<Discard<RigidBody>>,
    mut handles: Query<&mut BodyHandle>,
    mut queue: ResMut<BodyQueue>,
) {
    if let Ok(mut handle) = handles.get_mut(discard.entity) {
        queue.left.extend(handle.0.take());
    }
}

/// System: frees the slots of bodies that left, gives slots to those that arrived.
pub(crate) fn register_bodies(
    mut queue: ResMut<BodyQueue>,
    mut bodies: ResMut<Bodies>,
    mut entities: ResMut<BodyEntities>,
    mut cache: ResMut<crate::contact::cache::ContactCache>,
    mut warnings: ResMut<Messages<BodyWarning>>,
    parts: Query<BodyParts>,
    mut handles: Query<&mut BodyHandle>,
) {
    for (slot, id) in queue.left.drain(..) {
        if bodies.contains(slot) && bodies.id(slot) == id {
            bodies.remove(slot);
            cache.remove_body(id);
        }
    }
    if queue.arrived.is_empty() && queue.refused.is_empty() {
        return;
    }
    let earlier = std::mem::take(&mut queue.refused);
    let arrived = std::mem::take(&mut queue.arrived);
    let candidates = earlier
        .into_iter()
        .map(|(e, why)| (e, Some(why)))
        .chain(arrived.into_iter().map(|e| (e, None)));
    for (entity, known_problem) in candidates {
        let (Ok(item), Ok(mut handle)) = (parts.get(entity), handles.get_mut(entity)) else {
            continue;
        };
        if handle.0.is_some() {
            continue;
        }
        match pose_of(item.transform).and_then(|pose| bodies.insert(describe(&item, pose)?)) {
            Ok(slot) => {
                handle.0 = Some((slot, bodies.id(slot)));
                entities.set(slot, bodies.id(slot), entity, *item.transform);
            }
            Err(error) => {
                // As texts, because a NaN in the reason is not equal to itself.
                if known_problem.map(|p| p.to_string()) != Some(error.to_string()) {
                    warn(&mut warnings, entity, error);
                }
                queue.refused.push((entity, error));
            }
        }
    }
}

fn describe(parts: &BodyPartsItem, pose: Pose) -> Result<BodyDesc, BodyError> {
    let shape = match (parts.convex, parts.half_space) {
        (Some(mesh), _) => Shape::Convex(mesh.clone()),
        (None, Some(half_space)) => Shape::HalfSpace(*half_space),
        (None, None) => return Err(BodyError::NoShape),
    };
    Ok(BodyDesc {
        kind: *parts.kind,
        shape,
        pose,
        linear_velocity: parts.linear.0,
        angular_velocity: parts.angular.0,
        density: parts.density.0,
        mass: parts.mass.map(|m| m.0),
        friction: *parts.friction,
        restitution: *parts.restitution,
        layers: *parts.layers,
        fracturable: parts.fracturable.copied(),
    })
}

/// The pose in a `Transform`, which must not be scaled.
fn pose_of(transform: &Transform) -> Result<Pose, BodyError> {
    if transform.scale != Vec3::ONE {
        return Err(BodyError::Scaled(transform.scale));
    }
    Ok(Pose::new(transform.translation, transform.rotation))
}

/// System: poses and velocities that the user changed. A state that is not usable takes the body out until it is.
pub(crate) fn gather_motion(
    mut bodies: ResMut<Bodies>,
    mut entities: ResMut<BodyEntities>,
    mut warnings: ResMut<Messages<BodyWarning>>,
    motion: Query<(
        Entity,
        &BodyHandle,
        &Transform,
        &LinearVelocity,
        &AngularVelocity,
    )>,
) {
    for (entity, handle, transform, linear, angular) in &motion {
        let Some((slot, _)) = handle.0 else { continue };
        match read_motion(
            &mut bodies,
            &mut entities.seen[slot as usize],
            slot,
            transform,
            linear.0,
            angular.0,
        ) {
            Ok(()) => bodies.set_frozen(slot, false),
            Err(error) => {
                if bodies.is_active(slot) {
                    warn(&mut warnings, entity, error);
                }
                bodies.set_frozen(slot, true);
            }
        }
    }
}

fn read_motion(
    bodies: &mut Bodies,
    seen: &mut Transform,
    slot: u32,
    transform: &Transform,
    linear: Vec3,
    angular: Vec3,
) -> Result<(), BodyError> {
    body::check_velocity(linear, angular)?;
    if transform != seen {
        let pose = pose_of(transform)?;
        body::check_pose(&pose)?;
        bodies.set_pose(slot, pose);
        bodies.refresh_world(slot);
        *seen = *transform;
    }
    if bodies.kind(slot) != RigidBody::Static {
        bodies.set_velocity(slot, linear, angular);
    }
    Ok(())
}

/// What of a body's description changed.
type Changes = Or<(
    Changed<ConvexMesh>,
    Changed<HalfSpace>,
    Changed<Density>,
    Changed<MassOverride>,
    Changed<Friction>,
    Changed<Restitution>,
    Changed<CollisionLayers>,
    Changed<Fracturable>,
)>;

/// What of a body's description was taken away.
#[derive(SystemParam)]
pub(crate) struct Removals<'w, 's> {
    convex: RemovedComponents<'w, 's, ConvexMesh>,
    half_space: RemovedComponents<'w, 's, HalfSpace>,
    mass: RemovedComponents<'w, 's, MassOverride>,
    fracturable: RemovedComponents<'w, 's, Fracturable>,
}

impl Removals<'_, '_> {
    fn read(&mut self) -> impl Iterator<Item = Entity> + '_ {
        let shapes = self.convex.read().chain(self.half_space.read());
        shapes
            .chain(self.mass.read())
            .chain(self.fracturable.read())
    }
}

/// System: shapes, densities, materials and layers that the user changed. What is not usable is not taken over.
pub(crate) fn gather_changes(
    mut bodies: ResMut<Bodies>,
    mut warnings: ResMut<Messages<BodyWarning>>,
    changed: Query<Entity, (Changes, With<BodyHandle>)>,
    mut removals: Removals,
    described: Query<(&BodyHandle, BodyParts)>,
) {
    for entity in changed.iter().chain(removals.read()) {
        let Ok((&BodyHandle(Some((slot, _))), parts)) = described.get(entity) else {
            continue;
        };
        // Pose and velocity are gather_motion's business: broken ones must not hide a new shape.
        let desc = describe(&parts, Pose::IDENTITY);
        if let Err(error) = desc.and_then(|desc| bodies.redescribe(slot, desc)) {
            warn(&mut warnings, entity, error);
        }
    }
}

/// System: writes computed mass properties to their entities.
pub(crate) fn publish_mass(
    mut bodies: ResMut<Bodies>,
    entities: Res<BodyEntities>,
    mut masses: Query<&mut MassProperties>,
) {
    for slot in std::mem::take(&mut bodies.fresh_mass) {
        let entity = entities.of(slot, bodies.id(slot));
        if let Some(mut mass) = entity.and_then(|e| masses.get_mut(e).ok()) {
            mass.set_if_neq(*bodies.mass(slot));
        }
    }
}
