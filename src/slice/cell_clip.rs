//! A convex cell clipped plane by plane, keeping the inside only.

use crate::geometry::hull::hull_unless_flat;
use crate::geometry::predicates::{length_scale, plane_tolerance};
use crate::geometry::{ConvexHull, HullError};
use crate::math::Plane;
use crate::slice::cut::Cut;
use glam::{DVec3, Vec3};

const NONE: u32 = u32::MAX;

/// A plane that is not rounded to `f32`: the bisectors of three points meet in one line, and neighbors find the same
/// corners, only if they are not.
#[derive(Clone, Copy, Debug)]
pub(super) struct CutPlane {
    normal: DVec3,
    /// m.
    offset: f64,
    rounded: Plane,
}

impl From<Plane> for CutPlane {
    fn from(plane: Plane) -> Self {
        Self {
            normal: plane.normal.as_dvec3(),
            offset: f64::from(plane.offset),
            rounded: plane,
        }
    }
}

impl CutPlane {
    /// The plane half way between point number `index` and another one, its normal pointing to the other; none if they
    /// are at one place. Seen from the other point it is the same plane, flipped, bit for bit.
    pub(super) fn bisector(sites: &[Vec3], index: usize, other: usize) -> Option<Self> {
        let [low, high] = [index.min(other), index.max(other)].map(|site| sites[site].as_dvec3());
        let sign = if index < other { 1.0 } else { -1.0 };
        let normal = sign * (high - low).try_normalize()?;
        let middle = 0.5 * (low + high);
        let rounded = normal.as_vec3();
        Some(Self {
            normal,
            offset: normal.dot(middle),
            // The offset belongs to the rounded normal.
            rounded: Plane {
                normal: rounded,
                offset: rounded.as_dvec3().dot(middle) as f32,
            },
        })
    }

    pub(super) fn rounded(&self) -> Plane {
        self.rounded
    }

    fn distance(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

/// A face of a cell: a plane, and where its loop ends.
#[derive(Clone, Copy, Debug)]
struct CellFace {
    plane: Plane,
    end: u32,
}

/// A convex polyhedron: vertices, and faces as loops of vertex numbers, one after the other.
#[derive(Clone, Debug, Default)]
struct Polyhedron {
    vertices: Vec<DVec3>,
    faces: Vec<CellFace>,
    loops: Vec<u32>,
}

impl Polyhedron {
    fn clear(&mut self) {
        self.vertices.clear();
        self.faces.clear();
        self.loops.clear();
    }

    fn faces(&self) -> impl Iterator<Item = (Plane, &[u32])> + '_ {
        let mut first = 0;
        self.faces.iter().map(move |face| {
            let corners = &self.loops[first..face.end as usize];
            first = face.end as usize;
            (face.plane, corners)
        })
    }

    /// Ends the face whose corners were added since the last one; drops it if it has less than three.
    fn end_face(&mut self, plane: Plane) {
        let first = self.faces.last().map_or(0, |face| face.end as usize);
        if self.loops.len() - first < 3 {
            self.loops.truncate(first);
            return;
        }
        let end = self.loops.len() as u32;
        self.faces.push(CellFace { plane, end });
    }
}

/// The rim of a cut is not one simple loop.
struct IrregularCell;

/// Clips cells out of hulls, one after the other, keeping its working memory.
#[derive(Clone, Debug, Default)]
pub(super) struct CellClipper {
    cell: Polyhedron,
    /// What the cell becomes.
    next: Polyhedron,
    /// Half the thickness of a plane, m; that of the hull the cell is part of, so that all cells agree.
    tolerance: f64,
    /// Distance of each vertex from the plane, m.
    distances: Vec<f64>,
    /// New number of each vertex that stays.
    renumber: Vec<u32>,
    /// Edges with ends on both sides, and the vertex that each is cut at.
    cut_edges: Vec<([u32; 2], u32)>,
    /// Whether a new vertex is on the plane.
    is_on: Vec<bool>,
    /// By new vertex: the one after it on the rim.
    after: Vec<u32>,
}

impl CellClipper {
    /// Takes a whole hull as the cell.
    pub(super) fn load(&mut self, hull: &ConvexHull) {
        self.tolerance = f64::from(plane_tolerance(length_scale(&hull.aabb())));
        self.fill(hull);
    }

