//! What is simulated, and what makes sure that it is what the names say.

use crate::builds;
use crate::course::{Events, LARGE_ISLAND};
use crate::heaps::heap;
use crate::sleepers;
use crate::structures::{pyramid, tower};
use bevy_cleave::prelude::*;
use bevy_cleave::testing::graph::ContactOrder;

/// A scene with hashes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scene {
    /// Two heaps apart from each other, of 84 bodies of which every third can break.
    BreakingPile,
    /// A pyramid of 12 rows.
    Pyramid,
    /// A tower of 10 that a fast ball flies into, and bouncing bodies beside it.
    Mixed,
    /// One island that is cut into four leaves: a block of 2000 cubes, at rest at first, then hit by bodies of other shapes.
    Large,
    /// One island that is cut into two leaves, of which bonds and bodies break while it is solved.
    LargeBreaking,
    /// Structures that fall asleep, and are woken in several ways, or cut, or sleep on.
    Sleep,
    /// A wall of bonded bricks, some of which can break, that a ball flies into.
    BondedWall,
    /// A wall that is an island large enough to be rehearsed, of bricks that break by all patterns.
    BrickWall,
    /// A heap that breaks, by the paper's method, with its errors measured.
    Paper,
    /// Structures that rest and slide, by the paper's method and friction.
    PaperSquare,
    /// A tower and bodies that slide and bounce, by the exact method.
    Exact,
    /// A tower, which is narrow, in each order of contacts.
    TowerKept,
    /// See [`TowerKept`](Self::TowerKept).
    TowerColored,
    /// See [`TowerKept`](Self::TowerKept).
    TowerAutomatic,
    /// A heap, which is wide, by colors all the same.
    HeapColored,
    /// A heap in the order of its contacts, whatever that fills.
    HeapKept,
    /// A heap, a slide and a pyramid with independent friction bounds.
    /// A pyramid and a heap, every solve of which starts from nothing and stops after the least sweeps.
    ColdStart,
    /// What hits each other: fast, spinning, thin, bouncing, row after row.
    Blows,
    /// Bodies of all shapes that tumble through the air and touch nothing.
    Spinning,
    /// Bodies on what moves by itself.
    Carried,
}

impl Scene {
    /// All of them.
    pub(crate) const ALL: [Self; 20] = [
        Self::BreakingPile,
        Self::Pyramid,
        Self::Mixed,
        Self::Large,
        Self::LargeBreaking,
        Self::Sleep,
        Self::BondedWall,
        Self::BrickWall,
        Self::Paper,
        Self::PaperSquare,
        Self::Exact,
        Self::TowerKept,
        Self::TowerColored,
        Self::TowerAutomatic,
        Self::HeapColored,
        Self::HeapKept,
        Self::ColdStart,
        Self::Blows,
        Self::Spinning,
        Self::Carried,
    ];

