//! The scenes, by name.

use crate::common::{scenes, structures};
use crate::hitch::{self, Kind};
use crate::settings::Setting;
use crate::support::stats;
use crate::wall::Shot;
use crate::{app, wall};
use bevy_app::App;
use bevy_cleave::prelude::*;
use glam::Vec3;
use weigh::Error;

/// Length of a step, s.
const H: f32 = 1.0 / 60.0;

/// Something that can be stepped.
pub(crate) struct Scene {
    world: World,
    /// Steps before the window that is measured, and in it.
    pub(crate) steps: (usize, usize),
    truth: Truth,
    shots: Vec<Shot>,
    /// Pieces that each step made.
    made: Vec<usize>,
}

enum World {
    Plain(Box<Simulation>),
    App(Box<App>),
}

/// What the error of a scene is.
enum Truth {
    /// The largest way of a body from where it was, m.
    Rest(Vec<Vec3>),
    /// Distance of the last body from this place, m.
    Place(Vec3),
    /// The mean overlap of contacts, m.
    NoOverlap,
    /// Median time of a step in which something broke, as a multiple of those around it.
    Hitch,
    /// Number of bodies in the end: no error, but a sign that two builds did the same.
    Count,
}

/// Builds a scene.
pub(crate) fn build(name: &str, setting: &str) -> Result<Scene, Error> {
    let (kind, size) = match name.rsplit_once('-') {
        Some((kind, size)) if size.parse::<usize>().is_ok() => (kind, size.parse()?),
        _ => (name, 0),
    };
    if kind == "app" {
        let steps = if size < 1000 {
            (200, 20_000 / size.max(10))
        } else {
            (0, 200)
        };
        return Scene::of_app(structures::columns(size), setting, steps);
    }
    let setting = &Setting::named(setting)?;
    let rest = |bodies: Vec<BodyDesc>, steps| {
        let places = bodies.iter().map(|body| body.pose.position).collect();
        Ok(Scene::plain(bodies, setting, steps, Truth::Rest(places)))
    };
    match kind {
        "stick" => rest(structures::tower(1), (100, 5000)),
        "tower" => rest(structures::tower(size), (0, 300)),
        "load" => rest(structures::mass_ratio(100.0), (0, 300)),
        "arch" => rest(structures::arch(15, 0.15, 0.7), (0, 300)),
        "cards" => rest(structures::card_house(0.6, true), (0, 300)),
        "pyramid" => rest(structures::pyramid(size), (0, 300)),
        "chain" => rest(chain(), (0, 120)),
        "slide" => {
            // Half way between the axes of its friction: 5 m/s and 0.5 of the weight stop it after v^2 / (2 mu g).
            let bodies = structures::sliding_box(0.5, 5.0, 45.0);
            let way = 25.0 / (2.0 * 0.5 * 9.81) * std::f32::consts::FRAC_1_SQRT_2;
            let end = Vec3::new(way, 0.5, way);
            Ok(Scene::plain(bodies, setting, (0, 120), Truth::Place(end)))
        }
        "pile" => {
            // The small one lands, the large ones rest.
            let steps = match size {
                200 => (0, 240),
                2000 => (160, 40),
                _ => (160, 20),
            };
            Ok(Scene::plain(
                scenes::heap(size),
                setting,
                steps,
                Truth::NoOverlap,
            ))
        }
        "wall" => Ok(Scene::of_wall(f32::INFINITY, size, setting)?),
        // 2.6 m wide.
        "small-wall" => Ok(Scene::of_wall(1.3, size, setting)?),
        // Four shots, with quiet steps in between.
        "lone-shots" => {
            let mut scene = Scene::of_wall(f32::INFINITY, size, setting)?;
            scene.shots.retain(|shot| shot.step % 40 == 16);
            Ok(scene)
        }
        // What is paid where nothing breaks.
        "calm-wall" => Ok(Scene::plain(wall::wall()?, setting, (0, 100), Truth::Count)),
        _ => Err(format!("no scene {name}").into()),
    }
}

