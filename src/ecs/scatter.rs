//! Flat arrays into components: poses and velocities of bodies that moved, and problems of the step.

use super::components::*;
use crate::contact::BodyId;
use crate::math::Pose;
use crate::solver::bodies::Bodies;
use crate::step::StepReport;
use bevy_ecs::change_detection::{ContiguousComponentTicksMut, ContiguousMut};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemChangeTick;
use bevy_math::Vec3;
use bevy_transform::components::Transform;
use std::panic::Location;

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

/// What the plugin writes of a body's motion, table by table.
type Motion = (
    &'static BodyHandle,
    &'static mut Transform,
    &'static mut LinearVelocity,
    &'static mut AngularVelocity,
);

/// System: writes pose and velocity to the entities whose bodies moved. `Transform` is written, never read back: the
/// pose of record is the centre of mass in [`Bodies`].
pub(crate) fn scatter(
    bodies: Res<Bodies>,
    mut entities: ResMut<BodyEntities>,
    mut motion: Query<Motion, Without<Sleeping>>,
    tick: SystemChangeTick,
) {
    entities.written = tick.this_run();
    // All of these components are stored in tables, so there is a slice for each.
    let tables = motion.contiguous_iter_mut().ok().into_iter().flatten();
    for (handles, transforms, linear, angular) in tables {
        let mut transforms = Column::new(transforms);
        let mut linear = Column::new(linear);
        let mut angular = Column::new(angular);
        for (row, handle) in handles.iter().enumerate() {
            let is_alive =
                |&(slot, id): &(u32, BodyId)| bodies.is(slot, id) && bodies.is_active(slot);
            let Some((slot, _)) = handle.0.filter(is_alive) else {
                continue;
            };
            let (v, omega) = bodies.velocity(slot);
            linear.set(row, LinearVelocity(v));
            angular.set(row, AngularVelocity(omega));
            if !bodies.is_static(slot) {
                transforms.set(row, transform_of(bodies.pose(slot)));
            }
        }
    }
}

/// The `Transform` of a body, which is never scaled.
pub(super) fn transform_of(pose: Pose) -> Transform {
    Transform {
        translation: pose.position,
        rotation: pose.rotation,
        scale: Vec3::ONE,
    }
}

/// The values of one component in one table with the ticks of their last changes.
struct Column<'w, T> {
    values: &'w mut [T],
    ticks: ContiguousComponentTicksMut<'w>,
    has_changed: bool,
}

impl<'w, T: PartialEq> Column<'w, T> {
    fn new(column: ContiguousMut<'w, T>) -> Self {
        let (values, ticks) = ContiguousMut::bypass_change_detection_split(column);
        Self {
            values,
            ticks,
            has_changed: false,
        }
    }

    /// Writes `value`, and notes it as a change if it is one.
    fn set(&mut self, row: usize, value: T) {
        if self.values[row] != value {
            self.values[row] = value;
            let this_run = self.ticks.this_run();
            self.ticks.changed_mut()[row] = this_run;
            self.ticks
                .changed_by_mut()
                .map(|by| by[row] = Location::caller());
            self.has_changed = true;
        }
    }
}

impl<T> Drop for Column<'_, T> {
    /// The table's own mark of a change can only be set along with ticks, of which none are left to set.
    fn drop(&mut self) {
        if self.has_changed {
            self.ticks.reborrow().slice(0..0).mark_all_as_changed();
        }
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
