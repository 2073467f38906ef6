//! `ConvexHull`: planes, face loops and edges of a convex polyhedron.

use crate::geometry::TriMesh;
use crate::geometry::face::Edge;
use crate::geometry::face::Face;
use crate::geometry::hull_error::{HullDefect, HullError};
use crate::geometry::hull_lanes::HullLanes;
use crate::geometry::moments::{Fans, SolidMoments};
use crate::geometry::predicates::{
    SIZE_RANGE, check_plane, convex_tolerance, length_scale, signed_distance,
};
use crate::math::{Aabb, Plane, tangents};
use crate::simd::lanes::LaneWidth;
use glam::{DVec3, Vec2, Vec3};

/// A convex polyhedron as polygon faces, in the body's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexHull {
    pub(crate) vertices: Vec<Vec3>,
    /// In the order in which their loops stand in `loops`.
    pub(crate) faces: Vec<Face>,
    pub(crate) loops: Vec<u32>,
    pub(crate) edges: Vec<Edge>,
    pub(crate) aabb: Aabb,
    /// The same numbers as the narrow phase reads them.
    pub(crate) lanes: HullLanes,
    pub(crate) moments: SolidMoments,
}

impl ConvexHull {
    /// A hull from vertices (m) and polygon faces (vertex indices, counter-clockwise seen from outside).
    ///
    /// The planes are found by Newell's formula in `f64`. Every vertex must belong to a face.
    ///
    /// # Errors
    /// [`HullError`] says which vertex or face is wrong, or what [`validate`](Self::validate) found.
    ///
    /// Source of the planes: I. Sutherland, R. Sproull, R. Schumacker, "A Characterization of Ten Hidden-Surface
    /// Algorithms", ACM Computing Surveys 6(1), 1974, who credit M. Newell.
    pub fn from_faces(vertices: Vec<Vec3>, faces: &[impl AsRef<[u32]>]) -> Result<Self, HullError> {
        check_faces(&vertices, faces)?;
        let planes = faces
            .iter()
            .enumerate()
            .map(|(face, corners)| {
                newell_plane(&vertices, corners.as_ref()).ok_or(HullError::DegenerateFace { face })
            })
            .collect::<Result<Vec<_>, _>>()?;
        Self::assemble(vertices, faces, &planes)
    }

    /// As [`from_faces`](Self::from_faces), for faces whose planes are known, such as those of a piece of another hull.
    ///
    /// A known plane is better than one through the corners of a small or narrow face, whose direction is mostly
    /// rounding error. There is one plane for each face, with its normal pointing outwards.
    ///
    /// # Errors
    /// As [`from_faces`](Self::from_faces); [`HullError::DegenerateFace`] names a face without a finite plane.
    pub fn from_faces_and_planes(
        vertices: Vec<Vec3>,
        faces: &[impl AsRef<[u32]>],
        planes: &[Plane],
    ) -> Result<Self, HullError> {
        check_faces(&vertices, faces)?;
        let usable = |face: usize| {
            planes
                .get(face)
                .is_some_and(|plane| check_plane(plane).is_ok())
        };
        if let Some(face) = (0..faces.len()).find(|&face| !usable(face)) {
            return Err(HullError::DegenerateFace { face });
        }
        Self::assemble(vertices, faces, planes)
    }

    /// Builds loops and edges of checked faces, and validates the result.
    fn assemble(
        vertices: Vec<Vec3>,
        faces: &[impl AsRef<[u32]>],
        planes: &[Plane],
    ) -> Result<Self, HullError> {
        let mut hull = Self {
            aabb: Aabb::of_points(vertices.iter().copied()),
            vertices,
            faces: Vec::with_capacity(faces.len()),
            loops: Vec::new(),
            edges: Vec::new(),
            lanes: HullLanes::default(),
            moments: SolidMoments::default(),
        };
        let size = f64::from(length_scale(&hull.aabb));
        if !SIZE_RANGE.contains(&size) {
            return Err(HullError::Size { size });
        }
        for (corners, &plane) in faces.iter().zip(planes) {
            let corners = corners.as_ref();
            hull.faces.push(Face {
                plane,
                first: hull.loops.len() as u32,
                count: corners.len() as u32,
            });
            hull.loops.extend_from_slice(corners);
        }
        hull.edges = hull.pair_edges()?;
        hull.validate()?;
        hull.lanes = HullLanes::of(&hull.vertices, &hull.faces);
        hull.moments = hull.sum_moments();
        Ok(hull)
    }

    /// A hull of nothing, to be filled in.
    pub(crate) fn empty() -> Self {
        Self {
            vertices: Vec::new(),
            faces: Vec::new(),
            loops: Vec::new(),
            edges: Vec::new(),
            aabb: Aabb::EMPTY,
            lanes: HullLanes::default(),
            moments: SolidMoments::default(),
        }
    }

