//! Islands at rest fall asleep, cost nothing, and wake when anything about them changes.

use crate::common::dice::Dice;
use crate::common::states::bits_by_id;
use crate::common::structures::{
    block, cuboid, fixed, floor, pyramid, rolling_prism, slope_box, tower,
};
use allocation_counter::measure;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// Length of a step, s.
const H: f32 = 1.0 / 60.0;

fn sleepy(bodies: impl IntoIterator<Item = BodyDesc>) -> Simulation {
    let mut simulation = Simulation::default();
    simulation.config.sleep = SleepConfig::default();
    for desc in bodies {
        simulation.bodies.insert(desc).expect("usable");
    }
    simulation
}

fn run(simulation: &mut Simulation, steps: usize) {
    (0..steps).for_each(|_| simulation.step(H));
}

/// Steps until all dynamic bodies sleep.
fn fall_asleep(simulation: &mut Simulation) {
    let mut steps = 0;
    while steps == 0 || simulation.report.awake > 0 {
        simulation.step(H);
        steps += 1;
        assert!(steps < 900, "still {} awake", simulation.report.awake);
    }
}

/// A simulation of `bodies` that sleeps.
fn asleep(bodies: impl IntoIterator<Item = BodyDesc>) -> Simulation {
    let mut simulation = sleepy(bodies);
    fall_asleep(&mut simulation);
    simulation
}

/// Farthest that a body of `a` is from the same one of `b`, m.
fn distance(a: &Simulation, b: &Simulation) -> f32 {
    let way = |slot| {
        let (x, y) = (a.bodies.center_of_mass(slot), b.bodies.center_of_mass(slot));
        x.distance(y)
    };
    a.bodies.iter().map(way).fold(0.0, f32::max)
}

/// Runs a scene with sleep and without, side by side; they must not get farther apart than `bound` (m). How many slept in
/// the end.
fn compare_with_sleepless(scene: &[BodyDesc], seconds: f32, bound: f32) -> usize {
    let mut sleepless = sleepy(scene.iter().cloned());
    sleepless.config.sleep.enabled = false;
    let mut simulation = sleepy(scene.iter().cloned());
    for step in 0..(seconds / H) as usize {
        simulation.step(H);
        sleepless.step(H);
        let apart = distance(&simulation, &sleepless);
        assert!(apart <= bound, "{apart} m apart in step {step}");
    }
    assert_eq!(sleepless.report.asleep, 0);
    simulation.report.asleep
}

fn cube() -> ConvexMesh {
    cuboid(Vec3::ONE)
}

/// A unit cube on a static slab, asleep; slot 0 is the slab, slot 1 the cube.
fn cube_on_slab(kind: RigidBody) -> Simulation {
    let mut slab = fixed(&cuboid(Vec3::new(6.0, 1.0, 6.0)), -0.5 * Vec3::Y, 0.6);
    slab.kind = kind;
    asleep([slab, block(&cube(), 0.5 * Vec3::Y, 0.6)])
}

/// The cube in slot 1 is awake after the next step.
fn assert_wakes(mut simulation: Simulation) -> Simulation {
    simulation.step(H);
    assert!(!simulation.bodies.is_asleep(1), "still asleep");
    assert_eq!(simulation.report.asleep, 0);
    simulation
}

/// The cube in slot 1 wakes and falls.
fn assert_falls(simulation: Simulation) {
    let mut simulation = assert_wakes(simulation);
    run(&mut simulation, 29);
    let height = simulation.bodies.center_of_mass(1).y;
    assert!(height < -0.5, "it hangs at {height} m");
}

#[test]
fn a_tower_falls_asleep_and_keeps_every_bit() {
    let mut simulation = asleep(tower(10));
    assert_eq!((simulation.report.awake, simulation.report.asleep), (0, 10));
    let before = bits_by_id(&simulation);
    run(&mut simulation, 200);
    assert_eq!(bits_by_id(&simulation), before);
    assert_eq!(
        simulation.report.manifolds, 0,
        "sleeping pairs make no work"
    );
    for slot in 1..=10 {
        assert_eq!(simulation.bodies.velocity(slot), (Vec3::ZERO, Vec3::ZERO));
    }
}

