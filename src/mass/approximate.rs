//! The approximations of "Constraint-Based Physics With Real-Time Object Slicing", kept as reference functions.
//!
//! A body uses the exact integrals of the parent module; these show what the exact ones gain. The example
//! `mass_accuracy` prints both side by side.

use crate::mass::particle_inertia;
use glam::{DMat3, DVec3};

/// Center of mass taken as the mean of the vertices (m): exact only if the vertices are spread evenly about the center.
///
/// The mean of no vertices is NaN.
pub fn mean_of_vertices<P: Copy + Into<DVec3>>(vertices: &[P]) -> DVec3 {
    vertices.iter().map(|&v| v.into()).sum::<DVec3>() / vertices.len() as f64
}

/// Inertia tensor about `center` (m), kg m2, of `mass` (kg) shared equally by particles at the vertices.
///
/// Always too large for a convex body, since all its mass is moved outwards: a cube gets three times its inertia.
pub fn vertices_as_particles<P: Copy + Into<DVec3>>(
    vertices: &[P],
    mass: f64,
    center: DVec3,
) -> DMat3 {
    let share = mass / vertices.len() as f64;
    let tensors = vertices
        .iter()
        .map(|&v| particle_inertia(share, v.into() - center));
    tensors.fold(DMat3::ZERO, |sum, tensor| sum + tensor)
}

/// The tensor without its products of inertia, as if the axes of the body's frame were principal axes.
pub fn off_diagonals_dropped(inertia: DMat3) -> DMat3 {
    DMat3::from_diagonal(inertia.diagonal())
}
