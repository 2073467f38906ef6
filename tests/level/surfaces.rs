//! A level of several materials: each triangle rubs and bounces as its slot says.

use crate::app::stepping_app;
use crate::common::dice::Dice;
use crate::common::scenes::awake;
use bevy_cleave::geometry::MeshError;
use bevy_cleave::prelude::*;
use bevy_transform::components::Transform;
use glam::{Vec2, Vec3};

/// s.
const H: f32 = 1.0 / 60.0;
/// m/s2.
const G: f32 = 9.81;

const ICE: u16 = 3;
const GRAVEL: u16 = 9;

/// Level ground, 40 m by 8 m along x about the origin, in triangles of about `cell` (m) whose diagonals go either way; ice where x is
/// negative and gravel beyond, shaken within the plane by `shake` but at that border.
fn ground(cell: f32, shake: f32) -> (StaticMesh, Vec<u16>) {
    let [along, across] = [40.0, 8.0].map(|length: f32| 2 * (0.5 * length / cell).round() as usize);
    let mut dice = Dice::new(3);
    let mut corner = |x: usize, z: usize| {
        let at = Vec2::new(
            x as f32 - 0.5 * along as f32,
            z as f32 - 0.5 * across as f32,
        );
        let is_inner = x > 0 && x < along && 2 * x != along;
        let off = if is_inner {
            shake * dice.vector(-1.0, 1.0).truncate()
        } else {
            Vec2::ZERO
        };
        let at = cell * (at + off);
        Vec3::new(at.x, 0.0, at.y)
    };
    let mut positions = Vec::new();
    for z in 0..=across {
        positions.extend((0..=along).map(|x| corner(x, z)));
    }
    let number = |x: usize, z: usize| (z * (along + 1) + x) as u32;
    let (mut triangles, mut slots) = (Vec::new(), Vec::new());
    for (x, z) in (0..across).flat_map(|z| (0..along).map(move |x| (x, z))) {
        let [a, b, c, d] =
            [(x, z), (x + 1, z), (x, z + 1), (x + 1, z + 1)].map(|(x, z)| number(x, z));
        if (x + z) % 2 == 0 {
            triangles.extend([[a, c, d], [a, d, b]]);
        } else {
            triangles.extend([[a, c, b], [b, c, d]]);
        }
        slots.extend([if 2 * x < along { ICE } else { GRAVEL }; 2]);
    }
    let level = StaticMesh::new(&positions, &triangles).expect("a level");
    (level, slots)
}

fn materials(ice: f32, gravel: f32) -> SurfaceMaterials {
    let rough = |coefficient| Friction::new(coefficient).with_combine(CombineRule::Min);
    SurfaceMaterials::new()
        .with(ICE, rough(ice), Restitution::default())
        .with(GRAVEL, rough(gravel), Restitution::default())
}

/// A scene with that ground, whose own friction is none of these.
fn on(level: StaticMesh, surfaces: Option<SurfaceMaterials>) -> Simulation {
    let mut simulation = awake();
    let ground = BodyDesc {
        surfaces,
        friction: Friction::new(0.9).with_combine(CombineRule::Min),
        ..BodyDesc::level(level)
    };
    simulation.bodies.insert(ground).expect("usable");
    simulation
}

/// Bodies that slide and do not roll, with half their height (m).
fn sliders() -> Vec<(&'static str, Shape, f32)> {
    let flat = ConvexMesh::cuboid(1.0, 0.3, 0.8).expect("a box");
    let round = ConvexMesh::cuboid(0.8, 0.2, 0.6).expect("a box");
    let round = round.rounded(0.05).expect("usable");
    let half = |x: f32| {
        let part = ConvexMesh::cuboid(0.5, 0.3, 0.8).expect("a box");
        (Pose::from_position(Vec3::new(x, 0.0, 0.0)), part)
    };
    let compound = Compound::new([half(-0.25), half(0.25)]).expect("usable");
    vec![
        ("box", Shape::Convex(flat), 0.15),
        ("rounded box", Shape::Convex(round), 0.15),
        ("two halves", Shape::Compound(compound), 0.15),
    ]
}

/// Where along x a body comes to rest that is let slide from `start` (m) with `speed` (m/s).
fn way(simulation: &mut Simulation, (shape, half): (Shape, f32), start: f32, speed: f32) -> f32 {
    let desc = BodyDesc {
        pose: Pose::from_position(Vec3::new(start, half, 0.1)),
        linear_velocity: speed * Vec3::X,
        friction: Friction::new(1.0).with_combine(CombineRule::Min),
        ..BodyDesc::new(RigidBody::Dynamic, shape)
    };
    let slot = simulation.bodies.insert(desc).expect("usable");
    for _ in 0..600 {
        simulation.step(H);
    }
    let at = simulation.bodies.pose(slot).position;
    assert!((at.y - half).abs() < 0.02 && at.z.abs() < 0.6, "{at}");
    at.x - start
}