#[test]
fn nothing_sleeps_where_sleep_is_off() {
    let mut simulation = Simulation::default();
    simulation.config.sleep = SleepConfig::off();
    for desc in tower(3) {
        simulation.bodies.insert(desc).expect("usable");
    }
    run(&mut simulation, 120);
    assert_eq!((simulation.report.awake, simulation.report.asleep), (3, 0));
}

#[test]
fn a_whole_island_sleeps_or_none_of_it() {
    let mut simulation = sleepy(pyramid(4));
    let mut last = 0;
    for _ in 0..300 {
        simulation.step(H);
        assert!([0, 10].contains(&simulation.report.asleep));
        last = simulation.report.asleep;
    }
    assert_eq!(last, 10);
}

#[test]
fn islands_sleep_one_by_one() {
    let mut simulation = asleep(tower(2));
    let distant = block(&cube(), Vec3::new(10.0, 3.0, 0.0), 0.6);
    simulation.bodies.insert(distant).expect("usable");
    run(&mut simulation, 10);
    assert_eq!((simulation.report.awake, simulation.report.asleep), (1, 2));
    fall_asleep(&mut simulation);
    assert_eq!(simulation.report.asleep, 3);
}

#[test]
fn piles_fall_asleep() {
    let mut simulation = sleepy(crate::common::scenes::heap(60));
    run(&mut simulation, 1200);
    assert!(simulation.report.asleep >= 55, "{:?}", simulation.report);
}

#[test]
fn a_small_scene_falls_asleep_like_a_large_one() {
    let shape = cuboid(Vec3::splat(0.02));
    let dice = (0..4).map(|i| block(&shape, Vec3::Y * (0.01 + 0.02 * i as f32), 0.6));
    asleep(std::iter::once(floor(0.6)).chain(dice));
}

#[test]
fn a_velocity_wakes() {
    let mut simulation = cube_on_slab(RigidBody::Static);
    let up = 5.0 * Vec3::Y;
    simulation
        .bodies
        .set_velocity(1, up, Vec3::ZERO)
        .expect("usable");
    let simulation = assert_wakes(simulation);
    assert!(simulation.bodies.center_of_mass(1).y > 0.55);
}

#[test]
fn no_velocity_and_the_same_pose_do_not_wake() {
    let mut simulation = cube_on_slab(RigidBody::Static);
    let bodies = &mut simulation.bodies;
    for slot in [0, 1] {
        let pose = bodies.pose(slot);
        bodies.set_pose(slot, pose).expect("usable");
        bodies
            .set_velocity(slot, Vec3::ZERO, Vec3::ZERO)
            .expect("usable");
    }
    simulation.step(H);
    assert!(simulation.bodies.is_asleep(1));
}

#[test]
fn a_pose_wakes() {
    let mut simulation = cube_on_slab(RigidBody::Static);
    let aside = Pose::new(Vec3::new(0.0, 0.5, 10.0), Quat::IDENTITY);
    simulation.bodies.set_pose(1, aside).expect("usable");
    assert_falls(simulation);
}

#[test]
fn a_call_wakes_for_the_time_of_rest() {
    let mut simulation = asleep(tower(5));
    simulation.bodies.wake(3);
    assert_eq!(
        simulation.bodies.asleep(),
        0,
        "the whole island wakes at once"
    );
    run(&mut simulation, 25);
    assert_eq!(simulation.report.asleep, 0);
    fall_asleep(&mut simulation);
}

#[test]
fn a_body_that_lands_wakes_what_it_hits_and_pushes_it_in_the_same_step() {
    let mut simulation = asleep([floor(0.6), block(&cube(), 0.5 * Vec3::Y, 0.6)]);
    let mut bullet = block(&cuboid(Vec3::splat(0.4)), Vec3::new(-3.0, 0.5, 0.0), 0.6);
    bullet.linear_velocity = 20.0 * Vec3::X;
    simulation.bodies.insert(bullet).expect("usable");
    let mut steps = 0;
    while simulation.bodies.is_asleep(1) {
        simulation.step(H);
        steps += 1;
        assert!(steps < 20, "it flies through");
    }
    assert!(simulation.bodies.velocity(1).0.x > 0.5 || steps < 7);
    run(&mut simulation, 5);
    assert!(simulation.bodies.velocity(1).0.x > 0.5);
}

