//! All joints of a simulation: who is joined to whom, and what each bore.

use crate::bodies::store::{Bodies, RigidBody};
use crate::contact::body_id::BodyId;
use crate::joints::error::JointError;
use crate::joints::joint::Joint;
use bevy_ecs::component::Component;
use bevy_ecs::resource::Resource;
use glam::Vec3;

/// Name of a joint, given once and never again: later joints have larger numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JointId(pub u32);

/// A body of a joint, or the world.
pub(crate) type JointEnd = Option<(u32, BodyId)>;

/// What a joint bore in the last step, and how B was against A then.
#[derive(Clone, Copy, Debug, Default, PartialEq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct JointLoad {
    /// Force on B at its anchor, mean of the step, world axes, N. Where several joints could bear it, they share it such that it is least.
    pub force: Vec3,
    /// Torque on B, world axes, N m.
    pub torque: Vec3,
    /// How far B's anchor is from A's, axes of A's frame, m.
    pub translation: Vec3,
    /// Turn of a hinge or twist, counted on over full turns, rad.
    pub angle: f32,
    /// Largest error of what is locked in the step: m, and rad.
    pub error: [f32; 2],
}

/// A joint that is no more, because it bore too much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrokenJoint {
    /// Its name.
    pub id: JointId,
    /// Slots and ids of its bodies; `None` is the world.
    pub bodies: [Option<(u32, BodyId)>; 2],
    /// What it was.
    pub joint: Joint,
    /// What it bore.
    pub load: JointLoad,
    /// Energy that its springs held and that is gone with it, J.
    pub stored_energy: f32,
}

/// A joint with its bodies.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointRecord {
    pub(crate) id: JointId,
    pub(crate) joint: Joint,
    pub(crate) ends: [JointEnd; 2],
    pub(crate) load: JointLoad,
    /// Force on B at its anchor that may make bodies hard to turn, N.
    pub(crate) tension: Vec3,
    /// Energy in its springs, J.
    pub(crate) stored_energy: f32,
    /// Whether a piece of a body that broke has it, and its entity does not know yet.
    pub(crate) is_inherited: bool,
}

/// All joints of a simulation.
#[derive(Clone, Debug, Default, Resource)]
pub struct Joints {
    /// Sorted by id.
    pub(crate) list: Vec<JointRecord>,
    /// Joints that broke in the last step.
    pub broken: Vec<BrokenJoint>,
    next_id: u32,
    /// Whether `Bodies` must be told anew whom joints hold, and which pairs do not touch.
    pub(crate) is_outdated: bool,
}

impl Joints {
    /// Number of joints.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there are no joints.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Joins the body in slot `b` to the one in slot `a`, or to the world, and wakes both.
    ///
    /// # Errors
    /// [`JointError`]; nothing changes then.
    pub fn insert(
        &mut self,
        bodies: &mut Bodies,
        a: Option<u32>,
        b: u32,
        joint: Joint,
    ) -> Result<JointId, JointError> {
        joint.check()?;
        let ends = ends_of(bodies, a, b)?;
        let id = JointId(self.next_id);
        self.next_id += 1;
        self.list.push(JointRecord {
            id,
            joint,
            ends,
            load: JointLoad {
                angle: joint.expected_twist(),
                ..JointLoad::default()
            },
            tension: Vec3::ZERO,
            stored_energy: 0.0,
            is_inherited: false,
        });
        self.is_outdated = true;
        wake(bodies, &ends);
        Ok(id)
    }

    /// Changes what a joint is, and wakes its bodies if that changes anything; whether there is such a joint.
    ///
    /// # Errors
    /// [`JointError`], also if none of its bodies is dynamic any more; the joint stays as it was then.
    pub fn set(
        &mut self,
        bodies: &mut Bodies,
        id: JointId,
        joint: Joint,
    ) -> Result<bool, JointError> {
        joint.check()?;
        let Some(at) = self.find(id) else {
            return Ok(false);
        };
        let record = &mut self.list[at];
        if record.is_there(bodies) && !record.can_move(bodies) {
            return Err(JointError::NothingMoves);
        }
        if record.joint != joint {
            self.is_outdated |= record.joint.contacts != joint.contacts;
            record.joint = joint;
            wake(bodies, &record.ends);
        }
        Ok(true)
    }

