//! Explosions: clusters are pushed part by part, and what comes off flies.

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use crate::shapes::{parts_of, standing, wall};
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

const H: f32 = 1.0 / 60.0;

/// A world without weight.
fn space() -> Simulation {
    let mut simulation = awake();
    simulation.gravity = Gravity(Vec3::ZERO);
    simulation.budget.pieces_per_step = 1000;
    simulation
}

/// Mass, momentum, angular momentum about the origin, and kinetic energy of all that is dynamic.
fn sums(simulation: &Simulation) -> (f64, Vec3, Vec3, f32) {
    let bodies = &simulation.bodies;
    let dynamic = bodies
        .iter()
        .filter(|&slot| bodies.kind(slot) == RigidBody::Dynamic);
    let (mut mass, mut linear, mut angular, mut energy) = (0.0, Vec3::ZERO, Vec3::ZERO, 0.0);
    for slot in dynamic {
        let own = bodies.mass(slot);
        let (v, omega) = bodies.velocity(slot);
        let turn = bodies.pose(slot).rotation * own.principal_frame;
        let spin = turn * (own.principal * (turn.inverse() * omega));
        mass += f64::from(own.mass);
        linear += own.mass * v;
        angular += bodies.center_of_mass(slot).cross(own.mass * v) + spin;
        energy += 0.5 * (own.mass * v.length_squared() + omega.dot(spin));
    }
    (mass, linear, angular, energy)
}

#[test]
fn a_blast_breaks_off_of_a_wall_what_is_near_and_blows_it_away() {
    let mut simulation = space();
    let shape = wall(16, 20, 1e5);
    let count = shape.len();
    let foot = Anchors::none().and_behind(Vec3::Y, 0.05);
    let body = simulation.bodies.insert(standing(shape)).expect("usable");
    let held = simulation.bodies.set_anchors(body, Some(foot));
    held.expect("usable");
    simulation.step(H);
    let center = Vec3::new(0.4, 1.2, 0.5);
    let explosion = Explosion {
        center,
        radius: 0.8,
        impulse: 400.0,
    };
    simulation.bodies.explode(explosion).expect("usable");
    simulation.step(H);
    let bodies = &simulation.bodies;
    let fractures = &simulation.fractures.done;
    assert!(fractures.iter().all(|it| it.ledger.mass_error() < 1e-6));
    assert!(fractures[0].parent_slot == body && fractures[0].goes_on);
    assert!(matches!(fractures[0].blow, Some(blow) if blow.by.is_none() && blow.point == center));
    let left = parts_of(&simulation, body);
    assert!(left < count - 8 && left > count / 4, "{left} of {count}");
    assert_eq!(bodies.kind(body), RigidBody::Static);
    let (mut off, mut pushed, mut pieces, mut flying) = (0, Vec3::ZERO, 0, 0);
    for slot in bodies.iter().filter(|&slot| slot != body) {
        off += parts_of(&simulation, slot);
        let (velocity, _) = bodies.velocity(slot);
        pushed += bodies.mass(slot).mass * velocity;
        pieces += 1;
        flying += usize::from(velocity.dot(bodies.center_of_mass(slot) - center) > 0.0);
    }
    // Through the wall, to the other side; some hit others on their way.
    assert!(
        pushed.z < -0.5 * pushed.length() && flying * 10 >= pieces * 8,
        "{pushed}"
    );
    assert!(pushed.length() < explosion.impulse, "{pushed}");
    assert_eq!(left + off, count);
    assert!(
        simulation
            .bodies
            .explode(Explosion {
                radius: -1.0,
                ..explosion
            })
            .is_err()
    );
}

