//! Joints as rows, and their solution to rounding: all joints of some islands at once, loops and all, by one sparse factorisation.
//!
//! | file | holds |
//! |---|---|
//! | `vector6.rs` | velocities, rows and blocks of six |
//! | `body.rs` | bodies at the ends of joints |
//! | `measure.rs` | where two bodies are against each other: values and Jacobians of a joint's axes |
//! | `row.rs` | one constraint: stiffness, target, bounds |
//! | `rows.rs` | which rows a joint has, and what one aims at |
//! | `sparsity.rs` | in which order bodies are eliminated, and what fills in |
//! | `links.rs` | bodies that hang on one other, eliminated by the rows of their joints |
//! | `factor.rs` | `M + J^T K J`, factored body by body |
//! | `system.rs` | the bodies and joints of a batch, and their rows |
//! | `halves.rs` | what the rows aim at in each half of a sub-step |
//! | `linearise.rs` | these rows anew where the bodies are now, or those that the step before ended with |
//! | `solve.rs` | which rows act; velocities that satisfy them |
//! | `settle.rs` | the same where that goes round in circles |
//! | `bend.rs` | how much what turns is pulled inward |
//! | `geometric_stiffness.rs`, `stiffening.rs` | light links under heavy loads: inertia that holds their swings to what sub-steps follow |
//! | `drift.rs` | where the bodies go, and the impulses that keep the joints together there |
//! | `rigid.rs` | what connected bodies that nothing holds keep |
//! | `energy.rs` | which joints stay open, and what drives give |
//! | `borne.rs` | what bodies get by joints in loops |
//! | `passed.rs` | what those of trees bear that whip |
//! | `spread.rs` | which of these bears how much |
//! | `rounds.rs` | how long the search for these goes on, in each component of connected bodies |
//!
//! Must not know contacts, batches and threads. Read `row.rs` first, then `system.rs`.

mod bend;
pub(crate) mod body;
mod borne;
pub(crate) mod drift;
mod energy;
mod factor;
mod geometric_stiffness;
mod halves;
mod linearise;
mod links;
pub(crate) mod measure;
mod passed;
pub(crate) mod rigid;
mod rounds;
pub(crate) mod row;
pub(crate) mod rows;
mod settle;
mod solve;
mod sparsity;
mod spread;
mod stiffening;
pub(crate) mod system;
pub(crate) mod vector6;
