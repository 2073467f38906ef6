//! Laws of characters among clusters, compounds and what was just cut, beneath parents that move, where gravity changes, and far away, for solvers of
//! all efforts, over random members.
#![expect(
    clippy::disallowed_methods,
    reason = "sizes and slopes of scenes may differ between platforms"
)]

use crate::common::dice::Dice;
use crate::walker_stage::{
    RADIUS, STANDING, Stage, Verdict, add_ground, check, flat, heading, hold,
};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::{Quat, Vec2, Vec3};

/// A solver of some effort.
fn any_effort(dice: &mut Dice) -> SolverConfig {
    let substeps = [1, 2, 4, 8, 16][dice.below(5)];
    match dice.below(6) {
        0 => SolverConfig::fast(),
        1 => SolverConfig::precise(),
        2 => SolverConfig::default(),
        _ => SoftStep {
            min_substeps: substeps,
            max_substeps: substeps,
            max_local_steps: [1, 8][dice.below(2)],
            tolerance: [None, Some(1e-3)][dice.below(2)],
            contact_frequency: [SoftStep::default().contact_frequency, 0.05][dice.below(2)],
            ..SoftStep::default()
        }
        .into(),
    }
}

/// A stage whose bodies are solved with some effort.
fn any_stage(dice: &mut Dice) -> Stage {
    let mut stage = Stage::any(dice);
    stage.app.insert_resource(any_effort(dice));
    stage
}

/// A box cut in advance into parts that are bonded.
fn cluster(stage: &Stage, dice: &mut Dice, size: Vec3) -> Compound {
    let whole = stage.box_shape(size);
    let pattern = match dice.below(3) {
        0 => FracturePattern::Brick {
            size: stage.unit * size / dice.in_range(1.6, 3.4),
        },
        1 => FracturePattern::Slabs {
            count: 2 + dice.below(4) as u8,
        },
        _ => FracturePattern::Voronoi {
            cells: 4 + dice.below(10) as u16,
            focus: 0.0,
        },
    };
    let strength = 10.0_f32.powf(dice.in_range(4.0, 9.0));
    let cut = Cluster::cut(&whole, &pattern, dice.below(1000) as u64, strength).expect("cells");
    cut.compound().expect("connected")
}

/// Boxes with places as one body, units.
fn compound(stage: &Stage, boxes: &[(Vec3, Vec3)]) -> Compound {
    let part =
        |&(at, size): &(Vec3, Vec3)| (Pose::from_position(stage.unit * at), stage.box_shape(size));
    Compound::new(boxes.iter().map(part)).expect("usable")
}

/// A table, stairs, an arch or a row of blocks.
fn furniture(stage: &Stage, dice: &mut Dice) -> (Compound, f32) {
    let v = Vec3::new;
    match dice.below(4) {
        0 => {
            let high = dice.in_range(0.2, 1.2);
            let mut boxes = vec![(v(0.0, high - 0.05, 0.0), v(1.4, 0.1, 0.9))];
            for (x, z) in [(0.6, 0.35), (0.6, -0.35), (-0.6, 0.35), (-0.6, -0.35)] {
                boxes.push((v(x, 0.5 * high - 0.05, z), v(0.1, high - 0.1, 0.1)));
            }
            (compound(stage, &boxes), high)
        }
        1 => {
            let rise = dice.in_range(0.1, 0.28);
            let boxes: Vec<_> = (0..4)
                .map(|i| {
                    let high = rise * (i + 1) as f32;
                    (v(0.4 * i as f32 - 0.6, 0.5 * high, 0.0), v(0.4, high, 1.2))
                })
                .collect();
            (compound(stage, &boxes), 4.0 * rise)
        }
        2 => {
            let boxes = [
                (v(-0.7, 0.9, 0.0), v(0.3, 1.8, 0.5)),
                (v(0.7, 0.9, 0.0), v(0.3, 1.8, 0.5)),
                (v(0.0, 1.95, 0.0), v(1.7, 0.3, 0.5)),
            ];
            (compound(stage, &boxes), 2.1)
        }
        _ => {
            let boxes: Vec<_> = (0..3)
                .map(|i| {
                    let high = dice.in_range(0.1, 0.5);
                    (v(0.5 * i as f32 - 0.5, 0.5 * high, 0.0), v(0.5, high, 0.8))
                })
                .collect();
            (compound(stage, &boxes), 0.5)
        }
    }
}

