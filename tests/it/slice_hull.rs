//! The hull slicer over long chains, many generations, far away and beside its plain twin.

use crate::common::dice::Dice;
use crate::common::properties::cases;
use crate::hull_chain::{check_cut, check_part, cut_chain};
use crate::models::{MODELS, model_mesh};
use allocation_counter::measure;
use bevy_cleave::geometry::{ConvexHull, primitives};
use bevy_cleave::math::Plane;
use bevy_cleave::slice::{Cut, HullHalves, HullSlicer, SliceError, slice_hull};
use bevy_cleave::testing::predicates::length_scale;
use glam::Vec3;
use proptest::prelude::*;

fn middle(hull: &ConvexHull) -> Vec3 {
    hull.vertices().iter().sum::<Vec3>() / hull.vertices().len() as f32
}

fn size(hull: &ConvexHull) -> f64 {
    f64::from(length_scale(&hull.aabb()))
}

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn chains_of_cuts_are_right(bytes in prop::collection::vec(any::<u8>(), 0..500)) {
        cut_chain(&bytes);
    }
}

/// What the fuzzer and the property test have found worth keeping.
#[test]
fn kept_chains_of_cuts_are_right() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz/corpus/hull_cuts");
    let files = std::fs::read_dir(folder).unwrap();
    let cuts = files.map(|file| cut_chain(&std::fs::read(file.unwrap().path()).unwrap()));
    assert!(cuts.sum::<usize>() > 1000);
}

/// A plane of random direction through a random point, half way between the middle and a point of an edge or diagonal.
fn plane_inside(hull: &ConvexHull, dice: &mut Dice) -> Plane {
    let corners = hull.vertices();
    let [a, b] = [(); 2].map(|()| corners[dice.below(corners.len())]);
    let point = middle(hull).midpoint(a.lerp(b, dice.unit()));
    Plane::through(point, dice.direction())
}

/// All pieces of a body after so many cuts of each, by planes that `choose` chooses.
fn generations(
    hull: &ConvexHull,
    count: usize,
    seed: u64,
    choose: impl Fn(&ConvexHull, &mut Dice) -> Plane,
) -> Vec<ConvexHull> {
    let (mut dice, root) = (Dice::new(seed), size(hull));
    let (mut slicer, mut halves) = (HullSlicer::default(), HullHalves::copies_of(hull));
    let mut pieces = vec![hull.clone()];
    for _ in 0..count {
        let mut cut = Vec::with_capacity(2 * pieces.len());
        for piece in pieces {
            let plane = choose(&piece, &mut dice);
            if check_cut(&piece, plane, root, &mut slicer, &mut halves) {
                cut.extend([halves.below.clone(), halves.above.clone()]);
            } else {
                cut.push(piece);
            }
        }
        pieces = cut;
    }
    pieces
}

#[test]
fn twelve_generations_keep_the_volume_and_do_not_grow_triangles() {
    let cube = primitives::cuboid(1.0, 1.0, 1.0).unwrap();
    let pieces = generations(&cube, 12, 1, plane_inside);
    assert!(pieces.len() > 3900, "{}", pieces.len());
    let volume: f64 = pieces.iter().map(ConvexHull::volume).sum();
    assert!((volume - 1.0).abs() <= 1e-6, "{volume}");
    let triangles: usize = pieces.iter().map(|piece| piece.triangles().count()).sum();
    let mean = triangles as f64 / pieces.len() as f64;
    assert!(mean <= 14.0, "{mean}");
}

/// A way to choose the plane that cuts a piece.
type Choose<'a> = &'a dyn Fn(&ConvexHull, &mut Dice) -> Plane;

/// Three faces meet in a corner of a polyhedron at least, so `2 E >= 3 V`, and with Euler's formula its `2 E - 2 F` triangles
/// are at most `4 F - 12`. A point on an edge that was cut, or on the rim between two cuts in one plane, would add to them.
#[test]
fn pieces_have_no_corner_that_is_none_wherever_they_are_cut() {
    let middle_of =
        |piece: &ConvexHull, dice: &mut Dice| Plane::through(middle(piece), dice.direction());
    let anywhere = |piece: &ConvexHull, dice: &mut Dice| dice.plane_through(piece.vertices());
    let along_axes = |piece: &ConvexHull, dice: &mut Dice| {
        let axis = [Vec3::X, Vec3::Y, Vec3::Z][dice.below(3)];
        let corner = piece.vertices()[dice.below(piece.vertices().len())];
        Plane::through(middle(piece).lerp(corner, 0.5 * dice.unit()), axis)
    };
    let cube = primitives::cuboid(1.0, 1.0, 1.0).unwrap();
    let distributions: [Choose; 4] = [&plane_inside, &middle_of, &anywhere, &along_axes];
    for (seed, choose) in (10..).zip(distributions) {
        for piece in generations(&cube, 8, seed, choose) {
            let (faces, triangles) = (piece.faces().len(), piece.triangles().count());
            assert!(
                triangles <= 4 * faces - 12,
                "{triangles} triangles, {faces} faces"
            );
        }
    }
}

