//! Laws of characters in an app, over random members: on what moves, among what moves by itself, in corners and on stairs.
#![expect(
    clippy::disallowed_methods,
    reason = "sizes and slopes of scenes may differ between platforms"
)]

use crate::common::dice::Dice;
use crate::walker_stage::{LENGTH, RADIUS, SKIN, STANDING, Stage, flat};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::{Quat, Vec2, Vec3};

type Verdict = Result<(), String>;

/// Every law, with its name.
pub(crate) const LAWS: &[(&str, fn(u64) -> Verdict)] = &[
    ("still", judge_still),
    ("flat", judge_flat),
    ("stairs", judge_stairs),
    ("slope", judge_slope),
    ("walls", judge_walls),
    ("corridor", judge_corridor),
    ("ride", judge_ride),
    ("jump", judge_jump),
    ("moving_wall", judge_moving_wall),
    ("crushed", judge_crushed),
    ("push", judge_push),
    ("hit", judge_hit),
    ("meeting", judge_meeting),
    ("rates", judge_rates),
    ("turned", judge_turned),
    ("order", judge_order),
    ("far", judge_far),
    ("chaos", judge_chaos),
    ("ledge", judge_ledge),
    ("sliced", judge_sliced),
    ("inside", judge_inside),
    ("tilt", judge_tilt),
    ("company", judge_company),
    ("shoulders", judge_shoulders),
    ("door", judge_door),
    ("stair_rates", judge_stair_rates),
    ("ground_kinds", judge_ground_kinds),
    ("groove", judge_groove),
];

/// A law that is broken.
macro_rules! hold {
    ($is:expr, $($why:tt)*) => {
        if !$is {
            return Err(format!($($why)*));
        }
    };
}

fn heading(angle: f32) -> Vec2 {
    Vec2::new(angle.cos(), angle.sin())
}

/// Ground at height 0 around the origin, of some kind: a half-space, boxes, triangles of any cut.
fn add_ground(stage: &mut Stage, dice: &mut Dice) {
    match dice.below(5) {
        0 => {
            let normal = stage.world.rotation * Vec3::Y;
            stage.add(
                RigidBody::Static,
                HalfSpaceShape { normal },
                Pose::new(Vec3::ZERO, stage.world.rotation.inverse()),
            );
        }
        1 => {
            stage.add_floor();
        }
        2 => {
            // Slabs side by side.
            for i in -8..8 {
                let width = 5.0;
                let at = Vec3::new((i as f32 + 0.5) * width, -0.5, 0.0);
                stage.block(Vec3::new(width, 1.0, 80.0), at);
            }
        }
        _ => {
            let (corners, triangles) = flat_triangles(dice);
            stage.add_level(&corners, &triangles, dice.below(2) == 0);
        }
    }
}

/// Level triangles: rows of different cuts, so that edges end in the middle of others, with thin ones among them.
fn flat_triangles(dice: &mut Dice) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    let mut z = -40.0_f32;
    while z < 40.0 {
        let depth = [0.02, 0.7, 3.0, 10.0][dice.below(4)] * dice.in_range(0.5, 1.5);
        let mut x = -40.0_f32;
        while x < 40.0 {
            let width = [0.05, 0.5, 4.0, 20.0][dice.below(4)] * dice.in_range(0.5, 1.5);
            let first = corners.len() as u32;
            for (dx, dz) in [(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)] {
                corners.push(Vec3::new(x + dx, 0.0, z + dz));
            }
            let [a, b, c, d] = [0, 1, 2, 3].map(|i| first + i);
            triangles.extend(match dice.below(2) {
                0 => [[a, c, b], [a, d, c]],
                _ => [[a, d, b], [b, d, c]],
            });
            x += width;
        }
        z += depth;
    }
    (corners, triangles)
}

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

/// On level ground of any cut it goes as on one piece.
fn judge_flat(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x1000 + seed);
    let mut stage = Stage::any(&mut dice);
    add_ground(&mut stage, &mut dice);
    let walker = stage.add_walker(Vec3::new(0.0, STANDING + 0.02, 0.0));
    stage.run(0.3);
    let mut expected = stage.place(walker);
    for _ in 0..5 {
        let speed = 10.0_f32.powf(dice.in_range(-0.7, 1.0));
        let wish = speed * heading(dice.in_range(0.0, 6.3));
        stage.wish(walker, wish);
        for step in 0..stage.steps(0.5) {
            stage.step();
            let at = stage.place(walker);
            expected += stage.step_dt * Vec3::new(wish.x, 0.0, wish.y);
            let off = at.distance(expected);
            let rounding = 1e-6 * (stage.world.position.length() / stage.unit + 10.0) * step as f32;
            hold!(
                off < 1e-3 + rounding,
                "step {step}: {off} off at {at} with {wish}"
            );
            hold!(
                stage.is_on_ground(walker),
                "step {step}: off the ground at {at} with {wish}"
            );
        }
        expected = stage.place(walker);
        if expected.length() > 25.0 {
            break;
        }
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
        for (k, pair) in profile.windows(2).enumerate() {
            let _ = k;
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
            let rotation =
                Quat::from_mat3(&glam::Mat3::from_cols(along, n.cross(along), n)).normalize();
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
    let (along_walker, along_mover) = (axis.dot(stage.place(walker)), axis.dot(stage.place(mover)));
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
    let _ = (along_walker, along_mover);
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
            hold!(
                flatly < 1.5 * speed + 0.3,
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
    let floor = stage.add_floor();
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
                    entity.remove::<bevy_ecs::entity_disabling::Disabled>();
                } else {
                    entity.insert(bevy_ecs::entity_disabling::Disabled);
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
        let _ = floor;
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
    hold!(
        stage.app.world().get_entity(ground).is_err()
            || stage.app.world().get::<Pieces>(ground).is_some()
            || true,
        "not cut"
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
    let _ = LENGTH;
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
    let mut expected = stage.place(walker);
    for _ in 0..4 {
        let wish = dice.in_range(0.2, 6.0) * heading(dice.in_range(0.0, 6.3));
        stage.wish(walker, wish);
        for step in 0..stage.steps(0.5) {
            stage.step();
            let at = stage.place(walker);
            expected += stage.step_dt * Vec3::new(wish.x, 0.0, wish.y);
            let off = at.distance(expected);
            let rounding = 1e-6 * (stage.world.position.length() / stage.unit + 20.0) * step as f32;
            hold!(
                off < 1e-3 + rounding,
                "step {step}: {off} off at {at} with {wish}"
            );
            hold!(
                stage.is_on_ground(walker),
                "step {step}: off the ground at {at} with {wish}"
            );
        }
        expected = stage.place(walker);
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
