//! The triangles of a model as one list, before anything is known of their insides.

use crate::geometry::TriMesh;
use crate::import::error::ImportError;
use crate::import::model::{Model, ModelObject};
use crate::import::report::Repairs;
use crate::math::Aabb;
use glam::{Vec2, Vec3, Vec4};

/// No half-edge.
pub(super) const NONE: u32 = u32::MAX;

/// Triangles of all objects with what is known of each.
///
/// Half-edge `3 t + k` is the edge of triangle `t` from its corner `k` to the next one.
#[derive(Clone, Debug, Default)]
pub(super) struct Soup {
    /// Its topology numbers are those of places, until [`number_fans`](super::pairing::number_fans) makes them those of
    /// surfaces at places.
    pub(super) mesh: TriMesh,
    /// By triangle: its object.
    pub(super) objects: Vec<u32>,
    /// By triangle: what was done to it and for it.
    pub(super) repairs: Vec<Repairs>,
    /// By half-edge: the other side of the edge, if it was found.
    pub(super) twins: Vec<u32>,
    /// By object.
    pub(super) names: Vec<String>,
}

impl Soup {
    /// Checks the objects of a model and puts them together. Triangles with two corners at one place are left out.
    pub(super) fn gather(model: &Model) -> Result<Self, ImportError> {
        let mut soup = Self::default();
        let has = |any: fn(&ModelObject) -> bool| model.objects.iter().any(any);
        let has_normals = has(|object| !object.normals.is_empty());
        let has_uvs = has(|object| !object.uvs.is_empty());
        let has_colors = has(|object| !object.colors.is_empty());
        let has_materials = has(|object| !object.materials.is_empty());
        for object in &model.objects {
            check(object)?;
            let first = soup.mesh.positions.len() as u32;
            let count = object.positions.len();
            soup.mesh.positions.extend(&object.positions);
            if has_normals {
                match object.normals.is_empty() {
                    true => soup.mesh.normals.extend(mean_normals(object)),
                    false => soup.mesh.normals.extend(&object.normals),
                }
            }
            if has_uvs {
                append(&mut soup.mesh.uvs, &object.uvs, count, Vec2::ZERO);
            }
            if has_colors {
                append(&mut soup.mesh.colors, &object.colors, count, Vec4::ONE);
            }
            if has_materials {
                append(
                    &mut soup.mesh.materials,
                    &object.materials,
                    object.triangles.len(),
                    0,
                );
            }
            let triangles = object.triangles.iter().map(|t| t.map(|v| first + v));
            soup.mesh.triangles.extend(triangles);
            let number = soup.names.len() as u32;
            soup.objects.resize(soup.mesh.triangles.len(), number);
            soup.names.push(object.name.clone());
        }
        if soup.mesh.triangles.is_empty() {
            return Err(ImportError::NoTriangles);
        }
        soup.repairs
            .resize(soup.mesh.triangles.len(), Repairs::default());
        let welded = TriMesh::new(soup.mesh.positions.clone(), soup.mesh.triangles.clone());
        let Ok(welded) = welded else {
            return Err(ImportError::NoTriangles);
        };
        soup.mesh.topology = welded.topology;
        soup.drop_vanished();
        Ok(soup)
    }

    /// Diagonal of the box around the model, m: what shares of its size are of.
    pub(super) fn size(&self) -> f32 {
        self.mesh.aabb().diagonal()
    }

    /// Largest coordinate, m.
    pub(super) fn farthest(&self) -> f32 {
        let Aabb { min, max } = self.mesh.aabb();
        min.abs().max(max.abs()).max_element()
    }

    /// How far apart places may be that were one before their coordinates were rounded, m: each of them by half a unit in the last
    /// place in each direction, which is up to half of `f32::EPSILON` of the largest.
    pub(super) fn rounding(&self) -> f32 {
        2.0 * f32::EPSILON * self.farthest()
    }

    /// Names of the objects of which no triangle is left.
    pub(super) fn vanished(&self, model: &Model) -> Vec<String> {
        let mut is_left = vec![false; self.names.len()];
        for &object in &self.objects {
            is_left[object as usize] = true;
        }
        let objects = model.objects.iter().zip(is_left);
        let vanished = objects.filter(|(object, is_left)| !is_left && !object.triangles.is_empty());
        vanished.map(|(object, _)| object.name.clone()).collect()
    }

    /// The places of a triangle's corners.
    pub(super) fn places(&self, triangle: usize) -> [u32; 3] {
        self.mesh.triangles[triangle].map(|vertex| self.mesh.topology[vertex as usize])
    }

    /// The places that a half-edge goes from and to.
    pub(super) fn ends(&self, half_edge: u32) -> [u32; 2] {
        self.vertices(half_edge)
            .map(|vertex| self.mesh.topology[vertex as usize])
    }

    /// The vertices that a half-edge goes from and to.
    pub(super) fn vertices(&self, half_edge: u32) -> [u32; 2] {
        let corners = self.mesh.triangles[half_edge as usize / 3];
        let corner = half_edge as usize % 3;
        [corners[corner], corners[(corner + 1) % 3]]
    }

    pub(super) fn position(&self, vertex: u32) -> Vec3 {
        self.mesh.positions[vertex as usize]
    }

