//! A scene as plain numbers: who is in it, for how long, and which laws it has to keep.

use super::laws::Law;
use bevy_cleave::prelude::*;
use glam::{DVec3, Quat, Vec2, Vec3};

/// In which of a scene's two versions a body is. Some laws compare the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// In both.
    Both,
    /// Only in the scene itself: a floor in many pieces, something that is passed by.
    Here,
    /// Only in what the scene is compared with: the same floor in one piece.
    There,
}

impl Role {
    /// Name in files.
    pub(crate) const NAMES: [(Self, &str); 3] = [
        (Self::Both, "both"),
        (Self::Here, "here"),
        (Self::There, "there"),
    ];
}

/// A shape as numbers, m, in the body's frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Form {
    /// A box by its edge lengths.
    Box(Vec3),
    /// The hull of points.
    Hull(Vec<Vec3>),
    /// What is below the plane through the origin with this normal.
    HalfSpace(Vec3),
    /// What is round about y.
    Smooth(Smooth, [f32; 2]),
    /// All that is within a distance of another form.
    Rounded(Box<Form>, f32),
    /// Convex forms in one body.
    Compound(Vec<(Form, Pose)>),
    /// A level of triangles.
    Ground(Ground),
}

/// What is round about y, by its radius and its length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Smooth {
    /// The length does not count.
    Sphere,
    Capsule,
    Cylinder,
    Cone,
}

impl Smooth {
    /// Names in files.
    pub(crate) const NAMES: [(Self, &str); 4] = [
        (Self::Sphere, "sphere"),
        (Self::Capsule, "capsule"),
        (Self::Cylinder, "cylinder"),
        (Self::Cone, "cone"),
    ];
}

/// Heights over a grid in x and z, as `StaticMesh::from_heights` takes them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ground {
    pub(crate) heights: Vec<f32>,
    pub(crate) columns: usize,
    pub(crate) spacing: f32,
}

impl Ground {
    /// Width along x and z, m.
    pub(crate) fn extent(&self) -> [f32; 2] {
        let rows = self.heights.len() / self.columns;
        [self.columns, rows].map(|count| (count - 1) as f32 * self.spacing)
    }

    /// The points of the grid, m.
    pub(crate) fn points(&self) -> impl Iterator<Item = DVec3> + '_ {
        let heights = self.heights.iter().enumerate();
        heights.map(|(i, &height)| {
            let [x, z] = [i % self.columns, i / self.columns].map(|i| i as f32 * self.spacing);
            Vec3::new(x, height, z).as_dvec3()
        })
    }

    /// How far a point in the ground's frame is above the triangle below or above it, along its normal, m; infinite beside the ground.
    pub(crate) fn below(&self, point: DVec3) -> f64 {
        let [x, z] = [point.x, point.z].map(|at| at / f64::from(self.spacing));
        let rows = self.heights.len() / self.columns;
        let (last_x, last_z) = ((self.columns - 1) as f64, (rows - 1) as f64);
        if !((0.0..last_x).contains(&x) && (0.0..last_z).contains(&z)) {
            return f64::INFINITY;
        }
        let (column, row) = (x.floor(), z.floor());
        let (u, v) = (x - column, z - row);
        let at = |dx: usize, dz: usize| {
            let index = (row as usize + dz) * self.columns + column as usize + dx;
            f64::from(self.heights[index])
        };
        let [a, b, c, d] = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
        // Cells are cut from the first corner to the last.
        let [along_x, along_z] = if v > u {
            [d - c, c - a]
        } else {
            [b - a, d - b]
        };
        let height = a + u * along_x + v * along_z;
        let slope = [along_x, along_z].map(|rise| rise / f64::from(self.spacing));
        (point.y - height) / (1.0 + slope[0] * slope[0] + slope[1] * slope[1]).sqrt()
    }
}

impl Form {
    /// Largest distance of a corner from the frame's origin, m; zero for a half-space.
    pub(crate) fn radius(&self) -> f32 {
        match self {
            Self::Box(size) => 0.5 * size.length(),
            Self::Hull(points) => points.iter().fold(0.0, |r, p| r.max(p.length())),
            Self::HalfSpace(_) | Self::Ground(_) => 0.0,
            Self::Smooth(Smooth::Sphere, [radius, _]) => *radius,
            Self::Smooth(Smooth::Capsule, [radius, length]) => radius + 0.5 * length,
            Self::Smooth(_, [radius, length]) => Vec2::new(*radius, 0.5 * length).length(),
            Self::Rounded(form, radius) => form.radius() + radius,
            Self::Compound(parts) => parts.iter().fold(0.0, |far, (form, pose)| {
                far.max(form.radius() + pose.position.length())
            }),
        }
    }

