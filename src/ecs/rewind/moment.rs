//! The physics of an app at the end of a step.

use crate::bodies::body::RigidBody;
use crate::bodies::store::Bodies;
use crate::contact::impulses::ContactCache;
use crate::ecs::components::{AngularVelocity, BodyHandle, LinearVelocity};
use crate::ecs::rewind::values::{InPhysics, Kept, Values};
use crate::ecs::set_aside::bring_back;
use crate::ecs::state::PluginState;
use crate::fracture::{Bonds, Fractures};
use crate::joints::{Joint, Joints};
use crate::query::QueryIndex;
use crate::step::{Contacts, StepReport};
use bevy_ecs::change_detection::Tick;
use bevy_ecs::entity::{EntityHashMap, EntityHashSet};
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;

/// The physics was taken back: sent as a message, and as an event.
#[derive(Clone, Debug, PartialEq, Eq, Event, Message)]
pub struct Rewound {
    /// By how many steps.
    pub steps: u64,
    /// Entities of bodies and joints that did not exist then: they are despawned.
    pub removed: Vec<Entity>,
    /// Entities that had broken since, and are whole again.
    pub returned: Vec<Entity>,
    /// Entities that the app has despawned since: they do not come back, and their bodies are gone with them.
    pub lost: Vec<Entity>,
}

/// The physics at the end of a step.
pub(super) struct Moment {
    /// Number of the step.
    pub(super) step: u64,
    /// When it was.
    tick: Tick,
    simulated: Simulated,
    /// Entities of bodies and joints.
    tracked: EntityHashSet,
    values: Vec<Box<dyn Kept>>,
    /// Whose children those beneath bodies were, and where.
    children: Vec<(Entity, ChildOf, Option<Transform>)>,
}

/// The plugin's resources that steps change.
#[derive(Clone)]
struct Simulated {
    bodies: Bodies,
    contacts: Contacts,
    cache: ContactCache,
    fractures: Fractures,
    bonds: Bonds,
    joints: Joints,
    report: StepReport,
    state: PluginState,
}

impl Simulated {
    fn of(world: &World) -> Self {
        Self {
            bodies: world.resource::<Bodies>().clone(),
            contacts: world.resource::<Contacts>().clone(),
            cache: world.resource::<ContactCache>().clone(),
            fractures: world.resource::<Fractures>().clone(),
            bonds: world.resource::<Bonds>().clone(),
            joints: world.resource::<Joints>().clone(),
            report: world.resource::<StepReport>().clone(),
            state: world.resource::<PluginState>().clone(),
        }
    }

    fn put_into(self, world: &mut World) {
        let now = &world.resource::<PluginState>().entities;
        let (read, written) = (now.read, now.written);
        let mut state = self.state;
        (state.entities.read, state.entities.written) = (read, written);
        world.insert_resource(self.bodies);
        world.insert_resource(self.contacts);
        world.insert_resource(self.cache);
        world.insert_resource(self.fractures);
        world.insert_resource(self.bonds);
        world.insert_resource(self.joints);
        world.insert_resource(self.report);
        world.insert_resource(state);
        if let Some(mut index) = world.get_resource_mut::<QueryIndex>() {
            *index = QueryIndex::default();
        }
    }
}

impl Moment {
    /// The physics as it is.
    pub(super) fn take(world: &mut World, step: u64, values: &mut [Box<dyn Values>]) -> Self {
        let tracked = tracked(world);
        Self {
            step,
            tick: world.change_tick(),
            simulated: Simulated::of(world),
            values: values.iter_mut().map(|values| values.keep(world)).collect(),
            children: children_of(world, &tracked),
            tracked: tracked.into_iter().collect(),
        }
    }

    /// Makes the physics what it was. `aside`: what was set aside since.
    pub(super) fn restore(&self, world: &mut World, steps: u64, aside: Vec<Entity>) -> Rewound {
        // What was born and broke since has been for nothing.
        let (old, new): (Vec<Entity>, Vec<Entity>) =
            (aside.into_iter()).partition(|entity| self.tracked.contains(entity));
        let mut returned = old;
        returned.retain(|&entity| bring_back(world, entity));
        for kept in &self.values {
            kept.restore(world);
        }
        for kept in &self.values {
            kept.remove_new(world, &self.tracked);
        }
        self.restore_children(world);
        let removed = self.remove_new(world, new);
        world.flush();
        self.simulated.clone().put_into(world);
        self.claim_motion(world);
        let lost = leave_lost(world);
        Rewound {
            steps,
            removed,
            returned,
            lost,
        }
    }

    fn restore_children(&self, world: &mut World) {
        for &(child, ref child_of, place) in &self.children {
            if world.get_entity(child_of.parent()).is_err() {
                continue;
            }
            let Ok(mut child) = world.get_entity_mut(child) else {
                continue;
            };
            if child.get::<ChildOf>() != Some(child_of) {
                child.insert(child_of.clone());
            }
            if let Some(place) = place {
                child.insert(place);
            }
        }
    }

