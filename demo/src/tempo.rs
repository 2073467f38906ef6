//! Slow motion, pause and the way back, of the physics only: pointer and panel go on at their own pace.

use bevy::prelude::*;
use bevy_cleave::prelude::*;

/// How fast slow motion is.
const SLOW: f32 = 0.12;

/// What the clock does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Resource)]
pub(crate) struct Tempo {
    pub(crate) slow: bool,
    pub(crate) paused: bool,
    /// Whether time goes back.
    pub(crate) back: bool,
}

/// Steps that time goes back in a second.
const STEPS_BACK: f32 = 90.0;

/// Steps between two moments that are kept.
const INTERVAL: u64 = 2;

pub(crate) fn plugin(app: &mut App) {
    app.add_plugins(RewindPlugin {
        moments: 300,
        interval: INTERVAL,
    })
    .init_resource::<Tempo>()
    .add_systems(Update, (go_back, set_clock).chain());
}

fn set_clock(tempo: Res<Tempo>, mut time: ResMut<Time<Virtual>>) {
    if !tempo.is_changed() {
        return;
    }
    time.set_relative_speed(if tempo.slow { SLOW } else { 1.0 });
    if tempo.paused || tempo.back {
        time.pause();
    } else {
        time.unpause();
    }
}

/// Goes back until nothing is left to go back to.
fn go_back(
    mut tempo: ResMut<Tempo>,
    time: Res<Time<Real>>,
    history: Res<PhysicsHistory>,
    mut steps: Local<f32>,
    mut commands: Commands,
) {
    if !tempo.back {
        *steps = 0.0;
        return;
    }
    *steps += STEPS_BACK * time.delta_secs();
    let due = *steps as u64 / INTERVAL * INTERVAL;
    if due > 0 {
        *steps -= due as f32;
        commands.rewind(due);
    }
    tempo.back = history.reach() > due;
}
