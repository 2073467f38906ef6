//! Clusters: bodies are the groups of parts that bonds hold together, whatever broke them.

use crate::common::dice::Dice;
use crate::kit::*;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// Random clusters that are shot at, blown at, cut, and fall: parts, bodies and masses add up.
pub(crate) fn judge(seed: u64) -> Verdict {
    let dice = &mut Dice::new(seed);
    let on_floor = dice.below(2) == 0;
    let mut simulation = if on_floor {
        awake_on_floor()
    } else {
        in_space()
    };
    let mut parts = 0;
    for i in 0..1 + dice.below(2) {
        let strength = 10.0_f32.powf(dice.in_range(3.0, 6.0));
        let shape = cluster(dice, 1.5, strength);
        parts += shape.len();
        let at = Vec3::new(2.5 * i as f32, 1.3 + dice.unit(), 0.0);
        let mut desc = BodyDesc::compound(shape, at);
        desc.pose = turned(dice, at);
        desc.linear_velocity = dice.vector(-3.0, 3.0);
        desc.angular_velocity = dice.vector(-6.0, 6.0);
        let slot = simulation.bodies.insert(desc).expect("usable");
        if dice.below(3) == 0 {
            let fatigue = Fatigue {
                energy: dice.in_range(10.0, 500.0),
                ..Default::default()
            };
            let _ = simulation.bodies.set_fatigue(slot, Some(fatigue));
        }
    }
    let is_cut = dice.below(3) == 0;
    simulation.step(1e-6);
    let mut whole = mass(&simulation.bodies);
    let (mut broken, mut dropped) = (0, 0.0);
    for number in 0..40 {
        let slots: Vec<u32> = simulation
            .bodies
            .iter()
            .filter(|&s| simulation.bodies.compound(s).is_some())
            .collect();
        if dice.below(4) == 0 && !slots.is_empty() {
            let slot = slots[dice.below(slots.len())];
            let at = simulation.bodies.center_of_mass(slot);
            match dice.below(4) {
                0 if is_cut => simulation
                    .slice(slot, Plane::through(at, dice.direction()))
                    .expect("a body"),
                0 | 1 => {
                    let heavy = dice.in_range(1.0, 60.0);
                    whole += f64::from(heavy);
                    let from = at + 2.5 * dice.direction().with_y(0.5);
                    let speed = dice.in_range(5.0, 60.0);
                    let shot = shot(dice, at, from, heavy, speed);
                    simulation.bodies.insert(shot).expect("usable");
                }
                2 => {
                    let corners = corners(&simulation.bodies, slot);
                    let point = corners[dice.below(corners.len())];
                    let impulse = 10.0_f32.powf(dice.in_range(1.0, 3.5)) * dice.direction();
                    simulation
                        .bodies
                        .apply_at(slot, point, [Vec3::ZERO, impulse])
                        .expect("usable");
                }
                _ => {
                    let explosion = Explosion {
                        center: at + dice.direction(),
                        radius: dice.in_range(0.5, 3.0),
                        impulse: 10.0_f32.powf(dice.in_range(1.5, 3.5)),
                    };
                    simulation.bodies.explode(explosion).expect("usable");
                }
            }
        }
        simulation.step([1.0 / 30.0, H, 1.0 / 120.0, 1.0 / 240.0][seed as usize % 4]);
        dropped += check_ledgers(&simulation).map_err(|e| format!("step {number}: {e}"))?;
        broken += simulation.fractures.done.len();
        if simulation.fractures.waiting() == 0 {
            check_connected(&simulation).map_err(|e| format!("step {number}: {e}"))?;
        }
        for slot in simulation.bodies.iter() {
            check_mass_of_parts(&simulation.bodies, slot)
                .map_err(|e| format!("step {number}: {e}"))?;
        }
        let left = mass(&simulation.bodies) + dropped;
        ask!(
            (left - whole).abs() < 4e-6 * whole,
            "step {number}: {left} kg of {whole} kg"
        );
    }
    if !is_cut {
        let bodies = &simulation.bodies;
        let count = |slot: u32| {
            bodies
                .compound(slot)
                .map_or(usize::from(bodies.convex(slot).is_some()), Compound::len)
        };
        let shots = bodies
            .iter()
            .filter(|&s| bodies.convex(s).is_some_and(ConvexMesh::is_round))
            .count();
        let now: usize = bodies.iter().map(count).sum();
        ask!(now - shots == parts, "{} parts of {parts}", now - shots);
    }
    Ok(broken)
}

/// How a cluster falls apart under one blow, as groups of the numbers of its parts.
struct Fall {
    shape: Compound,
    pose: Pose,
    spin: Vec3,
    kind: RigidBody,
    hit: Hit,
    gravity: Vec3,
}

#[derive(Clone)]
enum Hit {
    Shot(Box<BodyDesc>),
    Blast(Explosion),
}

