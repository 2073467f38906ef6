//! Models from OBJ, GLB and glTF files, all their objects merged into one mesh.

use super::Error;
use bevy_cleave::geometry::TriMesh;
use bevy_cleave::import::ModelObject;
use glam::{Mat3, Mat4, Vec2, Vec3, Vec4};
use std::path::Path;

/// Reads a model by the extension of its file name: `.obj`, `.glb` or `.gltf`.
///
/// Normals that the file lacks are computed, with creases kept.
pub fn load(path: impl AsRef<Path>) -> Result<ModelObject, Error> {
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

/// The model centered on the origin, its bounding box scaled to a diagonal of `diagonal` metres.
pub fn fitted(mut model: ModelObject, diagonal: f32) -> ModelObject {
    let positions = &mut model.positions;
    let min = positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let max = positions
        .iter()
        .copied()
        .fold(Vec3::NEG_INFINITY, Vec3::max);
    let scale = diagonal / (max - min).length();
    for p in positions {
        *p = (*p - 0.5 * (min + max)) * scale;
    }
    model
}

/// The model in one color (linear RGB).
pub fn colored(mut model: ModelObject, color: Vec3) -> ModelObject {
    model.colors = vec![color.extend(1.0); model.positions.len()];
    model
}

/// The checked mesh that bodies are made from.
pub fn into_mesh(model: ModelObject) -> Result<TriMesh, Error> {
    let mut mesh = TriMesh::new(model.positions, model.triangles)?;
    if !model.normals.is_empty() {
        mesh = mesh.with_normals(model.normals)?;
    }
    if !model.uvs.is_empty() {
        mesh = mesh.with_uvs(model.uvs)?;
    }
    if !model.colors.is_empty() {
        mesh = mesh.with_colors(model.colors)?;
    }
    Ok(mesh)
}

fn load_obj(path: &Path) -> Result<ModelObject, Error> {
    // A missing material file is no error here: only shapes are used.
    let (objects, _materials) = tobj::load_obj(path, &tobj::GPU_LOAD_OPTIONS)?;
    let mut model = ModelObject::default();
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
        model.append(ModelObject {
            positions: vectors(&mesh.positions),
            normals: vectors(&mesh.normals),
            uvs: uvs.iter().copied().map(Vec2::from_array).collect(),
            colors: colors
                .iter()
                .map(|&c| Vec3::from_array(c).extend(1.0))
                .collect(),
            triangles: mesh.indices.as_chunks().0.to_vec(),
            ..ModelObject::default()
        });
    }
    Ok(model)
}

fn load_gltf(path: &Path) -> Result<ModelObject, Error> {
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
    let mut model = ModelObject::default();
    for node in scene.nodes() {
        append_node(&mut model, &node, Mat4::IDENTITY, &buffers)?;
    }
    Ok(model)
}

/// Adds the triangles of `node` and of the nodes below it, in the frame of the scene.
fn append_node(
    model: &mut ModelObject,
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
) -> Result<ModelObject, Error> {
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
    Ok(ModelObject {
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
        ..ModelObject::default()
    })
}
