//! Shapes as data: `ShapeConstructor`.

use crate::{all_with, app};
use bevy_cleave::prelude::*;
use bevy_math::Vec3;

fn family() -> Vec<ShapeConstructor> {
    let ball = ConvexMesh::icosphere(0.5, 1).expect("a ball");
    let cup = ConvexMesh::from_mesh(ball.hull().to_mesh()).expect("closed");
    vec![
        ShapeConstructor::default(),
        ShapeConstructor::Cuboid {
            size: Vec3::new(1.0, 2.0, 0.1),
        },
        ShapeConstructor::Icosphere {
            radius: 0.5,
            subdivisions: 2,
        },
        ShapeConstructor::RegularPrism {
            sides: 7,
            circumradius: 1.0,
            height: 0.2,
        },
        ShapeConstructor::Wedge { size: Vec3::ONE },
        ShapeConstructor::of(&ball),
        ShapeConstructor::of(&cup.with_mass_of_visual()),
    ]
}

#[test]
fn an_entity_gets_the_shape_that_is_described() {
    let mut app = app();
    app.finish();
    app.cleanup();
    for described in family() {
        let body = (RigidBody::Dynamic, described.clone());
        let body = app.world_mut().spawn(body).id();
        app.world_mut().flush();
        let shape = app
            .world()
            .get::<ConvexMesh>(body)
            .expect("built at once")
            .clone();
        // What is described again is the same to the last vertex.
        let again = ShapeConstructor::of(&shape)
            .build()
            .expect("it was a shape");
        assert_eq!(again.hull().vertices(), shape.hull().vertices());
        assert_eq!(again.visual(), shape.visual());
        assert_eq!(ShapeConstructor::of(&again), ShapeConstructor::of(&shape));
    }
    (0..3).for_each(|_| app.update());
    assert_eq!(app.world().resource::<Bodies>().len(), family().len());
}

#[test]
fn pieces_have_the_shapes_of_pieces() {
    let mut app = app();
    app.finish();
    app.cleanup();
    let body = (RigidBody::Dynamic, ShapeConstructor::default());
    let body = app.world_mut().spawn(body).id();
    app.update();
    app.update();
    let at = Vec3::ZERO;
    app.world_mut()
        .commands()
        .slice(body, Plane::through(at, Vec3::X));
    app.update();
    let pieces = all_with::<ConvexMesh>(&mut app);
    assert_eq!(pieces.len(), 2);
    for piece in pieces {
        let shape = app.world().get::<ConvexMesh>(piece).expect("a shape");
        assert!((shape.hull().volume() - 0.5).abs() < 1e-3);
        assert!(!app.world().entity(piece).contains::<ShapeConstructor>());
    }
}

#[test]
fn what_describes_no_shape_is_an_issue_until_it_does() {
    let mut app = app();
    app.finish();
    app.cleanup();
    let bad = [
        ShapeConstructor::Cuboid {
            size: Vec3::new(1.0, f32::NAN, 1.0),
        },
        ShapeConstructor::Icosphere {
            radius: -1.0,
            subdivisions: 1,
        },
        ShapeConstructor::Hull {
            points: vec![Vec3::ZERO; 5],
            visual: None,
            weighs_visual: false,
        },
    ];
    for described in bad {
        let body = (RigidBody::Dynamic, described);
        let body = app.world_mut().spawn(body).id();
        (0..3).for_each(|_| app.update());
        let issues = app
            .world()
            .get::<BodyIssues>(body)
            .expect("said on the entity");
        let is_shape = |problem: &BodyProblem| matches!(problem, BodyProblem::Shape(_));
        assert!(issues.iter().any(is_shape), "{issues:?}");
        app.world_mut()
            .entity_mut(body)
            .insert(ShapeConstructor::default());
        (0..3).for_each(|_| app.update());
        assert!(!app.world().entity(body).contains::<BodyIssues>());
        assert!(app.world().entity(body).contains::<ConvexMesh>());
    }
}
