//! The bodies of the scenes.

use crate::heaps::heap;
use crate::structures::{block, cuboid, fixed, floor, pyramid, sliding_box, tower};
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// A body that breaks at `strength` N s.
fn breakable(strength: f32, pattern: FracturePattern, seed: usize) -> Option<Fracturable> {
    Some(Fracturable {
        strength,
        pattern,
        seed: seed as u64,
        min_volume: 1e-3,
        ..Default::default()
    })
}

/// The same for a body whose pieces do not break again.
fn once(fracturable: Option<Fracturable>) -> Option<Fracturable> {
    fracturable.map(|fracturable| Fracturable {
        generations: 0,
        ..fracturable
    })
}

/// Moves all bodies but the floor.
fn moved(bodies: Vec<BodyDesc>, by: Vec3) -> impl Iterator<Item = BodyDesc> {
    bodies.into_iter().skip(1).map(move |mut desc| {
        desc.pose.position += by;
        desc
    })
}

/// A different direction and size for every `i`, up to 1 along each axis.
fn scatter(i: usize) -> Vec3 {
    let irrationals = [0.618_034, 0.414_214, 0.732_051];
    Vec3::from(irrationals.map(|x| 2.0 * (i as f32 * x).fract() - 1.0))
}

fn shapes() -> [ConvexMesh; 4] {
    [
        ConvexMesh::cuboid(0.8, 0.6, 0.5),
        ConvexMesh::icosphere(0.4, 1),
        ConvexMesh::regular_prism(6, 0.4, 0.6),
        ConvexMesh::wedge(0.8, 0.5, 0.6),
    ]
    .map(|shape| shape.expect("valid sizes"))
}

pub(crate) fn breaking_pile() -> Vec<BodyDesc> {
    let mut bodies = heap(84);
    for (i, body) in bodies.iter_mut().enumerate().skip(1) {
        if i > 42 {
            body.pose.position.x += 30.0;
        }
        if i % 3 == 0 {
            body.fracturable = breakable(150.0, FracturePattern::default(), i);
        }
    }
    bodies
}

pub(crate) fn mixed() -> Vec<BodyDesc> {
    let mut bodies = tower(10);
    let ball = ConvexMesh::icosphere(0.3, 1).expect("valid size");
    let mut fast = block(&ball, Vec3::new(-60.0, 6.2, 0.1), 0.3);
    fast.linear_velocity = 200.0 * Vec3::X;
    bodies.push(fast);
    let bar = cuboid(Vec3::new(0.4, 0.3, 0.9));
    for i in 0..12_u8 {
        let n = f32::from(i);
        let place = Vec3::new(-6.0 + 0.7 * (n % 3.0), 2.0 + n, 5.0 + 0.3 * (n % 2.0));
        let mut body = block(if i % 2 == 0 { &ball } else { &bar }, place, 0.4);
        body.restitution = Restitution::new(0.3 + 0.05 * n);
        body.pose.rotation = Quat::from_xyzw(0.1 * n, 0.3, -0.2, 1.0).normalize();
        body.angular_velocity = Vec3::new(3.0, 0.2 * n, -1.0);
        bodies.push(body);
    }
    bodies
}

/// Layers of unit cubes that touch each other, every second layer shifted by half a cube in x and z, all a little off their
/// places; on a floor. Each rests on four.
fn shifted_layers(side: usize, layers: usize) -> Vec<BodyDesc> {
    let cube = cuboid(Vec3::ONE);
    let cubes = (0..side * side * layers).map(|i| {
        let (x, y, z) = (i % side, i / (side * side), i / side % side);
        let shift = if y % 2 == 0 { 0.0 } else { 0.5 };
        let at = Vec3::new(x as f32 + shift, y as f32 + 0.5, z as f32 + shift);
        block(
            &cube,
            at + 1e-3 * scatter(i) * Vec3::new(1.0, 0.2, 1.0),
            0.6,
        )
    });
    std::iter::once(floor(0.6)).chain(cubes).collect()
}

