//! One mixed linear complementarity problem, and the methods that solve it.

pub mod adaptivity;
pub mod batch;
mod breakage_probe;
pub mod config;
pub mod contact_solver;
mod deferral;
mod estimates;
#[cfg(feature = "exact")]
pub mod exact;
mod free_flight;
pub mod graph;
pub mod results;
pub mod rows;
pub mod settings;
pub mod sleep;
pub mod wide;
