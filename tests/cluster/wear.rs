//! Clusters that tire: blows that break nothing wear the bonds near them, until one does.

use crate::app::stepping_app;
use crate::common::dice::Dice;
use crate::common::scenes::{awake, awake_on_floor};
use crate::shapes::{ball, parts_of, standing, wall};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::Vec3;

/// kg, as far as a ball of 20 sides each way is one; its energy is asked of the body itself.
const BALL: (f32, f32) = (0.1, 2000.0);

/// What a row of blows does to a cluster.
struct Blows {
    rate: f32,
    speed: f32,
    at: Vec3,
}

impl Blows {
    /// One more ball; its energy (J), and whether it broke something off.
    fn strike(&self, simulation: &mut Simulation) -> (f32, bool) {
        let missile = ball(BALL.0, BALL.1, self.at, -self.speed * Vec3::Z);
        let missile = simulation.bodies.insert(missile).expect("usable");
        let id = simulation.bodies.id(missile);
        let mut broke = false;
        let mut energy = 0.0;
        for _ in 0..(0.3 * self.rate) as usize {
            simulation.step(1.0 / self.rate);
            for fracture in &simulation.fractures.done {
                assert!(fracture.ledger.mass_error() < 1e-6);
                assert!(fracture.ledger.momentum_error() < 1e-5);
                broke = true;
            }
            if energy == 0.0 {
                energy = 0.5 * simulation.bodies.mass(missile).mass * self.speed * self.speed;
            }
        }
        if simulation.bodies.contains(missile) && simulation.bodies.id(missile) == id {
            simulation.bodies.remove(missile);
        }
        (energy, broke)
    }
}

fn damages(simulation: &Simulation, body: u32) -> Vec<f32> {
    let shape = simulation.bodies.compound(body);
    let bonds = shape.map_or(&[][..], Compound::bonds);
    bonds.iter().map(|bond| bond.damage).collect()
}

/// A wall that stands and wears out.
fn scene(wall: Compound, fatigue: Option<Fatigue>) -> (Simulation, u32) {
    let mut simulation = awake_on_floor();
    let body = simulation.bodies.insert(standing(wall)).expect("usable");
    let taken = simulation.bodies.set_fatigue(body, fatigue);
    taken.expect("usable");
    (simulation, body)
}

/// Bonds that a blow wears at a rate, with the energy of the blow (J).
fn worn_at(rate: f32, endurance: f32) -> (Vec<f32>, f32) {
    let fatigue = Fatigue {
        endurance,
        ..Fatigue::new(5000.0)
    };
    let (mut simulation, body) = scene(wall(12, 16, 3e7), Some(fatigue));
    let blows = Blows {
        rate,
        speed: 5.0,
        at: Vec3::new(0.07, 1.05, 0.3),
    };
    let (energy, broke) = blows.strike(&mut simulation);
    assert!(!broke);
    (damages(&simulation, body), energy)
}

#[test]
fn a_blow_wears_the_bonds_near_it_by_its_energy_at_any_rate() {
    let mut first = None;
    for rate in [30.0, 60.0, 120.0, 240.0] {
        let (damages, energy) = worn_at(rate, 0.5);
        let worn = || damages.iter().copied().filter(|&it| it > 0.0);
        let most = worn().fold(0.0, f32::max);
        let all = energy / 5000.0;
        // A bond that bears half of what it can takes a quarter.
        assert!(
            worn().all(|it| it > 0.24 * all && it < 1.01 * all),
            "{damages:?} of {all}"
        );
        let (count, before) = *first.get_or_insert((worn().count(), most));
        assert!(count >= 4 && worn().count().abs_diff(count) <= 1 + count / 4);
        assert!(
            (most - before).abs() < 0.1 * before,
            "{most} at {rate} Hz, {before} at 30"
        );
        // What is far away bears less: it is worn only if it endures less, and by less.
        let (wider, _) = worn_at(rate, 0.1);
        let pairs = damages.iter().zip(&wider);
        assert!(
            pairs
                .clone()
                .all(|(&narrow, &wide)| narrow == 0.0 || narrow == wide)
        );
        let others = pairs.filter(|(narrow, _)| **narrow == 0.0);
        let others: Vec<f32> = others.map(|(_, &wide)| wide).collect();
        assert!(others.iter().any(|&it| it > 0.0));
        assert!(others.iter().all(|&it| it < 0.26 * all), "{others:?}");
    }
}

