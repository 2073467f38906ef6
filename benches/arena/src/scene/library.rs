//! The scenes.

use super::random::Rng;
use super::{Scene, Truth, jointed, sign};
use glam::{Quat, Vec3, vec3};
use std::f32::consts::PI;

/// Name, meaning of the size, size used when none is given, builder.
type Recipe = (&'static str, &'static str, usize, fn(usize) -> Scene);

pub(crate) const LIBRARY: &[Recipe] = &[
    ("pyramid", "boxes in the base row", 30, pyramid),
    ("tower", "boxes", 10, tower),
    ("pile", "random hulls", 500, pile),
    ("pyramids", "pyramids of base 5 per side", 10, pyramids),
    ("massratio", "weight of the top cube", 100, massratio),
    ("arch", "voussoirs", 15, arch),
    ("cards", "levels", 3, cards),
    ("dominoes", "dominoes", 50, dominoes),
    ("stick", "-", 1, |_| {
        slope("stick", -1.0, Truth::Rest { fell: 0.5 })
    }),
    ("slide", "-", 1, |_| Scene {
        steps: 180,
        ..slope("slide", 2.0, Truth::Slide)
    }),
    ("spin", "-", 1, |_| spin()),
    ("collide", "-", 1, |_| collide()),
    ("bounce", "-", 1, |_| bounce()),
    ("fall", "-", 1, |_| fall()),
    ("bullet", "-", 1, |_| wall("bullet", false)),
    ("chain10", "load over link", 100, |n| jointed::chain(10, n)),
    ("chain30", "load over link", 100, |n| jointed::chain(30, n)),
    ("chain100", "load over link", 100, |n| {
        jointed::chain(100, n)
    }),
    ("pendulum", "-", 1, |_| jointed::pendulum_period()),
    ("pendulum_energy", "-", 1, |_| jointed::pendulum_energy()),
    ("double_pendulum", "angles, degrees", 30, |n| {
        jointed::double_pendulum(n as f64)
    }),
    ("door", "weight over frame", 100, jointed::door),
    ("bridge", "sag of 100 planks, mm", 1500, jointed::bridge),
    (
        "motor",
        "torque, % of what the weight needs",
        120,
        jointed::motor,
    ),
    ("spring", "damping ratio, %", 10, jointed::spring),
    ("gyroscope", "spin, rad/s", 40, jointed::gyroscope),
    ("stairs", "ragdolls", 10, jointed::stairs),
    ("ragdolls", "ragdolls", 100, jointed::ragdolls),
    ("bullet_ccd", "-", 1, |_| wall("bullet_ccd", true)),
];

/// Builds `name` or `name:size`.
pub(crate) fn build(spec: &str) -> Option<Scene> {
    let (name, size) = spec.split_once(':').unwrap_or((spec, ""));
    let &(_, _, default, f) = LIBRARY.iter().find(|e| e.0 == name)?;
    let mut scene = f(if size.is_empty() {
        default
    } else {
        size.parse().ok()?
    });
    scene.name = spec.into();
    Some(scene)
}

/// Wall of unit boxes, `base` wide, with gaps between neighbors in a row.
fn pyramid(base: usize) -> Scene {
    let mut s = Scene::on_ground("pyramid", Truth::Rest { fell: 0.5 });
    let cube = s.boxed(Vec3::splat(0.5));
    s.pyramid_at(cube, 0.5, base, Vec3::ZERO);
    s
}

/// `side` x `side` separate pyramids of base 5.
fn pyramids(side: usize) -> Scene {
    // The usual ground holds 28 in a row.
    let half = 100_f32.max(4.0 * side as f32);
    let mut s = Scene::on_wide_ground("pyramids", Truth::Rest { fell: 0.5 }, half);
    let cube = s.boxed(Vec3::splat(0.5));
    for i in 0..side * side {
        let (x, z) = ((i % side) as f32, (i / side) as f32);
        let origin = vec3(x - 0.5 * side as f32, 0.0, 0.4 * z - 0.2 * side as f32) * 7.0;
        s.pyramid_at(cube, 0.5, 5, origin);
    }
    s.steps = 300;
    s
}