/// Bodies of all shapes, `side` squared, that are about to fall on [`shifted_layers`].
fn rain(side: usize, height: f32, spacing: f32) -> impl Iterator<Item = BodyDesc> {
    let shapes = shapes();
    (0..side * side).map(move |i| {
        let at = spacing * Vec3::new((i % side) as f32 + 0.7, 0.0, (i / side) as f32 + 0.7);
        let mut body = block(&shapes[i % 4], at + height * Vec3::Y, 0.5);
        body.pose.rotation = Quat::from_vec4(scatter(i).extend(1.0)).normalize();
        body.linear_velocity = Vec3::new(0.0, -5.0, 0.0) + scatter(i + 7);
        body.angular_velocity = 4.0 * scatter(i + 3);
        body.restitution = Restitution::new(0.3);
        body
    })
}

/// See [`Scene::Large`](crate::scene::Scene::Large).
pub(crate) fn large() -> Vec<BodyDesc> {
    let mut bodies = shifted_layers(15, 8);
    bodies.extend(rain(7, 10.0, 2.0));
    bodies
}

/// Cubes along a side of [`large_breaking`], and its layers.
const SIDE: usize = 11;
const LAYERS: usize = 6;

/// See [`Scene::LargeBreaking`](crate::scene::Scene::LargeBreaking).
pub(crate) fn large_breaking() -> Vec<BodyDesc> {
    let mut bodies = shifted_layers(SIDE, LAYERS);
    let first_of_top = 1 + (LAYERS - 1) * SIDE * SIDE;
    for (i, body) in bodies.iter_mut().enumerate().skip(first_of_top) {
        if i % 2 == 0 {
            let pattern = FracturePattern::Voronoi {
                cells: 5,
                focus: 0.3,
            };
            body.fracturable = once(breakable(8000.0, pattern, i));
        }
    }
    let weights = rain(4, LAYERS as f32 + 1.6, 2.5).map(|mut body| {
        body.density = 6000.0;
        body.pose.position.y += 2.0 * body.pose.rotation.x.abs();
        body.linear_velocity *= 4.0;
        body
    });
    bodies.extend(weights);
    bodies
}

/// Bonds the cubes of [`large_breaking`] that lie in its upper layers.
pub(crate) fn bond_corner(simulation: &mut Simulation, slots: &[u32]) {
    let upper = &slots[1 + 3 * SIDE * SIDE..1 + LAYERS * SIDE * SIDE];
    let made = simulation.bond_neighbors(upper, 2e5);
    assert!(made.is_ok_and(|made| made > 500), "{made:?}");
}

/// Size of a brick, m.
const BRICK: Vec3 = Vec3::new(0.4, 0.2, 0.2);

/// A wall of bricks in running bond on a floor, 2000 kg/m3.
fn wall(rows: usize, columns: usize) -> Vec<BodyDesc> {
    let brick = cuboid(BRICK);
    let bricks = (0..rows * columns).map(|i| {
        let (row, column) = (i / columns, (i % columns) as f32);
        let shift = if row % 2 == 0 { 0.0 } else { 0.5 };
        let mut body = block(
            &brick,
            BRICK * Vec3::new(column + shift, row as f32 + 0.5, 0.0),
            0.6,
        );
        body.density = 2000.0;
        body
    });
    std::iter::once(floor(0.6)).chain(bricks).collect()
}

/// A heavy ball that flies at a wall along z.
fn shot(at: Vec3, speed: f32, density: f32) -> BodyDesc {
    let ball = ConvexMesh::icosphere(0.3, 2).expect("valid size");
    let mut ball = block(&ball, at + 1.5 * Vec3::Z, 0.4);
    ball.density = density;
    ball.linear_velocity = Vec3::new(0.1, 0.2, -1.0) * speed;
    ball
}

/// See [`Scene::BondedWall`](crate::scene::Scene::BondedWall).
pub(crate) fn bonded_wall() -> Vec<BodyDesc> {
    let mut bodies = wall(7, 8);
    for (i, body) in bodies.iter_mut().enumerate().skip(1) {
        if i % 3 == 0 {
            body.fracturable = breakable(60.0, FracturePattern::Star { planes: 2 }, i);
        }
    }
    bodies.push(shot(Vec3::new(1.7, 0.8, 0.0), 12.0, 2000.0));
    bodies
}

