//! The same questions to Avian, as a system asks them.

use super::{EDGES, Kind, Oracle, Question, RADIUS, REACH, Site, Thing};
use crate::Error;
use crate::engines::headless;
use avian3d::prelude::*;
use bevy::ecs::system::SystemState;
use bevy::prelude::*;

pub(super) struct Avian {
    app: App,
    state: SystemState<SpatialQuery<'static, 'static>>,
}

/// A view of the colliders, and the shapes that are asked with.
pub(super) struct View<'w> {
    queries: SpatialQuery<'w, 'w>,
    ball: Collider,
    cuboid: Collider,
    filter: SpatialQueryFilter,
}

impl Avian {
    pub(super) fn new(site: &Site) -> Result<Self, Error> {
        // Its trees are built by tasks that wait for a thread of the pool.
        let mut app = headless::app(1.0 / 60.0, 1);
        app.add_plugins(PhysicsPlugins::new(PostUpdate));
        headless::start(&mut app);
        let world = app.world_mut();
        for (thing, at, turn) in &site.bodies {
            let collider = match thing {
                Thing::Box(size) => Collider::cuboid(size.x, size.y, size.z),
                Thing::Hull(points) => Collider::convex_hull(points).ok_or("no hull")?,
                Thing::Ball(radius) => Collider::sphere(*radius),
            };
            let place = Transform::from_translation(*at).with_rotation(*turn);
            world.spawn((RigidBody::Static, collider, place));
        }
        if let Some((points, triangles)) = site.triangles() {
            world.spawn((RigidBody::Static, Collider::trimesh(points, triangles)));
        }
        // One for the colliders to come, one for their trees.
        app.update();
        app.update();
        let state = SystemState::new(app.world_mut());
        Ok(Self { app, state })
    }

    pub(super) fn oracle(&mut self) -> Result<View<'_>, Error> {
        Ok(View {
            queries: self.state.get(self.app.world())?,
            ball: Collider::sphere(RADIUS),
            cuboid: Collider::cuboid(EDGES.x, EDGES.y, EDGES.z),
            filter: SpatialQueryFilter::default(),
        })
    }
}

impl Oracle for View<'_> {
    fn answer(&self, kind: Kind, question: &Question) -> Option<f32> {
        let Question {
            at,
            direction,
            turn,
        } = *question;
        let along = Dir3::new(direction).ok()?;
        let cast = |shape| {
            let config = ShapeCastConfig::from_max_distance(REACH);
            let hit = self
                .queries
                .cast_shape(shape, at, turn, along, &config, &self.filter)?;
            Some(hit.distance)
        };
        match kind {
            Kind::Ray => {
                let hit = self
                    .queries
                    .cast_ray(at, along, REACH, true, &self.filter)?;
                Some(hit.distance)
            }
            Kind::MovedBall => cast(&self.ball),
            Kind::MovedBox => cast(&self.cuboid),
            Kind::Nearest => {
                let near = self.queries.project_point(at, true, &self.filter)?;
                Some(near.point.distance(at))
            }
            Kind::Overlap => {
                let mut count = 0;
                self.queries.shape_intersections_callback(
                    &self.cuboid,
                    at,
                    turn,
                    &self.filter,
                    |_| {
                        count += 1;
                        true
                    },
                );
                Some(count as f32)
            }
        }
    }
}
