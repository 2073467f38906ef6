//! What the programs share: CPU time and instruction counts.

use std::path::Path;
use std::process::{Command, Output};

/// An error is a sentence for the person who runs the program.
pub type Error = Box<dyn std::error::Error + Send + Sync>;

/// CPU time of this thread, us.
pub fn cpu_us() -> f64 {
    let mut time = libc::timespec {
        tv_sec: 0,
        tv_nsec: 0,
    };
    // SAFETY: `time` is a valid place to write to.
    unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &mut time) };
    time.tv_sec as f64 * 1e6 + time.tv_nsec as f64 * 1e-3
}

/// Runs a program under callgrind: its output, and the instructions within functions whose name contains `function`.
///
/// # Errors
/// If valgrind is not there, or the program fails.
pub fn count(program: &Path, arguments: &[&str], function: &str) -> Result<(Output, f64), Error> {
    let file = std::env::temp_dir().join(format!("weigh-{}.out", std::process::id()));
    let output = Command::new("valgrind")
        .args(["-q", "--tool=callgrind", "--collect-atstart=no"])
        .arg(format!("--toggle-collect=*{function}*"))
        .arg(format!("--callgrind-out-file={}", file.display()))
        .arg(program)
        .args(arguments)
        .output()
        .map_err(|error| format!("valgrind cannot be started: {error}"))?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into());
    }
    let dump = std::fs::read_to_string(&file)?;
    std::fs::remove_file(&file)?;
    let total = dump.lines().find_map(|line| line.strip_prefix("totals: "));
    let total = total.ok_or("a dump without a total")?.trim().parse()?;
    Ok((output, total))
}
