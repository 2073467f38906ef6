//! How a body is to be divided: planes, cells or sites.

use crate::math::Plane;
use glam::Vec3;
use smallvec::SmallVec;

/// The planes of one cell, their normals pointing out of it.
pub type CellPlanes = SmallVec<[Plane; 6]>;

/// How a body is divided, in its own frame.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Cutting {
    /// Every plane cuts every piece that it meets, one after the other.
    Planes(Planes),
    /// One piece for each list: what of the body lies below all its planes. The pieces fill the body if the cells fill
    /// space; that is for who makes the lists to see to.
    Cells(Vec<CellPlanes>),
    /// One piece for each point: what of the body is nearer to it than to all others.
    Sites(Vec<Vec3>),
}

/// The planes of an impact; up to eight without memory of its own.
pub type Planes = SmallVec<[Plane; 8]>;