/// A body of random parts that turns in space, and a blast beside it.
fn member(seed: u64, strength: f32) -> (Simulation, usize, f32, Explosion) {
    let mut dice = Dice::new(seed);
    let size = dice.vector(0.5, 1.5);
    let whole = ConvexMesh::cuboid(size.x, size.y, size.z).expect("a box");
    let cells = dice.in_range(4.0, 40.0) as u16;
    let pattern = FracturePattern::Voronoi { cells, focus: 0.0 };
    let cluster = Cluster::cut(&whole, &pattern, seed, strength).expect("cells");
    let shape = cluster.compound().expect("connected");
    let parts = shape.len();
    let mut simulation = space();
    let desc = BodyDesc {
        pose: Pose::new(dice.vector(-1.0, 1.0), dice.rotation()),
        linear_velocity: dice.vector(-1.0, 1.0),
        ..BodyDesc::compound(shape, Vec3::ZERO)
    };
    let center = desc.pose.position + dice.in_range(0.1, 1.5) * dice.direction();
    simulation.bodies.insert(desc).expect("usable");
    simulation.step(1e-6);
    let (mass, ..) = sums(&simulation);
    let explosion = Explosion {
        center,
        radius: dice.in_range(1.0, 3.0),
        impulse: mass as f32 * dice.in_range(1.0, 30.0),
    };
    (simulation, parts, mass as f32, explosion)
}

#[test]
fn what_a_blast_breaks_gets_together_what_the_whole_would_have_got() {
    let (mut broke, mut held) = (0, 0);
    for seed in 0..40 {
        let after = |strength: f32| {
            let (mut simulation, parts, _, explosion) = member(seed, strength);
            simulation.bodies.explode(explosion).expect("usable");
            // So short that nothing touches anything.
            simulation.step(1e-6);
            for fracture in &simulation.fractures.done {
                assert!(fracture.ledger.mass_error() < 1e-6, "{seed}");
                assert!(fracture.ledger.momentum_error() < 1e-5, "{seed}");
                assert!(fracture.ledger.energy_gain().abs() < 1e-4, "{seed}");
            }
            let bodies = simulation.bodies.iter();
            assert_eq!(
                bodies
                    .map(|slot| parts_of(&simulation, slot))
                    .sum::<usize>(),
                parts
            );
            (sums(&simulation), simulation.bodies.len())
        };
        let (whole, one) = after(1e14);
        assert_eq!(one, 1, "{seed}");
        let mut most = usize::MAX;
        for strength in [1e2, 1e5, 1e7, 1e9, 1e11] {
            let (broken, count) = after(strength);
            let scale = whole.1.length() + 1.0;
            assert!(
                (broken.1 - whole.1).length() < 1e-3 * scale,
                "{seed}: {broken:?}, {whole:?}"
            );
            let scale = whole.2.length() + scale;
            assert!(
                (broken.2 - whole.2).length() < 2e-3 * scale,
                "{seed}: {broken:?}, {whole:?}"
            );
            // What flies apart moves more than what flies together.
            assert!(broken.3 >= 0.999 * whole.3, "{seed}: {broken:?}, {whole:?}");
            assert!(
                count <= most.saturating_add(1),
                "{seed}: {count} at {strength} Pa, {most} before"
            );
            most = count;
            broke += usize::from(count > 1);
            held += usize::from(count == 1);
        }
    }
    assert!(broke > 30 && held > 30, "{broke} {held}");
}

#[test]
fn blasts_wear_what_they_do_not_break() {
    let mut simulation = space();
    let foot = Anchors::none().and_behind(Vec3::Y, 0.05);
    let body = simulation
        .bodies
        .insert(standing(wall(8, 10, 1e7)))
        .expect("usable");
    let held = simulation.bodies.set_anchors(body, Some(foot));
    held.expect("usable");
    let taken = simulation
        .bodies
        .set_fatigue(body, Some(Fatigue::new(40.0)));
    taken.expect("usable");
    simulation.step(H);
    let explosion = Explosion {
        center: Vec3::new(0.1, 0.7, 0.4),
        radius: 1.0,
        impulse: 80.0,
    };
    let blasts = (0..100).take_while(|_| {
        simulation.bodies.explode(explosion).expect("usable");
        simulation.step(H);
        let shape = simulation.bodies.compound(body).expect("a wall");
        let most = shape
            .bonds()
            .iter()
            .map(|bond| bond.damage)
            .fold(0.0, f32::max);
        let is_whole = simulation.fractures.done.is_empty();
        assert!(!is_whole || most > 0.0);
        is_whole
    });
    let blasts = blasts.count();
    assert!(blasts > 1 && blasts < 100, "{blasts}");
}

