//! Where two convex hulls touch: separating-axis test over faces and edges.
//!
//! Everything happens in A's frame with B's pose relative to A, so results do not depend on where in the world the
//! pair is; all tolerances are relative to the size of the smaller hull.
//!
//! # References
//! D. Gregorius, "The Separating Axis Test between Convex Polyhedra", GDC 2013: face queries, and edge queries pruned
//! on the Gauss map. Verifying each edge axis by its supports, and leaving out the edges that the best faces rule out,
//! are ours.

use crate::contact::narrow::scratch::FaceAxis;
use crate::contact::narrow::scratch::HullPair;
use crate::contact::narrow::scratch::MERGE;
use crate::contact::narrow::scratch::NarrowScratch;
use crate::contact::narrow::scratch::SatCache;
use crate::contact::narrow::scratch::SatResult;

use crate::contact::local_manifold::LocalManifold;
use crate::contact::narrow::clipping::{Clipping, edge_patch};
use crate::contact::narrow::edge_search::{EdgeAxis, best_edge_pair};
use crate::contact::narrow::leaning::leaning_patch;
use crate::geometry::ConvexHull;
use crate::geometry::hull_lanes::{LANES, Points4, lowest, lowest_height, point};
use crate::math::Pose;
use glam::{Mat3, Vec3};

/// A face is preferred over an edge pair, and the first face over the second, unless the other separates better by
/// this share of the smaller hull's diagonal.
///
/// Larger values make the kind of contact steadier from step to step and the separation less exact (0.5 mm for 1 m).
const PREFER_ABSOLUTE: f32 = 5e-4;

/// The same as a share of the separation itself, for deep overlaps.
const PREFER_RELATIVE: f32 = 0.02;

/// Contact of hull `a` with hull `b`, whose pose in A's frame is `b_in_a`; in A's frame, normal from A to B.
///
/// `None` if the hulls are farther apart than `margin` (m), or if an argument is not finite. The separation is the
/// largest over all axes of the separating-axis test, less at most a preference for faces of 0.05 % of the smaller
/// hull's diagonal; for hulls that overlap, minus the least translation that parts them.
pub fn collide_hulls(
    a: &ConvexHull,
    b: &ConvexHull,
    b_in_a: Pose,
    margin: f32,
    scratch: &mut NarrowScratch,
) -> Option<LocalManifold> {
    match examine_hulls(a, b, b_in_a, margin, SatCache::NONE, scratch) {
        SatResult::Touching(patch) if patch.count > 0 => Some(patch),
        _ => None,
    }
}

/// As [`collide_hulls`], which it does the work of, and says by which axis hulls are apart. `scratch.beside` is what bears besides, if four
/// points are not enough.
pub(crate) fn examine_hulls(
    a: &ConvexHull,
    b: &ConvexHull,
    b_in_a: Pose,
    margin: f32,
    hint: SatCache,
    scratch: &mut NarrowScratch,
) -> SatResult {
    scratch.beside = None;
    if !b_in_a.is_finite() || !margin.is_finite() {
        return SatResult::Touching(LocalManifold::default());
    }
    // The line through the middles of the two boxes separates most pairs that do not touch.
    let middles = b_in_a.transform_point(b.aabb().center()) - a.aabb().center();
    if let Some(axis) = middles.try_normalize() {
        let distance = distance_along(a, b, &b_in_a, axis);
        if distance > margin {
            return SatResult::Separated { axis, distance };
        }
    }
    scratch.load(a, b, &b_in_a);
    match SatAxes::find(a, b, middles, margin, hint, scratch) {
        Err(apart) => apart,
        Ok(None) => SatResult::Touching(LocalManifold::default()),
        Ok(Some(axes)) => {
            let pair = HullPair {
                a,
                b,
                b_in_a: &b_in_a,
                margin,
            };
            axes.choose(pair, hint, scratch)
        }
    }
}

/// Distance of two hulls along a unit vector from A to B (A's frame), m.
pub(crate) fn distance_along(a: &ConvexHull, b: &ConvexHull, b_in_a: &Pose, axis: Vec3) -> f32 {
    let axis_in_b = Mat3::from_quat(b_in_a.rotation).transpose() * axis;
    lowest_height(&b.lanes.points, axis_in_b)
        + axis.dot(b_in_a.position)
        + lowest_height(&a.lanes.points, -axis)
}

/// The best faces of a pair that no face separates by more than the margin.
#[derive(Debug)]
struct SatAxes {
    face_a: FaceAxis,
    face_b: FaceAxis,
}

