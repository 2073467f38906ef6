//! Scenes whose answer is known, and how far off it a simulation ends.
//!
//! The formulas are those of `tests/it/hard_cases`, which says why each case is hard.

use crate::dice::Dice;
use crate::measure::{G, H, displacement, drift, energy, frames, simulation_with, spin, steps};
use crate::settings::Size;
use crate::structures::*;
use bevy_cleave::prelude::*;
use glam::Vec3;
use std::sync::OnceLock;
use std::time::Instant;

/// A displacement, m, from which a structure counts as fallen.
const FALLEN: f64 = 0.1;

/// A scene and its measure of error.
pub(crate) struct Scene {
    /// Name of its picture and in the table of results.
    pub(crate) key: &'static str,
    pub(crate) title: &'static str,
    /// What the error is.
    pub(crate) measure: &'static str,
    /// Unit of the error; empty for a pure number.
    pub(crate) unit: &'static str,
    /// What counts as good.
    pub(crate) bar: f64,
    /// Error from which the scene counts as failed: what is left says nothing about the method then.
    pub(crate) failed_above: f64,
    pub(crate) size: Size,
    /// Runs it and returns the error; NaN if it did not get to where the error is measured.
    pub(crate) run: fn(&mut Run) -> f64,
}

/// What is recorded of a scene while it runs.
#[derive(Debug)]
pub(crate) struct Run {
    config: SolverConfig,
    /// Times of the steps, ms.
    pub(crate) times: Vec<f64>,
    /// Most contact points of a step.
    pub(crate) contacts: usize,
    /// Steps in which an island ended above the tolerance, or without a certificate.
    pub(crate) unconverged: usize,
}

impl Run {
    pub(crate) fn new(config: SolverConfig) -> Self {
        Self {
            config,
            times: Vec::new(),
            contacts: 0,
            unconverged: 0,
        }
    }

    fn simulation(&self, bodies: impl IntoIterator<Item = BodyDesc>) -> Simulation {
        simulation_with(self.config, bodies)
    }

    fn step_by(&mut self, simulation: &mut Simulation, h: f32) {
        let clock = Instant::now();
        simulation.step(h);
        self.times.push(1e3 * clock.elapsed().as_secs_f64());
        let report = &simulation.report;
        self.contacts = self.contacts.max(report.contacts);
        self.unconverged += usize::from(!report.unconverged.is_empty());
    }

    fn step(&mut self, simulation: &mut Simulation) {
        self.step_by(simulation, H);
    }

    fn run(&mut self, simulation: &mut Simulation, seconds: f64) {
        (0..steps(seconds)).for_each(|_| self.step(simulation));
    }

    /// Largest displacement of a body that should rest for `seconds`, m.
    fn rest(&mut self, bodies: Vec<BodyDesc>, seconds: f64) -> f64 {
        self.watch(bodies, seconds, displacement)
    }

    /// Largest of what `moved` makes of the frames of the bodies as built, m; ends early when the structure has fallen.
    fn watch(
        &mut self,
        bodies: Vec<BodyDesc>,
        seconds: f64,
        moved: fn(&Simulation, &[Pose]) -> f32,
    ) -> f64 {
        let mut simulation = self.simulation(bodies);
        let start = frames(&simulation);
        let mut most = 0.0_f64;
        for _ in 0..steps(seconds) {
            self.step(&mut simulation);
            most = most.max(f64::from(moved(&simulation, &start)));
            if most > FALLEN {
                break;
            }
        }
        most
    }
}

/// Largest displacement of a body, for the scenes in which nothing should move.
const MOVED: &str = "largest displacement of a body within 10 s; none is right";

/// A structure that should rest for 10 s.
const fn structure(
    key: &'static str,
    title: &'static str,
    size: Size,
    bar: f64,
    run: fn(&mut Run) -> f64,
) -> Scene {
    Scene {
        key,
        title,
        measure: MOVED,
        unit: "m",
        bar,
        failed_above: FALLEN,
        size,
        run,
    }
}

