//! Rays, moved shapes and points against a level of triangles, in the frame of the level.
//!
//! Whether a ray passes an edge is the sign of one product, the same for both triangles at the edge but for its sign: no ray gets
//! through between them.
//!
//! # References
//! S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013: edges are judged by one product for both
//! triangles.

use crate::geometry::StaticMesh;
use crate::geometry::bvh::RayWalk;
use crate::geometry::distance::{Separation, distance};
use crate::geometry::level_triangle::LevelTriangle;
use crate::geometry::support::{Core, PlacedCore};
use crate::geometry::triangle_distance::{nearest_on_triangle, rough_square};
use crate::math::Aabb;
use crate::query::box_sweep::{BoxSweep, BoxView};
use crate::query::cuboid::{Cuboid, Told};
use crate::query::hull::cast_against_core;
use crate::query::local::{LocalCast, LocalHit, LocalRay};
use glam::{DVec3, Vec3};
use smallvec::SmallVec;

/// Rounding of corners and normals, as a share of lengths.
const ROUNDING: f64 = 1e-6;

/// What `f32` leaves open of a distance, as a share of lengths.
const ROUGH: f32 = 1e-4;

/// Triangles that wait for others which a moved box may meet first.
const MAX_WAITING: usize = 16;

/// Where a ray hits a triangle, and whether from the front.
fn pierce(triangle: &LevelTriangle, ray: &LocalRay) -> Option<(f32, bool)> {
    let direction = ray.direction.as_dvec3();
    let origin = ray.origin.as_dvec3();
    let [a, b, c] = triangle.corners.map(|corner| corner.as_dvec3() - origin);
    let side = |p: DVec3, q: DVec3| direction.dot(p.cross(q));
    let sides = [side(b, c), side(c, a), side(a, b)];
    let is_inside = sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0);
    let sum = sides[0] + sides[1] + sides[2];
    if !is_inside || sum == 0.0 {
        return None;
    }
    let at = (sides[0] * a + sides[1] * b + sides[2] * c) / sum;
    let distance = at.dot(direction);
    // The product of the sides is six times a volume that is positive where the ray comes from behind.
    (distance >= 0.0).then_some((distance as f32, sum < 0.0))
}

pub(crate) fn cast_ray(mesh: &StaticMesh, ray: &LocalRay) -> Option<LocalHit> {
    let point = Aabb {
        min: Vec3::ZERO,
        max: Vec3::ZERO,
    };
    let walk = RayWalk::new(ray.origin, ray.direction, point);
    let mut best: Option<LocalHit> = None;
    mesh.tree()
        .along_ray(mesh.triangles(), walk, ray.end, |leaf, end| {
            let triangle = &mesh.triangles()[leaf as usize];
            let Some((distance, is_front)) = pierce(triangle, ray) else {
                return end;
            };
            if distance > end || !(is_front || mesh.is_two_sided()) {
                return end;
            }
            let normal = triangle.plane.normal;
            keep_first(
                &mut best,
                LocalHit {
                    point: ray.origin + distance * ray.direction,
                    normal: if is_front { normal } else { -normal },
                    distance,
                    part: 0,
                    triangle: Some(triangle.index),
                    face: None,
                },
            );
            end.min(distance)
        });
    best
}

/// Keeps the hit that is nearer, or of the triangle that comes first.
fn keep_first(best: &mut Option<LocalHit>, hit: LocalHit) {
    let order = |hit: &LocalHit| (hit.distance, hit.triangle);
    if best.as_ref().is_none_or(|best| order(&hit) < order(best)) {
        *best = Some(hit);
    }
}

fn core_of(triangle: &LevelTriangle) -> Core<'static> {
    Core::of_triangle(triangle.corners)
}

pub(crate) fn cast_shape(mesh: &StaticMesh, cast: &LocalCast) -> Option<LocalHit> {
    if let Some(sweep) = BoxSweep::of(cast) {
        return cast_box(mesh, cast, &sweep);
    }
    let mut best = None;
    on_the_way(mesh, cast, |leaf, is_behind, end| {
        let triangle = &mesh.triangles()[leaf as usize];
        if !stays_off(triangle, is_behind, cast, end) {
            meet(triangle, &LocalCast { end, ..*cast }, &mut best);
        }
        end.min(end_of(&best, cast))
    });
    best
}

/// The same of a box: axes tell which triangles it may meet first, and only how it meets these is looked for.
fn cast_box(mesh: &StaticMesh, cast: &LocalCast, sweep: &BoxSweep) -> Option<LocalHit> {
    let mut best = None;
    let mut waiting: SmallVec<[(f32, u32); MAX_WAITING]> = SmallVec::new();
    on_the_way(mesh, cast, |leaf, _, end| {
        let Some(meeting) = sweep.meeting(&mesh.triangles()[leaf as usize], end) else {
            return end;
        };
        let mut end = end.min(meeting.latest);
        if waiting.len() == MAX_WAITING {
            waiting.retain(|(soonest, _)| *soonest <= end);
        }
        if waiting.len() == MAX_WAITING {
            meet_first(mesh, cast, &mut waiting, &mut best);
            end = end.min(end_of(&best, cast));
        }
        waiting.push((meeting.soonest, leaf));
        end
    });
    meet_first(mesh, cast, &mut waiting, &mut best);
    best
}

