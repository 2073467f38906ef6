//! Beams that joints, posts that move or bonds between bodies hold up: statically determinate, so theory says what breaks them.

use crate::common::dice::Dice;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    TwoRopes,
    BallAndRope,
    HingeAndRope,
    /// One end, to the world.
    Fixed,
    /// On two dynamic posts.
    Posts,
    /// One half in a wall, and the other bonded to it.
    Halves,
}

const WAYS: [Way; 6] = [
    Way::TwoRopes,
    Way::BallAndRope,
    Way::HingeAndRope,
    Way::Fixed,
    Way::Posts,
    Way::Halves,
];

#[derive(Debug)]
struct Member {
    way: Way,
    count: usize,
    /// Of a part, m.
    size: Vec3,
    /// The parts that are held up.
    at: [usize; 2],
    /// On or below which part, and kg.
    load: (usize, f32),
    is_hung: bool,
    rate: f32,
    turn: Quat,
}

impl Member {
    fn random(seed: u64) -> Self {
        let dice = &mut Dice::new(seed);
        let way = WAYS[seed as usize % WAYS.len()];
        let size = dice.vector(0.1, 0.3);
        let count = 4 + (8.0 * size.y / size.x).ceil() as usize + dice.below(10);
        let third = count / 3;
        let at = match way {
            Way::Posts => [0, count - 1],
            _ => [dice.below(third), count - 1 - dice.below(third)],
        };
        let loaded = match way {
            Way::Fixed | Way::Halves => count / 2 + 1 + dice.below(count / 2 - 1),
            _ => at[0] + 2 + dice.below(at[1] - at[0] - 3),
        };
        let size = size * [0.2, 1.0, 5.0][dice.below(3)];
        let weight = 1000.0 * size.element_product() * count as f32;
        Self {
            way,
            count,
            size,
            at,
            load: (loaded, weight * dice.in_range(0.1, 3.0)),
            is_hung: way != Way::Posts && dice.below(3) > 0,
            rate: dice.in_range(30.0, 240.0),
            turn: [Quat::IDENTITY, dice.rotation()][dice.below(2)],
        }
    }

    /// Where the middle of a part is, m.
    fn x(&self, part: usize) -> f32 {
        self.size.x * (part as f32 + 0.5 - 0.5 * self.count as f32)
    }

    /// The largest moment at a bond over the section modulus, Pa.
    fn stress(&self) -> f32 {
        let (size, count) = (self.size, self.count);
        let mut forces = vec![-1000.0 * size.element_product() * 9.81; count];
        forces[self.load.0] -= self.load.1 * 9.81;
        if !matches!(self.way, Way::Fixed | Way::Halves) {
            let [a, b] = self.at;
            let down: f32 = forces.iter().sum();
            let moments = (0..count).map(|i| forces[i] * (self.x(i) - self.x(a)));
            let far = -moments.sum::<f32>() / (self.x(b) - self.x(a));
            forces[a] += -down - far;
            forces[b] += far;
        }
        let moment = |plane: usize| {
            let x = 0.5 * (self.x(plane - 1) + self.x(plane));
            (plane..count)
                .map(|i| forces[i] * (self.x(i) - x))
                .sum::<f32>()
        };
        let bonds = (1..count).filter(|&plane| self.way != Way::Halves || plane != count / 2);
        let most = bonds.map(|plane| moment(plane).abs()).fold(0.0, f32::max);
        most / (size.z * size.y * size.y / 6.0)
    }

    /// A cluster of some of the parts, as seen from the middle of them.
    fn shape(&self, parts: std::ops::Range<usize>, strength: f32) -> (Compound, f32) {
        let brick = ConvexMesh::cuboid(self.size.x, self.size.y, self.size.z).expect("a box");
        let middle = 0.5 * (self.x(parts.start) + self.x(parts.end - 1));
        let parts = parts.map(|i| {
            let at = Vec3::X * (self.x(i) - middle);
            (Pose::from_position(at), brick.clone())
        });
        let cluster = Cluster::new(parts, strength).expect("parts");
        (cluster.compound().expect("a beam"), middle)
    }

    /// The body that is loaded, and where its middle is, m.
    fn add_beam(&self, simulation: &mut Simulation, strength: f32) -> (u32, f32) {
        let frame = Pose::new(Vec3::ZERO, self.turn);
        let bodies = &mut simulation.bodies;
        let half = match self.way {
            Way::Halves => self.count / 2,
            _ => 0,
        };
        let (shape, middle) = self.shape(half..self.count, strength);
        let pose = frame * Pose::from_position(Vec3::X * middle);
        let beam = BodyDesc::compound(shape, Vec3::ZERO);
        let beam = bodies.insert(BodyDesc { pose, ..beam }).expect("usable");
        if half > 0 {
            let (shape, middle) = self.shape(0..half, strength);
            let pose = frame * Pose::from_position(Vec3::X * middle);
            let held = BodyDesc::new(RigidBody::Static, Shape::Compound(shape));
            let held = bodies.insert(BodyDesc { pose, ..held }).expect("usable");
            let root = Anchors::none().and_behind(Vec3::X, self.x(0) - middle);
            bodies.set_anchors(held, Some(root)).expect("usable");
            let made = (simulation.bonds).bond_neighbors(bodies, &[held, beam], 1e30);
            assert_eq!(made.expect("usable"), 1);
        }
        (beam, middle)
    }

