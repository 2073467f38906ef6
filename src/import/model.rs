//! A model as a file or an artist's tool has it, and what becomes of it.

use crate::geometry::{ConvexHull, ConvexMesh, HullError, TriMesh};
use crate::import::error::ImportError;
use crate::import::holes::Holes;
use crate::import::options::ImportOptions;
use crate::import::report::ImportReport;
use crate::import::soup::Soup;
use crate::import::{orient, pairing, seams, solids};
use glam::{Vec2, Vec3, Vec4};

/// Objects with triangles, as a file has them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// The objects, all in one frame, m.
    pub objects: Vec<ModelObject>,
    /// Names of the materials that triangles name by number, if the source has names.
    pub materials: Vec<String>,
    /// What its reader has to say; becomes part of the report.
    pub notes: Vec<String>,
}

/// One object of a model. An attribute has one entry for each vertex or none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelObject {
    /// What the artist calls it.
    pub name: String,
    /// m.
    pub positions: Vec<Vec3>,
    /// Unit normals.
    pub normals: Vec<Vec3>,
    /// Texture coordinates.
    pub uvs: Vec<Vec2>,
    /// Linear RGBA.
    pub colors: Vec<Vec4>,
    /// Vertex numbers, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Material slots of the triangles, one for each; empty for slot 0.
    pub materials: Vec<u16>,
}

/// A model that can be cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Import {
    /// Closed, sheets left out.
    pub mesh: TriMesh,
    /// What was found and done.
    pub report: ImportReport,
}

impl Import {
    /// The shape of a body: the hull around the mesh, with the mesh riding in it.
    ///
    /// # Errors
    /// As [`ConvexHull::from_points`], if the model is flat, too small or too large.
    pub fn shape(&self) -> Result<ConvexMesh, HullError> {
        let points: Vec<Vec3> = self.mesh.used_positions();
        let hull = ConvexHull::from_points(&points)?;
        Ok(ConvexMesh::from_parts(hull, Some(self.mesh.clone())))
    }
}

impl Model {
    /// A model of one object.
    pub fn from_object(object: ModelObject) -> Self {
        Self {
            objects: vec![object],
            ..Self::default()
        }
    }

    /// Makes a mesh of it that can be cut; the [module](crate::import) says how.
    ///
    /// # Errors
    /// [`ImportError`] says what is wrong where, and what to do.
    pub fn import(&self, options: &ImportOptions) -> Result<Import, ImportError> {
        options.check()?;
        let mut soup = Soup::gather(self)?;
        soup.drop_doubled();
        orient::face_alike(&mut soup);
        let size = soup.size();
        pairing::pair(&mut soup);
        seams::close(&mut soup, options.weld_distance * size);
        pairing::number_fans(&mut soup);
        let holes = Holes::find(&soup, size);
        let (mesh, mut report) = solids::build(soup, holes, options)?;
        report.notes.extend(self.notes.iter().cloned());
        Ok(Import { mesh, report })
    }
}

impl ImportOptions {
    fn check(&self) -> Result<(), ImportError> {
        let thickness = match self.open_parts {
            crate::import::OpenParts::Thicken(thickness) => thickness,
            _ => 0.0,
        };
        let values = [
            ("max_fill", self.max_fill),
            ("weld_distance", self.weld_distance),
            ("the thickness of open parts", thickness),
        ];
        // NaN is not.
        let bad = |&(_, value): &(&str, f32)| !(value.is_finite() && value >= 0.0);
        match values.into_iter().find(bad) {
            Some((option, value)) => Err(ImportError::BadOption { option, value }),
            None => Ok(()),
        }
    }
}
