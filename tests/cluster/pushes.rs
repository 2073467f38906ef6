//! Forces and impulses at points of clusters act on the part that is there.

use crate::app::stepping_app;
use crate::common::dice::Dice;
use crate::common::scenes::awake;
use crate::shapes::{parts_of, row, standing};
use bevy_app::{App, Update};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use glam::Vec3;

fn space() -> Simulation {
    let mut simulation = awake();
    simulation.gravity = Gravity(Vec3::ZERO);
    simulation
}

/// A row of cubes of 1 to 50 cm, pulled along itself at its end.
struct Pulled {
    side: f32,
    parts: usize,
    strength: f32,
    /// By what it hangs on its other end; free without.
    is_held: bool,
    rate: f32,
}

impl Pulled {
    fn member(dice: &mut Dice) -> Self {
        Self {
            side: [0.01, 0.1, 0.5][dice.below(3)],
            parts: 2 + dice.below(6),
            strength: [1e4, 1e5, 1e6][dice.below(3)],
            is_held: dice.below(2) == 0,
            rate: [30.0, 60.0, 120.0, 240.0][dice.below(4)],
        }
    }

    fn scene(&self) -> (Simulation, u32) {
        let mut simulation = space();
        let shape = row(self.parts, Vec3::splat(self.side), self.strength);
        let body = if self.is_held {
            let body = simulation.bodies.insert(standing(shape)).expect("usable");
            let foot = Anchors::none().and_behind(Vec3::X, 0.1 * self.side);
            let held = simulation.bodies.set_anchors(body, Some(foot));
            held.expect("usable");
            body
        } else {
            let desc = BodyDesc::compound(shape, Vec3::ZERO);
            simulation.bodies.insert(desc).expect("usable")
        };
        simulation.step(1.0 / self.rate);
        (simulation, body)
    }

    /// Force at the end (N) that the bond which bears most of it can just bear: of one that flies, the bond beside the end bears what moves all
    /// others.
    fn most(&self) -> f32 {
        let bears = self.strength * self.side * self.side;
        let others = (self.parts - 1) as f32 / self.parts as f32;
        if self.is_held { bears } else { bears / others }
    }

    fn end(&self, simulation: &Simulation, body: u32) -> Vec3 {
        let end = (self.parts as f32 - 0.5) * self.side;
        let pose = simulation.bodies.pose(body);
        pose.transform_point(Vec3::new(end, 0.0, 0.0))
    }
}

#[test]
fn a_pull_above_the_strength_of_a_bond_breaks_it_and_one_below_does_not() {
    let mut dice = Dice::new(7);
    for round in 0..24 {
        let pulled = Pulled::member(&mut dice);
        for share in [0.9, 1.1] {
            let (mut simulation, body) = pulled.scene();
            let force = share * pulled.most() * Vec3::X;
            for _ in 0..(0.7 * pulled.rate) as usize {
                let point = pulled.end(&simulation, body);
                let taken = simulation.bodies.apply_at(body, point, [force, Vec3::ZERO]);
                taken.expect("finite");
                simulation.step(1.0 / pulled.rate);
                if simulation.bodies.len() > 1 {
                    break;
                }
            }
            let is_broken = simulation.bodies.len() > 1;
            assert_eq!(is_broken, share > 1.0, "{round}: {share}");
            let fractures = simulation.fractures.done.iter();
            assert!(fractures.clone().all(|it| it.ledger.mass_error() < 1e-6));
        }
    }
}

