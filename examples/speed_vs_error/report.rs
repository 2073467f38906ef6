//! The report: Markdown, CSV and pictures.

use crate::files::{Exact, Files, LEVELS, REFERENCE, mean_and_worst};
use crate::findings::{LOADS, Noise, SUBSTEPS};
use crate::inheritance::Spike;
use crate::mlcp_files::sweeps::Profile;
use crate::order::{Convergence, PARTS};
use crate::pictures::friction_of;
use crate::settings::EXACT;
use crate::support::{Error, stats};
use crate::sweep::{Point, ROUNDING, Sweep, method_name};
use crate::{machine, pictures};
use bevy_cleave::prelude::*;
use std::fmt::Write;
use std::path::Path;

/// What was found where the study that the project started from said something else; by hand.
const FINDINGS: &str = include_str!("findings.md");

/// All that was measured.
pub(crate) struct Results {
    pub(crate) sweeps: Vec<Sweep>,
    pub(crate) files: Files,
    pub(crate) orders: [Convergence; 2],
    pub(crate) spikes: Vec<Spike>,
    pub(crate) noise: [Noise; 4],
    pub(crate) sag: [[f32; 4]; 3],
    /// What it took, s.
    pub(crate) seconds: f64,
    pub(crate) is_quick: bool,
}

/// Writes `accuracy.md`, `results.csv` and the pictures to `folder`.
pub(crate) fn write(folder: &Path, results: &Results) -> Result<(), Error> {
    let save = |name: &str, text: String| {
        let path = folder.join(name);
        std::fs::create_dir_all(folder)
            .and_then(|()| std::fs::write(&path, text))
            .map_err(|e| format!("cannot write {}: {e}", path.display()))
    };
    for sweep in &results.sweeps {
        pictures::scene(folder, sweep)?;
    }
    pictures::profiles(folder, &results.files)?;
    save("results.csv", csv(&results.sweeps))?;
    save("accuracy.md", markdown(results))?;
    Ok(())
}

/// The effort of a method, as the columns of the table have it.
struct Effort {
    substeps: u32,
    max_substeps: u32,
    sweeps: u32,
    relax_sweeps: u32,
    tolerance: Option<f32>,
}

impl Effort {
    fn of(method: &Method) -> Self {
        match method {
            Method::SoftStep(soft_step) => Self {
                substeps: soft_step.min_substeps,
                max_substeps: soft_step.max_substeps,
                sweeps: soft_step.sweeps,
                relax_sweeps: soft_step.relax_sweeps,
                tolerance: soft_step.tolerance,
            },
            Method::Pgs(pgs) => Self {
                substeps: pgs.substeps,
                max_substeps: pgs.substeps,
                sweeps: pgs.sweeps,
                relax_sweeps: 0,
                tolerance: pgs.tolerance,
            },
            Method::Exact(exact) => Self {
                substeps: exact.substeps,
                max_substeps: exact.substeps,
                sweeps: 0,
                relax_sweeps: 0,
                tolerance: None,
            },
        }
    }
}

/// One line for each scene and setting.
fn csv(sweeps: &[Sweep]) -> String {
    let mut text = String::from(
        "scene,setting,method,substeps,max_substeps,sweeps,relax_sweeps,tolerance,friction,\
         median_ms,p99_ms,steps,contacts,share_of_steps_capped,error,unit\n",
    );
    for sweep in sweeps {
        for p in &sweep.points {
            let c = &p.setting.config;
            let Effort {
                substeps,
                max_substeps,
                sweeps,
                relax_sweeps,
                tolerance,
            } = Effort::of(&c.method);
            let tolerance = tolerance.map_or_else(String::new, |t| t.to_string());
            let error = p.error.map_or("failed".into(), |e| format!("{e:.3e}"));
            let unit = if sweep.scene.unit.is_empty() {
                "1"
            } else {
                sweep.scene.unit
            };
            text += &format!(
                "{},\"{}\",{},{substeps},{max_substeps},{sweeps},{relax_sweeps},{tolerance},{:?},{:.5},{:.5},{},{},{:.4},{error},{unit}\n",
                sweep.scene.key,
                p.setting.name,
                method_name(c.method),
                friction_of(&c.method),
                p.median,
                p.p99,
                p.steps,
                p.contacts,
                p.unconverged,
            );
        }
    }
    text
}

