//! Objects put together, and normals for those that have none.

use crate::import::model::ModelObject;
use glam::{Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// Faces that meet at a sharper angle than this keep a crease where a file brings no normals: cos 40 degrees.
const CREASE_COSINE: f32 = 0.766;

impl ModelObject {
    /// Adds the vertices and triangles of another object. An attribute that only one of them has is filled up.
    pub fn append(&mut self, part: Self) {
        fn join<T: Clone>(all: &mut Vec<T>, before: usize, part: Vec<T>, count: usize, default: T) {
            if all.is_empty() && part.is_empty() {
                return;
            }
            all.resize(before, default.clone());
            all.extend(part);
            all.resize(before + count, default);
        }
        let (before, count) = (self.positions.len(), part.positions.len());
        join(&mut self.normals, before, part.normals, count, Vec3::Y);
        join(&mut self.uvs, before, part.uvs, count, Vec2::ZERO);
        join(&mut self.colors, before, part.colors, count, Vec4::ONE);
        let triangles = (self.triangles.len(), part.triangles.len());
        join(
            &mut self.materials,
            triangles.0,
            part.materials,
            triangles.1,
            0,
        );
        self.positions.extend(part.positions);
        let shifted = part.triangles.iter().map(|t| t.map(|v| v + before as u32));
        self.triangles.extend(shifted);
    }

    /// Normals as the area-weighted mean of the faces around a position that meet below 40 degrees. A vertex on a crease
    /// becomes several, one for each normal.
    ///
    /// Triangles that name vertices which do not exist are left as they are; [`Model::import`](crate::import::Model::import)
    /// names them.
    pub fn with_smooth_normals(self) -> Self {
        let count = self.positions.len();
        if self
            .triangles
            .iter()
            .flatten()
            .any(|&v| v as usize >= count)
        {
            return self;
        }
        let bits = |v: u32| {
            (self.positions[v as usize] + 0.0)
                .to_array()
                .map(f32::to_bits)
        };
        let mut faces_at: HashMap<[u32; 3], Vec<Vec3>> = HashMap::new();
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| self.positions[v as usize]);
            (b - a).cross(c - a)
        };
        for t in &self.triangles {
            for &v in t {
                faces_at.entry(bits(v)).or_default().push(area(t));
            }
        }
        let mut out = Self {
            name: self.name.clone(),
            materials: self.materials.clone(),
            ..Self::default()
        };
        let mut number: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
        for t in &self.triangles {
            let face = area(t).normalize_or_zero();
            let corners = t.map(|v| {
                let around = faces_at[&bits(v)].iter();
                let together = around.filter(|n| n.normalize_or_zero().dot(face) >= CREASE_COSINE);
                let normal = together.sum::<Vec3>().try_normalize().unwrap_or(Vec3::Y);
                *number
                    .entry((v, normal.to_array().map(f32::to_bits)))
                    .or_insert_with(|| {
                        out.positions.push(self.positions[v as usize]);
                        out.normals.push(normal);
                        out.uvs.extend(self.uvs.get(v as usize));
                        out.colors.extend(self.colors.get(v as usize));
                        out.positions.len() as u32 - 1
                    })
            });
            out.triangles.push(corners);
        }
        out
    }
}