    /// Takes joints away that `is_gone` tells, and wakes their bodies.
    pub fn remove_all(&mut self, bodies: &mut Bodies, is_gone: impl Fn(JointId) -> bool) {
        let before = self.list.len();
        self.list.retain(|record| {
            let is_gone = is_gone(record.id);
            if is_gone {
                wake(bodies, &record.ends);
            }
            !is_gone
        });
        self.is_outdated |= self.list.len() != before;
    }

    /// Takes a joint away, and wakes its bodies; whether there was one.
    pub fn remove(&mut self, bodies: &mut Bodies, id: JointId) -> bool {
        let is_there = self.find(id).is_some();
        if is_there {
            self.remove_all(bodies, |other| other == id);
        }
        is_there
    }

    /// Whether there is a joint of this name.
    pub fn contains(&self, id: JointId) -> bool {
        self.find(id).is_some()
    }

    /// A joint.
    pub fn get(&self, id: JointId) -> Option<&Joint> {
        self.find(id).map(|at| &self.list[at].joint)
    }

    /// What a joint bore in the last step.
    pub fn load(&self, id: JointId) -> Option<&JointLoad> {
        self.find(id).map(|at| &self.list[at].load)
    }

    /// Slots of a joint's bodies; `None` is the world.
    pub fn bodies(&self, id: JointId) -> Option<[Option<u32>; 2]> {
        let record = self.find(id).map(|at| &self.list[at])?;
        Some(record.ends.map(|end| end.map(|(slot, _)| slot)))
    }

    /// Names of all joints, in the order in which they were made.
    pub fn iter(&self) -> impl Iterator<Item = JointId> {
        self.list.iter().map(|record| record.id)
    }

    /// Whether there is a joint of this name, between bodies that are still there and of which one can move. `at`: where it is looked for
    /// first, for a walk through names that ascend.
    pub(crate) fn is_held(&self, bodies: &Bodies, id: JointId, at: &mut usize) -> bool {
        let rest = self.list.get(*at..).unwrap_or(&[]).iter();
        *at += rest.take_while(|record| record.id < id).count();
        let found = self.list.get(*at).filter(|record| record.id == id);
        found.is_some_and(|record| record.is_there(bodies) && record.can_move(bodies))
    }

    /// Joints that pieces have got since this was last asked.
    pub(crate) fn take_inherited(&mut self) -> impl Iterator<Item = JointRecord> {
        let inherited = |record: &mut JointRecord| std::mem::take(&mut record.is_inherited);
        let list = self.list.iter_mut();
        list.filter_map(move |record| inherited(record).then_some(*record))
    }

    pub(crate) fn find(&self, id: JointId) -> Option<usize> {
        self.list.binary_search_by_key(&id, |record| record.id).ok()
    }

    /// Forgets joints whose bodies are gone, wakes what hangs on a body that moves, and tells the bodies whom joints hold and which pairs
    /// do not touch. Before contacts are looked for.
    pub(crate) fn note_bodies(&mut self, bodies: &mut Bodies) {
        if bodies.asleep() > 0 {
            for record in &self.list {
                record.wake_carried(bodies);
            }
        }
        let before = self.list.len();
        self.list.retain(|record| {
            let is_there = record.is_there(bodies);
            if !is_there {
                wake(bodies, &record.ends);
            }
            is_there
        });
        if !(self.is_outdated || self.list.len() != before) {
            return;
        }
        self.is_outdated = false;
        bodies.jointed.clear();
        let ends = self.list.iter().flat_map(|record| record.ends);
        bodies.jointed.extend(ends.flatten().map(|(_, id)| id));
        bodies.jointed.sort_unstable();
        bodies.jointed.dedup();
        bodies.apart.clear();
        let pairs = self.list.iter().filter(|record| !record.joint.contacts);
        let pairs = pairs.filter_map(|record| match record.ends {
            [Some((_, a)), Some((_, b))] => Some((a.min(b), a.max(b))),
            _ => None,
        });
        bodies.apart.extend(pairs);
        bodies.apart.sort_unstable();
        bodies.apart.dedup();
    }

    /// Before the solve: lists the joints that are part of the problem.
    pub(crate) fn attach(&self, bodies: &Bodies, active: &mut Vec<JointRecord>) {
        active.clear();
        active.extend(self.list.iter().filter(|record| record.is_active(bodies)));
    }

