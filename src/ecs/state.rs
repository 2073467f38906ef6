//! What the plugin keeps for itself from system to system and from step to step.

use super::bond::BondRequests;
use super::components::BodyEntities;
use super::cut::SliceRequests;
use super::gather::BodyQueue;
use crate::step::StepSettings;
use bevy_ecs::prelude::*;

/// One resource for all of it: in a step of one body, to fetch resources is a good part of what the plugin adds.
#[derive(Debug, Default, Resource)]
pub(crate) struct PluginState {
    /// What the phases of the present step are told.
    pub(crate) settings: StepSettings,
    pub(crate) entities: BodyEntities,
    pub(crate) queue: BodyQueue,
    pub(crate) slice_requests: SliceRequests,
    pub(crate) bond_requests: BondRequests,
}
