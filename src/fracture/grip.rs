//! Friction of clusters that stand on several things: what follows from how they stand, without what is left from how they came to rest.
//!
//! On two posts a beam may push both outward as well as inward: contacts bear either with the same motion, which of them is left from the steps in which it came down, and
//! as a load it would strain the beam by a tenth of what it bears. What is known is the resultant. So each point gets friction in proportion to its normal
//! force, as from a surface that moves as a whole: of all that have the same resultant the one with the least sum of squares over normal forces.
//! Only at what stands: what moves may well pull a cluster apart by friction.

use crate::bodies::body::RigidBody;
use crate::bodies::store::Bodies;
use crate::contact::manifolds::{ManifoldRef, Manifolds};
use crate::contact::point::ContactPoint;
use glam::{DVec3, Vec3};

/// Friction at what stands, of one cluster: of the unit of normal force at its center of mass, and how that changes from there.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Grip {
    along: DVec3,
    /// 1/m.
    turning: DVec3,
}

/// The clusters that stand on several things, by slot.
pub(super) type Grips = Vec<(u32, Grip)>;

/// What conjugate gradients need for six unknowns, and as much again for rounding.
const ROUNDS: usize = 12;

/// What is hardly held, as a share of what is held best: forces out of the plane of all contacts, which are none but for rounding, would ask for
/// more friction than there is.
const LEAST: f64 = 1e-4;

/// Square of the error that is left of a resultant, as a share of it; rounding of single precision alone would leave 1e-14.
const ERROR: f64 = 1e-10;

/// Whether friction of a contact of the cluster at one side is found so, if there are several of the kind.
fn is_of_grip(bodies: &Bodies, manifold: &ManifoldRef, side: usize) -> bool {
    let slots = [manifold.a, manifold.b];
    bodies.cluster(slots[side]).is_some()
        && bodies.kind(slots[side]) == RigidBody::Dynamic
        && bodies.kind(slots[1 - side]) == RigidBody::Static
        && !bodies.are_bonded(slots[0], slots[1])
}

/// The friction of all clusters that several contacts with what stands bear.
pub(super) fn find_grips(bodies: &Bodies, manifolds: &Manifolds) -> Grips {
    let mut found: Vec<(u32, usize, ManifoldRef)> = Vec::new();
    for manifold in manifolds.iter() {
        for (side, slot) in [manifold.a, manifold.b].into_iter().enumerate() {
            if is_of_grip(bodies, &manifold, side) {
                found.push((slot, side, manifold));
            }
        }
    }
    found.sort_by_key(|(slot, ..)| *slot);
    let groups = found.chunk_by(|a, b| a.0 == b.0);
    let several = groups.filter(|group| group.len() > 1);
    several.map(|group| (group[0].0, Grip::of(group))).collect()
}

/// The friction of the cluster at one side of a contact, if it is found so.
pub(super) fn grip_at(
    bodies: &Bodies,
    grips: &Grips,
    manifold: &ManifoldRef,
    side: usize,
) -> Option<Grip> {
    let slot = [manifold.a, manifold.b][side];
    let place = grips.binary_search_by_key(&slot, |(of, _)| *of).ok()?;
    is_of_grip(bodies, manifold, side).then_some(grips[place].1)
}

impl Grip {
    /// Friction impulse on B at a point, N s; `arm` from the center of mass.
    pub(super) fn friction(&self, normal: Vec3, point: &ContactPoint, arm: Vec3) -> DVec3 {
        let along = self.along + self.turning.cross(arm.as_dvec3());
        let normal = normal.as_dvec3();
        f64::from(point.normal_impulse) * (along - along.dot(normal) * normal)
    }

    /// The one with the resultant that the points have.
    fn of(contacts: &[(u32, usize, ManifoldRef)]) -> Self {
        let points = || {
            contacts.iter().flat_map(|(_, side, manifold)| {
                let points = manifold.points().iter();
                points.map(move |point| {
                    (
                        manifold.normal,
                        point,
                        [point.anchor_a, point.anchor_b][*side],
                    )
                })
            })
        };
        // Turns as if of this arm, so that all unknowns are of one size.
        let reach = points()
            .map(|(.., arm)| arm.length())
            .fold(f32::MIN_POSITIVE, f32::max);
        let resultant = |force: &dyn Fn(Vec3, &ContactPoint, Vec3) -> DVec3| {
            let mut sum = [DVec3::ZERO; 2];
            for (normal, point, arm) in points() {
                let force = force(normal, point, arm);
                sum[0] += force;
                sum[1] += arm.as_dvec3().cross(force) / f64::from(reach);
            }
            sum
        };
        let dot = |a: [DVec3; 2], b: [DVec3; 2]| a[0].dot(b[0]) + a[1].dot(b[1]);
        let add = |a: [DVec3; 2], b: [DVec3; 2], by: f64| [a[0] + by * b[0], a[1] + by * b[1]];
        let grip = |[along, turning]: [DVec3; 2]| Self {
            along,
            turning: turning / f64::from(reach),
        };
        let total: f64 = points()
            .map(|(_, point, _)| f64::from(point.normal_impulse))
            .sum();
        let mut rest = resultant(&|_, point, _| point.friction_impulse.as_dvec3());
        let mut known = [DVec3::ZERO; 2];
        let (mut way, mut square) = (rest, dot(rest, rest));
        let goal = ERROR * square;
        for _ in 0..ROUNDS {
            let now = grip(way);
            let moved = resultant(&|normal, point, arm| now.friction(normal, point, arm));
            let moved = add(moved, way, LEAST * total);
            let step = square / dot(way, moved);
            if square <= goal || !step.is_finite() {
                break;
            }
            known = add(known, way, step);
            rest = add(rest, moved, -step);
            let next = dot(rest, rest);
            way = add(rest, way, next / square);
            square = next;
        }
        grip(known)
    }
}
