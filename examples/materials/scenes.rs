//! One scene for each material: what it is made of, what hits it, and where it is looked at from.

use crate::support::Error;
use crate::support::colors::{IRON, clay};
use crate::{concrete, recipes};
use bevy_cleave::geometry::primitives;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// A scene and how it is shown.
pub(crate) struct Demo {
    pub(crate) name: &'static str,
    pub(crate) simulation: Simulation,
    /// By slot, linear RGB; pieces have that of what they come from.
    pub(crate) colors: Vec<Vec3>,
    /// Steps after which a picture is taken.
    pub(crate) shown: [usize; 2],
    pub(crate) eye: Vec3,
    pub(crate) target: Vec3,
}

impl Demo {
    fn new(name: &'static str, shown: [usize; 2], eye: Vec3, target: Vec3) -> Result<Self, Error> {
        let mut demo = Self {
            name,
            simulation: Simulation::default(),
            colors: Vec::new(),
            shown,
            eye,
            target,
        };
        demo.add(BodyDesc::floor(HalfSpaceShape::new(Vec3::Y)?), Vec3::ZERO)?;
        Ok(demo)
    }

    fn add(&mut self, body: BodyDesc, color: Vec3) -> Result<u32, Error> {
        let slot = self.simulation.bodies.insert(body)?;
        self.colors.push(color);
        Ok(slot)
    }

    /// A fixed block.
    fn fix(&mut self, size: Vec3, at: Vec3) -> Result<(), Error> {
        let mut block = BodyDesc::dynamic(ConvexMesh::cuboid(size.x, size.y, size.z)?, at);
        block.kind = RigidBody::Static;
        self.add(block, Vec3::splat(0.25))?;
        Ok(())
    }

    /// A ball of iron.
    fn shoot(&mut self, radius: f32, from: Vec3, velocity: Vec3) -> Result<(), Error> {
        let hull = primitives::icosphere(radius, 2)?;
        let mut ball = BodyDesc::dynamic(ConvexMesh::from_hull(hull), from);
        ball.linear_velocity = velocity;
        ball.density = 7800.0;
        self.add(ball, IRON)?;
        Ok(())
    }

    /// A block of a material.
    fn put(
        &mut self,
        size: Vec3,
        at: Vec3,
        density: f32,
        material: Fracturable,
        color: Vec3,
    ) -> Result<u32, Error> {
        let mut block = BodyDesc::dynamic(ConvexMesh::cuboid(size.x, size.y, size.z)?, at);
        block.density = density;
        block.fracturable = Some(material);
        self.add(block, color)
    }
}

/// A pane in a groove, and a ball.
pub(crate) fn glass() -> Result<Demo, Error> {
    let (eye, target) = (Vec3::new(1.5, 1.1, 1.9), Vec3::new(0.0, 0.55, -0.1));
    let mut demo = Demo::new("glass", [12, 27], eye, target)?;
    let size = Vec3::new(1.2, 1.0, 0.012);
    let color = Vec3::new(0.35, 0.62, 0.60);
    for side in [-1.0, 1.0] {
        let at = Vec3::new(0.0, 0.03, side * (0.5 * size.z + 0.021));
        demo.fix(Vec3::new(1.3, 0.06, 0.04), at)?;
    }
    demo.put(
        size,
        Vec3::new(0.0, 0.5, 0.0),
        2500.0,
        recipes::glass(),
        color,
    )?;
    demo.shoot(0.05, Vec3::new(0.15, 0.62, 2.2), Vec3::new(0.0, 1.0, -10.0))?;
    Ok(demo)
}

/// A wall with mortar, and a ball.
pub(crate) fn brick() -> Result<Demo, Error> {
    let (eye, target) = (Vec3::new(2.6, 1.9, 3.4), Vec3::new(0.0, 0.75, -0.2));
    let mut demo = Demo::new("brick", [8, 32], eye, target)?;
    let size = Vec3::new(0.25, 0.125, 0.125);
    let mut bricks = Vec::new();
    for course in 0..12_u8 {
        let y = (f32::from(course) + 0.5) * size.y;
        let shift = if course % 2 == 0 { 0.0 } else { 0.5 };
        for i in 0..9_u8 {
            let x = (f32::from(i) + shift - 4.25) * size.x;
            let number = bricks.len();
            let color = clay(number);
            let material = recipes::brick(number as u64);
            bricks.push(demo.put(size, Vec3::new(x, y, 0.0), 1900.0, material, color)?);
        }
    }
    recipes::lay(&mut demo.simulation, &bricks)?;
    demo.shoot(0.09, Vec3::new(-0.2, 0.95, 2.6), Vec3::new(0.0, 0.8, -14.0))?;
    Ok(demo)
}

