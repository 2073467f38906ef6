//! Joints as entities: related to the two bodies that they join, and written back to.
//!
//! An entity with a [`Joint`](crate::joints::Joint) and a [`JointB`] joins that body to the one that its [`JointA`] names or, without
//! one, to the world. What is not usable is named on the entity by a [`JointProblem`] until it is.

mod observers;
mod pieces;
mod relations;

pub(crate) use observers::*;
pub(crate) use pieces::follow_pieces;

use crate::bodies::body::RigidBody;
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::ecs::components::*;
use crate::ecs::joint::relations::{JointRelations, relate_again};
use crate::ecs::state::{JointQueue, PluginState};
use crate::joints::{BrokenJoint, Joint, JointError, JointId, JointLoad, Joints};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

/// The first body of a joint, in whose frame its axes are. Without one, the joint holds on to the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Component)]
#[relationship(relationship_target = JointsOfA)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct JointA(pub Entity);

/// The second body of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Component)]
#[relationship(relationship_target = JointsOfB)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct JointB(pub Entity);

/// The joints of which a body is the first; they are despawned with it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Component)]
#[relationship_target(relationship = JointA, linked_spawn)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct JointsOfA(Vec<Entity>);

/// The joints of which a body is the second; they are despawned with it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Component)]
#[relationship_target(relationship = JointB, linked_spawn)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct JointsOfB(Vec<Entity>);

/// Why a joint does not hold. Written by the plugin; gone as soon as it does.
#[derive(Clone, Copy, Debug, PartialEq, Component)]
#[component(clone_behavior = Ignore)]
pub struct JointProblem(pub JointError);

/// Where the simulation keeps a joint. Written by the plugin; a clone of the entity gets its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Component)]
#[component(clone_behavior = Ignore)]
pub struct JointHandle(pub(crate) Option<JointId>);

impl JointHandle {
    /// Name of the joint, once it holds.
    pub fn get(&self) -> Option<JointId> {
        self.0
    }
}

/// A joint bore more than its strength and holds no more: sent as a message, and as an event of the joint's entity. The entity loses
/// its [`Joint`] and keeps the rest; to insert one again mends it.
#[derive(Clone, Copy, Debug, PartialEq, Message, EntityEvent)]
pub struct JointBroken {
    /// The joint's entity.
    pub entity: Entity,
    /// The bodies that it joined; `None` is the world, or a body without an entity.
    pub bodies: [Option<Entity>; 2],
    /// What it was.
    pub joint: Joint,
    /// What it bore.
    pub load: JointLoad,
    /// Energy that its springs held, which is lost, J.
    pub stored_energy: f32,
}

/// Joining bodies.
pub trait JointCommands {
    /// Spawns a joint of `b` to `a`, or to the world; the entity of the joint.
    fn join(&mut self, a: impl Into<Option<Entity>>, b: Entity, joint: Joint) -> Entity;
}

impl JointCommands for Commands<'_, '_> {
    fn join(&mut self, a: impl Into<Option<Entity>>, b: Entity, joint: Joint) -> Entity {
        let mut entity = self.spawn((joint, JointB(b)));
        if let Some(a) = a.into() {
            entity.insert(JointA(a));
        }
        entity.id()
    }
}

/// A joint as its entity describes it.
type JointParts = (
    &'static Joint,
    Option<&'static JointA>,
    Option<&'static JointB>,
);

/// What the user changed about joints.
#[derive(SystemParam)]
pub(crate) struct JointReadings<'w, 's> {
    changed: Query<'w, 's, Entity, Changed<Joint>>,
    parts: Query<'w, 's, JointParts>,
    /// Of those that are disabled too: their bodies are kept, and so are the joints that hold them.
    handles: Query<'w, 's, &'static BodyHandle, Allow<Disabled>>,
    awaited: Query<'w, 's, (), (IsAwaited, Allow<Disabled>)>,
    marks: Query<'w, 's, &'static mut JointHandle, Allow<Disabled>>,
    relations: Query<'w, 's, JointRelations, Allow<Disabled>>,
    commands: Commands<'w, 's>,
}

/// What has no body yet and says nothing of it: its shape is still to come, or it was never enabled.
type IsAwaited = Or<(With<ShapeAwaited>, (With<Disabled>, With<RigidBody>))>;

