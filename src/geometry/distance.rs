//! Distance of two convex cores, and when one that moves meets the other.
//!
//! The algorithm of Gilbert, Johnson and Keerthi on the difference B - A: a simplex of its corners comes ever nearer to the origin.
//! Corners are chosen in `f32` and combined in `f64`, so that what ends the search is a corner that comes again, and no noise.
//! Distances are good to 1e-6 of the larger shape.
//!
//! # References
//! - E. Gilbert, D. Johnson, S. Keerthi, "A Fast Procedure for Computing the Distance Between Complex Objects in
//!   Three-Dimensional Space", IEEE J. Robotics and Automation 4(2), 1988.
//! - C. Ericson, "Real-Time Collision Detection", 2005, sections 5.1 and 9.5: closest points of simplices.
//! - B. Mirtich, "Impulse-based Dynamic Simulation of Rigid Body Systems", 1996: conservative advancement.

use crate::geometry::simplex::{Corner, Simplex};
use crate::geometry::support::{Core, PlacedCore, Support};
use glam::DVec3;

/// Most corners that are tried. Hulls of a thousand faces take some ten.
const MAX_CORNERS: usize = 64;

/// Share of the distance that may be missing from it.
const TOLERANCE: f64 = 1e-7;

/// Distance below which cores count as overlapping, as a share of the coordinates: some rounding of `f32` corners.
const TOUCH: f64 = 3e-7;

/// How many times that distance a core is taken back along the normal to tell where it touches.
const CLEAR: f64 = 8.0;

/// Most moments at which a moving core is looked at. What comes nearer all the while but is not there then, counts as there.
const MAX_MOMENTS: usize = 64;

/// Where two cores are nearest, in A's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest {
    /// Unit vector from A to B.
    pub(crate) normal: DVec3,
    /// How far they are apart along it at least, m.
    pub(crate) distance: f64,
    /// The nearest point of A.
    pub(crate) on_a: DVec3,
}

/// What is known of the distance of two cores.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Separation {
    /// They are nearest here.
    Near(Nearest),
    /// They are farther apart than was asked.
    Far,
    /// They overlap, or touch.
    Overlap,
}

/// How far apart two cores are, if no more than `limit` (m).
pub(crate) fn distance(a: &Core, b: &PlacedCore, limit: f64) -> Separation {
    distance_from(a, b, b.middle() - a.middle().as_dvec3(), limit)
}

/// The same by a search that begins with the corners along `start`, which points from A to B: the nearer it is to the normal where
/// the cores are nearest, the sooner it ends.
pub(crate) fn distance_from(a: &Core, b: &impl Support, start: DVec3, limit: f64) -> Separation {
    let axis = unit_or_x(start);
    let first = corner(a, b, axis);
    if axis.dot(first.apart) > limit {
        return Separation::Far;
    }
    search(a, b, &mut Simplex::new(first), |_, bound| bound > limit)
}

fn unit_or_x(v: DVec3) -> DVec3 {
    v.try_normalize().unwrap_or(DVec3::X)
}

/// The corner of B - A that is farthest against an axis.
fn corner(a: &Core, b: &impl Support, axis: DVec3) -> Corner {
    Corner::new(a.exact_support(axis), b.support(-axis))
}

/// Goes on from a simplex until it is nearest. `is_far` is told of unit axes and how far apart the cores are along them at least (m),
/// and ends the search.
fn search(
    a: &Core,
    b: &impl Support,
    simplex: &mut Simplex,
    is_far: impl Fn(DVec3, f64) -> bool,
) -> Separation {
    let mut size = 0.0_f64;
    for _ in 0..MAX_CORNERS {
        let to = simplex.nearest();
        let length = to.length();
        size = size.max(simplex.extent());
        if simplex.is_full() || length <= TOUCH * size {
            return Separation::Overlap;
        }
        let normal = to / length;
        let next = corner(a, b, normal);
        let bound = normal.dot(next.apart);
        if is_far(normal, bound) {
            return Separation::Far;
        }
        let is_done = length - bound <= TOLERANCE * length || simplex.has(&next);
        if is_done || !simplex.add(next) {
            return Separation::Near(Nearest {
                normal,
                distance: bound.max(0.0).min(length),
                on_a: simplex.point_on_a(),
            });
        }
    }
    let to = simplex.nearest();
    Separation::Near(Nearest {
        normal: unit_or_x(to),
        distance: to.length(),
        on_a: simplex.point_on_a(),
    })
}

