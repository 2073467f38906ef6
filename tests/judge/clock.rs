//! Processor time of the thread, where the system tells it as text.

use std::fs;

/// Processor time of this thread until now, ms; zero where it is not known.
pub(crate) fn cpu_ms() -> f64 {
    // The scheduler adds up the time of a running thread only at its ticks and when the thread is asked to yield.
    std::thread::yield_now();
    let text = fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let running = text
        .split_whitespace()
        .next()
        .and_then(|ns| ns.parse::<f64>().ok());
    running.unwrap_or(0.0) * 1e-6
}
