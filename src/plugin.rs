//! The plugin: the phases of [`step`] as system sets, in the same order and under the same names.

mod breaking;
mod rewind;
mod walker;

pub use rewind::RewindPlugin;
pub use walker::WalkerPlugin;

use crate::bodies::store::Bodies;
use crate::contact::impulses::ContactCache;
use crate::ecs::collisions::{CollisionEnd, CollisionStart, ContactForce};
use crate::ecs::components::*;
use crate::ecs::forces::{self, ForceQuery};
use crate::ecs::pieces::PieceRules;
use crate::ecs::state::PluginState;
use crate::ecs::walker as walkers;
use crate::ecs::{bond_constructor, gather, joint, options, parts, pieces, query, scatter, setup};
use crate::fracture::{Bonds, FractureBudget, Fractures};
use crate::joints::{Joint, JointLoad, Joints};
use crate::mass::MassProperties;
use crate::query::QueryIndex;
use crate::solver::config::{Gravity, SolverConfig};
use crate::step;
use crate::step::{Contacts, StepReport, StepSettings};
use bevy_app::{App, FixedMainScheduleOrder, FixedPostUpdate, Plugin, Startup};
use bevy_ecs::intern::Interned;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{ScheduleLabel, SingleThreadedExecutor};
use bevy_ecs::system::{SystemChangeTick, SystemParam};
use bevy_time::Time;

/// The schedule of one physics step. Run by the plugin; its time step is `Time`'s current delta.
///
/// Systems of your own go between its [phases](PhysicsSystems), and run conditions on them.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub struct PhysicsSchedule;

/// The phases of a step, in order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PhysicsSystems {
    /// Entities and what changed about them become bodies; mass, center and inertia of changed shapes. [`Gravity`],
    /// [`SolverConfig`], [`FractureBudget`] and the clock are read here: changed later, they act from the next step on.
    MassProperties,
    /// Bodies that are to be cut become pieces.
    Cut,
    /// Pairs of bodies that may touch.
    Broadphase,
    /// Where pairs touch, and which of them are bonded; multipliers from the cache.
    ContactGeneration,
    /// Forces and contact impulses; bonds that they overload break.
    Solve,
    /// Bodies that were hit with more than they bear become pieces, and their islands are solved anew.
    Fracture,
    /// Islands of what is small for the step take several steps of their own.
    LocalSteps,
    /// Poses from velocities.
    Integrate,
    /// The contact cache takes the new multipliers and ages the rest.
    CacheAging,
    /// Islands at rest fall asleep, if [`SleepConfig`](crate::solver::config::SleepConfig) says so.
    Sleep,
    /// Pieces become entities, and poses and velocities are written to all.
    Writeback,
}

/// Rigid-body physics with slicing and fracture.
///
/// Runs [`PhysicsSchedule`] in each fixed time step between `FixedUpdate` and `FixedPostUpdate`, unless told otherwise:
/// systems of the former can push bodies, those of the latter see where they went. Needs `TimePlugin` (part of Bevy's
/// default and minimal plugins), or a `Time` resource that you advance yourself.
#[derive(Clone, Copy, Debug, Default)]
pub struct CleavePlugin {
    /// The schedule to run in; else the physics has its own place among those of a fixed time step.
    schedule: Option<Interned<dyn ScheduleLabel>>,
}

impl CleavePlugin {
    /// Runs the physics in a system of `schedule`.
    pub fn new(schedule: impl ScheduleLabel) -> Self {
        Self {
            schedule: Some(schedule.intern()),
        }
    }
}