/// Sixty dominoes lying end to end in a groove: a narrow structure, whose blocks are filled by colors.
fn chain() -> Vec<BodyDesc> {
    let mut bodies = structures::tower(0);
    let shape = structures::cuboid(Vec3::ONE);
    bodies.extend((0..60).map(|i| structures::block(&shape, Vec3::new(i as f32, 0.5, 0.0), 0.6)));
    bodies
}

impl Scene {
    fn plain(
        bodies: Vec<BodyDesc>,
        setting: &Setting,
        steps: (usize, usize),
        truth: Truth,
    ) -> Self {
        let mut simulation = Simulation {
            config: setting.config,
            overrides: setting.overrides,
            ..Default::default()
        };
        for body in bodies {
            simulation.bodies.insert(body).expect("usable");
        }
        Self {
            world: World::Plain(Box::new(simulation)),
            steps,
            truth,
            shots: Vec::new(),
            made: Vec::new(),
        }
    }

    /// The wall of the example `demolition` as far as `end` from its middle, under its fire, which is `variant` tenths of a
    /// metre aside.
    fn of_wall(end: f32, variant: usize, setting: &Setting) -> Result<Self, Error> {
        let mut bodies = wall::wall()?;
        bodies.retain(|body| body.kind == RigidBody::Static || body.pose.position.x.abs() < end);
        let mut scene = Self::plain(bodies, setting, (0, 176), Truth::Hitch);
        scene.shots = wall::shots()?;
        for shot in &mut scene.shots {
            shot.body.pose.position.x += 0.1 * variant as f32;
        }
        Ok(scene)
    }

    /// Through the plugin; or, to compare with, the plain step.
    fn of_app(bodies: Vec<BodyDesc>, way: &str, steps: (usize, usize)) -> Result<Self, Error> {
        if way == "plain" {
            return Ok(Self::plain(
                bodies,
                &Setting::named("default")?,
                steps,
                Truth::Count,
            ));
        }
        let mut app = app::app();
        for body in bodies {
            app.world_mut().spawn_body(body);
        }
        Ok(Self {
            world: World::App(Box::new(app)),
            steps,
            truth: Truth::Count,
            shots: Vec::new(),
            made: Vec::new(),
        })
    }

    pub(crate) fn step(&mut self) {
        match &mut self.world {
            World::Plain(simulation) => {
                let step = self.made.len() + 1;
                for shot in self.shots.iter().filter(|shot| shot.step == step) {
                    simulation.bodies.insert(shot.body.clone()).expect("usable");
                }
                simulation.step(H);
                let pieces = simulation
                    .fractures
                    .done
                    .iter()
                    .map(|fracture| fracture.pieces.len());
                self.made.push(pieces.sum());
            }
            World::App(app) => app.update(),
        }
    }

    /// What went wrong up to now, in a window of steps that took these times at the end.
    pub(crate) fn error(&self, times: &[f64]) -> f64 {
        let World::Plain(simulation) = &self.world else {
            return 0.0;
        };
        let place = |slot: usize| simulation.bodies.pose(slot as u32).position;
        match &self.truth {
            Truth::Rest(places) => {
                let ways = places
                    .iter()
                    .enumerate()
                    .map(|(i, p)| place(i).distance(*p));
                f64::from(ways.fold(0.0, f32::max))
            }
            Truth::Place(end) => f64::from(place(1).distance(*end)),
            Truth::NoOverlap => {
                let points = simulation.contacts.manifolds().points();
                let sum: f64 = points
                    .iter()
                    .map(|p| f64::from((-p.separation).max(0.0)))
                    .sum();
                sum / points.len().max(1) as f64
            }
            Truth::Hitch => {
                let made = &self.made[self.made.len() - times.len()..];
                stats::median(&hitch::finite(&hitch::ratios(times, made, Kind::Fracture)))
            }
            Truth::Count => simulation.bodies.len() as f64,
        }
    }
}
