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
//! 7 integrate          velocities       -> poses
//! 8 cache aging        impulses         -> cache: hits reset, others one step older, stale ones evicted
//! 9 sleep              velocities, poses -> islands at rest, left out from the next step on
//! ```
//!
//! Sleeping bodies are woken in phase 4, where it is known who touches them; see [`sleep`](crate::solver::sleep).

use crate::bodies::body::BodyError;
use crate::bodies::integrate;
use crate::bodies::store::Bodies;
use crate::collide::narrow_phase::{self, NarrowPhase};
use crate::collide::proxies::Lookahead;
use crate::contact::impulses::{CacheStats, ContactCache};
use crate::contact::manifolds::{ManifoldRef, Manifolds};
use crate::contact::pairs::broad_phase::Broadphase;
use crate::fracture::{
    Bond, BondError, Bonds, CutError, CutRequest, FractureBudget, Fractures, break_overloaded,
    make_cuts, note_loads,
};
use crate::math::Plane;
use crate::solver::config::{Gravity, SolverConfig};
use crate::solver::contact_solver::{ContactSolver, Round};
use crate::solver::rows::contact_rows::PointRows;
use crate::solver::rows::mlcp::Residual;
use crate::solver::rows::residual::ResidualSum;
use crate::solver::settings::{SolverOverrides, SubstepSettings};
use crate::threads::team::Team;
use bevy_ecs::resource::Resource;

/// Everything between the bodies and the solver that lives from step to step.
#[derive(Debug, Default, Resource)]
pub struct Contacts {
    pub(crate) broadphase: Broadphase,
    pub(crate) narrow: NarrowPhase,
    pub(crate) manifolds: Manifolds,
    pub(crate) solver: ContactSolver,
    /// Whether a body broke in the last round, and its island waits for the next one.
    is_broken: bool,
    /// Manifolds that are solved while a new round is prepared, sorted by body ids.
    solved: Manifolds,
    /// For putting the two together.
    joined: Manifolds,
    /// Kinetic and potential energy before the step, J, if the error is measured.
    energy_before: Option<f64>,
    /// Rows of an island whose error is measured.
    rows: Vec<PointRows>,
}

/// Rounds of breaking in one step. What breaks only after so many others before it bears the step and may break in the next
/// one.
const MAX_ROUNDS: u32 = 3;

impl Contacts {
    /// Solves what is not solved yet.
    fn solve_round(
        &mut self,
        bodies: &mut Bodies,
        fractures: &Fractures,
        settings: &StepSettings,
        round: u32,
    ) {
        let StepSettings {
            gravity,
            config,
            step_dt,
            ..
        } = *settings;
        let substeps =
            SubstepSettings::new(&config, gravity.0, step_dt).overridden(&settings.overrides);
        let round = Round {
            is_first: round == 0,
            may_break: round < MAX_ROUNDS && fractures.can_afford(&settings.budget),
        };
        let Self {
            solver, manifolds, ..
        } = self;
        self.is_broken = solver.solve(manifolds, bodies, &substeps, round);
    }

    /// Keeps the manifolds of bodies that have got their motion, whose contacts are not to be looked for again.
    fn stash_solved(&mut self) {
        self.solved.clear();
        for manifold in self.manifolds.iter() {
            if self.solver.is_solved(manifold.a) || self.solver.is_solved(manifold.b) {
                self.solved.push(manifold);
            }
        }
    }

    /// Puts them back in place of what was found anew for the same bodies.
    fn merge_solved(&mut self, bodies: &Bodies) {
        let solver = &self.solver;
        let name = |m: &ManifoldRef| (bodies.id(m.a), bodies.id(m.b));
        let is_new = |m: &ManifoldRef| !solver.is_solved(m.a) && !solver.is_solved(m.b);
        let mut new = self.manifolds.iter().filter(is_new).peekable();
        self.joined.clear();
        for solved in self.solved.iter() {
            while let Some(before) = new.next_if(|new| name(new) < name(&solved)) {
                self.joined.push(before);
            }
            self.joined.push(solved);
        }
        new.for_each(|manifold| self.joined.push(manifold));
        std::mem::swap(&mut self.manifolds, &mut self.joined);
    }