impl Fall {
    /// Masses of what comes of it, sorted: which parts hang together, whatever their order.
    fn groups(&self) -> Vec<f32> {
        let mut simulation = in_space();
        simulation.gravity = Gravity(self.gravity);
        let mut desc = BodyDesc::new(self.kind, Shape::Compound(self.shape.clone()));
        desc.pose = self.pose;
        desc.angular_velocity = self.spin;
        let slot = simulation.bodies.insert(desc).expect("usable");
        if self.kind == RigidBody::Static {
            hold_foot(&mut simulation, slot, &self.shape);
        }
        simulation.step(1e-6);
        match &self.hit {
            Hit::Shot(shot) => {
                simulation.bodies.insert((**shot).clone()).expect("usable");
            }
            Hit::Blast(blast) => simulation.bodies.explode(*blast).expect("usable"),
        }
        let is_shot = matches!(self.hit, Hit::Shot(_));
        for _ in 0..30 {
            simulation.step(H);
            if !simulation.fractures.done.is_empty() || !is_shot {
                break;
            }
        }
        let bodies = &simulation.bodies;
        let shot = is_shot.then_some(slot + 1);
        let bonds: f32 = bodies
            .iter()
            .filter_map(|s| bodies.compound(s))
            .map(|c| c.bonds().len() as f32)
            .sum();
        let mut masses: Vec<f32> = bodies
            .iter()
            .filter(|&s| Some(s) != shot && is_solid(bodies, s))
            .map(|s| bodies.mass(s).mass)
            .collect();
        masses.sort_by(f32::total_cmp);
        masses.push(bonds);
        masses
    }

    fn random(dice: &mut Dice) -> Self {
        let strength = 10.0_f32.powf(dice.in_range(3.0, 6.0));
        let shape = cluster(dice, 1.5, strength);
        let at = dice.vector(-1.0, 1.0);
        let pose = turned(dice, at);
        let kind = [RigidBody::Dynamic, RigidBody::Static][dice.below(2)];
        let aabb = shape.aabb();
        let from = dice.direction();
        let target =
            pose.transform_point(aabb.center() + 0.3 * aabb.extents() * dice.vector(-1.0, 1.0));
        let hit = if dice.below(3) == 0 {
            Hit::Blast(Explosion {
                center: target + 0.8 * from,
                radius: 2.0,
                impulse: 10.0_f32.powf(dice.in_range(1.5, 4.0)),
            })
        } else {
            let (heavy, speed) = (dice.in_range(1.0, 60.0), dice.in_range(5.0, 60.0));
            Hit::Shot(Box::new(shot(
                dice,
                target,
                target + 2.5 * from,
                heavy,
                speed,
            )))
        };
        let spin = if dice.below(3) == 0 && kind == RigidBody::Dynamic {
            dice.vector(-3.0, 3.0)
        } else {
            Vec3::ZERO
        };
        Self {
            shape,
            pose,
            spin,
            kind,
            hit,
            gravity: Vec3::ZERO,
        }
    }

    /// The same with its parts and bonds in another order.
    fn permuted(&self, dice: &mut Dice) -> Self {
        let count = self.shape.len();
        let mut order: Vec<usize> = (0..count).collect();
        for i in (1..count).rev() {
            order.swap(i, dice.below(i + 1));
        }
        let parts = order.iter().map(|&old| self.shape.parts()[old].clone());
        let place = |old: u32| {
            order
                .iter()
                .position(|&o| o == old as usize)
                .expect("there") as u32
        };
        let mut bonds: Vec<PartBond> = self
            .shape
            .bonds()
            .iter()
            .map(|bond| PartBond {
                parts: bond.parts.map(place),
                ..*bond
            })
            .collect();
        bonds.reverse();
        let shape = Compound::new(parts)
            .and_then(|it| it.with_bonds(bonds))
            .expect("the same");
        Self {
            shape,
            hit: self.hit.clone(),
            ..*self
        }
    }

    /// The same turned about the origin, and moved.
    fn moved(&self, turn: Quat, by: Vec3) -> Self {
        let way = Pose::new(by, turn);
        let hit = match &self.hit {
            Hit::Shot(shot) => {
                let mut shot = shot.clone();
                shot.pose = way * shot.pose;
                shot.linear_velocity = turn * shot.linear_velocity;
                Hit::Shot(shot)
            }
            Hit::Blast(blast) => Hit::Blast(Explosion {
                center: way.transform_point(blast.center),
                ..*blast
            }),
        };
        Self {
            shape: self.shape.clone(),
            pose: way * self.pose,
            spin: turn * self.spin,
            hit,
            kind: self.kind,
            gravity: turn * self.gravity,
        }
    }
}

fn alike(a: &[f32], b: &[f32]) -> bool {
    a.len() == b.len()
        && a.iter()
            .zip(b)
            .all(|(a, b)| (a - b).abs() <= 1e-4 * a.max(1e-3))
}

