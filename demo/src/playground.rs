//! All of the playground but where it is shown: a plugin of plugins.

use crate::{ball, debug_view, exhibits, look, measures, panel, studio, swipe, tempo};
use bevy::prelude::*;
use bevy_cleave::prelude::*;

/// Everything that is the same in a window, off-screen and in a browser.
pub(crate) struct PlaygroundPlugin;

impl Plugin for PlaygroundPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((
            CleavePlugin::default(),
            InterpolationPlugin,
            CleaveMeshPlugin,
            CleaveGizmosPlugin,
            CleaveDiagnosticsPlugin,
        ))
        .insert_resource(Time::<Fixed>::from_hz(60.0))
        .insert_resource(SolverConfig {
            measure_error: true,
            ..SolverConfig::default()
        })
        .add_plugins((
            look::plugin,
            studio::plugin,
            exhibits::plugin,
            swipe::plugin,
            ball::plugin,
            tempo::plugin,
            measures::plugin,
            debug_view::plugin,
            panel::plugin,
        ));
    }
}
