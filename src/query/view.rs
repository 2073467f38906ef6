//! `Queries`: all questions that can be asked of the bodies as they are now.

use crate::bodies::store::Bodies;
use crate::contact::pairs::broad_phase::Broadphase;
use crate::geometry::bvh::{RayWalk, along_ray, around, within};
use crate::math::{Aabb, Pose};
use crate::query::ball::{Ball, NOWHERE};
use crate::query::error::{QueryError, check_length, check_point, check_pose};
use crate::query::filter::QueryFilter;
use crate::query::hit::QueryHit;
use crate::query::index::QueryIndex;
use crate::query::request::{Ray, ShapeCast};
use crate::query::shape::QueryShape;
use crate::query::target::Target;
use crate::query::waiting::Waiting;
use glam::{Quat, Vec3};

/// A read-only view of the bodies that answers questions. Cheap to copy, and good for several threads at once.
///
/// Distances and places are good to 1e-5 of the lengths that go into them: the body, the shape, how far away it is asked.
#[derive(Clone, Copy, Debug)]
pub struct Queries<'q> {
    bodies: &'q Bodies,
    broadphase: &'q Broadphase,
    index: &'q QueryIndex,
}

impl<'q> Queries<'q> {
    /// A view, of an index that was refreshed since the bodies changed.
    pub(crate) fn new(
        bodies: &'q Bodies,
        broadphase: &'q Broadphase,
        index: &'q QueryIndex,
    ) -> Self {
        Self {
            bodies,
            broadphase,
            index,
        }
    }

