//! `arena level`: what it costs to stand on a level of triangles and not on a plane, and how long the level takes to build.
//!
//! A thousand bodies, a third each of boxes, hulls and balls, on ground of so many triangles and on a plane: the two scenes make
//! their steps in turns. Told are medians of the times of steps while they land, while they slide and roll, and at rest. The ground is
//! level, or has hills of a height and a length, or bumps: corners that are higher than they would be by up to so much.

use crate::Error;
use crate::cli::{self, Arguments};
use crate::race::{H, race};
use crate::scene::random::Rng;
use bevy_cleave::prelude as ours;
use glam::{Quat, Vec3};
use std::time::Instant;

/// m.
const APART: f32 = 2.3;

struct Body {
    /// Of 0 to 2: box, hull, ball.
    kind: usize,
    points: Vec<Vec3>,
    at: Vec3,
    turn: Quat,
    velocity: Vec3,
}

/// Square ground.
struct Ground {
    cells: usize,
    /// m.
    spacing: f32,
    /// Height of hills over the middle, and from one to the next, m.
    hills: [f32; 2],
    /// How much higher a corner may be, m.
    bumps: f32,
}

impl Ground {
    fn half(&self) -> f32 {
        0.5 * self.spacing * self.cells as f32
    }

    /// Of the hills at a place, m.
    fn height(&self, x: f32, z: f32) -> f32 {
        let [height, length] = self.hills;
        let turn = std::f32::consts::TAU / length;
        0.5 * height * ((turn * x).sin() + (turn * z).cos())
    }

    /// Row by row, m.
    fn heights(&self) -> Vec<f32> {
        let (side, mut rng) = (self.cells + 1, Rng(3));
        let at = |k: usize| self.spacing * k as f32 - self.half();
        let corners = (0..side * side).map(|i| [at(i % side), at(i / side)]);
        let height = corners.map(|[x, z]| self.height(x, z) + self.bumps * rng.unit());
        height.collect()
    }
}

impl Body {
    /// Where it begins over a ground, or over a plane, m.
    fn over(&self, ground: Option<&Ground>) -> Vec3 {
        let height = ground.map_or(0.0, |ground| ground.height(self.at.x, self.at.z));
        self.at + height * Vec3::Y
    }
}

fn bodies(count: usize) -> Vec<Body> {
    let mut rng = Rng(11);
    let side = (count as f32).sqrt().ceil() as usize;
    let body = |i: usize| {
        let points = (0..16).map(|_| 0.45 * rng.direction()).collect();
        let middle = 0.5 * (side - 1) as f32;
        let (x, z) = ((i % side) as f32 - middle, (i / side) as f32 - middle);
        Body {
            kind: i % 3,
            points,
            at: Vec3::new(APART * x, 0.8 + 0.3 * rng.unit(), APART * z),
            turn: rng.rotation(),
            velocity: 3.0 * Vec3::new(rng.range(-1.0, 1.0), 0.0, rng.range(-1.0, 1.0)),
        }
    };
    (0..count).map(body).collect()
}

/// Ours, on a level or on a plane, and the time that the level took, s.
fn own(bodies: &[Body], ground: Option<&Ground>) -> Result<(ours::Simulation, f64), Error> {
    let mut simulation = ours::Simulation::default();
    simulation.config.sleep = ours::SleepConfig::off();
    let mut secs = 0.0;
    let floor = match ground {
        None => ours::BodyDesc::floor(ours::HalfSpaceShape { normal: Vec3::Y }),
        Some(ground) => {
            let heights = ground.heights();
            let begun = Instant::now();
            let level = ours::StaticMesh::from_heights(&heights, ground.cells + 1, ground.spacing)?;
            secs = begun.elapsed().as_secs_f64();
            let mut desc = ours::BodyDesc::level(level);
            desc.pose.position = -ground.half() * Vec3::new(1.0, 0.0, 1.0);
            desc
        }
    };
    simulation.bodies.insert(floor)?;
    for body in bodies {
        let shape = match body.kind {
            0 => ours::ConvexMesh::cuboid(0.8, 0.5, 0.6)?,
            1 => ours::ConvexMesh::from_points(&body.points)?,
            _ => ours::ConvexMesh::sphere(0.35)?,
        };
        let mut desc = ours::BodyDesc::dynamic(shape, body.over(ground));
        desc.pose.rotation = body.turn;
        desc.linear_velocity = body.velocity;
        simulation.bodies.insert(desc)?;
    }
    Ok((simulation, secs))
}

#[cfg(feature = "rapier")]
mod theirs {
    use super::{Body, Error, Ground, Instant};
    use rapier3d::prelude::*;