    /// Manifolds of the last step with the impulses that were found, sorted by body ids. Those of bodies that sleep are not
    /// among them.
    pub fn manifolds(&self) -> &Manifolds {
        &self.manifolds
    }

    /// Islands and rows of the last step.
    pub fn solver(&self) -> &ContactSolver {
        &self.solver
    }
}

/// What the last step did.
#[derive(Clone, Debug, Default, PartialEq, Resource)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct StepReport {
    /// Bodies in the simulation.
    pub bodies: usize,
    /// Dynamic bodies that are awake.
    pub awake: usize,
    /// Bodies that sleep.
    pub asleep: usize,
    /// Pairs that the broad phase found.
    pub pairs: usize,
    /// Pairs that touch or nearly touch.
    pub manifolds: usize,
    /// Contact points.
    pub contacts: usize,
    /// How the contact cache did.
    pub cache: CacheStats,
    /// Errors of the solution; only with [`SolverConfig::measure_error`].
    pub error: Option<StepError>,
    /// One body each of the islands in which a sub-step ended above the tolerance, by slot.
    pub unconverged: Vec<u32>,
    /// The islands; only with [`SolverConfig::measure_islands`].
    #[cfg_attr(feature = "reflect", reflect(ignore))]
    pub islands: Vec<IslandReport>,
    /// Bodies that were left out since the last step, with the reason, by slot.
    #[cfg_attr(feature = "reflect", reflect(ignore))]
    pub problems: Vec<(u32, BodyError)>,
}

/// How wrong the step was.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct StepError {
    /// Residual of the contact problem of the last sub-step.
    pub residual: Residual,
    /// Deepest overlap of two bodies at the start of the step, m.
    pub penetration: f32,
    /// Kinetic energy of all dynamic bodies after the step, J.
    pub kinetic_energy: f64,
    /// Potential energy of all dynamic bodies in the gravity field after the step, zero at the origin, J.
    pub potential_energy: f64,
    /// What both together gained in the step, J; friction and impacts make it negative.
    pub energy_change: f64,
}

/// How one island was solved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IslandReport {
    /// Slot of one of its dynamic bodies, to find it by.
    pub slot: u32,
    /// Bodies, with those that contacts do not move.
    pub bodies: usize,
    /// Contact points.
    pub contacts: usize,
    /// Sweeps of all sub-steps together.
    pub sweeps: u32,
    /// Whether a sub-step ended above the tolerance, because [`SolverConfig::max_sweeps`] were done.
    pub is_unconverged: bool,
    /// Its own residual, with [`SolverConfig::measure_error`].
    pub residual: Option<Residual>,
}

/// A simulation on plain data: what the plugin does, without an app.
#[derive(Debug, Default)]
pub struct Simulation {
    /// The bodies.
    pub bodies: Bodies,
    /// Contacts of the last step.
    pub contacts: Contacts,
    /// Multipliers of earlier steps.
    pub cache: ContactCache,
    /// Cuts asked for and made.
    pub fractures: Fractures,
    /// What holds bodies together.
    pub bonds: Bonds,
    /// Gravity.
    pub gravity: Gravity,
    /// How contacts are solved.
    pub config: SolverConfig,
    /// What fracture may cost.
    pub budget: FractureBudget,
    /// What the last step did.
    pub report: StepReport,
    /// What a test wants otherwise.
    #[doc(hidden)]
    pub overrides: SolverOverrides,
}

/// What all phases of one step are told.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepSettings {
    /// Gravity.
    pub gravity: Gravity,
    /// How contacts are solved.
    pub config: SolverConfig,
    /// What fracture may cost.
    pub budget: FractureBudget,
    /// Length of the step, s.
    pub step_dt: f32,
    /// What a test wants otherwise.
    #[doc(hidden)]
    pub overrides: SolverOverrides,
}

impl StepSettings {
    /// Whether a step can be made: its length must be finite and positive, gravity and configuration usable.
    pub fn is_usable(&self) -> bool {
        self.has_length() && self.are_numbers_usable()
    }

