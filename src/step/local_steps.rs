//! Islands of bodies that are small for the step, or turn far in it: several steps for them within it, while all others wait.
//!
//! Contacts are found at the start of a step, for bodies that move straight on and turn a little. What is small falls by its own
//! size in a step, and is anywhere else by the end of it: a card of 4 mm is 2.7 mm below at 60 Hz. Its island takes as many local
//! steps as let gravity move it by a small share of its size in each, and as let it turn by half a radian, all like a step of the whole scene: pairs, contacts,
//! warm start, solve, breaking, integration. Islands that ask for as many take them together.
//!
//! Who waits is not there for them. What may meet them takes local steps too, if it is free to (`step/companions.rs`).

use crate::bodies::integrate::move_bodies;
use crate::bodies::store::Bodies;
use crate::contact::manifolds::{ManifoldRef, Manifolds};
use crate::contact::point::ContactPoint;
use crate::fracture::{Fracture, note_blows};
use crate::merge::{Merged, merge};
use crate::solver::config::Method;
use crate::solver::contact_solver::ContactSolver;
use crate::step::contacts::Contacts;
use crate::step::local_buffers::LocalBuffers;
use crate::step::report::StepReport;
use crate::step::settings::StepSettings;
use crate::step::{Breakable, break_in_rounds, broadphase, generate_contacts};

/// Lets the islands that were put off, of which there are some, take their local steps, those that take as many of them together.
pub(super) fn take_local_steps(
    bodies: &mut Bodies,
    contacts: &mut Contacts,
    mut breakable: Breakable,
    settings: &StepSettings,
    report: &mut StepReport,
) {
    let mut local = std::mem::take(&mut contacts.local);
    let stats = report.cache;
    let bonded = std::mem::take(&mut contacts.solver.bonded);
    let joints = std::mem::take(&mut contacts.solver.joints);
    std::mem::swap(&mut local.whole, &mut contacts.manifolds);
    let most = contacts.solver.put_off.iter().map(|it| it.local_steps);
    let most = most.max().unwrap_or(1);
    // Powers of two.
    for exponent in 1..=most.ilog2() {
        let count = 1 << exponent;
        let ContactSolver {
            put_off,
            put_off_slots,
            ..
        } = &contacts.solver;
        let takes_as_many = put_off.iter().filter(|island| island.local_steps == count);
        let members = takes_as_many.flat_map(|island| &put_off_slots[island.bodies.clone()]);
        local.members.clear();
        local
            .members
            .extend(members.filter(|&&slot| bodies.contains(slot)));
        if !local.members.is_empty() {
            local.begin_group(bodies, contacts, settings);
            let first_batch = contacts.solver.earlier;
            for _ in 0..count {
                contacts.solver.begin_local_step(bodies, first_batch);
                // As the step itself tells it, so that boxes do not change their size all the time.
                broadphase(bodies, contacts, settings, report);
                let settings = &settings.of_local_step(count);
                local.take(bodies, contacts, breakable.again(), settings, report);
                note_blows(breakable.fractures, bodies, &contacts.solver, first_batch);
            }
            bodies.end_local();
            scale_rates(&mut local.sums, count as f32);
            join(&mut local.whole, &local.sums, &mut local.joined, bodies);
        }
    }
    std::mem::swap(&mut local.whole, &mut contacts.manifolds);
    (contacts.solver.bonded, contacts.solver.joints) = (bonded, joints);
    contacts.local = local;
    report.cache = stats;
    report.manifolds = contacts.manifolds.len();
    report.contacts = contacts.manifolds.points().len();
}

impl StepSettings {
    /// The same for one of so many local steps, which share the sweeps that an island may take beyond the least.
    fn of_local_step(&self, count: u32) -> Self {
        let mut settings = *self;
        settings.step_dt /= count as f32;
        if let Method::SoftStep(soft_step) = &mut settings.config.method {
            soft_step.max_local_steps = 1;
            soft_step.max_extra_updates /= count;
        }
        settings
    }
}