impl SatAxes {
    /// `Err` if a face separates the hulls, `None` if nothing is comparable. `middles` points from A's middle to B's.
    #[allow(
        clippy::result_large_err,
        reason = "what it holds is the answer, and goes up one call"
    )]
    fn find(
        a: &ConvexHull,
        b: &ConvexHull,
        middles: Vec3,
        margin: f32,
        hint: SatCache,
        scratch: &mut NarrowScratch,
    ) -> Result<Option<Self>, SatResult> {
        let [first_a, first_b] = hint.faces.map_or([None; 2], |faces| faces.map(Some));
        let face_a = best_face(a, &scratch.b_in_a, middles, first_a);
        let apart = |axis: Vec3, face: &FaceAxis| SatResult::Separated {
            axis,
            distance: face.separation,
        };
        if face_a.separation > margin {
            return Err(apart(face_a.plane.normal, &face_a));
        }
        let back = -(scratch.turn.transpose() * middles);
        let face_b = best_face(b, &scratch.a_in_b, back, first_b);
        if face_b.separation > margin {
            return Err(apart(-(scratch.turn * face_b.plane.normal), &face_b));
        }
        scratch.best_faces = [face_a.face as u32, face_b.face as u32];
        let comparable = face_a.separation.is_finite() && face_b.separation.is_finite();
        Ok(comparable.then_some(Self { face_a, face_b }))
    }

    /// Whether B has the reference face, for hulls whose diagonals are these, m.
    #[inline(always)]
    fn b_refers(&self, [extent_a, extent_b]: [f32; 2], slack: impl Fn(f32) -> f32) -> bool {
        let [of_a, of_b] = [self.face_a.separation, self.face_b.separation];
        // On a tie the larger hull offers the reference face, so that the points sit on the smaller one's corners.
        let b_is_larger = extent_b > extent_a * (1.0 + PREFER_RELATIVE);
        if b_is_larger {
            of_b >= of_a - slack(of_a)
        } else {
            of_b > of_a + slack(of_a)
        }
    }

    /// Weighs the faces against each other and against the edges, and makes the contact.
    fn choose(&self, pair: HullPair<'_>, hint: SatCache, scratch: &mut NarrowScratch) -> SatResult {
        let (Self { face_a, face_b }, HullPair { a, b, margin, .. }) = (self, pair);
        let extents = [a, b].map(|hull| hull.aabb().diagonal());
        let size = extents[0].min(extents[1]);
        let slack = |separation: f32| PREFER_ABSOLUTE * size + PREFER_RELATIVE * separation.abs();
        let b_refers = self.b_refers(extents, slack);
        let face = if b_refers { face_b } else { face_a };

        // Edges matter if they separate by more than this. No axis separates by more than the distance of the hulls.
        let bar = face.separation + slack(face.separation);
        let best_of_faces = face_a.separation.max(face_b.separation);
        let threshold = bar.min(margin.max(best_of_faces));
        let gap = hint.gap.min(self.gap_at_most(a, b, scratch));
        let search = |floor: f32, scratch: &mut NarrowScratch| {
            // The hulls overlap by no more than along any axis.
            let hinted = (hint.axis).map(|axis| distance_along(a, b, pair.b_in_a, axis));
            let best = hinted.map_or(best_of_faces, |s| s.max(best_of_faces));
            scratch.load_near_edges(a, b, [face_a, face_b], gap.max(-best));
            // What is worth less than the hint is not the best; rounding of the hint is far below the slack.
            let floor = hinted.map_or(floor, |s| floor.max(s - slack(s)));
            best_edge_pair(a, scratch, floor)
        };
        let edge = (gap > threshold)
            .then(|| search(threshold, scratch))
            .flatten();
        let merge = MERGE * size;
        let contact = Clipping { pair, merge };
        if let Some(edge) = edge {
            if edge.separation > margin {
                return SatResult::Separated {
                    axis: edge.normal,
                    distance: edge.separation,
                };
            }
            if edge.separation > bar {
                return SatResult::Touching(contact_of_edges(&contact, &edge, scratch));
            }
        }
        let patch = contact.face_patch(face, b_refers, scratch);
        if patch.count > 0 {
            return SatResult::Touching(patch);
        }
        // What supports the face is beside it, and so is the face of it that was cut.
        SatResult::Touching(match search(best_of_faces, scratch) {
            Some(edge) if edge.separation <= margin => contact_of_edges(&contact, &edge, scratch),
            _ => contact.support_patch(face, b_refers, scratch),
        })
    }

    /// An upper bound of the distance of two hulls, m: from a support vertex to the face that it supports.
    fn gap_at_most(&self, a: &ConvexHull, b: &ConvexHull, scratch: &NarrowScratch) -> f32 {
        let Self { face_a, face_b } = self;
        let from_a = distance_from_face(a, face_a, point(&scratch.b_in_a, face_a.support));
        if from_a <= face_a.separation.max(0.0) {
            return from_a;
        }
        let from_b = distance_from_face(b, face_b, point(&scratch.a_in_b, face_b.support));
        from_a.min(from_b)
    }
}

/// The contact of two edges that cross, with what a face beside one of them tells.
fn contact_of_edges(
    contact: &Clipping<'_>,
    edge: &EdgeAxis,
    scratch: &mut NarrowScratch,
) -> LocalManifold {
    let leaning = leaning_patch(contact, edge, scratch);
    leaning.unwrap_or_else(|| edge_patch(&contact.pair, edge, scratch))
}

