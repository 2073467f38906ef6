//! Loading of the models and reference numbers that tests share.

#![allow(dead_code, reason = "each test file uses a part")]

use bevy_cleave::geometry::{MeshError, TriMesh};
use glam::{DMat3, DVec3, Vec3};
use serde_json::Value;
use std::path::Path;

/// The models under `assets/meshes`.
pub(crate) const MODELS: [&str; 16] = [
    "barrel.obj",
    "bottle.obj",
    "building.obj",
    "candle.obj",
    "crate.obj",
    "demosthenes.obj",
    "floor_tile.obj",
    "goathead.obj",
    "key.obj",
    "penguin.obj",
    "plate.obj",
    "rubble.obj",
    "scorpion.obj",
    "spot.obj",
    "stairs.obj",
    "wall_broken.obj",
];

/// The two clouds of `horizon_hull_points.json` that are flat.
pub(crate) const FLAT_CLOUDS: [usize; 2] = [175, 176];

/// The cloud of `horizon_hull_points.json` that lies far from its origin: 3 m of body at 3 km.
pub(crate) const FAR_CLOUD: usize = 42;

/// Text of a file of the repository.
pub(crate) fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Positions, as written in the file, and triangles (polygons as fans) of a model.
pub(crate) fn model(name: &str) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for line in read(&format!("assets/meshes/{name}")).lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let numbers: Vec<f64> = words.take(3).map(|word| word.parse().unwrap()).collect();
                positions.push(DVec3::from_slice(&numbers));
            }
            Some("f") => {
                let index =
                    |word: &str| word.split('/').next().unwrap().parse::<u32>().unwrap() - 1;
                let corners: Vec<u32> = words.map(index).collect();
                triangles.extend(
                    corners[1..]
                        .windows(2)
                        .map(|pair| [corners[0], pair[0], pair[1]]),
                );
            }
            _ => {}
        }
    }
    (positions, triangles)
}

/// A model in `f32`, positions only.
pub(crate) fn model_mesh(name: &str) -> TriMesh {
    let (positions, triangles) = model(name);
    TriMesh::new(single(&positions), triangles).unwrap()
}

/// The models whose meshes are closed, as the reference says.
pub(crate) fn closed_models() -> Vec<&'static str> {
    let reference = reference();
    let is_closed = |name: &&str| !reference[name]["mesh"].is_null();
    MODELS.into_iter().filter(is_closed).collect()
}

/// Asserts that the edge that `error` names is an edge of its triangle and is wrong as `error` says, by brute force over
/// topology numbers: an open edge has no reverse, a non-manifold one occurs more than once.
pub(crate) fn assert_edge_is_bad(name: &str, mesh: &TriMesh, error: &MeshError) {
    let (MeshError::Open { from, to, triangle } | MeshError::NonManifold { from, to, triangle }) =
        *error
    else {
        panic!("{name}: {error:?} names no edge");
    };
    let edges = |corners: [u32; 3]| (0..3).map(move |k| [corners[k], corners[(k + 1) % 3]]);
    assert!(
        edges(mesh.triangles()[triangle]).any(|edge| edge == [from, to]),
        "{name}: {error:?} is no edge of its triangle"
    );
    let number = |vertex: u32| mesh.topology()[vertex as usize];
    let [from, to] = [from, to].map(number);
    let count = |target_velocity: [u32; 2]| {
        let all = mesh.triangles().iter().flat_map(|&t| edges(t));
        all.filter(|edge| edge.map(number) == target_velocity)
            .count()
    };
    let (along, against) = (count([from, to]), count([to, from]));
    match error {
        MeshError::Open { .. } => assert_eq!((along, against), (1, 0), "{name}: {error:?}"),
        _ => assert!(along > 1, "{name}: {error:?} occurs {along} times"),
    }
}

/// Positions rounded to `f32`.
pub(crate) fn single(positions: &[DVec3]) -> Vec<Vec3> {
    positions.iter().map(|p| p.as_vec3()).collect()
}

/// The 209 point clouds of real collision hulls.
pub(crate) fn clouds() -> Vec<Vec<DVec3>> {
    let file: Value =
        serde_json::from_str(&read("assets/meshes/horizon_hull_points.json")).unwrap();
    let clouds = file["hulls"].as_array().unwrap();
    clouds
        .iter()
        .map(|cloud| cloud.as_array().unwrap().iter().map(vector).collect())
        .collect()
}

/// The whole of `reference.json`.
pub(crate) fn reference() -> Value {
    serde_json::from_str(&read("tests/data/reference.json")).unwrap()
}

/// What `reference.json` says of one body, at unit density.
#[derive(Clone, Debug)]
pub(crate) struct Expected {
    pub(crate) volume: f64,
    pub(crate) area: f64,
    pub(crate) centroid: DVec3,
    pub(crate) inertia: DMat3,
    pub(crate) principal: DVec3,
}

impl Expected {
    pub(crate) fn parse(entry: &Value) -> Self {
        let rows = &entry["inertia_about_centroid_unit_density"];
        Self {
            volume: entry["volume"].as_f64().unwrap(),
            area: entry["area"].as_f64().unwrap(),
            centroid: vector(&entry["centroid"]),
            inertia: DMat3::from_cols(vector(&rows[0]), vector(&rows[1]), vector(&rows[2])),
            principal: vector(&entry["principal_inertia"]),
        }
    }
}

fn vector(value: &Value) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|k| value[k].as_f64().unwrap()))
}
