//! Laws of characters on grounds of all kinds, over random members.
#![expect(
    clippy::disallowed_methods,
    reason = "sizes and slopes of scenes may differ between platforms"
)]

use crate::common::dice::Dice;
use crate::walker_stage::{
    RADIUS, STANDING, Stage, Verdict, add_ground, check, flat, heading, hold,
};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::Entity;
use glam::{Quat, Vec2, Vec3};

/// Who wants nothing on still ground stays to the bit.
fn judge_still(seed: u64) -> Verdict {
    let mut dice = Dice::new(seed);
    let mut stage = Stage::any(&mut dice);
    if dice.below(2) == 0 {
        add_ground(&mut stage, &mut dice);
    } else {
        // A slope that it may stand on, to any side.
        let tilt = dice.in_range(0.0, 0.75);
        let turn = Quat::from_rotation_y(dice.in_range(0.0, 6.0)) * Quat::from_rotation_z(tilt);
        stage.add_box(
            RigidBody::Static,
            Vec3::new(30.0, 1.0, 30.0),
            Pose::new(turn * Vec3::new(0.0, -0.5, 0.0), turn),
        );
    }
    let at = Vec3::new(dice.in_range(-2.0, 2.0), 3.5, dice.in_range(-2.0, 2.0));
    let walker = stage.add_walker(at);
    stage.run(2.5);
    let before = stage.transform_of(walker);
    hold!(
        stage.is_on_ground(walker),
        "not on the ground at {}",
        stage.place(walker)
    );
    for step in 0..stage.steps(1.0) {
        stage.step();
        let after = stage.transform_of(walker);
        let moved = (after.translation - before.translation) / stage.unit;
        hold!(after == before, "step {step}: moved by {moved:?}");
        hold!(stage.is_on_ground(walker), "step {step}: off the ground");
    }
    Ok(())
}

/// Half a second on level ground it goes where it wants to, and stays on the ground; `far` is how far from the middle it may be, for rounding.
fn walk_level(stage: &mut Stage, walker: Entity, wish: Vec2, far: f32) -> Verdict {
    let mut expected = stage.place(walker);
    stage.wish(walker, wish);
    for step in 0..stage.steps(0.5) {
        stage.step();
        let at = stage.place(walker);
        expected += stage.step_dt * Vec3::new(wish.x, 0.0, wish.y);
        let off = at.distance(expected);
        let rounding = 1e-6 * (stage.world.position.length() / stage.unit + far) * step as f32;
        hold!(
            off < 1e-3 + rounding,
            "step {step}: {off} off at {at} with {wish}"
        );
        hold!(
            stage.is_on_ground(walker),
            "step {step}: off the ground at {at} with {wish}"
        );
    }
    Ok(())
}

/// On level ground of any cut it goes as on one piece.
fn judge_flat(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x1000 + seed);
    let mut stage = Stage::any(&mut dice);
    add_ground(&mut stage, &mut dice);
    let walker = stage.add_walker(Vec3::new(0.0, STANDING + 0.02, 0.0));
    stage.run(0.3);
    for _ in 0..5 {
        let speed = 10.0_f32.powf(dice.in_range(-0.7, 1.0));
        let wish = speed * heading(dice.in_range(0.0, 6.3));
        walk_level(&mut stage, walker, wish, 10.0)?;
        if stage.place(walker).length() > 25.0 {
            break;
        }
    }
    Ok(())
}

/// On compounds, levels of heights, round and kinematic bodies at rest it stands as on a floor.
fn judge_ground_kinds(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x1b000 + seed);
    let mut stage = Stage::any(&mut dice);
    let unit = stage.unit;
    let kind = [RigidBody::Static, RigidBody::Kinematic][dice.below(2)];
    match dice.below(4) {
        0 => {
            let slab = stage.box_shape(Vec3::new(5.0, 1.0, 40.0));
            let parts = (0..8).map(|i| {
                (
                    Pose::from_position(unit * Vec3::new(5.0 * i as f32 - 17.5, 0.0, 0.0)),
                    slab.clone(),
                )
            });
            let compound = Compound::new(parts).expect("usable");
            stage.add(kind, compound, flat(-0.5 * Vec3::Y));
        }
        1 => {
            let heights = vec![0.0; 41 * 41];
            let mesh = StaticMesh::from_heights(&heights, 41, unit).expect("a grid");
            stage.add(kind, mesh, flat(Vec3::new(-20.0, 0.0, -20.0)));
        }
        2 => {
            let shape = ConvexMesh::cylinder(unit * 20.0, unit).expect("usable");
            stage.add(kind, shape, flat(-0.5 * Vec3::Y));
        }
        _ => {
            stage.add_box(kind, Vec3::new(40.0, 1.0, 40.0), flat(-0.5 * Vec3::Y));
        }
    }
    let walker = stage.add_walker(Vec3::new(0.0, STANDING + 0.02, 0.0));
    stage.run(0.3);
    for _ in 0..4 {
        let wish = dice.in_range(0.2, 6.0) * heading(dice.in_range(0.0, 6.3));
        walk_level(&mut stage, walker, wish, 20.0)?;
    }
    Ok(())
}

