//! Who takes local steps besides those whose contacts ask for it: who may meet them, and what a step would let into each other.
//!
//! Contacts are found where a step begins, along the ways that bodies go by then, and who takes local steps meets nobody who waits
//! meanwhile. So what is in reach of an island that takes some takes as many, if it touches nothing or takes fewer.
//!
//! And who is struck goes another way: it meets others that it has no contact with, or from a side that the contact it has does not know.
//! So the ends of these ways are looked at before bodies are moved. Where two would be inside of each other, their islands are put back
//! to where they were and take local steps, each of which finds contacts anew.

use crate::bodies::body::Shape;
use crate::bodies::solver_body::SolverBody;
use crate::bodies::store::Bodies;
use crate::collide::proxies::Lookahead;
use crate::contact::pairs::broad_phase::Broadphase;
use crate::geometry::distance::{Separation, distance, distance_from};
use crate::geometry::support::{PlacedCore, ShrunkCore, Support};
use crate::math::{Pose, rotate};
use crate::query::shape::QueryPart;
use crate::solver::config::{Method, SoftStep};
use crate::solver::contact_solver::ContactSolver;
use crate::solver::deferral::StepRole;
use crate::solver::estimates::FALL;
use crate::step::settings::StepSettings;
use glam::Vec3;
use smallvec::SmallVec;
use std::cmp::Reverse;

/// How far a body goes in a step, or is turned aside in it, as a share of its least extent, from which on the end of its way is looked at.
const FAR: f32 = 0.25;

/// How far a body goes in a step, as a share of its radius, from which on it may meet who waits. Of its least extent, plates and needles would
/// take many local steps more, and not rest for it (`docs/decisions/local_steps.md`).
const NOTICEABLE: f32 = 0.1;

/// Bodies are inside of each other if the smaller one still overlaps the other when it is so many times as large.
const INSIDE: f64 = 0.8;

/// How far two bodies that would be inside of each other move against each other in a local step, as a share of the smaller one's least
/// extent.
const STRIDE: f32 = 0.25;

/// Velocities before the solve, and who is found after it; buffers are reused.
#[derive(Debug, Default)]
pub(crate) struct Companions {
    /// Slots of the bodies that contacts move, ascending, with their velocities before the solve; empty where nothing goes far or is small
    /// for the step.
    start: Vec<(u32, SolverBody)>,
    roles: Vec<StepRole>,
    near: Vec<u32>,
    /// Slots that are found, and how many local steps they take.
    found: Vec<(u32, u32)>,
}

impl Companions {
    /// Notes the velocities if any body goes far in the step, or is so small that its contacts may ask for local steps.
    pub(super) fn begin(&mut self, bodies: &Bodies, settings: &StepSettings) {
        self.start.clear();
        let Some(_) = local_method(settings) else {
            return;
        };
        let step = settings.step_dt;
        let small = step * step * settings.gravity.0.length() / FALL;
        let is_noted = |slot: u32| {
            let i = slot as usize;
            let (extent, velocity) = (bodies.min_extent[i], bodies.velocity[i].linear);
            let far = FAR * extent;
            (step * step * velocity.length_squared() > far * far || extent < small)
                && bodies.is_carried(slot)
        };
        let slots = 0..bodies.slots() as u32;
        if slots.clone().any(is_noted) {
            let carried = slots.filter(|&slot| bodies.is_carried(slot));
            let start = carried.map(|slot| (slot, bodies.velocity[slot as usize]));
            self.start.extend(start);
        }
    }

    /// Puts off who goes with the islands that take local steps, and who would end inside of another one.
    pub(super) fn put_off(
        &mut self,
        bodies: &mut Bodies,
        broadphase: &Broadphase,
        solver: &mut ContactSolver,
        settings: &StepSettings,
    ) {
        let Some(method) = local_method(settings).filter(|_| !self.start.is_empty()) else {
            return;
        };
        self.found.clear();
        self.find_inside(bodies, broadphase, solver, (settings, &method));
        if self.found.is_empty() && solver.put_off.is_empty() {
            return;
        }
        solver.find_roles(bodies, &mut self.roles);
        self.find_in_reach(bodies, broadphase, solver, settings);
        // Of each the most steps.
        self.found
            .sort_unstable_by_key(|&(slot, steps)| (slot, Reverse(steps)));
        self.found.dedup_by_key(|&mut (slot, _)| slot);
        for &(slot, local_steps) in &self.found {
            let role = self.roles[slot as usize];
            solver.put_off_too(bodies, &self.start, (slot, role), local_steps);
        }
        solver.forget_put_off();
    }