fn tower(height: usize) -> Scene {
    let mut s = Scene::on_ground("tower", Truth::Rest { fell: 0.5 });
    let cube = s.boxed(Vec3::splat(0.5));
    for i in 0..height {
        s.add(cube, vec3(0.0, 0.5 + i as f32, 0.0));
    }
    s
}

/// Three light cubes carry one that is `ratio` times as heavy.
fn massratio(ratio: usize) -> Scene {
    let mut s = tower(4);
    s.name = "massratio".into();
    s.bodies.last_mut().unwrap().density *= ratio as f32;
    s
}

/// Semicircular arch of `n` wedge-shaped blocks, thickness 0.2 of the mean radius (stable if rigid).
fn arch(n: usize) -> Scene {
    let mut s = Scene::on_ground("arch", Truth::Rest { fell: 0.5 });
    s.friction = 0.9;
    let at = |i: usize, r: f32, z: f32| {
        let a = PI * i as f32 / n as f32;
        let y = if i == 0 || i == n { 0.0 } else { r * a.sin() };
        vec3(r * a.cos(), y, z)
    };
    for i in 0..n {
        let points: Vec<_> = (0..8)
            .map(|k| {
                at(
                    i + (k & 1),
                    if k & 2 == 0 { 4.5 } else { 5.5 },
                    0.5 * sign(k >> 2),
                )
            })
            .collect();
        let (shape, com) = s.hull(&points);
        s.add(shape, com);
    }
    s
}

/// House of cards: frames of two cards leaning on each other, a plate over each level, one frame less above.
fn cards(levels: usize) -> Scene {
    let mut s = Scene::on_ground("cards", Truth::Rest { fell: 0.3 });
    let (t, h) = (0.02, 0.5);
    let card = s.boxed(vec3(t, h, 0.35));
    let lean = 20f32.to_radians();
    // Lowest corner on the floor, inner top edge on the symmetry plane.
    let center = vec3(
        t * lean.cos() + h * lean.sin(),
        t * lean.sin() + h * lean.cos(),
        0.0,
    );
    let pitch = 4.0 * (t * lean.cos() + h * lean.sin()) + 0.1;
    let mut floor = 0.0;
    for level in 0..levels {
        let frames = levels - level;
        for i in 0..frames {
            let origin = vec3((i as f32 - 0.5 * (frames - 1) as f32) * pitch, floor, 0.0);
            for side in [-1.0, 1.0] {
                let body = s.add(card, origin + center * vec3(side, 1.0, 1.0));
                body.rot = Quat::from_rotation_z(side * lean);
            }
        }
        if frames > 1 {
            let plate = s.boxed(vec3(0.5 * (frames - 1) as f32 * pitch + 0.1, t, 0.35));
            s.add(plate, vec3(0.0, floor + 2.0 * center.y + t, 0.0));
        }
        floor += 2.0 * (center.y + t);
    }
    s
}

/// `n` random hulls dropped in layers into a pit with four walls.
fn pile(n: usize) -> Scene {
    let side = (n as f32 / 10.0).sqrt().ceil() as usize;
    let w = 0.55 * side as f32 + 0.3;
    let mut s = Scene::on_ground("pile", Truth::Settle { walls: w });
    s.friction = 0.5;
    let mut rng = Rng(7);
    for (x, z) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
        let half = vec3(
            if x != 0.0 { 0.5 } else { w + 1.0 },
            10.0,
            if z != 0.0 { 0.5 } else { w + 1.0 },
        );
        s.fixed_box(vec3(x, 0.0, z) * (w + 0.5) + Vec3::Y * 10.0, half);
    }
    for i in 0..n {
        let (x, y, z) = (i % side, i / (side * side), i / side % side);
        let p = vec3(x as f32, y as f32, z as f32)
            - vec3(side as f32 - 1.0, 0.0, side as f32 - 1.0) * 0.5;
        let shape = s.rock(&mut rng, 0.5);
        let rot = rng.rotation();
        s.add(shape, p * 1.1 + Vec3::Y * 0.7).rot = rot;
    }
    s.steps = 480;
    s.warmup = 180;
    s.deep_every = 40;
    s
}

