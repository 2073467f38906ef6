//! Rays, moved shapes and points against a round shape, in its frame.
//!
//! Spheres are hit where a quadratic equation says; all else is a point or a core that is moved until it is as near to the core of
//! the shape as its radius.

use crate::geometry::distance::{Separation, distance};
use crate::geometry::round::RoundShape;
use crate::geometry::round_core::RoundCore;
use crate::geometry::support::{Core, PlacedCore};
use crate::math::Pose;
use crate::query::cuboid::Cuboid;
use crate::query::hull::{self, cast_against_core};
use crate::query::local::{LocalCast, LocalHit, LocalRay};
use glam::{DVec3, Quat, Vec3};

/// Gap at which a ray touches, as a share of the shape's diagonal.
const TOUCH: f32 = 1e-6;

fn placed(core: Core<'static>, at: Vec3) -> PlacedCore<'static> {
    PlacedCore::new(core, &Pose::new(at, Quat::IDENTITY))
}

pub(crate) fn cast_ray(shape: &RoundShape, ray: &LocalRay) -> Option<LocalHit> {
    if is_inside(shape, ray.origin) {
        return if ray.is_solid {
            Some(ray.inside())
        } else {
            leave(shape, ray)
        };
    }
    if let RoundCore::Point = shape.core {
        return enter_sphere(shape.radius, ray);
    }
    let cast = LocalCast {
        core: placed(Core::of_point(Vec3::ZERO), ray.origin),
        radius: 0.0,
        direction: ray.direction,
        free: 0.0,
        end: ray.end,
        touch: TOUCH * shape.aabb.diagonal(),
    };
    cast_shape(shape, &cast)
}

/// Where a ray from outside enters a sphere around the origin.
fn enter_sphere(radius: f32, ray: &LocalRay) -> Option<LocalHit> {
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let half = origin.dot(direction);
    // From the middle to the nearest point of the ray's line.
    let aside = origin - half * direction;
    let square = f64::from(radius) * f64::from(radius) - aside.length_squared();
    if square < 0.0 {
        return None;
    }
    let at = -half - square.sqrt();
    if at < 0.0 || at > f64::from(ray.end) {
        return None;
    }
    let point = origin + at * direction;
    let normal = point.normalize_or(-direction);
    Some(LocalHit::at(point.as_vec3(), normal.as_vec3(), at as f32))
}

/// Where a ray from inside leaves the shape: what comes from the other end of its line meets it there.
fn leave(shape: &RoundShape, ray: &LocalRay) -> Option<LocalHit> {
    let away = 2.0 * shape.aabb.diagonal() + shape.aabb.center().distance(ray.origin);
    let back = LocalRay {
        origin: ray.origin + away * ray.direction,
        direction: -ray.direction,
        end: 2.0 * away,
        is_solid: true,
    };
    let found = cast_ray(shape, &back)?;
    let distance = (away - found.distance).max(0.0);
    (distance <= ray.end).then_some(LocalHit { distance, ..found })
}

fn is_inside(shape: &RoundShape, point: Vec3) -> bool {
    closest(shape, point, 0.0).is_some()
}

pub(crate) fn cast_shape(shape: &RoundShape, cast: &LocalCast) -> Option<LocalHit> {
    let both = LocalCast {
        radius: cast.radius + shape.radius,
        ..*cast
    };
    let mut hit = cast_against_core(&shape.core(), &both)?;
    if hit.distance > 0.0 || hit.normal != -cast.direction {
        hit.point += shape.radius * hit.normal;
    }
    Some(hit)
}

pub(crate) fn overlaps(shape: &RoundShape, core: &PlacedCore, radius: f32) -> bool {
    let limit = f64::from(radius) + f64::from(shape.radius);
    if let (RoundCore::Point, Some(cuboid)) = (&shape.core, Cuboid::of(core)) {
        return cuboid.reaches(Vec3::ZERO, limit);
    }
    match distance(&shape.core(), core, limit) {
        Separation::Overlap => true,
        Separation::Near(nearest) => nearest.distance <= limit,
        Separation::Far => false,
    }
}

/// The point of the surface that is nearest to a point, if it is within `limit` (m).
pub(crate) fn closest(shape: &RoundShape, point: Vec3, limit: f32) -> Option<LocalHit> {
    let at = point.as_dvec3();
    let about = |center: DVec3, spare: DVec3| {
        let away = at - center;
        let normal = away.try_normalize().unwrap_or(spare);
        (away.length(), normal, center)
    };
    let (away, normal, on_core) = match &shape.core {
        RoundCore::Point => about(DVec3::ZERO, DVec3::Y),
        RoundCore::Segment(half) => {
            let half = f64::from(*half);
            about(at.y.clamp(-half, half) * DVec3::Y, DVec3::X)
        }
        RoundCore::Frustum(frustum) => frustum.nearest(at),
        RoundCore::Hull(core) => {
            let found = hull::closest(core, point, limit + shape.radius)?;
            let (normal, at) = (found.normal.as_dvec3(), found.point.as_dvec3());
            (f64::from(found.distance), normal, at)
        }
    };
    let radius = f64::from(shape.radius);
    let distance = (away - radius) as f32;
    let surface = (on_core + radius * normal).as_vec3();
    (distance <= limit).then(|| LocalHit::at(surface, normal.as_vec3(), distance))
}
