//! Where entities beneath others are.
#![allow(dead_code, reason = "not every program puts entities beneath others")]

use bevy_ecs::prelude::*;
use bevy_math::{Affine3A, Mat4};
use bevy_transform::components::Transform;

/// World of an entity by the `Transform`s of this moment.
pub(crate) fn world_of(world: &World, entity: Entity) -> Affine3A {
    let up = |&entity: &Entity| world.get::<ChildOf>(entity).map(ChildOf::parent);
    let chain = std::iter::successors(Some(entity), up);
    chain.fold(Affine3A::IDENTITY, |below, entity| {
        let own = world.get::<Transform>(entity).copied();
        own.unwrap_or_default().compute_affine() * below
    })
}

/// The `Transform` beneath a parent, or none, of what is at a place, as Bevy's `set_parent_in_place` makes it.
pub(crate) fn local_beneath(world: &World, parent: Option<Entity>, place: Affine3A) -> Transform {
    let above = parent.map_or(Affine3A::IDENTITY, |parent| world_of(world, parent));
    Transform::from_matrix(Mat4::from(above.inverse() * place))
}
