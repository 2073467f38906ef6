//! The table of results: a CSV file that runs append to, with a comment line for each run of the arena.

use crate::Error;
use std::collections::HashMap;
use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::Path;

/// One engine with one setting on one scene: medians over its runs. Times in ms per step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Row {
    pub(crate) scene: String,
    pub(crate) bodies: usize,
    pub(crate) engine: String,
    pub(crate) setting: String,
    /// Whether it is the setting that the engine ships with.
    pub(crate) is_default: bool,
    pub(crate) threads: usize,
    pub(crate) steps: usize,
    pub(crate) wall: f64,
    pub(crate) wall_p99: f64,
    pub(crate) cpu: f64,
    pub(crate) cpu_mean: f64,
    /// Slowest over fastest run.
    pub(crate) noise: f64,
    pub(crate) build_ms: f64,
    pub(crate) err: f64,
    pub(crate) pen_max: f64,
    pub(crate) pen_mean: f64,
    pub(crate) energy_gain: f64,
    pub(crate) energy_drift: f64,
    pub(crate) disp_max: f64,
    pub(crate) rms_speed: f64,
    pub(crate) fallen: usize,
    /// Not a number where the engine does not tell.
    pub(crate) awake: f64,
    pub(crate) contacts: f64,
}

const COLUMNS: [&str; 23] = [
    "scene",
    "bodies",
    "engine",
    "setting",
    "default",
    "threads",
    "steps",
    "ms_median",
    "ms_p99",
    "cpu_ms",
    "cpu_mean",
    "noise",
    "build_ms",
    "err",
    "pen_max",
    "pen_mean",
    "energy_gain",
    "energy_drift",
    "disp_max",
    "rms_speed",
    "fallen",
    "awake",
    "contacts",
];

impl Row {
    /// What its time is judged by, ms: CPU time on one thread, which other processes disturb less; wall time on more.
    pub(crate) fn cost(&self) -> f64 {
        if self.threads == 1 {
            self.cpu
        } else {
            self.wall
        }
    }

    /// Name of the scene without its size.
    pub(crate) fn scene_name(&self) -> &str {
        self.scene.split(':').next().unwrap_or_default()
    }

    /// Whether the run ended as it should: finite, nothing fell, nothing passed a wall.
    pub(crate) fn stands(&self) -> bool {
        let is_wall = self.scene_name().starts_with("bullet");
        self.fallen == 0 && self.err.is_finite() && !(is_wall && self.err > 0.0)
    }

    fn to_line(&self) -> String {
        let head = [
            self.scene.clone(),
            self.bodies.to_string(),
            self.engine.clone(),
            self.setting.clone(),
            u8::from(self.is_default).to_string(),
            self.threads.to_string(),
            self.steps.to_string(),
        ];
        let times = [
            self.wall,
            self.wall_p99,
            self.cpu,
            self.cpu_mean,
            self.noise,
            self.build_ms,
        ];
        let errors = [
            self.err,
            self.pen_max,
            self.pen_mean,
            self.energy_gain,
            self.energy_drift,
            self.disp_max,
            self.rms_speed,
        ];
        let times = times.map(|t| format!("{t:.5}")).join(",");
        let errors = errors.map(|e| format!("{e:e}")).join(",");
        let (head, fallen, awake, contacts) =
            (head.join(","), self.fallen, self.awake, self.contacts);
        format!("{head},{times},{errors},{fallen},{awake},{contacts}")
    }

    fn from_cells(cells: &HashMap<&str, &str>) -> Result<Self, Error> {
        let text = |name: &str| {
            cells
                .get(name)
                .copied()
                .ok_or(format!("no column `{name}`"))
        };
        let number = |name: &str| -> Result<f64, Error> {
            let text = text(name)?;
            text.parse()
                .map_err(|_| format!("`{text}` in column `{name}`").into())
        };
        let count = |name: &str| number(name).map(|n| n as usize);
        Ok(Self {
            scene: text("scene")?.into(),
            bodies: count("bodies")?,
            engine: text("engine")?.into(),
            setting: text("setting")?.into(),
            is_default: count("default")? > 0,
            threads: count("threads")?,
            steps: count("steps")?,
            wall: number("ms_median")?,
            wall_p99: number("ms_p99")?,
            cpu: number("cpu_ms")?,
            cpu_mean: number("cpu_mean")?,
            noise: number("noise")?,
            build_ms: number("build_ms")?,
            err: number("err")?,
            pen_max: number("pen_max")?,
            pen_mean: number("pen_mean")?,
            energy_gain: number("energy_gain")?,
            energy_drift: number("energy_drift")?,
            disp_max: number("disp_max")?,
            rms_speed: number("rms_speed")?,
            fallen: count("fallen")?,
            awake: number("awake")?,
            contacts: number("contacts")?,
        })
    }
}

