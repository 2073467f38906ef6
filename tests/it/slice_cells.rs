//! Large meshes in many cells: each cell takes what it needs of the triangles in one go, and gets what cuts wall by wall leave.
//!
//! The twin is the same mesh with caps that are shaded smoothly, which are cut by planes.

use crate::common::dice::Dice;
use crate::common::mesh_parts::{joined, torus};
use crate::slice_common::defect;
use bevy_cleave::geometry::{ConvexHull, TriMesh, primitives};
use bevy_cleave::slice::{CapNormals, Cutting, Piece, PieceCutter, SliceOptions};
use glam::{Quat, Vec2, Vec3};

/// Slot of the caps.
const INSIDE: u16 = 7;

/// Texture coordinates as a function of the place.
fn uv(point: Vec3) -> Vec2 {
    Vec2::new(2.0 * point.x - point.z, point.y + 0.5 * point.z)
}

/// A mesh with bumps, turned and scaled; now and then with a cavity, or of two parts.
fn member(dice: &mut Dice) -> TriMesh {
    let ball = primitives::icosphere(0.5, 4).unwrap().to_mesh();
    let bumps = [(); 4].map(|()| (8.0 * dice.direction(), dice.in_range(0.0, 0.08)));
    let bumpy = |mesh: &TriMesh, scale: f32| {
        let move_out = |p: &Vec3| {
            let wave = |&(wave, height): &(Vec3, f32)| {
                let turn = wave.dot(*p).rem_euclid(2.0) - 1.0;
                height * (1.0 - turn.abs())
            };
            *p * scale * (1.0 + bumps.iter().map(wave).sum::<f32>())
        };
        let positions = mesh.positions().iter().map(move_out).collect();
        TriMesh::new(positions, mesh.triangles().to_vec()).unwrap()
    };
    let mesh = match dice.below(4) {
        0 => bumpy(&torus(0.5, 0.2, 50, 30), 1.0),
        1 => joined(&[(bumpy(&ball, 1.0), false), (bumpy(&ball, 0.6), true)]),
        2 => {
            let aside = bumpy(&ball, 0.7);
            let moved = aside.positions().iter().map(|&p| p + 1.2 * Vec3::X);
            let moved = TriMesh::new(moved.collect(), aside.triangles().to_vec()).unwrap();
            joined(&[(bumpy(&ball, 0.8), false), (moved, false)])
        }
        _ => bumpy(&ball, 1.0),
    };
    let (turn, size) = (dice.rotation(), [0.01, 1.0, 100.0][dice.below(3)]);
    let place = |&p: &Vec3| turn * (p * size);
    let positions: Vec<Vec3> = mesh.positions().iter().map(place).collect();
    let normals = positions.iter().map(|p| p.normalize()).collect();
    let uvs = positions.iter().map(|&p| uv(p)).collect();
    let slots = vec![0; mesh.triangles().len()];
    let mesh = TriMesh::new(positions, mesh.triangles().to_vec()).unwrap();
    let mesh = mesh.with_normals(normals).unwrap().with_uvs(uvs).unwrap();
    mesh.with_materials(slots).unwrap()
}

fn visual(piece: &Piece) -> &TriMesh {
    piece.visual.as_ref().unwrap()
}

/// Parts of the surface look as before, and caps have the texture of their wall in metres.
fn check_looks(mesh: &TriMesh, size: f32) {
    for (triangle, &slot) in mesh.triangles().iter().zip(mesh.materials()) {
        let points = triangle.map(|v| mesh.positions()[v as usize]);
        let uvs = triangle.map(|v| mesh.uvs()[v as usize]);
        if slot != INSIDE {
            for (point, found) in points.into_iter().zip(uvs) {
                assert!(
                    (uv(point) - found).length() < 1e-5 * size,
                    "{point} {found}"
                );
            }
            continue;
        }
        let normals = triangle.map(|v| mesh.normals()[v as usize]);
        let (a, b) = (points[1] - points[0], points[2] - points[0]);
        let area = a.cross(b);
        assert!(normals[0].distance(normals[1]) < 1e-5);
        assert!(
            area.dot(normals[0]) > -1e-6 * size * size,
            "faces backwards"
        );
        for edge in 0..3 {
            let along = points[(edge + 1) % 3] - points[edge];
            let found = uvs[(edge + 1) % 3] - uvs[edge];
            let off = (along.length() - found.length()).abs();
            assert!(off < 1e-5 * size, "{off}");
        }
    }
}