/// Bonds the bricks of a [`bonded_wall`].
pub(crate) fn bond_wall(simulation: &mut Simulation, slots: &[u32]) {
    let bricks = &slots[1..=7 * 8];
    let made = simulation.bond_neighbors(bricks, 5e5);
    assert!(made.is_ok_and(|made| made > 100), "{made:?}");
}

/// See [`Scene::BrickWall`](crate::scene::Scene::BrickWall).
pub(crate) fn brick_wall() -> Vec<BodyDesc> {
    let patterns = [
        FracturePattern::SinglePlane,
        FracturePattern::RandomPlane,
        FracturePattern::Star { planes: 3 },
        FracturePattern::Radial { rays: 5, rings: 1 },
        FracturePattern::Voronoi {
            cells: 6,
            focus: 0.5,
        },
        FracturePattern::Slabs { count: 3 },
        FracturePattern::Brick { size: 0.5 * BRICK },
    ];
    let mut bodies = wall(14, 14);
    for (i, body) in bodies.iter_mut().enumerate().skip(1) {
        body.fracturable = once(breakable(400.0, patterns[i % patterns.len()].clone(), i));
    }
    bodies.push(shot(Vec3::new(2.8, 1.5, 0.0), 25.0, 2500.0));
    bodies.push(shot(Vec3::new(1.2, 0.8, 2.0), 25.0, 2500.0));
    bodies
}

/// See [`Scene::Paper`](crate::scene::Scene::Paper).
pub(crate) fn breaking_heap() -> Vec<BodyDesc> {
    let mut bodies = heap(48);
    for (i, body) in bodies.iter_mut().enumerate().skip(1) {
        if i % 3 == 0 {
            body.fracturable = breakable(100.0, FracturePattern::RandomPlane, i);
        }
    }
    bodies
}

/// A pyramid, a heap and boxes that slide across their axes.
pub(crate) fn resting_and_sliding() -> Vec<BodyDesc> {
    let mut bodies = pyramid(6);
    bodies.extend(moved(heap(30), 10.0 * Vec3::Z));
    for (i, heading) in [0.0, 20.0, 45.0].into_iter().enumerate() {
        let by = Vec3::new(0.0, 0.0, -3.0 - 6.0 * i as f32);
        bodies.extend(moved(sliding_box(0.4, 5.0, heading), by));
    }
    bodies
}

/// See [`Scene::Exact`](crate::scene::Scene::Exact).
pub(crate) fn small() -> Vec<BodyDesc> {
    let mut bodies = tower(5);
    bodies.extend(moved(sliding_box(0.4, 4.0, 30.0), 4.0 * Vec3::Z));
    bodies.extend(moved(pyramid(3), -4.0 * Vec3::Z));
    let falling = rain(2, 1.5, 1.5).map(|mut body| {
        body.pose.position.x += 5.0;
        body
    });
    bodies.extend(falling);
    bodies
}

