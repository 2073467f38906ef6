//! The same bits, however often and wherever.

use crate::common::scenes::awake_on_floor;
use crate::scene::{Chain, H, Random, chain, fixed_substeps, heavy};
use bevy_cleave::prelude::*;
use bevy_cleave::testing::simd::LaneWidth;
use glam::Vec3;

/// Chains that fall on a floor and on each other, with hinges and motors among them.
fn heap() -> Simulation {
    let mut simulation = awake_on_floor();
    let mut random = Random::new(5);
    for i in 0..6 {
        let mut last: Option<u32> = None;
        for k in 0..8 {
            let size = Vec3::new(0.5, 0.2, 0.2);
            let at = Vec3::new(
                0.55 * k as f32,
                0.5 + 0.4 * i as f32,
                random.range(-0.1, 0.1),
            );
            let slot = simulation
                .bodies
                .insert(heavy(size, at, 1.0))
                .expect("usable");
            if let Some(last) = last {
                let poses = [last, slot].map(|slot| simulation.bodies.pose(slot));
                let middle = 0.5 * (poses[0].position + poses[1].position);
                let joint = match k % 3 {
                    0 => Joint::ball(),
                    1 => Joint::hinge().with_angular_drive(JointDrive::velocity(1.0, 0.5)),
                    _ => Joint::cone_twist(0.4, 0.2),
                };
                let joint = joint.with_anchor(middle, Vec3::Z, poses);
                simulation.join(Some(last), slot, joint).expect("usable");
            }
            last = Some(slot);
        }
    }
    simulation
}

fn state(simulation: &Simulation) -> Vec<u32> {
    let bodies = &simulation.bodies;
    let of = |slot: u32| {
        let (pose, (v, omega)) = (bodies.pose(slot), bodies.velocity(slot));
        let numbers = [pose.position, v, omega].map(|v| v.to_array());
        let all = numbers.concat().into_iter().chain(pose.rotation.to_array());
        all.map(f32::to_bits).collect::<Vec<_>>()
    };
    bodies.iter().flat_map(of).collect()
}

#[test]
fn a_heap_of_chains_ends_the_same_twice() {
    let run = || {
        let mut simulation = heap();
        for _ in 0..120 {
            simulation.step(H);
        }
        simulation
    };
    let [first, second] = [run(), run()];
    assert_eq!(state(&first), state(&second));
    for id in first.joints.iter() {
        let error = first.joints.load(id).expect("there").error;
        assert!(error[0] < 1e-4 && error[1] < 1e-3, "{error:?}");
    }
    let lowest = first
        .bodies
        .iter()
        .skip(1)
        .map(|slot| first.bodies.center_of_mass(slot).y);
    assert!(lowest.fold(f32::INFINITY, f32::min) > 0.05);
}

/// Loops over bodies and rows give the same bits with the registers of any processor.
#[test]
fn a_heap_of_chains_ends_the_same_with_any_lanes() {
    let run = |width: LaneWidth| {
        let mut simulation = heap();
        simulation.overrides.lane_width = width;
        for _ in 0..120 {
            simulation.step(H);
        }
        state(&simulation)
    };
    let widest = run(LaneWidth::Widest);
    for width in [LaneWidth::Four, LaneWidth::One] {
        assert_eq!(run(width), widest, "{width:?}");
    }
}

#[test]
fn slots_that_were_used_before_change_nothing() {
    let mut fresh = chain(10, 10.0, Vec3::X, Vec3::ZERO);
    let mut used = chain(10, 10.0, Vec3::X, Vec3::ZERO);
    let Simulation { joints, bodies, .. } = &mut used.simulation;
    let extra = bodies
        .insert(heavy(Vec3::ONE, Vec3::new(0.0, 50.0, 0.0), 1.0))
        .expect("usable");
    let id = joints
        .insert(bodies, None, extra, Joint::ball())
        .expect("usable");
    assert!(joints.remove(bodies, id));
    bodies.remove(extra);
    for _ in 0..60 {
        fresh.simulation.step(H);
        used.simulation.step(H);
    }
    assert_eq!(state(&fresh.simulation), state(&used.simulation));
}

/// What a step does is told by the state alone, and not by what the solver still has of the step before: a joint that holds nothing, comes and goes,
/// has all rows written anew.
#[test]
fn what_was_solved_before_changes_no_bit() {
    for (count, ratio) in [(1, 1.0), (2, 100.0), (4, 1000.0)] {
        let run = |is_disturbed: bool| {
            let Chain {
                mut simulation,
                joints,
            } = chain(12, ratio, Vec3::X, Vec3::ZERO);
            simulation.config = SolverConfig {
                sleep: simulation.config.sleep,
                ..fixed_substeps(count)
            };
            let ball = *simulation.joints.get(joints[6]).expect("there");
            let with_angles = Joint {
                angular: Joint::cone_twist(1.0, 0.2).angular,
                ..ball
            };
            let bodies = &mut simulation.bodies;
            let set = simulation.joints.set(bodies, joints[6], with_angles);
            set.expect("usable");
            let [a, b] = simulation.joints.bodies(joints[5]).expect("there");
            let free = Joint::six_axis([JointAxis::FREE; 3], [JointAxis::FREE; 3]);
            for _ in 0..60 {
                let extra = is_disturbed.then(|| simulation.join(a, b.expect("a link"), free));
                simulation.step(H);
                if let Some(extra) = extra {
                    let extra = extra.expect("usable");
                    simulation.joints.remove(&mut simulation.bodies, extra);
                }
                simulation.step(H);
            }
            state(&simulation)
        };
        assert_eq!(run(false), run(true), "{count} sub-steps, load {ratio}");
    }
}
