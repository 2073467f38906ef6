//! How the bodies of a pair move against each other within a step: straight, and turning steadily.

use crate::contact::local_manifold::LocalManifold;
use crate::math::{Pose, rotate, rotate_by};
use glam::{Quat, Vec3};

/// Distance that counts as none, as a share of the smaller shape's diagonal: moments that come ever closer end there.
pub(super) const TOUCH: f32 = 3e-5;

/// Share of its length by which a motion may run against what it goes along.
pub(super) const ALONG: f32 = 0.01;

/// How two shapes move against each other within a step, in A's frame at its start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Course {
    /// At the start.
    pub(crate) b_in_a: Pose,
    /// Centers of mass, own frames, m.
    pub(crate) centers: [Vec3; 2],
    /// How far B's center goes as seen from A's, m.
    pub(crate) travel: Vec3,
    /// How far they turn, rad.
    pub(crate) spins: [Vec3; 2],
    /// Largest distances of the surfaces from the centers, m.
    pub(crate) radii: [f32; 2],
    /// The moment up to which the motion may go in the step, which is more than 1 where gravity may hasten it.
    pub(crate) end: f32,
}

impl Course {
    /// How A has turned at a moment from 0 to 1.
    pub(crate) fn turn_of_a(&self, moment: f32) -> Quat {
        rotate_by(Quat::IDENTITY, self.spins[0], moment)
    }

    /// From A's center of mass to B's at the start, m.
    pub(crate) fn apart(&self) -> Vec3 {
        self.b_in_a.transform_point(self.centers[1]) - self.centers[0]
    }

    /// B's pose in A's frame at a moment.
    pub(crate) fn at(&self, moment: f32) -> Pose {
        let back = self.turn_of_a(moment).inverse();
        let turn = rotate_by(self.b_in_a.rotation, self.spins[1], moment);
        let rotation = (back * turn).normalize();
        let center = self.centers[0] + rotate(back, self.apart() + moment * self.travel);
        Pose::new(center - rotate(rotation, self.centers[1]), rotation)
    }

    /// How far turning can bring surfaces together in the whole step, m.
    pub(crate) fn turning(&self) -> f32 {
        self.spins[0].length() * self.radii[0] + self.spins[1].length() * self.radii[1]
    }

    /// How far turning can take the height of a point from its chord over the whole step, m.
    pub(crate) fn bend(&self) -> f32 {
        let bends = [0, 1].map(|i| self.spins[i].length_squared() * self.radii[i]);
        0.125 * (bends[0] + bends[1])
    }

    /// How fast B comes towards A along `normal` (A's frame at `moment`) at a point there, m per step.
    pub(crate) fn approach(&self, moment: f32, normal: Vec3, point: Vec3) -> f32 {
        let turn = self.turn_of_a(moment);
        let from_a = rotate(turn, point - self.centers[0]);
        let from_b = from_a - (self.apart() + moment * self.travel);
        let velocity = self.travel + self.spins[1].cross(from_b) - self.spins[0].cross(from_a);
        -velocity.dot(rotate(turn, normal))
    }

    /// The moment from `first` on at which the centers are nearest.
    pub(crate) fn nearest_moment(&self, first: f32) -> f32 {
        let moment = -self.apart().dot(self.travel) / self.travel.length_squared();
        // Not a number where nothing travels.
        if moment > first {
            moment.min(self.end)
        } else {
            first
        }
    }

    /// The patch as found at a moment with this pose, its normal bound to the body that turns less.
    pub(crate) fn bind(&self, patch: LocalManifold, pose: &Pose) -> LocalManifold {
        let turns = self.spins.map(|spin| spin.length_squared());
        let in_b = rotate(pose.rotation.inverse(), patch.normal);
        LocalManifold {
            normal_in_b: (turns[1] < turns[0]).then_some(in_b),
            ..patch
        }
    }
}
