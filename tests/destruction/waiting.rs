//! What waits for its turn, whatever becomes of it in the meantime; and debris that goes.

use crate::common::dice::Dice;
use crate::kit::*;
use bevy_cleave::prelude::*;
use glam::Vec3;
use std::collections::{HashMap, HashSet};

/// A few bodies that break, in a row on a floor, with sleep or without.
fn row(dice: &mut Dice) -> Simulation {
    let mut simulation = awake_on_floor();
    simulation.config.sleep.enabled = dice.below(2) == 0;
    let count = 2 + dice.below(2);
    for i in 0..count {
        let at = Vec3::new(1.4 * i as f32, 1.0, 0.0);
        let mut desc = match dice.below(4) {
            0 => BodyDesc::dynamic(convex(dice, 1.0), at),
            1 => BodyDesc::dynamic(with_visual(dice, 1.0), at),
            2 => BodyDesc::compound(compound(dice, 0.6), at),
            _ => {
                let strength = 10.0_f32.powf(dice.in_range(2.5, 4.5));
                BodyDesc::compound(cluster(dice, 1.0, strength), at)
            }
        };
        if !matches!(&desc.shape, Shape::Compound(it) if it.is_bonded()) {
            let strength = dice.in_range(1.0, 30.0);
            desc.fracturable = Some(breakable(dice, strength));
        }
        if dice.below(4) == 0 {
            desc.kind = RigidBody::Static;
        }
        simulation.bodies.insert(desc).expect("usable");
    }
    simulation
}

pub(crate) fn judge(seed: u64) -> Verdict {
    let dice = &mut Dice::new(seed);
    let mut simulation = row(dice);
    simulation.step(1e-6);
    simulation.budget.pieces_per_step = [0, 1, 2, 3, 5][dice.below(5)];
    simulation.budget.triangles_per_step = [0, 50, 500, 10_000][dice.below(4)];
    let (mut broken, mut waited) = (0, 0);
    let mut balance = mass(&simulation.bodies);
    let all = balance;
    for number in 0..40 {
        let solid: Vec<u32> = simulation
            .bodies
            .iter()
            .filter(|&s| is_solid(&simulation.bodies, s))
            .collect();
        if dice.below(3) == 0 && !solid.is_empty() && number < 32 {
            let slot = solid[dice.below(solid.len())];
            let at = simulation.bodies.center_of_mass(slot);
            let bodies = &mut simulation.bodies;
            match dice.below(9) {
                0 => {
                    balance -= f64::from(bodies.mass(slot).mass);
                    bodies.remove(slot);
                }
                1 => {
                    let pose = Pose::new(dice.vector(0.0, 8.0), dice.rotation());
                    bodies.set_pose(slot, pose).expect("usable");
                }
                2 => bodies.set_fracturable(slot, None),
                3 => {
                    let _ = bodies.set_kind(
                        slot,
                        [RigidBody::Static, RigidBody::Dynamic, RigidBody::Kinematic]
                            [dice.below(3)],
                    );
                }
                4 => {
                    // Another one in its place, in the same slot.
                    balance -= f64::from(bodies.mass(slot).mass);
                    bodies.remove(slot);
                    let shape = cluster(dice, 1.0, 1e4);
                    let anew = bodies
                        .insert(BodyDesc::compound(shape, at))
                        .expect("usable");
                    simulation.fractures.requests.clear();
                    let volume = simulation.bodies.compound(anew).expect("it").clone();
                    let sum = bevy_cleave::mass::VolumeIntegrals::of_compound(&volume).volume;
                    balance += sum * f64::from(simulation.bodies.density(anew));
                }
                5 => {
                    let plane = Plane::through(at, dice.direction());
                    simulation.slice(slot, plane).expect("a body");
                }
                _ => {
                    let explosion = Explosion {
                        center: at + 0.7 * dice.direction(),
                        radius: 3.0,
                        impulse: 10.0_f32.powf(dice.in_range(1.5, 3.5)),
                    };
                    bodies.explode(explosion).expect("usable");
                }
            }
        }
        simulation.step(H);
        balance -= check_ledgers(&simulation)?;
        broken += simulation.fractures.done.len();
        waited = waited.max(simulation.fractures.waiting());
        for slot in simulation.bodies.iter() {
            check_mass_of_parts(&simulation.bodies, slot)
                .map_err(|e| format!("step {number}: {e}"))?;
        }
        let left = mass(&simulation.bodies);
        ask!(
            (left - balance).abs() < 4e-6 * all.max(balance),
            "step {number}: {left} kg of {balance} kg"
        );
    }
    simulation.budget = FractureBudget {
        growth: f32::INFINITY,
        pieces_per_step: 1000,
        ..Default::default()
    };
    for _ in 0..60 {
        simulation.step(H);
        broken += simulation.fractures.done.len();
        // Something may always have just begun to.
        if simulation.fractures.waiting() == 0 {
            check_connected(&simulation)?;
            return Ok(broken);
        }
    }
    Err(format!(
        "{} of {waited} wait for ever",
        simulation.fractures.waiting()
    ))
}

