//! A capsule that walks: over a mesh, up steps and slopes, along walls, on lifts and turntables, and into what can be pushed.

use crate::common::scenes::awake;
use bevy_app::{App, TaskPoolPlugin};
use bevy_cleave::prelude::*;
use bevy_cleave::query::{Push, Slider, WalkInput, WalkSettings, WalkState};
use bevy_ecs::bundle::Bundle;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use glam::{Quat, Vec3};

const H: f32 = 1.0 / 60.0;
const RADIUS: f32 = 0.3;
const LENGTH: f32 = 1.0;
/// Height of its frame when it stands on level ground, m.
const STANDING: f32 = RADIUS + 0.5 * LENGTH;

/// Moves a character for a step; what it pushes.
pub(crate) fn walked(
    simulation: &mut Simulation,
    how: (&Slider, &WalkSettings),
    state: &mut WalkState,
    (input, filter): (&WalkInput, &QueryFilter),
) -> Vec<Push> {
    let mut pushes = Vec::new();
    let queries = simulation.queries();
    queries.walk(how, state, input, filter, &mut pushes);
    pushes
}

/// A scene and a character in it.
struct Course {
    simulation: Simulation,
    state: WalkState,
    settings: WalkSettings,
}

impl Course {
    fn new(grounds: Vec<BodyDesc>, start: Vec3) -> Self {
        let mut simulation = awake();
        for ground in grounds {
            simulation.bodies.insert(ground).expect("usable");
        }
        simulation.step(H);
        Self {
            simulation,
            state: WalkState {
                position: start,
                rotation: Quat::IDENTITY,
                ..WalkState::default()
            },
            settings: WalkSettings::default(),
        }
    }

    fn step_with(&mut self, velocity: Vec3, jump: f32) {
        let capsule = QueryShape::capsule(RADIUS, LENGTH).expect("usable");
        self.step_as(capsule, velocity, jump);
    }

    fn step_as(&mut self, shape: QueryShape, velocity: Vec3, jump: f32) {
        let slider = Slider { shape, skin: 0.01 };
        let input = WalkInput {
            velocity,
            jump,
            gravity: self.simulation.gravity.0,
            step_dt: H,
        };
        let how = (&slider, &self.settings);
        let filter = QueryFilter::all();
        let pushes = walked(
            &mut self.simulation,
            how,
            &mut self.state,
            (&input, &filter),
        );
        let bodies = &mut self.simulation.bodies;
        for push in pushes {
            push.apply(bodies, H).expect("finite");
        }
        self.simulation.step(H);
    }

    fn walk(&mut self, velocity: Vec3, secs: f32) -> Vec3 {
        for _ in 0..(secs / H) as usize {
            self.step_with(velocity, 0.0);
        }
        self.state.position
    }
}

fn floor() -> BodyDesc {
    BodyDesc::floor(HalfSpaceShape::new(Vec3::Y).expect("a unit vector"))
}

fn cuboid(size: Vec3, center: Vec3) -> BodyDesc {
    let mesh = ConvexMesh::cuboid(size.x, size.y, size.z).expect("a box");
    BodyDesc {
        kind: RigidBody::Static,
        ..BodyDesc::dynamic(mesh, center)
    }
}

/// A strip of triangles along x with these heights at each metre, 4 m wide.
fn strip(heights: &[f32]) -> BodyDesc {
    let mut positions = Vec::new();
    for (i, &height) in heights.iter().enumerate() {
        positions.extend([-2.0, 2.0].map(|z| Vec3::new(i as f32, height, z)));
    }
    let quads = (0..heights.len() as u32 - 1).map(|i| 2 * i);
    let triangles: Vec<[u32; 3]> = quads
        .flat_map(|i| [[i, i + 1, i + 2], [i + 2, i + 1, i + 3]])
        .collect();
    BodyDesc::level(StaticMesh::new(&positions, &triangles).expect("a level"))
}

/// A character as a capsule, and the same one of two parts: the capsule, and one that lies within it.
fn as_one_and_as_two() -> (ConvexMesh, Compound) {
    let capsule = ConvexMesh::capsule(RADIUS, LENGTH).expect("usable");
    let core = ConvexMesh::cuboid(0.2, 0.6, 0.2).expect("a box");
    let parts = [(Pose::IDENTITY, capsule.clone()), (Pose::IDENTITY, core)];
    (capsule, Compound::new(parts).expect("usable"))
}

