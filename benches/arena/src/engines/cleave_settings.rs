//! The settings of bevy_cleave that are compared: add cheap and precise ones here.

use crate::engine::Setting;
use bevy_cleave::prelude::*;

/// A configuration with a name.
pub(super) struct Named {
    name: &'static str,
    pub(super) config: SolverConfig,
    /// Scenes with more dynamic bodies are not run with it.
    max_bodies: usize,
}

/// Name of the configuration with nothing changed.
pub(super) const DEFAULT: &str = "default";

/// All of them. Names are without spaces and commas and stay what they are: tables are compared by them.
pub(super) fn all() -> Vec<Named> {
    vec![
        named("soft-1", fixed(1)),
        named("soft-2", fixed(2)),
        named("soft-3", fixed(3)),
        named("soft-4", fixed(4)),
        named("soft-5", fixed(5)),
        named("soft-6", fixed(6)),
        named("soft-7", fixed(7)),
        named("soft-8", fixed(8)),
        named("soft-10", fixed(10)),
        named("soft-12", fixed(12)),
        named("soft-16", fixed(16)),
        named("soft-24", fixed(24)),
        named("soft-32", fixed(32)),
        named(DEFAULT, SolverConfig::default()),
        named("paper", SolverConfig::paper()),
        named("paper-4", paper(4)),
        named("paper-adaptive", adaptive_paper()),
        Named {
            // Its time grows with the cube of the number of contacts.
            max_bodies: 60,
            ..named("exact", SolverConfig::exact())
        },
    ]
}

fn named(name: &'static str, config: SolverConfig) -> Named {
    Named {
        name,
        config,
        max_bodies: usize::MAX,
    }
}

/// Soft steps in a fixed number of sub-steps of one sweep before and one after the bodies move: no adaptive effort, no local steps.
fn fixed(substeps: u32) -> SolverConfig {
    SoftStep {
        min_substeps: substeps,
        max_substeps: substeps,
        max_local_steps: 1,
        tolerance: None,
        ..SoftStep::default()
    }
    .into()
}

/// The paper's method with fewer sweeps.
fn paper(sweeps: u32) -> SolverConfig {
    Pgs {
        sweeps,
        ..Pgs::default()
    }
    .into()
}

/// The paper's method with as many sweeps, of 1 to 16, as each island needs to meet the default tolerance.
fn adaptive_paper() -> SolverConfig {
    Pgs {
        sweeps: 1,
        tolerance: SoftStep::default().tolerance,
        max_sweeps: Pgs::default().sweeps,
        ..Pgs::default()
    }
    .into()
}

/// The list as the arena wants it; a value is an index into [`all`].
pub(super) fn settings() -> Vec<Setting> {
    let setting = |(value, named): (u32, Named)| Setting {
        name: named.name.into(),
        value,
        max_bodies: named.max_bodies,
    };
    (0..).zip(all()).map(setting).collect()
}

/// The same, with sleep or without.
pub(super) fn with_sleep(config: SolverConfig, sleeps: bool) -> SolverConfig {
    SolverConfig {
        sleep: SleepConfig {
            enabled: sleeps,
            ..config.sleep
        },
        ..config
    }
}

/// The configuration that a setting stands for.
pub(super) fn config(value: u32) -> SolverConfig {
    all()[value as usize].config
}
