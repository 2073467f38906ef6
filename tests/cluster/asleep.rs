//! Loads of large clusters, which fall asleep before it is worked out what they do.

use crate::common::dice::Dice;
use bevy_cleave::prelude::*;
use glam::Vec3;

/// A beam of many parts that lies on two posts.
#[derive(Debug)]
struct Span {
    counts: [usize; 3],
    size: Vec3,
}

impl Span {
    fn random(seed: u64) -> Self {
        let dice = &mut Dice::new(seed);
        let counts = [23 + 2 * dice.below(8), 2 + dice.below(3), 2 + dice.below(3)];
        let size = dice.vector(0.1, 0.3);
        let slender = 8.0 * size.y * counts[1] as f32 / counts[0] as f32;
        Self {
            counts,
            size: size.with_x(size.x.max(slender)),
        }
    }

    fn parts(&self) -> usize {
        self.counts.into_iter().product()
    }

    fn extents(&self) -> Vec3 {
        self.size * Vec3::from_array(self.counts.map(|count| count as f32))
    }

    /// At the faces of the part in the middle, Pa: moment over section modulus.
    fn stress(&self) -> f32 {
        let Vec3 { x, y, z } = self.extents();
        let (weight, part) = (1000.0 * y * z * 9.81, self.size.x);
        let span = x - part;
        let moment = weight * (span * span / 8.0 - part * part / 4.0);
        moment / (z * y * y / 6.0)
    }

    /// The step within ten seconds in which it breaks, and whether it sleeps in the end.
    fn run(&self, strength: f32) -> (Option<usize>, bool) {
        let mut simulation = Simulation::default();
        let Vec3 { x, y, z } = self.size;
        let brick = ConvexMesh::cuboid(x, y, z).expect("a box");
        let [columns, rows, _] = self.counts;
        let parts = (0..self.parts()).map(|i| {
            let cell = [i % columns, i / columns % rows, i / (columns * rows)];
            let cell = Vec3::from_array(cell.map(|i| i as f32 + 0.5));
            let at = cell * self.size - 0.5 * self.extents();
            (Pose::from_position(at), brick.clone())
        });
        let beam = Cluster::new(parts, strength).expect("parts");
        let beam = beam.compound().expect("a beam");
        let beam = BodyDesc::compound(beam, Vec3::ZERO);
        let beam = simulation.bodies.insert(beam).expect("usable");
        let Vec3 { x: length, y, z } = self.extents();
        for side in [-0.5, 0.5] {
            let post = ConvexMesh::cuboid(0.1 * x, y, z).expect("a box");
            let at = Vec3::new(side * (length - x), -y, 0.0);
            let post = BodyDesc {
                kind: RigidBody::Static,
                ..BodyDesc::dynamic(post, at)
            };
            simulation.bodies.insert(post).expect("usable");
        }
        let broken = (0..600).find(|_| {
            simulation.step(1.0 / 60.0);
            !simulation.fractures.done.is_empty()
        });
        (
            broken,
            broken.is_none() && simulation.bodies.is_asleep(beam),
        )
    }
}

/// Symptom: nobody looked at what slept, and a beam of some hundreds of parts fell asleep first: it bore any load.
#[test]
fn what_falls_asleep_under_too_much_collapses_all_the_same() {
    for seed in 0..6 {
        let span = Span::random(seed);
        let stress = span.stress();
        let (weak, _) = span.run(0.75 * stress);
        assert!(weak.is_some(), "{seed}: {span:?}");
        assert_eq!(span.run(1.3 * stress), (None, true), "{seed}: {span:?}");
    }
}