    /// Says that the plugin has written what was put back of bodies' motion: it is changed for everyone else, and nothing to be read. Rounding
    /// and the sign of zero differ between what was written and what is simulated. What the app has set otherwise in the step is still to be read.
    fn claim_motion(&self, world: &mut World) {
        let now = world.change_tick();
        world.increment_change_tick();
        world.resource_scope(|world, bodies: Mut<Bodies>| {
            for &entity in &self.tracked {
                claim_motion(world, &bodies, entity, now);
            }
        });
        world.resource_mut::<PluginState>().entities.written = now;
    }

    /// Despawns bodies and joints that are younger, and takes what makes them such from older entities; the former.
    fn remove_new(&self, world: &mut World, aside: Vec<Entity>) -> Vec<Entity> {
        let mut removed = Vec::new();
        for entity in aside {
            // Nobody has seen it since it broke, but the app may have despawned it.
            if let Ok(entity) = world.get_entity_mut(entity) {
                entity.despawn();
            }
        }
        let now = world.read_change_tick();
        for entity in tracked(world) {
            if self.tracked.contains(&entity) {
                continue;
            }
            // It may have gone with another one.
            let Ok(mut entity) = world.get_entity_mut(entity) else {
                continue;
            };
            if entity.spawn_tick().is_newer_than(self.tick, now) {
                removed.push(entity.id());
                entity.despawn();
            } else {
                entity.remove::<(RigidBody, BodyHandle, Joint)>();
            }
        }
        removed
    }
}

/// Marks as changed at `now` what an entity says of the motion of its body, if that is how it moves.
fn claim_motion(world: &mut World, bodies: &Bodies, entity: Entity, now: Tick) {
    let body = world.get::<BodyHandle>(entity).and_then(BodyHandle::get);
    let Some((slot, _)) = body.filter(|&(slot, id)| bodies.is_current(slot, id)) else {
        return;
    };
    let (pose, (linear, angular)) = (bodies.pose(slot), bodies.velocity(slot));
    let is_written = world
        .get::<Transform>(entity)
        .is_some_and(|place| place.translation == pose.position && place.rotation == pose.rotation);
    if !is_written
        || world.get::<LinearVelocity>(entity) != Some(&LinearVelocity(linear))
        || world.get::<AngularVelocity>(entity) != Some(&AngularVelocity(angular))
    {
        return;
    }
    if let Some(mut place) = world.get_mut::<Transform>(entity) {
        place.set_last_changed(now);
    }
    if let Some(mut velocity) = world.get_mut::<LinearVelocity>(entity) {
        velocity.set_last_changed(now);
    }
    if let Some(mut velocity) = world.get_mut::<AngularVelocity>(entity) {
        velocity.set_last_changed(now);
    }
}

/// Entities of bodies and joints, ascending.
fn tracked(world: &mut World) -> Vec<Entity> {
    let mut query = world.query_filtered::<Entity, InPhysics>();
    let mut tracked: Vec<Entity> = query.iter(world).collect();
    tracked.sort_unstable();
    tracked
}

/// Everyone beneath `bodies` that is no body, with the parent and the place beneath it.
fn children_of(world: &World, bodies: &[Entity]) -> Vec<(Entity, ChildOf, Option<Transform>)> {
    let mut found = Vec::new();
    let mut parents = bodies.to_vec();
    while let Some(parent) = parents.pop() {
        let Some(children) = world.get::<Children>(parent) else {
            continue;
        };
        for child in children.iter() {
            if world.get::<BodyHandle>(child).is_none() {
                let place = world.get::<Transform>(child).copied();
                found.push((child, ChildOf(parent), place));
                parents.push(child);
            }
        }
    }
    found
}

/// Lets bodies and joints go whose entities are no more; these.
fn leave_lost(world: &mut World) -> Vec<Entity> {
    let bodies = world.resource::<Bodies>();
    let state = world.resource::<PluginState>();
    let is_gone = |entity: Entity| world.get_entity(entity).is_err();
    let mut entities: EntityHashMap<(u32, _)> = EntityHashMap::default();
    for slot in bodies.iter() {
        let id = bodies.id(slot);
        if let Some(entity) = state.entities.of(slot, id).filter(|&it| is_gone(it)) {
            entities.insert(entity, (slot, id));
        }
    }
    let joints = state.joints.entities.iter().map(|&(_, entity)| entity);
    let joints: Vec<Entity> = joints.filter(|&it| is_gone(it)).collect();
    let state = &mut *world.resource_mut::<PluginState>();
    let mut lost: Vec<Entity> = entities.keys().copied().collect();
    lost.sort_unstable();
    state
        .queue
        .left
        .extend(lost.iter().map(|entity| entities[entity]));
    state.joints.arrived.extend(&joints);
    lost.extend(joints);
    lost
}
