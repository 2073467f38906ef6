//! The points of a pair along its direction.

use crate::contact::local_manifold::{LocalManifold, LocalPoint};
use crate::contact::narrow::round::axis::{PairAxis, SolidPair};
use crate::contact::narrow::round::solid::{Flat, Place, Solid};
use crate::contact::narrow::scratch::MERGE;
use crate::contact::reduce::{Candidate, CornerKind, reduce};
use glam::{DVec3, Vec3};

/// Sine of the angle between two lines up to which they lie side by side.
const PARALLEL: f32 = 0.05;

/// How far a point may be beside a face that it is on, over the distance up to which two points are one.
const BESIDE: f32 = 30.0;

/// Buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct RoundScratch {
    pub(super) places: Vec<Place>,
    pub(super) clipped: Vec<Place>,
    pub(super) outline: Vec<Vec3>,
    candidates: Vec<Candidate>,
}

/// Where a patch is made: up to which gap points count, and how near to each other they are one, m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PatchRule {
    pub(crate) reach: f32,
    pub(crate) merge: f32,
}

impl PatchRule {
    pub(crate) fn new(reach: f32, size: f32) -> Self {
        Self {
            reach,
            merge: MERGE * size,
        }
    }
}

/// The contact of a pair along a direction.
pub(crate) fn patch_along(
    pair: &SolidPair,
    axis: &PairAxis,
    rule: PatchRule,
    scratch: &mut RoundScratch,
) -> LocalManifold {
    let patch = wide_patch(pair, axis.normal, rule, scratch);
    if patch.count > 0 {
        patch
    } else {
        point_patch(pair, axis)
    }
}

/// The contact of a pair along a direction on a face or along a line, if there is one: else without points.
pub(super) fn wide_patch(
    pair: &SolidPair,
    normal: Vec3,
    rule: PatchRule,
    scratch: &mut RoundScratch,
) -> LocalManifold {
    let face_a = pair.a.face_near(normal);
    let face_b = pair.b.face_near(-pair.seen_from_b(normal));
    match (face_a, face_b) {
        (Some(face), None) => face_patch(pair, &face, rule, scratch),
        (Some(face), Some(_)) if is_larger(pair) => face_patch(pair, &face, rule, scratch),
        (_, Some(face)) => {
            let turned = pair.swapped();
            face_patch(&turned, &face, rule, scratch).swapped(&turned.b_in_a)
        }
        (None, None) => line_patch(pair, normal, rule),
    }
}

/// Whether A is not smaller than B, so that its face is what the other one stands on.
fn is_larger(pair: &SolidPair) -> bool {
    let size = |core: &crate::geometry::support::Core| {
        let b = core.bounds(&glam::Mat3::IDENTITY, Vec3::ZERO);
        b.diagonal()
    };
    size(&pair.a.core()) >= size(&pair.b.core())
}

/// Points of B over a face of A.
fn face_patch(
    pair: &SolidPair,
    face: &Flat,
    rule: PatchRule,
    scratch: &mut RoundScratch,
) -> LocalManifold {
    let normal = face.normal;
    let towards_a = -pair.seen_from_b(normal);
    pair.b.feature(towards_a, &mut scratch.places);
    for place in &mut scratch.places {
        place.at = pair.b_in_a.transform_point(place.at);
    }
    face.outline(&mut scratch.outline);
    clip_places(normal, scratch);
    let offset = face.offset() + pair.a.radius + pair.b.radius;
    let mut patch = LocalManifold {
        normal,
        ..LocalManifold::default()
    };
    keep_near(normal, offset, rule, scratch);
    let is_one = scratch.places.len() == 1;
    if is_one && !is_over(&scratch.outline, normal, scratch.places[0].at, rule) {
        return patch;
    }
    for place in &scratch.places {
        let own = pair.b_in_a.inverse_transform_point(place.at);
        let curvature = if is_one {
            pair.b.curvature(towards_a, own)
        } else {
            place.curvature
        };
        let separation = normal.dot(place.at) - offset;
        let on_b = place.at - pair.b.radius * normal;
        patch.push(LocalPoint {
            on_a: on_b - separation * normal,
            on_b: pair.b_in_a.inverse_transform_point(on_b),
            separation,
            share_b: 1.0,
            along: Vec3::ZERO,
            radii: [pair.a.radius, curvature],
        });
    }
    patch
}

/// Whether a point is over a face, or beside it by less than two points that are one: the point of a shape that is deepest below the plane of a face that it
/// overlaps may be anywhere beside it.
fn is_over(outline: &[Vec3], normal: Vec3, at: Vec3, rule: PatchRule) -> bool {
    let Some(&(mut from)) = outline.last() else {
        return true;
    };
    outline.iter().all(|&to| {
        let outward = (to - from).cross(normal);
        let beside = outward.dot(at - from);
        from = to;
        beside <= BESIDE * rule.merge * outward.length()
    })
}

/// Keeps of `scratch.places` those that are not higher than `rule.reach` (m) above a plane, four at most.
pub(super) fn keep_near(normal: Vec3, offset: f32, rule: PatchRule, scratch: &mut RoundScratch) {
    let RoundScratch {
        places, candidates, ..
    } = scratch;
    places.retain(|place| normal.dot(place.at) - offset <= rule.reach);
    candidates.clear();
    candidates.extend(places.iter().map(|place| Candidate {
        at: place.at,
        separation: normal.dot(place.at) - offset,
        kind: CornerKind::Incident,
        leaves_on_cut: false,
    }));
    reduce(candidates, normal, rule.merge);
    // What is left stands in the same order.
    let mut left = candidates.iter().peekable();
    places.retain(|place| left.next_if(|c| c.at == place.at).is_some());
}

