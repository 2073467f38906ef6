//! What an adapter is: an engine is a world that is built from a [`Scene`], stepped, and read.

use crate::scene::Scene;
use glam::{Quat, Vec3};

/// All that the arena varies. Everything else stays as the engine ships it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Settings {
    /// What [`Setting::value`] of the chosen setting is.
    pub(crate) value: u32,
    /// Threads that may work at once, the calling one included.
    pub(crate) threads: usize,
    /// Whether bodies at rest may be left out of the step.
    #[allow(
        dead_code,
        reason = "not read without the features of the other engines"
    )]
    pub(crate) sleeping: bool,
}

/// State of one body at the end of a step. Its origin is its center of mass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct State {
    pub(crate) pos: Vec3,
    pub(crate) rot: Quat,
    pub(crate) linvel: Vec3,
    pub(crate) angvel: Vec3,
}

/// A world in some engine.
pub(crate) trait Engine {
    /// Advances by `scene.dt`. This call is timed, and nothing else.
    fn step(&mut self);

    /// Appends the state of each body of the scene, in its order, fixed ones included.
    fn read(&self, out: &mut Vec<State>);

    /// Dynamic bodies that do not sleep, where the engine tells.
    fn num_awake(&self) -> Option<usize> {
        None
    }

    /// Contact points of the last step, where the engine tells.
    fn num_contacts(&self) -> Option<usize> {
        None
    }
}

/// One way to run an engine: a point of its curve of speed against error.
#[derive(Clone, Debug)]
pub(crate) struct Setting {
    /// Without spaces and commas; what tables and command lines call it.
    pub(crate) name: String,
    /// What the adapter is told: a number of sub-steps, say, or an index into its own list.
    pub(crate) value: u32,
    /// Scenes with more dynamic bodies are not run with it.
    pub(crate) max_bodies: usize,
}

/// One line of the table of engines.
pub(crate) struct Entry {
    pub(crate) name: &'static str,
    /// What a setting chooses.
    pub(crate) knob: &'static str,
    pub(crate) settings: Vec<Setting>,
    /// Name of the setting that the engine ships with.
    pub(crate) default: String,
    pub(crate) build: fn(&Scene, &Settings) -> Box<dyn Engine>,
    /// Whether it differs from another entry in joints alone, and is not run where there are none.
    pub(crate) is_for_joints: bool,
}

impl Entry {
    /// An engine whose settings are numbers.
    #[cfg(any(
        feature = "rapier",
        feature = "avian",
        feature = "box3d",
        feature = "jolt"
    ))]
    pub(crate) fn numbered(
        name: &'static str,
        knob: &'static str,
        default: u32,
        values: &[u32],
        build: fn(&Scene, &Settings) -> Box<dyn Engine>,
    ) -> Self {
        let setting = |&value: &u32| Setting {
            name: value.to_string(),
            value,
            max_bodies: usize::MAX,
        };
        Self {
            name,
            knob,
            settings: values.iter().map(setting).collect(),
            default: default.to_string(),
            build,
            is_for_joints: false,
        }
    }

    /// The same, run on scenes with joints only.
    #[cfg(any(feature = "rapier", feature = "box3d", feature = "jolt"))]
    pub(crate) fn for_joints(self) -> Self {
        Self {
            is_for_joints: true,
            ..self
        }
    }
}

/// All adapters in this binary, ours first.
pub(crate) fn registry() -> Vec<Entry> {
    let ours = [
        crate::engines::cleave::entry(),
        crate::engines::cleave_plugin::entry(),
        crate::engines::bare_app::entry(),
    ];
    #[allow(
        unused_mut,
        reason = "nothing is added without the features of the other engines"
    )]
    let mut all = Vec::from(ours);
    #[cfg(feature = "rapier")]
    all.extend(crate::engines::rapier::entries());
    #[cfg(feature = "avian")]
    all.push(crate::engines::avian::entry());
    #[cfg(feature = "box3d")]
    all.extend(crate::engines::box3d::entries());
    #[cfg(feature = "jolt")]
    all.extend(crate::engines::jolt::entries());
    all
}
