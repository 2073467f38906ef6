//! Bodies whose entities are children: where they are in the world, and their `Transform` beneath the parent.
//!
//! A dynamic body goes its own way, wherever its parent goes; one that is static or kinematic goes with the parent. Of a chain the
//! `Transform`s of this moment count, not the `GlobalTransform`s, which are of the last frame.

use crate::bodies::body::{BodyError, RigidBody};
use crate::bodies::store::Bodies;
use crate::ecs::components::BodyHandle;
use crate::ecs::state::PluginState;
use crate::math::Pose;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::query::Allow;
use bevy_ecs::system::SystemParam;
use bevy_math::{Affine3A, Vec3};
use bevy_transform::components::Transform;

/// Difference of a scale from 1, or of scales from each other, that is rounding.
const ROUNDING: f32 = 1e-5;

/// Shear of a child beneath a scaled parent that is rounding: components of a unit matrix.
const SHEAR: f32 = 1e-4;

/// The chains above entities.
#[derive(SystemParam)]
pub(crate) struct Parents<'w, 's> {
    above: Query<'w, 's, (&'static Transform, Option<&'static ChildOf>), Allow<Disabled>>,
}

impl Parents<'_, '_> {
    /// Where a body is in the world, and by how much its shape is scaled there.
    pub(crate) fn place(
        &self,
        transform: &Transform,
        child_of: Option<&ChildOf>,
    ) -> Result<(Pose, Vec3), BodyError> {
        let above = |entity| self.above.get(entity).ok();
        place(
            transform,
            child_of.map(|parent| world_of(parent.parent(), above)),
        )
    }
}

/// The place of a body whose parent is at `parent`, if it has one.
pub(super) fn place(
    transform: &Transform,
    parent: Option<Affine3A>,
) -> Result<(Pose, Vec3), BodyError> {
    let Some(parent) = parent else {
        let pose = Pose::new(transform.translation, transform.rotation);
        return Ok((pose, rounded(transform.scale)));
    };
    let world = parent * transform.compute_affine();
    let (scale, rotation, translation) = world.to_scale_rotation_translation();
    let again = Affine3A::from_scale_rotation_translation(scale, rotation, translation);
    let most = scale.abs().max_element();
    let shear = (again.matrix3 - world.matrix3).to_cols_array();
    // Nothing to compare where there are no finite numbers: these are named as what they are.
    if shear.iter().any(|off| off.abs() > SHEAR * most) {
        return Err(BodyError::Sheared);
    }
    Ok((Pose::new(translation, rotation.normalize()), rounded(scale)))
}

/// A scale without rounding: 1 where it is nearly 1, and one number where it is nearly uniform.
fn rounded(scale: Vec3) -> Vec3 {
    if (scale - Vec3::ONE).abs().max_element() <= ROUNDING {
        return Vec3::ONE;
    }
    if (scale - scale.x).abs().max_element() <= ROUNDING * scale.x.abs() {
        return Vec3::splat(scale.x);
    }
    scale
}

/// World of an entity, by going up.
fn world_of<'w>(
    entity: Entity,
    above: impl Fn(Entity) -> Option<(&'w Transform, Option<&'w ChildOf>)>,
) -> Affine3A {
    let (mut world, mut next) = (Affine3A::IDENTITY, Some(entity));
    while let Some((transform, child_of)) = next.and_then(&above) {
        world = transform.compute_affine() * world;
        next = child_of.map(ChildOf::parent);
    }
    world
}

/// World of the parent of an entity, if it has one.
pub(super) fn parent_of(world: &World, entity: Entity) -> Option<Affine3A> {
    let parent = world.get::<ChildOf>(entity)?.parent();
    let above = |entity| {
        let transform = world.get::<Transform>(entity)?;
        Some((transform, world.get::<ChildOf>(entity)))
    };
    Some(world_of(parent, above))
}

/// The `Transform` beneath a parent of a body at `pose`; its scale stays what it is.
pub(super) fn local_of(parent: &Affine3A, pose: Pose, scale: Vec3) -> Transform {
    let (_, rotation, _) = parent.to_scale_rotation_translation();
    Transform {
        translation: parent.inverse().transform_point3(pose.position),
        rotation: (rotation.inverse() * pose.rotation).normalize(),
        scale,
    }
}

/// Command: writes the `Transform`s of bodies that are children, from the root down.
pub(crate) fn write_children(world: &mut World) {
    let mut children = std::mem::take(&mut world.resource_mut::<PluginState>().children);
    let depth = |world: &World, entity: Entity| {
        let up = |entity: &Entity| world.get::<ChildOf>(*entity).map(ChildOf::parent);
        std::iter::successors(Some(entity), up).count()
    };
    children.sort_by_cached_key(|&entity| depth(world, entity));
    for &entity in &children {
        let body = world.get::<BodyHandle>(entity).and_then(|handle| handle.0);
        let bodies = world.resource::<Bodies>();
        let Some((slot, _)) = body.filter(|&(slot, id)| bodies.is_current(slot, id)) else {
            continue;
        };
        // One that stands where its parent brings it has the `Transform` that it was given.
        let is_moved = match bodies.kind(slot) {
            RigidBody::Dynamic => true,
            RigidBody::Kinematic => bodies.velocity(slot) != (Vec3::ZERO, Vec3::ZERO),
            RigidBody::Static => false,
        };
        let pose = bodies.pose(slot);
        let Some(parent) = parent_of(world, entity).filter(|_| is_moved) else {
            continue;
        };
        let (now, entities) = (
            world.change_tick(),
            &world.resource::<PluginState>().entities,
        );
        let (read, known) = (entities.read, entities.local(slot));
        let Some(mut transform) = world.get_mut::<Transform>(entity) else {
            continue;
        };
        // What somebody else has changed meanwhile is for the next step to read.
        if known != Some(*transform) && transform.last_changed().is_newer_than(read, now) {
            continue;
        }
        let local = local_of(&parent, pose, transform.scale);
        if local.is_finite() {
            transform.set_if_neq(local);
            let entities = &mut world.resource_mut::<PluginState>().entities;
            entities.set_local(slot, local);
            // What this reads as is no news.
            if let Ok((pose, scale)) = place(&local, Some(parent)) {
                entities.seen[slot as usize] = Transform {
                    translation: pose.position,
                    rotation: pose.rotation,
                    scale,
                };
            }
        }
    }
    world.resource_mut::<PluginState>().children = children;
}
