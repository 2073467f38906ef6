//! The scene that sleeps and wakes: structures far apart from each other, each with a way of its own to be woken.

use crate::course::Events;
use crate::heaps::heap;
use crate::structures::{block, cuboid, fixed, floor, tower};
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Steps in all.
pub(crate) const STEPS: u32 = 420;

/// Step in which the ball comes down on the tower, more or less: it falls 36 m.
const BALL_FROM: f32 = 42.0;

/// First of the steps in which something is done.
const ACTS_FROM: u32 = 200;

/// Indices of bodies in [`bodies`].
const SLAB: usize = 1;
const STACK: usize = 2;
const PUSHED: usize = 5;
const CUT: usize = 8;
const CARRIER: usize = 10;
const SETTLED: usize = 12;

/// A floor; a slab with a stack on it; a stack that is pushed; a long box that is cut under another; a box on a fixed
/// carrier that moves on; one that is told to settle; a tower under a ball that falls from far above; a heap.
pub(crate) fn bodies() -> Vec<BodyDesc> {
    let cube = cuboid(Vec3::ONE);
    let mut bodies = vec![floor(0.6)];
    bodies.push(fixed(
        &cuboid(Vec3::new(3.0, 0.5, 3.0)),
        Vec3::new(0.0, 0.25, 0.0),
        0.6,
    ));
    for i in 0..3_u8 {
        bodies.push(block(&cube, Vec3::new(0.0, 1.0 + f32::from(i), 0.0), 0.6));
    }
    for i in 0..3_u8 {
        let at = Vec3::new(10.0 + 0.1 * f32::from(i), 0.5 + f32::from(i), 0.0);
        bodies.push(block(&cube, at, 0.6));
    }
    let beam = cuboid(Vec3::new(4.0, 0.5, 1.0));
    bodies.push(block(&beam, Vec3::new(20.0, 0.25, 0.0), 0.6));
    bodies.push(block(&cube, Vec3::new(20.3, 1.0, 0.0), 0.6));
    let mut carrier = fixed(
        &cuboid(Vec3::new(3.0, 0.5, 3.0)),
        Vec3::new(30.0, 0.25, 0.0),
        0.6,
    );
    carrier.kind = RigidBody::Kinematic;
    bodies.push(carrier);
    bodies.push(block(&cube, Vec3::new(30.0, 1.0, 0.0), 0.6));
    bodies.push(block(&cube, Vec3::new(40.0, 0.5, 0.0), 0.6));
    let moved = |mut desc: BodyDesc, by: Vec3| {
        desc.pose.position += by;
        desc
    };
    let towers = [50.0, 60.0].map(|x| tower(6).into_iter().skip(1).map(move |d| (d, x)));
    bodies.extend(
        towers
            .into_iter()
            .flatten()
            .map(|(d, x)| moved(d, x * Vec3::X)),
    );
    let ball = ConvexMesh::icosphere(0.4, 1).expect("valid size");
    bodies.push(block(&ball, Vec3::new(50.2, BALL_FROM, 0.1), 0.4));
    let heap = heap(20).into_iter().skip(1);
    bodies.extend(heap.map(|desc| moved(desc, 20.0 * Vec3::Z)));
    bodies
}

/// What is done before step number `step`.
pub(crate) fn act(step: u32, simulation: &mut Simulation, slots: &[u32]) {
    let Simulation {
        bodies, fractures, ..
    } = simulation;
    match step {
        2 => bodies.request_sleep(slots[SETTLED]),
        ACTS_FROM => {
            assert!(bodies.is_asleep(slots[STACK]), "it sleeps on the slab");
            bodies.remove(slots[SLAB]);
        }
        210 => {
            assert!(bodies.is_asleep(slots[PUSHED]), "it sleeps");
            let push = (0.5 * Vec3::X, Vec3::ZERO);
            let outcome = bodies.set_velocity(slots[PUSHED], push.0, push.1);
            outcome.expect("usable");
        }
        220 => {
            assert!(bodies.is_asleep(slots[CUT]), "it sleeps");
            let plane = Plane::through(19.8 * Vec3::X, Vec3::new(1.0, 0.1, 0.2).normalize());
            let request = CutRequest::in_world(bodies, slots[CUT], plane);
            fractures.requests.push(request.expect("there is a body"));
        }
        230 => {
            assert!(bodies.is_asleep(slots[CARRIER + 1]), "it sleeps");
            let outcome = bodies.set_velocity(slots[CARRIER], 0.5 * Vec3::Z, Vec3::ZERO);
            outcome.expect("usable");
        }
        240 => bodies.wake(slots[SETTLED]),
        _ => {}
    }
}

/// Panics unless bodies slept, woke, slept again and were removed.
pub(crate) fn check(events: &Events) {
    let is = |what: &str, holds: bool| assert!(holds, "{what}: {events:?}");
    is("many fall asleep", events.slept >= 50);
    is("many wake", events.woken >= 15);
    is("by being touched too", events.jolt > 10.0);
    is("many sleep at the end", events.asleep >= 25);
    is("again", events.slept > events.asleep + 10);
    is("one is cut", events.fractures == 1);
    is("its pieces are removed", events.expired == 2);
}