#[test]
fn a_body_that_passes_by_does_not_wake() {
    let mut simulation = asleep([floor(0.0), block(&cube(), 0.5 * Vec3::Y, 0.6)]);
    let mut passer = block(&cube(), Vec3::new(-3.0, 0.5, 1.2), 0.0);
    passer.linear_velocity = 5.0 * Vec3::X;
    let passer = simulation.bodies.insert(passer).expect("usable");
    for _ in 0..120 {
        simulation.step(H);
        assert!(simulation.bodies.is_asleep(1));
    }
    assert!(simulation.bodies.center_of_mass(passer).x > 3.0);
}

#[test]
fn gravity_wakes() {
    let mut simulation = cube_on_slab(RigidBody::Static);
    simulation.gravity = Gravity(3.0 * Vec3::Y);
    let simulation = assert_wakes(simulation);
    assert!(simulation.bodies.velocity(1).0.y > 0.0);
}

#[test]
fn removing_the_floor_wakes() {
    let mut simulation = cube_on_slab(RigidBody::Static);
    simulation.bodies.remove(0);
    assert_falls(simulation);
}

#[test]
fn a_floor_that_is_replaced_in_the_same_slot_wakes() {
    let mut simulation = cube_on_slab(RigidBody::Static);
    simulation.bodies.remove(0);
    let elsewhere = fixed(&cube(), 100.0 * Vec3::X, 0.6);
    assert_eq!(
        simulation.bodies.insert(elsewhere),
        Ok(0),
        "slots are reused"
    );
    assert_falls(simulation);
}

#[test]
fn a_floor_that_is_moved_away_wakes() {
    for kind in [RigidBody::Static, RigidBody::Kinematic] {
        let mut simulation = cube_on_slab(kind);
        let below = Pose::new(-5.0 * Vec3::Y, Quat::IDENTITY);
        simulation.bodies.set_pose(0, below).expect("usable");
        assert_falls(simulation);
    }
}

#[test]
fn a_platform_that_starts_to_move_wakes() {
    for speed in [-8.0, -0.01, 0.01, 2.0] {
        let mut simulation = cube_on_slab(RigidBody::Kinematic);
        let velocity = speed * Vec3::Y;
        simulation
            .bodies
            .set_velocity(0, velocity, Vec3::ZERO)
            .expect("usable");
        let mut simulation = assert_wakes(simulation);
        run(&mut simulation, 30);
        assert_eq!(simulation.report.asleep, 0, "nothing sleeps on what moves");
        let height = simulation.bodies.center_of_mass(1).y;
        assert!((height - 0.5) * speed > 0.0, "{height} m at {speed} m/s");
    }
}

#[test]
fn other_layers_of_the_floor_wake() {
    let mut simulation = cube_on_slab(RigidBody::Static);
    let mut slab = fixed(&cuboid(Vec3::new(6.0, 1.0, 6.0)), -0.5 * Vec3::Y, 0.6);
    let shape = simulation.bodies.convex(0).expect("convex").clone();
    slab.shape = Shape::Convex(shape);
    simulation
        .bodies
        .redescribe(0, slab.clone())
        .expect("usable");
    simulation.step(H);
    assert!(simulation.bodies.is_asleep(1), "nothing has changed yet");
    slab.layers = CollisionLayers {
        memberships: 2,
        filters: 0,
    };
    simulation.bodies.redescribe(0, slab).expect("usable");
    assert_falls(simulation);
}

#[test]
fn a_smaller_shape_of_the_floor_wakes() {
    let mut simulation = cube_on_slab(RigidBody::Static);
    let thinner = fixed(&cuboid(Vec3::new(6.0, 0.1, 6.0)), Vec3::ZERO, 0.6);
    simulation.bodies.redescribe(0, thinner).expect("usable");
    let mut simulation = assert_wakes(simulation);
    fall_asleep(&mut simulation);
    let height = simulation.bodies.center_of_mass(1).y;
    assert!((height - 0.05).abs() < 1e-3, "{height} m");
}

#[test]
fn another_friction_or_strength_wakes() {
    let simulation = || cube_on_slab(RigidBody::Static);
    let mut slippery = simulation();
    slippery
        .bodies
        .redescribe(1, block(&cube(), Vec3::ZERO, 0.1))
        .expect("usable");
    assert_wakes(slippery);
    let mut fragile = simulation();
    let weak = Fracturable::with_strength(1.0);
    fragile.bodies.set_fracturable(1, Some(weak));
    let fragile = assert_wakes(fragile);
    assert_eq!(fragile.fractures.done.len(), 0, "what it bears is no blow");
}

