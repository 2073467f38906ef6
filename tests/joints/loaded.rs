//! Jointed structures under loads, with every effort of the solver: few sub-steps may open joints, but nothing flies apart.

use crate::common::dice::Dice;
use crate::common::ragdoll::add_ragdoll;
use crate::common::scenes::awake;
use crate::scene::{Bridge, fixed_substeps, heavy, largest_gap};
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Efforts, from the least: sub-steps, or what the presets have.
fn efforts() -> [(&'static str, SolverConfig); 6] {
    [
        ("1 sub-step", fixed_substeps(1)),
        ("2 sub-steps", fixed_substeps(2)),
        ("fast", SolverConfig::fast()),
        ("8 sub-steps", fixed_substeps(8)),
        ("default", SolverConfig::default()),
        ("paper", SolverConfig::paper()),
    ]
}

fn simulation_with(config: &SolverConfig) -> Simulation {
    let mut simulation = awake();
    let sleep = simulation.config.sleep;
    simulation.config = SolverConfig { sleep, ..*config };
    simulation
}

/// Kinetic energy, over all that there is, that is still no explosion.
const MOST_ENERGY: f64 = 1.05;

/// A hanging bridge, or with one end a rope, and what falls on it.
#[derive(Clone, Copy, Debug)]
struct LoadedBridge {
    bridge: Bridge,
    loads: u8,
    /// Mass of a load over that of a plank.
    ratio: f32,
    /// From which loads fall, m.
    height: f32,
}

impl LoadedBridge {
    fn random(dice: &mut Dice) -> Self {
        let length = dice.in_range(0.1, 1.0);
        let root_of_ratio = dice.in_range(1.0, 10.0);
        let mut bridge = Bridge {
            planks: 4 + dice.below(60) as u8,
            plank: Vec3::new(
                length,
                length * dice.in_range(0.05, 0.3),
                dice.in_range(1.0, 4.0),
            ),
            mass: dice.in_range(1.0, 60.0),
            height: 0.0,
            sag: 0.0,
            per_seam: 1,
            has_far_end: true,
        };
        bridge.sag = 2.0 * bridge.half() * dice.in_range(0.005, 0.2);
        bridge.per_seam += dice.below(2) as u8;
        bridge.has_far_end = dice.below(4) > 0;
        Self {
            bridge,
            loads: 1 + dice.below(4) as u8,
            ratio: root_of_ratio * root_of_ratio,
            height: dice.in_range(0.0, 2.0),
        }
    }

    /// Puts it up, and its loads above it; its joints.
    fn add(&self, simulation: &mut Simulation) -> Vec<JointId> {
        let Bridge {
            planks,
            plank,
            mass,
            ..
        } = self.bridge;
        let ids = self.bridge.add(simulation);
        let spacing = f32::from(planks) * plank.x / f32::from(self.loads);
        let edge = (0.6 * plank.z).min(0.7 * spacing);
        for k in 0..self.loads {
            let share = (f32::from(k) + 0.5) / f32::from(self.loads);
            let under = self.bridge.seam((share * f32::from(planks)) as u8);
            // Clear of planks that rise to the ends.
            let up = edge + plank.y + self.height;
            let load = heavy(
                Vec3::splat(edge),
                Vec3::new(under.x, under.y.max(-edge) + up, 0.0),
                self.ratio * mass,
            );
            simulation.bodies.insert(load).expect("usable");
        }
        ids
    }
}

/// What came of a scene.
#[derive(Debug, Default)]
struct Outcome {
    /// m
    gap: f64,
    /// Most kinetic energy over what falls by the height that bodies fell until then, and by half a meter, give.
    gain: f64,
}

/// Steps a scene of passive bodies for some seconds.
fn watch(simulation: &mut Simulation, ids: &[JointId], h: f32, seconds: f32) -> Outcome {
    let mut outcome = Outcome::default();
    let dynamic: Vec<u32> = {
        let bodies = &simulation.bodies;
        let slots = bodies.iter();
        slots
            .filter(|&slot| bodies.kind(slot) == RigidBody::Dynamic)
            .collect()
    };
    let sums = |simulation: &Simulation| {
        let bodies = &simulation.bodies;
        dynamic.iter().fold([0.0_f64; 3], |sums, &slot| {
            let weight = 9.81 * f64::from(bodies.mass(slot).mass);
            let height = f64::from(bodies.center_of_mass(slot).y);
            [
                sums[0] + bodies.kinetic_energy(slot),
                sums[1] + weight * height,
                sums[2] + weight,
            ]
        })
    };
    // Masses are known after the first step.
    simulation.step(h);
    let start = sums(simulation);
    for _ in 0..(seconds / h) as usize {
        simulation.step(h);
        let now = sums(simulation);
        let fallen = (start[1] - now[1]).max(0.0);
        let gain = now[0] / (start[0] + fallen + 0.5 * now[2]);
        outcome.gain = outcome
            .gain
            .max(if gain.is_nan() { f64::INFINITY } else { gain });
        outcome.gap = outcome.gap.max(largest_gap(simulation, ids));
    }
    outcome
}

#[test]
fn loaded_bridges_and_ropes_do_not_fly_apart_with_any_effort() {
    let mut dice = Dice::new(31);
    let mut worst = [(0.0_f64, 0.0_f64, 0); 6];
    for _ in 0..14 {
        let loaded = LoadedBridge::random(&mut dice);
        let rate = [30.0, 60.0, 120.0][dice.below(3)];
        for ((_, config), worst) in efforts().iter().zip(&mut worst) {
            let mut simulation = simulation_with(config);
            let ids = loaded.add(&mut simulation);
            let outcome = watch(&mut simulation, &ids, 1.0 / rate, 2.0);
            let size = f64::from(loaded.bridge.plank.x);
            *worst = (
                worst.0.max(outcome.gap / size),
                worst.1.max(outcome.gain),
                worst.2 + i32::from(outcome.gap > 1e-3 * size),
            );
        }
    }
    for ((name, _), (gap, gain, open)) in efforts().iter().zip(worst) {
        println!(
            "{name}: gaps of up to {gap:.1e} planks, open by 1e-3 in {open} of 14, energy {gain:.2}"
        );
        assert!(gain < MOST_ENERGY, "{name}: {gain}");
    }
    let (gap, gain, _) = worst[4];
    assert!(gap < 1e-4 && gain < 1.0, "default: {gap}, {gain}");
}

#[test]
fn heaps_of_ragdolls_do_not_fly_apart_with_any_effort() {
    for (name, config) in efforts() {
        for rate in [30.0, 60.0] {
            let mut simulation = simulation_with(&config);
            let floor = HalfSpaceShape { normal: Vec3::Y };
            simulation
                .bodies
                .insert(BodyDesc::floor(floor))
                .expect("usable");
            let mut dice = Dice::new(8);
            let mut ids = Vec::new();
            for k in 0..6_u8 {
                let feet = Vec3::new(
                    dice.in_range(-0.3, 0.3),
                    0.2 + 1.0 * f32::from(k),
                    dice.in_range(-0.3, 0.3),
                );
                ids.extend(add_ragdoll(&mut simulation, feet, dice.rotation()));
            }
            let outcome = watch(&mut simulation, &ids, 1.0 / rate, 3.0);
            println!("{name} {rate} Hz: {outcome:?}");
            assert!(outcome.gain < 1.0, "{name} {rate}: {outcome:?}");
        }
    }
}
