//! All phases as one system, as long as no other system is among them.
//!
//! With a few bodies most of a step is what the phases cost as systems: each is handed out by the executor and fetches its
//! resources and queries, which nobody can have touched since the phase before. Who has a system of their own in
//! [`PhysicsSchedule`](crate::plugin::PhysicsSchedule), or a run condition on a phase, gets the phases one by one; else they are run here,
//! with the same outcome.

use crate::bodies::store::Bodies;
use crate::contact::impulses::ContactCache;
use crate::ecs::components::*;
use crate::ecs::state::PluginState;
use crate::ecs::{bond, cut, gather, scatter};
use crate::fracture::{Bonds, Fractures};
use crate::mass::MassProperties;
use crate::plugin::{PhysicsSchedule, Settings, check};
use crate::step;
use crate::step::{Contacts, StepReport, StepSettings};
use bevy_ecs::error::{ErrorContext, ErrorHandler};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::graph::DiGraph;
use bevy_ecs::schedule::{
    FixedBitSet, FlattenedDependencies, NodeId, ScheduleBuildError, ScheduleBuildPass,
    ScheduleGraph, SingleThreadedExecutor, SystemExecutor, SystemKey, SystemSchedule, SystemSetKey,
};
use bevy_ecs::system::{
    BoxedSystem, RunSystemError, SystemChangeTick, SystemParam, SystemParamValidationError,
    SystemState,
};
use std::any::TypeId;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Runs the phases at once if they are alone in their schedule.
#[derive(Default)]
pub(super) struct Runner {
    /// What [`Watch`] has found.
    is_exclusive: Arc<AtomicBool>,
    /// Made for the world that it first runs in.
    at_once: Option<AtOnce>,
}

impl Runner {
    /// Has a schedule that holds the phases run them at once, until something is added to it.
    pub(super) fn take_over(schedule: &mut Schedule) -> Self {
        let runner = Self::default();
        schedule.add_build_pass(Watch {
            phases: Contents::of(schedule.graph()),
            is_exclusive: runner.is_exclusive.clone(),
        });
        schedule.set_executor(PhaseExecutor {
            one_by_one: SingleThreadedExecutor::new(),
            runner: runner.another(),
        });
        runner
    }

    fn another(&self) -> Self {
        Self {
            is_exclusive: self.is_exclusive.clone(),
            at_once: None,
        }
    }

    /// A system that runs the phases: not even their schedule is looked for then, which takes as long as a small step.
    pub(super) fn into_system(mut self) -> impl FnMut(&mut World) + Send + Sync + 'static {
        move |world| {
            let schedules = world.get_resource::<Schedules>();
            let schedule = schedules.and_then(|schedules| schedules.get(PhysicsSchedule));
            let is_built = schedule.is_some_and(|schedule| !schedule.is_changed());
            if !(is_built && self.run(world, world.fallback_error_handler())) {
                world.run_schedule(PhysicsSchedule);
            }
        }
    }

    /// Whether a step could be made.
    fn run(&mut self, world: &mut World, error_handler: ErrorHandler) -> bool {
        if !self.is_exclusive.load(Ordering::Relaxed) {
            return false;
        }
        self.at_once.take_if(|known| !known.is_for(world));
        let at_once = self.at_once.get_or_insert_with(|| AtOnce::new(world));
        let outcome = at_once.run(world, error_handler);
        // Where something is missing, the phases say what.
        outcome.is_ok()
    }
}

/// Types of the systems of a schedule, and number of their run conditions and those of sets.
#[derive(Debug, PartialEq, Eq)]
struct Contents {
    systems: Vec<TypeId>,
    conditions: usize,
}

impl Contents {
    fn of(graph: &ScheduleGraph) -> Self {
        let mut systems: Vec<_> = graph
            .systems
            .iter()
            .map(|(_, s, _)| s.system_type())
            .collect();
        systems.sort_unstable();
        let of_systems = graph.systems.iter().map(|(_, _, c)| c.len());
        let of_sets = graph.system_sets.iter().map(|(_, _, c)| c.len());
        Self {
            systems,
            conditions: of_systems.chain(of_sets).sum(),
        }
    }
}

/// Looks, whenever the schedule is built, whether there is more in it than the phases.
#[derive(Debug)]
struct Watch {
    phases: Contents,
    is_exclusive: Arc<AtomicBool>,
}

impl ScheduleBuildPass for Watch {
    type EdgeOptions = ();

    fn add_dependency(&mut self, _: NodeId, _: NodeId, _: Option<&()>) {}

    fn collapse_set(
        &mut self,
        _: SystemSetKey,
        _: &indexmap::IndexSet<SystemKey, bevy_platform::hash::FixedHasher>,
        _: &DiGraph<NodeId>,
    ) -> impl Iterator<Item = (NodeId, NodeId)> {
        std::iter::empty()
    }

    fn build(
        &mut self,
        _: &mut World,
        graph: &mut ScheduleGraph,
        _: FlattenedDependencies<'_>,
    ) -> Result<(), ScheduleBuildError> {
        let is_exclusive = Contents::of(graph) == self.phases;
        self.is_exclusive.store(is_exclusive, Ordering::Relaxed);
        Ok(())
    }
}

/// Runs the phases at once or, if they are not alone, one by one.
struct PhaseExecutor {
    one_by_one: SingleThreadedExecutor,
    runner: Runner,
}

