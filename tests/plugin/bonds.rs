//! Bonds between entities.

use crate::app::{app, bits_of_entity, step_length};
use crate::common::states::bits;
use crate::common::structures::cuboid;
use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::Vec3;

/// What a cube of 1 m weighs, N: 1000 kg/m3 and 9.81 m/s2.
const WEIGHT: f32 = 1000.0 * 9.81;

fn cube() -> ConvexMesh {
    cuboid(Vec3::ONE)
}

fn fixed_cube(at: Vec3) -> BodyDesc {
    BodyDesc {
        kind: RigidBody::Static,
        ..BodyDesc::dynamic(cube(), at)
    }
}

/// A cube that hangs under a fixed one.
fn hanging(app: &mut App) -> [Entity; 2] {
    let upper = app.world_mut().spawn_body(fixed_cube(Vec3::ZERO));
    let lower = BodyDesc::dynamic(cube(), -Vec3::Y);
    [upper, app.world_mut().spawn_body(lower)]
}

fn height(app: &App, entity: Entity) -> f32 {
    let transform = app.world().entity(entity).get::<Transform>();
    transform.expect("a body has a Transform").translation.y
}

fn messages<M: Message + Clone>(app: &mut App) -> Vec<M> {
    app.world_mut()
        .resource_mut::<Messages<M>>()
        .drain()
        .collect()
}

#[test]
fn entities_are_bonded_by_command_and_a_message_names_those_that_come_apart() {
    let mut app = app();
    let [upper, lower] = hanging(&mut app);
    let strong = Bond::new(2.0 * WEIGHT, 1.0);
    app.world_mut().commands().bond(upper, lower, strong);
    (0..60).for_each(|_| app.update());
    assert!((height(&app, lower) + 1.0).abs() < 1e-3, "hangs");
    assert_eq!(messages::<BondBroken>(&mut app), []);

    let weak = Bond::new(0.5 * WEIGHT, 1.0);
    app.world_mut().commands().bond(lower, upper, weak);
    let mut broken = Vec::new();
    for _ in 0..30 {
        app.update();
        broken.extend(messages::<BondBroken>(&mut app));
    }
    let expected = BondBroken {
        entities: [upper, lower],
        bond: weak,
    };
    assert_eq!(broken, [expected]);
    assert!(height(&app, lower) < -1.1, "falls");
}

#[test]
fn neighbors_are_bonded_as_they_are_spawned_and_released_by_command() {
    let mut app = app();
    let entities = hanging(&mut app);
    app.world_mut()
        .commands()
        .bond_neighbors(entities, 2.0 * WEIGHT);
    (0..30).for_each(|_| app.update());
    assert_eq!(app.world().resource::<Bonds>().len(), 1);
    app.world_mut().commands().unbond(entities[0], entities[1]);
    (0..30).for_each(|_| app.update());
    assert!(app.world().resource::<Bonds>().is_empty());
    assert_eq!(messages::<BondBroken>(&mut app), [], "it was taken away");
    assert!(height(&app, entities[1]) < -1.5);
}

/// One cube is held by three static ones around it; one of those holds another cube too.
#[test]
fn an_entity_lets_go_of_all_that_held_it_and_of_nothing_else() {
    let mut app = app();
    let [upper, lower] = hanging(&mut app);
    let bond = Bond::new(20.0 * WEIGHT, 1.0);
    let beside = |x: f32| (RigidBody::Static, cube(), Transform::from_xyz(x, -1.0, 0.0));
    let [left, right] = [-1.0, 1.0].map(|x| app.world_mut().spawn(beside(x)).id());
    let under = (
        RigidBody::Dynamic,
        cube(),
        Transform::from_xyz(-1.0, -2.0, 0.0),
    );
    let under = app.world_mut().spawn(under).id();
    let mut commands = app.world_mut().commands();
    commands.bond_neighbors([upper, lower, left, right], 20.0 * WEIGHT);
    commands.bond(left, under, bond);
    (0..10).for_each(|_| app.update());
    assert_eq!(app.world().resource::<Bonds>().len(), 4);
    app.world_mut().commands().unbond_all(lower);
    // Of an entity without a body, and of one without bonds: nothing to let go.
    let nobody = app.world_mut().spawn_empty().id();
    app.world_mut().commands().unbond_all(nobody);
    app.world_mut().commands().unbond_all(upper);
    (0..30).for_each(|_| app.update());
    assert_eq!(app.world().resource::<Bonds>().len(), 1);
    assert_eq!(messages::<BondBroken>(&mut app), [], "they were taken away");
    assert!(height(&app, lower) < -1.5, "falls");
    assert!(height(&app, under) > -2.01, "is still held");
}

