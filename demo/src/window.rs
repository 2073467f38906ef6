//! The playground in a window, or on the canvas of a web page.

use crate::playground::PlaygroundPlugin;
use bevy::prelude::*;

/// Runs until the window is closed.
pub(crate) fn run() {
    let mut app = App::new();
    app.add_plugins(bevy::DefaultPlugins.set(WindowPlugin {
        primary_window: Some(Window {
            title: "bevy_cleave".into(),
            // On the web: the canvas that the page has, in the size that the page gives it.
            canvas: Some("#playground".into()),
            fit_canvas_to_parent: true,
            resolution: (1280, 720).into(),
            ..default()
        }),
        ..default()
    }));
    app.add_plugins(PlaygroundPlugin);
    #[cfg(target_arch = "wasm32")]
    app.add_plugins(crate::web::plugin);
    app.run();
}
