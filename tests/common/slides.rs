//! Slides over floors of flush pieces, drawn at random: what slides, how fast, over what, at what angle to the seams and to gravity,
//! with and without friction.
#![allow(dead_code, reason = "each user needs some of it")]
#![allow(clippy::print_stdout, reason = "the measured figures are the result")]
#![allow(clippy::disallowed_methods, reason = "angles and speeds of scenes")]

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use crate::common::structures::{block, cuboid, fixed};
use bevy_cleave::geometry::Face;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

pub(crate) const H: f32 = 1.0 / 60.0;
pub(crate) const G: f32 = 9.81;

/// How much deeper or higher than on one piece a body may lie, as a share of its least extent: the sag of a soft contact.
pub(crate) const SAG: f32 = 1.25e-4;

/// Share of the speed that a seam may change.
pub(crate) const SPEED: f32 = 1e-3;

/// How many slides of 160 drawn at random, but for those that topple, differ from the slide over one piece, and how many there were;
/// prints those that do.
pub(crate) fn count_different(floor: Floor) -> [usize; 2] {
    let (mut failed, mut ran) = (0, 0);
    for seed in 0..160 {
        let slide = Slide::random(&mut Dice::new(seed));
        let Some([speed, height]) = slide.differences(floor) else {
            continue;
        };
        ran += 1;
        // What goes over several pieces in a step falls a little in between.
        let is_fast = slide.speed * H > 0.5 * slide.tile;
        let fall = if is_fast { 0.05 * G * H * H } else { 0.0 };
        let least = slide.slider.shape.hull().aabb().extents().min_element();
        if speed > SPEED || height > 2.0 * SAG + fall / least {
            failed += 1;
            println!(
                "{seed}: speed off by {speed:.1e}, height by {height:.1e} of the extent: {}",
                slide.describe()
            );
        }
    }
    println!("{failed} of {ran} slides differ");
    [failed, ran]
}

/// What the floor is made of.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Floor {
    /// One piece.
    Whole,
    /// A body for each piece.
    Bodies,
    /// One body with a part for each piece.
    Compound,
}

/// What slides: its shape, standing on a face, turned so that the face is at the bottom.
#[derive(Clone)]
pub(crate) struct Slider {
    pub(crate) shape: ConvexMesh,
    pub(crate) rotation: Quat,
    /// Of the centre of mass above the floor, m.
    pub(crate) height: f32,
    pub(crate) name: &'static str,
}

impl Slider {
    pub(crate) fn random(dice: &mut Dice) -> Self {
        let size = 0.2 + dice.unit();
        let (name, shape) = match dice.below(6) {
            0 => ("cube", cuboid(Vec3::splat(size))),
            1 => ("plate", cuboid(Vec3::new(size, 0.15 * size, size))),
            2 => ("rod", cuboid(Vec3::new(2.0 * size, 0.1 * size, 0.1 * size))),
            3 => (
                "prism",
                regular_prism(3 + dice.below(6), 0.5 * size, 0.6 * size),
            ),
            4 => ("round", round(0.5 * size)),
            _ => ("hull", random_hull(dice, size)),
        };
        Self::standing(name, shape)
    }

    /// On its largest face, or the lowest of those.
    pub(crate) fn standing(name: &'static str, shape: ConvexMesh) -> Self {
        let hull = shape.hull();
        let area = |face: &Face| {
            let corners = hull.face_loop(face);
            let at = |i: usize| hull.vertices()[corners[i % corners.len()] as usize];
            let cross = (1..corners.len() - 1).map(|i| (at(i) - at(0)).cross(at(i + 1) - at(0)));
            cross.sum::<Vec3>().length()
        };
        let lowness = |face: &Face| -face.plane.normal.y;
        let best = hull.faces().iter().max_by(|a, b| {
            let score = |f| area(f) * (1.0 + 1e-3 * lowness(f));
            score(a).total_cmp(&score(b))
        });
        let plane = best.expect("a face").plane;
        let rotation = Quat::from_rotation_arc(plane.normal, Vec3::NEG_Y);
        Self {
            height: plane.offset,
            rotation,
            shape,
            name,
        }
    }
}

