//! Fracture patterns: how an impact divides a body.
//!
//! The same pattern, impact, hull and seed give the same pieces, bit for bit, on every platform: the generator's stream is
//! fixed, random directions are found by rejection, and angles are made without trigonometry.

use crate::geometry::ConvexHull;
use crate::geometry::predicates::length_scale;
use crate::math::{Plane, tangents};
use crate::slice::cutting::CellPlanes;
use crate::slice::cutting::Cutting;
use crate::slice::cutting::Planes;
use crate::slice::even_sites::even_sites;
use crate::slice::random::{PointsInHull, centered, unit_interval, unit_vector};
use crate::slice::tilings::{between, bricks, sectors};
use glam::{Vec2, Vec3};
use rand_core::SeedableRng;
use rand_pcg::Pcg32;
use smallvec::smallvec;

/// How far a body reaches beyond a plane that only grazes it, as a share of its diagonal.
const GRAZE: f32 = 1e-3;

/// How far [`FracturePattern::RandomPlane`] goes from the impact towards the middle of the body, as a fraction.
///
/// A plane through a point inside the hull cuts it whatever the plane's direction; a plane through the impact itself,
/// which is on the surface, may only graze it.
const RANDOM_DEPTH: f32 = 0.5;

/// Largest turn of a plane of [`FracturePattern::Star`] away from even spacing, as a fraction of the spacing.
const STAR_JITTER: f32 = 0.6;

/// Most planes of a star; more pieces than that meet at one line as needles.
const STAR_MAX_PLANES: u8 = 8;

/// Largest turn of a ray away from even spacing, as a fraction of the spacing. With three rays, the widest sector is 172
/// degrees wide: less than half a turn, so that it is convex.
const RAY_JITTER: f32 = 0.3;

/// Numbers of rays that [`FracturePattern::Radial`] may have.
const RAYS: std::ops::RangeInclusive<u8> = 3..=64;

/// Largest shift of a ring or a slab away from its place, as a fraction of the distance between two.
const SHIFT_JITTER: f32 = 0.4;

/// Least distance between two sites of Voronoi cells, relative to the size of the body: nearer, and the cells would be
/// grains that no collision is found for.
const MIN_SITE_DISTANCE: f32 = 1.0e-3;

/// A blow to a body, in the body's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Point of contact, m.
    pub point: Vec3,
    /// Unit direction of the impulse.
    pub normal: Vec3,
    /// Size of the impulse, N s.
    pub impulse: f32,
    /// Kinetic energy that the blow turned into something else, J.
    pub energy: f32,
}

/// How a body breaks.
///
/// Numbers of planes, rays, rings, cells and slabs are the most there are: an impact with little energy makes fewer.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
#[non_exhaustive]
pub enum FracturePattern {
    /// One plane through the point of contact that contains the direction of the blow, across the longest direction of
    /// the body's box: its normal is the part of that direction which is perpendicular to the blow.
    ///
    /// Source: "Constraint-Based Physics With Real-Time Object Slicing".
    #[default]
    SinglePlane,
    /// One plane with a random direction, halfway between the point of contact and the center of the body's box, or its
    /// centroid where that plane would miss the body, so that it cuts the body.
    RandomPlane,
    /// Planes that contain the line of the blow, spaced evenly about it with a random jitter.
    Star {
        /// Number of planes, 1 to 8; numbers outside are moved to the nearer end.
        planes: u8,
    },
    /// Cracks that run outwards from the line of the blow, and rings of cracks around it, closer together near the
    /// middle: how a pane of glass breaks.
    Radial {
        /// Number of rays, 3 to 64; numbers outside are moved to the nearer end.
        rays: u8,
        /// Number of rings.
        rings: u8,
    },
    /// Voronoi cells about random points: how stone and concrete break.
    Voronoi {
        /// Number of cells.
        cells: u16,
        /// How much smaller the cells are near the impact: each point moves up to this fraction of the way towards it. 0
        /// for cells of one size, at most 1.
        focus: f32,
    },
    /// Voronoi cells of about the same size: how concrete crumbles. The time to find them grows with the square of their number.
    EvenVoronoi {
        /// Number of cells.
        cells: u16,
    },
    /// Slabs across the longest direction of the body's box: how a beam or a tree breaks.
    Slabs {
        /// Number of slabs.
        count: u8,
    },
    /// Bricks in courses along the body's y axis, every second course shifted by half a brick: how masonry breaks.
    Brick {
        /// Length (x), height (y) and depth (z) of a brick in the body's frame, m. Doubled as often as there would be too
        /// many bricks; where that leaves one, a single plane.
        size: Vec3,
    },
    /// Planes of one's own, in the body's frame.
    Planes(Vec<Plane>),
}

