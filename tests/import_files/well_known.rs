//! Models that everybody knows, as they are passed around, and hollow ones: taken by default, closed wherever they are cut, and broken
//! into pieces that are all seen, weigh what the mesh does and lie on the floor as they are seen.

#[path = "../common/dice.rs"]
mod dice;

use bevy_cleave::import::{ImportOptions, Model, ModelObject};
use bevy_cleave::prelude::*;
use bevy_cleave::slice::{Cut, SliceOptions, slice_mesh};
use bevy_cleave::solver::SleepConfig;
use dice::Dice;
use glam::{IVec3, Vec3};

const H: f32 = 1.0 / 60.0;
/// kg/m3.
const DENSITY: f32 = 1000.0;
/// Length of the longest side of a model that is dropped, m.
const SIZE: f32 = 1.2;

/// Name and model of each member.
fn family() -> Vec<(&'static str, Model)> {
    let of_file = |name: &'static str| {
        let path = format!("{}/assets/meshes/{name}.obj", env!("CARGO_MANIFEST_DIR"));
        (name, Model::load(path).expect("a model of the repository"))
    };
    let mut all: Vec<_> = ["bunny", "suzanne", "teapot"].map(of_file).into();
    all.push(("cup of voxels", voxels(IVec3::new(12, 14, 12), false, cup)));
    all.push((
        "house of voxels",
        voxels(IVec3::new(20, 9, 12), false, house),
    ));
    all.push(("cup of strips", voxels(IVec3::new(12, 14, 12), true, cup)));
    all.push((
        "house of strips",
        voxels(IVec3::new(20, 9, 12), true, house),
    ));
    all
}

/// A round cup of one voxel's wall.
fn cup(p: IVec3) -> bool {
    let from_axis = (2 * p.x - 11).pow(2) + (2 * p.z - 11).pow(2);
    from_axis <= 121 && (from_axis > 81 || p.y == 0)
}

/// Two rooms with a door between them, a door to the outside and windows, walls and roof of one voxel.
fn house(p: IVec3) -> bool {
    let is_room =
        (1..8).contains(&p.y) && (1..11).contains(&p.z) && (1..19).contains(&p.x) && p.x != 10;
    let is_door = (1..6).contains(&p.y) && (4..7).contains(&p.z) && [0, 10].contains(&p.x);
    let is_window =
        (3..6).contains(&p.y) && [0, 11].contains(&p.z) && [4, 5, 14, 15].contains(&p.x);
    !(is_room || is_door || is_window)
}

/// The faces between voxels of side 0.1 m and air, each with corners of its own as voxel editors write them; or merged into strips along one
/// axis, where hardly an edge is the whole edge of another.
fn voxels(size: IVec3, are_merged: bool, is_solid: impl Fn(IVec3) -> bool) -> Model {
    let is_solid = |p: IVec3| p.cmpge(IVec3::ZERO).all() && p.cmplt(size).all() && is_solid(p);
    let mut object = ModelObject {
        name: "voxels".into(),
        ..ModelObject::default()
    };
    for axis in 0..3 {
        let [normal, u, v] = [0, 1, 2].map(|k| IVec3::AXES[(axis + k) % 3]);
        for sign in [1, -1] {
            let is_face = |p: IVec3| is_solid(p) && !is_solid(p + sign * normal);
            let cells = (0..size.x * size.y * size.z)
                .map(|i| IVec3::new(i % size.x, i / size.x % size.y, i / size.x / size.y));
            let is_first = |p: IVec3| is_face(p) && !(are_merged && is_face(p - u));
            for p in cells.filter(|&p| is_first(p)) {
                let others = (1..).take_while(|&k| are_merged && is_face(p + k * u));
                let length = others.count() as i32 + 1;
                let base = if sign > 0 { p + normal } else { p };
                let along = length * u;
                let corners = [base, base + along, base + along + v, base + v];
                let first = object.positions.len() as u32;
                let points = corners.map(|corner| 0.1 * corner.as_vec3());
                object.positions.extend(points);
                let quad = [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k| first + k));
                let turned = |[a, b, c]: [u32; 3]| if sign > 0 { [a, b, c] } else { [a, c, b] };
                object.triangles.extend(quad.map(turned));
            }
        }
    }
    Model::from_object(object)
}

/// Whether a mesh is closed, as if nothing were known of it.
fn is_closed(mesh: &TriMesh) -> bool {
    let anew = mesh.clone().with_sheets(mesh.sheets()).expect("as before");
    anew.is_closed()
}

