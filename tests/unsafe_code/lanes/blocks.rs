//! Blocks of manifolds against the rows they stand for: one sweep does what Gauss-Seidel does row by row.

use super::WIDTHS;
use crate::common::dice::Dice;
use bevy_cleave::contact::{ContactPoint, MAX_POINTS, Manifold, ManifoldHead};
use bevy_cleave::solver::FrictionModel;
use bevy_cleave::testing::bodies::{BodyMass, SolverBody};
use bevy_cleave::testing::graph::{LaneSlot, OrderedPacking, Packer};
use bevy_cleave::testing::math::tangents;
use bevy_cleave::testing::pgs;
use bevy_cleave::testing::rows::{Bias, PointRows, RowBody, RowSoftness, Softness};
use bevy_cleave::testing::simd::{F8, LaneWidth};
use bevy_cleave::testing::wide::{Block, ContactBlocks, Pass, Point, Source, fill};
use glam::Mat3;
use std::cell::Cell;

/// Number of bodies; every fifth is fixed.
const BODIES: usize = 24;

/// Share of the least extent.
const SLOP: f32 = 0.01;

/// A sweep over rows without compliance.
const HARD: Pass = Pass::Solve {
    softness: RowSoftness::HARD,
    measure: false,
};

/// Position bias of a sub-step of an eighth of 1/60 s.
const FEEDBACK: Bias = Bias {
    substep_dt: 1.0 / 480.0,
    bias_rate: 30.0,
    bond_rate: 15.0,
    max_bias_velocity: 3.0,
};

/// Random contacts of random bodies.
struct Scene {
    manifolds: Vec<Manifold>,
    bodies: Vec<SolverBody>,
    /// With one more for the lanes that are not used.
    masses: Vec<BodyMass>,
}

impl Scene {
    fn new(seed: u64) -> Self {
        let mut dice = Dice::new(seed);
        let (mut bodies, mut masses) = (Vec::new(), Vec::new());
        for i in 0..BODIES {
            let is_fixed = i % 5 == 0;
            let inverse_mass = if is_fixed {
                0.0
            } else {
                dice.in_range(0.2, 5.0)
            };
            let (body, inertia) = dice.solver_body(inverse_mass);
            bodies.push(body);
            masses.push(BodyMass::new(
                inverse_mass,
                &inertia,
                dice.in_range(0.3, 2.0),
            ));
        }
        bodies.push(SolverBody::default());
        masses.push(BodyMass::new(0.0, &Mat3::ZERO, 1.0));
        let manifolds = (0..3 * BODIES)
            .filter_map(|_| random_manifold(&mut dice))
            .collect();
        Self {
            manifolds,
            bodies,
            masses,
        }
    }

    /// The rows of all points in the order of the manifolds.
    fn rows(&self) -> Vec<PointRows> {
        let rows = self.manifolds.iter().flat_map(|manifold| {
            let pair = [manifold.a, manifold.b];
            let masses = pair.map(|body| &self.masses[body as usize]);
            let sides = masses.map(|solid| RowBody {
                inverse_mass: solid.inverse_mass(),
                inverse_inertia: solid.inverse_inertia(),
            });
            let extent = masses[0].extent().min(masses[1].extent());
            let points = manifold.points().iter();
            points.map(move |point| PointRows::new(manifold, point, pair, sides, extent, SLOP))
        });
        rows.collect()
    }
}

/// `None` for a manifold of a body with itself or of two fixed bodies.
fn random_manifold(dice: &mut Dice) -> Option<Manifold> {
    let pair = [dice.below(BODIES), dice.below(BODIES)];
    if pair[0] == pair[1] || pair.iter().all(|body| body % 5 == 0) {
        return None;
    }
    let normal = dice.direction();
    let friction = if dice.below(5) == 0 { 0.0 } else { dice.unit() };
    let [t1, t2] = tangents(normal);
    let points = [(); MAX_POINTS].map(|()| {
        let impulse = dice.unit();
        let bound = 0.5 * friction * impulse;
        ContactPoint {
            anchor_a: dice.vector(-0.5, 0.5),
            anchor_b: dice.vector(-0.5, 0.5),
            separation: dice.in_range(-0.02, 0.02),
            normal_impulse: impulse,
            friction_impulse: bound * (dice.unit() * t1 - dice.unit() * t2),
            ..Default::default()
        }
    });
    let head = ManifoldHead {
        a: pair[0] as u32,
        b: pair[1] as u32,
        normal,
        friction,
        restitution: 0.0,
        count: 1 + dice.below(MAX_POINTS) as u32,
    };
    Some(Manifold { head, points })
}

/// The scene in blocks.
struct Blocks {
    places: Vec<LaneSlot>,
    blocks: Vec<Block>,
    points: Vec<Point>,
    bodies: Vec<SolverBody>,
    friction: FrictionModel,
    width: LaneWidth,
}

