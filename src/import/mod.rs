//! A door for models as artists make them: what is closed is taken as it is, what can be closed is, the rest is told.
//!
//! A cut needs to know where inside is, so a body's mesh must be closed. Few models of game kits are: they stand on open
//! undersides, have doubled or inward faces, edges that four faces share, and leaves that are sheets. [`Model::import`]
//! goes through them in order and says in an [`ImportReport`] what it did where:
//!
//! | step | file |
//! |---|---|
//! | objects become one list of triangles; equal positions are one; triangles without area and doubled ones go | `soup.rs` |
//! | corners on the middle of another triangle's edge divide it, where that is unpaired | `seams.rs` |
//! | triangles that face against their neighbors are turned | `orient.rs` |
//! | the two sides of each edge find each other; four faces at an edge are two pairs | `pairing.rs` |
//! | border points that nearly meet are joined; corners on the middle of a border edge divide it | `seams.rs` |
//! | holes are filled, up to a share of a part's area | `holes.rs` |
//! | open parts become sheets, get a thickness or are left out | `surface.rs`, `thicken.rs` |
//! | parts that are inside out are turned, hollows stay; all become one mesh and a report | `solids.rs`, `part_report.rs` |
//!
//! [`Model`]s come from any source as objects with positions and triangles (`model.rs`), or from files: glTF and GLB with the
//! cargo feature `gltf`, OBJ with `obj`.
//!
//! Whatever the input, the mesh that comes out is closed, sheets left out, and stays so under cuts: closedness is a matter
//! of numbers and not of coordinates.
//!
//! Must not know bodies, contacts or the ECS. Read `soup.rs` first, then `solids.rs`.

mod error;
mod holes;
mod importing;
mod model;
mod model_file;
mod options;
mod orient;
mod pairing;
mod part_report;
mod report;
mod seams;
mod smooth;
mod solids;
mod soup;
mod surface;
mod thicken;

#[cfg(feature = "gltf")]
mod gltf_data;
#[cfg(feature = "gltf")]
mod gltf_file;
#[cfg(feature = "gltf")]
mod gltf_skin;
#[cfg(feature = "obj")]
mod obj_file;

pub use error::{ImportError, ModelFileError};
pub use importing::Import;
pub use model::{Model, ModelObject};
pub use options::{ImportOptions, OpenParts};
pub use report::{Hole, ImportReport, PartReport, PartState, Repairs};