/// A body of random parts, whether it stands, and blows that it bears while it is new.
fn member(seed: u64) -> (Compound, Blows, f32) {
    let mut dice = Dice::new(seed);
    let size = Vec3::new(
        dice.in_range(0.6, 1.6),
        dice.in_range(0.6, 1.6),
        dice.in_range(0.1, 0.3),
    );
    let whole = ConvexMesh::cuboid(size.x, size.y, size.z).expect("a box");
    let pattern = if dice.below(2) == 0 {
        FracturePattern::Voronoi {
            cells: dice.in_range(8.0, 40.0) as u16,
            focus: 0.0,
        }
    } else {
        FracturePattern::Brick {
            size: Vec3::new(size.x / 4.0, size.y / 5.0, size.z),
        }
    };
    let blows = Blows {
        rate: [30.0, 60.0, 120.0, 240.0][dice.below(4)],
        speed: dice.in_range(2.0, 8.0),
        at: Vec3::new(
            dice.in_range(-0.2, 0.2),
            size.y * dice.in_range(0.2, 0.35),
            0.4,
        ),
    };
    let mut strength = 1e4;
    loop {
        let cluster = Cluster::cut(&whole, &pattern, seed, strength).expect("cells");
        let shape = cluster.compound().expect("connected");
        let (mut simulation, _) = anchored(shape.clone(), size, None);
        let (energy, broke) = blows.strike(&mut simulation);
        if !broke {
            // Strong enough that the next ones are borne as well, though this one may have cracked it.
            let cluster = Cluster::cut(&whole, &pattern, seed, 4.0 * strength).expect("cells");
            return (cluster.compound().expect("connected"), blows, energy);
        }
        strength *= 2.0;
    }
}
/// The body, held at its foot, in a world without weight.
fn anchored(shape: Compound, size: Vec3, fatigue: Option<Fatigue>) -> (Simulation, u32) {
    let mut simulation = awake();
    simulation.gravity = Gravity(Vec3::ZERO);
    let foot = Anchors::none().and_behind(Vec3::Y, -0.4 * size.y);
    let body = simulation.bodies.insert(standing(shape)).expect("usable");
    let held = simulation.bodies.set_anchors(body, Some(foot));
    held.expect("usable");
    let taken = simulation.bodies.set_fatigue(body, fatigue);
    taken.expect("usable");
    (simulation, body)
}

/// Blows until something comes off; 30 if nothing does.
fn endured(shape: &Compound, blows: &Blows, fatigue: Option<Fatigue>) -> usize {
    let size = shape.aabb().extents();
    let (mut simulation, body) = anchored(shape.clone(), size, fatigue);
    let mut before = damages(&simulation, body);
    for blow in 0..30 {
        let (_, broke) = blows.strike(&mut simulation);
        if broke {
            return blow;
        }
        let after = damages(&simulation, body);
        assert!(after.iter().all(|damage| (0.0..1.0).contains(damage)));
        if after.len() == before.len() {
            let pairs = before.iter().zip(&after);
            assert!(pairs.clone().all(|(before, after)| before <= after));
        }
        if fatigue.is_none() {
            assert!(after.iter().all(|&damage| damage == 0.0));
        }
        before = after;
    }
    30
}

#[test]
fn random_clusters_that_wear_out_break_sooner_the_less_energy_that_takes() {
    let mut total = [0; 4];
    for seed in 0..8 {
        let (shape, blows, energy) = member(seed);
        let takes = |share: f32| endured(&shape, &blows, Some(Fatigue::new(share * energy)));
        let counts = [
            endured(&shape, &blows, None),
            takes(20.0),
            takes(5.0),
            takes(1.5),
        ];
        let never_later = counts.windows(2).all(|pair| pair[0] >= pair[1]);
        assert!(never_later, "seed {seed}: {counts:?}");
        let tough = Fatigue {
            endurance: 1.0,
            ..Fatigue::new(1e9 * energy)
        };
        assert_eq!(
            endured(&shape, &blows, Some(tough)),
            counts[0],
            "seed {seed}"
        );
        (0..4).for_each(|i| total[i] += counts[i]);
    }
    assert!(total.windows(2).all(|pair| pair[0] > pair[1]), "{total:?}");
}

#[test]
fn what_is_saved_while_it_wears_goes_on_as_it_would_have() {
    for seed in 20..23 {
        let (shape, blows, energy) = member(seed);
        let fatigue = Some(Fatigue::new(4.0 * energy));
        let size = shape.aabb().extents();
        let (mut simulation, body) = anchored(shape.clone(), size, fatigue);
        if blows.strike(&mut simulation).1 {
            continue;
        }
        let worn = simulation.bodies.compound(body).expect("a body").clone();
        assert!(
            worn.bonds().iter().any(|bond| bond.damage > 0.0),
            "seed {seed}"
        );
        let saved = Cluster::from(&worn);
        let loaded = saved.compound().expect("one body");
        assert_eq!(loaded.bonds(), worn.bonds());
        let whole = endured(&shape, &blows, fatigue);
        assert_eq!(1 + endured(&loaded, &blows, fatigue), whole, "seed {seed}");
    }
}