/// Distance of a point from a face, m; 0 for a point behind the face, which may be inside the hull.
fn distance_from_face(hull: &ConvexHull, axis: &FaceAxis, place: Vec3) -> f32 {
    let outline = hull.face_loop(&hull.faces()[axis.face]);
    let mut is_beside = false;
    let mut nearest = f32::INFINITY;
    let mut from = hull.vertices()[outline[outline.len() - 1] as usize];
    for &to in outline {
        let to = hull.vertices()[to as usize];
        let (along, offset) = (to - from, place - from);
        is_beside |= along.cross(axis.plane.normal).dot(offset) > 0.0;
        let share = (along.dot(offset) / along.length_squared()).clamp(0.0, 1.0);
        nearest = nearest.min((offset - share * along).length_squared());
        from = to;
    }
    if is_beside {
        nearest.sqrt()
    } else {
        axis.separation.max(0.0)
    }
}

/// The face of `hull` with the largest separation from `points`, the first one on a tie; same frame.
///
/// The search starts with the face `first`, or with the one that looks most towards the other hull (`towards`): that
/// changes the effort, never the answer.
fn best_face(hull: &ConvexHull, points: &[Points4], towards: Vec3, first: Option<u32>) -> FaceAxis {
    let evaluate = |face: usize| FaceAxis::new(hull, face, points);
    let start = first.map_or_else(
        || lowest(hull.lanes.planes.iter().map(|p| &p.normals), -towards).0,
        |face| face as usize,
    );
    let mut best = evaluate(start.min(hull.faces().len() - 1));
    // A vertex of the other hull bounds the separation of every face from above: most are ruled out by the one that
    // supports the best face so far.
    let mut witness = point(points, best.support);
    for (group, planes) in hull.lanes.planes.iter().enumerate() {
        let heights = planes.heights(witness);
        if heights.iter().all(|&h| h < best.separation) {
            continue;
        }
        for (l, &height) in heights.iter().enumerate() {
            let face = group * LANES + l;
            if height < best.separation || face >= hull.faces().len() || face == best.face {
                continue;
            }
            let axis = evaluate(face);
            let is_first = axis.separation == best.separation && face < best.face;
            if axis.separation > best.separation || is_first {
                best = axis;
                witness = point(points, axis.support);
            }
        }
    }
    best
}

#[cfg(test)]
pub(super) mod tests {
    use super::examine_hulls;
    use crate::contact::body_manifold::BodyManifold;
    use crate::contact::narrow::scratch::{NarrowScratch, SatCache, SatResult};
    use crate::geometry::primitives::{cuboid, icosphere, regular_prism, wedge};
    use crate::math::Pose;
    use glam::{Quat, Vec3};
    use rand_core::Rng;
    use rand_pcg::Pcg32;

    /// From [-1, 1].
    pub(in crate::contact::narrow) fn signed(random: &mut Pcg32) -> f32 {
        (random.next_u32() >> 8) as f32 / 8_388_608.0 - 1.0
    }

    pub(in crate::contact::narrow) fn vector(random: &mut Pcg32) -> Vec3 {
        [(); 3].map(|()| signed(random)).into()
    }

    #[test]
    fn hints_do_not_change_the_answer() {
        let hulls = [
            cuboid(1.0, 0.6, 0.4),
            icosphere(0.5, 1),
            regular_prism(5, 0.5, 0.7),
            wedge(1.0, 0.7, 0.4),
        ]
        .map(|hull| hull.expect("valid sizes"));
        let mut random = Pcg32::new(7, 1);
        let (mut scratch, mut hinted) = (NarrowScratch::new(), [0; 2]);
        for _ in 0..20_000 {
            let [a, b] = [(); 2].map(|()| &hulls[random.next_u32() as usize % hulls.len()]);
            let turn = Quat::from_vec4(vector(&mut random).extend(signed(&mut random)));
            let pose = Pose::new(0.8 * vector(&mut random), turn.normalize());
            let margin = 0.02;
            let found = examine_hulls(a, b, pose, margin, SatCache::NONE, &mut scratch);
            let SatResult::Touching(patch) = found else {
                continue;
            };
            let patch = BodyManifold::new(&patch, pose.rotation, [Vec3::ZERO; 2], [None; 2]);
            let faces = Some(scratch.best_faces);
            let way = [0.1, 0.01, 1e-3, 1e-4][random.next_u32() as usize % 4];
            let spin = Quat::from_scaled_axis(way * vector(&mut random));
            let moved = Pose::new(
                pose.position + way * vector(&mut random),
                (spin * pose.rotation).normalize(),
            );
            let hint = SatCache {
                faces,
                ..patch.hint(&moved, [Vec3::ZERO; 2])
            };
            hinted[usize::from(hint.axis.is_some())] += usize::from(patch.count > 0);
            let expected = examine_hulls(a, b, moved, margin, SatCache::NONE, &mut scratch);
            let found = examine_hulls(a, b, moved, margin, hint, &mut scratch);
            assert_eq!(found, expected, "{a:?} {b:?} {moved:?} {hint:?}");
        }
        assert!(hinted.iter().all(|&count| count > 1000), "{hinted:?}");
    }
}