    /// The bodies that are asked.
    pub fn bodies(&self) -> &'q Bodies {
        self.bodies
    }

    /// The first body that a ray hits, at the place where it does so first.
    pub fn cast_ray(&self, ray: &Ray, filter: &QueryFilter) -> Option<QueryHit> {
        let mut best: Option<QueryHit> = None;
        let (way, ball) = Way::of_ray(ray);
        self.along(way, |slot, end| {
            let target = self.target(slot, filter, ball, (ray.direction, end))?;
            keep_first(&mut best, target.cast_ray(ray, end)?)
        });
        best
    }

    /// All bodies that a ray hits, each once, where it does so first, from near to far. `hits` is cleared first.
    pub fn cast_ray_all(&self, ray: &Ray, filter: &QueryFilter, hits: &mut Vec<QueryHit>) {
        hits.clear();
        let (way, ball) = Way::of_ray(ray);
        self.along(way, |slot, end| {
            let target = self.target(slot, filter, ball, (ray.direction, end))?;
            hits.extend(target.cast_ray(ray, end));
            None
        });
        settle(hits);
    }

    /// Whether a ray hits anything.
    pub fn is_ray_blocked(&self, ray: &Ray, filter: &QueryFilter) -> bool {
        let mut is_blocked = false;
        let (way, ball) = Way::of_ray(ray);
        self.along(way, |slot, end| {
            let target = self.target(slot, filter, ball, (ray.direction, end))?;
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
        self.along(way, |slot, end| {
            let target = self.target(slot, filter, ball, (cast.direction, end))?;
            keep_first(&mut best, target.cast_shape(cast, touch, end)?)
        });
        best
    }

    /// All bodies that a moved shape touches, each once, where it does so first, from near to far. `hits` is cleared first.
    pub fn cast_shape_all(&self, cast: &ShapeCast, filter: &QueryFilter, hits: &mut Vec<QueryHit>) {
        hits.clear();
        let (way, ball, touch) = Way::of_cast(cast);
        self.along(way, |slot, end| {
            let target = self.target(slot, filter, ball, (cast.direction, end))?;
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
        self.inside(&bounds, |slot| {
            if let Some(target) = self.target(slot, filter, ball, NOWHERE)
                && target.overlaps(shape, pose)
            {
                found.push(slot);
            }
        });
        found.sort_unstable_by_key(|&slot| self.bodies.id(slot));
        found.dedup();
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
        let mut waiting = Waiting::default();
        self.near(point, max_distance, |slot, limit| {
            let within = Ball {
                center: point,
                radius: limit,
            };
            let target = self.target(slot, filter, within, NOWHERE)?;
            let ball = Ball::of(self.bodies, slot);
            match ball.map(|ball| ball.distances_from(point)) {
                Some([least, most]) if waiting.has_room() => {
                    waiting.add(least, slot);
                    (most < limit).then_some(most)
                }
                _ => keep_first(&mut best, target.closest(point, limit)?),
            }
        })?;
        for &(least, slot) in waiting.nearest_first() {
            let limit = best.map_or(max_distance, |best| best.distance);
            if least > limit {
                break;
            }
            let target = Target::of(self.bodies, slot);
            let found = target.closest(point, limit.max(0.0));
            found.and_then(|hit| keep_first(&mut best, hit));
        }
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
        self.near(point, radius, |slot, _| {
            let target = self.target(slot, filter, within, NOWHERE)?;
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
        self.inside(&region, |slot| {
            if let Some(target) = self.target(slot, filter, ball, NOWHERE) {
                hits.extend(target.nearest_to(shape, pose, max_distance));
            }
        });
        settle(hits);
        Ok(())
    }

    /// The body in a slot, if it is there, counts, and is not surely off a ball all along a direction for a length (m).
    #[inline]
    fn target(
        &self,
        slot: u32,
        filter: &QueryFilter,
        ball: Ball,
        way: (Vec3, f32),
    ) -> Option<Target<'q>> {
        let body = Ball::of(self.bodies, slot);
        let counts = body.is_none_or(|body| ball.may_reach(&body, way))
            && self.bodies.is_active(slot)
            && filter.accepts(self.bodies, slot);
        counts.then(|| Target::of(self.bodies, slot))
    }

    /// Visits what may lie along a way; some of it twice. `visit` may shorten the way.
    fn along(&self, way: Way, mut visit: impl FnMut(u32, f32) -> Option<f32>) {
        let mut end = way.length;
        for &slot in self.index.half_spaces() {
            end = visit(slot, end).unwrap_or(end);
        }
        along_ray(self.index.tree(), way.walk, end, |leaf, now| {
            end = visit(self.index.strays()[leaf as usize], now).unwrap_or(now);
            end
        });
        along_ray(self.broadphase.tree(), way.walk, end, |slot, now| {
            visit(slot, now).unwrap_or(now)
        });
    }

    /// Visits what may lie in a box; some of it twice.
    fn inside(&self, b: &Aabb, mut visit: impl FnMut(u32)) {
        self.index
            .half_spaces()
            .iter()
            .for_each(|&slot| visit(slot));
        within(self.index.tree(), b, |leaf| {
            visit(self.index.strays()[leaf as usize]);
        });
        within(self.broadphase.tree(), b, visit);
    }

    /// Visits what may be near a point; some of it twice. `visit` may shorten the distance; what holds the point is visited
    /// all the same.
    fn near(
        &self,
        point: Vec3,
        max_distance: f32,
        mut visit: impl FnMut(u32, f32) -> Option<f32>,
    ) -> Result<(), QueryError> {
        check_point("the point", point)?;
        check_length("the distance", max_distance)?;
        let mut limit = max_distance;
        let mut shorten = |slot: u32, now: f32| visit(slot, now).map_or(now, |new| new.max(0.0));
        for &slot in self.index.half_spaces() {
            limit = shorten(slot, limit);
        }
        around(self.index.tree(), point, limit, |leaf, now| {
            limit = shorten(self.index.strays()[leaf as usize], now);
            limit
        });
        around(self.broadphase.tree(), point, limit, shorten);
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

/// Puts hits in order, each body once.
fn settle(hits: &mut Vec<QueryHit>) {
    hits.sort_unstable_by(QueryHit::order);
    hits.dedup_by_key(|hit| hit.id);
}