    /// Whether the step is positive and finite; it is not while time is paused.
    pub fn has_length(&self) -> bool {
        self.step_dt.is_finite() && self.step_dt > 0.0
    }

    /// Whether gravity is finite and the configuration usable.
    pub fn are_numbers_usable(&self) -> bool {
        self.gravity.0.is_finite() && self.config.is_usable()
    }
}

impl Simulation {
    /// Cuts the body in `slot` by a plane (world frame) in the next step; what came of it is in `fractures` then.
    ///
    /// # Errors
    /// [`CutError::NoBody`] if the slot is free.
    pub fn slice(&mut self, slot: u32, plane: Plane) -> Result<(), CutError> {
        let request = CutRequest::in_world(&self.bodies, slot, plane)?;
        self.fractures.requests.push(request);
        Ok(())
    }

    /// Bonds the bodies in two slots as they lie now.
    ///
    /// # Errors
    /// [`BondError`]; nothing changes then.
    pub fn bond(&mut self, a: u32, b: u32, bond: Bond) -> Result<(), BondError> {
        self.bonds.bond(&mut self.bodies, a, b, bond)
    }

    /// Bonds all of the given bodies that touch face to face over their common areas with a tensile and shear strength
    /// (Pa); the number of bonds made. See [`Bonds::bond_neighbors`].
    ///
    /// # Errors
    /// [`BondError`]; no bonds are made then.
    pub fn bond_neighbors(&mut self, slots: &[u32], strength: f32) -> Result<usize, BondError> {
        self.bonds.bond_neighbors(&mut self.bodies, slots, strength)
    }

    /// What the phases of a step of `step_dt` seconds are told.
    pub fn settings(&self, step_dt: f32) -> StepSettings {
        StepSettings {
            gravity: self.gravity,
            config: self.config,
            budget: self.budget,
            step_dt,
            overrides: self.overrides,
        }
    }

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
            report,
            ..
        } = self;
        mass_properties(bodies, report);
        advance(bodies, contacts, cache, fractures, bonds, settings, report);
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

/// Phases 2 to 9, one after the other.
pub fn advance(
    bodies: &mut Bodies,
    contacts: &mut Contacts,
    cache: &mut ContactCache,
    fractures: &mut Fractures,
    bonds: &mut Bonds,
    settings: &StepSettings,
    report: &mut StepReport,
) {
    cut(bodies, cache, fractures, bonds, settings);
    broadphase(bodies, contacts, settings, report);
    generate_contacts(bodies, contacts, cache, settings, report);
    attach_bonds(bodies, contacts, bonds);
    solve(bodies, contacts, fractures, settings, report);
    fracture(bodies, contacts, cache, fractures, bonds, settings, report);
    break_bonds(bodies, contacts, bonds);
    integrate(bodies, report);
    age_cache(bodies, contacts, cache, settings);
    sleep(bodies, contacts, cache, settings, report);
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
    make_cuts(fractures, bodies, cache, bonds, budget, *step_dt);
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
    bodies.wake_disturbed(&settings.config.sleep, settings.gravity.0);
    let is_worth_help = narrow_phase::is_worth_help(broadphase.pairs().len());
    report.cache = Team::lead_if(is_worth_help, |team| {
        loop {
            narrow.collide(bodies, broadphase, ahead, manifolds, team);
            // What was woken has pairs of its own, and may touch others that sleep.
            if !bodies.wake_touched(manifolds.heads()) {
                break;
            }
        }
        bodies.end_wake();
        bodies.resume_woken(cache);
        if !settings.config.warm_start {
            return CacheStats::default();
        }
        let Bodies {
            ids,
            rotation,
            kd_box,
            ..
        } = &*bodies;
        cache.warm_start_by(team, manifolds, ids, rotation, kd_box, settings.step_dt)
    });
    report.manifolds = manifolds.len();
    report.contacts = manifolds.points().len();
}

/// The end of phase 4: manifolds of bonded pairs hold.
pub fn attach_bonds(bodies: &Bodies, contacts: &mut Contacts, bonds: &mut Bonds) {
    let Contacts {
        solver, manifolds, ..
    } = contacts;
    bonds.begin_step();
    bonds.attach(bodies, manifolds, &mut solver.bonded);
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
    contacts.solve_round(bodies, fractures, settings, 0);
    contacts.energy_before = energy_before;
    if !contacts.is_broken {
        report_solution(bodies, contacts, settings, report);
    }
}

