//! Cuts on request: random planes through bodies of all kinds.

use crate::common::dice::Dice;
use crate::kit::*;
use bevy_cleave::mass::VolumeIntegrals;
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Volume of the hulls of a body, and of what weighs, m3.
fn volumes(bodies: &Bodies, slot: u32) -> [f64; 2] {
    let hulls = hulls(bodies, slot);
    let solid = hulls.iter().map(|(_, shape)| shape.hull().volume()).sum();
    let weight = hulls
        .iter()
        .map(|(_, shape)| VolumeIntegrals::of_shape(shape).volume)
        .sum();
    [solid, weight]
}

/// Whether two convex shapes overlap by more than `depth`: no face of either separates them, nor do edges.
fn overlap(a: &(Pose, ConvexMesh), b: &(Pose, ConvexMesh)) -> f32 {
    let corners = |(pose, shape): &(Pose, ConvexMesh)| -> Vec<Vec3> {
        let corners = shape.hull().vertices().iter();
        corners.map(|&v| pose.transform_point(v)).collect()
    };
    let (of_a, of_b) = (corners(a), corners(b));
    let mut deepest = f32::INFINITY;
    let mut along = |axis: Vec3| {
        let Some(axis) = axis.try_normalize() else {
            return;
        };
        let range = |points: &[Vec3]| {
            points
                .iter()
                .map(|p| p.dot(axis))
                .fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), d| {
                    (l.min(d), h.max(d))
                })
        };
        let ((al, ah), (bl, bh)) = (range(&of_a), range(&of_b));
        deepest = deepest.min((ah - bl).min(bh - al));
    };
    let normals = |(pose, shape): &(Pose, ConvexMesh)| -> Vec<Vec3> {
        shape
            .hull()
            .faces()
            .iter()
            .map(|face| pose.rotation * face.plane.normal)
            .collect()
    };
    let all: Vec<Vec3> = normals(a).into_iter().chain(normals(b)).collect();
    all.into_iter().for_each(&mut along);
    deepest
}

pub(crate) fn judge(seed: u64) -> Verdict {
    let dice = &mut Dice::new(seed);
    let size = 10.0_f32.powf(dice.in_range(-0.5, 0.8));
    let family = dice.below(5);
    let shape = match family {
        0 | 1 => Shape::Convex(convex(dice, size)),
        2 => Shape::Convex(with_visual(dice, size)),
        3 => Shape::Compound(compound(dice, size)),
        _ => Shape::Compound(cluster(dice, size, 1e6)),
    };
    let kind = [
        RigidBody::Dynamic,
        RigidBody::Dynamic,
        RigidBody::Static,
        RigidBody::Kinematic,
    ][dice.below(4)];
    let mut desc = BodyDesc::new(kind, shape);
    // Rounding of where pieces lie is much in so short a step.
    desc.layers = CollisionLayers::NONE;
    if dice.below(3) == 0 {
        let factor = dice.vector(0.5, 2.0);
        desc.shape = match desc.shape {
            Shape::Convex(shape) => Shape::Convex(match shape.scaled(factor) {
                Ok(shape) => shape,
                Err(_) => shape.scaled(Vec3::splat(factor.x)).expect("alike"),
            }),
            Shape::Compound(shape) => match shape.scaled(factor) {
                Ok(scaled) => Shape::Compound(scaled),
                Err(_) => Shape::Compound(shape),
            },
            other => other,
        };
    }
    let at = size * dice.vector(-3.0, 3.0);
    desc.pose = turned(dice, at);
    if kind != RigidBody::Static {
        desc.linear_velocity = size * dice.vector(-5.0, 5.0);
        desc.angular_velocity = dice.vector(-8.0, 8.0);
    }
    let mut simulation = in_space();
    let body = simulation.bodies.insert(desc).map_err(|e| e.to_string())?;
    // So short a step that nothing moves by more than rounding.
    const INSTANT: f32 = 1e-7;
    simulation.step(INSTANT);
    let mut planes: Vec<Plane> = Vec::new();
    let center = simulation.bodies.center_of_mass(body);
    for _ in 0..1 + dice.below(3) {
        let through = center + 0.15 * size * dice.vector(-1.0, 1.0);
        let plane = Plane::through(through, dice.direction());
        planes.push(plane);
        simulation.slice(body, plane).map_err(|e| e.to_string())?;
    }
    let before = volumes(&simulation.bodies, body);
    let whole = mass(&simulation.bodies);
    let is_round = hulls(&simulation.bodies, body)
        .iter()
        .any(|(_, shape)| shape.is_round());
    let (v, omega) = simulation.bodies.velocity(body);
    let is_visual = family == 2;
    simulation.step(INSTANT);
    if !simulation.fractures.refused.is_empty() {
        let (_, why) = &simulation.fractures.refused[0];
        ask!(matches!(why, CutError::Missed), "refused: {why}");
        return Ok(0);
    }
    let dropped = check_ledgers(&simulation)?;
    let bodies = &simulation.bodies;
    let pieces: Vec<u32> = simulation
        .fractures
        .done
        .iter()
        .flat_map(|f| f.pieces.iter().copied())
        .collect();
    ask!(pieces.len() >= 2, "{} pieces", pieces.len());
    let sum = pieces
        .iter()
        .map(|&slot| volumes(bodies, slot))
        .fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    // A polyhedron stands for what is round, overlapping parts count once in what is cut of them, and hulls of visual parts shrink.
    if !is_round {
        let which = usize::from(is_visual);
        let error = (sum[which] - before[which]).abs() / before[which];
        if !is_visual {
            ask!(
                error < 1e-5,
                "family {family}: volume {} of {}",
                sum[which],
                before[which]
            );
        }
    }
    let left = mass(bodies) + dropped;
    ask!(
        (left - whole).abs() < 2e-6 * whole,
        "family {family}: {left} kg of {whole} kg"
    );
    // Polyhedra stand for round parts: a velocity makes up for what their centers are off.
    let slip = if is_round { 0.02 } else { 2e-5 };
    let slack = 1e-5 * size.max(center.length());
    for &slot in &pieces {
        let at = corners(bodies, slot);
        for plane in &planes {
            let range = at.iter().map(|&p| plane.distance(p));
            let (low, high) = range.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), d| {
                (l.min(d), h.max(d))
            });
            ask!(
                low > -slack || high < slack,
                "family {family}: a piece on both sides of a plane: {low} {high}"
            );
        }
        let (pv, po) = bodies.velocity(slot);
        let lever = bodies.center_of_mass(slot) - center;
        let expected = v + omega.cross(lever);
        let fast = v.length() + omega.length() * size;
        if bodies.kind(slot) == RigidBody::Dynamic || kind == RigidBody::Kinematic {
            ask!(
                (pv - expected).length() <= slip * fast,
                "family {family} {kind:?}: velocity {pv} instead of {expected}"
            );
            ask!(
                (po - omega).length() <= 1e-5 * omega.length(),
                "spin {po} instead of {omega}"
            );
        }
        check_mass_of_parts(bodies, slot)?;
    }
    check_connected(&simulation)?;
    if family != 3 {
        for (i, &a) in pieces.iter().enumerate() {
            for &b in &pieces[..i] {
                for a in &hulls(bodies, a) {
                    for b in &hulls(bodies, b) {
                        let depth = overlap(a, b);
                        ask!(
                            depth < 4.0 * slack,
                            "family {family}: pieces overlap by {depth} m at size {size}"
                        );
                    }
                }
            }
        }
    }
    Ok(pieces.len())
}