    /// Those that only the plain step runs, which are held against their golden hashes on other threads and lanes too.
    pub(crate) fn plain() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().skip(3)
    }

    /// Steps of 1/60 s.
    pub(crate) fn steps(self) -> u32 {
        match self {
            Self::BreakingPile => 1000,
            Self::Pyramid | Self::Mixed => 300,
            Self::Large => 30,
            Self::LargeBreaking => 25,
            Self::Sleep => sleepers::STEPS,
            Self::BondedWall | Self::BrickWall | Self::Spinning => 90,
            Self::Exact => 60,
            _ => 120,
        }
    }

    /// How it is solved, but for the lanes: the default, with less effort where there are many steps to make.
    pub(crate) fn config(self) -> SolverConfig {
        let mut config = SolverConfig::default();
        match self {
            Self::BreakingPile => {
                config.method = SoftStep {
                    max_substeps: 8,
                    max_extra_updates: 1000,
                    ..SoftStep::default()
                }
                .into();
            }
            Self::Sleep => return config,
            Self::Paper => {
                config = SolverConfig::paper();
                config.measure_error = true;
            }
            Self::PaperSquare => {
                config.method = Pgs {
                    friction: FrictionModel::Box,
                    ..Pgs::default()
                }
                .into();
            }
            Self::Exact => config = SolverConfig::exact(),
            Self::ColdStart => {
                config.warm_start = false;
                config.method = SoftStep {
                    tolerance: None,
                    ..SoftStep::default()
                }
                .into();
            }
            _ => {}
        }
        config.sleep = SleepConfig::off();
        config
    }

    /// In which order contacts are solved, if not in that of the method.
    pub(crate) fn order(self) -> Option<ContactOrder> {
        match self {
            Self::TowerKept | Self::HeapKept => Some(ContactOrder::Ordered),
            Self::TowerColored | Self::HeapColored => Some(ContactOrder::Colored),
            _ => None,
        }
    }

    /// What fracture may cost.
    pub(crate) fn budget(self) -> FractureBudget {
        let mut budget = FractureBudget::default();
        match self {
            Self::Sleep => budget.debris.max_sleep = 0.5,
            // What may break at once must not have to wait, or nothing is rehearsed.
            Self::LargeBreaking | Self::BrickWall => {
                (budget.growth, budget.pieces_per_step) = (f32::INFINITY, 400);
            }
            _ => {}
        }
        budget
    }

    /// The bodies, in the order that decides their ids.
    pub(crate) fn bodies(self) -> Vec<BodyDesc> {
        match self {
            Self::BreakingPile => builds::breaking_pile(),
            Self::Pyramid => pyramid(12),
            Self::Mixed => builds::mixed(),
            Self::Large => builds::large(),
            Self::LargeBreaking => builds::large_breaking(),
            Self::Sleep => sleepers::bodies(),
            Self::BondedWall => builds::bonded_wall(),
            Self::BrickWall => builds::brick_wall(),
            Self::Paper => builds::breaking_heap(),
            Self::PaperSquare => builds::resting_and_sliding(),
            Self::Exact => builds::small(),
            Self::TowerKept | Self::TowerColored | Self::TowerAutomatic => tower(24),
            Self::HeapColored | Self::HeapKept => heap(64),
            Self::ColdStart => builds::resting_and_sliding(),
            Self::Blows => builds::blows(),
            Self::Spinning => builds::spinning(),
            Self::Carried => builds::carried(),
        }
    }

    /// What is done before the first step to bodies that are in `slots`, in their order.
    pub(crate) fn prepare(self, simulation: &mut Simulation, slots: &[u32]) {
        simulation.budget = self.budget();
        match self {
            Self::LargeBreaking => builds::bond_corner(simulation, slots),
            Self::BondedWall => builds::bond_wall(simulation, slots),
            _ => {}
        }
    }

    /// What is done before step number `step`.
    pub(crate) fn act(self, step: u32, simulation: &mut Simulation, slots: &[u32]) {
        if self == Self::Sleep {
            sleepers::act(step, simulation, slots);
        }
    }

    /// Panics if the scene did not go as its name says: a hash of something else would prove nothing.
    pub(crate) fn check(self, events: &Events) {
        let is = |what: &str, holds: bool| assert!(holds, "{self:?}: {what}: {events:?}");
        is("all stay on the floor", events.lowest > 0.0);
        match self {
            Self::BreakingPile => {
                is("several break", events.fractures >= 10);
                is("enough for several threads", events.manifolds > 256);
            }
            Self::Pyramid => is("it stands", events.speed < 0.01),
            Self::Mixed => is("the ball is stopped", events.speed < 50.0),
            Self::Large => {
                is("four leaves", leaves(events.largest_island) == 4);
                is("all the time", events.steps_with_large >= 25);
                is("bodies hit it", events.jolt > 3.0);
            }
            Self::LargeBreaking => {
                is("two leaves", leaves(events.largest_island) == 2);
                is("all the time", events.steps_with_large >= 20);
                is("bodies break in it", events.fractures_in_large >= 5);
                is("others are overloaded by it", events.late_fractures >= 5);
                is("bonds break in it", events.broken_bonds >= 10);
                is("not all of them", events.bonds >= 10);
            }
            Self::Sleep => sleepers::check(events),
            Self::BondedWall => {
                is("bonds break", events.broken_bonds >= 10);
                is("not all of them", events.bonds >= 10);
                is("bricks break", events.fractures_in_small >= 2);
            }
            Self::BrickWall => {
                is("several are rehearsed", events.fractures_in_large >= 5);
                is("others are overloaded later", events.late_fractures >= 4);
                is("not cut into domains", leaves(events.largest_island) == 1);
            }
            Self::Paper => {
                is("several break", events.fractures >= 4);
                is("errors are measured", events.measured > 60);
            }
            Self::PaperSquare | Self::ColdStart => is("many touch", events.manifolds > 60),
            Self::Exact => is("several touch", events.manifolds >= 8),
            Self::TowerKept | Self::TowerColored | Self::TowerAutomatic => {
                is("it is a chain", events.manifolds == 24);
                is("it stands", events.speed < 0.1);
            }
            Self::HeapColored | Self::HeapKept => is("many touch", events.manifolds > 100),
            Self::Blows => {
                is("fast", events.top_speed > 100.0);
                is("hard", events.jolt > 30.0);
            }
            Self::Spinning => {
                is("nothing touches", events.manifolds == 0);
                is("they tumble", events.tumble > 50.0);
            }
            Self::Carried => is("they are carried", events.moving >= 12),
        }
    }
}

/// Leaves of an island.
fn leaves(manifolds: usize) -> usize {
    debug_assert!(bevy_cleave::testing::graph::leaves(LARGE_ISLAND) == 2);
    bevy_cleave::testing::graph::leaves(manifolds)
}
