//! What a step costs and holds, as diagnostics of Bevy: for its log, its overlay, or a panel of one's own.

use crate::bodies::store::Bodies;
use crate::plugin::{PhysicsSchedule, PhysicsSystems as Phase};
use crate::step::StepReport;
use bevy_app::{App, Plugin};
use bevy_diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, RegisterDiagnostic};
use bevy_ecs::prelude::*;
use bevy_platform::time::Instant;

/// Time of each step and phase (ms), and what is in it, as diagnostics: read them from `DiagnosticsStore`, or add Bevy's
/// `LogDiagnosticsPlugin`. A value is added for every step that is made.
///
/// The residual is there when [`SolverConfig::measure_error`](crate::solver::SolverConfig::measure_error) asks for it.
#[derive(Clone, Copy, Debug, Default)]
pub struct CleaveDiagnosticsPlugin;

impl CleaveDiagnosticsPlugin {
    /// Of a whole step, ms.
    pub const STEP_TIME: DiagnosticPath = DiagnosticPath::const_new("cleave/step");
    /// Of each phase, ms, in the order of [`PhysicsSystems`](crate::plugin::PhysicsSystems).
    pub const PHASE_TIMES: [DiagnosticPath; 11] = [
        DiagnosticPath::const_new("cleave/step/mass_properties"),
        DiagnosticPath::const_new("cleave/step/cut"),
        DiagnosticPath::const_new("cleave/step/broadphase"),
        DiagnosticPath::const_new("cleave/step/contact_generation"),
        DiagnosticPath::const_new("cleave/step/solve"),
        DiagnosticPath::const_new("cleave/step/fracture"),
        DiagnosticPath::const_new("cleave/step/local_steps"),
        DiagnosticPath::const_new("cleave/step/integrate"),
        DiagnosticPath::const_new("cleave/step/cache_aging"),
        DiagnosticPath::const_new("cleave/step/sleep"),
        DiagnosticPath::const_new("cleave/step/writeback"),
    ];
    /// Bodies of any kind.
    pub const BODIES: DiagnosticPath = DiagnosticPath::const_new("cleave/bodies");
    /// Dynamic bodies that were stepped.
    pub const AWAKE: DiagnosticPath = DiagnosticPath::const_new("cleave/awake");
    /// Dynamic bodies that sleep.
    pub const ASLEEP: DiagnosticPath = DiagnosticPath::const_new("cleave/asleep");
    /// Pairs of bodies that may touch.
    pub const PAIRS: DiagnosticPath = DiagnosticPath::const_new("cleave/pairs");
    /// Points of contact.
    pub const CONTACTS: DiagnosticPath = DiagnosticPath::const_new("cleave/contacts");
    /// Of the contact problem, relative.
    pub const RESIDUAL: DiagnosticPath = DiagnosticPath::const_new("cleave/residual");

    fn counts() -> [DiagnosticPath; 6] {
        [
            Self::BODIES,
            Self::AWAKE,
            Self::ASLEEP,
            Self::PAIRS,
            Self::CONTACTS,
            Self::RESIDUAL,
        ]
    }
}

/// The sets between which the clock is read.
const PHASES: [Phase; 11] = [
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
];

/// When the step began, and when each phase ended.
#[derive(Resource)]
struct PhaseClock {
    begun: Instant,
    ended: [Instant; PHASES.len()],
}

impl Plugin for CleaveDiagnosticsPlugin {
    fn build(&self, app: &mut App) {
        for path in Self::PHASE_TIMES.into_iter().chain([Self::STEP_TIME]) {
            app.register_diagnostic(Diagnostic::new(path).with_suffix(" ms"));
        }
        for path in Self::counts() {
            app.register_diagnostic(Diagnostic::new(path));
        }
        let now = Instant::now();
        app.insert_resource(PhaseClock {
            begun: now,
            ended: [now; PHASES.len()],
        });
        let begin = |mut clock: ResMut<PhaseClock>| clock.begun = Instant::now();
        app.add_systems(PhysicsSchedule, begin.before(PHASES[0]));
        for (number, phase) in PHASES.into_iter().enumerate() {
            let end = move |mut clock: ResMut<PhaseClock>| clock.ended[number] = Instant::now();
            let end = end.after(phase);
            match PHASES.get(number + 1) {
                Some(&next) => app.add_systems(PhysicsSchedule, end.before(next)),
                None => app.add_systems(PhysicsSchedule, (end, publish).chain()),
            };
        }
    }
}

/// The report is written by whatever step is made.
fn publish(
    clock: Res<PhaseClock>,
    bodies: Option<Res<Bodies>>,
    report: Option<Res<StepReport>>,
    mut diagnostics: Diagnostics,
) {
    let (Some(bodies), Some(report)) = (bodies, report) else {
        return;
    };
    if !report.is_changed() {
        return;
    }
    let milliseconds = |from: Instant, to: Instant| 1e3 * (to - from).as_secs_f64();
    let mut before = clock.begun;
    for (path, &ended) in CleaveDiagnosticsPlugin::PHASE_TIMES
        .iter()
        .zip(&clock.ended)
    {
        diagnostics.add_measurement(path, || milliseconds(before, ended));
        before = ended;
    }
    let whole = milliseconds(clock.begun, before);
    diagnostics.add_measurement(&CleaveDiagnosticsPlugin::STEP_TIME, || whole);
    let counts = [
        bodies.len(),
        report.awake,
        report.asleep,
        report.pairs,
        report.contacts,
    ];
    let counts = counts.into_iter().map(|count| count as f64);
    let residual = report.error.map(|error| f64::from(error.residual.relative));
    for (path, value) in CleaveDiagnosticsPlugin::counts()
        .iter()
        .zip(counts.chain(residual))
    {
        diagnostics.add_measurement(path, || value);
    }
}