fn markdown(results: &Results) -> String {
    let Results { sweeps, files, .. } = results;
    [
        head(results),
        summary(sweeps),
        scene_pictures(sweeps),
        solver_on_files(files),
        convergence(&results.orders),
        spikes(&results.spikes),
        findings(results),
    ]
    .join("\n")
}

fn head(results: &Results) -> String {
    let mode = if results.is_quick { " -- --quick" } else { "" };
    format!(
        "# Speed against error\n\n\
         | | |\n|---|---|\n\
         | machine | {} |\n| date | {} |\n| commit | {} |\n\
         | command | `cargo run --release --example speed_vs_error{mode}` ({:.0} s) |\n\n\
         This report is written by that command; `-- --publish` writes it here. All figures of all runs are in \
         [results.csv](results.csv).\n\n\
         ## Scenes\n\n\
         g = 9.81 m/s2, steps of 1/60 s, density 1000 kg/m3, one thread. Time is that of whole steps (collision, solver, all \
         else): median, and in brackets the 99th percentile, which also holds what other programs took from the machine. Errors below {ROUNDING:.0e} are rounding and stand as that. \
         *Good* is the bar of the hard cases in `tests/it/hard_cases`, which say where each answer comes from. \
         *failed*: fell, or moved by more than 0.1 m, or did not get to where the error is measured.\n",
        machine::processor(),
        machine::date(),
        machine::commit(),
        results.seconds,
    )
}

/// A figure with three digits.
fn figure(value: f64) -> String {
    if value == 0.0 || (1e-3..1e4).contains(&value) {
        let digits = (2 - value.max(1e-3).log10().floor() as i32).clamp(0, 6) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.1e}")
    }
}

fn error(point: &Point, unit: &str) -> String {
    let unit = if unit.is_empty() { "" } else { " m" };
    match point.error {
        None => "failed".into(),
        Some(ROUNDING) => format!("<= {ROUNDING:.0e}{unit}"),
        Some(error) => format!("{error:.1e}{unit}"),
    }
}

/// The default, the cheapest setting that is as good, and the paper's method on each scene.
pub(crate) fn summary(sweeps: &[Sweep]) -> String {
    let mut text = String::from(
        "| scene | contacts | good | default: ms | error | cheapest that is better: ms | error | paper: ms | error |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    for sweep in sweeps {
        let scene = &sweep.scene;
        let time = |p: &Point| format!("{} ({})", figure(p.median), figure(p.p99));
        let (default, paper) = (sweep.default(), sweep.paper());
        let better = sweep.cheapest_as_good().map_or("none | ".into(), |p| {
            let name = &p.setting.name;
            format!("{name}: {} | {}", time(p), error(p, scene.unit))
        });
        text += &format!(
            "| [{}]({}.png) | {} | {:.0e} | {} | {} | {better} | {} | {} |\n",
            scene.title,
            scene.key,
            default.contacts,
            scene.bar,
            time(default),
            error(default, scene.unit),
            time(paper),
            error(paper, scene.unit),
        );
    }
    text
}

fn scene_pictures(sweeps: &[Sweep]) -> String {
    let mut text = String::from(
        "`soft 8x(1+1)`: 8 sub-steps, each a sweep before and one after the motion, no more and no less. `default`: at least 8 \
         sub-steps, more where the load asks for it, and sweeps until the tolerance is met. `pgs 4x4`: 4 sub-steps of 4 sweeps. \
         `exact 2`: 2 sub-steps. *box*: two independent bounds of friction instead of the disc. Marks on the upper edge failed.\n\n",
    );
    for sweep in sweeps {
        let Sweep { scene, .. } = sweep;
        text += &format!(
            "### {}\n\nError: {}.\n\n![Error over time: {}]({}.png)\n\n",
            scene.title, scene.measure, scene.title, scene.key
        );
    }
    text
}