    /// All half-edges by their two ends, smaller one first: runs of what lies on one edge.
    pub(super) fn sorted_edges(&self) -> Vec<([u32; 2], u32)> {
        let half_edges = 0..3 * self.mesh.triangles.len() as u32;
        let mut edges: Vec<_> = half_edges
            .map(|half_edge| {
                let [a, b] = self.ends(half_edge);
                ([a.min(b), a.max(b)], half_edge)
            })
            .collect();
        edges.sort_unstable();
        edges
    }

    /// The half-edges without another side.
    pub(super) fn open_edges(&self) -> Vec<u32> {
        let all = (0..).zip(&self.twins);
        all.filter(|&(_, &twin)| twin == NONE)
            .map(|(h, _)| h)
            .collect()
    }

    /// Drops triangles with two corners at one place; a triangle that stays at one of their places, if any, is told so.
    pub(super) fn drop_vanished(&mut self) {
        let is_left = |places: [u32; 3]| {
            let [a, b, c] = places;
            a != b && b != c && c != a
        };
        let count = self.mesh.triangles.len();
        let keep: Vec<bool> = (0..count).map(|t| is_left(self.places(t))).collect();
        if keep.iter().all(|&keep| keep) {
            return;
        }
        let mut at_place = vec![NONE; self.mesh.topology_count()];
        for triangle in (0..count).rev().filter(|&t| keep[t]) {
            let places = self.places(triangle);
            for place in places {
                at_place[place as usize] = triangle as u32;
            }
        }
        for triangle in (0..count).filter(|&t| !keep[t]) {
            let near = self.places(triangle).map(|place| at_place[place as usize]);
            if let Some(&heir) = near.iter().find(|&&triangle| triangle != NONE) {
                self.repairs[heir as usize].without_area += 1;
            }
        }
        self.retain(&keep);
    }

    /// Drops triangles that their object has before, with the same corners in the same order.
    pub(super) fn drop_doubled(&mut self) {
        let key = |soup: &Self, triangle: usize| {
            let mut places = soup.places(triangle);
            let smallest = (0..3).min_by_key(|&k| places[k]).unwrap_or(0);
            places.rotate_left(smallest);
            (places, soup.objects[triangle])
        };
        let count = self.mesh.triangles.len();
        let mut keys: Vec<_> = (0..count).map(|t| (key(self, t), t)).collect();
        keys.sort_unstable();
        let mut keep = vec![true; count];
        for same in keys.chunk_by(|a, b| a.0 == b.0) {
            for &(_, again) in &same[1..] {
                keep[again] = false;
                self.repairs[same[0].1].doubled += 1;
            }
        }
        self.retain(&keep);
    }

    fn retain(&mut self, keep: &[bool]) {
        fn retain<T>(list: &mut Vec<T>, keep: &[bool]) {
            let mut keep = keep.iter();
            list.retain(|_| keep.next().is_none_or(|&keep| keep));
        }
        retain(&mut self.mesh.triangles, keep);
        retain(&mut self.mesh.materials, keep);
        retain(&mut self.objects, keep);
        retain(&mut self.repairs, keep);
    }

    /// Adds a triangle that is like another one in all but its corners.
    pub(super) fn push_like(&mut self, corners: [u32; 3], like: usize) {
        self.mesh.triangles.push(corners);
        let material = self.mesh.materials.get(like).copied();
        self.mesh.materials.extend(material);
        self.objects.push(self.objects[like]);
        self.repairs.push(Repairs::default());
    }
}

fn append<T: Copy>(all: &mut Vec<T>, part: &[T], count: usize, default: T) {
    let end = all.len() + count;
    all.extend(part);
    all.resize(end, default);
}

fn check(object: &ModelObject) -> Result<(), ImportError> {
    let vertices = object.positions.len();
    let name = || object.name.clone();
    let lengths = [
        ("normals", object.normals.len(), vertices),
        ("texture coordinates", object.uvs.len(), vertices),
        ("colors", object.colors.len(), vertices),
        (
            "material slots",
            object.materials.len(),
            object.triangles.len(),
        ),
    ];
    for (attribute, found, wanted) in lengths {
        if found != 0 && found != wanted {
            return Err(ImportError::AttributeLength {
                object: name(),
                attribute,
                found,
                vertices: wanted,
            });
        }
    }
    let bad = [
        object.positions.iter().position(|p| !p.is_finite()),
        object.normals.iter().position(|n| !n.is_finite()),
        object.uvs.iter().position(|uv| !uv.is_finite()),
        object.colors.iter().position(|c| !c.is_finite()),
    ];
    if let Some(vertex) = bad.into_iter().flatten().next() {
        return Err(ImportError::NotFinite {
            object: name(),
            vertex,
        });
    }
    for (triangle, corners) in object.triangles.iter().enumerate() {
        if let Some(&index) = corners.iter().find(|&&v| v as usize >= vertices) {
            return Err(ImportError::IndexOutOfRange {
                object: name(),
                triangle,
                index,
                vertices,
            });
        }
    }
    Ok(())
}

/// For an object without normals among others that have some: at each vertex the mean of the triangles around it.
fn mean_normals(object: &ModelObject) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; object.positions.len()];
    for corners in &object.triangles {
        let [a, b, c] = corners.map(|vertex| object.positions[vertex as usize]);
        let area = (b - a).cross(c - a);
        for &vertex in corners {
            sums[vertex as usize] += area;
        }
    }
    sums.into_iter()
        .map(|sum| sum.normalize_or(Vec3::Y))
        .collect()
}
