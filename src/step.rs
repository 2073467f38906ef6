//! The loop: one step of the simulation as phases over plain data.
//!
//! [`Simulation::step`] is the whole step; the plugin runs the same phase functions as systems in the same order.
//!
//! ```text
//! 1 mass properties    changed shapes   -> mass, center, inertia
//! 2 cut                cuts asked for   -> pieces, with the multipliers of their parents
//! 3 broadphase         boxes            -> pairs, sorted by body id
//! 4 contact generation pairs, hulls     -> manifolds; multipliers from the cache
//! 5 solve              forces, manifolds -> rows -> impulses with w = A lambda - b, lo <= lambda <= hi
//! 6 fracture           impulses over the strength -> pieces; 3, 4 and 5 again for the islands in which something broke
//! 7 local steps        3 to 8, several times, for the islands of bodies that are small for the step
//! 8 integrate          velocities       -> poses
//! 9 cache aging        impulses         -> cache: hits reset, others one step older, stale ones evicted
//! 10 sleep             velocities, poses -> islands at rest, left out from the next step on
//! ```
//!
//! Sleeping bodies are woken in phase 4, where it is known who touches them; see `solver/sleep.rs`.

mod breakable;
mod companions;
pub(crate) mod contact_events;
mod contact_news;
mod contact_place;
pub(crate) mod contacts;
mod guard;
mod loads;
mod local_buffers;
mod local_steps;
mod measure;
pub(crate) mod report;
pub(crate) mod settings;
pub(crate) mod simulation;
mod surfaces;

use crate::step::loads::bear_loads;
use crate::step::local_steps::take_local_steps;
use crate::step::measure::report_solution;
pub use breakable::Breakable;
pub use contact_events::ContactEvents;
pub use contact_news::{ContactChange, ContactEvent, ContactWatch};
pub use contacts::Contacts;
pub use report::{IslandReport, StepError, StepReport};
pub use settings::StepSettings;
pub use simulation::Simulation;

use crate::bodies::integrate;
use crate::bodies::store::Bodies;
use crate::collide::narrow_phase::{self};
use crate::collide::proxies::Lookahead;
use crate::contact::impulses::{CacheStats, ContactCache, TouchingBodies};
use crate::fracture::{
    Bonds, Fractures, Inherited, break_overloaded, find_holds, make_cuts, note_blows,
};
use crate::joints::Joints;
use crate::threads::team::Team;

impl Simulation {
    /// Advances the simulation by `step_dt` seconds. Does nothing unless the settings are usable.
    pub fn step(&mut self, step_dt: f32) {
        let settings = &self.settings(step_dt);
        if !settings.is_usable() {
            return;
        }
        let Self {
            bodies,
            contacts,
            cache,
            fractures,
            bonds,
            joints,
            report,
            ..
        } = self;
        mass_properties(bodies, report);
        cut(bodies, cache, fractures, bonds, settings);
        begin_joints(bodies, fractures, joints);
        broadphase(bodies, contacts, settings, report);
        generate_contacts(bodies, contacts, cache, settings, report);
        attach_bonds(bodies, contacts, bonds);
        attach_joints(bodies, contacts, joints);
        solve(bodies, contacts, fractures, settings, report);
        let mut breakable = Breakable {
            cache,
            fractures,
            bonds,
            joints,
        };
        fracture(bodies, contacts, breakable.again(), settings, report);
        local_steps(bodies, contacts, breakable, settings, report);
        integrate(bodies, contacts, report);
        age_cache(bodies, contacts, cache, settings);
        sleep(bodies, contacts, cache, settings, report);
        find_contact_events(bodies, contacts, settings);
        bodies.forget_sleep_changes();
    }
}

/// Phase 1: mass, center of mass and inertia of bodies whose shape or density changed.
pub fn mass_properties(bodies: &mut Bodies, report: &mut StepReport) {
    report.problems.clear();
    bodies.fresh_mass.clear();
    let mut stale = std::mem::take(&mut bodies.stale_mass);
    for slot in stale.drain(..) {
        if !bodies.contains(slot) {
            continue;
        }
        if let Err(error) = bodies.refresh_mass(slot) {
            report.problems.push((slot, error.into()));
        }
    }
    bodies.stale_mass = stale;
    report.bodies = bodies.len();
}

/// Phase 2: cuts that were asked for.
pub fn cut(
    bodies: &mut Bodies,
    cache: &mut ContactCache,
    fractures: &mut Fractures,
    bonds: &mut Bonds,
    settings: &StepSettings,
) {
    let StepSettings {
        budget, step_dt, ..
    } = settings;
    find_holds(bodies);
    make_cuts(fractures, bodies, cache, bonds, budget, *step_dt);
    bonds.note_pairs(bodies);
}