/// It goes up and down stairs of steps that are low enough, and not up others.
fn judge_stairs(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x2000 + seed);
    let mut stage = Stage::any(&mut dice);
    let goes_up = dice.below(3) > 0;
    let share = if goes_up {
        dice.in_range(0.05, 0.97)
    } else {
        dice.in_range(1.05, 3.0)
    };
    let (rise, count) = (0.3 * share, 8);
    // So that the stairs as a whole are no wall to the capsule.
    let run = dice.in_range(0.25, 1.2).max(rise);
    stage.add_floor();
    if dice.below(2) == 0 {
        for i in 0..count {
            let (top, from) = (rise * (i + 1) as f32, run * i as f32);
            let length = run * count as f32 + 12.0 - from;
            stage.block(
                Vec3::new(length, top, 12.0),
                Vec3::new(from + 0.5 * length, 0.5 * top, 0.0),
            );
        }
    } else {
        let (mut corners, mut triangles) = (Vec::new(), Vec::new());
        let mut profile = vec![Vec2::ZERO];
        for i in 0..count {
            let (x, y) = (run * i as f32, rise * (i + 1) as f32);
            let end = if i + 1 == count { 12.0 } else { run };
            profile.extend([Vec2::new(x, y), Vec2::new(x + end, y)]);
        }
        for pair in profile.windows(2) {
            let first = corners.len() as u32;
            let [p, q] = [pair[0], pair[1]];
            corners.extend(
                [(p, -6.0), (q, -6.0), (q, 6.0), (p, 6.0)].map(|(p, z)| Vec3::new(p.x, p.y, z)),
            );
            triangles.extend([[first, first + 2, first + 1], [first, first + 3, first + 2]]);
        }
        stage.add_level(&corners, &triangles, dice.below(2) == 0);
    }
    let walker = stage.add_walker(Vec3::new(-1.5, STANDING + 0.02, 0.0));
    stage.run(0.3);
    let speed = dice.in_range(0.3, 6.0);
    let aside = dice.in_range(-0.5, 0.5);
    let wish = speed * heading(aside);
    stage.wish(walker, wish);
    let way = (1.5 + run * count as f32 + 1.0).min(3.0 / aside.abs().max(1e-3));
    let steps = stage.steps(way / wish.x);
    for step in 0..steps {
        stage.step();
        let (at, gap) = (stage.place(walker), stage.gap(walker));
        hold!(gap > -1e-3, "step {step}: {gap} in the stairs at {at}");
        hold!(
            stage.is_on_ground(walker),
            "step {step}: off the ground at {at} up {rise}, {run} with {speed}"
        );
        hold!(
            goes_up || at.y < STANDING + 0.05,
            "step {step}: up {share} of the highest step to {at}"
        );
    }
    if !goes_up {
        return Ok(());
    }
    let at = stage.place(walker);
    let made = (at.x + 1.5) / way;
    hold!(
        made > 0.96,
        "made {made} of the way up {rise}, {run} to {at} with {speed} to {aside}"
    );
    stage.wish(walker, -wish);
    for step in 0..steps {
        stage.step();
        let (at, gap) = (stage.place(walker), stage.gap(walker));
        hold!(
            gap > -1e-3,
            "down, step {step}: {gap} in the stairs at {at}"
        );
        hold!(
            stage.is_on_ground(walker),
            "down, step {step}: off the ground at {at}, {rise}, {run} with {speed}"
        );
    }
    let at = stage.place(walker);
    hold!(
        at.distance(Vec3::new(-1.5, STANDING, 0.0)) < 0.1 * way,
        "down to {at} of {way}, made {made} up {rise}, {run} with {speed} to {aside} at {}",
        stage.step_dt
    );
    Ok(())
}

