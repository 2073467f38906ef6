//! Joints of Jolt, through a few functions of our own, since JoltC has none.

use crate::scene::{self, JointKind, Scene};
use glam::Vec3;
use joltc_sys::{JPC_BodyID, JPC_PhysicsSystem};
use std::ffi::c_void;

/// As in `joints.cpp`.
#[repr(C)]
#[derive(Default)]
struct Frame {
    point: [f32; 3],
    x: [f32; 3],
    y: [f32; 3],
}

/// As in `joints.cpp`.
#[repr(C)]
struct Joint {
    kind: i32,
    frames: [Frame; 2],
    has_range: bool,
    range: [f32; 2],
    has_drive: bool,
    drive: [f32; 2],
}

unsafe extern "C" {
    fn arena_jolt_fits() -> bool;
    fn arena_jolt_join(
        system: *mut c_void,
        bodies: *const JPC_BodyID,
        joint: *const Joint,
        iterations: *const u32,
    );
    fn arena_jolt_group(
        system: *mut c_void,
        group: u32,
        bodies: *const JPC_BodyID,
        members: u32,
        without_contacts: *const [u32; 2],
        pairs: u32,
    );
}

/// Adds the joints of a scene, with so many velocity and position iterations; 0: as Jolt has it.
///
/// # Safety
/// The system is alive and has the bodies.
pub(super) unsafe fn add(
    system: *mut JPC_PhysicsSystem,
    scene: &Scene,
    bodies: &[JPC_BodyID],
    iterations: [u32; 2],
) {
    // SAFETY: the caller's, and arrays are as long as said.
    unsafe {
        assert!(
            arena_jolt_fits(),
            "joints.cpp was compiled with other flags than Jolt"
        );
        let system = system.cast();
        for joint in &scene.joints {
            let ids = joint.bodies.map(|body| bodies[body]);
            arena_jolt_join(system, ids.as_ptr(), &joint_of(joint), iterations.as_ptr());
        }
        for (number, members) in (0..).zip(groups(scene)) {
            let ids: Vec<_> = members.iter().map(|&body| bodies[body]).collect();
            let place = |body| members.binary_search(&body).ok().map(|at| at as u32);
            let pairs: Vec<[u32; 2]> = scene
                .joints
                .iter()
                .filter_map(|joint| Some([place(joint.bodies[0])?, place(joint.bodies[1])?]))
                .collect();
            let counts = (members.len() as u32, pairs.len() as u32);
            arena_jolt_group(
                system,
                number,
                ids.as_ptr(),
                counts.0,
                pairs.as_ptr(),
                counts.1,
            );
        }
    }
}

/// The bodies that joints hold together, each group in order.
fn groups(scene: &Scene) -> Vec<Vec<usize>> {
    let mut of: Vec<usize> = (0..scene.bodies.len()).collect();
    let mut has_changed = true;
    while has_changed {
        has_changed = false;
        for joint in &scene.joints {
            let least = of[joint.bodies[0]].min(of[joint.bodies[1]]);
            for body in joint.bodies {
                has_changed |= of[body] != least;
                of[body] = least;
            }
        }
    }
    let mut groups = vec![vec![]; of.len()];
    for (body, group) in of.into_iter().enumerate() {
        groups[group].push(body);
    }
    groups.retain(|group| group.len() > 1);
    groups
}

fn joint_of(joint: &scene::Joint) -> Joint {
    let kind = match joint.kind {
        JointKind::Fixed => 0,
        JointKind::Ball => 1,
        JointKind::Hinge { .. } => 2,
        JointKind::Slider { .. } => 3,
        JointKind::ConeTwist { .. } => 4,
    };
    let (range, drive) = match joint.kind {
        JointKind::Fixed | JointKind::Ball => (None, None),
        JointKind::Hinge { range, motor } => {
            (range, motor.map(|motor| [motor.speed, motor.max_torque]))
        }
        JointKind::Slider { spring } => (
            None,
            spring.map(|spring| [spring.hertz, spring.damping_ratio]),
        ),
        JointKind::ConeTwist { swing, twist } => (Some([swing, twist]), None),
    };
    let frames = joint.frames.map(|frame| Frame {
        point: frame.pos.to_array(),
        x: (frame.rot * Vec3::X).to_array(),
        y: (frame.rot * Vec3::Y).to_array(),
    });
    Joint {
        kind,
        frames,
        has_range: range.is_some(),
        range: range.unwrap_or_default(),
        has_drive: drive.is_some(),
        drive: drive.unwrap_or_default(),
    }
}
