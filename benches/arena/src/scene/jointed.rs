//! The scenes with joints.

use super::joint::{JointKind, Motor, Spring};
use super::reference::{self, GRAVITY};
use super::{Scene, Truth, sign};
use glam::{DVec3, Quat, Vec3, dvec3, vec3};
use std::f32::consts::{FRAC_PI_2, PI};

/// Links of 1 m and 1 kg, level at first, by ball joints from a post; at the end a cube that weighs as much as `load` links.
pub(super) fn chain(links: usize, load: usize) -> Scene {
    let mut s = hung(Truth::Joints);
    let (link, cube) = (s.boxed(vec3(0.5, 0.05, 0.05)), s.boxed(Vec3::splat(0.5)));
    for i in 0..=links {
        let is_load = i == links;
        let shape = if is_load { cube } else { link };
        let body = s.add(shape, vec3(i as f32 + 0.5, 0.0, 0.0));
        body.density = if is_load { load as f32 } else { 100.0 };
        s.join([i, i + 1], i as f32 * Vec3::X, Vec3::X, JointKind::Ball);
    }
    (s.steps, s.warmup) = (240, 20);
    s
}

/// A small fixed box at the origin, body 0, to hang things on; 4 s.
fn hung(truth: Truth) -> Scene {
    let mut s = Scene::new("hung", truth);
    s.fixed_box(Vec3::ZERO, Vec3::splat(0.05));
    (s.steps, s.warmup) = (240, 20);
    s
}

/// Half edges of the bar of a pendulum along it and across, m, and its mass, kg.
const BAR: ([f32; 2], f32) = ([0.5, 0.05], 10.0);

/// A bar that swings by 60 degrees to either side for a minute, how long a swing takes, and the energy that goes to and fro.
fn pendulum() -> (Scene, f64, f64) {
    let ([half, thin], mass) = BAR;
    let mut s = hung(Truth::Joints);
    let angle = PI / 3.0;
    let rot = Quat::from_rotation_z(angle - FRAC_PI_2);
    let bar = s.boxed(vec3(half, thin, thin));
    let body = s.add(bar, rot * vec3(half, 0.0, 0.0));
    (body.rot, body.density) = (rot, mass / (8.0 * half * thin * thin));
    s.join([0, 1], Vec3::ZERO, Vec3::Z, JointKind::HINGE);
    s.steps = 3600;
    let [half, thin, mass, angle] = [half, thin, mass, angle].map(f64::from);
    let inertia = mass * ((half * half + thin * thin) / 3.0 + half * half);
    let torque = mass * GRAVITY * half;
    let period = reference::period(inertia, torque, angle);
    (s, period, torque * (1.0 - angle.cos()))
}

pub(super) fn pendulum_period() -> Scene {
    let (s, period, _) = pendulum();
    Scene {
        truth: Truth::Period { period },
        ..s
    }
}

pub(super) fn pendulum_energy() -> Scene {
    let (s, _, scale) = pendulum();
    Scene {
        truth: Truth::Energy { scale },
        ..s
    }
}

/// Two bars of 1 m and 1 kg that hang on each other by hinges, released in line at so many degrees from the vertical, for 5 s.
pub(super) fn double_pendulum(degrees: f64) -> Scene {
    let mut s = hung(Truth::Path {
        body: 2,
        scale: 1.0,
    });
    let (half, thin, angle) = (0.5_f32, 0.01_f32, degrees.to_radians());
    let rot = Quat::from_rotation_z(angle as f32 - FRAC_PI_2);
    let bar = s.boxed(vec3(half, thin, thin));
    for i in 0..2 {
        let seam = rot * vec3(i as f32, 0.0, 0.0);
        let body = s.add(bar, seam + rot * vec3(half, 0.0, 0.0));
        (body.rot, body.density) = (rot, 1.0 / (8.0 * half * thin * thin));
        s.join([i, i + 1], seam, Vec3::Z, JointKind::HINGE);
    }
    s.steps = 300;
    let (half, thin) = (f64::from(half), f64::from(thin));
    let moment = (half * half + thin * thin) / 3.0;
    let down = |angle: f64| dvec3(angle.sin(), -angle.cos(), 0.0);
    let states = reference::double_pendulum(moment, angle, s.steps);
    let place = |[t1, t2, ..]: [f64; 4]| down(t1) + 0.5 * down(t2);
    s.path = states.into_iter().map(place).collect();
    s
}

