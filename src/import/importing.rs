//! From a model to a mesh that can be cut, step by step.

use crate::geometry::{ConvexHull, ConvexMesh, HullError, TriMesh};
use crate::import::error::ImportError;
use crate::import::holes::Holes;
use crate::import::model::Model;
use crate::import::options::{ImportOptions, OpenParts};
use crate::import::report::ImportReport;
use crate::import::soup::Soup;
use crate::import::{orient, pairing, seams, solids};
use glam::Vec3;

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
    /// Makes a mesh of it that can be cut; the [module](crate::import) says how.
    ///
    /// # Errors
    /// [`ImportError`] says what is wrong where, and what to do.
    pub fn import(&self, options: &ImportOptions) -> Result<Import, ImportError> {
        options.check()?;
        let mut soup = Soup::gather(self)?;
        soup.drop_doubled();
        let size = soup.size();
        seams::divide_at_corners(&mut soup, options.weld_distance * size);
        orient::face_alike(&mut soup);
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
            OpenParts::Thicken(thickness) => thickness,
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
