//! `TriMesh` from and to Bevy's `Mesh`.

use bevy_asset::RenderAssetUsages;
use bevy_cleave::extras::unread_attributes;
use bevy_cleave::geometry::primitives;
use bevy_cleave::prelude::*;
use bevy_math::{Vec2, Vec3, Vec4};
use bevy_mesh::{Indices, Mesh, PrimitiveTopology};

/// Shapes with every set of attributes.
fn family() -> Vec<TriMesh> {
    let hulls = [
        primitives::cuboid(1.0, 2.0, 3.0),
        primitives::icosphere(0.7, 2),
        primitives::regular_prism(7, 1.0, 0.3),
        primitives::wedge(1.0, 1.0, 1.0),
    ];
    let mut all = Vec::new();
    for hull in hulls {
        let hull = hull.expect("a shape");
        let bare = TriMesh::new(hull.vertices().to_vec(), hull.triangles().collect());
        let bare = bare.expect("a mesh");
        let of_vertices =
            |f: &dyn Fn(Vec3) -> Vec3| bare.positions().iter().map(|&p| f(p)).collect();
        let normals: Vec<Vec3> = of_vertices(&|p| p.normalize());
        let smooth = bare.clone().with_normals(normals).expect("fits");
        let uvs: Vec<Vec2> = bare.positions().iter().map(|p| p.truncate()).collect();
        let colors: Vec<Vec4> = bare.positions().iter().map(|p| p.extend(1.0)).collect();
        let full = smooth.clone().with_uvs(uvs.clone()).expect("fits");
        let full = full.with_colors(colors.clone()).expect("fits");
        let slots: Vec<u16> = (0..bare.triangles().len())
            .map(|i| (i % 3) as u16)
            .collect();
        let slotted = full.clone().with_materials(slots.clone()).expect("fits");
        let flat = bare.clone().with_uvs(uvs).expect("fits");
        let flat = flat.with_colors(colors).expect("fits");
        let flat = flat.with_materials(slots).expect("fits");
        all.extend([bare, smooth, full, slotted, flat, hull.to_mesh()]);
    }
    all
}

/// Corners of triangles with all that they have, in order.
fn corners(mesh: &TriMesh) -> Vec<(Vec3, Option<Vec2>, Option<Vec4>)> {
    let vertices = mesh.triangles().as_flattened().iter().map(|&v| v as usize);
    let corner = |v: usize| {
        let uv = mesh.uvs().get(v).copied();
        (mesh.positions()[v], uv, mesh.colors().get(v).copied())
    };
    vertices.map(corner).collect()
}

#[test]
fn a_mesh_comes_back_as_it_went() {
    for mesh in family() {
        let there = Mesh::from(&mesh);
        assert_eq!(unread_attributes(&there), [""; 0]);
        let back = TriMesh::try_from(&there).expect("readable");
        assert_eq!(corners(&back), corners(&mesh));
        assert!((back.volume() - mesh.volume()).abs() < 1e-6 * mesh.volume());
        back.check_closed().expect("closed");
        for (corners, given) in back.triangles().iter().zip(mesh.triangles()) {
            let [a, b, c] = corners.map(|v| back.positions()[v as usize]);
            let face = (b - a).cross(c - a).normalize();
            for (&corner, &given) in corners.iter().zip(given) {
                let normal = back.normals()[corner as usize];
                // Flat where the mesh has none.
                let expected = mesh.normals().get(given as usize).copied();
                assert!(normal.distance(expected.unwrap_or(face)) < 1e-5);
            }
        }
    }
}

#[test]
fn slots_share_the_triangles_out() {
    for mesh in family() {
        let slots = [0, 1, 2].map(|slot| mesh.mesh_of_slot(slot));
        let counts = slots.iter().flatten().map(|mesh| {
            let back = TriMesh::try_from(mesh).expect("readable");
            back.triangles().len()
        });
        assert_eq!(counts.sum::<usize>(), mesh.triangles().len());
        assert!(mesh.mesh_of_slot(3).is_none());
    }
}

