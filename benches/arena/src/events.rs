//! `arena events`: what news of contacts cost, of bodies that touch: all are watched, or none.

use crate::Error;
use crate::cli::{self, Arguments};
use crate::engines::headless;
use crate::race::{H, race};
use bevy_app::{App, PostUpdate};
use bevy_cleave::prelude::*;
use bevy_cleave::step::ContactWatch;
use glam::Vec3;

/// From which step to which is timed.
const SPAN: [usize; 2] = [30, 230];

/// Columns of five crates.
fn crates(count: usize) -> impl Iterator<Item = Vec3> {
    let side = ((count / 5) as f32).sqrt().ceil() as usize;
    (0..count).map(move |i| {
        let (column, height) = (i / 5, (i % 5) as f32);
        let (x, z) = ((column % side) as f32, (column / side) as f32);
        Vec3::new(2.0 * x, height + 0.5, 2.0 * z)
    })
}

fn floor() -> HalfSpaceShape {
    HalfSpaceShape { normal: Vec3::Y }
}

fn plain(count: usize, is_watched: bool) -> Result<Simulation, Error> {
    let mut simulation = Simulation::default();
    simulation.config.sleep = SleepConfig::off();
    simulation.bodies.insert(BodyDesc::floor(floor()))?;
    let shape = ConvexMesh::cuboid(1.0, 1.0, 1.0)?;
    for at in crates(count) {
        let slot = simulation
            .bodies
            .insert(BodyDesc::dynamic(shape.clone(), at))?;
        let watch = ContactWatch {
            touches: is_watched,
            ..ContactWatch::default()
        };
        let Simulation {
            bodies, contacts, ..
        } = &mut simulation;
        contacts.events_mut().watch(bodies, slot, watch);
    }
    Ok(simulation)
}

fn plugin(count: usize, is_watched: bool) -> Result<App, Error> {
    let mut app = headless::app(H, 0);
    app.add_plugins(CleavePlugin::new(PostUpdate));
    app.insert_resource(SolverConfig {
        sleep: SleepConfig::off(),
        ..SolverConfig::default()
    });
    headless::start(&mut app);
    let world = app.world_mut();
    world.spawn((RigidBody::Static, floor()));
    let shape = ConvexMesh::cuboid(1.0, 1.0, 1.0)?;
    for at in crates(count) {
        let place = bevy_transform::components::Transform::from_translation(at);
        let mut body = world.spawn((RigidBody::Dynamic, shape.clone(), place));
        if is_watched {
            body.insert(CollisionEvents);
        }
    }
    Ok(app)
}

#[cfg(feature = "rapier")]
mod theirs {
    use super::{Error, H, Vec3, crates};
    use crate::race::World;
    use rapier3d::prelude::*;
    use std::sync::mpsc;

    /// With somebody who hears.
    pub(super) struct Heard {
        world: PhysicsWorld,
        heard: mpsc::Receiver<CollisionEvent>,
        handler: ChannelEventCollector,
    }

    impl World for Heard {
        fn step(&mut self) {
            self.world.step_with_events(&(), &self.handler);
            self.heard.try_iter().for_each(drop);
        }
    }

    pub(super) fn rapier(count: usize, is_watched: bool) -> Result<Heard, Error> {
        let mut world = PhysicsWorld::new();
        world.integration_parameters.dt = H;
        world.physics_pipeline.configure_thread_pool(1)?;
        let ground = world.insert_body(RigidBodyBuilder::fixed());
        let floor = ColliderBuilder::new(SharedShape::halfspace(Vec3::Y));
        world.insert_collider(floor, Some(ground));
        for at in crates(count) {
            let body = RigidBodyBuilder::dynamic().translation(at).can_sleep(false);
            let handle = world.insert_body(body);
            let events = match is_watched {
                true => ActiveEvents::COLLISION_EVENTS,
                false => ActiveEvents::empty(),
            };
            let collider = ColliderBuilder::cuboid(0.5, 0.5, 0.5).active_events(events);
            world.insert_collider(collider, Some(handle));
        }
        let (send, heard) = mpsc::channel();
        let ((forces, _), (tears, _)) = (mpsc::channel(), mpsc::channel());
        let handler = ChannelEventCollector::new(send, forces, tears);
        Ok(Heard {
            world,
            heard,
            handler,
        })
    }
}

/// Runs what the command line says.
pub(crate) fn run(mut words: Arguments) -> Result<(), Error> {
    let mut count = 10_000;
    while let Some(flag) = words.word() {
        match flag.as_str() {
            "--bodies" => count = words.value(&flag)?,
            _ => return Err(cli::unknown(&flag)),
        }
    }
    let tell = |name: &str, times: Vec<[f64; 2]>| {
        for [off, on] in times {
            println!(
                "| {name} | {off:.3} ms | {on:.3} ms | {:.2} % |",
                100.0 * (on / off - 1.0)
            );
        }
    };
    println!("| {count} crates | no news | news of all | cost |");
    println!("|---|---|---|---|");
    let (mut off, mut on) = (plain(count, false)?, plain(count, true)?);
    tell("ours, step", race([&mut off, &mut on], &[SPAN]));
    let (mut off, mut on) = (plugin(count, false)?, plugin(count, true)?);
    tell("ours, App::update", race([&mut off, &mut on], &[SPAN]));
    #[cfg(feature = "rapier")]
    {
        let (mut off, mut on) = (theirs::rapier(count, false)?, theirs::rapier(count, true)?);
        tell("Rapier", race([&mut off, &mut on], &[SPAN]));
    }
    Ok(())
}