/// What rests on a body that is cut stays at rest if the pieces stay where they are.
pub(crate) fn judge_stack(seed: u64) -> Verdict {
    let dice = &mut Dice::new(seed);
    let mut simulation = Simulation::default();
    simulation.config.sleep.enabled = dice.below(2) == 0;
    let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    simulation.bodies.insert(floor).expect("usable");
    let base = Vec3::new(
        dice.in_range(1.0, 2.0),
        dice.in_range(0.3, 1.0),
        dice.in_range(1.0, 2.0),
    );
    let shape = match dice.below(3) {
        0 => Shape::Convex(cuboid(base)),
        1 => {
            let cells = FracturePattern::Brick { size: base / 2.5 };
            let cluster = Cluster::cut(&cuboid(base), &cells, seed, 1e7).expect("bricks");
            Shape::Compound(cluster.compound().expect("connected"))
        }
        _ => {
            let half = Vec3::new(0.5 * base.x, base.y, base.z);
            let at = |side: f32| {
                (
                    Pose::from_position(Vec3::X * 0.25 * side * base.x),
                    cuboid(half),
                )
            };
            Shape::Compound(Compound::new([at(-1.0), at(1.0)]).expect("two halves"))
        }
    };
    let kind = [RigidBody::Dynamic, RigidBody::Dynamic, RigidBody::Static][dice.below(3)];
    let mut body = BodyDesc::new(kind, shape);
    body.pose.position = 0.5 * base.y * Vec3::Y;
    let body = simulation.bodies.insert(body).expect("usable");
    let mut top = base.y;
    let mut stack = Vec::new();
    for _ in 0..1 + dice.below(4) {
        let size = Vec3::new(
            dice.in_range(0.5, 0.9),
            dice.in_range(0.2, 0.5),
            dice.in_range(0.5, 0.9),
        );
        let mut desc = BodyDesc::dynamic(cuboid(size), (top + 0.5 * size.y) * Vec3::Y);
        desc.density = 10.0_f32.powf(dice.in_range(2.0, 4.0));
        top += size.y;
        stack.push(simulation.bodies.insert(desc).expect("usable"));
    }
    for _ in 0..90 {
        simulation.step(H);
    }
    let places: Vec<Vec3> = stack
        .iter()
        .map(|&slot| simulation.bodies.center_of_mass(slot))
        .collect();
    // Level or upright cuts: pieces stand on each other or beside each other, none slides.
    let count = 1 + dice.below(2);
    for _ in 0..count {
        let plane = if dice.below(2) == 0 {
            let height = base.y * dice.in_range(0.3, 0.7);
            Plane::through(height * Vec3::Y, Vec3::Y)
        } else {
            let around = dice.in_range(0.0, 6.3);
            let normal = Vec3::new(around.cos(), 0.0, around.sin());
            Plane::through(0.1 * dice.in_range(-1.0, 1.0) * normal, normal)
        };
        simulation.slice(body, plane).expect("a body");
    }
    let before = simulation.bodies.len();
    let mut fastest = 0.0_f32;
    for _ in 0..120 {
        simulation.step(H);
        check_ledgers(&simulation)?;
        for &slot in &stack {
            fastest = fastest.max(simulation.bodies.velocity(slot).0.length());
        }
    }
    let bodies = &simulation.bodies;
    let pieces = bodies.len() - before + 1;
    for (&slot, &place) in stack.iter().zip(&places) {
        let off = (bodies.center_of_mass(slot) - place).length();
        ask!(
            off < 0.003,
            "{kind:?}, {pieces} pieces: a body of the stack of {} has moved by {off} m, up to {fastest} m/s",
            stack.len()
        );
    }
    ask!(
        fastest < 0.05,
        "{kind:?}, {pieces} pieces: the stack moved with {fastest} m/s"
    );
    Ok(pieces)
}
