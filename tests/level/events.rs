//! Bodies that touch in several places touch once: news of pairs with several contacts.

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use bevy_cleave::prelude::*;
use bevy_cleave::step::{ContactChange, ContactWatch};
use glam::Vec3;
use std::collections::BTreeMap;

/// s.
const H: f32 = 1.0 / 60.0;

/// Rough ground, 20 m by 20 m about the origin, or a floor of boxes side by side that is one body.
fn ground(kind: usize, dice: &mut Dice) -> BodyDesc {
    if kind == 0 {
        let heights: Vec<f32> = (0..41 * 41).map(|_| 0.4 * dice.unit()).collect();
        let level = StaticMesh::from_heights(&heights, 41, 0.5).expect("a level");
        let mut desc = BodyDesc::level(level);
        desc.pose.position = Vec3::new(-10.0, 0.0, -10.0);
        return desc;
    }
    let tile = ConvexMesh::cuboid(2.0, 0.5, 2.0).expect("a box");
    let parts = (0..100).map(|i| {
        let at = Vec3::new(
            2.0 * (i % 10) as f32 - 9.0,
            0.3 * dice.unit(),
            2.0 * (i / 10) as f32 - 9.0,
        );
        (Pose::from_position(at), tile.clone())
    });
    BodyDesc {
        kind: RigidBody::Static,
        ..BodyDesc::compound(Compound::new(parts).expect("usable"), Vec3::ZERO)
    }
}

fn shape(dice: &mut Dice) -> Shape {
    let leg = |x: f32, z: f32| {
        let leg = ConvexMesh::cuboid(0.1, 0.6, 0.1).expect("a box");
        (Pose::from_position(Vec3::new(x, -0.35, z)), leg)
    };
    match dice.below(4) {
        0 => Shape::Convex(bevy_cleave::cuboid!(0.9, 0.4, 0.6)),
        1 => Shape::Convex(bevy_cleave::sphere!(0.4)),
        2 => Shape::Convex(ConvexMesh::capsule(0.2, 0.8).expect("usable")),
        _ => {
            let top = ConvexMesh::cuboid(0.8, 0.1, 0.8).expect("a box");
            let mut parts = vec![(Pose::IDENTITY, top)];
            parts.extend(
                [-0.3, 0.3]
                    .into_iter()
                    .flat_map(|x| [leg(x, -0.3), leg(x, 0.3)]),
            );
            Shape::Compound(Compound::new(parts).expect("usable"))
        }
    }
}

#[test]
fn starts_and_ends_of_a_pair_come_in_turns_however_many_contacts_it_has() {
    let mut dice = Dice::new(5);
    let mut most = 0;
    for kind in [0, 1] {
        let mut simulation = awake();
        let floor = simulation
            .bodies
            .insert(ground(kind, &mut dice))
            .expect("usable");
        for i in 0..40 {
            let at = Vec3::new(2.0 * (i % 7) as f32 - 6.0, 2.0, 2.0 * (i / 7) as f32 - 6.0);
            let desc = BodyDesc {
                pose: Pose::new(at, dice.rotation()),
                linear_velocity: 4.0 * dice.direction(),
                angular_velocity: 3.0 * dice.direction(),
                ..BodyDesc::new(RigidBody::Dynamic, shape(&mut dice))
            };
            let slot = simulation.bodies.insert(desc).expect("usable");
            let watch = ContactWatch {
                touches: true,
                force: 1.0,
            };
            let Simulation {
                bodies, contacts, ..
            } = &mut simulation;
            contacts.events_mut().watch(bodies, slot, watch);
        }
        // By pair: whether it touches, as far as was told.
        let mut touching: BTreeMap<[u32; 2], bool> = BTreeMap::new();
        for _ in 0..400 {
            simulation.step(H);
            let mut forces: BTreeMap<[u32; 2], f32> = BTreeMap::new();
            for news in simulation.contacts.events().news() {
                let pair = news.bodies.map(|(slot, _)| slot);
                let state = touching.entry(pair).or_default();
                match news.change {
                    ContactChange::Start => assert!(!std::mem::replace(state, true), "{pair:?}"),
                    ContactChange::End => assert!(std::mem::replace(state, false), "{pair:?}"),
                    ContactChange::Force { .. } => {
                        assert!(*state);
                        assert!(
                            forces.insert(pair, news.impulse).is_none(),
                            "{pair:?} twice"
                        );
                    }
                }
            }
            // What is told is the whole of what the pair bears.
            let mut borne: BTreeMap<[u32; 2], (f32, usize)> = BTreeMap::new();
            for manifold in simulation.contacts.manifolds().iter() {
                let sum = borne.entry([manifold.a, manifold.b]).or_default();
                sum.0 += manifold
                    .points()
                    .iter()
                    .map(|p| p.total_impulse)
                    .sum::<f32>();
                sum.1 += 1;
            }
            for (pair, told) in forces {
                let (whole, count) = borne[&pair];
                assert!((told - whole).abs() <= 1e-4 * whole, "{told} of {whole}");
                most = most.max(count);
            }
        }
        assert!(touching.keys().any(|pair| pair.contains(&floor)));
    }
    assert!(most >= 3, "a pair of {most} contacts");
}
