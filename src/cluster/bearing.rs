//! How bodies at a face of a cluster load it: what it lies on, what lies on it or leans against it, and what is bonded to it, by all of that face.
//!
//! A contact is at most four points at the rim of the common face, and which of them bears how much is all that a rigid body needs. Were these
//! points all that bears an elastic one, a beam that lies flat on the floor would be bent as between two posts. What the face bears
//! together is known; how it is spread over the face is chosen so that each place bears what is above it, as far as that has the
//! same resultant. By the theorem of the lower bound a body stands if any way to spread it breaks nothing. What lies on the cluster, or is bonded
//! to it, loads it in proportion to area, as a rigid body on an even bed does: at the corners of its contact alone, a block across the whole width of a plate
//! bent its rims down.

use crate::cluster::elastic::Wrench;
use crate::cluster::footprint::{Outline, Plane, overlap};
use crate::cluster::network::Network;
use crate::geometry::Compound;
use crate::math::Aabb;
use glam::{DMat2, DMat3, DVec2, DVec3};
use smallvec::SmallVec;

/// How far from the plane of a face a corner may be, and how far beyond its rim, as a share of the least extent of its part.
const NEAR: f64 = 0.02;

/// Width of a face that is none, as a share of its length.
const LEAST_WIDTH: f64 = 1e-4;

/// How often places that would have to pull are left out.
const ROUNDS: usize = 16;

/// How what is at a face is spread over it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Spread {
    /// The cluster lies there: by what comes down.
    ByWeight,
    /// Something pushes there: by area, and nothing pulls.
    ByArea,
    /// By area, and it may pull.
    Bonded,
}

/// A face where another body touches, frame of the compound.
#[derive(Clone, Debug)]
pub(crate) struct Bearing {
    pub(crate) spread: Spread,
    /// Unit vector in which it is pushed.
    pub(crate) normal: DVec3,
    /// Points at the rim, m.
    pub(crate) rim: SmallVec<[DVec3; 4]>,
}

/// What one other body does at faces of a cluster.
#[derive(Clone, Debug, Default)]
pub(crate) struct Borne<'b> {
    pub(crate) faces: SmallVec<[&'b Bearing; 2]>,
    /// By part, as the points of contacts have it.
    pub(crate) parts: Vec<(u32, Wrench)>,
}

impl Borne<'_> {
    fn spread(&self) -> Spread {
        (self.faces.first()).map_or(Spread::ByArea, |face| face.spread)
    }

    /// Force and, about the origin, torque of all of it.
    fn sum(&self, network: &Network) -> Wrench {
        let mut sum = Wrench::default();
        for (part, wrench) in &self.parts {
            sum.add(*wrench);
            sum.torque += network.nodes[*part as usize].center.cross(wrench.force);
        }
        sum
    }
}

/// A place on the face of a part.
struct Place {
    part: u32,
    at: DVec3,
    /// Force that comes down there, N, or its share of the area, m2.
    weight: f64,
}

impl Network {
    /// Adds what others do at faces of a cluster to the `loads` of its parts, which hold all others but gravity (m/s2).
    pub(crate) fn spread(
        &self,
        compound: &Compound,
        borne: &[Borne],
        gravity: DVec3,
        loads: &mut [Wrench],
    ) {
        let (below, others): (Vec<&Borne>, Vec<&Borne>) =
            (borne.iter()).partition(|borne| borne.spread() == Spread::ByWeight);
        for borne in others {
            // What is on one part loads that one, wherever it is.
            let is_on_one = borne.parts.windows(2).all(|two| two[0].0 == two[1].0);
            let shares = match borne.spread() {
                _ if is_on_one => None,
                Spread::Bonded => self.bonded_shares(borne, &areas_of(compound, borne)),
                _ => self.shares_of(borne, areas_of(compound, borne)),
            };
            add_shares(loads, borne, shares);
        }
        let mut places: Vec<Vec<Place>> = (below.iter())
            .map(|borne| corners_of(compound, borne))
            .collect();
        self.weigh(&mut places, gravity, loads);
        for (borne, places) in below.into_iter().zip(places) {
            let shares = self.shares_of(borne, places);
            add_shares(loads, borne, shares);
        }
    }

