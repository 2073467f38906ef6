//! Flat arrays into components: poses and velocities of bodies that moved, and problems of the step.

use crate::bodies::body::RigidBody;
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::ecs::collision_news::send_collisions;
use crate::ecs::components::*;
use crate::ecs::cut;
use crate::ecs::issue_sync::sync_issues;
use crate::ecs::parents::{is_rounded_pose, write_children};
use crate::ecs::pieces::spawn_pieces;
use crate::ecs::state::PluginState;
use crate::fracture::Fractures;
use crate::math::Pose;
use crate::step::StepReport;
use crate::threads::team::Team;
use crate::tuning::{ENTITIES_WORTH_HELP, MIN_WRITTEN_ROWS};
use bevy_ecs::change_detection::{ContiguousComponentTicksMut, ContiguousMut, Tick};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::query::Allow;
use bevy_ecs::system::{SystemChangeTick, SystemParam, SystemState};
use bevy_math::Vec3;
use bevy_transform::components::Transform;
use std::panic::Location;

/// No motion, m/s and rad/s.
const AT_REST: (Vec3, Vec3) = (Vec3::ZERO, Vec3::ZERO);

/// What entities are renewed with.
#[derive(SystemParam)]
pub(crate) struct BodySync<'w, 's> {
    commands: Commands<'w, 's>,
    bodies: Res<'w, Bodies>,
    fractures: Res<'w, Fractures>,
    state: Res<'w, PluginState>,
    warnings: ResMut<'w, Messages<BodyWarning>>,
    removed: ResMut<'w, Messages<DebrisRemoved>>,
    marked: Query<'w, 's, (), (With<Sleeping>, Allow<Disabled>)>,
}

/// Run condition of [`renew_entities`]: most steps would fetch all that it takes only to find that nothing broke or woke.
pub(crate) fn any_entity_is_outdated(bodies: Res<Bodies>, fractures: Res<Fractures>) -> bool {
    let Fractures {
        done,
        refused,
        expired,
        fading,
        ..
    } = &*fractures;
    let is_unbroken = done.is_empty() && refused.is_empty() && bodies.cracked.is_empty();
    let nothing_goes = expired.is_empty() && fading.is_empty();
    !(is_unbroken && nothing_goes && bodies.sleep_changes().is_empty())
}

/// System: brings the entities in line with the bodies, before motion is written: cuts that were refused, pieces whose time is
/// over, marks of bodies that woke, and what broke.
///
/// It has the world to itself and applies its commands itself: a point in the schedule that applied them would be passed in
/// every step.
pub(crate) fn renew_entities(world: &mut World, renewal: &mut SystemState<BodySync>) -> Result {
    let BodySync {
        mut commands,
        bodies,
        fractures,
        state,
        mut warnings,
        mut removed,
        marked,
    } = renewal.get_mut(world)?;
    let entities = &state.entities;
    cut::report_refusals(&fractures, entities, &mut warnings);
    let fade = state.settings.budget.debris.fade;
    cut::despawn_expired(&mut commands, &fractures, entities, fade, &mut removed);
    unmark_woken(&mut commands, &bodies, entities, &marked);
    if !(fractures.done.is_empty() && bodies.cracked.is_empty()) {
        commands.queue(spawn_pieces);
    }
    renewal.apply(world);
    Ok(())
}

/// System: writes motion, then what is left: marks of bodies that fell asleep, and problems of the step.
pub(crate) fn write_entities(
    mut bodies: ResMut<Bodies>,
    mut state: ResMut<PluginState>,
    report: Res<StepReport>,
    mut warnings: ResMut<Messages<BodyWarning>>,
    (mut motion, tick): (Query<WrittenMotion, Without<Sleeping>>, SystemChangeTick),
    mut marks: SleepMarks,
) {
    let state = &mut *state;
    state.entities.written = tick.this_run();
    for target in state.kinematic.drain(..) {
        target.end(&mut bodies);
    }
    scatter(&bodies, state.entities.read, &mut motion);
    report_problems(&report, &bodies, &state.entities, &mut warnings);
    marks.set(&bodies, &state.entities);
    bodies.forget_sleep_changes();
    for entity in state.queue.halted.drain(..) {
        let rest = (LinearVelocity::default(), AngularVelocity::default());
        marks.commands.entity(entity).try_insert(rest);
    }
    for damaged in bodies.damaged() {
        if let Some(entity) = state.entities.of(damaged.slot, damaged.id) {
            marks.commands.entity(entity).try_insert(damaged.fatigue);
        }
    }
    if !state.children.is_empty() {
        marks.commands.queue(write_children);
    }
    if !state.issues.changed.is_empty() {
        marks.commands.queue(sync_issues);
    }
    let has_new_options = state.options.is_used && !state.options.entities.is_empty();
    if state.is_watching || has_new_options || !bodies.sensors.is_empty() {
        marks.commands.queue(send_collisions);
    }
}

