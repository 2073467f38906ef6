//! Laws of characters on what moves and against it, over random members.
#![expect(
    clippy::disallowed_methods,
    reason = "sizes and slopes of scenes may differ between platforms"
)]

use crate::common::dice::Dice;
use crate::walker_stage::{
    RADIUS, SKIN, STANDING, Stage, Verdict, add_ground, check, flat, heading, hold,
};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::{Quat, Vec2, Vec3};

/// How a platform moves: by its velocity, or by its `Transform`; steadily or to and fro.
#[derive(Clone, Copy, Debug)]
struct Motion {
    by_pose: bool,
    swings: bool,
    linear: Vec3,
    angular: Vec3,
    rate: f32,
}

impl Motion {
    fn any(dice: &mut Dice) -> Self {
        let speed = 10.0_f32.powf(dice.in_range(-1.0, 0.7));
        let mut linear = speed * dice.direction();
        if dice.below(3) == 0 {
            linear = linear.y * Vec3::Y;
        }
        Self {
            by_pose: dice.below(2) == 0,
            swings: dice.below(2) == 0,
            linear: [linear, linear, Vec3::ZERO][dice.below(3)],
            angular: [0.0, 0.0, dice.in_range(-2.0, 2.0)][dice.below(3)] * Vec3::Y,
            rate: dice.in_range(0.5, 4.0),
        }
    }

    /// Share of the velocity at a time.
    fn share(&self, time: f32) -> f32 {
        if self.swings {
            (self.rate * time).cos()
        } else {
            1.0
        }
    }

    /// Lets an entity move so in the next step.
    fn apply(&self, stage: &mut Stage, entity: Entity, time: f32) {
        let share = self.share(time);
        if !self.by_pose {
            return stage.set_velocity(entity, share * self.linear, share * self.angular);
        }
        let dt = stage.step_dt;
        let (way, turn) = (
            stage.vector(dt * share * self.linear),
            stage.world.rotation * (dt * share * self.angular),
        );
        let mut world = stage.app.world_mut().entity_mut(entity);
        let mut transform = world.get_mut::<Transform>().expect("there");
        transform.translation += way;
        transform.rotation = (Quat::from_scaled_axis(turn) * transform.rotation).normalize();
    }
}

/// It stays where it is on a platform, and walks there as on what stands.
fn judge_ride(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x6000 + seed);
    let mut stage = Stage::any(&mut dice);
    let size = Vec3::new(16.0, 1.0, 16.0);
    let platform = stage.add_box(RigidBody::Kinematic, size, flat(Vec3::new(0.0, -0.5, 0.0)));
    let at = Vec3::new(
        dice.in_range(-3.0, 3.0),
        STANDING + 0.02,
        dice.in_range(-3.0, 3.0),
    );
    let walker = stage.add_walker(at);
    stage.run(0.3);
    let motion = Motion::any(&mut dice);
    let walks = dice.below(3) == 0;
    let wish = [0.0, 1.0][walks as usize] * heading(dice.in_range(0.0, 6.3));
    let local = |stage: &Stage| stage.seen_from(platform, stage.transform_of(walker).translation);
    let start = local(&stage);
    let (mut time, mut expected) = (0.0, start);
    for step in 0..stage.steps(2.0) {
        motion.apply(&mut stage, platform, time);
        stage.wish(walker, wish);
        stage.step();
        time += stage.step_dt;
        let turn = stage.transform_of(platform).rotation.inverse() * stage.world.rotation;
        expected += turn * (stage.step_dt * Vec3::new(wish.x, 0.0, wish.y));
        let off = local(&stage).distance(expected);
        let most = if walks { 2e-2 } else { 1e-3 };
        hold!(
            off < most,
            "step {step} of {}: {off} off, walks {walks}, {motion:?}",
            stage.step_dt
        );
        hold!(
            stage.is_on_ground(walker),
            "step {step}: off the ground, {motion:?}"
        );
    }
    Ok(())
}