#[test]
fn a_load_at_rest_wears_no_bonds() {
    let (mut simulation, body) = scene(wall(8, 10, 1e6), Some(Fatigue::new(1.0)));
    let mut load = BodyDesc::dynamic(
        ConvexMesh::cuboid(0.5, 0.5, 0.5).expect("a box"),
        Vec3::new(0.0, 1.2505, 0.0),
    );
    load.density = 4000.0;
    simulation.bodies.insert(load).expect("usable");
    (0..600).for_each(|_| simulation.step(1.0 / 60.0));
    assert_eq!(parts_of(&simulation, body), wall(8, 10, 1e6).len());
    assert!(
        damages(&simulation, body)
            .iter()
            .all(|&damage| damage < 0.2)
    );
    let before = damages(&simulation, body);
    (0..600).for_each(|_| simulation.step(1.0 / 60.0));
    assert_eq!(damages(&simulation, body), before);
}

/// The component on the entity tells; clones and pieces keep it.
#[test]
fn an_entity_tells_how_worn_its_bonds_are_and_what_comes_off_keeps_it() {
    let mut app = stepping_app();
    let floor = HalfSpaceShape { normal: Vec3::Y };
    app.world_mut().spawn((RigidBody::Static, floor));
    let worn = |app: &bevy_app::App, entity| {
        let shape = app.world().get::<Compound>(entity).expect("a cluster");
        let bonds = shape.bonds().iter().filter(|bond| bond.damage > 0.0);
        bonds.count()
    };
    let entity = (RigidBody::Static, wall(8, 10, 3e7), Fatigue::new(1000.0));
    let entity = app.world_mut().spawn(entity).id();
    app.update();
    assert!(app.world().get::<BodyIssues>(entity).is_none());
    let shoot = |app: &mut bevy_app::App, speed: f32| {
        let ball = ConvexMesh::sphere(0.1).expect("a ball");
        let ball = app.world_mut().spawn((
            RigidBody::Dynamic,
            ball,
            Density(2000.0),
            LinearVelocity(-speed * Vec3::Z),
            Transform::from_xyz(0.07, 0.62, 0.3),
        ));
        let ball = ball.id();
        (0..20).for_each(|_| app.update());
        app.world_mut().entity_mut(ball).despawn();
    };
    shoot(&mut app, 5.0);
    let before = worn(&app, entity);
    assert!(before > 0);
    let clone = app.world_mut().entity_mut(entity).clone_and_spawn();
    app.world_mut()
        .entity_mut(clone)
        .insert(Transform::from_xyz(20.0, 0.0, 0.0));
    app.update();
    assert_eq!(worn(&app, clone), before);
    (0..40).for_each(|_| shoot(&mut app, 8.0));
    let mut pieces = app
        .world_mut()
        .query::<(&PieceOf, Option<&Compound>, Has<Fatigue>)>();
    let pieces: Vec<_> = pieces.iter(app.world()).collect();
    assert!(!pieces.is_empty());
    for (_, shape, wears) in pieces {
        assert_eq!(wears, shape.is_some_and(Compound::is_bonded));
    }
    assert_eq!(worn(&app, clone), before, "nobody shot at it");
}

#[test]
fn a_blow_that_breaks_something_wears_what_it_leaves() {
    let mut dice = Dice::new(21);
    let (mut broken, mut worn) = (0, 0);
    for _ in 0..8 {
        let fatigue = Fatigue {
            endurance: 0.05,
            ..Fatigue::new(1e4)
        };
        let (mut simulation, body) = scene(wall(12, 16, 1e6), Some(fatigue));
        let at = Vec3::new(dice.in_range(-1.2, 1.2), dice.in_range(0.8, 1.4), 0.3);
        let missile = ball(BALL.0, BALL.1, at, -dice.in_range(6.0, 12.0) * Vec3::Z);
        simulation.bodies.insert(missile).expect("usable");
        for _ in 0..30 {
            simulation.step(1.0 / 60.0);
            // Of the very step: what comes after has blows of its own.
            if !simulation.fractures.done.is_empty() {
                broken += 1;
                let damages = damages(&simulation, body);
                worn += usize::from(damages.iter().any(|&damage| damage > 0.0));
                break;
            }
        }
    }
    assert!(broken > 4 && worn == broken, "{worn} of {broken}");
}
