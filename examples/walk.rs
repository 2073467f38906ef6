//! A character walks a course: a ramp, stairs, a wall to slide along, crates to push, a lift and a turntable.
//!
//! Look for where it got to, and when. The picture in `target/walk` shows it every half second.
//!
//! `cargo run --release --example walk`
#![expect(clippy::print_stdout, reason = "an example prints what it shows")]
#[path = "support/mod.rs"]
mod support;

use bevy_app::{App, TaskPoolPlugin};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use glam::{Quat, Vec3};
use support::Error;
use support::render::{Camera, Scene, palette};

const FOLDER: &str = "target/walk";

/// Speed of the character, m/s.
const SPEED: f32 = 2.5;

/// Where it goes, one after the other, and what is there.
const COURSE: [(&str, Vec3); 8] = [
    ("up the ramp", Vec3::new(7.0, 2.0, 0.0)),
    ("down the stairs", Vec3::new(13.0, 0.0, 0.0)),
    ("along the wall", Vec3::new(15.0, 0.0, 6.0)),
    ("through the crates", Vec3::new(6.0, 0.0, 6.0)),
    ("onto the lift", Vec3::new(1.0, 0.3, 6.0)),
    ("off the lift", Vec3::new(1.0, 2.5, 9.5)),
    ("over the turntable", Vec3::new(7.0, 2.5, 10.0)),
    ("to the end", Vec3::new(12.0, 2.5, 10.0)),
];

fn main() -> Result<(), Error> {
    std::fs::create_dir_all(FOLDER)?;
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        TimePlugin,
        CleavePlugin::default(),
        WalkerPlugin,
    ))
    .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    let world = app.world_mut();
    build(world)?;
    let shape = ConvexMesh::capsule(0.3, 1.0)?;
    let start = Transform::from_xyz(0.0, 0.85, 0.0);
    let character = world
        .spawn((RigidBody::Kinematic, shape, start, Walker::default()))
        .id();
    let mut scene = Scene::default();
    let mut reached = 0;
    for step in 0..3600 {
        let Some((name, goal)) = COURSE.get(reached) else {
            break;
        };
        let world = app.world_mut();
        let at = world
            .get::<Transform>(character)
            .map_or(Vec3::ZERO, |t| t.translation);
        let feet = at.y - 0.8;
        let way = (*goal - at).with_y(0.0);
        // On the lift it waits until that is up.
        let is_riding = *name == "off the lift" && at.z < 7.5 && feet < goal.y - 0.25;
        if let Some(mut walker) = world.get_mut::<Walker>(character) {
            walker.velocity = if is_riding {
                Vec3::ZERO
            } else {
                SPEED * way.clamp_length_max(1.0)
            };
        }
        lift(world, step);
        app.update();
        if step % 30 == 0 {
            show(app.world(), character, palette(reached), &mut scene);
        }
        if way.length() < 0.3 && (feet - goal.y).abs() < 0.5 {
            println!("{:5.1} s: {name}, at {at:.2}", step as f32 / 60.0);
            reached += 1;
        }
    }
    println!("{reached} of {} reached", COURSE.len());
    draw(app.world_mut(), character, scene)
}

/// The lift goes up when the character has had time to get there, and down again.
#[derive(Component)]
struct Lift;

fn lift(world: &mut World, step: usize) {
    let speed = match step % 1200 {
        0..540 => 0.25,
        600..1140 => -0.25,
        _ => 0.0,
    };
    let mut lifts = world.query_filtered::<&mut LinearVelocity, With<Lift>>();
    for mut velocity in lifts.iter_mut(world) {
        velocity.0 = speed * Vec3::Y;
    }
}