    /// The shape if it is a convex one; `None` if the numbers make none.
    pub(crate) fn convex(&self) -> Option<ConvexMesh> {
        match self {
            Self::Box(s) => ConvexMesh::cuboid(s.x, s.y, s.z).ok(),
            Self::Hull(points) => ConvexMesh::from_points(points).ok(),
            Self::Smooth(kind, [radius, length]) => match kind {
                Smooth::Sphere => ConvexMesh::sphere(*radius),
                Smooth::Capsule => ConvexMesh::capsule(*radius, *length),
                Smooth::Cylinder => ConvexMesh::cylinder(*radius, *length),
                Smooth::Cone => ConvexMesh::cone(*radius, *length),
            }
            .ok(),
            Self::Rounded(form, radius) => form.convex()?.rounded(*radius).ok(),
            Self::HalfSpace(_) | Self::Compound(_) | Self::Ground(_) => None,
        }
    }

    /// The shape of a simulation; `None` if the numbers make none.
    pub(crate) fn shape(&self) -> Option<Shape> {
        match self {
            Self::HalfSpace(normal) => Some(Shape::HalfSpace(HalfSpaceShape::new(*normal).ok()?)),
            Self::Compound(parts) => {
                let parts = parts
                    .iter()
                    .map(|(form, pose)| Some((form.convex()?, *pose)));
                let parts: Option<Vec<_>> = parts.collect();
                let parts = parts?.into_iter();
                let parts = parts.map(|(shape, pose)| CompoundPart::new(pose, shape));
                Some(Shape::Compound(Compound::new(parts).ok()?))
            }
            Self::Ground(ground) => {
                let Ground {
                    heights,
                    columns,
                    spacing,
                } = ground;
                let mesh = StaticMesh::from_heights(heights, *columns, *spacing);
                Some(Shape::Level(mesh.ok()?))
            }
            _ => Some(Shape::Convex(self.convex()?)),
        }
    }

    /// The same shape in another size.
    pub(crate) fn scaled(&mut self, factor: f32) {
        match self {
            Self::Box(size) => *size *= factor,
            Self::Hull(points) => points.iter_mut().for_each(|p| *p *= factor),
            Self::HalfSpace(_) => {}
            Self::Smooth(_, sizes) => *sizes = sizes.map(|size| size * factor),
            Self::Rounded(form, radius) => {
                form.scaled(factor);
                *radius *= factor;
            }
            Self::Compound(parts) => parts.iter_mut().for_each(|(form, pose)| {
                form.scaled(factor);
                pose.position *= factor;
            }),
            Self::Ground(ground) => {
                ground
                    .heights
                    .iter_mut()
                    .for_each(|height| *height *= factor);
                ground.spacing *= factor;
            }
        }
    }
}

/// A body of a scene.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Actor {
    pub(crate) kind: RigidBody,
    pub(crate) role: Role,
    pub(crate) form: Form,
    pub(crate) pose: Pose,
    /// Velocity of the center of mass, m/s.
    pub(crate) linear: Vec3,
    /// rad/s, world axes.
    pub(crate) angular: Vec3,
    /// kg/m3.
    pub(crate) density: f32,
    pub(crate) friction: f32,
    pub(crate) restitution: f32,
}

impl Actor {
    /// A dynamic body at rest, of the density of water.
    pub(crate) fn new(form: Form, position: Vec3) -> Self {
        Self {
            kind: RigidBody::Dynamic,
            role: Role::Both,
            form,
            pose: Pose::new(position, Quat::IDENTITY),
            linear: Vec3::ZERO,
            angular: Vec3::ZERO,
            density: 1000.0,
            friction: 0.5,
            restitution: 0.0,
        }
    }

    /// A static body.
    pub(crate) fn fixed(form: Form, position: Vec3) -> Self {
        Self {
            kind: RigidBody::Static,
            ..Self::new(form, position)
        }
    }

    pub(crate) fn is_dynamic(&self) -> bool {
        self.kind == RigidBody::Dynamic
    }

    /// What a simulation makes the body from; `None` if its numbers make no shape.
    pub(crate) fn desc(&self) -> Option<BodyDesc> {
        let mut desc = BodyDesc::new(self.kind, self.form.shape()?);
        desc.pose = self.pose;
        (desc.linear_velocity, desc.angular_velocity) = (self.linear, self.angular);
        desc.density = self.density;
        desc.friction = Friction::new(self.friction);
        desc.restitution = Restitution::new(self.restitution);
        Some(desc)
    }
}

/// A scene and the laws that it has to keep.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scene {
    pub(crate) family: String,
    pub(crate) seed: u64,
    pub(crate) laws: Vec<Law>,
    /// m/s2.
    pub(crate) gravity: Vec3,
    /// Steps per second.
    pub(crate) rate: f32,
    /// With how many sub-steps, no more and no less, each of one sweep before and one after the motion; 0: default settings.
    pub(crate) soft: u32,
    /// How many steps the laws are given.
    pub(crate) steps: u32,
    pub(crate) actors: Vec<Actor>,
}

impl Scene {
    pub(crate) fn has(&self, law: Law) -> bool {
        self.laws.contains(&law)
    }

    /// Length of a step, s.
    pub(crate) fn step_length(&self) -> f32 {
        self.rate.recip()
    }

    /// The version of the scene that holds the bodies of both and those of `role`.
    pub(crate) fn version(&self, role: Role) -> Self {
        let mut version = self.clone();
        version
            .actors
            .retain(|actor| actor.role == Role::Both || actor.role == role);
        version
    }
}
