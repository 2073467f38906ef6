//! What rests on joints falls asleep, and what is changed about a joint acts in the next step, asleep or not, on plain data and on entities.

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use crate::members::{Carrier, Member, Rig};
use crate::scene::{H, heavy};
use crate::statics::{RESTS, Rest, Resting, along};
use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_time::Time;
use bevy_transform::components::Transform;
use glam::{Quat, Vec3};
use std::time::Duration;

/// Members of each kind of rest.
const SEEDS: u64 = 4;

/// What is done to a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Change {
    Remove,
    Weaken,
    LetGo,
    Motor,
    Anchor,
}

const CHANGES: [Change; 5] = [
    Change::Remove,
    Change::Weaken,
    Change::LetGo,
    Change::Motor,
    Change::Anchor,
];

/// A body at rest on what does not move.
fn resting(rest: Rest, seed: u64) -> Resting {
    let mut dice = Dice::new(1000 * rest as u64 + seed);
    let mut member = Member::draw(&mut dice);
    if let Carrier::Moving(_) = member.carrier {
        member.carrier = Carrier::Moving(Vec3::ZERO);
    }
    Resting::new(rest, member, &mut dice)
}

/// A speed of a member, m/s.
fn natural(member: &Member) -> f32 {
    (member.size * member.gravity.length()).sqrt()
}

impl Change {
    /// Of a joint that stays.
    fn make(self, joint: &mut Joint, member: &Member) {
        match self {
            Self::Remove => {}
            Self::Weaken => joint.break_force = 0.9 * member.weight().length(),
            Self::LetGo => {
                joint.linear = [JointAxis::FREE; 3];
                joint.angular = [JointAxis::FREE; 3];
                joint.distance = JointAxis::FREE;
            }
            Self::Motor => {
                let speed = 0.1 * natural(member) / member.size;
                let motor = JointDrive::velocity(speed, f32::INFINITY);
                joint.angular[0] = JointAxis::FREE.with_drive(motor);
            }
            Self::Anchor => joint.frame_b.position += 0.01 * member.size * Vec3::X,
        }
    }

    /// Whether it is seen in a step: by velocities, how far the body went, and whether the joint broke.
    fn is_seen(self, member: &Member, [v, omega, moved]: [Vec3; 3], has_broken: bool) -> bool {
        let fall = member.step() * member.gravity;
        match self {
            Self::Remove | Self::LetGo => v.distance(fall) < 0.01 * fall.length(),
            Self::Weaken => has_broken,
            Self::Motor => omega.length() > 0.05 * natural(member) / member.size,
            // A spring is pulled a little farther, all else is put where it belongs.
            Self::Anchor => moved != Vec3::ZERO && v.is_finite(),
        }
    }
}

#[test]
fn what_rests_on_a_joint_sleeps_until_that_is_changed() {
    for (rest, seed) in RESTS
        .into_iter()
        .flat_map(|rest| (0..SEEDS).map(move |seed| (rest, seed)))
    {
        for change in CHANGES {
            let mut resting = resting(rest, seed);
            let (body, id, member) = (resting.body, resting.id, resting.rig.member);
            resting.rig.simulation.config.sleep = SleepConfig::default();
            // Half a second is what it takes, and what is soft comes to rest before.
            for _ in 0..(2.0 * member.rate) as usize {
                resting.rig.step();
            }
            assert!(
                resting.rig.simulation.bodies.is_asleep(body),
                "{rest:?} {seed} {member:?}"
            );
            let before = resting.rig.simulation.bodies.center_of_mass(body);
            if change == Change::Remove {
                let Simulation { joints, bodies, .. } = &mut resting.rig.simulation;
                assert!(joints.remove(bodies, id));
            } else {
                resting.rig.change(id, |joint| change.make(joint, &member));
            }
            resting.rig.step();
            let (v, omega) = resting.rig.velocity(body);
            let Simulation { joints, bodies, .. } = &resting.rig.simulation;
            let moved = bodies.center_of_mass(body) - before;
            let is_seen = change.is_seen(&member, [v, omega, moved], joints.broken.len() == 1);
            let is_awake = !bodies.is_asleep(body);
            assert!(
                is_seen && is_awake,
                "{rest:?} {seed} {change:?}: {v} {omega} {moved} {member:?}"
            );
        }
    }
}

