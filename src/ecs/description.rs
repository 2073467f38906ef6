//! Everything that is simulated, described so that a scene file can hold it.

use crate::bodies::store::Bodies;
use crate::ecs::bond_constructor::{BondConstructor, BondDescription};
use crate::ecs::parts::CompoundOfChildren;
use crate::ecs::shape_constructor::{
    CompoundConstructor, Constructor, LevelConstructor, ShapeConstructor,
};
use crate::ecs::state::PluginState;
use crate::fracture::Bonds;
use bevy_ecs::entity::EntityIndexMap;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;

/// Describes all shapes and bonds as they are now, so that a scene file holds whatever is simulated: call it before a game is saved, or run
/// it as a system.
///
/// Entities with a [`ConvexMesh`](crate::geometry::ConvexMesh), a [`Compound`](crate::geometry::Compound) or a
/// [`StaticMesh`](crate::geometry::StaticMesh), pieces among them, get the constructor of that, unless they have one that makes the same; the
/// first body of each bond gets a [`BondConstructor`]. The simulation goes on as if nothing had been asked. Chapter "Saving" of
/// `docs/features.md` says what a file holds then, and what it does not.
pub fn describe_bodies(world: &mut World) {
    describe_shapes::<ShapeConstructor>(world);
    describe_shapes::<CompoundConstructor>(world);
    describe_shapes::<LevelConstructor>(world);
    describe_bonds(world);
    world.flush();
}

fn describe_shapes<C: Constructor>(world: &mut World) {
    // What is made of children is described by these.
    type IsWanted = (Without<CompoundOfChildren>, Allow<Disabled>);
    let mut shapes = world.query_filtered::<(Entity, &C::Shape, Option<&C>), IsWanted>();
    let outdated = |(entity, shape, constructor): (Entity, &C::Shape, Option<&C>)| {
        let described = C::describe(shape);
        let makes = |it: &C| {
            let again = || it.build().map(|built| C::describe(&built));
            *it == described || again().is_ok_and(|again| again == described)
        };
        (!constructor.is_some_and(makes)).then_some((entity, described))
    };
    let outdated: Vec<(Entity, C)> = shapes.iter(world).filter_map(outdated).collect();
    for (entity, constructor) in outdated {
        world.entity_mut(entity).insert(constructor);
    }
    // The shape was taken away, unless none could be made.
    let mut idle = world.query_filtered::<(Entity, &C), (Without<C::Shape>, Allow<Disabled>)>();
    let idle: Vec<Entity> = idle
        .iter(world)
        .filter(|(_, constructor)| constructor.build().is_ok())
        .map(|(entity, _)| entity)
        .collect();
    for entity in idle {
        world.entity_mut(entity).remove::<C>();
    }
}

fn describe_bonds(world: &mut World) {
    let (Some(bodies), Some(bonds), Some(state)) = (
        world.get_resource::<Bodies>(),
        world.get_resource::<Bonds>(),
        world.get_resource::<PluginState>(),
    ) else {
        return;
    };
    let mut described = EntityIndexMap::<BondConstructor>::default();
    for ([a, b], &bond) in bonds.iter() {
        let entity_of = |slot| state.entities.of(slot, bodies.id(slot));
        let ends = entity_of(a).zip(entity_of(b));
        if let (Some((a, entity)), Some(pose)) = (ends, bonds.rest_pose(bodies, a, b)) {
            let bond = BondDescription { entity, bond, pose };
            described.entry(a).or_default().bonds.push(bond);
        }
    }
    for (entity, constructor) in described {
        world.entity_mut(entity).insert(constructor);
    }
}
