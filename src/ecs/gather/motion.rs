//! Poses and velocities that the user changed.

use crate::bodies::body::{BodyError, RigidBody, check_pose};
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::ecs::components::*;
use crate::ecs::gather::idle_velocity;
use crate::ecs::issues::{Issues, Source};
use crate::ecs::kinematic::KinematicTarget;
use crate::ecs::parents::{
    Parents, is_rounded_pose, is_rounding, is_same_place, is_same_scale, reach,
};
use crate::math::Pose;
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
    Option<&'static ChildOf>,
);

/// The same of one entity.
type MotionOf<'r> = (
    Entity,
    &'r BodyHandle,
    Ref<'r, Transform>,
    Ref<'r, LinearVelocity>,
    Ref<'r, AngularVelocity>,
    Option<&'r ChildOf>,
);

/// One entity's motion.
#[derive(Clone, Copy)]
struct Row<'r> {
    entity: Entity,
    handle: &'r BodyHandle,
    transform: &'r Transform,
    velocity: (Vec3, Vec3),
    child_of: Option<&'r ChildOf>,
}

/// Reads poses and velocities that the user changed. A state that is not usable takes the body out until it is.
pub(super) struct MotionReader<'r, 'w, 's> {
    pub(super) bodies: &'r mut Bodies,
    pub(super) entities: &'r mut BodyEntities,
    pub(super) issues: &'r mut Issues,
    pub(super) warnings: &'r mut Messages<BodyWarning>,
    /// Entities of bodies with parents.
    pub(super) children: &'r mut Vec<Entity>,
    pub(super) kinematic: &'r mut Vec<KinematicTarget>,
    /// Entities whose shapes are to be scaled otherwise.
    pub(super) rescaled: &'r mut Vec<Entity>,
    /// Entities of bodies that became static in this step: what they moved by is taken from them at its end.
    pub(super) halted: &'r [Entity],
    pub(super) parents: &'r Parents<'w, 's>,
    pub(super) handles: &'r Query<'w, 's, &'static BodyHandle>,
}