pub(crate) fn judge_same(seed: u64) -> Verdict {
    let dice = &mut Dice::new(seed);
    let fall = Fall::random(dice);
    let as_is = fall.groups();
    let permuted = fall.permuted(dice).groups();
    ask!(
        alike(&as_is, &permuted),
        "{:?} in another order: {as_is:?} against {permuted:?}",
        fall.kind
    );
    let moved = fall
        .moved(Quat::IDENTITY, Vec3::new(4.0, -2.0, 8.0))
        .groups();
    ask!(
        alike(&as_is, &moved),
        "{:?} moved: {as_is:?} against {moved:?}",
        fall.kind
    );
    let turned = fall.moved(dice.rotation(), Vec3::ZERO).groups();
    ask!(
        alike(&as_is, &turned),
        "{:?} turned: {as_is:?} against {turned:?}",
        fall.kind
    );
    Ok(usize::from(as_is.len() > 2))
}

/// Where a blow breaks something, harder ones do.
pub(crate) fn judge_harder(seed: u64) -> Verdict {
    let dice = &mut Dice::new(seed);
    let fall = Fall::random(dice);
    let harder = |factor: f32| {
        let hit = match &fall.hit {
            Hit::Shot(shot) => {
                let mut shot = shot.clone();
                // From as many steps away.
                let way = factor * shot.linear_velocity - shot.linear_velocity;
                let steps = 2.4 / shot.linear_velocity.length();
                shot.pose.position -= steps * way;
                shot.linear_velocity *= factor;
                // And from outside: what is slow would start within what it hits.
                let away = 0.1 + 2.4 * factor;
                let more = (2.5 - away) / (shot.linear_velocity.length() * H);
                shot.pose.position -= more.ceil().max(0.0) * H * shot.linear_velocity;
                Hit::Shot(shot)
            }
            Hit::Blast(blast) => Hit::Blast(Explosion {
                impulse: factor * blast.impulse,
                ..*blast
            }),
        };
        let spin = Vec3::ZERO;
        let fall = Fall {
            shape: fall.shape.clone(),
            hit,
            spin,
            ..fall
        };
        *fall.groups().last().expect("bonds")
    };
    let left = [0.25, 0.5, 0.7, 1.0, 1.4, 2.0, 4.0].map(harder);
    // How many break is another matter: a fast one goes through before what is around has moved.
    let whole = fall.shape.bonds().len() as f32;
    for pair in left.windows(2) {
        ask!(
            pair[0] == whole || pair[1] < whole,
            "{:?}: of {whole} bonds are left {left:?}",
            fall.kind
        );
    }
    Ok(usize::from(left[6] < left[0]))
}

/// Nothing gains energy by breaking: random clusters, free and anchored, and what is shot at them.
pub(crate) fn judge_energy(seed: u64) -> Verdict {
    let dice = &mut Dice::new(seed);
    let mut simulation = in_space();
    let fall = loop {
        let fall = Fall::random(dice);
        if matches!(fall.hit, Hit::Shot(_)) {
            break fall;
        }
    };
    let mut desc = BodyDesc::new(fall.kind, Shape::Compound(fall.shape.clone()));
    desc.pose = fall.pose;
    desc.angular_velocity = fall.spin;
    let friction = Friction::new(dice.unit());
    desc.friction = friction;
    if dice.below(3) == 0 {
        desc.restitution = Restitution::new(0.6 * dice.unit());
    }
    let slot = simulation.bodies.insert(desc).expect("usable");
    if fall.kind == RigidBody::Static {
        hold_foot(&mut simulation, slot, &fall.shape);
    }
    for i in 0..1 + dice.below(2) {
        let Hit::Shot(shot) = &fall.hit else {
            unreachable!()
        };
        let mut shot = (**shot).clone();
        shot.pose.position += 0.4 * i as f32 * dice.vector(-1.0, 1.0)
            - 0.7 * i as f32 * shot.linear_velocity.normalize();
        simulation.bodies.insert(shot).expect("usable");
    }
    simulation.step(1e-6);
    let first = energy(&simulation);
    let momentum = |simulation: &Simulation| -> Vec3 {
        let bodies = &simulation.bodies;
        bodies
            .iter()
            .filter(|&s| bodies.kind(s) == RigidBody::Dynamic)
            .map(|s| bodies.mass(s).mass * bodies.velocity(s).0)
            .sum()
    };
    let had = momentum(&simulation);
    let (mut last, mut worst, mut at, mut broken) = (first, 0.0_f64, 0, 0);
    let rate = [1.0 / 30.0, H, 1.0 / 120.0, 1.0 / 240.0][seed as usize % 4];
    for number in 0..(1.0 / rate) as usize {
        simulation.step(rate);
        let now = energy(&simulation);
        if (now - last) / first > worst {
            (worst, at) = ((now - last) / first, number);
        }
        last = now;
        broken += simulation.fractures.done.len();
    }
    ask!(
        worst < 3e-3,
        "{:?}: energy rises by {worst:.1e} in step {at}",
        fall.kind
    );
    if fall.kind == RigidBody::Dynamic {
        let off = (momentum(&simulation) - had).length() / had.length().max(1e-3);
        ask!(off < 1e-4, "momentum changes by {off:.1e}");
    }
    Ok(broken)
}