fn regular_prism(sides: usize, radius: f32, height: f32) -> ConvexMesh {
    ConvexMesh::regular_prism(sides as u32, radius, height).expect("valid sizes")
}

fn round(radius: f32) -> ConvexMesh {
    ConvexMesh::icosphere(radius, 2).expect("valid radius")
}

fn random_hull(dice: &mut Dice, size: f32) -> ConvexMesh {
    let points: Vec<Vec3> = (0..24).map(|_| 0.5 * size * dice.direction()).collect();
    ConvexMesh::from_points(&points).expect("points on a sphere")
}

/// The pieces of a floor whose surface is y = 0, as shapes and places, around a way of `length` m that runs at an angle
/// `heading` about y to the seams.
fn pieces(dice: &mut Dice, length: f32, heading: f32, tile: f32) -> Vec<(ConvexMesh, Vec3)> {
    let thick = 0.5;
    let way = Quat::from_rotation_y(-heading) * Vec3::X;
    let count = (length / tile).ceil() as i32 + 6;
    let kind = dice.below(3);
    if kind == 0 {
        // Planks across.
        let plank = cuboid(Vec3::new(tile, thick, 40.0));
        let first = if way.x < 0.0 { -count } else { -4 };
        let places = first..first + count + 4;
        return places
            .map(|i| (plank.clone(), Vec3::new(i as f32 * tile, -0.5 * thick, 0.0)))
            .collect();
    }
    let cells = (-count..=count)
        .flat_map(|i| (-count..=count).map(move |k| tile * Vec3::new(i as f32, 0.0, k as f32)));
    let near = cells.filter(|at| {
        let along = at.dot(way).clamp(0.0, length);
        (at - along * way).length() < 1.5 + tile
    });
    if kind == 1 {
        let shape = cuboid(Vec3::new(tile, thick, tile));
        return near
            .map(|at| (shape.clone(), at - 0.5 * thick * Vec3::Y))
            .collect();
    }
    // Two prisms in place of each tile.
    let corner = |x: f32, z: f32| 0.5 * tile * Vec3::new(x, 0.0, z);
    let half = |corners: [Vec3; 3]| {
        let points = corners.into_iter().flat_map(|c| [c, c - thick * Vec3::Y]);
        ConvexMesh::from_points(&points.collect::<Vec<_>>()).expect("a prism")
    };
    let halves = [
        half([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0)]),
        half([corner(-1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]),
    ];
    near.flat_map(|at| halves.clone().map(|half| (half, at)))
        .collect()
}

/// A slide: over pieces, or over one.
pub(crate) struct Slide {
    pub(crate) slider: Slider,
    pub(crate) speed: f32,
    mu: f32,
    /// Angle of gravity to the floor's normal, rad: a slope or a wall that falls along the way.
    lean: f32,
    /// Of the whole scene.
    turn: Quat,
    /// Of the slider about the normal.
    yaw: f32,
    /// Of the floor about the normal, rad.
    heading: f32,
    pieces: Vec<(ConvexMesh, Vec3)>,
    pub(crate) tile: f32,
    steps: usize,
}

impl Slide {
    pub(crate) fn random(dice: &mut Dice) -> Self {
        let slider = Slider::random(dice);
        let speed = 0.05 * 1000.0_f32.powf(dice.unit());
        let mu = [0.0, 0.0, 0.02, 0.15][dice.below(4)];
        let lean = [0.0, 0.0, 0.3, std::f32::consts::FRAC_PI_2][dice.below(4)];
        let tile = [0.25, 0.6, 1.0, 2.0][dice.below(4)];
        let length = (2.0 * speed).clamp(0.1, 40.0 * tile).min(16.0);
        let steps = ((length / speed / H) as usize).clamp(8, 240);
        let heading = [0.0, 0.0, 0.7, 3.0 * dice.unit()][dice.below(4)];
        // A fall along the floor ends after 12 m.
        let fall = (2.0 * 12.0 / (G * lean.sin() + 1e-3)).sqrt();
        let steps = steps.min((fall / H) as usize);
        let reach = length + 0.5 * G * lean.sin() * (steps as f32 * H).powi(2);
        let pieces = pieces(dice, reach, heading, tile);
        let yaw = [0.0, 3.0 * dice.unit()][dice.below(2)];
        let turn = [Quat::IDENTITY, dice.rotation()][dice.below(2)];
        Self {
            slider,
            speed,
            mu,
            lean,
            turn,
            yaw,
            heading,
            pieces,
            tile,
            steps,
        }
    }