#[test]
fn what_slides_stops_as_the_slot_says_and_not_as_the_body() {
    for (cell, shake) in [(1.0, 0.0), (0.4, 0.2), (3.0, 0.3)] {
        for (name, shape, half) in sliders() {
            for (friction, start, speed) in [
                (0.1, -18.0, 4.0),
                (0.3, -12.0, 5.0),
                (0.2, 3.0, 4.0),
                (0.5, 3.0, 6.0),
            ] {
                let (level, slots) = ground(cell, shake);
                let level = level.with_materials(slots).expect("a slot each");
                // The other slot, which it never gets to, is quite different.
                let surfaces = if start < 0.0 {
                    materials(friction, 2.0)
                } else {
                    materials(2.0, friction)
                };
                let mut simulation = on(level, Some(surfaces));
                let way = way(&mut simulation, (shape.clone(), half), start, speed);
                let expected = speed * speed / (2.0 * friction * G);
                assert!(
                    (way - expected).abs() < 0.04 * expected,
                    "{name} on {friction}, triangles of {cell}: {way} m for {expected} m"
                );
            }
        }
    }
}

#[test]
fn what_slides_from_one_material_to_the_next_is_held_by_both_in_turn() {
    for (name, shape, half) in sliders() {
        let (level, slots) = ground(0.7, 0.2);
        let level = level.with_materials(slots).expect("a slot each");
        let mut simulation = on(level, Some(materials(0.0, 0.25)));
        let (start, speed) = (-3.0, 4.0);
        let way = way(&mut simulation, (shape, half), start, speed);
        // The share of the weight that is on gravel grows as it crosses the border: in the mean it is there from its middle on.
        let expected = speed * speed / (2.0 * 0.25 * G) - start;
        assert!(
            (way - expected).abs() < 0.05 * expected,
            "{name}: {way} m for {expected} m"
        );
    }
}

#[test]
fn what_falls_bounces_as_the_slot_says() {
    let (level, slots) = ground(0.9, 0.2);
    let level = level.with_materials(slots).expect("a slot each");
    let bouncy = |coefficient| Restitution::new(coefficient).with_combine(CombineRule::Max);
    let surfaces = SurfaceMaterials::new()
        .with(ICE, Friction::default(), bouncy(0.8))
        .with(GRAVEL, Friction::default(), bouncy(0.0));
    for shape in [bevy_cleave::sphere!(0.3), bevy_cleave::cuboid!(0.6)] {
        let mut simulation = on(level.clone(), Some(surfaces.clone()));
        let [on_ice, on_gravel] = [-4.2, 4.2].map(|x| {
            let desc = BodyDesc::dynamic(shape.clone(), Vec3::new(x, 2.3, 0.1));
            simulation.bodies.insert(desc).expect("usable")
        });
        let mut rebound = [0.0_f32; 2];
        for step in 0..90 {
            simulation.step(H);
            for (rebound, slot) in rebound.iter_mut().zip([on_ice, on_gravel]) {
                if step > 40 {
                    *rebound = rebound.max(simulation.bodies.pose(slot).position.y - 0.3);
                }
            }
        }
        // 0.64 of 2 m.
        assert!(
            (rebound[0] - 1.28).abs() < 0.1 && rebound[1] < 0.02,
            "{rebound:?}"
        );
    }
}

/// All states after a while of some bodies on a ground.
fn states(mut simulation: Simulation) -> Vec<(Pose, (Vec3, Vec3))> {
    let mut slots = Vec::new();
    for (i, (_, shape, _)) in (0..).zip(sliders().into_iter().cycle().take(12)) {
        let desc = BodyDesc {
            pose: Pose::from_position(Vec3::new(1.5 * i as f32 - 9.0, 1.0, 0.3 * i as f32 - 2.0)),
            linear_velocity: Vec3::new(2.0, 0.0, 0.5),
            angular_velocity: Vec3::new(0.5, 1.0, 0.2),
            ..BodyDesc::new(RigidBody::Dynamic, shape)
        };
        slots.push(simulation.bodies.insert(desc).expect("usable"));
    }
    (0..120).for_each(|_| simulation.step(H));
    let bodies = &simulation.bodies;
    slots
        .iter()
        .map(|&slot| (bodies.pose(slot), bodies.velocity(slot)))
        .collect()
}

#[test]
fn slots_without_materials_change_no_bit() {
    let (plain, slots) = ground(0.8, 0.2);
    let with_slots = plain.with_materials(slots).expect("a slot each");
    assert_eq!(
        states(on(plain.clone(), None)),
        states(on(with_slots.clone(), None))
    );
    // Materials of a level without slots, or of other slots, are the body's.
    let other = SurfaceMaterials::new().with(70, Friction::new(0.0), Restitution::new(1.0));
    let expected = states(on(plain.clone(), None));
    assert_eq!(states(on(plain, Some(other))), expected);
}