/// What it walks among, and how high that stands, units.
fn add_things(stage: &mut Stage, dice: &mut Dice) -> f32 {
    let mut highest = 0.0_f32;
    for _ in 0..1 + dice.below(5) {
        let at = Vec3::new(dice.in_range(1.2, 6.0), 0.0, dice.in_range(-2.0, 2.0));
        let kind = [RigidBody::Dynamic, RigidBody::Dynamic, RigidBody::Static][dice.below(3)];
        let (shape, low, high) = if dice.below(2) == 0 {
            let size = Vec3::new(
                dice.in_range(0.3, 1.5),
                dice.in_range(0.1, 1.5),
                dice.in_range(0.3, 1.5),
            );
            (cluster(stage, dice, size), 0.5 * size.y, size.y)
        } else {
            let (shape, high) = furniture(stage, dice);
            (shape, 0.0, high)
        };
        let density = 10.0_f32.powf(dice.in_range(1.5, 3.5));
        let turn = Quat::from_rotation_y(dice.in_range(0.0, 6.3));
        let pose = Pose::new(at + (low + 0.005) * Vec3::Y, turn);
        stage.add(kind, (shape, Density(density)), pose);
        highest = highest.max(high);
    }
    highest
}

/// Pieces of boxes that fall to a heap.
fn add_rubble(stage: &mut Stage, dice: &mut Dice) {
    for i in 0..1 + dice.below(2) {
        let size = dice.vector(0.2, 0.8);
        let at = Vec3::new(
            1.5 + 1.3 * i as f32,
            0.5 * size.y + 0.01,
            dice.in_range(-0.4, 0.4),
        );
        let whole = stage.add_box(RigidBody::Dynamic, size, flat(at));
        let mut pieces = vec![whole];
        for _ in 0..2 + dice.below(2) {
            stage.step();
            for &piece in &pieces {
                let middle = stage.transform_of(piece).translation;
                let plane = Plane::through(middle, dice.direction());
                stage.app.world_mut().commands().slice(piece, plane);
            }
            stage.app.world_mut().flush();
            stage.step();
            let world = stage.app.world_mut();
            let mut all = world.query_filtered::<(Entity, &RigidBody), With<ConvexMesh>>();
            let dynamic = |(entity, kind): (Entity, &RigidBody)| {
                (*kind == RigidBody::Dynamic).then_some(entity)
            };
            pieces = all.iter(world).filter_map(dynamic).collect();
            pieces.sort();
            pieces.truncate(8);
        }
    }
}

/// The fastest dynamic body, units a second.
fn fastest(stage: &Stage) -> f32 {
    let bodies = stage.app.world().resource::<Bodies>();
    let dynamic = bodies
        .iter()
        .filter(|&s| bodies.kind(s) == RigidBody::Dynamic);
    let speeds = dynamic.map(|slot| bodies.velocity(slot).0.length() / stage.unit);
    speeds.fold(0.0, f32::max)
}

/// Whether a walker is more than 0.03 units in what contacts move. Depths that the queries tell are along one way out, of edges too long.
fn is_in_thing(stage: &Stage, walker: Entity) -> bool {
    let dynamic = |_: u32, kind| kind == RigidBody::Dynamic;
    if stage.gap_to(walker, &dynamic) > -0.03 {
        return false;
    }
    let scale = Vec3::new(
        1.0 - 0.03 / RADIUS,
        1.0 - 0.03 / STANDING,
        1.0 - 0.03 / RADIUS,
    );
    let vertices = stage.get::<ConvexMesh>(walker).hull().vertices();
    let smaller: Vec<Vec3> = vertices.iter().map(|&at| scale * at).collect();
    let smaller = ConvexMesh::from_points(&smaller).expect("usable");
    let bodies = stage.app.world().resource::<Bodies>();
    let queries = stage.app.world().resource::<QueryIndex>().queries(bodies);
    let at = stage.transform_of(walker);
    let pose = Pose::new(at.translation, at.rotation);
    let counts = |slot| bodies.kind(slot) == RigidBody::Dynamic;
    let filter = QueryFilter::all().with_predicate(&counts);
    let mut found = Vec::new();
    let asked = queries.overlap_shape(&(&smaller).into(), &pose, &filter, &mut found);
    asked.expect("usable");
    !found.is_empty()
}

