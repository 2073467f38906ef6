//! Rays, moved shapes and points against a convex shape, round or not, in its frame.

use crate::geometry::ConvexMesh;
use crate::geometry::support::PlacedCore;
use crate::query::local::{LocalCast, LocalHit, LocalRay};
use crate::query::{hull, round};
use glam::Vec3;

pub(crate) fn cast_ray(mesh: &ConvexMesh, ray: &LocalRay) -> Option<LocalHit> {
    match mesh.round() {
        Some(shape) => round::cast_ray(shape, ray),
        None => hull::cast_ray(mesh.hull(), ray),
    }
}

pub(crate) fn cast_shape(mesh: &ConvexMesh, cast: &LocalCast) -> Option<LocalHit> {
    match mesh.round() {
        Some(shape) => round::cast_shape(shape, cast),
        None => hull::cast_shape(mesh.hull(), cast),
    }
}

/// Whether a core comes within `radius` (m) of the shape.
pub(crate) fn overlaps(mesh: &ConvexMesh, core: &PlacedCore, radius: f32) -> bool {
    match mesh.round() {
        Some(shape) => round::overlaps(shape, core, radius),
        None => hull::overlaps(mesh.hull(), core, radius),
    }
}

/// The point of the surface that is nearest to a point, if it is within `limit` (m).
pub(crate) fn closest(mesh: &ConvexMesh, point: Vec3, limit: f32) -> Option<LocalHit> {
    match mesh.round() {
        Some(shape) => round::closest(shape, point, limit),
        None => hull::closest(mesh.hull(), point, limit),
    }
}

/// A place on the surface with the face that it lies on, if the shape has faces.
pub(crate) fn on_surface(mesh: &ConvexMesh, found: LocalHit) -> LocalHit {
    match mesh.round() {
        Some(_) => found,
        None => hull::on_surface(mesh.hull(), found),
    }
}
