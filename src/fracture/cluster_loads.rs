//! Sustained loads of clusters: what contacts, joints, gravity and inertia do to their parts, and what breaks under it.
//!
//! Looked at after the solve. Blows are no part of it: a contact counts with what it bore when nothing hit it any more, as a mean over
//! [`MEMORY`]. Most clusters bear so little that no bond could break, or the same as when it was last found out what that does; only
//! the others are solved.

use crate::bodies::body::RigidBody;
use crate::bodies::cluster_state::{ClusterState, LoadSource, PartLoad};
use crate::bodies::store::Bodies;
use crate::cluster::bearing::Borne;
use crate::cluster::elastic::Wrench;
use crate::cluster::load::LoadOutcome;
use crate::contact::manifolds::Manifolds;
use crate::fracture::bearings::{borne_by, find_bearings, is_held_back};
use crate::fracture::cluster::BrokenBonds;
use crate::fracture::contact_loads::add_contact;
use crate::fracture::grip::{find_grips, grip_at};
use crate::geometry::Compound;
use crate::joints::Joints;
use crate::math::rotate;
use glam::{DVec3, Vec3};

/// Time over which a load is a mean, s.
const MEMORY: f32 = 0.05;

/// Time from one look at the loads to the next, s; a little less than two steps at 60 Hz.
pub(super) const LOOK_INTERVAL: f32 = 0.032;

/// Time for which a load must be more than bonds bear before they break, s. What comes to rest on soft contacts sags and rebounds for as long:
/// a mean alone is up to 1.3 times the load at 30 Hz, and what hits is a blow.
const SUSTAINED: f32 = 0.12;

/// Share of its strength that a bond must bear for the loads of its cluster to be noted in each step.
const FOLLOWED: f64 = 0.5;

/// Change of a load that is worth another look at what it does, as a share of all of it.
const CHANGE: f64 = 0.005;

/// Products of blocks of six by six that a cluster may take in a step to work out what its parts do, 2 to 3 ms: a beam of 1300 parts is done after 20
/// steps, a block of 1800 after 170. No step is long because a large one has lost a corner.
const WORK_PER_STEP: usize = 40_000;

/// Share of the largest load below which another one is over.
const OVER: f64 = 1e-6;

/// What loads clusters in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepLoads<'s> {
    pub(crate) manifolds: &'s Manifolds,
    pub(crate) joints: &'s Joints,
    /// m/s2.
    pub(crate) gravity: Vec3,
    /// Length of the step, s.
    pub(crate) step_dt: f32,
}

/// Bonds that sustained loads break, by body; `elapsed` (s) after the last look.
pub(super) fn judge_loads(
    bodies: &mut Bodies,
    step: &StepLoads,
    elapsed: f32,
) -> Vec<(u32, BrokenBonds)> {
    let found = find_loads(bodies, step, |_, _| true);
    let slots: Vec<u32> = bodies.cluster_slots().collect();
    let mut asked: Vec<(u32, [DVec3; 2])> = Vec::new();
    for slot in slots {
        let is_asleep = bodies.is_active(slot) && bodies.is_asleep(slot);
        if !bodies.is_active(slot) || is_asleep && !goes_on(bodies, slot) {
            continue;
        }
        // The steps before have been noted.
        let elapsed = match is_followed(bodies, slot) {
            true => step.step_dt,
            false => elapsed,
        };
        let own = loads_of(&found, slot);
        asked.extend(is_asked(bodies, slot, &own, (step.gravity, elapsed)).map(|it| (slot, it)));
    }
    if !asked.is_empty() {
        let slots: Vec<u32> = asked.iter().map(|(slot, _)| *slot).collect();
        find_bearings(bodies, step.manifolds, step.gravity, &slots);
    }
    let mut broken = Vec::new();
    for (slot, motion) in asked {
        let Some(outcome) = judge(bodies, slot, &motion, elapsed) else {
            continue;
        };
        let of = bodies.cluster(slot).map_or(0, |it| it.network.bonds.len());
        broken.push((
            slot,
            BrokenBonds {
                of,
                bonds: outcome.broken,
            },
        ));
    }
    broken
}

