//! What the plugin keeps for itself from system to system and from step to step.

use crate::contact::body_id::BodyId;
use crate::ecs::components::BodyEntities;
use crate::ecs::issues::Issues;
use crate::ecs::kinematic::KinematicTarget;
use crate::ecs::scaled_shapes::ScaledShapes;
use crate::fracture::bond::Bond;
use crate::joints::{JointError, JointId};
use crate::math::Plane;
use crate::step::{ContactWatch, StepSettings};
use bevy_ecs::component::ComponentId;
use bevy_ecs::entity::{EntityIndexMap, EntityIndexSet};
use bevy_ecs::prelude::*;

/// One resource for all of it: in a step of one body, to fetch resources is a good part of what the plugin adds.
#[derive(Clone, Debug, Default, Resource)]
pub(crate) struct PluginState {
    /// What the phases of the present step are told.
    pub(crate) settings: StepSettings,
    pub(crate) entities: BodyEntities,
    pub(crate) scaled: ScaledShapes,
    pub(crate) queue: BodyQueue,
    pub(crate) slice_requests: SliceRequests,
    pub(crate) bond_requests: BondRequests,
    /// Entities whose bonds are described, and not all made yet.
    pub(crate) bond_constructors: Vec<Entity>,
    pub(crate) options: OptionQueue,
    pub(crate) issues: Issues,
    /// Components that could not be cloned for pieces, and were named.
    pub(crate) uncloned: Vec<ComponentId>,
    /// Entities of bodies with parents.
    pub(crate) children: Vec<Entity>,
    /// Kinematic bodies that are moved by their `Transform` in this step.
    pub(crate) kinematic: Vec<KinematicTarget>,
    /// Whether there may be news of contacts.
    pub(crate) is_watching: bool,
    /// Bodies that left since the last news, if there are any, and their entities.
    pub(crate) departed: Vec<(BodyId, Entity)>,
    pub(crate) joints: JointQueue,
}

/// What happened to joints' entities since the last step, and which of them hold.
#[derive(Clone, Debug, Default)]
pub(crate) struct JointQueue {
    /// Entities that became joints, or stopped to be, in order.
    pub(crate) arrived: Vec<Entity>,
    /// Entities that could not become joints, with the reason, or none if a shape is still to come; tried again each step, warned about once.
    pub(crate) refused: EntityIndexMap<Option<JointError>>,
    /// Joints that hold, and their entities, ascending.
    pub(crate) entities: Vec<(JointId, Entity)>,
    /// What is to be written to entities of what is wrong with them.
    pub(crate) problems: Vec<(Entity, Option<JointError>)>,
    /// Whether bodies came or went.
    pub(crate) have_bodies_changed: bool,
}

/// What a command asked for.
#[derive(Clone, Debug)]
pub(crate) enum BondRequest {
    Pair(Entity, Entity, Bond),
    Neighbors(Vec<Entity>, f32),
    Release(Entity, Entity),
    ReleaseAll(Entity),
}

/// What commands asked for since the last step, in order.
#[derive(Clone, Debug, Default)]
pub(crate) struct BondRequests(pub(crate) Vec<BondRequest>);

/// Cuts that commands asked for since the last step, in order.
#[derive(Clone, Debug, Default)]
pub(crate) struct SliceRequests(pub(crate) Vec<(Entity, Plane)>);

/// What happened to bodies' entities since the last step, in the order in which it happened.
///
/// The order of commands decides body ids, not tables or entity numbers: results do not depend on how entities are
/// stored. Observers fill the queue, because what systems are told of removals is forgotten when frames outrun steps.
#[derive(Clone, Debug, Default)]
pub(crate) struct BodyQueue {
    pub(crate) arrived: Vec<Entity>,
    pub(crate) left: Vec<(u32, BodyId)>,
    /// Entities of bodies that are to be described again, as they lost a component or await a shape.
    pub(crate) reduced: Vec<Entity>,
    /// Entities that were marked as sleeping by somebody else.
    pub(crate) marked: Vec<Entity>,
    /// Entities that could not become bodies; tried again each step.
    pub(crate) refused: EntityIndexSet,
    /// Bodies whose entities got another `RigidBody`.
    pub(crate) changed_kind: Vec<Entity>,
    /// Entities of bodies that became static: what they moved by is no velocity of theirs any more.
    pub(crate) halted: Vec<Entity>,
    /// Entities that were disabled or enabled.
    pub(crate) toggled: Vec<Entity>,
    /// Entities with impulses that wait, as they had no body, or one that took no part.
    pub(crate) pushed: Vec<Entity>,
    /// Entities with something of a body that had no `RigidBody` when they got or lost it, or that are bodies no more.
    pub(crate) lone_parts: Vec<Entity>,
}

/// What was asked of the options since the last step.
#[derive(Clone, Debug, Default)]
pub(crate) struct OptionQueue {
    /// Whether any entity ever had one.
    pub(crate) is_used: bool,
    /// Entities whose options came or went, or that became bodies.
    pub(crate) entities: Vec<Entity>,
    /// Bodies whose contacts are to be watched otherwise.
    pub(crate) watches: Vec<(u32, BodyId, ContactWatch)>,
}

impl OptionQueue {
    /// Reads the options of these entities again, if there are any: kind or scale of their bodies changed.
    pub(crate) fn read_again(&mut self, entities: &[Entity]) {
        if self.is_used {
            self.entities.extend_from_slice(entities);
        }
    }
}
