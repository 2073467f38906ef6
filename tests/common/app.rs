//! An app for tests of what entities do.
#![allow(dead_code, reason = "not every program asks for it")]

use bevy_app::{App, TaskPoolPlugin};
use bevy_cleave::prelude::*;
use bevy_time::{TimePlugin, TimeUpdateStrategy};

/// One that makes a step with every update.
pub(crate) fn stepping_app() -> App {
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        TimePlugin,
        CleavePlugin::default(),
    ))
    .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    app
}