/// A door of 1 m by 2 m, `ratio` times as heavy as the frame of 2 kg that it hangs on, which is held at its foot; it swings, and as nothing
/// brakes it, goes on as it began.
pub(super) fn door(ratio: usize) -> Scene {
    let mut s = hung(Truth::Path {
        body: 2,
        scale: 1.0,
    });
    let frame = s.boxed(vec3(0.05, 1.0, 0.05));
    let leaf = s.boxed(vec3(0.5, 1.0, 0.025));
    s.add(frame, vec3(0.0, 1.1, 0.0)).density = 2.0 / 0.02;
    let (arm, rate) = (0.55_f32, 1.0_f32);
    let body = s.add(leaf, vec3(arm, 1.1, 0.0));
    body.density = 2.0 * ratio as f32 / 0.1;
    (body.angvel, body.linvel) = (vec3(0.0, rate, 0.0), vec3(0.0, 0.0, -rate * arm));
    s.join([0, 1], vec3(0.0, 0.1, 0.0), Vec3::Y, JointKind::Fixed);
    s.join([1, 2], vec3(0.0, 1.1, 0.0), Vec3::Y, JointKind::HINGE);
    let (arm, rate) = (f64::from(arm), f64::from(rate));
    s.path = s
        .times()
        .map(|t| circle(arm, -rate * t, f64::from(1.1_f32)))
        .collect();
    s
}

/// A point of a level circle at a height.
fn circle(radius: f64, angle: f64, height: f64) -> DVec3 {
    dvec3(radius * angle.cos(), height, radius * angle.sin())
}

/// A motor turns an arm of 1 m and 1 kg with a weight of 10 kg fixed to its end, from where it hangs, with a torque of so many per cent
/// of what holds it level; it is to turn faster than it can. 1 s; the error is relative to the way.
pub(super) fn motor(percent: usize) -> Scene {
    let (length, thin, cube) = (1.0_f32, 0.05_f32, 0.1_f32);
    let (arm_mass, weight) = (1.0_f32, 10.0_f32);
    let mut s = hung(Truth::Joints);
    let arm = s.boxed(vec3(thin, 0.5 * length, thin));
    let load = s.boxed(Vec3::splat(cube));
    s.add(arm, vec3(0.0, -0.5 * length, 0.0)).density = arm_mass / (4.0 * thin * thin * length);
    s.add(load, vec3(0.0, -length, 0.0)).density = weight / (8.0 * cube.powi(3));
    let level = 9.81 * length * (0.5 * arm_mass + weight);
    let motor = Motor {
        speed: 100.0,
        max_torque: 0.01 * percent as f32 * level,
    };
    let driven = JointKind::Hinge {
        range: None,
        motor: Some(motor),
    };
    s.join([0, 1], Vec3::ZERO, Vec3::Z, driven);
    s.join([1, 2], vec3(0.0, -length, 0.0), Vec3::X, JointKind::Fixed);
    s.steps = 60;
    let [l, t, c, m, w] = [length, thin, cube, arm_mass, weight].map(f64::from);
    let inertia = m * (l * l / 3.0 + t * t / 3.0) + w * (l * l + 2.0 * c * c / 3.0);
    let need = GRAVITY * l * (0.5 * m + w);
    let torque = f64::from(motor.max_torque);
    let angles = reference::lifted(torque / inertia, need / inertia, s.steps);
    let turned = angles.last().expect("steps") + std::f64::consts::FRAC_PI_2;
    s.truth = Truth::Path {
        body: 2,
        scale: l * turned,
    };
    let place = |angle: f64| l * dvec3(angle.cos(), angle.sin(), 0.0);
    s.path = angles.into_iter().map(place).collect();
    s
}

