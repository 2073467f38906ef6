//! Fracture patterns: which planes an impact cuts a body by, and in which order.
//!
//! The same pattern, impact, hull and seed give the same planes, bit for bit, on every platform: the generator's stream
//! is fixed, and random directions are found by rejection, without trigonometry.

use crate::geometry::ConvexHull;
use crate::math::{Plane, tangents};
use glam::{Vec2, Vec3};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg32;
use smallvec::SmallVec;

/// How far [`FracturePattern::RandomPlane`] goes from the impact towards the centre of the body's box, as a fraction.
///
/// A plane through a point inside the hull cuts it whatever the plane's direction; a plane through the impact itself,
/// which is on the surface, may only graze it.
const RANDOM_DEPTH: f32 = 0.5;

/// Largest turn of a plane of [`FracturePattern::Star`] away from even spacing, as a fraction of the spacing.
const STAR_JITTER: f32 = 0.6;

/// Most planes of a star; more pieces than that meet at one line as needles.
const STAR_MAX_PLANES: u8 = 8;

/// A blow to a body, in the body's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Point of contact, m.
    pub point: Vec3,
    /// Unit direction of the impulse.
    pub normal: Vec3,
    /// Size of the impulse, N s.
    pub impulse: f32,
}

/// The planes of an impact; up to eight without memory of its own.
pub type Planes = SmallVec<[Plane; 8]>;

/// How a body breaks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
#[non_exhaustive]
pub enum FracturePattern {
    /// One plane through the point of contact that contains the direction of the blow, across the longest direction of
    /// the body's box: its normal is the part of that direction which is perpendicular to the blow.
    ///
    /// Source: "Constraint-Based Physics With Real-Time Object Slicing".
    #[default]
    SinglePlane,
    /// One plane with a random direction, through the middle between the point of contact and the centre of the body's
    /// box, so that it cuts the body.
    RandomPlane,
    /// Planes that contain the line of the blow, spaced evenly about it with a random jitter.
    Star {
        /// Number of planes, 1 to 8; numbers outside are moved to the nearer end.
        planes: u8,
    },
}

impl FracturePattern {
    /// The planes (body frame) that `impact` cuts `hull` by.
    ///
    /// Empty if the impact is not finite or has no direction where the pattern needs one.
    pub fn planes(&self, impact: &Impact, hull: &ConvexHull, seed: u64) -> Planes {
        let Some(direction) = impact.normal.try_normalize() else {
            return Planes::new();
        };
        if !impact.point.is_finite() {
            return Planes::new();
        }
        let mut random = Pcg32::seed_from_u64(seed);
        match *self {
            Self::SinglePlane => single_plane(impact.point, direction, hull),
            Self::RandomPlane => random_plane(impact.point, hull, &mut random),
            Self::Star { planes } => star(
                impact.point,
                direction,
                hull,
                planes.clamp(1, STAR_MAX_PLANES),
                &mut random,
            ),
        }
    }
}

/// The plane through `point` and the line of the blow whose normal is nearest to the longest axis of the box.
fn single_plane(point: Vec3, direction: Vec3, hull: &ConvexHull) -> Planes {
    Planes::from_iter([Plane::through(point, across(direction, hull))])
}

/// The unit vector perpendicular to `direction` that is nearest to the longest axis of the hull's box, or, if the blow
/// runs along that axis, to the next longest.
fn across(direction: Vec3, hull: &ConvexHull) -> Vec3 {
    let extents = hull.aabb().extents();
    let mut axes = [Vec3::X, Vec3::Y, Vec3::Z];
    axes.sort_by(|a, b| extents.dot(*b).total_cmp(&extents.dot(*a)));
    axes.into_iter()
        .map(|axis| axis - axis.dot(direction) * direction)
        // Three axes cannot all be within 45 degrees of one direction, so one of them leaves half its square.
        .find(|part| part.length_squared() >= 0.5)
        .map_or(tangents(direction)[0], Vec3::normalize)
}

/// A plane of random direction through a point inside.
fn random_plane(point: Vec3, hull: &ConvexHull, random: &mut Pcg32) -> Planes {
    let inside = point.lerp(hull.aabb().centre(), RANDOM_DEPTH);
    Planes::from_iter([Plane::through(inside, unit_vector(random))])
}

/// Planes through the line of the blow: even steps of half a turn, each with a jitter.
fn star(point: Vec3, direction: Vec3, hull: &ConvexHull, count: u8, random: &mut Pcg32) -> Planes {
    let u = across(direction, hull);
    let v = direction.cross(u);
    (0..count)
        .map(|index| {
            let jitter = STAR_JITTER * (unit_interval(random) - 0.5);
            let turn = half_turn((f32::from(index) + jitter) / f32::from(count));
            Plane::through(point, turn.x * u + turn.y * v)
        })
        .collect()
}

/// The unit vector at about `fraction` of half a turn from `(1, 0)`.
///
/// On each quarter turn it is the point `(1 - s^2, 2 s) / (1 + s^2)` of the circle with `s` from 0 to 1, whose angle
/// `2 atan s` is within 8.2 degrees of `90 s`.
fn half_turn(fraction: f32) -> Vec2 {
    let quarters = 2.0 * fraction;
    let quarter = quarters.floor();
    let s = quarters - quarter;
    let within = Vec2::new(1.0 - s * s, 2.0 * s) / (1.0 + s * s);
    // A normal and its opposite are the same plane cut, so only the parity of the quarter counts.
    if quarter as i32 % 2 == 0 {
        within
    } else {
        within.perp()
    }
}

/// A number from [0, 1), a multiple of 2^-24.
fn unit_interval(random: &mut Pcg32) -> f32 {
    (random.next_u32() >> 8) as f32 / 16_777_216.0
}

/// A unit vector, all directions alike: the first random point of a cube that falls into the unit ball, scaled.
fn unit_vector(random: &mut Pcg32) -> Vec3 {
    loop {
        let [x, y, z] = std::array::from_fn(|_| 2.0 * unit_interval(random) - 1.0);
        let point = Vec3::new(x, y, z);
        let square = point.length_squared();
        // Too near the middle the direction is rounding error.
        if (1.0e-4..=1.0).contains(&square) {
            return point / square.sqrt();
        }
    }
}