/// A character that walks about for some seconds: it gets into nothing, is not launched, and throws nothing about.
fn walk_about(
    stage: &mut Stage,
    dice: &mut Dice,
    walker: Entity,
    (speed, highest): (f32, f32),
) -> Verdict {
    let mut before = stage.place(walker);
    for step in 0..stage.steps(3.0).min(180) {
        if step % (stage.steps(0.5).max(1)) == 0 {
            stage.wish(walker, speed * heading(dice.in_range(-0.9, 0.9)));
        }
        let was_fast = fastest(stage);
        stage.step();
        let (at, gap) = (stage.place(walker), stage.gap(walker));
        let moved = at - before;
        before = at;
        hold!(gap > -1e-3, "step {step}: {gap} inside what stands at {at}");
        hold!(
            !is_in_thing(stage, walker),
            "step {step}: in a thing at {at}"
        );
        hold!(
            at.y > STANDING - 0.02,
            "step {step}: through the floor at {at}"
        );
        // Where a low thing stands before a higher one it may go up both at once.
        hold!(
            moved.y < 2.0 * 0.3 + 0.02 + was_fast * stage.step_dt,
            "step {step}: up by {} at {at}",
            moved.y
        );
        hold!(at.y < STANDING + highest + 0.35, "step {step}: up at {at}");
        let way = moved.with_y(0.0).length();
        // On top of a step it goes as far as it must to stand there.
        let most = (1.2 * speed + was_fast + 0.3) * stage.step_dt + 0.1;
        hold!(
            way < most,
            "step {step}: {way} instead of {most} to {at} by {speed}"
        );
        let fast = fastest(stage);
        hold!(
            fast < was_fast.max(2.0 * speed) + 2.0 + 10.0 * stage.step_dt,
            "step {step}: things are {fast} fast, before {was_fast}, by one of {speed}"
        );
    }
    Ok(())
}

/// Over and among clusters and compounds.
pub(crate) fn judge_structures(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x40000 + seed);
    let mut stage = any_stage(&mut dice);
    add_ground(&mut stage, &mut dice);
    let highest = add_things(&mut stage, &mut dice);
    let walker = stage.add_walker(Vec3::new(-0.5, STANDING + 0.02, 0.0));
    let unit = stage.unit;
    stage.walker(walker).settings.push_force =
        [0.0, 100.0, 500.0, 3e3][dice.below(4)] * unit.powi(3);
    stage.run(0.7);
    let speed = dice.in_range(0.5, 6.0);
    walk_about(&mut stage, &mut dice, walker, (speed, highest + 0.5))
}

/// Over pieces that were just cut.
pub(crate) fn judge_rubble(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x41000 + seed);
    let mut stage = any_stage(&mut dice);
    add_ground(&mut stage, &mut dice);
    add_rubble(&mut stage, &mut dice);
    let walker = stage.add_walker(Vec3::new(-0.5, STANDING + 0.02, 0.0));
    let unit = stage.unit;
    stage.walker(walker).settings.push_force = [0.0, 50.0, 500.0][dice.below(3)] * unit.powi(3);
    stage.run([0.3, 1.2][dice.below(2)]);
    let speed = dice.in_range(0.5, 6.0);
    walk_about(&mut stage, &mut dice, walker, (speed, 1.3))
}

