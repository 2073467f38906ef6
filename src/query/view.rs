//! `Queries`: all questions that can be asked of the bodies as they are now.

use crate::bodies::store::Bodies;
use crate::geometry::bvh::RayWalk;
use crate::math::{Aabb, Pose};
use crate::query::ball::{Ball, NOWHERE};
use crate::query::error::{QueryError, check_length, check_point, check_pose};
use crate::query::filter::QueryFilter;
use crate::query::hit::QueryHit;
use crate::query::index::QueryIndex;
use crate::query::movers::KinematicMovers;
use crate::query::place::Place;
use crate::query::request::{Ray, ShapeCast};
use crate::query::shape::QueryShape;
use crate::query::target::Target;
use glam::{Quat, Vec3};

/// A read-only view of the bodies that answers questions. Cheap to copy, and good for several threads at once.
///
/// Distances and places are good to 1e-5 of the lengths that go into them: the body, the shape, how far away it is asked.
#[derive(Clone, Copy, Debug)]
pub struct Queries<'q> {
    bodies: &'q Bodies,
    index: &'q QueryIndex,
    is_current: bool,
    /// Bodies that are looked for elsewhere than where they are.
    ahead: &'q [Place],
}

impl QueryIndex {
    /// A view of the bodies, for which the index was refreshed since they changed.
    pub fn queries<'q>(&'q self, bodies: &'q Bodies) -> Queries<'q> {
        Queries {
            bodies,
            index: self,
            is_current: self.is_current(bodies),
            ahead: &[],
        }
    }
}

