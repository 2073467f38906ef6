//! Which pieces stay and which fall.

use crate::common::dice::Dice;
use crate::scenes::*;
use bevy_cleave::math::rotate;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

fn mass_of(bodies: &Bodies) -> f64 {
    let convex = bodies.iter().filter(|&slot| bodies.convex(slot).is_some());
    convex.map(|slot| f64::from(bodies.mass(slot).mass)).sum()
}

/// A wall on a floor that a ball flies at.
fn shot_wall(cells: u16, seed: u64) -> (Simulation, Vec<Fracture>) {
    let mut wall = standing(Vec3::new(3.0, 2.0, 0.2), Vec3::Y);
    wall.fracturable = Some(voronoi(cells, 50.0, seed));
    let ball = ball(Vec3::new(0.3, 1.2, 2.0), Vec3::new(0.0, 0.0, -25.0));
    let mut simulation = scene([floor(), wall, ball]);
    let done = run(&mut simulation, 3.0);
    (simulation, done)
}

#[test]
fn a_wall_breaks_by_the_blow_and_its_foot_stays() {
    for seed in 0..2 {
        let (simulation, done) = shot_wall(20, seed);
        let first = done.first().expect("it breaks");
        assert!(first.blow.is_some_and(|blow| blow.impulse > 50.0), "{seed}");
        let bodies = &simulation.bodies;
        let held = of_kind(bodies, RigidBody::Static);
        assert!(!held.is_empty(), "{seed}: something stands on the floor");
        for &slot in &held {
            assert!(
                lowest(bodies, slot).abs() < 1e-3,
                "{seed}: piece in the air"
            );
        }
        let fallen = of_kind(bodies, RigidBody::Dynamic);
        assert!(fallen.len() > held.len(), "{seed}: most fall");
        check_nothing_floats(&simulation);
        let dropped: f64 = done.iter().map(|f| f.ledger.dropped.mass).sum();
        let ball = 20.0;
        let sum = mass_of(bodies) + dropped;
        assert!((sum - 1200.0 - ball).abs() < 1.0, "{sum} kg");
    }
}

/// The ball goes through what falls; what stays stops it.
#[test]
fn the_ball_goes_on_through_a_wall_that_breaks() {
    let speed_after = |strength: f32| {
        let mut wall = standing(Vec3::new(3.0, 2.0, 0.05), Vec3::Y);
        wall.fracturable = Some(voronoi(30, strength, 3));
        let mut simulation = scene([
            floor(),
            wall,
            ball(Vec3::new(0.0, 1.3, 1.0), -25.0 * Vec3::Z),
        ]);
        run(&mut simulation, 0.1);
        simulation.bodies.velocity(2).0.z
    };
    let [whole, strong, weak] = [1e9, 200.0, 20.0].map(speed_after);
    assert!(whole > -0.5, "{whole} m/s");
    // 20 kg lose 200 N s and what pushes the pieces aside.
    assert!(strong < -2.0 && strong > -15.1, "{strong} m/s");
    assert!(weak < strong, "{weak} m/s against {strong} m/s");
}

/// Same bits whatever ran before, and slots that are used again.
#[test]
fn what_stays_is_deterministic() {
    let places = |simulation: &Simulation| -> Vec<_> {
        let bodies = &simulation.bodies;
        let mut all: Vec<_> = bodies
            .iter()
            .map(|slot| (bodies.id(slot), bodies.kind(slot), bodies.pose(slot)))
            .collect();
        all.sort_by_key(|&(id, ..)| id);
        all
    };
    let [first, again] = [0; 2].map(|_| shot_wall(30, 7).0);
    assert_eq!(places(&first), places(&again));
}

#[test]
fn a_post_cut_at_its_foot_falls() {
    for (height, tilt) in [(0.1, 0.0), (0.5, 0.3), (2.0, -0.4)] {
        let mut simulation = scene([floor(), standing(Vec3::new(0.2, 3.0, 0.2), 1.5 * Vec3::Y)]);
        let normal = Quat::from_rotation_z(tilt) * Vec3::Y;
        let plane = Plane::through(height * Vec3::Y, normal);
        simulation.slice(1, plane).expect("a body");
        run(&mut simulation, 3.0);
        let bodies = &simulation.bodies;
        let [held, fallen] =
            [RigidBody::Static, RigidBody::Dynamic].map(|kind| of_kind(bodies, kind));
        assert_eq!([held.len(), fallen.len()], [1, 1], "cut at {height} m");
        assert!(lowest(bodies, held[0]).abs() < 1e-5);
        let center = bodies.center_of_mass(held[0]).y;
        assert!(center < height, "the stump stays");
        check_nothing_floats(&simulation);
    }
}

