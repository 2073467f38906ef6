//! Entities with clusters that break: what is beneath them, and what is done to them meanwhile.

use crate::app::stepping_app;
use crate::common::dice::Dice;
use crate::hierarchy::world_of;
use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::{Affine3A, Vec3};

fn app() -> App {
    let mut app = stepping_app();
    app.finish();
    app.cleanup();
    app.update();
    app
}

/// A box that was cut in advance.
fn cluster(dice: &mut Dice) -> Compound {
    let size = dice.vector(0.3, 1.5);
    let whole = ConvexMesh::cuboid(size.x, size.y, size.z).expect("a box");
    let pattern = match dice.below(2) {
        0 => FracturePattern::Brick {
            size: size / dice.in_range(1.8, 4.0),
        },
        _ => FracturePattern::Voronoi {
            cells: 6 + dice.below(16) as u16,
            focus: 0.0,
        },
    };
    let strength = [1e3, 1e4, 1e5][dice.below(3)];
    let cluster = Cluster::cut(&whole, &pattern, 1 + dice.below(100) as u64, strength);
    cluster.expect("cells").compound().expect("connected")
}

/// A ball that flies at a point within the cluster.
fn shoot(world: &mut World, dice: &mut Dice, target: Vec3) {
    let from = target + 2.5 * (dice.direction() + 0.5 * Vec3::Z).normalize();
    world.spawn((
        RigidBody::Dynamic,
        ConvexMesh::sphere(0.1).expect("a ball"),
        Density(3000.0),
        Transform::from_translation(from),
        LinearVelocity(dice.in_range(15.0, 50.0) * (target - from).normalize()),
    ));
}

/// Symptom: a cluster that is scaled is as large as it is when it loses a part, and its scale 1; its children were moved by that.
#[test]
fn children_of_a_scaled_cluster_that_goes_on_stay_where_they_are() {
    let mut lost = 0;
    for seed in 0..36 {
        let dice = &mut Dice::new(seed);
        let mut app = app();
        let world = app.world_mut();
        let shape = cluster(dice);
        let scale = match dice.below(2) {
            0 => Vec3::splat(dice.in_range(0.5, 2.0)),
            _ => dice.vector(0.5, 2.0),
        };
        let foot = shape.aabb().min.y + 0.1 * shape.aabb().extents().y;
        let anchors = Anchors::none().and_behind(Vec3::Y, scale.y * foot);
        let aabb = shape.aabb();
        let (at, body) = (Transform::from_scale(scale), RigidBody::Static);
        let wall = world.spawn((body, shape, at, anchors)).id();
        if dice.below(2) == 0 {
            let above = Transform::from_translation(dice.vector(-1.0, 1.0))
                .with_rotation(dice.rotation())
                .with_scale(Vec3::splat(dice.in_range(0.5, 2.0)));
            let above = world.spawn(above).id();
            world.entity_mut(wall).insert(ChildOf(above));
        }
        let children: Vec<Entity> = (0..4)
            .map(|_| {
                let place = aabb.min + dice.vector(0.0, 1.0) * aabb.extents();
                let place = Transform::from_translation(place).with_scale(Vec3::splat(0.3));
                world.spawn((place, ChildOf(wall))).id()
            })
            .collect();
        for number in 0..30 {
            let world = app.world_mut();
            if number % 10 == 0 {
                let place = aabb.min + dice.vector(0.2, 0.8) * aabb.extents();
                let place = world_of(world, wall).transform_point3(place);
                shoot(world, dice, place);
            }
            let before = children.iter().map(|&child| world_of(world, child));
            let before: Vec<Affine3A> = before.collect();
            app.update();
            let world = app.world();
            if world.get_entity(wall).is_err() {
                break;
            }
            for (&child, before) in children.iter().zip(before) {
                let above = world.get::<ChildOf>(child).expect("a child").parent();
                let is_there = above == wall;
                let off = world_of(world, child).abs_diff_eq(before, 1e-3);
                assert!(off || !is_there, "{seed}: {child} in step {number}");
            }
        }
        let left = app.world().get::<Transform>(wall);
        lost += usize::from(left.is_some_and(|left| left.scale != scale));
    }
    assert!(lost > 6, "{lost}");
}

/// An entity whose body is several groups of parts that wait to come apart.
fn divided(world: &mut World) -> Option<Entity> {
    let mut all = world.query::<(Entity, &Compound)>();
    let mut found = all.iter(world).filter(|(_, shape)| is_divided(shape));
    found.next().map(|(entity, _)| entity)
}

fn is_divided(shape: &Compound) -> bool {
    shape.is_bonded() && Cluster::from(shape).separated().len() > 1
}

/// Symptom: what was disabled before its turn came, a clone of it, and what was saved and loaded stayed one body of loose parts, or was no body at all.
#[test]
fn what_waits_comes_apart_whatever_is_done_to_it() {
    let mut judged = 0;
    for seed in 0..36 {
        let dice = &mut Dice::new(seed);
        let mut app = app();
        let world = app.world_mut();
        world.insert_resource(FractureBudget {
            pieces_per_step: 2,
            ..Default::default()
        });
        world.spawn((cluster(dice), RigidBody::Dynamic));
        shoot(world, dice, Vec3::ZERO);
        let mut found = None;
        for _ in 0..12 {
            app.update();
            found = divided(app.world_mut());
            if found.is_some() {
                break;
            }
        }
        let Some(entity) = found else {
            continue;
        };
        judged += 1;
        let world = app.world_mut();
        match dice.below(3) {
            0 => {
                world.entity_mut(entity).insert(Disabled);
                (0..1 + dice.below(5)).for_each(|_| app.update());
                app.world_mut().entity_mut(entity).remove::<Disabled>();
            }
            1 => {
                let clone = world.entity_mut(entity).clone_and_spawn();
                world.entity_mut(entity).despawn();
                assert!(world.get::<Compound>(clone).is_some_and(is_divided));
            }
            _ => {
                let shape = world.get::<Compound>(entity).expect("has one");
                let saved = CompoundConstructor::of(shape);
                world.entity_mut(entity).despawn();
                let loaded = world.spawn((RigidBody::Dynamic, saved)).id();
                world.flush();
                assert!(world.get::<Compound>(loaded).is_some_and(is_divided));
            }
        }
        app.world_mut().insert_resource(FractureBudget::default());
        (0..40).for_each(|_| app.update());
        assert_eq!(divided(app.world_mut()), None, "{seed}");
    }
    assert!(judged > 9, "{judged}");
}