/// The app around our plugin without it; its times stand for no engine.
pub(crate) const BARE_APP: &str = "bare-app";

/// All that a file holds.
#[derive(Debug, Default)]
pub(crate) struct Table {
    /// In the order of their first appearance; a later row of the same point replaces an earlier one.
    pub(crate) rows: Vec<Row>,
    /// Those of the [bare app](BARE_APP).
    pub(crate) bare: Vec<Row>,
    /// The comment lines, without their mark.
    pub(crate) comments: Vec<String>,
}

impl Table {
    /// Reads a file.
    pub(crate) fn read(path: &Path) -> Result<Self, Error> {
        let text = fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
        Self::parse(&text)
    }

    fn parse(text: &str) -> Result<Self, Error> {
        let mut table = Self::default();
        let mut header: Vec<&str> = Vec::new();
        for line in text.lines() {
            if let Some(comment) = line.strip_prefix("# ") {
                table.comments.push(comment.into());
            } else if line.starts_with("scene,") {
                header = line.split(',').collect();
            } else {
                let cells = header.iter().copied().zip(line.split(',')).collect();
                table.put(Row::from_cells(&cells)?);
            }
        }
        Ok(table)
    }

    fn put(&mut self, row: Row) {
        let is_same = |old: &&mut Row| {
            let key = |r: &Row| {
                (
                    r.scene.clone(),
                    r.engine.clone(),
                    r.setting.clone(),
                    r.threads,
                )
            };
            key(old) == key(&row)
        };
        let rows = if row.engine == BARE_APP {
            &mut self.bare
        } else {
            &mut self.rows
        };
        match rows.iter_mut().find(is_same) {
            Some(old) => *old = row,
            None => rows.push(row),
        }
    }

    /// What an update of an app without physics takes in a scene, ms, if that was measured.
    pub(crate) fn bare_cost(&self, scene: &str, threads: usize) -> Option<f64> {
        let here = |row: &&Row| row.scene == scene && row.threads == threads;
        self.bare.iter().find(here).map(Row::cost)
    }

    /// The different values of something in the rows, in the order of their first appearance.
    pub(crate) fn distinct<T: PartialEq>(&self, of: impl Fn(&Row) -> T) -> Vec<T> {
        let mut found = Vec::new();
        for value in self.rows.iter().map(of) {
            if !found.contains(&value) {
                found.push(value);
            }
        }
        found
    }
}

/// A file that rows are appended to.
pub(crate) struct Writer(fs::File);

impl Writer {
    /// Opens or makes the file, with its folder, and adds a comment to it.
    pub(crate) fn open(path: &Path, comment: &str) -> Result<Self, Error> {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        let mut file = OpenOptions::new().append(true).create(true).open(path)?;
        if file.metadata()?.len() == 0 {
            writeln!(file, "{}", COLUMNS.join(","))?;
        }
        writeln!(file, "# {comment}")?;
        Ok(Self(file))
    }

    pub(crate) fn add(&mut self, row: &Row) -> Result<(), Error> {
        Ok(writeln!(self.0, "{}", row.to_line())?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_survive_the_file_and_later_ones_replace_earlier_ones() {
        let row = |err| Row {
            scene: "tower:10".into(),
            engine: "cleave".into(),
            setting: "soft-4".into(),
            threads: 1,
            awake: f64::NAN,
            err,
            ..Row::default()
        };
        let lines = [
            COLUMNS.join(","),
            "# a note".into(),
            row(f64::INFINITY).to_line(),
            row(0.25).to_line(),
        ];
        let table = Table::parse(&lines.join("\n")).expect("a table");
        assert_eq!(table.comments, ["a note"]);
        assert_eq!(format!("{:?}", table.rows), format!("{:?}", [row(0.25)]));
    }

    #[test]
    fn what_fell_or_broke_or_passed_the_wall_does_not_stand() {
        let row = |scene: &str, err, fallen| Row {
            scene: scene.into(),
            err,
            fallen,
            ..Row::default()
        };
        assert!(row("tower:10", 0.4, 0).stands() && row("bullet", 0.0, 0).stands());
        assert!(!row("tower:10", 0.4, 1).stands());
        assert!(!row("pile:500", f64::INFINITY, 0).stands());
        assert!(!row("bullet_ccd", 1.0, 0).stands());
    }
}
