//! Rays, moved shapes and points against a hull, in the hull's frame.
//!
//! # References
//! M. Cyrus, J. Beck, "Generalized Two- and Three-Dimensional Clipping", Computers and Graphics 3(1), 1978: a ray is cut by plane
//! after plane.

use crate::geometry::ConvexHull;
use crate::geometry::distance::{CoreCast, Nearest, Separation, distance_from};
use crate::geometry::hull_lanes::{LANES, Planes4, lowest_height};
use crate::geometry::support::{Core, PlacedCore};
use crate::query::cuboid::{Cuboid, Told, box_of, nearest_of_box};
use crate::query::local::{LocalCast, LocalHit, LocalRay};
use glam::{DVec3, Vec3};

/// Rounding of a point's height over a plane, as a share of coordinates.
const FOOT: f32 = 3e-7;

/// Where a ray passes the planes of a hull.
#[derive(Clone, Copy)]
struct Passage {
    enters: f32,
    leaves: f32,
    /// The faces there.
    faces: [usize; 2],
}

impl Passage {
    /// None if the line of the ray misses the hull.
    fn of(hull: &ConvexHull, ray: &LocalRay) -> Option<Self> {
        let mut passage = Self {
            enters: f32::NEG_INFINITY,
            leaves: f32::INFINITY,
            faces: [usize::MAX; 2],
        };
        for (group, planes) in hull.lanes.planes.iter().enumerate() {
            let heights = planes.heights(ray.origin);
            let rates = planes.normals.along(ray.direction);
            let mut times = [0.0; LANES];
            for l in 0..LANES {
                times[l] = -heights[l] / rates[l];
            }
            for l in 0..LANES {
                let (height, rate, at) = (heights[l], rates[l], times[l]);
                // From above the plane the ray has to come down to it.
                if height > 0.0 && (rate >= 0.0 || at > ray.end) {
                    return None;
                }
                if rate < 0.0 && at > passage.enters {
                    (passage.enters, passage.faces[0]) = (at, group * LANES + l);
                }
                if rate > 0.0 && at < passage.leaves {
                    (passage.leaves, passage.faces[1]) = (at, group * LANES + l);
                }
            }
            if passage.enters > passage.leaves {
                return None;
            }
        }
        Some(passage)
    }
}

pub(crate) fn cast_ray(hull: &ConvexHull, ray: &LocalRay) -> Option<LocalHit> {
    let Passage {
        enters,
        leaves,
        faces: [front, back],
    } = Passage::of(hull, ray)?;
    let (distance, face) = if enters > 0.0 {
        (enters, front)
    } else if leaves < 0.0 {
        return None;
    } else if ray.is_solid {
        return Some(ray.inside());
    } else {
        (leaves.max(0.0), back)
    };
    let plane = hull.faces().get(face)?.plane;
    (distance <= ray.end).then(|| LocalHit {
        point: ray.origin + distance * ray.direction,
        normal: plane.normal,
        distance,
        part: 0,
        triangle: None,
        face: Some(face as u32),
    })
}

/// The largest of what planes come to, and the first face of which it is.
#[inline]
fn largest(hull: &ConvexHull, of: impl Fn(&Planes4) -> [f32; LANES]) -> (f32, usize) {
    let (mut most, mut groups) = ([f32::NEG_INFINITY; LANES], [0_u32; LANES]);
    for (group, planes) in (0..).zip(&hull.lanes.planes) {
        let of_group = of(planes);
        for l in 0..LANES {
            let is_more = of_group[l] > most[l];
            most[l] = if is_more { of_group[l] } else { most[l] };
            groups[l] = if is_more { group } else { groups[l] };
        }
    }
    let mut best = (f32::NEG_INFINITY, 0);
    for l in 0..LANES {
        let face = groups[l] as usize * LANES + l;
        if most[l] > best.0 || most[l] == best.0 && face < best.1 {
            best = (most[l], face);
        }
    }
    best
}

/// The face that a point on the hull's surface lies on; of several, the one that looks most along `normal`.
fn face_at(hull: &ConvexHull, point: Vec3, normal: Vec3) -> Option<u32> {
    let slack = 1e-5 * hull.aabb().diagonal();
    let (most, face) = largest(hull, |planes| {
        let (heights, mut along) = (planes.heights(point), planes.normals.along(normal));
        for l in 0..LANES {
            along[l] = if heights[l] >= -slack {
                along[l]
            } else {
                f32::NEG_INFINITY
            };
        }
        along
    });
    (most > f32::NEG_INFINITY).then_some(face as u32)
}

pub(crate) fn cast_shape(hull: &ConvexHull, cast: &LocalCast) -> Option<LocalHit> {
    let core = Core::of_hull(hull);
    let mut hit = cast_against_core(&core, cast)?;
    if hit.distance > 0.0 || hit.normal != -cast.direction {
        hit.face = face_at(hull, hit.point, hit.normal);
    }
    Some(hit)
}

