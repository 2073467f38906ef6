//! Cars go where their wheels roll, at the speed at which their motors turn these, over any floor, and stay where they are parked.

use crate::common::dice::Dice;
use crate::members::between;
use crate::scene::cuboid;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};
use std::f32::consts::PI;

const GRAVITY: f32 = 9.81;

/// A floor to drive on.
#[derive(Clone, Copy, Debug)]
enum Ground {
    HalfSpace,
    Tiles,
    Heights,
}

/// What a car is like; it heads for x, and its wheels turn about z.
#[derive(Clone, Copy, Debug)]
struct Plan {
    /// Hz
    rate: f32,
    /// Of all lengths, m.
    size: f32,
    axles: usize,
    wheel_radius: f32,
    has_round_wheels: bool,
    is_sprung: bool,
    chassis: Vec3,
    /// Mass of a wheel over that of the chassis.
    wheel_mass: f32,
    /// Whether the floor is there before the car.
    floor_first: bool,
}

impl Plan {
    fn draw(dice: &mut Dice) -> Self {
        let rate = [30.0, 60.0, 60.0, 120.0, 240.0][dice.below(5)];
        // At least four steps in the time in which it falls by half of its size.
        let least = GRAVITY * (4.0 / rate) * (4.0 / rate);
        let size = between(dice, least.max(0.03), 100.0 * least.max(0.03));
        let axles = 2 + dice.below(3);
        let wheel_radius = size * dice.in_range(0.3, 0.5);
        let length = size * dice.in_range(2.0, 4.0);
        let chassis = Vec3::new(
            length.max(2.2 * wheel_radius * (axles - 1) as f32),
            size * dice.in_range(0.4, 0.8),
            size * dice.in_range(1.2, 2.0),
        );
        Self {
            rate,
            size,
            axles,
            wheel_radius,
            has_round_wheels: dice.below(2) == 0,
            is_sprung: dice.below(2) == 0,
            chassis,
            wheel_mass: dice.in_range(0.02, 0.2),
            floor_first: dice.below(2) == 0,
        }
    }

    /// The time in which it falls by half of its size, s.
    fn unit(&self) -> f32 {
        (self.size / GRAVITY).sqrt()
    }
}

struct Car {
    simulation: Simulation,
    plan: Plan,
    chassis: u32,
    wheels: Vec<JointId>,
}

impl Car {
    fn new(plan: Plan, floor: Vec<BodyDesc>, turn: Quat) -> Self {
        let mut simulation = Simulation::default();
        let mut insert = |body| simulation.bodies.insert(body).expect("usable");
        let (before, after) = match plan.floor_first {
            true => (floor, Vec::new()),
            false => (Vec::new(), floor),
        };
        for body in before {
            insert(body);
        }
        let above = plan.wheel_radius + 0.5 * plan.chassis.y + 0.1 * plan.size;
        let Vec3 { x, y, z } = plan.chassis;
        let mut body = BodyDesc::dynamic(cuboid(x, y, z), turn * (above * Vec3::Y));
        body.pose.rotation = turn;
        body.density = 200.0;
        let mass = body.density * plan.chassis.element_product();
        let chassis = insert(body);
        let places = Self::places(&plan);
        let bodies: Vec<u32> = places
            .iter()
            .map(|&at| insert(Self::wheel(&plan, at, turn, mass)))
            .collect();
        for body in after {
            insert(body);
        }
        let hertz = (0.7 / plan.unit()).min(0.2 * plan.rate);
        let spring = JointSpring::Frequency {
            hertz,
            damping_ratio: 0.7,
        };
        let kind = match plan.is_sprung {
            true => Joint::wheel(0.2 * plan.size, spring),
            false => Joint::hinge(),
        };
        let mut wheels = Vec::new();
        for (&wheel, &at) in bodies.iter().zip(&places) {
            let poses = [chassis, wheel].map(|slot| simulation.bodies.pose(slot));
            let [axis, up] = [Vec3::Z, Vec3::Y].map(|axis| turn * axis);
            let joint = kind.with_anchor_and_up(turn * at, axis, up, poses);
            let id = simulation.join(Some(chassis), wheel, joint);
            wheels.push(id.expect("usable"));
        }
        Self {
            simulation,
            plan,
            chassis,
            wheels,
        }
    }

    fn places(plan: &Plan) -> Vec<Vec3> {
        let aside = 0.5 * plan.chassis.z + 0.35 * plan.wheel_radius;
        let axle = |i: usize| plan.chassis.x * (i as f32 / (plan.axles - 1) as f32 - 0.5);
        let sides = |i| [-aside, aside].map(|z| Vec3::new(axle(i), plan.wheel_radius, z));
        (0..plan.axles).flat_map(sides).collect()
    }

    fn wheel(plan: &Plan, at: Vec3, turn: Quat, mass: f32) -> BodyDesc {
        let (r, width) = (plan.wheel_radius, 0.5 * plan.wheel_radius);
        let (shape, volume) = match plan.has_round_wheels {
            true => (ConvexMesh::sphere(r), 4.0 / 3.0 * PI * r * r * r),
            false => (ConvexMesh::cylinder(r, width), PI * r * r * width),
        };
        let mut wheel = BodyDesc::dynamic(shape.expect("a wheel"), turn * at);
        wheel.pose.rotation = turn * Quat::from_rotation_arc(Vec3::Y, Vec3::Z);
        wheel.friction = Friction::new(1.0);
        wheel.density = plan.wheel_mass * mass / volume;
        wheel
    }

