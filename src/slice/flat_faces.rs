//! Which triangles of a mesh are one flat face, as an artist's model or a file has them.
//!
//! Triangles are one face if they hang together, lie in one plane, have one material slot, and if their attributes are one affine
//! function of the position: then the face looks the same however it is divided.

use crate::geometry::TriMesh;
use crate::geometry::predicates::{length_scale, plane_tolerance};
use glam::{DVec3, Vec2, Vec3, Vec4};

/// No triangle, no face.
const NONE: u32 = u32::MAX;

/// How far texture coordinates and colors may be from the affine function, as a share of the largest or of 1.
const ATTRIBUTE_TOLERANCE: f32 = 2e-5;

/// How far unit normals may be from the affine function: a third of what 8-bit normal maps resolve.
const NORMAL_TOLERANCE: f32 = 1e-3;

/// The number of the face of each triangle. Numbers are those of triangles, so a number from that of the triangles on is free.
pub(crate) fn flat_faces(mesh: &TriMesh) -> Vec<u32> {
    let mut faces: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
    let finder = Finder {
        mesh,
        neighbors: neighbors(mesh),
        tolerance: f64::from(plane_tolerance(length_scale(&mesh.aabb()))),
    };
    // Most triangles of most models have no neighbor in their plane; only the others are sorted by size.
    let mut seeds: Vec<(f64, u32)> = (mesh.sheets..mesh.triangles.len() as u32)
        .filter(|&t| {
            finder.neighbors[t as usize]
                .iter()
                .any(|&n| n != NONE && finder.is_flat(t, n))
        })
        .map(|t| (finder.area(t).length_squared(), t))
        .collect();
    seeds.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut is_done = vec![false; mesh.triangles.len()];
    let mut members = Vec::new();
    for (_, seed) in seeds {
        if std::mem::replace(&mut is_done[seed as usize], true) {
            continue;
        }
        let plane = Frame::of(mesh, seed);
        members.clear();
        members.push(seed);
        let mut next = 0;
        while next < members.len() {
            let triangle = members[next];
            next += 1;
            for across in finder.neighbors[triangle as usize] {
                if across != NONE && !is_done[across as usize] && finder.joins(&plane, seed, across)
                {
                    is_done[across as usize] = true;
                    members.push(across);
                }
            }
        }
        let first = members.iter().copied().min().unwrap_or(seed);
        members.iter().for_each(|&t| faces[t as usize] = first);
    }
    faces
}

struct Finder<'a> {
    mesh: &'a TriMesh,
    neighbors: Vec<[u32; 3]>,
    /// m.
    tolerance: f64,
}

impl Finder<'_> {
    fn position(&self, vertex: u32) -> DVec3 {
        self.mesh.positions[vertex as usize].as_dvec3()
    }

    /// Twice the area of a triangle along its normal, m2.
    fn area(&self, triangle: u32) -> DVec3 {
        let [a, b, c] = self.mesh.triangles[triangle as usize].map(|v| self.position(v));
        (b - a).cross(c - a)
    }

    /// Whether the corners of one of two triangles are in the plane of the other.
    fn is_flat(&self, a: u32, b: u32) -> bool {
        let lies_in = |corners: u32, plane: u32| {
            let normal = self.area(plane);
            let base = self.position(self.mesh.triangles[plane as usize][0]);
            let limit = self.tolerance * normal.length();
            (self.mesh.triangles[corners as usize].iter())
                .all(|&v| normal.dot(self.position(v) - base).abs() <= limit)
        };
        lies_in(b, a) || lies_in(a, b)
    }

    /// Whether a triangle is in the plane of a face, faces the same way and has its attributes.
    fn joins(&self, plane: &Frame, seed: u32, triangle: u32) -> bool {
        let mesh = self.mesh;
        let corners = mesh.triangles[triangle as usize];
        let is_near =
            |&v: &u32| plane.normal.dot(self.position(v) - plane.origin).abs() <= self.tolerance;
        let area = self.area(triangle);
        let longest =
            corners.map(|v| (self.position(v) - self.position(corners[0])).length_squared());
        // One without area faces anywhere.
        let is_sliver = area.length() <= self.tolerance * longest[1].max(longest[2]).sqrt();
        let slot = |t: u32| mesh.materials.get(t as usize);
        corners.iter().all(is_near)
            && (is_sliver || area.dot(plane.normal) > 0.0)
            && slot(seed) == slot(triangle)
            && corners.iter().all(|&v| plane.has_attributes(mesh, v))
    }
}

