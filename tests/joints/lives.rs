//! Joints while their bodies are moved, copied, disabled, cut, broken and bonded.

use crate::common::scenes::awake;
use crate::entities::{app, bob, hanging, join, place, step, steps};
use crate::scene::{H, chain, fixed, gap, heavy};
use bevy_cleave::prelude::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::Vec3;

#[test]
fn a_body_that_is_put_elsewhere_comes_back_without_a_blow() {
    let mut app = app();
    let (bob, joint) = hanging(&mut app);
    steps(&mut app, 10);
    app.world_mut()
        .get_mut::<Transform>(bob)
        .expect("a body")
        .translation = Vec3::new(4.0, 2.0, 0.0);
    let mut fastest = 0.0_f32;
    for _ in 0..300 {
        step(&mut app);
        let velocity = app.world().get::<LinearVelocity>(bob).expect("a body").0;
        fastest = fastest.max(velocity.length());
    }
    let load = app.world().get::<JointLoad>(joint).expect("required");
    assert!(load.error[0] < 1e-4, "{load:?}");
    // No more than what it falls while it is brought back.
    assert!(fastest < 12.0, "{fastest}");
}

#[test]
fn a_chain_that_is_put_elsewhere_as_a_whole_notices_nothing() {
    let mut app = app();
    let hook = BodyDesc {
        kind: RigidBody::Kinematic,
        ..fixed(Vec3::ZERO)
    };
    let hook = app.world_mut().spawn_body(hook);
    let mut bodies = vec![hook];
    for i in 1..=4_u8 {
        let link = bob(&mut app, Vec3::new(0.0, -f32::from(i), 0.0));
        let joint = Joint::ball().with_anchors(-0.5 * Vec3::Y, 0.5 * Vec3::Y);
        join(&mut app, bodies.last().copied(), link, joint);
        bodies.push(link);
    }
    steps(&mut app, 60);
    let shift = Vec3::new(30.0, 5.0, -20.0);
    let before: Vec<Vec3> = bodies.iter().map(|&body| place(&app, body)).collect();
    for &body in &bodies {
        let mut transform = app.world_mut().get_mut::<Transform>(body).expect("a body");
        transform.translation += shift;
    }
    steps(&mut app, 30);
    for (&body, before) in bodies.iter().zip(before) {
        let moved = place(&app, body) - before;
        assert!(moved.distance(shift) < 1e-3, "{moved}");
    }
}

#[test]
fn a_copy_of_a_joint_is_a_joint_and_a_copy_of_a_body_hangs_on_nothing() {
    let mut app = app();
    let (bob, joint) = hanging(&mut app);
    steps(&mut app, 2);
    let copy = app.world_mut().entity_mut(joint).clone_and_spawn();
    steps(&mut app, 2);
    assert_eq!(app.world().resource::<Joints>().len(), 2);
    let handle = |entity: Entity| app.world().get::<JointHandle>(entity).and_then(|h| h.get());
    assert!(handle(copy).is_some() && handle(copy) != handle(joint));
    let free = app.world_mut().entity_mut(bob).clone_and_spawn();
    app.world_mut()
        .entity_mut(free)
        .insert(Transform::from_xyz(5.0, -1.0, 0.0));
    steps(&mut app, 60);
    assert_eq!(app.world().resource::<Joints>().len(), 2);
    assert!(place(&app, free).y < -4.0, "{}", place(&app, free));
    assert!(place(&app, bob).distance(Vec3::NEG_Y) < 1e-3);
    app.world_mut().despawn(joint);
    steps(&mut app, 60);
    // The copy still holds it.
    assert!(place(&app, bob).distance(Vec3::NEG_Y) < 1e-3);
}

#[test]
fn a_joint_goes_with_either_of_its_bodies() {
    for goes in [0, 1] {
        let mut app = app();
        let bodies = [bob(&mut app, Vec3::ZERO), bob(&mut app, Vec3::NEG_Y)];
        let joint = Joint::ball().with_anchors(-0.5 * Vec3::Y, 0.5 * Vec3::Y);
        let joint = join(&mut app, Some(bodies[0]), bodies[1], joint);
        steps(&mut app, 2);
        app.world_mut().despawn(bodies[goes]);
        steps(&mut app, 10);
        assert!(app.world().get_entity(joint).is_err());
        assert!(app.world().resource::<Joints>().is_empty());
        assert!(place(&app, bodies[1 - goes]).is_finite());
    }
}