/// A kilogram on an upright slider with a spring of 1 Hz that bears it from now on; the error is relative to how far it sinks in the end.
pub(super) fn spring(percent: usize) -> Scene {
    let spring = Spring {
        hertz: 1.0,
        damping_ratio: 0.01 * percent as f32,
        mass: 1.0,
    };
    let omega = 2.0 * std::f64::consts::PI * f64::from(spring.hertz);
    let scale = GRAVITY / (omega * omega);
    let mut s = hung(Truth::Path { body: 1, scale });
    let cube = s.boxed(Vec3::splat(0.1));
    s.add(cube, Vec3::ZERO).density = spring.mass / 0.008;
    let kind = JointKind::Slider {
        spring: Some(spring),
    };
    s.join([0, 1], Vec3::ZERO, Vec3::Y, kind);
    s.steps = 300;
    let sunk = |t| reference::sunk(spring.hertz.into(), spring.damping_ratio.into(), t);
    s.path = s.times().map(|t| -scale * sunk(t) * DVec3::Y).collect();
    s
}

/// A plate of 0.8 m by 0.8 m whose level axis of 0.5 m ends in a ball joint: it goes round at `m g d / (I s)` and stays level. 5 s; the error
/// is relative to the way.
pub(super) fn gyroscope(spin: usize) -> Scene {
    let (edge, thick, arm, spin) = (0.8_f32, 0.1_f32, 0.5_f32, spin as f32);
    let rate = 9.81 * arm * 6.0 / (edge * edge * spin);
    let way = f64::from(arm * rate) * 5.0;
    let mut s = hung(Truth::Path {
        body: 1,
        scale: way,
    });
    let plate = s.boxed(0.5 * vec3(thick, edge, edge));
    let body = s.add(plate, vec3(arm, 0.0, 0.0));
    (body.angvel, body.linvel) = (vec3(spin, rate, 0.0), vec3(0.0, 0.0, -rate * arm));
    s.join([0, 1], Vec3::ZERO, Vec3::X, JointKind::Ball);
    s.steps = 300;
    let (arm, rate) = (f64::from(arm), f64::from(rate));
    s.path = s.times().map(|t| circle(arm, -rate * t, 0.0)).collect();
    s
}

/// A truck of 2 t with 3 t on it drives over 100 planks of 50 kg between two banks, whose middle hangs lower than the ends by so many
/// millimetres; two ball joints at each seam.
pub(super) fn bridge(sag: usize) -> Scene {
    let mut s = Scene::new("bridge", Truth::Joints);
    let (planks, length, sag) = (100, 0.4_f32, 1e-3 * sag as f32);
    let half = 0.5 * planks as f32 * length;
    for side in [-1.0, 1.0] {
        s.fixed_box(vec3(side * (half + 5.0), -0.5, 0.0), vec3(5.0, 0.5, 3.0));
    }
    let seam = |i: usize| {
        let x = -half + i as f32 * length;
        vec3(x, -0.05 - sag * (1.0 - (x / half).powi(2)), 0.0)
    };
    for i in 0..planks {
        let (from, to) = (seam(i), seam(i + 1));
        let size = vec3(0.95 * from.distance(to), 0.1, 4.0);
        let plank = s.boxed(0.5 * size);
        let body = s.add(plank, 0.5 * (from + to));
        body.rot = Quat::from_rotation_arc(Vec3::X, (to - from).normalize());
        body.density = 50.0 / size.element_product();
    }
    for i in 0..=planks {
        let left = if i == 0 { 0 } else { i + 1 };
        let right = if i == planks { 1 } else { i + 2 };
        for z in [-1.8, 1.8] {
            s.join(
                [left, right],
                seam(i) + z * Vec3::Z,
                Vec3::X,
                JointKind::Ball,
            );
        }
    }
    s.add_truck(vec3(-half - 4.0, 0.6, 0.0));
    (s.steps, s.deep_every) = (600, 600);
    s
}