/// All scenes; those that the short form leaves out come last.
pub(crate) fn all() -> Vec<Scene> {
    let mut list = moving();
    list.extend([
        Scene {
            measure: "largest horizontal displacement of a cube within 10 s; none is right",
            ..structure("tower_40", "Tower of 40 cubes", Size::Small, 5e-3, |run| {
                run.watch(tower(40), 10.0, drift)
            })
        },
        structure(
            "load_100",
            "4 cubes under a load of 100 times their mass",
            Size::Small,
            1e-2,
            |run| run.rest(mass_ratio(100.0), 10.0),
        ),
        structure(
            "load_1000",
            "4 cubes under a load of 1000 times their mass",
            Size::Small,
            2e-2,
            |run| run.rest(mass_ratio(1000.0), 10.0),
        ),
        structure(
            "arch",
            "Arch of 15 voussoirs, thickness 0.117 of the radius",
            Size::Medium,
            1e-2,
            |run| run.rest(arch(15, 0.117, 0.9), 10.0),
        ),
        structure(
            "card_house",
            "Loaded card house, 10 % above its least friction",
            Size::Small,
            1e-2,
            |run| {
                let mu = 1.1 * card_house_friction(true);
                run.rest(card_house(mu as f32, true), 10.0)
            },
        ),
        structure(
            "corbel",
            "10 planks at 97 % of the harmonic overhang",
            Size::Small,
            1e-2,
            |run| run.rest(corbel(10, 0.97), 10.0),
        ),
        Scene {
            measure: "largest displacement of a cube within 5 s; none is right",
            ..structure(
                "pyramid_30",
                "Pyramid of base 30 (465 cubes)",
                Size::Large,
                1e-2,
                |run| run.rest(pyramid(30), 5.0),
            )
        },
        Scene {
            measure: "largest displacement of a cube within 5 s; none is right",
            ..structure(
                "pyramid_50",
                "Pyramid of base 50 (1275 cubes)",
                Size::Large,
                1e-2,
                |run| run.rest(pyramid(50), 5.0),
            )
        },
    ]);
    list
}

fn moving() -> Vec<Scene> {
    vec![
        Scene {
            key: "sliding_stop",
            title: "Cube that slides to a stop, 8 directions",
            measure: "error of the distance against v^2 / (2 mu g), worst direction",
            unit: "",
            bar: 1e-2,
            failed_above: 1.0,
            size: Size::Small,
            run: sliding_stop,
        },
        Scene {
            key: "slope_creep",
            title: "Cube on a slope 0.1 degree below the angle of friction",
            measure: "creep in 9 s, worst of 8 directions; none is right",
            unit: "m",
            bar: 9e-4,
            failed_above: FALLEN,
            size: Size::Small,
            run: slope_creep,
        },
        Scene {
            key: "bounce",
            title: "Cube and corner dropped from 1 m, e = 0.5",
            measure: "error of the heights 1/4, 1/16, 1/64 m, the worst",
            unit: "",
            bar: 3e-2,
            failed_above: 1.0,
            size: Size::Small,
            run: bounce,
        },
        Scene {
            key: "dominoes",
            title: "Row of 20 dominoes",
            measure: "error of the speed of the wave against converged impacts in quarter steps",
            unit: "",
            bar: 3e-2,
            failed_above: 1.0,
            size: Size::Medium,
            run: dominoes_wave,
        },
        Scene {
            key: "fracture_block",
            title: "Resting block cut in place into 32 pieces",
            measure: "largest displacement of a piece within 1 s; none is right",
            unit: "m",
            bar: 1e-3,
            failed_above: FALLEN,
            size: Size::Medium,
            run: fracture_block,
        },
        Scene {
            key: "dzhanibekov",
            title: "Free box that flips for 60 s (no contacts)",
            measure: "largest change of |L| or of the energy",
            unit: "",
            bar: 1e-3,
            failed_above: 1.0,
            size: Size::Small,
            run: dzhanibekov,
        },
    ]
}

/// Eight directions about the vertical, degrees.
fn headings() -> impl Iterator<Item = f64> {
    (0..8_u8).map(|k| 45.0 * f64::from(k))
}

fn sliding_stop(run: &mut Run) -> f64 {
    let exact = 100.0 / G;
    let errors = headings().map(|heading| {
        let mut simulation = run.simulation(sliding_box(0.5, 10.0, heading));
        run.run(&mut simulation, 3.0);
        let way = simulation.bodies.center_of_mass(1) - 0.5 * Vec3::Y;
        (f64::from(way.length()) / exact - 1.0).abs()
    });
    errors.fold(0.0, f64::max)
}

fn slope_creep(run: &mut Run) -> f64 {
    let degrees = 0.6_f64.atan().to_degrees() - 0.1;
    let creep = headings().map(|heading| {
        let mut simulation = run.simulation(slope_box(Vec3::ONE, 0.6, degrees, heading));
        let down = downhill(degrees, heading);
        let place = |simulation: &Simulation| simulation.bodies.center_of_mass(1).dot(down);
        // In the first second it settles from a cold start.
        run.run(&mut simulation, 1.0);
        let settled = place(&simulation);
        run.run(&mut simulation, 9.0);
        f64::from((place(&simulation) - settled).abs())
    });
    creep.fold(0.0, f64::max)
}