/// Takes the mark from the entities whose bodies woke, or never fell asleep, so that they are written again.
fn unmark_woken(
    commands: &mut Commands,
    bodies: &Bodies,
    entities: &BodyEntities,
    marked: &Query<(), (With<Sleeping>, Allow<Disabled>)>,
) {
    for &(slot, id) in bodies.sleep_changes() {
        if bodies.is_current(slot, id) && !bodies.is_asleep(slot) {
            let entity = entities.of(slot, id);
            if let Some(entity) = entity.filter(|&entity| marked.contains(entity)) {
                commands.entity(entity).remove::<Sleeping>();
            }
        }
    }
}

/// Marks entities as sleeping.
#[derive(SystemParam)]
pub(crate) struct SleepMarks<'w, 's> {
    commands: Commands<'w, 's>,
    marked: Query<'w, 's, (), (With<Sleeping>, Allow<Disabled>)>,
}

impl SleepMarks<'_, '_> {
    /// Marks the entities whose bodies fell asleep, after they were written for the last time.
    fn set(&mut self, bodies: &Bodies, entities: &BodyEntities) {
        for &(slot, id) in bodies.sleep_changes() {
            if bodies.is_current(slot, id) && bodies.is_asleep(slot) {
                let entity = entities.of(slot, id);
                if let Some(entity) = entity.filter(|&entity| !self.marked.contains(entity)) {
                    self.commands.entity(entity).insert(Sleeping);
                }
            }
        }
    }
}

/// What the plugin writes of a body's motion, table by table.
type WrittenMotion = (
    &'static BodyHandle,
    &'static mut Transform,
    &'static mut LinearVelocity,
    &'static mut AngularVelocity,
    Has<ChildOf>,
);

/// Writes pose and velocity to the entities whose bodies moved. `Transform` is written, never read back: the pose of record
/// is the center of mass in [`Bodies`].
///
/// What was changed since entities were `read` stays as it is: by observers of pieces that were born, say. The next step reads it.
fn scatter(bodies: &Bodies, read: Tick, motion: &mut Query<WrittenMotion, Without<Sleeping>>) {
    // All of these components are stored in tables, so there is a slice for each.
    let tables = motion.contiguous_iter_mut().ok().into_iter().flatten();
    let awake = bodies.len().saturating_sub(bodies.asleep());
    Team::lead_if(awake >= ENTITIES_WORTH_HELP, |team| {
        for (handles, transforms, linear, angular, is_child) in tables {
            // Those beneath parents are written by themselves.
            let is_child = IsChild(is_child);
            let mut transforms = Column::new(transforms, read);
            let mut linear = Column::new(linear, read);
            let mut angular = Column::new(angular, read);
            if team.is_none() {
                write_rows(
                    (bodies, is_child),
                    handles,
                    transforms.all(),
                    linear.all(),
                    angular.all(),
                );
                continue;
            }
            let size = Team::part_size(team, handles.len(), MIN_WRITTEN_ROWS);
            let velocities = linear.parts(size).zip(angular.parts(size));
            let motions = transforms.parts(size).zip(velocities);
            let parts = handles.chunks(size).zip(motions);
            Team::each_of_many(team, parts, |(handles, (transforms, (linear, angular)))| {
                write_rows((bodies, is_child), handles, transforms, linear, angular);
            });
        }
    });
}

/// Whether entities of a table are children.
#[derive(Clone, Copy)]
struct IsChild(bool);