/// What loads the clusters that are asked for, by cluster, source and part.
fn find_loads(
    bodies: &Bodies,
    step: &StepLoads,
    is_asked: impl Fn(&Bodies, u32) -> bool,
) -> Vec<(u32, PartLoad)> {
    let mut found: Vec<(u32, PartLoad)> = Vec::new();
    let grips = find_grips(bodies, step.manifolds);
    for manifold in step.manifolds.iter() {
        for side in 0..2 {
            let slot = [manifold.a, manifold.b][side];
            if bodies.cluster(slot).is_some() && is_asked(bodies, slot) {
                let grip = grip_at(bodies, &grips, &manifold, side);
                add_contact(bodies, &manifold, side, (step.step_dt, grip), &mut found);
            }
        }
    }
    add_joints(bodies, step.joints, &mut found);
    add_pushes(bodies, &mut found);
    found.sort_by_key(|(slot, load)| (*slot, load.from));
    found
}

/// Those of a cluster.
fn loads_of(found: &[(u32, PartLoad)], slot: u32) -> Vec<PartLoad> {
    let first = found.partition_point(|(of, _)| *of < slot);
    let own = found[first..].iter().take_while(|(of, _)| *of == slot);
    own.map(|(_, load)| *load).collect()
}

/// Whether the loads of a cluster are noted in each step: where they are, or were at the last look, near to what breaks it.
fn is_followed(bodies: &Bodies, slot: u32) -> bool {
    let is_near = |state: &ClusterState| {
        let judged = state.judged.as_ref();
        state.overloaded > 0.0 || judged.is_some_and(|judged| judged.utilization > FOLLOWED)
    };
    bodies.cluster(slot).is_some_and(is_near)
}

/// Between two looks at the loads: takes note of what loads those that it may break. Contacts tremble by rounding, and their impulses are those of a
/// sub-step: a beam on edge, 60 times as long as it is wide, bore three hundredths of its load sideways at one look and not at the next.
pub(super) fn follow_loads(bodies: &mut Bodies, step: &StepLoads) {
    let slots = bodies.cluster_slots();
    let slots = slots.filter(|&slot| is_followed(bodies, slot));
    let slots: Vec<u32> = slots
        .filter(|&slot| bodies.is_active(slot) && !bodies.is_asleep(slot))
        .collect();
    if slots.is_empty() {
        return;
    }
    let found = find_loads(bodies, step, is_followed);
    for slot in slots {
        let holding = held_back(bodies, slot);
        let now = loads_of(&found, slot);
        if let Some(state) = bodies.cluster_mut(slot) {
            remember(&mut state.loads, &now, &holding, step.step_dt);
        }
    }
}

/// Between two looks at the loads: goes on with what the last one has begun to work out, for as much as a step may.
pub(super) fn work_out_loads(bodies: &mut Bodies) {
    for slot in 0..bodies.cluster_end() {
        let is_active = bodies.cluster(slot).is_some() && bodies.is_active(slot);
        let state = bodies.cluster_mut(slot).filter(|_| is_active);
        if let Some(elastic) = state.and_then(|state| state.elastic.as_mut()) {
            elastic.prepare(&mut WORK_PER_STEP.clone());
        }
    }
}

/// Whether it is not known yet what the load does that a body has fallen asleep with: a large one sleeps before that is worked out.
fn goes_on(bodies: &Bodies, slot: u32) -> bool {
    let state = bodies.cluster(slot);
    state.is_some_and(|state| state.judged.is_none() && !state.loads.is_empty())
}

