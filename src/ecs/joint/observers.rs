//! What is noted of joints as it happens.

use crate::ecs::joint::{JointA, JointB};
use crate::ecs::state::PluginState;
use crate::joints::Joint;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;

/// Observer: an entity became a joint, or joins other bodies now.
pub(crate) fn on_joint_inserted(
    insert: On<Insert<(Joint, JointA, JointB)>>,
    mut state: ResMut<PluginState>,
) {
    state.joints.arrived.push(insert.entity);
}

/// Observer: a joint is no more, or lost a body.
pub(crate) fn on_joint_removed(
    remove: On<Remove<(Joint, JointA, JointB)>>,
    mut state: ResMut<PluginState>,
) {
    state.joints.arrived.push(remove.entity);
}

/// Observer: an entity was disabled.
pub(crate) fn on_disabled(
    insert: On<Insert<Disabled>>,
    joints: Query<(), (With<Joint>, Allow<Disabled>)>,
    mut state: ResMut<PluginState>,
) {
    if joints.contains(insert.entity) {
        state.joints.arrived.push(insert.entity);
    }
}

/// Observer: an entity is enabled again.
pub(crate) fn on_enabled(
    remove: On<Remove<Disabled>>,
    joints: Query<(), (With<Joint>, Allow<Disabled>)>,
    mut state: ResMut<PluginState>,
) {
    if joints.contains(remove.entity) {
        state.joints.arrived.push(remove.entity);
    }
}
