//! Arrangements are kept as long as nothing that they rest on changes.

use crate::dice::Dice;
use crate::properties::cases;
use bevy_cleave::solver::arrangement::{Arrangement, Joint, Rule};
use bevy_cleave::solver::blocks::Place;
use bevy_cleave::solver::schedule::ContactOrder;
use proptest::prelude::*;
use std::ops::Range;

fn outcome(arrangement: &Arrangement) -> (Vec<Place>, Vec<Range<usize>>, Vec<usize>) {
    (
        arrangement.places().to_vec(),
        arrangement.stages().to_vec(),
        arrangement.points_of_blocks().collect(),
    )
}

fn random_joint(dice: &mut Dice, bodies: usize) -> Joint {
    let a = dice.below(bodies);
    let b = (a + 1 + dice.below(bodies - 1)) % bodies;
    let is_fixed = dice.below(8) == 0;
    Joint {
        bodies: [Some(a as u32), (!is_fixed).then_some(b as u32)],
        points: 1 + dice.below(4) as u32,
    }
}

fn random_rule(dice: &mut Dice, bodies: usize) -> Rule {
    let orders = [
        ContactOrder::Automatic,
        ContactOrder::Kept,
        ContactOrder::Coloured,
    ];
    Rule {
        order: orders[dice.below(3)],
        has_team: dice.below(2) == 0,
        bodies,
    }
}

proptest! {
    #![proptest_config(cases(200))]

    /// Steps in which nothing changes, one joint changes, joints come or go, or the rule changes.
    #[test]
    fn an_arrangement_that_is_used_again_is_the_one_made_anew(seed: u64) {
        let mut dice = Dice::new(seed);
        let bodies = 4 + dice.below(60);
        let count = dice.below(200);
        let mut joints: Vec<Joint> = (0..count).map(|_| random_joint(&mut dice, bodies)).collect();
        let mut rule = random_rule(&mut dice, bodies);
        let mut kept = Arrangement::default();
        for _ in 0..12 {
            kept.arrange(joints.iter().copied(), rule);
            let mut fresh = Arrangement::default();
            fresh.arrange(joints.iter().copied(), rule);
            prop_assert_eq!(outcome(&kept), outcome(&fresh));
            match dice.below(5) {
                0 => joints.push(random_joint(&mut dice, bodies)),
                1 => drop(joints.pop()),
                2 if !joints.is_empty() => {
                    let at = dice.below(joints.len());
                    joints[at] = random_joint(&mut dice, bodies);
                }
                3 => rule = random_rule(&mut dice, bodies),
                _ => {}
            }
        }
    }
}
