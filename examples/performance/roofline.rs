//! A sweep of the solver on scenes of different sizes, against the limits of the machine.

use crate::contacts::{Source, four_substeps, pass, settled};
use crate::heaps::heap;
use crate::limits::{LEVELS, Limits, WIDTHS};
use crate::structures::{block, cuboid, floor, pyramid, tower};
use bevy_cleave::prelude::*;
use bevy_cleave::testing::batch::Batch;
use bevy_cleave::testing::bodies::SolverBody;
use bevy_cleave::testing::simd::{Kernel, LaneWidth, Lanes, WIDTH, run};
use bevy_cleave::testing::wide::{Block, Pass, Point};
use glam::Vec3;
use std::cell::Cell;
use std::time::Instant;

/// Parts of `Solve` (`solver/sweep.rs`) and the operations of each in one lane, counted by hand: additions, subtractions and
/// multiplications; and how many of all operations follow one after the other, because each needs the one before. Where all
/// lanes stick: a branch skips what only those that slip need.
pub(crate) const OPERATIONS: [(&str, u32, u32); 7] = [
    ("velocity of B against A at the point", 27, 4),
    ("its parts along normal and tangents", 15, 3),
    ("friction: wish, whether it is in the disc, change", 11, 3),
    ("normal: what friction did to it, wish, change", 12, 5),
    ("impulse from its parts", 15, 2),
    ("angular impulses", 18, 2),
    ("velocities of both bodies", 48, 4),
];

/// Operations of a point in a sweep, one lane.
pub(crate) fn flops() -> f64 {
    f64::from(OPERATIONS.iter().map(|part| part.1).sum::<u32>())
}

/// Cycles of the longest chain through a point: 4 for an addition, multiplication or maximum (Fog, "Instruction tables",
/// 2022: Ice Lake, as Golden Cove does not differ much in these).
pub(crate) fn chain() -> f64 {
    f64::from(4 * OPERATIONS.iter().map(|part| part.2).sum::<u32>())
}

/// Cycles that a slipping lane adds to it: a square root, a division, a choice and a multiplication.
pub(crate) const SLIP: u32 = 12 + 11 + 4 + 4;

/// Lines of a point that a sweep changes: its impulses.
const DIRTY: usize = 128;

/// A scene and its times.
pub(crate) struct Measured {
    pub(crate) name: &'static str,
    /// Contact points, and lanes in which there might be one.
    pub(crate) points: usize,
    pub(crate) lanes: usize,
    /// Bytes that a sweep goes through.
    pub(crate) working_set: usize,
    /// Bytes that it reads and writes for each point, caches of the bodies aside.
    pub(crate) bytes: f64,
    /// ns for each point of a sweep by width: shortest and median of all rounds.
    pub(crate) solve: [[f64; 2]; 3],
    pub(crate) relax: [f64; 2],
    /// Velocities gathered and scattered, nothing else.
    pub(crate) transposes: [f64; 2],
}

/// All that is measured.
pub(crate) struct Roofline {
    pub(crate) limits: Limits,
    pub(crate) scenes: Vec<Measured>,
}

struct Scene {
    name: &'static str,
    points: usize,
    batch: Batch,
    /// Times of each kernel in each round, ns for each point.
    times: [Vec<f64>; 5],
}

pub(crate) fn measure() -> Roofline {
    let before = Limits::measure();
    let mut scenes = scenes();
    // Round by round, so that all see the same other load of the machine.
    for _ in 0..40 {
        scenes.iter_mut().for_each(Scene::round);
    }
    Roofline {
        limits: Limits::measure().or(&before),
        scenes: scenes.into_iter().map(Scene::into_measured).collect(),
    }
}

fn scenes() -> [Scene; 4] {
    [
        Scene::new("512 boxes side by side", boxes(), 10),
        Scene::new("8 towers of 40", towers(), 10),
        Scene::new("pyramid of base 30", pyramid(30), 10),
        Scene::new("pile of 8000", heap(8000), 90),
    ]
}

/// Bodies that touch the floor only: no block has to do with another.
fn boxes() -> Vec<BodyDesc> {
    let shape = cuboid(Vec3::ONE);
    let place = |i: u16| Vec3::new(2.0 * f32::from(i % 32), 0.5, 2.0 * f32::from(i / 32));
    let boxes = (0..512).map(|i| block(&shape, place(i), 0.6));
    std::iter::once(floor(0.6)).chain(boxes).collect()
}

