//! Events, sensors and forces: what is told of a heap, and what acts on it.

use crate::heaps::{ASIDE, H, beside, insert, plain, step};
use crate::pair::{Pair, Row};
use bevy_cleave::prelude::*;
use glam::Vec3;

fn drive_all(simulation: &mut Simulation, drive: BodyDrive) {
    for slot in 0..simulation.bodies.slots() as u32 {
        let taken = simulation.bodies.set_drive(slot, drive);
        taken.expect("usable");
    }
}

/// Asks for all news of all bodies, of loads that no contact bears.
pub(crate) fn watch_all(simulation: &mut Simulation) {
    let watch = ContactWatch {
        touches: true,
        force: f32::MAX,
    };
    let Simulation {
        bodies, contacts, ..
    } = simulation;
    for slot in 0..bodies.slots() as u32 {
        contacts.events_mut().watch(bodies, slot, watch);
    }
}

/// A box that senses, of so many meters.
fn sensor(size: f32, at: Vec3) -> BodyDesc {
    let shape = ConvexMesh::cuboid(size, size, size).expect("valid size");
    BodyDesc {
        kind: RigidBody::Static,
        is_sensor: true,
        ..BodyDesc::dynamic(shape, at)
    }
}

/// The heap, and the same with an explosion before each step.
fn under_fire(explosion: Explosion) -> Pair {
    let mut simulation = plain();
    let with = Box::new(move || {
        simulation.bodies.explode(explosion).expect("usable");
        simulation.step(H);
    });
    Pair::new(step(plain()), with)
}

pub(crate) fn rows() -> Vec<Row> {
    vec![
        Row::new("Events, sensors, forces", "news of all contacts", || {
            beside(watch_all)
        }),
        Row::new("Events, sensors, forces", "a sensor aside", || {
            beside(|s| {
                insert(s, sensor(1.0, ASIDE));
            })
        }),
        Row::new("Events, sensors, forces", "a sensor about all", || {
            beside(|s| {
                insert(s, sensor(40.0, Vec3::ZERO));
            })
        }),
        Row::new("Events, sensors, forces", "a force on one aside", || {
            beside(|s| {
                let body = bevy_cleave::cuboid!(0.3, 0.3, 0.3);
                let slot = insert(s, BodyDesc::dynamic(body, ASIDE + 0.15 * Vec3::Y));
                let drive = BodyDrive {
                    force: Vec3::X,
                    ..BodyDrive::default()
                };
                s.bodies.set_drive(slot, drive).expect("usable");
            })
        }),
        Row::new(
            "Events, sensors, forces",
            "an explosion aside in each step",
            || {
                under_fire(Explosion {
                    center: ASIDE,
                    radius: 5.0,
                    impulse: 1.0,
                })
            },
        ),
        Row::new(
            "Events, sensors, forces",
            "an explosion in each step that reaches all, of 1e-6 N s",
            || {
                under_fire(Explosion {
                    center: Vec3::new(3.0, 1.0, 3.0),
                    radius: 50.0,
                    impulse: 1e-6,
                })
            },
        ),
        Row::new("Events, sensors, forces", "damping on all", || {
            beside(|s| {
                let damped = BodyDrive {
                    linear_damping: 0.01,
                    ..BodyDrive::default()
                };
                drive_all(s, damped);
            })
        }),
    ]
}
