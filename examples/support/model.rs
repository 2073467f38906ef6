//! Models from OBJ, GLB and glTF files, all their objects merged into one mesh.

use super::Error;
use bevy_cleave::geometry::TriMesh;
use glam::{Mat3, Mat4, Vec2, Vec3, Vec4};
use std::collections::HashMap;
use std::path::Path;

/// Faces that meet at a sharper angle than this keep a crease where a file brings no normals: cos 40 degrees.
const CREASE_COSINE: f32 = 0.766;

/// Triangles with per-vertex attributes as a file has them; an attribute array is empty if the file has none.
#[derive(Clone, Debug, Default)]
pub struct Model {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    pub colors: Vec<Vec4>,
    pub triangles: Vec<[u32; 3]>,
}

/// Reads a model by the extension of its file name: `.obj`, `.glb` or `.gltf`.
///
/// Normals that the file lacks are computed, with creases kept.
pub fn load(path: impl AsRef<Path>) -> Result<Model, Error> {
    let path = path.as_ref();
    if !path.is_file() {
        return Err(format!("{}: no such file", path.display()).into());
    }
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    let read = match extension.to_ascii_lowercase().as_str() {
        "obj" => load_obj,
        "glb" | "gltf" => load_gltf,
        _ => {
            return Err(format!("{}: want a .obj, .glb or .gltf file", path.display()).into());
        }
    };
    let model = read(path).map_err(|e| format!("{}: {e}", path.display()))?;
    if model.triangles.is_empty() {
        return Err(format!("{}: the file has no triangles", path.display()).into());
    }
    Ok(if model.normals.is_empty() {
        model.with_smooth_normals()
    } else {
        model
    })
}

impl Model {
    /// The same model centered on the origin, its bounding box scaled to a diagonal of `diagonal` metres.
    pub fn fitted(mut self, diagonal: f32) -> Self {
        let min = self
            .positions
            .iter()
            .copied()
            .fold(Vec3::INFINITY, Vec3::min);
        let max = self
            .positions
            .iter()
            .copied()
            .fold(Vec3::NEG_INFINITY, Vec3::max);
        let scale = diagonal / (max - min).length();
        for p in &mut self.positions {
            *p = (*p - 0.5 * (min + max)) * scale;
        }
        self
    }

    /// The same model in one color (linear RGB).
    pub fn colored(mut self, color: Vec3) -> Self {
        self.colors = vec![color.extend(1.0); self.positions.len()];
        self
    }

    /// The checked mesh that bodies are made from.
    pub fn into_mesh(self) -> Result<TriMesh, Error> {
        let mut mesh = TriMesh::new(self.positions, self.triangles)?;
        if !self.normals.is_empty() {
            mesh = mesh.with_normals(self.normals)?;
        }
        if !self.uvs.is_empty() {
            mesh = mesh.with_uvs(self.uvs)?;
        }
        if !self.colors.is_empty() {
            mesh = mesh.with_colors(self.colors)?;
        }
        Ok(mesh)
    }

    /// Adds the triangles of `part`. An attribute that only one side has is filled up with `default` values.
    fn append(&mut self, part: Model) {
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
        self.positions.extend(part.positions);
        let shifted = part.triangles.iter().map(|t| t.map(|v| v + before as u32));
        self.triangles.extend(shifted);
    }

