//! Every cut of a closed body gives two closed bodies that together are the one that was cut.

#[path = "common/mod.rs"]
mod common;
mod slice_common;

use bevy_cleave::geometry::predicates::length_scale;
use bevy_cleave::geometry::{ConvexHull, MeshError, PlaneError, TriMesh, primitives};
use bevy_cleave::math::{Plane, tangents};
use bevy_cleave::slice::{
    FracturePattern, HullSlice, Impact, Slice, SliceError, SliceOptions, cut_by_planes, slice_hull,
    slice_mesh,
};
use common::{MODELS, closed_models, model_mesh};
use glam::{Vec2, Vec3, Vec4};
use proptest::prelude::*;
use slice_common::{Dice, Worst, check_hull_cut, check_mesh_cut, defect, model_hull};

const PLANES: usize = 1000;

/// Relative volume that a cut may lose or gain.
const VOLUME_TOLERANCE: f64 = 1e-6;

fn random_planes_cut_mesh(mesh: &TriMesh, seed: u64) -> Worst {
    let (mut dice, mut worst) = (Dice::new(seed), Worst::default());
    let volume = mesh.volume();
    for _ in 0..PLANES {
        let plane = dice.plane_through(mesh.positions());
        check_mesh_cut(mesh, volume, plane, &mut worst);
    }
    worst
}

fn assert_sound(name: &str, worst: &Worst) {
    println!("{name}: {worst:?}");
    assert!(worst.volume_error <= VOLUME_TOLERANCE, "{name}: {worst:?}");
    assert!(worst.cap_error <= 1e-6, "{name}: {worst:?}");
    assert!(worst.flipped <= 1e-6, "{name}: {worst:?}");
}

macro_rules! random_planes_cut_model {
    ($($test:ident: $file:literal,)*) => {
        $(#[test]
        fn $test() {
            assert_sound($file, &random_planes_cut_mesh(&model_mesh($file), 1));
        })*

        #[test]
        fn all_closed_models_are_cut() {
            let mut files = vec![$($file),*];
            files.sort_unstable();
            assert_eq!(files, closed_models());
        }
    };
}

random_planes_cut_model! {
    random_planes_cut_crate: "crate.obj",
    random_planes_cut_bottle: "bottle.obj",
    random_planes_cut_plate: "plate.obj",
    random_planes_cut_key: "key.obj",
    random_planes_cut_candle: "candle.obj",
    random_planes_cut_spot: "spot.obj",
    random_planes_cut_goathead: "goathead.obj",
    random_planes_cut_penguin: "penguin.obj",
    random_planes_cut_scorpion: "scorpion.obj",
    random_planes_cut_stairs: "stairs.obj",
}

#[test]
fn random_planes_cut_hulls_as_meshes() {
    for name in MODELS {
        let mesh = model_hull(name).to_mesh();
        assert_sound(name, &random_planes_cut_mesh(&mesh, 2));
    }
}

#[test]
fn random_planes_cut_hulls() {
    for name in MODELS {
        let hull = model_hull(name);
        let (mut dice, mut worst) = (Dice::new(3), Worst::default());
        for _ in 0..PLANES {
            check_hull_cut(&hull, dice.plane_through(hull.vertices()), &mut worst);
        }
        assert_sound(name, &worst);
    }
}

/// Planes that meet the mesh in as unfortunate a way as can be.
fn adversarial_planes(mesh: &TriMesh, seed: u64) -> Vec<Plane> {
    let mut dice = Dice::new(seed);
    let points = mesh.positions();
    let size = length_scale(&mesh.aabb());
    let count = mesh.triangles().len();
    let samples: Vec<usize> = if count <= 200 {
        (0..count).collect()
    } else {
        (0..200).map(|_| dice.below(count)).collect()
    };
    let mut planes = Vec::new();
    for triangle in samples {
        let [a, b, c] = mesh.triangles()[triangle].map(|v| points[v as usize]);
        let far = points[dice.below(points.len())];
        planes.push(Plane::through(a, dice.direction()));
        planes.push(Plane::through(a, (b - a).cross(dice.direction())));
        planes.push(Plane::through(a, (b - a).cross(far - a)));
        let normal = (b - a).cross(c - a);
        planes.push(Plane::through(a, normal));
        planes.push(Plane::through(a, -normal));
        planes.extend([Vec3::X, Vec3::Y, Vec3::Z].map(|axis| Plane::through(a, axis)));
        for exponent in 3..=9 {
            let offset = size * (0..exponent).fold(1.0, |x, _| 0.1 * x);
            let (face, vertex) = (Plane::through(a, normal), Plane::through(a, dice.direction()));
            for sign in [-1.0, 1.0] {
                for plane in [face, vertex] {
                    planes.push(Plane {
                        offset: plane.offset + sign * offset,
                        ..plane
                    });
                }
            }
        }
        planes.push(Plane::through(a + 3.0 * size * Vec3::X, dice.direction()));
    }
    // A triangle without area has no plane.
    planes.retain(|plane| plane.normal.is_finite());
    planes
}

#[test]
fn adversarial_planes_cut_meshes() {
    for name in closed_models() {
        let mesh = model_mesh(name);
        let (volume, mut worst) = (mesh.volume(), Worst::default());
        let planes = adversarial_planes(&mesh, 4);
        let few = if mesh.triangles().len() > 1000 { 400 } else { planes.len() };
        for &plane in planes.iter().step_by(planes.len().div_ceil(few)) {
            check_mesh_cut(&mesh, volume, plane, &mut worst);
        }
        println!("{name}: {worst:?}");
        assert!(worst.volume_error <= VOLUME_TOLERANCE, "{name}: {worst:?}");
    }
}

#[test]
fn adversarial_planes_cut_hulls_as_meshes() {
    for name in MODELS {
        let mesh = model_hull(name).to_mesh();
        let (volume, mut worst) = (mesh.volume(), Worst::default());
        for plane in adversarial_planes(&mesh, 5) {
            check_mesh_cut(&mesh, volume, plane, &mut worst);
        }
        println!("{name}: {worst:?}");
        assert!(worst.volume_error <= VOLUME_TOLERANCE, "{name}: {worst:?}");
    }
}

#[test]
fn adversarial_planes_cut_hulls() {
    for name in MODELS {
        let hull = model_hull(name);
        let mut worst = Worst::default();
        for plane in adversarial_planes(&hull.to_mesh(), 6) {
            check_hull_cut(&hull, plane, &mut worst);
        }
        println!("{name}: {worst:?}");
        assert!(worst.volume_error <= VOLUME_TOLERANCE, "{name}: {worst:?}");
    }
}
