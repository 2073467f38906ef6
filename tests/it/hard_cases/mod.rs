//! Cases that are hard for a contact solver, each against an answer known in advance.
//!
//! Every test says why its case is hard and where its number comes from. Unless a case says otherwise: g = 9.81 m/s2, steps of
//! 1/60 s, density 1000 kg/m3, the same friction for both bodies of a pair, and the default solver. Each prints what it
//! measured: `cargo test --release --test it hard_cases -- --nocapture`.

#![expect(
    clippy::disallowed_methods,
    reason = "expected values within a tolerance, and angles of scenes"
)]
#![expect(clippy::print_stdout, reason = "the measured figures are the result")]

mod scene;
mod support;

mod arch;
mod bounce;
mod cards;
mod corbel;
mod dominoes;
mod flight;
mod pyramid;
mod rebounds;
mod rolling;
mod sliding;
mod slopes;
mod towers;

mod bullet;
mod cloud;
mod far;
mod fracture;
mod overlap;
mod painleve;
mod redundant;
mod shards;
mod sizes;
mod slivers;
mod spinning;
mod spinning_top;
mod warm_start;