/// Phase 3: pairs of bodies whose boxes, with all they may reach within the step, overlap.
pub fn broadphase(
    bodies: &Bodies,
    contacts: &mut Contacts,
    settings: &StepSettings,
    report: &mut StepReport,
) {
    let ahead = Lookahead::new(settings.step_dt, settings.gravity.0);
    narrow_phase::update_pairs(
        &mut contacts.broadphase,
        &mut contacts.narrow,
        bodies,
        ahead,
    );
    report.pairs = contacts.broadphase.pairs().len();
}

/// Phase 4: manifolds of all pairs that are awake, and where the solver left off at the same points. Wakes what must.
pub fn generate_contacts(
    bodies: &mut Bodies,
    contacts: &mut Contacts,
    cache: &mut ContactCache,
    settings: &StepSettings,
    report: &mut StepReport,
) {
    let Contacts {
        broadphase,
        narrow,
        manifolds,
        ..
    } = contacts;
    let ahead = Lookahead::new(settings.step_dt, settings.gravity.0);
    if !bodies.local.is_on {
        bodies.wake_disturbed(&settings.config.sleep, settings.gravity.0);
    }
    let is_worth_help = narrow_phase::is_worth_help(broadphase.pairs().len());
    report.cache = Team::lead_if(is_worth_help, |team| {
        loop {
            narrow.collide(bodies, broadphase, ahead, manifolds, team);
            // What was woken has pairs of its own, and may touch others that sleep.
            if bodies.local.is_on || !bodies.wake_touched(manifolds.heads()) {
                break;
            }
        }
        // Who takes local steps touches nobody that sleeps: the next step wakes those.
        if !bodies.local.is_on {
            bodies.end_wake();
            bodies.resume_woken(cache);
        }
        if !settings.config.warm_start {
            return CacheStats::default();
        }
        let touching = TouchingBodies {
            ids: &bodies.ids,
            rotations: &bodies.rotation,
            boxes: &bodies.kd_box,
            have_parts: bodies.any_level || bodies.any_compound,
        };
        cache.warm_start_by(team, manifolds, touching, settings.step_dt)
    });
    report.manifolds = manifolds.len();
    report.contacts = manifolds.points().len();
}

/// The end of phase 4: manifolds of bonded pairs hold, those of running surfaces run.
pub fn attach_bonds(bodies: &Bodies, contacts: &mut Contacts, bonds: &mut Bonds) {
    let Contacts {
        solver, manifolds, ..
    } = contacts;
    bonds.begin_step();
    bonds.attach(bodies, manifolds, &mut solver.bonded);
    surfaces::attach(bodies, manifolds, &mut solver.bonded);
}

/// The end of phase 2: joints of bodies that were cut go to the pieces, those of bodies that are gone go.
pub fn begin_joints(bodies: &mut Bodies, fractures: &Fractures, joints: &mut Joints) {
    joints.broken.clear();
    joints.inherit(bodies, fractures);
    joints.note_bodies(bodies);
}

/// The end of phase 4: joints that are part of the problem.
pub fn attach_joints(bodies: &Bodies, contacts: &mut Contacts, joints: &Joints) {
    joints.attach(bodies, &mut contacts.solver.joints);
}

/// Within phase 6: takes over what joints bore; those that bore too much break.
fn break_joints(bodies: &mut Bodies, contacts: &Contacts, joints: &mut Joints) {
    joints.take_back(&contacts.solver.joints);
    joints.break_overloaded(bodies);
}

/// Phase 5: forces, then impulses that keep the bodies apart. Islands in which a body breaks are left as they were.
pub fn solve(
    bodies: &mut Bodies,
    contacts: &mut Contacts,
    fractures: &Fractures,
    settings: &StepSettings,
    report: &mut StepReport,
) {
    let StepSettings {
        gravity, config, ..
    } = *settings;
    let energy_before = config
        .measure_error
        .then(|| bodies.energy(gravity.0, false).iter().sum::<f64>());
    contacts.events.note_velocities(bodies);
    contacts.companions.begin(bodies, settings);
    contacts.solve_round(bodies, fractures, settings, 0);
    contacts.put_off_companions(bodies, settings);
    contacts.energy_before = energy_before;
    if contacts.is_solved() {
        report_solution(bodies, contacts, settings, report);
    }
}

/// Within phase 6: bonds that were loaded beyond their strength break.
fn break_bonds(bodies: &mut Bodies, contacts: &Contacts, bonds: &mut Bonds) {
    bonds.break_overloaded(bodies, &contacts.solver.bonded);
}