/// Who jumps on what moves steadily comes down where it jumped, and keeps its motion where it jumps off.
fn judge_jump(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x7000 + seed);
    let mut stage = Stage::any(&mut dice);
    let size = Vec3::new(30.0, 1.0, 30.0);
    let platform = stage.add_box(RigidBody::Kinematic, size, flat(Vec3::new(0.0, -0.5, 0.0)));
    let walker = stage.add_walker(STANDING * Vec3::Y + 0.02 * Vec3::Y);
    stage.run(0.3);
    let motion = Motion {
        swings: false,
        angular: Vec3::ZERO,
        ..Motion::any(&mut dice)
    };
    let wish = [0.0, dice.in_range(0.0, 3.0)][dice.below(2)] * heading(dice.in_range(0.0, 6.3));
    let local = |stage: &Stage| stage.seen_from(platform, stage.transform_of(walker).translation);
    let stops = dice.below(3) == 0;
    let mut time = 0.0;
    let mut go = |stage: &mut Stage, moves: bool| {
        if moves {
            motion.apply(stage, platform, time);
        } else {
            stage.set_velocity(platform, Vec3::ZERO, Vec3::ZERO);
        }
        stage.step();
        time += stage.step_dt;
    };
    for _ in 0..5 {
        go(&mut stage, true);
    }
    stage.wish(walker, wish);
    let (start, from) = (local(&stage), stage.place(walker));
    let jump = dice.in_range(2.0, 6.0);
    let speed = jump * stage.unit;
    stage.walker(walker).jump = speed;
    let mut steps = 0;
    let mut highest = 0.0_f32;
    loop {
        // The step in which it jumps moves as those before.
        go(&mut stage, !stops || steps == 0);
        steps += 1;
        highest = highest.max(stage.place(walker).y - from.y);
        if stage.is_on_ground(walker) && steps > 2 {
            break;
        }
        hold!(steps < 2000, "never lands");
    }
    let secs = stage.step_dt * steps as f32;
    let by_wish = secs * Vec3::new(wish.x, 0.0, wish.y);
    let lateral = Vec3::new(motion.linear.x, 0.0, motion.linear.z);
    if stops {
        let off = (stage.place(walker) - from - by_wish - secs * lateral)
            .with_y(0.0)
            .length();
        hold!(
            off < 0.02 * (1.0 + lateral.length() * secs),
            "{off} off where it should be with its own motion, {motion:?}"
        );
    } else {
        let off = (local(&stage) - start - by_wish).with_y(0.0).length();
        hold!(
            off < 0.02,
            "{off} off on the platform after {secs} s, {motion:?}"
        );
        let rises = jump + motion.linear.y;
        let expected = 0.5 * rises * rises.max(0.0) / 9.81;
        hold!(
            (highest - expected).abs() < 0.02 + 0.03 * expected + 0.6 * stage.step_dt * rises.abs(),
            "{highest} high, not {expected}, {motion:?}"
        );
    }
    Ok(())
}

/// What moves against it takes it along, and never passes it; nor does that push it through what stands.
fn judge_moving_wall(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x8000 + seed);
    let mut stage = Stage::any(&mut dice);
    add_ground(&mut stage, &mut dice);
    let speed = 10.0_f32.powf(dice.in_range(-0.5, 1.5));
    let thick = [0.05, 0.3, 2.0][dice.below(3)];
    let turn = Quat::from_rotation_y(dice.in_range(-0.3, 0.3))
        * Quat::from_rotation_z(dice.in_range(-0.2, 0.2));
    let at = Vec3::new(-1.5 - 0.5 * thick, 1.5, 0.0);
    let wall = stage.add_box(
        RigidBody::Kinematic,
        Vec3::new(thick, 4.0, 30.0),
        Pose::new(at, turn),
    );
    let walker = stage.add_walker(Vec3::new(0.0, STANDING + 0.02, 0.0));
    stage.run(0.2);
    let by_pose = dice.below(2) == 0 && speed * stage.step_dt < 2.0;
    let motion = Motion {
        by_pose,
        swings: false,
        linear: speed * Vec3::X,
        angular: Vec3::ZERO,
        rate: 1.0,
    };
    let wish = [0.0, dice.in_range(0.0, 5.0)][dice.below(2)] * heading(dice.in_range(0.0, 6.3));
    stage.wish(walker, wish);
    let normal = turn * Vec3::X;
    for step in 0..stage.steps(10.0 / speed).min(600) {
        motion.apply(&mut stage, wall, 0.0);
        stage.step();
        let (at, gap) = (stage.place(walker), stage.gap(walker));
        let ahead = (at - stage.place(wall)).dot(normal) - 0.5 * thick;
        if at.z.abs() > 12.0 || at.x > 35.0 || at.x.abs().max(at.z.abs()) > 35.0 {
            break;
        }
        hold!(
            ahead > 0.0,
            "step {step}: behind the wall by {ahead}, {speed}, {thick}, {by_pose}"
        );
        hold!(
            gap > -2e-3,
            "step {step}: {gap} inside, {speed}, {thick}, {by_pose}"
        );
    }
    Ok(())
}

