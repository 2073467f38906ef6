//! Clusters that nothing anchors and that lie on something bear their own weight as what is below them lets them.

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use crate::shapes::row;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// A scene in which a cluster lies, turned anyhow, and gravity with it.
struct Ground {
    shape: Shape,
    /// Of the ground, before it is turned.
    at: Vec3,
    rotation: Quat,
    rate: f32,
    comes_first: bool,
}

impl Ground {
    fn random(dice: &mut Dice) -> Self {
        let (shape, at) = match dice.below(3) {
            0 => {
                let normal = Vec3::Y;
                (Shape::HalfSpace(HalfSpaceShape { normal }), Vec3::ZERO)
            }
            1 => {
                let slab = ConvexMesh::cuboid(40.0, 1.0, 40.0).expect("a slab");
                (Shape::Convex(slab), -0.5 * Vec3::Y)
            }
            _ => {
                let flat = StaticMesh::from_heights(&[0.0; 400], 20, 3.0).expect("a grid");
                let shift = dice.vector(-1.0, 1.0).with_y(0.0);
                let middle = 0.5 * (flat.aabb().min + flat.aabb().max);
                (Shape::Level(flat), shift - middle)
            }
        };
        Self {
            shape,
            at,
            rotation: dice.rotation(),
            rate: dice.in_range(30.0, 240.0),
            comes_first: dice.below(2) == 0,
        }
    }

    /// Whether a cluster breaks that is put there, its lowest point on the ground.
    fn breaks(&self, shape: &Compound, at: Vec3) -> bool {
        let mut simulation = awake();
        simulation.gravity = Gravity(self.rotation * (-9.81 * Vec3::Y));
        let place = |at: Vec3| Pose::new(self.rotation * at, self.rotation);
        let mut ground = BodyDesc::new(RigidBody::Static, self.shape.clone());
        ground.pose = place(self.at);
        let mut body = BodyDesc::compound(shape.clone(), Vec3::ZERO);
        body.pose = place(at - shape.aabb().min.y * Vec3::Y);
        let both = match self.comes_first {
            true => [ground, body],
            false => [body, ground],
        };
        for desc in both {
            simulation.bodies.insert(desc).expect("usable");
        }
        let steps = (3.0 * self.rate) as usize;
        (0..steps).any(|_| {
            simulation.step(1.0 / self.rate);
            !simulation.fractures.done.is_empty()
        })
    }
}

/// Symptom: the weight came down on the four points at the rim that a contact is, as if nothing were below the rest: a beam of 7.5 m by 0.15 m that
/// lay flat on the floor needed a strength of 2.7 MPa, and walls seven times the weight of a column.
#[test]
fn what_lies_flat_bears_no_more_than_its_weight() {
    for seed in 0..24 {
        let dice = &mut Dice::new(seed);
        let kind = dice.below(3);
        let counts = match kind {
            0 => Vec3::new(4.0 + dice.below(16) as f32, 1.0, 1.0),
            1 => Vec3::new(4.0 + dice.below(6) as f32, 2.0 + dice.below(6) as f32, 1.0),
            _ => Vec3::new(4.0 + dice.below(6) as f32, 1.0, 4.0 + dice.below(6) as f32),
        };
        let size = dice.vector(0.1, 0.4);
        let Vec3 { x, y, z } = size * counts;
        let whole = ConvexMesh::cuboid(x, y, z).expect("a box");
        let strength = 3.0 * 1000.0 * 9.81 * y;
        let bricks = FracturePattern::Brick { size: 1.001 * size };
        let shape = Cluster::cut(&whole, &bricks, seed, strength);
        let shape = shape.expect("bricks").compound().expect("connected");
        let ground = Ground::random(dice);
        assert!(
            !ground.breaks(&shape, Vec3::ZERO),
            "{seed}: {x} {y} {z}, {} parts",
            shape.len()
        );
    }
}

#[test]
fn what_lies_over_an_edge_breaks_where_theory_says() {
    for seed in 0..16 {
        let dice = &mut Dice::new(seed);
        let (count, size) = (16 + dice.below(6), dice.vector(0.1, 0.3));
        let size = size.with_x(size.x.max(0.7 * size.y));
        let over = count / 3 + dice.below(count / 8);
        let free = over as f32 * size.x;
        let weight = 1000.0 * size.y * size.z * free * 9.81;
        let stress = 0.5 * weight * free / (size.z * size.y * size.y / 6.0);
        let mut ground = Ground::random(dice);
        let table = ConvexMesh::cuboid(10.0, 1.0, 10.0).expect("a table");
        (ground.shape, ground.at) = (Shape::Convex(table), Vec3::new(-5.0, -0.5, 0.0));
        let end = Vec3::X * (free - count as f32 * size.x);
        for (share, breaks) in [(0.85, true), (1.2, false)] {
            let found = ground.breaks(&row(count, size, share * stress), end);
            assert_eq!(found, breaks, "{seed}: {over} of {count}, {size}, {share}");
        }
    }
}