#[test]
fn bonds_are_made_and_taken_away_while_a_body_is_disabled() {
    for (is_bonded_before, is_upper_off) in
        [(false, false), (false, true), (true, false), (true, true)]
    {
        let mut app = app();
        let [upper, lower] = hanging(&mut app);
        // Strong enough to stop what has fallen for a step.
        let bond = Bond::new(20.0 * WEIGHT, 1.0);
        if is_bonded_before {
            app.world_mut().commands().bond(upper, lower, bond);
        }
        (0..2).for_each(|_| app.update());
        let bonded_height = height(&app, lower);
        let off = if is_upper_off { upper } else { lower };
        let world = app.world_mut();
        if !is_bonded_before {
            // As it was, since it would fall meanwhile.
            world.entity_mut(lower).insert(LinearVelocity::default());
        }
        world.entity_mut(off).insert(Disabled);
        let mut commands = world.commands();
        match is_bonded_before {
            true => commands.unbond(upper, lower),
            false => commands.bond(upper, lower, bond),
        }
        app.update();
        app.world_mut().entity_mut(off).remove::<Disabled>();
        (0..30).for_each(|_| app.update());
        let falls = height(&app, lower) < bonded_height - 0.5;
        assert_eq!(falls, is_bonded_before, "upper off: {is_upper_off}");
    }
}

#[test]
fn a_despawned_body_loses_its_bonds() {
    let mut app = app();
    let [upper, lower] = hanging(&mut app);
    let bond = Bond::new(2.0 * WEIGHT, 1.0);
    app.world_mut().commands().bond(upper, lower, bond);
    (0..10).for_each(|_| app.update());
    app.world_mut().despawn(upper);
    (0..30).for_each(|_| app.update());
    assert!(app.world().resource::<Bonds>().is_empty());
    assert!(height(&app, lower) < -1.5);
    assert_eq!(messages::<BondBroken>(&mut app), []);
}

#[test]
fn bonds_that_cannot_be_made_are_warned_about() {
    let mut app = app();
    let [upper, lower] = hanging(&mut app);
    let stranger = app.world_mut().spawn_empty().id();
    let bond = Bond::new(1.0, 1.0);
    let mut commands = app.world_mut().commands();
    commands.bond(upper, stranger, bond);
    commands.bond(upper, lower, Bond::new(-1.0, 1.0));
    commands.bond_neighbors([upper, stranger], 1.0);
    app.update();
    let problems: Vec<_> = messages::<BodyWarning>(&mut app)
        .into_iter()
        .map(|warning| (warning.entity, warning.problem))
        .collect();
    let expected = [
        (upper, BondError::NoBody),
        (upper, BondError::Strength { strength: -1.0 }),
        (stranger, BondError::NoBody),
    ];
    assert_eq!(
        problems,
        expected.map(|(e, why)| (e, BodyProblem::Bond(why)))
    );
}

#[test]
fn plugin_and_plain_step_agree_bit_for_bit_while_bonds_break() {
    let mut app = app();
    let mut simulation = Simulation::default();
    let bodies = (0..6).map(|i| {
        let at = Vec3::X * i as f32;
        if i == 0 {
            fixed_cube(at)
        } else {
            BodyDesc::dynamic(cube(), at)
        }
    });
    let (mut entities, mut slots) = (Vec::new(), Vec::new());
    for desc in bodies {
        entities.push(app.world_mut().spawn_body(desc.clone()));
        slots.push(simulation.bodies.insert(desc).expect("usable"));
    }
    let strength = 12.0 * WEIGHT;
    simulation.bond_neighbors(&slots, strength).expect("usable");
    let all = entities.iter().copied();
    app.world_mut().commands().bond_neighbors(all, strength);
    let mut broken = 0;
    for step in 0..60 {
        simulation.step(step_length().as_secs_f32());
        app.update();
        broken += simulation.bonds.broken.len();
        for (&slot, &entity) in slots.iter().zip(&entities) {
            let (v, omega) = simulation.bodies.velocity(slot);
            let plain = bits(&simulation.bodies.pose(slot), v, omega);
            assert_eq!(plain, bits_of_entity(app.world(), entity), "step {step}");
        }
    }
    assert!(broken > 0, "a bond is meant to break");
}