    /// Pairs each directed edge with its reverse by sorting.
    fn pair_edges(&self) -> Result<Vec<Edge>, HullDefect> {
        let mut directed: Vec<DirectedEdge> = Vec::with_capacity(self.loops.len());
        for (face, corners) in self
            .faces
            .iter()
            .map(|face| self.face_loop(face))
            .enumerate()
        {
            for (corner, &from) in corners.iter().enumerate() {
                let to = corners[(corner + 1) % corners.len()];
                directed.push(DirectedEdge {
                    ends: [from.min(to), from.max(to)],
                    reversed: from > to,
                    face: face as u32,
                });
            }
        }
        directed.sort_unstable();
        let mut edges = Vec::with_capacity(directed.len() / 2);
        for run in directed.chunk_by(|a, b| a.ends == b.ends) {
            match run {
                [forward, backward] if !forward.reversed && backward.reversed => edges.push(Edge {
                    vertices: forward.ends,
                    faces: [forward.face, backward.face],
                }),
                _ => {
                    let [low, high] = run[0].ends;
                    let (from, to) = if run[0].reversed {
                        (high, low)
                    } else {
                        (low, high)
                    };
                    let face = run[0].face as usize;
                    return Err(HullDefect::Open { from, to, face });
                }
            }
        }
        Ok(edges)
    }

    /// Checks Euler's formula, that each edge has two faces, that no vertex lies outside a face by more than
    /// [`convex_tolerance`], and that the faces enclose a positive volume.
    ///
    /// # Errors
    /// The first [`HullDefect`] found.
    pub fn validate(&self) -> Result<(), HullDefect> {
        let (vertices, edges, faces) = (self.vertices.len(), self.edges.len(), self.faces.len());
        let paired = self.pair_edges()?;
        if paired.len() != edges || vertices + faces != edges + 2 {
            return Err(HullDefect::Euler {
                vertices,
                edges,
                faces,
            });
        }
        let tolerance = f64::from(convex_tolerance(length_scale(&self.aabb)));
        for (face, Face { plane, .. }) in self.faces.iter().enumerate() {
            for (vertex, &point) in self.vertices.iter().enumerate() {
                let distance = signed_distance(plane, point);
                // Written so that a NaN in the plane is a defect too.
                let inside = distance <= tolerance;
                if !inside {
                    let distance = distance as f32;
                    return Err(HullDefect::NotConvex {
                        vertex,
                        face,
                        distance,
                    });
                }
            }
        }
        let volume = self.sum_moments().volume();
        let outward = volume > 0.0;
        if !outward {
            return Err(HullDefect::Inward { volume });
        }
        Ok(())
    }

    /// Whether [`validate`](Self::validate) finds nothing.
    pub fn is_valid(&self) -> bool {
        self.validate().is_ok()
    }

    /// Volume, m3, in `f64` as it follows from the vertices.
    pub fn volume(&self) -> f64 {
        self.moments.volume()
    }

    /// The centroid, m: a point inside, as the middle of the box around the hull need not be.
    pub(crate) fn centroid(&self) -> Vec3 {
        self.moments.centroid().as_vec3()
    }

    /// The middle of the box around the hull if that is inside, else the centroid: planes through it divide the hull,
    /// a corner of a box too, of which that middle is outside.
    pub(crate) fn middle_inside(&self) -> Vec3 {
        let middle = self.aabb().center();
        let mut faces = self.faces().iter();
        let is_inside = faces.all(|face| face.plane.distance(middle) <= 0.0);
        if is_inside { middle } else { self.centroid() }
    }

    /// The moments, summed up afresh.
    fn sum_moments(&self) -> SolidMoments {
        self.sum_moments_with(&mut Fans::default(), LaneWidth::Widest)
    }

    /// The moments, summed up afresh with memory and registers that do not change the result.
    pub(crate) fn sum_moments_with(&self, fans: &mut Fans, width: LaneWidth) -> SolidMoments {
        SolidMoments::of_faces(&self.vertices, &self.faces, &self.loops, fans, width)
    }

    /// The hull moved by `offset` (m).
    pub fn translated(mut self, offset: Vec3) -> Self {
        self.vertices.iter_mut().for_each(|v| *v += offset);
        for face in &mut self.faces {
            face.plane.offset += face.plane.normal.dot(offset);
        }
        self.aabb = Aabb::of_points(self.vertices.iter().copied());
        self.lanes = HullLanes::of(&self.vertices, &self.faces);
        self.moments = self.sum_moments();
        self
    }

