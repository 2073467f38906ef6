//! The report: Markdown, and the counts as the baseline.

use crate::counts::Counts;
use crate::limits::{LEVELS, WIDTHS};
use crate::roofline::{OPERATIONS, Roofline, SLIP, chain, flops};
use crate::{Error, machine};
use bevy_cleave::testing::bodies::SolverBody;
use bevy_cleave::testing::wide::{Block, Point};
use std::fmt::Write;
use std::path::Path;

/// What the figures mean; by hand.
const FINDINGS: &str = include_str!("findings.md");

/// Writes `performance.md` and, if there are any, `counts.csv` to `folder`.
pub(crate) fn write(
    folder: &Path,
    counts: &Result<Counts, Error>,
    roofline: &Roofline,
    seconds: f64,
) -> Result<(), Error> {
    std::fs::create_dir_all(folder)?;
    let text = [
        head(seconds),
        instructions(counts),
        limits(roofline),
        work(),
        sweeps(roofline, counts.as_ref().ok()),
        FINDINGS.into(),
    ];
    std::fs::write(folder.join("performance.md"), text.join("\n"))?;
    if let Ok(counts) = counts {
        std::fs::write(folder.join("counts.csv"), counts.csv())?;
    }
    Ok(())
}

fn head(seconds: f64) -> String {
    format!(
        "# What the kernels cost\n\n\
         | | |\n|---|---|\n\
         | machine | {} |\n| date | {} |\n| commit | {} |\n\
         | command | `cargo run --release --example performance -- --publish` ({seconds:.0} s) |\n",
        machine::processor(),
        machine::date(),
        machine::commit(),
    )
}

fn instructions(counts: &Result<Counts, Error>) -> String {
    let mut text = String::from(
        "## Instructions\n\n\
         Counted by callgrind within the kernel only, in the second run of each, on one thread. The baseline is \
         [counts.csv](counts.csv); `cargo run --release --example performance -- --compare` says what is more than 2 % off it, and \
         `-- --publish` renews it together with this page. Counts of another compiler differ. The C library is kept from filling and \
         copying memory by one instruction that repeats itself, of which callgrind counts each byte.\n\n",
    );
    match counts {
        Ok(counts) => {
            text += "| kernel | items | instructions per item |\n|---|---|---|\n";
            for count in &counts.0 {
                let (kernel, unit, items) = (&count.kernel, &count.unit, count.items);
                let _ = writeln!(
                    text,
                    "| {kernel} | {items} x {unit} | {:.0} |",
                    count.per_item()
                );
            }
        }
        Err(error) => {
            let _ = writeln!(text, "Not counted: {error}");
        }
    }
    text
}

fn limits(roofline: &Roofline) -> String {
    let limits = &roofline.limits;
    let mut text = format!(
        "## Limits of one core\n\n\
         Shortest times of many runs: the machine is shared, so that medians say more of others than of us. Clock {:.2} GHz (a chain of \
         integer operations of known latency). Calculations go through the solver's own lanes, without fused operations.\n\n\
         | lanes | additions and multiplications, Gflop/s | per cycle | pairs of square root and division, G/s |\n|---|---|---|---|\n",
        limits.clock,
    );
    for (k, (_, name)) in WIDTHS.into_iter().enumerate() {
        let (flops, roots) = (limits.flops[k], limits.roots[k]);
        let per_cycle = flops / limits.clock;
        let _ = writeln!(
            text,
            "| {name} | {flops:.1} | {per_cycle:.1} | {roots:.2} |"
        );
    }
    text += "\n(One lane is plain Rust, of which the compiler makes vector code where a loop is as simple as these.)\n\n\
             | held by | buffers | read, GB/s | triad `a = b + s c`, GB/s |\n|---|---|---|---|\n";
    for (k, (name, bytes)) in LEVELS.into_iter().enumerate() {
        let (read, triad, size) = (limits.read[k], limits.triad[k], bytes >> 10);
        let _ = writeln!(text, "| {name} | {size} KiB | {read:.1} | {triad:.1} |");
    }
    text
}

/// What a sweep has to do for a point.
fn work() -> String {
    let mut text = String::from(
        "## Work of a point in a sweep\n\n\
         `Contacts::solve` with friction in a disc; `relax` has about as many operations.\n\n\
         | part | operations | of these one after the other |\n|---|---|---|\n",
    );
    for (part, operations, chain) in OPERATIONS {
        let _ = writeln!(text, "| {part} | {operations} | {chain} |");
    }
    let _ = writeln!(
        text,
        "| sum | {} | {:.0} cycles |\n\n\
         Where a lane slips, a square root, a division and two multiplications are added, {SLIP} cycles.\n\n\
         In memory a point of eight manifolds takes {} bytes, a block {} bytes, a body's velocity {} bytes; of a point two cache \
         lines are written. A block gathers and scatters the velocities of 16 bodies.\n",
        flops(),
        chain(),
        size_of::<Point>(),
        size_of::<Block>(),
        size_of::<SolverBody>(),
    );
    text
}

fn sweeps(roofline: &Roofline, counts: Option<&Counts>) -> String {
    let mut text = String::from(
        "## Sweeps against the limits\n\n\
         ns for each contact point and sweep: shortest of 40 rounds, all scenes and kernels in turns; in brackets the median.\n\n\
         | scene | points | lanes used | working set | solve, 8 lanes | 4 lanes | 1 lane | relax, 8 lanes |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    let time = |[least, median]: [f64; 2]| format!("{least:.2} ({median:.2})");
    for scene in &roofline.scenes {
        let [eight, four, one] = scene.solve.map(time);
        let _ = writeln!(
            text,
            "| {} | {} | {:.0} % | {} KiB | {eight} | {four} | {one} | {} |",
            scene.name,
            scene.points,
            100.0 * scene.points as f64 / scene.lanes as f64,
            scene.working_set >> 10,
            time(scene.relax),
        );
    }
    text += "\nWhat a point of `solve` would take in 8 lanes for one reason alone, ns, and the share of the measured time that this is:\n\n\
             | scene | bytes per point | flop per byte | operations | with unused lanes | bandwidth | \
             chain, if nothing overlaps | gather and scatter alone (measured) |\n|---|---|---|---|---|---|---|---|\n";
    for scene in &roofline.scenes {
        let bounds = scene.bounds(&roofline.limits);
        let share = |ns: f64| format!("{ns:.2} ({:.0} %)", 100.0 * ns / scene.solve[0][0]);
        let _ = writeln!(
            text,
            "| {} | {:.0} | {:.2} | {} | {} | {} in {} | {} | {} |",
            scene.name,
            scene.bytes,
            flops() / scene.bytes,
            share(bounds.operations),
            share(bounds.with_unused_lanes),
            share(bounds.bandwidth),
            bounds.level,
            share(bounds.chain),
            share(scene.transposes[0]),
        );
    }
    if let Some(counts) = counts {
        let _ = writeln!(
            text,
            "\nInstructions of a point (pyramid of 10): {:.1} in 8 lanes, {:.1} in 4, {:.0} in 1.",
            counts.of("solve sweep: widest lanes"),
            counts.of("solve sweep: four lanes"),
            counts.of("solve sweep: one lane"),
        );
    }
    text
}