impl Blocks {
    fn new(scene: &Scene, friction: FrictionModel, width: LaneWidth) -> Self {
        let mut schedule = OrderedPacking::default();
        schedule.begin(scene.bodies.len());
        for m in &scene.manifolds {
            let moves = |body: &u32| scene.bodies[*body as usize].inverse_mass > 0.0;
            schedule.add([m.a, m.b].map(|body| Some(body).filter(moves)), m.count);
        }
        let places: Vec<LaneSlot> = schedule.place().collect();
        let mut blocks = Vec::new();
        let mut count = 0;
        for points in schedule
            .points_of_blocks()
            .iter()
            .map(|&points| usize::from(points))
        {
            let mut block = Block::default();
            block.clear(BODIES as u32, count..count + points);
            blocks.push(block);
            count += points;
        }
        for (i, (manifold, place)) in scene.manifolds.iter().zip(&places).enumerate() {
            let block = &mut blocks[place.block as usize];
            block.put(place.lane as usize, i as u32, [manifold.a, manifold.b]);
        }
        let mut points = vec![Point::default(); count];
        let source = Source {
            manifolds: &scene.manifolds.iter().collect(),
            masses: &scene.masses,
            share: 1.0,
            slop: SLOP,
        };
        fill(&mut blocks, &mut points, source, width);
        Self {
            places,
            blocks,
            points,
            bodies: scene.bodies.clone(),
            friction,
            width,
        }
    }

    /// Does a pass, with displacements where the pass looks at them.
    fn pass(&mut self, pass: Pass, displacements: &mut [SolverBody], last: &mut [[F8; 3]]) -> f32 {
        let mut contacts = ContactBlocks {
            blocks: &self.blocks,
            points: &mut self.points,
            first_point: 0,
            impacts: &[],
            lane_changes: &mut [],
            bodies: Cell::from_mut(&mut self.bodies[..]).as_slice_of_cells(),
            displacements: Cell::from_mut(displacements).as_slice_of_cells(),
            friction: self.friction,
            width: self.width,
            is_far: false,
        };
        contacts.pass(pass, last)
    }

    /// A pass that looks at no displacements.
    fn alone(&mut self, pass: Pass) {
        self.pass(pass, &mut [], &mut []);
    }

    fn targets(&mut self, displacements: &mut [SolverBody]) {
        let (bias, is_first) = (FEEDBACK, true);
        self.pass(Pass::UpdateBias { bias, is_first }, displacements, &mut []);
    }

    /// Points with their lanes, in the order of the manifolds.
    fn points(&self) -> impl Iterator<Item = (&Point, usize)> {
        self.places.iter().flat_map(|place| {
            let range = self.blocks[place.block as usize].points.clone();
            let points = self.points[range].iter().take(place.count as usize);
            points.map(|point| (point, place.lane as usize))
        })
    }

    /// Impulses of all points in the order of the manifolds.
    fn impulses(&self) -> impl Iterator<Item = [f32; 3]> {
        self.points()
            .map(|(point, lane)| point.impulse.map(|lanes| lanes.0[lane]))
    }

    /// Wanted velocities of all points in the order of the manifolds.
    fn target_velocity(&self) -> impl Iterator<Item = f32> {
        self.points()
            .map(|(point, lane)| point.target_velocity.0[lane])
    }

    /// All that a sub-step does, in bits; targets are set by the is_first sweep, or by a pass of their own.
    fn bits_after_all_loops(&mut self, targets: Targets) -> Vec<u32> {
        let contacts = Softness {
            bias_rate: 30.0,
            mass_scale: 0.9,
            impulse_scale: 0.1,
        };
        let bonds = Softness::HARD;
        let softness = RowSoftness {
            contacts,
            friction: 0.5,
            bonds,
        };
        let mut displacements: Vec<_> = self.bodies.iter().map(|body| scaled(body, 1e-2)).collect();
        let mut last = vec![[F8::default(); 3]; self.points.len()];
        let (bias, measure, weight) = (FEEDBACK, true, 0.5);
        let mut do_pass = |pass| self.pass(pass, &mut displacements, &mut last);
        let (is_first, later) = (true, false);
        do_pass(Pass::Warm);
        let solved = match targets {
            Targets::ByFirstSweep => do_pass(Pass::SolveFirst {
                bias,
                is_first,
                softness,
                measure,
            }),
            Targets::Before => {
                do_pass(Pass::UpdateBias { bias, is_first });
                do_pass(Pass::Solve { softness, measure })
            }
        };
        do_pass(Pass::Extrapolate { weight });
        let is_first = later;
        do_pass(Pass::UpdateBias { bias, is_first });
        let relaxed = do_pass(Pass::Relax { measure });
        let bodies = self.bodies.iter().flat_map(|body| {
            let parts = [body.linear, body.angular];
            parts.into_iter().flat_map(|v| v.to_array())
        });
        let points = self.points.iter().flat_map(|point| {
            let lanes = [
                point.target_velocity,
                point.total_normal_impulse,
                point.normal_mass,
                point.tangent_mass,
            ];
            point
                .impulse
                .into_iter()
                .chain(lanes)
                .flat_map(|lanes| lanes.0)
        });
        let all = bodies.chain(points).chain([solved, relaxed]);
        all.map(f32::to_bits).collect()
    }
}

