//! What the solver sees, as lines.

use crate::app;
use bevy_app::App;
use bevy_asset::Assets;
use bevy_cleave::prelude::*;
use bevy_color::{Color, LinearRgba};
use bevy_gizmos::config::GizmoConfigStore;
use bevy_gizmos::{GizmoAsset, GizmoHandles, GizmoPlugin};
use bevy_math::Vec3;
use bevy_transform::components::Transform;
use std::any::TypeId;

/// Of bodies that touch, are bonded and joined.
fn scene() -> App {
    let mut app = app();
    app.add_plugins((GizmoPlugin, CleaveGizmosPlugin));
    app.finish();
    app.cleanup();
    let cube = || ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a box");
    let at = |x: f32, y: f32| Transform::from_xyz(x, y, 0.0);
    let floor = ConvexMesh::cuboid(20.0, 1.0, 20.0).expect("a box");
    let world = app.world_mut();
    world.spawn((RigidBody::Static, floor, at(0.0, -0.5)));
    let [a, b, c] = [(0.0, 0.5), (1.0, 0.5), (4.0, 0.5)].map(|(x, y)| {
        let body = (RigidBody::Dynamic, cube(), at(x, y));
        world.spawn(body).id()
    });
    let bond = Bond {
        strength: 1e6,
        shear_strength: 1e6,
        area: 1.0,
    };
    world.commands().bond(a, b, bond);
    let hinge = Joint::ball().with_anchors(Vec3::new(1.5, 0.0, 0.0), Vec3::new(-1.5, 0.0, 0.0));
    world.spawn((hinge, JointA(b), JointB(c)));
    (0..5).for_each(|_| app.update());
    app
}

/// Colors of the ends of all lines of the last frame.
fn drawn(app: &App) -> Vec<LinearRgba> {
    let handles = app.world().resource::<GizmoHandles>().handles();
    let Some(Some(handle)) = handles.get(&TypeId::of::<CleaveGizmos>()) else {
        return Vec::new();
    };
    let assets = app.world().resource::<Assets<GizmoAsset>>();
    let lines = assets.get(handle).expect("there");
    lines.list_colors.clone()
}

fn set(app: &mut App, group: CleaveGizmos) {
    let mut store = app.world_mut().resource_mut::<GizmoConfigStore>();
    *store.config_mut::<CleaveGizmos>().1 = group;
    app.update();
}

#[test]
fn each_kind_of_lines_is_drawn_and_can_be_left_out() {
    let mut app = scene();
    let all = CleaveGizmos::default();
    type Kind = fn(&mut CleaveGizmos) -> &mut Option<Color>;
    let kinds: [(Kind, usize); 6] = [
        // Edges of three cubes, and of the floor.
        (|group| &mut group.awake, 36),
        (|group| &mut group.fixed, 12),
        // A cross of three lines at each of the twelve corners, and a line of their impulses.
        (|group| &mut group.contacts, 36),
        (|group| &mut group.impulses, 12),
        (|group| &mut group.bonds, 1),
        // From two centers to two anchors with crosses, and between them.
        (|group| &mut group.joints, 9),
    ];
    for (kind, least) in kinds {
        let color = kind(&mut all.clone())
            .expect("drawn by default")
            .to_linear();
        let count = |app: &App| drawn(app).iter().filter(|&&line| line == color).count() / 2;
        set(&mut app, all.clone());
        assert!(count(&app) >= least, "{} of {least} lines", count(&app));
        let mut without = all.clone();
        *kind(&mut without) = None;
        set(&mut app, without);
        assert_eq!(count(&app), 0);
        assert!(!drawn(&app).is_empty(), "the others are drawn");
    }
}

#[test]
fn nothing_is_drawn_when_the_group_is_switched_off() {
    let mut app = scene();
    let mut store = app.world_mut().resource_mut::<GizmoConfigStore>();
    store.config_mut::<CleaveGizmos>().0.enabled = false;
    app.update();
    assert!(drawn(&app).is_empty());
}

#[test]
fn each_island_has_a_color_of_its_own() {
    let mut app = scene();
    // Apart from the three that are bonded and joined: one alone, and two on top of each other.
    let cube = || ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a box");
    for (x, y) in [(-4.0, 0.5), (-7.0, 0.5), (-7.0, 1.5)] {
        let at = Transform::from_xyz(x, y, 3.0);
        app.world_mut().spawn((RigidBody::Dynamic, cube(), at));
    }
    (0..2).for_each(|_| app.update());
    let only_hulls = CleaveGizmos {
        islands: true,
        fixed: None,
        contacts: None,
        impulses: None,
        bonds: None,
        joints: None,
        ..CleaveGizmos::default()
    };
    set(&mut app, only_hulls);
    let mut counts: Vec<(LinearRgba, usize)> = Vec::new();
    for color in drawn(&app) {
        // Lines are set apart by what is no number.
        if color.red.is_nan() {
            continue;
        }
        match counts.iter_mut().find(|(known, _)| *known == color) {
            Some((_, count)) => *count += 1,
            None => counts.push((color, 1)),
        }
    }
    let mut edges: Vec<usize> = counts.iter().map(|(_, ends)| ends / 2).collect();
    edges.sort_unstable();
    assert_eq!(edges, [12, 24, 36]);
}
