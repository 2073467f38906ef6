//! A judge of scenes that nobody named: it draws random scenes, runs them and looks whether they keep laws that need no
//! reference.
//!
//! [`generate`] draws a scene of a family from a seed, [`laws`] says what it has to keep and asks [`watch`] (what one run
//! shows), [`cause`], [`alike`] and [`same`] (what several runs show); [`shrink`] makes a failing scene as small as it goes and [`file`]
//! keeps it. [`tally`] counts. `examples/judge.rs` runs as many as it is told to, `tests/unnamed_scenes.rs` some hundreds.
#![allow(dead_code, reason = "the test and the example each use some of it")]

pub(crate) mod alike;
pub(crate) mod cause;
pub(crate) mod clock;
#[path = "../common/dice.rs"]
pub(crate) mod dice;
pub(crate) mod file;
pub(crate) mod generate;
pub(crate) mod laws;
pub(crate) mod run;
pub(crate) mod same;
pub(crate) mod scene;
pub(crate) mod shrink;
pub(crate) mod solid;
pub(crate) mod tally;
pub(crate) mod watch;