impl MotionReader<'_, '_, '_> {
    /// What the plugin wrote itself bears the tick of its own system and is passed over without a look at the values.
    pub(super) fn read_all(&mut self, motion: &Query<ReadMotion>) {
        let own = self.entities.written;
        let mut deeper = Vec::new();
        // All of these components are stored in tables, so there is a slice for each.
        let tables = motion.contiguous_iter().ok().into_iter().flatten();
        for (entity, handle, transform, linear, angular, child_of) in tables {
            let (last_run, this_run) = (transform.last_run_tick(), transform.this_run_tick());
            let by_user = |tick: Tick| tick != own && tick.is_newer_than(last_run, this_run);
            let ticks = [
                transform.changed_ticks_slice(),
                linear.changed_ticks_slice(),
                angular.changed_ticks_slice(),
            ];
            let row = |at: usize| Row {
                entity: entity[at],
                handle: &handle[at],
                transform: &transform[at],
                velocity: (linear[at].0, angular[at].0),
                child_of: child_of.map(|parents| &parents[at]),
            };
            if child_of.is_some() {
                // Their parents may have moved.
                self.children.extend_from_slice(entity);
                for row in (0..entity.len()).map(row) {
                    let parent = row.child_of.map(ChildOf::parent);
                    match parent.map_or(0, |parent| self.parents.depth(parent)) {
                        0 => self.read(row),
                        depth => deeper.push((depth, row.entity)),
                    }
                }
                continue;
            }
            let strange = strange_rows(ticks, own);
            for at in strange.filter(|&at| ticks.iter().any(|column| by_user(column[at]))) {
                self.read(row(at));
            }
        }
        // From the root down, whatever tables they are in: where somebody is depends on who is above.
        deeper.sort_by_key(|&(depth, _)| depth);
        for item in deeper
            .into_iter()
            .flat_map(|(_, entity)| motion.get(entity))
        {
            self.read_one(item);
        }
    }

    /// Reads those that were enabled, whatever their ticks say, and those that have lost a parent, unless they were read since.
    pub(super) fn read_again(
        &mut self,
        motion: &Query<ReadMotion>,
        enabled: Vec<Entity>,
        orphans: Vec<Entity>,
    ) {
        for item in enabled.into_iter().flat_map(|entity| motion.get(entity)) {
            if !self.is_read(&item) {
                self.read_one(item);
            }
        }
        for item in orphans.into_iter().flat_map(|entity| motion.get(entity)) {
            let slot = item.1.get().map(|(slot, _)| slot);
            // Those that could not be read beneath it take no part.
            let is_unread =
                |slot| self.entities.local(slot).is_some() || !self.bodies.is_active(slot);
            if slot.is_some_and(is_unread) {
                self.read_one(item);
            }
        }
    }

    /// Whether [`Self::read_all`] has read an entity: to take the velocity over once more would undo that a kinematic body goes to its pose.
    fn is_read(&self, (_, _, transform, linear, angular, child_of): &MotionOf) -> bool {
        let by_user = |tick: Tick, is_changed: bool| is_changed && tick != self.entities.written;
        child_of.is_some()
            || by_user(transform.last_changed(), transform.is_changed())
            || by_user(linear.last_changed(), linear.is_changed())
            || by_user(angular.last_changed(), angular.is_changed())
    }

    fn read_one(&mut self, (entity, handle, transform, linear, angular, child_of): MotionOf) {
        self.read(Row {
            entity,
            handle,
            transform: &transform,
            velocity: (linear.0, angular.0),
            child_of,
        });
    }

    fn read(&mut self, row: Row) {
        let bodies = &mut *self.bodies;
        let Some((slot, _)) = (row.handle.0).filter(|&(slot, id)| bodies.is_current(slot, id))
        else {
            return;
        };
        let idle = idle_velocity(bodies.kind(slot), row.velocity.0, row.velocity.1)
            .or_else(|idle| self.halted.contains(&row.entity).then_some(()).ok_or(idle));
        self.issues
            .note(self.warnings, row.entity, Source::Velocity, idle);
        let taken = self.take(slot, row);
        let is_usable = taken.is_ok();
        self.issues
            .note(self.warnings, row.entity, Source::Motion, taken);
        self.bodies.set_frozen(slot, !is_usable);
        if self.issues.is_any_of_place(row.entity) {
            // What it lacked may be what is read now.
            self.rescaled.push(row.entity);
        }
    }

    /// Takes velocity and pose over.
    fn take(&mut self, slot: u32, row: Row) -> Result<(), BodyError> {
        let bodies = &mut *self.bodies;
        let (linear, angular) = row.velocity;
        bodies.set_velocity(slot, linear, angular)?;
        let seen = self.entities.seen[slot as usize];
        let kind = bodies.kind(slot);
        let known = self.entities.local(slot);
        let (pose, scale, is_moved) = match row.child_of {
            None => {
                self.entities.forget_local(slot);
                let pose = Pose::new(row.transform.translation, row.transform.rotation);
                let is_moved = is_elsewhere(bodies, slot, pose, &seen);
                (pose, row.transform.scale, is_moved)
            }
            Some(child_of) => {
                let (entities, from) = (&*self.entities, &*bodies);
                let (parents, handles) = (self.parents, self.handles);
                let own_way = |entity, local| {
                    let handle = handles.get(entity).ok()?;
                    goes_own_way(from, entities, handle.0?, local)
                };
                let (pose, scale) = parents.place(row.transform, row.child_of, kind, &own_way)?;
                let local = (child_of.parent(), *row.transform);
                let before = Pose::new(seen.translation, seen.rotation);
                let size = 2.0 * reach(row.transform, pose.position, scale);
                let is_moved = match kind {
                    // Goes its own way, wherever its parent goes.
                    RigidBody::Dynamic => {
                        known != Some(local) && !is_rounding(pose, from.pose(slot), size)
                    }
                    _ => !is_rounding(pose, before, size),
                };
                self.entities.set_local(slot, local.0, local.1);
                // What rounding makes of a chain is not followed.
                (if is_moved { pose } else { before }, scale, is_moved)
            }
        };
        let is_rescaled = !is_same_scale(scale, seen.scale);
        self.entities.seen[slot as usize] = Transform {
            translation: pose.position,
            rotation: pose.rotation,
            // Not what rounding makes of it as parents turn.
            scale: if is_rescaled { scale } else { seen.scale },
        };
        if is_rescaled {
            self.rescaled.push(row.entity);
        }
        // Who is handed from parent to parent in place is not moved by what rounding makes of it.
        let is_handed_on = known.map(|local| local.0) != row.child_of.map(ChildOf::parent);
        let stays = is_handed_on && is_same_place(pose, self.bodies.pose(slot));
        if is_moved && !stays {
            let put = self.put(slot, pose);
            let refused = |_: &BodyError| self.forget_place(slot, row.child_of);
            put.inspect_err(refused)?;
        }
        Ok(())
    }

    /// A body is not where it was to be: whenever that is read again it is news again.
    fn forget_place(&mut self, slot: u32, child_of: Option<&ChildOf>) {
        self.entities.seen[slot as usize].translation = Vec3::NAN;
        if let Some(child_of) = child_of {
            let nowhere = Transform::from_translation(Vec3::NAN);
            self.entities.set_local(slot, child_of.parent(), nowhere);
        }
    }

    /// Puts a body somewhere else, or lets it go there within the step.
    fn put(&mut self, slot: u32, pose: Pose) -> Result<(), BodyError> {
        let bodies = &mut *self.bodies;
        if bodies.kind(slot) == RigidBody::Kinematic && bodies.is_active(slot) {
            check_pose(&pose)?;
            self.kinematic
                .push(KinematicTarget::new(bodies, slot, pose));
            return Ok(());
        }
        bodies.set_pose(slot, pose)
    }
}

/// Whether somebody has put a body that is no child elsewhere, which was seen last at `seen`.
fn is_elsewhere(bodies: &Bodies, slot: u32, pose: Pose, seen: &Transform) -> bool {
    if bodies.kind(slot) == RigidBody::Static {
        // Never written: what was read last may differ by rounding from the pose about the center of mass. And it may be long ago that
        // it was read, before the body moved and was made static where it was.
        let is_same = pose == Pose::new(seen.translation, seen.rotation);
        return !is_same && !is_rounded_pose(pose, bodies.pose(slot), false);
    }
    // Whoever sets it anew where it is neither stops it nor moves it.
    let moves = bodies.velocity(slot) != (Vec3::ZERO, Vec3::ZERO);
    !is_rounded_pose(pose, bodies.pose(slot), moves)
}

/// Where a dynamic body is that is not where its parent would bring it, unless somebody has set it there.
fn goes_own_way(
    bodies: &Bodies,
    entities: &BodyEntities,
    (slot, id): (u32, BodyId),
    local: (Entity, Transform),
) -> Option<Pose> {
    let is_own = bodies.is_current(slot, id)
        && bodies.kind(slot) == RigidBody::Dynamic
        && entities.local(slot) == Some(local);
    is_own.then(|| bodies.pose(slot))
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
