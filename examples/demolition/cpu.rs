//! Processor time of this process, where the system tells it as text.

use std::fs;

/// Processor time of all threads until now, by thread, ns; empty where it is not known.
#[derive(Clone, Debug)]
pub(crate) struct CpuClock(Vec<(String, u64)>);

impl CpuClock {
    /// Reads the clocks of all threads.
    pub(crate) fn now() -> Self {
        // The scheduler adds up the time of a running thread only at its ticks and when the thread is asked to yield.
        std::thread::yield_now();
        let tasks = fs::read_dir("/proc/self/task").into_iter().flatten();
        let clock = |task: std::io::Result<fs::DirEntry>| {
            let task = task.ok()?;
            let text = fs::read_to_string(task.path().join("schedstat")).ok()?;
            let running = text.split_whitespace().next()?.parse().ok()?;
            Some((task.file_name().to_string_lossy().into_owned(), running))
        };
        Self(tasks.filter_map(clock).collect())
    }

    /// Processor time of all threads since `earlier`, ms; NaN where it is not known.
    pub(crate) fn ms_since(&self, earlier: &Self) -> f64 {
        let since = |(task, now): &(String, u64)| {
            let before = earlier.0.iter().find(|(name, _)| name == task);
            now.saturating_sub(before.map_or(0, |&(_, time)| time))
        };
        if self.0.is_empty() {
            f64::NAN
        } else {
            self.0.iter().map(since).sum::<u64>() as f64 * 1e-6
        }
    }
}
