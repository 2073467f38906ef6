//! Questions to this crate, without an app.

use super::{EDGES, Kind, Oracle, Question, RADIUS, REACH, Site, Thing};
use crate::Error;
use bevy_cleave::prelude::*;
use std::cell::RefCell;

pub(super) struct Ours(Simulation);

/// A view of the bodies, and the shapes that are asked with.
pub(super) struct View<'s> {
    queries: Queries<'s>,
    ball: QueryShape<'static>,
    cuboid: QueryShape<'static>,
    filter: QueryFilter<'static>,
    found: RefCell<Vec<u32>>,
}

impl Ours {
    pub(super) fn new(site: &Site) -> Result<Self, Error> {
        let mut simulation = Simulation::default();
        for (thing, at, turn) in &site.bodies {
            let shape = match thing {
                Thing::Box(size) => ConvexMesh::cuboid(size.x, size.y, size.z)?,
                Thing::Hull(points) => ConvexMesh::from_points(points)?,
                Thing::Ball(radius) => ConvexMesh::sphere(*radius)?,
            };
            simulation.bodies.insert(BodyDesc {
                pose: Pose::new(*at, *turn),
                ..BodyDesc::new(RigidBody::Static, Shape::Convex(shape))
            })?;
        }
        if let Some((heights, columns, spacing)) = &site.level {
            let level = StaticMesh::from_heights(heights, *columns, *spacing)?;
            let mut desc = BodyDesc::level(level);
            (desc.pose.position.x, desc.pose.position.z) = (-site.half, -site.half);
            simulation.bodies.insert(desc)?;
        }
        simulation.step(1.0 / 60.0);
        Ok(Self(simulation))
    }

    pub(super) fn oracle(&mut self) -> View<'_> {
        View {
            queries: self.0.queries(),
            ball: QueryShape::sphere(RADIUS).expect("usable"),
            cuboid: QueryShape::cuboid(EDGES).expect("usable"),
            filter: QueryFilter::all(),
            found: RefCell::default(),
        }
    }
}

impl Oracle for View<'_> {
    fn answer(&self, kind: Kind, question: &Question) -> Option<f32> {
        let Question {
            at,
            direction,
            turn,
        } = *question;
        let cast = |shape| {
            let cast = ShapeCast::new(shape, Pose::new(at, turn), direction, REACH).ok()?;
            let hit = self.queries.cast_shape(&cast, &self.filter)?;
            Some(hit.distance)
        };
        match kind {
            Kind::Ray => {
                let ray = Ray::new(at, direction, REACH).ok()?;
                Some(self.queries.cast_ray(&ray, &self.filter)?.distance)
            }
            Kind::MovedBall => cast(self.ball),
            Kind::MovedBox => cast(self.cuboid),
            Kind::Nearest => {
                let hit = self.queries.closest_point(at, REACH, &self.filter);
                hit.ok()?.map(|hit| hit.distance.max(0.0))
            }
            Kind::Overlap => {
                let found = &mut *self.found.borrow_mut();
                let pose = Pose::new(at, turn);
                let asked = self
                    .queries
                    .overlap_shape(&self.cuboid, &pose, &self.filter, found);
                asked.ok().map(|()| found.len() as f32)
            }
        }
    }
}
