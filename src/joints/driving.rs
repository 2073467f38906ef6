//! Whether a motor moves what it holds.

use crate::bodies::driving::STALLED;
use crate::bodies::store::Bodies;
use crate::joints::axis::{DriveTarget, JointAxis};
use crate::joints::store::JointRecord;
use glam::Vec3;

impl JointRecord {
    /// Whether a motor of the joint keeps it going, however slowly.
    pub(crate) fn is_driven(&self, bodies: &Bodies) -> bool {
        let joint = &self.joint;
        let linear = joint.linear.iter().chain([&joint.distance]);
        let [linear, angular] = [fastest(linear), fastest(&joint.angular)];
        if linear == 0.0 && angular == 0.0 {
            return false;
        }
        let frames = [joint.frame_a.position, joint.frame_b.position];
        let motion = |end: usize| {
            self.ends[end].map_or([Vec3::ZERO; 2], |(slot, _)| {
                let anchor = bodies.pose(slot).transform_point(frames[end]);
                [bodies.velocity_at(slot, anchor), bodies.velocity(slot).1]
            })
        };
        let [a, b] = [motion(0), motion(1)];
        let [along, turning] = [0, 1].map(|kind| (b[kind] - a[kind]).length());
        linear > 0.0 && along > STALLED * linear || angular > 0.0 && turning > STALLED * angular
    }
}

/// Greatest speed that a motor of some axes aims at, m/s or rad/s.
fn fastest<'a>(axes: impl IntoIterator<Item = &'a JointAxis>) -> f32 {
    let speeds = axes.into_iter().map(|axis| match axis.drive {
        Some(drive) if drive.max_force > 0.0 => match drive.target {
            DriveTarget::Velocity(velocity) => velocity.abs(),
            DriveTarget::Position { .. } => 0.0,
        },
        _ => 0.0,
    });
    speeds.fold(0.0, f32::max)
}
