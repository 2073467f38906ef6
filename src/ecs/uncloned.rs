//! Components that pieces cannot get.

use crate::ecs::components::{BodyProblem, BodyWarning, warn};
use crate::ecs::state::PluginState;
use bevy_ecs::component::{ComponentCloneBehavior, ComponentId};
use bevy_ecs::prelude::*;

/// Names, once each, the components of the parent that could not be cloned because they are not `Clone`.
pub(super) fn name_uncloned(world: &mut World, parent: Entity, piece: Option<Entity>) {
    let Some(piece) = piece.and_then(|piece| world.get_entity(piece).ok()) else {
        return;
    };
    let Ok(entity) = world.get_entity(parent) else {
        return;
    };
    let is_lost = |id: &&ComponentId| {
        let info = world.components().get_info(**id);
        // Who says `Ignore` means it.
        let is_default = |behavior| matches!(behavior, &ComponentCloneBehavior::Default);
        !piece.contains_id(**id) && info.is_some_and(|info| is_default(info.clone_behavior()))
    };
    let known = &world.resource::<PluginState>().uncloned;
    let lost = entity.archetype().components().iter().filter(is_lost);
    let lost: Vec<ComponentId> = lost.copied().filter(|id| !known.contains(id)).collect();
    for id in lost {
        let name = world.components().get_name(id).map(|name| name.to_string());
        world.resource_mut::<PluginState>().uncloned.push(id);
        let problem = BodyProblem::NotCloned(name.unwrap_or_default());
        warn(
            &mut world.resource_mut::<Messages<BodyWarning>>(),
            parent,
            problem,
        );
    }
}