#[test]
fn slots_come_along_with_meshes_and_scales() {
    let (level, slots) = ground(2.0, 0.0);
    assert!(!level.has_materials() && level.material_of(0).is_none());
    let few = level.with_materials(vec![0; 3]);
    assert!(matches!(
        few,
        Err(MeshError::MaterialLength { found: 3, .. })
    ));
    let level = level.with_materials(slots.clone()).expect("a slot each");
    let mesh = level.to_mesh();
    assert_eq!(mesh.materials(), slots);
    let again = StaticMesh::from_mesh(&mesh).expect("a level");
    let scaled = again.scaled(Vec3::new(2.0, 1.0, 0.5)).expect("a level");
    for (triangle, &slot) in (0..).zip(&slots) {
        assert_eq!(scaled.two_sided().material_of(triangle), Some(slot));
    }
    // What has no area has a slot all the same, since it is counted.
    let positions = [Vec3::ZERO, Vec3::Z, Vec3::X, Vec3::new(1.0, 0.0, 1.0)];
    let triangles = [[0, 1, 1], [0, 1, 2], [2, 1, 3]];
    let level = StaticMesh::new(&positions, &triangles).expect("a level");
    let level = level.with_materials(vec![1, 2, 3]).expect("a slot each");
    assert_eq!((level.len(), level.material_of(2)), (2, Some(3)));
    assert_eq!(level.to_mesh().materials(), [2, 3]);
}

#[test]
fn unusable_materials_are_refused() {
    let (level, slots) = ground(2.0, 0.0);
    let level = level.with_materials(slots).expect("a slot each");
    for (friction, restitution) in [(f32::NAN, 0.0), (-1.0, 0.0), (0.5, 2.0), (0.5, f32::NAN)] {
        let bad = SurfaceMaterials::new().with(
            ICE,
            Friction::new(friction),
            Restitution::new(restitution),
        );
        let desc = BodyDesc {
            surfaces: Some(bad),
            ..BodyDesc::level(level.clone())
        };
        let refused = awake().bodies.insert(desc);
        assert!(
            matches!(refused, Err(BodyError::Material(_))),
            "{refused:?}"
        );
    }
}

#[test]
fn in_an_app_materials_come_change_and_go_with_their_component() {
    let mut app = stepping_app();
    let (level, slots) = ground(0.8, 0.1);
    let level = level.with_materials(slots).expect("a slot each");
    let own = Friction::new(0.0).with_combine(CombineRule::Min);
    let world = app.world_mut();
    let ground = world.spawn((RigidBody::Static, level, own)).id();
    let at = Transform::from_xyz(-15.0, 0.15, 0.1);
    let shape = bevy_cleave::cuboid!(1.0, 0.3, 0.8);
    let speed = LinearVelocity(3.0 * Vec3::X);
    let body = world.spawn((RigidBody::Dynamic, shape, at, speed)).id();
    let mut loss = |change: &dyn Fn(&mut bevy_ecs::world::EntityWorldMut)| {
        change(&mut app.world_mut().entity_mut(ground));
        let mut velocity = app.world_mut().entity_mut(body);
        velocity.insert((speed, at));
        (0..32).for_each(|_| app.update());
        let now = app.world().get::<LinearVelocity>(body).expect("a body").0;
        let issues = app.world().get::<BodyIssues>(ground).is_some();
        (3.0 - now.x, issues)
    };
    // Bevy makes 64 fixed steps in a second.
    let half = |friction: f32| 0.5 * friction * G;
    let is = |(loss, has_issue): (f32, bool), expected: f32| {
        assert!(
            (loss - expected).abs() < 0.04 + 0.04 * expected,
            "{loss} for {expected}"
        );
        assert!(!has_issue);
    };
    is(loss(&|_| {}), 0.0);
    is(
        loss(&|ground| {
            ground.insert(materials(0.3, 0.0));
        }),
        half(0.3),
    );
    is(
        loss(&|ground| {
            let mut known = ground.get_mut::<SurfaceMaterials>().expect("there");
            *known = materials(0.1, 0.0);
        }),
        half(0.1),
    );
    is(
        loss(&|ground| {
            ground.remove::<SurfaceMaterials>();
        }),
        0.0,
    );
    // Nothing in silence: there is nothing that has slots.
    let plain = StaticMesh::from_heights(&[0.0; 4], 2, 1.0).expect("a level");
    let (_, has_issue) = loss(&|ground| {
        ground.insert((plain.clone(), materials(0.1, 0.1)));
    });
    assert!(has_issue);
    let (_, has_issue) = loss(&|ground| {
        ground.remove::<SurfaceMaterials>();
    });
    assert!(!has_issue);
}
