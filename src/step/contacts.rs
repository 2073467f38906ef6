//! Everything between the bodies and the solver that lives from step to step, and the rounds of a step in which bodies break.

use crate::bodies::store::Bodies;
use crate::collide::narrow_phase::NarrowPhase;
use crate::contact::manifolds::{ManifoldRef, Manifolds};
use crate::contact::pairs::broad_phase::Broadphase;
use crate::fracture::Fractures;
use crate::merge::merge;
use crate::solver::contact_solver::{ContactSolver, Round};
use crate::solver::rows::contact_rows::PointRows;
use crate::solver::settings::SubstepSettings;
use crate::step::companions::Companions;
use crate::step::contact_events::ContactEvents;
use crate::step::guard::hold_before_walls;
use crate::step::local_buffers::LocalBuffers;
use crate::step::settings::StepSettings;
use bevy_ecs::resource::Resource;

/// Everything between the bodies and the solver that lives from step to step.
#[derive(Debug, Default, Resource)]
pub struct Contacts {
    pub(crate) broadphase: Broadphase,
    pub(crate) narrow: NarrowPhase,
    pub(crate) manifolds: Manifolds,
    pub(crate) solver: ContactSolver,
    pub(crate) events: ContactEvents,
    /// Whether a body broke in the last round, and its island waits for the next one.
    pub(crate) is_broken: bool,
    /// Manifolds that are solved while a new round is prepared, sorted by body ids.
    solved: Manifolds,
    /// For putting the two together.
    joined: Manifolds,
    pub(crate) local: LocalBuffers,
    pub(super) companions: Companions,
    /// Who is near the way of a body; a buffer.
    near: Vec<u32>,
    /// Kinetic and potential energy before the step, J, if the error is measured.
    pub(crate) energy_before: Option<f64>,
    /// Rows of an island whose error is measured.
    pub(crate) rows: Vec<PointRows>,
}

/// Rounds of breaking in one step. What breaks only after so many others before it bears the step and may break in the next
/// one.
const MAX_ROUNDS: u32 = 3;

/// What the next step goes on from; buffers, and what is arranged anew in each step, begin empty.
impl Clone for Contacts {
    fn clone(&self) -> Self {
        Self {
            broadphase: self.broadphase.clone(),
            narrow: self.narrow.clone(),
            manifolds: self.manifolds.clone(),
            events: self.events.clone(),
            ..Self::default()
        }
    }
}

impl Contacts {
    /// Solves what is not solved yet.
    pub(crate) fn solve_round(
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

    /// Cuts the ways that have been solved short where they go through what bodies strike.
    pub(super) fn hold_before_walls(&mut self, bodies: &mut Bodies) {
        hold_before_walls(bodies, &self.broadphase, &mut self.near);
    }

    /// Puts off who goes with those that take local steps, unless something breaks: then who is where is not known yet.
    pub(crate) fn put_off_companions(&mut self, bodies: &mut Bodies, settings: &StepSettings) {
        if self.is_broken {
            return;
        }
        let Self {
            companions,
            broadphase,
            solver,
            ..
        } = self;
        companions.put_off(bodies, broadphase, solver, settings);
    }

    /// Whether nothing waits for another round or for local steps.
    pub(crate) fn is_solved(&self) -> bool {
        !self.is_broken && !self.any_island_waits()
    }

    /// Whether islands of this step wait for local steps, or have taken them.
    pub(crate) fn any_island_waits(&self) -> bool {
        !self.solver.put_off.is_empty()
    }

    /// Keeps the manifolds of bodies that have got their motion, whose contacts are not to be looked for again.
    pub(crate) fn stash_solved(&mut self, bodies: &Bodies) {
        self.solved.clear();
        for manifold in self.manifolds.iter() {
            // What rested on a body that stood, and broke, has been solved with it, and meets its pieces in the next step.
            let are_there = bodies.contains(manifold.a) && bodies.contains(manifold.b);
            if !are_there {
                continue;
            }
            if self.solver.is_solved(manifold.a) || self.solver.is_solved(manifold.b) {
                self.solved.push(manifold);
            }
        }
    }

    /// Puts them back in place of what was found anew for the same bodies.
    pub(crate) fn merge_solved(&mut self, bodies: &Bodies) {
        let solver = &self.solver;
        let name = |m: &ManifoldRef| (bodies.id(m.a), bodies.id(m.b));
        let is_new = |m: &ManifoldRef| !solver.is_solved(m.a) && !solver.is_solved(m.b);
        let new = self.manifolds.iter().filter(is_new);
        let solved = self.solved.iter();
        self.joined.clear();
        for manifold in merge(solved, new, |solved, new| name(solved).cmp(&name(new))) {
            let (solved, new) = manifold.into_options();
            (solved.into_iter().chain(new)).for_each(|manifold| self.joined.push(manifold));
        }
        std::mem::swap(&mut self.manifolds, &mut self.joined);
    }

    /// Manifolds of the last step with the impulses that were found, sorted by body ids. Those of bodies that sleep are not
    /// among them.
    pub fn manifolds(&self) -> &Manifolds {
        &self.manifolds
    }

    /// Slots of pairs that touch and of which one sleeps; by body ids.
    pub(crate) fn dormant_pairs(&self, bodies: &Bodies) -> impl Iterator<Item = [u32; 2]> {
        self.narrow.dormant_pairs(self.broadphase.pairs(), bodies)
    }

    /// Slots of pairs of which one is a sensor and has the other in it; by body ids.
    pub(crate) fn sensed_pairs(&self) -> impl Iterator<Item = [u32; 2]> {
        let overlaps = self.events.sensing.overlaps.iter();
        overlaps.map(|overlap| [overlap.pair.a, overlap.pair.b])
    }

    /// News of bodies that touch or come apart.
    pub fn events(&self) -> &ContactEvents {
        &self.events
    }

    /// The same, to say which bodies it is asked for.
    pub fn events_mut(&mut self) -> &mut ContactEvents {
        &mut self.events
    }

    /// Islands and rows of the last step.
    #[doc(hidden)]
    pub fn solver(&self) -> &ContactSolver {
        &self.solver
    }
}
