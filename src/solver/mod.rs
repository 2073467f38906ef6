//! From manifolds and bodies to new velocities: one mixed linear complementarity problem, and the methods that solve it.
//!
//! | room | is | must not know |
//! |---|---|---|
//! | `rows` | the problem row by row: statement, sweep, residual; read this first | lanes, batches |
//! | `graph` | who is solved with whom, and in which order: answers are integers | impulses |
//! | `wide` | what eight contacts do | islands, batches, teams |
//! | `joint` | joints as rows, and their solution to rounding | contacts, batches |
//! | `batch` | time: the sub-steps of some islands | how manifolds were found |
//! | `exact` | the problem solved to rounding, in double precision (feature `exact`) | time |
//!
//! Above them, the way of a step: `contact_solver.rs` finds islands and batches and has them solved, `estimates.rs` says what each
//! manifold and island asks for (`adaptivity.rs`), `deferral.rs` and `breakage_probe.rs` see to large islands in which bodies break,
//! `results.rs` takes back what was found. `config.rs` is what users set, `settings.rs` the numbers of one sub-step that follow from
//! it, `free_flight.rs` what touches nothing, `rest.rs` who is at rest, `sleep.rs` when islands at rest
//! are left out.
//!
//! Must not know how contacts were found, nor entities. After `rows`, read `batch/substep.rs`: one sub-step, line by line.

pub(crate) mod adaptivity;
pub(crate) mod batch;
mod breakage_probe;
pub(crate) mod config;
pub(crate) mod contact_solver;
pub(crate) mod deferral;
pub(crate) mod estimates;
#[cfg(feature = "exact")]
pub(crate) mod exact;
mod free_flight;
pub(crate) mod graph;
pub(crate) mod joint;
mod rest;
pub(crate) mod results;
pub(crate) mod rows;
pub(crate) mod settings;
pub(crate) mod sleep;
pub(crate) mod wide;

#[cfg(feature = "exact")]
pub use config::Exact;
pub use config::{FrictionModel, Gravity, Method, Pgs, SleepConfig, SoftStep, SolverConfig};
pub use rows::mlcp::Residual;