    pub(crate) fn describe(&self) -> String {
        format!(
            "{} at {:.3} m/s, mu {}, lean {:.1}, heading {:.2}, yaw {:.2}, tiles of {} m ({})",
            self.slider.name,
            self.speed,
            self.mu,
            self.lean,
            self.heading,
            self.yaw,
            self.tile,
            self.pieces.len()
        )
    }

    fn simulation(&self, kind: Floor) -> (Simulation, u32) {
        let gravity = G * Vec3::new(self.lean.sin(), -self.lean.cos(), 0.0);
        let mut simulation = Simulation {
            gravity: Gravity(self.turn * gravity),
            ..awake()
        };
        let heading = Quat::from_rotation_y(self.heading);
        let mut add = |mut desc: BodyDesc, own: Quat| {
            desc.pose = Pose::new(
                self.turn * desc.pose.position,
                (self.turn * own * desc.pose.rotation).normalize(),
            );
            desc.linear_velocity = self.turn * desc.linear_velocity;
            simulation.bodies.insert(desc).expect("usable body")
        };
        // The first tiles lie around the start, at a corner of four.
        let pieces = self.pieces.iter().map(|(shape, at)| {
            let at = *at + 0.37 * self.tile * Vec3::new(1.0, 0.0, 1.0);
            (heading * at, shape)
        });
        match kind {
            Floor::Whole => {
                let slab = cuboid(Vec3::new(200.0, 0.5, 200.0));
                add(fixed(&slab, -0.25 * Vec3::Y, self.mu), heading);
            }
            Floor::Bodies => pieces.for_each(|(at, shape)| {
                add(fixed(shape, at, self.mu), heading);
            }),
            Floor::Compound => {
                let parts = pieces.map(|(at, shape)| (Pose::new(at, heading), shape.clone()));
                let compound = Compound::new(parts).expect("usable parts");
                let desc = BodyDesc {
                    friction: Friction::new(self.mu),
                    ..BodyDesc::new(RigidBody::Static, Shape::Compound(compound))
                };
                add(desc, Quat::IDENTITY);
            }
        }
        let Slider {
            shape,
            rotation,
            height,
            ..
        } = &self.slider;
        let mut body = block(shape, *height * Vec3::Y, self.mu);
        body.pose.rotation = *rotation;
        body.linear_velocity = self.speed * Vec3::X;
        let body = add(body, Quat::from_rotation_y(self.yaw));
        (simulation, body)
    }

    /// Largest difference of speed, as a share of it, and of height, as a share of the least extent, to the slide over one
    /// piece; none if that one topples.
    pub(crate) fn differences(&self, kind: Floor) -> Option<[f32; 2]> {
        let [(mut tiled, body), (mut whole, same)] =
            [kind, Floor::Whole].map(|kind| self.simulation(kind));
        let mut worst = [0.0_f32; 2];
        let least = self.slider.shape.hull().aabb().extents().min_element();
        let radius = 0.5 * self.slider.shape.hull().aabb().diagonal();
        for _ in 0..self.steps {
            tiled.step(H);
            whole.step(H);
            let state = |s: &Simulation, b| (s.bodies.center_of_mass(b), s.bodies.velocity(b));
            let ((x, (v, w)), (y, (u, spin))) = (state(&tiled, body), state(&whole, same));
            if spin.length() * radius > 0.02 * self.speed.max(u.length()) {
                return None;
            }
            let speed = self.speed.max(u.length());
            let up = self.turn * Vec3::Y;
            let off = v - u;
            // What the sag of the next piece does to a small face on which it stands.
            // A body may move by its sag within a step.
            let sag = SAG * least / H;
            let rocking = 0.05 * radius * (w - spin).length() - 0.25 * sag;
            let bobbing = off.dot(up).abs() - sag;
            let change = off.reject_from(up).length().max(rocking).max(bobbing);
            worst[0] = worst[0].max(change / speed);
            worst[1] = worst[1].max((x - y).dot(up).abs() / least);
        }
        Some(worst)
    }
}