/// A pane of glass in a frame of four bars.
#[test]
fn the_rim_of_a_pane_stays_in_its_frame() {
    let bar = |size: Vec3, at: Vec3| standing(size, at + 2.0 * Vec3::Y);
    let frame = [
        bar(Vec3::new(1.2, 0.1, 0.1), 0.55 * Vec3::Y),
        bar(Vec3::new(1.2, 0.1, 0.1), -0.55 * Vec3::Y),
        bar(Vec3::new(0.1, 1.0, 0.1), 0.55 * Vec3::X),
        bar(Vec3::new(0.1, 1.0, 0.1), -0.55 * Vec3::X),
    ];
    let mut pane = bar(Vec3::new(1.0, 1.0, 0.01), Vec3::ZERO);
    pane.fracturable = Some(Fracturable {
        pattern: FracturePattern::Radial { rays: 12, rings: 4 },
        strength: 1.0,
        generations: 0,
        ..Default::default()
    });
    let bodies = frame
        .into_iter()
        .chain([pane, ball(Vec3::new(0.0, 2.0, 1.0), -20.0 * Vec3::Z)]);
    let mut simulation = scene(bodies.chain([floor()]));
    let done = run(&mut simulation, 2.0);
    assert_eq!(done.len(), 1);
    let bodies = &simulation.bodies;
    let (mut held, mut fallen, mut on_floor) = (0, 0, 0);
    for (&slot, &id) in done[0].pieces.iter().zip(&done[0].ids) {
        assert!(bodies.is_current(slot, id));
        if bodies.kind(slot) == RigidBody::Static {
            held += 1;
            let at_rim = corners(bodies, slot)
                .map(|v| v - 2.0 * Vec3::Y)
                .filter(|v| v.x.abs().max(v.y.abs()) > 0.499);
            assert!(at_rim.count() >= 4, "a shard in the air");
        } else {
            fallen += 1;
            on_floor += usize::from(bodies.center_of_mass(slot).y < 1.0);
        }
    }
    check_nothing_floats(&simulation);
    // A few lie on the lower bar, and some of the lower half stand on those that stay: nothing pushes them.
    assert!(
        10 * on_floor >= 7 * fallen,
        "{on_floor} of {fallen} have fallen"
    );
    assert!(held >= 8 && fallen >= 8, "{held} stay, {fallen} fall");
}

/// A bridge that lies on two banks loses its middle; said by regions, and by the banks themselves.
#[test]
fn a_bridge_cut_in_the_middle_drops_what_is_not_held() {
    for is_said in [false, true] {
        let bank = |x: f32| standing(Vec3::new(2.0, 2.0, 2.0), Vec3::new(x, 1.0, 0.0));
        let bridge = standing(Vec3::new(8.0, 0.3, 2.0), 2.15 * Vec3::Y);
        let mut simulation = scene([floor(), bridge]);
        if is_said {
            let half = Vec3::new(0.5, 0.2, 1.1);
            let at = |x: f32| (x * Vec3::X - half, x * Vec3::X + half);
            let anchors = Anchors::none()
                .and_within(at(-3.6).0, at(-3.6).1)
                .and_within(at(3.6).0, at(3.6).1);
            simulation
                .bodies
                .set_anchors(1, Some(anchors))
                .expect("usable");
        } else {
            for x in [-4.0, 4.0] {
                simulation.bodies.insert(bank(x)).expect("usable");
            }
        }
        for x in [-1.0, 1.5] {
            simulation
                .slice(1, Plane::through(x * Vec3::X, Vec3::X))
                .expect("a body");
        }
        run(&mut simulation, 3.0);
        let bodies = &simulation.bodies;
        let fallen = of_kind(bodies, RigidBody::Dynamic);
        assert_eq!(fallen.len(), 1, "said: {is_said}");
        let middle = bodies.center_of_mass(fallen[0]);
        assert!(middle.y < 0.2 && (middle.x - 0.25).abs() < 0.1, "{middle}");
        let banks = if is_said { 0 } else { 2 };
        assert_eq!(of_kind(bodies, RigidBody::Static).len(), 2 + banks);
    }
}