fn write_rows(
    (bodies, IsChild(is_child)): (&Bodies, IsChild),
    handles: &[BodyHandle],
    transforms: EntityRows<Transform>,
    linear: EntityRows<LinearVelocity>,
    angular: EntityRows<AngularVelocity>,
) {
    let rows = transforms
        .into_rows()
        .zip(linear.into_rows().zip(angular.into_rows()));
    for (handle, (transform, (linear, angular))) in handles.iter().zip(rows) {
        let is_alive =
            |&(slot, id): &(u32, BodyId)| bodies.is_current(slot, id) && bodies.is_active(slot);
        let Some((slot, _)) = handle.0.filter(is_alive) else {
            continue;
        };
        // What the user gave it stays there to be seen.
        if bodies.is_static(slot) {
            continue;
        }
        let (v, omega) = bodies.velocity(slot);
        linear.set(LinearVelocity(v));
        angular.set(AngularVelocity(omega));
        if !is_child {
            let pose = bodies.pose(slot);
            let Transform {
                translation,
                rotation,
                scale,
            } = *transform.value;
            // What users add to it by less than is told from rounding adds up until it is more.
            let rests = bodies.kind(slot) == RigidBody::Kinematic && (v, omega) == AT_REST;
            if rests && is_rounded_pose(Pose::new(translation, rotation), pose, false) {
                continue;
            }
            transform.set(Transform {
                translation: pose.position,
                rotation: pose.rotation,
                scale,
            });
        }
    }
}

/// The values of one component in one table with the ticks of their last changes.
struct Column<'w, T: Component> {
    values: &'w mut [T],
    ticks: ContiguousComponentTicksMut<'w>,
    /// What has changed since then is not written.
    read: Tick,
}

impl<'w, T: Component> Column<'w, T> {
    fn new(column: ContiguousMut<'w, T>, read: Tick) -> Self {
        let (values, ticks) = ContiguousMut::bypass_change_detection_split(column);
        Self {
            values,
            ticks,
            read,
        }
    }

    /// All rows.
    fn all(&mut self) -> EntityRows<'_, T> {
        EntityRows {
            now: self.ticks.this_run(),
            read: self.read,
            values: self.values,
            changed: self.ticks.changed_mut(),
        }
    }

    /// The rows in parts of `size`.
    fn parts(
        &mut self,
        size: usize,
    ) -> impl ExactSizeIterator<Item = EntityRows<'_, T>> + DoubleEndedIterator {
        let (now, read) = (self.ticks.this_run(), self.read);
        let values = self.values.chunks_mut(size);
        let parts = values.zip(self.ticks.changed_mut().chunks_mut(size));
        parts.map(move |(values, changed)| EntityRows {
            values,
            changed,
            now,
            read,
        })
    }
}

impl<T: Component> Drop for Column<'_, T> {
    /// Notes what goes with changes, if there were any: the table's own mark, if the component has one, which can only be set
    /// along with ticks, of which none are left to set, and, in builds that track it, who made them.
    fn drop(&mut self) {
        let now = self.ticks.this_run();
        let is_noted = T::HAS_SUMMARY_TICK || self.ticks.changed_by().into_option().is_some();
        if !(is_noted && self.ticks.changed().contains(&now)) {
            return;
        }
        self.ticks.reborrow().slice(0..0).mark_all_as_changed();
        if self.ticks.changed_by().into_option().is_some() {
            let changed = self.ticks.changed().to_vec();
            self.ticks.changed_by_mut().map(|by| {
                for (by, _) in by.iter_mut().zip(changed).filter(|(_, tick)| *tick == now) {
                    *by = Location::caller();
                }
            });
        }
    }
}

/// Some of the rows of a column.
struct EntityRows<'c, T> {
    values: &'c mut [T],
    changed: &'c mut [Tick],
    now: Tick,
    read: Tick,
}

impl<'c, T> EntityRows<'c, T> {
    fn into_rows(self) -> impl Iterator<Item = EntityRow<'c, T>> {
        let rows = self.values.iter_mut().zip(self.changed);
        rows.map(move |(value, changed)| EntityRow {
            value,
            changed,
            now: self.now,
            read: self.read,
        })
    }
}

/// One row.
struct EntityRow<'c, T> {
    value: &'c mut T,
    changed: &'c mut Tick,
    now: Tick,
    read: Tick,
}

impl<T: PartialEq> EntityRow<'_, T> {
    /// Writes `value`, and notes it as a change if it is one; unless somebody else has changed it meanwhile.
    fn set(self, value: T) {
        if *self.value != value && !self.changed.is_newer_than(self.read, self.now) {
            *self.value = value;
            *self.changed = self.now;
        }
    }
}

/// Warns about bodies that the step could not handle.
fn report_problems(
    report: &StepReport,
    bodies: &Bodies,
    entities: &BodyEntities,
    warnings: &mut Messages<BodyWarning>,
) {
    for (slot, error) in &report.problems {
        if let Some(entity) = entities.of(*slot, bodies.id(*slot)) {
            warn(warnings, entity, *error);
        }
    }
}
