//! Drops a real model among other bodies: it breaks on impact, the pieces break again and come to rest.
//!
//! `cargo run --release --example shatter [MODEL.obj|MODEL.glb]` prints what happened as `name: value` lines and
//! writes pictures of the scene over time, a contact sheet of them, and a plot of step time, residual and energy
//! under `target/shatter/`. Look for the pale cut faces: they are where the model was cut while it moved.
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "an example prints what it shows"
)]

#[path = "support/mod.rs"]
mod support;

use bevy_cleave::prelude::*;
use glam::Vec3;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;
use support::picture::{Picture, contact_sheet};
use support::plot::{Panel, time_series};
use support::render::{Camera, Scene, palette};
use support::stats;

const FOLDER: &str = "target/shatter";
const H: f32 = 1.0 / 60.0;
const STEPS: usize = 420;
/// Steps after which a picture is taken: in flight, at the impact, breaking, spreading, hit from above, at rest.
const PICTURES: [usize; 6] = [24, 48, 56, 70, 110, STEPS];

fn main() -> ExitCode {
    match shatter() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("shatter: {error}");
            ExitCode::FAILURE
        }
    }
}

fn shatter() -> Result<(), support::Error> {
    let path = std::env::args()
        .nth(1)
        .unwrap_or_else(|| support::DEFAULT_MODEL.into());
    let mut simulation = Simulation::default();
    simulation.config.measure_error = true;
    for body in support::scene::shatter(&path)? {
        simulation.bodies.insert(body)?;
    }
    let mut run = Run::new(simulation);
    let bar = ProgressBar::new(STEPS as u64).with_style(ProgressStyle::with_template(
        "{bar:40} {pos}/{len} steps  {msg}",
    )?);
    let mut pictures = Vec::new();
    for step in 1..=STEPS {
        run.step();
        if PICTURES.contains(&step) {
            let picture = run.picture();
            picture.save(Path::new(FOLDER).join(format!("{:04}.png", pictures.len())))?;
            pictures.push((format!("t = {:.2} s", step as f32 * H), picture));
        }
        bar.set_message(format!("{} bodies", run.simulation.bodies.len()));
        bar.inc(1);
    }
    bar.finish();
    contact_sheet(&pictures, 2, 2).save(Path::new(FOLDER).join("contact_sheet.png"))?;
    run.plot()?;
    run.print();
    Ok(())
}

/// The simulation with what is remembered of it for the report.
struct Run {
    simulation: Simulation,
    /// By slot: which of the first bodies the body in it is or comes from.
    origin: Vec<usize>,
    /// By origin: the density is 1000 kg/m3 for all, so this is the mass at the start, kg.
    mass_at_start: f64,
    step_ms: Vec<f64>,
    residual: Vec<f64>,
    energy: Vec<f64>,
    kinetic_energy: Vec<f64>,
    penetration: f64,
    dropped_mass: f64,
    ledgers: Vec<Ledger>,
}

impl Run {
    fn new(simulation: Simulation) -> Self {
        Self {
            origin: (0..simulation.bodies.slots()).collect(),
            simulation,
            mass_at_start: 0.0,
            step_ms: Vec::new(),
            residual: Vec::new(),
            energy: Vec::new(),
            kinetic_energy: Vec::new(),
            penetration: 0.0,
            dropped_mass: 0.0,
            ledgers: Vec::new(),
        }
    }

    fn step(&mut self) {
        let start = Instant::now();
        self.simulation.step(H);
        self.step_ms.push(start.elapsed().as_secs_f64() * 1e3);
        let Some(error) = self.simulation.report.error else {
            return;
        };
        self.residual.push(f64::from(error.residual.relative));
        self.energy
            .push(error.kinetic_energy + error.potential_energy);
        self.kinetic_energy.push(error.kinetic_energy);
        self.penetration = self.penetration.max(f64::from(error.penetration));
        for fracture in &self.simulation.fractures.done {
            let origin = self.origin[fracture.parent_slot as usize];
            for &piece in &fracture.pieces {
                let needed = self.origin.len().max(piece as usize + 1);
                self.origin.resize(needed, 0);
                self.origin[piece as usize] = origin;
            }
            self.dropped_mass += fracture.ledger.dropped.mass;
            self.ledgers.push(fracture.ledger);
        }
        if self.step_ms.len() == 1 {
            self.mass_at_start = self.mass() + self.dropped_mass;
        }
    }