/// Between a lift and a ceiling, or a wall and another, it stays between them, and walks on when it is free.
fn judge_crushed(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x9000 + seed);
    let mut stage = Stage::any(&mut dice);
    let is_lift = dice.below(2) == 0;
    let speed = dice.in_range(0.2, 4.0);
    let thin = [0.02, 0.3][dice.below(2)];
    let (axis, half) = if is_lift {
        (Vec3::Y, STANDING)
    } else {
        (Vec3::X, RADIUS)
    };
    let size = |thick: f32| {
        if is_lift {
            Vec3::new(6.0, thick, 6.0)
        } else {
            Vec3::new(thick, 6.0, 6.0)
        }
    };
    if !is_lift {
        stage.add_floor();
    }
    let middle = if is_lift {
        Vec3::ZERO
    } else {
        (STANDING + 0.02) * Vec3::Y
    };
    let place =
        |along: f32, thick: f32| middle.with_y(0.0) + axis * (along + 0.5 * thick * along.signum());
    let (thick, reach) = (dice.in_range(0.1, 1.0), half + 0.05);
    let mover = stage.add_box(
        RigidBody::Kinematic,
        size(thick),
        flat(place(-reach, thick)),
    );
    let ends = half + dice.in_range(0.1, 1.0);
    if dice.below(2) == 0 {
        stage.block(size(thin), place(ends, thin));
    } else {
        let c = [(-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0)];
        let corners = c.map(|(a, b)| {
            if is_lift {
                Vec3::new(a, ends, b)
            } else {
                Vec3::new(ends, a, b)
            }
        });
        let triangles = if is_lift {
            [[0, 1, 2], [0, 2, 3]]
        } else {
            [[0, 2, 1], [0, 3, 2]]
        };
        stage.add_level(&corners, &triangles, dice.below(2) == 0);
    }
    let walker = stage.add_walker(middle);
    stage.run(0.2);
    let goes = (ends + reach) - half * dice.in_range(1.2, 1.9);
    let steps = stage.steps(goes / speed);
    for step in 0..2 * steps {
        let there = step < steps;
        stage.set_velocity(mover, if there { speed } else { -speed } * axis, Vec3::ZERO);
        stage.step();
        let (at, from) = (stage.place(walker), stage.place(mover));
        let (mine, its) = (axis.dot(at), axis.dot(from) + 0.5 * thick);
        hold!(
            mine > its - 0.01 && mine < ends + 0.01,
            "step {step} of {steps}: at {mine}, between {its} and {ends}, lift {is_lift}"
        );
    }
    stage.set_velocity(mover, Vec3::ZERO, Vec3::ZERO);
    stage.run(1.0);
    let (before, gap) = (stage.place(walker), stage.gap(walker));
    hold!(gap > -1e-3, "{gap} inside when it is over");
    hold!(stage.is_on_ground(walker), "off the ground when it is over");
    stage.wish(walker, Vec2::new(0.0, 1.0));
    stage.run(0.5);
    let made = stage.place(walker).distance(before);
    hold!((made - 0.5).abs() < 0.05, "goes {made} when it is over");
    Ok(())
}

/// It stays on what tilts as long as that is not too steep, and out of it.
fn judge_tilt(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x16000 + seed);
    let mut stage = Stage::any(&mut dice);
    let platform = stage.add_box(
        RigidBody::Kinematic,
        Vec3::new(10.0, 1.0, 10.0),
        flat(Vec3::new(0.0, -0.5, 0.0)),
    );
    let at = Vec3::new(
        dice.in_range(-2.0, 2.0),
        STANDING + 0.02,
        dice.in_range(-2.0, 2.0),
    );
    let walker = stage.add_walker(at);
    stage.run(0.3);
    let axis = heading(dice.in_range(0.0, 6.3));
    let most = dice.in_range(0.1, 0.6);
    let rate = dice.in_range(0.5, 3.0);
    let by_pose = dice.below(2) == 0;
    let motion = Motion {
        by_pose,
        swings: true,
        linear: Vec3::ZERO,
        angular: most * rate * Vec3::new(axis.x, 0.0, axis.y),
        rate,
    };
    let local = |stage: &Stage| stage.seen_from(platform, stage.transform_of(walker).translation);
    let start = local(&stage);
    let mut time = 0.0;
    for step in 0..stage.steps(3.0) {
        motion.apply(&mut stage, platform, time);
        stage.step();
        time += stage.step_dt;
        let gap = stage.gap(walker);
        hold!(
            (-1e-3..0.05).contains(&gap),
            "step {step}: {gap} over what tilts, {motion:?}"
        );
        hold!(
            stage.is_on_ground(walker),
            "step {step}: off the ground, {motion:?}"
        );
        let off = (local(&stage) - start).with_y(0.0).length();
        // Upright as it is, its middle is somewhere else over what is tilted.
        hold!(
            off < STANDING * most + 0.1,
            "step {step}: {off} off, {motion:?}"
        );
    }
    Ok(())
}

