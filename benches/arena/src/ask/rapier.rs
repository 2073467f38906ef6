//! The same questions to Rapier.

use super::{EDGES, Kind, Oracle, Question, RADIUS, REACH, Site, Thing};
use crate::Error;
use rapier3d::parry::query::ShapeCastOptions;
use rapier3d::parry::shape::{Ball, Cuboid};
use rapier3d::prelude::*;

pub(super) struct Rapier(PhysicsWorld);

impl Rapier {
    pub(super) fn new(site: &Site) -> Result<Self, Error> {
        let mut world = PhysicsWorld::new();
        let mut add = |shape: SharedShape, pose: Pose| {
            let body = world.insert_body(RigidBodyBuilder::fixed().pose(pose));
            world.insert_collider(ColliderBuilder::new(shape), Some(body));
        };
        for (thing, at, turn) in &site.bodies {
            let shape = match thing {
                Thing::Box(size) => SharedShape::cuboid(0.5 * size.x, 0.5 * size.y, 0.5 * size.z),
                Thing::Hull(points) => SharedShape::convex_hull(points).ok_or("no hull")?,
                Thing::Ball(radius) => SharedShape::ball(*radius),
            };
            add(shape, Pose::from_parts(*at, *turn));
        }
        if let Some((points, triangles)) = site.triangles() {
            add(SharedShape::trimesh(points, triangles)?, Pose::IDENTITY);
        }
        world.step();
        Ok(Self(world))
    }
}

impl Oracle for Rapier {
    fn answer(&self, kind: Kind, question: &Question) -> Option<f32> {
        let Question {
            at,
            direction,
            turn,
        } = *question;
        let asked = self.0.query_pipeline();
        let cast = |shape: &dyn Shape| {
            let options = ShapeCastOptions::with_max_time_of_impact(REACH);
            let pose = Pose::from_parts(at, turn);
            let (_, hit) = asked.cast_shape(&pose, direction, shape, options)?;
            Some(hit.time_of_impact)
        };
        match kind {
            Kind::Ray => {
                let ray = Ray::new(at, direction);
                let (_, hit) = asked.cast_ray_and_get_normal(&ray, REACH, true)?;
                Some(hit.time_of_impact)
            }
            Kind::MovedBall => cast(&Ball::new(RADIUS)),
            Kind::MovedBox => cast(&Cuboid::new(0.5 * EDGES)),
            Kind::Nearest => {
                let (_, near) = asked.project_point(at, REACH, true)?;
                Some(near.point.distance(at))
            }
            Kind::Overlap => {
                let cuboid = Cuboid::new(0.5 * EDGES);
                let pose = Pose::from_parts(at, turn);
                Some(asked.intersect_shape(pose, &cuboid).count() as f32)
            }
        }
    }
}
