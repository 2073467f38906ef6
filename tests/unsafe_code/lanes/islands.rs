//! Islands are kept as long as the same bodies touch at as many points.

use crate::common::dice::Dice;
use crate::common::properties::cases;
use bevy_cleave::contact::{MAX_POINTS, ManifoldHead};
use bevy_cleave::prelude::*;
use bevy_cleave::step;
use bevy_cleave::testing::graph::{BodyNumber, Island, Islands, ManifoldIndex};
use glam::Vec3;
use proptest::prelude::*;

const BODIES: u32 = 30;

/// Bodies in slots of their numbers; every fifth is fixed.
fn bodies() -> Bodies {
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
    let mut bodies = Bodies::default();
    for slot in 0..BODIES {
        let mut desc = BodyDesc::dynamic(cube.clone(), Vec3::X * slot as f32);
        if slot % 5 == 0 {
            desc.kind = RigidBody::Static;
        }
        assert_eq!(bodies.insert(desc), Ok(slot));
    }
    step::mass_properties(&mut bodies, &mut StepReport::default());
    bodies
}

fn manifold(dice: &mut Dice) -> ManifoldHead {
    let a = dice.below(BODIES as usize);
    let b = (a + 1 + dice.below(BODIES as usize - 1)) % BODIES as usize;
    ManifoldHead {
        a: a as u32,
        b: b as u32,
        count: 1 + dice.below(MAX_POINTS) as u32,
        ..ManifoldHead::default()
    }
}

type Outcome = (
    Vec<Island>,
    Vec<ManifoldIndex>,
    [Vec<u32>; 2],
    Vec<[BodyNumber; 2]>,
);

fn outcome(islands: &Islands) -> Outcome {
    let Islands {
        list,
        manifolds,
        pairs,
        counts,
        slots,
        ..
    } = islands;
    let numbers = [counts, slots].map(Vec::clone);
    (list.clone(), manifolds.clone(), numbers, pairs.clone())
}

proptest! {
    #![proptest_config(cases(100))]

    /// Steps in which nothing changes, a manifold changes, comes, goes or has other points, or bodies are left out.
    #[test]
    fn islands_that_are_used_again_are_those_found_anew(seed: u64) {
        let (mut dice, bodies) = (Dice::new(seed), bodies());
        let count = dice.below(40);
        let mut manifolds: Vec<ManifoldHead> = (0..count).map(|_| manifold(&mut dice)).collect();
        let mut left_out = BODIES;
        let mut kept = Islands::default();
        for _ in 0..12 {
            let is_open = |m: &ManifoldHead| m.a != left_out && m.b != left_out;
            kept.find(&manifolds, &bodies, is_open, None);
            let mut fresh = Islands::default();
            fresh.find(&manifolds, &bodies, is_open, None);
            prop_assert_eq!(outcome(&kept), outcome(&fresh));
            match dice.below(7) {
                0 => manifolds.push(manifold(&mut dice)),
                1 => drop(manifolds.pop()),
                2 if !manifolds.is_empty() => {
                    let at = dice.below(manifolds.len());
                    manifolds[at] = manifold(&mut dice);
                }
                3 => left_out = dice.below(BODIES as usize + 1) as u32,
                4 if !manifolds.is_empty() => {
                    let at = dice.below(manifolds.len());
                    manifolds[at].count = 1 + dice.below(MAX_POINTS) as u32;
                }
                _ => {}
            }
        }
    }
}
