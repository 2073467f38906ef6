//! What a scene pays for each part of the crate: the same scene without it and with it, stepped in turns in one run.
//!
//! `cargo bench --bench features` prints a table of ratios; words after `--` choose rows whose names hold one of them;
//! `--all-features -- --publish` writes `docs/report/features.md`. As a test it makes each row once.
#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a bench tells its figures"
)]

#[path = "../../tests/plugin/app.rs"]
mod app;
mod apps;
mod built;
mod clusters;
#[path = "../../tests/common/mod.rs"]
mod common;
mod heaps;
mod joints;
#[path = "../../examples/speed_vs_error/machine.rs"]
mod machine;
mod news;
mod pair;
mod questions;
mod report;

use pair::{Pair, Row, is_bench};

/// All rows, in the order of `docs/features.md`.
fn rows() -> Vec<Row> {
    let mut rows = [
        heaps::rows(),
        joints::rows(),
        clusters::rows(),
        questions::rows(),
        news::rows(),
        built::rows(),
        apps::rows(),
    ]
    .concat();
    let order = report::capabilities();
    rows.sort_by_key(|row| order.iter().position(|name| name == row.capability));
    rows
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let is_published = words.iter().any(|word| word == "--publish");
    let chosen: Vec<&String> = words.iter().filter(|w| !w.starts_with("--")).collect();
    let rounds = if is_bench() { Pair::ROUNDS } else { 1 };
    let mut lines = Vec::new();
    for row in rows() {
        let name = row.name();
        if !chosen.is_empty() && !chosen.iter().any(|word| name.contains(word.as_str())) {
            continue;
        }
        let line = row.measure(rounds);
        println!("{line}");
        lines.push(line);
    }
    if is_published {
        report::publish(&lines).expect("the report can be written");
    }
}