/// Random bodies, cuts and anchors: a piece stays if, and only if, a face of it lies on the region or a part of it is behind. Cut
/// again, the pieces keep to the same rule.
#[test]
fn pieces_of_random_cuts_stay_where_a_naive_rule_says() {
    let mut dice = Dice::new(34);
    let (mut held, mut fallen) = (0, 0);
    for round in 0..150 {
        let size = dice.vector(0.2, 3.0);
        let kind = [RigidBody::Static, RigidBody::Kinematic][round % 2];
        let mut body = standing(size, dice.vector(-5.0, 5.0));
        body.kind = kind;
        body.pose.rotation = dice.rotation();
        let pose = body.pose;
        let mut simulation = scene([body]);
        simulation.config.sleep.enabled = false;
        let region = Plane {
            normal: dice.direction(),
            offset: dice.in_range(-0.4, 0.0) * size.min_element(),
        };
        let reach = 0.002;
        let anchors = Anchors::none()
            .and_behind(3.0 * region.normal, region.offset)
            .with_reach(reach);
        simulation
            .bodies
            .set_anchors(0, Some(anchors))
            .expect("usable");
        let to_world = pose.inverse();
        let plane = region.in_frame_of(&to_world);
        for generation in 0..3 {
            let slots: Vec<u32> = of_kind(&simulation.bodies, kind);
            for slot in slots {
                let center = simulation.bodies.center_of_mass(slot);
                let at =
                    center + 0.2 * dice.in_range(-1.0, 1.0) * size.min_element() * dice.direction();
                let along = [0.0, 2.0][dice.below(2)];
                let normal = dice.direction() + along * rotate(pose.rotation, region.normal);
                let plane = Plane::through(at, normal);
                simulation.slice(slot, plane).expect("a body");
            }
            simulation.step(1e-4);
            let bodies = &simulation.bodies;
            for fracture in &simulation.fractures.done {
                assert!(fracture.ledger.mass_error() < 1e-6);
                for &slot in &fracture.pieces {
                    let stays = bodies.kind(slot) == kind;
                    let depth = plane.distance(bodies.center_of_mass(slot));
                    let near = corners_behind(bodies, slot, &plane, reach);
                    assert!(!stays || near > 0, "{round}.{generation}: it floats");
                    assert!(
                        stays || depth > 0.0,
                        "{round}.{generation}: it fell though held"
                    );
                    held += usize::from(stays);
                    fallen += usize::from(!stays);
                }
            }
        }
    }
    assert!(held > 300 && fallen > 150, "{held} stay, {fallen} fall");
}

/// Each shot at what is left of a wall breaks pieces that stand by the same rule.
#[test]
fn pieces_that_stayed_break_again_by_the_same_rule() {
    let mut wall = standing(Vec3::new(4.0, 2.0, 0.3), Vec3::Y);
    wall.fracturable = Some(Fracturable {
        generations: 10,
        ..voronoi(6, 50.0, 1)
    });
    let mut simulation = scene([floor(), wall]);
    let mut dice = Dice::new(5);
    let mut broken = 0;
    for shot in 0..12 {
        let at = Vec3::new(dice.in_range(-1.8, 1.8), dice.in_range(0.1, 0.6), 2.0);
        simulation
            .bodies
            .insert(ball(at, -30.0 * Vec3::Z))
            .expect("usable");
        let done = run(&mut simulation, 1.0);
        broken += done.len();
        let bodies = &simulation.bodies;
        for slot in of_kind(bodies, RigidBody::Static) {
            assert!(
                lowest(bodies, slot).abs() < 0.01,
                "shot {shot}: a piece floats"
            );
        }
        check_nothing_floats(&simulation);
    }
    assert!(broken >= 4, "{broken} fractures");
    let left = of_kind(&simulation.bodies, RigidBody::Static);
    assert!(!left.is_empty(), "stumps stand");
}

/// What lies on what broke has nothing to hang on; what was put into the air stays there.
#[test]
fn what_hung_on_a_body_that_broke_falls_too() {
    let block = |x: f32, y: f32, size: Vec3| {
        let mut block = standing(size, Vec3::new(x, y, 0.0));
        block.fracturable = Some(voronoi(4, 1e6, 0));
        block
    };
    let post = Vec3::new(0.3, 2.0, 0.3);
    let mut simulation = scene([
        floor(),
        block(-1.5, 1.0, post),
        block(1.5, 1.0, post),
        block(0.0, 2.15, Vec3::new(4.0, 0.3, 0.3)),
        // On the beam, and in the air beside all of it.
        block(0.0, 2.45, Vec3::splat(0.3)),
        block(0.0, 5.0, Vec3::splat(0.5)),
    ]);
    let kinds = |simulation: &Simulation| {
        [1, 2, 3, 4, 5].map(|slot| {
            let bodies = &simulation.bodies;
            bodies.contains(slot).then(|| bodies.kind(slot))
        })
    };
    use RigidBody::{Dynamic, Static};
    simulation
        .slice(1, Plane::through(Vec3::Y, Vec3::Y))
        .expect("a body");
    simulation.step(H);
    let stays = [None, Some(Static), Some(Static), Some(Static), Some(Static)];
    assert_eq!(kinds(&simulation), stays, "one post bears the beam");
    simulation
        .slice(2, Plane::through(Vec3::Y, Vec3::Y))
        .expect("a body");
    simulation.step(H);
    assert_eq!(
        simulation.fractures.done[0].fallen.len(),
        4,
        "two half posts, the beam, the block"
    );
    let falls = [None, None, Some(Dynamic), Some(Dynamic), Some(Static)];
    let now = kinds(&simulation);
    assert_eq!([now[2], now[3], now[4]], [falls[2], falls[3], falls[4]]);
    run(&mut simulation, 3.0);
    check_nothing_floats(&simulation);
}