/// Bonds left of a cluster after those of two blasts that `acts` names, where none may break anything at once; and how many were told to wait.
fn left_after(seed: u64, acts: [bool; 2]) -> (usize, usize) {
    let dice = &mut Dice::new(seed);
    let mut simulation = in_space();
    let kind = [RigidBody::Dynamic, RigidBody::Static][dice.below(2)];
    let strength = 10.0_f32.powf(dice.in_range(2.5, 5.5));
    let shape = cluster(dice, 1.5, strength);
    let mut desc = BodyDesc::compound(shape.clone(), Vec3::ZERO);
    desc.kind = kind;
    desc.layers = CollisionLayers::NONE;
    let slot = simulation.bodies.insert(desc).expect("usable");
    hold_foot(&mut simulation, slot, &shape);
    simulation.step(1e-6);
    simulation.budget.pieces_per_step = 0;
    let mut waited = 0;
    for is_on in acts {
        let explosion = Explosion {
            center: 1.2 * dice.direction(),
            radius: 3.0,
            impulse: 10.0_f32.powf(dice.in_range(1.5, 3.5)),
        };
        if is_on {
            simulation.bodies.explode(explosion).expect("usable");
        }
        // So short that nothing gets anywhere.
        simulation.step(1e-7);
        waited += simulation.fractures.waiting();
    }
    simulation.budget.pieces_per_step = usize::MAX;
    for _ in 0..10 {
        simulation.step(1e-7);
    }
    let compounds = simulation
        .bodies
        .iter()
        .filter_map(|slot| simulation.bodies.compound(slot));
    (compounds.map(|shape| shape.bonds().len()).sum(), waited)
}

/// What blasts break while a cluster waits for its turn, breaks too.
pub(crate) fn judge_in_the_end(seed: u64) -> Verdict {
    let [first, second, both] =
        [[true, false], [false, true], [true, true]].map(|acts| left_after(seed, acts));
    if first.1 == 0 {
        // It cracked, at most, and is another one since.
        return Ok(0);
    }
    let least = first.0.min(second.0);
    ask!(
        both.0 <= least,
        "{} bonds left by two blasts, {} and {} by one of them",
        both.0,
        first.0,
        second.0
    );
    Ok(both.1)
}

