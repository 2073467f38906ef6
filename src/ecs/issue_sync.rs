//! The components that say what is wrong, in line with what is.

use crate::ecs::issues::BodyIssues;
use crate::ecs::state::PluginState;
use bevy_ecs::prelude::*;

/// Command: brings the components in line with what is wrong.
pub(crate) fn sync_issues(world: &mut World) {
    let mut issues = std::mem::take(&mut world.resource_mut::<PluginState>().issues);
    issues.retain(|entity| world.get_entity(entity).is_ok());
    for entity in std::mem::take(&mut issues.changed) {
        let problems = issues.problems(entity);
        let Ok(mut entity) = world.get_entity_mut(entity) else {
            continue;
        };
        if problems.is_empty() {
            entity.remove::<BodyIssues>();
        } else {
            entity.insert(BodyIssues(problems));
        }
    }
    world.resource_mut::<PluginState>().issues = issues;
}