/// A row of balls on the floor of which the last is hit by one that rolls; bars that turn fast and meet; panes that fast
/// balls are shot at; a stack that a ball falls on; a box that spins like a top on the floor.
pub(crate) fn blows() -> Vec<BodyDesc> {
    let ball = ConvexMesh::icosphere(0.25, 2).expect("valid size");
    let mut bodies = vec![floor(0.5)];
    for i in 0..6_u8 {
        let x = if i == 0 { -2.0 } else { 0.5 * f32::from(i) };
        let mut body = block(&ball, Vec3::new(x, 0.25, 0.0), 0.2);
        body.restitution = Restitution::new(0.95);
        body.linear_velocity = if i == 0 { 8.0 * Vec3::X } else { Vec3::ZERO };
        bodies.push(body);
    }
    let bar = cuboid(Vec3::new(0.08, 0.08, 2.0));
    for i in 0..6_u8 {
        let n = f32::from(i);
        let at = Vec3::new(1.2 * (n % 3.0), 2.0 + 0.3 * n, 6.0 + n % 2.0);
        let mut body = block(&bar, at, 0.3);
        body.angular_velocity = Vec3::new(25.0 - 3.0 * n, 10.0 * (n - 2.5), 2.0);
        body.linear_velocity = Vec3::new(6.0 - 6.0 * (n % 3.0), 1.0, 0.0);
        body.restitution = Restitution::new(0.6);
        bodies.push(body);
    }
    let pane = cuboid(Vec3::new(0.03, 1.5, 1.5));
    for i in 0..3_u8 {
        let n = f32::from(i);
        bodies.push(block(&pane, Vec3::new(4.0 * n, 0.75, -6.0), 0.5));
        let mut shot = block(&ball, Vec3::new(-10.0 - 3.0 * n, 1.1, -6.0 + 0.2 * n), 0.3);
        shot.linear_velocity = Vec3::new(150.0 + 40.0 * n, 0.0, 0.0);
        shot.angular_velocity = Vec3::new(0.0, 0.0, -60.0);
        shot.restitution = Restitution::new(0.2);
        bodies.push(shot);
    }
    bodies.extend(moved(tower(4), Vec3::new(-6.0, 0.0, 6.0)));
    let mut dropped = block(&ball, Vec3::new(-6.1, 6.0, 6.1), 0.3);
    (dropped.linear_velocity, dropped.density) = (-20.0 * Vec3::Y, 5000.0);
    bodies.push(dropped);
    let mut top = block(
        &cuboid(Vec3::new(0.6, 0.2, 0.3)),
        Vec3::new(-6.0, 0.1, 0.0),
        0.3,
    );
    top.angular_velocity = Vec3::new(0.0, 45.0, 0.0);
    bodies.push(top);
    bodies
}

/// See [`Scene::Spinning`](crate::scene::Scene::Spinning).
pub(crate) fn spinning() -> Vec<BodyDesc> {
    let shapes = shapes();
    let plate = cuboid(Vec3::new(0.1, 0.7, 1.3));
    let bodies = (0..24_usize).map(|i| {
        let shape = shapes.get(i % 5).unwrap_or(&plate);
        let at = Vec3::new(90.0 * (i % 6) as f32, 90.0, 90.0 * (i / 6) as f32);
        let mut body = block(shape, at, 0.5);
        body.pose.rotation = Quat::from_vec4(scatter(i).extend(0.7)).normalize();
        body.linear_velocity = scatter(i + 11);
        // Some faster than their rotation can be followed.
        let rate = if i % 8 == 7 {
            5000.0
        } else {
            2.0 + 3.0 * i as f32
        };
        body.angular_velocity = rate * scatter(i + 5);
        body
    });
    std::iter::once(floor(0.5)).chain(bodies).collect()
}

/// A platform that goes along, a turntable and a paddle that turns, with boxes on them and in its way.
pub(crate) fn carried() -> Vec<BodyDesc> {
    let moving = |size: Vec3, at: Vec3, v: Vec3, omega: Vec3| BodyDesc {
        kind: RigidBody::Kinematic,
        linear_velocity: v,
        angular_velocity: omega,
        ..fixed(&cuboid(size), at, 0.7)
    };
    let mut bodies = vec![
        floor(0.6),
        moving(
            Vec3::new(4.0, 0.4, 4.0),
            Vec3::new(0.0, 0.2, 0.0),
            Vec3::X,
            Vec3::ZERO,
        ),
        moving(
            Vec3::new(4.0, 0.4, 4.0),
            Vec3::new(0.0, 0.2, 8.0),
            Vec3::ZERO,
            Vec3::Y,
        ),
        moving(
            Vec3::new(0.2, 0.8, 4.0),
            Vec3::new(0.0, 0.5, -8.0),
            Vec3::ZERO,
            3.0 * Vec3::Y,
        ),
    ];
    let shapes = shapes();
    for i in 0..27_usize {
        let group = [0.0, 8.0, -6.8][i % 3];
        let at = Vec3::new(
            0.9 * (i / 3 % 3) as f32 - 0.9,
            0.9 + 0.7 * (i / 9) as f32,
            group,
        );
        let mut body = block(&shapes[(i / 3) % 4], at + 0.02 * scatter(i), 0.6);
        body.pose.position.y -= if i % 3 == 2 { 0.4 } else { 0.0 };
        bodies.push(body);
    }
    bodies
}
