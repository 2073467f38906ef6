//! What the solver sees: contact points with their impulses, bonds, and which bodies sleep. The crate draws it.

use bevy::prelude::*;
use bevy_cleave::prelude::*;

/// Whether it is drawn.
#[derive(Default, Resource)]
pub(crate) struct DebugView(pub(crate) bool);

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<DebugView>()
        .add_systems(Startup, draw_in_front)
        .add_systems(Update, switch);
}

fn draw_in_front(mut store: ResMut<GizmoConfigStore>) {
    // The trace of a swipe, and all of the physics.
    store.config_mut::<DefaultGizmoConfigGroup>().0.depth_bias = -1.0;
    let (config, _) = store.config_mut::<CleaveGizmos>();
    config.depth_bias = -1.0;
    config.line.width = 1.5;
}

fn switch(view: Res<DebugView>, mut store: ResMut<GizmoConfigStore>) {
    if view.is_changed() {
        store.config_mut::<CleaveGizmos>().0.enabled = view.0;
    }
}
