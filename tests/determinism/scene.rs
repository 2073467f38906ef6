//! What is simulated, and what makes sure that it is what the names say.

use crate::heaps::heap;
use crate::structures::{block, cuboid, pyramid, tower};
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// A scene with a hash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scene {
    /// Two heaps apart from each other, of 84 bodies of which every third can break.
    BreakingPile,
    /// A pyramid of 12 rows.
    Pyramid,
    /// A tower of 10 that a fast ball flies into, and bouncing bodies beside it.
    Mixed,
}

/// What happened in a run.
#[derive(Debug, Default)]
pub(crate) struct Events {
    /// Bodies that broke.
    pub(crate) fractures: usize,
    /// Largest number of manifolds in a step.
    pub(crate) manifolds: usize,
    /// Fastest body at the end, m/s.
    pub(crate) speed: f32,
    /// Lowest centre of mass at the end, m.
    pub(crate) lowest: f32,
}

impl Scene {
    /// All of them.
    pub(crate) const ALL: [Self; 3] = [Self::BreakingPile, Self::Pyramid, Self::Mixed];

    /// Steps of 1/60 s.
    pub(crate) fn steps(self) -> u32 {
        match self {
            Self::BreakingPile => 1000,
            Self::Pyramid | Self::Mixed => 300,
        }
    }

    /// How it is solved, but for the lanes: the default, with less effort where there are many steps to make.
    pub(crate) fn config(self) -> SolverConfig {
        let mut config = SolverConfig::default();
        if self == Self::BreakingPile {
            (config.max_substeps, config.spare_updates) = (8, 1000);
        }
        config
    }

    /// The bodies, in the order that decides their ids.
    pub(crate) fn bodies(self) -> Vec<BodyDesc> {
        match self {
            Self::BreakingPile => breaking_pile(),
            Self::Pyramid => pyramid(12),
            Self::Mixed => mixed(),
        }
    }

    /// Panics if the scene did not go as its name says: a hash of something else would prove nothing.
    pub(crate) fn check(self, events: &Events) {
        assert!(
            events.lowest > 0.0,
            "{self:?}: all stay on the floor, {events:?}"
        );
        match self {
            Self::BreakingPile => {
                assert!(events.fractures >= 10, "several break: {events:?}");
                assert!(
                    events.manifolds > 256,
                    "enough for several threads: {events:?}"
                );
            }
            Self::Pyramid => assert!(events.speed < 0.01, "it stands: {events:?}"),
            Self::Mixed => assert!(events.speed < 50.0, "the ball is stopped: {events:?}"),
        }
    }
}

fn breaking_pile() -> Vec<BodyDesc> {
    let mut bodies = heap(84);
    for (i, body) in bodies.iter_mut().enumerate().skip(1) {
        if i > 42 {
            body.pose.position.x += 30.0;
        }
        if i % 3 == 0 {
            body.fracturable = Some(Fracturable {
                strength: 150.0,
                seed: i as u64,
                least_volume: 1e-3,
                ..Default::default()
            });
        }
    }
    bodies
}

fn mixed() -> Vec<BodyDesc> {
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
