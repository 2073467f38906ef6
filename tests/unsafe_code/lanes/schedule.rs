//! Places of manifolds: what the order of a sweep rests on.

use crate::common::dice::Dice;
use crate::common::properties::cases;
use bevy_cleave::testing::graph::{Coloring, LaneSlot, OrderedPacking, Packer};
use bevy_cleave::testing::simd::WIDTH;
use proptest::prelude::*;

/// Two bodies, of which either may be one that contacts do not move, and a number of points.
type ContactEdge = ([Option<u32>; 2], u32);

fn place_all(
    mut filling: impl Packer,
    joints: &[ContactEdge],
    bodies: usize,
) -> (Vec<LaneSlot>, Vec<usize>) {
    filling.begin(bodies);
    for &(pair, count) in joints {
        filling.add(pair, count);
    }
    let places = filling.place().collect();
    let points = filling.points_of_blocks().iter();
    (places, points.map(|&count| usize::from(count)).collect())
}

fn in_order(joints: &[ContactEdge], bodies: usize) -> (Vec<LaneSlot>, Vec<usize>) {
    place_all(OrderedPacking::default(), joints, bodies)
}

fn by_color(joints: &[ContactEdge], bodies: usize) -> (Vec<LaneSlot>, Vec<usize>) {
    place_all(Coloring::default(), joints, bodies)
}

fn share_a_body(a: &ContactEdge, b: &ContactEdge) -> bool {
    a.0.iter().flatten().any(|body| b.0.contains(&Some(*body)))
}

fn check(joints: &[ContactEdge], bodies: usize) {
    check_places(joints, in_order(joints, bodies), |earlier, later| {
        earlier < later
    });
}

fn check_colors(joints: &[ContactEdge], bodies: usize) {
    check_places(joints, by_color(joints, bodies), |one, other| one != other);
}

/// `fit`: whether two joints that share a body may be in these blocks, that of the earlier joint first.
fn check_places(
    joints: &[ContactEdge],
    (places, points): (Vec<LaneSlot>, Vec<usize>),
    fit: impl Fn(u32, u32) -> bool,
) {
    check_blocks(&places, &points);
    for (i, (joint, place)) in joints.iter().zip(&places).enumerate() {
        assert_eq!(u32::from(place.count), joint.1);
        for (other, earlier) in joints[..i].iter().zip(&places) {
            assert!(
                !share_a_body(joint, other) || fit(earlier.block, place.block),
                "{other:?} comes before {joint:?}"
            );
        }
    }
}

/// The lanes of each block are the first ones, and its points those of its largest manifold.
fn check_blocks(places: &[LaneSlot], points: &[usize]) {
    for (block, &count) in points.iter().enumerate() {
        let held = || places.iter().filter(|place| place.block as usize == block);
        let mut lanes: Vec<u16> = held().map(|place| place.lane).collect();
        lanes.sort_unstable();
        assert!(lanes.iter().copied().eq(0..lanes.len() as u16), "{lanes:?}");
        assert!(lanes.len() <= WIDTH);
        assert_eq!(held().map(|place| place.count as usize).max(), Some(count));
    }
}

/// Joints of up to 40 bodies, of which every eighth is fixed.
fn joints() -> impl Strategy<Value = (Vec<ContactEdge>, usize)> {
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

    #[test]
    fn no_block_of_a_color_holds_a_movable_body_twice((joints, bodies) in joints()) {
        check_colors(&joints, bodies);
    }
}

#[test]
fn manifolds_of_a_color_share_blocks_with_those_of_as_many_points() {
    let points = [1, 2, 3, 4, 2, 1, 4, 3];
    let apart: Vec<ContactEdge> = (0..64)
        .map(|i| ([None, Some(i)], points[i as usize % 8]))
        .collect();
    assert_eq!(by_color(&apart, 64).1, [4, 4, 3, 3, 2, 2, 1, 1]);
}

#[test]
fn manifolds_that_find_no_color_get_blocks_of_their_own() {
    let star: Vec<ContactEdge> = (1..41).map(|i| ([Some(0), Some(i)], 1 + i % 4)).collect();
    check_colors(&star, 41);
    assert_eq!(by_color(&star, 41).1.len(), 40);
}

#[test]
fn chain_takes_a_block_for_each_link() {
    let chain: Vec<ContactEdge> = (0..20).map(|i| ([Some(i), Some(i + 1)], 4)).collect();
    check(&chain, 21);
    assert_eq!(in_order(&chain, 21).1.len(), 20);
}

#[test]
fn bodies_on_a_floor_fill_all_lanes() {
    let apart: Vec<ContactEdge> = (0..64).map(|i| ([None, Some(i)], 4)).collect();
    check(&apart, 64);
    assert_eq!(in_order(&apart, 64).1, vec![4; 64 / WIDTH]);
}

#[test]
fn same_joints_after_others_are_placed_as_if_there_had_been_none() {
    fn check(mut filling: impl Packer) {
        let mut dice = Dice::new(5);
        let mut places: Vec<Vec<LaneSlot>> = Vec::new();
        for _ in 0..3 {
            filling.begin(64);
            for i in 0..dice.below(50) as u32 {
                filling.add([Some(i), Some(i + 1)], 1);
            }
            drop(filling.place());
            filling.begin(10);
            for body in [0, 1, 0] {
                filling.add([Some(body), Some(body + 2)], 2);
            }
            places.push(filling.place().collect());
        }
        assert!(places.iter().all(|p| *p == places[0]), "{places:?}");
    }
    check(OrderedPacking::default());
    check(Coloring::default());
}

/// 500 bodies in no order with as many points as in a heap: the neighbors of a body are few enough to wait for.
#[test]
fn joints_of_a_heap_fill_their_lanes_in_their_order() {
    let mut dice = Dice::new(11);
    let points = [1, 1, 1, 1, 2, 2, 3, 4];
    let joints: Vec<ContactEdge> = (0..1500)
        .map(|_| {
            let a = dice.below(500);
            let b = (a + 1 + dice.below(499)) % 500;
            ([Some(a as u32), Some(b as u32)], points[dice.below(8)])
        })
        .collect();
    let (places, rows) = in_order(&joints, 500);
    check_blocks(&places, &rows);
    let used: u32 = joints.iter().map(|joint| joint.1).sum();
    let lanes = WIDTH * rows.iter().sum::<usize>();
    assert!(used as usize * 100 >= lanes * 93, "{used} of {lanes}");
}
