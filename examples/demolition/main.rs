//! A wall of bricks is shot to rubble, through the plugin, with the default budget of pieces for a step.
//!
//! `cargo run --release --example demolition` prints what happened as `name: value` lines and writes pictures, a contact
//! sheet of them, and a plot of the step's time under `target/demolition/`; with `-- --publish` a smaller sheet to `docs/`. With
//! `-- --repeats 3` the same is played three times, and the least time of each step counts: all runs have the same bits, so that
//! what differs between them is the machine.
//! 514 bricks break into cells, and their pieces break again.
//!
//! What a fracture costs is told as the ratio of the time of a step in which something broke to the median of the steps
//! around it ([`hitch`] says which ones), and next to it the same for steps in which nothing broke: those differ too, with
//! what moves and how fast. A step is one `App::update`: entities of the pieces and messages are in it. `cpu_...` is the
//! processor's time of all threads, where the system tells it: other programs on the machine do not count there. Threads
//! that wait for work in a busy loop do, so it is best read on one (`taskset -c 0`).
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "an example prints what it shows"
)]

#[path = "../support/mod.rs"]
mod support;

mod books;
mod cpu;
mod hitch;
mod scene;

use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use books::Books;
use cpu::CpuClock;
use glam::Vec3;
use hitch::{Kind, worst};
use indicatif::{ProgressBar, ProgressStyle};
use scene::{Color, H, Shot};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;
use support::colors::{IRON, clay};
use support::picture::{Picture, contact_sheet};
use support::plot::{Panel, time_series};
use support::render::{Camera, Scene};
use support::stats;

const FOLDER: &str = "target/demolition";
const STEPS: usize = 208;
/// Steps after which a picture is taken.
const PICTURES: [usize; 9] = [40, 56, 72, 96, 120, 144, 168, 188, STEPS];
/// Which of the pictures are on the sheet for `docs/`.
const PUBLISHED: [usize; 6] = [0, 2, 3, 4, 6, 8];

fn main() -> ExitCode {
    match demolition() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("demolition: {error}");
            ExitCode::FAILURE
        }
    }
}

fn demolition() -> Result<(), support::Error> {
    let (wall, shots) = (scene::wall()?, scene::shots()?);
    let repeats = repeats()?;
    let mut pictures = Vec::new();
    let mut run = play(&wall, &shots, |step, bodies, app| {
        if PICTURES.contains(&step) {
            let taken = picture(app.world_mut());
            taken.save(Path::new(FOLDER).join(format!("{:04}.png", pictures.len())))?;
            let label = format!("t = {:.1} s, {bodies} bodies", step as f64 * H);
            pictures.push((label, taken));
        }
        Ok(())
    })?;
    for _ in 1..repeats {
        run.keep_least(&play(&wall, &shots, |_, _, _| Ok(()))?)?;
    }
    contact_sheet(&pictures, 3, 3).save(Path::new(FOLDER).join("contact_sheet.png"))?;
    if std::env::args().any(|argument| argument == "--publish") {
        let some = PUBLISHED.map(|number| pictures[number].clone());
        contact_sheet(&some, 3, 4).save("docs/demolition.png")?;
    }
    run.plot()?;
    println!("bricks: {}", wall.len() - 1);
    println!("shots: {}", shots.len());
    println!("repeats: {repeats}");
    run.print();
    Ok(())
}

/// How often the scene is to be played.
fn repeats() -> Result<usize, support::Error> {
    let mut rest = std::env::args().skip_while(|argument| argument != "--repeats");
    match (rest.next(), rest.next()) {
        (None, _) => Ok(1),
        (_, Some(count)) => Ok(count.parse()?),
        (Some(_), None) => Err("how many repeats?".into()),
    }
}

/// Plays the scene; `look` sees the app after each step, whose number and number of bodies it gets.
fn play(
    wall: &[BodyDesc],
    shots: &[Shot],
    mut look: impl FnMut(usize, usize, &mut App) -> Result<(), support::Error>,
) -> Result<Run, support::Error> {
    let mut app = scene::app();
    for (number, body) in wall.iter().enumerate() {
        scene::spawn(app.world_mut(), body, clay(number));
    }
    let mut run = Run::default();
    let bar = ProgressBar::new(STEPS as u64).with_style(ProgressStyle::with_template(
        "{bar:40} {pos}/{len} steps  {msg}",
    )?);
    for step in 1..=STEPS {
        for shot in shots.iter().filter(|shot| shot.step == step) {
            run.books.brought_in(&shot.body);
            scene::spawn(app.world_mut(), &shot.body, IRON);
        }
        run.step(&mut app);
        look(step, run.bodies, &mut app)?;
        bar.set_message(format!("{} bodies", run.bodies));
        bar.inc(1);
    }
    bar.finish();
    Ok(run)
}

