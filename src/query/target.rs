//! One body: its shape where it lies now, and what is asked in its frame.

use crate::bodies::body::Shape;
use crate::contact::body_id::BodyId;
use crate::geometry::support::{Core, PlacedCore};
use crate::math::{Aabb, Pose, rotate};
use crate::query::cuboid::{Cuboid, Told};
use crate::query::hit::QueryHit;
use crate::query::local::{LocalCast, LocalHit, LocalRay};
use crate::query::nearness::nearest_to;
use crate::query::place::{Place, Plain};
use crate::query::request::{Ray, ShapeCast};
use crate::query::shape::{QueryPart, QueryShape};
use crate::query::{compound, convex, half_space, level};
use glam::{Mat3, Vec3};

/// A body that is asked.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target<'b> {
    slot: u32,
    id: BodyId,
    pose: Pose,
    plain: Plain,
    shape: &'b Shape,
}

impl<'b> Target<'b> {
    pub(crate) fn at(place: &'b Place) -> Self {
        Self {
            slot: place.slot,
            id: place.id,
            pose: place.pose(),
            plain: place.plain,
            shape: &place.shape,
        }
    }

    /// The box around the body; none for a half-space.
    pub(crate) fn bounds(&self) -> Option<Aabb> {
        let turn = Mat3::from_quat(self.pose.rotation);
        match self.shape {
            Shape::Convex(mesh) => Some(mesh.bounds(&turn, self.pose.position)),
            Shape::Compound(mesh) => Some(mesh.bounds(&turn, self.pose.position)),
            Shape::Level(mesh) => Some(Core::Box(mesh.aabb()).bounds(&turn, self.pose.position)),
            Shape::HalfSpace(_) => None,
        }
    }

    fn in_world(&self, hit: LocalHit) -> QueryHit {
        QueryHit {
            body: self.slot,
            id: self.id,
            point: self.pose.transform_point(hit.point),
            normal: rotate(self.pose.rotation, hit.normal),
            distance: hit.distance,
            part: hit.part,
            triangle: hit.triangle,
            face: hit.face,
        }
    }

    /// The pose of the shape of a question in the body's frame.
    fn own_pose(&self, pose: &Pose) -> Pose {
        let back = self.pose.rotation.inverse();
        Pose::new(
            rotate(back, pose.position - self.pose.position),
            (back * pose.rotation).normalize(),
        )
    }

    /// What a ray hits of the body up to `end` (m).
    pub(crate) fn cast_ray(&self, ray: &Ray, end: f32) -> Option<QueryHit> {
        let back = self.pose.rotation.inverse();
        let local = LocalRay {
            origin: rotate(back, ray.origin - self.pose.position),
            direction: rotate(back, ray.direction),
            end,
            is_solid: ray.is_solid,
        };
        let hit = match self.shape {
            Shape::Convex(mesh) => convex::cast_ray(mesh, &local),
            Shape::Compound(mesh) => compound::cast_ray(mesh, &local),
            Shape::HalfSpace(below) => half_space::cast_ray(below.normal, &local),
            Shape::Level(mesh) => level::cast_ray(mesh, &local),
        }?;
        Some(QueryHit {
            point: ray.at(hit.distance),
            ..self.in_world(hit)
        })
    }

    /// What a moved shape touches of the body up to `end` (m), where gaps of `touch` (m) are none; of what its parts touch as early,
    /// that of the first.
    pub(crate) fn cast_shape(&self, cast: &ShapeCast, touch: f32, end: f32) -> Option<QueryHit> {
        let back = self.pose.rotation.inverse();
        let mut best: Option<LocalHit> = None;
        for part in cast.shape.parts(&cast.pose) {
            let local = LocalCast {
                core: PlacedCore::new(part.core, &self.own_pose(&part.pose)),
                radius: part.radius,
                direction: rotate(back, cast.direction),
                free: 0.0,
                end: best.map_or(end, |best| best.distance),
                touch,
            };
            let hit = match self.shape {
                Shape::Convex(mesh) => convex::cast_shape(mesh, &local),
                Shape::Compound(mesh) => compound::cast_shape(mesh, &local),
                Shape::HalfSpace(below) => half_space::cast_shape(below.normal, &local),
                Shape::Level(mesh) => level::cast_shape(mesh, &local),
            };
            keep_nearest(&mut best, hit);
        }
        best.map(|hit| self.in_world(hit))
    }

    /// Whether a shape at a pose overlaps the body or touches it.
    pub(crate) fn overlaps(&self, shape: &QueryShape, pose: &Pose) -> bool {
        shape.parts(pose).any(|part| {
            let own = self.own_pose(&part.pose);
            if let Some(overlaps) = self.overlaps_plainly(&part, &own) {
                return overlaps;
            }
            let other = PlacedCore::new(part.core, &own);
            let radius = f64::from(part.radius);
            match self.shape {
                Shape::Convex(mesh) => convex::overlaps(mesh, &other, part.radius),
                Shape::Compound(mesh) => compound::overlaps(mesh, &other, part.radius),
                Shape::HalfSpace(below) => half_space::lowest(below.normal, &other).0 <= radius,
                Shape::Level(mesh) => level::overlaps(mesh, &other, part.radius),
            }
        })
    }

    /// The same of a box, at a pose in the body's frame, and a body that a few numbers tell, if these are enough.
    fn overlaps_plainly(&self, part: &QueryPart, own: &Pose) -> Option<bool> {
        let Core::Box(b) = part.core else {
            return None;
        };
        let cuboid = Cuboid::at(&b, own);
        match self.plain {
            Plain::Ball(radius) => {
                let reach = f64::from(part.radius) + f64::from(radius);
                Some(cuboid.reaches(Vec3::ZERO, reach))
            }
            Plain::Box(body) if part.radius == 0.0 => match cuboid.against_box(&body) {
                Told::Apart => Some(false),
                Told::Overlap => Some(true),
                Told::Nothing(_) => None,
            },
            Plain::Box(_) | Plain::Other => None,
        }
    }

    /// Where the body is nearest to a shape at a pose, if that is within `limit` (m).
    pub(crate) fn nearest_to(
        &self,
        shape: &QueryShape,
        pose: &Pose,
        limit: f32,
    ) -> Option<QueryHit> {
        let mut best = None;
        for part in shape.parts(pose) {
            let core = PlacedCore::new(part.core, &self.own_pose(&part.pose));
            let hit = nearest_to(self.shape, &core, part.radius, limit);
            keep_nearest(&mut best, hit);
        }
        best.map(|hit| self.in_world(hit))
    }

    /// The point of the surface that is nearest to `point`, if it is within `limit` (m).
    pub(crate) fn closest(&self, point: Vec3, limit: f32) -> Option<QueryHit> {
        let local = rotate(self.pose.rotation.inverse(), point - self.pose.position);
        let hit = match self.shape {
            Shape::Convex(mesh) => convex::closest(mesh, local, limit)?,
            Shape::Compound(mesh) => compound::closest(mesh, local, limit)?,
            Shape::HalfSpace(below) => half_space::closest(below.normal, local),
            Shape::Level(mesh) => level::closest(mesh, local, limit)?,
        };
        (hit.distance <= limit).then(|| self.in_world(hit))
    }
}

/// Keeps a hit if it is nearer than what is known.
fn keep_nearest(best: &mut Option<LocalHit>, hit: Option<LocalHit>) {
    if let Some(hit) = hit
        && best.is_none_or(|best| hit.distance < best.distance)
    {
        *best = Some(hit);
    }
}