/// The end of phase 6: bonds that were loaded beyond their strength break.
pub fn break_bonds(bodies: &mut Bodies, contacts: &Contacts, bonds: &mut Bonds) {
    bonds.break_overloaded(bodies, &contacts.solver.bonded);
}

fn report_solution(
    bodies: &Bodies,
    contacts: &mut Contacts,
    settings: &StepSettings,
    report: &mut StepReport,
) {
    report_islands(contacts, &settings.config, report);
    let before = contacts.energy_before;
    report.error = before.map(|before| measure_error(bodies, contacts, settings, before));
}

/// Phase 6: bodies that were hit with more than they bear become pieces, and the islands in which that happened are solved
/// anew, until nothing breaks any more.
pub fn fracture(
    bodies: &mut Bodies,
    contacts: &mut Contacts,
    cache: &mut ContactCache,
    fractures: &mut Fractures,
    bonds: &mut Bonds,
    settings: &StepSettings,
    report: &mut StepReport,
) {
    let was_broken = contacts.is_broken;
    let mut round = 0;
    while contacts.is_broken {
        round += 1;
        break_bonds(bodies, contacts, bonds);
        let Contacts {
            manifolds, solver, ..
        } = contacts;
        break_overloaded(
            fractures,
            bodies,
            manifolds,
            cache,
            bonds,
            &settings.budget,
            solver,
        );
        contacts.stash_solved();
        broadphase(bodies, contacts, settings, report);
        generate_contacts(bodies, contacts, cache, settings, report);
        contacts.merge_solved(bodies);
        bonds.attach(bodies, &mut contacts.manifolds, &mut contacts.solver.bonded);
        contacts.solve_round(bodies, fractures, settings, round);
    }
    if was_broken {
        report_solution(bodies, contacts, settings, report);
    }
    note_loads(fractures, bodies, &contacts.manifolds, &contacts.solver);
}

/// Phase 7: poses from velocities. A body that would stop being finite is stopped where it is, and reported.
pub fn integrate(bodies: &mut Bodies, report: &mut StepReport) {
    integrate::integrate_positions(bodies, &mut report.problems);
}

/// Phase 8: the cache takes the new impulses and ages the rest.
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

/// Phase 9: islands at rest fall asleep. Their multipliers are kept for when they wake.
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

fn report_islands(contacts: &mut Contacts, config: &SolverConfig, report: &mut StepReport) {
    let Contacts { solver, rows, .. } = contacts;
    report.islands.clear();
    report.unconverged.clear();
    for island in solver.islands() {
        let movable = island.bodies.iter().position(|b| b.inverse_mass > 0.0);
        let slot = island.slots[movable.unwrap_or(0)];
        if island.budget.is_unconverged {
            report.unconverged.push(slot);
        }
        if config.measure_islands {
            let residual = config
                .measure_error
                .then(|| island.residual_sum(rows).residual());
            report.islands.push(IslandReport {
                slot,
                bodies: island.bodies.len(),
                contacts: island.contacts,
                sweeps: island.budget.sweeps,
                is_unconverged: island.budget.is_unconverged,
                residual,
            });
        }
    }
}

fn measure_error(
    bodies: &Bodies,
    contacts: &mut Contacts,
    settings: &StepSettings,
    energy_before: f64,
) -> StepError {
    let Contacts {
        solver,
        rows,
        manifolds,
        ..
    } = contacts;
    let mut sum = ResidualSum::default();
    for island in solver.islands() {
        sum.add(&island.residual_sum(rows));
    }
    let [kinetic_energy, potential_energy] = bodies.energy(settings.gravity.0, true);
    let points = manifolds.points().iter();
    StepError {
        residual: sum.residual(),
        penetration: points.map(|p| -p.separation).fold(0.0, f32::max),
        kinetic_energy,
        potential_energy,
        energy_change: kinetic_energy + potential_energy - energy_before,
    }
}