    /// Tells each place what comes down on it: of each part its weight and what loads it, at the nearest part that is borne.
    fn weigh(&self, places: &mut [Vec<Place>], gravity: DVec3, loads: &[Wrench]) {
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
        if middles.is_empty() {
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
        let sum = borne.sum(self);
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

    /// What each of the places bears of what is bonded there: as if it were glued there evenly. None if they are in a row.
    fn bonded_shares(&self, borne: &Borne, places: &[Place]) -> Option<Vec<(u32, Wrench)>> {
        let normal = borne.faces.first()?.normal;
        let whole: f64 = places.iter().map(|place| place.weight).sum();
        let mean = places.iter().map(|place| place.weight * place.at);
        let mean = mean.sum::<DVec3>() / whole;
        let squares = places.iter().map(|place| {
            let arm = place.at - mean;
            let outer = DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
            (DMat3::from_diagonal(DVec3::splat(arm.length_squared())) - outer) * place.weight
        });
        let squares = squares.fold(DMat3::ZERO, |sum, own| sum + own);
        // All of the square is that about the normal, and what is left of it in a row is none.
        let size = normal.dot(squares * normal);
        let is_wide = squares.determinant() > LEAST_WIDTH * LEAST_WIDTH * size * size * size;
        let sum = borne.sum(self);
        let (along, turning) = (
            sum.force / whole,
            squares.inverse() * (sum.torque - mean.cross(sum.force)),
        );
        let is_usable = is_wide && along.is_finite() && turning.is_finite();
        let share = |place: &Place| {
            let force = place.weight * (along + turning.cross(place.at - mean));
            let arm = place.at - self.nodes[place.part as usize].center;
            let torque = arm.cross(force);
            (place.part, Wrench { force, torque })
        };
        is_usable.then(|| places.iter().map(share).collect())
    }
}

/// Adds the shares of what a body does, or what its points do if it has none.
fn add_shares(loads: &mut [Wrench], borne: &Borne, shares: Option<Vec<(u32, Wrench)>>) {
    for &(part, wrench) in shares.as_ref().unwrap_or(&borne.parts) {
        loads[part as usize].add(wrench);
    }
}

/// Corners of what of each part lies on the faces, by part.
fn corners_of(compound: &Compound, borne: &Borne) -> Vec<Place> {
    let mut places = Vec::new();
    overlaps_of(compound, borne, |part, plane, outline| {
        places.extend(outline.iter().map(|&at| Place {
            part,
            at: plane.point(at),
            weight: 0.0,
        }));
    });
    places
}

/// What of each part lies on the faces, by part: at the middles of the sides of triangles, which sum up squares exactly.
fn areas_of(compound: &Compound, borne: &Borne) -> Vec<Place> {
    let mut places = Vec::new();
    overlaps_of(compound, borne, |part, plane, outline| {
        for pair in outline.windows(2).skip(1) {
            let [a, b, c] = [outline[0], pair[0], pair[1]];
            let weight = (b - a).perp_dot(c - a).abs() / 6.0;
            places.extend([(a, b), (b, c), (c, a)].map(|(from, to)| Place {
                part,
                at: plane.point(0.5 * (from + to)),
                weight,
            }));
        }
    });
    places
}

/// Visits what of each part lies on the faces, by part.
fn overlaps_of(compound: &Compound, borne: &Borne, mut visit: impl FnMut(u32, &Plane, &Outline)) {
    let Some(first) = borne.faces.first() else {
        return;
    };
    let plane = Plane::through(first.rim[0], first.normal);
    let rims = borne.faces.iter();
    let rims: SmallVec<[Outline; 2]> = rims
        .map(|face| plane.outline(face.rim.iter().copied()))
        .collect();
    let around = Aabb::of_points(
        (borne.faces.iter()).flat_map(|face| face.rim.iter().map(|at| at.as_vec3())),
    );
    // No part is near from farther away than that.
    let around = around.fattened(NEAR as f32 * compound.aabb().diagonal());
    let mut near_it: Vec<u32> = Vec::new();
    compound.within(&around, |part| near_it.push(part));
    near_it.sort_unstable();
    for number in near_it {
        let part = &compound.parts()[number as usize];
        let near = NEAR * f64::from(part.shape.aabb().extents().min_element());
        let corners = part.shape.hull().vertices().iter();
        let corners = corners.map(|&corner| part.pose.transform_point(corner).as_dvec3());
        let own = plane.outline(corners.filter(|&at| plane.height_of(at).abs() <= near));
        if own.is_empty() {
            continue;
        }
        for rim in &rims {
            visit(number, &plane, &overlap(own.clone(), rim, near));
        }
    }
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
