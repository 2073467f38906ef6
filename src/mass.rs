//! Polyhedral volume integrals, and the mass, centre of mass and inertia that follow from them.

use bevy_ecs::component::Component;
use glam::{DMat3, DVec3, Quat, Vec3};

/// Volume integrals of a closed polyhedron at unit density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeIntegrals {
    /// Volume, m3.
    pub volume: f64,
    /// Centroid, m.
    pub centroid: DVec3,
    /// Inertia tensor about the centroid at unit density, m5.
    pub inertia: DMat3,
}

/// Mass, centre of mass and principal inertia of a body, in its own frame.
#[derive(Clone, Copy, Debug, PartialEq, Component)]
pub struct MassProperties {
    /// Mass, kg.
    pub mass: f32,
    /// Centre of mass in the body's frame, m.
    pub centre: Vec3,
    /// Principal moments of inertia about the centre, ascending, kg m2.
    pub principal: Vec3,
    /// Rotation from the principal frame to the body's frame.
    pub principal_frame: Quat,
}