/// Meshes of 2560 to 10 240 triangles and of 1 cm to 200 m, with holes, cavities and several parts, in 2 to 60 cells.
#[test]
fn cells_of_large_meshes_are_what_cuts_by_planes_leave() {
    let mut dice = Dice::new(34);
    for round in 0..10 {
        let mesh = member(&mut dice);
        let hull = ConvexHull::from_points(mesh.positions()).unwrap();
        let size = hull.aabb().diagonal();
        let count = 2 + dice.below(59);
        let middle = hull.aabb().center();
        let site = |dice: &mut Dice| middle + 0.3 * size * dice.vector(-1.0, 1.0);
        let cutting = Cutting::Sites((0..count).map(|_| site(&mut dice)).collect());
        let cut = |cap_normals| {
            let options = SliceOptions {
                cap_normals,
                cap_material: Some(INSIDE),
                ..SliceOptions::default()
            };
            (PieceCutter::default().cut(&hull, Some(&mesh), &cutting, usize::MAX, options)).unwrap()
        };
        let (pieces, twins) = (cut(CapNormals::Flat), cut(CapNormals::Smooth));
        assert_eq!(pieces.len(), twins.len());
        let whole = mesh.volume();
        let mut sum = 0.0;
        for (piece, twin) in pieces.iter().zip(&twins) {
            let [own, other] = [piece, twin].map(|piece| visual(piece).volume());
            assert!((own - other).abs() < 2e-6 * whole, "{round}: {own} {other}");
            assert_eq!(defect(visual(piece)), None, "{round}");
            let [own, other] = [piece, twin].map(|piece| visual(piece).triangles().len());
            assert!(own <= other, "{round}: {own} triangles, {other}");
            check_looks(visual(piece), size);
            sum += visual(piece).volume();
        }
        assert!((sum / whole - 1.0).abs() < 1e-6, "{round}: {sum} {whole}");
    }
}

/// Cells whose walls run through corners of a fine grid are left to planes, and are closed as well.
#[test]
fn walls_through_corners_of_large_meshes_are_no_obstacle() {
    let mut dice = Dice::new(35);
    let ball = primitives::icosphere(0.5, 4).unwrap().to_mesh();
    for _ in 0..3 {
        let mesh = ball.clone();
        let hull = ConvexHull::from_points(mesh.positions()).unwrap();
        // Planes half way between a corner and its image in a plane through the middle go through that, as many edges do.
        let turn = Quat::from_rotation_y(dice.in_range(0.0, 3.0));
        let mut sites: Vec<Vec3> = [Vec3::X, Vec3::Y, Vec3::Z]
            .into_iter()
            .flat_map(|axis| [0.2 * axis, -0.2 * axis])
            .collect();
        sites.push(turn * Vec3::new(0.1, 0.0, 0.0));
        let cutting = Cutting::Sites(sites);
        let pieces = PieceCutter::default()
            .cut(
                &hull,
                Some(&mesh),
                &cutting,
                usize::MAX,
                SliceOptions::default(),
            )
            .unwrap();
        let sum: f64 = pieces.iter().map(|piece| visual(piece).volume()).sum();
        assert!((sum / mesh.volume() - 1.0).abs() < 1e-6);
        for piece in &pieces {
            assert_eq!(defect(visual(piece)), None);
        }
    }
}
