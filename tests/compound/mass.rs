//! Mass, center and inertia are those of the parts together, and what makes no compound is named.

use crate::common::dice::Dice;
use crate::common::structures::cuboid;
use crate::shapes::{brick, compound, dumbbell, table};
use bevy_cleave::geometry::MAX_PARTS;
use bevy_cleave::mass::VolumeIntegrals;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// A box cut into boxes by planes at random places.
fn divided(dice: &mut Dice, size: Vec3) -> Vec<(Pose, ConvexMesh)> {
    let cuts = |dice: &mut Dice, length: f32| {
        let count = dice.below(4);
        let mut at: Vec<f32> = (0..count)
            .map(|_| length * dice.in_range(-0.45, 0.45))
            .collect();
        at.extend([-0.5 * length, 0.5 * length]);
        at.sort_by(f32::total_cmp);
        at.dedup_by(|a, b| *a - *b < 0.01 * length);
        at
    };
    let [x, y, z] = size.to_array().map(|length| cuts(dice, length));
    let mut parts = Vec::new();
    for x in x.windows(2) {
        for y in y.windows(2) {
            for z in z.windows(2) {
                let (min, max) = (Vec3::new(x[0], y[0], z[0]), Vec3::new(x[1], y[1], z[1]));
                parts.push(brick(max - min, 0.5 * (min + max)));
            }
        }
    }
    parts
}

#[test]
fn a_box_in_parts_weighs_what_the_box_weighs() {
    for seed in 0..60 {
        let dice = &mut Dice::new(seed);
        let size = dice.vector(0.2, 2.0);
        let place = Pose::new(dice.vector(-3.0, 3.0), dice.rotation());
        let parts = divided(dice, size)
            .into_iter()
            // Each box turned about its own axes, or not: the pose takes back what the shape was turned by.
            .map(|(pose, shape)| (place * pose, shape));
        let whole = VolumeIntegrals::of_hull(cuboid(size).hull());
        let sum = VolumeIntegrals::of_compound(&Compound::new(parts).expect("usable"));
        let center = place.transform_point(whole.centroid.as_vec3());
        let apart = sum.centroid.as_vec3().distance(center);
        assert!((sum.volume / whole.volume - 1.0).abs() < 1e-6, "{seed}");
        assert!(apart < 1e-6 * (3.0 + size.length()), "{seed}: {apart}");
        let [of_sum, of_whole] = [&sum, &whole].map(|integrals| {
            let mass = MassProperties::from_integrals(integrals, 1000.0);
            mass.expect("a solid").principal
        });
        let off = (of_sum / of_whole - 1.0).abs().max_element();
        assert!(off < 1e-5, "{seed}: {off}");
    }
}

#[test]
fn a_tee_has_the_center_and_the_moments_of_its_two_bars() {
    // A bar of 4 x 1 x 1 lies on one of 1 x 3 x 1: 4 and 3 m3, middles 2 m apart.
    let tee = compound(vec![
        brick(Vec3::new(4.0, 1.0, 1.0), 3.5 * Vec3::Y),
        brick(Vec3::new(1.0, 3.0, 1.0), 1.5 * Vec3::Y),
    ]);
    let mass = MassProperties::of_compound(&tee, 2.0).expect("a solid");
    assert!((mass.mass - 14.0).abs() < 1e-5);
    let center = Vec3::new(0.0, (4.0 * 3.5 + 3.0 * 1.5) / 7.0, 0.0);
    assert!(mass.center.distance(center) < 1e-6);
    // About the common center: 4 (2 * 3/7)^2 + 3 (2 * 4/7)^2 = 48/7 m5 for axes across the way between the middles.
    let apart = 48.0 / 7.0;
    let about = [
        4.0 * 2.0 / 12.0 + 3.0 * 10.0 / 12.0 + apart,
        4.0 * 17.0 / 12.0 + 3.0 * 2.0 / 12.0,
        4.0 * 17.0 / 12.0 + 3.0 * 10.0 / 12.0 + apart,
    ];
    let inertia = mass.inertia();
    for (axis, expected) in about.into_iter().enumerate() {
        let found = inertia.col(axis)[axis];
        assert!((found - 2.0 * expected).abs() < 1e-4, "{found} {expected}");
    }
}

#[test]
fn round_parts_weigh_what_they_are_and_overlaps_count_for_each() {
    let pi = std::f64::consts::PI;
    let (ball, bar) = (0.15_f64, 0.05_f64);
    let expected = 2.0 * 4.0 / 3.0 * pi * ball * ball * ball + pi * bar * bar * 0.6;
    let sum = VolumeIntegrals::of_compound(&dumbbell());
    assert!((sum.volume / expected - 1.0).abs() < 1e-6);
    assert!(sum.centroid.length() < 1e-7);
}

#[test]
fn a_scaled_compound_is_scaled_part_by_part() {
    let even = table().scaled(Vec3::splat(2.0)).expect("usable");
    let [one, eight] = [&table(), &even].map(|c| VolumeIntegrals::of_compound(c).volume);
    assert!((eight / one - 8.0).abs() < 1e-5);
    let turn = Quat::from_xyzw(0.1, 0.3, 0.2, 0.9).normalize();
    let turned = Compound::new([
        (Pose::new(Vec3::X, turn), cuboid(Vec3::ONE)),
        (
            Pose::new(-Vec3::X, turn),
            ConvexMesh::sphere(0.5).expect("valid"),
        ),
    ]);
    let turned = turned.expect("usable");
    let uneven = turned.scaled(Vec3::new(1.0, 2.0, 3.0)).expect("usable");
    let volume = VolumeIntegrals::of_hull(uneven.parts()[0].shape.hull()).volume;
    assert!((volume - 6.0).abs() < 1e-4, "{volume}");
    assert!(!uneven.parts()[1].shape.is_round());
    for factor in [Vec3::ZERO, Vec3::NAN, Vec3::new(1.0, -1.0, 1.0)] {
        let refused = turned.scaled(factor).expect_err("no scale");
        assert!(matches!(refused, CompoundError::Part { part: 0, .. }));
    }
}

#[test]
fn what_makes_no_compound_is_named() {
    let none: [(Pose, ConvexMesh); 0] = [];
    assert_eq!(
        Compound::new(none).expect_err("empty"),
        CompoundError::Empty
    );
    let cube = cuboid(Vec3::ONE);
    let with = |pose: Pose| Compound::new([(Pose::IDENTITY, cube.clone()), (pose, cube.clone())]);
    let far = with(Pose::from_position(Vec3::new(f32::NAN, 0.0, 0.0)));
    assert_eq!(far.expect_err("NaN"), CompoundError::NotFinite { part: 1 });
    let long = with(Pose::new(Vec3::X, Quat::from_xyzw(0.0, 0.0, 0.0, 2.0)));
    let expected = CompoundError::NotUnitRotation {
        part: 1,
        length: 2.0,
    };
    assert_eq!(long.expect_err("no rotation"), expected);
    let count = MAX_PARTS + 1;
    let many = Compound::new(std::iter::repeat_n(cube, count));
    assert_eq!(
        many.expect_err("too many"),
        CompoundError::TooMany { count }
    );
}