#[test]
fn a_blast_within_the_material_drives_it_apart() {
    let mut simulation = space();
    let whole = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a box");
    let size = Vec3::splat(0.2);
    let cluster = Cluster::cut(&whole, &FracturePattern::Brick { size }, 1, 1e3).expect("bricks");
    let shape = cluster.compound().expect("one block");
    let count = shape.len();
    let turned = Pose::new(Vec3::new(3.0, 2.0, 1.0), Quat::from_rotation_y(0.4));
    let desc = BodyDesc {
        pose: turned,
        ..BodyDesc::compound(shape, Vec3::ZERO)
    };
    simulation.bodies.insert(desc).expect("usable");
    simulation.step(H);
    let explosion = Explosion {
        center: turned.transform_point(Vec3::new(0.02, -0.03, 0.01)),
        radius: 2.0,
        impulse: 5000.0,
    };
    simulation.bodies.explode(explosion).expect("usable");
    (0..20).for_each(|_| simulation.step(H));
    let bodies = &simulation.bodies;
    assert!(bodies.len() > count / 4, "{}", bodies.len());
    let farthest = bodies
        .iter()
        .map(|slot| bodies.center_of_mass(slot).distance(explosion.center));
    assert!(farthest.fold(0.0, f32::max) > 2.0);
}

#[test]
fn a_bond_that_blasts_have_worn_out_is_gone() {
    for seed in 0..12 {
        let (mut simulation, ..) = member(seed, 1e9);
        let body = simulation.bodies.iter().next().expect("a body");
        let Explosion { radius, .. } = member(seed, 1e9).3;
        let taken = simulation.bodies.set_fatigue(body, Some(Fatigue::new(1.0)));
        taken.expect("usable");
        let mut blasts = 0;
        while simulation.bodies.len() == 1 && blasts < 40 {
            let mass = simulation.bodies.mass(body).mass;
            let explosion = Explosion {
                center: simulation.bodies.center_of_mass(body) + 0.9 * Vec3::X,
                radius,
                impulse: 20.0 * mass,
            };
            simulation.bodies.explode(explosion).expect("usable");
            simulation.step(1e-6);
            // What comes off waits for its turn.
            simulation.step(1e-6);
            for slot in simulation.bodies.iter() {
                let shape = simulation.bodies.compound(slot);
                let bonds = shape.map_or(&[][..], Compound::bonds);
                assert!(bonds.iter().all(|it| it.damage < 0.999), "{seed}: {blasts}");
            }
            blasts += 1;
        }
        assert!(blasts < 40, "{seed}: never worn out");
    }
}

/// A body that is no cluster, and a blast beside it that gives it so much of its strength.
struct Beside {
    desc: BodyDesc,
    explosion: Explosion,
    strength: f32,
}

impl Beside {
    fn member(dice: &mut Dice, share: f32) -> Self {
        let size = 0.3 + 2.0 * dice.vector(0.0, 1.0);
        let shape = ConvexMesh::cuboid(size.x, size.y, size.z).expect("a box");
        let patterns = [
            FracturePattern::Voronoi {
                cells: 8,
                focus: 0.3,
            },
            FracturePattern::Star { planes: 3 },
        ];
        let strength = [10.0, 300.0, 1e4][dice.below(3)];
        let pose = Pose::new(dice.vector(-1.0, 1.0), dice.rotation());
        let center = pose.position + dice.in_range(0.1, 3.0) * dice.direction();
        let half = 0.5 * size;
        let local = pose.inverse_transform_point(center).clamp(-half, half);
        let distance = pose.transform_point(local).distance(center);
        let radius = distance + dice.in_range(0.5, 4.0);
        let impulse = share * strength / (1.0 - distance / radius);
        let kind = [RigidBody::Static, RigidBody::Dynamic][dice.below(2)];
        let desc = BodyDesc {
            pose,
            fracturable: Some(Fracturable {
                pattern: patterns[dice.below(2)].clone(),
                ..Fracturable::with_strength(strength)
            }),
            ..BodyDesc::new(kind, Shape::Convex(shape))
        };
        let explosion = Explosion {
            center,
            radius,
            impulse,
        };
        Self {
            desc,
            explosion,
            strength,
        }
    }
}