/// What it pushes, without friction, gets no more momentum than its force gives.
pub(crate) fn judge_force(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x42000 + seed);
    let mut stage = any_stage(&mut dice);
    let unit = stage.unit;
    let floor = stage.add_floor();
    let mut world = stage.app.world_mut().entity_mut(floor);
    world.insert(Friction::new(0.0));
    let (shape, low) = match dice.below(3) {
        0 => {
            let size = dice.vector(0.4, 1.2);
            (cluster(&stage, &mut dice, size), 0.5 * size.y)
        }
        1 => (furniture(&stage, &mut dice).0, 0.0),
        _ => {
            let size = dice.vector(0.4, 1.2);
            let whole = [(Vec3::ZERO, size)];
            (compound(&stage, &whole), 0.5 * size.y)
        }
    };
    let density = 10.0_f32.powf(dice.in_range(1.5, 3.5));
    stage.add(
        RigidBody::Dynamic,
        (shape, Density(density), Friction::new(0.0)),
        flat(Vec3::new(1.6, low + 0.002, dice.in_range(-0.3, 0.3))),
    );
    let walker = stage.add_walker(Vec3::new(-0.5, STANDING + 0.02, 0.0));
    let force = unit.powi(4) * [0.0, 20.0, 500.0, 3e3][dice.below(4)];
    stage.walker(walker).settings.push_force = force;
    stage.run(0.6);
    let speed = dice.in_range(0.3, 4.0);
    stage.wish(walker, speed * Vec2::X);
    let mut before = momentum(&stage);
    for step in 0..stage.steps(3.0).min(300) {
        let (count, bumps) = near_things(&stage, walker);
        stage.step();
        let after = momentum(&stage);
        let got = (after.0 - before.0).with_y(0.0).length();
        let mass = after.1;
        before = after;
        let most = force * stage.step_dt * count as f32;
        // What rests trembles.
        let noise = 1e-2 * mass * unit;
        hold!(
            got <= 1.01 * most + noise + 2.0 * mass * bumps,
            "step {step}: {got} instead of {most} N s, {mass} kg, {speed}, at {}",
            stage.place(walker)
        );
    }
    Ok(())
}

/// Momentum of all that contacts move, in the course, N s, and its mass, kg.
fn momentum(stage: &Stage) -> (Vec3, f32) {
    let bodies = stage.app.world().resource::<Bodies>();
    let all = bodies
        .iter()
        .filter(|&s| bodies.kind(s) == RigidBody::Dynamic);
    let (mut sum, mut mass) = (Vec3::ZERO, 0.0);
    for slot in all {
        let own = bodies.mass(slot).mass;
        sum += own * bodies.velocity(slot).0;
        mass += own;
    }
    (stage.world.rotation.inverse() * sum, mass)
}

/// How many things a walker may run into in a step, and how fast one of them comes against it, m/s: to those it is as heavy as a wall.
fn near_things(stage: &Stage, walker: Entity) -> (usize, f32) {
    let bodies = stage.app.world().resource::<Bodies>();
    let queries = stage.app.world().resource::<QueryIndex>().queries(bodies);
    let at = stage.transform_of(walker);
    let shape = stage.get::<ConvexMesh>(walker);
    let counts = |slot| bodies.kind(slot) == RigidBody::Dynamic;
    let filter = QueryFilter::all().with_predicate(&counts);
    let (mut near, pose) = (Vec::new(), Pose::new(at.translation, at.rotation));
    (queries.near_shape(&shape.into(), &pose, 0.3 * stage.unit, &filter, &mut near))
        .expect("usable");
    let mut fastest = 0.0_f32;
    for hit in &near {
        let (linear, angular) = bodies.velocity(hit.body);
        let arm = hit.point - bodies.center_of_mass(hit.body);
        let turning = 1.5 * stage.unit * angular.length();
        let comes = (linear + angular.cross(arm)).dot(hit.normal);
        // Where it touches in the end may be elsewhere on it.
        fastest = fastest.max(comes).max(turning - 0.02 * stage.unit);
    }
    (near.len().max(1), fastest)
}

