//! The settings of the solver that are compared.

use bevy_cleave::prelude::*;

/// One way to solve a scene.
#[derive(Clone, Debug)]
pub(crate) struct Setting {
    /// Short: method, sub-steps, sweeps, what is unusual about it.
    pub(crate) name: String,
    pub(crate) config: SolverConfig,
}

/// How much work a scene is: big ones are run with few settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Size {
    /// A step takes about a millisecond or less, whatever the setting.
    Small,
    /// Slow with the exact method.
    Medium,
    /// Thousands of contacts: too slow for the exact method, and for many sweeps.
    Large,
}

/// Name of the setting with nothing changed.
pub(crate) const DEFAULT: &str = "default";
/// Name of the paper's method as [`SolverConfig::paper`] has it.
pub(crate) const PAPER: &str = "paper: pgs 16";
/// Name of the exact method in one step.
pub(crate) const EXACT: &str = "exact 1";

fn setting(name: impl Into<String>, config: SolverConfig) -> Setting {
    Setting {
        name: name.into(),
        config,
    }
}

/// Soft steps: a fixed number of sub-steps with a fixed number of sweeps, not chosen by load or residual.
pub(crate) fn soft(substeps: u32, sweeps: u32) -> SoftStep {
    SoftStep {
        min_substeps: substeps,
        max_substeps: substeps,
        sweeps,
        relax_sweeps: sweeps,
        tolerance: None,
        ..SoftStep::default()
    }
}

/// The same as a whole configuration.
pub(crate) fn fixed(substeps: u32, sweeps: u32) -> SolverConfig {
    soft(substeps, sweeps).into()
}

fn pgs(substeps: u32, sweeps: u32) -> SolverConfig {
    Pgs {
        substeps,
        sweeps,
        ..Pgs::default()
    }
    .into()
}

/// One setting for each method; the exact one where it is fast.
pub(crate) fn quick(size: Size) -> Vec<Setting> {
    let mut list = vec![
        setting(DEFAULT, SolverConfig::default()),
        setting(PAPER, SolverConfig::paper()),
    ];
    if size == Size::Small {
        list.push(setting(EXACT, SolverConfig::exact()));
    }
    list
}

/// All settings for a scene of that size.
pub(crate) fn all(size: Size) -> Vec<Setting> {
    let mut list = quick(size);
    list.extend([4, 8, 16].map(|n| setting(format!("soft {n}x(1+1)"), fixed(n, 1))));
    list.push(setting("pgs 64", pgs(1, 64)));
    if size == Size::Large {
        return list;
    }
    if size == Size::Medium {
        list.push(setting(EXACT, SolverConfig::exact()));
    }
    list.extend([2, 32].map(|n| setting(format!("soft {n}x(1+1)"), fixed(n, 1))));
    list.extend([4, 8].map(|n| setting(format!("soft {n}x(4+4)"), fixed(n, 4))));
    let tolerance = |tolerance| {
        let soft_step = SoftStep {
            tolerance: Some(tolerance),
            ..SoftStep::default()
        };
        soft_step.into()
    };
    list.push(setting("default, tol 1e-2", tolerance(1e-2)));
    list.push(setting("default, tol 1e-4", tolerance(1e-4)));
    let boxed = Pgs {
        friction: FrictionModel::Box,
        ..Pgs::default()
    };
    list.push(setting("pgs 16, box", boxed.into()));
    list.extend([4, 256].map(|k| setting(format!("pgs {k}"), pgs(1, k))));
    list.extend([(4, 4), (16, 1)].map(|(n, k)| setting(format!("pgs {n}x{k}"), pgs(n, k))));
    let exact = |substeps, friction| {
        let exact = Exact {
            substeps,
            friction,
            ..Exact::default()
        };
        exact.into()
    };
    if size == Size::Small {
        list.push(setting("exact 1, box", exact(1, FrictionModel::Box)));
        let disc = |n| setting(format!("exact {n}"), exact(n, FrictionModel::Disc));
        list.extend([2, 4].map(disc));
    }
    list
}
