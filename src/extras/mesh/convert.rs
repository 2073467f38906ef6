//! `TriMesh` from Bevy's `Mesh`, and back.

use crate::geometry::{MeshError, TriMesh};
use crate::import::ModelObject;
use bevy_asset::RenderAssetUsages;
use bevy_math::{Vec2, Vec3, Vec4};
use bevy_mesh::{Indices, Mesh, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues};

/// Why a mesh of Bevy is no mesh of triangles that can be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshConversionError {
    /// Its vertices are the renderer's alone.
    #[error(
        "its vertices were moved to the renderer; load it with RenderAssetUsages::MAIN_WORLD as well"
    )]
    OnlyInRenderWorld,
    /// Nothing says where its vertices are.
    #[error("it has no positions in the format Float32x3")]
    NoPositions,
    /// It is made of points or lines.
    #[error("it is a {0:?} and not made of triangles")]
    NotTriangles(PrimitiveTopology),
    /// Its numbers are not usable.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// What a [`TriMesh`] has room for.
const READ: [MeshVertexAttribute; 4] = [
    Mesh::ATTRIBUTE_POSITION,
    Mesh::ATTRIBUTE_NORMAL,
    Mesh::ATTRIBUTE_UV_0,
    Mesh::ATTRIBUTE_COLOR,
];

/// Names of the attributes that a conversion of `mesh` leaves out: all but positions, normals, colors and the first set of texture
/// coordinates, and these if they are stored as anything but `f32`. Tangents are among them; [`DrawShape`] makes them anew.
///
/// [`DrawShape`]: super::DrawShape
pub fn unread_attributes(mesh: &Mesh) -> Vec<&'static str> {
    let Ok(attributes) = mesh.try_attributes() else {
        return Vec::new();
    };
    let is_read = |attribute: &MeshVertexAttribute, values: &VertexAttributeValues| {
        let known = READ.iter().find(|read| read.id == attribute.id);
        known.is_some_and(|read| read.format == values.into())
    };
    attributes
        .filter(|(attribute, values)| !is_read(attribute, values))
        .map(|(attribute, _)| attribute.name)
        .collect()
}

impl TryFrom<&Mesh> for ModelObject {
    type Error = MeshConversionError;

    /// Lists and strips of triangles, with or without indices, as [`Model::import`](crate::import::Model::import) takes them.
    /// [`unread_attributes`] are left out.
    fn try_from(mesh: &Mesh) -> Result<Self, MeshConversionError> {
        let only_drawn = |_| MeshConversionError::OnlyInRenderWorld;
        let read = |attribute: MeshVertexAttribute| mesh.try_attribute_option(attribute.id);
        let positions = read(Mesh::ATTRIBUTE_POSITION).map_err(only_drawn)?;
        let Some(VertexAttributeValues::Float32x3(positions)) = positions else {
            return Err(MeshConversionError::NoPositions);
        };
        let mut object = Self {
            positions: positions.iter().copied().map(Vec3::from).collect(),
            triangles: triangles_of(mesh, positions.len())?,
            ..Self::default()
        };
        if let Ok(Some(VertexAttributeValues::Float32x3(normals))) = read(Mesh::ATTRIBUTE_NORMAL) {
            object.normals = normals.iter().copied().map(Vec3::from).collect();
        }
        if let Ok(Some(VertexAttributeValues::Float32x2(uvs))) = read(Mesh::ATTRIBUTE_UV_0) {
            object.uvs = uvs.iter().copied().map(Vec2::from).collect();
        }
        if let Ok(Some(VertexAttributeValues::Float32x4(colors))) = read(Mesh::ATTRIBUTE_COLOR) {
            object.colors = colors.iter().copied().map(Vec4::from).collect();
        }
        Ok(object)
    }
}

fn triangles_of(mesh: &Mesh, vertices: usize) -> Result<Vec<[u32; 3]>, MeshConversionError> {
    let indices = mesh.try_indices_option();
    let indices = indices.map_err(|_| MeshConversionError::OnlyInRenderWorld)?;
    // The largest number of its type ends a strip.
    let (indices, end): (Vec<u32>, u32) = match indices {
        None => ((0..vertices as u32).collect(), u32::MAX),
        Some(Indices::U16(indices)) => (
            indices.iter().copied().map(u32::from).collect(),
            u16::MAX.into(),
        ),
        Some(Indices::U32(indices)) => (indices.clone(), u32::MAX),
    };
    match mesh.primitive_topology() {
        PrimitiveTopology::TriangleList => Ok(indices.as_chunks().0.to_vec()),
        PrimitiveTopology::TriangleStrip => {
            let strips = indices.split(|&index| index == end);
            Ok(strips.flat_map(strip).collect())
        }
        other => Err(MeshConversionError::NotTriangles(other)),
    }
}