/// On platforms beneath parents that are moved, turned and scaled it stays where it is.
pub(crate) fn judge_parents(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x43000 + seed);
    let mut stage = any_stage(&mut dice);
    let scale = [1.0, 1.0, 10.0_f32.powf(dice.in_range(-0.5, 0.5))][dice.below(3)];
    let place = dice.vector(-5.0, 5.0);
    let turn = Quat::from_rotation_y(dice.in_range(0.0, 6.3));
    let parent_at = stage
        .transform(Pose::new(place, turn))
        .with_scale(Vec3::splat(scale));
    let parent = stage.app.world_mut().spawn(parent_at).id();
    let middle = if dice.below(2) == 0 {
        parent
    } else {
        let at = Transform::from_translation(stage.unit * dice.vector(-1.0, 1.0));
        stage.app.world_mut().spawn((at, ChildOf(parent))).id()
    };
    // The platform is where the origin of the course is.
    let there = stage.transform(flat(-0.5 * Vec3::Y)).with_scale(Vec3::ONE);
    let local =
        crate::hierarchy::local_beneath(stage.app.world(), Some(middle), there.compute_affine());
    let kind = [
        RigidBody::Kinematic,
        RigidBody::Kinematic,
        RigidBody::Static,
    ][dice.below(3)];
    let size = Vec3::new(12.0, 1.0, 12.0);
    let shape = stage.box_shape(size);
    let platform = (stage.app.world_mut())
        .spawn((kind, shape, local, ChildOf(middle)))
        .id();
    let start = Vec3::new(
        dice.in_range(-3.0, 3.0),
        STANDING + 0.02,
        dice.in_range(-3.0, 3.0),
    );
    let walker = stage.add_walker(start);
    stage.run(0.4);
    let issues = stage.app.world().get::<BodyIssues>(platform);
    hold!(issues.is_none(), "{issues:?}");
    hold!(
        stage.is_on_ground(walker),
        "not on it at {}",
        stage.place(walker)
    );
    let way = [Vec3::ZERO, dice.in_range(0.1, 3.0) * dice.direction()][dice.below(2)];
    let spin = [0.0, dice.in_range(-1.5, 1.5)][dice.below(2)];
    let seen = |stage: &Stage| {
        let on = crate::hierarchy::world_of(stage.app.world(), platform);
        let at = stage.transform_of(walker).translation;
        let (_, rotation, translation) = on.to_scale_rotation_translation();
        (rotation.inverse() * (at - translation)) / stage.unit
    };
    let moves = kind == RigidBody::Kinematic;
    let before = seen(&stage);
    for step in 0..stage.steps(1.5) {
        if moves {
            let step_dt = stage.step_dt;
            let (by, turned) = (
                stage.vector(step_dt * way),
                stage.world.rotation * (step_dt * spin * Vec3::Y),
            );
            let mut entity = stage.app.world_mut().entity_mut(parent);
            let mut transform = entity.get_mut::<Transform>().expect("there");
            transform.translation += by;
            transform.rotation = (Quat::from_scaled_axis(turned) * transform.rotation).normalize();
        }
        stage.step();
        let off = seen(&stage).distance(before);
        hold!(
            off < 2e-3,
            "step {step} of {}: {off} off, {way}, {spin}, scale {scale}, unit {}",
            stage.step_dt,
            stage.unit
        );
        hold!(stage.is_on_ground(walker), "step {step}: off the ground");
        hold!(
            stage.gap(walker) > -1e-3,
            "step {step}: {} in it",
            stage.gap(walker)
        );
    }
    Ok(())
}