fn build(world: &mut World) -> Result<(), Error> {
    world.spawn((RigidBody::Static, HalfSpaceShape::new(Vec3::Y)?));
    world.spawn((RigidBody::Static, ground()?));
    let mut place = |kind: RigidBody, size: Vec3, at: Vec3| -> Result<Entity, Error> {
        let mesh = ConvexMesh::cuboid(size.x, size.y, size.z)?;
        Ok(world
            .spawn((kind, mesh, Transform::from_translation(at)))
            .id())
    };
    let fixed = RigidBody::Static;
    // A wall that it runs into askew.
    place(fixed, Vec3::new(0.4, 2.0, 6.0), Vec3::new(16.0, 1.0, 3.0))?;
    // A floor above, from the lift to the end.
    place(fixed, Vec3::new(4.5, 0.3, 3.0), Vec3::new(2.25, 2.35, 9.5))?;
    place(fixed, Vec3::new(4.0, 0.3, 3.0), Vec3::new(11.5, 2.35, 10.0))?;
    let lift = place(
        RigidBody::Kinematic,
        Vec3::new(2.0, 0.2, 3.0),
        Vec3::new(1.0, 0.1, 6.45),
    )?;
    // Empty crates, which friction holds with less than what the character can push: it shoves them aside.
    for i in 0..4 {
        let size = Vec3::splat(0.5 + 0.1 * i as f32);
        let aside = [0.4, -0.4][i % 2];
        let at = Vec3::new(9.0 + i as f32, 0.5 * size.y, 6.0 + aside);
        let mesh = ConvexMesh::cuboid(size.x, size.y, size.z)?;
        let at = Transform::from_translation(at);
        world.spawn((RigidBody::Dynamic, mesh, at, Density(50.0)));
    }
    world.entity_mut(lift).insert(Lift);
    let disc = ConvexMesh::cylinder(2.4, 0.3)?;
    let turning = AngularVelocity(0.5 * Vec3::Y);
    let at = Transform::from_xyz(7.0, 2.35, 10.0);
    world.spawn((RigidBody::Kinematic, disc, at, turning));
    for i in 0..5 {
        let ball = ConvexMesh::sphere(0.15 + 0.05 * i as f32)?;
        let at = Transform::from_xyz(3.0 + i as f32, 0.5, 4.0);
        world.spawn((RigidBody::Dynamic, ball, at, Density(100.0)));
    }
    Ok(())
}

/// Places along x and heights of a ramp and stairs, m.
fn outline() -> Vec<(f32, f32)> {
    let mut outline = vec![(2.0, 0.0), (6.0, 2.0), (8.0, 2.0)];
    for step in 0..8 {
        let (x, y) = (8.0 + 0.4 * step as f32, 2.0 - 0.25 * (step + 1) as f32);
        outline.extend([(x, y), (x + 0.4, y)]);
    }
    outline
}

/// A ramp and stairs of triangles.
fn ground() -> Result<StaticMesh, Error> {
    let outline = outline();
    let positions: Vec<Vec3> = outline
        .iter()
        .flat_map(|&(x, y)| [-1.5, 1.5].map(|z| Vec3::new(x, y, z)))
        .collect();
    let strips = (0..outline.len() as u32 - 1).map(|i| 2 * i);
    let triangles: Vec<[u32; 3]> = strips
        .flat_map(|i| [[i, i + 1, i + 2], [i + 2, i + 1, i + 3]])
        .collect();
    Ok(StaticMesh::new(&positions, &triangles)?)
}

/// Adds the character as it stands to the picture.
fn show(world: &World, character: Entity, color: Vec3, scene: &mut Scene) {
    let parts = (
        world.get::<ConvexMesh>(character),
        world.get::<Transform>(character),
    );
    if let (Some(mesh), Some(at)) = parts {
        scene.draw(
            &mesh.render_mesh(),
            Pose::new(at.translation, at.rotation),
            color,
        );
    }
}

fn draw(world: &mut World, character: Entity, mut scene: Scene) -> Result<(), Error> {
    let gray = Vec3::splat(0.45);
    let mut bodies = world.query::<(Entity, &ConvexMesh, &Transform)>();
    for (entity, mesh, at) in bodies.iter(world) {
        if entity != character {
            scene.draw(
                &mesh.render_mesh(),
                Pose::new(at.translation, at.rotation),
                gray,
            );
        }
    }
    let outline = ground_mesh()?;
    scene.draw(&outline, Pose::new(Vec3::ZERO, Quat::IDENTITY), gray);
    let (eye, target) = (Vec3::new(7.0, 14.0, 24.0), Vec3::new(7.5, 0.5, 5.0));
    let camera = Camera::look_at(eye, target, Vec3::Y, 40.0, 1200, 700);
    let path = format!("{FOLDER}/course.png");
    scene.render(&camera).save(&path)?;
    println!("picture: {path}");
    Ok(())
}

/// The ramp and the stairs to be drawn: blocks below them.
fn ground_mesh() -> Result<TriMesh, Error> {
    let outline = outline();
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for pair in outline.windows(2).filter(|pair| pair[1].0 > pair[0].0) {
        let [(x, y), (u, v)] = [pair[0], pair[1]];
        let corners = [(x, 0.0), (x, y), (u, v), (u, 0.0)];
        let points = corners.map(|(x, y)| [-1.5, 1.5].map(|z| Vec3::new(x, y, z)));
        // The last step is the ground.
        if let Ok(block) = ConvexHull::from_points(&points.concat()) {
            let mesh = block.to_mesh();
            let first = positions.len() as u32;
            positions.extend_from_slice(mesh.positions());
            triangles.extend(mesh.triangles().iter().map(|t| t.map(|v| first + v)));
        }
    }
    Ok(TriMesh::new(positions, triangles)?)
}
