//! The page of the report.

use crate::machine;
use std::fs;
use std::path::Path;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// What `docs/features.md` lists, in its order.
pub(crate) fn capabilities() -> Vec<String> {
    let page = fs::read_to_string(root().join("docs/features.md")).expect("the page is there");
    let bold = page.lines().filter_map(|line| line.strip_prefix("- **"));
    bold.filter_map(|rest| rest.split_once("**"))
        .map(|(name, _)| name.trim_end_matches('.').to_string())
        .collect()
}

/// Writes the page anew.
pub(crate) fn publish(lines: &[String]) -> std::io::Result<()> {
    let page = format!(
        "# What a scene pays for\n\n\
         The same scene without a part of the crate and with it, stepped in turns in one run: medians of the CPU time of a step, us, of the thread that \
         steps, and the median of the ratio of both in a turn,\nwith the range that its middle half lies in. Rows of something aside show what a part \
         costs those who do not use it, though it is in the scene; the other rows what it costs\nwhere all use it. Where shapes differ the heap lies \
         differently, and where bodies sleep, slide or bounce it is not the same work: such ratios tell what to expect, not what\nthe part itself takes.\n\n\
         Unless a row says otherwise: a heap of 200 hulls that lies, awake, on one thread, no app. Rows that begin with \"app\" are a whole \
         `App::update`.\n\n\
         `cargo bench --bench features --all-features -- --publish`; {}; {}; commit {}.\n\n\
         | part | difference | without | with | ratio | middle half |\n|---|---|---|---|---|---|\n{}\n",
        machine::processor(),
        machine::date(),
        machine::commit(),
        lines.join("\n"),
    );
    fs::write(root().join("docs/report/features.md"), page)
}