pub(crate) fn judge_debris(seed: u64) -> Verdict {
    let dice = &mut Dice::new(seed);
    let mut simulation = row(dice);
    for i in 0..3 {
        let at = Vec3::new(i as f32, 3.0, 1.0);
        let plain = BodyDesc::dynamic(cuboid(Vec3::splat(0.3)), at);
        simulation.bodies.insert(plain).expect("usable");
    }
    let rules = DebrisRules {
        max_pieces: [usize::MAX, 0, 3, 10][dice.below(4)],
        max_age: [f32::INFINITY, 0.2, 1.0][dice.below(3)],
        max_sleep: [f32::INFINITY, 0.3][dice.below(2)],
        dust_volume: [0.0, 0.01][dice.below(2)],
        max_volume: [f32::INFINITY, 0.1][dice.below(2)],
        fade: [0.0, 0.3][dice.below(2)],
    };
    simulation.budget.debris = rules;
    simulation.step(1e-6);
    let wholes: HashSet<BodyId> = simulation
        .bodies
        .iter()
        .map(|s| simulation.bodies.id(s))
        .collect();
    let mut pieces: HashSet<BodyId> = HashSet::new();
    let mut balance = mass(&simulation.bodies);
    let all = balance;
    let mut gone = 0.0_f64;
    for number in 0..120 {
        if dice.below(12) == 0 && number < 80 {
            let explosion = Explosion {
                center: dice.vector(0.0, 5.0).with_z(0.5),
                radius: 3.0,
                impulse: 10.0_f32.powf(dice.in_range(1.5, 3.0)),
            };
            simulation.bodies.explode(explosion).expect("usable");
        }
        if dice.below(12) == 0 {
            let solid: Vec<u32> = simulation
                .bodies
                .iter()
                .filter(|&s| is_solid(&simulation.bodies, s))
                .collect();
            if !solid.is_empty() {
                let slot = solid[dice.below(solid.len())];
                let at = simulation.bodies.center_of_mass(slot);
                simulation
                    .slice(slot, Plane::through(at, dice.direction()))
                    .expect("a body");
            }
        }
        let bodies = &simulation.bodies;
        let before: HashMap<BodyId, (f32, RigidBody, f64)> = bodies
            .iter()
            .filter(|&s| is_solid(bodies, s))
            .map(|s| {
                let volume = hulls(bodies, s)
                    .iter()
                    .map(|(_, shape)| shape.hull().volume())
                    .sum();
                (bodies.id(s), (bodies.mass(s).mass, bodies.kind(s), volume))
            })
            .collect();
        simulation.step(H);
        let mut made = 0.0;
        for fracture in &simulation.fractures.done {
            pieces.extend(&fracture.ids);
            made += fracture.ledger.dropped.mass;
        }
        balance -= made;
        for piece in &simulation.fractures.expired {
            let Some(&(mass, kind, volume)) = before.get(&piece.body) else {
                return Err(format!("step {number}: what went was not there"));
            };
            ask!(
                pieces.contains(&piece.body) && !wholes.contains(&piece.body),
                "step {number}: a whole body went"
            );
            ask!(
                kind == RigidBody::Dynamic,
                "step {number}: what stands went"
            );
            ask!(
                volume <= f64::from(rules.max_volume) * 1.0001,
                "step {number}: a large piece went"
            );
            ask!(
                mass == piece.mass,
                "step {number}: {} kg instead of {mass}",
                piece.mass
            );
            gone += f64::from(mass);
            balance -= f64::from(mass);
        }
        ask!(
            (gone - simulation.fractures.removed.mass).abs() <= 1e-9 * gone,
            "step {number}: removed {gone} kg"
        );
        let left = mass(&simulation.bodies);
        ask!(
            (left - balance).abs() < 4e-6 * all.max(balance),
            "step {number}: {left} kg of {balance} kg"
        );
        let bodies = &simulation.bodies;
        for fading in &simulation.fractures.fading {
            ask!(
                bodies.is_current(fading.slot, fading.body),
                "step {number}: what fades is not there"
            );
            ask!(
                fading.remaining > 0.0 && fading.remaining <= rules.fade,
                "fading for {}",
                fading.remaining
            );
        }
    }
    for _ in 0..60 {
        simulation.step(H);
    }
    let bodies = &simulation.bodies;
    let left = bodies.iter().filter(|&s| {
        let volume: f64 = hulls(bodies, s)
            .iter()
            .map(|(_, shape)| shape.hull().volume())
            .sum();
        pieces.contains(&bodies.id(s))
            && bodies.kind(s) == RigidBody::Dynamic
            && volume <= 0.999 * f64::from(rules.max_volume)
    });
    let left = left.count();
    ask!(
        left <= rules.max_pieces,
        "{left} pieces stay, {} may",
        rules.max_pieces
    );
    Ok(pieces.len())
}