/// A beam of laths on two trestles, and a ball that falls on it.
pub(crate) fn wood() -> Result<Demo, Error> {
    let (eye, target) = (Vec3::new(1.7, 1.6, 2.6), Vec3::new(0.0, 0.55, 0.0));
    let mut demo = Demo::new("wood", [14, 36], eye, target)?;
    for side in [-0.95, 0.95] {
        demo.fix(Vec3::new(0.12, 0.7, 0.5), Vec3::new(side, 0.35, 0.0))?;
    }
    let size = Vec3::new(2.2, 0.04, 0.06);
    let mut laths = Vec::new();
    for layer in 0..3_u8 {
        for row in 0..4_u8 {
            let y = 0.7 + (f32::from(layer) + 0.5) * size.y;
            let z = (f32::from(row) - 1.5) * size.z;
            let shade = 0.85 + 0.1 * f32::from((layer * 3 + row * 5) % 4);
            let color = shade * Vec3::new(0.48, 0.31, 0.15);
            let material = recipes::lath(u64::from(4 * layer + row));
            laths.push(demo.put(size, Vec3::new(0.0, y, z), 450.0, material, color)?);
        }
    }
    recipes::grow(&mut demo.simulation, &laths)?;
    demo.shoot(0.17, Vec3::new(0.1, 3.0, 0.0), Vec3::new(0.0, -7.0, 0.0))?;
    Ok(demo)
}

/// A boulder that falls on an edge of rock.
pub(crate) fn stone() -> Result<Demo, Error> {
    let (eye, target) = (Vec3::new(3.4, 2.4, 4.2), Vec3::new(0.0, 0.7, 0.0));
    let mut demo = Demo::new("stone", [40, 85], eye, target)?;
    demo.fix(Vec3::new(1.2, 0.5, 0.9), Vec3::new(0.0, 0.25, 0.0))?;
    let points: Vec<Vec3> = primitives::icosphere(0.75, 2)?
        .vertices()
        .iter()
        .enumerate()
        .filter(|(i, _)| i % 5 < 2)
        .map(|(i, v)| *v * (0.85 + 0.05 * (i * 7 % 5) as f32))
        .collect();
    let hull = ConvexHull::from_points(&points)?;
    let mut boulder = BodyDesc::dynamic(ConvexMesh::from_hull(hull), Vec3::new(0.1, 5.0, 0.0));
    boulder.pose.rotation = Quat::from_rotation_z(0.5);
    boulder.linear_velocity = Vec3::new(0.0, -2.0, 0.0);
    boulder.density = 2650.0;
    boulder.fracturable = Some(recipes::stone());
    demo.add(boulder, Vec3::new(0.42, 0.40, 0.37))?;
    Ok(demo)
}

/// A wall that stands, cast around bars of steel, and two balls. Lumps break off; the bars, bodies of their own, go on standing.
pub(crate) fn concrete() -> Result<Demo, Error> {
    let (eye, target) = (Vec3::new(1.5, 1.5, 3.0), Vec3::new(0.15, 0.75, 0.0));
    let mut demo = Demo::new("concrete", [7, 70], eye, target)?;
    let size = Vec3::new(2.4, 1.6, 0.16);
    let at = Pose::from_position(0.5 * size.y * Vec3::Y);
    let (wall, bars) = concrete::concrete(size, 0.4)?;
    let wall = BodyDesc {
        kind: RigidBody::Static,
        pose: at,
        density: 2400.0,
        ..BodyDesc::compound(wall.compound()?, Vec3::ZERO)
    };
    let wall = demo.add(wall, Vec3::new(0.46, 0.45, 0.43))?;
    // It stands on its foot, and is not hung up on the bars.
    let foot = Anchors::none().and_behind(Vec3::Y, 0.02 - 0.5 * size.y);
    demo.simulation.bodies.set_anchors(wall, Some(foot))?;
    for bar in bars {
        let bar = BodyDesc {
            pose: at * bar.pose,
            ..BodyDesc::new(RigidBody::Static, Shape::Convex(bar.shape))
        };
        demo.add(bar, Vec3::new(0.30, 0.15, 0.08))?;
    }
    // Through the grid, on both sides of a crossing, from behind.
    for at in [Vec3::new(0.0, 1.2, -2.0), Vec3::new(0.4, 0.8, -2.6)] {
        demo.shoot(0.15, at, Vec3::new(0.0, 0.4, 24.0))?;
    }
    Ok(demo)
}