/// How a core moves against another one, in the frame of the one that stays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CoreCast {
    /// Unit vector.
    pub(crate) direction: DVec3,
    /// How far it surely goes without touching the other one, m.
    pub(crate) free: f64,
    /// How far it goes, m.
    pub(crate) length: f64,
    /// Radius of both together, m.
    pub(crate) radius: f64,
    /// Gap that counts as none, m.
    pub(crate) touch: f64,
}

/// When a moving core comes as near as the radius.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CastTouch {
    /// How far it has moved then, m.
    pub(crate) distance: f64,
    /// Where they are nearest then. None if they overlap from the start.
    pub(crate) nearest: Option<Nearest>,
}

impl CoreCast {
    /// When `b`, which moves, touches `a`. What is told of several moments goes on from the corners of the one before.
    pub(crate) fn first_touch(&self, a: &Core, b: &PlacedCore) -> Option<CastTouch> {
        let start = b.middle() - a.middle().as_dvec3();
        if self.passes_by(a, b, start) {
            return None;
        }
        let (mut moved, mut last) = (self.free, None);
        let at = |moved: f64| b.moved(moved * self.direction);
        let first = |b: &PlacedCore| {
            let start = b.middle() - a.middle().as_dvec3();
            Simplex::new(corner(a, b, unit_or_x(start)))
        };
        let mut simplex = first(&at(moved));
        for _ in 0..MAX_MOMENTS {
            let left = self.length - moved;
            let now = at(moved);
            let is_far = |normal, bound| self.stays_apart(normal, bound, left);
            let nearest = match search(a, &now, &mut simplex, is_far) {
                Separation::Far => return None,
                // Rounding: it was not free so far.
                Separation::Overlap if last.is_none() && moved > 0.0 => {
                    (moved, simplex) = (0.0, first(b));
                    continue;
                }
                Separation::Overlap => {
                    let size = simplex.extent();
                    return Some(CastTouch {
                        distance: moved,
                        nearest: last.map(|last| self.just_before(a, b, (moved, size), last)),
                    });
                }
                Separation::Near(nearest) => nearest,
            };
            let rate = -self.direction.dot(nearest.normal);
            let gap = nearest.distance - self.radius;
            if gap > -self.touch && rate <= 0.0 {
                return None;
            }
            if gap <= self.touch {
                return Some(CastTouch {
                    distance: moved,
                    nearest: Some(nearest),
                });
            }
            moved += gap / rate;
            if moved > self.length {
                return None;
            }
            simplex = simplex.moved(gap / rate * self.direction);
            last = Some(nearest);
        }
        Some(CastTouch {
            distance: moved,
            nearest: last,
        })
    }

    /// Where cores of a size (m), which overlap after a way (m) because rounding leaves nothing between them, are nearest just before;
    /// `last`: where they were at the moment before, from where the one has moved along the other since.
    fn just_before(
        &self,
        a: &Core,
        b: &PlacedCore,
        (moved, size): (f64, f64),
        last: Nearest,
    ) -> Nearest {
        let rate = -self.direction.dot(last.normal);
        let there = b.moved((moved - CLEAR * TOUCH * size / rate) * self.direction);
        let mut simplex = Simplex::new(corner(a, &there, last.normal));
        match search(a, &there, &mut simplex, |_, _| false) {
            Separation::Near(nearest) => nearest,
            Separation::Far | Separation::Overlap => last,
        }
    }

    /// Whether the cores pass each other apart, as far as one axis across the motion tells.
    fn passes_by(&self, a: &Core, b: &PlacedCore, start: DVec3) -> bool {
        let across = start - start.dot(self.direction) * self.direction;
        let Some(axis) = across.try_normalize() else {
            return false;
        };
        self.stays_apart(axis, axis.dot(corner(a, b, axis).apart), self.length)
    }

    /// Whether cores that are `bound` (m) apart along an axis do not touch on the `left` (m) of the way.
    fn stays_apart(&self, axis: DVec3, bound: f64, left: f64) -> bool {
        let gap = bound - self.radius - self.touch;
        let sinks = (-self.direction.dot(axis)).max(0.0);
        gap > 0.0 && (sinks == 0.0 || gap > sinks * left)
    }
}
