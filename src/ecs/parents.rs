//! Bodies whose entities are children: where they are in the world, and their `Transform` beneath the parent.
//!
//! A dynamic body goes its own way, wherever its parent goes; one that is static or kinematic goes with the parent. Of a chain the
//! `Transform`s of this moment count, not the `GlobalTransform`s, which are of the last frame.

use crate::bodies::body::{BodyError, RigidBody};
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
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

/// Where in the world a body is that does not go with its parent, by its entity, parent and `Transform`.
pub(super) type OwnWay<'f> = &'f dyn Fn(Entity, (Entity, Transform)) -> Option<Pose>;

impl Parents<'_, '_> {
    /// How many entities are above one.
    pub(super) fn depth(&self, entity: Entity) -> usize {
        let above = |&entity: &Entity| Some(self.above.get(entity).ok()?.1?.parent());
        std::iter::successors(Some(entity), above).count() - 1
    }

    /// Where a body is in the world, and by how much its shape is scaled there. Bodies above it may go their own ways.
    pub(crate) fn place(
        &self,
        transform: &Transform,
        child_of: Option<&ChildOf>,
        kind: RigidBody,
        own_way: OwnWay,
    ) -> Result<(Pose, Vec3), BodyError> {
        let above = |entity| self.above.get(entity).ok();
        let parent = child_of.map(|parent| world_of(parent.parent(), &above, own_way));
        if let Some(parent) = parent.filter(|_| kind == RigidBody::Dynamic) {
            let (scale, ..) = parent.to_scale_rotation_translation();
            // However it lies now, it will turn.
            if scale.is_finite() && !is_same_scale(scale, Vec3::splat(scale.x)) {
                return Err(BodyError::Sheared);
            }
        }
        place(transform, parent)
    }
}

/// World of an entity, by going up: `above` tells the `Transform` and the parent of each.
fn world_of<'t>(
    entity: Entity,
    above: &dyn Fn(Entity) -> Option<(&'t Transform, Option<&'t ChildOf>)>,
    own_way: OwnWay,
) -> Affine3A {
    let Some((transform, child_of)) = above(entity) else {
        return Affine3A::IDENTITY;
    };
    let local = transform.compute_affine();
    let Some(parent) = child_of.map(ChildOf::parent) else {
        return local;
    };
    let world = world_of(parent, above, own_way) * local;
    own_way(entity, (parent, *transform)).map_or(world, |pose| {
        let (scale, ..) = world.to_scale_rotation_translation();
        Affine3A::from_scale_rotation_translation(scale, pose.rotation, pose.position)
    })
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

/// Whether scales differ by rounding at most.
pub(super) fn is_same_scale(a: Vec3, b: Vec3) -> bool {
    let difference = (a - b).abs().max_element();
    // Infinite ones are no rounding of each other.
    difference.is_finite() && difference <= ROUNDING * b.abs().max_element()
}

/// Whether poses differ by rounding at most, of coordinates of their size.
pub(super) fn is_same_place(a: Pose, b: Pose) -> bool {
    let size = a.position.abs().max_element().max(1.0);
    let turn = (a.rotation - b.rotation).length();
    let turn = turn.min((a.rotation + b.rotation).length());
    a.position.distance(b.position) <= ROUNDING * size && turn <= ROUNDING
}

/// Whether poses differ by no more than what computing them from coordinates of `size` m by another way makes of them: a few units in
/// the last place, 5e-7 of it. Turns that are each other's negative are one.
pub(super) fn is_rounding(a: Pose, b: Pose, size: f32) -> bool {
    let turn = (a.rotation - b.rotation).length();
    let turn = turn.min((a.rotation + b.rotation).length());
    let shift = a.position.distance(b.position);
    shift <= 4.0 * f32::EPSILON * size.max(1.0) && turn <= 8.0 * f32::EPSILON
}

/// The same of a body at `b` that is no child, and of one that moves by itself: there rounding twice as large, that of a way through
/// another frame and back, is told from a push, as no one's slow motion is lost by it.
pub(super) fn is_rounded_pose(a: Pose, b: Pose, moves: bool) -> bool {
    let size = b.position.abs().max_element().max(1.0);
    is_rounding(a, b, if moves { 2.0 * size } else { size })
}

/// The largest coordinate, m, from which the place of a child is computed: where it is, and how far from its parent.
pub(super) fn reach(local: &Transform, position: Vec3, scale: Vec3) -> f32 {
    let from_parent = local.translation * (scale / local.scale).abs().max_element();
    position.abs().max(from_parent.abs()).max_element()
}

/// A scale without rounding: 1 where it is nearly 1, and one number where it is nearly uniform.
fn rounded(scale: Vec3) -> Vec3 {
    let even = [Vec3::ONE, Vec3::splat(scale.x)];
    let known = even.into_iter().find(|&even| is_same_scale(scale, even));
    known.unwrap_or(scale)
}

/// World of the parent of an entity, if it has one.
pub(super) fn parent_of(world: &World, entity: Entity) -> Option<Affine3A> {
    let parent = world.get::<ChildOf>(entity)?.parent();
    let above = |entity| {
        let transform = world.get::<Transform>(entity)?;
        Some((transform, world.get::<ChildOf>(entity)))
    };
    Some(world_of(parent, &above, &|_, _| None))
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
        let is_there =
            |&(slot, id): &(u32, BodyId)| bodies.is_current(slot, id) && bodies.is_active(slot);
        let Some((slot, _)) = body.filter(is_there) else {
            continue;
        };
        // One that stands where its parent brings it has the `Transform` that it was given.
        let is_moved = match bodies.kind(slot) {
            RigidBody::Dynamic => true,
            RigidBody::Kinematic => bodies.velocity(slot) != (Vec3::ZERO, Vec3::ZERO),
            RigidBody::Static => false,
        };
        let pose = bodies.pose(slot);
        let above = world.get::<ChildOf>(entity).map(ChildOf::parent);
        let parent = parent_of(world, entity).filter(|_| is_moved);
        let (Some(above), Some(parent)) = (above, parent) else {
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
        let is_set = known.is_none_or(|(_, local)| local != *transform)
            && transform.last_changed().is_newer_than(read, now);
        if is_set || known.is_some_and(|(parent, _)| parent != above) {
            continue;
        }
        let local = local_of(&parent, pose, transform.scale);
        if local.is_finite() {
            transform.set_if_neq(local);
            let entities = &mut world.resource_mut::<PluginState>().entities;
            entities.set_local(slot, above, local);
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
