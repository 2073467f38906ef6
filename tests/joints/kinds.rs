//! What a kind of joint lets move moves as if it were free, and what it does not let move stays.

use crate::common::scenes::awake;
use crate::scene::{H, Random, gap, heavy};
use bevy_cleave::prelude::*;
use glam::{DQuat, DVec3, Quat, Vec3};

/// Places of B's frame in A's: where its anchor is, and how it is turned.
struct Relative {
    at: DVec3,
    turn: DQuat,
}

fn relative(simulation: &Simulation, id: JointId) -> Relative {
    let joint = simulation.joints.get(id).expect("there");
    let slots = simulation.joints.bodies(id).expect("there");
    let frames = [joint.frame_a, joint.frame_b];
    let [a, b] = [0, 1].map(|side| {
        let pose = slots[side].map_or(Pose::IDENTITY, |slot| simulation.bodies.pose(slot));
        let turn = pose.rotation.as_dquat().normalize();
        let at = pose.position.as_dvec3() + turn * frames[side].position.as_dvec3();
        (at, turn * frames[side].rotation.as_dquat().normalize())
    });
    let turn = a.1.inverse() * b.1;
    Relative {
        at: a.1.inverse() * (b.0 - a.0),
        turn: if turn.w < 0.0 { -turn } else { turn },
    }
}

/// Two bodies of random shapes, masses, places and velocities, joined at a random point between them.
fn pair(random: &mut Random, joint: Joint, to_world: bool) -> (Simulation, JointId) {
    let mut simulation = awake();
    simulation.gravity.0 = random.vector(-5.0, 5.0);
    let bodies = [Vec3::ZERO, Vec3::new(1.6, 0.0, 0.0)].map(|at| {
        let size = random.vector(0.3, 1.0);
        let mass = random.range(0.5, 20.0);
        let mut body = heavy(size, at + random.vector(-0.1, 0.1), mass);
        body.pose.rotation = random.rotation();
        body.linear_velocity = random.vector(-2.0, 2.0);
        body.angular_velocity = random.vector(-3.0, 3.0);
        body
    });
    let [a, b] = bodies.map(|body| simulation.bodies.insert(body).expect("usable"));
    let frame = Pose::new(
        Vec3::new(0.8, 0.0, 0.0) + random.vector(-0.2, 0.2),
        random.rotation(),
    );
    let pose_a = if to_world {
        Pose::IDENTITY
    } else {
        simulation.bodies.pose(a)
    };
    let poses = [pose_a, simulation.bodies.pose(b)];
    let joint = joint.with_frame(frame, poses);
    let id = simulation.join((!to_world).then_some(a), b, joint);
    (simulation, id.expect("usable"))
}

/// Largest of what does not move, and of what moves, in two seconds: axes of A's frame, m and rad.
fn travel(simulation: &mut Simulation, id: JointId) -> ([f64; 3], [f64; 3]) {
    let (mut linear, mut angular) = ([0.0_f64; 3], [0.0_f64; 3]);
    for _ in 0..120 {
        simulation.step(H);
        let now = relative(simulation, id);
        for (most, now) in linear.iter_mut().zip(now.at.to_array()) {
            *most = most.max(now.abs());
        }
        // Of a turn about x, where nothing else turns, only x is left.
        let turn = [now.turn.x, now.turn.y, now.turn.z];
        for (most, now) in angular.iter_mut().zip(turn) {
            *most = most.max(2.0 * now.abs());
        }
    }
    (linear, angular)
}

fn check(name: &str, joint: Joint, free_linear: [bool; 3], free_angular: [bool; 3]) {
    let mut random = Random::new(7);
    for member in 0..12 {
        let (mut simulation, id) = pair(&mut random, joint, member % 3 == 0);
        let (linear, angular) = travel(&mut simulation, id);
        for i in 0..3 {
            for (moved, is_free, what) in [
                (linear[i], free_linear[i], "along"),
                (angular[i], free_angular[i], "about"),
            ] {
                let is_right = if is_free { moved > 0.01 } else { moved < 1e-5 };
                assert!(is_right, "{name} {member}: {moved:e} {what} axis {i}");
            }
        }
    }
}

#[test]
fn a_fixed_joint_lets_nothing_move() {
    check("fixed", Joint::fixed(), [false; 3], [false; 3]);
}

#[test]
fn a_ball_joint_lets_bodies_turn() {
    check("ball", Joint::ball(), [false; 3], [true; 3]);
}

#[test]
fn a_hinge_lets_bodies_turn_about_its_axis() {
    check("hinge", Joint::hinge(), [false; 3], [true, false, false]);
}