impl FracturePattern {
    /// How `impact` divides `hull`, into at most `most` pieces; see [`Cutting`].
    ///
    /// Nothing if the impact is not finite or has no direction, the pattern's numbers are not usable, or `most` is less
    /// than two. Planes of one's own are not counted: how many pieces they make is known once they cut.
    pub fn cutting(
        &self,
        impact: &Impact,
        hull: &ConvexHull,
        seed: u64,
        most: u32,
    ) -> Option<Cutting> {
        let direction = impact.normal.try_normalize()?;
        if !impact.point.is_finite() || most < 2 {
            return None;
        }
        let blow = ImpactFrame {
            point: impact.point,
            direction,
            hull,
        };
        let most_u8 = u8::try_from(most).unwrap_or(u8::MAX);
        let mut random = Pcg32::seed_from_u64(seed);
        let cutting = match *self {
            Self::SinglePlane => Cutting::Planes(blow.single_plane()),
            Self::RandomPlane => Cutting::Planes(blow.random_plane(&mut random)),
            // Each plane makes two sectors.
            Self::Star { planes } => {
                let planes = planes.clamp(1, STAR_MAX_PLANES).min(most_u8 / 2);
                sectors(&blow.star(planes, &mut random))
            }
            // Two sectors are divided by one plane.
            Self::Radial { .. } if most < 3 => sectors(&blow.star(1, &mut random)),
            Self::Radial { rays, rings } => {
                let rays = u32::from(rays.clamp(*RAYS.start(), *RAYS.end())).min(most);
                let rings = u32::from(rings).min((most / rays).saturating_sub(1));
                Cutting::Cells(blow.radial(rays, rings, &mut random))
            }
            Self::Voronoi { cells, focus } => {
                let count = u32::from(cells).min(most);
                let focus = if focus.is_nan() { 0.0 } else { focus };
                Cutting::Sites(blow.sites(count, focus.clamp(0.0, 1.0), &mut random))
            }
            Self::EvenVoronoi { cells } => {
                let count = u32::from(cells).min(most) as usize;
                let points = PointsInHull::new(hull);
                Cutting::Sites(even_sites(&points, count, &mut random))
            }
            Self::Slabs { count } => Cutting::Cells(blow.slabs(count.min(most_u8), &mut random)),
            Self::Brick { size } => {
                let bricks = bricks(&hull.aabb(), size, most)?;
                // Doubled until nothing but one was left.
                if bricks.len() < 2 && size.cmplt(hull.aabb().extents()).any() {
                    Cutting::Planes(blow.single_plane())
                } else {
                    Cutting::Cells(bricks)
                }
            }
            Self::Planes(ref planes) => Cutting::Planes(planes.iter().copied().collect()),
        };
        Some(cutting)
    }

    /// The planes (body frame) that `impact` cuts `hull` by; none if the pattern is not made of planes.
    ///
    /// Empty also where [`cutting`](Self::cutting) gives nothing.
    pub fn planes(&self, impact: &Impact, hull: &ConvexHull, seed: u64) -> Planes {
        match self.cutting(impact, hull, seed, u32::MAX) {
            Some(Cutting::Planes(planes)) => planes,
            _ => Planes::new(),
        }
    }
}

/// Where and how a body was hit.
struct ImpactFrame<'a> {
    point: Vec3,
    /// Unit vector.
    direction: Vec3,
    hull: &'a ConvexHull,
}

