//! Contacts of a scene in one batch, for what runs over blocks.

use crate::H;
use bevy_cleave::contact::Manifolds;
use bevy_cleave::prelude::*;
use bevy_cleave::testing::batch::{Batch, Group, IslandRequirements, Step, SubstepSettings};
use bevy_cleave::testing::graph::Islands;
use bevy_cleave::testing::simd::LaneWidth;
use bevy_cleave::testing::wide::Pass;

/// A simulation of `bodies` after some steps.
pub(crate) fn settled(bodies: Vec<BodyDesc>, config: SolverConfig, steps: u32) -> Simulation {
    let mut simulation = Simulation {
        config: SolverConfig {
            sleep: SleepConfig::off(),
            ..config
        },
        ..Default::default()
    };
    for desc in bodies {
        simulation.bodies.insert(desc).expect("usable");
    }
    (0..steps).for_each(|_| simulation.step(H));
    simulation
}

/// Four sub-steps, as many for every island, no sweeps beyond those.
pub(crate) fn four_substeps() -> SolverConfig {
    SoftStep {
        min_substeps: 4,
        max_substeps: 4,
        tolerance: None,
        ..SoftStep::default()
    }
    .into()
}

/// What a batch is loaded from.
pub(crate) struct Source {
    simulation: Simulation,
    manifolds: Manifolds,
    islands: Islands,
}

impl Source {
    pub(crate) fn new(simulation: Simulation) -> Self {
        let manifolds = simulation.contacts.manifolds().clone();
        let mut islands = Islands::default();
        islands.find(manifolds.heads(), &simulation.bodies, |_| true, None);
        Self {
            simulation,
            manifolds,
            islands,
        }
    }

    /// Contact points of all islands.
    pub(crate) fn points(&self) -> usize {
        self.islands
            .list
            .iter()
            .map(|island| island.points.len())
            .sum()
    }

    fn settings(&self) -> SubstepSettings {
        SubstepSettings::new(&four_substeps(), self.simulation.gravity.0, H)
    }

    /// Loads all islands into one batch.
    pub(crate) fn load(&self, batch: &mut Batch) {
        let demand = IslandRequirements {
            substeps: 4,
            ..Default::default()
        };
        let all: Vec<u32> = (0..self.islands.list.len() as u32).collect();
        let step = Step {
            islands: &self.islands,
            manifolds: &self.manifolds,
            bodies: &self.simulation.bodies,
            settings: &self.settings(),
            team: None,
            may_break: false,
        };
        batch.load(&step, Group::one(&all), &demand);
    }

    /// A batch that is ready to be swept over.
    pub(crate) fn batch(&self) -> Batch {
        let mut batch = Batch::default();
        self.load(&mut batch);
        let bias = self.settings().bias();
        let is_first = true;
        batch.pass(Pass::UpdateBias { bias, is_first }, None);
        batch.pass(Pass::Warm, None);
        batch
    }
}

/// Does a pass over the contacts of a batch with registers of the given width.
pub(crate) fn pass(batch: &mut Batch, width: LaneWidth, pass: Pass) {
    batch.settings.lane_width = width;
    batch.pass(pass, None);
}
