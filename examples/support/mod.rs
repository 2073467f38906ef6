//! What the examples share: models from files, pictures, plots, and a few statistics.
//!
//! Include it with `#[path = "support/mod.rs"] mod support;`. Frames are right-handed with y up, lengths in metres.

#![allow(dead_code, reason = "each example uses a part of this")]
#![allow(
    unreachable_pub,
    reason = "nothing of an example can be reached from outside"
)]
#![allow(
    clippy::disallowed_methods,
    reason = "pictures may differ in the last bit between platforms"
)]

pub mod chart;
pub mod colors;
pub mod film;
pub mod light;
pub mod masonry;
pub mod model;
pub mod picture;
pub mod plot;
pub mod raster;
pub mod render;
pub mod scene;
pub mod stats;

/// The error of everything here: a sentence for the person who runs the example.
pub type Error = Box<dyn std::error::Error + Send + Sync>;

/// The model that examples use unless they are given another one.
pub const DEFAULT_MODEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/meshes/penguin.obj");
