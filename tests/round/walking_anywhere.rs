//! Characters of random shapes and sizes on random grounds: laws of walking that need no reference.
#![expect(
    clippy::disallowed_methods,
    reason = "sizes and slopes of scenes may differ between platforms"
)]

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use crate::walking::walked;
use bevy_cleave::prelude::*;
use bevy_cleave::query::{Slider, WalkInput, WalkSettings, WalkState};
use glam::{Quat, Vec2, Vec3};

/// Points of a terrain along one side.
const COLUMNS: usize = 41;

/// A slot that no body has: what else is left out changes nothing.
const NOBODY: u32 = 1_000_000;

/// A character in a world that has its own size, place and direction of down. Lengths are in units of that size.
struct Course {
    simulation: Simulation,
    state: WalkState,
    settings: WalkSettings,
    shape: ConvexMesh,
    /// From the course to the world, without the size.
    world: Pose,
    /// m.
    unit: f32,
    step_dt: f32,
}

impl Course {
    fn new(dice: &mut Dice) -> Self {
        let unit = 10.0_f32.powf(dice.in_range(-1.0, 1.0));
        let world = match dice.below(3) {
            0 => Pose::IDENTITY,
            1 => Pose::new(unit * dice.vector(-100.0, 100.0), Quat::IDENTITY),
            _ => Pose::new(unit * dice.vector(-20.0, 20.0), dice.rotation()),
        };
        let up = world.rotation * Vec3::Y;
        let mut simulation = awake();
        simulation.gravity = Gravity(-9.81 * unit * up);
        Self {
            simulation,
            state: WalkState::default(),
            settings: WalkSettings {
                up,
                step_height: 0.3 * unit,
                skin: 0.01 * unit,
                ..WalkSettings::default()
            },
            shape: character(dice, unit),
            world,
            unit,
            step_dt: 1.0 / [30.0, 60.0, 120.0][dice.below(3)],
        }
    }

    fn add(&mut self, desc: BodyDesc, at: Pose) {
        let pose = self.world * Pose::new(self.unit * at.position, at.rotation);
        let desc = BodyDesc {
            kind: RigidBody::Static,
            pose,
            ..desc
        };
        self.simulation.bodies.insert(desc).expect("usable");
    }

    fn add_box(&mut self, size: Vec3, at: Pose) {
        let size = self.unit * size;
        let shape = ConvexMesh::cuboid(size.x, size.y, size.z).expect("a box");
        self.add(BodyDesc::dynamic(shape, Vec3::ZERO), at);
    }

    /// Puts the character somewhere, upright.
    fn start(&mut self, at: Vec3) {
        self.state.position = self.world.transform_point(self.unit * at);
        self.state.rotation = self.world.rotation;
        self.simulation.step(self.step_dt);
    }

    /// Where it is on the course.
    fn place(&self) -> Vec3 {
        self.world.inverse_transform_point(self.state.position) / self.unit
    }

    /// One step with a velocity seen from above, in units a second.
    fn step(&mut self, wish: Vec2) {
        let slider = Slider {
            shape: QueryShape::from(&self.shape),
            skin: self.settings.skin,
        };
        let input = WalkInput {
            velocity: self.unit * (self.world.rotation * Vec3::new(wish.x, 0.0, wish.y)),
            jump: 0.0,
            gravity: self.simulation.gravity.0,
            step_dt: self.step_dt,
        };
        let how = (&slider, &self.settings);
        let filter = QueryFilter::all().excluding(&[NOBODY]);
        walked(
            &mut self.simulation,
            how,
            &mut self.state,
            (&input, &filter),
        );
    }

    /// Lets it stand for some seconds.
    fn stand(&mut self, secs: f32) {
        for _ in 0..(secs / self.step_dt) as usize {
            self.step(Vec2::ZERO);
        }
    }

