//! What is cut, and the planes.

use crate::dice::Dice;
use bevy_cleave::geometry::{ConvexHull, TriMesh, primitives};
use bevy_cleave::math::Plane;
use glam::Vec3;

/// A body and the planes that cut it.
pub struct Body {
    pub name: &'static str,
    /// For a convex body.
    pub hull: Option<ConvexHull>,
    /// Positions and triangles alone, which is all that the others read.
    pub mesh: TriMesh,
    pub planes: Vec<Plane>,
}

impl Body {
    fn convex(name: &'static str, hull: ConvexHull) -> Self {
        let triangles = hull.triangles().collect();
        let mesh = TriMesh::new(hull.vertices().to_vec(), triangles).expect("a valid mesh");
        let planes = planes(hull.vertices(), 1, 200);
        Self { name, hull: Some(hull), mesh, planes }
    }

    fn other(name: &'static str, mesh: TriMesh) -> Self {
        let planes = planes(mesh.positions(), 2, 60);
        Self { name, hull: None, mesh, planes }
    }
}

/// All bodies, from a cube to a model that is not convex.
pub fn bodies() -> Vec<Body> {
    let spot = spot();
    let hull_of_spot = ConvexHull::from_points(spot.positions()).expect("a valid hull");
    let cube = primitives::cuboid(1.0, 1.0, 1.0).expect("valid sizes");
    let sphere = |subdivisions| primitives::icosphere(0.5, subdivisions).expect("valid sizes");
    vec![
        Body::convex("cube", cube),
        Body::convex("icosphere, 320 triangles", sphere(2)),
        Body::convex("hull of spot, 606 triangles", hull_of_spot),
        Body::convex("icosphere, 1280 triangles", sphere(3)),
        Body::other("spot, 5856 triangles, not convex", spot),
    ]
}

/// Planes of random direction through random points between two of the points.
fn planes(points: &[Vec3], seed: u64, count: usize) -> Vec<Plane> {
    let mut dice = Dice::new(seed);
    (0..count).map(|_| dice.plane_through(points)).collect()
}

fn spot() -> TriMesh {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/meshes/spot.obj");
    let text = std::fs::read_to_string(path).expect("the model is there");
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let numbers: Vec<f32> = words.take(3).map(|w| w.parse().expect("a number")).collect();
                positions.push(Vec3::from_slice(&numbers));
            }
            Some("f") => {
                let index = |word: &str| {
                    let number = word.split('/').next().expect("an index");
                    number.parse::<u32>().expect("an index") - 1
                };
                let corners: Vec<u32> = words.map(index).collect();
                triangles.extend(corners[1..].windows(2).map(|pair| [corners[0], pair[0], pair[1]]));
            }
            _ => {}
        }
    }
    TriMesh::new(positions, triangles).expect("a valid mesh")
}