fn bounce(run: &mut Run) -> f64 {
    let corners = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| [0.5 * axis, -0.5 * axis]);
    let octahedron = ConvexMesh::from_points(&corners.concat()).expect("valid size");
    let shapes = [cuboid(Vec3::ONE), octahedron];
    let errors = shapes.map(|shape| {
        let mut apexes = apexes(run, &shape).into_iter();
        let exact = [0.25, 0.0625, 0.015_625];
        let error = |exact: f64| (apexes.next().unwrap_or(f64::NAN) / exact - 1.0).abs();
        exact.map(error).into_iter().fold(0.0, worse)
    });
    worse(errors[0], errors[1])
}

/// The larger error; NaN, which a missing figure is, is larger than all.
fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// Heights of the apexes of a body that is dropped from 1 m and keeps half its speed at each impact, m.
fn apexes(run: &mut Run, shape: &ConvexMesh) -> Vec<f64> {
    let restitution = Restitution::new(0.5);
    let bodies = [floor(0.5), block(shape, 1.5 * Vec3::Y, 0.5)];
    let mut simulation = run.simulation(bodies.map(|body| BodyDesc {
        restitution,
        ..body
    }));
    let (mut apexes, mut last) = (Vec::new(), 0.0);
    for _ in 0..steps(2.0) {
        run.step(&mut simulation);
        let speed = f64::from(simulation.bodies.velocity(1).0.y);
        if last > 0.0 && speed <= 0.0 {
            // The apex lies between two steps: as high above here as a fall to this speed is deep.
            let height = f64::from(simulation.bodies.center_of_mass(1).y) - 0.5;
            apexes.push(height + speed * speed / (2.0 * G));
        }
        last = speed;
    }
    apexes
}

/// Relative to the same row in quarter steps with 64 sweeps.
fn dominoes_wave(run: &mut Run) -> f64 {
    static EXACT: OnceLock<f64> = OnceLock::new();
    let exact = EXACT.get_or_init(|| {
        let converged = SoftStep {
            sweeps: 32,
            relax_sweeps: 32,
            ..SoftStep::default()
        };
        wave_speed(&mut Run::new(converged.into()), H / 4.0)
    });
    (wave_speed(run, H) / exact - 1.0).abs()
}

/// Speed of the wave from the sixth to the last of 20 dominoes in steps of `h` seconds, m/s; NaN if it dies.
fn wave_speed(run: &mut Run, h: f32) -> f64 {
    let mut simulation = run.simulation(dominoes(20));
    let (mut last, mut times) = ([0.0; 2], [f64::NAN; 2]);
    for k in 0..(8.0 / h).round() as usize {
        run.step_by(&mut simulation, h);
        for (i, slot) in [6, 20].into_iter().enumerate() {
            let up = simulation.bodies.pose(slot).rotation * Vec3::Y;
            let now = f64::from(up.x);
            if last[i] < 0.1 && now >= 0.1 {
                times[i] = (k as f64 + (0.1 - last[i]) / (now - last[i])) * f64::from(h);
            }
            last[i] = now;
        }
        if times[1].is_finite() {
            break;
        }
    }
    14.0 * 0.5 / (times[1] - times[0])
}

/// A block of 4 x 2 x 4 m is cut by seven planes out of true by up to 5 %; the step of the cut is not timed.
fn fracture_block(run: &mut Run) -> f64 {
    let shape = cuboid(Vec3::new(4.0, 2.0, 4.0));
    let mut simulation = run.simulation([floor(0.6), block(&shape, Vec3::Y, 0.6)]);
    (0..30).for_each(|_| simulation.step(H));
    let mut dice = Dice::new(29);
    for (at, normal) in cuts_of_block() {
        let turned = normal + 0.05 * dice.vector(-1.0, 1.0);
        let through = at * normal + Vec3::Y * (1.0 - normal.y);
        let plane = Plane::through(through, turned);
        simulation.slice(1, plane).expect("a body");
    }
    simulation.step(H);
    let start = frames(&simulation);
    run.run(&mut simulation, 1.0);
    f64::from(displacement(&simulation, &start))
}

fn dzhanibekov(run: &mut Run) -> f64 {
    let mut body = block(&cuboid(Vec3::new(1.0, 0.5, 0.2)), Vec3::ZERO, 0.5);
    body.angular_velocity = Vec3::new(0.01, 10.0, 0.01);
    let mut simulation = run.simulation([body]);
    simulation.gravity = Gravity(Vec3::ZERO);
    // Computes the masses.
    simulation.step(1e-9);
    let (l0, e0) = (spin(&simulation, 0).length(), energy(&simulation));
    let mut worst = 0.0_f64;
    for _ in 0..steps(60.0) {
        run.step(&mut simulation);
        let (l, e) = (spin(&simulation, 0).length(), energy(&simulation));
        worst = worst.max((l / l0 - 1.0).abs()).max((e / e0 - 1.0).abs());
    }
    worst
}
