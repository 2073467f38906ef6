//! Diagnostics of steps.

use crate::app;
use bevy_cleave::prelude::*;
use bevy_diagnostic::{DiagnosticPath, DiagnosticsPlugin, DiagnosticsStore};
use bevy_math::Vec3;
use bevy_transform::components::Transform;

#[test]
fn each_step_is_told_by_phase() {
    let mut app = app();
    app.add_plugins((DiagnosticsPlugin, CleaveDiagnosticsPlugin))
        .insert_resource(SolverConfig {
            measure_error: true,
            ..SolverConfig::default()
        });
    app.finish();
    app.cleanup();
    let floor = HalfSpaceShape { normal: Vec3::Y };
    app.world_mut().spawn((RigidBody::Static, floor));
    for i in 0..5 {
        let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a box");
        let at = Transform::from_xyz(0.0, 0.5 + i as f32, 0.0);
        app.world_mut().spawn((RigidBody::Dynamic, cube, at));
    }
    (0..11).for_each(|_| app.update());
    let store = app.world().resource::<DiagnosticsStore>();
    let value = |path: &DiagnosticPath| store.get(path).and_then(|known| known.value());
    let whole = value(&CleaveDiagnosticsPlugin::STEP_TIME).expect("steps were made");
    let phases = CleaveDiagnosticsPlugin::PHASE_TIMES.map(|path| value(&path));
    let sum: f64 = phases
        .map(|phase| phase.expect("each phase is told"))
        .iter()
        .sum();
    assert!(
        (sum - whole).abs() < 1e-9 + 1e-6 * whole,
        "{sum} of {whole} ms"
    );
    assert_eq!(value(&CleaveDiagnosticsPlugin::BODIES), Some(6.0));
    assert_eq!(value(&CleaveDiagnosticsPlugin::AWAKE), Some(5.0));
    assert_eq!(value(&CleaveDiagnosticsPlugin::CONTACTS), Some(20.0));
    assert!(value(&CleaveDiagnosticsPlugin::RESIDUAL).is_some());
    let steps = store.get(&CleaveDiagnosticsPlugin::STEP_TIME);
    assert_eq!(steps.expect("known").history_len(), 10, "one for each step");
}
