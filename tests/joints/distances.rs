//! Distances whose anchors meet: the direction from one to the other is undefined there, and turns at once.

use crate::common::scenes::awake;
use crate::scene::{Random, fixed, gap, heavy, point};
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Two bodies that a spring pulls through each other, or one through a place of the world.
struct Pulled {
    simulation: Simulation,
    slots: Vec<u32>,
    id: JointId,
    rest: f64,
    stiffness: f64,
}

impl Pulled {
    fn energy(&self) -> f64 {
        let kinetic = |&slot: &u32| self.simulation.bodies.kinetic_energy(slot);
        let stretch = gap(&self.simulation, self.id) - self.rest;
        let stored = 0.5 * self.stiffness * stretch * stretch;
        self.slots.iter().map(kinetic).sum::<f64>() + stored
    }
}

/// `offset`: by how much they miss each other, m; `lever`: how far the anchors are from the centers of mass, m.
fn pulled(random: &mut Random, hertz: f32, rest: f32, [offset, lever]: [f32; 2]) -> Pulled {
    let mut simulation = awake();
    simulation.gravity.0 = Vec3::ZERO;
    let is_to_world = random.range(0.0, 1.0) < 0.5;
    let masses = [random.range(0.5, 3.0), random.range(0.5, 3.0)];
    let turn = random.rotation();
    let mut slots = Vec::new();
    for (i, mass) in masses
        .into_iter()
        .enumerate()
        .skip(usize::from(is_to_world))
    {
        let at = turn * Vec3::new(i as f32, offset * i as f32, 0.0);
        let mut body = heavy(Vec3::new(0.5, 0.4, 0.3), at, mass);
        body.layers = CollisionLayers::NONE;
        slots.push(simulation.bodies.insert(body).expect("usable"));
    }
    let reduced = match is_to_world {
        true => masses[1],
        false => masses[0] * masses[1] / (masses[0] + masses[1]),
    };
    let omega = std::f32::consts::TAU * hertz;
    let stiffness = reduced * omega * omega;
    let spring = JointSpring::Coefficients {
        stiffness,
        damping: 0.0,
    };
    let anchors = [0; 2].map(|_| lever * random.vector(-1.0, 1.0));
    let joint = Joint::spring(rest, spring).with_anchors(anchors[0], anchors[1]);
    let b = *slots.last().expect("one at least");
    let a = (!is_to_world).then_some(slots[0]);
    let id = simulation.join(a, b, joint).expect("usable");
    Pulled {
        simulation,
        slots,
        id,
        rest: rest.into(),
        stiffness: stiffness.into(),
    }
}

/// The force of a spring with a length turns at once where its anchors meet, within a sub-step of which only the ends are seen: a few per
/// cent of the energy come or go there, and no more.
#[test]
fn springs_that_pull_bodies_through_each_other_do_not_blow_up() {
    let mut random = Random::new(3);
    for hertz in [0.5, 2.0, 10.0, 60.0, 1000.0] {
        for rest in [0.0, 0.05, 0.3] {
            let mut worst = 0.0_f64;
            for k in 0..24 {
                let offset = [0.0, 1e-4, 1e-2, 0.2][k % 4];
                let lever = [0.0, 0.2][k % 2];
                let mut pulled = pulled(&mut random, hertz, rest, [offset, lever]);
                let before = pulled.energy();
                let rate = [30.0, 60.0, 240.0][k % 3];
                for _ in 0..(10.0 * rate) as usize {
                    pulled.simulation.step(1.0 / rate);
                    worst = worst.max(pulled.energy() / before - 1.0);
                }
            }
            println!("{hertz} Hz, rest {rest} m: gains {worst:e} of its energy");
            assert!(worst < [1e-4, 0.05][usize::from(rest > 0.0)], "{worst}");
        }
    }
}

/// A body of 2 kg on a post: where it is joined and what for, and how its energy changes from the end of the first step on, J.
fn on_a_post(joint: Joint, at: Vec3, anchor: Vec3, steps: usize) -> (f64, [f64; 2]) {
    let mut simulation = awake();
    let post = simulation.bodies.insert(fixed(Vec3::ZERO)).expect("usable");
    let mut body = heavy(Vec3::new(0.5, 0.4, 0.3), at, 2.0);
    body.layers = CollisionLayers::NONE;
    body.linear_velocity = -4.0 * at;
    let slot = simulation.bodies.insert(body).expect("usable");
    let joint = joint.with_anchors(Vec3::ZERO, anchor);
    let id = simulation.join(Some(post), slot, joint).expect("usable");
    let energy = |simulation: &Simulation| {
        let height = point(simulation, slot, Vec3::ZERO).y;
        simulation.bodies.kinetic_energy(slot) + 2.0 * 9.81 * height
    };
    simulation.step(1.0 / 60.0);
    let before = energy(&simulation);
    let (mut largest, mut change) = (0.0_f64, [0.0_f64; 2]);
    for _ in 0..steps {
        simulation.step(1.0 / 60.0);
        largest = largest.max(gap(&simulation, id));
        let now = energy(&simulation) - before;
        change = [change[0].min(now), change[1].max(now)];
    }
    (largest, change)
}

#[test]
fn a_rod_or_a_rope_without_length_is_a_ball_joint() {
    let mut random = Random::new(4);
    for joint in [Joint::rod(0.0), Joint::rope(0.0)] {
        for _ in 0..6 {
            let at = random.vector(-0.3, 0.3);
            let (gap, [lost, gained]) = on_a_post(joint, at, -at, 300);
            assert!(gap < 1e-6, "{gap}");
            // Of up to 6 J: some 4 rad/s are followed by four sub-steps a step.
            assert!(lost > -2e-3 && gained < 1e-3, "{lost} {gained}");
        }
    }
}

#[test]
fn anchors_of_a_rope_pass_through_each_other() {
    let mut random = Random::new(5);
    for _ in 0..6 {
        let at = random.vector(-0.3, 0.3);
        // Slack: nothing but free fall.
        let (_, [lost, gained]) = on_a_post(Joint::rope(1.0), at, Vec3::ZERO, 10);
        assert!(lost > -1e-3 && gained < 1e-3, "{lost} {gained}");
        let (gap, [_, gained]) = on_a_post(Joint::rope(1.0), at, Vec3::ZERO, 300);
        assert!(gap < 1.0 + 1e-5 && gained < 1e-3, "{gap} {gained}");
    }
}