#[test]
fn blasts_break_what_is_no_cluster_if_they_give_it_more_than_its_strength() {
    let mut dice = Dice::new(77);
    for round in 0..60 {
        let share = [0.3, 0.95, 1.05, 3.0, 20.0][dice.below(5)];
        let beside = Beside::member(&mut dice, share);
        let mut simulation = space();
        let is_static = beside.desc.kind == RigidBody::Static;
        let body = simulation.bodies.insert(beside.desc).expect("usable");
        simulation.step(1e-6);
        simulation.bodies.explode(beside.explosion).expect("usable");
        simulation.step(1e-6);
        let count = simulation.bodies.len();
        assert_eq!(count > 1, share > 1.0, "{round}: {count} at {share}");
        let given = share * beside.strength;
        let (_, linear, ..) = sums(&simulation);
        assert!(linear.length() < 1.001 * given, "{round}: {linear}");
        if share < 1.0 {
            assert!(is_static || (linear.length() / given - 1.0).abs() < 1e-3);
            continue;
        }
        let fracture = &simulation.fractures.done[0];
        assert!(fracture.ledger.mass_error() < 1e-6, "{round}");
        assert_eq!(fracture.parent_slot, body);
        let blow = fracture.blow.expect("a blow");
        assert!((blow.impulse / given - 1.0).abs() < 1e-3 && blow.by.is_none());
        if is_static && share > 2.0 {
            let bodies = &simulation.bodies;
            for slot in bodies.iter() {
                let away = bodies.center_of_mass(slot) - beside.explosion.center;
                let (velocity, _) = bodies.velocity(slot);
                assert!(velocity.dot(away) >= 0.0, "{round}: {velocity}");
            }
        }
    }
}

#[test]
fn blasts_wear_what_is_no_cluster() {
    let mut dice = Dice::new(78);
    for round in 0..10 {
        let beside = Beside::member(&mut dice, 0.6);
        let mut simulation = space();
        let body = simulation.bodies.insert(beside.desc).expect("usable");
        simulation.step(1e-6);
        let mass = simulation.bodies.mass(body).mass;
        let impulse = 0.6 * beside.strength;
        // Worn to 0.6 of its strength, and so broken, after some blasts.
        let energy = impulse * impulse / (2.0 * mass);
        let taken = simulation
            .bodies
            .set_fatigue(body, Some(Fatigue::new(5.0 * energy)));
        taken.expect("usable");
        let mut blasts = 0;
        let mut last = 0.0;
        while simulation.bodies.len() == 1 && blasts < 20 {
            simulation.bodies.explode(beside.explosion).expect("usable");
            simulation.step(1e-6);
            if let Some(fatigue) = simulation.bodies.fatigue(body) {
                assert!(
                    simulation.bodies.len() > 1 || fatigue.damage > last,
                    "{round}"
                );
                last = fatigue.damage;
            }
            blasts += 1;
        }
        assert!((2..=4).contains(&blasts), "{round}: {blasts}");
    }
}

#[test]
fn what_breaks_under_a_blast_is_worn_besides() {
    let mut dice = Dice::new(79);
    let (mut broken, mut worn) = (0, 0);
    for _ in 0..8 {
        let mut simulation = space();
        let body = simulation
            .bodies
            .insert(standing(wall(12, 16, 1e5)))
            .expect("usable");
        let foot = Anchors::none().and_behind(Vec3::Y, 0.05);
        let held = simulation.bodies.set_anchors(body, Some(foot));
        held.expect("usable");
        let fatigue = Fatigue {
            endurance: 0.05,
            ..Fatigue::new(1e4)
        };
        let taken = simulation.bodies.set_fatigue(body, Some(fatigue));
        taken.expect("usable");
        simulation.step(H);
        let explosion = Explosion {
            center: Vec3::new(dice.in_range(-1.0, 1.0), dice.in_range(0.5, 1.2), 0.4),
            radius: 0.8,
            impulse: dice.in_range(100.0, 400.0),
        };
        simulation.bodies.explode(explosion).expect("usable");
        simulation.step(1e-6);
        if simulation.fractures.done.is_empty() {
            continue;
        }
        broken += 1;
        let shape = simulation.bodies.compound(body).expect("a wall");
        worn += usize::from(shape.bonds().iter().any(|bond| bond.damage > 0.0));
    }
    assert!(broken > 4 && worn == broken, "{worn} of {broken}");
}
