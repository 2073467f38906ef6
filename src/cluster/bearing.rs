//! How what a cluster lies on bears it: by all of the face that lies there.
//!
//! A contact is at most four points at the rim of the common face, and which of them bears how much is all that a rigid body needs. Were these
//! points all that bears an elastic one, a beam that lies flat on the floor would be bent as between two posts. What the face bears
//! together is known; how it is spread over the face is chosen so that each place bears what is above it, as far as that has the
//! same resultant. By the theorem of the lower bound a body stands if any way to spread it breaks nothing.

use crate::cluster::elastic::Wrench;
use crate::cluster::footprint::{Outline, Plane, overlap};
use crate::cluster::network::Network;
use crate::geometry::Compound;
use glam::{DMat2, DVec2, DVec3};
use smallvec::SmallVec;

/// How far from the plane of a face a corner may be, and how far beyond its rim, as a share of the least extent of its part.
const NEAR: f64 = 0.02;

/// Width of a face that is none, as a share of its length.
const LEAST_WIDTH: f64 = 1e-4;

/// How often places that would have to pull are left out.
const ROUNDS: usize = 16;

/// A face that lies on something, frame of the compound.
#[derive(Clone, Debug)]
pub(crate) struct Bearing {
    /// Unit vector in which it is borne.
    pub(crate) normal: DVec3,
    /// Points at the rim, m.
    pub(crate) rim: SmallVec<[DVec3; 4]>,
}

/// What bears a cluster at faces that lie on one other body.
#[derive(Clone, Debug, Default)]
pub(crate) struct Borne<'b> {
    pub(crate) faces: SmallVec<[&'b Bearing; 2]>,
    /// By part, as the points of contacts have it.
    pub(crate) parts: Vec<(u32, Wrench)>,
}

/// A corner of a part that is borne.
struct Place {
    part: u32,
    at: DVec3,
    /// Force that comes down there, N.
    weight: f64,
}

impl Network {
    /// Adds what bears a cluster to the `loads` of its parts, which hold all others but gravity (m/s2).
    pub(crate) fn spread(
        &self,
        compound: &Compound,
        borne: &[Borne],
        gravity: DVec3,
        loads: &mut [Wrench],
    ) {
        let mut places: Vec<Vec<Place>> = (borne.iter())
            .map(|borne| places_of(compound, borne))
            .collect();
        self.weigh(&mut places, borne, gravity, loads);
        for (borne, places) in borne.iter().zip(places) {
            let shares = self.shares_of(borne, places);
            for &(part, wrench) in shares.as_ref().unwrap_or(&borne.parts) {
                loads[part as usize].add(wrench);
            }
        }
    }

    /// Tells each place what comes down on it: of each part its weight and what loads it, at the nearest part that is borne.
    fn weigh(&self, places: &mut [Vec<Place>], borne: &[Borne], gravity: DVec3, loads: &[Wrench]) {
        let up = -gravity.normalize_or_zero();
        // The middles of the parts that are borne, and which of the places they are.
        let mut middles: Vec<(DVec3, usize, std::ops::Range<usize>)> = Vec::new();
        for (of, places) in places.iter().enumerate() {
            let mut from = 0;
            for group in places.chunk_by(|a, b| a.part == b.part) {
                let sum: DVec3 = group.iter().map(|place| place.at).sum();
                let range = from..from + group.len();
                middles.push((sum / group.len() as f64, of, range.clone()));
                from = range.end;
            }
        }
        if borne.is_empty() || middles.is_empty() {
            return;
        }
        for (node, load) in self.nodes.iter().zip(loads) {
            let own = (node.mass * gravity.length(), node.center);
            let square = load.force.length_squared().max(f64::MIN_POSITIVE);
            let at = node.center + load.force.cross(load.torque) / square;
            for (weight, at) in [own, (-load.force.dot(up), at)] {
                let off = |middle: DVec3| (at - middle).reject_from_normalized(up).length_squared();
                let nearest = middles.iter().min_by(|a, b| off(a.0).total_cmp(&off(b.0)));
                if let Some((_, of, range)) = nearest.filter(|_| weight != 0.0) {
                    let share = weight / range.len() as f64;
                    let corners = &mut places[*of][range.clone()];
                    corners.iter_mut().for_each(|place| place.weight += share);
                }
            }
        }
    }

