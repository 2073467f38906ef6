//! Users' systems and run conditions go between the phases, and change nothing by being there.

use crate::app::{accompanied_app, app, app_of, bits_of_entity};
use crate::common::structures::tower;
use bevy_app::{App, Update};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::ScheduleCleanupPolicy;
use bevy_transform::components::Transform;
use glam::Vec3;

/// Whether an update makes a step.
fn steps(app: &mut App) -> bool {
    let steps = app.world().resource::<Steps>().0;
    app.update();
    app.world().resource::<Steps>().0 > steps
}

/// How often a falling body was seen to have moved.
#[derive(Resource, Default)]
struct Steps(usize);

/// An app in which something falls.
fn falling(mut app: App) -> App {
    let mesh = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid");
    app.world_mut().spawn((RigidBody::Dynamic, mesh));
    app.init_resource::<Steps>();
    let count = |moved: Query<(), Changed<Transform>>, mut steps: ResMut<Steps>| {
        steps.0 += moved.iter().count();
    };
    app.add_systems(bevy_app::Last, count);
    app.update();
    app
}

#[test]
fn a_system_runs_between_the_phases_that_it_names() {
    #[derive(Resource, Default)]
    struct Seen(Vec<usize>);

    for plugin in [CleavePlugin::default(), CleavePlugin::new(Update)] {
        let mut app = falling(app_of(plugin));
        app.init_resource::<Seen>();
        let look = |bodies: Res<Bodies>, mut seen: ResMut<Seen>| seen.0.push(bodies.len());
        let first = look.before(PhysicsSystems::MassProperties);
        let second = look
            .after(PhysicsSystems::MassProperties)
            .before(PhysicsSystems::Cut);
        app.add_systems(PhysicsSchedule, (first, second));
        let mesh = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid");
        let aside = Transform::from_xyz(9.0, 0.0, 0.0);
        app.world_mut().spawn((RigidBody::Dynamic, mesh, aside));
        assert!(steps(&mut app));
        assert_eq!(app.world().resource::<Seen>().0, [1, 2]);
    }
}

#[test]
fn a_condition_on_a_phase_is_asked() {
    #[derive(Resource)]
    struct IsFrozen(bool);

    for plugin in [CleavePlugin::default(), CleavePlugin::new(Update)] {
        let mut app = falling(app_of(plugin));
        app.insert_resource(IsFrozen(true));
        let is_free = |is_frozen: Res<IsFrozen>| !is_frozen.0;
        app.configure_sets(PhysicsSchedule, PhysicsSystems::Integrate.run_if(is_free));
        app.update();
        assert!(!steps(&mut app));
        app.insert_resource(IsFrozen(false));
        assert!(steps(&mut app));
    }
}

#[test]
fn a_paused_clock_and_unusable_numbers_make_no_step() {
    let mut app = falling(app());
    app.insert_resource(Gravity(Vec3::NAN));
    assert!(!steps(&mut app));
    app.insert_resource(Gravity::default());
    assert!(steps(&mut app));
    let stopped = bevy_time::TimeUpdateStrategy::FixedTimesteps(0);
    app.insert_resource(stopped);
    assert!(!steps(&mut app));
}

