//! Rays and shapes against everything below a plane, in the frame of the half-space, whose plane goes through its origin.

use crate::geometry::support::PlacedCore;
use crate::query::local::{LocalCast, LocalHit, LocalRay};
use glam::{DVec3, Vec3};

pub(crate) fn cast_ray(normal: Vec3, ray: &LocalRay) -> Option<LocalHit> {
    let height = normal.as_dvec3().dot(ray.origin.as_dvec3());
    let rate = normal.dot(ray.direction);
    if height <= 0.0 && ray.is_solid {
        return Some(ray.inside());
    }
    let distance = (-height / f64::from(rate)) as f32;
    let is_hit = (height > 0.0) == (rate < 0.0) && distance >= 0.0 && distance <= ray.end;
    is_hit.then(|| LocalHit::at(ray.origin + distance * ray.direction, normal, distance))
}

/// Height of the lowest point of a core above the plane, and the point, m.
pub(crate) fn lowest(normal: Vec3, core: &PlacedCore) -> (f64, DVec3) {
    let normal = normal.as_dvec3();
    let at = core.support(-normal);
    (normal.dot(at), at)
}

pub(crate) fn cast_shape(normal: Vec3, cast: &LocalCast) -> Option<LocalHit> {
    let (height, at) = lowest(normal, &cast.core);
    let gap = height - f64::from(cast.radius);
    let rate = f64::from(normal.dot(cast.direction));
    let is_apart = gap > -f64::from(cast.touch);
    if is_apart && rate >= 0.0 {
        return None;
    }
    let distance = if is_apart {
        (gap / -rate).max(0.0)
    } else {
        0.0
    };
    let there = at + distance * cast.direction.as_dvec3();
    let on_plane = there - normal.as_dvec3().dot(there) * normal.as_dvec3();
    (distance <= f64::from(cast.end))
        .then(|| LocalHit::at(on_plane.as_vec3(), normal, distance as f32))
}

pub(crate) fn closest(normal: Vec3, point: Vec3) -> LocalHit {
    let height = normal.as_dvec3().dot(point.as_dvec3()) as f32;
    LocalHit::at(point - height * normal, normal, height)
}