/// System: takes over joints that came, went or changed, and those of bodies that did, once the entities have bodies.
pub(crate) fn read_joints(
    (mut state, mut bodies): (ResMut<PluginState>, ResMut<Bodies>),
    mut joints: ResMut<Joints>,
    mut warnings: ResMut<Messages<BodyWarning>>,
    mut readings: JointReadings,
) {
    let (bodies, joints, readings) = (&mut *bodies, &mut *joints, &mut readings);
    let queue = &mut state.joints;
    let arrived = std::mem::take(&mut queue.arrived);
    let mut asked: Vec<Entity> = readings
        .changed
        .iter()
        .chain(arrived.iter().copied())
        .collect();
    let has_changed = !asked.is_empty() || !queue.refused.is_empty();
    if !has_changed && !queue.have_bodies_changed {
        return;
    }
    queue.have_bodies_changed = false;
    for &entity in &arrived {
        relate_again(entity, &readings.relations, &mut readings.commands);
    }
    asked.sort_unstable();
    let remade = update_known(queue, &asked, bodies, joints, readings);
    let refused = std::mem::take(&mut queue.refused);
    let known: Vec<Entity> = refused.keys().copied().collect();
    for entity in remade.into_iter().chain(known).chain(arrived) {
        let is_there = readings
            .marks
            .get(entity)
            .is_ok_and(|handle| handle.0.is_some_and(|id| joints.contains(id)));
        let is_refused = queue.refused.contains_key(&entity);
        let Ok(parts) = readings.parts.get(entity) else {
            // What is no joint any more, or disabled, has no problem.
            queue.problems.push((entity, None));
            continue;
        };
        if is_there || is_refused {
            continue;
        }
        let made = make(parts, bodies, joints, &readings.handles);
        match made {
            Ok(id) => {
                queue.entities.push((id, entity));
                queue.problems.push((entity, None));
                if let Ok(mut handle) = readings.marks.get_mut(entity) {
                    handle.0 = Some(id);
                }
            }
            Err(error) => {
                let waits = error == JointError::NoBody && waits(parts, bodies, readings);
                let before = refused.get(&entity).copied();
                let problem = (!waits).then_some(error);
                refuse(queue, &mut warnings, entity, problem, before);
            }
        }
    }
}

/// A joint as its entity describes it. What is wrong with that itself is told while its bodies are still to come.
fn make(
    parts: (&Joint, Option<&JointA>, Option<&JointB>),
    bodies: &mut Bodies,
    joints: &mut Joints,
    handles: &Query<&BodyHandle, Allow<Disabled>>,
) -> Result<JointId, JointError> {
    parts.0.check()?;
    let (a, b) = ends_of(parts, bodies, handles)?;
    joints.insert(bodies, a.map(|(slot, _)| slot), b.0, *parts.0)
}

/// Whether all bodies that are missing are still to come.
fn waits(
    (_, a, b): (&Joint, Option<&JointA>, Option<&JointB>),
    bodies: &Bodies,
    readings: &JointReadings,
) -> bool {
    let Some(b) = b else {
        return false;
    };
    let mut ends = a.map(|a| a.0).into_iter().chain([b.0]);
    ends.all(|end| {
        body_of(end, bodies, &readings.handles).is_some() || readings.awaited.contains(end)
    })
}

/// A joint does not hold, because of a problem or because it waits; that is told unless it was so before.
fn refuse(
    queue: &mut JointQueue,
    warnings: &mut Messages<BodyWarning>,
    entity: Entity,
    problem: Option<JointError>,
    before: Option<Option<JointError>>,
) {
    // As texts, because a NaN in the reason is not equal to itself.
    let text = |why: Option<JointError>| why.map(|why| why.to_string());
    if before.map(text) != Some(text(problem)) {
        if let Some(error) = problem {
            warn(warnings, entity, error);
        }
        queue.problems.push((entity, problem));
    }
    queue.refused.insert(entity, problem);
}

/// Follows what became of the joints that hold; those that are to be made anew. `asked`: entities that describe their joints anew, sorted.
/// Of the others it is enough to know that their bodies are there.
fn update_known(
    queue: &mut JointQueue,
    asked: &[Entity],
    bodies: &mut Bodies,
    joints: &mut Joints,
    readings: &mut JointReadings,
) -> Vec<Entity> {
    let mut remade = Vec::new();
    let mut gone: Vec<JointId> = Vec::new();
    let mut at = 0;
    queue.entities.retain(|&(id, entity)| {
        let is_held = joints.is_held(bodies, id, &mut at);
        if is_held && asked.binary_search(&entity).is_err() {
            return true;
        }
        let parts = readings.parts.get(entity).ok();
        let is_kept = is_held
            && parts.is_some_and(|parts| is_as_asked(parts, id, bodies, joints, &readings.handles));
        // What is kept too: the entity may have lost the mark, and got another one, together with its joint.
        if let Ok(mut handle) = readings.marks.get_mut(entity) {
            handle.set_if_neq(JointHandle(is_kept.then_some(id)));
        }
        if !is_kept {
            gone.push(id);
            if parts.is_some() {
                remade.push(entity);
            }
        }
        is_kept
    });
    if !gone.is_empty() {
        joints.remove_all(bodies, |id| gone.binary_search(&id).is_ok());
    }
    remade
}