/// Where gravity turns, grows and ends, with and without what it takes for up.
pub(crate) fn judge_gravity(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x44000 + seed);
    let mut stage = any_stage(&mut dice);
    // A closed room.
    let half = 3.0;
    for side in 0..6 {
        let mut axis = Vec3::ZERO;
        axis[side / 2] = [1.0, -1.0][side % 2];
        let size = Vec3::splat(2.0 * half + 2.0);
        stage.block(size - axis.abs() * (size.x - 1.0), (half + 0.5) * axis);
    }
    for _ in 0..dice.below(4) {
        let kind = [RigidBody::Static, RigidBody::Dynamic][dice.below(2)];
        let (size, at) = (dice.vector(0.2, 1.0), dice.vector(-2.0, 2.0).with_y(-2.2));
        stage.add_box(kind, size, Pose::new(at, dice.rotation()));
    }
    let walker = stage.add_walker(Vec3::new(0.0, STANDING, 0.0));
    let every = 1 + dice.below(stage.steps(0.7));
    let mut before = stage.place(walker);
    for step in 0..stage.steps(3.0).min(300) {
        if step % every == 0 {
            let strength = [0.0, 1.0, 9.81, 98.1, dice.in_range(0.0, 20.0)][dice.below(5)];
            let down = dice.direction();
            let gravity = stage.vector(strength * down);
            stage.app.insert_resource(Gravity(gravity));
            if dice.below(2) == 0 {
                let up = (stage.world.rotation * -down).normalize();
                stage.walker(walker).settings.up = up;
            }
            let wish = stage.vector(dice.in_range(0.0, 6.0) * dice.direction());
            stage.walker(walker).velocity = wish;
            stage.walker(walker).jump = [0.0, 4.0 * stage.unit][dice.below(2)];
        }
        stage.step();
        let (at, gap) = (stage.place(walker), stage.gap(walker));
        hold!(gap > -2e-3, "step {step}: {gap} in the room at {at}");
        hold!(
            at.abs().max_element() < half,
            "step {step}: out of it at {at}"
        );
        let way = at.distance(before) / stage.step_dt;
        before = at;
        let falls = (2.0 * 98.1 * 2.0 * half * 1.8_f32).sqrt() + 6.0 + 4.0;
        hold!(
            way < falls + 0.35 / stage.step_dt,
            "step {step}: {way} fast at {at}"
        );
    }
    Ok(())
}

/// It walks around a ball whose middle draws it.
pub(crate) fn judge_planet(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x45000 + seed);
    let mut stage = any_stage(&mut dice);
    let radius = dice.in_range(4.0, 30.0);
    let shape = ConvexMesh::sphere(radius * stage.unit).expect("a ball");
    stage.add(RigidBody::Static, shape, flat(-radius * Vec3::Y));
    let walker = stage.add_walker(Vec3::new(0.0, STANDING + 0.02, 0.0));
    let speed = dice.in_range(0.3, 4.0);
    let mut forward = dice.direction();
    let steps = stage.steps(4.0).min(500);
    for step in 0..steps {
        let up = (stage.place(walker) + radius * Vec3::Y).normalize();
        forward = (forward - forward.dot(up) * up).normalize();
        let (world_up, wish) = (stage.world.rotation * up, stage.vector(speed * forward));
        stage
            .app
            .insert_resource(Gravity(-9.81 * stage.unit * world_up));
        let world_up = world_up.normalize();
        let turn = {
            let own = stage.transform_of(walker).rotation * Vec3::Y;
            Quat::from_rotation_arc(own, world_up)
        };
        let mut entity = stage.app.world_mut().entity_mut(walker);
        let mut transform = entity.get_mut::<Transform>().expect("there");
        transform.rotation = (turn * transform.rotation).normalize();
        let mut it = stage.walker(walker);
        it.settings.up = world_up;
        it.velocity = wish;
        stage.step();
        let (at, gap) = (stage.place(walker), stage.gap(walker));
        hold!(gap > -2e-3, "step {step}: {gap} in the ball");
        let high = at.distance(-radius * Vec3::Y) - radius;
        let most = 0.1 + speed * stage.step_dt;
        hold!(
            (high - STANDING).abs() < most,
            "step {step}: {high} high, {speed}, {radius}"
        );
        hold!(
            step < 20 || stage.is_on_ground(walker),
            "step {step}: off the ground, {high} high, {speed} {radius}"
        );
    }
    Ok(())
}