fn solver_on_files(files: &Files) -> String {
    let (all, again) = (files.exact.len(), files.exact_warm.len());
    let mut text = format!(
        "## The solver alone, on problems from files\n\n\
         {all} problems of `tests/data/mlcp` with certified solutions (the one without solution is left out), in double \
         precision, friction bounds frozen at those of the solution so that velocities are unique. One sweep updates every row \
         once. The error is that of the velocities in the mass norm, relative to what the contacts do. *Default (momentum)*: what the default does \
         with the rows of a sub-step until its tolerance is met, the first sweep plain. *Sub-steps of one sweep*: as many as there are \
         sweeps, warm started, as the default takes them where one sweep is enough.\n\n\
         Share of the problems solved, in %, from no impulses:\n\n"
    );
    text += &share_table(
        files
            .curves
            .iter()
            .map(|c| (c.name.into(), &c.cold))
            .collect(),
    );
    let pairs = files.curves.iter().flat_map(|c| {
        [
            (format!("{}, cold", c.name), &c.again_cold),
            (format!("{}, warm", c.name), &c.warm),
        ]
    });
    _ = write!(
        text,
        "\nThe {again} problems that have a step before, from no impulses and from those of the step before:\n\n"
    );
    text += &share_table(pairs.collect());
    text += &format!(
        "\nGeometric mean and worst of the velocity errors (below {REFERENCE:.0e}, to which the solutions are certified, they count \
         as that):\n\n"
    );
    text += &error_table(files);
    text += "\nShare solved within a time, in %, microseconds for each contact, from no impulses (sweeps in the form for files: double \
             precision, on the matrix without its zeros):\n\n";
    text += &time_table(files);
    text += &exact_table(files);
    for (kind, axis) in [("work", "sweeps"), ("time", "time")] {
        for (i, level) in LEVELS.iter().enumerate() {
            let i = i + 1;
            text += &format!("\n![Share solved to {level} over {axis}]({kind}_{i}.png)\n");
        }
    }
    text
}

/// Positions of the powers of two in the list of sweeps.
fn powers(profile: &Profile) -> Vec<usize> {
    let sweeps = profile.sweeps.iter().enumerate();
    let powers = sweeps.filter(|(_, k)| k.is_power_of_two());
    powers.map(|(i, _)| i).collect()
}

/// Head and rule of a table.
fn table_head(first: &str, columns: impl IntoIterator<Item = String>) -> String {
    let columns: Vec<String> = columns.into_iter().collect();
    format!(
        "| {first} | {} |\n|---|{}\n",
        columns.join(" | "),
        "---|".repeat(columns.len())
    )
}

fn share_table(profiles: Vec<(String, &Profile)>) -> String {
    let sweeps = powers(profiles[0].1);
    let columns = sweeps.iter().map(|&i| profiles[0].1.sweeps[i].to_string());
    let mut text = table_head("error, method, sweeps", columns);
    for level in LEVELS {
        for (name, profile) in &profiles {
            let shares = profile.shares(level);
            let cells = sweeps.iter().map(|&i| format!("{:.0}", shares[i]));
            let cells: Vec<_> = cells.collect();
            text += &format!("| {level:.0e} {name} | {} |\n", cells.join(" | "));
        }
    }
    text
}

fn error_table(files: &Files) -> String {
    let sweeps = powers(&files.curves[0].cold);
    let sweeps: Vec<_> = sweeps.into_iter().take(5).collect();
    let columns = sweeps
        .iter()
        .map(|&i| files.curves[0].cold.sweeps[i].to_string());
    let mut text = table_head("method, sweeps", columns);
    for curve in &files.curves {
        let sets = [
            ("all, cold", &curve.cold),
            ("cold", &curve.again_cold),
            ("warm", &curve.warm),
        ];
        for (set, profile) in sets {
            let cells = sweeps.iter().map(|&k| {
                let [mean, worst] = mean_and_worst(profile, k);
                format!("{mean:.1e}, {worst:.1e}")
            });
            let cells: Vec<_> = cells.collect();
            text += &format!("| {}, {set} | {} |\n", curve.name, cells.join(" | "));
        }
    }
    text
}

fn time_table(files: &Files) -> String {
    const TIMES: [f64; 7] = [0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0];
    let mut text = table_head("error, method, us a contact", TIMES.map(|t| t.to_string()));
    for level in LEVELS {
        for curve in &files.curves {
            let cells = TIMES.map(|t| format!("{:.0}", curve.share(level, t)));
            text += &format!("| {level:.0e} {} | {} |\n", curve.name, cells.join(" | "));
        }
    }
    let cells = TIMES.map(|t| format!("{:.0}", files.exact_share(t)));
    text + &format!("| exact, certified | {} |\n", cells.join(" | "))
}