    fn run(&mut self, seconds: f32) {
        let steps = (seconds * self.plan.rate).ceil() as usize;
        (0..steps).for_each(|_| self.simulation.step(1.0 / self.plan.rate));
    }

    /// Has the motors drive at a speed, m/s, with a share of the chassis' weight each.
    fn drive(&mut self, speed: f32, share: f32) {
        let weight = GRAVITY * self.simulation.bodies.mass(self.chassis).mass;
        let torque = share * weight * self.plan.wheel_radius;
        for &id in &self.wheels {
            let mut joint = *self.simulation.joints.get(id).expect("there");
            let motor = JointDrive::velocity(-speed / self.plan.wheel_radius, torque);
            joint.angular[0].drive = Some(motor);
            let Simulation { joints, bodies, .. } = &mut self.simulation;
            joints.set(bodies, id, joint).expect("usable");
        }
    }

    fn place(&self) -> Vec3 {
        self.simulation.bodies.center_of_mass(self.chassis)
    }
}

fn floor(dice: &mut Dice, kind: Ground, plan: &Plan) -> Vec<BodyDesc> {
    let size = plan.size;
    match kind {
        Ground::HalfSpace => vec![BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y })],
        Ground::Tiles => {
            let tile = size * dice.in_range(0.7, 3.0);
            let shape = cuboid(tile, size, tile);
            let places = (-8..60).flat_map(|i| (-4..4).map(move |j| [i as f32, j as f32 + 0.5]));
            let tile = |[x, z]: [f32; 2]| BodyDesc {
                pose: Pose::from_position(Vec3::new(x * tile, -0.5 * size, z * tile)),
                ..BodyDesc::new(RigidBody::Static, Shape::Convex(shape.clone()))
            };
            places.map(tile).collect()
        }
        Ground::Heights => {
            let spacing = size * dice.in_range(0.5, 1.5);
            let level = StaticMesh::from_heights(&[0.0; 80 * 80], 80, spacing);
            let mut level = BodyDesc::level(level.expect("flat"));
            level.pose.position = Vec3::new(-10.0, 0.0, -40.3) * spacing;
            vec![level]
        }
    }
}

/// Wheels that were there before a floor of tiles were once thrown up by the edges of these.
#[test]
fn cars_drive_straight_at_the_speed_of_their_wheels() {
    for seed in 0..24 {
        let dice = &mut Dice::new(seed);
        let plan = Plan::draw(dice);
        let ground = [Ground::HalfSpace, Ground::Tiles, Ground::Heights][seed as usize % 3];
        let floor = floor(dice, ground, &plan);
        let (size, unit) = (plan.size, plan.unit());
        let mut car = Car::new(plan, floor, Quat::IDENTITY);
        car.run(10.0 * unit);
        let start = car.place();
        let speed = dice.in_range(0.3, 2.0) * size / unit;
        car.drive(speed, 0.2);
        car.run(10.0 * unit);
        let (mut low, mut high) = (f32::MAX, f32::MIN);
        for _ in 0..(5.0 * unit * plan.rate) as usize {
            car.run(0.5 / plan.rate);
            let y = car.place().y;
            (low, high) = (low.min(y), high.max(y));
        }
        let said = format!("{seed}: {plan:?} on {ground:?} at {speed} m/s");
        let off = car.simulation.bodies.velocity(car.chassis).0.x / speed - 1.0;
        assert!(off.abs() < 0.01, "{said}: off by {off}");
        let way = car.place() - start;
        assert!(way.z.abs() < 0.01 * way.x, "{said}: {way}");
        let bounce = (high - low) / size;
        assert!(bounce < 0.01, "{said}: bounces by {bounce}");
        car.drive(0.0, 0.2);
        car.run(20.0 * unit);
        let parked = car.place();
        car.run(10.0 * unit + 1.0);
        let moved = car.place().distance(parked) / size;
        assert!(moved < 1e-3, "{said}: parked, it moves by {moved}");
        assert_eq!(car.simulation.report.awake, 0, "{said}: awake");
    }
}

#[test]
fn cars_that_are_parked_on_a_slope_stay_there_and_sleep() {
    for seed in 0..20 {
        let dice = &mut Dice::new(seed);
        let plan = Plan::draw(dice);
        let axis = Vec3::Z + dice.in_range(-1.0, 1.0) * Vec3::X;
        let turn = Quat::from_rotation_arc(Vec3::Y, {
            let tilt = dice.in_range(0.05, 0.5);
            (Vec3::Y + tilt * axis.normalize().cross(Vec3::Y)).normalize()
        });
        let slope = HalfSpaceShape {
            normal: turn * Vec3::Y,
        };
        let slope = BodyDesc {
            friction: Friction::new(1.0),
            ..BodyDesc::floor(slope)
        };
        let mut car = Car::new(plan, vec![slope], turn);
        car.run(1.0 / plan.rate);
        car.drive(0.0, 100.0);
        car.run(15.0 * plan.unit());
        let parked = car.place();
        car.run(15.0 * plan.unit() + 1.0);
        let moved = car.place().distance(parked) / plan.size;
        assert!(moved < 2e-3, "{seed}: {plan:?} moves by {moved}");
        assert_eq!(car.simulation.report.awake, 0, "{seed}: {plan:?} is awake");
    }
}
