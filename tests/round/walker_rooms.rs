//! Laws of characters among walls, and of their steps in time, over random members.
#![expect(
    clippy::disallowed_methods,
    reason = "sizes and slopes of scenes may differ between platforms"
)]

use crate::common::dice::Dice;
use crate::walker_stage::{
    RADIUS, SKIN, STANDING, Stage, Verdict, add_ground, check, flat, heading, hold,
};
use bevy_cleave::prelude::*;
use glam::{Mat3, Quat, Vec2, Vec3};

/// Walls around the origin at random angles: none is passed at any speed.
fn judge_walls(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x4000 + seed);
    let mut stage = Stage::any(&mut dice);
    let sides = 3 + dice.below(4);
    let kind = dice.below(4);
    let mut normals = Vec::new();
    let mut angles: Vec<f32> = (0..sides)
        .map(|i| (i as f32 + dice.in_range(0.05, 0.95)) * std::f32::consts::TAU / sides as f32)
        .collect();
    angles.sort_by(f32::total_cmp);
    let ring: Vec<Vec3> = angles
        .iter()
        .map(|a| dice.in_range(3.0, 6.0) * Vec3::new(a.cos(), 0.0, a.sin()))
        .collect();
    let leans: Vec<f32> = ring
        .iter()
        .map(|_| [0.0, dice.in_range(-0.4, 0.4)][dice.below(2)])
        .collect();
    let high = 4.0;
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..sides {
        let (p, q) = (ring[i], ring[(i + 1) % sides]);
        // Into the room.
        let mut inward = (q - p).cross(Vec3::Y).normalize();
        if inward.dot(-p) < 0.0 {
            inward = -inward;
        }
        if inward.dot(-p) < 0.5 {
            return Ok(());
        }
        let along = (q - p).normalize();
        let turn = Quat::from_axis_angle(along, leans[i]);
        let n = turn * inward;
        normals.push((p, n));
        let length = 120.0;
        let middle = 0.5 * (p + q);
        let up = turn * Vec3::Y;
        if kind < 2 {
            let thick = [0.01, 0.05, 0.3][dice.below(3)];
            let rotation = Quat::from_mat3(&Mat3::from_cols(along, n.cross(along), n)).normalize();
            let at = Pose::new(middle - 0.5 * thick * n, rotation);
            stage.add_box(RigidBody::Static, Vec3::new(length, 20.0, thick), at);
        } else {
            let first = corners.len() as u32;
            for (a, u) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                corners.push(middle + 0.5 * length * a * along + 8.0 * u * up);
            }
            let order = [[0, 1, 2], [0, 2, 3]];
            let facing = (corners[first as usize + 1] - corners[first as usize])
                .cross(corners[first as usize + 2] - corners[first as usize]);
            for t in order {
                let t = t.map(|k| first + k);
                triangles.push(if facing.dot(n) > 0.0 {
                    t
                } else {
                    [t[0], t[2], t[1]]
                });
            }
        }
    }
    if kind >= 2 {
        stage.add_level(&corners, &triangles, kind == 3);
    }
    stage.block(Vec3::new(400.0, 0.2, 400.0), -0.1 * Vec3::Y);
    stage.block(Vec3::new(400.0, 0.2, 400.0), (high + 0.1) * Vec3::Y);
    let walker = stage.add_walker(Vec3::new(0.0, STANDING + 0.02, 0.0));
    stage.step();
    if stage.gap(walker) < 5e-3 {
        return Ok(());
    }
    stage.run(0.2);
    let speed = [3.0, 30.0, 30.0, 100.0][dice.below(4)];
    for step in 0..150 {
        if step % 5 == 0 {
            stage.wish(walker, speed * heading(dice.in_range(0.0, 6.3)));
            let jump = [0.0, 0.0, dice.in_range(1.0, 30.0)][dice.below(3)] * stage.unit;
            stage.walker(walker).jump = jump;
        }
        stage.step();
        let (at, gap) = (stage.place(walker), stage.gap(walker));
        hold!(gap > -2e-3, "step {step}: {gap} in a wall at {at}, {speed}");
        for (on, n) in &normals {
            let ahead = (at - *on).dot(*n);
            hold!(
                ahead > 0.9 * RADIUS,
                "step {step}: behind a wall at {at} by {ahead}, {speed}"
            );
        }
        hold!(
            at.y > 0.9 * STANDING && at.y < high - 0.9 * STANDING,
            "step {step}: out at {at}"
        );
    }
    Ok(())
}

