//! Cutting: a plane against a closed triangle mesh, and against a convex hull.
//!
//! Works in the body's frame on plain data. Both sides are made from the same classification of the same vertices, so
//! they are exactly complementary: no gap, no overlap, no crack.
//!
//! Vertices nearer to the plane than [`plane_tolerance`] are on it and stay where they are. From then on every decision
//! follows from the three-way side of each vertex, never from a second look at coordinates. A closed mesh therefore gives
//! closed parts, whatever its shape; only the shape of the cap's triangles depends on geometry.
//!
//! # References
//! - The steps (old-vertex table, undirected-edge table, border from directed edges without partner, fan cap) are those
//!   of "Constraint-Based Physics With Real-Time Object Slicing".

mod attributes;
mod border;
mod cap;
mod clip;
pub mod convex;
mod edge_table;
pub mod fracturable;
pub mod pattern;

pub use convex::{HullHalves, HullSlice, HullSlicer, Piece, cut_by_planes, slice_hull};
pub use pattern::{FracturePattern, Impact};

use crate::geometry::predicates::{check_plane, length_scale, plane_tolerance};
use crate::geometry::{HullError, MeshError, PlaneError, TriMesh};
use crate::math::{Plane, tangents};
use attributes::CapStyle;
use cap::CapFill;
use clip::{Clip, Verdict};
use glam::Vec4;

/// What a plane does to a mesh.
#[derive(Clone, Debug, PartialEq)]
pub enum Slice {
    /// Missed: no vertex is above the plane.
    Below,
    /// Missed: no vertex is below the plane.
    Above,
    /// Cut in two.
    Cut(Box<Halves>),
}

impl Slice {
    /// The two parts, if the plane cut the mesh.
    pub fn halves(self) -> Option<Halves> {
        match self {
            Self::Cut(halves) => Some(*halves),
            Self::Below | Self::Above => None,
        }
    }
}

/// The two parts of a mesh that a plane cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Halves {
    /// The part on the side that the plane's normal points away from.
    pub below: TriMesh,
    /// The part on the side that the normal points to.
    pub above: TriMesh,
    /// The new surface, which both parts have.
    pub cap: Cap,
}

/// The new surface of a cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cap {
    /// Area, m2.
    pub area: f64,
    /// Number of closed border loops.
    pub loops: usize,
    /// Number of triangles; they are the last ones of each part.
    pub triangles: usize,
}

/// Choices for [`slice_mesh`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SliceOptions {
    /// Linear RGBA colour of the cap. Without one the cap takes the colours of its rim. If the mesh has no colours, the
    /// old surface becomes white, which leaves a texture or material as it was.
    pub cap_colour: Option<Vec4>,
}

/// Why something was not cut.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SliceError {
    /// The plane is not usable.
    #[error(transparent)]
    Plane(#[from] PlaneError),
    /// The mesh is not usable; for an open mesh, names the open edge.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A part is not a convex hull.
    #[error(transparent)]
    Hull(#[from] HullError),
}

/// Cuts a closed mesh by a plane into two closed meshes.
///
/// `plane` is in the mesh's frame (m). Seams stay seams, attributes are interpolated on cut edges, and each part gets a
/// cap with the plane's normal, texture coordinates in metres along the plane's tangents, and vertices of its own.
/// The parts share the positions of the cut bit for bit, and their volumes add up to that of the mesh.
///
/// # Errors
/// [`SliceError::Plane`] if the plane has NaN or infinite numbers or no unit normal; [`SliceError::Mesh`] if the mesh is
/// open, non-manifold or empty.
pub fn slice_mesh(
    mesh: &TriMesh,
    plane: Plane,
    options: SliceOptions,
) -> Result<Slice, SliceError> {
    check_plane(&plane)?;
    if mesh.triangles.is_empty() {
        return Err(MeshError::Empty.into());
    }
    mesh.check_closed()?;
    Ok(slice_closed(mesh, &plane, options))
}

/// As [`slice_mesh`], for a mesh that is known to be closed, such as a part of an earlier cut, and a checked plane.
fn slice_closed(mesh: &TriMesh, plane: &Plane, options: SliceOptions) -> Slice {
    let tolerance = plane_tolerance(length_scale(&mesh.aabb()));
    let sides = match clip::classify(mesh, plane, tolerance) {
        Verdict::Below => return Slice::Below,
        Verdict::Above => return Slice::Above,
        Verdict::Both(sides) => sides,
    };
    let mut clip = clip::clip(mesh, plane, &sides);
    if options.cap_colour.is_some() && clip.vertices.colours.is_empty() {
        clip.vertices.colours = vec![Vec4::ONE; clip.vertices.positions.len()];
    }
    let loops = border::loops(&clip);
    let cap = cap::fill(&mut clip, plane, &loops);
    let style = CapStyle {
        normal: plane.normal,
        tangents: tangents(plane.normal),
        colour: options.cap_colour,
    };
    let facing_below = CapStyle {
        normal: -plane.normal,
        ..style
    };
    let reversed: Vec<[u32; 3]> = cap.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    Slice::Cut(Box::new(Halves {
        below: assemble(&clip, &clip.below, &cap, &cap.triangles, &style),
        above: assemble(&clip, &clip.above, &cap, &reversed, &facing_below),
        cap: Cap {
            area: cap.area,
            loops: loops.len(),
            triangles: cap.triangles.len(),
        },
    }))
}

/// Collects one part: the vertices that its triangles use, renumbered, and its cap.
fn assemble(
    clip: &Clip,
    triangles: &[[u32; 3]],
    cap: &CapFill,
    cap_triangles: &[[u32; 3]],
    style: &CapStyle,
) -> TriMesh {
    let source = &clip.vertices;
    let mut part = TriMesh::default();
    part.triangles
        .reserve(triangles.len() + cap_triangles.len());
    let mut new_vertex = Renumber::new(source.positions.len());
    let mut new_topology = Renumber::new(clip.topology_count as usize);
    for triangle in triangles {
        let renumbered = triangle.map(|vertex| {
            let (number, is_first) = new_vertex.of(vertex);
            if is_first {
                let (topology, _) = new_topology.of(source.topology[vertex as usize]);
                attributes::push_copy(&mut part, source, vertex, topology);
            }
            number
        });
        part.triangles.push(renumbered);
    }
    let first = part.positions.len() as u32;
    for &vertex in &cap.corners {
        let (topology, _) = new_topology.of(source.topology[vertex as usize]);
        attributes::push_cap(&mut part, source, vertex, topology, style);
    }
    part.triangles
        .extend(cap_triangles.iter().map(|t| t.map(|corner| first + corner)));
    part
}

/// New numbers in the order in which old ones are first asked for.
struct Renumber {
    table: Vec<u32>,
    used: u32,
}

impl Renumber {
    const UNUSED: u32 = u32::MAX;

    fn new(count: usize) -> Self {
        Self {
            table: vec![Self::UNUSED; count],
            used: 0,
        }
    }

    /// The new number of `old`, and whether this is the first time it is asked for.
    fn of(&mut self, old: u32) -> (u32, bool) {
        let entry = &mut self.table[old as usize];
        let is_first = *entry == Self::UNUSED;
        if is_first {
            *entry = self.used;
            self.used += 1;
        }
        (*entry, is_first)
    }
}