    /// Finds who is in reach of islands that take more local steps.
    fn find_in_reach(
        &mut self,
        bodies: &Bodies,
        broadphase: &Broadphase,
        solver: &ContactSolver,
        settings: &StepSettings,
    ) {
        let ahead = Lookahead::new(settings.step_dt, settings.gravity.0);
        let roles = &self.roles;
        let in_reach = broadphase.pairs().iter().filter_map(|pair| {
            let slots = [pair.a, pair.b];
            let [a, b] = slots.map(|slot| solver.local_steps_of(roles[slot as usize]));
            let (a, b) = (a?, b?);
            let found = if a < b { (pair.a, b) } else { (pair.b, a) };
            let joins = a != b
                && bodies.may_touch(pair.a, pair.b)
                && reach_each_other(bodies, slots, &ahead);
            joins.then_some(found)
        });
        self.found.extend(in_reach);
    }

    /// Finds who contacts turn aside so that it ends inside of another body.
    fn find_inside(
        &mut self,
        bodies: &Bodies,
        broadphase: &Broadphase,
        solver: &ContactSolver,
        (settings, method): (&StepSettings, &SoftStep),
    ) {
        for (slot, start) in &self.start {
            let slot = *slot;
            let least = FAR * bodies.min_extent[slot as usize];
            if !solver.is_solved(slot) || turned_aside(bodies, slot, start, settings) < least {
                continue;
            }
            self.near.clear();
            for part in parts_after_step(bodies, slot) {
                broadphase.search_box(&part.bounds(), &mut self.near);
            }
            for &other in &self.near {
                let is_fixed = bodies.velocity[other as usize].inverse_mass == 0.0;
                let is_there = bodies.is_active(other) && (is_fixed || solver.is_solved(other));
                let meets = other != slot && is_there && bodies.may_touch(slot, other);
                if let Some(strides) = strides(bodies, [slot, other]).filter(|_| meets)
                    && is_inside_after_step(bodies, [slot, other])
                {
                    let most = method.max_local_steps as f32;
                    let local_steps = (strides.clamp(2.0, most) as u32).next_power_of_two();
                    self.found.push((slot, local_steps));
                    if !is_fixed {
                        self.found.push((other, local_steps));
                    }
                }
            }
        }
    }
}

/// How far points of a body are from where they would be without contacts, at most, m. `start`: its velocity before the solve.
fn turned_aside(bodies: &Bodies, slot: u32, start: &SolverBody, settings: &StepSettings) -> f32 {
    let (i, step) = (slot as usize, settings.step_dt);
    let straight = step * (start.linear + 0.5 * step * settings.gravity.0);
    let turn = step * (bodies.velocity[i].angular - start.angular).length();
    (bodies.motion[i].shift - straight).length() + turn * bodies.radius(slot)
}

/// The method, if it knows local steps.
fn local_method(settings: &StepSettings) -> Option<SoftStep> {
    match settings.config.method {
        Method::SoftStep(soft_step) if soft_step.max_local_steps > 1 => Some(soft_step),
        _ => None,
    }
}

/// Whether one of two bodies goes so far in the step that it gets to where the other is or will be, even if something stops one of them. What
/// hardly moves meets nobody.
fn reach_each_other(bodies: &Bodies, slots: [u32; 2], ahead: &Lookahead) -> bool {
    let ways = slots.map(|slot| ahead.travel(bodies, slot).length());
    let least = slots.map(|slot| NOTICEABLE * bodies.radius(slot));
    let goes_on = ways[0] > least[0] || ways[1] > least[1];
    if !goes_on || !ahead.may_meet(bodies, slots) {
        return false;
    }
    let limit = f64::from(ways[0].max(ways[1]) + ahead.fall);
    let [of_a, of_b] = slots.map(|slot| parts_at(bodies, slot, bodies.pose(slot)));
    of_a.iter().any(|a| {
        of_b.iter().any(|b| {
            let core = PlacedCore::new(b.core, &b.pose).seen_from(&a.pose);
            let radii = f64::from(a.radius) + f64::from(b.radius);
            !matches!(distance(&a.core, &core, limit + radii), Separation::Far)
        })
    })
}