/// Through a corridor that is hardly wider than it is, and under ceilings that are hardly higher, and not into what is narrower.
fn judge_corridor(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x5000 + seed);
    let mut stage = Stage::any(&mut dice);
    let goes = dice.below(3) > 0;
    let is_low = dice.below(2) == 0;
    let spare = if goes {
        dice.in_range(2.5, 20.0)
    } else {
        -dice.in_range(2.5, 20.0)
    } * SKIN;
    stage.add_floor();
    if is_low {
        let high = 2.0 * STANDING + spare;
        stage.block(Vec3::new(4.0, 1.0, 20.0), Vec3::new(2.0, high + 0.5, 0.0));
    } else {
        let half = RADIUS + 0.5 * spare;
        for side in [-1.0, 1.0] {
            stage.block(
                Vec3::new(4.0, 3.0, 1.0),
                Vec3::new(2.0, 1.5, side * (half + 0.5)),
            );
        }
    }
    let z = if is_low {
        dice.in_range(-1.0, 1.0)
    } else {
        0.0
    };
    let walker = stage.add_walker(Vec3::new(-1.0, STANDING + 0.02, z));
    stage.run(0.2);
    let speed = dice.in_range(0.5, 10.0);
    // Not past the corners of the entrance.
    let aside = if is_low { 0.1 } else { 0.3 * spare.max(0.0) };
    let wish = speed * heading(dice.in_range(-aside, aside));
    stage.wish(walker, wish);
    for step in 0..stage.steps(7.0 / wish.x) {
        stage.step();
        let (at, gap) = (stage.place(walker), stage.gap(walker));
        hold!(gap > -1e-3, "step {step}: {gap} inside at {at}");
        hold!(
            goes || at.x < 0.05,
            "step {step}: in what is narrower by {spare} at {at}, low {is_low}"
        );
    }
    let at = stage.place(walker);
    hold!(
        !goes || at.x > 4.0,
        "not through, spare {spare} at {at}, low {is_low}"
    );
    Ok(())
}

/// Put into what stands it comes out, where it is not deep, and walks on.
fn judge_inside(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x15000 + seed);
    let mut stage = Stage::any(&mut dice);
    add_ground(&mut stage, &mut dice);
    let size = Vec3::new(dice.in_range(0.5, 3.0), 3.0, dice.in_range(0.5, 3.0));
    let turn = Quat::from_rotation_y(dice.in_range(0.0, 6.0));
    stage.add_box(
        RigidBody::Static,
        size,
        Pose::new(Vec3::new(0.0, 1.5, 0.0), turn),
    );
    // The middle at most so far within the side.
    let deep = dice.in_range(-0.25, 0.25);
    let side = Vec3::new(0.5 * size.x - deep, 0.0, dice.in_range(-0.4, 0.4) * size.z);
    let walker = stage.add_walker(turn * side + (STANDING + dice.in_range(-0.2, 0.02)) * Vec3::Y);
    stage.run(1.0);
    let gap = stage.gap(walker);
    hold!(
        gap > -1e-3,
        "{gap} inside at {} after a second",
        stage.place(walker)
    );
    // By the side that it came out of.
    let from = turn.inverse() * stage.place(walker);
    let over = [from.x.abs() - 0.5 * size.x, from.z.abs() - 0.5 * size.z];
    let out = if over[0] > over[1] {
        from.x.signum() * Vec3::X
    } else {
        from.z.signum() * Vec3::Z
    };
    let out = turn * out;
    stage.wish(walker, 2.0 * Vec2::new(out.x, out.z));
    let before = stage.place(walker);
    stage.run(0.5);
    let made = stage.place(walker).distance(before);
    hold!((made - 1.0).abs() < 0.05, "goes {made} then, {deep} deep");
    Ok(())
}