fn exact_table(files: &Files) -> String {
    let mut text = String::from(
        "\nThe exact method (interior point and Newton, certified by its residual):\n\n\
         | start | certified | factorisations: median, 90 %, most | us a contact: median, 90 %, most | worst velocity error |\n\
         |---|---|---|---|---|\n",
    );
    for (start, list) in [("cold", &files.exact), ("warm", &files.exact_warm)] {
        let spread = |pick: &dyn Fn(&Exact) -> f64| {
            let values: Vec<f64> = list.iter().map(pick).collect();
            [0.5, 0.9, 1.0]
                .map(|share| figure(stats::percentile(&values, share)))
                .join(", ")
        };
        let certified = list.iter().filter(|e| e.is_certified).count();
        text += &format!(
            "| {start} | {certified} of {} | {} | {} | {:.1e} |\n",
            list.len(),
            spread(&|e| f64::from(e.factorisations)),
            spread(&|e| e.micros),
            list.iter().map(|e| e.error).fold(0.0, f64::max),
        );
    }
    text
}

fn convergence(orders: &[Convergence]) -> String {
    let columns = PARTS.map(|n| format!("h = 1/{} s", 60 * u32::from(n)));
    let mut text = String::from(
        "\n## Order of convergence\n\nThe exact method in one sub-step; semi-implicit Euler is of order 1.\n\n",
    );
    text += &table_head(
        "motion",
        columns.into_iter().chain(["observed orders".into()]),
    );
    for motion in orders {
        let errors = motion.errors.map(|e| format!("{e:.2e}")).join(" | ");
        let orders = motion.orders().map(|p| format!("{p:.3}")).join(", ");
        text += &format!("| {} | {errors} | {orders} |\n", motion.title);
    }
    text
}

fn spikes(spikes: &[Spike]) -> String {
    let mut text = String::from(
        "\n## Cuts in place\n\nBodies at rest are cut and stay where they are; pieces inherit the contact multipliers of \
         their parents, or start without any.\n\n",
    );
    let columns = [
        "setting",
        "inherited",
        "residual of the step of the cut, relative",
        "fastest piece after it, m/s",
        "fastest within a second, m/s",
        "farthest way in a second, m",
    ];
    text += &table_head("cut", columns.into_iter().map(String::from));
    for spike in spikes {
        for (outcome, inherits) in spike.outcomes.iter().zip(["yes", "no"]) {
            text += &format!(
                "| {} | {} | {inherits} | {:.1e} | {:.1e} | {:.1e} | {:.1e} |\n",
                spike.title,
                spike.setting,
                outcome.residual,
                outcome.first,
                outcome.peak,
                outcome.moved,
            );
        }
    }
    text
}

fn findings(results: &Results) -> String {
    let mut text = String::from(FINDINGS);
    text += "\n### Measured for these findings\n\nTower of 10 cubes, 8 sub-steps of 1 + 1 sweeps, 10 s:\n\n\
             | contact frequency, share of the sub-step rate | largest kinetic energy in the last 5 s, J | largest displacement, mm |\n\
             |---|---|---|\n";
    for n in &results.noise {
        let (energy, moved) = (figure(n.energy), figure(f64::from(1e3 * n.moved)));
        text += &format!("| {} | {energy} | {moved} |\n", n.frequency);
    }
    text += "\nFour cubes under a load, sub-steps of 4 + 4 sweeps, largest displacement in 10 s, mm:\n\n";
    text += &table_head("load, sub-steps", SUBSTEPS.map(|n| n.to_string()));
    for (load, row) in LOADS.iter().zip(&results.sag) {
        let cell = |moved: &f32| {
            let is_down = *moved > 0.3;
            if is_down {
                "fell".into()
            } else {
                figure(f64::from(1e3 * moved))
            }
        };
        let cells: Vec<String> = row.iter().map(cell).collect();
        text += &format!("| x{load} | {} |\n", cells.join(" | "));
    }
    text += "\nShare of the steps in which the exact method (one sub-step) found no solution it could certify, and sweeps took \
             over:\n\n| scene | steps without certificate, % | error |\n|---|---|---|\n";
    for sweep in &results.sweeps {
        for p in sweep.points.iter().filter(|p| p.setting.name == EXACT) {
            let error = error(p, sweep.scene.unit);
            text += &format!(
                "| {} | {:.1} | {error} |\n",
                sweep.scene.title,
                100.0 * p.unconverged
            );
        }
    }
    text
}
