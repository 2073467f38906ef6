//! Bodies that become dynamic, kinematic or static, and those that are disabled or enabled.

use crate::bodies::body::{BodyError, RigidBody};
use crate::bodies::store::Bodies;
use crate::ecs::components::*;
use crate::ecs::gather::lone::LoneParts;
use crate::ecs::issues::{Issues, Source};
use crate::ecs::state::BodyQueue;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::query::Allow;
use bevy_ecs::system::SystemParam;
use bevy_math::Vec3;

/// The velocities of an entity, unless they were taken off.
type Velocities = Option<(&'static LinearVelocity, &'static AngularVelocity)>;

/// What is looked at only of entities that were queued.
#[derive(SystemParam)]
pub(crate) struct RareReadings<'w, 's> {
    toggled: Query<'w, 's, (&'static BodyHandle, Has<Disabled>)>,
    kinds: Query<'w, 's, (&'static BodyHandle, &'static RigidBody, Velocities), Allow<Disabled>>,
    lone: LoneParts<'w, 's>,
}

/// Bodies that were made dynamic, kinematic or static, and what is still without a body.
pub(super) fn read_kinds(
    queue: &mut BodyQueue,
    bodies: &mut Bodies,
    issues: &mut Issues,
    warnings: &mut Messages<BodyWarning>,
    rare: &RareReadings,
) {
    rare.lone.tell(&mut queue.lone_parts, issues, warnings);
    for entity in queue.changed_kind.drain(..) {
        let Ok((handle, kind, velocities)) = rare.kinds.get(entity) else {
            continue;
        };
        let velocity = velocities.map_or_else(Default::default, |(v, omega)| (v.0, omega.0));
        if let Some((slot, _)) = handle.0.filter(|&(slot, id)| bodies.is_current(slot, id)) {
            // One that its shape does not allow may get another shape along with it: that is told with the description, which tells
            // of what breaks too.
            let target = (entity, slot, velocity);
            let _ = set_kind((bodies, issues), &mut queue.halted, target, *kind);
            queue.reduced.push(entity);
        }
    }
}

/// Makes a body (its entity, slot, and the linear and angular velocity that the entity has) dynamic, kinematic or static, if it is not.
pub(super) fn set_kind(
    (bodies, issues): (&mut Bodies, &mut Issues),
    halted: &mut Vec<Entity>,
    (entity, slot, velocity): (Entity, u32, (Vec3, Vec3)),
    kind: RigidBody,
) -> Result<(), BodyError> {
    let before = bodies.kind(slot);
    if before == kind {
        return Ok(());
    }
    bodies.set_kind(slot, kind)?;
    issues.mend(entity, Source::Velocity);
    if kind == RigidBody::Static {
        halted.push(entity);
    }
    if before == RigidBody::Static {
        // It did nothing until now, whenever it was set. One without numbers is told of by those who read motion.
        let _ = bodies.set_velocity(slot, velocity.0, velocity.1);
    }
    Ok(())
}

/// Takes bodies out whose entities were disabled, and lets those in again that were enabled, whose state is to be read then.
pub(super) fn toggle(
    queue: &mut BodyQueue,
    bodies: &mut Bodies,
    issues: &mut Issues,
    rare: &RareReadings,
) -> Vec<Entity> {
    let mut enabled = Vec::new();
    for entity in queue.toggled.drain(..) {
        let Ok((handle, is_disabled)) = rare.toggled.get(entity) else {
            continue;
        };
        if let Some((slot, _)) = handle.0.filter(|&(slot, id)| bodies.is_current(slot, id)) {
            bodies.set_frozen(slot, is_disabled);
            if !is_disabled {
                issues.mend(entity, Source::Motion);
                queue.reduced.push(entity);
                // It may have been marked as sleeping meanwhile.
                queue.marked.push(entity);
                enabled.push(entity);
            }
        }
    }
    enabled
}