impl Plugin for CleavePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Bodies>()
            .init_resource::<Contacts>()
            .init_resource::<ContactCache>()
            .init_resource::<Fractures>()
            .init_resource::<Bonds>()
            .init_resource::<Joints>()
            .init_resource::<Gravity>()
            .init_resource::<SolverConfig>()
            .init_resource::<FractureBudget>()
            .init_resource::<StepReport>()
            .init_resource::<PluginState>()
            .init_resource::<PieceRules>()
            .add_message::<Fractured>()
            .add_message::<BondBroken>()
            .add_message::<joint::JointBroken>()
            .add_message::<BodyWarning>()
            .add_message::<DebrisRemoved>()
            .add_message::<CollisionStart>()
            .add_message::<CollisionEnd>()
            .add_message::<ContactForce>()
            .add_observer(options::on_option_inserted)
            .add_observer(options::on_option_removed)
            .add_observer(gather::on_body_inserted)
            .add_observer(gather::on_body_removed)
            .add_observer(pieces::on_last_piece_gone)
            .add_observer(walkers::on_walker_added)
            .add_observer(walkers::on_walker_removed)
            .add_observer(gather::on_disabled)
            .add_observer(gather::on_enabled)
            .add_observer(gather::on_lone_part_added)
            .add_observer(gather::on_lone_part_removed)
            .add_observer(gather::on_part_removed)
            .add_observer(gather::on_shape_awaited)
            .add_observer(gather::on_sleeping_inserted)
            .add_observer(gather::on_sleeping_removed)
            .add_observer(joint::on_joint_inserted)
            .add_observer(joint::on_joint_removed)
            .add_observer(joint::on_disabled)
            .add_observer(joint::on_enabled);
        setup::require_components(app);
        bond_constructor::adopt_bonds(app.world_mut());
        app.register_required_components::<Joint, joint::JointHandle>()
            .register_required_components::<Joint, JointLoad>();
        app.add_systems(Startup, setup::name_what_is_missing);
        #[cfg(feature = "reflect")]
        crate::ecs::reflect::register_types(app);
        app.init_schedule(PhysicsSchedule)
            .edit_schedule(PhysicsSchedule, add_phases);
        match self.schedule {
            Some(schedule) => {
                app.add_systems(schedule, |world: &mut World| {
                    world.run_schedule(PhysicsSchedule);
                });
            }
            None => run_in_fixed_time_steps(app),
        }
    }
}

/// Gives the physics its place among the schedules of a fixed time step. As a system of one of them it would wait for that
/// schedule's executor to hand it out, which takes longer than to step a few bodies.
fn run_in_fixed_time_steps(app: &mut App) {
    app.init_resource::<FixedMainScheduleOrder>();
    let labels = &mut app
        .world_mut()
        .resource_mut::<FixedMainScheduleOrder>()
        .labels;
    let next = FixedPostUpdate.intern();
    let place = labels.iter().position(|&label| label == next);
    labels.insert(place.unwrap_or(labels.len()), PhysicsSchedule.intern());
}

fn add_phases(schedule: &mut Schedule) {
    use PhysicsSystems as Phase;
    // The phases follow each other anyway; those with much to do ask the task pool for help themselves. Handing each to another
    // thread would cost more than a scene of a few bodies does.
    schedule.set_executor(SingleThreadedExecutor::new());
    schedule.configure_sets(
        (
            Phase::MassProperties,
            Phase::Cut,
            Phase::Broadphase,
            Phase::ContactGeneration,
            Phase::Solve,
            Phase::Fracture,
            Phase::LocalSteps,
            Phase::Integrate,
            Phase::CacheAging,
            Phase::Sleep,
            Phase::Writeback,
        )
            .chain()
            .run_if(can_step),
    );
    schedule.add_systems((
        (
            parts::make_compounds.run_if(parts::any),
            gather::register_bodies.run_if(gather::any_body_comes_or_goes),
            mass_properties,
            bond_constructor::make_described_bonds.run_if(bond_constructor::any_bond_is_described),
            joint::read_joints.run_if(joint::any_joint),
        )
            .chain()
            .in_set(Phase::MassProperties),
        breaking::cut.in_set(Phase::Cut),
        broadphase.in_set(Phase::Broadphase),
        generate_contacts.in_set(Phase::ContactGeneration),
        solve.in_set(Phase::Solve),
        breaking::fracture.in_set(Phase::Fracture),
        breaking::local_steps
            .run_if(breaking::any_island_waits)
            .in_set(Phase::LocalSteps),
        integrate.in_set(Phase::Integrate),
        age_cache.in_set(Phase::CacheAging),
        sleep.in_set(Phase::Sleep),
        (
            scatter::renew_entities.run_if(scatter::any_entity_is_outdated),
            scatter::write_entities,
            joint::write_joints.run_if(joint::any_joint),
            query::refresh_index.run_if(resource_exists::<QueryIndex>),
        )
            .chain()
            .in_set(Phase::Writeback),
    ));
}

/// What the settings of a step are made from, at its start.
#[derive(SystemParam)]
struct Settings<'w> {
    gravity: Res<'w, Gravity>,
    config: Res<'w, SolverConfig>,
    budget: Res<'w, FractureBudget>,
    time: Option<Res<'w, Time>>,
}

