//! Children of a body that breaks: they go to the piece that holds them.

use crate::bodies::store::Bodies;
use crate::ecs::components::BodyHandle;
use crate::ecs::parents::{local_of, parent_of};
use crate::ecs::state::PluginState;
use crate::geometry::ConvexHull;
use crate::math::Pose;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_transform::components::Transform;

/// What becomes of the children of an entity whose body breaks; a component of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum ChildrenOfPieces {
    /// Each goes to the piece that its origin is in, or else to the nearest, and stays where it is in the world. The default,
    /// without this component too. Those that have no `Transform` go to the first piece.
    #[default]
    ToNearest,
    /// They are despawned with the parent.
    Despawn,
}

/// Gives the children of `parent` to its pieces (slots and entities).
pub(super) fn hand_on_children(world: &mut World, parent: Entity, pieces: &[(u32, Entity)]) {
    let rule = world
        .get::<ChildrenOfPieces>(parent)
        .copied()
        .unwrap_or_default();
    let children = world
        .get::<Children>(parent)
        .map(|children| children.to_vec());
    if rule == ChildrenOfPieces::Despawn {
        return;
    }
    for child in children.into_iter().flatten() {
        let place = place_of(world, child);
        let alive = |&&(_, piece): &&(u32, Entity)| world.get_entity(piece).is_ok();
        let piece = match place {
            Some((_, pose)) => nearest(world, pieces.iter().filter(alive), pose.position),
            None => pieces.iter().find(alive).map(|&(_, piece)| piece),
        };
        if let Some(piece) = piece {
            put_beneath(world, child, piece, place);
        }
    }
}

/// Gives an entity another `Transform`; its children stay where they are in the world.
pub(super) fn move_without_children(world: &mut World, entity: Entity, transform: Transform) {
    let children = world.get::<Children>(entity);
    let children = children.map_or(Vec::new(), |children| children.to_vec());
    let places: Vec<_> = (children.into_iter())
        .map(|child| (child, place_of(world, child)))
        .collect();
    world.entity_mut(entity).insert(transform);
    for (child, place) in places.into_iter().filter(|(_, place)| place.is_some()) {
        put_beneath(world, child, entity, place);
    }
}

/// Scale and pose of a child in the world, if it has a place there.
fn place_of(world: &World, child: Entity) -> Option<(Vec3, Pose)> {
    let local = world.get::<Transform>(child)?;
    let above = parent_of(world, child)?;
    let (scale, rotation, translation) =
        (above * local.compute_affine()).to_scale_rotation_translation();
    Some((scale, Pose::new(translation, rotation)))
}

/// Makes an entity a child of another one, at a place in the world.
fn put_beneath(world: &mut World, child: Entity, parent: Entity, place: Option<(Vec3, Pose)>) {
    let local = place.and_then(|(scale, pose)| {
        let parent_world = parent_of(world, parent).unwrap_or_default()
            * world.get::<Transform>(parent)?.compute_affine();
        let (above, ..) = parent_world.to_scale_rotation_translation();
        Some(local_of(&parent_world, pose, scale / above))
    });
    let mut child = world.entity_mut(child);
    child.insert(ChildOf(parent));
    if let Some(local) = local {
        child.insert(local);
    }
    let body = child.get::<BodyHandle>().and_then(|handle| handle.0);
    if let (Some((slot, _)), Some(local)) = (body, local) {
        // It is where it was: no news to its body.
        world
            .resource_mut::<PluginState>()
            .entities
            .set_local(slot, parent, local);
    }
}

/// The piece that a point (world, m) is in, or is nearest to by the planes of its faces.
fn nearest<'p>(
    world: &World,
    pieces: impl Iterator<Item = &'p (u32, Entity)>,
    point: Vec3,
) -> Option<Entity> {
    let bodies = world.resource::<Bodies>();
    let distance = |slot: u32| {
        let local = bodies.pose(slot).inverse_transform_point(point);
        let above = |hull: &ConvexHull, at: Vec3| {
            let heights = hull.faces().iter().map(|face| face.plane.distance(at));
            heights.fold(f32::NEG_INFINITY, f32::max)
        };
        if let Some(compound) = bodies.compound(slot) {
            let parts = compound.parts().iter();
            let heights = parts
                .map(|part| above(part.shape.hull(), part.pose.inverse_transform_point(local)));
            return heights.fold(f32::INFINITY, f32::min);
        }
        let mesh = bodies.convex(slot);
        mesh.map_or(f32::NEG_INFINITY, |mesh| above(mesh.hull(), local))
    };
    let pieces = pieces.map(|&(slot, piece)| (distance(slot), piece));
    let nearest = pieces.min_by(|(a, _), (b, _)| a.total_cmp(b));
    nearest.map(|(_, piece)| piece)
}
