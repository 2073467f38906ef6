//! Models far from the origin: the parts are those that they are near it, or the report says what is the matter and what to do.
#![allow(clippy::disallowed_methods, reason = "distances of models")]

use crate::common::dice::Dice;
use bevy_cleave::geometry::{ConvexHull, TriMesh, primitives};
use bevy_cleave::import::{
    ImportError, ImportOptions, ImportReport, Model, ModelObject, PartState,
};
use bevy_cleave::math::Pose;
use glam::Vec3;

/// A closed part of about `size` m.
fn part(dice: &mut Dice, size: f32) -> TriMesh {
    let edges = size * dice.vector(0.4, 1.0);
    let hull = match dice.below(4) {
        0 => primitives::cuboid(edges.x, edges.y, edges.z),
        1 => primitives::regular_prism(3 + dice.below(9) as u32, 0.5 * edges.x, edges.y),
        2 => primitives::icosphere(0.5 * edges.x, 1),
        _ => {
            let points: Vec<Vec3> = (0..14).map(|_| 0.5 * size * dice.direction()).collect();
            ConvexHull::from_points(&points)
        }
    };
    let mesh = hull.expect("a solid").to_mesh();
    mesh.transformed(&Pose::new(Vec3::ZERO, dice.rotation()))
}

/// Parts apart from each other, one or several to an object; some lack a face that is filled, or have vertices of their own for each
/// triangle. Length of the smallest part, m.
fn model(dice: &mut Dice) -> (Model, f32) {
    let size = [0.1, 1.0, 10.0, 100.0][dice.below(4)] * dice.in_range(0.5, 2.0);
    let mut objects = Vec::new();
    let mut place = 0.0;
    for name in 0..1 + dice.below(3) {
        let mut object = ModelObject {
            name: format!("object {name}"),
            ..ModelObject::default()
        };
        for _ in 0..1 + dice.below(3) {
            place += 3.0 * size;
            let at = Vec3::new(place, size * dice.unit(), size * dice.unit());
            let mesh = part(dice, size);
            let first = object.positions.len() as u32;
            let fault = dice.below(4);
            let mut triangles = mesh.triangles().to_vec();
            if fault == 0 {
                // A hole with three edges.
                triangles.swap_remove(dice.below(mesh.triangles().len()));
            }
            let positions = mesh.positions().iter().map(|p| *p + at);
            let positions: Vec<Vec3> = positions.collect();
            if fault == 1 {
                for t in triangles {
                    let first = object.positions.len() as u32;
                    object.positions.extend(t.map(|v| positions[v as usize]));
                    object.triangles.push([first, first + 1, first + 2]);
                }
            } else {
                object.positions.extend(positions);
                object
                    .triangles
                    .extend(triangles.iter().map(|t| t.map(|v| first + v)));
            }
        }
        objects.push(object);
    }
    let model = Model {
        objects,
        ..Model::default()
    };
    (model, 0.4 * size)
}

fn moved(model: &Model, by: Vec3) -> Model {
    let mut model = model.clone();
    for object in &mut model.objects {
        object.positions.iter_mut().for_each(|p| *p += by);
    }
    model
}

/// Volume of a closed mesh whose corners are moved, and rounded, m3.
fn volume_moved(mesh: &TriMesh, by: Vec3) -> f64 {
    let corner = |v: u32| (mesh.positions()[v as usize] + by).as_dvec3();
    let apex = corner(0);
    let triangles = mesh.triangles().iter();
    let six_volumes = triangles.map(|t| {
        let [a, b, c] = t.map(|v| corner(v) - apex);
        a.dot(b.cross(c))
    });
    six_volumes.sum::<f64>() / 6.0
}

fn says_what_to_do(text: &str) -> bool {
    text.contains("move it to the origin")
}

/// Names and states.
fn parts(report: &ImportReport) -> Vec<(String, PartState)> {
    let parts = report.parts.iter();
    parts.map(|part| (part.name.clone(), part.state)).collect()
}

// At 100 km the points of a border counted as one within a meter, as a share of how far they were from the origin: holes closed by themselves
// into something else, and small parts were nothing.
#[test]
fn a_model_far_from_the_origin_has_the_same_parts_or_the_report_says_what_to_do() {
    let (mut kept, mut told) = (0, 0);
    for seed in 0..400 {
        let dice = &mut Dice::new(seed);
        let (near, least) = model(dice);
        let distance = 1e3 * 2e3f32.powf(dice.unit());
        let by = distance * dice.direction();
        let far = moved(&near, by);
        let options = ImportOptions::default();
        let expected = near.import(&options).expect("parts that are solid");
        let rounding = f32::EPSILON * distance;
        let about = format!("seed {seed}: {distance} m, least {least} m, rounding {rounding} m");
        let found = match far.import(&options) {
            Ok(found) => found,
            Err(error) => {
                assert!(
                    matches!(error, ImportError::TooFar { .. }),
                    "{about}: {error}"
                );
                assert!(says_what_to_do(&error.to_string()), "{about}: {error}");
                assert!(rounding > 0.02 * least, "{about}: {error}");
                told += 1;
                continue;
            }
        };
        assert!(found.mesh.is_closed(), "{about}");
        let is_told = found.report.notes.iter().any(|note| says_what_to_do(note));
        let error = (found.mesh.volume() / volume_moved(&expected.mesh, by) - 1.0).abs();
        let same_parts = parts(&found.report) == parts(&expected.report);
        let is_same = same_parts && error <= 1e-5;
        assert!(
            is_same || is_told && rounding > 0.02 * least,
            "{about}: {error} of the volume, {:?} for {:?}, {:?}",
            parts(&found.report),
            parts(&expected.report),
            found.report.notes
        );
        let around = found.mesh.aabb();
        let farthest = around.min.abs().max(around.max.abs()).max_element();
        let share = f32::EPSILON * farthest / around.diagonal();
        assert_eq!(is_told, share > 1e-5, "{about}: {share} of its size");
        kept += usize::from(is_same);
        told += usize::from(is_told);
    }
    assert!(kept > 200 && told > 100, "{kept} kept, {told} told");
}

#[test]
fn an_object_of_which_nothing_is_left_is_named() {
    let cube = primitives::cuboid(1.0, 1.0, 1.0).expect("a cube").to_mesh();
    let object = |name: &str, scale: f32| ModelObject {
        name: name.into(),
        positions: cube
            .positions()
            .iter()
            .map(|p| Vec3::ONE + scale * *p)
            .collect(),
        triangles: cube.triangles().to_vec(),
        ..ModelObject::default()
    };
    let model = Model {
        objects: vec![object("crate", 1.0), object("screw", 1e-9)],
        ..Model::default()
    };
    let import = model.import(&ImportOptions::default()).expect("a crate");
    let notes = import.report.notes;
    assert!(
        notes.len() == 1 && notes[0].contains("'screw'"),
        "{notes:?}"
    );
}
