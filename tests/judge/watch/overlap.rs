//! No overlap stays, and none gets deep.
//!
//! A contact under a load may sag by 1.25e-4 of the smaller body's least extent (`SolverConfig::sag`), and a blow may press
//! bodies together for a moment. What is 2 % deep at two looks in a row was not pushed out; a quarter is a body inside of
//! another.

use crate::judge::laws::{Breach, Law};
use crate::judge::run::Run;

/// Shares of the smaller least extent.
const STAYS: f64 = 0.02;
const DEEP: f64 = 0.25;

/// How often the scene is looked at, and the least number of steps in between: what a blow pressed together has these to come
/// apart.
const LOOKS: u32 = 24;
const MIN_STRIDE: u32 = 8;

pub(super) struct Overlap {
    /// Steps between two looks.
    stride: u32,
    /// Least extent of each actor, m; infinite for what has none.
    min_extents: Vec<f64>,
    /// Pairs that overlapped at the last look.
    before: Vec<(usize, usize)>,
    worst: Option<Breach>,
}

impl Overlap {
    pub(super) fn new(run: &Run<'_>) -> Self {
        let min_extents = run.slots.iter().map(|&slot| match run.size(slot) {
            (0.0, _) => f64::INFINITY,
            (min_extent, _) => min_extent,
        });
        Self {
            stride: (run.scene.steps / LOOKS).max(MIN_STRIDE),
            min_extents: min_extents.collect(),
            before: Vec::new(),
            worst: None,
        }
    }

    pub(super) fn look(&mut self, run: &Run<'_>, step: u32) {
        if step.is_multiple_of(self.stride) {
            self.measure(run, step);
        }
    }

    fn measure(&mut self, run: &Run<'_>, step: u32) {
        let solids = run.solids();
        let before = std::mem::take(&mut self.before);
        let actors = &run.scene.actors;
        for i in 0..actors.len() {
            for j in 0..i {
                if !actors[i].is_dynamic() && !actors[j].is_dynamic() {
                    continue;
                }
                let min_extent = self.min_extents[i].min(self.min_extents[j]);
                let depth = -run.gap(&solids, i, j, -STAYS * min_extent) / min_extent;
                if depth <= STAYS {
                    continue;
                }
                self.before.push((i, j));
                let stayed = before.contains(&(i, j));
                if stayed || depth > DEEP {
                    self.note(depth, [i, j], step);
                }
            }
        }
    }

    fn note(&mut self, depth: f64, [i, j]: [usize; 2], step: u32) {
        let excess = depth / STAYS;
        if self.worst.as_ref().is_none_or(|w| w.excess < excess) {
            self.worst = Some(Breach {
                law: Law::Overlap,
                excess,
                what: format!(
                    "bodies {j} and {i} overlap by {depth:.2} of the smaller in step {step}"
                ),
            });
        }
    }

    /// Looks once more.
    pub(super) fn breach(mut self, run: &Run<'_>) -> Option<Breach> {
        self.measure(run, run.scene.steps);
        self.worst
    }
}