/// The plane of a triangle, and its attributes as affine functions: `value = at + u along + v across`.
struct Frame {
    origin: DVec3,
    normal: DVec3,
    /// Rows of the inverse of the triangle's edges, 1/m.
    rows: [DVec3; 2],
    corners: [u32; 3],
}

impl Frame {
    fn of(mesh: &TriMesh, triangle: u32) -> Self {
        let corners = mesh.triangles[triangle as usize];
        let [a, b, c] = corners.map(|v| mesh.positions[v as usize].as_dvec3());
        let (u, v) = (b - a, c - a);
        let area = u.cross(v);
        let scale = 1.0 / area.length_squared().max(f64::MIN_POSITIVE);
        Self {
            origin: a,
            normal: area.normalize_or_zero(),
            rows: [v.cross(area) * scale, area.cross(u) * scale],
            corners,
        }
    }

    /// Whether a vertex in the plane has the attributes that the functions have there.
    fn has_attributes(&self, mesh: &TriMesh, vertex: u32) -> bool {
        let offset = mesh.positions[vertex as usize].as_dvec3() - self.origin;
        let [s, t] = self.rows.map(|row| row.dot(offset) as f32);
        let near = |error: f32, size: f32| error <= ATTRIBUTE_TOLERANCE * size.max(1.0);
        let is_normal = expected(&mesh.normals, self.corners, s, t, Vec3::ZERO).is_none_or(|n| {
            n.normalize_or_zero()
                .distance(mesh.normals[vertex as usize])
                <= NORMAL_TOLERANCE
        });
        let is_color = expected(&mesh.colors, self.corners, s, t, Vec4::ZERO).is_none_or(|c| {
            let own = mesh.colors[vertex as usize];
            near((c - own).abs().max_element(), own.abs().max_element())
        });
        let is_uv = expected(&mesh.uvs, self.corners, s, t, Vec2::ZERO).is_none_or(|uv| {
            let own = mesh.uvs[vertex as usize];
            near((uv - own).abs().max_element(), own.abs().max_element())
        });
        is_normal && is_color && is_uv
    }
}

/// An attribute at a point of a triangle's plane; none of none.
fn expected<T>(values: &[T], corners: [u32; 3], s: f32, t: f32, _: T) -> Option<T>
where
    T: Copy
        + std::ops::Add<Output = T>
        + std::ops::Sub<Output = T>
        + std::ops::Mul<f32, Output = T>,
{
    let value = |k: usize| values.get(corners[k] as usize).copied();
    let (a, b, c) = (value(0)?, value(1)?, value(2)?);
    Some(a + (b - a) * s + (c - a) * t)
}

/// For each solid triangle those across its edges.
fn neighbors(mesh: &TriMesh) -> Vec<[u32; 3]> {
    let count = mesh.topology_count();
    let solid = mesh.sheets..mesh.triangles.len() as u32;
    let numbers = |t: u32| mesh.triangles[t as usize].map(|v| mesh.topology[v as usize]);
    // Half-edges by the position that they leave, sorted by counting.
    let mut ends = vec![0_u32; count + 1];
    for t in solid.clone() {
        for number in numbers(t) {
            ends[number as usize + 1] += 1;
        }
    }
    for place in 0..count {
        ends[place + 1] += ends[place];
    }
    let mut fill = ends.clone();
    let mut leaving = vec![(0, 0); 3 * solid.len()];
    for t in solid.clone() {
        let [a, b, c] = numbers(t);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let place = &mut fill[from as usize];
            leaving[*place as usize] = (to, t);
            *place += 1;
        }
    }
    let mut neighbors = vec![[NONE; 3]; mesh.triangles.len()];
    for t in solid {
        let [a, b, c] = numbers(t);
        neighbors[t as usize] = [(a, b), (b, c), (c, a)].map(|(from, to)| {
            let [first, end] = [0, 1].map(|k| ends[to as usize + k] as usize);
            let back = leaving[first..end]
                .iter()
                .find(|&&(other, _)| other == from);
            back.map_or(NONE, |&(_, across)| across)
        });
    }
    neighbors
}