#[test]
fn well_known_and_hollow_models_are_taken_by_default_and_closed_wherever_they_are_cut() {
    for (name, model) in family() {
        let import = model.import(&ImportOptions::default());
        let import = import.unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(import.mesh.volume() > 0.0, "{name}");
        let (mut dice, mut cuts) = (Dice::new(34), 0);
        for _ in 0..80 {
            let plane = dice.plane_through(import.mesh.positions());
            let cut = slice_mesh(&import.mesh, plane, SliceOptions::default());
            let Cut::Cut(halves) = cut.unwrap_or_else(|error| panic!("{name}: {error}")) else {
                continue;
            };
            cuts += 1;
            assert!(
                is_closed(&halves.below) && is_closed(&halves.above),
                "{name}: {plane:?}"
            );
            let sum = halves.below.volume() + halves.above.volume();
            let error = sum / import.mesh.volume() - 1.0;
            assert!(error.abs() < 1e-5, "{name}: {plane:?} makes {error} more");
        }
        assert!(cuts > 60, "{name}: {cuts} cuts");
    }
}

/// Drops a model, which breaks into about `cells` pieces, and lets them lie.
fn drop_and_break(name: &str, model: &Model, cells: u16) {
    let import = model.import(&ImportOptions::default()).expect("taken");
    let extents = import.mesh.aabb().extents();
    let shape = import.shape().expect("a hull").with_mass_of_visual();
    let shape = shape
        .scaled(Vec3::splat(SIZE / extents.max_element()))
        .expect("a size");
    let weighed = f64::from(DENSITY) * shape.visual().expect("a mesh").volume();
    let mut simulation = Simulation::default();
    simulation.config.sleep = SleepConfig::default();
    let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    simulation.bodies.insert(floor).expect("usable");
    let body = BodyDesc {
        density: DENSITY,
        fracturable: Some(Fracturable {
            pattern: FracturePattern::Voronoi { cells, focus: 0.0 },
            generations: 0,
            ..Fracturable::with_strength(1.0)
        }),
        ..BodyDesc::dynamic(shape.clone(), Vec3::Y * (1.0 - shape.aabb().min.y))
    };
    simulation.bodies.insert(body).expect("usable");
    let mut dropped = 0.0;
    for _ in 0..360 {
        simulation.step(H);
        for fracture in &simulation.fractures.done {
            dropped += fracture.ledger.dropped.mass;
            assert!(fracture.ledger.mass_error() < 1e-6, "{name}");
        }
    }
    let bodies = &simulation.bodies;
    let pieces: Vec<u32> = (bodies.iter())
        .filter(|&slot| bodies.kind(slot) == RigidBody::Dynamic)
        .collect();
    assert!(
        pieces.len() >= usize::from(cells) / 2,
        "{name}: {} pieces",
        pieces.len()
    );
    let mass: f64 = pieces
        .iter()
        .map(|&slot| f64::from(bodies.mass(slot).mass))
        .sum();
    let error = (mass + dropped) / weighed - 1.0;
    assert!(
        error.abs() < 1e-6,
        "{name}: {error} more mass than the mesh has"
    );
    // Splinters too thin for a body, which the ledger tells of.
    assert!(
        dropped.abs() < 1e-5 * weighed,
        "{name}: {dropped} kg of {weighed} are gone"
    );
    for slot in pieces {
        let (shape, pose) = (bodies.convex(slot).expect("a hull"), bodies.pose(slot));
        let mesh = shape.visual().expect("seen");
        assert!(
            !mesh.triangles().is_empty() && mesh.volume() > 0.0,
            "{name}: a piece is not seen"
        );
        assert!(is_closed(mesh), "{name}: an open piece");
        let lowest = |points: &[Vec3]| {
            let heights = points.iter().map(|&p| pose.transform_point(p).y);
            heights.fold(f32::INFINITY, f32::min)
        };
        let (hull, seen) = (lowest(shape.hull().vertices()), lowest(mesh.positions()));
        let size = mesh.aabb().diagonal();
        assert!(
            seen - hull < 0.01 * size,
            "{name}: hangs {} m of {size} above its hull",
            seen - hull
        );
        // What lies on the floor and on no other piece. A splinter may bear the whole model, more than a thousand times its weight: it gives way.
        let is_down = hull < 0.005 * size;
        let may_sink = f64::from(bodies.mass(slot).mass) < 1e-3 * weighed;
        let sunk = if may_sink { 0.0 } else { -seen };
        assert!(
            !is_down || seen.max(sunk) < 0.01 * size,
            "{name}: {seen} m of {size} off the floor"
        );
    }
}

#[test]
fn pieces_of_well_known_and_hollow_models_are_all_seen_weigh_what_is_seen_and_lie_on_the_floor() {
    for (name, model) in family() {
        for cells in [12, 40] {
            drop_and_break(name, &model, cells);
        }
    }
}