/// In how many strides two bodies go the way that they move against each other within the step; `None` if it is not far.
fn strides(bodies: &Bodies, slots: [u32; 2]) -> Option<f32> {
    let [a, b] = slots.map(|slot| way_in_step(bodies, slot));
    let way = (a.0 - b.0).length() + a.1 + b.1;
    let extents = slots.map(|slot| bodies.min_extent[slot as usize]);
    let extents = extents.map(|extent| if extent > 0.0 { extent } else { f32::INFINITY });
    let extent = extents[0].min(extents[1]);
    (way >= FAR * extent).then_some((way / (STRIDE * extent)).ceil())
}

/// How far the solver moves a body, and how far a point of it may turn about its center at most, m.
fn way_in_step(bodies: &Bodies, slot: u32) -> (Vec3, f32) {
    if !bodies.is_moving(slot) {
        return (Vec3::ZERO, 0.0);
    }
    let (i, motion) = (slot as usize, &bodies.motion[slot as usize]);
    let turn = motion.rotation * bodies.rotation[i].inverse();
    (
        motion.shift,
        2.0 * turn.xyz().length() * bodies.radius(slot),
    )
}

/// The convex parts of a body as they will be after the step.
fn parts_after_step(bodies: &Bodies, slot: u32) -> SmallVec<[QueryPart<'_>; 4]> {
    parts_at(bodies, slot, bodies.pose_after_step(slot))
}

/// The convex parts of a body at a pose; none for what is not made of any.
fn parts_at(bodies: &Bodies, slot: u32, pose: Pose) -> SmallVec<[QueryPart<'_>; 4]> {
    match &bodies.info(slot).shape {
        Shape::Convex(mesh) => SmallVec::from_iter([QueryPart::of(mesh, pose)]),
        Shape::Compound(compound) => {
            let parts = compound.parts().iter();
            let parts = parts.map(|part| QueryPart::of(&part.shape, pose * part.pose));
            parts.collect()
        }
        Shape::HalfSpace(_) | Shape::Level(_) => SmallVec::new(),
    }
}

/// Whether two bodies are inside of each other after the step. What gets into levels is looked for elsewhere (`step/guard.rs`).
fn is_inside_after_step(bodies: &Bodies, slots: [u32; 2]) -> bool {
    let [a, b] = slots.map(|slot| bodies.min_extent[slot as usize]);
    let [large, small] = if b > 0.0 && b < a {
        slots
    } else {
        [slots[1], slots[0]]
    };
    let parts = parts_after_step(bodies, small);
    if let Shape::HalfSpace(below) = &bodies.info(large).shape {
        let pose = bodies.pose_after_step(large);
        let down = -rotate(pose.rotation, below.normal).as_dvec3();
        return parts.iter().any(|part| {
            let lowest =
                ShrunkCore::new(PlacedCore::new(part.core, &part.pose), INSIDE).support(down);
            let depth = (lowest - pose.position.as_dvec3()).dot(down);
            depth > -INSIDE * f64::from(part.radius)
        });
    }
    let others = parts_after_step(bodies, large);
    parts.iter().any(|part| {
        others.iter().any(|other| {
            let core = PlacedCore::new(part.core, &part.pose);
            let core = ShrunkCore::new(core.seen_from(&other.pose), INSIDE);
            let start = core.inside() - other.core.middle().as_dvec3();
            let radii = f64::from(other.radius) + INSIDE * f64::from(part.radius);
            match distance_from(&other.core, &core, start, radii) {
                Separation::Near(near) => near.distance < radii,
                Separation::Far => false,
                Separation::Overlap => true,
            }
        })
    })
}