/// On what moves it is among things that move by themselves as on what stands.
fn judge_company(seed: u64) -> Verdict {
    let run = |moves: bool| {
        let mut dice = Dice::new(0x17000 + seed);
        let mut stage = Stage::plain([60.0, 120.0][dice.below(2)]);
        let platform = stage.add_box(
            RigidBody::Kinematic,
            Vec3::new(30.0, 1.0, 30.0),
            flat(Vec3::new(0.0, -0.5, 0.0)),
        );
        let size = dice.in_range(0.6, 1.2);
        let shape = stage.box_shape(Vec3::splat(size));
        let density = 10.0_f32.powf(dice.in_range(1.0, 3.3));
        let thing = stage.add(
            RigidBody::Dynamic,
            (shape, Density(density)),
            flat(Vec3::new(
                RADIUS + SKIN + 0.5 * size + 0.002,
                0.5 * size,
                0.0,
            )),
        );
        let walker = stage.add_walker(Vec3::new(0.0, STANDING + 0.02, 0.0));
        let linear = dice.in_range(0.5, 2.0)
            * Vec3::new(dice.in_range(-1.0, 1.0), 0.0, dice.in_range(-1.0, 1.0));
        let rise = [0.0, dice.in_range(-2.0, 2.0)][dice.below(2)] * Vec3::Y;
        let walks = dice.below(2) == 0;
        // Slowly, so that the thing does not slip.
        let steps = stage.steps(2.0);
        for step in 0..steps {
            let share = if moves {
                (2.0 * step as f32 / steps as f32).min(1.0)
            } else {
                0.0
            };
            stage.set_velocity(platform, share * (linear + rise), Vec3::ZERO);
            stage.step();
        }
        let local = |stage: &Stage, entity| {
            stage.seen_from(platform, stage.transform_of(entity).translation)
        };
        let before = local(&stage, walker);
        if walks {
            stage.wish(walker, Vec2::X);
        }
        stage.run(1.5);
        (before, local(&stage, walker), local(&stage, thing), walks)
    };
    let ((a0, a1, a2, walks), (b0, b1, b2, _)) = (run(false), run(true));
    let off = (a1 - a0).distance(b1 - b0);
    hold!(
        off < if walks { 0.1 } else { 5e-3 },
        "{off} off, walks {walks}: from {a0} to {a1}, thing {a2}, but from {b0} to {b1}, thing {b2}"
    );
    Ok(())
}

/// One that stands on another goes where that goes.
fn judge_shoulders(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x18000 + seed);
    let mut stage = Stage::any(&mut dice);
    add_ground(&mut stage, &mut dice);
    let high = dice.below(2) == 0;
    // Whichever comes first.
    let places = [STANDING + 0.02, 3.0 * STANDING + 0.05];
    let at = |y: f32| Vec3::new(0.0, y, 0.0);
    let mut two = [Entity::PLACEHOLDER; 2];
    for i in if high { [1, 0] } else { [0, 1] } {
        two[i] = stage.add_walker(at(places[i]));
    }
    let [below, above] = two;
    stage.run(0.3);
    let wish = dice.in_range(0.2, 4.0) * heading(dice.in_range(0.0, 6.3));
    stage.wish(below, wish);
    let start = stage.place(above) - stage.place(below);
    for step in 0..stage.steps(1.0) {
        stage.step();
        let off = (stage.place(above) - stage.place(below)).distance(start);
        hold!(off < 5e-3, "step {step}: {off} off the shoulders");
        hold!(
            stage.is_on_ground(above) && stage.is_on_ground(below),
            "step {step}: off the ground"
        );
    }
    let made = stage
        .place(below)
        .distance(Vec3::new(wish.x, STANDING, wish.y));
    hold!(made < 0.1, "the one below is {made} off");
    Ok(())
}

