//! Instructions of the kernels: the program starts itself under callgrind, which collects within one function only.

use crate::{Error, kernels};
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

/// The argument by which a child knows that it is one.
pub(crate) const CHILD: &str = "--kernels";

/// Change, in percent, that is worth telling.
const TOLERANCE: f64 = 2.0;

/// Keeps the C library from filling and copying memory by one instruction that repeats itself, of which callgrind counts each byte: whether
/// the compiler makes a loop or a call of a fill would change a kernel's count by a tenth.
const NO_REPETITIONS: &str =
    "glibc.cpu.x86_rep_stosb_threshold=100000000:glibc.cpu.x86_rep_movsb_threshold=100000000";

/// Instructions of one kernel.
#[derive(Clone, Debug)]
pub(crate) struct Count {
    pub(crate) kernel: String,
    pub(crate) unit: String,
    pub(crate) items: f64,
    pub(crate) instructions: f64,
}

/// Instructions of all kernels, in their order.
#[derive(Clone, Debug)]
pub(crate) struct Counts(pub(crate) Vec<Count>);

impl Count {
    pub(crate) fn per_item(&self) -> f64 {
        self.instructions / self.items
    }
}

impl Counts {
    /// Counts anew.
    pub(crate) fn measure() -> Result<Self, Error> {
        let folder = std::env::temp_dir().join(format!("cleave-counts-{}", std::process::id()));
        std::fs::create_dir_all(&folder)?;
        let counts = Self::measure_in(&folder);
        std::fs::remove_dir_all(&folder)?;
        counts
    }

    fn measure_in(folder: &Path) -> Result<Self, Error> {
        let output = Command::new("valgrind")
            .env("GLIBC_TUNABLES", NO_REPETITIONS)
            .args(["--tool=callgrind", "--collect-atstart=no"])
            .arg(format!("--toggle-collect=*{}*", kernels::COUNTED))
            .arg(format!("--dump-after=*{}*", kernels::DUMPED))
            .arg(format!("--callgrind-out-file={}/out", folder.display()))
            .arg(std::env::current_exe()?)
            .arg(CHILD)
            .output()
            .map_err(|error| format!("valgrind cannot be started: {error}"))?;
        let text = String::from_utf8(output.stdout)?;
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into());
        }
        // One dump for each kernel, numbered from 1.
        let counts = text.lines().zip(1..).map(|(line, number)| {
            let dump = std::fs::read_to_string(folder.join(format!("out.{number}")))?;
            Self::parse(line, total(&dump).ok_or("a dump without a total")?)
        });
        Ok(Self(counts.collect::<Result<_, _>>()?))
    }

    /// The counts in a file that [`csv`](Self::csv) made.
    pub(crate) fn read(path: &Path) -> Result<Self, Error> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| format!("no baseline: {}: {error}", path.display()))?;
        let counts = text.lines().skip(1).map(|line| {
            let (kernel, total) = line.rsplit_once(',').ok_or("a line without a comma")?;
            Self::parse(kernel, total.parse()?)
        });
        Ok(Self(counts.collect::<Result<_, _>>()?))
    }

    fn parse(line: &str, instructions: f64) -> Result<Count, Error> {
        let [kernel, unit, items] = line.split(',').collect::<Vec<_>>()[..] else {
            return Err(format!("not a kernel: {line}").into());
        };
        Ok(Count {
            kernel: kernel.into(),
            unit: unit.into(),
            items: items.parse()?,
            instructions,
        })
    }

    pub(crate) fn csv(&self) -> String {
        let mut text = String::from("kernel,unit,items,instructions\n");
        for count in &self.0 {
            let Count {
                kernel,
                unit,
                items,
                instructions,
            } = count;
            let _ = writeln!(text, "{kernel},{unit},{items},{instructions}");
        }
        text
    }

    /// Instructions per item of a kernel; NaN if it was not counted.
    pub(crate) fn of(&self, kernel: &str) -> f64 {
        let count = self.0.iter().find(|count| count.kernel == kernel);
        count.map_or(f64::NAN, Count::per_item)
    }

    /// A line for each kernel, and what has changed.
    pub(crate) fn against(&self, baseline: &Self) -> String {
        let mut text = format!(
            "{:<44} {:>14} {:>14} {:>8}\n",
            "instructions per item", "baseline", "now", "change"
        );
        let mut changed = 0;
        for count in &self.0 {
            let (before, now) = (baseline.of(&count.kernel), count.per_item());
            let change = 100.0 * (now / before - 1.0);
            // A kernel that the baseline does not know has changed as well.
            let is_same = change.abs() <= TOLERANCE;
            changed += u32::from(!is_same);
            let mark = if is_same { "" } else { " <--" };
            let name = format!("{}, {}", count.kernel, count.unit);
            let _ = writeln!(
                text,
                "{name:<44} {before:>14.1} {now:>14.1} {change:>+7.2}%{mark}"
            );
        }
        let _ = write!(
            text,
            "{changed} of {} kernels are more than {TOLERANCE} % off the baseline",
            self.0.len()
        );
        text
    }
}

/// Instructions in a dump of callgrind.
fn total(dump: &str) -> Option<f64> {
    let line = dump.lines().find_map(|line| line.strip_prefix("totals: "));
    line?.trim().parse().ok()
}
