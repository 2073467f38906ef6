//! What holds bodies together goes to the pieces that it is at: bonds by area, joints by place.

use crate::common::dice::Dice;
use crate::kit::*;
use bevy_cleave::math::rotate;
use bevy_cleave::prelude::*;
use glam::Vec3;

/// The pieces of one of two bonded bodies, or of both, share the bond by where they lie on the other.
pub(crate) fn judge_bonds(seed: u64) -> Verdict {
    let dice = &mut Dice::new(seed);
    let mut simulation = in_space();
    let lower = dice.vector(0.5, 1.5);
    let upper = dice.vector(0.5, 1.5);
    let turn = dice.rotation();
    let aside = 0.3 * Vec3::new(dice.in_range(-1.0, 1.0), 0.0, dice.in_range(-1.0, 1.0));
    let way = Pose::new(dice.vector(-3.0, 3.0), turn);
    let place = |at: Vec3| Pose::new(way.transform_point(at), turn);
    let [a, b] = [
        (lower, Vec3::ZERO),
        (upper, aside + 0.5 * (lower.y + upper.y) * Vec3::Y),
    ]
    .map(|(size, at)| {
        let shape = match dice.below(3) {
            0 => {
                let cells = FracturePattern::Voronoi {
                    cells: 6,
                    focus: 0.0,
                };
                let cluster = Cluster::cut(&cuboid(size), &cells, seed, 1e8).expect("cells");
                Shape::Compound(cluster.compound().expect("connected"))
            }
            _ => Shape::Convex(cuboid(size)),
        };
        let mut desc = BodyDesc::new(RigidBody::Dynamic, shape);
        desc.pose = place(at);
        simulation.bodies.insert(desc).expect("usable")
    });
    if dice.below(3) == 0 {
        simulation
            .bodies
            .set_kind(a, RigidBody::Static)
            .expect("usable");
    }
    let made = simulation
        .bond_neighbors(&[a, b], 1e7)
        .map_err(|e| e.to_string())?;
    ask!(made == 1, "{made} bonds");
    simulation.step(1e-6);
    let sum = |simulation: &Simulation| {
        simulation
            .bonds
            .iter()
            .map(|(_, bond)| bond.area)
            .sum::<f32>()
    };
    let whole = sum(&simulation);
    for _ in 0..1 + dice.below(2) {
        for slot in [a, b] {
            if dice.below(3) > 0 {
                let center = simulation.bodies.center_of_mass(slot);
                let plane = Plane::through(center + 0.2 * dice.vector(-1.0, 1.0), dice.direction());
                simulation.slice(slot, plane).map_err(|e| e.to_string())?;
            }
        }
    }
    simulation.step(1e-6);
    check_ledgers(&simulation)?;
    let pieces: usize = simulation
        .fractures
        .done
        .iter()
        .map(|f| f.pieces.len())
        .sum();
    let left = sum(&simulation);
    ask!(
        (left - whole).abs() < 2e-3 * whole,
        "bonds of {left} m2 instead of {whole} m2"
    );
    ask!(
        simulation.bonds.broken.is_empty(),
        "{} bonds broke by a cut",
        simulation.bonds.broken.len()
    );
    for ([a, b], bond) in simulation.bonds.iter() {
        ask!(bond.area > 0.0 && bond.strength == 1e7, "{bond:?}");
        ask!(
            simulation.bodies.contains(a) && simulation.bodies.contains(b),
            "a bond to nothing"
        );
    }
    // And they hold.
    for _ in 0..30 {
        simulation.step(H);
        ask!(
            simulation.bonds.broken.is_empty(),
            "a bond broke without a load"
        );
    }
    Ok(pieces)
}

/// Whether a point of the world is in a body, or how far out of it, m.
fn depth(bodies: &Bodies, slot: u32, at: Vec3) -> f32 {
    let hulls = hulls(bodies, slot).into_iter();
    let heights = hulls.map(|(pose, shape)| {
        let own = pose.inverse_transform_point(at);
        let faces = shape.hull().faces().iter();
        faces
            .map(|face| face.plane.distance(own))
            .fold(f32::NEG_INFINITY, f32::max)
    });
    heights.fold(f32::INFINITY, f32::min)
}