#[test]
fn a_push_at_a_point_moves_a_cluster_as_any_other_body() {
    let mut dice = Dice::new(8);
    for _ in 0..20 {
        let parts = 2 + dice.below(6);
        let size = dice.vector(0.1, 0.3);
        let cluster = row(parts, size, 1e14);
        let single = ConvexMesh::cuboid(size.x * parts as f32, size.y, size.z).expect("a box");
        let middle = Vec3::X * 0.5 * size.x * parts as f32;
        let descs = [
            BodyDesc::compound(cluster, Vec3::ZERO),
            BodyDesc::dynamic(single, middle),
        ];
        let point = middle + dice.vector(-0.5, 0.5) * size;
        let pushes = [dice.vector(-50.0, 50.0), dice.vector(-5.0, 5.0)];
        let [a, b] = descs.map(|desc| {
            let mut simulation = space();
            let body = simulation.bodies.insert(desc).expect("usable");
            simulation.step(1e-6);
            let taken = simulation.bodies.apply_at(body, point, pushes);
            taken.expect("finite");
            simulation.step(1.0 / 60.0);
            simulation.bodies.velocity(body)
        });
        assert!((a.0 - b.0).length() < 1e-4 * b.0.length(), "{a:?} {b:?}");
        assert!((a.1 - b.1).length() < 1e-3 * b.1.length(), "{a:?} {b:?}");
    }
}

#[test]
fn a_blow_at_a_point_breaks_off_what_is_there() {
    let mut dice = Dice::new(9);
    for round in 0..16 {
        let pulled = Pulled::member(&mut dice);
        let (mut simulation, body) = pulled.scene();
        let mass = simulation.bodies.mass(body).mass / pulled.parts as f32;
        // 30 m/s for the last cube: far more energy than its bond takes.
        let impulse = 30.0 * mass * Vec3::Y;
        let point = pulled.end(&simulation, body);
        let taken = simulation
            .bodies
            .apply_at(body, point, [Vec3::ZERO, impulse]);
        taken.expect("finite");
        simulation.step(1e-6);
        assert!(simulation.bodies.len() > 1, "{round}");
        let bodies = &simulation.bodies;
        let pieces = bodies
            .iter()
            .filter(|&slot| bodies.kind(slot) == RigidBody::Dynamic);
        let sum: Vec3 = pieces
            .map(|slot| bodies.mass(slot).mass * bodies.velocity(slot).0)
            .sum();
        if pulled.is_held {
            assert!(sum.y > 0.0 && sum.y < 1.001 * impulse.y, "{round}: {sum}");
        } else {
            let off = (sum - impulse).length();
            assert!(off < 1e-3 * impulse.y, "{round}: {sum} {impulse}");
        }
    }
}

/// Pulls at the end of what has a `Compound`.
fn pull(mut bodies: Query<Forces, With<Compound>>, force: Res<Pull>) {
    for mut forces in &mut bodies {
        forces.apply_force_at(force.0, Vec3::new(0.95, 0.0, 0.0));
    }
}

#[derive(Resource)]
struct Pull(Vec3);

#[test]
fn forces_of_an_app_break_what_they_pull_at() {
    for share in [0.8, 1.2] {
        let mut app: App = stepping_app();
        app.insert_resource(Gravity(Vec3::ZERO));
        app.insert_resource(Pull(share * 1e5 * 0.01 * Vec3::X));
        app.add_systems(Update, pull);
        let shape = row(10, Vec3::splat(0.1), 1e5);
        let foot = Anchors::none().and_behind(Vec3::X, 0.01);
        let entity = (RigidBody::Static, shape, foot);
        let entity = app.world_mut().spawn(entity).id();
        (0..60).for_each(|_| app.update());
        let parts = app.world().get::<Compound>(entity).map_or(1, Compound::len);
        assert_eq!(parts < 10, share > 1.0, "{share}: {parts}");
    }
}

#[test]
fn points_that_mean_nothing_are_refused() {
    let pulled = Pulled::member(&mut Dice::new(10));
    let (mut simulation, body) = pulled.scene();
    let bodies = &mut simulation.bodies;
    let nowhere = Vec3::splat(f32::NAN);
    assert!(bodies.apply_at(body, nowhere, [Vec3::X; 2]).is_err());
    let endless = [Vec3::ZERO, Vec3::splat(f32::INFINITY)];
    assert!(bodies.apply_at(body, Vec3::ZERO, endless).is_err());
    simulation.step(1.0 / 60.0);
    assert_eq!(parts_of(&simulation, body), pulled.parts);
}