#[test]
fn a_shape_of_parts_walks_as_its_outline_does() {
    let (capsule, compound) = as_one_and_as_two();
    let grounds = || {
        let heights = [
            0.0, 0.1, 0.2, 0.1, -0.1, -0.2, -0.2, 0.0, 0.1, 0.2, 0.1, 0.0,
        ];
        let wall = cuboid(Vec3::new(0.5, 3.0, 4.0), Vec3::new(9.0, 1.0, 0.0));
        let step = cuboid(Vec3::new(1.0, 0.2, 4.0), Vec3::new(6.0, -0.15, 0.0));
        vec![strip(&heights), wall, step]
    };
    let run = |shape: QueryShape| {
        let mut course = Course::new(grounds(), Vec3::new(1.0, STANDING + 0.3, 0.0));
        let mut places = Vec::new();
        for _ in 0..360 {
            course.step_as(shape, Vec3::new(2.0, 0.0, 0.1), 0.0);
            places.push(course.state.position);
        }
        places
    };
    let one = run(QueryShape::from(&capsule));
    let two = run(QueryShape::from(&compound));
    assert!(one[359].x > 7.0, "{}", one[359]);
    assert_eq!(one, two);
}

#[test]
fn on_level_ground_it_goes_as_fast_as_it_wants_to() {
    for ground in [floor(), strip(&[0.0; 30])] {
        let mut course = Course::new(vec![ground], Vec3::new(1.0, STANDING + 0.3, 0.0));
        let start = course.walk(Vec3::ZERO, 1.0);
        assert!((start.y - STANDING).abs() < 0.02, "{start}");
        assert!(course.state.footing.is_some());
        let end = course.walk(3.0 * Vec3::X, 5.0);
        assert!((end.x - start.x - 15.0).abs() < 0.1, "{start} {end}");
        assert!(
            (end.y - start.y).abs() < 2e-3 && end.z.abs() < 1e-3,
            "{end}"
        );
    }
}

#[test]
fn it_walks_up_the_slopes_that_it_may_and_no_steeper_ones() {
    for (rise, goes_up) in [
        (0.3, true),
        (0.6, true),
        (0.9, true),
        (1.2, false),
        (2.5, false),
    ] {
        let mut heights = vec![0.0; 4];
        heights.extend((1..12).map(|i| rise * i as f32));
        let mut course = Course::new(vec![strip(&heights)], Vec3::new(1.0, STANDING, 0.0));
        let end = course.walk(2.0 * Vec3::X, 4.0);
        if goes_up {
            assert!(end.x > 8.0, "rise {rise}: {end}");
            // And down again, without leaving the ground.
            for _ in 0..120 {
                course.step_with(-2.0 * Vec3::X, 0.0);
                assert!(
                    course.state.footing.is_some(),
                    "rise {rise}: {}",
                    course.state.position
                );
            }
        } else {
            assert!(end.x < 3.6 && end.y < STANDING + 0.4, "rise {rise}: {end}");
        }
    }
}

#[test]
fn it_goes_up_steps_that_are_low_enough() {
    for (height, goes_up) in [
        (0.1, true),
        (0.2, true),
        (0.28, true),
        (0.4, false),
        (1.0, false),
    ] {
        let steps: Vec<BodyDesc> = (0..4)
            .map(|i| {
                let top = height * (i + 1) as f32;
                let size = Vec3::new(6.0 - i as f32, top, 4.0);
                cuboid(size, Vec3::new(5.0 + 0.5 * i as f32, 0.5 * top, 0.0))
            })
            .chain([floor()])
            .collect();
        let mut course = Course::new(steps, Vec3::new(0.0, STANDING, 0.0));
        let end = course.walk(2.0 * Vec3::X, 3.2);
        if goes_up {
            assert!(end.x > 5.8, "steps of {height}: {end}");
            assert!(
                (end.y - STANDING - 4.0 * height).abs() < 0.03,
                "steps of {height}: {end}"
            );
        } else {
            assert!(
                end.x < 2.0 && end.y < STANDING + 0.1,
                "steps of {height}: {end}"
            );
        }
    }
}

#[test]
fn it_slides_along_walls_and_stops_in_corners() {
    let walls = vec![
        floor(),
        cuboid(Vec3::new(1.0, 4.0, 20.0), Vec3::new(3.0, 2.0, 0.0)),
        cuboid(Vec3::new(20.0, 4.0, 1.0), Vec3::new(0.0, 2.0, 6.0)),
    ];
    let mut course = Course::new(walls, Vec3::new(0.0, STANDING, 0.0));
    let end = course.walk(Vec3::new(2.0, 0.0, 1.0), 3.0);
    assert!((end.x - 2.5 + RADIUS + 0.01).abs() < 0.02, "{end}");
    assert!((end.z - 3.0).abs() < 0.2, "{end}");
    let corner = course.walk(Vec3::new(2.0, 0.0, 1.0), 6.0);
    assert!((corner.z - 5.5 + RADIUS + 0.01).abs() < 0.02, "{corner}");
    let still = course.walk(Vec3::new(2.0, 0.0, 1.0), 1.0);
    assert!(still.distance(corner) < 1e-3, "{corner} {still}");
}