/// Mass and motion of all bodies of a tower whose top is cut, with what users do meanwhile, as bits.
fn story(mut app: App, mut step: impl FnMut(&mut App)) -> Vec<Vec<u32>> {
    // What somebody gives to pieces as they come to be is read in the next step.
    let lighten = |new: On<Add<BodyHandle>>, mut densities: Query<&mut Density>| {
        if let Ok(mut density) = densities.get_mut(new.entity) {
            density.0 *= 0.25;
        }
    };
    app.add_observer(lighten);
    app.world_mut().resource_mut::<SolverConfig>().sleep = SleepConfig::default();
    let spawn = |desc| app.world_mut().spawn_body(desc);
    let entities: Vec<Entity> = tower(4).into_iter().map(spawn).collect();
    for count in 0..200 {
        let world = app.world_mut();
        match count {
            20 => {
                let top = world.get::<Transform>(entities[4]).expect("there");
                let plane = Plane::through(top.translation, Vec3::new(0.3, 1.0, 0.2));
                world.commands().slice(entities[4], plane);
            }
            40 => {
                let mut friction = world.get_mut::<Friction>(entities[3]).expect("there");
                *friction = Friction::new(0.1);
            }
            60 => {
                let push = LinearVelocity(Vec3::X);
                world.entity_mut(entities[3]).insert(push);
            }
            90 => {
                world.despawn(entities[1]);
            }
            _ => {}
        }
        step(&mut app);
    }
    let mut bodies = app.world_mut().query_filtered::<Entity, With<RigidBody>>();
    let bodies: Vec<Entity> = bodies.iter(app.world()).collect();
    let mut all: Vec<_> = bodies
        .into_iter()
        .map(|entity| {
            let body = app.world().entity(entity);
            let mut bits = vec![body.contains::<Sleeping>().into()];
            let mass = body.get::<MassProperties>().expect("there").mass;
            bits.push(mass.to_bits());
            bits.extend(bits_of_entity(app.world(), entity));
            bits
        })
        .collect();
    all.sort_unstable();
    all
}

#[test]
fn what_users_do_has_the_same_outcome_alone_and_in_company() {
    let update = |app: &mut App| app.update();
    let alone = story(app(), update);
    assert_eq!(alone.len(), 5, "a floor, two cubes and two halves");
    assert_eq!(alone, story(accompanied_app(), update));
    assert_eq!(alone, story(app_of(CleavePlugin::new(Update)), update));
    assert_eq!(alone, story(app(), update_in_changing_company()));
}

/// Updates; before every seventh one, a system comes among the phases or goes.
fn update_in_changing_company() -> impl FnMut(&mut App) {
    #[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
    struct Company;

    let mut updates = 0;
    move |app| {
        if updates % 14 == 0 {
            let company = (|| ()).in_set(Company).after(PhysicsSystems::Solve);
            app.add_systems(PhysicsSchedule, company.before(PhysicsSystems::Integrate));
        } else if updates % 7 == 0 {
            let policy = ScheduleCleanupPolicy::RemoveSystemsOnly;
            let removed = app.remove_systems_in_set(PhysicsSchedule, Company, policy);
            assert_eq!(removed.expect("can be built"), 1);
        }
        app.update();
        updates += 1;
    }
}

#[test]
fn what_is_small_moves_in_a_phase_of_its_own() {
    #[derive(Resource, Default)]
    struct Heights(Vec<[f32; 2]>);

    let mut app = app();
    app.init_resource::<Heights>();
    let world = app.world_mut();
    let floor = HalfSpaceShape { normal: Vec3::Y };
    world.spawn((RigidBody::Static, floor));
    // One of a millimetre falls by more than itself in a step; the other one is large.
    for (size, x) in [(0.002, 0.0), (1.0, 5.0)] {
        let mesh = ConvexMesh::cuboid(size, size, size).expect("valid");
        let at = Transform::from_xyz(x, 0.501 * size, 0.0);
        world.spawn((RigidBody::Dynamic, mesh, at));
    }
    let look = |bodies: Res<Bodies>, mut heights: ResMut<Heights>| {
        heights
            .0
            .push([1, 2].map(|slot| bodies.pose(slot).position.y));
    };
    app.add_systems(
        PhysicsSchedule,
        (
            look.after(PhysicsSystems::Fracture)
                .before(PhysicsSystems::LocalSteps),
            look.after(PhysicsSystems::LocalSteps)
                .before(PhysicsSystems::Integrate),
        ),
    );
    app.update();
    let heights = &app.world().resource::<Heights>().0;
    assert_eq!(heights.len(), 2);
    assert_ne!(heights[0][0], heights[1][0], "the small one has moved");
    assert_eq!(heights[0][1], heights[1][1], "the large one has not");
}
