//! What a table starts with: date, machine, version and command.

#[allow(
    dead_code,
    reason = "the example that the file belongs to uses the rest"
)]
#[path = "../../../../examples/speed_vs_error/machine.rs"]
mod shared;

use std::process::Command;

/// The words of the command line after the program's name, as they were typed apart from quotes.
pub(crate) fn command_line() -> String {
    let words: Vec<String> = std::env::args().skip(1).collect();
    format!("arena {}", words.join(" "))
}

/// One line for the head of a table: date, machine, commit, command.
pub(crate) fn heading(command: &str) -> String {
    let (date, processor) = (shared::date(), shared::processor());
    format!("{date}, {processor}, {}, `{command}`", commit())
}

/// The commit that is checked out; a plus if library or arena differ from it.
fn commit() -> String {
    let git = |arguments: &[&str]| {
        let output = Command::new("git")
            .args(arguments)
            .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
            .output();
        let output = output.ok().filter(|o| o.status.success())?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_string())
    };
    let changed = git(&["status", "--porcelain", "--", "src", "benches/arena"]);
    let plus = if changed.is_some_and(|s| !s.is_empty()) {
        "+"
    } else {
        ""
    };
    match git(&["rev-parse", "--short", "HEAD"]) {
        Some(hash) => format!("commit {hash}{plus}"),
        None => "unknown commit".into(),
    }
}