#[test]
fn scale_and_place_do_not_matter() {
    for (scale, place) in [
        (0.001, 0.0),
        (1000.0, 0.0),
        (1.0, 10_000.0),
        (1000.0, 10_000.0),
    ] {
        let hull = primitives::cuboid(scale, scale, scale).unwrap();
        let hull = hull.translated(Vec3::new(place, -0.3 * place, 0.7 * place));
        // What the rounding of coordinates leaves of the volume: at 10 km a metre is 1024 steps.
        let volume = hull.volume();
        let pieces = generations(&hull, 6, 2, plane_inside);
        let sum: f64 = pieces.iter().map(ConvexHull::volume).sum();
        let relative = 1e-6 * (size(&hull) / f64::from(hull.aabb().diagonal()));
        assert!(
            (sum / volume - 1.0).abs() <= relative,
            "{scale} {place}: {}",
            sum / volume - 1.0
        );
    }
}

#[test]
fn thousand_cuts_in_a_row_lose_nothing() {
    for (hull, seed) in [
        (primitives::cuboid(1.0, 1.0, 1.0).unwrap(), 3),
        (primitives::icosphere(1.0, 3).unwrap(), 4),
    ] {
        let (mut dice, root, volume) = (Dice::new(seed), size(&hull), hull.volume());
        let (mut slicer, mut halves) = (HullSlicer::default(), HullHalves::copies_of(&hull));
        let (mut rest, mut cut_off, mut cuts) = (hull, 0.0, 0);
        while cuts < 1000 {
            // A little of what is left: near a corner, across the line to the middle.
            let corner = rest.vertices()[dice.below(rest.vertices().len())];
            let inwards = middle(&rest) - corner;
            let direction = inwards.normalize() + 0.5 * dice.direction();
            let plane = Plane::through(corner + 0.01 * inwards, direction);
            if check_cut(&rest, plane, root, &mut slicer, &mut halves) {
                let (kept, lost) = if halves.below.volume() < halves.above.volume() {
                    (&mut halves.above, &halves.below)
                } else {
                    (&mut halves.below, &halves.above)
                };
                cut_off += lost.volume();
                std::mem::swap(&mut rest, kept);
            }
            cuts += 1;
        }
        check_part(&rest, root);
        let drift = (rest.volume() + cut_off) / volume - 1.0;
        assert!(drift.abs() <= 1e-6, "{drift}");
    }
}

#[test]
fn faces_keep_their_planes_and_parts_share_the_cut_bit_for_bit() {
    let bits = |p: Vec3| p.to_array().map(f32::to_bits);
    for name in MODELS {
        let hull = ConvexHull::from_points(model_mesh(name).positions()).unwrap();
        let mut dice = Dice::new(5);
        for _ in 0..50 {
            let plane = dice.plane_through(hull.vertices());
            let Some(halves) = slice_hull(&hull, plane).unwrap().halves() else {
                continue;
            };
            let [below, above] = [&halves.below, &halves.above].map(|part| {
                let (cap, old) = part.faces().split_last().unwrap();
                for face in old {
                    assert!(hull.faces().iter().any(|parent| parent.plane == face.plane));
                }
                let corners = part.face_loop(cap).iter();
                let mut corners: Vec<_> = corners
                    .map(|&v| bits(part.vertices()[v as usize]))
                    .collect();
                corners.sort_unstable();
                (cap.plane, corners)
            });
            assert_eq!(below.0, plane);
            assert_eq!(above.0, plane.flipped());
            assert_eq!(below.1, above.1);
        }
    }
}

#[test]
fn cutting_into_kept_memory_allocates_nothing() {
    let seen = measure(|| drop(std::hint::black_box(Vec::<u8>::with_capacity(1))));
    assert_eq!(seen.count_total, 1, "allocations are counted");
    let shapes = [
        primitives::cuboid(1.0, 1.0, 1.0),
        primitives::icosphere(1.0, 3),
    ];
    for hull in shapes.map(Result::unwrap) {
        let mut dice = Dice::new(6);
        let planes: Vec<Plane> = (0..200)
            .map(|_| dice.plane_through(hull.vertices()))
            .collect();
        let (mut slicer, mut halves) = (HullSlicer::default(), HullHalves::copies_of(&hull));
        let mut cuts = 0;
        let mut cut_all = || {
            for &plane in &planes {
                let verdict = slicer.slice_into(&hull, plane, &mut halves).unwrap();
                cuts += usize::from(verdict.is_cut());
            }
        };
        cut_all();
        let allocated = measure(cut_all);
        assert_eq!(allocated.count_total, 0, "{allocated:?}");
        assert!(cuts > 300);
    }
}

#[test]
fn what_is_not_cut_leaves_usable_hulls_behind() {
    let hull = primitives::cuboid(1.0, 1.0, 1.0).unwrap();
    let (mut slicer, mut halves) = (HullSlicer::default(), HullHalves::copies_of(&hull));
    let plane = |offset| Plane {
        normal: Vec3::Y,
        offset,
    };
    let verdict = |slicer: &mut HullSlicer, halves: &mut HullHalves, offset| {
        slicer.slice_into(&hull, plane(offset), halves)
    };
    assert_eq!(verdict(&mut slicer, &mut halves, 2.0), Ok(Cut::Below));
    assert_eq!(verdict(&mut slicer, &mut halves, -2.0), Ok(Cut::Above));
    assert!(matches!(
        verdict(&mut slicer, &mut halves, f32::NAN),
        Err(SliceError::Plane(_))
    ));
    assert_eq!(halves, HullHalves::copies_of(&hull));
    assert_eq!(verdict(&mut slicer, &mut halves, 0.0), Ok(Cut::Cut(())));
    let afresh = slice_hull(&hull, plane(0.0)).unwrap().halves().unwrap();
    assert_eq!(
        halves, afresh,
        "what was in the memory before does not matter"
    );
}