    fn mass(&self) -> f64 {
        let bodies = &self.simulation.bodies;
        bodies
            .iter()
            .map(|slot| f64::from(bodies.mass(slot).mass))
            .sum()
    }

    fn picture(&self) -> Picture {
        let bodies = &self.simulation.bodies;
        let mut scene = Scene::default();
        for slot in bodies.iter() {
            if let Some(mesh) = bodies.convex(slot) {
                let color = palette(self.origin[slot as usize]);
                scene.draw(&mesh.render_mesh(), bodies.pose(slot), color);
            }
        }
        let camera = Camera::look_at(
            Vec3::new(4.6, 3.6, 6.2),
            Vec3::new(0.0, 1.3, 0.0),
            Vec3::Y,
            42.0,
            1280,
            720,
        );
        scene.render(&camera)
    }

    fn plot(&self) -> Result<(), support::Error> {
        let series = |values: &[f64]| {
            values
                .iter()
                .enumerate()
                .map(|(i, &v)| (i as f64 * f64::from(H), v))
                .collect::<Vec<_>>()
        };
        let panel = |label: &str, unit: &str, log, values: &[f64]| Panel {
            label: label.into(),
            unit: unit.into(),
            log,
            series: series(values),
        };
        let panels = [
            panel("step time", "ms", true, &self.step_ms),
            panel("residual", "", true, &self.residual),
            panel("energy", "J", false, &self.energy),
        ];
        time_series(Path::new(FOLDER).join("plot.png"), "shatter", &panels)
    }

    /// Largest rise of the energy above an earlier value, relative to the energy at the start.
    fn energy_gain(&self) -> f64 {
        let mut lowest = f64::INFINITY;
        let rises = self.energy.iter().map(|&energy| {
            lowest = lowest.min(energy);
            energy - lowest
        });
        rises.fold(0.0, f64::max) / self.energy[0]
    }

    fn print(&self) {
        let worst = |error: fn(&Ledger) -> f64| self.ledgers.iter().map(error).fold(0.0, f64::max);
        let bodies = &self.simulation.bodies;
        let mass_error =
            (self.mass() + self.dropped_mass - self.mass_at_start).abs() / self.mass_at_start;
        let pieces: usize = self.simulation.bodies.len() - self.first_bodies_left();
        println!("bodies: {}", bodies.len());
        println!("fractures: {}", self.ledgers.len());
        println!("pieces: {pieces}");
        println!("contacts: {}", self.simulation.report.contacts);
        println!("step_ms_median: {:.4}", stats::median(&self.step_ms));
        println!("step_ms_p99: {:.4}", stats::percentile(&self.step_ms, 0.99));
        println!("step_ms_max: {:.4}", stats::max(&self.step_ms));
        println!("residual_max: {:.3e}", stats::max(&self.residual));
        println!(
            "residual_final: {:.3e}",
            self.residual[self.residual.len() - 1]
        );
        println!("penetration_max_m: {:.4}", self.penetration);
        println!("mass_error_rel: {mass_error:.2e}");
        println!("momentum_error_rel: {:.2e}", worst(Ledger::momentum_error));
        println!(
            "angular_momentum_error_rel: {:.2e}",
            worst(Ledger::angular_momentum_error)
        );
        println!("energy_gain_rel: {:.2e}", self.energy_gain());
        let (moving, most) = (
            self.kinetic_energy[STEPS - 1],
            stats::max(&self.kinetic_energy),
        );
        println!("kinetic_energy_final_rel: {:.2e}", moving / most);
        println!("dropped_mass_kg: {:.3}", self.dropped_mass);
        println!("pictures: {FOLDER}/");
    }

    /// How many of the bodies that were there at the start are still whole.
    fn first_bodies_left(&self) -> usize {
        let first = self.origin.iter().max().map_or(0, |m| m + 1) as u32;
        let bodies = &self.simulation.bodies;
        bodies
            .iter()
            .filter(|&slot| bodies.id(slot).0 < first)
            .count()
    }
}
