//! What the solver's sweeps touch of a body: velocity, mass and motion as rows of eight numbers.
#![allow(
    unsafe_code,
    reason = "a record of eight numbers is read and written as one row; every block says why it is sound"
)]

use crate::simd::lanes::{F8, ReadRow, WriteRow};
use glam::{Mat3, Quat, Vec3};

/// Velocity and inverse mass: all that a sweep of the solver touches of a body, half a cache line and never parts of two.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct SolverBody {
    /// Velocity of the center of mass, m/s.
    pub linear: Vec3,
    /// 1 / mass, 1/kg; zero for bodies that contacts do not move.
    pub inverse_mass: f32,
    /// Angular velocity, world axes, rad/s.
    pub angular: Vec3,
    /// Pads to half a cache line.
    pub unused: f32,
}

const _: () = assert!(size_of::<SolverBody>() == 32);

/// Where a step takes a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Motion {
    /// Displacement of the center of mass, m.
    pub(crate) shift: Vec3,
    /// `world_from_body` rotation after it.
    pub(crate) rotation: Quat,
}

/// What does not change when a body moves, and its inertia: xx, yy, zz, xy, xz and yz of the inverse tensor (world axes,
/// 1/(kg m2)), 1 / mass (1/kg), least extent (m).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyMass(pub F8);

impl BodyMass {
    /// From its parts; `extent`, m.
    pub fn new(inverse_mass: f32, inverse_inertia: &Mat3, extent: f32) -> Self {
        let (x, y, z) = (
            inverse_inertia.x_axis,
            inverse_inertia.y_axis,
            inverse_inertia.z_axis,
        );
        let six = [x.x, y.y, z.z, x.y, x.z, y.z];
        let [xx, yy, zz, xy, xz, yz] = six;
        Self(F8([xx, yy, zz, xy, xz, yz, inverse_mass, extent]))
    }

    /// The inverse tensor.
    pub fn inverse_inertia(&self) -> Mat3 {
        let [xx, yy, zz, xy, xz, yz, ..] = self.0.0;
        Mat3::from_cols(
            Vec3::new(xx, xy, xz),
            Vec3::new(xy, yy, yz),
            Vec3::new(xz, yz, zz),
        )
    }

    /// 1 / mass, 1/kg.
    pub fn inverse_mass(&self) -> f32 {
        self.0.0[6]
    }

    /// Least extent, m.
    pub fn extent(&self) -> f32 {
        self.0.0[7]
    }

    /// With so many times the inverse mass and inertia.
    pub(crate) fn scaled(&self, scale: f32) -> Self {
        Self::new(
            scale * self.inverse_mass(),
            &(scale * self.inverse_inertia()),
            self.extent(),
        )
    }

    /// Sets the inverse tensor.
    pub fn set_inverse_inertia(&mut self, inverse_inertia: &Mat3) {
        *self = Self::new(self.inverse_mass(), inverse_inertia, self.extent());
    }
}

impl ReadRow for BodyMass {
    #[inline(always)]
    fn numbers(&self) -> [f32; 8] {
        self.0.0
    }
}

// As one piece: built from its parts, a row would be written in pieces and read as a whole soon after, for which the
// processor has to wait until the pieces are in the cache.
impl ReadRow for SolverBody {
    #[inline(always)]
    fn numbers(&self) -> [f32; 8] {
        // SAFETY: a `SolverBody` is eight `f32` in the order of its fields (`repr(C)`, 32 bytes, so no padding).
        unsafe { std::mem::transmute::<Self, [f32; 8]>(*self) }
    }
}

impl WriteRow for SolverBody {
    #[inline(always)]
    fn of(numbers: [f32; 8]) -> Self {
        // SAFETY: as above, and any eight `f32` are a `SolverBody`.
        unsafe { std::mem::transmute::<[f32; 8], Self>(numbers) }
    }
}