/// Adds what joints do to clusters.
fn add_joints(bodies: &Bodies, joints: &Joints, found: &mut Vec<(u32, PartLoad)>) {
    for record in &joints.list {
        for side in 0..2 {
            let Some((slot, id)) = record.ends[side] else {
                continue;
            };
            let Some(state) = bodies.cluster(slot).filter(|_| bodies.is_current(slot, id)) else {
                continue;
            };
            let Some(compound) = bodies.compound(slot) else {
                continue;
            };
            let place = [record.joint.frame_a, record.joint.frame_b][side].position;
            let part = compound.part_at(place);
            let to_body = bodies.pose(slot).rotation.inverse();
            let sign = [-1.0, 1.0][side];
            let own = |v: Vec3| rotate(to_body, sign * v).as_dvec3();
            let (force, torque) = (own(record.load.force), own(record.load.torque));
            let arm = place.as_dvec3() - state.network.nodes[part as usize].center;
            let wrench = Wrench {
                force,
                torque: torque + arm.cross(force),
            };
            let from = (LoadSource::Joint(record.id.0), part);
            found.push((slot, PartLoad { from, wrench }));
        }
    }
}

/// Adds what forces at points do to clusters.
fn add_pushes(bodies: &Bodies, found: &mut Vec<(u32, PartLoad)>) {
    let first = found.len();
    for push in &bodies.pushes.forces {
        let slot = push.slot;
        let state = bodies.cluster(slot);
        let state = state.filter(|_| bodies.is_current(slot, push.id));
        let (Some(compound), Some(state)) = (bodies.compound(slot), state) else {
            continue;
        };
        let part = compound.part_at(push.place);
        let force = push.amount.as_dvec3();
        let arm = push.place.as_dvec3() - state.network.nodes[part as usize].center;
        let wrench = Wrench {
            force,
            torque: arm.cross(force),
        };
        let from = (LoadSource::Push, part);
        let mut own = found[first..].iter_mut();
        match own.find(|(of, load)| *of == slot && load.from == from) {
            Some((_, load)) => load.wrench.add(wrench),
            None => found.push((slot, PartLoad { from, wrench })),
        }
    }
}

/// Takes note of the loads of a step; if it is to be asked what they do to the bonds, gravity and spin in the frame of the compound.
fn is_asked(
    bodies: &mut Bodies,
    slot: u32,
    now: &[PartLoad],
    (gravity, elapsed): (Vec3, f32),
) -> Option<[DVec3; 2]> {
    let to_body = bodies.pose(slot).rotation.inverse();
    let (kind, spin) = (bodies.kind(slot), bodies.velocity(slot).1);
    let weight = bodies.drive(slot).gravity_scale * gravity;
    let motion = [weight, spin].map(|v| rotate(to_body, v).as_dvec3());
    let reach = f64::from(bodies.compound(slot)?.aabb().diagonal());
    let is_asleep = bodies.is_asleep(slot);
    let holding = held_back(bodies, slot);
    let state = bodies.cluster_mut(slot)?;
    // Contacts of what sleeps are not looked at: all loads go on as they were.
    if !is_asleep {
        remember(&mut state.loads, now, &holding, elapsed);
    }
    let is_held = state.held.as_ref()?.contains(&true);
    if kind == RigidBody::Kinematic || kind == RigidBody::Static && !is_held {
        return None;
    }
    let mass: f64 = state.network.nodes.iter().map(|node| node.mass).sum();
    let own = |motion: &[DVec3; 2]| match is_held {
        true => mass * motion[0],
        false => mass * reach * motion[1] * motion[1].length(),
    };
    let loads = state.loads.iter().map(PartLoad::size);
    let total = loads.sum::<f64>() + own(&motion).length();
    let least = state.network.least_force;
    // Not a number: nothing is known.
    if !total.is_finite() || total < least {
        state.overloaded = 0.0;
        if is_asleep {
            // No bond can bear a larger share than this.
            state.note_judged(motion, total / least);
        }
        return None;
    }
    if let Some(judged) = &state.judged {
        let changed = difference(&judged.loads, &state.loads);
        let changed = changed + (own(&motion) - own(&judged.motion)).length();
        let is_safe = judged.utilization + changed / least < 1.0;
        if is_safe || changed < CHANGE * total {
            return None;
        }
    }
    Some(motion)
}

