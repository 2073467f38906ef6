//! Laws of characters among what moves by itself, among each other, and of whatever is done to them, over random members.
#![expect(
    clippy::disallowed_methods,
    reason = "sizes and slopes of scenes may differ between platforms"
)]

use crate::common::dice::Dice;
use crate::walker_stage::{
    RADIUS, STANDING, Stage, Verdict, add_ground, check, flat, heading, hold,
};
use bevy_cleave::prelude::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::{Quat, Vec2, Vec3};

/// A body that moves by itself, on the ground somewhere.
fn add_thing(stage: &mut Stage, dice: &mut Dice, at: Vec3) -> (Entity, f32) {
    let size = dice.in_range(0.3, 1.0);
    let unit = stage.unit;
    let s = unit * size;
    let (shape, low) = match dice.below(5) {
        0 => (ConvexMesh::sphere(0.5 * s), 0.5 * size),
        1 => (ConvexMesh::cylinder(0.3 * s, s), 0.5 * size),
        2 => (ConvexMesh::cuboid(2.0 * s, 0.3 * s, 0.3 * s), 0.15 * size),
        3 => (ConvexMesh::capsule(0.2 * s, 0.8 * s), 0.6 * size),
        _ => (ConvexMesh::cuboid(s, s, s), 0.5 * size),
    };
    let shape = shape.expect("usable");
    let density = 10.0_f32.powf(dice.in_range(0.5, 3.5));
    let pose = Pose::new(
        at + low * Vec3::Y,
        Quat::from_rotation_y(dice.in_range(0.0, 6.0)),
    );
    (
        stage.add(RigidBody::Dynamic, (shape, Density(density)), pose),
        size,
    )
}

/// What it pushes gets no more than the rule says, is not thrown about, and stays out of it.
fn judge_push(seed: u64) -> Verdict {
    let mut dice = Dice::new(0xa000 + seed);
    let mut stage = Stage::plain([30.0, 60.0, 120.0][dice.below(3)]);
    add_ground(&mut stage, &mut dice);
    let count = 1 + dice.below(6);
    let things: Vec<Entity> = (0..count)
        .map(|_| {
            let at = Vec3::new(dice.in_range(0.8, 6.0), 0.0, dice.in_range(-1.5, 1.5));
            add_thing(&mut stage, &mut dice, at).0
        })
        .collect();
    let walker = stage.add_walker(Vec3::new(-2.0, STANDING + 0.02, 0.0));
    stage.walker(walker).settings.push_force = [0.0, 20.0, 500.0, 1e5][dice.below(4)];
    stage.run(1.5);
    let speed = dice.in_range(0.5, 6.0);
    let force = stage.walker(walker).settings.push_force;
    let most_rise = |stage: &Stage| {
        things
            .iter()
            .map(|&it| stage.place(it).y)
            .fold(0.0, f32::max)
    };
    let high = most_rise(&stage);
    for step in 0..stage.steps(5.0 / speed) {
        if step % 20 == 0 {
            stage.wish(walker, speed * heading(dice.in_range(-0.7, 0.7)));
        }
        let before: Vec<Vec3> = things
            .iter()
            .map(|&it| stage.get::<LinearVelocity>(it).0)
            .collect();
        stage.step();
        let (at, gap) = (stage.place(walker), stage.gap(walker));
        hold!(gap > -1e-3, "step {step}: {gap} inside at {at}");
        hold!(at.y < 0.4 + STANDING + 1.0, "step {step}: up at {at}");
        for (i, &thing) in things.iter().enumerate() {
            let v = stage.get::<LinearVelocity>(thing).0;
            let flatly = v.with_y(0.0).length();
            // 1.6 times as fast was the fastest thing of 400 scenes; why is not traced.
            hold!(
                flatly < 2.0 * speed + 0.3,
                "step {step}: thing {i} at {v} by one of {speed}, force {force}, before {}",
                before[i]
            );
        }
        let rise = most_rise(&stage) - high;
        hold!(rise < 0.7, "step {step}: a thing rises by {rise}");
        let inside = stage.gap_to(walker, &|_, kind| kind == RigidBody::Dynamic);
        hold!(
            inside > -0.03,
            "step {step}: {inside} in a thing at {at}, {speed}, {force}"
        );
    }
    Ok(())
}

