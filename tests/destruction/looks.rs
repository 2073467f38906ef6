//! What faces of cuts look like: they have their slot, and nothing else has it, whatever was cut before.

use crate::common::dice::Dice;
use crate::kit::*;
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Slot of the faces of cuts.
const CUT: u16 = 7;

/// So short a step that nothing moves by more than rounding.
const INSTANT: f32 = 1e-7;

/// What is drawn of a shape, with slots of its own or without.
fn painted(dice: &mut Dice, shape: ConvexMesh) -> ConvexMesh {
    let mesh = shape.render_mesh().into_owned();
    let slots = (0..mesh.triangles().len()).map(|_| dice.below(3) as u16);
    let slots: Vec<u16> = slots.collect();
    let mesh = match dice.below(3) {
        0 => return shape,
        1 => mesh,
        _ => mesh.with_materials(slots).expect("one each"),
    };
    ConvexMesh::from_parts(shape.hull().clone(), Some(mesh))
}

/// Area of all that is drawn of the bodies: of faces of cuts, and of the rest, m2.
fn areas(bodies: &Bodies) -> [f64; 2] {
    let mut areas = [0.0; 2];
    for slot in bodies.iter() {
        let convex = bodies.convex(slot).map(ConvexMesh::render_mesh);
        let Some(mesh) = convex.or_else(|| bodies.compound(slot).map(Compound::render_mesh)) else {
            continue;
        };
        for (i, corners) in mesh.triangles().iter().enumerate() {
            let [a, b, c] = corners.map(|v| mesh.positions()[v as usize].as_dvec3());
            let is_cut = mesh.materials().get(i) == Some(&CUT);
            areas[usize::from(!is_cut)] += 0.5 * (b - a).cross(c - a).length();
        }
    }
    areas
}

/// Cuts everything by random planes, several times, beyond the generations that break by themselves. How many pieces there are.
pub(crate) fn judge(seed: u64) -> Verdict {
    let dice = &mut Dice::new(seed);
    let shape = match dice.below(4) {
        0 | 1 => {
            let shape = convex(dice, 1.0);
            Shape::Convex(painted(dice, shape))
        }
        2 => Shape::Convex(with_visual(dice, 1.0)),
        _ => Shape::Compound(compound(dice, 1.0)),
    };
    let is_compound = matches!(shape, Shape::Compound(_));
    let fracturable = Fracturable {
        cut_material: Some(CUT),
        generations: dice.below(3) as u8,
        min_volume: 0.0,
        ..Fracturable::with_strength(1e9)
    };
    let desc = BodyDesc {
        fracturable: Some(fracturable),
        layers: CollisionLayers::NONE,
        ..BodyDesc::new(RigidBody::Dynamic, shape)
    };
    let mut simulation = in_space();
    simulation.bodies.insert(desc).map_err(|e| e.to_string())?;
    simulation.step(INSTANT);
    let [_, outside] = areas(&simulation.bodies);
    let mut inside = 0.0;
    for round in 0..4 {
        let all: Vec<u32> = simulation.bodies.iter().collect();
        for slot in all {
            let middle = simulation.bodies.center_of_mass(slot);
            let through = middle + 0.02 * dice.vector(-1.0, 1.0);
            let plane = Plane::through(through, dice.direction());
            let _ = simulation.slice(slot, plane);
        }
        simulation.step(INSTANT);
        if check_ledgers(&simulation)? > 0.0 {
            return Ok(0);
        }
        let [cut, rest] = areas(&simulation.bodies);
        ask!(
            (rest - outside).abs() < 1e-4 * outside,
            "round {round}: {rest} m2 of the {outside} m2 that was outside"
        );
        // A plane may pass between the parts of a compound.
        let is_cut = !simulation.fractures.done.is_empty() && !is_compound;
        ask!(
            cut > inside || !is_cut && cut == inside,
            "round {round}: {cut} m2 of faces of cuts after {inside} m2"
        );
        inside = cut;
    }
    Ok(simulation.bodies.iter().count())
}

/// The same of a blow that uses up what breaks by itself, and cuts of its pieces.
pub(crate) fn judge_after_a_blow(seed: u64) -> Verdict {
    let dice = &mut Dice::new(seed);
    let shape = convex(dice, 1.0);
    let mut body = BodyDesc::dynamic(painted(dice, shape), Vec3::ZERO);
    body.fracturable = Some(Fracturable {
        cut_material: Some(CUT),
        generations: 0,
        min_volume: 0.0,
        ..breakable(dice, 1.0)
    });
    let mut simulation = in_space();
    simulation.bodies.insert(body).map_err(|e| e.to_string())?;
    simulation.step(INSTANT);
    let [_, outside] = areas(&simulation.bodies);
    let blast = Explosion {
        center: 0.9 * dice.direction(),
        radius: 3.0,
        impulse: 500.0,
    };
    simulation
        .bodies
        .explode(blast)
        .map_err(|e| e.to_string())?;
    let mut dropped = 0.0;
    for _ in 0..2 {
        simulation.step(INSTANT);
        dropped += check_ledgers(&simulation)?;
    }
    let shards: Vec<u32> = simulation.bodies.iter().collect();
    let [by_blow, _] = areas(&simulation.bodies);
    for &slot in &shards {
        let middle = simulation.bodies.center_of_mass(slot);
        let _ = simulation.slice(slot, Plane::through(middle, dice.direction()));
    }
    simulation.step(INSTANT);
    dropped += check_ledgers(&simulation)?;
    if shards.len() < 2 || dropped > 0.0 {
        return Ok(0);
    }
    let [cut, rest] = areas(&simulation.bodies);
    ask!(
        (rest - outside).abs() < 1e-4 * outside,
        "{rest} m2 of the {outside} m2 that was outside, of {} shards",
        shards.len()
    );
    ask!(cut > by_blow, "no face of a cut is seen");
    Ok(shards.len())
}
