//! Poses and velocities that the user changed.

use crate::bodies::body::{BodyError, RigidBody};
use crate::bodies::store::Bodies;
use crate::ecs::components::*;
use crate::ecs::gather::pose_of;
use crate::ecs::scatter::transform_of;
use crate::tuning::COMPARED_ROWS;
use bevy_ecs::change_detection::Tick;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_transform::components::Transform;
use std::ops::Range;

/// What the user may have changed of a body's motion, table by table.
pub(super) type ReadMotion = (
    Entity,
    &'static BodyHandle,
    Ref<'static, Transform>,
    Ref<'static, LinearVelocity>,
    Ref<'static, AngularVelocity>,
);

/// Poses and velocities that the user changed. A state that is not usable takes the body out until it is.
///
/// What the plugin wrote itself bears the tick of its own system and is passed over without a look at the values.
pub(super) fn gather_motion(
    bodies: &mut Bodies,
    entities: &mut BodyEntities,
    warnings: &mut Messages<BodyWarning>,
    motion: &Query<ReadMotion>,
) {
    let own = entities.written;
    // All of these components are stored in tables, so there is a slice for each.
    let tables = motion.contiguous_iter().ok().into_iter().flatten();
    for (entity, handle, transform, linear, angular) in tables {
        let (last_run, this_run) = (transform.last_run_tick(), transform.this_run_tick());
        let by_user = |tick: Tick| tick != own && tick.is_newer_than(last_run, this_run);
        let ticks = [
            transform.changed_ticks_slice(),
            linear.changed_ticks_slice(),
            angular.changed_ticks_slice(),
        ];
        let strange = strange_rows(ticks, own);
        for row in strange.filter(|&row| ticks.iter().any(|column| by_user(column[row]))) {
            let handle = &handle[row];
            let Some((slot, _)) = handle.0.filter(|&(slot, id)| bodies.is_current(slot, id)) else {
                continue;
            };
            let velocity = (linear[row].0, angular[row].0);
            let seen = &mut entities.seen[slot as usize];
            match read_motion(bodies, seen, slot, &transform[row], velocity) {
                Ok(()) => bodies.set_frozen(slot, false),
                Err(error) => {
                    if bodies.is_active(slot) {
                        warn(warnings, entity[row], error);
                    }
                    bodies.set_frozen(slot, true);
                }
            }
        }
    }
}

/// Rows among which are all that have another tick than `own` in a column.
///
/// Most have not, so many are compared at once.
fn strange_rows<const N: usize>(columns: [&[Tick]; N], own: Tick) -> impl Iterator<Item = usize> {
    let count = columns.iter().map(|column| column.len()).min().unwrap_or(0);
    let starts = (0..count).step_by(COMPARED_ROWS);
    let runs = starts.map(move |start| start..(start + COMPARED_ROWS).min(count));
    let is_strange = move |run: &Range<usize>| {
        let mut columns = columns.iter().map(|column| &column[run.clone()]);
        columns.any(|ticks| ticks.iter().fold(false, |any, &tick| any | (tick != own)))
    };
    runs.filter(is_strange).flatten()
}

fn read_motion(
    bodies: &mut Bodies,
    seen: &mut Transform,
    slot: u32,
    transform: &Transform,
    (linear, angular): (Vec3, Vec3),
) -> Result<(), BodyError> {
    bodies.set_velocity(slot, linear, angular)?;
    let last = match bodies.kind(slot) {
        // Never written: what was read last may differ by rounding from the pose about the center of mass.
        RigidBody::Static => *seen,
        _ => transform_of(bodies.pose(slot)),
    };
    if *transform != last {
        bodies.set_pose(slot, pose_of(transform)?)?;
        *seen = *transform;
    }
    Ok(())
}