    /// How far the character is from what is nearest to it, in units.
    fn gap(&mut self) -> f32 {
        let shape = QueryShape::from(&self.shape);
        let pose = Pose::new(self.state.position, self.state.rotation);
        let mut near = Vec::new();
        let queries = self.simulation.queries();
        (queries.near_shape(&shape, &pose, self.unit, &QueryFilter::all(), &mut near))
            .expect("usable");
        near.first()
            .map_or(f32::INFINITY, |hit| hit.distance / self.unit)
    }
}

/// Something that walks, 1.2 to 2 units high.
fn character(dice: &mut Dice, unit: f32) -> ConvexMesh {
    let (radius, height) = (
        unit * dice.in_range(0.25, 0.45),
        unit * dice.in_range(1.2, 2.0),
    );
    match dice.below(6) {
        0..3 => ConvexMesh::capsule(radius, height - 2.0 * radius),
        3 => ConvexMesh::cylinder(radius, height),
        4 => ConvexMesh::cuboid(2.0 * radius, height, 2.0 * radius),
        _ => ConvexMesh::regular_prism(7, radius, height),
    }
    .expect("valid sizes")
}

/// A terrain around the middle, none of it steeper than `slope`; heights by column along x, rows along z.
fn terrain(dice: &mut Dice, slope: f32, spacing: f32) -> Vec<f32> {
    let mut heights: Vec<f32> = (0..COLUMNS * COLUMNS).map(|_| dice.unit()).collect();
    if dice.below(2) == 0 {
        // Hills.
        let waves: Vec<(Vec2, f32)> = (0..4)
            .map(|_| {
                let v = dice.vector(-0.6, 0.6);
                (Vec2::new(v.x, v.z), dice.in_range(0.0, 6.0))
            })
            .collect();
        for (i, height) in heights.iter_mut().enumerate() {
            let at = Vec2::new((i % COLUMNS) as f32, (i / COLUMNS) as f32);
            *height = waves
                .iter()
                .map(|(k, phase)| (k.dot(at) + phase).sin())
                .sum();
        }
    }
    let at = |i: usize, j: usize| heights[j * COLUMNS + i];
    let mut steepest = 0.0_f32;
    for (i, j) in (0..COLUMNS - 1).flat_map(|i| (0..COLUMNS - 1).map(move |j| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)];
        // Whichever diagonal there is.
        for [x, z] in [
            [b - a, c - a],
            [b - a, d - b],
            [d - c, c - a],
            [d - c, d - b],
        ] {
            steepest = steepest.max(x.hypot(z) / spacing);
        }
    }
    heights
        .iter()
        .map(|height| height * slope / steepest)
        .collect()
}

fn add_terrain(course: &mut Course, heights: &[f32], spacing: f32) {
    let unit = course.unit;
    let heights: Vec<f32> = heights.iter().map(|height| unit * height).collect();
    let mesh = StaticMesh::from_heights(&heights, COLUMNS, unit * spacing).expect("a terrain");
    let side = 0.5 * spacing * (COLUMNS - 1) as f32;
    let at = Pose::new(Vec3::new(-side, 0.0, -side), Quat::IDENTITY);
    course.add(BodyDesc::level(mesh), at);
}

