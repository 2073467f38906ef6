//! The settings that are compared, by name.

use bevy_cleave::prelude::*;
use bevy_cleave::testing::batch::SolverOverrides;
use bevy_cleave::testing::graph::ContactOrder;
use bevy_cleave::testing::simd::LaneWidth;
use weigh::Error;

/// What is set before the first step.
pub(crate) struct Setting {
    pub(crate) config: SolverConfig,
    pub(crate) overrides: SolverOverrides,
}

impl Setting {
    /// The setting of a name.
    pub(crate) fn named(name: &str) -> Result<Self, Error> {
        let config = match name {
            "default" | "four" | "one" => SolverConfig::default(),
            "paper" => SolverConfig::paper(),
            "paper-box" => SolverConfig::from(Pgs {
                friction: FrictionModel::Box,
                ..Pgs::default()
            }),
            "exact" => SolverConfig::exact(),
            _ => match name.rsplit_once('-') {
                Some(("fixed" | "ordered" | "colored", substeps)) => fixed(substeps.parse()?),
                _ => return Err(format!("no setting {name}").into()),
            },
        };
        let overrides = SolverOverrides {
            lane_width: match name {
                "four" => LaneWidth::Four,
                "one" => LaneWidth::One,
                _ => LaneWidth::Widest,
            },
            order: match name.split('-').next() {
                Some("ordered") => Some(ContactOrder::Ordered),
                Some("colored") => Some(ContactOrder::Colored),
                _ => None,
            },
        };
        Ok(Self { config, overrides })
    }
}

/// So many sub-steps of one sweep before and one after the bodies move, whatever happens.
fn fixed(substeps: u32) -> SolverConfig {
    SolverConfig::from(SoftStep {
        min_substeps: substeps,
        max_substeps: substeps,
        tolerance: None,
        ..SoftStep::default()
    })
}
