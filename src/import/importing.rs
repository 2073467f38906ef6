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
use std::fmt;

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
        let distance = weld_distance(&soup, options);
        let notes = notes(self, &soup);
        seams::divide_at_corners(&mut soup, distance);
        orient::face_alike(&mut soup);
        pairing::pair(&mut soup);
        seams::close(&mut soup, distance);
        pairing::number_fans(&mut soup);
        let holes = Holes::find(&soup);
        let far = TooFar::of(&soup);
        match solids::build(soup, holes, options) {
            Ok((mesh, mut report)) => {
                report.notes.extend(notes);
                Ok(Import { mesh, report })
            }
            Err(error) => Err(far.map_or(error, TooFar::error)),
        }
    }
}

/// How near to each other border points count as one, m: at least as near as rounding may have taken them apart, if any do.
fn weld_distance(soup: &Soup, options: &ImportOptions) -> f32 {
    match options.weld_distance {
        0.0 => 0.0,
        share => (share * soup.size()).max(soup.rounding()),
    }
}

/// What the reader of the file has to say, and what rounding may have taken from the model before it came here.
fn notes(model: &Model, soup: &Soup) -> Vec<String> {
    let mut notes = model.notes.clone();
    notes.extend(TooFar::of(soup).map(|far| far.to_string()));
    notes.extend(soup.vanished(model).into_iter().map(|name| {
        format!("'{name}' is left out: each of its triangles has two corners at one place")
    }));
    notes
}

/// Rounding as a share of a model's size above which the report tells of it: the share within which border points are one by default.
const COARSE: f32 = 1e-5;

/// A model that lies so far from the origin that its coordinates are coarse for its size.
#[derive(Clone, Copy, Debug)]
struct TooFar {
    distance: f32,
    rounding: f32,
    size: f32,
}

impl TooFar {
    fn of(soup: &Soup) -> Option<Self> {
        let (distance, size) = (soup.farthest(), soup.size());
        let rounding = f32::EPSILON * distance;
        let far = Self {
            distance,
            rounding,
            size,
        };
        (rounding > COARSE * size).then_some(far)
    }

    fn error(self) -> ImportError {
        ImportError::TooFar {
            distance: self.distance,
            rounding: self.rounding,
            size: self.size,
        }
    }
}

impl fmt::Display for TooFar {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            distance,
            rounding,
            size,
        } = self;
        write!(
            f,
            "the model of {size:.3} m lies {distance:.0} m from the origin, where coordinates are off by up to {rounding:.4} m, as all that is \
             made of it will be: move it to the origin, export it again, and place it by its transform"
        )
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