#[test]
fn it_rides_lifts_and_turntables() {
    let mut lift = cuboid(Vec3::new(3.0, 0.5, 3.0), Vec3::new(0.0, 0.25, 0.0));
    lift.kind = RigidBody::Kinematic;
    let top = STANDING + 0.5;
    for velocity in [Vec3::Y, Vec3::NEG_Y, Vec3::new(1.0, 0.3, -0.5)] {
        let mut moving = lift.clone();
        moving.linear_velocity = velocity;
        let mut course = Course::new(vec![moving], Vec3::new(0.5, top + 0.02, 0.0));
        course.walk(Vec3::ZERO, 0.5);
        let before = course.state.position - course.simulation.bodies.pose(0).position;
        course.walk(Vec3::ZERO, 3.0);
        let after = course.state.position - course.simulation.bodies.pose(0).position;
        assert!(
            before.distance(after) < 0.02,
            "{velocity}: {before} {after}"
        );
        assert!(course.state.footing.is_some());
    }
    let mut table = lift;
    table.angular_velocity = Vec3::Y;
    let mut course = Course::new(vec![table], Vec3::new(1.0, top + 0.005, 0.0));
    course.walk(Vec3::ZERO, 0.2);
    let from_axis = |p: Vec3| Vec3::new(p.x, 0.0, p.z).length();
    let before = from_axis(course.state.position);
    let turned = course.state.rotation;
    course.walk(Vec3::ZERO, 2.0);
    assert!((from_axis(course.state.position) - before).abs() < 0.01);
    let angle = course.state.rotation.angle_between(turned);
    assert!((angle - 2.0).abs() < 0.05, "{angle}");
}

#[test]
fn it_pushes_what_its_force_can_move() {
    for (density, moves) in [(50.0, true), (5000.0, false)] {
        let mesh = ConvexMesh::cuboid(0.8, 0.8, 0.8).expect("a box");
        let mut crate_ = BodyDesc::dynamic(mesh, Vec3::new(2.0, 0.4, 0.0));
        crate_.density = density;
        let mut course = Course::new(vec![floor(), crate_], Vec3::new(0.0, STANDING, 0.0));
        let end = course.walk(1.5 * Vec3::X, 4.0);
        let crate_ = course.simulation.bodies.pose(1).position;
        if moves {
            assert!(crate_.x > 3.5 && end.x > 2.5, "{end} {crate_}");
        } else {
            assert!(
                (crate_.x - 2.0).abs() < 0.05 && end.x < 1.4,
                "{end} {crate_}"
            );
        }
    }
}

#[test]
fn it_jumps_as_high_as_its_speed_says_and_lands() {
    let mut course = Course::new(vec![floor()], Vec3::new(0.0, STANDING, 0.0));
    course.walk(Vec3::ZERO, 0.5);
    let ground = course.state.position.y;
    course.step_with(Vec3::ZERO, 4.0);
    let mut highest = 0.0_f32;
    for _ in 0..60 {
        course.step_with(Vec3::X, 0.0);
        highest = highest.max(course.state.position.y - ground);
    }
    let expected = 4.0 * 4.0 / (2.0 * 9.81);
    assert!(
        (highest / expected - 1.0).abs() < 0.06,
        "{highest} {expected}"
    );
    assert!(course.state.footing.is_some());
    assert!((course.state.position.y - ground).abs() < 2e-3);
}