/// Joints stay where they are, and at the piece that they are in, however often what they hold breaks in one step.
pub(crate) fn judge_joints(seed: u64) -> Verdict {
    let dice = &mut Dice::new(seed);
    let mut simulation = in_space();
    let size = 10.0_f32.powf(dice.in_range(-0.5, 0.5));
    let add = |dice: &mut Dice, simulation: &mut Simulation, at: Vec3| {
        let shape = match dice.below(4) {
            0 => Shape::Compound(cluster(dice, size, 3e3)),
            1 => Shape::Compound(compound(dice, size)),
            _ => Shape::Convex(convex(dice, size)),
        };
        let mut desc = BodyDesc::new(RigidBody::Dynamic, shape);
        desc.pose = turned(dice, at);
        desc.layers = CollisionLayers::NONE;
        let volume = size.powi(3);
        if dice.below(2) == 0 {
            desc.fracturable = Some(breakable(dice, 10.0 * volume));
        }
        simulation.bodies.insert(desc).expect("usable")
    };
    let a = add(dice, &mut simulation, Vec3::ZERO);
    let b = add(dice, &mut simulation, 1.5 * size * Vec3::X);
    let mut joints = Vec::new();
    for _ in 0..1 + dice.below(3) {
        let [pa, pb] = [a, b].map(|slot| simulation.bodies.pose(slot));
        let of = corners(&simulation.bodies, a);
        let at = of[dice.below(of.len())].lerp(pa.position, dice.in_range(0.1, 0.9));
        let joint = [Joint::fixed(), Joint::ball(), Joint::hinge()][dice.below(3)];
        let joint = joint.with_anchor(at, dice.direction(), [pa, pb]);
        let id = simulation
            .join(Some(a), b, joint)
            .map_err(|e| e.to_string())?;
        joints.push((id, at));
    }
    simulation.step(1e-6);
    let ids = [a, b].map(|slot| simulation.bodies.id(slot));
    // Cuts, and blasts that break what the cuts leave, in the same step.
    for slot in [a, b] {
        for _ in 0..dice.below(3) {
            let at = simulation.bodies.center_of_mass(slot) + 0.2 * size * dice.vector(-1.0, 1.0);
            simulation
                .slice(slot, Plane::through(at, dice.direction()))
                .map_err(|e| e.to_string())?;
        }
    }
    for _ in 0..dice.below(3) {
        let explosion = Explosion {
            center: 1.2 * size * dice.direction(),
            radius: 3.0 * size,
            impulse: 1000.0 * size.powi(3) * 10.0_f32.powf(dice.in_range(-2.0, 0.0)),
        };
        simulation.bodies.explode(explosion).expect("usable");
    }
    simulation.step(1e-7);
    check_ledgers(&simulation)?;
    let bodies = &simulation.bodies;
    let made: usize = simulation
        .fractures
        .done
        .iter()
        .map(|f| f.pieces.len())
        .sum();
    let any_dropped = simulation
        .fractures
        .done
        .iter()
        .any(|f| f.ledger.dropped_pieces > 0);
    // The pieces that each was, by name.
    let mut parts = ids.map(|id| vec![id]);
    for fracture in &simulation.fractures.done {
        for of in &mut parts {
            if of.contains(&fracture.parent) {
                of.extend(&fracture.ids);
            }
        }
    }
    for &(id, at) in &joints {
        let both = [0, 1].map(|side| {
            // Splinters that a blast has hit are away by now, or have turned.
            let alive = bodies.iter().filter(|&s| {
                let (v, omega) = bodies.velocity(s);
                let is_near = v.length() < 1e4 * size && omega.length() < 1e4;
                is_near && parts[side].contains(&bodies.id(s))
            });
            alive.collect::<Vec<u32>>()
        });
        let Some([Some(slot_a), Some(slot_b)]) = simulation.joints.bodies(id) else {
            return Err("a joint is gone".into());
        };
        let joint = simulation.joints.get(id).expect("there");
        for (side, slot) in [(0, slot_a), (1, slot_b)] {
            ask!(
                parts[side].contains(&bodies.id(slot)),
                "end {side} is at a body that was no part of its own"
            );
            if !both[side].contains(&slot) {
                continue;
            }
            let frame = [joint.frame_a, joint.frame_b][side];
            let pose = bodies.pose(slot);
            let now = pose.position + rotate(pose.rotation, frame.position);
            let off = (now - at).length();
            ask!(
                off < 2e-3 * size,
                "end {side} has moved by {off} m of {size} m"
            );
            let nearest = both[side]
                .iter()
                .map(|&s| depth(bodies, s, at))
                .fold(f32::INFINITY, f32::min);
            let own = depth(bodies, slot, at);
            let slack = 0.02 * size;
            ask!(
                any_dropped || own <= nearest.max(0.0) + slack,
                "end {side} is {own} m out of its piece, {nearest} m out of another"
            );
        }
    }
    Ok(made)
}