impl Scene {
    /// End times of its steps, s.
    fn times(&self) -> impl Iterator<Item = f64> + use<> {
        (1..=self.steps).map(|step| step as f64 / 60.0)
    }

    /// A chassis of 1600 kg on four wheels of 100 kg with motors, their axles at the height of `at`, loaded with 3000 kg. Drives along x.
    fn add_truck(&mut self, at: Vec3) {
        let chassis = self.boxed(vec3(2.0, 0.2, 1.0));
        let load = self.boxed(vec3(1.0, 0.5, 0.9));
        self.add(chassis, at + vec3(0.0, 0.4, 0.0)).density = 1600.0 / 3.2;
        let chassis = self.bodies.len() - 1;
        self.add(load, at + vec3(0.0, 1.1, 0.0)).density = 3000.0 / 3.6;
        let rim: Vec<Vec3> = (0..48)
            .map(|i| {
                let (sine, cosine) = (PI * (i / 2) as f32 / 12.0).sin_cos();
                vec3(0.6 * cosine, 0.6 * sine, 0.15 * sign(i & 1))
            })
            .collect();
        let (wheel, _) = self.hull(&rim);
        for (x, z) in [(-1.4, -1.2), (-1.4, 1.2), (1.4, -1.2), (1.4, 1.2)] {
            let axle = at + vec3(x, 0.0, z);
            self.add(wheel, axle).density = 100.0 / 0.34;
            let driven = JointKind::Hinge {
                range: None,
                motor: Some(Motor {
                    speed: -8.0,
                    max_torque: 2500.0,
                }),
            };
            let wheel = self.bodies.len() - 1;
            self.join([chassis, wheel], axle, Vec3::Z, driven);
        }
    }
}

/// Half edges (m), place of the middle (m; sides in pairs) and mass (kg) of the parts of a ragdoll.
const LIMBS: [([f32; 3], [f32; 2], f32); 7] = [
    ([0.16, 0.10, 0.11], [0.0, 1.00], 12.0),
    ([0.18, 0.22, 0.12], [0.0, 1.33], 30.0),
    ([0.09, 0.12, 0.10], [0.0, 1.69], 5.0),
    ([0.15, 0.045, 0.045], [0.34, 1.48], 2.5),
    ([0.15, 0.04, 0.04], [0.65, 1.48], 1.5),
    ([0.07, 0.21, 0.07], [0.09, 0.68], 6.5),
    ([0.055, 0.22, 0.055], [0.09, 0.24], 3.5),
];

/// Ragdolls of eleven parts that fall in rows, half a metre above the ground and from each other: necks, waists, shoulders and hips
/// are ball joints, elbows and knees bend one way.
pub(super) fn ragdolls(count: usize) -> Scene {
    let side = (count as f32).sqrt().ceil() as usize;
    let mut s = Scene::on_wide_ground("ragdolls", Truth::Joints, side as f32 + 50.0);
    let shapes = LIMBS.map(|(half, ..)| s.boxed(Vec3::from_array(half)));
    for i in 0..count {
        let (x, z) = ((i % side) as f32, (i / side) as f32);
        let middle = 0.5 * (side - 1) as f32;
        // Each leans a little another way.
        let lean = 0.2 * vec3((1.7 * i as f32).sin(), 0.0, (2.3 * i as f32).cos());
        let feet = vec3(2.2 * (x - middle), 0.5, 1.5 * (z - middle));
        add_ragdoll(&mut s, &shapes, feet, |height| lean * height, false);
    }
    (s.steps, s.warmup, s.deep_every) = (240, 60, 240);
    if count >= 500 {
        // Many take long, and have landed by then.
        (s.steps, s.deep_every) = (120, 120);
    }
    s
}

