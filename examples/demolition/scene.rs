//! A wall of bricks and what is shot at it.

use crate::support;
use bevy_app::{App, TaskPoolPlugin};
use bevy_cleave::geometry::primitives;
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_time::{Fixed, Time, TimePlugin, TimeUpdateStrategy};
use glam::{Quat, Vec3};
use std::time::Duration;

/// Length of a step, s.
pub(crate) const H: f64 = 1.0 / 60.0;
/// Length, height and depth of a brick, m.
const BRICK: Vec3 = Vec3::new(0.6, 0.3, 0.3);
/// Whole bricks of a course, and courses.
const LENGTH: u8 = 24;
const COURSES: u8 = 21;
/// Of brick, kg/m3.
const DENSITY: f32 = 1900.0;
/// Of the shots, kg/m3: iron.
const SHOT_DENSITY: f32 = 7200.0;

/// What a body is drawn in; pieces are clones of what they come from, so they have its color.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Color(pub(crate) Vec3);

/// What is shot when.
#[derive(Clone, Debug)]
pub(crate) struct Shot {
    pub(crate) step: usize,
    pub(crate) body: BodyDesc,
}

/// An app that makes one step with every update.
pub(crate) fn app() -> App {
    let mut app = App::new();
    app.add_plugins((TaskPoolPlugin::default(), TimePlugin));
    app.add_plugins(CleavePlugin::default());
    app.insert_resource(Time::<Fixed>::from_duration(Duration::from_secs_f64(H)));
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    app.update();
    app
}

/// A floor, and a wall of bricks in running bond with half bricks at its ends.
pub(crate) fn wall() -> Result<Vec<BodyDesc>, support::Error> {
    let mut bodies = vec![BodyDesc::floor(HalfSpaceShape::new(Vec3::Y)?)];
    let half_length = Vec3::new(0.5, 1.0, 1.0) * BRICK;
    let [whole, half] = [BRICK, half_length].map(|size| ConvexMesh::cuboid(size.x, size.y, size.z));
    let (whole, half) = (whole?, half?);
    let end = 0.5 * f32::from(LENGTH) * BRICK.x;
    for course in 0..COURSES {
        let y = (f32::from(course) + 0.5) * BRICK.y;
        let is_shifted = course % 2 == 1;
        let (count, first) = if is_shifted {
            (LENGTH - 1, BRICK.x - end)
        } else {
            (LENGTH, 0.5 * BRICK.x - end)
        };
        let row = (0..count).map(|i| (first + f32::from(i) * BRICK.x, &whole));
        let at_end = end - 0.25 * BRICK.x;
        let ends = [(-at_end, &half), (at_end, &half)].into_iter();
        for (x, mesh) in row.chain(ends.filter(|_| is_shifted)) {
            let mut body = BodyDesc::dynamic(mesh.clone(), Vec3::new(x, y, 0.0));
            body.density = DENSITY;
            body.fracturable = Some(brick(bodies.len() as u64));
            bodies.push(body);
        }
    }
    Ok(bodies)
}

/// Spawns a body in its color.
pub(crate) fn spawn(world: &mut World, body: &BodyDesc, color: Vec3) {
    let entity = world.spawn_body(body.clone());
    world.entity_mut(entity).insert(Color(color));
}

/// A brick stands the wall above it, which comes without energy, and breaks where it is hit at some metres per second.
fn brick(seed: u64) -> Fracturable {
    Fracturable {
        strength: 300.0,
        min_energy: 800.0,
        pattern: FracturePattern::Voronoi {
            cells: 16,
            focus: 0.3,
        },
        toughness: 400.0,
        max_pieces: 16,
        min_volume: 2e-5,
        generations: 2,
        seed,
        ..Fracturable::default()
    }
}

/// Iron balls, one after the other, that sweep over the wall from below.
pub(crate) fn shots() -> Result<Vec<Shot>, support::Error> {
    let ball = ConvexMesh::from_parts(primitives::icosphere(0.3, 1)?, None);
    let shot = |i: u8| {
        // Low, middle, high; the columns in an order that leaves no gap.
        let column = f32::from(i * 5 % 12) - 5.5;
        let height = 0.9 + 1.7 * f32::from(i / 4 % 3);
        let at = Vec3::new(1.15 * column, height, 9.0);
        let mut body = BodyDesc::dynamic(ball.clone(), at);
        body.pose.rotation = Quat::from_rotation_y(f32::from(i));
        body.linear_velocity = Vec3::new(0.0, 1.6, -28.0);
        body.density = SHOT_DENSITY;
        Shot {
            step: 16 + 8 * usize::from(i),
            body,
        }
    };
    Ok((0..20).map(shot).collect())
}