/// A course of things that stand or move by their velocity, at a place, turned, its things in some order: where who walks there gets to.
fn course(seed: u64, world: Pose, is_reversed: bool) -> Vec<Vec3> {
    let mut dice = Dice::new(0x46000 + seed);
    let hertz = [30.0, 60.0, 120.0][dice.below(3)];
    let mut stage = Stage::plain(hertz).moved_to(world, 1.0);
    stage.app.insert_resource(any_effort(&mut dice));
    let mut things = Vec::new();
    for _ in 0..3 + dice.below(6) {
        let at = Vec3::new(dice.in_range(1.0, 7.0), 0.0, dice.in_range(-2.5, 2.5));
        let turn = Quat::from_rotation_y(dice.in_range(0.0, 6.3));
        let size = dice.vector(0.2, 1.2);
        let (shape, low) = match dice.below(3) {
            0 => (furniture(&stage, &mut dice).0, 0.0),
            1 => (cluster(&stage, &mut dice, size), 0.5 * size.y),
            _ => (compound(&stage, &[(Vec3::ZERO, size)]), 0.5 * size.y),
        };
        let moves = dice.below(3) == 0;
        let velocity = 0.5 * heading(dice.in_range(0.0, 6.3));
        things.push((shape, Pose::new(at + low * Vec3::Y, turn), moves, velocity));
    }
    if is_reversed {
        things.reverse();
    }
    stage.add_floor();
    for (shape, pose, moves, velocity) in things {
        let kind = [RigidBody::Static, RigidBody::Kinematic][usize::from(moves)];
        let entity = stage.add(kind, shape, pose);
        if moves {
            stage.set_velocity(entity, Vec3::new(velocity.x, 0.0, velocity.y), Vec3::ZERO);
        }
    }
    let walker = stage.add_walker(Vec3::new(-0.5, STANDING + 0.02, 0.0));
    stage.run(0.2);
    let speed = dice.in_range(0.5, 4.0);
    let mut way = Vec::new();
    for step in 0..stage.steps(2.0) {
        if step % stage.steps(0.5) == 0 {
            stage.wish(walker, speed * heading(dice.in_range(-0.7, 0.7)));
        }
        stage.step();
        way.push(stage.place(walker));
    }
    way
}

/// Two ways that are the same, or part by a foothold: rounding may let one of them take the edge of a step a little earlier.
fn part_little(one: &[Vec3], other: &[Vec3], what: &str) -> Verdict {
    let off = one.iter().zip(other).map(|(a, b)| a.distance(*b));
    let Some((step, off)) = off.enumerate().find(|(_, off)| *off > 0.02) else {
        return Ok(());
    };
    hold!(
        off < 0.2,
        "step {step}: {what} off by {off} at {}",
        one[step]
    );
    Ok(())
}

/// In which order things came does not matter to the bit; far away and turned it gets to the same place.
pub(crate) fn judge_elsewhere(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x47000 + seed);
    let here = course(seed, Pose::IDENTITY, false);
    let reversed = course(seed, Pose::IDENTITY, true);
    hold!(here == reversed, "other places in another order");
    let far = 10.0_f32.powf(dice.in_range(2.0, 3.0));
    let away = course(seed, Pose::from_position(far * dice.direction()), false);
    part_little(&here, &away, &format!("{far} away"))?;
    let turned = course(seed, Pose::new(Vec3::ZERO, dice.rotation()), false);
    part_little(&here, &turned, "turned")
}

