//! Plates many parts wide, and beams on edge: what is at a face of theirs loads all of it, and trembles.

use crate::common::dice::Dice;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    /// One end in a wall, and a block bonded to the other.
    EndBonded,
    /// One end in a wall, and a block on the last column.
    EndResting,
    /// On two posts, with a block on the middle.
    MiddleResting,
    /// The same, bonded.
    MiddleBonded,
}

const WAYS: [Way; 4] = [
    Way::EndBonded,
    Way::EndResting,
    Way::MiddleResting,
    Way::MiddleBonded,
];

#[derive(Debug)]
struct Member {
    way: Way,
    /// Along x, up and across.
    count: [usize; 3],
    /// Of a part, m.
    size: Vec3,
    /// kg.
    load: f32,
    /// Width of posts, m.
    post: f32,
    gravity: f32,
    rate: f32,
    turn: Quat,
}

impl Member {
    fn random(dice: &mut Dice, way: Way, count: [usize; 3]) -> Self {
        let mut size = dice.vector(0.1, 0.3) * [0.2, 1.0, 3.0][dice.below(3)];
        size.x = size.x.max(8.0 * size.y * count[1] as f32 / count[0] as f32);
        let weight = 1000.0 * size.element_product() * count.iter().product::<usize>() as f32;
        Self {
            way,
            count,
            size,
            load: weight * dice.in_range(0.2, 2.0),
            post: size.x * dice.in_range(0.05, 0.3),
            gravity: dice.in_range(2.0, 20.0),
            rate: dice.in_range(30.0, 240.0),
            turn: [Quat::IDENTITY, dice.rotation()][dice.below(2)],
        }
    }

    fn plate(dice: &mut Dice, way: Way) -> Self {
        let count = [9 + 2 * dice.below(3), 1, 7 + dice.below(6)];
        Self::random(dice, way, count)
    }

    fn on_edge(dice: &mut Dice, way: Way) -> Self {
        let count = [35 + 2 * dice.below(6), 4 + dice.below(3), 1];
        let mut member = Self::random(dice, way, count);
        member.size.z = member.size.y * dice.in_range(0.5, 0.8);
        let weight =
            1000.0 * member.size.element_product() * count.iter().product::<usize>() as f32;
        member.load = weight * dice.in_range(0.2, 2.0);
        member
    }

    fn extents(&self) -> Vec3 {
        self.size * Vec3::from_array(self.count.map(|count| count as f32))
    }

    fn is_held(&self) -> bool {
        matches!(self.way, Way::EndBonded | Way::EndResting)
    }

    /// Where the middle of a column is, m.
    fn x(&self, column: usize) -> f32 {
        self.size.x * (column as f32 + 0.5) - 0.5 * self.extents().x
    }

    /// The largest moment between two columns over the section modulus, Pa.
    fn stress(&self) -> f32 {
        let (whole, columns) = (self.extents(), self.count[0]);
        let column = 1000.0 * self.size.x * whole.y * whole.z * self.gravity;
        let mut forces: Vec<(f32, f32)> = (0..columns).map(|i| (self.x(i), -column)).collect();
        let at = match self.way {
            Way::EndBonded => 0.5 * (whole.x + self.size.x),
            Way::EndResting => self.x(columns - 1),
            Way::MiddleResting | Way::MiddleBonded => 0.0,
        };
        forces.push((at, -self.load * self.gravity));
        if !self.is_held() {
            let half = -0.5 * forces.iter().map(|force| force.1).sum::<f32>();
            forces.extend([(self.x(0), half), (self.x(columns - 1), half)]);
        }
        let moment_at = |x: f32| {
            let beyond = forces.iter().filter(|force| force.0 > x);
            beyond.map(|force| force.1 * (force.0 - x)).sum::<f32>()
        };
        let moments = (1..columns).map(|i| moment_at(0.5 * (self.x(i - 1) + self.x(i))).abs());
        moments.fold(0.0, f32::max) / (whole.z * whole.y * whole.y / 6.0)
    }

    fn shape(&self, strength: f32) -> Compound {
        let brick = ConvexMesh::cuboid(self.size.x, self.size.y, self.size.z).expect("a box");
        let [x, y, _] = self.count;
        let parts = (0..self.count.iter().product::<usize>()).map(|i| {
            let at = [i % x, i / x % y, i / (x * y)].map(|i| i as f32 + 0.5);
            let at = self.size * Vec3::from_array(at) - 0.5 * self.extents();
            (Pose::from_position(at), brick.clone())
        });
        let cluster = Cluster::new(parts, strength).expect("parts");
        cluster.compound().expect("a plate")
    }