/// On ground that is nowhere too steep it goes where it wants as fast as it wants, never leaves the ground, touches nothing, and stands still.
fn judge_rolling(seed: u64) -> Result<(), String> {
    let mut dice = Dice::new(seed);
    let mut course = Course::new(&mut dice);
    let spacing = 10.0_f32.powf(dice.in_range(-0.7, 0.7));
    let slope = dice.in_range(0.05, 0.9);
    let heights = terrain(&mut dice, slope, spacing);
    add_terrain(&mut course, &heights, spacing);
    let top = heights.iter().fold(0.0_f32, |a, b| a.max(*b));
    course.start(Vec3::new(0.0, top + 1.5, 0.0));
    course.stand(6.0);
    if course.state.footing.is_none() {
        return Err("does not land".into());
    }
    let half = 0.5 * spacing * (COLUMNS - 1) as f32 - 1.0;
    let mut wish = Vec2::ZERO;
    for step in 0..600 {
        if step % 30 == 0 {
            let to = dice.vector(-half, half);
            let from = course.place();
            let toward = Vec2::new(to.x - from.x, to.z - from.z).normalize_or_zero();
            wish = toward * dice.in_range(0.1, 6.0);
        }
        let before = course.place();
        course.step(wish);
        let after = course.place();
        if after.x.abs().max(after.z.abs()) > half {
            break;
        }
        let made = Vec2::new(after.x - before.x, after.z - before.z);
        let wanted = course.step_dt * wish;
        if made.distance(wanted) > 0.02 * wanted.length() + 1e-3 {
            return Err(format!("step {step}: made {made} of {wanted} at {after}"));
        }
        if course.state.footing.is_none() {
            return Err(format!("step {step}: leaves the ground at {after}"));
        }
        let gap = course.gap();
        if !(0.0..0.3).contains(&gap) {
            return Err(format!("step {step}: {gap} from the ground at {after}"));
        }
    }
    let still = course.place();
    course.stand(2.0);
    let drift = course.place().distance(still);
    if drift > 0.02 {
        return Err(format!("drifts by {drift}"));
    }
    Ok(())
}

/// Low steps do not stop it.
fn judge_steps(seed: u64) -> Result<(), String> {
    let mut dice = Dice::new(0x5000 + seed);
    let mut course = Course::new(&mut dice);
    course.add_box(
        Vec3::new(60.0, 1.0, 20.0),
        Pose::new(Vec3::new(0.0, -0.5, 0.0), Quat::IDENTITY),
    );
    for _ in 0..40 {
        let high = dice.in_range(0.02, 0.27);
        let size = Vec3::new(dice.in_range(0.2, 2.0), high, dice.in_range(0.2, 3.0));
        let at = Vec3::new(
            dice.in_range(-9.0, 9.0),
            0.5 * high,
            dice.in_range(-1.0, 1.0),
        );
        let turn = Quat::from_rotation_y(dice.in_range(0.0, 6.0));
        course.add_box(size, Pose::new(at, turn));
    }
    course.start(Vec3::new(-12.0, 1.5, 0.0));
    course.stand(1.0);
    let speed = dice.in_range(0.5, 6.0);
    let secs = 22.0 / speed;
    let steps = (secs / course.step_dt) as usize;
    for step in 0..steps {
        course.step(Vec2::new(speed, 0.0));
        let gap = course.gap();
        if !(-1e-4..0.35).contains(&gap) {
            return Err(format!(
                "step {step}: {gap} from the ground at {}",
                course.place()
            ));
        }
    }
    let share = (course.place().x + 12.0) / (speed * course.step_dt * steps as f32);
    if !(0.95..1.05).contains(&share) {
        return Err(format!("made {share} of the way, to {}", course.place()));
    }
    Ok(())
}

/// Walls around 20 by 20 units, and things to run into between them.
fn furnish(course: &mut Course, dice: &mut Dice) {
    let flat = |at: Vec3| Pose::new(at, Quat::IDENTITY);
    for side in [-1.0, 1.0] {
        course.add_box(
            Vec3::new(0.2, 40.0, 22.0),
            flat(Vec3::new(10.1 * side, 0.0, 0.0)),
        );
        course.add_box(
            Vec3::new(22.0, 40.0, 0.2),
            flat(Vec3::new(0.0, 0.0, 10.1 * side)),
        );
    }
    let unit = course.unit;
    for _ in 0..25 {
        let size = dice.in_range(0.3, 3.0);
        let [a, b, c] = [(); 3].map(|()| unit * size * dice.in_range(0.2, 1.0));
        let shape = match dice.below(5) {
            0 => ConvexMesh::cuboid(a, b, c),
            1 => ConvexMesh::sphere(0.5 * a),
            2 => ConvexMesh::cylinder(0.5 * a, b),
            3 => ConvexMesh::wedge(a, b, c),
            _ => ConvexMesh::icosphere(0.5 * a, 1),
        }
        .expect("valid");
        let at = Vec3::new(
            dice.in_range(-9.0, 9.0),
            dice.in_range(0.0, 2.0),
            dice.in_range(-9.0, 9.0),
        );
        if at.with_y(0.0).length() > 3.0 {
            course.add(
                BodyDesc::dynamic(shape, Vec3::ZERO),
                Pose::new(at, dice.rotation()),
            );
        }
    }
}

