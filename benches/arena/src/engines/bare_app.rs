//! The app around a physics plugin without one: what an update costs before any physics. No engine, and no point of any curve.

use super::cleave::pool_threads;
use super::headless;
use crate::engine::{Engine, Entry, Setting, Settings, State};
use crate::scene::Scene;
use crate::table::BARE_APP;
use bevy_app::App;

struct BareApp {
    app: App,
    bodies: usize,
}

pub(crate) fn entry() -> Entry {
    let setting = Setting {
        name: "default".into(),
        value: 0,
        max_bodies: usize::MAX,
    };
    Entry {
        name: BARE_APP,
        knob: "none",
        default: setting.name.clone(),
        settings: vec![setting],
        build,
        is_for_joints: false,
    }
}

fn build(scene: &Scene, settings: &Settings) -> Box<dyn Engine> {
    let mut app = headless::app(scene.dt, pool_threads(settings.threads));
    headless::start(&mut app);
    let bodies = scene.bodies.len();
    Box::new(BareApp { app, bodies })
}

impl Engine for BareApp {
    fn step(&mut self) {
        self.app.update();
    }

    /// States that are not finite, which nobody takes for a result.
    fn read(&self, out: &mut Vec<State>) {
        let nowhere = State {
            pos: glam::Vec3::NAN,
            ..State::default()
        };
        out.extend(std::iter::repeat_n(nowhere, self.bodies));
    }
}
