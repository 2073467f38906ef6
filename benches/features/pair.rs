//! Two scenes that are stepped in turns, and what is told of them.

use cpu_time::ThreadTime;

/// Makes the next step of a scene, or whatever is compared.
pub(crate) type Step = Box<dyn FnMut()>;

/// Whether times are wanted. Else it is a test that the bench runs, in which scenes need not come to rest.
pub(crate) fn is_bench() -> bool {
    std::env::args().any(|arg| arg == "--bench")
}

/// The same without a part of the crate and with it.
pub(crate) struct Pair {
    pub(crate) without: Step,
    pub(crate) with: Step,
}

impl Pair {
    /// Turns that each of the two has.
    pub(crate) const ROUNDS: usize = 200;

    pub(crate) fn new(without: Step, with: Step) -> Self {
        Self { without, with }
    }
}

/// A row of the table, before it is measured.
#[derive(Clone, Copy)]
pub(crate) struct Row {
    /// What `docs/features.md` calls it.
    pub(crate) capability: &'static str,
    /// The difference of the two scenes.
    pub(crate) difference: &'static str,
    make: fn() -> Pair,
}

impl Row {
    pub(crate) fn new(
        capability: &'static str,
        difference: &'static str,
        make: fn() -> Pair,
    ) -> Self {
        Self {
            capability,
            difference,
            make,
        }
    }

    pub(crate) fn name(&self) -> String {
        format!("{}: {}", self.capability, self.difference)
    }

    /// The row as Markdown. The ratio is the median over turns, so that what else runs on the machine falls on both alike; the
    /// range holds its middle half.
    pub(crate) fn measure(&self, rounds: usize) -> String {
        let Pair {
            mut without,
            mut with,
        } = (self.make)();
        let [mut off, mut on, mut ratios] = [const { Vec::new() }; 3];
        for round in 0..rounds {
            // Who comes first finds what the other has left in the caches, so they take turns at that too.
            let (off_time, on_time) = if round % 2 == 0 {
                let off_time = microseconds(&mut without);
                (off_time, microseconds(&mut with))
            } else {
                let on_time = microseconds(&mut with);
                (microseconds(&mut without), on_time)
            };
            off.push(off_time);
            on.push(on_time);
            ratios.push(on_time / off_time);
        }
        let [_, off, _] = quartiles(&mut off);
        let [_, on, _] = quartiles(&mut on);
        let [low, ratio, high] = quartiles(&mut ratios);
        let Self {
            capability,
            difference,
            ..
        } = self;
        format!(
            "| {capability} | {difference} | {off:.0} | {on:.0} | {ratio:.2} | {low:.2} to {high:.2} |"
        )
    }
}

fn microseconds(work: &mut Step) -> f64 {
    let start = ThreadTime::now();
    work();
    start.elapsed().as_secs_f64() * 1e6
}

fn quartiles(values: &mut [f64]) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    [1, 2, 3].map(|i| values[(values.len() - 1) * i / 4])
}