impl SystemExecutor for PhaseExecutor {
    fn init(&mut self, schedule: &SystemSchedule) {
        self.one_by_one.init(schedule);
    }

    fn run(
        &mut self,
        schedule: &mut SystemSchedule,
        world: &mut World,
        skip_systems: Option<&FixedBitSet>,
        error_handler: ErrorHandler,
    ) {
        // A debugger steps through systems, of which it may skip some.
        if skip_systems.is_none() && self.runner.run(world, error_handler) {
            return;
        }
        // The phases follow each other anyway; those with much to do ask the task pool for help themselves. Handing each to
        // another thread would cost more than a scene of a few bodies does.
        self.one_by_one
            .run(schedule, world, skip_systems, error_handler);
    }

    fn set_apply_final_deferred(&mut self, value: bool) {
        self.one_by_one.set_apply_final_deferred(value);
    }
}

/// What is asked before anything is done.
type Start = (
    Settings<'static>,
    Local<'static, bool>,
    Res<'static, PluginState>,
);

/// The phases as one system, and the systems that most steps have no need of.
struct AtOnce {
    start: SystemState<Start>,
    phases: SystemState<Phases<'static, 'static>>,
    register_bodies: BoxedSystem,
    renew_entities: BoxedSystem,
    write_entities: BoxedSystem,
}

impl AtOnce {
    fn new(world: &mut World) -> Self {
        let mut made = Self {
            start: SystemState::new(world),
            phases: SystemState::new(world),
            register_bodies: Box::new(IntoSystem::into_system(gather::register_bodies)),
            renew_entities: Box::new(IntoSystem::into_system(scatter::renew_entities)),
            write_entities: Box::new(IntoSystem::into_system(scatter::write_entities)),
        };
        for system in [
            &mut made.register_bodies,
            &mut made.renew_entities,
            &mut made.write_entities,
        ] {
            system.initialize(world);
        }
        made
    }

    fn is_for(&self, world: &World) -> bool {
        self.start.matches_world(world.id())
    }

    /// Makes a step.
    ///
    /// # Errors
    /// If something is missing in the world; nothing of the step has been made then.
    fn run(
        &mut self,
        world: &mut World,
        error_handler: ErrorHandler,
    ) -> Result<(), SystemParamValidationError> {
        let (settings, mut has_warned, state) = self.start.get_mut(world)?;
        let settings = settings.get();
        if !check(&settings, &mut has_warned) {
            return Ok(());
        }
        if state.queue.is_waiting() {
            run(&mut self.register_bodies, world, error_handler);
        }
        let mut phases = self.phases.get_mut(world)?;
        phases.run(settings);
        if scatter::is_any_outdated(&phases.bodies, &phases.fractures) {
            // What entities get in between is not the plugin's, and is to be read in the next step: so this is not written as
            // at the tick of `phases`.
            run(&mut self.renew_entities, world, error_handler);
            run(&mut self.write_entities, world, error_handler);
        } else {
            phases.write_motion();
        }
        Ok(())
    }
}

fn run(system: &mut BoxedSystem, world: &mut World, error_handler: ErrorHandler) {
    if let Err(RunSystemError::Failed(error)) = system.run((), world) {
        let context = ErrorContext::System {
            name: system.name(),
            last_run: system.get_last_run(),
        };
        error_handler(error, context);
    }
}

/// What entities hold, read and then written.
type Entities = (
    gather::Readings<'static, 'static>,
    Query<'static, 'static, scatter::WrittenMotion, Without<Sleeping>>,
);

/// What all phases work on, each resource fetched once.
#[derive(SystemParam)]
struct Phases<'w, 's> {
    bodies: ResMut<'w, Bodies>,
    contacts: ResMut<'w, Contacts>,
    cache: ResMut<'w, ContactCache>,
    fractures: ResMut<'w, Fractures>,
    bonds: ResMut<'w, Bonds>,
    state: ResMut<'w, PluginState>,
    report: ResMut<'w, StepReport>,
    warnings: ResMut<'w, Messages<BodyWarning>>,
    broken: MessageWriter<'w, BondBroken>,
    masses: Query<'w, 's, &'static mut MassProperties>,
    entities: ParamSet<'w, 's, Entities>,
    tick: SystemChangeTick,
}

impl Phases<'_, '_> {
    /// All phases up to the writeback.
    fn run(&mut self, settings: StepSettings) {
        let Self {
            bodies,
            contacts,
            cache,
            fractures,
            bonds,
            state,
            report,
            warnings,
            ..
        } = self;
        let readings = self.entities.p0();
        gather::read_entities(state, bodies, bonds, warnings, &readings);
        state.settings = settings;
        step::mass_properties(bodies, report);
        gather::publish_mass(bodies, &state.entities, &mut self.masses);
        let requests = &mut state.slice_requests;
        cut::gather_requests(requests, bodies, fractures, warnings, &readings.handles);
        step::advance(bodies, contacts, cache, fractures, bonds, &settings, report);
        bond::report_broken(bonds, &state.entities, &mut self.broken);
    }

    /// The writeback where no entity comes, goes, wakes or falls asleep.
    fn write_motion(mut self) {
        let now = self.tick.this_run();
        let (state, report) = (&mut self.state, &self.report);
        let mut motion = self.entities.p1();
        scatter::write_motion(
            state,
            &self.bodies,
            report,
            &mut self.warnings,
            &mut motion,
            now,
        );
    }
}
