//! Bonds as data that a scene file can hold, and descriptions of all that the plugin simulates.

use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::ecs::components::{BodyHandle, BodyWarning, ShapeAwaited, not_cloned};
use crate::ecs::issues::Source;
use crate::ecs::shape_constructor::note;
use crate::ecs::state::PluginState;
use crate::fracture::{Bond, BondError, Bonds};
use crate::math::Pose;
use bevy_ecs::entity::MapEntities;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use std::any::TypeId;

/// Bonds of this body to others, to be made as soon as both have bodies. Those that are made are taken off the list, and the component
/// goes when it is empty.
///
/// For scene files, as [`ShapeConstructor`](crate::ecs::ShapeConstructor) is for shapes; [`describe_bodies`](crate::ecs::describe_bodies)
/// writes it. A bond that cannot be made stays, and is named in [`BodyIssues`](crate::ecs::BodyIssues).
#[derive(Clone, Component, Debug, Default, PartialEq)]
#[component(on_insert = Self::ask, on_remove = Self::forget, clone_behavior = Custom(not_cloned))]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct BondConstructor {
    /// In any order.
    #[entities]
    pub bonds: Vec<BondDescription>,
}

/// A bond as data.
#[derive(Clone, Copy, Debug, MapEntities, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct BondDescription {
    /// The other body.
    #[entities]
    pub entity: Entity,
    /// What holds them together.
    pub bond: Bond,
    /// Where the frame of the other's shape was in that of this one when they were bonded.
    pub pose: Pose,
}

impl BondConstructor {
    /// Hook: the next step looks at it.
    fn ask(mut world: DeferredWorld, context: HookContext) {
        let entity = context.entity;
        world.commands().queue(move |world: &mut World| {
            // Before the plugin is there, `adopt_bonds` finds it.
            if let Some(mut state) = world.get_resource_mut::<PluginState>() {
                state.bond_constructors.push(entity);
            }
        });
    }

    /// Hook: nothing is wrong with bonds that nobody asks for.
    fn forget(mut world: DeferredWorld, context: HookContext) {
        let entity = context.entity;
        world
            .commands()
            .queue(move |world: &mut World| note::<Self, BondError>(world, entity, Ok(())));
    }
}

/// Those that were there before the plugin.
pub(crate) fn adopt_bonds(world: &mut World) {
    let mut found = world.query_filtered::<Entity, (With<BondConstructor>, Allow<Disabled>)>();
    let mut found: Vec<Entity> = found.iter(world).collect();
    found.sort_unstable();
    let mut state = world.resource_mut::<PluginState>();
    state.bond_constructors.extend(found);
}

/// Run condition of [`make_described_bonds`].
pub(crate) fn any_bond_is_described(state: Res<PluginState>) -> bool {
    !state.bond_constructors.is_empty()
}

/// System: makes the bonds that are described, once their entities have bodies.
pub(crate) fn make_described_bonds(
    mut state: ResMut<PluginState>,
    (mut bodies, mut bonds): (ResMut<Bodies>, ResMut<Bonds>),
    mut warnings: ResMut<Messages<BodyWarning>>,
    mut constructors: Query<&mut BondConstructor, Allow<Disabled>>,
    ends: Query<BondEnd, Allow<Disabled>>,
    mut commands: Commands,
) {
    let mut asked = std::mem::take(&mut state.bond_constructors);
    asked.retain(|&entity| {
        let Ok(mut constructor) = constructors.get_mut(entity) else {
            return false;
        };
        let mut found = Ok(());
        constructor
            .bypass_change_detection()
            .bonds
            .retain(|described| {
                let made = make(entity, described, &mut bodies, &mut bonds, &ends);
                if let Err(Unmade::Refused(error)) = made {
                    found = Err(error);
                }
                made.is_err()
            });
        if constructor.bonds.is_empty() {
            commands.entity(entity).try_remove::<BondConstructor>();
            return false;
        }
        let source = Source::Constructor(TypeId::of::<BondConstructor>());
        (state.issues).note(&mut warnings, entity, source, found);
        true
    });
    state.bond_constructors.append(&mut asked);
}

/// One end of a bond, and why its body may be still to come.
type BondEnd = (
    Option<&'static BodyHandle>,
    Has<ShapeAwaited>,
    Has<Disabled>,
);

/// Why a described bond is not there.
enum Unmade {
    /// A body is still to come.
    Waits,
    Refused(BondError),
}

/// Makes a bond unless it is there.
fn make(
    entity: Entity,
    described: &BondDescription,
    bodies: &mut Bodies,
    bonds: &mut Bonds,
    ends: &Query<BondEnd, Allow<Disabled>>,
) -> Result<(), Unmade> {
    let body_of = |bodies: &Bodies, entity: Entity| {
        let end = ends.get(entity).ok();
        let body = end.and_then(|(handle, ..)| handle?.0);
        let body = body.filter(|&(slot, id): &(u32, BodyId)| bodies.is_current(slot, id));
        body.map(|(slot, _)| slot).ok_or(match end {
            Some((_, true, _) | (.., true)) => Unmade::Waits,
            _ => Unmade::Refused(BondError::NoBody),
        })
    };
    let a = body_of(bodies, entity)?;
    let b = body_of(bodies, described.entity)?;
    let BondDescription { bond, pose, .. } = *described;
    let is_there = bonds.get(bodies, a, b) == Some(&bond);
    // To make it anew would wake what sleeps on it.
    if is_there && bonds.rest_pose(bodies, a, b) == Some(pose) {
        return Ok(());
    }
    let made = bonds.bond_at(bodies, a, b, bond, pose);
    made.map_err(Unmade::Refused)
}