    /// The same in Rapier.
    pub(super) fn rapier(
        bodies: &[Body],
        ground: Option<&Ground>,
    ) -> Result<(PhysicsWorld, f64), Error> {
        let mut world = PhysicsWorld::new();
        world.integration_parameters.dt = super::H;
        world.physics_pipeline.configure_thread_pool(1)?;
        let mut secs = 0.0;
        let floor = match ground {
            None => SharedShape::halfspace(Vector::Y),
            Some(ground) => {
                let side = ground.cells + 1;
                let heights = ground.heights();
                let place = |i: usize| {
                    let at = |k: usize| ground.spacing * k as f32 - ground.half();
                    Vector::new(at(i % side), heights[i], at(i / side))
                };
                let points: Vec<Vector> = (0..side * side).map(place).collect();
                let corner = |x: usize, z: usize| (z * side + x) as u32;
                let cells = (0..ground.cells).flat_map(|z| (0..ground.cells).map(move |x| (x, z)));
                let triangles = cells.flat_map(|(x, z)| {
                    let [a, b] = [corner(x, z), corner(x + 1, z)];
                    let [c, d] = [corner(x, z + 1), corner(x + 1, z + 1)];
                    [[a, c, d], [a, d, b]]
                });
                let triangles = triangles.collect();
                let begun = Instant::now();
                let flags = TriMeshFlags::FIX_INTERNAL_EDGES;
                let shape = SharedShape::trimesh_with_flags(points, triangles, flags)?;
                secs = begun.elapsed().as_secs_f64();
                shape
            }
        };
        let body = world.insert_body(RigidBodyBuilder::fixed());
        world.insert_collider(ColliderBuilder::new(floor), Some(body));
        for body in bodies {
            let shape = match body.kind {
                0 => SharedShape::cuboid(0.4, 0.25, 0.3),
                1 => SharedShape::convex_hull(&body.points).ok_or("no hull")?,
                _ => SharedShape::ball(0.35),
            };
            let builder = RigidBodyBuilder::dynamic()
                .pose(Pose::from_parts(body.over(ground), body.turn))
                .linvel(body.velocity)
                .can_sleep(false);
            let handle = world.insert_body(builder);
            world.insert_collider(ColliderBuilder::new(shape).density(1000.0), Some(handle));
        }
        Ok((world, secs))
    }
}

/// What is timed: from which step to which.
const SPANS: [(&str, [usize; 2]); 3] = [
    ("landing", [10, 40]),
    ("sliding, rolling", [40, 120]),
    ("resting", [500, 600]),
];

fn tell(name: &str, ground: &Ground, secs: f64, times: Vec<[f64; 2]>) {
    let (triangles, spacing) = (2 * ground.cells.pow(2), ground.spacing);
    for ((span, _), [plane, level]) in SPANS.iter().zip(times) {
        println!(
            "| {name} | {triangles} of {spacing} m | {secs:.2} s | {span} | {plane:.3} | {level:.3} | {:.2} |",
            level / plane
        );
    }
}

/// Runs what the command line says.
pub(crate) fn run(mut words: Arguments) -> Result<(), Error> {
    let (mut count, mut cells, mut spacings) = (1000, 708, vec![0.7, 0.14]);
    let (mut hills, mut bumps) = (vec![0.0, 1.0], 0.0);
    while let Some(flag) = words.word() {
        match flag.as_str() {
            "--bodies" => count = words.value(&flag)?,
            "--cells" => cells = words.value(&flag)?,
            "--spacings" => spacings = words.list(&flag)?,
            "--hills" => hills = words.list(&flag)?,
            "--bumps" => bumps = words.value(&flag)?,
            _ => return Err(cli::unknown(&flag)),
        }
    }
    println!(
        "| engine | triangles | built in | {count} bodies | on a plane, ms | on triangles, ms | ratio |"
    );
    println!("|---|---|---|---|---|---|---|");
    let bodies = bodies(count);
    let hills = <[f32; 2]>::try_from(hills).map_err(|_| "--hills takes a height and a length")?;
    for spacing in spacings {
        let ground = &Ground {
            cells,
            spacing,
            hills,
            bumps,
        };
        let (mut level, secs) = own(&bodies, Some(ground))?;
        let (mut plane, _) = own(&bodies, None)?;
        tell(
            "ours",
            ground,
            secs,
            race([&mut plane, &mut level], &SPANS.map(|(_, span)| span)),
        );
        #[cfg(feature = "rapier")]
        {
            let (mut level, secs) = theirs::rapier(&bodies, Some(ground))?;
            let (mut plane, _) = theirs::rapier(&bodies, None)?;
            tell(
                "Rapier",
                ground,
                secs,
                race([&mut plane, &mut level], &SPANS.map(|(_, span)| span)),
            );
        }
    }
    Ok(())
}