#[test]
fn removing_one_body_wakes_those_on_it() {
    let mut simulation = asleep(tower(4));
    simulation.bodies.remove(2);
    simulation.step(H);
    assert_eq!(simulation.report.asleep, 0);
    run(&mut simulation, 59);
    assert!(simulation.bodies.center_of_mass(4).y < 3.0, "it hangs");
}

#[test]
fn a_cut_wakes_and_the_pieces_move_as_if_nothing_had_slept() {
    let mut simulation = asleep(tower(4));
    let mut sleepless = sleepy(tower(4));
    sleepless.config.sleep.enabled = false;
    run(&mut sleepless, 100);
    let steep = Plane::through(1.5 * Vec3::Y, Vec3::new(1.0, 0.3, 0.0).normalize());
    for simulation in [&mut simulation, &mut sleepless] {
        simulation.slice(2, steep).expect("a body");
        run(simulation, 2);
        let report = &simulation.report;
        assert_eq!((report.awake, report.asleep), (5, 0));
        run(simulation, 20);
    }
    let apart = distance(&simulation, &sleepless);
    assert!(apart < 2e-3, "{apart} m");
}

#[test]
fn a_static_body_that_appears_inside_wakes() {
    let mut simulation = cube_on_slab(RigidBody::Static);
    let wedge = fixed(&cuboid(Vec3::splat(0.5)), Vec3::new(0.6, 0.3, 0.0), 0.6);
    simulation.bodies.insert(wedge).expect("usable");
    assert_wakes(simulation);
}

#[test]
fn turning_sleep_off_wakes_everything() {
    let mut simulation = cube_on_slab(RigidBody::Static);
    simulation.config.sleep.enabled = false;
    let mut simulation = assert_wakes(simulation);
    run(&mut simulation, 120);
    assert_eq!(simulation.report.asleep, 0);
}

#[test]
fn a_body_that_leaves_the_simulation_for_its_state_wakes_what_it_bears() {
    let mut simulation = cube_on_slab(RigidBody::Static);
    let on_top = block(&cube(), 1.5 * Vec3::Y, 0.6);
    simulation.bodies.insert(on_top).expect("usable");
    fall_asleep(&mut simulation);
    simulation.bodies.remove(1);
    simulation.step(H);
    assert_eq!(simulation.report.awake, 1);
}

#[test]
fn nothing_sleeps_in_the_air() {
    let mut thrown = block(&cube(), 2.0 * Vec3::Y, 0.6);
    thrown.linear_velocity = 6.0 * Vec3::Y;
    let mut bouncing = block(&cube(), Vec3::new(5.0, 3.0, 0.0), 0.6);
    bouncing.restitution = Restitution::new(0.9);
    let scene = [floor(0.6), thrown, bouncing];
    assert_eq!(compare_with_sleepless(&scene, 12.0, 2e-3), 2);
}

#[test]
fn nothing_sleeps_at_a_slow_apex_beside_a_wall() {
    let wall = fixed(&cuboid(Vec3::new(1.0, 9.0, 9.0)), -Vec3::X, 0.0);
    let mut simulation = sleepy([wall, block(&cube(), Vec3::ZERO, 0.0)]);
    simulation.gravity = Gravity(-2e-3 * Vec3::Y);
    simulation.config.sleep.drift = 0.1;
    simulation.config.sleep.speed = 0.5;
    simulation
        .bodies
        .set_velocity(1, 1e-3 * Vec3::Y, Vec3::ZERO)
        .expect("usable");
    for _ in 0..120 {
        simulation.step(H);
        assert_eq!(simulation.report.contacts, 4, "it touches the wall");
        assert_eq!(simulation.report.asleep, 0, "but nothing bears it");
    }
}

#[test]
fn without_gravity_only_what_does_not_move_sleeps() {
    let mut simulation = sleepy([floor(0.6), block(&cube(), 0.5 * Vec3::Y, 0.6)]);
    simulation
        .bodies
        .insert(block(&cube(), 20.0 * Vec3::Y, 0.6))
        .expect("usable");
    simulation.gravity = Gravity(Vec3::ZERO);
    simulation
        .bodies
        .set_velocity(1, 1e-6 * Vec3::X, Vec3::ZERO)
        .expect("usable");
    run(&mut simulation, 120);
    assert_eq!(
        simulation.report.asleep, 0,
        "one creeps, nothing holds the other"
    );
}