/// Along a wall it goes as fast as what is along it of its wish, however straight it runs into it.
fn judge_slide(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x1d000 + seed);
    let mut stage = Stage::any(&mut dice);
    add_ground(&mut stage, &mut dice);
    let turn = Quat::from_rotation_y(dice.in_range(0.0, 6.0));
    let size = Vec3::new(1.0, 4.0, 120.0);
    let at = Pose::new(turn * Vec3::new(1.5, 2.0, 0.0), turn);
    stage.add_box(RigidBody::Static, size, at);
    let walker = stage.add_walker(Vec3::new(0.0, STANDING + 0.02, 0.0));
    stage.run(0.2);
    let off = 10.0_f32.powf(dice.in_range(-3.0, 0.17)) * [-1.0, 1.0][dice.below(2)];
    let speed = dice.in_range(1.0, 6.0);
    let wish = turn * (speed * Vec3::new(off.cos(), 0.0, off.sin()));
    stage.wish(walker, Vec2::new(wish.x, wish.z));
    // Until it is there.
    stage.run(2.0 / (speed * off.cos()));
    let before = stage.place(walker);
    let secs = 1.0;
    stage.run(secs);
    let made = turn.inverse() * (stage.place(walker) - before);
    let expected = stage.step_dt * stage.steps(secs) as f32 * speed * off.sin();
    let miss = (made.z - expected).abs();
    hold!(
        miss < 2e-3 + 0.01 * expected.abs(),
        "made {} of {expected} along the wall, {off} off straight",
        made.z
    );
    hold!(made.x.abs() < 2e-3 && made.y.abs() < 2e-3, "moves {made}");
    Ok(())
}

/// It walks up slopes that are a little less steep than it may, and not up those that are a little steeper.
fn judge_slope(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x3000 + seed);
    let mut stage = Stage::any(&mut dice);
    let goes_up = dice.below(2) == 0;
    let most = dice.in_range(0.3, 1.5);
    let share = if goes_up {
        dice.in_range(0.9, 0.995)
    } else {
        dice.in_range(1.005, 1.15)
    };
    let slope = share * most;
    let is_mesh = dice.below(2) == 0;
    if is_mesh {
        let (mut corners, mut triangles) = (Vec::new(), Vec::new());
        let mut x = -40.0;
        while x < 30.0 {
            let next = if x < 0.0 {
                0.0
            } else {
                x + dice.in_range(0.05, 3.0)
            };
            let first = corners.len() as u32;
            let y = |x: f32| slope * x.max(0.0);
            corners.extend(
                [(x, -40.0), (next, -40.0), (next, 40.0), (x, 40.0)]
                    .map(|(x, z)| Vec3::new(x, y(x), z)),
            );
            triangles.extend([[first, first + 2, first + 1], [first, first + 3, first + 2]]);
            x = next;
        }
        stage.add_level(&corners, &triangles, dice.below(2) == 0);
    } else {
        stage.add_floor();
        let turn = Quat::from_rotation_z(slope.atan());
        stage.add_box(
            RigidBody::Static,
            Vec3::new(80.0, 1.0, 60.0),
            Pose::new(turn * Vec3::new(30.0, -0.5, 0.0), turn),
        );
    }
    let walker = stage.add_walker(Vec3::new(-2.0, STANDING + 0.02, 0.0));
    stage.walker(walker).settings.max_slope = most;
    stage.run(0.3);
    let speed = dice.in_range(0.5, 8.0);
    let aside = dice.in_range(-1.0, 1.0);
    let wish = speed * heading(aside);
    stage.wish(walker, wish);
    let steps = stage.steps(6.0 / wish.x);
    let start = stage.place(walker);
    for step in 0..steps {
        stage.step();
        let (at, gap) = (stage.place(walker), stage.gap(walker));
        hold!(gap > -1e-3, "step {step}: {gap} in the ground at {at}");
        hold!(
            goes_up || at.y < STANDING + 0.1,
            "step {step}: up {share} of {most} to {at}"
        );
        hold!(
            stage.is_on_ground(walker),
            "step {step}: off the ground at {at}"
        );
    }
    let made = (stage.place(walker).x - start.x) / (wish.x * stage.step_dt * steps as f32);
    hold!(
        !goes_up || (0.97..1.03).contains(&made),
        "{made} of the way up {share} of {most}"
    );
    if goes_up {
        stage.wish(walker, Vec2::ZERO);
        stage.step();
        let before = stage.place(walker);
        stage.run(0.5);
        let drift = stage.place(walker).distance(before);
        hold!(drift < 1e-3, "drifts by {drift} on {share} of {most}");
        stage.wish(walker, -wish);
        for step in 0..stage.steps(2.0 / wish.x) {
            stage.step();
            hold!(
                stage.is_on_ground(walker),
                "down, step {step}: off the ground"
            );
        }
    }
    Ok(())
}