    /// The hull as a flat-shaded mesh: each face has vertices of its own, with the face's normal and, as texture
    /// coordinates, metres along two directions in the face's plane.
    pub fn to_mesh(&self) -> TriMesh {
        let mut mesh = TriMesh::default();
        for face in &self.faces {
            let first = mesh.positions.len() as u32;
            let [u, v] = tangents(face.plane.normal);
            for &vertex in self.face_loop(face) {
                let position = self.vertices[vertex as usize];
                mesh.positions.push(position);
                mesh.normals.push(face.plane.normal);
                mesh.uvs.push(Vec2::new(u.dot(position), v.dot(position)));
                mesh.topology.push(vertex);
            }
            mesh.triangles.extend(
                (1..face.count - 1).map(|corner| [first, first + corner, first + corner + 1]),
            );
        }
        mesh
    }

    /// Vertices, m.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// Faces.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// Vertex indices of all face loops, one after the other.
    pub fn loops(&self) -> &[u32] {
        &self.loops
    }

    /// Undirected edges, each once.
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// Bounding box in the body's frame.
    pub fn aabb(&self) -> Aabb {
        self.aabb
    }

    /// Vertex indices of one face, counter-clockwise seen from outside.
    #[inline]
    pub fn face_loop(&self, face: &Face) -> &[u32] {
        &self.loops[face.range()]
    }

    /// The loops of all faces, if they are all triangles.
    pub(crate) fn only_triangles(&self) -> Option<&[[u32; 3]]> {
        // No face has fewer corners.
        let (triangles, rest) = self.loops.as_chunks();
        (rest.is_empty() && triangles.len() == self.faces.len()).then_some(triangles)
    }

    /// Area of a face, m2.
    pub(crate) fn face_area(&self, face: &Face) -> f64 {
        let corner = |i: u32| self.vertices[i as usize].as_dvec3();
        let [first, rest @ ..] = self.face_loop(face) else {
            return 0.0;
        };
        let fan = rest.windows(2).map(|w| {
            let (u, v) = (corner(w[0]) - corner(*first), corner(w[1]) - corner(*first));
            u.cross(v)
        });
        0.5 * fan.sum::<DVec3>().length()
    }

    /// Surface area, m2, summed in `f64`.
    pub(crate) fn area(&self) -> f64 {
        self.faces.iter().map(|face| self.face_area(face)).sum()
    }

    /// The faces as triangle fans.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.faces.iter().flat_map(|face| {
            let corners = self.face_loop(face);
            corners[1..]
                .windows(2)
                .map(move |pair| [corners[0], pair[0], pair[1]])
        })
    }
}

/// A directed edge of a face, ordered so that sorting puts an edge beside its reverse.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct DirectedEdge {
    ends: [u32; 2],
    reversed: bool,
    face: u32,
}

fn check_faces(vertices: &[Vec3], faces: &[impl AsRef<[u32]>]) -> Result<(), HullError> {
    if let Some(point) = vertices.iter().position(|v| !v.is_finite()) {
        return Err(HullError::NotFinite { point });
    }
    if vertices.len() < 4 {
        return Err(HullError::TooFewPoints {
            found: vertices.len(),
        });
    }
    for (face, corners) in faces.iter().map(AsRef::as_ref).enumerate() {
        if corners.len() < 3 {
            return Err(HullError::DegenerateFace { face });
        }
        if let Some(&index) = corners.iter().find(|&&i| i as usize >= vertices.len()) {
            let vertices = vertices.len();
            return Err(HullError::IndexOutOfRange {
                face,
                index,
                vertices,
            });
        }
    }
    Ok(())
}

/// The plane of a polygon: its normal is the area vector, it goes through the mean of the corners.
///
/// For a polygon that is not quite planar this is the plane that balances the corners' distances.
pub(crate) fn newell_plane(vertices: &[Vec3], corners: &[u32]) -> Option<Plane> {
    let corner = |k: usize| vertices[corners[k % corners.len()] as usize].as_dvec3();
    let origin = corner(0);
    let mut area = DVec3::ZERO;
    let mut sum = DVec3::ZERO;
    for k in 0..corners.len() {
        let (a, b) = (corner(k) - origin, corner(k + 1) - origin);
        area += a.cross(b);
        sum += a;
    }
    let length = area.length();
    if !(length > 0.0 && length.is_finite()) {
        return None;
    }
    let normal = area / length;
    let center = origin + sum / corners.len() as f64;
    let rounded = normal.as_vec3();
    // The offset belongs to the rounded normal, or a body far from its origin would see the plane displaced.
    let offset = rounded.as_dvec3().dot(center) as f32;
    Some(Plane {
        normal: rounded,
        offset,
    })
}