/// A flat box on a plane inclined `offset` degrees from the friction angle atan(0.5), downhill 30° off
/// the box axes. The plane stays level and gravity is tilted, which is the same problem.
fn slope(name: &str, offset: f32, truth: Truth) -> Scene {
    let mut s = Scene::on_ground(name, truth);
    s.friction = 0.5;
    let (angle, yaw) = (0.5f32.atan() + offset.to_radians(), 30f32.to_radians());
    s.gravity = 9.81
        * vec3(
            angle.sin() * yaw.cos(),
            -angle.cos(),
            angle.sin() * yaw.sin(),
        );
    let shape = s.boxed(vec3(0.5, 0.2, 0.5));
    s.add(shape, vec3(0.0, 0.2, 0.0));
    s
}

/// Torque-free rotation about the unstable axis.
fn spin() -> Scene {
    let mut s = Scene::new("spin", Truth::FreeRotation);
    s.gravity = Vec3::ZERO;
    let shape = s.boxed(vec3(0.5, 0.1, 0.25));
    s.add(shape, Vec3::ZERO).angvel = vec3(0.02, 0.01, 5.0);
    s
}

/// Two hulls collide off-center in empty space.
fn collide() -> Scene {
    let mut s = Scene::new("collide", Truth::Isolated);
    s.gravity = Vec3::ZERO;
    s.steps = 120;
    let mut rng = Rng(3);
    let (a, b) = (s.rock(&mut rng, 0.6), s.rock(&mut rng, 0.4));
    s.add(a, Vec3::ZERO).angvel = vec3(0.5, 1.0, 0.0);
    let body = s.add(b, vec3(-3.0, 0.25, 0.15));
    (body.linvel, body.angvel) = (vec3(6.0, 0.0, 0.0), vec3(0.0, 2.0, 3.0));
    s
}

fn bounce() -> Scene {
    let mut s = Scene::on_ground("bounce", Truth::Bounce { height: 1.25 });
    s.restitution = 0.5;
    s.steps = 110;
    let cube = s.boxed(Vec3::splat(0.5));
    s.add(cube, vec3(0.0, 5.5, 0.0));
    s
}

fn fall() -> Scene {
    let mut s = Scene::on_ground("fall", Truth::Fall);
    s.steps = 120;
    let cube = s.boxed(Vec3::splat(0.5));
    s.add(cube, vec3(0.0, 100.0, 0.0));
    s
}

fn dominoes(n: usize) -> Scene {
    let mut s = Scene::on_ground("dominoes", Truth::Topple);
    let shape = s.boxed(vec3(0.05, 0.5, 0.25));
    for i in 0..n {
        s.add(shape, vec3(0.4 * i as f32 - 0.2 * n as f32, 0.5, 0.0));
    }
    let w = 3.0; // first domino rotates about its lower front edge
    (s.bodies[1].linvel, s.bodies[1].angvel) = (vec3(0.5 * w, 0.05 * w, 0.0), vec3(0.0, 0.0, -w));
    s.steps = 240 + 12 * n;
    s
}

/// A pebble at 200 m/s (3.3 m per step) and a wall 2 cm thick.
fn wall(name: &str, bullet: bool) -> Scene {
    let mut s = Scene::new(name, Truth::Wall);
    s.gravity = Vec3::ZERO;
    s.steps = 30;
    s.warmup = 5;
    s.fixed_box(Vec3::ZERO, vec3(0.01, 2.0, 2.0));
    let rock = s.rock(&mut Rng(5), 0.05);
    let body = s.add(rock, vec3(-5.0, 0.1, 0.2));
    (body.linvel, body.bullet) = (vec3(200.0, 0.0, 0.0), bullet);
    s
}
