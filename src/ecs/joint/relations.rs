//! Joints that their bodies do not know of.

use crate::ecs::joint::{JointA, JointB, JointsOfA, JointsOfB};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;

/// What an entity relates to as a joint, and what to it as a body.
pub(super) type JointRelations = (
    Option<&'static JointA>,
    Option<&'static JointB>,
    Option<&'static JointsOfA>,
    Option<&'static JointsOfB>,
);

/// Relates a joint to bodies that do not know of it, so that it goes with them: a body that is cloned with its joints gets clones of these,
/// which bevy_ecs relates to the cloned body alone. One whose other body has gone meanwhile goes too.
pub(super) fn relate_again(
    entity: Entity,
    relations: &Query<JointRelations, Allow<Disabled>>,
    commands: &mut Commands,
) {
    let Ok((a, b, ..)) = relations.get(entity) else {
        return;
    };
    let mut ends = [a.map(|a| a.0), b.map(|b| b.0)].into_iter().flatten();
    if ends.any(|end| !relations.contains(end)) {
        commands.entity(entity).try_despawn();
        return;
    }
    if let Some(&a) = a
        && let Ok((.., of_a, _)) = relations.get(a.0)
        && !of_a.is_some_and(|joints| joints.0.contains(&entity))
    {
        commands.entity(entity).try_insert(a);
    }
    if let Some(&b) = b
        && let Ok((.., of_b)) = relations.get(b.0)
        && !of_b.is_some_and(|joints| joints.0.contains(&entity))
    {
        commands.entity(entity).try_insert(b);
    }
}