impl Settings<'_> {
    fn get(&self) -> StepSettings {
        StepSettings {
            gravity: *self.gravity,
            config: *self.config,
            budget: *self.budget,
            step_dt: self.time.as_ref().map_or(0.0, |time| time.delta_secs()),
            ..StepSettings::default()
        }
    }
}

/// Run condition of all phases. Warns once when gravity or configuration, and not a standing clock, stops the physics.
fn can_step(settings: Settings, mut has_warned: Local<bool>) -> bool {
    let settings = settings.get();
    let is_broken = !settings.are_numbers_usable();
    if is_broken && !*has_warned {
        log::warn!(
            "no physics step is made: Gravity or SolverConfig has unusable numbers: {settings:?}"
        );
    }
    *has_warned = is_broken;
    !is_broken && settings.has_length()
}

/// Reads entities too, now that they have bodies: with one body, systems and the resources that they take are most of what the
/// plugin adds to a step.
fn mass_properties(
    (mut state, mut bodies): (ResMut<PluginState>, ResMut<Bodies>),
    mut report: ResMut<StepReport>,
    (mut bonds, mut warnings): (ResMut<Bonds>, ResMut<Messages<BodyWarning>>),
    mut queries: ParamSet<(gather::Readings, ForceQuery)>,
    mut masses: Query<&mut MassProperties>,
    (settings, tick): (Settings, SystemChangeTick),
) {
    state.settings = settings.get();
    state.entities.read = tick.this_run();
    let readings = queries.p0();
    gather::read_entities(
        &mut state,
        &mut bodies,
        &mut bonds,
        &mut warnings,
        &readings,
    );
    let has_forces = readings.has_forces() || !state.queue.pushed.is_empty();
    step::mass_properties(&mut bodies, &mut report);
    if has_forces {
        let waiting = &mut state.queue.pushed;
        forces::apply_forces(&mut bodies, &mut warnings, &mut queries.p1(), waiting);
    }
    gather::publish_mass(&bodies, &state.entities, &mut masses);
}

fn broadphase(
    bodies: Res<Bodies>,
    mut contacts: ResMut<Contacts>,
    mut state: ResMut<PluginState>,
    mut report: ResMut<StepReport>,
) {
    if !state.options.watches.is_empty() {
        state.is_watching = true;
        options::set_watches(&mut state.options, &bodies, contacts.events_mut());
    }
    step::broadphase(&bodies, &mut contacts, &state.settings, &mut report);
}

fn generate_contacts(
    mut bodies: ResMut<Bodies>,
    mut contacts: ResMut<Contacts>,
    mut cache: ResMut<ContactCache>,
    (mut bonds, joints): (ResMut<Bonds>, Res<Joints>),
    state: Res<PluginState>,
    mut report: ResMut<StepReport>,
) {
    step::generate_contacts(
        &mut bodies,
        &mut contacts,
        &mut cache,
        &state.settings,
        &mut report,
    );
    step::attach_bonds(&bodies, &mut contacts, &mut bonds);
    step::attach_joints(&bodies, &mut contacts, &joints);
}

fn solve(
    mut bodies: ResMut<Bodies>,
    mut contacts: ResMut<Contacts>,
    fractures: Res<Fractures>,
    state: Res<PluginState>,
    mut report: ResMut<StepReport>,
) {
    step::solve(
        &mut bodies,
        &mut contacts,
        &fractures,
        &state.settings,
        &mut report,
    );
}

fn integrate(
    mut bodies: ResMut<Bodies>,
    mut contacts: ResMut<Contacts>,
    mut report: ResMut<StepReport>,
) {
    step::integrate(&mut bodies, &mut contacts, &mut report);
}

fn age_cache(
    bodies: Res<Bodies>,
    contacts: Res<Contacts>,
    mut cache: ResMut<ContactCache>,
    state: Res<PluginState>,
) {
    step::age_cache(&bodies, &contacts, &mut cache, &state.settings);
}

fn sleep(
    mut bodies: ResMut<Bodies>,
    contacts: Res<Contacts>,
    mut cache: ResMut<ContactCache>,
    state: Res<PluginState>,
    mut report: ResMut<StepReport>,
) {
    step::sleep(
        &mut bodies,
        &contacts,
        &mut cache,
        &state.settings,
        &mut report,
    );
}