/// When a moved shape meets a core.
pub(crate) fn cast_against_core(core: &Core, cast: &LocalCast) -> Option<LocalHit> {
    let motion = CoreCast {
        direction: cast.direction.as_dvec3(),
        free: f64::from(cast.free),
        length: f64::from(cast.end),
        radius: f64::from(cast.radius),
        touch: f64::from(cast.touch),
    };
    let touch = motion.first_touch(core, &cast.core)?;
    let (point, normal) = match touch.nearest {
        Some(nearest) => (nearest.on_a.as_vec3(), nearest.normal.as_vec3()),
        None => (cast.core.middle().as_vec3(), -cast.direction),
    };
    Some(LocalHit::at(point, normal, touch.distance as f32))
}

/// Whether a core comes within `radius` (m) of the hull.
pub(crate) fn overlaps(hull: &ConvexHull, core: &PlacedCore, radius: f32) -> bool {
    let radius = f64::from(radius);
    let mut start = core.middle() - hull.aabb().center().as_dvec3();
    if radius == 0.0
        && let Some(cuboid) = Cuboid::of(core)
    {
        match cuboid.against(hull) {
            Told::Apart => return false,
            Told::Overlap => return true,
            Told::Nothing(axis) => start = axis.as_dvec3(),
        }
    }
    match distance_from(&Core::of_hull(hull), core, start, radius) {
        Separation::Overlap => true,
        Separation::Near(nearest) => nearest.distance <= radius,
        Separation::Far => false,
    }
}

/// Whether a point is in the hull or, but for rounding, on it.
fn holds(hull: &ConvexHull, point: Vec3) -> bool {
    let slack = FOOT * (hull.aabb().diagonal() + point.abs().max_element());
    let mut planes = hull.lanes.planes.iter();
    planes.all(|planes| planes.heights(point).iter().all(|&height| height <= slack))
}

/// The point of the surface that is nearest to a point, if it is within `limit` (m).
pub(crate) fn closest(hull: &ConvexHull, point: Vec3, limit: f32) -> Option<LocalHit> {
    let (height, face) = largest(hull, |planes| planes.heights(point));
    if height > limit {
        return None;
    }
    let plane = hull.faces().get(face)?.plane;
    let on_face = || {
        Some(LocalHit {
            point: point - height * plane.normal,
            normal: plane.normal,
            distance: height,
            part: 0,
            triangle: None,
            face: Some(face as u32),
        })
    };
    // Over the inside of the face it is the foot on it.
    let foot = point - height * plane.normal;
    if height <= 0.0 || holds(hull, foot) {
        return on_face();
    }
    if let Some(b) = box_of(hull) {
        let (on_hull, normal, distance) = nearest_of_box(&b, point);
        let found = LocalHit::at(on_hull, normal, distance);
        return (distance <= limit).then(|| on_surface(hull, found));
    }
    let point = point.as_dvec3();
    let edge = on_outline(hull, face, point);
    let (axis, length) = (point - edge).normalize_and_length();
    let found = LocalHit::at(edge.as_vec3(), axis.as_vec3(), length as f32);
    if length > 0.0 && is_farthest(hull, &found) {
        return (found.distance <= limit).then(|| on_surface(hull, found));
    }
    match distance_from(&Core::of_hull(hull), &point, axis, f64::from(limit)) {
        Separation::Far => None,
        Separation::Overlap => on_face(),
        Separation::Near(Nearest {
            normal,
            distance,
            on_a,
        }) => {
            let found = LocalHit::at(on_a.as_vec3(), normal.as_vec3(), distance as f32);
            Some(on_surface(hull, found))
        }
    }
}

/// A place on the surface with the face that it lies on.
pub(crate) fn on_surface(hull: &ConvexHull, found: LocalHit) -> LocalHit {
    LocalHit {
        face: face_at(hull, found.point, found.normal),
        ..found
    }
}

/// The point of a face's outline that is nearest to a point.
fn on_outline(hull: &ConvexHull, face: usize, point: DVec3) -> DVec3 {
    let corners = hull.face_loop(&hull.faces()[face]);
    let at = |&corner: &u32| hull.vertices()[corner as usize].as_dvec3();
    let mut from = corners.last().map_or(point, at);
    let mut best = (f64::INFINITY, from);
    for to in corners.iter().map(at) {
        let along = to - from;
        let share = (point - from).dot(along) / along.length_squared();
        let on_edge = from + share.clamp(0.0, 1.0) * along;
        let square = point.distance_squared(on_edge);
        if square < best.0 {
            best = (square, on_edge);
        }
        from = to;
    }
    best.1
}

/// Whether no point of the hull, but for rounding, lies farther along the normal of a place: then none is nearer to whatever is there.
fn is_farthest(hull: &ConvexHull, place: &LocalHit) -> bool {
    let top = -lowest_height(&hull.lanes.points, -place.normal);
    let slack = FOOT * (hull.aabb().diagonal() + place.point.abs().max_element());
    top - place.point.dot(place.normal) <= slack
}