#[test]
fn a_slider_lets_bodies_slide_along_its_axis() {
    check("slider", Joint::slider(), [true, false, false], [false; 3]);
}

#[test]
fn a_cylindrical_joint_does_both() {
    let free = [true, false, false];
    check("cylindrical", Joint::cylindrical(), free, free);
}

#[test]
fn rods_keep_their_length_and_ropes_do_not_grow() {
    let mut random = Random::new(3);
    let mut slack = 0;
    for member in 0..12 {
        for joint in [Joint::rod(0.7), Joint::rope(0.7)] {
            let (mut simulation, id) = pair(&mut random, joint, member % 3 == 0);
            let mut joint = *simulation.joints.get(id).expect("there");
            joint.frame_b.position += simulation
                .bodies
                .pose(simulation.joints.bodies(id).expect("there")[1].expect("a body"))
                .rotation
                .inverse()
                * Vec3::new(0.7, 0.0, 0.0);
            let Simulation { joints, bodies, .. } = &mut simulation;
            joints.set(bodies, id, joint).expect("usable");
            let is_rod = joint.distance == Joint::rod(0.7).distance;
            let mut shortest = f64::INFINITY;
            for _ in 0..120 {
                simulation.step(H);
                let length = gap(&simulation, id);
                shortest = shortest.min(length);
                assert!(length < 0.7 + 1e-5, "{member}: {length}");
                assert!(!is_rod || length > 0.7 - 1e-5, "{member}: {length}");
            }
            slack += usize::from(!is_rod && shortest < 0.7 - 1e-3);
        }
    }
    assert!(slack > 3, "ropes were slack {slack} times");
}

#[test]
fn a_cone_twist_joint_stays_in_its_cone() {
    let mut random = Random::new(11);
    let (swing, twist) = (0.5, 0.3);
    for member in 0..12 {
        let joint = Joint::cone_twist(swing, twist);
        let (mut simulation, id) = pair(&mut random, joint, member % 3 == 0);
        let mut widest = [0.0_f64; 2];
        for _ in 0..240 {
            simulation.step(H);
            let now = relative(&simulation, id);
            let angle = (now.turn * DVec3::X).dot(DVec3::X).clamp(-1.0, 1.0);
            let turn = 2.0 * (now.turn.x / now.turn.w).atan_of();
            widest[0] = widest[0].max(angle.acos_of());
            widest[1] = widest[1].max(turn.abs());
            // Pairs fall by 40 m, where coordinates are as round as that.
            assert!(now.at.length() < 2e-5, "{member}: {:e}", now.at.length());
        }
        assert!(widest[0] < f64::from(swing) + 2e-3, "{member}: {widest:?}");
        assert!(widest[1] < f64::from(twist) + 2e-3, "{member}: {widest:?}");
        assert!(widest[0] > 0.3, "{member}: {widest:?}");
    }
}

#[test]
fn what_is_put_together_wrongly_comes_together_without_blowing_up() {
    for turn in [
        Quat::from_xyzw(1.0, 0.0, 0.0, 0.0),
        Quat::from_xyzw(0.0, 1.0, 0.0, 0.0),
        Quat::from_xyzw(0.5, 0.5, 0.5, 0.5),
    ] {
        for joint in [Joint::fixed(), Joint::hinge()] {
            let mut simulation = awake();
            simulation.gravity.0 = Vec3::ZERO;
            let mut body = heavy(Vec3::ONE, Vec3::new(1.0, 0.3, 0.0), 2.0);
            body.pose.rotation = turn;
            let slot = simulation.bodies.insert(body).expect("usable");
            let joint = joint.with_anchors(Vec3::ZERO, Vec3::new(-0.5, 0.0, 0.0));
            let id = simulation.join(None, slot, joint).expect("usable");
            let mut fastest = 0.0_f32;
            for _ in 0..240 {
                simulation.step(H);
                let (v, omega) = simulation.bodies.velocity(slot);
                fastest = fastest.max(v.length()).max(omega.length());
            }
            assert!(
                gap(&simulation, id) < 1e-5,
                "{turn} {}",
                gap(&simulation, id)
            );
            let error = simulation.joints.load(id).expect("there").error;
            assert!(error[1] < 1e-5, "{turn}: {error:?}");
            assert!(fastest < 30.0, "{turn}: {fastest}");
        }
    }
}

/// Functions of the platform's library are good enough to check with.
trait Arcs {
    fn acos_of(self) -> f64;
    fn atan_of(self) -> f64;
}

#[expect(
    clippy::disallowed_methods,
    reason = "a test may differ in the last bit"
)]
impl Arcs for f64 {
    fn acos_of(self) -> f64 {
        self.acos()
    }

    fn atan_of(self) -> f64 {
        self.atan()
    }
}
