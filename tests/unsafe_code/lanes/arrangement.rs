//! Arrangements are kept as long as nothing that they rest on changes, and subdomains that are solved side by side share no body.

use crate::common::dice::Dice;
use crate::common::properties::cases;
use bevy_cleave::testing::graph::{
    AssignmentRule, BodyNumber, ContactEdge, ContactOrder, LaneAssignment, LaneSlot, Partition,
    leaves, stages,
};
use glam::Vec3;
use proptest::prelude::*;
use std::ops::Range;

fn outcome(arrangement: &LaneAssignment) -> (Vec<LaneSlot>, Vec<Range<usize>>, Vec<u16>) {
    (
        arrangement.places().to_vec(),
        arrangement.subdomains().collect(),
        arrangement.points_of_blocks().to_vec(),
    )
}

/// A joint and its domain.
type Sorted = (u32, ContactEdge);

fn arrange(arrangement: &mut LaneAssignment, joints: &[Sorted], rule: AssignmentRule) {
    let subdomains = joints.iter().map(|(domain, _)| *domain);
    arrangement.arrange(subdomains, |at| joints[at].1, rule, None);
}

fn random_joint(dice: &mut Dice, bodies: usize) -> Sorted {
    let a = dice.below(bodies);
    let b = (a + 1 + dice.below(bodies - 1)) % bodies;
    let is_fixed = dice.below(8) == 0;
    let joint = ContactEdge {
        bodies: [Some(a as u32), (!is_fixed).then_some(b as u32)],
        points: 1 + dice.below(4) as u32,
    };
    (dice.below(3) as u32, joint)
}

fn random_rule(dice: &mut Dice, bodies: usize) -> AssignmentRule {
    let orders = [
        ContactOrder::Automatic,
        ContactOrder::Ordered,
        ContactOrder::Colored,
    ];
    AssignmentRule {
        order: orders[dice.below(3)],
        bodies,
        subdomains: 3 + dice.below(2),
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
        let mut joints: Vec<Sorted> = (0..count).map(|_| random_joint(&mut dice, bodies)).collect();
        let mut rule = random_rule(&mut dice, bodies);
        let mut kept = LaneAssignment::default();
        for _ in 0..12 {
            arrange(&mut kept, &joints, rule);
            let mut fresh = LaneAssignment::default();
            arrange(&mut fresh, &joints, rule);
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

    /// What different threads may solve at a time: no two manifolds in different subdomains of a stage share a body that moves.
    /// Within a domain manifolds stay in their order, if that is asked for.
    #[test]
    fn domains_of_a_stage_share_no_body_and_keep_their_order(seed: u64) {
        let mut dice = Dice::new(seed);
        let bodies = 4 + dice.below(60);
        let is_fixed = |body: usize| body.is_multiple_of(7);
        let center = |body: usize| (!is_fixed(body)).then(|| dice.vector(-5.0, 5.0));
        let centers: Vec<Option<Vec3>> = (0..bodies).map(center).collect();
        let leaves = [1, 2, 4, 8][dice.below(4)];
        let mut cuts = Partition::default();
        cuts.cut(centers.len(), |i| centers[i], dice.vector(-1.0, 1.0), leaves, None);
        let joint = |_| {
            let a = dice.below(bodies);
            let pair = [a, (a + 1 + dice.below(bodies - 1)) % bodies].map(|body| body as u32);
            let movable = |body: u32| (!is_fixed(body as usize)).then_some(body);
            let joint = ContactEdge { bodies: pair.map(movable), points: 1 + dice.below(4) as u32 };
            (joint.bodies != [None; 2]).then(|| (cuts.of(pair.map(BodyNumber)), joint))
        };
        let joints: Vec<Sorted> = (0..200).filter_map(joint).collect();
        let order = [ContactOrder::Ordered, ContactOrder::Colored][dice.below(2)];
        let mut arrangement = LaneAssignment::default();
        let subdomains = cuts.count();
        arrange(&mut arrangement, &joints, AssignmentRule { order, bodies, subdomains });
        let (places, ranges, points) = outcome(&arrangement);
        prop_assert_eq!(ranges.len(), subdomains);
        prop_assert_eq!(ranges.iter().map(Range::len).sum::<usize>(), points.len());
        let first_of_stage = |domain: u32| {
            let ends = stages(subdomains).scan(0, |end, count| {
                *end += count;
                Some(*end)
            });
            ends.take_while(|&end| end <= domain as usize).count()
        };
        for (i, ((domain, joint), place)) in joints.iter().zip(&places).enumerate() {
            prop_assert!(ranges[*domain as usize].contains(&(place.block as usize)));
            for ((other_domain, other), earlier) in joints[..i].iter().zip(&places) {
                let mut movable = other.bodies.iter().flatten();
                if !movable.any(|body| joint.bodies.contains(&Some(*body))) {
                    continue;
                }
                let is_same = domain == other_domain;
                prop_assert!(is_same || first_of_stage(*domain) != first_of_stage(*other_domain));
                prop_assert!(earlier.block != place.block);
                let keeps_order = order == ContactOrder::Ordered && is_same;
                prop_assert!(!keeps_order || earlier.block < place.block);
            }
        }
    }
}

#[test]
fn leaves_of_a_cloud_are_of_a_size_and_separators_small() {
    let mut dice = Dice::new(9);
    let side = 16;
    let at = |i: usize| {
        Vec3::new(
            (i % side) as f32,
            (i / side % side) as f32,
            (i / 256) as f32,
        )
    };
    let mut jitter = |i: usize| at(i) + 0.2 * dice.vector(-1.0, 1.0);
    let centers: Vec<Option<Vec3>> = (0..side * side * side).map(|i| Some(jitter(i))).collect();
    let mut cuts = Partition::default();
    cuts.cut(centers.len(), |i| centers[i], Vec3::NEG_Y, 4, None);
    let mut sizes = [0; 7];
    for i in 0..centers.len() as u32 {
        sizes[cuts.of([BodyNumber(i); 2]) as usize] += 1;
        // The neighbors along x, y and z: the manifolds of a grid.
        for step in [1, 16, 256] {
            if (i / step) % 16 < 15 {
                let domain = cuts.of([i, i + step].map(BodyNumber)) as usize;
                sizes[domain] += usize::from(domain > 3);
            }
        }
    }
    assert!(
        sizes[..4].iter().all(|leaf| (900..1150).contains(leaf)),
        "{sizes:?}"
    );
    // A cut through the whole grid crosses 256 of 11 520 edges, those of its halves 128 each; jitter makes the cuts uneven.
    assert!(
        sizes[4..].iter().all(|&separator| separator < 400),
        "{sizes:?}"
    );
    let sizes = [1, 3999, 4000, 9000, 31_999, 32_000, 1 << 20];
    assert_eq!(sizes.map(leaves), [1, 1, 2, 4, 8, 16, 16]);
}
