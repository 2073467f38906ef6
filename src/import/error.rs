//! Why a model is refused, and what to do about it.

use crate::import::report::ImportReport;
use glam::Vec3;

/// Why a model is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// The model has no triangles.
    #[error(
        "the model has no triangles; check that the export holds meshes, and not only curves, lights or empty objects"
    )]
    NoTriangles,
    /// A coordinate or an attribute is NaN or infinite.
    #[error(
        "vertex {vertex} of '{object}' is not a finite point; apply or reset the object's transform and export again"
    )]
    NotFinite {
        /// Name of the object.
        object: String,
        /// Number of the vertex in the object.
        vertex: usize,
    },
    /// A triangle names a vertex that the object does not have.
    #[error(
        "triangle {triangle} of '{object}' names vertex {index} of {vertices}; the file is damaged, export it again"
    )]
    IndexOutOfRange {
        /// Name of the object.
        object: String,
        /// Number of the triangle in the object.
        triangle: usize,
        /// The vertex it names.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// An attribute has neither no entry nor one for each vertex.
    #[error(
        "'{object}' has {found} {attribute} for {vertices} vertices; leave them out or give one for each"
    )]
    AttributeLength {
        /// Name of the object.
        object: String,
        /// Which attribute.
        attribute: &'static str,
        /// Entries found.
        found: usize,
        /// Number of vertices.
        vertices: usize,
    },
    /// An option is not usable.
    #[error("{option} must be a finite number that is not negative, got {value}")]
    BadOption {
        /// Which one.
        option: &'static str,
        /// Its value.
        value: f32,
    },
    /// Nothing solid is left of the model, as it lies so far from the origin that coordinates are coarse beside its size.
    #[error(
        "the model of {size:.3} m lies {distance:.0} m from the origin, where coordinates are off by up to {rounding:.4} m, so that nothing \
         solid is left of it: move it to the origin, export it again, and place it by its transform"
    )]
    TooFar {
        /// Its largest coordinate, m.
        distance: f32,
        /// By how much coordinates there may be off, m.
        rounding: f32,
        /// Diagonal of the box around it, m.
        size: f32,
    },
    /// No part encloses anything, as the report says part by part.
    #[error(
        "no part of the model is solid; the largest, {name} at {center}, would need new faces of {share:.2} of its area: allow that with \
         max_fill, or give open parts a thickness with OpenParts::Thicken"
    )]
    NothingSolid {
        /// The largest part.
        name: String,
        /// Its middle, m.
        center: Vec3,
        /// Area of the new faces that would close it, as a share of its own.
        share: f32,
        /// All parts.
        report: Box<ImportReport>,
    },
}

/// Why a file is not read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelFileError {
    /// The file or one that it needs cannot be opened.
    #[error(
        "{path} cannot be read ({error}); a .gltf needs the .bin files beside it, a .glb holds everything"
    )]
    Unreadable {
        /// Which file.
        path: String,
        /// Why.
        error: std::io::Error,
    },
    /// The ending of the file's name is unknown, or its cargo feature is off.
    #[error(
        "'.{extension}' files are not read here; export as .glb, .gltf (feature `gltf`) or .obj (feature `obj`)"
    )]
    UnknownFormat {
        /// The ending.
        extension: String,
    },
    /// The geometry is compressed.
    #[error(
        "the geometry is compressed with {method} ({extension}), which is not read; export without compression"
    )]
    Compressed {
        /// What the method is called.
        method: &'static str,
        /// The extension of the file format.
        extension: String,
    },
    /// The file says that it cannot be read without an extension that shapes depend on.
    #[error("the file needs the extension {extension}, which is not read; export without it")]
    Extension {
        /// Its name.
        extension: String,
    },
    /// Data that the file refers to is not there.
    #[error("{what} is missing or too short; the file is damaged or incomplete, export it again")]
    MissingData {
        /// What.
        what: String,
    },
    /// The file is not what its name says.
    #[error("the file is damaged: {reason}; export it again")]
    Damaged {
        /// What the reader says.
        reason: String,
    },
}