/// A view finds what moves once: whoever walks by it, however often, goes as by a view that is new; and one whose index knows older velocities
/// goes as one that does not.
pub(crate) fn judge_views(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x48000 + seed);
    let mut bodies = Bodies::default();
    let normal = Vec3::Y;
    let mut add = |desc: BodyDesc| bodies.insert(desc).expect("usable");
    add(BodyDesc::floor(HalfSpaceShape { normal }));
    let kinds = [
        RigidBody::Kinematic,
        RigidBody::Kinematic,
        RigidBody::Static,
    ];
    let movers: Vec<u32> = (0..4 + dice.below(200))
        .map(|_| {
            let size = dice.vector(0.3, 2.0);
            let shape = ConvexMesh::cuboid(size.x, size.y, size.z).expect("a box");
            let at = dice.vector(-12.0, 12.0).with_y(dice.in_range(-0.5, 1.5));
            let mut desc = BodyDesc::new(kinds[dice.below(3)], Shape::Convex(shape));
            desc.pose.position = at;
            if dice.below(3) == 0 {
                desc.linear_velocity = 10.0_f32.powf(dice.in_range(-2.0, 1.5)) * dice.direction();
                desc.angular_velocity = dice.vector(-3.0, 3.0);
            }
            add(desc)
        })
        .collect();
    let mut report = StepReport::default();
    bevy_cleave::step::mass_properties(&mut bodies, &mut report);
    let mut old = QueryIndex::default();
    old.refresh(&bodies);
    let capsule = ConvexMesh::capsule(RADIUS, 1.0).expect("usable");
    let settings = WalkSettings::default();
    let slider = Slider {
        shape: QueryShape::from(&capsule),
        skin: settings.skin,
    };
    let walk = |queries: Queries, dice: &mut Dice| {
        let mut state = WalkState {
            position: dice.vector(-6.0, 6.0).with_y(0.85),
            ..WalkState::default()
        };
        let input = WalkInput {
            velocity: dice.vector(-4.0, 4.0).with_y(0.0),
            jump: 0.0,
            gravity: 9.81 * Vec3::NEG_Y,
            step_dt: [1.0 / 30.0, 1.0 / 120.0][dice.below(2)],
        };
        let filter = QueryFilter::all();
        let mut pushes = Vec::new();
        queries.walk(
            (&slider, &settings),
            &mut state,
            &input,
            &filter,
            &mut pushes,
        );
        state
    };
    for round in 0..4 {
        for _ in 0..3 {
            let turn = 1 + dice.below(1000) as u64;
            let mut new = QueryIndex::default();
            new.refresh(&bodies);
            let [a, b] =
                [&old, &new].map(|index| walk(index.queries(&bodies), &mut Dice::new(turn)));
            hold!(
                a == b,
                "round {round}: {a:?} by a view that was asked before, {b:?}"
            );
        }
        let slot = movers[dice.below(movers.len())];
        match dice.below(3) {
            0 => {
                let to = 10.0 * dice.direction();
                bodies.set_velocity(slot, to, Vec3::ZERO).expect("finite");
            }
            1 => bodies
                .set_velocity(slot, Vec3::ZERO, Vec3::ZERO)
                .expect("finite"),
            _ => old.refresh(&bodies),
        }
    }
    Ok(())
}

#[test]
fn over_and_among_clusters_and_compounds_it_gets_into_nothing() {
    // A splinter shot off, steps taken slantwise far too far.
    check(|member| judge_structures([5, 56, 329][member as usize]), 3);
    check(judge_structures, 18);
}

#[test]
fn over_pieces_just_cut_it_gets_into_nothing() {
    check(judge_rubble, 10);
}

#[test]
fn what_it_pushes_gets_no_more_than_its_force_gives() {
    // It climbed a low edge, and was set down into it.
    check(|member| judge_force(36 + member), 1);
    check(judge_force, 20);
}

#[test]
fn it_rides_on_what_is_beneath_parents_that_move() {
    check(judge_parents, 30);
}

#[test]
fn where_gravity_changes_it_stays_in_its_room() {
    // In a body that it stood on, and on what had become a wall.
    check(
        |member| judge_gravity([182, 386, 647, 1012][member as usize]),
        4,
    );
    check(judge_gravity, 30);
}

#[test]
fn it_walks_around_a_ball() {
    check(judge_planet, 24);
}

#[test]
fn a_view_that_was_asked_before_answers_as_a_new_one() {
    check(judge_views, 60);
}

#[test]
fn in_another_order_far_away_and_turned_it_goes_the_same_way() {
    check(judge_elsewhere, 10);
}