    /// What each of the places bears, all together what the points of the contacts do; none if they cannot.
    fn shares_of(&self, borne: &Borne, mut places: Vec<Place>) -> Option<Vec<(u32, Wrench)>> {
        let normal = borne.faces.first()?.normal;
        let mut sum = Wrench::default();
        for (part, wrench) in &borne.parts {
            sum.add(*wrench);
            sum.torque += self.nodes[*part as usize].center.cross(wrench.force);
        }
        let (force, square) = (sum.force.dot(normal), sum.force.length_squared());
        if force <= 0.0 {
            return None;
        }
        // Where its axis goes through the face, and what it turns about that.
        let twist = sum.torque.dot(sum.force) / square * sum.force;
        let near = sum.force.cross(sum.torque) / square;
        let height = normal.dot(places.first()?.at);
        let middle = near + (height - normal.dot(near)) / force * sum.force;
        for _ in 0..ROUNDS {
            places.retain(|place| place.weight > 0.0);
            let tilt = Tilt::of(&places, (normal, middle), force)?;
            if places.iter().all(|place| tilt.share_at(place) >= 0.0) {
                let share = |place: &Place| {
                    let share = tilt.share_at(place) * place.weight / force;
                    let own = share * sum.force;
                    let arm = place.at - self.nodes[place.part as usize].center;
                    let torque = arm.cross(own) + share * twist;
                    (place.part, Wrench { force: own, torque })
                };
                return Some(places.iter().map(share).collect());
            }
            places.retain(|place| tilt.share_at(place) > 0.0);
        }
        None
    }
}

/// Corners of what of each part lies on the faces, by part.
fn places_of(compound: &Compound, borne: &Borne) -> Vec<Place> {
    let mut places = Vec::new();
    let Some(first) = borne.faces.first() else {
        return places;
    };
    let plane = Plane::through(first.rim[0], first.normal);
    let rims = borne.faces.iter();
    let rims: SmallVec<[Outline; 2]> = rims
        .map(|face| plane.outline(face.rim.iter().copied()))
        .collect();
    for (number, part) in (0..).zip(compound.parts()) {
        let near = NEAR * f64::from(part.shape.aabb().extents().min_element());
        let corners = part.shape.hull().vertices().iter();
        let corners = corners.map(|&corner| part.pose.transform_point(corner).as_dvec3());
        let own = plane.outline(corners.filter(|&at| plane.height_of(at).abs() <= near));
        if own.is_empty() {
            continue;
        }
        let corners = rims.iter().flat_map(|rim| overlap(own.clone(), rim, near));
        places.extend(corners.map(|at| Place {
            part: number,
            at: plane.point(at),
            weight: 0.0,
        }));
    }
    places
}

/// By how much more than its weight a place bears, linear over the face.
struct Tilt {
    axes: [DVec3; 2],
    mean: DVec3,
    level: f64,
    slope: DVec2,
}

impl Tilt {
    /// The one with which weights have the force (N) as their sum, and its middle as theirs; none if there is none.
    fn of(places: &[Place], (normal, middle): (DVec3, DVec3), force: f64) -> Option<Self> {
        let whole: f64 = places.iter().map(|place| place.weight).sum();
        let mean = places.iter().map(|place| place.weight * place.at);
        let mean = mean.sum::<DVec3>() / whole;
        let first = normal.any_orthonormal_vector();
        let mut tilt = Self {
            axes: [first, normal.cross(first)],
            mean,
            level: force / whole,
            slope: DVec2::ZERO,
        };
        let squares = places.iter().map(|place| {
            let at = tilt.in_face(place.at);
            DMat2::from_cols(at * at.x, at * at.y) * place.weight
        });
        let squares = squares.fold(DMat2::ZERO, |sum, own| sum + own);
        let off = tilt.in_face(middle);
        // Places in a row bear no moment about it.
        let size = squares.col(0).x + squares.col(1).y;
        let is_wide = squares.determinant() > LEAST_WIDTH * LEAST_WIDTH * size * size;
        tilt.slope = squares.inverse() * off * force;
        let is_finite = tilt.level.is_finite() && tilt.slope.is_finite();
        (is_wide && is_finite).then_some(tilt)
    }

    fn in_face(&self, at: DVec3) -> DVec2 {
        DVec2::from_array(self.axes.map(|axis| axis.dot(at - self.mean)))
    }

    /// Force that a place bears over its weight.
    fn share_at(&self, place: &Place) -> f64 {
        self.level + self.slope.dot(self.in_face(place.at))
    }
}
