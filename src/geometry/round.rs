//! `RoundShape`: spheres, capsules, cylinders, cones, and hulls with a rounding radius.
//!
//! A round shape is a core and a radius around it: a point, a segment, a hull; cylinders and cones are cores of their own without a
//! radius. Contacts and questions work on the core and take the radius off, so that nothing of the surface is made of faces.

use crate::geometry::distance::{Separation, distance};
use crate::geometry::frustum::Frustum;
use crate::geometry::hull_error::HullError;
use crate::geometry::moments::SolidMoments;
use crate::geometry::primitives::check_length;
use crate::geometry::round_core::RoundCore;
use crate::geometry::support::{Core, PlacedCore};
use crate::geometry::{ConvexHull, TriMesh, round_moments, round_polyhedron};
use crate::math::{Aabb, Pose};
use glam::{Mat3, Quat, Vec3};

/// A convex shape whose surface is curved.
#[derive(Clone, Debug)]
pub(crate) struct RoundShape {
    pub(crate) core: RoundCore,
    /// Rounding radius, m.
    pub(crate) radius: f32,
    pub(crate) aabb: Aabb,
    pub(crate) moments: SolidMoments,
}

impl RoundShape {
    pub(crate) fn sphere(radius: f32) -> Result<Self, HullError> {
        check_length("radius", radius)?;
        Ok(Self::assemble(RoundCore::Point, radius))
    }

    /// All within `radius` (m) of a segment of `length` (m) along y.
    pub(crate) fn capsule(radius: f32, length: f32) -> Result<Self, HullError> {
        check_length("radius", radius)?;
        check_length("length", length)?;
        Ok(Self::assemble(RoundCore::Segment(0.5 * length), radius))
    }

    /// A cylinder along y, or if `top` is 0 a cone.
    pub(crate) fn frustum(radius: f32, top: f32, height: f32) -> Result<Self, HullError> {
        check_length("radius", radius)?;
        check_length("height", height)?;
        let frustum = Frustum::new(radius, top, height);
        Ok(Self::assemble(RoundCore::Frustum(frustum), 0.0))
    }

    /// All within `radius` (m) of a hull.
    pub(crate) fn hull(hull: ConvexHull, radius: f32) -> Result<Self, HullError> {
        check_length("radius", radius)?;
        Ok(Self::assemble(RoundCore::Hull(Box::new(hull)), radius))
    }

    fn assemble(core: RoundCore, radius: f32) -> Self {
        let moments = round_moments::of(&core, f64::from(radius));
        let mut shape = Self {
            core,
            radius,
            aabb: Aabb::EMPTY,
            moments,
        };
        shape.aabb = shape.bounds(&Mat3::IDENTITY, Vec3::ZERO);
        shape
    }

    /// The same with a larger radius; none of a cylinder or a cone.
    pub(crate) fn rounded(&self, more: f32) -> Option<Self> {
        let is_cored = !matches!(self.core, RoundCore::Frustum(_));
        is_cored.then(|| Self::assemble(self.core.clone(), self.radius + more))
    }

    /// The same shape scaled about its origin, if it is of the same kind then.
    pub(crate) fn scaled(&self, factor: Vec3) -> Option<Self> {
        let is_even = factor.x == factor.y && factor.y == factor.z;
        let k = factor.x;
        let core = match &self.core {
            RoundCore::Point if is_even => RoundCore::Point,
            RoundCore::Segment(half) if is_even => RoundCore::Segment(k * half),
            RoundCore::Frustum(f) if factor.x == factor.z => RoundCore::Frustum(Frustum {
                levels: f.levels.map(|level| factor.y * level),
                radii: f.radii.map(|radius| k * radius),
            }),
            RoundCore::Hull(hull) if is_even => {
                let points: Vec<Vec3> = hull.vertices().iter().map(|v| k * *v).collect();
                RoundCore::Hull(Box::new(ConvexHull::from_points(&points).ok()?))
            }
            _ => return None,
        };
        Some(Self::assemble(core, k * self.radius))
    }

    /// The core, to which the radius is to be added.
    pub(crate) fn core(&self) -> Core<'_> {
        self.core.core()
    }

    /// The box around the shape in another frame.
    pub(crate) fn bounds(&self, turn: &Mat3, shift: Vec3) -> Aabb {
        self.core().bounds(turn, shift).fattened(self.radius)
    }

    /// Largest distance of the surface from a point, m.
    pub(crate) fn farthest_from(&self, point: Vec3) -> f32 {
        let of_core = match &self.core {
            RoundCore::Point => point.length(),
            RoundCore::Segment(half) => {
                let ends = [*half * Vec3::Y, *half * Vec3::NEG_Y];
                ends.map(|end| end.distance(point))
                    .into_iter()
                    .fold(0.0, f32::max)
            }
            RoundCore::Frustum(f) => {
                let from_axis = Vec3::new(point.x, 0.0, point.z).length();
                let far = [0, 1].map(|k| {
                    Vec3::new(from_axis + f.radii[k], f.levels[k] - point.y, 0.0).length()
                });
                far[0].max(far[1])
            }
            RoundCore::Hull(hull) => {
                let away = hull.vertices().iter().map(|v| v.distance(point));
                away.fold(0.0, f32::max)
            }
        };
        of_core + self.radius
    }

    /// The outward unit normal at a point of the surface, for the face with this normal that the point is a corner of.
    fn normal_at(&self, point: Vec3, face: Vec3) -> Vec3 {
        let out = |v: Vec3| v.try_normalize().unwrap_or(face);
        match &self.core {
            RoundCore::Point => out(point),
            RoundCore::Segment(half) => out(point - point.y.clamp(-half, *half) * Vec3::Y),
            RoundCore::Frustum(f) => {
                let n = f.side_normal().as_vec2();
                // The facets of the side are as steep as the side, but for those of the caps.
                if face.y.abs() > 0.999 {
                    return face;
                }
                let across = Vec3::new(point.x, 0.0, point.z).try_normalize();
                let across = across.or_else(|| Vec3::new(face.x, 0.0, face.z).try_normalize());
                across.map_or(face, |out| n.x * out + n.y * Vec3::Y)
            }
            RoundCore::Hull(hull) => {
                let there = Pose::new(point, Quat::IDENTITY);
                let there = PlacedCore::new(Core::of_point(Vec3::ZERO), &there);
                match distance(&Core::of_hull(hull), &there, f64::INFINITY) {
                    Separation::Near(nearest) => nearest.normal.as_vec3(),
                    _ => face,
                }
            }
        }
    }

    /// A mesh of a polyhedron of this shape with the normals of the shape.
    pub(crate) fn smooth_mesh(&self, polyhedron: &ConvexHull) -> TriMesh {
        let mut mesh = polyhedron.to_mesh();
        for at in 0..mesh.positions.len() {
            mesh.normals[at] = self.normal_at(mesh.positions[at], mesh.normals[at]);
        }
        mesh
    }

    /// The polyhedron that stands for the shape where it is cut or drawn, with its corners on the surface.
    pub(crate) fn polyhedron(&self, resolution: u32) -> Result<ConvexHull, HullError> {
        round_polyhedron::of(&self.core, self.radius, resolution)
    }
}