/// Meets the triangles that wait, each with the way on which it is not touched (m), and lets them go.
fn meet_first(
    mesh: &StaticMesh,
    cast: &LocalCast,
    waiting: &mut SmallVec<[(f32, u32); MAX_WAITING]>,
    best: &mut Option<LocalHit>,
) {
    waiting.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    for (free, leaf) in waiting.drain(..) {
        let end = end_of(best, cast);
        if free <= end {
            let triangle = &mesh.triangles()[leaf as usize];
            meet(triangle, &LocalCast { free, end, ..*cast }, best);
        }
    }
}

/// How far a cast goes that has met this.
fn end_of(best: &Option<LocalHit>, cast: &LocalCast) -> f32 {
    best.map_or(cast.end, |best| best.distance)
}

/// Keeps where a moved shape meets a triangle, if that is the first.
fn meet(triangle: &LevelTriangle, cast: &LocalCast, best: &mut Option<LocalHit>) {
    if let Some(hit) = cast_against_core(&core_of(triangle), cast) {
        let triangle = Some(triangle.index);
        keep_first(best, LocalHit { triangle, ..hit });
    }
}

/// Visits the triangles whose boxes that of a moved shape meets, and that it may come against, each with whether the shape begins behind it.
fn on_the_way(mesh: &StaticMesh, cast: &LocalCast, mut visit: impl FnMut(u32, bool, f32) -> f32) {
    let b = cast.core.bounds().fattened(cast.radius);
    let origin = b.center();
    let about = Aabb {
        min: b.min - origin,
        max: b.max - origin,
    };
    let walk = RayWalk::new(origin, cast.direction, about);
    let middle = cast.core.inside();
    mesh.tree()
        .along_ray(mesh.triangles(), walk, cast.end, |leaf, end| {
            let plane = &mesh.triangles()[leaf as usize].plane;
            let is_behind = plane.distance(middle) < 0.0;
            if is_behind && !mesh.is_two_sided() {
                return end;
            }
            visit(leaf, is_behind, end)
        });
}

/// Whether a moved shape stays on its side of a triangle's plane up to `end` (m), and off it.
fn stays_off(triangle: &LevelTriangle, is_behind: bool, cast: &LocalCast, end: f32) -> bool {
    let normal = triangle.plane.normal.as_dvec3();
    let up = if is_behind { -normal } else { normal };
    let lowest = cast.core.support(-up) - triangle.corners[0].as_dvec3();
    let gap = up.dot(lowest) - f64::from(cast.radius);
    let sinks = (-up.dot(cast.direction.as_dvec3())).max(0.0);
    let way = if sinks > 0.0 {
        sinks * f64::from(end)
    } else {
        0.0
    };
    // Corners and normals are rounded.
    let slack = f64::from(2.0 * cast.touch) + ROUNDING * lowest.length();
    gap > way + slack
}

pub(crate) fn overlaps(mesh: &StaticMesh, core: &PlacedCore, radius: f32) -> bool {
    let mut is_met = false;
    let view = Cuboid::of(core).filter(|_| radius == 0.0);
    let view = view.map(|cuboid| BoxView::of(&cuboid));
    mesh.tree()
        .within(mesh.triangles(), &core.bounds().fattened(radius), |leaf| {
            let triangle = &mesh.triangles()[leaf as usize];
            if is_met {
                return;
            }
            is_met = match view.as_ref().map(|view| view.against(triangle)) {
                Some(Told::Apart) => false,
                Some(Told::Overlap) => true,
                Some(Told::Nothing(_)) | None => is_within(triangle, core, radius),
            };
        });
    is_met
}

fn is_within(triangle: &LevelTriangle, core: &PlacedCore, radius: f32) -> bool {
    match distance(&core_of(triangle), core, f64::from(radius)) {
        Separation::Overlap => true,
        Separation::Near(nearest) => nearest.distance <= f64::from(radius),
        Separation::Far => false,
    }
}

/// The point of the surface that is nearest to a point, if it is within `limit` (m).
pub(crate) fn closest(mesh: &StaticMesh, point: Vec3, limit: f32) -> Option<LocalHit> {
    let there = point.as_dvec3();
    let mut best: Option<LocalHit> = None;
    mesh.tree()
        .around(mesh.triangles(), point, limit, |leaf, limit| {
            let triangle = &mesh.triangles()[leaf as usize];
            let beside = triangle.corners.map(|corner| corner - point);
            let most = limit * (1.0 + ROUGH) + ROUGH * point.abs().max_element();
            if rough_square(beside, triangle.plane.normal) > most * most {
                return limit;
            }
            let at = nearest_on_triangle(triangle.corners.map(|corner| corner.as_dvec3()), there);
            let apart = there - at;
            let away = apart.length();
            if away > f64::from(limit) {
                return limit;
            }
            let normal = apart.try_normalize().map(|normal| normal.as_vec3());
            let normal = normal.unwrap_or(triangle.plane.normal);
            let (at, away) = (at.as_vec3(), away as f32);
            keep_first(
                &mut best,
                LocalHit {
                    point: at,
                    normal,
                    distance: away,
                    part: 0,
                    triangle: Some(triangle.index),
                    face: None,
                },
            );
            limit.min(away)
        });
    best
}
