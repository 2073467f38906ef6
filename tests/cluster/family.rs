//! Random clusters under random blows.

use crate::common::dice::Dice;
use crate::common::scenes::awake_on_floor;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// Whether bonds hold all parts of a body together.
fn is_connected(shape: &Compound) -> bool {
    let cluster = Cluster::from(shape);
    cluster.separated().len() == 1
}

fn member(seed: u64) -> (Compound, Dice) {
    let mut dice = Dice::new(seed);
    let size = Vec3::from_array(std::array::from_fn(|_| dice.in_range(0.3, 1.5)));
    let whole = ConvexMesh::cuboid(size.x, size.y, size.z).expect("a box");
    let pattern = if dice.in_range(0.0, 1.0) < 0.5 {
        FracturePattern::Voronoi {
            cells: dice.in_range(4.0, 40.0) as u16,
            focus: 0.0,
        }
    } else {
        FracturePattern::Brick {
            size: size / dice.in_range(2.0, 5.0),
        }
    };
    let decade = [3e3, 3e4, 3e5][dice.below(3)];
    let strength = decade * dice.in_range(1.0, 10.0);
    let cluster = Cluster::cut(&whole, &pattern, seed, strength).expect("cells");
    (cluster.compound().expect("connected"), dice)
}

#[test]
fn nothing_is_lost_of_random_clusters_that_fall_and_are_shot_at() {
    let mut fractures = 0;
    for seed in 0..32 {
        let (shape, mut dice) = member(seed);
        let mut simulation = awake_on_floor();
        let axis = Vec3::from_array(std::array::from_fn(|_| dice.in_range(-1.0, 1.0)));
        let turn = Quat::from_axis_angle(axis.normalize_or(Vec3::Y), dice.in_range(0.0, 3.0));
        let desc = BodyDesc {
            pose: Pose::new(Vec3::Y * dice.in_range(1.2, 4.0), turn),
            linear_velocity: Vec3::Y * dice.in_range(-8.0, 0.0),
            angular_velocity: axis * dice.in_range(0.0, 4.0),
            ..BodyDesc::compound(shape.clone(), Vec3::ZERO)
        };
        simulation.bodies.insert(desc).expect("usable");
        let at = Vec3::new(dice.in_range(-0.2, 0.2), dice.in_range(1.0, 2.0), 3.0);
        let shot = crate::shapes::ball(0.1, 3000.0, at, -Vec3::Z * dice.in_range(5.0, 40.0));
        simulation.bodies.insert(shot).expect("usable");
        let rate = [30.0, 60.0, 120.0, 240.0][seed as usize % 4];
        simulation.step(1.0 / rate);
        let mass = |simulation: &Simulation| -> f64 {
            let bodies = &simulation.bodies;
            bodies.iter().map(|s| f64::from(bodies.mass(s).mass)).sum()
        };
        let whole = mass(&simulation);
        for _ in 0..rate as usize {
            simulation.step(1.0 / rate);
            for fracture in &simulation.fractures.done {
                fractures += 1;
                let ledger = &fracture.ledger;
                assert!(
                    ledger.mass_error() < 1e-6,
                    "{seed}: {}",
                    ledger.mass_error()
                );
                assert!(
                    ledger.momentum_error() < 1e-5,
                    "{seed}: {}",
                    ledger.momentum_error()
                );
                assert!(
                    ledger.angular_momentum_error() < 1e-4,
                    "{seed}: {}",
                    ledger.angular_momentum_error()
                );
                assert!(
                    ledger.energy_gain().abs() < 1e-4,
                    "{seed}: {}",
                    ledger.energy_gain()
                );
            }
            for slot in simulation.bodies.iter() {
                let shape = simulation.bodies.compound(slot);
                assert!(shape.is_none_or(is_connected), "seed {seed}");
            }
        }
        let left = mass(&simulation);
        assert!(
            (left - whole).abs() < 1e-5 * whole,
            "{seed}: {left} of {whole} kg"
        );
    }
    assert!(fractures > 20, "{fractures}");
}