impl ImpactFrame<'_> {
    /// The unit vector perpendicular to the blow that is nearest to the longest axis of the hull's box, or, if the blow
    /// runs along that axis, to the next longest.
    fn across(&self) -> Vec3 {
        let (direction, extents) = (self.direction, self.hull.aabb().extents());
        let mut axes = [Vec3::X, Vec3::Y, Vec3::Z];
        axes.sort_by(|a, b| extents.dot(*b).total_cmp(&extents.dot(*a)));
        axes.into_iter()
            .map(|axis| axis - axis.dot(direction) * direction)
            // Three axes cannot all be within 45 degrees of one direction, so one of them leaves half its square.
            .find(|part| part.length_squared() >= 0.5)
            .map_or(tangents(direction)[0], Vec3::normalize)
    }

    /// The plane through the point and the line of the blow whose normal is nearest to the longest axis of the box.
    fn single_plane(&self) -> Planes {
        Planes::from_iter([Plane::through(self.point, self.across())])
    }

    /// Whether the body reaches noticeably beyond a plane on both sides.
    fn is_divided_by(&self, plane: Plane) -> bool {
        let least = GRAZE * self.hull.aabb().diagonal();
        let mut heights = self.hull.vertices().iter().map(|&v| plane.distance(v));
        heights.clone().any(|height| height > least) && heights.any(|height| height < -least)
    }

    /// A plane of random direction through a point inside.
    fn random_plane(&self, random: &mut Pcg32) -> Planes {
        let normal = unit_vector(random);
        let towards = |aim| Plane::through(self.point.lerp(aim, RANDOM_DEPTH), normal);
        let mut plane = towards(self.hull.aabb().center());
        if !self.is_divided_by(plane) {
            plane = towards(self.hull.centroid());
        }
        Planes::from_iter([plane])
    }

    /// Planes through the line of the blow: even steps of half a turn, each with a jitter.
    fn star(&self, count: u8, random: &mut Pcg32) -> Planes {
        let u = self.across();
        let v = self.direction.cross(u);
        (0..count)
            .map(|index| {
                let jitter = STAR_JITTER * centered(random);
                let part = (f32::from(index) + jitter) / f32::from(count);
                // Half a turn is all of it: a normal and its opposite belong to the same plane.
                let turn = direction_at(0.5 * part);
                Plane::through(self.point, turn.x * u + turn.y * v)
            })
            .collect()
    }

    /// Sectors between rays from the line of the blow, each divided by the chords of the rings.
    ///
    /// All rings have the same distances along all rays, so that the chords of neighboring sectors meet. The distances
    /// grow with the square of the ring's number.
    fn radial(&self, rays: u32, rings: u32, random: &mut Pcg32) -> Vec<CellPlanes> {
        let u = self.across();
        let v = self.direction.cross(u);
        let in_space = |flat: Vec2| flat.x * u + flat.y * v;
        let directions: Vec<Vec2> = (0..rays)
            .map(|ray| direction_at((ray as f32 + RAY_JITTER * centered(random)) / rays as f32))
            .collect();
        let reach = self.hull.vertices().iter().map(|&vertex| {
            let from_point = vertex - self.point;
            (from_point - from_point.dot(self.direction) * self.direction).length()
        });
        let reach = reach.fold(0.0, f32::max);
        let radii: Vec<f32> = (1..=rings)
            .map(|ring| {
                let part = (ring as f32 + SHIFT_JITTER * centered(random)) / (rings + 1) as f32;
                reach * part * part
            })
            .collect();
        // The plane of each ray, the sector after it being above.
        let sides: Vec<Plane> = directions
            .iter()
            .map(|ray| Plane::through(self.point, in_space(ray.perp())))
            .collect();
        let mut cells = Vec::with_capacity((rays * (rings + 1)) as usize);
        for ray in 0..rays as usize {
            let next = (ray + 1) % rays as usize;
            let middle = directions[ray] + directions[next];
            let chords: Vec<Plane> = radii
                .iter()
                .map(|&radius| {
                    let on_chord = self.point + in_space(radius * directions[ray]);
                    Plane::through(on_chord, in_space(middle))
                })
                .collect();
            for ring in 0..=chords.len() {
                let mut cell: CellPlanes = smallvec![sides[ray].flipped(), sides[next]];
                cell.extend(chords.get(ring).copied());
                cell.extend(ring.checked_sub(1).map(|inner| chords[inner].flipped()));
                cells.push(cell);
            }
        }
        cells
    }

    /// Random points in the hull, moved towards the impact; points that come too near to another are left out.
    fn sites(&self, count: u32, focus: f32, random: &mut Pcg32) -> Vec<Vec3> {
        let least = MIN_SITE_DISTANCE * length_scale(&self.hull.aabb());
        let points = PointsInHull::new(self.hull);
        let target = self.point_in_hull();
        let mut sites: Vec<Vec3> = Vec::with_capacity(count as usize);
        for _ in 0..count {
            let point = points.next(random);
            let site = point.lerp(target, focus * unit_interval(random));
            let is_free = |other: &Vec3| other.distance_squared(site) > least * least;
            if sites.iter().all(is_free) {
                sites.push(site);
            }
        }
        sites
    }

    /// The point of contact, brought back behind the faces that it lies outside of.
    fn point_in_hull(&self) -> Vec3 {
        self.hull.faces().iter().fold(self.point, |point, face| {
            point - face.plane.distance(point).max(0.0) * face.plane.normal
        })
    }

    /// Slabs of about the same thickness.
    fn slabs(&self, count: u8, random: &mut Pcg32) -> Vec<CellPlanes> {
        let normal = self.across();
        let along = self
            .hull
            .vertices()
            .iter()
            .map(|vertex| normal.dot(*vertex));
        let (low, high) = along.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        let walls: Vec<Plane> = (1..count.max(1))
            .map(|wall| {
                let part = (f32::from(wall) + SHIFT_JITTER * centered(random)) / f32::from(count);
                let offset = low + part * (high - low);
                Plane { normal, offset }
            })
            .collect();
        (0..=walls.len())
            .map(|slab| between(&walls, slab))
            .collect()
    }
}

/// The unit vector at about `fraction` of a turn from `(1, 0)`.
///
/// On each quarter turn it is the point `(1 - s^2, 2 s) / (1 + s^2)` of the circle with `s` from 0 to 1, whose angle
/// `2 atan s` is within 8.2 degrees of `90 s`.
fn direction_at(fraction: f32) -> Vec2 {
    let quarters = 4.0 * fraction;
    let quarter = quarters.floor();
    let s = quarters - quarter;
    let within = Vec2::new(1.0 - s * s, 2.0 * s) / (1.0 + s * s);
    match (quarter as i32).rem_euclid(4) {
        0 => within,
        1 => within.perp(),
        2 => -within,
        _ => -within.perp(),
    }
}
