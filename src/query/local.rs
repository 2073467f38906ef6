//! Questions and answers in the frame of a body.

use crate::geometry::support::PlacedCore;
use glam::Vec3;

/// A ray in a body's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalRay {
    pub(crate) origin: Vec3,
    pub(crate) direction: Vec3,
    /// Up to where, m.
    pub(crate) end: f32,
    pub(crate) is_solid: bool,
}

impl LocalRay {
    /// What a ray hits that begins inside.
    pub(crate) fn inside(&self) -> LocalHit {
        LocalHit::at(self.origin, -self.direction, 0.0)
    }
}

/// A moved shape in a body's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalCast<'s> {
    pub(crate) core: PlacedCore<'s>,
    pub(crate) radius: f32,
    pub(crate) direction: Vec3,
    /// How far it surely goes without touching what is asked, m.
    pub(crate) free: f32,
    pub(crate) end: f32,
    pub(crate) touch: f32,
}

/// A place on a shape, in the shape's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalHit {
    pub(crate) point: Vec3,
    pub(crate) normal: Vec3,
    pub(crate) distance: f32,
    pub(crate) part: u32,
    pub(crate) triangle: Option<u32>,
    pub(crate) face: Option<u32>,
}

impl LocalHit {
    /// A place on a surface that is neither of a triangle nor of a face.
    pub(crate) fn at(point: Vec3, normal: Vec3, distance: f32) -> Self {
        Self {
            point,
            normal,
            distance,
            part: 0,
            triangle: None,
            face: None,
        }
    }
}