    fn hold_up(&self, simulation: &mut Simulation, beam: u32) {
        let frame = Pose::new(Vec3::ZERO, self.turn);
        let height = 4.0 * self.size.y;
        let place = |part: usize| Vec3::new(self.x(part), 0.5 * self.size.y, 0.0);
        let rope = |part: usize| {
            let hook = frame.transform_point(place(part) + height * Vec3::Y);
            Joint::rope(height).with_anchors(hook, place(part))
        };
        let [a, b] = self.at;
        let axle = Vec3::X * self.x(a);
        let across = Quat::from_rotation_arc(Vec3::X, Vec3::Z);
        let both = [Pose::IDENTITY, frame];
        let joints = match self.way {
            Way::TwoRopes => vec![rope(a), rope(b)],
            Way::BallAndRope => vec![
                Joint::ball().with_anchors(frame.transform_point(axle), axle),
                rope(b),
            ],
            Way::HingeAndRope => vec![
                Joint::hinge().with_frame(frame * Pose::new(axle, across), both),
                rope(b),
            ],
            Way::Fixed => {
                let end = Vec3::X * (self.x(0) - 0.3 * self.size.x);
                vec![Joint::fixed().with_frame(frame * Pose::from_position(end), both)]
            }
            Way::Posts | Way::Halves => vec![],
        };
        for joint in joints {
            let made = (simulation.joints).insert(&mut simulation.bodies, None, beam, joint);
            made.expect("usable");
        }
    }

    fn add_posts(&self, simulation: &mut Simulation) {
        let frame = Pose::new(Vec3::ZERO, self.turn);
        let (size, long) = (self.size, 2.0 * self.size.x * self.count as f32);
        let floor = ConvexMesh::cuboid(long, size.y, long).expect("a box");
        let floor = BodyDesc {
            pose: frame * Pose::from_position(-3.0 * size.y * Vec3::Y),
            ..BodyDesc::new(RigidBody::Static, Shape::Convex(floor))
        };
        simulation.bodies.insert(floor).expect("usable");
        for part in self.at {
            let post = ConvexMesh::cuboid(0.5 * size.x, 2.0 * size.y, size.z).expect("a box");
            let at = Vec3::new(self.x(part), -1.5 * size.y, 0.0);
            let post = BodyDesc {
                pose: frame * Pose::from_position(at),
                ..BodyDesc::dynamic(post, Vec3::ZERO)
            };
            simulation.bodies.insert(post).expect("usable");
        }
    }

    fn add_load(&self, simulation: &mut Simulation, (beam, middle): (u32, f32)) {
        let frame = Pose::new(Vec3::ZERO, self.turn);
        let (part, mass) = self.load;
        let side = 0.8 * self.size.min_element();
        let above = match self.is_hung {
            true => -0.5 * self.size.y - 2.0 * side,
            false => 0.5 * self.size.y + 0.5 * side,
        };
        let block = ConvexMesh::cuboid(side, side, side).expect("a box");
        let block = BodyDesc {
            density: mass / (side * side * side),
            pose: frame * Pose::from_position(Vec3::new(self.x(part), above, 0.0)),
            ..BodyDesc::dynamic(block, Vec3::ZERO)
        };
        let block = simulation.bodies.insert(block).expect("usable");
        if self.is_hung {
            let below = Vec3::new(self.x(part) - middle, -0.5 * self.size.y, 0.0);
            let joint = Joint::ball().with_anchors(below, 2.0 * side * Vec3::Y);
            let made = (simulation.joints).insert(&mut simulation.bodies, Some(beam), block, joint);
            made.expect("usable");
        }
    }

    fn falls(&self, strength: f32) -> bool {
        let mut simulation = Simulation {
            gravity: Gravity(self.turn * (-9.81 * Vec3::Y)),
            ..Simulation::default()
        };
        if self.way == Way::Posts {
            self.add_posts(&mut simulation);
        }
        let beam = self.add_beam(&mut simulation, strength);
        self.hold_up(&mut simulation, beam.0);
        self.add_load(&mut simulation, beam);
        (0..(3.0 * self.rate) as usize).any(|_| {
            simulation.step(1.0 / self.rate);
            !simulation.fractures.done.is_empty()
        })
    }
}

#[test]
fn what_joints_posts_and_bonds_hold_up_breaks_where_statics_says() {
    let failures = (0..24).filter_map(|seed| {
        let member = Member::random(seed);
        let stress = member.stress();
        let found = [member.falls(stress / 1.1), member.falls(stress / 0.9)];
        (found != [true, false]).then(|| format!("{seed}: {found:?}, {member:?}"))
    });
    let failures: Vec<String> = failures.collect();
    assert!(failures.is_empty(), "{failures:#?}");
}
