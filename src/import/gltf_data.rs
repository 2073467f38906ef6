//! The numbers in the buffers of a glTF document.
//!
//! The crate `gltf` reads the document; the numbers are read here, because files in the wild quantize positions and cut
//! buffers short.
//!
//! # References
//! - Khronos Group, *glTF 2.0 Specification*, section 3.6 (accessors, sparse ones, normalized integers).

use crate::import::error::ModelFileError;
use crate::import::model::ModelObject;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{Vec2, Vec3, Vec4};
use gltf::accessor::DataType;
use gltf::mesh::{Mode, Semantic};
use gltf::{Accessor, Document, Gltf, Primitive};

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
    /// Extensions that the file cannot do without.
    pub(super) extensions: Vec<String>,
    buffers: Vec<Vec<u8>>,
}

impl File {
    pub(super) fn open(
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
        let extensions = std::mem::take(&mut root.extensions_required);
        let used = root.extensions_used.clone();
        let document = Document::from_json(root)
            .map_err(|error| check_extensions(&used).err().unwrap_or(damaged(error)))?;
        let buffers = document
            .buffers()
            .map(|buffer| match buffer.source() {
                gltf::buffer::Source::Bin => Ok(blob.take().unwrap_or_default()),
                gltf::buffer::Source::Uri(uri) => fetch(uri, &read),
            })
            .collect::<Result<_, _>>()?;
        Ok(Self {
            document,
            extensions,
            buffers,
        })
    }

    /// The vertices of a primitive in the frame of its mesh; morph targets at their default weights, which are 0 in most files.
    pub(super) fn vertices(
        &self,
        primitive: &Primitive<'_>,
    ) -> Result<ModelObject, ModelFileError> {
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
    pub(super) fn triangles(
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