/// Ragdolls side by side that are pushed down twelve steps, with cones for necks, waists, shoulders and hips.
pub(super) fn stairs(count: usize) -> Scene {
    let mut s = Scene::on_ground("stairs", Truth::Joints);
    let (tread, rise, wide) = (0.3_f32, 0.18_f32, 1.1 * count as f32 + 1.0);
    for i in 0..12 {
        let half = 0.5 * rise * (12 - i) as f32;
        let at = vec3(0.0, half, tread * (i as f32 + 0.5));
        s.fixed_box(at, vec3(wide, half, 0.5 * tread));
    }
    let top = 12.0 * rise;
    s.fixed_box(vec3(0.0, 0.5 * top, -2.0), vec3(wide, 0.5 * top, 2.0));
    let shapes = LIMBS.map(|(half, ..)| s.boxed(Vec3::from_array(half)));
    for i in 0..count {
        let x = 2.2 * (i as f32 - 0.5 * (count - 1) as f32);
        let turn = 0.3 * (1.7 * i as f32).sin();
        let push = |height: f32| vec3(0.2 * turn, 0.0, 1.0 + turn + height);
        add_ragdoll(&mut s, &shapes, vec3(x, top + 0.02, -0.2), push, true);
    }
    (s.steps, s.warmup, s.deep_every) = (300, 30, 300);
    s
}

/// Adds one that stands at `feet` with its arms out along x, and moves as `velocity` says for each height above them. `has_cones`: how far
/// balls turn is bounded.
fn add_ragdoll(
    s: &mut Scene,
    shapes: &[usize; 7],
    feet: Vec3,
    velocity: impl Fn(f32) -> Vec3,
    has_cones: bool,
) {
    let mut add = |part: usize, side: f32| {
        let ([x, y, z], [beside, above], mass) = LIMBS[part];
        let body = s.add(shapes[part], feet + vec3(side * beside, above, 0.0));
        (body.density, body.linvel) = (mass / (8.0 * x * y * z), velocity(above));
        s.bodies.len() - 1
    };
    let [pelvis, chest, head] = [0, 1, 2].map(|part| add(part, 1.0));
    let limbs = [-1.0, 1.0].map(|side| (side, [3, 4, 5, 6].map(|part| add(part, side))));
    let mut ball = |bodies: [usize; 2], at: Vec3, axis: Vec3, [swing, twist]: [f32; 2]| {
        let kind = if has_cones {
            JointKind::ConeTwist { swing, twist }
        } else {
            JointKind::Ball
        };
        s.join(bodies, feet + at, axis, kind);
    };
    ball([pelvis, chest], vec3(0.0, 1.10, 0.0), Vec3::Y, [0.5, 0.4]);
    ball([chest, head], vec3(0.0, 1.56, 0.0), Vec3::Y, [0.7, 0.8]);
    for (side, [upper_arm, _, upper_leg, _]) in limbs {
        let (shoulder, hip) = (vec3(0.19 * side, 1.48, 0.0), vec3(0.09 * side, 0.89, 0.0));
        ball([chest, upper_arm], shoulder, side * Vec3::X, [1.4, 0.8]);
        ball([pelvis, upper_leg], hip, -Vec3::Y, [1.2, 0.4]);
    }
    let bend = |range| JointKind::Hinge {
        range: Some(range),
        motor: None,
    };
    for (side, [upper_arm, lower_arm, upper_leg, lower_leg]) in limbs {
        let elbow = feet + vec3(0.495 * side, 1.48, 0.0);
        let knee = feet + vec3(0.09 * side, 0.47, 0.0);
        s.join(
            [upper_arm, lower_arm],
            elbow,
            side * Vec3::Y,
            bend([-2.2, 0.0]),
        );
        s.join([upper_leg, lower_leg], knee, Vec3::X, bend([0.0, 2.3]));
    }
}
