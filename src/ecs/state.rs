//! What the plugin keeps for itself from system to system and from step to step.

use crate::bodies::body::BodyError;
use crate::contact::body_id::BodyId;
use crate::ecs::components::BodyEntities;
use crate::fracture::bond::Bond;
use crate::joints::{JointError, JointId};
use crate::math::Plane;
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
    pub(crate) joints: JointQueue,
}

/// What happened to joints' entities since the last step, and which of them hold.
#[derive(Debug, Default)]
pub(crate) struct JointQueue {
    /// Entities that became joints, or stopped to be, in order.
    pub(crate) arrived: Vec<Entity>,
    /// Entities that could not become joints, with the reason; tried again each step, warned about once.
    pub(crate) refused: Vec<(Entity, JointError)>,
    /// Joints that hold, and their entities, ascending.
    pub(crate) entities: Vec<(JointId, Entity)>,
    /// What is to be written to entities of what is wrong with them.
    pub(crate) problems: Vec<(Entity, Option<JointError>)>,
    /// Whether bodies came or went.
    pub(crate) have_bodies_changed: bool,
}

/// What a command asked for.
#[derive(Debug)]
pub(crate) enum BondRequest {
    Pair(Entity, Entity, Bond),
    Neighbors(Vec<Entity>, f32),
    Release(Entity, Entity),
}

/// What commands asked for since the last step, in order.
#[derive(Debug, Default)]
pub(crate) struct BondRequests(pub(crate) Vec<BondRequest>);

/// Cuts that commands asked for since the last step, in order.
#[derive(Debug, Default)]
pub(crate) struct SliceRequests(pub(crate) Vec<(Entity, Plane)>);

/// What happened to bodies' entities since the last step, in the order in which it happened.
///
/// The order of commands decides body ids, not tables or entity numbers: results do not depend on how entities are
/// stored. Observers fill the queue, because what systems are told of removals is forgotten when frames outrun steps.
#[derive(Debug, Default)]
pub(crate) struct BodyQueue {
    pub(crate) arrived: Vec<Entity>,
    pub(crate) left: Vec<(u32, BodyId)>,
    /// Entities that lost a component of their body.
    pub(crate) reduced: Vec<Entity>,
    /// Entities that were marked as sleeping by somebody else.
    pub(crate) marked: Vec<Entity>,
    /// Entities that could not become bodies, with the reason; tried again each step, warned about once.
    pub(crate) refused: Vec<(Entity, BodyError)>,
}