/// Whether a joint holds the bodies that its entity names, and can become what that says.
fn is_as_asked(
    parts: (&Joint, Option<&JointA>, Option<&JointB>),
    id: JointId,
    bodies: &mut Bodies,
    joints: &mut Joints,
    handles: &Query<&BodyHandle, Allow<Disabled>>,
) -> bool {
    let slots = |(a, b): Ends| [a.map(|(slot, _)| slot), Some(b.0)];
    let ends = ends_of(parts, bodies, handles).map(slots);
    joints.bodies(id) == ends.ok() && joints.set(bodies, id, *parts.0).is_ok()
}

/// The bodies that an entity asks to be joined.
type Ends = (Option<(u32, BodyId)>, (u32, BodyId));

fn ends_of(
    (_, a, b): (&Joint, Option<&JointA>, Option<&JointB>),
    bodies: &Bodies,
    handles: &Query<&BodyHandle, Allow<Disabled>>,
) -> Result<Ends, JointError> {
    let b = b.ok_or(JointError::NoBody)?.0;
    if a.is_some_and(|a| a.0 == b) {
        return Err(JointError::SameBody);
    }
    let body_of = |entity| body_of(entity, bodies, handles).ok_or(JointError::NoBody);
    let a = a.map(|a| body_of(a.0)).transpose()?;
    Ok((a, body_of(b)?))
}

/// The body of an entity, if it has one.
fn body_of(
    entity: Entity,
    bodies: &Bodies,
    handles: &Query<&BodyHandle, Allow<Disabled>>,
) -> Option<(u32, BodyId)> {
    let handle = handles.get(entity).ok().and_then(|handle| handle.0);
    handle.filter(|&(slot, id)| bodies.is_current(slot, id))
}

/// Run condition of the systems of joints: most scenes have none.
pub(crate) fn any_joint(state: Res<PluginState>) -> bool {
    let queue = &state.joints;
    let is_known = !(queue.refused.is_empty() && queue.entities.is_empty());
    is_known || !(queue.arrived.is_empty() && queue.problems.is_empty())
}

/// System: writes to the entities of joints what these bore, what is wrong with them, and which broke.
pub(crate) fn write_joints(
    joints: Res<Joints>,
    mut state: ResMut<PluginState>,
    mut loads: Query<&mut JointLoad>,
    mut messages: MessageWriter<JointBroken>,
    mut commands: Commands,
) {
    for &(id, entity) in &state.joints.entities {
        if let (Some(load), Ok(mut to)) = (joints.load(id), loads.get_mut(entity)) {
            to.set_if_neq(*load);
        }
    }
    for (entity, problem) in state.joints.problems.drain(..) {
        let Ok(mut entity) = commands.get_entity(entity) else {
            continue;
        };
        match problem {
            Some(problem) => entity.try_insert(JointProblem(problem)),
            None => entity.try_remove::<JointProblem>(),
        };
    }
    report_broken(&joints.broken, &mut state, &mut messages, &mut commands);
}

/// Tells which joints broke, and takes them from their entities.
fn report_broken(
    broken: &[BrokenJoint],
    state: &mut PluginState,
    messages: &mut MessageWriter<JointBroken>,
    commands: &mut Commands,
) {
    for joint in broken {
        let queue = &mut state.joints;
        let Ok(at) = queue
            .entities
            .binary_search_by_key(&joint.id, |(id, _)| *id)
        else {
            continue;
        };
        let (_, entity) = queue.entities.remove(at);
        let entities = &state.entities;
        let bodies = joint
            .bodies
            .map(|end| end.and_then(|(slot, id)| entities.of(slot, id)));
        let message = JointBroken {
            entity,
            bodies,
            joint: joint.joint,
            load: joint.load,
            stored_energy: joint.stored_energy,
        };
        messages.write(message);
        commands.queue(move |world: &mut World| {
            if let Ok(mut entity) = world.get_entity_mut(message.entity) {
                // Before it is told, so that who hears of it can mend it.
                entity.insert((message.load, JointHandle(None)));
                entity.remove::<Joint>();
                world.trigger(message);
            }
        });
    }
}