/// What falls on it or hits it moves it a little at most, and never into what stands.
fn judge_hit(seed: u64) -> Verdict {
    let mut dice = Dice::new(0xb000 + seed);
    let mut stage = Stage::plain([30.0, 60.0, 120.0][dice.below(3)]);
    add_ground(&mut stage, &mut dice);
    let walker = stage.add_walker(Vec3::new(0.0, STANDING + 0.02, 0.0));
    stage.run(0.3);
    let before = stage.place(walker);
    for _ in 0..1 + dice.below(8) {
        let is_shot = dice.below(2) == 0;
        let from = if is_shot {
            3.0 * heading(dice.in_range(0.0, 6.3))
        } else {
            dice.in_range(0.0, 0.4) * heading(dice.in_range(0.0, 6.3))
        };
        let at = Vec3::new(
            from.x,
            if is_shot {
                dice.in_range(0.2, 1.5)
            } else {
                dice.in_range(2.5, 6.0)
            },
            from.y,
        );
        let (thing, _) = add_thing(&mut stage, &mut dice, at);
        if is_shot {
            let to = dice.in_range(1.0, 60.0) * (stage.place(walker) - at).normalize();
            stage.set_velocity(thing, to, Vec3::ZERO);
        }
    }
    for step in 0..stage.steps(3.0) {
        stage.step();
        let (at, gap) = (stage.place(walker), stage.gap(walker));
        hold!(gap > -1e-3, "step {step}: {gap} in the ground at {at}");
        let off = at.distance(before);
        hold!(off < 0.05, "step {step}: moved by {off} to {at}");
        hold!(
            stage.is_on_ground(walker),
            "step {step}: off the ground at {at}"
        );
    }
    // And it can walk away.
    let to = heading(dice.in_range(0.0, 6.3));
    stage.wish(walker, 2.0 * to);
    stage.walker(walker).settings.push_force = 1e4;
    let mut farthest = 0.0_f32;
    for _ in 0..stage.steps(3.0) {
        stage.step();
        farthest = farthest.max(stage.place(walker).distance(before));
        hold!(
            stage.gap(walker) > -1e-3,
            "{} in the ground on its way",
            stage.gap(walker)
        );
    }
    hold!(farthest > 0.5, "only {farthest} away");
    Ok(())
}

/// Walkers that meet stop at each other, and do not change sides.
fn judge_meeting(seed: u64) -> Verdict {
    let mut dice = Dice::new(0xc000 + seed);
    let mut stage = Stage::any(&mut dice);
    add_ground(&mut stage, &mut dice);
    let speed = 10.0_f32.powf(dice.in_range(-0.3, 1.5));
    let count = 2 + dice.below(5);
    let is_lane = dice.below(2) == 0;
    let half = if is_lane { RADIUS + 0.03 } else { 4.0 };
    for side in [-1.0, 1.0] {
        stage.block(
            Vec3::new(40.0, 4.0, 0.2),
            Vec3::new(0.0, 2.0, side * (half + 0.1)),
        );
    }
    let walkers: Vec<Entity> = (0..count)
        .map(|i| {
            let z = if is_lane {
                0.0
            } else {
                dice.in_range(-1.0, 1.0)
            };
            stage.add_walker(Vec3::new(1.5 * i as f32, STANDING + 0.02, z))
        })
        .collect();
    stage.run(0.2);
    for step in 0..stage.steps(2.0).min(200) {
        if step % 15 == 0 {
            for (i, &walker) in walkers.iter().enumerate() {
                let to = if is_lane {
                    0.0
                } else {
                    dice.in_range(-0.5, 0.5)
                };
                let toward = if 2 * i < count { 1.0 } else { -1.0 };
                let share = dice.in_range(0.2, 1.0);
                stage.wish(walker, toward * share * speed * heading(to));
            }
        }
        stage.step();
        for (i, &walker) in walkers.iter().enumerate() {
            let gap = stage.gap(walker);
            hold!(
                gap > -2e-3,
                "step {step}: {gap} in another, {speed}, {}",
                stage.place(walker)
            );
            let before = i.checked_sub(1).map(|i| stage.place(walkers[i]).x);
            let mine = stage.place(walker).x;
            hold!(
                !is_lane || before.is_none_or(|x| x < mine),
                "step {step}: {i} changed sides, {speed}"
            );
            hold!(
                stage.place(walker).y < STANDING + 0.1,
                "step {step}: {i} climbs another to {}",
                stage.place(walker)
            );
        }
    }
    Ok(())
}

