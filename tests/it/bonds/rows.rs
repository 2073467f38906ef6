//! Bonded blocks against the rows they stand for: one sweep does what Gauss-Seidel does row by row.

use crate::common::dice::Dice;
use bevy_cleave::contact::{ContactPoint, MAX_POINTS, Manifold, ManifoldHead};
use bevy_cleave::solver::FrictionModel;
use bevy_cleave::testing::bodies::{BodyMass, SolverBody};
use bevy_cleave::testing::math::tangents;
use bevy_cleave::testing::pgs;
use bevy_cleave::testing::rows::{PointRows, RowSoftness};
use bevy_cleave::testing::simd::{F8, LaneWidth, WIDTH};
use bevy_cleave::testing::wide::{Block, BondConstraint, ContactBlocks, Pass, Point, Source, fill};
use glam::Vec3;
use std::cell::Cell;

/// One block of eight manifolds between sixteen bodies; about half of the manifolds are bonded.
struct Scene {
    blocks: Vec<Block>,
    points: Vec<Point>,
    bond_constraints: Vec<BondConstraint>,
    bodies: Vec<SolverBody>,
}

fn any_manifold(dice: &mut Dice, a: u32) -> Manifold {
    let normal = dice.direction();
    let [t1, t2] = tangents(normal);
    let points = [(); MAX_POINTS].map(|()| {
        let friction = 0.1 * (dice.unit() * t1 - dice.unit() * t2);
        ContactPoint {
            anchor_a: dice.vector(-0.5, 0.5),
            anchor_b: dice.vector(-0.5, 0.5),
            normal_impulse: 0.1 * dice.unit(),
            friction_impulse: friction,
            ..ContactPoint::default()
        }
    });
    let head = ManifoldHead {
        a,
        b: a + 1,
        normal,
        friction: dice.unit(),
        count: MAX_POINTS as u32,
        ..ManifoldHead::default()
    };
    Manifold { head, points }
}

impl Scene {
    fn new(seed: u64) -> Self {
        let mut dice = Dice::new(seed);
        let (mut bodies, mut masses) = (Vec::new(), Vec::new());
        for _ in 0..2 * WIDTH {
            let inverse_mass = dice.in_range(0.2, 5.0);
            let (body, inertia) = dice.solver_body(inverse_mass);
            bodies.push(body);
            masses.push(BodyMass::new(inverse_mass, &inertia, 1.0));
        }
        let manifolds: Vec<_> = (0..WIDTH as u32)
            .map(|i| any_manifold(&mut dice, 2 * i))
            .collect();
        let mut blocks = vec![Block::default()];
        blocks[0].clear(0, 0..MAX_POINTS);
        for (lane, m) in manifolds.iter().enumerate() {
            blocks[0].put(lane, lane as u32, [m.a, m.b]);
        }
        let mut points = vec![Point::default(); MAX_POINTS];
        let source = Source {
            manifolds: &manifolds.iter().collect(),
            masses: &masses,
            share: 1.0,
            slop: 0.0,
        };
        fill(&mut blocks, &mut points, source, LaneWidth::One);
        let mut bond_constraints = vec![BondConstraint::default(); MAX_POINTS];
        for lane in 0..WIDTH {
            if dice.below(2) == 0 {
                continue;
            }
            for (tie, point) in bond_constraints.iter_mut().zip(&mut points) {
                tie.adhesion.0[lane] = dice.in_range(0.01, 0.5);
                tie.shear.0[lane] = dice.in_range(0.01, 0.5);
                tie.target_velocity[0].0[lane] = dice.in_range(-0.2, 0.2);
                tie.target_velocity[1].0[lane] = dice.in_range(-0.2, 0.2);
                point.target_velocity.0[lane] = dice.in_range(-2.0, 0.5);
            }
        }
        Self {
            blocks,
            points,
            bond_constraints,
            bodies,
        }
    }

    fn rows(&self) -> Vec<PointRows> {
        let lanes = 0..WIDTH;
        let rows = lanes.flat_map(|lane| {
            let points = self.points.iter().zip(&self.bond_constraints);
            points.map(move |(point, tie)| point.rows(lane, &self.blocks[0], Some(tie), 0.0))
        });
        rows.collect()
    }

    fn sweep(&mut self, friction: FrictionModel, width: LaneWidth) {
        let cells = Cell::from_mut(self.bodies.as_mut_slice()).as_slice_of_cells();
        let mut contacts = ContactBlocks {
            blocks: &self.blocks,
            points: &mut self.points,
            first_point: 0,
            impacts: &[],
            lane_changes: &mut [],
            bodies: cells,
            displacements: &[],
            friction,
            width,
            is_far: false,
        };
        let pass = Pass::Solve {
            softness: RowSoftness::HARD,
            measure: false,
        };
        contacts.pass_bonded(pass, &mut [], &mut self.bond_constraints);
    }
}

fn assert_close(found: Vec3, expected: Vec3, what: &str) {
    let error = (found - expected).length();
    assert!(
        error < 2e-5 * (1.0 + expected.length()),
        "{what}: {found}, not {expected}"
    );
}

#[test]
fn a_sweep_over_bonded_blocks_is_the_one_over_rows() {
    let mut pulling = 0;
    for seed in 0..50 {
        let mut scene = Scene::new(seed);
        let (mut rows, mut bodies) = (scene.rows(), scene.bodies.clone());
        for _ in 0..3 {
            pgs::sweep(&mut rows, &mut bodies, FrictionModel::Disc);
            scene.sweep(FrictionModel::Disc, LaneWidth::Widest);
        }
        for (found, expected) in scene.bodies.iter().zip(&bodies) {
            assert_close(found.linear, expected.linear, "velocity");
            assert_close(found.angular, expected.angular, "rotation");
        }
        for (found, expected) in scene.rows().iter().zip(&rows) {
            let impulses = [found, expected].map(|row| Vec3::from(row.impulses()));
            assert_close(impulses[0], impulses[1], "impulses");
            let [normal, ..] = expected.impulses();
            assert!(normal >= -expected.adhesion);
            pulling += usize::from(normal < 0.0);
        }
    }
    assert!(pulling > 200, "only {pulling} points pull");
}

#[test]
fn lanes_without_a_bond_get_the_bits_that_they_get_among_contacts() {
    for seed in 0..50 {
        let mut tied = Scene::new(seed);
        let free: Vec<_> = (0..WIDTH)
            .filter(|&lane| tied.bond_constraints[0].adhesion.0[lane] == 0.0)
            .collect();
        let mut plain = Scene::new(seed);
        plain.bond_constraints = vec![BondConstraint::default(); MAX_POINTS];
        let cells = Cell::from_mut(plain.bodies.as_mut_slice()).as_slice_of_cells();
        let mut contacts = ContactBlocks {
            blocks: &plain.blocks,
            points: &mut plain.points,
            first_point: 0,
            impacts: &[],
            lane_changes: &mut [],
            bodies: cells,
            displacements: &[],
            friction: FrictionModel::Disc,
            width: LaneWidth::Widest,
            is_far: false,
        };
        let pass = Pass::Solve {
            softness: RowSoftness::HARD,
            measure: false,
        };
        contacts.pass(pass, &mut []);
        tied.sweep(FrictionModel::Disc, LaneWidth::Widest);
        let bits = |impulse: &[F8; 3], lane: usize| impulse.map(|lanes| lanes.0[lane].to_bits());
        for lane in free {
            for (a, b) in tied.points.iter().zip(&plain.points) {
                assert_eq!(
                    bits(&a.impulse, lane),
                    bits(&b.impulse, lane),
                    "lane {lane}"
                );
            }
        }
    }
}
