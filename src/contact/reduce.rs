//! The points of a contact before they are reduced to four, and their reduction.

use crate::contact::point::MAX_POINTS;
use crate::math::tangents;
use glam::Vec3;

/// A contact point before reduction, in the frame of one body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    /// On the surface of the body that the reference face does not belong to, m.
    pub(crate) at: Vec3,
    /// Gap along the normal, m.
    pub(crate) separation: f32,
    pub(crate) kind: CornerKind,
    /// Whether the polygon runs on along an edge of the reference face.
    pub(crate) leaves_on_cut: bool,
}

/// What a corner of a cut face is.
#[derive(Clone, Copy, Debug)]
pub(crate) enum CornerKind {
    /// A vertex of the incident body.
    Incident,
    /// Where an edge of the incident body crosses an edge of the reference face, which runs along this unit vector.
    Crossing(Vec3),
    /// A vertex of the reference face.
    Reference,
}

/// How much lower a point must be to matter, as a share of the distance within which points are one: rounding of a flat face is a tenth of that.
const UNEVEN: f32 = 0.02;

/// How far hulls may sag into each other under a load, as a share of the smaller one's least extent: the heights of points that differ by
/// less tell of loads, and not of where a body tips.
pub(crate) const SAG: f32 = 1e-3;

/// Chooses at most [`MAX_POINTS`] of `candidates` that carry a load as well as all of them would, and keeps their order.
///
/// `candidates` are in one frame; `normal` is the unit contact normal; points nearer to each
/// other than `merge` (m) count as one. First the deepest point, then the one farthest from it, then the one that spans
/// the largest triangle with these two, then the one that adds most area outside the triangle. Points within `merge`
/// of the deepest are taken as equally deep, and the most extreme of them in a fixed direction is chosen, so that
/// rounding noise on a flat face does not change the choice from step to step; any other tie goes to the first.
pub(crate) fn reduce(candidates: &mut Vec<Candidate>, normal: Vec3, merge: f32) {
    remove_duplicates(candidates, merge);
    if candidates.len() <= MAX_POINTS {
        return;
    }
    let chosen = choose_four(candidates, normal, merge);
    let mut index = 0;
    candidates.retain(|_| {
        index += 1;
        chosen.contains(&(index - 1))
    });
}

/// [`reduce`] where gaps under one face differ, as on ridges, or below a plate that tips over an edge: what it leaves out and is lower than
/// all but one of those chosen goes to `lower`, or a body that rests on two points beside the chosen ones rocks from one set of them to
/// another. By less than `sag` (m), or a share of `merge`, a point is not lower.
pub(crate) fn reduce_uneven(
    candidates: &mut Vec<Candidate>,
    lower: &mut Vec<Candidate>,
    normal: Vec3,
    merge: f32,
    sag: f32,
) {
    lower.clear();
    remove_duplicates(candidates, merge);
    if candidates.len() <= MAX_POINTS {
        return;
    }
    let chosen = choose_four(candidates, normal, merge);
    let mut gaps = chosen.map(|it| candidates[it].separation);
    gaps.sort_unstable_by(f32::total_cmp);
    let limit = gaps[1] - sag.max(UNEVEN * merge);
    let mut index = 0;
    candidates.retain(|candidate| {
        index += 1;
        let is_chosen = chosen.contains(&(index - 1));
        if !is_chosen && candidate.separation < limit {
            lower.push(*candidate);
        }
        is_chosen
    });
    reduce(lower, normal, merge);
}

/// Drops each point that lies within `merge` of an earlier one, which keeps the smaller of both separations.
fn remove_duplicates(candidates: &mut Vec<Candidate>, merge: f32) {
    let mut kept = 0;
    for i in 0..candidates.len() {
        let candidate = candidates[i];
        let twin = candidates[..kept]
            .iter_mut()
            .find(|other| other.at.distance_squared(candidate.at) <= merge * merge);
        match twin {
            Some(twin) => twin.separation = twin.separation.min(candidate.separation),
            None => {
                candidates[kept] = candidate;
                kept += 1;
            }
        }
    }
    candidates.truncate(kept);
}

/// The four points of [`reduce`], as indices; fewer distinct ones if the points lie on a line.
fn choose_four(candidates: &[Candidate], normal: Vec3, merge: f32) -> [usize; MAX_POINTS] {
    let best = |score: &dyn Fn(Vec3) -> f32| {
        let mut best = (f32::NEG_INFINITY, 0);
        for (i, candidate) in candidates.iter().enumerate() {
            let value = score(candidate.at);
            if value > best.0 {
                best = (value, i);
            }
        }
        best.1
    };
    let deepest = candidates
        .iter()
        .fold(f32::INFINITY, |d, candidate| d.min(candidate.separation));
    let [along, _] = tangents(normal);
    let mut first = (f32::NEG_INFINITY, 0);
    for (i, candidate) in candidates.iter().enumerate() {
        let extreme = along.dot(candidate.at);
        if candidate.separation <= deepest + merge && extreme > first.0 {
            first = (extreme, i);
        }
    }
    let first = first.1;
    let p = candidates[first].at;
    let second = best(&|point| point.distance_squared(p));
    let q = candidates[second].at;
    // Twice the signed area of the triangle (from, to, point), seen against the normal.
    let area = |from: Vec3, to: Vec3, point: Vec3| normal.dot((to - from).cross(point - from));
    let third = best(&|point| area(p, q, point).abs());
    let r = candidates[third].at;
    // Edges of the triangle run so that outside is negative for all three.
    let turn = 1.0_f32.copysign(area(p, q, r));
    let fourth = best(&|point| {
        let outside = |from, to| -turn * area(from, to, point);
        outside(p, q).max(outside(q, r)).max(outside(r, p))
    });
    [first, second, third, fourth]
}
