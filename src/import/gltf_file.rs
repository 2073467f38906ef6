//! Models from glTF and GLB files.
//!
//! The crate `gltf` reads the document; the numbers in its buffers are read here, because files in the wild quantize
//! positions and cut buffers short.
//!
//! # References
//! - Khronos Group, *glTF 2.0 Specification*, sections 3.6 (accessors, sparse ones, normalized integers) and 3.7 (meshes, skins).

use crate::import::error::ModelFileError;
use crate::import::gltf_skin::Skeleton;
use crate::import::model::{Model, ModelObject};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{Mat3, Mat4, Vec2, Vec3, Vec4};
use gltf::accessor::DataType;
use gltf::mesh::{Mode, Semantic};
use gltf::{Accessor, Document, Gltf, Node, Primitive};

/// Extensions that shapes are hidden behind, and what users know them as.
const COMPRESSION: [(&str, &str); 3] = [
    ("KHR_draco_mesh_compression", "Draco"),
    ("EXT_meshopt_compression", "meshopt (gltfpack)"),
    ("KHR_meshopt_compression", "meshopt"),
];

/// Extensions that place or make shapes in ways that are not read.
const SHAPES: [&str; 2] = ["EXT_mesh_gpu_instancing", "KHR_gaussian_splatting"];

/// A document with the bytes of its buffers.
pub(super) struct File {
    pub(super) document: Document,
    buffers: Vec<Vec<u8>>,
}

impl Model {
    /// A model from the bytes of a .gltf or .glb file: the nodes of its scene, each an object in the scene's frame, skins as
    /// they are at rest. `read` gives the bytes of a file that is named by the document, relative to it; data within the
    /// document is read without it.
    ///
    /// # Errors
    /// [`ModelFileError`] says what is missing, damaged or compressed.
    pub fn from_gltf(
        bytes: &[u8],
        read: impl Fn(&str) -> std::io::Result<Vec<u8>>,
    ) -> Result<Self, ModelFileError> {
        let file = File::open(bytes, read)?;
        let mut model = Self {
            materials: (file.document.materials())
                .map(|material| material.name().unwrap_or("unnamed").to_string())
                .collect(),
            ..Self::default()
        };
        model.note_extensions(&file.document);
        let skeleton = Skeleton::of(&file)?;
        for (node, scene_from_node) in skeleton.nodes() {
            model.append_node(&file, &skeleton, node, *scene_from_node)?;
        }
        Ok(model)
    }

    fn note_extensions(&mut self, document: &Document) {
        for extension in document.extensions_required() {
            if extension != "KHR_mesh_quantization" {
                self.notes.push(format!(
                    "the extension {extension} is left out; it does not change shapes"
                ));
            }
        }
    }

