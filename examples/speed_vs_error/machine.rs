//! What a report starts with: the machine, the date and the version.

use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

/// Name of the processor and number of threads that it runs at once.
pub(crate) fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find(|line| line.starts_with("model name"));
    let name = name.and_then(|line| line.split_once(": "));
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    format!(
        "{}, {cores} cores, {}",
        name.map_or("unknown processor", |(_, name)| name),
        std::env::consts::ARCH
    )
}

/// Year, month and day in UTC.
pub(crate) fn date() -> String {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    let days = now.map_or(0, |d| d.as_secs() / 86_400);
    let (year, month, day) = civil(days);
    format!("{year}-{month:02}-{day:02}")
}

/// The day `days` after 1970-01-01 in the Gregorian calendar.
///
/// Hinnant, "chrono-Compatible Low-Level Date Algorithms", 2013: years that begin in March, in cycles of 400.
fn civil(days: u64) -> (u64, u64, u64) {
    let days = days + 719_468;
    let (cycle, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let (date, month) = (day - (153 * month + 2) / 5 + 1, (month + 2) % 12 + 1);
    (year + 400 * cycle + u64::from(month <= 2), month, date)
}

/// The commit that is checked out; a plus if the files differ from it. Empty where there is no repository.
pub(crate) fn commit() -> String {
    let git = |arguments: &[&str]| {
        let output = Command::new("git")
            .args(arguments)
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output();
        let output = output.ok().filter(|o| o.status.success())?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_string())
    };
    let changed = git(&["status", "--porcelain", "--", "src"]).is_some_and(|s| !s.is_empty());
    let plus = if changed { "+" } else { "" };
    git(&["rev-parse", "--short", "HEAD"]).map_or_else(String::new, |hash| hash + plus)
}