/// A slab that hangs in the air by the will of who made the scene bears what stands on it before and after that breaks.
#[test]
fn a_floor_of_its_own_is_not_pulled_down_by_what_breaks_on_it() {
    let mut slab = standing(Vec3::new(10.0, 0.5, 10.0), -0.25 * Vec3::Y);
    slab.fracturable = Some(voronoi(10, 1e6, 0));
    let mut wall = standing(Vec3::new(3.0, 2.0, 0.2), Vec3::Y);
    wall.fracturable = Some(voronoi(15, 50.0, 2));
    let mut simulation = scene([slab, wall, ball(Vec3::new(0.0, 1.5, 1.0), -25.0 * Vec3::Z)]);
    let done = run(&mut simulation, 3.0);
    assert!(!done.is_empty());
    let bodies = &simulation.bodies;
    assert_eq!(bodies.kind(0), RigidBody::Static);
    assert!(
        of_kind(bodies, RigidBody::Static).len() > 1,
        "the wall's foot stands on it"
    );
}

/// Levels of triangles hold as half-spaces and blocks do.
#[test]
fn a_wall_stands_on_a_level() {
    let corners = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)];
    let corners = corners.map(|(x, z)| Vec3::new(x, 0.0, z));
    let level = StaticMesh::new(&corners, &[[0, 2, 1], [0, 3, 2]]).expect("a level");
    for sunk in [0.0, 0.3] {
        let wall = standing(Vec3::new(3.0, 2.0, 0.2), (1.0 - sunk) * Vec3::Y);
        let mut simulation = scene([BodyDesc::level(level.clone()), wall]);
        simulation
            .slice(1, Plane::through(0.7 * Vec3::Y, Vec3::Y))
            .expect("a body");
        simulation.step(H);
        let bodies = &simulation.bodies;
        assert_eq!(of_kind(bodies, RigidBody::Static).len(), 1, "sunk {sunk} m");
        assert_eq!(of_kind(bodies, RigidBody::Dynamic).len(), 1);
    }
}

/// Pieces of a body that is moved fall with its motion, those that hold on go on with it.
#[test]
fn pieces_of_a_moved_body_go_on() {
    let mut lift = standing(Vec3::new(4.0, 0.2, 2.0), 3.0 * Vec3::Y);
    lift.kind = RigidBody::Kinematic;
    lift.linear_velocity = Vec3::new(0.0, 1.0, 0.0);
    let mut simulation = scene([lift]);
    let half = Anchors::none().and_within(Vec3::new(-2.0, -1.0, -1.0), Vec3::new(-1.5, 1.0, 1.0));
    simulation
        .bodies
        .set_anchors(0, Some(half))
        .expect("usable");
    simulation
        .slice(0, Plane::through(Vec3::ZERO, Vec3::X))
        .expect("a body");
    run(&mut simulation, 1.0);
    let bodies = &simulation.bodies;
    let [held, fallen] =
        [RigidBody::Kinematic, RigidBody::Dynamic].map(|kind| of_kind(bodies, kind)[0]);
    assert!((bodies.center_of_mass(held).y - 4.0).abs() < 0.02);
    assert!((bodies.center_of_mass(fallen).y - (4.0 - 4.9)).abs() < 0.2);
}

/// A shelf on the face of a wall that is anchored by a region alone falls with the part of the wall that bore it.
#[test]
fn what_hangs_on_a_wall_with_a_region_falls_with_its_part() {
    for (height, falls) in [(1.0, true), (2.6, false)] {
        let wall = standing(Vec3::new(3.0, 3.0, 0.2), 1.5 * Vec3::Y);
        let mut shelf = standing(Vec3::new(1.0, 0.1, 0.4), Vec3::new(0.0, 2.0, 0.3));
        shelf.fracturable = Some(voronoi(4, 1e6, 0));
        let mut simulation = scene([wall, shelf]);
        let foot = Anchors::none().and_behind(Vec3::Y, -1.4);
        simulation
            .bodies
            .set_anchors(0, Some(foot))
            .expect("usable");
        simulation
            .slice(0, Plane::through(height * Vec3::Y, Vec3::Y))
            .expect("a body");
        simulation.step(H);
        let is_loose = simulation.bodies.kind(1) == RigidBody::Dynamic;
        assert_eq!(is_loose, falls, "cut at {height} m");
    }
}