    fn fill(&mut self, hull: &ConvexHull) {
        self.cell.clear();
        self.cell
            .vertices
            .extend(hull.vertices().iter().map(|v| v.as_dvec3()));
        self.cell.loops.extend_from_slice(hull.loops());
        let faces = hull.faces().iter().map(|face| CellFace {
            plane: face.plane,
            end: face.first + face.count,
        });
        self.cell.faces.extend(faces);
    }

    /// Square of the distance (m2) from `site` beyond which no other point's bisector cuts the cell: twice the distance
    /// to the farthest vertex, squared.
    pub(super) fn security_radius_squared(&self, site: DVec3) -> f64 {
        let squares = self.cell.vertices.iter().map(|v| v.distance_squared(site));
        4.0 * squares.fold(0.0, f64::max)
    }

    /// Takes off what is above `plane`. Vertices nearer to it than the tolerance stay as they are.
    ///
    /// The verdict is [`Cut::Above`] if nothing is left; the cell is then as it was.
    pub(super) fn clip(&mut self, plane: CutPlane) -> Cut {
        self.distances.clear();
        self.distances
            .extend(self.cell.vertices.iter().map(|&v| plane.distance(v)));
        let (low, high) = self
            .distances
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &d| {
                (low.min(d), high.max(d))
            });
        if high <= self.tolerance {
            return Cut::Below;
        }
        if low >= -self.tolerance {
            return Cut::Above;
        }
        self.keep_vertices();
        self.keep_faces();
        match self.close(plane.rounded()) {
            Ok(()) => {
                std::mem::swap(&mut self.cell, &mut self.next);
                Cut::Cut(())
            }
            Err(IrregularCell) => self.rebuild(),
        }
    }

    fn keep_vertices(&mut self) {
        self.next.clear();
        self.renumber.clear();
        self.is_on.clear();
        self.cut_edges.clear();
        for (&vertex, &distance) in self.cell.vertices.iter().zip(&self.distances) {
            if distance > self.tolerance {
                self.renumber.push(NONE);
                continue;
            }
            self.renumber.push(self.next.vertices.len() as u32);
            self.next.vertices.push(vertex);
            self.is_on.push(distance >= -self.tolerance);
        }
    }

    /// Clips each face that has a vertex below; the others are not part of what is left.
    fn keep_faces(&mut self) {
        let cell = std::mem::take(&mut self.cell);
        for (plane, corners) in cell.faces() {
            if corners
                .iter()
                .all(|&v| self.distances[v as usize] >= -self.tolerance)
            {
                continue;
            }
            for (place, &from) in corners.iter().enumerate() {
                let to = corners[(place + 1) % corners.len()];
                let [d_from, d_to] = [from, to].map(|v| self.distances[v as usize]);
                if d_from <= self.tolerance {
                    self.next.loops.push(self.renumber[from as usize]);
                }
                let is_cut =
                    d_from.min(d_to) < -self.tolerance && d_from.max(d_to) > self.tolerance;
                if is_cut {
                    let cut = self.cut_vertex(&cell, [from.min(to), from.max(to)]);
                    self.next.loops.push(cut);
                }
            }
            self.next.end_face(plane);
        }
        self.cell = cell;
    }

    /// The vertex where the plane crosses an edge, one for both its faces.
    fn cut_vertex(&mut self, cell: &Polyhedron, ends: [u32; 2]) -> u32 {
        if let Some(&(_, vertex)) = self.cut_edges.iter().find(|(edge, _)| *edge == ends) {
            return vertex;
        }
        let [a, b] = ends.map(|v| cell.vertices[v as usize]);
        let [d_a, d_b] = ends.map(|v| self.distances[v as usize]);
        let vertex = self.next.vertices.len() as u32;
        self.next.vertices.push(a + d_a / (d_a - d_b) * (b - a));
        self.is_on.push(true);
        self.cut_edges.push((ends, vertex));
        vertex
    }