/// Towers side by side: each block has to do with the one before, and all lanes are full.
fn towers() -> Vec<BodyDesc> {
    let tower = tower(40);
    let moved = |k: u8| {
        tower.iter().skip(1).cloned().map(move |mut cube| {
            cube.pose.position.x += 3.0 * f32::from(k);
            cube
        })
    };
    std::iter::once(floor(0.6))
        .chain((0..8).flat_map(moved))
        .collect()
}

impl Scene {
    fn new(name: &'static str, bodies: Vec<BodyDesc>, steps: u32) -> Self {
        let source = Source::new(settled(bodies, four_substeps(), steps));
        Self {
            name,
            points: source.points(),
            batch: source.batch(),
            times: Default::default(),
        }
    }

    /// Times each kernel once.
    fn round(&mut self) {
        let sweeps = 1 + 30_000 / self.points;
        let per_point = 1e9 / (sweeps * self.points) as f64;
        let softness = self.batch.settings.softness();
        let measure = false;
        let batch = &mut self.batch;
        let mut note = |kernel: usize, work: &mut dyn FnMut()| {
            work();
            let clock = Instant::now();
            (0..sweeps).for_each(|_| work());
            self.times[kernel].push(per_point * clock.elapsed().as_secs_f64());
        };
        for (kernel, (width, _)) in WIDTHS.into_iter().enumerate() {
            let solve = Pass::Solve { softness, measure };
            note(kernel, &mut || pass(batch, width, solve));
        }
        note(3, &mut || {
            pass(batch, LaneWidth::Widest, Pass::Relax { measure });
        });
        note(4, &mut || run(LaneWidth::Widest, Transposes(batch)));
    }

    fn into_measured(self) -> Measured {
        let (blocks, rows) = (
            self.batch.contacts.blocks.len(),
            self.batch.contacts.points.len(),
        );
        let bodies = self.batch.bodies.velocities.len();
        let moved = blocks * size_of::<Block>() + rows * (size_of::<Point>() + DIRTY);
        let of_bodies = blocks * 2 * 2 * WIDTH * size_of::<SolverBody>();
        let [solve @ .., relax, transposes] = self.times.map(least_and_median);
        Measured {
            name: self.name,
            points: self.points,
            lanes: rows * WIDTH,
            working_set: blocks * size_of::<Block>()
                + rows * size_of::<Point>()
                + bodies * size_of::<SolverBody>(),
            bytes: (moved + of_bodies) as f64 / self.points as f64,
            solve,
            relax,
            transposes,
        }
    }
}

fn least_and_median(mut times: Vec<f64>) -> [f64; 2] {
    times.sort_by(f64::total_cmp);
    [times[0], times[times.len() / 2]]
}

/// What a sweep does around its points: velocities into lanes, and back.
struct Transposes<'a>(&'a mut Batch);

impl Kernel for Transposes<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Batch {
            contacts, bodies, ..
        } = self.0;
        let bodies = Cell::from_mut(&mut bodies.velocities[..]).as_slice_of_cells();
        for block in contacts.blocks.iter() {
            let [a, b] = &block.bodies;
            let (of_a, of_b) = (L::gather(bodies, a), L::gather(bodies, b));
            L::scatter(of_a, bodies, a, block.used);
            L::scatter(of_b, bodies, b, block.used);
        }
    }
}

/// Shortest times that a point could take for one reason alone, ns.
pub(crate) struct Bounds {
    /// Its operations at the peak of 8 lanes.
    pub(crate) operations: f64,
    /// The same with the lanes in which there is no point.
    pub(crate) with_unused_lanes: f64,
    /// Its bytes at the bandwidth of the level that holds the working set.
    pub(crate) bandwidth: f64,
    /// The chain of operations, if points come strictly one after the other.
    pub(crate) chain: f64,
    /// That level.
    pub(crate) level: &'static str,
}

impl Measured {
    pub(crate) fn bounds(&self, limits: &Limits) -> Bounds {
        let lanes_for_a_point = self.lanes as f64 / self.points as f64;
        let operations = flops() / limits.flops[0];
        // The caches of this kind of processor: 48 KiB, 2 MiB; and one that all cores share.
        let level = [40 << 10, 3 << 19, 64 << 20]
            .iter()
            .take_while(|&&size| self.working_set > size)
            .count();
        Bounds {
            operations,
            with_unused_lanes: lanes_for_a_point * operations,
            bandwidth: self.bytes / limits.triad[level],
            chain: lanes_for_a_point / WIDTH as f64 * chain() / limits.clock,
            level: LEVELS[level].0,
        }
    }
}
