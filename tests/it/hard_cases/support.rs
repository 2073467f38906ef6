//! What the hard cases share: running a scene, and what is measured of it.
#![allow(dead_code, reason = "each family of cases uses some of them")]

use bevy_cleave::prelude::*;
use glam::{DVec3, Vec3};

/// Length of a step unless a case says otherwise, s.
pub(crate) const H: f32 = 1.0 / 60.0;

/// Standard gravity as the cases use it, m/s2.
pub(crate) const G: f64 = 9.81;

/// A simulation of `bodies` with the default solver; slots are the places in the list.
pub(crate) fn simulation(bodies: impl IntoIterator<Item = BodyDesc>) -> Simulation {
    simulation_with(SolverConfig::default(), bodies)
}

/// A simulation of `bodies` in which nothing falls asleep, for that proves nothing; slots are the places in the list.
pub(crate) fn simulation_with(
    config: SolverConfig,
    bodies: impl IntoIterator<Item = BodyDesc>,
) -> Simulation {
    let mut simulation = Simulation {
        config: SolverConfig {
            sleep: SleepConfig::off(),
            ..config
        },
        ..Default::default()
    };
    for desc in bodies {
        simulation.bodies.insert(desc).expect("usable body");
    }
    simulation
}

/// The same without gravity.
pub(crate) fn weightless(bodies: impl IntoIterator<Item = BodyDesc>) -> Simulation {
    Simulation {
        gravity: Gravity(Vec3::ZERO),
        ..simulation(bodies)
    }
}

/// Number of steps of [`H`] in `seconds`.
pub(crate) fn steps(seconds: f64) -> usize {
    (seconds / f64::from(H)).round() as usize
}

/// Steps of [`H`] for `seconds`.
pub(crate) fn run(simulation: &mut Simulation, seconds: f64) {
    for _ in 0..steps(seconds) {
        simulation.step(H);
    }
}

/// Slots of the dynamic bodies.
pub(crate) fn movable(simulation: &Simulation) -> Vec<u32> {
    let bodies = &simulation.bodies;
    let dynamic = bodies
        .iter()
        .filter(|&s| bodies.kind(s) == RigidBody::Dynamic);
    dynamic.collect()
}

/// Where all bodies are, to measure displacements from later. Taken before the first step it is the scene as built.
pub(crate) fn frames(simulation: &Simulation) -> Vec<Pose> {
    let bodies = &simulation.bodies;
    bodies.iter().map(|slot| bodies.pose(slot)).collect()
}

/// Largest distance that the frame of a body has moved from `start` (of [`frames`]), m.
pub(crate) fn displacement(simulation: &Simulation, start: &[Pose]) -> f32 {
    let moved = frames(simulation)
        .into_iter()
        .zip(start)
        .map(|(now, then)| now.position.distance(then.position));
    moved.fold(0.0, f32::max)
}

/// The same along the horizontal only, m.
pub(crate) fn drift(simulation: &Simulation, start: &[Pose]) -> f32 {
    let moved = frames(simulation)
        .into_iter()
        .zip(start)
        .map(|(now, then)| ((now.position - then.position) * Vec3::new(1.0, 0.0, 1.0)).length());
    moved.fold(0.0, f32::max)
}

/// Deepest overlap of two bodies when contacts were last found, m.
pub(crate) fn penetration(simulation: &Simulation) -> f32 {
    let manifolds = simulation.contacts.manifolds().iter();
    let depths = manifolds.flat_map(|m| m.points()).map(|p| -p.separation);
    depths.fold(0.0, f32::max)
}

/// Sum of the normal impulses between two slots in the last step, N s.
pub(crate) fn normal_impulse(simulation: &Simulation, one: u32, other: u32) -> f32 {
    let manifolds = simulation.contacts.manifolds().iter();
    let between = manifolds.filter(|m| [m.a, m.b] == [one, other] || [m.b, m.a] == [one, other]);
    between
        .flat_map(|m| m.points())
        .map(|p| p.normal_impulse)
        .sum()
}

/// Kinetic energy of all dynamic bodies, J.
pub(crate) fn kinetic_energy(simulation: &Simulation) -> f64 {
    let energy = |slot: u32| simulation.bodies.kinetic_energy(slot);
    movable(simulation).into_iter().map(energy).sum()
}

/// Kinetic and potential energy (zero at the origin) of all dynamic bodies, J.
pub(crate) fn energy(simulation: &Simulation) -> f64 {
    let bodies = &simulation.bodies;
    let potential = |slot: u32| {
        let weight = f64::from(bodies.mass(slot).mass) * simulation.gravity.0.as_dvec3();
        -weight.dot(bodies.center_of_mass(slot).as_dvec3())
    };
    kinetic_energy(simulation) + movable(simulation).into_iter().map(potential).sum::<f64>()
}

/// Momentum of one body, kg m/s.
pub(crate) fn momentum(simulation: &Simulation, slot: u32) -> DVec3 {
    let bodies = &simulation.bodies;
    f64::from(bodies.mass(slot).mass) * bodies.velocity(slot).0.as_dvec3()
}

/// Angular momentum of one body about its center of mass, world axes, kg m2/s.
pub(crate) fn spin(simulation: &Simulation, slot: u32) -> DVec3 {
    let bodies = &simulation.bodies;
    let mass = bodies.mass(slot);
    let frame =
        (bodies.pose(slot).rotation.as_dquat() * mass.principal_frame.as_dquat()).normalize();
    let omega = bodies.velocity(slot).1.as_dvec3();
    frame * (mass.principal.as_dvec3() * (frame.inverse() * omega))
}

/// Angular momentum of one body about the world's origin, kg m2/s.
pub(crate) fn angular_momentum(simulation: &Simulation, slot: u32) -> DVec3 {
    let center = simulation.bodies.center_of_mass(slot).as_dvec3();
    spin(simulation, slot) + center.cross(momentum(simulation, slot))
}

/// Distance that a body slides until friction stops it, by semi-implicit Euler with steps of `h` seconds:
/// `h sum(v0 - k a h)` over the steps in which it still moves.
pub(crate) fn discrete_stop(speed: f64, deceleration: f64, h: f64) -> f64 {
    let (mut v, mut x) = (speed - deceleration * h, 0.0);
    while v > 0.0 {
        x += v * h;
        v -= deceleration * h;
    }
    x
}

/// Length of a sub-step of the default settings in steps of `h`, s, where nothing asks for more of them.
pub(crate) fn substep(h: f32) -> f64 {
    f64::from(h) / f64::from(SoftStep::default().min_substeps)
}

/// The value between `falls` and `stands` at which a structure begins to stand, to a sixteenth of the way between them; both ends
/// must do as they are called.
pub(crate) fn threshold(falls: f64, stands: f64, does_stand: impl Fn(f64) -> bool) -> f64 {
    assert!(does_stand(stands), "falls at {stands}");
    assert!(!does_stand(falls), "stands at {falls}");
    let (mut low, mut high) = (falls, stands);
    for _ in 0..3 {
        let middle = 0.5 * (low + high);
        if does_stand(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    0.5 * (low + high)
}
