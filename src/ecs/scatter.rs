//! Flat arrays into components: poses and velocities of bodies that moved, and problems of the step.

use super::components::*;
use crate::contact::BodyId;
use crate::solver::bodies::{Bodies, RigidBody};
use crate::step::StepReport;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;

/// System: takes the mark from the entities whose bodies woke, or never fell asleep, so that they are written again.
pub(crate) fn unmark_woken(
    mut commands: Commands,
    bodies: Res<Bodies>,
    entities: Res<BodyEntities>,
    marked: Query<(), With<Sleeping>>,
) {
    for &(slot, id) in bodies.turned() {
        if bodies.is(slot, id) && !bodies.is_asleep(slot) {
            let entity = entities.of(slot, id);
            if let Some(entity) = entity.filter(|&entity| marked.contains(entity)) {
                commands.entity(entity).remove::<Sleeping>();
            }
        }
    }
}

/// System: marks the entities whose bodies fell asleep, after they were written for the last time.
pub(crate) fn mark_asleep(
    mut commands: Commands,
    mut bodies: ResMut<Bodies>,
    entities: Res<BodyEntities>,
    marked: Query<(), With<Sleeping>>,
) {
    for &(slot, id) in bodies.turned() {
        if bodies.is(slot, id) && bodies.is_asleep(slot) {
            let entity = entities.of(slot, id);
            if let Some(entity) = entity.filter(|&entity| !marked.contains(entity)) {
                commands.entity(entity).insert(Sleeping);
            }
        }
    }
    bodies.forget_turned();
}

/// System: writes pose and velocity to the entities whose bodies moved. `Transform` is written, never read back: the
/// pose of record is the centre of mass in [`Bodies`].
pub(crate) fn scatter(
    bodies: Res<Bodies>,
    mut entities: ResMut<BodyEntities>,
    mut motion: Query<
        (
            &BodyHandle,
            &mut Transform,
            &mut LinearVelocity,
            &mut AngularVelocity,
        ),
        Without<Sleeping>,
    >,
) {
    for (handle, mut transform, mut linear, mut angular) in &mut motion {
        let is_alive = |&(slot, id): &(u32, BodyId)| bodies.is(slot, id) && bodies.is_active(slot);
        let Some((slot, _)) = handle.0.filter(is_alive) else {
            continue;
        };
        let (v, omega) = bodies.velocity(slot);
        linear.set_if_neq(LinearVelocity(v));
        angular.set_if_neq(AngularVelocity(omega));
        if bodies.kind(slot) == RigidBody::Static {
            continue;
        }
        let pose = bodies.pose(slot);
        transform.set_if_neq(Transform {
            translation: pose.position,
            rotation: pose.rotation,
            scale: transform.scale,
        });
        entities.seen[slot as usize] = *transform;
    }
}

/// System: warns about bodies that the step could not handle.
pub(crate) fn report_problems(
    report: Res<StepReport>,
    bodies: Res<Bodies>,
    entities: Res<BodyEntities>,
    mut warnings: ResMut<Messages<BodyWarning>>,
) {
    for (slot, error) in &report.problems {
        if let Some(entity) = entities.of(*slot, bodies.id(*slot)) {
            warn(&mut warnings, entity, *error);
        }
    }
}