/// In a room full of things, however fast it goes, it is in nothing and within the walls.
fn judge_room(seed: u64) -> Result<(), String> {
    let mut dice = Dice::new(0x9000 + seed);
    let mut course = Course::new(&mut dice);
    let flat = |at: Vec3| Pose::new(at, Quat::IDENTITY);
    let mut bottom = 0.0_f32;
    if dice.below(2) == 0 {
        let heights = terrain(&mut dice, 3.0, 0.7);
        bottom = heights.iter().fold(0.0, |a, b| a.min(*b));
        add_terrain(&mut course, &heights, 0.7);
    } else {
        course.add_box(Vec3::new(30.0, 1.0, 30.0), flat(Vec3::new(0.0, -0.5, 0.0)));
    }
    furnish(&mut course, &mut dice);
    course.start(Vec3::new(0.0, 12.0, 0.0));
    course.stand(4.0);
    let speed = 10.0_f32.powf(dice.in_range(-0.5, 1.5));
    let mut wish = Vec2::ZERO;
    for step in 0..600 {
        if step % 20 == 0 {
            let to = dice.direction();
            wish = speed * Vec2::new(to.x, to.z);
        }
        course.step(wish);
        let gap = course.gap();
        if gap < -1e-3 {
            return Err(format!(
                "step {step}: {gap} inside at {} with {wish}",
                course.place()
            ));
        }
        let at = course.place();
        if at.x.abs().max(at.z.abs()) > 10.0 || at.y < bottom {
            return Err(format!("step {step}: gets out at {at}"));
        }
    }
    Ok(())
}

/// It walks up what is not too steep as fast as over level ground, and not up what is steeper.
fn judge_steep(seed: u64) -> Result<(), String> {
    let mut dice = Dice::new(0xd000 + seed);
    let mut course = Course::new(&mut dice);
    let goes_up = dice.below(2) == 0;
    course.settings.max_slope = dice.in_range(0.3, 1.5);
    let share = if goes_up {
        dice.in_range(0.2, 0.95)
    } else {
        dice.in_range(1.05, 3.0)
    };
    let tilt = (share * course.settings.max_slope).atan();
    let flat = |at: Vec3| Pose::new(at, Quat::IDENTITY);
    course.add_box(
        Vec3::new(40.0, 1.0, 20.0),
        flat(Vec3::new(-17.0, -0.5, 0.0)),
    );
    // Its upper side goes through the origin, and rises along x.
    let turn = Quat::from_rotation_z(tilt);
    let at = Pose::new(turn * Vec3::new(15.0, -0.5, 0.0), turn);
    course.add_box(Vec3::new(60.0, 1.0, 20.0), at);
    course.start(Vec3::new(-2.0, 1.5, 0.0));
    course.stand(1.0);
    let (speed, start) = (dice.in_range(0.5, 6.0), course.place());
    let steps = (8.0 / speed / course.step_dt) as usize;
    for step in 0..steps {
        course.step(Vec2::new(speed, dice.in_range(-0.1, 0.1)));
        let (gap, at) = (course.gap(), course.place());
        if gap < -1e-4 {
            return Err(format!("step {step}: {gap} in the ground at {at}"));
        }
        if !goes_up && at.y - start.y > 0.35 {
            return Err(format!(
                "step {step}: up {share} of the steepest slope to {at}"
            ));
        }
    }
    let made = (course.place().x - start.x) / (speed * course.step_dt * steps as f32);
    if goes_up && !(0.97..1.03).contains(&made) {
        return Err(format!(
            "{made} of the way up {share} of the steepest slope"
        ));
    }
    Ok(())
}