/// What is remembered of the steps.
#[derive(Default)]
struct Run {
    bodies: usize,
    step_ms: Vec<f64>,
    cpu_ms: Vec<f64>,
    /// Pieces that each step made.
    made: Vec<usize>,
    /// Most bodies that had to wait for their turn to break.
    most_waiting: usize,
    contacts: usize,
    books: Books,
}

impl Run {
    fn step(&mut self, app: &mut App) {
        let (cpu, start) = (CpuClock::now(), Instant::now());
        app.update();
        self.step_ms.push(start.elapsed().as_secs_f64() * 1e3);
        self.cpu_ms.push(CpuClock::now().ms_since(&cpu));
        let world = app.world();
        let (bodies, fractures) = (world.resource::<Bodies>(), world.resource::<Fractures>());
        let pieces = fractures.done.iter().map(|fracture| fracture.pieces.len());
        self.made.push(pieces.sum());
        self.most_waiting = self.most_waiting.max(fractures.waiting());
        self.contacts = world.resource::<StepReport>().contacts;
        self.bodies = bodies.len();
        self.books.close(bodies, &fractures.done);
    }

    /// Keeps the least time that a step took in this run and another one.
    fn keep_least(&mut self, other: &Self) -> Result<(), support::Error> {
        if self.made != other.made {
            return Err("the same scene broke into other pieces".into());
        }
        let least = |times: &mut [f64], others: &[f64]| {
            for (time, other) in times.iter_mut().zip(others) {
                *time = time.min(*other);
            }
        };
        least(&mut self.step_ms, &other.step_ms);
        least(&mut self.cpu_ms, &other.cpu_ms);
        Ok(())
    }

    fn plot(&self) -> Result<(), support::Error> {
        let series = |values: &mut dyn Iterator<Item = f64>| {
            let numbered = (0..).zip(values);
            numbered
                .map(|(i, value)| (f64::from(i) * H, value))
                .collect::<Vec<_>>()
        };
        let panel = |label: &str, unit: &str, values: &mut dyn Iterator<Item = f64>| Panel {
            label: label.into(),
            unit: unit.into(),
            log: false,
            series: series(values),
        };
        let mut ratios = hitch::ratios(&self.step_ms, &self.made, Kind::Fracture).into_iter();
        let panels = [
            panel("step", "ms", &mut self.step_ms.iter().copied()),
            panel("pieces made", "", &mut self.made.iter().map(|&n| n as f64)),
            panel("fracture step / neighbors", "", &mut ratios),
        ];
        let path = Path::new(FOLDER).join("plot.png");
        time_series(path, "demolition", &panels)
    }

    fn print(&self) {
        let pieces: usize = self.made.iter().sum();
        let steps = self.made.iter().filter(|&&made| made > 0).count();
        println!("bodies: {}", self.bodies);
        println!("pieces_made: {pieces}");
        println!(
            "pieces_made_in_a_step_max: {}",
            self.made.iter().max().unwrap_or(&0)
        );
        println!("steps_with_fracture: {steps}");
        println!("waiting_max: {}", self.most_waiting);
        println!("contacts_final: {}", self.contacts);
        for (name, times) in [("step", &self.step_ms), ("cpu", &self.cpu_ms)] {
            println!("{name}_ms_median: {:.3}", stats::median(times));
            println!("{name}_ms_p99: {:.3}", stats::percentile(times, 0.99));
            println!("{name}_ms_max: {:.3}", stats::max(times));
            for (kind, which) in [("fracture", Kind::Fracture), ("quiet", Kind::Quiet)] {
                let ratios = hitch::ratios(times, &self.made, which);
                let (worst, step) = worst(&ratios);
                let ratios = hitch::finite(&ratios);
                println!(
                    "{name}_{kind}_to_neighbors_median: {:.2}",
                    stats::median(&ratios)
                );
                println!(
                    "{name}_{kind}_to_neighbors_p95: {:.2}",
                    stats::percentile(&ratios, 0.95)
                );
                println!("{name}_{kind}_to_neighbors_worst: {worst:.2} (step {step})");
            }
        }
        self.books.print();
        println!("pictures: {FOLDER}/");
    }
}

/// The scene as it is now, seen from in front of the wall.
fn picture(world: &mut World) -> Picture {
    let mut scene = Scene::default();
    let mut drawn = world.query::<(&ConvexMesh, &Transform, &Color)>();
    for (mesh, transform, color) in drawn.iter(world) {
        let pose = Pose::new(transform.translation, transform.rotation);
        scene.draw(&mesh.render_mesh(), pose, color.0);
    }
    let (eye, target) = (Vec3::new(9.5, 7.0, 15.0), Vec3::new(0.0, 1.6, 0.0));
    scene.render(&Camera::look_at(eye, target, Vec3::Y, 40.0, 1120, 720))
}
