//! The components that say what is wrong, in line with what is.

use crate::ecs::issues::BodyIssues;
use crate::ecs::state::PluginState;
use bevy_ecs::prelude::*;

/// Command: brings the components in line with what is wrong.
pub(crate) fn sync_issues(world: &mut World) {
    let mut issues = std::mem::take(&mut world.resource_mut::<PluginState>().issues);
    issues
        .known
        .retain(|issue| world.get_entity(issue.entity).is_ok());
    for entity in issues.changed.drain(..) {
        let of_entity = issues.known.iter().filter(|issue| issue.entity == entity);
        let problems: Vec<_> = of_entity.map(|issue| issue.problem.clone()).collect();
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