/// The triangles of a strip: every other one is turned around.
fn strip(indices: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    let triples = indices.array_windows().enumerate();
    triples.map(|(i, &[a, b, c])| if i % 2 == 0 { [a, b, c] } else { [b, a, c] })
}

impl TryFrom<&Mesh> for TriMesh {
    type Error = MeshConversionError;

    /// Lists and strips of triangles, with or without indices. [`unread_attributes`] are left out; whether the mesh is closed is
    /// not asked.
    fn try_from(mesh: &Mesh) -> Result<Self, MeshConversionError> {
        let object = ModelObject::try_from(mesh)?;
        let mut read = Self::new(object.positions, object.triangles)?;
        if !object.normals.is_empty() {
            read = read.with_normals(object.normals)?;
        }
        if !object.uvs.is_empty() {
            read = read.with_uvs(object.uvs)?;
        }
        if !object.colors.is_empty() {
            read = read.with_colors(object.colors)?;
        }
        Ok(read)
    }
}

impl From<&TriMesh> for Mesh {
    /// All triangles, whatever their material slots; flat normals if there are none.
    fn from(mesh: &TriMesh) -> Self {
        let all: Vec<[u32; 3]> = mesh.triangles().to_vec();
        mesh.to_bevy(&all)
    }
}

impl TriMesh {
    /// A mesh of Bevy from the triangles with material slot `slot`, with flat normals if there are none; nothing if there is no such
    /// triangle. Without [`materials`](Self::materials) all is of slot 0.
    pub fn mesh_of_slot(&self, slot: u16) -> Option<Mesh> {
        let of_slot = self.triangles_of(|other| other == slot);
        (!of_slot.is_empty()).then(|| self.to_bevy(&of_slot))
    }

    /// The triangles whose material slots are picked.
    pub(super) fn triangles_of(&self, is_picked: impl Fn(u16) -> bool) -> Vec<[u32; 3]> {
        let slot_of = |i: usize| self.materials().get(i).copied().unwrap_or(0);
        let triangles = self.triangles().iter().enumerate();
        let picked = triangles.filter(|&(i, _)| is_picked(slot_of(i)));
        picked.map(|(_, &corners)| corners).collect()
    }

    /// A mesh of Bevy from some of the triangles.
    pub(super) fn to_bevy(&self, triangles: &[[u32; 3]]) -> Mesh {
        let is_smooth = !self.normals().is_empty();
        let (vertices, triangles) = if is_smooth {
            self.used_by(triangles)
        } else {
            // Each corner is a vertex of its own, so that its normal can be that of its face.
            let vertices = triangles.as_flattened().to_vec();
            let numbers: Vec<u32> = (0..vertices.len() as u32).collect();
            (vertices, numbers.as_chunks().0.to_vec())
        };
        let pick = |from: &[Vec3]| -> Vec<[f32; 3]> {
            let picked = vertices.iter().map(|&v| from[v as usize].to_array());
            picked.collect()
        };
        let indices = if vertices.len() <= usize::from(u16::MAX) {
            Indices::U16(triangles.as_flattened().iter().map(|&v| v as u16).collect())
        } else {
            Indices::U32(triangles.as_flattened().to_vec())
        };
        let positions = pick(self.positions());
        let normals = if is_smooth {
            pick(self.normals())
        } else {
            flat_normals(&positions)
        };
        let usage = RenderAssetUsages::default();
        let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, usage)
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
            .with_inserted_indices(indices);
        if !self.uvs().is_empty() {
            let uvs = vertices.iter().map(|&v| self.uvs()[v as usize].to_array());
            mesh.insert_attribute(Mesh::ATTRIBUTE_UV_0, uvs.collect::<Vec<_>>());
        }
        if !self.colors().is_empty() {
            let colors = vertices.iter();
            let colors = colors.map(|&v| self.colors()[v as usize].to_array());
            mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, colors.collect::<Vec<_>>());
        }
        mesh
    }

    /// The vertices that triangles use, in order, and the triangles by their places in that list.
    fn used_by(&self, triangles: &[[u32; 3]]) -> (Vec<u32>, Vec<[u32; 3]>) {
        let mut place = vec![u32::MAX; self.positions().len()];
        let mut vertices = Vec::new();
        let renumbered = triangles.iter().map(|corners| {
            corners.map(|v| {
                let place = &mut place[v as usize];
                if *place == u32::MAX {
                    *place = vertices.len() as u32;
                    vertices.push(v);
                }
                *place
            })
        });
        let renumbered = renumbered.collect();
        (vertices, renumbered)
    }
}

/// Of triangles whose corners are given one after the other.
fn flat_normals(corners: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let (triangles, _) = corners.as_chunks();
    let normals = triangles.iter().flat_map(|corners: &[[f32; 3]; 3]| {
        let [a, b, c] = corners.map(Vec3::from);
        [(b - a).cross(c - a).normalize_or_zero().to_array(); 3]
    });
    normals.collect()
}