#[test]
fn a_body_that_rocks_stays_awake_until_it_rests() {
    for (rate, seconds) in [(0.3, 10.0), (1.0, 40.0)] {
        let scene = rolling_prism(16, 0.0, rate);
        assert_eq!(compare_with_sleepless(&scene, seconds, 2e-3), 1);
    }
}

#[test]
fn what_creeps_down_a_slope_stays_awake_and_what_holds_sleeps() {
    // Friction 0.5 holds up to 26.565 degrees; 0.05 degrees more leave an acceleration of 1e-3 g.
    for size in [0.02, 0.2, 1.0].map(Vec3::splat) {
        let mut creeping = sleepy(slope_box(size, 0.5, 26.615, 0.0));
        let mut holding = sleepy(slope_box(size, 0.5, 26.515, 0.0));
        for _ in 0..300 {
            creeping.step(H);
            holding.step(H);
            assert_eq!(creeping.report.asleep, 0, "{size}");
        }
        assert_eq!(holding.report.asleep, 1, "{size}");
    }
}

/// A rod along x.
fn rod(length: f32, slenderness: f32) -> ConvexMesh {
    let thickness = length / slenderness;
    cuboid(Vec3::new(length, thickness, thickness))
}

#[test]
fn rods_across_each_other_come_to_rest_and_sleep() {
    let mut random = Dice::new(30);
    for member in 0..24 {
        let length = 0.05 / random.in_range(0.005, 1.0);
        let slenderness = 1.0 / random.in_range(1e-3, 0.1);
        let shape = rod(length, slenderness);
        let mut simulation = sleepy([floor(0.5)]);
        for level in 0..3 {
            let height = (level as f32 + 0.6) * 1.1 * length / slenderness;
            let heading = 6.0 * random.unit();
            simulation
                .bodies
                .insert(BodyDesc {
                    pose: Pose::new(
                        Vec3::new(0.0, height, 0.0),
                        Quat::from_xyzw(0.0, heading, 0.0, 1.0).normalize(),
                    ),
                    ..block(&shape, Vec3::ZERO, 0.5)
                })
                .expect("usable");
        }
        run(&mut simulation, 600);
        let asleep = simulation.report.asleep;
        assert_eq!(asleep, 3, "{member}: {length} m, 1 : {slenderness}");
    }
}

#[test]
fn a_rod_whose_ends_move_stays_awake() {
    for slenderness in [10.0, 100.0, 1000.0] {
        let slow = 0.01 * (9.81_f32 / slenderness).sqrt();
        let swinging = BodyDesc {
            angular_velocity: 2.0 * slow / 0.5 * Vec3::Y,
            ..block(&rod(1.0, slenderness), 0.5 * Vec3::Y / slenderness, 0.0)
        };
        let mut simulation = sleepy([floor(0.0), swinging]);
        run(&mut simulation, 120);
        assert_eq!(simulation.report.asleep, 0, "1 : {slenderness}");
    }
}

/// Largest kinetic energy of all bodies over 25 steps, J.
fn liveliest(simulation: &mut Simulation) -> f64 {
    let energy = |simulation: &mut Simulation| -> f64 {
        simulation.step(H);
        let bodies = &simulation.bodies;
        bodies.iter().map(|slot| bodies.kinetic_energy(slot)).sum()
    };
    (0..25).map(|_| energy(simulation)).fold(0.0, f64::max)
}

#[test]
fn a_tower_of_20_wakes_as_calm_as_one_that_never_slept() {
    let mut sleepless = sleepy(tower(20));
    sleepless.config.sleep.enabled = false;
    run(&mut sleepless, 200);
    let usual = liveliest(&mut sleepless);
    let mut simulation = asleep(tower(20));
    run(&mut simulation, 100);
    let before: Vec<Vec3> = (1..=20)
        .map(|s| simulation.bodies.center_of_mass(s))
        .collect();
    simulation.bodies.wake(1);
    let woken = liveliest(&mut simulation);
    assert_eq!(simulation.report.asleep, 0);
    assert!(
        woken < 1.5 * usual,
        "{woken} J after sleep, {usual} J without"
    );
    let way = |(slot, x): (u32, &Vec3)| simulation.bodies.center_of_mass(slot).distance(*x);
    let drift = (1..).zip(&before).map(way).fold(0.0, f32::max);
    assert!(drift < 5e-4, "{drift} m");
}