/// A strip of `count` vertices in the plane, zigzag, all of its triangles facing up.
fn zigzag(count: usize) -> Vec<[f32; 3]> {
    (0..count)
        .map(|i| [0.5 * i as f32, 0.0, -((i % 2) as f32)])
        .collect()
}

fn strip(positions: Vec<[f32; 3]>, indices: Option<Indices>) -> Mesh {
    let usage = RenderAssetUsages::default();
    let mesh = Mesh::new(PrimitiveTopology::TriangleStrip, usage)
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    match indices {
        Some(indices) => mesh.with_inserted_indices(indices),
        None => mesh,
    }
}

#[test]
fn triangles_of_strips_face_the_same_side() {
    let small: Vec<u16> = vec![0, 1, 2, 3, 4, u16::MAX, 3, 4, 5, 6];
    let large: Vec<u32> = vec![0, 1, 2, 3, 4, u32::MAX, 3, 4, 5, 6];
    // Restarted with an odd corner, the second strip faces the other way.
    let strips = [
        (strip(zigzag(7), None), 5, 0),
        (strip(zigzag(7), Some(Indices::U16(small))), 5, 2),
        (strip(zigzag(7), Some(Indices::U32(large))), 5, 2),
    ];
    for (mesh, count, turned) in strips {
        let read = TriMesh::try_from(&mesh).expect("readable");
        assert_eq!(read.triangles().len(), count);
        let faces = read.triangles().iter().map(|corners| {
            let [a, b, c] = corners.map(|v| read.positions()[v as usize]);
            (b - a).cross(c - a).y
        });
        let faces: Vec<f32> = faces.collect();
        let first = faces[0].signum();
        let other = faces.iter().filter(|y| y.signum() != first).count();
        assert_eq!(other, turned, "{faces:?}");
    }
}

#[test]
fn what_cannot_be_read_is_named() {
    let usage = RenderAssetUsages::default();
    let empty = Mesh::new(PrimitiveTopology::TriangleList, usage);
    assert_eq!(
        TriMesh::try_from(&empty),
        Err(MeshConversionError::NoPositions)
    );
    for topology in [PrimitiveTopology::LineList, PrimitiveTopology::PointList] {
        let mesh =
            Mesh::new(topology, usage).with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, zigzag(6));
        let error = MeshConversionError::NotTriangles(topology);
        assert_eq!(TriMesh::try_from(&mesh), Err(error));
    }
    let mut drawn = Mesh::from(&primitives::cuboid(1.0, 1.0, 1.0).expect("a box").to_mesh());
    drawn.take_gpu_data().expect("there");
    let error = MeshConversionError::OnlyInRenderWorld;
    assert_eq!(TriMesh::try_from(&drawn), Err(error));
    let far = Mesh::new(PrimitiveTopology::TriangleList, usage)
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, zigzag(3))
        .with_inserted_indices(Indices::U32(vec![0, 1, 7]));
    let error = TriMesh::try_from(&far).expect_err("vertex 7 is not there");
    assert!(error.to_string().contains("vertex 7"), "{error}");
}

#[test]
fn attributes_without_room_are_named() {
    let mut mesh = Mesh::from(&primitives::icosphere(1.0, 1).expect("a ball").to_mesh());
    let count = mesh.count_vertices();
    mesh.insert_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.5_f32, 0.25]; count]);
    mesh.insert_attribute(Mesh::ATTRIBUTE_UV_1, vec![[0.5_f32, 0.25]; count]);
    mesh.insert_attribute(
        Mesh::ATTRIBUTE_TANGENT,
        vec![[1.0_f32, 0.0, 0.0, 1.0]; count],
    );
    let mut unread = unread_attributes(&mesh);
    unread.sort_unstable();
    assert_eq!(unread, ["Vertex_Tangent", "Vertex_Uv_1"]);
}