    /// Normals as the area-weighted mean of the faces around a position that meet below the crease angle.
    ///
    /// A vertex on a crease becomes several, one per normal.
    fn with_smooth_normals(self) -> Self {
        let bits = |v: u32| {
            (self.positions[v as usize] + 0.0)
                .to_array()
                .map(f32::to_bits)
        };
        let mut faces_at: HashMap<[u32; 3], Vec<Vec3>> = HashMap::new();
        let area_vectors: Vec<Vec3> = self
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| self.positions[v as usize]);
                (b - a).cross(c - a)
            })
            .collect();
        for (t, area) in self.triangles.iter().zip(&area_vectors) {
            t.iter()
                .for_each(|&v| faces_at.entry(bits(v)).or_default().push(*area));
        }
        let mut out = Self::default();
        let mut number: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
        for (t, area) in self.triangles.iter().zip(&area_vectors) {
            let face = area.normalize_or_zero();
            let corners = t.map(|v| {
                let together = faces_at[&bits(v)]
                    .iter()
                    .filter(|n| n.normalize_or_zero().dot(face) >= CREASE_COSINE);
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

fn load_obj(path: &Path) -> Result<Model, Error> {
    // A missing material file is no error here: only shapes are used.
    let (objects, _materials) = tobj::load_obj(path, &tobj::GPU_LOAD_OPTIONS)?;
    let mut model = Model::default();
    for tobj::Model { mesh, .. } in objects {
        let vectors = |flat: &[f32]| {
            flat.as_chunks()
                .0
                .iter()
                .copied()
                .map(Vec3::from_array)
                .collect()
        };
        let uvs = mesh.texcoords.as_chunks().0;
        let colors = mesh.vertex_color.as_chunks().0;
        model.append(Model {
            positions: vectors(&mesh.positions),
            normals: vectors(&mesh.normals),
            uvs: uvs.iter().copied().map(Vec2::from_array).collect(),
            colors: colors
                .iter()
                .map(|&c| Vec3::from_array(c).extend(1.0))
                .collect(),
            triangles: mesh.indices.as_chunks().0.to_vec(),
        });
    }
    Ok(model)
}

fn load_gltf(path: &Path) -> Result<Model, Error> {
    let gltf::Gltf { document, mut blob } = gltf::Gltf::from_slice(&std::fs::read(path)?)?;
    let buffers = document
        .buffers()
        .map(|buffer| match buffer.source() {
            gltf::buffer::Source::Bin => blob.take().ok_or("the binary chunk is missing".into()),
            gltf::buffer::Source::Uri(uri) if uri.starts_with("data:") => {
                Err("buffers embedded as text are not read; export as .glb".into())
            }
            gltf::buffer::Source::Uri(uri) => {
                let file = path.with_file_name(uri);
                std::fs::read(&file).map_err(|e| format!("buffer {}: {e}", file.display()).into())
            }
        })
        .collect::<Result<Vec<_>, Error>>()?;
    let scene = document
        .default_scene()
        .or_else(|| document.scenes().next())
        .ok_or("the file has no scene")?;
    let mut model = Model::default();
    for node in scene.nodes() {
        append_node(&mut model, &node, Mat4::IDENTITY, &buffers)?;
    }
    Ok(model)
}

/// Adds the triangles of `node` and of the nodes below it, in the frame of the scene.
fn append_node(
    model: &mut Model,
    node: &gltf::Node<'_>,
    scene_from_parent: Mat4,
    buffers: &[Vec<u8>],
) -> Result<(), Error> {
    let scene_from_node = scene_from_parent * Mat4::from_cols_array_2d(&node.transform().matrix());
    for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
        if primitive.mode() == gltf::mesh::Mode::Triangles {
            model.append(read_primitive(&primitive, scene_from_node, buffers)?);
        }
    }
    node.children()
        .try_for_each(|child| append_node(model, &child, scene_from_node, buffers))
}

fn read_primitive(
    primitive: &gltf::Primitive<'_>,
    scene_from_node: Mat4,
    buffers: &[Vec<u8>],
) -> Result<Model, Error> {
    let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
    let positions: Vec<Vec3> = reader
        .read_positions()
        .ok_or("a primitive has no positions")?
        .map(|p| scene_from_node.transform_point3(p.into()))
        .collect();
    let indices: Vec<u32> = match reader.read_indices() {
        Some(indices) => indices.into_u32().collect(),
        None => (0..positions.len() as u32).collect(),
    };
    // A mirrored node turns triangles inside out.
    let mirrored = scene_from_node.determinant() < 0.0;
    let turn = |[a, b, c]: [u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
    let normal_matrix = Mat3::from_mat4(scene_from_node).inverse().transpose();
    let normals = reader.read_normals().into_iter().flatten();
    let uvs = reader.read_tex_coords(0).into_iter();
    let colors = reader.read_colors(0).into_iter();
    Ok(Model {
        positions,
        normals: normals
            .map(|n| {
                (normal_matrix * Vec3::from(n))
                    .try_normalize()
                    .unwrap_or(Vec3::Y)
            })
            .collect(),
        uvs: uvs.flat_map(|t| t.into_f32()).map(Vec2::from).collect(),
        colors: colors
            .flat_map(|c| c.into_rgba_f32())
            .map(Vec4::from)
            .collect(),
        triangles: indices.as_chunks().0.iter().copied().map(turn).collect(),
    })
}
