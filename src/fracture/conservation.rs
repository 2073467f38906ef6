//! What rounding takes from the pieces of a body, they get back: by their density, and by a velocity.
//!
//! Only bodies that are hardly thicker than the rounding of their corners have need of it.

use crate::bodies::body::{BodyDesc, Shape};
use crate::bodies::store::Bodies;
use crate::fracture::ledger::{Invariants, Ledger, Reference};
use crate::geometry::predicates::{length_scale, plane_tolerance};
use crate::geometry::{Compound, ConvexHull, ConvexMesh, TriMesh};
use crate::mass::VolumeIntegrals;

/// Share of a body's mass that its pieces may lose or gain before their density makes up for it. Usual pieces stay far below it and
/// have the density of the body, bit for bit.
const MASS_TOLERANCE: f64 = 5e-7;

/// Share of the mass of a body of several parts that may be rounding of the corners of cut parts, or of round ones the polyhedra that
/// stand for them.
const ROUNDING_OF_PARTS: f64 = 1e-4;

/// Share of the momentum that pieces may lose or gain before a velocity makes up for it.
const MOMENTUM_TOLERANCE: f64 = 5e-6;

/// Gives the pieces of a body, or its `halves` if parts of them came apart, a density with which they have its mass.
///
/// Corners of pieces are rounded to `f32`, in the frame of the body and then about their own centroids, and cells too flat for a hull
/// are left out. Where a body is not much thicker than that, it takes or gives a share of the volume. What cannot be rounding stays
/// for the ledger to tell.
pub(super) fn keep_mass(
    bodies: &Bodies,
    slot: u32,
    pieces: &mut [BodyDesc],
    halves: &mut [BodyDesc],
) {
    let Some(body) = bodies.convex(slot) else {
        keep_mass_of_parts(bodies, slot, pieces);
        return;
    };
    let whole = if halves.is_empty() {
        &*pieces
    } else {
        &*halves
    };
    let meshes = || whole.iter().filter_map(|desc| desc.shape.convex());
    let hulls = || meshes().map(ConvexMesh::hull);
    let weighed = |mesh: &ConvexMesh| mesh.weighed_visual().map(TriMesh::volume);
    let volume: f64 = meshes()
        .map(|mesh| weighed(mesh).unwrap_or_else(|| mesh.hull().volume()))
        .sum();
    let (mass, density) = (bodies.mass(slot).mass, bodies.density(slot));
    let missing = f64::from(mass) / f64::from(density) - volume;
    if missing.abs() <= MASS_TOLERANCE * volume {
        return;
    }
    let area: f64 = hulls().map(ConvexHull::area).sum();
    // A polyhedron has stood for a round body.
    let is_known = body.is_round();
    if is_known || missing.abs() <= 2.0 * f64::from(thickness_of_faces(body.hull())) * area {
        let density = (f64::from(mass) / volume) as f32;
        let descs = pieces.iter_mut().chain(halves);
        descs.for_each(|desc| desc.density = density);
    }
}

/// The same of a body of several parts.
fn keep_mass_of_parts(bodies: &Bodies, slot: u32, pieces: &mut [BodyDesc]) {
    let Some(body) = bodies.compound(slot) else {
        return;
    };
    let volume = |desc: &BodyDesc| match &desc.shape {
        Shape::Convex(mesh) => VolumeIntegrals::of_shape(mesh).volume,
        Shape::Compound(compound) => VolumeIntegrals::of_compound(compound).volume,
        Shape::HalfSpace(_) | Shape::Level(_) => 0.0,
    };
    let volume: f64 = pieces.iter().map(volume).sum();
    let (mass, density) = (bodies.mass(slot).mass, bodies.density(slot));
    let missing = (f64::from(mass) / f64::from(density) - volume).abs();
    if missing <= MASS_TOLERANCE * volume {
        return;
    }
    if missing <= ROUNDING_OF_PARTS * volume
        || bodies.is_round(slot)
        || missing <= rounding_of_corners(body, pieces)
    {
        let density = (f64::from(mass) / volume) as f32;
        pieces.iter_mut().for_each(|desc| desc.density = density);
    }
}

/// Most volume that the pieces of a body of several parts may have less or more than it because their corners are rounded, m3.
fn rounding_of_corners(body: &Compound, pieces: &[BodyDesc]) -> f64 {
    let thicknesses = body.parts().iter();
    let thicknesses = thicknesses.map(|part| thickness_of_faces(part.shape.hull()));
    // What comes off by itself gets a hull in the frame of the body.
    let own = plane_tolerance(length_scale(&body.aabb()));
    let thickness = thicknesses.fold(own, f32::max);
    let area = |desc: &BodyDesc| -> f64 {
        match &desc.shape {
            Shape::Convex(mesh) => mesh.hull().area(),
            Shape::Compound(piece) => piece.parts().iter().map(|it| it.shape.hull().area()).sum(),
            Shape::HalfSpace(_) | Shape::Level(_) => 0.0,
        }
    };
    2.0 * f64::from(thickness) * pieces.iter().map(area).sum::<f64>()
}

/// Gives a group of parts that comes off a cluster a density with which it has their `mass` (kg).
///
/// One part by itself becomes a hull, whose corners are rounded in the frame of the cluster; several keep their shapes.
pub(super) fn keep_mass_of_group(piece: &mut BodyDesc, mass: f64) {
    let Some(mesh) = piece.shape.convex() else {
        return;
    };
    let volume = VolumeIntegrals::of_shape(mesh).volume;
    let missing = mass / f64::from(piece.density) - volume;
    if missing.abs() > MASS_TOLERANCE * volume {
        piece.density = (mass / volume) as f32;
    }
}

/// How far from where they should be corners of a hull and of its pieces may lie, m: as far as a plane reaches, or as its own lie from
/// their faces, which were rounded when it was part of a larger body.
fn thickness_of_faces(hull: &ConvexHull) -> f32 {
    let distances = hull.faces.iter().flat_map(|face| {
        let corners = hull.face_loop(face).iter();
        corners.map(|&v| face.plane.distance(hull.vertices[v as usize]).abs())
    });
    distances.fold(plane_tolerance(length_scale(&hull.aabb())), f32::max)
}

/// Gives the pieces the momentum that they lack, as one velocity for all of them.
///
/// Pieces move as the body did where their centroids are. Where those are rounded as much as [`keep_mass`] says, they are together no
/// longer at the center of mass of the body.
pub(super) fn keep_momentum(
    bodies: &mut Bodies,
    kept: &[u32],
    ledger: &mut Ledger,
    reference: &Reference,
) {
    let is_mass_kept = ledger.mass_error() <= 2.0 * MASS_TOLERANCE;
    if ledger.momentum_error() <= MOMENTUM_TOLERANCE || !is_mass_kept {
        return;
    }
    let change = ledger.missing_momentum() / ledger.after.mass;
    ledger.after = Invariants::default();
    for &slot in kept {
        let (v, omega) = bodies.velocity(slot);
        let v = (v.as_dvec3() + change).as_vec3();
        // Of a velocity that no f32 can hold the piece keeps the old one.
        let _ = bodies.set_velocity(slot, v, omega);
        ledger.after.add_body(bodies, slot, reference);
    }
}