/// A door that swings lets it through, and is not torn out or thrown about.
fn judge_door(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x19000 + seed);
    let mut stage = Stage::plain([60.0, 120.0][dice.below(2)]);
    stage.add_floor();
    let post = stage.block(Vec3::new(0.2, 2.4, 0.2), Vec3::new(0.0, 1.2, -0.75));
    let shape = stage.box_shape(Vec3::new(0.06, 2.2, 1.2));
    let density = 10.0_f32.powf(dice.in_range(1.0, 2.7));
    let door = stage.add(
        RigidBody::Dynamic,
        (shape, Density(density)),
        flat(Vec3::new(0.0, 1.2, 0.0)),
    );
    let joint = Joint::hinge()
        .with_anchors(Vec3::new(0.0, 0.0, 0.1), Vec3::new(0.0, 0.0, -0.65))
        .with_axes(Vec3::Y, Vec3::Y);
    stage.app.world_mut().commands().join(post, door, joint);
    stage.app.world_mut().flush();
    let walker = stage.add_walker(Vec3::new(-1.5, STANDING + 0.02, dice.in_range(0.0, 0.5)));
    stage.run(0.5);
    let speed = dice.in_range(0.5, 4.0);
    stage.wish(walker, speed * Vec2::X);
    for step in 0..stage.steps(5.0 / speed) {
        stage.step();
        let at = stage.place(door);
        let apart = at.distance(Vec3::new(0.0, 1.2, -0.65));
        hold!(
            (apart - 0.65).abs() < 0.05,
            "step {step}: door at {at}, {speed}, {density}"
        );
        let spin = stage.get::<AngularVelocity>(door).0.length();
        hold!(
            spin < 4.0 * speed / 0.3 + 2.0,
            "step {step}: door spins by {spin}, {speed}, {density}"
        );
        let inside = stage.gap_to(walker, &|_, kind| kind == RigidBody::Dynamic);
        hold!(
            inside > -0.03,
            "step {step}: {inside} in the door, {speed}, {density}"
        );
    }
    let at = stage.place(walker);
    hold!(at.x > 0.5, "not through at {at}, {speed}, {density}");
    Ok(())
}

/// In which order entities came changes nothing of who does not meet.
fn judge_order(seed: u64) -> Verdict {
    let run = |is_reversed: bool| {
        let mut dice = Dice::new(0xf000 + seed);
        let mut stage = Stage::plain(60.0);
        let mut things: Vec<(Vec3, u64)> = (0..8)
            .map(|i| {
                (
                    Vec3::new(6.0 * i as f32 - 20.0, 0.0, 0.0),
                    dice.below(1000) as u64,
                )
            })
            .collect();
        if is_reversed {
            things.reverse();
        }
        let normal = Vec3::Y;
        stage.add(RigidBody::Static, HalfSpaceShape { normal }, Pose::IDENTITY);
        let mut walkers = Vec::new();
        for (at, seed) in &things {
            let mut dice = Dice::new(*seed);
            stage.block(Vec3::new(0.5, 2.0, 3.0), *at + Vec3::new(1.5, 1.0, 0.0));
            let _ = add_thing(&mut stage, &mut dice, *at + Vec3::new(0.0, 0.0, 1.2));
            let walker = stage.add_walker(*at + Vec3::new(0.0, STANDING + 0.02, 0.0));
            walkers.push((
                walker,
                dice.in_range(0.3, 1.0) * heading(dice.in_range(0.0, 6.3)),
            ));
        }
        stage.run(0.2);
        for (walker, wish) in &walkers {
            stage.wish(*walker, *wish);
        }
        stage.run(1.0);
        let mut places: Vec<[u32; 3]> = walkers
            .iter()
            .map(|(walker, _)| {
                stage
                    .transform_of(*walker)
                    .translation
                    .to_array()
                    .map(f32::to_bits)
            })
            .collect();
        if is_reversed {
            places.reverse();
        }
        places
    };
    let (one, other) = (run(false), run(true));
    let differ = one.iter().zip(&other).filter(|(a, b)| a != b).count();
    hold!(differ == 0, "{differ} of {} differ", one.len());
    Ok(())
}