#[test]
fn multipliers_survive_sleep_and_start_the_first_step_after_it() {
    let mut simulation = asleep(tower(20));
    run(&mut simulation, 100);
    let (floor, lowest) = (simulation.bodies.id(0), simulation.bodies.id(1));
    let entries = simulation.cache.entries_of(floor, lowest);
    let (count, borne) = entries.fold((0, 0.0), |(count, sum), entry| {
        assert_eq!(entry.age, 0);
        (count + 1, sum + entry.normal_impulse)
    });
    let weight = 20.0 * 1000.0 * 9.81 * H;
    assert!(
        count == 4 && (borne / weight - 1.0).abs() < 0.02,
        "{borne} N s"
    );
    simulation.bodies.wake(1);
    simulation.step(H);
    assert_eq!(simulation.report.cache.exact_hits, 80);
}

#[test]
fn another_step_length_scales_the_multipliers_that_were_kept() {
    let mut simulation = asleep(tower(5));
    simulation.step(0.5 * H);
    simulation.bodies.wake(1);
    let mut fastest = 0.0_f32;
    for _ in 0..20 {
        simulation.step(0.5 * H);
        fastest = fastest.max(simulation.bodies.velocity(5).0.length());
    }
    assert!(fastest < 5e-3, "{fastest} m/s");
}

#[test]
fn a_settled_body_sleeps_at_once_and_one_that_falls_does_not() {
    let mut simulation = sleepy(tower(3));
    let falling = block(&cube(), Vec3::new(9.0, 5.0, 0.0), 0.6);
    simulation.bodies.insert(falling).expect("usable");
    (1..=4).for_each(|slot| simulation.bodies.request_sleep(slot));
    run(&mut simulation, 2);
    assert_eq!((simulation.report.awake, simulation.report.asleep), (1, 3));
}

#[test]
fn sleeping_waking_and_steps_asleep_allocate_nothing_once_warm() {
    let mut simulation = asleep(tower(5));
    let cycle = |simulation: &mut Simulation| {
        simulation.bodies.wake(2);
        fall_asleep(simulation);
        run(simulation, 20);
    };
    cycle(&mut simulation);
    let allocated = measure(|| cycle(&mut simulation));
    assert_eq!(allocated.count_total, 0, "{allocated:?}");
}

/// What gravity, weak, strong or turned round for a body, and a force of its own press against a wall; once only what acts in full was
/// counted as borne.
#[test]
fn what_rests_under_other_forces_than_gravity_sleeps() {
    for seed in 0..60 {
        let dice = &mut Dice::new(seed);
        let pull = dice.direction();
        let wall = BodyDesc::floor(HalfSpaceShape { normal: -pull });
        let mut simulation = sleepy([wall]);
        let (scale, share) = (dice.in_range(0.05, 3.0), dice.in_range(0.0, 0.9));
        let (gravity, scale, force) = match seed % 4 {
            0 => (9.81, scale, 0.0),
            1 => (-9.81, -scale, 0.0),
            2 => (0.0, 1.0, 9.81 * scale),
            _ => (9.81, 1.0, -9.81 * share),
        };
        simulation.gravity = Gravity(gravity * pull);
        for i in 0..2_u8 {
            let mut body = BodyDesc::dynamic(cube(), -(0.5 + f32::from(i)) * pull);
            body.pose.rotation = Quat::from_rotation_arc(Vec3::Y, -pull);
            let mass = body.density;
            let slot = simulation.bodies.insert(body).expect("usable");
            let drive = BodyDrive {
                gravity_scale: scale,
                force: mass * force * pull,
                ..BodyDrive::default()
            };
            simulation.bodies.set_drive(slot, drive).expect("usable");
        }
        run(&mut simulation, 120);
        let awake = simulation.report.awake;
        assert_eq!(
            awake, 0,
            "{seed}: gravity {gravity}, scale {scale}, {force}"
        );
    }
}
