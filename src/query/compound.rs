//! Rays, moved shapes and points against a compound, in its frame: part by part, of which the nearest counts, the first on a tie.

use crate::geometry::bvh::{RayWalk, along_ray, around, within};
use crate::geometry::support::PlacedCore;
use crate::geometry::{Compound, CompoundPart};
use crate::math::{Aabb, rotate};
use crate::query::convex;
use crate::query::local::{LocalCast, LocalHit, LocalRay};
use glam::Vec3;

/// How far beyond the end of a part a ray that leaves the body looks for the next one, as a share of the body's diagonal: rounding.
const SEAM: f32 = 1e-6;

/// Keeps the hit that is nearer, or of the part that comes first.
pub(crate) fn keep_first(best: &mut Option<LocalHit>, hit: LocalHit) {
    let order = |hit: &LocalHit| (hit.distance, hit.part);
    if best.as_ref().is_none_or(|best| order(&hit) < order(best)) {
        *best = Some(hit);
    }
}

/// A hit on a part as one on the compound.
pub(crate) fn on_part(part: &CompoundPart, index: u32, hit: LocalHit) -> LocalHit {
    LocalHit {
        point: part.pose.transform_point(hit.point),
        normal: rotate(part.pose.rotation, hit.normal),
        part: index,
        ..hit
    }
}

/// Visits the parts that a moved box may meet before `end` (m), as [`along_ray`] does.
fn along(compound: &Compound, walk: RayWalk, end: f32, mut visit: impl FnMut(u32, f32) -> f32) {
    match compound.tree() {
        Some(tree) => along_ray(tree, walk, end, visit),
        None => {
            let parts = 0..compound.len() as u32;
            parts.fold(end, |end, part| visit(part, end));
        }
    }
}

/// A ray as a part sees it.
fn seen_from(part: &CompoundPart, ray: &LocalRay) -> LocalRay {
    LocalRay {
        origin: part.pose.inverse_transform_point(ray.origin),
        direction: rotate(part.pose.rotation.inverse(), ray.direction),
        ..*ray
    }
}

/// What a ray hits first, or what it begins inside of.
fn enter(compound: &Compound, ray: &LocalRay) -> Option<LocalHit> {
    let point = Aabb {
        min: Vec3::ZERO,
        max: Vec3::ZERO,
    };
    let walk = RayWalk::new(ray.origin, ray.direction, point);
    let mut best = None;
    along(compound, walk, ray.end, |index, end| {
        let part = &compound.parts()[index as usize];
        let own = LocalRay {
            end,
            is_solid: true,
            ..seen_from(part, ray)
        };
        let Some(hit) = convex::cast_ray(&part.shape, &own) else {
            return end;
        };
        keep_first(&mut best, on_part(part, index, hit));
        end.min(hit.distance)
    });
    best
}

pub(crate) fn cast_ray(compound: &Compound, ray: &LocalRay) -> Option<LocalHit> {
    let hit = enter(compound, ray)?;
    if ray.is_solid || hit.distance > 0.0 {
        let point = ray.origin + hit.distance * ray.direction;
        return Some(LocalHit { point, ..hit });
    }
    leave(compound, ray)
}

/// Where a ray from inside leaves the compound: from part to part.
fn leave(compound: &Compound, ray: &LocalRay) -> Option<LocalHit> {
    let step = SEAM * compound.aabb().diagonal();
    let mut left: Option<LocalHit> = None;
    // Each part is left once.
    for _ in 0..compound.len() {
        let from = left.map_or(0.0, |hit| hit.distance + step);
        let rest = LocalRay {
            origin: ray.origin + from * ray.direction,
            end: f32::MAX,
            is_solid: false,
            ..*ray
        };
        let inside = Aabb::of_points([rest.origin]);
        let mut farthest = None;
        compound.within(&inside.fattened(step), |index| {
            let part = &compound.parts()[index as usize];
            let own = seen_from(part, &rest);
            let is_in = convex::closest(&part.shape, own.origin, 0.0).is_some();
            let hit = is_in.then(|| convex::cast_ray(&part.shape, &own)).flatten();
            let Some(hit) = hit else {
                return;
            };
            let order = |hit: &LocalHit| (hit.distance, std::cmp::Reverse(hit.part));
            let hit = on_part(part, index, hit);
            if farthest
                .as_ref()
                .is_none_or(|known| order(&hit) > order(known))
            {
                farthest = Some(hit);
            }
        });
        let Some(hit) = farthest else {
            break;
        };
        let distance = from + hit.distance;
        left = Some(LocalHit { distance, ..hit });
        if distance > ray.end {
            return None;
        }
    }
    let hit = left?;
    let point = ray.origin + hit.distance * ray.direction;
    Some(LocalHit { point, ..hit })
}

pub(crate) fn cast_shape(compound: &Compound, cast: &LocalCast) -> Option<LocalHit> {
    let b = cast.core.bounds().fattened(cast.radius + cast.touch);
    let origin = b.center();
    let about = Aabb {
        min: b.min - origin,
        max: b.max - origin,
    };
    let walk = RayWalk::new(origin, cast.direction, about);
    let mut best = None;
    along(compound, walk, cast.end, |index, end| {
        let part = &compound.parts()[index as usize];
        let own = LocalCast {
            core: cast.core.seen_from(&part.pose),
            direction: rotate(part.pose.rotation.inverse(), cast.direction),
            end,
            ..*cast
        };
        let Some(hit) = convex::cast_shape(&part.shape, &own) else {
            return end;
        };
        keep_first(&mut best, on_part(part, index, hit));
        end.min(hit.distance)
    });
    best
}

pub(crate) fn overlaps(compound: &Compound, core: &PlacedCore, radius: f32) -> bool {
    let mut is_met = false;
    compound.within(&core.bounds().fattened(radius), |index| {
        let part = &compound.parts()[index as usize];
        is_met = is_met || convex::overlaps(&part.shape, &core.seen_from(&part.pose), radius);
    });
    is_met
}

/// The point of the surface that is nearest to a point, if it is within `limit` (m). Of a point inside, that of the part that it is
/// deepest in.
pub(crate) fn closest(compound: &Compound, point: Vec3, limit: f32) -> Option<LocalHit> {
    let mut best = None;
    let mut visit = |index: u32, limit: f32| {
        let part = &compound.parts()[index as usize];
        let own = part.pose.inverse_transform_point(point);
        let Some(hit) = convex::closest(&part.shape, own, limit) else {
            return limit;
        };
        keep_first(&mut best, on_part(part, index, hit));
        // All parts that the point is in are looked at.
        limit.min(hit.distance.max(0.0))
    };
    match compound.tree() {
        Some(tree) => around(tree, point, limit, visit),
        None => {
            let parts = 0..compound.len() as u32;
            parts.fold(limit, |limit, part| visit(part, limit));
        }
    }
    best
}

/// Visits the parts that may be within `limit` (m) of a core.
pub(crate) fn near(compound: &Compound, core: &PlacedCore, limit: f32, mut visit: impl FnMut(u32)) {
    let bounds = core.bounds().fattened(limit);
    match compound.tree() {
        // A limit without end is no box.
        Some(tree) if bounds.min.is_finite() && bounds.max.is_finite() => {
            within(tree, &bounds, visit);
        }
        _ => (0..compound.len() as u32).for_each(&mut visit),
    }
}