/// Bodies far from a walker keep their bits.
fn judge_far(seed: u64) -> Verdict {
    let run = |walks: bool| {
        let mut dice = Dice::new(0x11000 + seed);
        let mut stage = Stage::plain(60.0);
        stage.add(
            RigidBody::Static,
            HalfSpaceShape { normal: Vec3::Y },
            Pose::IDENTITY,
        );
        let things: Vec<Entity> = (0..6)
            .map(|_| {
                let at = Vec3::new(
                    dice.in_range(-1.0, 1.0),
                    dice.in_range(0.5, 3.0),
                    dice.in_range(-1.0, 1.0),
                );
                add_thing(&mut stage, &mut dice, at).0
            })
            .collect();
        let wish = dice.in_range(0.0, 5.0) * heading(dice.in_range(0.0, 6.3));
        if walks {
            let walker = stage.add_walker(Vec3::new(60.0, STANDING + 0.02, 0.0));
            stage.wish(walker, wish);
        }
        stage.run(1.0);
        things
            .iter()
            .map(|&it| (stage.transform_of(it), stage.get::<LinearVelocity>(it).0))
            .collect::<Vec<_>>()
    };
    hold!(run(false) == run(true), "bodies far away go other ways");
    Ok(())
}

/// Whatever is done to it: it keeps numbers, and says what it cannot do as long as it cannot.
fn judge_chaos(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x12000 + seed);
    let mut stage = Stage::plain(60.0);
    stage.add_floor();
    let mut other = stage.block(Vec3::new(3.0, 0.2, 3.0), Vec3::new(0.0, 0.1, 0.0));
    for i in 0..4 {
        let at = Vec3::new(dice.in_range(-3.0, 3.0), i as f32, dice.in_range(-3.0, 3.0));
        let _ = add_thing(&mut stage, &mut dice, at);
    }
    let walker = stage.add_walker(Vec3::new(0.0, STANDING + 0.3, 0.0));
    stage.run(0.3);
    let mut is_disabled = false;
    for step in 0..120 {
        let bad = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            1e30,
            -1e30,
            1e20,
        ][dice.below(6)];
        match dice.below(14) {
            0 => stage.walker(walker).velocity = Vec3::new(bad, 0.0, 1.0),
            1 => stage.walker(walker).jump = [bad, 3.0, -1.0][dice.below(3)],
            2 => stage.walker(walker).settings.skin = [bad, 0.01, 0.0, -1.0][dice.below(4)],
            3 => stage.walker(walker).settings.step_height = [bad, 0.3, 0.0][dice.below(3)],
            4 => {
                stage.walker(walker).settings.up =
                    [Vec3::Y, Vec3::X, Vec3::ZERO, Vec3::splat(bad)][dice.below(4)]
            }
            5 => {
                let at = dice.vector(-4.0, 4.0);
                let mut entity = stage.app.world_mut().entity_mut(walker);
                entity.get_mut::<Transform>().expect("there").translation = at;
            }
            6 => {
                let mut entity = stage.app.world_mut().entity_mut(walker);
                if is_disabled {
                    entity.remove::<Disabled>();
                } else {
                    entity.insert(Disabled);
                }
                is_disabled = !is_disabled;
            }
            7 => {
                stage.app.world_mut().despawn(other);
                other = stage.block(dice.vector(0.2, 3.0), dice.vector(-2.0, 2.0));
            }
            8 => {
                let at = Vec3::new(dice.in_range(-3.0, 3.0), 4.0, dice.in_range(-3.0, 3.0));
                let _ = add_thing(&mut stage, &mut dice, at);
            }
            9 => stage.wish(
                walker,
                dice.in_range(0.0, 40.0) * heading(dice.in_range(0.0, 6.3)),
            ),
            10 => stage.walker(walker).settings = WalkSettings::default(),
            11 => {
                let scale = [1.0, 0.5, 2.0, -1.0, 0.0][dice.below(5)];
                let mut entity = stage.app.world_mut().entity_mut(walker);
                entity.get_mut::<Transform>().expect("there").scale = Vec3::splat(scale);
            }
            12 => stage.walker(walker).settings.push_force = [bad, 500.0, -1.0][dice.below(3)],
            _ => stage.walker(walker).velocity = Vec3::X,
        }
        stage.step();
        let at = stage.transform_of(walker);
        hold!(
            at.translation.is_finite() && at.rotation.is_normalized(),
            "step {step}: {at:?}"
        );
        let walking = stage.get::<Walking>(walker);
        hold!(walking.velocity.is_finite(), "step {step}: {walking:?}");
        let of = *stage.get::<Walker>(walker);
        let is_bad = !of.velocity.is_finite() || !of.jump.is_finite() || !of.settings.is_usable();
        let says = stage
            .app
            .world()
            .get::<BodyIssues>(walker)
            .is_some_and(|issues| issues.iter().any(|it| matches!(it, BodyProblem::Walker(_))));
        hold!(
            is_disabled || is_bad == says,
            "step {step}: is bad {is_bad}, and says so {says}: {of:?}"
        );
    }
    Ok(())
}

