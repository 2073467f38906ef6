//! `Queries::move_and_slide`: a shape that is moved, and goes along what it meets.

use crate::math::Pose;
use crate::query::filter::QueryFilter;
use crate::query::hit::QueryHit;
use crate::query::request::{Ray, ShapeCast};
use crate::query::shape::QueryShape;
use crate::query::view::Queries;
use glam::Vec3;

/// How often a motion is deflected.
const MAX_SLIDES: usize = 6;

/// How often a shape is pushed out of what it overlaps.
const MAX_PUSHES: usize = 6;

/// Least sine of the angle between a motion and what it meets that the skin is kept for: less would stop the motion too early.
const GRAZING: f32 = 0.1;

/// Share of a motion by which one along a surface may lead into it: rounding.
const FREE: f32 = 1e-6;

/// Share of the skin to which a shape is pushed out. Pushed out to all of it, a slow one would never get past what is just below its feet.
const KEPT: f32 = 0.5;

/// A shape that slides.
#[derive(Clone, Copy, Debug)]
pub struct Slider<'s> {
    /// The shape.
    pub shape: QueryShape<'s>,
    /// Gap that is left between the shape and what it meets, m.
    pub skin: f32,
}

/// Where a motion has led.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slid {
    /// Position of the shape's frame, m.
    pub position: Vec3,
    /// What was left of the motion when the last thing was met, along which it could not go on, m; zero if it was made in full.
    pub rest: Vec3,
}

/// What a motion must not run against.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Obstacles {
    normals: [Vec3; MAX_SLIDES],
    count: usize,
}

impl Obstacles {
    /// A motion that goes along what it met before and along this.
    pub(crate) fn deflect(&mut self, motion: Vec3, normal: Vec3) -> Vec3 {
        if self.count < MAX_SLIDES {
            self.normals[self.count] = normal;
            self.count += 1;
        }
        let met = &self.normals[..self.count];
        // By the length of what is deflected: of a motion almost straight against a wall rounding leaves as much as that.
        let slack = FREE * motion.length();
        let is_free = |along: Vec3| met.iter().all(|n| along.dot(*n) >= -slack);
        let along = motion - motion.dot(normal).min(0.0) * normal;
        if is_free(along) {
            return along;
        }
        // Between two of them there is a crease.
        for other in met {
            let crease = normal.cross(*other);
            if let Some(crease) = crease.try_normalize() {
                let along = motion.dot(crease) * crease;
                if is_free(along) {
                    return along;
                }
            }
        }
        Vec3::ZERO
    }
}

impl Queries<'_> {
    /// Moves a shape from `start` by `motion` (m). What it meets on its way deflects it: it goes on along that. `met` gets what it
    /// has met, in order; it is cleared first.
    ///
    /// Nothing is passed through however long the motion is. What the shape overlaps at the start it is pushed out of at first.
    pub fn move_and_slide(
        &self,
        slider: &Slider,
        start: Pose,
        motion: Vec3,
        filter: &QueryFilter,
        met: &mut Vec<QueryHit>,
    ) -> Slid {
        met.clear();
        let mut pose = start;
        pose.position = self.push_out(slider, start, filter);
        let (mut rest, mut obstacles) = (motion, Obstacles::default());
        for _ in 0..MAX_SLIDES {
            let (moved, hit) = self.advance(slider, &pose, rest, filter);
            pose.position += moved;
            rest -= moved;
            let Some(hit) = hit else {
                break;
            };
            rest = obstacles.deflect(rest, hit.normal);
            met.push(hit);
            if rest == Vec3::ZERO || rest.dot(motion) <= 0.0 {
                rest = Vec3::ZERO;
                break;
            }
        }
        Slid {
            position: pose.position,
            rest,
        }
    }

    /// How far a shape gets along a motion, and what it meets then.
    pub(crate) fn advance(
        &self,
        slider: &Slider,
        pose: &Pose,
        motion: Vec3,
        filter: &QueryFilter,
    ) -> (Vec3, Option<QueryHit>) {
        let length = motion.length();
        let reach = length + slider.skin / GRAZING;
        let Ok(cast) = ShapeCast::new(slider.shape, *pose, motion, reach) else {
            return (Vec3::ZERO, None);
        };
        let Some(hit) = self.cast_shape(&cast, filter) else {
            return (motion, None);
        };
        let against = (-cast.direction.dot(hit.normal)).max(GRAZING);
        let way = (hit.distance - slider.skin / against).max(0.0);
        if way >= length {
            return (motion, None);
        }
        (way * cast.direction, Some(hit))
    }

    /// Where a shape is when it has been pushed out of what it overlaps, as far as that goes.
    pub(crate) fn push_out(&self, slider: &Slider, pose: Pose, filter: &QueryFilter) -> Vec3 {
        let mut pose = pose;
        let mut near = Vec::new();
        for _ in 0..MAX_PUSHES {
            let kept = KEPT * slider.skin;
            let found = self.near_shape(&slider.shape, &pose, kept, filter, &mut near);
            let push: Vec3 = near
                .iter()
                .map(|hit| (kept - hit.distance, hit.normal))
                .filter(|(depth, _)| *depth > 1e-3 * slider.skin)
                .map(|(depth, normal)| depth * normal)
                .fold(Vec3::ZERO, |sum, push| {
                    // What is pushed that way already is not pushed twice.
                    let done = push.try_normalize().map_or(0.0, |n| sum.dot(n).max(0.0));
                    sum + push.normalize_or_zero() * (push.length() - done).max(0.0)
                });
            if found.is_err() || push == Vec3::ZERO {
                break;
            }
            pose.position += self.kept_before_surfaces(slider, &pose, push, filter);
        }
        pose.position
    }

    /// A push by which the middle of a shape gets into nothing: what is pushed out of one body comes behind no other.
    fn kept_before_surfaces(
        &self,
        slider: &Slider,
        pose: &Pose,
        push: Vec3,
        filter: &QueryFilter,
    ) -> Vec3 {
        let middle = slider.shape.bounds(pose).center();
        let length = push.length();
        let Ok(ray) = Ray::new(middle, push, length) else {
            return push;
        };
        let mut hits = Vec::new();
        self.cast_ray_all(&ray.hollow(), filter, &mut hits);
        let enters = |hit: &&QueryHit| hit.normal.dot(push) < 0.0;
        let first = hits.iter().find(enters).map(|hit| hit.distance);
        first.map_or(push, |distance| {
            (distance - slider.skin).max(0.0) / length * push
        })
    }
}