/// Phase 6: bodies that were hit with more than they bear become pieces, and the islands in which that happened are solved
/// anew, until nothing breaks any more; so do bonds and joints.
pub fn fracture(
    bodies: &mut Bodies,
    contacts: &mut Contacts,
    breakable: Breakable,
    settings: &StepSettings,
    report: &mut StepReport,
) {
    let mut breakable = breakable;
    let was_solved = contacts.is_solved();
    break_in_rounds(bodies, contacts, breakable.again(), settings, report);
    note_blows(breakable.fractures, bodies, &contacts.solver, 0);
    break_bonds(bodies, contacts, breakable.bonds);
    break_joints(bodies, contacts, breakable.joints);
    if contacts.any_island_waits() {
        return;
    }
    if !was_solved {
        report_solution(bodies, contacts, settings, report);
    }
    bear_loads(bodies, contacts, breakable, settings);
}

/// Phase 7: islands of what is small for the step take several steps of their own. Nothing if there are none.
pub fn local_steps(
    bodies: &mut Bodies,
    contacts: &mut Contacts,
    mut breakable: Breakable,
    settings: &StepSettings,
    report: &mut StepReport,
) {
    if !contacts.any_island_waits() {
        return;
    }
    take_local_steps(bodies, contacts, breakable.again(), settings, report);
    report_solution(bodies, contacts, settings, report);
    bear_loads(bodies, contacts, breakable, settings);
}

/// Breaks what was hit with more than it bears and solves its islands anew, until nothing breaks any more.
fn break_in_rounds(
    bodies: &mut Bodies,
    contacts: &mut Contacts,
    breakable: Breakable,
    settings: &StepSettings,
    report: &mut StepReport,
) {
    let Breakable {
        cache,
        fractures,
        bonds,
        joints,
    } = breakable;
    let mut round = 0;
    while contacts.is_broken {
        round += 1;
        break_bonds(bodies, contacts, bonds);
        joints.take_back(&contacts.solver.joints);
        let Contacts {
            manifolds, solver, ..
        } = contacts;
        let inherited = Inherited { cache, bonds };
        break_overloaded(
            fractures,
            bodies,
            manifolds,
            inherited,
            &settings.budget,
            solver,
        );
        bonds.note_pairs(bodies);
        joints.inherit(bodies, fractures);
        joints.note_bodies(bodies);
        contacts.events.note_pieces(bodies, fractures);
        contacts.stash_solved(bodies);
        broadphase(bodies, contacts, settings, report);
        generate_contacts(bodies, contacts, cache, settings, report);
        contacts.merge_solved(bodies);
        // What is bonded, jointed or on a running surface takes no local steps.
        if !bodies.local.is_on {
            bonds.attach(bodies, &mut contacts.manifolds, &mut contacts.solver.bonded);
            surfaces::attach(bodies, &contacts.manifolds, &mut contacts.solver.bonded);
            joints.attach(bodies, &mut contacts.solver.joints);
        }
        contacts.solve_round(bodies, fractures, settings, round);
    }
}

/// Phase 8: poses from velocities. A body that would stop being finite is stopped where it is, and reported; one that would get through what
/// it strikes stops before it.
pub fn integrate(bodies: &mut Bodies, contacts: &mut Contacts, report: &mut StepReport) {
    contacts.hold_before_walls(bodies);
    integrate::integrate_positions(bodies, &mut report.problems);
}

/// Phase 9: the cache takes the new impulses and ages the rest.
pub fn age_cache(
    bodies: &Bodies,
    contacts: &Contacts,
    cache: &mut ContactCache,
    settings: &StepSettings,
) {
    if !settings.config.warm_start {
        cache.clear();
        return;
    }
    cache.store_and_age(
        &contacts.manifolds,
        &bodies.ids,
        &bodies.rotation,
        settings.step_dt,
    );
}

/// Phase 10: islands at rest fall asleep. Their multipliers are kept for when they wake.
pub fn sleep(
    bodies: &mut Bodies,
    contacts: &Contacts,
    cache: &mut ContactCache,
    settings: &StepSettings,
    report: &mut StepReport,
) {
    let Contacts {
        solver, manifolds, ..
    } = contacts;
    bodies.fall_asleep(&settings.config.sleep, solver, manifolds, settings.step_dt);
    if !bodies.sleep.slept.is_empty() {
        cache.suspend(&bodies.sleep.slept);
    }
    report.asleep = bodies.asleep();
    report.awake = bodies.dynamic() - report.asleep;
}

/// After the last phase: who began to touch, came apart or bears much, of those that were asked about.
pub fn find_contact_events(bodies: &Bodies, contacts: &mut Contacts, settings: &StepSettings) {
    let Contacts {
        events,
        manifolds,
        broadphase,
        narrow,
        ..
    } = contacts;
    if events.is_on() || !bodies.sensors.is_empty() {
        events.update(bodies, manifolds, (broadphase, narrow), settings.step_dt);
    }
}
