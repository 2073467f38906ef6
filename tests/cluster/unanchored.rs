//! Clusters of a thousand parts and more that lose what held them: they come down whole, or as what hangs together.
#![allow(clippy::disallowed_methods, reason = "strengths of scenes")]
#![allow(
    clippy::print_stdout,
    reason = "the times of the steps are looked at, not asserted"
)]

use crate::common::dice::Dice;
use crate::common::scenes::awake_on_floor;
use crate::shapes::{ball, standing};
use bevy_cleave::prelude::*;
use glam::Vec3;
use std::time::Instant;

/// What takes the hold from a cluster.
#[derive(Clone, Copy, Debug)]
enum Loss {
    /// It becomes dynamic.
    Kind,
    /// Its anchors go, and then a ball hits it.
    Anchors,
    /// A cut goes through it that has no anchors any more.
    Cut,
}

/// A wall, tower or slab of bricks above the floor, some of it behind an anchored plane.
fn member(dice: &mut Dice) -> (Compound, Vec3) {
    let brick = dice.vector(0.1, 0.4);
    let shapes = [[40, 30, 1], [10, 25, 5], [12, 12, 8]];
    let [x, y, z] = shapes[dice.below(3)];
    let at = |i: usize| {
        let place = Vec3::new((i % x) as f32, (i / x % y) as f32, (i / x / y) as f32);
        Pose::from_position(brick * (place + 0.5))
    };
    let brick_shape = ConvexMesh::cuboid(brick.x, brick.y, brick.z).expect("a brick");
    let parts = (0..x * y * z).map(|i| (at(i), brick_shape.clone()));
    let strength = 1e6 * 30.0f32.powf(dice.unit());
    let cluster = Cluster::new(parts, strength).expect("bricks");
    let size = brick * Vec3::new(x as f32, y as f32, z as f32);
    (cluster.compound().expect("connected"), size)
}

#[test]
fn a_large_cluster_that_nothing_holds_any_more_comes_down_in_connected_parts() {
    for (seed, loss) in [Loss::Kind, Loss::Anchors, Loss::Cut]
        .into_iter()
        .cycle()
        .take(9)
        .enumerate()
    {
        let dice = &mut Dice::new(seed as u64);
        let (shape, size) = member(dice);
        let count = shape.len();
        assert!(count >= 1000);
        let mut simulation = awake_on_floor();
        let lift = dice.in_range(0.1, 1.0);
        let desc = BodyDesc {
            pose: Pose::from_position(lift * Vec3::Y),
            ..standing(shape)
        };
        let body = simulation.bodies.insert(desc).expect("usable");
        let held = Anchors::none().and_behind(Vec3::X, 0.3 * size.x);
        simulation
            .bodies
            .set_anchors(body, Some(held))
            .expect("usable");
        let rate = [30.0, 60.0, 120.0][dice.below(3)];
        let mut longest = 0.0f64;
        let mut step = |simulation: &mut Simulation| {
            let start = Instant::now();
            simulation.step(1.0 / rate);
            longest = longest.max(start.elapsed().as_secs_f64());
            for fracture in &simulation.fractures.done {
                assert!(fracture.ledger.mass_error() < 1e-6, "seed {seed}: {loss:?}");
                assert!(
                    fracture.ledger.momentum_error() < 1e-5,
                    "seed {seed}: {loss:?}"
                );
            }
        };
        (0..5).for_each(|_| step(&mut simulation));
        let id = simulation.bodies.id(body);
        let is_there = |simulation: &Simulation| simulation.bodies.is_current(body, id);
        assert!(is_there(&simulation), "seed {seed}: it broke by itself");
        match loss {
            Loss::Kind => simulation
                .bodies
                .set_kind(body, RigidBody::Dynamic)
                .expect("usable"),
            Loss::Anchors => {
                let none = Some(Anchors::none());
                simulation.bodies.set_anchors(body, none).expect("usable");
                let at = size * Vec3::new(0.93, 0.9, 1.0) + Vec3::new(0.0, lift, 0.3);
                let missile = ball(0.1, 8000.0, at, -60.0 * Vec3::Z);
                simulation.bodies.insert(missile).expect("usable");
            }
            Loss::Cut => {
                let none = Some(Anchors::none());
                simulation.bodies.set_anchors(body, none).expect("usable");
                let plane = Plane::through(
                    dice.in_range(0.3, 0.7) * size + lift * Vec3::Y,
                    dice.direction(),
                );
                simulation.slice(body, plane).expect("a body");
            }
        }
        // Until it has fallen by half of the way to the floor.
        let seconds = (lift / 9.81f32).sqrt();
        for _ in 0..2 + (seconds * rate) as usize {
            step(&mut simulation);
        }
        let about = format!("seed {seed}: {loss:?}, {rate} Hz");
        let bodies = clusters(&simulation);
        let parts: usize = bodies.iter().map(|(_, parts)| parts).sum();
        let (largest, _) = bodies.iter().max_by_key(|(_, parts)| *parts).expect("some");
        println!(
            "{about}: {parts} of {count} parts in {} bodies",
            bodies.len()
        );
        assert!(
            matches!(loss, Loss::Cut) || parts == count,
            "{about}: {parts} of {count} parts"
        );
        for &(slot, _) in &bodies {
            let kind = simulation.bodies.kind(slot);
            assert_eq!(kind, RigidBody::Dynamic, "{about}: hangs on nothing");
        }
        let speed = simulation.bodies.velocity(*largest).0.y;
        assert!(speed < -0.5 * 9.81 * seconds, "{about}: {speed} m/s");
        // It hits the floor.
        (0..(0.5 * rate) as usize).for_each(|_| step(&mut simulation));
        let bodies = clusters(&simulation);
        println!(
            "  then in {} bodies; longest step {:.0} ms",
            bodies.len(),
            1e3 * longest
        );
        for (slot, _) in bodies {
            let shape = simulation.bodies.compound(slot);
            let together = shape.map_or(1, |shape| Cluster::from(shape).separated().len());
            assert_eq!(together, 1, "{about}: no bond holds its parts together");
        }
    }
}

/// The bodies that are made of parts, or were, and how many of them.
fn clusters(simulation: &Simulation) -> Vec<(u32, usize)> {
    let bodies = &simulation.bodies;
    let parts = bodies.iter().filter_map(|slot| {
        let brick = || bodies.convex(slot).filter(|mesh| !mesh.is_round());
        let parts = bodies.compound(slot).map(Compound::len);
        parts
            .or_else(|| brick().map(|_| 1))
            .map(|parts| (slot, parts))
    });
    parts.collect()
}