impl<'q> Queries<'q> {
    /// The bodies that are asked.
    pub fn bodies(&self) -> &'q Bodies {
        self.bodies
    }

    /// The same view with some bodies at other places.
    pub(crate) fn with_ahead<'a>(&self, ahead: &'a [Place]) -> Queries<'a>
    where
        'q: 'a,
    {
        let shorter: Queries<'a> = *self;
        Queries { ahead, ..shorter }
    }

    /// The kinematic bodies that move, if they are still those of when it was asked for them first.
    pub(crate) fn kinematic_movers(&self) -> Option<&'q KinematicMovers> {
        self.index.movers(self.bodies)
    }

    /// Visits the bodies in a box.
    pub(crate) fn inside(&self, b: &Aabb, mut visit: impl FnMut(u32)) {
        self.index.inside(b, |place| {
            if place.is_taken(self.bodies) {
                visit(place.slot);
            }
        });
    }

    /// The first body that a ray hits, at the place where it does so first.
    pub fn cast_ray(&self, ray: &Ray, filter: &QueryFilter) -> Option<QueryHit> {
        let mut best: Option<QueryHit> = None;
        let (way, ball) = Way::of_ray(ray);
        self.along(way, |place, end| {
            let target = self.target(place, filter, ball, (ray.direction, end))?;
            keep_first(&mut best, target.cast_ray(ray, end)?)
        });
        best
    }

    /// All bodies that a ray hits, each once, where it does so first, from near to far. `hits` is cleared first.
    pub fn cast_ray_all(&self, ray: &Ray, filter: &QueryFilter, hits: &mut Vec<QueryHit>) {
        hits.clear();
        let (way, ball) = Way::of_ray(ray);
        self.along(way, |place, end| {
            let target = self.target(place, filter, ball, (ray.direction, end))?;
            hits.extend(target.cast_ray(ray, end));
            None
        });
        settle(hits);
    }

    /// Whether a ray hits anything.
    pub fn is_ray_blocked(&self, ray: &Ray, filter: &QueryFilter) -> bool {
        let mut is_blocked = false;
        let (way, ball) = Way::of_ray(ray);
        self.along(way, |place, end| {
            let target = self.target(place, filter, ball, (ray.direction, end))?;
            let hit = target.cast_ray(ray, end);
            is_blocked |= hit.is_some();
            hit.map(|_| STOP)
        });
        is_blocked
    }

    /// The first body that a moved shape touches, and where.
    pub fn cast_shape(&self, cast: &ShapeCast, filter: &QueryFilter) -> Option<QueryHit> {
        let mut best: Option<QueryHit> = None;
        let (way, ball, touch) = Way::of_cast(cast);
        self.along(way, |place, end| {
            let target = self.target(place, filter, ball, (cast.direction, end))?;
            keep_first(&mut best, target.cast_shape(cast, touch, end)?)
        });
        best
    }

    /// All bodies that a moved shape touches, each once, where it does so first, from near to far. `hits` is cleared first.
    pub fn cast_shape_all(&self, cast: &ShapeCast, filter: &QueryFilter, hits: &mut Vec<QueryHit>) {
        hits.clear();
        let (way, ball, touch) = Way::of_cast(cast);
        self.along(way, |place, end| {
            let target = self.target(place, filter, ball, (cast.direction, end))?;
            hits.extend(target.cast_shape(cast, touch, end));
            None
        });
        settle(hits);
    }

    /// The bodies that a shape at a pose (world frame) overlaps or touches, by id. `found` is cleared first.
    ///
    /// # Errors
    /// [`QueryError`] if the pose is not finite or not a rotation.
    pub fn overlap_shape(
        &self,
        shape: &QueryShape,
        pose: &Pose,
        filter: &QueryFilter,
        found: &mut Vec<u32>,
    ) -> Result<(), QueryError> {
        check_pose(pose)?;
        found.clear();
        let bounds = shape.bounds(pose);
        let ball = shape.ball(pose, &bounds);
        self.near_box(&bounds, |place| {
            if let Some(target) = self.target(place, filter, ball, NOWHERE)
                && target.overlaps(shape, pose)
            {
                found.push(place.slot);
            }
        });
        found.sort_unstable_by_key(|&slot| self.bodies.id(slot));
        Ok(())
    }

    /// The bodies that overlap or touch a box along the axes of the world, by id. `found` is cleared first.
    ///
    /// # Errors
    /// [`QueryError`] if the box is not finite, or has no corner.
    pub fn overlap_box(
        &self,
        b: &Aabb,
        filter: &QueryFilter,
        found: &mut Vec<u32>,
    ) -> Result<(), QueryError> {
        check_point("the corner", b.min)?;
        check_point("the corner", b.max)?;
        check_length("the edge", b.extents().min_element())?;
        let pose = Pose::new(b.center(), Quat::IDENTITY);
        self.overlap_shape(&QueryShape::of_extents(b.extents()), &pose, filter, found)
    }

    /// The place on a body's surface that is nearest to a point, if one is within `max_distance` (m). In a body, its distance is
    /// negative, and the body that it is deepest in comes first.
    ///
    /// # Errors
    /// [`QueryError`] if the point is not finite or the distance negative.
    pub fn closest_point(
        &self,
        point: Vec3,
        max_distance: f32,
        filter: &QueryFilter,
    ) -> Result<Option<QueryHit>, QueryError> {
        let mut best: Option<QueryHit> = None;
        self.near(point, max_distance, |place, limit| {
            let within = Ball {
                center: point,
                radius: limit,
            };
            let target = self.target(place, filter, within, NOWHERE)?;
            keep_first(&mut best, target.closest(point, limit)?)
        })?;
        Ok(best)
    }

    /// The bodies that come within `radius` (m) of a point, with their nearest places, from near to far. `hits` is cleared first.
    ///
    /// # Errors
    /// [`QueryError`] if the point is not finite or the radius negative.
    pub fn within_radius(
        &self,
        point: Vec3,
        radius: f32,
        filter: &QueryFilter,
        hits: &mut Vec<QueryHit>,
    ) -> Result<(), QueryError> {
        hits.clear();
        let within = Ball {
            center: point,
            radius,
        };
        self.near(point, radius, |place, _| {
            let target = self.target(place, filter, within, NOWHERE)?;
            hits.extend(target.closest(point, radius));
            None
        })?;
        settle(hits);
        Ok(())
    }

    /// The bodies that come within `max_distance` (m) of a shape at a pose, with the places on them that are nearest to it, from near
    /// to far; distances are negative where they overlap. `hits` is cleared first.
    ///
    /// # Errors
    /// [`QueryError`] if the pose is not finite or not a rotation, or the distance negative.
    pub fn near_shape(
        &self,
        shape: &QueryShape,
        pose: &Pose,
        max_distance: f32,
        filter: &QueryFilter,
        hits: &mut Vec<QueryHit>,
    ) -> Result<(), QueryError> {
        check_pose(pose)?;
        check_length("the distance", max_distance)?;
        hits.clear();
        let region = shape.bounds(pose).fattened(max_distance);
        let ball = Ball::around(&region);
        self.near_box(&region, |place| {
            if let Some(target) = self.target(place, filter, ball, NOWHERE) {
                hits.extend(target.nearest_to(shape, pose, max_distance));
            }
        });
        settle(hits);
        Ok(())
    }

    /// The body at a place, if it is there, counts, and is not surely off a ball all along a direction for a length (m).
    #[inline]
    fn target(
        &self,
        place: &'q Place,
        filter: &QueryFilter,
        ball: Ball,
        way: (Vec3, f32),
    ) -> Option<Target<'q>> {
        let body = place.ball();
        let may_meet = body.is_none_or(|body| ball.may_reach(&body, way));
        let is_there = || self.is_current && !place.is_empty() || place.is_taken(self.bodies);
        let is_elsewhere = |other: &Place| other.slot == place.slot && !std::ptr::eq(other, place);
        let is_here = || !self.ahead.iter().any(is_elsewhere);
        let counts = || filter.is_open() || filter.accepts(self.bodies, place.slot);
        (may_meet && is_there() && is_here() && counts()).then(|| Target::at(place))
    }

    /// Visits what may lie in a box.
    fn near_box(&self, b: &Aabb, mut visit: impl FnMut(&'q Place)) {
        self.ahead.iter().for_each(&mut visit);
        self.index.inside(b, visit);
    }

    /// Visits what may lie along a way. `visit` may shorten the way.
    fn along(&self, way: Way, mut visit: impl FnMut(&'q Place, f32) -> Option<f32>) {
        let mut end = way.length;
        for place in self.ahead {
            end = visit(place, end).unwrap_or(end);
        }
        self.index
            .along(way.walk, end, |place, end| visit(place, end).unwrap_or(end));
    }

    /// Visits what may be near a point. `visit` may shorten the distance; what holds the point is visited all the same.
    fn near(
        &self,
        point: Vec3,
        max_distance: f32,
        mut visit: impl FnMut(&'q Place, f32) -> Option<f32>,
    ) -> Result<(), QueryError> {
        check_point("the point", point)?;
        check_length("the distance", max_distance)?;
        let mut step = |place, now: f32| visit(place, now).map_or(now, |new| new.max(0.0));
        let mut now = max_distance;
        for place in self.ahead {
            now = step(place, now);
        }
        self.index.near(point, now, step);
        Ok(())
    }
}

/// Gap at which a moved shape touches, as a share of the shape's diagonal, m.
const TOUCH: f32 = 2e-6;

/// An end before all others.
const STOP: f32 = -1.0;

/// The way of a ray or a moved box.
#[derive(Clone, Copy, Debug)]
struct Way {
    walk: RayWalk,
    length: f32,
}

impl Way {
    /// And a ball around where it starts.
    fn of_ray(ray: &Ray) -> (Self, Ball) {
        let (min, max) = (Vec3::ZERO, Vec3::ZERO);
        let way = Self {
            walk: RayWalk::new(ray.origin, ray.direction, Aabb { min, max }),
            length: ray.max_distance,
        };
        let ball = Ball {
            center: ray.origin,
            radius: 0.0,
        };
        (way, ball)
    }

    /// The same of a shape, with room for a gap that counts as none, and that gap (m).
    fn of_cast(cast: &ShapeCast) -> (Self, Ball, f32) {
        let b = cast.shape.bounds(&cast.pose);
        let origin = b.center();
        let about = Aabb {
            min: b.min - origin,
            max: b.max - origin,
        };
        let way = Self {
            walk: RayWalk::new(origin, cast.direction, about),
            length: cast.max_distance,
        };
        let ball = Ball::around(&b);
        let touch = 2.0 * TOUCH * ball.radius;
        let radius = ball.radius + touch;
        (way, Ball { radius, ..ball }, touch)
    }
}

/// Keeps a hit if it comes first; its distance then.
fn keep_first(best: &mut Option<QueryHit>, hit: QueryHit) -> Option<f32> {
    let is_first = hit.comes_before(best.as_ref());
    is_first.then(|| best.insert(hit).distance)
}

/// Puts hits in order.
fn settle(hits: &mut [QueryHit]) {
    hits.sort_unstable_by(QueryHit::order);
}