/// What moves far away changes no bit of a character among what moves near it: few are looked at one by one, of many those near alone.
fn judge_many_movers(seed: u64) -> Verdict {
    let run = |far: usize| {
        let mut dice = Dice::new(0xe000 + seed);
        let mut stage = Stage::plain([30.0, 60.0, 120.0][dice.below(3)]);
        add_ground(&mut stage, &mut dice);
        let walker = stage.add_walker(Vec3::new(0.0, STANDING + 0.02, 0.0));
        stage.run(0.2);
        for _ in 0..3 + dice.below(6) {
            let speed = 10.0_f32.powf(dice.in_range(-1.0, 1.7));
            add_mover(&mut stage, &mut dice, Vec3::ZERO, speed);
        }
        let wish = dice.in_range(0.0, 5.0) * heading(dice.in_range(0.0, 6.3));
        stage.wish(walker, wish);
        for _ in 0..far {
            let speed = 10.0_f32.powf(dice.in_range(-3.0, 1.0));
            add_mover(&mut stage, &mut dice, 1e3 * Vec3::X, speed);
        }
        let mut way = Vec::new();
        for _ in 0..stage.steps(2.0) {
            stage.step();
            let at = stage.transform_of(walker);
            way.push((at.translation.to_array(), at.rotation.to_array()));
        }
        way
    };
    let (few, many) = (run(0), run(150));
    match few.iter().zip(&many).position(|(few, many)| few != many) {
        None => Ok(()),
        Some(step) => Err(format!(
            "step {step}: {:?} instead of {:?}",
            many[step], few[step]
        )),
    }
}

/// A kinematic bar that comes past a place, or turns there.
fn add_mover(stage: &mut Stage, dice: &mut Dice, near: Vec3, speed: f32) {
    let size = dice.vector(0.2, 2.0) * Vec3::new(dice.in_range(1.0, 4.0), 1.0, 1.0);
    let way = heading(dice.in_range(0.0, 6.3));
    let way = Vec3::new(way.x, 0.0, way.y);
    // It is there within a second.
    let at = near - speed * dice.in_range(0.0, 1.0) * way + dice.vector(-3.0, 3.0).with_y(1.0);
    let bar = stage.add_box(RigidBody::Kinematic, size, flat(at));
    let turn = dice.in_range(-10.0, 10.0) * [Vec3::ZERO, Vec3::Y][dice.below(2)];
    stage.set_velocity(bar, speed * way, turn);
}

#[test]
fn what_moves_far_away_changes_no_bit() {
    check(judge_many_movers, 30);
}

#[test]
fn what_it_pushes_is_not_thrown_about() {
    check(judge_push, 60);
}

#[test]
fn what_falls_on_it_or_hits_it_does_not_move_it() {
    check(judge_hit, 40);
}

#[test]
fn those_that_meet_do_not_change_sides() {
    check(judge_meeting, 50);
}

#[test]
fn doors_let_it_through() {
    check(judge_door, 60);
}

#[test]
fn in_which_order_they_came_changes_nothing() {
    check(judge_order, 12);
}

#[test]
fn bodies_far_from_it_keep_their_bits() {
    check(judge_far, 15);
}

#[test]
fn whatever_is_done_to_it_it_keeps_numbers_and_says_what_it_cannot_do() {
    check(judge_chaos, 30);
}