/// It stays where it is on what moves and turns under it, and walks there as on what stands.
fn judge_ride(seed: u64) -> Result<(), String> {
    let mut dice = Dice::new(0xe000 + seed);
    let mut course = Course::new(&mut dice);
    course.add_box(
        Vec3::new(12.0, 1.0, 12.0),
        Pose::new(Vec3::new(0.0, -0.5, 0.0), Quat::IDENTITY),
    );
    let slot = course.simulation.bodies.iter().next().expect("a platform");
    course.start(Vec3::new(
        dice.in_range(-3.0, 3.0),
        1.5,
        dice.in_range(-3.0, 3.0),
    ));
    course.stand(1.0);
    let up = course.settings.up;
    let linear = course.unit * dice.in_range(0.0, 4.0) * dice.direction();
    let angular = [0.0, dice.in_range(-1.5, 1.5)][dice.below(2)] * up;
    (course
        .simulation
        .bodies
        .set_kind(slot, RigidBody::Kinematic))
    .expect("usable");
    (course.simulation.bodies.set_velocity(slot, linear, angular)).expect("finite");
    let on_platform = |course: &Course| {
        let pose = course.simulation.bodies.pose(slot);
        pose.inverse_transform_point(course.state.position) / course.unit
    };
    let start = on_platform(&course);
    let mut worst = 0.0_f32;
    for step in 0..(3.0 / course.step_dt) as usize {
        course.step(Vec2::ZERO);
        course.simulation.step(course.step_dt);
        let drift = on_platform(&course).distance(start);
        worst = worst.max(drift);
        if course.state.footing.is_none() {
            return Err(format!("step {step}: loses the ground"));
        }
    }
    if worst > 0.01 {
        return Err(format!("up to {worst} away from where it stood"));
    }
    Ok(())
}

/// Settings that mean nothing do no harm: it stays somewhere.
fn judge_unusable(seed: u64) -> Result<(), String> {
    let mut dice = Dice::new(0xf000 + seed);
    let mut course = Course::new(&mut dice);
    let flat = |at: Vec3| Pose::new(at, Quat::IDENTITY);
    course.add_box(Vec3::new(20.0, 1.0, 20.0), flat(Vec3::new(0.0, -0.5, 0.0)));
    course.add_box(Vec3::new(1.0, 0.2, 20.0), flat(Vec3::new(2.0, 0.1, 0.0)));
    course.start(Vec3::new(0.0, 1.5, 0.0));
    course.stand(1.0);
    let bad = [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e30][dice.below(5)];
    match dice.below(4) {
        0 => course.settings.step_height = bad,
        1 => course.settings.skin = bad,
        2 => course.settings.max_slope = bad,
        _ => course.settings.up = bad * course.settings.up,
    }
    for _ in 0..60 {
        course.step(Vec2::new(3.0, dice.in_range(-0.1, 0.1)));
        let at = course.state.position;
        if !at.is_finite() {
            return Err(format!("{:?} brings it to {at}", course.settings));
        }
    }
    Ok(())
}

/// How many scenes of a law are judged; more show nothing more, but take longer.
const SCENES: u64 = 100;

fn check(law: fn(u64) -> Result<(), String>) {
    let broken: Vec<String> = (0..SCENES)
        .filter_map(|seed| law(seed).err().map(|why| format!("{seed}: {why}")))
        .collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn it_goes_over_rolling_ground_as_it_wants_to() {
    check(judge_rolling);
}

#[test]
fn low_steps_do_not_stop_it() {
    check(judge_steps);
}

#[test]
fn it_gets_into_nothing_and_out_of_no_room() {
    check(judge_room);
}

#[test]
fn it_goes_up_all_slopes_that_are_not_too_steep_and_no_others() {
    check(judge_steep);
}

#[test]
fn it_stays_where_it_is_on_what_moves_and_turns() {
    check(judge_ride);
}

#[test]
fn settings_that_mean_nothing_do_no_harm() {
    check(judge_unusable);
}