impl LocalBuffers {
    /// Lets all but the members wait, and keeps what the members' contacts start from.
    fn begin_group(
        &mut self,
        bodies: &mut Bodies,
        contacts: &mut Contacts,
        settings: &StepSettings,
    ) {
        bodies.begin_local(&self.members, &contacts.solver.carriers);
        self.sums.clear();
        self.joined.clear();
        for manifold in self.whole.iter() {
            let is_of_group = bodies.is_local(manifold.a) || bodies.is_local(manifold.b);
            let list = if is_of_group {
                &mut self.joined
            } else {
                &mut self.sums
            };
            list.push(manifold);
        }
        std::mem::swap(&mut self.whole, &mut self.sums);
        self.sums.clear();
        self.cache.clear();
        if settings.config.warm_start {
            let (ids, rotations) = (&bodies.ids, &bodies.rotation);
            self.cache
                .store_and_age(&self.joined, ids, rotations, settings.step_dt);
        }
        contacts.solver.begin_group();
    }

    /// One local step, of the pairs that are known.
    fn take(
        &mut self,
        bodies: &mut Bodies,
        contacts: &mut Contacts,
        breakable: Breakable,
        settings: &StepSettings,
        report: &mut StepReport,
    ) {
        generate_contacts(bodies, contacts, &mut self.cache, settings, report);
        contacts.solve_round(bodies, breakable.fractures, settings, 1);
        let mut breakable = Breakable {
            cache: &mut self.cache,
            ..breakable
        };
        let known = breakable.fractures.done.len();
        break_in_rounds(bodies, contacts, breakable.again(), settings, report);
        let broken = &breakable.fractures.done[known..];
        forget_broken(&mut self.sums, broken, &mut self.joined);
        contacts.hold_before_walls(bodies);
        move_bodies(bodies, &mut report.problems);
        self.keep_impulses(bodies, contacts, settings);
    }

    /// Adds the impulses of a local step to those of the ones before, and stores them for the next one.
    fn keep_impulses(&mut self, bodies: &Bodies, contacts: &Contacts, settings: &StepSettings) {
        if settings.config.warm_start {
            self.cache.store_and_age(
                &contacts.manifolds,
                &bodies.ids,
                &bodies.rotation,
                settings.step_dt,
            );
        }
        // What is over goes on at no rate.
        scale_rates(&mut self.sums, 0.0);
        join(
            &mut self.sums,
            &contacts.manifolds,
            &mut self.joined,
            bodies,
        );
    }
}

/// Adds `new` manifolds to `list`, both sorted by body ids: of a pair that both have, the points are the new ones, which get what
/// the others bore too.
fn join(list: &mut Manifolds, new: &Manifolds, joined: &mut Manifolds, bodies: &Bodies) {
    let name = |m: &ManifoldRef| (bodies.id(m.a), bodies.id(m.b));
    joined.clear();
    for manifold in merge(list.iter(), new.iter(), |old, new| {
        name(old).cmp(&name(new))
    }) {
        match manifold {
            Merged::Left(manifold) | Merged::Right(manifold) => joined.push(manifold),
            Merged::Both(old, new) => {
                joined.push(new);
                let first = joined.points().len() - new.points().len();
                let borne = old.points().iter().map(|point| point.total_impulse).sum();
                add_impulse(&mut joined.points_mut()[first..], borne);
            }
        }
    }
    std::mem::swap(list, joined);
}

/// Shares an impulse of earlier local steps, N s, among points in proportion to what they have borne, or evenly.
fn add_impulse(points: &mut [ContactPoint], impulse: f32) {
    let borne: f32 = points.iter().map(|point| point.total_impulse).sum();
    let even = impulse / points.len() as f32;
    for point in points {
        point.total_impulse += if borne > 0.0 {
            point.total_impulse / borne * impulse
        } else {
            even
        };
    }
}

/// Multiplies the impulses that go on at the rate of the last sub-step.
fn scale_rates(manifolds: &mut Manifolds, scale: f32) {
    for point in manifolds.points_mut() {
        point.normal_impulse *= scale;
        point.friction_impulse *= scale;
    }
}

/// Takes contacts of what broke out of a list: a piece may have its slot.
fn forget_broken(list: &mut Manifolds, broken: &[Fracture], kept: &mut Manifolds) {
    if broken.is_empty() {
        return;
    }
    let is_gone = |slot: u32| broken.iter().any(|fracture| fracture.parent_slot == slot);
    kept.clear();
    for manifold in list.iter() {
        if !is_gone(manifold.a) && !is_gone(manifold.b) {
            kept.push(manifold);
        }
    }
    std::mem::swap(list, kept);
}