fn described(entity: Entity, bond: Bond) -> BondConstructor {
    let pose = Pose::from_position(-Vec3::Y);
    BondConstructor {
        bonds: vec![BondDescription { entity, bond, pose }],
    }
}

fn is_described(app: &App, entity: Entity) -> bool {
    app.world().get::<BondConstructor>(entity).is_some()
}

// A scene file held shapes and joints, and no bonds.
#[test]
fn bonds_are_made_of_their_descriptions_once_there_are_bodies() {
    let bond = Bond::new(2.0 * WEIGHT, 1.0);
    let mut app = app();
    let [upper, lower] = hanging(&mut app);
    let world = app.world_mut();
    let shape = world.entity_mut(lower).take::<ConvexMesh>();
    world.entity_mut(lower).insert(ShapeAwaited);
    world.entity_mut(upper).insert(described(lower, bond));
    app.update();
    assert!(is_described(&app, upper), "its shape is still to come");
    assert!(app.world().get::<BodyIssues>(upper).is_none());
    let world = app.world_mut();
    let shape = shape.expect("a cube");
    (world.entity_mut(lower).remove::<ShapeAwaited>())
        .insert((shape, Transform::from_xyz(0.0, -1.0, 0.0)));
    (0..60).for_each(|_| app.update());
    assert!(!is_described(&app, upper));
    assert_eq!(app.world().resource::<Bonds>().len(), 1);
    assert!((height(&app, lower) + 1.0).abs() < 1e-3, "hangs");
}

#[test]
fn what_keeps_a_described_bond_from_being_made_is_an_issue() {
    let mut app = app();
    let [upper, lower] = hanging(&mut app);
    let nobody = app.world_mut().spawn_empty().id();
    let unusable = |change: fn(&mut BondDescription)| {
        let mut constructor = described(lower, Bond::new(1e6, 1.0));
        change(&mut constructor.bonds[0]);
        constructor
    };
    let cases = [
        (described(nobody, Bond::new(1e6, 1.0)), BondError::NoBody),
        (described(upper, Bond::new(1e6, 1.0)), BondError::SameBody),
        (
            unusable(|it| it.bond.area = 0.0),
            BondError::Area { area: 0.0 },
        ),
        (
            unusable(|it| it.pose.position.x = f32::NAN),
            BondError::Pose,
        ),
        (unusable(|it| it.pose.rotation *= 2.0), BondError::Pose),
    ];
    for (constructor, error) in cases {
        app.world_mut().entity_mut(upper).insert(constructor);
        app.update();
        let issues = app.world().get::<BodyIssues>(upper);
        let issues: Vec<BodyProblem> = issues.iter().flat_map(|it| it.iter().cloned()).collect();
        assert_eq!(issues, [BodyProblem::Bond(error)]);
        app.world_mut()
            .entity_mut(upper)
            .remove::<BondConstructor>();
        app.update();
        assert!(app.world().get::<BodyIssues>(upper).is_none());
    }
    // Those that can be made are.
    let mut app = crate::app::app();
    let [upper, lower] = hanging(&mut app);
    let nobody = app.world_mut().spawn_empty().id();
    let bonds = [lower, nobody].map(|end| described(end, Bond::new(1e6, 1.0)).bonds);
    let two = BondConstructor {
        bonds: bonds.concat(),
    };
    app.world_mut().entity_mut(upper).insert(two);
    app.update();
    assert_eq!(app.world().resource::<Bonds>().len(), 1);
    let left = app.world().get::<BondConstructor>(upper);
    assert_eq!(left.map(|it| it.bonds.len()), Some(1));
}
