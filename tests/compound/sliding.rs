//! Sliding over a compound of flush parts, or with one, is sliding over one piece.
#![expect(clippy::print_stdout, reason = "the measured figures are the result")]
#![expect(clippy::disallowed_methods, reason = "speeds of scenes")]

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use crate::common::structures::{cuboid, fixed, floor};
use crate::shapes::{brick, compound};
use crate::slides::{Floor, G, H, SAG, SPEED, count_different};
use bevy_cleave::prelude::*;
use glam::Vec3;

#[test]
fn sliding_over_a_compound_of_flush_parts_is_sliding_over_one() {
    let [failed, ran] = count_different(Floor::Compound);
    assert_eq!(failed, 0, "of {ran} slides differ");
}

/// A slab of tiles that slides over the ground, or over tiles.
#[test]
fn a_compound_of_flush_parts_slides_as_one_piece() {
    let mut worst = 0.0_f32;
    for seed in 0..40 {
        let dice = &mut Dice::new(seed);
        let speed = 0.05 * 1000.0_f32.powf(dice.unit());
        let size = Vec3::new(1.2, 0.2, 0.9);
        let [nx, nz] = [1 + dice.below(4), 1 + dice.below(3)];
        let tile = size / Vec3::new(nx as f32, 1.0, nz as f32);
        let tiles = (0..nx).flat_map(|x| (0..nz).map(move |z| (x, z)));
        let tiles = tiles.map(|(x, z)| {
            let at = Vec3::new(x as f32 + 0.5, 0.5, z as f32 + 0.5) * tile;
            brick(tile, at - 0.5 * size)
        });
        let tiles = compound(tiles.collect());
        let ground = dice.below(3);
        let over = 0.3 + dice.unit();
        let speed_at_end = |shape: Shape| {
            let mut simulation = awake();
            let mut insert = |desc| simulation.bodies.insert(desc).expect("usable body");
            match ground {
                0 => {
                    insert(floor(0.0));
                }
                1 => {
                    insert(fixed(
                        &cuboid(Vec3::new(400.0, 1.0, 4.0)),
                        -0.5 * Vec3::Y,
                        0.0,
                    ));
                }
                _ => {
                    let count = (110.0_f32.min(2.0 * speed + 4.0) / over) as i32;
                    let parts = (-4..count).map(|i| {
                        brick(
                            Vec3::new(over, 1.0, 4.0),
                            Vec3::new(over * (i as f32 + 0.37), -0.5, 0.0),
                        )
                    });
                    let desc = BodyDesc {
                        friction: Friction::new(0.0),
                        ..BodyDesc::new(
                            RigidBody::Static,
                            Shape::Compound(compound(parts.collect())),
                        )
                    };
                    insert(desc);
                }
            }
            let slab = insert(BodyDesc {
                pose: Pose::from_position(0.5 * size.y * Vec3::Y),
                linear_velocity: speed * Vec3::X,
                friction: Friction::new(0.0),
                ..BodyDesc::new(RigidBody::Dynamic, shape)
            });
            let mut off = 0.0_f32;
            for _ in 0..100 {
                simulation.step(H);
                let (v, w) = simulation.bodies.velocity(slab);
                let bobbing = (v.y.abs() - SAG * size.y / H).max(0.0);
                off = off.max((v.x - speed).abs().max(v.z.abs()).max(bobbing));
                off = off.max(0.3 * w.length() - 0.5 * SAG * size.y / H);
            }
            off / speed
        };
        let off = speed_at_end(Shape::Compound(tiles));
        let of_slab = speed_at_end(Shape::Convex(cuboid(size)));
        worst = worst.max(off);
        assert!(
            off < SPEED,
            "{seed}: {nx} x {nz} tiles at {speed} m/s, ground {ground}: off by {off:.1e}, one slab by {of_slab:.1e}"
        );
    }
    println!("slabs of tiles lose {worst:.1e} of their speed at most");
}

/// A step of a millimeter is there: a cube stops before it.
#[test]
fn an_edge_between_parts_that_is_there_stops_a_cube() {
    for speed in [0.05_f32, 0.2, 1.0] {
        let mut simulation = awake();
        let slab = Vec3::new(2.0, 0.5, 2.0);
        let steps = compound(vec![
            brick(slab, Vec3::new(0.0, -0.25, 0.0)),
            brick(slab, Vec3::new(2.0, -0.25 + 2e-3, 0.0)),
        ]);
        let mut insert = |desc| simulation.bodies.insert(desc).expect("usable body");
        insert(BodyDesc {
            friction: Friction::new(0.0),
            ..BodyDesc::new(RigidBody::Static, Shape::Compound(steps))
        });
        let cube = insert(BodyDesc {
            linear_velocity: speed * Vec3::X,
            friction: Friction::new(0.0),
            ..BodyDesc::dynamic(cuboid(Vec3::splat(0.4)), Vec3::new(0.5, 0.2, 0.0))
        });
        let mut last = f32::NEG_INFINITY;
        for _ in 0..(0.6 / speed / H) as usize {
            simulation.step(H);
            last = last.max(simulation.bodies.center_of_mass(cube).x + 0.2 - 1.0);
        }
        let climb = speed * speed / (2.0 * G) + 1e-3;
        assert!(last < climb, "{last} m beyond the edge at {speed} m/s");
    }
}