    fn falls(&self, strength: f32, seconds: f32) -> bool {
        let (whole, part) = (self.extents(), self.size);
        let mut simulation = Simulation {
            gravity: Gravity(self.turn * (-self.gravity * Vec3::Y)),
            ..Simulation::default()
        };
        let frame = Pose::new(Vec3::ZERO, self.turn);
        let bodies = &mut simulation.bodies;
        let plate = if self.is_held() {
            let plate = BodyDesc::new(RigidBody::Static, Shape::Compound(self.shape(strength)));
            let plate = BodyDesc {
                pose: frame,
                ..plate
            };
            let plate = bodies.insert(plate).expect("usable");
            let root = Anchors::none().and_behind(Vec3::X, self.x(0));
            bodies.set_anchors(plate, Some(root)).expect("usable");
            plate
        } else {
            for column in [0, self.count[0] - 1] {
                let post = ConvexMesh::cuboid(self.post, whole.y, whole.z).expect("a box");
                let at = Vec3::new(self.x(column), -whole.y, 0.0);
                let post = BodyDesc::new(RigidBody::Static, Shape::Convex(post));
                let pose = frame * Pose::from_position(at);
                bodies.insert(BodyDesc { pose, ..post }).expect("usable");
            }
            let plate = BodyDesc::compound(self.shape(strength), Vec3::ZERO);
            let plate = BodyDesc {
                pose: frame,
                ..plate
            };
            bodies.insert(plate).expect("usable")
        };
        let (at, width) = match self.way {
            Way::EndBonded => (0.5 * (whole.x + part.x) * Vec3::X, part.x),
            Way::EndResting => (
                Vec3::new(self.x(self.count[0] - 1), whole.y, 0.0),
                0.8 * part.x,
            ),
            Way::MiddleResting | Way::MiddleBonded => (whole.y * Vec3::Y, 0.8 * part.x),
        };
        let block = ConvexMesh::cuboid(width, whole.y, whole.z).expect("a box");
        let block = BodyDesc {
            density: self.load / (width * whole.y * whole.z),
            pose: frame * Pose::from_position(at),
            ..BodyDesc::dynamic(block, Vec3::ZERO)
        };
        let block = bodies.insert(block).expect("usable");
        if matches!(self.way, Way::EndBonded | Way::MiddleBonded) {
            let bonds = &mut simulation.bonds;
            let made = bonds.bond_neighbors(&mut simulation.bodies, &[plate, block], 1e30);
            assert_eq!(made.expect("usable"), 1);
        }
        (0..(seconds * self.rate) as usize).any(|_| {
            simulation.step(1.0 / self.rate);
            !simulation.fractures.done.is_empty()
        })
    }
}

/// Of members of a family, those that do not break as theory says within a tenth.
fn failures(seeds: std::ops::Range<u64>, member: impl Fn(&mut Dice, Way) -> Member) -> Vec<String> {
    let found = seeds.filter_map(|seed| {
        let way = WAYS[seed as usize % WAYS.len()];
        let member = member(&mut Dice::new(seed), way);
        let stress = member.stress();
        let found = [
            member.falls(stress / 1.1, 4.0),
            member.falls(stress / 0.9, 3.0),
        ];
        (found != [true, false]).then(|| format!("{seed}: {found:?}, {member:?}"))
    });
    found.collect()
}

/// Symptom: what lay on a plate or was bonded to it loaded it at the corners of the contact alone. A block across all of its width bent the rims
/// down, and plates of 7 to 12 parts needed up to 1.5 times the strength.
#[test]
fn wide_plates_bear_what_beams_of_their_section_do() {
    let failures = failures(0..16, Member::plate);
    assert!(failures.is_empty(), "{failures:#?}");
}

/// Symptom: loads were noted once in 32 ms. Contacts tremble sideways, by rounding, and a beam on edge broke under 0.7 of what it bears.
#[test]
fn beams_on_edge_bear_what_trembles_on_them() {
    let failures = failures(0..24, Member::on_edge);
    assert!(failures.is_empty(), "{failures:#?}");
}