#[test]
fn nothing_is_passed_through_at_30_metres_a_second() {
    // A room of triangles, and a character that runs and is thrown about in it.
    let wall = |from: Vec3, to: Vec3| {
        let up = 4.0 * Vec3::Y;
        [from, to, to + up, from + up]
    };
    let corners = [(-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0)];
    let corners = corners.map(|(x, z)| Vec3::new(x, 0.0, z));
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    let mut add = |quad: [Vec3; 4]| {
        let first = positions.len() as u32;
        positions.extend(quad);
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    };
    add([corners[0], corners[3], corners[2], corners[1]]);
    for k in 0..4 {
        add(wall(corners[k], corners[(k + 1) % 4]));
    }
    let up = 4.0 * Vec3::Y;
    add(corners.map(|corner| corner + up));
    let room = StaticMesh::new(&positions, &triangles).expect("a room");
    for level in [room.two_sided(), room] {
        let mut course = Course::new(vec![BodyDesc::level(level)], Vec3::new(0.0, 1.5, 0.0));
        let mut dice = crate::common::dice::Dice::new(5);
        for step in 0..1200 {
            let mut velocity = 30.0 * dice.direction();
            if step % 3 == 0 {
                velocity.y = 0.0;
            }
            let jump = if step % 7 == 0 { 30.0 } else { 0.0 };
            course.step_with(velocity, jump);
            let at = course.state.position;
            let is_inside = at.x.abs() < 5.0 - 0.9 * RADIUS
                && at.z.abs() < 5.0 - 0.9 * RADIUS
                && at.y > 0.9 * STANDING
                && at.y < 4.0 - 0.9 * STANDING;
            assert!(is_inside, "step {step}: {at}");
        }
    }
}

#[test]
fn in_an_app_it_walks_jumps_and_pushes_by_its_component() {
    let (one, two) = as_one_and_as_two();
    walks_in_an_app(one);
    walks_in_an_app(two);
}

fn walks_in_an_app(shape: impl Bundle) {
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        TimePlugin,
        CleavePlugin::default(),
        WalkerPlugin,
    ))
    .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    let world = app.world_mut();
    let floor = HalfSpaceShape { normal: Vec3::Y };
    let floor = world.spawn((RigidBody::Static, floor)).id();
    let light = (bevy_cleave::cuboid!(0.6), Density(50.0));
    let at = Transform::from_xyz(4.0, 0.3, 0.0);
    let crate_ = world.spawn((RigidBody::Dynamic, light, at)).id();
    let start = Transform::from_xyz(0.0, STANDING + 0.02, 0.0);
    let walker = (RigidBody::Kinematic, shape, start, Walker::default());
    let walker = world.spawn(walker).id();
    let place = |app: &App, entity| {
        app.world()
            .get::<Transform>(entity)
            .expect("there")
            .translation
    };
    let walking = |app: &App| *app.world().get::<Walking>(walker).expect("required");
    (0..30).for_each(|_| app.update());
    assert_eq!(walking(&app).ground, Some(floor));
    app.world_mut()
        .get_mut::<Walker>(walker)
        .expect("there")
        .velocity = 2.0 * Vec3::X;
    (0..60).for_each(|_| app.update());
    // Bevy makes 64 fixed steps in a second.
    let (at, expected) = (place(&app, walker), 2.0 * 60.0 / 64.0);
    assert!((at.x - expected).abs() < 0.02, "{at}");
    assert!((walking(&app).velocity - 2.0 * Vec3::X).length() < 0.05);
    app.world_mut()
        .get_mut::<Walker>(walker)
        .expect("there")
        .jump = 3.0;
    (0..3).for_each(|_| app.update());
    assert!(!walking(&app).is_on_ground() && place(&app, walker).y > at.y + 0.05);
    assert_eq!(app.world().get::<Walker>(walker).expect("there").jump, 0.0);
    (0..180).for_each(|_| app.update());
    assert!(walking(&app).is_on_ground());
    assert!(place(&app, crate_).x > 4.5, "{}", place(&app, crate_));
}

#[test]
fn a_belt_takes_along_who_stands_on_it_and_whom_walks() {
    let belt = cuboid(Vec3::new(60.0, 1.0, 4.0), -0.5 * Vec3::Y);
    let mut course = Course::new(vec![belt], Vec3::new(-5.0, STANDING + 0.01, 0.0));
    let run = BodyDrive {
        surface_velocity: Vec3::new(1.0, 0.3, 0.0),
        ..BodyDrive::default()
    };
    course.simulation.bodies.set_drive(0, run).expect("usable");
    let mut went = |seconds: f32, velocity: Vec3, jump: f32| {
        let before = course.state.position;
        for step in 0..(seconds / H).round() as usize {
            course.step_with(velocity, if step == 0 { jump } else { 0.0 });
        }
        course.state.position - before
    };
    went(0.5, Vec3::ZERO, 0.0);
    let stood = went(2.0, Vec3::ZERO, 0.0);
    assert!((stood - 2.0 * Vec3::X).length() < 0.02, "{stood}");
    let walked = went(2.0, Vec3::new(-3.0, 0.0, 0.5), 0.0);
    assert!(
        (walked - Vec3::new(-4.0, 0.0, 1.0)).length() < 0.02,
        "{walked}"
    );
    let jumped = went(0.5, Vec3::ZERO, 4.0);
    assert!((jumped.x - 0.5).abs() < 0.02, "{jumped}");
}
