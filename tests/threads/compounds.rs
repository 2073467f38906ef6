//! Tables, cups and boxes that fall on a floor of parts.

use crate::common::dice::Dice;
use crate::common::states::bits_by_id;
use crate::common::structures::cuboid;
use crate::{alone, on_threads};
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Length of a step, s.
const H: f32 = 1.0 / 60.0;

pub(crate) type Outcome = Vec<[u32; 13]>;

fn compound(parts: &[(Vec3, Vec3)]) -> Compound {
    let parts = parts.iter();
    let parts = parts.map(|&(size, at)| (Pose::from_position(at), cuboid(size)));
    Compound::new(parts).expect("usable parts")
}

/// State of a heap of compounds after three seconds.
pub(crate) fn run() -> Outcome {
    let dice = &mut Dice::new(7);
    let mut simulation = Simulation::default();
    let tiles = (0..100).map(|i| {
        let at = Vec3::new((i % 10) as f32 - 4.5, -0.5, (i / 10) as f32 - 4.5);
        (Vec3::ONE, at)
    });
    let floor = compound(&tiles.collect::<Vec<_>>());
    let floor = BodyDesc::new(RigidBody::Static, Shape::Compound(floor));
    simulation.bodies.insert(floor).expect("usable");
    let legs = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];
    let mut table = vec![(Vec3::new(0.6, 0.05, 0.6), 0.3 * Vec3::Y)];
    table.extend(legs.map(|[x, z]| {
        let at = Vec3::new(0.25 * x, 0.0, 0.25 * z);
        (Vec3::new(0.06, 0.6, 0.06), at)
    }));
    let table = compound(&table);
    for i in 0..400 {
        let at = Vec3::new(
            dice.in_range(-3.0, 3.0),
            0.5 + 0.02 * i as f32,
            dice.in_range(-3.0, 3.0),
        );
        let desc = match i % 2 {
            0 => BodyDesc::compound(table.clone(), at),
            _ => BodyDesc::dynamic(cuboid(dice.vector(0.1, 0.4)), at),
        };
        let pose = Pose::new(at, dice.rotation());
        simulation
            .bodies
            .insert(BodyDesc { pose, ..desc })
            .expect("usable");
    }
    for _ in 0..180 {
        simulation.step(H);
    }
    let states = bits_by_id(&simulation).into_iter();
    states.map(|(_, state)| state).collect()
}

#[test]
fn a_heap_of_compounds_does_not_depend_on_threads() {
    assert_eq!(on_threads(run), alone().compounds);
}