/// It stays where it is when what it stands on is cut, or replaced, under it.
fn judge_sliced(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x14000 + seed);
    let mut stage = Stage::plain([30.0, 60.0, 120.0][dice.below(3)]);
    stage.add_floor();
    let high = dice.in_range(0.5, 2.0);
    let mesh = stage.box_shape(Vec3::new(4.0, high, 4.0));
    let kind = [RigidBody::Dynamic, RigidBody::Static][dice.below(2)];
    let ground = stage.add(kind, (mesh, Anchors::default()), flat(0.5 * high * Vec3::Y));
    let walker = stage.add_walker(Vec3::new(
        dice.in_range(-1.0, 1.0),
        high + STANDING + 0.02,
        dice.in_range(-1.0, 1.0),
    ));
    stage.run(1.0);
    let before = stage.place(walker);
    let normal = Quat::from_rotation_y(dice.in_range(0.0, 6.0)) * Vec3::X;
    let at = Vec3::new(
        dice.in_range(-0.5, 0.5),
        0.5 * high,
        dice.in_range(-0.5, 0.5),
    );
    let mut commands = stage.app.world_mut().commands();
    commands.slice(ground, Plane::through(at, normal));
    stage.app.world_mut().flush();
    for step in 0..stage.steps(1.0) {
        stage.step();
        let (at, gap) = (stage.place(walker), stage.gap(walker));
        hold!(gap > -1e-3, "step {step}: {gap} inside at {at}");
        hold!(
            at.distance(before) < 0.03,
            "step {step}: from {before} to {at}, {kind:?}"
        );
        hold!(
            stage.is_on_ground(walker),
            "step {step}: off the ground at {at}, {kind:?}"
        );
    }
    let mut pieces = stage.app.world_mut().query::<&PieceOf>();
    let count = pieces.iter(stage.app.world()).count();
    hold!(count > 1, "{count} pieces of it");
    Ok(())
}

/// It stays where it is on what slides by itself.
fn judge_raft(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x1e000 + seed);
    let mut stage = Stage::plain([30.0, 60.0, 120.0][dice.below(3)]);
    let floor = stage.box_shape(Vec3::new(200.0, 1.0, 200.0));
    stage.add(
        RigidBody::Static,
        (floor, Friction::new(0.0)),
        flat(-0.5 * Vec3::Y),
    );
    let slab = stage.box_shape(Vec3::new(3.0, 0.5, 3.0));
    let what = (
        slab,
        Friction::new(0.0),
        LinearDamping([0.0, 1.0][dice.below(2)]),
    );
    let raft = stage.add(RigidBody::Dynamic, what, flat(0.25 * Vec3::Y));
    let at = Vec3::new(
        dice.in_range(-1.0, 1.0),
        0.5 + STANDING + 0.02,
        dice.in_range(-1.0, 1.0),
    );
    let walker = stage.add_walker(at);
    stage.run(0.5);
    let to = heading(dice.in_range(0.0, 6.3));
    let spin = dice.in_range(-1.0, 1.0) * Vec3::Y;
    stage.set_velocity(
        raft,
        dice.in_range(0.2, 5.0) * Vec3::new(to.x, 0.0, to.y),
        spin,
    );
    stage.step();
    let start = stage.seen_from(raft, stage.transform_of(walker).translation);
    for step in 0..stage.steps(2.0) {
        stage.step();
        let off = stage
            .seen_from(raft, stage.transform_of(walker).translation)
            .distance(start);
        // It is where the raft was expected to be before the step: what damps that within is made up for in the next.
        hold!(off < 5e-3, "step {step}: {off} off on the raft");
        hold!(stage.is_on_ground(walker), "step {step}: off the raft");
    }
    Ok(())
}

#[test]
fn it_stays_where_it_is_on_what_moves() {
    check(judge_ride, 50);
}

#[test]
fn who_jumps_keeps_the_motion_of_the_ground() {
    check(judge_jump, 50);
}

#[test]
fn what_moves_against_it_takes_it_along_and_never_passes_it() {
    check(judge_moving_wall, 50);
}

#[test]
fn crushed_it_stays_between_what_crushes_it() {
    check(judge_crushed, 50);
}

#[test]
fn it_stays_on_what_tilts() {
    check(judge_tilt, 50);
}

#[test]
fn on_what_moves_it_is_among_things_as_on_what_stands() {
    check(judge_company, 30);
}

#[test]
fn one_that_stands_on_another_goes_with_it() {
    check(judge_shoulders, 50);
}

#[test]
fn it_stays_where_it_is_when_its_ground_is_cut() {
    check(judge_sliced, 60);
}

#[test]
fn it_stays_where_it_is_on_what_contacts_move() {
    check(judge_raft, 60);
}