/// Cuts the polygon, line or point `scratch.places` by the planes through the edges of `scratch.outline`, which is seen against the
/// normal.
pub(super) fn clip_places(normal: Vec3, scratch: &mut RoundScratch) {
    let RoundScratch {
        places,
        clipped,
        outline,
        ..
    } = scratch;
    let Some(&last) = outline.last() else {
        return;
    };
    let mut from = last;
    for &to in outline.iter() {
        let outward = (to - from).cross(normal);
        match places.as_slice() {
            [] | [_] => {}
            [p, q] => clip_line([*p, *q], from, outward, clipped),
            _ => clip_polygon(places, from, outward, clipped),
        }
        if places.len() > 1 {
            std::mem::swap(places, clipped);
        }
        from = to;
    }
}

fn between(p: &Place, q: &Place, share: f32) -> Place {
    Place {
        at: p.at + share * (q.at - p.at),
        curvature: p.curvature + share * (q.curvature - p.curvature),
    }
}

fn clip_line([p, q]: [Place; 2], from: Vec3, outward: Vec3, result: &mut Vec<Place>) {
    result.clear();
    let [h, k] = [p, q].map(|place| outward.dot(place.at - from));
    let cut = || between(&p, &q, h / (h - k));
    match (h <= 0.0, k <= 0.0) {
        (true, true) => result.extend([p, q]),
        (true, false) => result.extend([p, cut()]),
        (false, true) => result.extend([cut(), q]),
        (false, false) => {}
    }
}

fn clip_polygon(polygon: &[Place], from: Vec3, outward: Vec3, result: &mut Vec<Place>) {
    result.clear();
    let Some(mut before) = polygon.last() else {
        return;
    };
    let height = |place: &Place| outward.dot(place.at - from);
    for place in polygon {
        let (h, k) = (height(before), height(place));
        if (h > 0.0) != (k > 0.0) {
            result.push(between(before, place, h / (h - k)));
        }
        if k <= 0.0 {
            result.push(*place);
        }
        before = place;
    }
}

/// Two lines side by side.
fn line_patch(pair: &SolidPair, normal: Vec3, rule: PatchRule) -> LocalManifold {
    let mut patch = LocalManifold {
        normal,
        ..LocalManifold::default()
    };
    let (Some(p), Some(q)) = (pair.a.line(normal), pair.b.line(-pair.seen_from_b(normal))) else {
        return patch;
    };
    let q = q.map(|place| Place {
        at: pair.b_in_a.transform_point(place.at),
        ..place
    });
    let (along, other) = (p[1].at - p[0].at, q[1].at - q[0].at);
    let (length, other_length) = (along.length(), other.length());
    if along.cross(other).length() > PARALLEL * length * other_length {
        return patch;
    }
    let along = along / length;
    let on_a = |place: &Place| along.dot(place.at - p[0].at);
    let [first, last] = [on_a(&q[0]), on_a(&q[1])];
    let (low, high) = (first.min(last).max(0.0), first.max(last).min(length));
    if high - low <= rule.merge {
        return patch;
    }
    for t in [low, high] {
        let at_a = between(&p[0], &p[1], t / length);
        let at_b = between(&q[0], &q[1], ((t - first) / (last - first)).clamp(0.0, 1.0));
        let surface_a = at_a.at + pair.a.radius * normal;
        let surface_b = at_b.at - pair.b.radius * normal;
        let separation = normal.dot(surface_b - surface_a);
        if separation <= rule.reach {
            let on_b = surface_a + separation * normal;
            patch.push(LocalPoint {
                on_a: surface_a,
                on_b: pair.b_in_a.inverse_transform_point(on_b),
                separation,
                share_b: 0.5,
                along: Vec3::ZERO,
                radii: [at_a.curvature, at_b.curvature],
            });
        }
    }
    patch
}

/// The one point where two shapes are nearest.
fn point_patch(pair: &SolidPair, axis: &PairAxis) -> LocalManifold {
    let normal = axis.normal.as_dvec3();
    let separation = axis.separation;
    let to_b = pair.seen_from_b(axis.normal);
    let of_b = |at: Vec3| pair.b_in_a.transform_point(at).as_dvec3();
    // A rim or a tip of one that looks towards the other one may be far from where that is nearest.
    let is_near = |solid: &Solid, inner: DVec3| {
        let beside = axis.inner.map_or(DVec3::ZERO, |at| {
            (inner - at).reject_from_normalized(normal)
        });
        beside.length() <= f64::from(solid.depth)
    };
    let [sharp_a, sharp_b] = [pair.a.sharp_point(axis.normal), pair.b.sharp_point(-to_b)];
    let sharp_a = sharp_a.filter(|_| is_near(&pair.a, pair.a.inner.exact_support(normal)));
    let sharp_b = sharp_b.filter(|_| is_near(&pair.b, of_b(pair.b.inner.support(-to_b))));
    let on_a: DVec3 = match (sharp_a, sharp_b, axis.inner) {
        (Some(at), ..) => at.as_dvec3(),
        (None, Some(at), _) => of_b(at) - separation * normal,
        (None, None, Some(at)) => at + f64::from(pair.a.depth) * normal,
        (None, None, None) => pair.a.support(normal),
    };
    let on_b = pair
        .b_in_a
        .inverse_transform_point((on_a + separation * normal).as_vec3());
    let mut patch = LocalManifold {
        normal: axis.normal,
        ..LocalManifold::default()
    };
    let curvatures = [
        pair.a.curvature(axis.normal, on_a.as_vec3()),
        pair.b.curvature(-to_b, on_b),
    ];
    patch.push(LocalPoint {
        on_a: on_a.as_vec3(),
        on_b,
        separation: separation as f32,
        share_b: 0.5,
        along: Vec3::ZERO,
        radii: curvatures,
    });
    patch
}