    fn append_node(
        &mut self,
        file: &File,
        skeleton: &Skeleton<'_>,
        node: &Node<'_>,
        scene_from_node: Mat4,
    ) -> Result<(), ModelFileError> {
        let Some(mesh) = node.mesh() else {
            return Ok(());
        };
        let unnamed = || format!("node {}", node.index());
        let name = node
            .name()
            .or(mesh.name())
            .map_or_else(unnamed, str::to_string);
        let mut object = ModelObject {
            name,
            ..ModelObject::default()
        };
        for primitive in mesh.primitives() {
            let Some(triangles) = file.triangles(&primitive)? else {
                self.notes
                    .push(format!("points or lines of '{}' are left out", object.name));
                continue;
            };
            let mut part = file.vertices(&primitive)?;
            let mirrored = skeleton.place(file, node, &primitive, scene_from_node, &mut part)?;
            let turn = |[a, b, c]: [u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
            part.triangles = triangles.into_iter().map(turn).collect();
            let slot = primitive.material().index().unwrap_or(self.materials.len());
            part.materials = vec![slot as u16; part.triangles.len()];
            if part.normals.is_empty() {
                part = part.with_smooth_normals();
            }
            object.append(part);
        }
        if !object.triangles.is_empty() {
            self.objects.push(object);
        }
        Ok(())
    }
}

impl File {
    fn open(
        bytes: &[u8],
        read: impl Fn(&str) -> std::io::Result<Vec<u8>>,
    ) -> Result<Self, ModelFileError> {
        let damaged = |error: gltf::Error| ModelFileError::Damaged {
            reason: error.to_string(),
        };
        let Gltf { document, mut blob } =
            Gltf::from_slice_without_validation(bytes).map_err(damaged)?;
        let mut root = document.into_json();
        check_extensions(&root.extensions_required)?;
        // The crate refuses what it does not know, although materials and lights change no shape.
        root.extensions_required.clear();
        let document = Document::from_json(root).map_err(damaged)?;
        let buffers = document
            .buffers()
            .map(|buffer| match buffer.source() {
                gltf::buffer::Source::Bin => Ok(blob.take().unwrap_or_default()),
                gltf::buffer::Source::Uri(uri) => fetch(uri, &read),
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { document, buffers })
    }

    /// The vertices of a primitive in the frame of its mesh; morph targets at their default weights, which are 0 in most files.
    fn vertices(&self, primitive: &Primitive<'_>) -> Result<ModelObject, ModelFileError> {
        let missing = || self.missing("the positions of a mesh".to_string());
        let positions = primitive.get(&Semantic::Positions).ok_or_else(missing)?;
        let positions: Vec<Vec3> = self.read(&positions)?.into_iter().map(Vec3::from).collect();
        let count = positions.len();
        let fits = |accessor: &Accessor<'_>| accessor.count() == count;
        let normals = primitive.get(&Semantic::Normals).filter(fits);
        let uvs = primitive.get(&Semantic::TexCoords(0)).filter(fits);
        let colors = primitive.get(&Semantic::Colors(0)).filter(fits);
        Ok(ModelObject {
            positions,
            normals: self
                .read_all(normals)?
                .into_iter()
                .map(Vec3::from)
                .collect(),
            uvs: self.read_all(uvs)?.into_iter().map(Vec2::from).collect(),
            // Colors without alpha are read with 1.
            colors: self
                .read_all::<4>(colors)?
                .into_iter()
                .map(Vec4::from)
                .collect(),
            ..ModelObject::default()
        })
    }

    /// The triangles of a primitive, strips and fans taken apart; none of points and lines.
    fn triangles(
        &self,
        primitive: &Primitive<'_>,
    ) -> Result<Option<Vec<[u32; 3]>>, ModelFileError> {
        let indices: Vec<u32> = match primitive.indices() {
            Some(accessor) => self
                .read::<1>(&accessor)?
                .into_iter()
                .map(|[i]| i as u32)
                .collect(),
            None => {
                let positions = primitive.get(&Semantic::Positions);
                (0..positions.map_or(0, |accessor| accessor.count() as u32)).collect()
            }
        };
        let triangles = match primitive.mode() {
            Mode::Triangles => indices.as_chunks().0.to_vec(),
            Mode::TriangleStrip => (indices.windows(3).enumerate())
                .map(|(i, t)| {
                    if i % 2 == 0 {
                        [t[0], t[1], t[2]]
                    } else {
                        [t[1], t[0], t[2]]
                    }
                })
                .collect(),
            Mode::TriangleFan => (indices.windows(2).skip(1))
                .map(|t| [indices[0], t[0], t[1]])
                .collect(),
            Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => return Ok(None),
        };
        Ok(Some(triangles))
    }

    /// As [`read`](Self::read); nothing of nothing.
    pub(super) fn read_all<const N: usize>(
        &self,
        accessor: Option<Accessor<'_>>,
    ) -> Result<Vec<[f32; N]>, ModelFileError> {
        accessor.map_or_else(|| Ok(Vec::new()), |accessor| self.read(&accessor))
    }

    /// The numbers of an accessor as floats, normalized integers from their range; components that it does not have are 1.
    pub(super) fn read<const N: usize>(
        &self,
        accessor: &Accessor<'_>,
    ) -> Result<Vec<[f32; N]>, ModelFileError> {
        let width = accessor.dimensions().multiplicity();
        let (kind, is_normalized) = (accessor.data_type(), accessor.normalized());
        let item = |bytes: &[u8]| -> [f32; N] {
            std::array::from_fn(|k| match k < width {
                true => number(&bytes[k * kind.size()..], kind, is_normalized),
                false => 1.0,
            })
        };
        let mut items = match accessor.view() {
            Some(view) => {
                let stride = view.stride().unwrap_or(accessor.size());
                let bytes = self.bytes(
                    &view,
                    accessor.offset(),
                    accessor.count(),
                    stride,
                    accessor.size(),
                )?;
                bytes.chunks(stride.max(1)).map(item).collect()
            }
            None if accessor.sparse().is_some() => vec![[0.0; N]; accessor.count()],
            None => return Err(self.missing(format!("the data of accessor {}", accessor.index()))),
        };
        if let Some(sparse) = accessor.sparse() {
            let (count, indices, values) = (sparse.count(), sparse.indices(), sparse.values());
            let index_kind = match indices.index_type() {
                gltf::accessor::sparse::IndexType::U8 => DataType::U8,
                gltf::accessor::sparse::IndexType::U16 => DataType::U16,
                gltf::accessor::sparse::IndexType::U32 => DataType::U32,
            };
            let (size, value_size) = (index_kind.size(), accessor.size());
            let places = self.bytes(&indices.view(), indices.offset(), count, size, size)?;
            let new = self.bytes(
                &values.view(),
                values.offset(),
                count,
                value_size,
                value_size,
            )?;
            for (place, value) in places.chunks(size).zip(new.chunks(value_size)) {
                let place = number(place, index_kind, false) as usize;
                if let Some(target) = items.get_mut(place) {
                    *target = item(value);
                }
            }
        }
        Ok(items)
    }

    /// The bytes of `count` items of `size` bytes, `stride` bytes apart, the last one without what follows it.
    fn bytes(
        &self,
        view: &gltf::buffer::View<'_>,
        offset: usize,
        count: usize,
        stride: usize,
        size: usize,
    ) -> Result<&[u8], ModelFileError> {
        let first = view.offset() + offset;
        let length =
            count.saturating_sub(1).saturating_mul(stride) + if count == 0 { 0 } else { size };
        let buffer = self.buffers.get(view.buffer().index());
        let bytes = buffer.and_then(|b| b.get(first..first.checked_add(length)?));
        bytes.ok_or_else(|| self.missing(format!("data of buffer {}", view.buffer().index())))
    }

    /// Data is missing: because it is compressed, where the file says so.
    fn missing(&self, what: String) -> ModelFileError {
        let used: Vec<String> = self
            .document
            .extensions_used()
            .map(str::to_string)
            .collect();
        match check_extensions(&used) {
            Err(error) => error,
            Ok(()) => ModelFileError::MissingData { what },
        }
    }
}

/// One component of an item.
fn number(bytes: &[u8], kind: DataType, is_normalized: bool) -> f32 {
    let b = |k: usize| bytes[k];
    let (value, range) = match kind {
        DataType::I8 => (f32::from(b(0) as i8), 127.0),
        DataType::U8 => (f32::from(b(0)), 255.0),
        DataType::I16 => (f32::from(i16::from_le_bytes([b(0), b(1)])), 32767.0),
        DataType::U16 => (f32::from(u16::from_le_bytes([b(0), b(1)])), 65535.0),
        DataType::U32 => (
            u32::from_le_bytes([b(0), b(1), b(2), b(3)]) as f32,
            u32::MAX as f32,
        ),
        DataType::F32 => return f32::from_le_bytes([b(0), b(1), b(2), b(3)]),
    };
    if is_normalized {
        (value / range).max(-1.0)
    } else {
        value
    }
}

fn check_extensions(required: &[String]) -> Result<(), ModelFileError> {
    for extension in required {
        if let Some((_, method)) = COMPRESSION.iter().find(|(name, _)| name == extension) {
            return Err(ModelFileError::Compressed {
                method,
                extension: extension.clone(),
            });
        }
        if SHAPES.contains(&extension.as_str()) {
            return Err(ModelFileError::Extension {
                extension: extension.clone(),
            });
        }
    }
    Ok(())
}

/// The bytes behind a URI: base64 within it, or a file.
fn fetch(
    uri: &str,
    read: impl Fn(&str) -> std::io::Result<Vec<u8>>,
) -> Result<Vec<u8>, ModelFileError> {
    let Some(data) = uri.strip_prefix("data:") else {
        let path = percent_decoded(uri);
        return read(&path).map_err(|error| ModelFileError::Unreadable { path, error });
    };
    let damaged = |reason: String| ModelFileError::Damaged { reason };
    let encoded = data.split_once(";base64,").map(|(_, encoded)| encoded);
    let encoded = encoded.ok_or_else(|| damaged("data in a URI that is not base64".to_string()))?;
    STANDARD
        .decode(encoded.trim())
        .map_err(|error| damaged(error.to_string()))
}

/// A path in which `%20` stands for a space, and the like.
fn percent_decoded(uri: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = uri.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let hex = after.get(..2).and_then(|hex| std::str::from_utf8(hex).ok());
        let code = hex.and_then(|hex| u8::from_str_radix(hex, 16).ok());
        match code.filter(|_| first == b'%') {
            Some(code) => {
                bytes.push(code);
                rest = &after[2..];
            }
            None => {
                bytes.push(first);
                rest = after;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

impl ModelObject {
    /// Moves an object by a matrix; whether that mirrors it.
    pub(super) fn transform(&mut self, matrix: Mat4) -> bool {
        let normal_matrix = Mat3::from_mat4(matrix).inverse().transpose();
        for position in &mut self.positions {
            *position = matrix.transform_point3(*position);
        }
        for normal in &mut self.normals {
            *normal = (normal_matrix * *normal).try_normalize().unwrap_or(Vec3::Y);
        }
        matrix.determinant() < 0.0
    }
}
