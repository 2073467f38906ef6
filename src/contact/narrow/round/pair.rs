//! Two shapes of which one is round, and a round shape over a half-space.

use crate::contact::local_manifold::{LocalManifold, LocalPoint};
use crate::contact::narrow::round::axis::SolidPair;
use crate::contact::narrow::round::patch::{PatchRule, RoundScratch, keep_near, patch_along};
use crate::contact::narrow::round::solid::Solid;
use crate::contact::narrow::scratch::SatResult;
use crate::geometry::ConvexMesh;
use crate::math::{Plane, Pose, rotate};
use glam::Vec3;

/// Contact of `a` with `b`, whose pose in A's frame is `b_in_a`; in A's frame, normal from A to B. They touch if they are not
/// farther apart than `reach` (m).
pub(crate) fn examine_round(
    [a, b]: [&ConvexMesh; 2],
    b_in_a: Pose,
    reach: f32,
    scratch: &mut RoundScratch,
) -> SatResult {
    if !b_in_a.is_finite() || !reach.is_finite() {
        return SatResult::Touching(LocalManifold::default());
    }
    let pair = SolidPair {
        a: Solid::of(a),
        b: Solid::of(b),
        b_in_a,
    };
    let axis = pair.axis(f64::from(reach));
    if axis.separation > f64::from(reach) {
        return SatResult::Separated {
            axis: axis.normal,
            distance: axis.separation as f32,
        };
    }
    let size = a.aabb().diagonal().min(b.aabb().diagonal());
    let rule = PatchRule::new(reach, size);
    SatResult::Touching(patch_along(&pair, &axis, rule, scratch))
}

/// Distance of two shapes along a unit vector from A to B (A's frame), m.
pub(crate) fn round_distance_along([a, b]: [&ConvexMesh; 2], b_in_a: Pose, axis: Vec3) -> f32 {
    let pair = SolidPair {
        a: Solid::of(a),
        b: Solid::of(b),
        b_in_a,
    };
    pair.separation(axis) as f32
}

/// Contact of a round shape (A) with everything below a plane, which is given in its frame; `b_in_a` is the frame of the half-space.
pub(crate) fn examine_round_half_space(
    mesh: &ConvexMesh,
    plane: Plane,
    b_in_a: Pose,
    reach: f32,
    scratch: &mut RoundScratch,
) -> SatResult {
    let mut patch = LocalManifold {
        normal: -plane.normal,
        normal_in_b: Some(-rotate(b_in_a.rotation.inverse(), plane.normal)),
        ..LocalManifold::default()
    };
    if !b_in_a.is_finite() || !reach.is_finite() {
        return SatResult::Touching(patch);
    }
    let solid = Solid::of(mesh);
    let down = -plane.normal;
    let deepest = solid.support(down.as_dvec3()).as_vec3();
    let distance = plane.distance(deepest);
    if distance > reach {
        return SatResult::Separated {
            axis: down,
            distance,
        };
    }
    solid.feature(down, &mut scratch.places);
    let rule = PatchRule::new(reach, mesh.aabb().diagonal());
    keep_near(plane.normal, plane.offset + solid.radius, rule, scratch);
    let is_one = scratch.places.len() == 1;
    for place in &scratch.places {
        let on_a = place.at + solid.radius * down;
        let separation = plane.distance(on_a);
        let curvature = if is_one {
            solid.curvature(down, place.at)
        } else {
            place.curvature
        };
        patch.push(LocalPoint {
            on_a,
            on_b: b_in_a.inverse_transform_point(on_a + separation * down),
            separation,
            share_b: 0.0,
            along: Vec3::ZERO,
            radii: [curvature, 0.0],
        });
    }
    SatResult::Touching(patch)
}

#[cfg(test)]
mod tests {
    use super::examine_round;
    use crate::contact::narrow::round::axis::SolidPair;
    use crate::contact::narrow::round::patch::RoundScratch;
    use crate::contact::narrow::round::solid::Solid;
    use crate::contact::narrow::sat::tests::{signed, vector};
    use crate::contact::narrow::scratch::SatResult;
    use crate::geometry::ConvexMesh;
    use crate::geometry::distance::{Separation, distance};
    use crate::geometry::support::{Core, PlacedCore};
    use crate::math::Pose;
    use glam::{Quat, Vec3};
    use rand_core::Rng;
    use rand_pcg::Pcg32;

    fn any_shape(random: &mut Pcg32) -> ConvexMesh {
        let [a, b] = [(); 2].map(|()| 0.3 + 0.2 * signed(random));
        let cuboid = || ConvexMesh::cuboid(a, b, 0.4);
        match random.next_u32() % 7 {
            0 => ConvexMesh::sphere(a),
            1 => ConvexMesh::capsule(a, b),
            2 => ConvexMesh::cylinder(a, b),
            3 => ConvexMesh::cone(a, b),
            4 => cuboid().and_then(|cuboid| cuboid.rounded(0.3 * a)),
            5 => ConvexMesh::icosphere(a, 1),
            _ => cuboid(),
        }
        .expect("usable sizes")
    }