/// Between slopes that are too steep, and in corners of them with the floor, it keeps still and out of them, and walks away.
fn judge_groove(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x1c000 + seed);
    let mut stage = Stage::any(&mut dice);
    let has_floor = dice.below(2) == 0;
    if has_floor {
        stage.add_floor();
    }
    let count = 1 + dice.below(3);
    let turn = dice.in_range(0.0, 6.0);
    for i in 0..if has_floor { count } else { 2 } {
        let lean = dice.in_range(0.9, 1.5);
        let around = turn
            + if has_floor {
                dice.in_range(1.0, 2.5) * i as f32
            } else {
                std::f32::consts::PI * i as f32
            };
        let rotation = Quat::from_rotation_y(around) * Quat::from_rotation_z(lean);
        let away = if has_floor {
            dice.in_range(0.4, 0.8)
        } else {
            0.0
        };
        let foot = Quat::from_rotation_y(around) * Vec3::new(away, 0.0, 0.0);
        stage.add_box(
            RigidBody::Static,
            Vec3::new(12.0, 1.0, 12.0),
            Pose::new(foot + rotation * Vec3::new(5.0, -0.5, 0.0), rotation),
        );
    }
    // Above where steep slopes are as far apart as it is wide.
    let from = if has_floor { STANDING + 1.0 } else { 8.0 };
    let walker = stage.add_walker(from * Vec3::Y);
    stage.run(3.0);
    let before = stage.place(walker);
    let ground = stage.is_on_ground(walker);
    for step in 0..stage.steps(0.5) {
        stage.step();
        let (at, gap) = (stage.place(walker), stage.gap(walker));
        hold!(gap > -1e-3, "step {step}: {gap} inside at {at}");
        hold!(
            at.distance(before) < 1e-2,
            "step {step}: from {before} to {at}"
        );
        hold!(
            !has_floor || stage.is_on_ground(walker) == ground,
            "step {step}: was on the ground {ground}"
        );
    }
    for _ in 0..4 {
        stage.wish(
            walker,
            dice.in_range(0.5, 4.0) * heading(dice.in_range(0.0, 6.3)),
        );
        for step in 0..stage.steps(0.5) {
            stage.step();
            let (at, gap) = (stage.place(walker), stage.gap(walker));
            hold!(gap > -1e-3, "walks, step {step}: {gap} inside at {at}");
            hold!(
                !has_floor || !ground || stage.is_on_ground(walker),
                "walks, step {step}: off the ground at {at}"
            );
        }
    }
    Ok(())
}

/// It walks off a ledge and falls as a stone does, and stays on one on which it stands half.
fn judge_ledge(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x13000 + seed);
    let mut stage = Stage::any(&mut dice);
    let high = dice.in_range(1.5, 4.0);
    stage.add_floor();
    stage.block(Vec3::new(6.0, high, 20.0), Vec3::new(-3.0, 0.5 * high, 0.0));
    let out = dice.in_range(-0.1, 0.9) * RADIUS;
    let walker = stage.add_walker(Vec3::new(out, high + STANDING + 0.02, 0.0));
    stage.run(0.5);
    let before = stage.place(walker);
    stage.run(0.5);
    let drift = stage.place(walker).distance(before);
    hold!(
        drift < 1e-3 || !stage.is_on_ground(walker) || before.y < high,
        "drifts by {drift}, {out} over the edge, {before}"
    );
    let speed = dice.in_range(0.3, 8.0);
    stage.wish(walker, speed * heading(dice.in_range(-0.8, 0.8)));
    let (mut in_air, mut fell) = (0, false);
    for step in 0..stage.steps(2.5) {
        stage.step();
        let (at, gap) = (stage.place(walker), stage.gap(walker));
        hold!(gap > -1e-3, "step {step}: {gap} inside at {at}");
        if !stage.is_on_ground(walker) {
            in_air += 1;
        } else if in_air > 0 && at.y < high {
            fell = true;
            break;
        }
    }
    if before.y > high {
        let secs = stage.step_dt * in_air as f32;
        let expected = (2.0 * (high - 0.0) / 9.81).sqrt();
        hold!(
            fell,
            "hangs at {} in the air for {secs}",
            stage.place(walker)
        );
        hold!(
            secs < expected + 0.15 && secs > 0.6 * expected,
            "falls {secs} s from {high}, not {expected}, {speed}"
        );
    }
    Ok(())
}

#[test]
fn who_wants_nothing_on_still_ground_stays_to_the_bit() {
    check(judge_still, 50);
}

#[test]
fn on_level_ground_of_any_cut_it_goes_as_on_one_piece() {
    check(judge_flat, 50);
}

#[test]
fn on_grounds_of_any_kind_it_goes_as_on_a_floor() {
    check(judge_ground_kinds, 50);
}

#[test]
fn it_goes_up_and_down_stairs_that_are_low_enough() {
    check(judge_stairs, 30);
}

#[test]
fn it_slides_along_walls_however_straight_it_runs_into_them() {
    check(judge_slide, 60);
}

#[test]
fn slopes_near_the_limit_are_told_apart() {
    check(judge_slope, 50);
}

#[test]
fn between_steep_slopes_it_keeps_still_and_out_of_them() {
    check(judge_groove, 30);
}

#[test]
fn it_falls_off_ledges_as_a_stone_does() {
    check(judge_ledge, 50);
}
