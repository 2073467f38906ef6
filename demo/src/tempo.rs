//! Slow motion and pause, of the physics only: pointer and panel go on at their own pace.

use bevy::prelude::*;

/// How fast slow motion is.
const SLOW: f32 = 0.12;

/// What the clock does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Resource)]
pub(crate) struct Tempo {
    pub(crate) slow: bool,
    pub(crate) paused: bool,
}

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<Tempo>().add_systems(Update, set_clock);
}

fn set_clock(tempo: Res<Tempo>, mut time: ResMut<Time<Virtual>>) {
    if !tempo.is_changed() {
        return;
    }
    time.set_relative_speed(if tempo.slow { SLOW } else { 1.0 });
    if tempo.paused {
        time.pause();
    } else {
        time.unpause();
    }
}