/// What the loads do to a cluster, if they break a bond; with gravity and spin in its frame.
fn judge(bodies: &mut Bodies, slot: u32, motion: &[DVec3; 2], elapsed: f32) -> Option<LoadOutcome> {
    let compound = bodies.compound(slot)?.clone();
    let state = bodies.cluster_mut(slot)?;
    let is_held = state.held.as_ref()?.contains(&true);
    let is_due = state.overloaded + elapsed >= SUSTAINED;
    let outcome = bear(state, &compound, (is_held, motion), is_due)?;
    if outcome.broken.is_empty() {
        state.note_judged(*motion, outcome.utilization);
        state.overloaded = 0.0;
        return None;
    }
    // Looked at again until it is over, or long enough.
    state.judged = None;
    state.overloaded += elapsed;
    is_due.then_some(outcome)
}

/// What the load does; none as long as that is being worked out. As long as it `is_due` to break nothing, no more than whether it would.
fn bear(
    state: &mut ClusterState,
    compound: &Compound,
    (is_held, motion): (bool, &[DVec3; 2]),
    is_due: bool,
) -> Option<LoadOutcome> {
    let network = &state.network;
    let mut loads = vec![Wrench::default(); network.nodes.len()];
    let mut borne = borne_by(state);
    for PartLoad {
        from: (source, part),
        wrench,
    } in &state.loads
    {
        match borne.iter_mut().find(|(of, _)| of == source) {
            Some((_, borne)) => borne.parts.push((*part, *wrench)),
            None => loads[*part as usize].add(*wrench),
        }
    }
    let borne: Vec<Borne> = borne.into_iter().map(|(_, borne)| borne).collect();
    network.spread(compound, &borne, motion[0], &mut loads);
    drop(borne);
    if is_held {
        for (load, node) in loads.iter_mut().zip(&network.nodes) {
            load.force += node.mass * motion[0];
        }
    }
    let held = state.held.as_deref().unwrap_or_default();
    let mut budget = WORK_PER_STEP;
    let how_far = (!is_due, &mut budget);
    network.bear(&mut state.elastic, &loads, (held, motion[1]), how_far)
}

/// Loads of a cluster by contacts with bodies that sleep: these are not looked at, and go on as they were.
fn held_back(bodies: &Bodies, slot: u32) -> Vec<LoadSource> {
    let loads = bodies.cluster(slot).map_or(&[][..], |state| &state.loads);
    let sources = loads.iter().map(|load| load.from.0);
    sources
        .filter(|source| is_held_back(bodies, source))
        .collect()
}

/// Lets what is remembered come nearer to what is now; both are sorted.
fn remember(loads: &mut Vec<PartLoad>, now: &[PartLoad], holding: &[LoadSource], elapsed: f32) {
    let share = f64::from(elapsed / (MEMORY + elapsed));
    for load in loads.iter_mut() {
        if now
            .binary_search_by_key(&load.from, |new| new.from)
            .is_err()
            && !holding.contains(&load.from.0)
        {
            load.wrench.scale(1.0 - share);
        }
    }
    for new in now {
        match loads.binary_search_by_key(&new.from, |load| load.from) {
            Ok(at) => {
                let old = &mut loads[at].wrench;
                old.scale(1.0 - share);
                let mut added = new.wrench;
                added.scale(share);
                old.add(added);
            }
            Err(at) => {
                let mut first = *new;
                first.wrench.scale(share);
                loads.insert(at, first);
            }
        }
    }
    let most = loads.iter().map(PartLoad::size).fold(0.0, f64::max);
    loads.retain(|load| load.size() > OVER * most);
}

/// How far two lists of loads are apart, N.
fn difference(before: &[PartLoad], after: &[PartLoad]) -> f64 {
    let pairs = crate::merge::merge(before.iter(), after.iter(), |a, b| a.from.cmp(&b.from));
    let sizes = pairs.map(|pair| {
        let (before, after) = pair.into_options();
        let mut wrench = after.map_or(Wrench::default(), |load| load.wrench);
        let mut taken = before.map_or(Wrench::default(), |load| load.wrench);
        taken.scale(-1.0);
        wrench.add(taken);
        wrench.force.length()
    });
    sizes.sum()
}