/// The same scene as an app; its body and its joint.
fn app_of(resting: &Resting) -> (App, Entity, Entity) {
    let rig = &resting.rig;
    let mut app = App::new();
    app.init_resource::<Time>();
    app.add_plugins(CleavePlugin::new(bevy_app::Update));
    app.insert_resource(SolverConfig {
        sleep: SleepConfig::default(),
        ..rig.simulation.config
    });
    app.insert_resource(Gravity(rig.member.gravity));
    let world = app.world_mut();
    let bodies = rig.descs.iter();
    let bodies: Vec<Entity> = bodies.map(|desc| world.spawn_body(desc.clone())).collect();
    let entity = |slot: Option<u32>| slot.map(|slot| bodies[slot as usize]);
    let joints = &rig.simulation.joints;
    let mut last = Entity::PLACEHOLDER;
    for id in joints.iter() {
        let [a, b] = joints.bodies(id).expect("there").map(entity);
        let joint = *joints.get(id).expect("there");
        last = world.commands().join(a, b.expect("a body"), joint);
        world.flush();
    }
    (app, bodies[resting.body as usize], last)
}

#[test]
fn what_rests_as_an_entity_sleeps_until_its_joint_is_changed() {
    for (rest, change) in RESTS
        .into_iter()
        .flat_map(|rest| CHANGES.map(|change| (rest, change)))
    {
        let resting = resting(rest, 0);
        let member = resting.rig.member;
        let (mut app, body, joint) = app_of(&resting);
        let step = |app: &mut App| {
            let h = Duration::from_secs_f32(member.step());
            app.world_mut().resource_mut::<Time>().advance_by(h);
            app.update();
        };
        let place = |app: &App| {
            let transform = app.world().get::<Transform>(body);
            transform.expect("a body").translation
        };
        for _ in 0..(2.0 * member.rate) as usize {
            step(&mut app);
        }
        assert!(
            app.world().get::<Sleeping>(body).is_some(),
            "{rest:?} {member:?}"
        );
        let before = place(&app);
        if change == Change::Remove {
            app.world_mut().despawn(joint);
        } else {
            let mut joint = app.world_mut().get_mut::<Joint>(joint).expect("there");
            change.make(&mut joint, &member);
        }
        step(&mut app);
        let world = app.world();
        let v = world.get::<LinearVelocity>(body).expect("a body").0;
        let omega = world.get::<AngularVelocity>(body).expect("a body").0;
        let moved = place(&app) - before;
        let has_broken = world.get::<Joint>(joint).is_none();
        let is_seen = change.is_seen(&member, [v, omega, moved], has_broken);
        let is_awake = world.get::<Sleeping>(body).is_none();
        assert!(
            is_seen && is_awake,
            "{rest:?} {change:?}: {v} {omega} {moved} {member:?}"
        );
    }
}

/// A hinge whose range is beyond half a turn is where it was put.
#[test]
fn turns_are_counted_from_the_range_that_they_have() {
    for middle in [-5.0_f32, -3.5, -1.0, 0.0, 1.0, 3.1, 4.0, 5.5, 9.0] {
        let mut simulation = awake();
        simulation.gravity.0 = Vec3::ZERO;
        let body = heavy(Vec3::ONE, Vec3::ZERO, 1.0);
        let slot = simulation.bodies.insert(body).expect("usable");
        let mut joint = Joint::hinge().with_angular_limits(middle - 0.2, middle + 0.2);
        joint.frame_a.rotation = Quat::from_axis_angle(Vec3::X, -middle);
        let id = simulation.join(None, slot, joint).expect("usable");
        for _ in 0..30 {
            simulation.step(H);
        }
        let angle = simulation.joints.load(id).expect("there").angle;
        assert!((angle - middle).abs() < 1e-5, "{middle}: {angle}");
        let turned = simulation.bodies.pose(slot).rotation.xyz().length();
        assert!(turned < 1e-5, "{middle}: {turned}");
    }
}

/// Where the center of a wheel, its hinge and the origin are one, what is amiss has no size to be compared with but that of the wheel: it is
/// solved as anywhere else.
#[test]
fn wheels_on_their_centers_turn_at_the_origin_as_elsewhere() {
    for seed in 0..8 {
        let mut ends = Vec::new();
        for far in [0.0, 1.0] {
            let mut dice = Dice::new(seed);
            let member = Member {
                carrier: Carrier::World,
                gravity: Vec3::ZERO,
                ..Member::draw(&mut dice)
            };
            let mut rig = Rig::new(member, &mut dice);
            let axis = dice.direction();
            let at = far * member.size * dice.vector(-3.0, 3.0);
            let pose = Pose::new(at, along(&mut dice, axis));
            let size = member.size * Vec3::new(0.2, 1.0, 1.0);
            let body = rig.add(size, pose, member.mass);
            rig.join(None, body, Joint::hinge(), [pose; 2]);
            let spin = 0.1 * member.rate * axis;
            let bodies = &mut rig.simulation.bodies;
            bodies.set_velocity(body, Vec3::ZERO, spin).expect("finite");
            (0..120).for_each(|_| rig.step());
            ends.push(rig.simulation.bodies.pose(body).rotation);
        }
        assert_eq!(ends[0], ends[1], "{seed}");
    }
}
