//! Polyhedra that stand for round shapes where they are cut or drawn. Their corners are on the surface of the shape.

use crate::geometry::ConvexHull;
use crate::geometry::frustum::Frustum;
use crate::geometry::hull_error::HullError;
use crate::geometry::primitives::{check_count, icosphere_directions, unit_circle};
use crate::geometry::round_core::RoundCore;
use crate::geometry::support::Core;
use glam::{DVec3, Vec3};
use std::ops::RangeInclusive;

/// How many sides the polygon may have that stands for a whole circle.
pub const RESOLUTIONS: RangeInclusive<u32> = 8..=96;

/// Sides unless others are asked for.
pub(crate) const RESOLUTION: u32 = 24;

/// Sides around an icosphere without subdivisions, more or less.
const ICOSAHEDRON_SIDES: f64 = 5.7;

/// The polyhedron of all within `radius` (m) of a core; a whole circle has `sides`.
pub(crate) fn of(core: &RoundCore, radius: f32, sides: u32) -> Result<ConvexHull, HullError> {
    check_count("resolution", sides, &RESOLUTIONS)?;
    let points = match core {
        RoundCore::Point => sphere(radius, sides),
        RoundCore::Segment(half) => capsule(radius, *half, sides),
        RoundCore::Frustum(frustum) => rims(frustum, sides),
        RoundCore::Hull(hull) => around(hull, radius, sides),
    };
    ConvexHull::from_points(&points)
}

/// Directions of an icosphere that has about so many sides around.
fn directions(sides: u32) -> Vec<DVec3> {
    let is_fine = |k: &u32| ICOSAHEDRON_SIDES * f64::from(1_u32 << k) >= 0.8 * f64::from(sides);
    icosphere_directions((0..4).find(is_fine).unwrap_or(4))
}

fn sphere(radius: f32, sides: u32) -> Vec<Vec3> {
    let directions = directions(sides).into_iter();
    directions
        .map(|d| (f64::from(radius) * d).as_vec3())
        .collect()
}

/// Rings about y, and the two poles.
fn capsule(radius: f32, half: f32, sides: u32) -> Vec<Vec3> {
    // A quarter of the outline has a whole number of sides.
    let sides = 4 * sides.div_ceil(4);
    let (radius, half) = (f64::from(radius), f64::from(half));
    let mut points = vec![
        (half + radius) as f32 * Vec3::Y,
        -(half + radius) as f32 * Vec3::Y,
    ];
    for ring in 0..sides / 4 {
        let outline = unit_circle(ring, sides);
        for k in 0..sides {
            let around = radius * outline.x * unit_circle(k, sides);
            let level = half + radius * outline.y;
            let at = |y: f64| DVec3::new(around.x, y, around.y).as_vec3();
            points.extend([at(level), at(-level)]);
        }
    }
    points
}

fn rims(frustum: &Frustum, sides: u32) -> Vec<Vec3> {
    let discs = [0, 1].map(|k| (f64::from(frustum.radii[k]), frustum.levels[k]));
    let mut points = Vec::new();
    for (radius, level) in discs {
        if radius == 0.0 {
            points.push(level * Vec3::Y);
            continue;
        }
        points.extend((0..sides).map(|k| {
            let at = radius * unit_circle(k, sides);
            Vec3::new(at.x as f32, level, at.y as f32)
        }));
    }
    points
}

/// The faces moved outwards, arcs at both ends of the edges, and what of a sphere is at the corners.
fn around(hull: &ConvexHull, radius: f32, sides: u32) -> Vec<Vec3> {
    let core = Core::of_hull(hull);
    let mut points = Vec::new();
    for face in hull.faces() {
        let outline = hull.face_loop(face).iter();
        points.extend(outline.map(|&v| hull.vertices()[v as usize] + radius * face.plane.normal));
    }
    for edge in hull.edges() {
        let [a, b] = edge.faces.map(|f| hull.faces()[f as usize].plane.normal);
        // As many sides as the chord of the angle has, which is not more than a tenth less than the arc.
        let steps =
            (f64::from(sides) * f64::from(a.distance(b)) / std::f64::consts::TAU).ceil() as u32;
        for k in 1..steps {
            let share = k as f32 / steps as f32;
            let out = radius * a.lerp(b, share).normalize_or(a);
            points.extend(edge.vertices.map(|v| hull.vertices()[v as usize] + out));
        }
    }
    for direction in directions(sides) {
        let direction = direction.as_vec3();
        points.push(core.support(direction) + radius * direction);
    }
    points
}