/// What sets the target velocities.
#[derive(Clone, Copy)]
enum Targets {
    Before,
    ByFirstSweep,
}

fn scaled(body: &SolverBody, factor: f32) -> SolverBody {
    SolverBody {
        linear: factor * body.linear,
        angular: factor * body.angular,
        ..*body
    }
}

/// Largest difference of two lists of triples, and the largest number in them.
fn difference(a: impl Iterator<Item = [f32; 3]>, b: impl Iterator<Item = [f32; 3]>) -> [f32; 2] {
    a.zip(b)
        .flat_map(|(a, b)| a.into_iter().zip(b))
        .fold([0.0, 0.0], |[error, size]: [f32; 2], (a, b)| {
            [error.max((a - b).abs()), size.max(a.abs())]
        })
}

fn velocities(bodies: &[SolverBody]) -> impl Iterator<Item = [f32; 3]> {
    let parts = bodies.iter().flat_map(|body| [body.linear, body.angular]);
    parts.map(|v| v.to_array())
}

/// The same scene as rows and as blocks, with the same targets, warm started.
fn both(scene: &Scene, friction: FrictionModel, width: LaneWidth) -> (Rows, Blocks) {
    let (mut rows, mut bodies) = (scene.rows(), scene.bodies.clone());
    let mut blocks = Blocks::new(scene, friction, width);
    let mut at_rest = vec![SolverBody::default(); scene.bodies.len()];
    blocks.targets(&mut at_rest);
    for (row, target_velocity) in rows.iter_mut().zip(blocks.target_velocity()) {
        row.normal.target_velocity = target_velocity;
    }
    pgs::apply_impulses(&rows, &mut bodies);
    blocks.alone(Pass::Warm);
    (Rows { rows, bodies }, blocks)
}

struct Rows {
    rows: Vec<PointRows>,
    bodies: Vec<SolverBody>,
}

#[test]
fn sweep_over_blocks_is_the_sweep_over_rows() {
    for (seed, width) in (0..20).flat_map(|seed| WIDTHS.map(|width| (seed, width))) {
        let (mut rows, mut blocks) = both(&Scene::new(seed), FrictionModel::Disc, width);
        for sweep in 0..4 {
            let [error, size] = difference(velocities(&rows.bodies), velocities(&blocks.bodies));
            assert!(
                error < 2e-5 * size,
                "{seed}, sweep {sweep}: {error} of {size}"
            );
            let of_rows = rows.rows.iter().map(PointRows::impulses);
            let [error, size] = difference(of_rows, blocks.impulses());
            assert!(
                error < 2e-5 * size,
                "{seed}, sweep {sweep}: {error} of {size} N s"
            );
            pgs::sweep(&mut rows.rows, &mut rows.bodies, FrictionModel::Disc);
            blocks.alone(HARD);
        }
    }
}

/// The rows of the paper's box are solved one after the other, those of a block's point together: not the same sweep, but
/// the same solution.
#[test]
fn sweeps_over_blocks_and_over_rows_end_at_the_same_velocities_with_friction_in_a_box() {
    for seed in 0..20 {
        let mut scene = Scene::new(seed);
        // Few points, so that the sweeps converge.
        scene.manifolds.truncate(12);
        scene.manifolds.iter_mut().for_each(|m| m.count = 1);
        let (mut rows, mut blocks) = both(&scene, FrictionModel::Box, LaneWidth::Widest);
        for _ in 0..400 {
            pgs::sweep(&mut rows.rows, &mut rows.bodies, FrictionModel::Box);
            blocks.alone(HARD);
        }
        let [error, size] = difference(velocities(&rows.bodies), velocities(&blocks.bodies));
        assert!(error < 1e-4 * size, "{seed}: {error} of {size}");
    }
}

#[test]
fn all_widths_give_the_same_bits_in_all_loops() {
    for seed in 0..20 {
        for friction in [FrictionModel::Disc, FrictionModel::Box] {
            let scene = Scene::new(seed);
            let bits_by =
                |width, targets| Blocks::new(&scene, friction, width).bits_after_all_loops(targets);
            let before = bits_by(LaneWidth::Widest, Targets::Before);
            let bits = WIDTHS.map(|width| bits_by(width, Targets::ByFirstSweep));
            assert!(
                bits.iter().all(|other| *other == before),
                "{seed}, {friction:?}"
            );
        }
    }
}

#[test]
fn body_of_unused_lanes_stays_as_it_was() {
    let scene = Scene::new(7);
    for width in WIDTHS {
        let mut blocks = Blocks::new(&scene, FrictionModel::Disc, width);
        blocks.bits_after_all_loops(Targets::ByFirstSweep);
        assert_eq!(blocks.bodies[BODIES], SolverBody::default());
    }
}
