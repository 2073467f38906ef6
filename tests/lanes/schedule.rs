//! Places of manifolds: what the order of a sweep rests on.

use crate::dice::Dice;
use crate::properties::cases;
use bevy_cleave::solver::blocks::Place;
use bevy_cleave::solver::lanes::WIDTH;
use bevy_cleave::solver::schedule::{Filling, Schedule};
use proptest::prelude::*;

/// Two bodies, of which either may be one that contacts do not move, and a number of points.
type Joint = ([Option<u32>; 2], u32);

fn place_all(joints: &[Joint], bodies: usize) -> (Vec<Place>, Vec<usize>) {
    let mut schedule = Schedule::default();
    schedule.begin(bodies, Filling::Densely);
    let places = joints.iter().map(|&(pair, n)| schedule.place(pair, n));
    let places = places.collect();
    (places, schedule.points_of_blocks().collect())
}

fn share_a_body(a: &Joint, b: &Joint) -> bool {
    a.0.iter().flatten().any(|body| b.0.contains(&Some(*body)))
}

/// The block of each joint by the definition: the first one behind all that hold an earlier joint of one of its bodies that
/// has a lane left.
fn blocks_by_definition(joints: &[Joint]) -> Vec<u32> {
    let (mut blocks, mut used) = (Vec::<u32>::new(), Vec::new());
    for (i, joint) in joints.iter().enumerate() {
        let earlier = joints[..i].iter().zip(&blocks);
        let shared = earlier.filter(|(other, _)| share_a_body(other, joint));
        let mut block = shared.map(|(_, block)| block + 1).max().unwrap_or(0) as usize;
        used.resize(used.len().max(block + 1), 0);
        while used.get(block) == Some(&WIDTH) {
            block += 1;
        }
        used.resize(used.len().max(block + 1), 0);
        used[block] += 1;
        blocks.push(block as u32);
    }
    blocks
}

fn check(joints: &[Joint], bodies: usize) {
    let (places, points) = place_all(joints, bodies);
    let blocks: Vec<u32> = places.iter().map(|place| place.block).collect();
    assert_eq!(blocks, blocks_by_definition(joints));
    for (i, (joint, place)) in joints.iter().zip(&places).enumerate() {
        assert_eq!(u32::from(place.count), joint.1);
        assert!(place.count as usize <= points[place.block as usize]);
        for (other, earlier) in joints[..i].iter().zip(&places) {
            assert!(
                !share_a_body(joint, other) || earlier.block < place.block,
                "{other:?} comes before {joint:?}"
            );
        }
    }
    for (block, &count) in points.iter().enumerate() {
        let held = || places.iter().filter(|place| place.block as usize == block);
        let lanes: Vec<u16> = held().map(|place| place.lane).collect();
        assert!(lanes.iter().copied().eq(0..lanes.len() as u16), "{lanes:?}");
        assert!(lanes.len() <= WIDTH);
        assert_eq!(held().map(|place| place.count as usize).max(), Some(count));
    }
}

/// Joints of up to 40 bodies, of which every eighth is fixed.
fn joints() -> impl Strategy<Value = (Vec<Joint>, usize)> {
    (2_u32..40).prop_flat_map(|bodies| {
        let joint = (0..bodies, 0..bodies, 1_u32..=4)
            .prop_filter("two bodies", |(a, b, _)| a != b)
            .prop_map(|(a, b, n)| ([a, b].map(|body| (body % 8 > 0).then_some(body)), n));
        let joints = proptest::collection::vec(joint, 0..120);
        (joints, Just(bodies as usize))
    })
}

proptest! {
    #![proptest_config(cases(48))]

    #[test]
    fn no_block_holds_a_movable_body_twice_and_manifolds_that_share_one_keep_their_order(
        (joints, bodies) in joints()
    ) {
        check(&joints, bodies);
    }
}

#[test]
fn chain_takes_a_block_for_each_link() {
    let chain: Vec<Joint> = (0..20).map(|i| ([Some(i), Some(i + 1)], 4)).collect();
    check(&chain, 21);
    assert_eq!(place_all(&chain, 21).1.len(), 20);
}

#[test]
fn bodies_on_a_floor_fill_all_lanes() {
    let apart: Vec<Joint> = (0..64).map(|i| ([None, Some(i)], 4)).collect();
    check(&apart, 64);
    assert_eq!(place_all(&apart, 64).1, vec![4; 64 / WIDTH]);
}

#[test]
fn same_joints_after_others_are_placed_as_if_there_had_been_none() {
    let mut dice = Dice::new(5);
    let mut schedule = Schedule::default();
    let mut places = Vec::new();
    for _ in 0..3 {
        let other = (0..dice.below(50) as u32).map(|i| [Some(i), Some(i + 1)]);
        schedule.begin(64, Filling::Densely);
        for pair in other {
            schedule.place(pair, 1);
        }
        schedule.begin(10, Filling::Densely);
        places.push([0, 1, 0].map(|body| schedule.place([Some(body), Some(body + 2)], 2)));
    }
    assert!(places.iter().all(|p| *p == places[0]), "{places:?}");
}
