//! The scene of `shatter` and `minimal`, as descriptions of bodies.

use super::{Error, model};
use bevy_cleave::geometry::primitives;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3, Vec4};

/// Colors of meshes multiply the color of their body: surfaces are dark, cut faces pale.
const SURFACE_COLOR: Vec3 = Vec3::splat(0.5);
const CUT_COLOR: Vec4 = Vec4::new(2.2, 2.2, 2.2, 1.0);

/// A floor, a model from a file high above it, and bodies around and above the place where it lands.
pub fn shatter(path: &str) -> Result<Vec<BodyDesc>, Error> {
    let model = model::colored(model::fitted(model::load(path)?, 2.6), SURFACE_COLOR);
    let body = ConvexMesh::from_mesh(model::into_mesh(model)?)?;
    let mut model = BodyDesc::dynamic(body, Vec3::new(0.0, 4.0, 0.0));
    model.pose.rotation = Quat::from_rotation_z(0.12) * Quat::from_rotation_y(0.7);
    model.angular_velocity = Vec3::new(0.1, 0.3, 0.1);
    model.fracturable = Some(breakable(1500.0, 3, 2));
    let mut scene = vec![BodyDesc::floor(HalfSpaceShape::new(Vec3::Y)?), model];
    let shapes = [
        painted(primitives::cuboid(0.6, 0.6, 0.6)?)?,
        painted(primitives::regular_prism(6, 0.35, 0.7)?)?,
        painted(primitives::icosphere(0.38, 1)?)?,
        painted(primitives::wedge(0.8, 0.5, 0.6)?)?,
    ];
    for i in 0..12_u8 {
        // Eight around the place of the impact, four that come down on it later.
        let turn = Quat::from_rotation_y(f32::from(i) * std::f32::consts::TAU / 8.0);
        let (radius, height) = if i < 8 {
            (1.9, 0.5)
        } else {
            (1.2, 8.0 + f32::from(i))
        };
        let shape = shapes[usize::from(i % 4)].clone();
        let mut desc = BodyDesc::dynamic(shape, turn * Vec3::new(radius, height, 0.0));
        desc.pose.rotation = turn;
        desc.fracturable = (i % 2 == 0).then(|| breakable(700.0, 2, 1));
        scene.push(desc);
    }
    Ok(scene)
}

fn breakable(strength: f32, planes: u8, generations: u8) -> Fracturable {
    Fracturable {
        strength,
        pattern: FracturePattern::Star { planes },
        min_volume: 2e-4,
        generations,
        seed: 7,
        cut_color: Some(CUT_COLOR),
        ..Fracturable::default()
    }
}

/// A primitive with a mesh of its own, in the surface color, so that cut faces show on it.
fn painted(hull: ConvexHull) -> Result<ConvexMesh, Error> {
    let mesh = hull.to_mesh();
    let colors = vec![SURFACE_COLOR.extend(1.0); mesh.positions().len()];
    let mesh = mesh.with_colors(colors)?;
    Ok(ConvexMesh::from_parts(hull, Some(mesh)))
}