    /// After the solve: takes over what the joints bore.
    pub(crate) fn take_back(&mut self, active: &[JointRecord]) {
        let mut next = 0;
        for record in active {
            let rest = self.list[next..].iter();
            next += rest.take_while(|known| known.id < record.id).count();
            let Some(known) = self
                .list
                .get_mut(next)
                .filter(|known| known.id == record.id)
            else {
                continue;
            };
            known.load = record.load;
            known.tension = record.tension;
            known.stored_energy = record.stored_energy;
        }
    }

    /// Breaks joints that bore too much. What slept on their bodies wakes.
    pub(crate) fn break_overloaded(&mut self, bodies: &mut Bodies) {
        let before = self.broken.len();
        for record in self.list.iter().filter(|record| record.is_overloaded()) {
            wake(bodies, &record.ends);
            self.broken.push(BrokenJoint {
                id: record.id,
                bodies: record.ends,
                joint: record.joint,
                load: record.load,
                stored_energy: record.stored_energy,
            });
        }
        if self.broken.len() != before {
            self.list.retain(|record| !record.is_overloaded());
            self.is_outdated = true;
        }
    }
}

impl JointRecord {
    /// Whether its bodies are the ones that it was made for.
    pub(crate) fn is_there(&self, bodies: &Bodies) -> bool {
        let mut ends = self.ends.iter().flatten();
        ends.all(|&(slot, id)| bodies.is_current(slot, id))
    }

    /// Whether one of its bodies is dynamic.
    fn can_move(&self, bodies: &Bodies) -> bool {
        let mut ends = self.ends.iter().flatten();
        ends.any(|&(slot, _)| bodies.kind(slot) == RigidBody::Dynamic)
    }

    /// Wakes a body that sleeps on one that is moved or was changed.
    fn wake_carried(&self, bodies: &mut Bodies) {
        if let [Some((a, _)), Some((b, _))] = self.ends {
            for (fixed, slot) in [(a, b), (b, a)] {
                if bodies.is_asleep(slot) && is_displaced(bodies, fixed) {
                    bodies.wake(slot);
                }
            }
        }
    }

    /// Whether it bore more than it can.
    fn is_overloaded(&self) -> bool {
        let JointLoad { force, torque, .. } = self.load;
        force.length() > self.joint.break_force || torque.length() > self.joint.break_torque
    }

    /// Whether it is part of the problem of a step: its bodies take part, one of them is awake and dynamic.
    pub(crate) fn is_active(&self, bodies: &Bodies) -> bool {
        let mut slots = self.ends.iter().flatten().map(|&(slot, _)| slot);
        let moves = |slot: u32| {
            bodies.velocity[slot as usize].inverse_mass > 0.0 && !bodies.is_asleep(slot)
        };
        slots.clone().all(|slot| bodies.is_active(slot)) && slots.any(moves)
    }
}

/// Whether a body that joints do not move moves, or was changed since the last step.
pub(crate) fn is_displaced(bodies: &Bodies, slot: u32) -> bool {
    let Some(body) = bodies.velocity.get(slot as usize) else {
        return false;
    };
    let moves = body.linear != Vec3::ZERO || body.angular != Vec3::ZERO;
    body.inverse_mass == 0.0 && (moves || bodies.sleep.is_changed(slot))
}

fn ends_of(bodies: &Bodies, a: Option<u32>, b: u32) -> Result<[JointEnd; 2], JointError> {
    if a == Some(b) {
        return Err(JointError::SameBody);
    }
    let mut slots = a.into_iter().chain([b]);
    if !slots.clone().all(|slot| bodies.contains(slot)) {
        return Err(JointError::NoBody);
    }
    if !slots.any(|slot| bodies.kind(slot) == RigidBody::Dynamic) {
        return Err(JointError::NothingMoves);
    }
    Ok([a, Some(b)].map(|end| end.map(|slot| (slot, bodies.id(slot)))))
}

fn wake(bodies: &mut Bodies, ends: &[JointEnd; 2]) {
    for &(slot, id) in ends.iter().flatten() {
        if bodies.is_current(slot, id) {
            bodies.wake(slot);
        }
    }
}