    /// How far a point is outside of a shape, m; zero inside.
    fn how_far(solid: &Solid, at: Vec3) -> f64 {
        let point = PlacedCore::new(Core::of_point(at), &Pose::IDENTITY);
        match distance(&solid.core(), &point, f64::INFINITY) {
            Separation::Near(near) => (near.distance - f64::from(solid.radius)).max(0.0),
            _ => 0.0,
        }
    }

    #[test]
    fn no_direction_parts_a_pair_better_than_the_one_that_is_found() {
        let (mut random, mut scratch) = (Pcg32::new(3, 1), RoundScratch::default());
        let mut counts = [0; 2];
        for _ in 0..6000 {
            let [a, b] = [(); 2].map(|()| any_shape(&mut random));
            if !a.is_round() && !b.is_round() {
                continue;
            }
            let turn = Quat::from_vec4(vector(&mut random).extend(signed(&mut random)));
            let pose = Pose::new(0.9 * vector(&mut random), turn.normalize());
            let pair = SolidPair {
                a: Solid::of(&a),
                b: Solid::of(&b),
                b_in_a: pose,
            };
            let SatResult::Touching(patch) = examine_round([&a, &b], pose, 10.0, &mut scratch)
            else {
                panic!("nothing is ten metres away");
            };
            let found = pair.separation(patch.normal);
            // Of directions the gap of what is apart is concave: what is best among its neighbors is best of all. Of what overlaps there may be
            // better ones farther off.
            let scales = if found < -0.02 {
                &[0.1, 0.03, 0.01][..]
            } else {
                &[1.0, 0.3, 0.1, 0.03, 0.01]
            };
            for scale in scales {
                for _ in 0..8 {
                    let other = (patch.normal + scale * vector(&mut random)).normalize();
                    let gap = pair.separation(other);
                    // A rim is taken for rounder than it is, and directions near that of a face for it: shapes are half a metre large.
                    let spare = 5e-4 + 0.1 * found.max(0.0) + 0.02 * (-found).max(0.0);
                    assert!(gap < found + spare, "{found} {gap}");
                }
            }
            // Of what is farther apart than contacts are made for, places may be any on a line.
            for point in patch.points().iter().filter(|_| found < 0.01) {
                let [a, b] = [(pair.a, point.on_a), (pair.b, point.on_b)]
                    .map(|(solid, at)| how_far(&solid, at));
                assert!(a.max(b) < 1e-2, "{a} {b} {found}");
            }
            counts[usize::from(found < 0.0)] += 1;
            assert!(patch.count > 0);
            let deepest = patch.points().iter().map(|point| point.separation);
            let deepest = deepest.fold(f32::INFINITY, f32::min);
            // Of what is farther away than contacts are made for, the deepest point may be cut off.
            let off = (f64::from(deepest) - found).abs();
            assert!(found.abs() > 0.01 || off < 5e-3, "{deepest} {found}");
            for point in patch.points() {
                let on_b = pose.transform_point(point.on_b);
                let gap = patch.normal.dot(on_b - point.on_a);
                assert!((gap - point.separation).abs() < 1e-5);
            }
        }
        assert!(counts.iter().all(|&count| count > 100), "{counts:?}");
    }

    #[test]
    fn a_pair_seen_from_the_other_side_touches_at_the_same_places() {
        let (mut random, mut scratch) = (Pcg32::new(4, 1), RoundScratch::default());
        for _ in 0..3000 {
            let [a, b] = [(); 2].map(|()| any_shape(&mut random));
            if !a.is_round() && !b.is_round() {
                continue;
            }
            let turn = Quat::from_vec4(vector(&mut random).extend(signed(&mut random)));
            let pose = Pose::new(0.9 * vector(&mut random), turn.normalize());
            let seen = |pair, pose, scratch: &mut _| match examine_round(pair, pose, 0.05, scratch)
            {
                SatResult::Touching(patch) => Some(patch),
                SatResult::Separated { .. } => None,
            };
            let one = seen([&a, &b], pose, &mut scratch);
            let other = seen([&b, &a], pose.inverse(), &mut scratch);
            let (Some(one), Some(other)) = (one, other) else {
                assert!(one.is_none() == other.is_none());
                continue;
            };
            let other = other.swapped(&pose.inverse());
            let deepest = |patch: &crate::contact::local_manifold::LocalManifold| {
                let gaps = patch.points().iter().map(|point| point.separation);
                gaps.fold(f32::INFINITY, f32::min)
            };
            if deepest(&one) > -0.02 {
                assert!(
                    (deepest(&one) - deepest(&other)).abs() < 2e-3,
                    "{one:?} {other:?}"
                );
            }
        }
    }
}