#[test]
fn a_disabled_body_leaves_its_joint_and_comes_back_to_it() {
    let mut app = app();
    let (bob, joint) = hanging(&mut app);
    steps(&mut app, 2);
    app.world_mut().entity_mut(bob).insert(Disabled);
    steps(&mut app, 30);
    app.world_mut().entity_mut(bob).remove::<Disabled>();
    steps(&mut app, 30);
    assert_eq!(app.world().resource::<Joints>().len(), 1);
    assert!(place(&app, bob).distance(Vec3::NEG_Y) < 1e-3);
    assert!(app.world().get::<JointProblem>(joint).is_none());
}

#[test]
fn what_sleeps_on_a_joint_falls_when_the_joint_goes() {
    let mut app = app();
    app.world_mut().resource_mut::<SolverConfig>().sleep = SleepConfig::default();
    let (bob, joint) = hanging(&mut app);
    steps(&mut app, 90);
    assert!(app.world().get::<Sleeping>(bob).is_some());
    app.world_mut().despawn(joint);
    steps(&mut app, 30);
    assert!(place(&app, bob).y < -1.5);
}

/// A chain hangs with a load; its third link is hit, and shatters.
#[test]
fn a_link_that_shatters_lets_go() {
    let mut chain = chain(5, 5.0, Vec3::NEG_Y, Vec3::ZERO);
    let simulation = &mut chain.simulation;
    let link = 2;
    simulation.bodies.set_fracturable(
        link,
        Some(Fracturable {
            pattern: FracturePattern::Voronoi {
                cells: 8,
                focus: 0.0,
            },
            ..Fracturable::with_strength(1.0)
        }),
    );
    let mut shot = heavy(Vec3::splat(0.2), Vec3::new(-2.0, -2.5, 0.0), 3.0);
    shot.linear_velocity = Vec3::new(40.0, 0.0, 0.0);
    simulation.bodies.insert(shot).expect("usable");
    let mut has_broken = false;
    for _ in 0..90 {
        simulation.step(H);
        has_broken |= !simulation.fractures.done.is_empty();
    }
    assert!(has_broken);
    // The load falls, and takes its side of the chain along; the other side hangs on.
    let load = simulation.bodies.center_of_mass(5);
    assert!(load.y < -8.0, "{load}");
    let hung = simulation.bodies.center_of_mass(0);
    assert!(hung.length() < 1.0, "{hung}");
    for id in simulation.joints.iter().collect::<Vec<_>>() {
        let gap = gap(simulation, id);
        assert!(gap < 1e-3, "{gap}");
    }
}

/// Two blocks side by side, bonded and joined: the bond carries what the joint lets go, and when it breaks the joint still holds.
#[test]
fn a_bond_and_a_joint_hold_the_same_pair() {
    for contacts in [false, true] {
        let mut simulation = awake();
        let post = BodyDesc {
            kind: RigidBody::Static,
            ..heavy(Vec3::ONE, Vec3::ZERO, 1.0)
        };
        let post = simulation.bodies.insert(post).expect("usable");
        let arm = heavy(Vec3::ONE, Vec3::X, 10.0);
        let arm = simulation.bodies.insert(arm).expect("usable");
        let bonds = simulation.bond_neighbors(&[post, arm], 2e3);
        assert_eq!(bonds, Ok(1));
        // At the lower edge of the common face, about which the arm can turn.
        let [on_post, on_arm] = [0.5, -0.5].map(|x| Vec3::new(x, -0.5, 0.0));
        let joint = Joint::hinge()
            .with_axes(Vec3::Z, Vec3::Z)
            .with_anchors(on_post, on_arm)
            .with_contacts(contacts);
        let id = simulation.join(Some(post), arm, joint).expect("usable");
        for _ in 0..60 {
            simulation.step(H);
        }
        let level = simulation.bodies.center_of_mass(arm);
        assert!(level.distance(Vec3::X) < 1e-3, "{contacts}: {level}");
        assert_eq!(simulation.bonds.len(), 1, "{contacts}");
        // A blow tears the bond; the hinge swings.
        simulation
            .bodies
            .set_velocity(arm, Vec3::ZERO, Vec3::new(0.0, 0.0, -60.0))
            .expect("finite");
        for _ in 0..20 {
            simulation.step(H);
        }
        assert_eq!(simulation.bonds.len(), 0, "{contacts}");
        assert!(gap(&simulation, id) < 1e-3, "{contacts}");
        assert!(simulation.bodies.center_of_mass(arm).y < -0.2, "{contacts}");
    }
}