    /// Adds the face on the plane: the loop of edges that lack a partner, reversed.
    fn close(&mut self, plane: Plane) -> Result<(), IrregularCell> {
        self.after.clear();
        self.after.resize(self.next.vertices.len(), NONE);
        let (mut count, mut start) = (0, NONE);
        for (_, corners) in self.next.faces() {
            for (place, &from) in corners.iter().enumerate() {
                let to = corners[(place + 1) % corners.len()];
                if !(self.is_on[from as usize] && self.is_on[to as usize]) {
                    continue;
                }
                if self.after[from as usize] == to {
                    // The partner came first: the plane touches the edge from outside.
                    self.after[from as usize] = NONE;
                    count -= 1;
                } else if self.after[to as usize] == NONE {
                    self.after[to as usize] = from;
                    count += 1;
                    start = to;
                } else {
                    return Err(IrregularCell);
                }
            }
        }
        let mut at = start;
        for _ in 0..count {
            if at == NONE {
                return Err(IrregularCell);
            }
            self.next.loops.push(at);
            at = self.after[at as usize];
        }
        if count < 3 || at != start {
            return Err(IrregularCell);
        }
        self.next.end_face(plane);
        Ok(())
    }

    /// What is left as the convex hull of its points, where noise near the plane left no simple rim.
    fn rebuild(&mut self) -> Cut {
        let points: Vec<Vec3> = self.next.vertices.iter().map(|v| v.as_vec3()).collect();
        match ConvexHull::from_points(&points) {
            Ok(hull) => {
                self.fill(&hull);
                Cut::Cut(())
            }
            Err(_) => Cut::Above,
        }
    }

    /// The cell as a hull; none if it is flat.
    pub(super) fn hull(&mut self) -> Result<Option<ConvexHull>, HullError> {
        self.number_used();
        let faces: Vec<&[u32]> = self.cell.faces().map(|(_, corners)| corners).collect();
        let planes: Vec<Plane> = self.cell.faces.iter().map(|face| face.plane).collect();
        let vertices: Vec<Vec3> = self.cell.vertices.iter().map(|v| v.as_vec3()).collect();
        match ConvexHull::from_faces_and_planes(vertices.clone(), &faces, &planes) {
            Ok(hull) => Ok(Some(hull)),
            Err(_) => hull_unless_flat(&vertices),
        }
    }

    /// Drops vertices that no face uses: those on the plane of a cut whose faces are all on its far side.
    fn number_used(&mut self) {
        self.renumber.clear();
        self.renumber.resize(self.cell.vertices.len(), NONE);
        let mut used = 0;
        for corner in &mut self.cell.loops {
            let number = &mut self.renumber[*corner as usize];
            if *number == NONE {
                *number = used;
                used += 1;
            }
            *corner = *number;
        }
        self.next.vertices.clear();
        self.next.vertices.resize(used as usize, DVec3::ZERO);
        for (&vertex, &number) in self.cell.vertices.iter().zip(&self.renumber) {
            if number != NONE {
                self.next.vertices[number as usize] = vertex;
            }
        }
        std::mem::swap(&mut self.cell.vertices, &mut self.next.vertices);
    }
}

/// Whether the box of a hull is on one side of a plane, by more than the thickness of the plane.
pub(super) fn is_missed(hull: &ConvexHull, plane: &Plane) -> bool {
    let aabb = hull.aabb();
    let reach = 0.5 * plane.normal.abs().dot(aabb.extents());
    // Twice: once for points on the plane, once for the rounding of the distance itself.
    let margin = 2.0 * plane_tolerance(length_scale(&aabb));
    plane.distance(aabb.center()).abs() > reach + margin
}