/// A course of hills and a wall, walked with a step length.
fn finish(seed: u64, mut stage: Stage) -> (Vec3, Vec<Vec3>) {
    let mut dice = Dice::new(0xd000 + seed);
    let columns = 31;
    let waves: Vec<(Vec2, f32)> = (0..3)
        .map(|_| {
            (
                Vec2::new(dice.in_range(-0.5, 0.5), dice.in_range(-0.5, 0.5)),
                dice.in_range(0.0, 6.0),
            )
        })
        .collect();
    let unit = stage.unit;
    let heights: Vec<f32> = (0..columns * columns)
        .map(|i| {
            let at = Vec2::new((i % columns) as f32, (i / columns) as f32);
            0.25 * unit
                * waves
                    .iter()
                    .map(|(k, p)| (k.dot(at) + p).sin())
                    .sum::<f32>()
        })
        .collect();
    let mesh = StaticMesh::from_heights(&heights, columns, unit).expect("a terrain");
    stage.add(RigidBody::Static, mesh, flat(Vec3::new(-15.0, 0.0, -15.0)));
    let turn = Quat::from_rotation_y(dice.in_range(-0.6, 0.6));
    stage.add_box(
        RigidBody::Static,
        Vec3::new(0.4, 8.0, 20.0),
        Pose::new(Vec3::new(3.0, 0.0, 0.0), turn),
    );
    let walker = stage.add_walker(Vec3::new(0.0, STANDING + 0.8, 0.0));
    stage.run(1.0);
    let mut places = Vec::new();
    for _ in 0..4 {
        let speed = dice.in_range(0.5, 4.0);
        stage.wish(walker, speed * heading(dice.in_range(-2.0, 2.0)));
        stage.run(0.5);
        places.push(stage.place(walker));
    }
    (stage.place(walker), places)
}

/// Finer steps lead to the same places.
fn judge_rates(seed: u64) -> Verdict {
    let at = [30.0, 60.0, 120.0, 240.0].map(|hertz| finish(seed, Stage::plain(hertz)).0);
    let off = [0, 1, 2].map(|i| at[i].distance(at[3]));
    hold!(
        off[0] < 0.15 && off[1] < 0.08 && off[2] < 0.04,
        "{off:?} off what 240 steps a second do"
    );
    Ok(())
}

/// Up stairs, finer steps lead to the same places.
fn judge_stair_rates(seed: u64) -> Verdict {
    let run = |hertz: f64| {
        let mut dice = Dice::new(0x1a000 + seed);
        let mut stage = Stage::plain(hertz);
        let (rise, run) = (dice.in_range(0.05, 0.28), dice.in_range(0.3, 1.0));
        stage.add_floor();
        for i in 0..6 {
            let (top, from) = (rise * (i + 1) as f32, run * i as f32);
            let length = run * 6.0 + 12.0 - from;
            stage.block(
                Vec3::new(length, top, 12.0),
                Vec3::new(from + 0.5 * length, 0.5 * top, 0.0),
            );
        }
        let walker = stage.add_walker(Vec3::new(-0.5, STANDING + 0.02, 0.0));
        stage.run(0.3);
        let speed = dice.in_range(0.4, 4.0);
        stage.wish(walker, speed * heading(dice.in_range(-0.4, 0.4)));
        stage.run((1.5 + 6.0 * run) / speed);
        (stage.place(walker), speed, run, rise)
    };
    let at = [30.0, 60.0, 120.0, 240.0].map(run);
    let way = 1.5 + 6.0 * at[0].2;
    for (i, there) in at.iter().enumerate() {
        let off = there.0.distance(at[3].0);
        // A step is taken by a tenth of the highest at least, however short the steps in time are.
        hold!(
            off < 0.02 * way + 6.0 * 0.03,
            "{i}: {off} off what 240 steps a second do, {at:?}"
        );
    }
    Ok(())
}

/// A turned and moved scene leads to the same places, and a larger one to larger.
fn judge_turned(seed: u64) -> Verdict {
    let mut dice = Dice::new(0xe000 + seed);
    let world = Pose::new(dice.vector(-20.0, 20.0), dice.rotation());
    let unit = [1.0, 10.0_f32.powf(dice.in_range(-1.0, 1.0))][dice.below(2)];
    let (_, here) = finish(seed, Stage::plain(60.0));
    let (_, there) = finish(seed, Stage::plain(60.0).moved_to(world, unit));
    for (i, (a, b)) in here.iter().zip(&there).enumerate() {
        let off = a.distance(*b);
        hold!(
            off < 5e-3 * (i + 1) as f32,
            "{off} off on leg {i}, unit {unit}"
        );
    }
    Ok(())
}

#[test]
fn no_wall_at_any_angle_is_passed() {
    check(judge_walls, 50);
}

#[test]
fn it_goes_through_what_is_wider_and_higher_than_it_is_and_nothing_else() {
    check(judge_corridor, 50);
}

#[test]
fn put_into_what_stands_it_comes_out() {
    check(judge_inside, 50);
}

#[test]
fn finer_steps_lead_to_the_same_places() {
    check(judge_rates, 14);
}

#[test]
fn up_stairs_finer_steps_lead_to_the_same_places() {
    check(judge_stair_rates, 20);
}

#[test]
fn a_turned_scene_leads_to_the_same_places() {
    check(judge_turned, 30);
}
