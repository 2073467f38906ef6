//! Clusters: many convex parts held by bonds, which are one body until bonds break. What of them a blow or a load breaks.
//!
//! | file | holds |
//! |---|---|
//! | `building.rs` | a cluster as plain data: from parts, or by cutting a body in advance |
//! | `network.rs` | parts as masses, bonds as springs |
//! | `hit.rs` | what a cluster is hit with |
//! | `blow.rs`, `instant.rs`, `moving_part.rs`, `link.rs` | what a blow breaks: the parts around it in motion for an instant |
//! | `blast.rs` | how what comes off moves that was pushed part by part |
//! | `load.rs`, `elastic.rs`, `spring.rs`, `sparse.rs`, `removal.rs`, `dissection.rs` | what a sustained load breaks: forces as in an elastic body |
//! | `bearing.rs`, `footprint.rs` | how what is at the faces of a cluster bears and loads it |
//!
//! Must not know contacts or bodies: all is in the frame of the compound, and pushes come as numbers. Read `network.rs` first.

pub(crate) mod bearing;
mod blast;
pub(crate) mod blow;
mod building;
mod dissection;
pub(crate) mod elastic;
mod footprint;
pub(crate) mod hit;
mod instant;
mod link;
pub(crate) mod load;
mod moving_part;
pub(crate) mod network;
mod removal;
mod sparse;
mod spring;

pub use building::{Cluster, ClusterError};
