//! Round bodies are cut as the polyhedra that stand for them.

use crate::any_shape;
use crate::common::dice::Dice;
use crate::common::scenes::awake;
use bevy_cleave::prelude::*;
use glam::Vec3;

#[test]
fn pieces_are_closed_and_have_all_of_the_mass_and_momentum() {
    let mut dice = Dice::new(5);
    for round in 0..60 {
        let mut simulation = Simulation {
            gravity: Gravity(Vec3::ZERO),
            ..awake()
        };
        let mesh = any_shape(&mut dice);
        let mut body = BodyDesc::dynamic(mesh, dice.vector(-5.0, 5.0));
        body.pose.rotation = dice.rotation();
        body.linear_velocity = dice.vector(-3.0, 3.0);
        body.angular_velocity = dice.vector(-5.0, 5.0);
        body.friction = Friction::new(0.17);
        let slot = simulation.bodies.insert(body).expect("usable");
        simulation.step(1e-6);
        let mass = simulation.bodies.mass(slot).mass;
        let plane = Plane::through(simulation.bodies.center_of_mass(slot), dice.direction());
        simulation.slice(slot, plane).expect("a usable plane");
        simulation.step(1e-6);
        let done = &simulation.fractures.done;
        assert_eq!(done.len(), 1, "round {round}");
        let ledger = &done[0].ledger;
        assert!(ledger.mass_error() < 1e-6, "mass {}", ledger.mass_error());
        assert!(
            ledger.momentum_error() < 1e-4,
            "momentum {}",
            ledger.momentum_error()
        );
        assert!(
            ledger.energy_gain() < 1e-4,
            "energy {}",
            ledger.energy_gain()
        );
        let mut sum = 0.0;
        for slot in simulation.bodies.iter() {
            let piece = simulation.bodies.convex(slot).expect("convex");
            assert!(!piece.is_round() && piece.hull().is_valid());
            sum += simulation.bodies.mass(slot).mass;
        }
        assert!((sum / mass - 1.0).abs() < 1e-5, "{sum} kg of {mass} kg");
    }
}

#[test]
fn the_resolution_is_what_was_asked_for() {
    let cylinder = ConvexMesh::cylinder(0.5, 1.0).expect("a cylinder");
    for sides in [8, 24, 61, 96] {
        let mesh = cylinder.with_resolution(sides).expect("usable");
        assert_eq!(mesh.hull().vertices().len() as u32, 2 * sides);
        assert_eq!(mesh.resolution(), Some(sides));
    }
    assert!(cylinder.with_resolution(3).is_err());
    let mut dice = Dice::new(3);
    for _ in 0..30 {
        let mesh = any_shape(&mut dice);
        let volume = |sides: u32| {
            let mesh = mesh.with_resolution(sides).expect("usable");
            mesh.hull().volume()
        };
        let round = bevy_cleave::mass::VolumeIntegrals::of_shape(&mesh).volume;
        let [coarse, fine] = [volume(8), volume(96)];
        assert!(coarse < fine && fine < round, "{coarse} {fine} {round}");
        assert!(fine > 0.99 * round, "{fine} of {round}");
    }
}

#[test]
fn what_is_drawn_is_closed_and_smooth() {
    let mut dice = Dice::new(4);
    for _ in 0..30 {
        let mesh = any_shape(&mut dice);
        let drawn = mesh.render_mesh();
        assert!(drawn.check_closed().is_ok());
        assert!(drawn.normals().iter().all(|n| n.is_normalized()));
    }
    let sphere = ConvexMesh::sphere(1.0).expect("a sphere");
    let drawn = sphere.render_mesh();
    for (at, normal) in drawn.positions().iter().zip(drawn.normals()) {
        assert!(at.distance(*normal) < 1e-5);
    }
}
