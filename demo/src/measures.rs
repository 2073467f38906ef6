//! What the panel shows: how many pieces there are, how long a step takes and how wrong it is.

use bevy::diagnostic::{DiagnosticPath, DiagnosticsStore};
use bevy::platform::time::Instant;
use bevy::prelude::*;
use bevy_cleave::prelude::*;

/// Share of the newest value in a running mean.
const NEWEST: f32 = 0.1;

/// Of the last steps.
#[derive(Clone, Copy, Debug, Default, Resource)]
pub(crate) struct Measures {
    /// Dynamic bodies.
    pub(crate) pieces: usize,
    pub(crate) asleep: usize,
    pub(crate) contacts: usize,
    /// Running mean, ms.
    pub(crate) step_time: f32,
    /// Running mean, ms.
    pub(crate) frame_time: f32,
    /// Residual of the last step's contact problem, relative.
    pub(crate) residual: f32,
}

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<Measures>()
        .add_systems(Update, (read_diagnostics, measure_frame));
}

fn read_diagnostics(store: Res<DiagnosticsStore>, mut measures: ResMut<Measures>) {
    use CleaveDiagnosticsPlugin as Of;
    let read = |path: DiagnosticPath| store.get(&path).and_then(|known| known.value());
    let read = |path| read(path).unwrap_or_default() as f32;
    measures.asleep = read(Of::ASLEEP) as usize;
    measures.pieces = read(Of::AWAKE) as usize + measures.asleep;
    measures.contacts = read(Of::CONTACTS) as usize;
    measures.residual = read(Of::RESIDUAL);
    let time = store.get(&Of::STEP_TIME).and_then(|known| known.smoothed());
    measures.step_time = time.unwrap_or_default() as f32;
}

/// By a clock of its own: that of Bevy is set by hand without a window. While it stands still a picture is taken, which is no frame.
fn measure_frame(
    time: Res<Time<Real>>,
    mut begun: Local<Option<Instant>>,
    mut measures: ResMut<Measures>,
) {
    let before = begun.take();
    if time.delta().is_zero() {
        return;
    }
    let now = Instant::now();
    *begun = Some(now);
    if let Some(before) = before {
        let frame = 1e3 * (now - before).as_secs_f32();
        measures.frame_time += NEWEST * (frame - measures.frame_time);
    }
}
