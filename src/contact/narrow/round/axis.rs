//! The direction along which two shapes are nearest to each other, or overlap least.

use crate::contact::narrow::round::solid::{Form, Solid};
use crate::geometry::distance::{Nearest, Separation, distance};
use crate::geometry::penetration::WayOut;
use crate::geometry::support::PlacedCore;
use crate::math::{Pose, rotate};
use glam::{DVec3, Mat3, Vec3};

/// Two shapes, the second one in the frame of the first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SolidPair<'s> {
    pub(crate) a: Solid<'s>,
    pub(crate) b: Solid<'s>,
    pub(crate) b_in_a: Pose,
}

/// A direction from A to B.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PairAxis {
    /// Unit vector, A's frame.
    pub(crate) normal: Vec3,
    /// How far the shapes are apart along it, m; negative where they overlap.
    pub(crate) separation: f64,
    /// The point inside of A that is nearest to the inside of B, or where that leaves the inside of A first if they overlap; if it is known.
    pub(crate) inner: Option<DVec3>,
}

impl SolidPair<'_> {
    /// The same pair, seen from B.
    pub(crate) fn swapped(&self) -> Self {
        Self {
            a: self.b,
            b: self.a,
            b_in_a: self.b_in_a.inverse(),
        }
    }

    pub(crate) fn seen_from_b(&self, axis: Vec3) -> Vec3 {
        rotate(self.b_in_a.rotation.inverse(), axis)
    }

    /// The point of B farthest against a unit vector of A's frame.
    fn foot_of_b(&self, axis: DVec3) -> DVec3 {
        let turn = Mat3::from_quat(self.b_in_a.rotation).as_dmat3();
        let own = (turn.transpose() * -axis).normalize();
        turn * self.b.support(own) + self.b_in_a.position.as_dvec3()
    }

    /// Where the shapes come nearest to each other along a unit vector, on the one that has fewer such places: a hull has a whole face of
    /// them, of which [`Solid::support`] tells any corner.
    pub(super) fn place_along(&self, axis: DVec3, is_a_smaller: bool) -> DVec3 {
        let [is_a_hull, is_b_hull] =
            [self.a, self.b].map(|solid| matches!(solid.form, Form::Hull(_)));
        let is_on_a = match is_a_hull == is_b_hull {
            true => is_a_smaller,
            false => is_b_hull,
        };
        match is_on_a {
            true => self.a.support(axis),
            false => self.foot_of_b(axis),
        }
    }

    /// How far the shapes are apart along a unit vector from A to B, m.
    pub(crate) fn separation(&self, axis: Vec3) -> f64 {
        let axis = axis.as_dvec3().normalize();
        axis.dot(self.foot_of_b(axis) - self.a.support(axis))
    }

    /// A direction from A to B, and how far they are apart along it.
    fn along(&self, normal: Vec3, inner: Option<DVec3>) -> PairAxis {
        PairAxis {
            normal,
            separation: self.separation(normal),
            inner,
        }
    }

    /// From the middle of A to that of B; none if it is one point.
    fn between(&self) -> Option<Vec3> {
        let middle = self.b_in_a.transform_point(self.b.middle());
        (middle - self.a.middle()).try_normalize()
    }

    /// The direction and how far they are apart along it, if it is not more than `reach` (m); else a direction that tells so.
    pub(crate) fn axis(&self, reach: f64) -> PairAxis {
        if let Some(between) = self.between() {
            let axis = self.along(between, None);
            if axis.separation > reach {
                return axis;
            }
        }
        let placed = PlacedCore::new(self.b.inner, &self.b_in_a);
        match distance(&self.a.inner, &placed, f64::INFINITY) {
            Separation::Near(Nearest { normal, on_a, .. }) => {
                self.along(self.straightened(normal.as_vec3()), Some(on_a))
            }
            _ => self.way_out(&placed),
        }
    }

    /// The same of shapes whose insides overlap, by the least way on which B gets out of A: of few directions the best one, turned as long as
    /// the way becomes shorter.
    fn way_out(&self, placed: &PlacedCore) -> PairAxis {
        let inner = &self.a.inner;
        let best = WayOut::along(inner, placed, self.deepest().as_dvec3());
        let way = best.turned(inner, placed);
        self.along(self.straightened(way.normal.as_vec3()), way.on_a)
    }

    /// The normal of a face or a side that looks along a direction from A to B, or else the direction.
    fn straightened(&self, axis: Vec3) -> Vec3 {
        if let Some(normal) = self.a.normal_near(axis) {
            return normal;
        }
        let of_b = self.b.normal_near(-self.seen_from_b(axis));
        of_b.map_or(axis, |normal| -rotate(self.b_in_a.rotation, normal))
    }

    /// Of the directions that may part shapes which overlap by more than they are rounded, the one along which they do least.
    fn deepest(&self) -> Vec3 {
        let mut best = (f64::NEG_INFINITY, Vec3::Y);
        let mut weigh = |axis: Vec3| {
            let separation = self.separation(axis);
            if separation > best.0 {
                best = (separation, axis);
            }
        };
        let towards = self.between().unwrap_or(Vec3::Y);
        for_normals(&self.a, towards, &mut weigh);
        let turn = self.b_in_a.rotation;
        for_normals(&self.b, -self.seen_from_b(towards), &mut |normal| {
            weigh(-rotate(turn, normal));
        });
        if let (Form::Segment([p, q]), Form::Segment([r, s])) = (self.a.form, self.b.form) {
            let across = (q - p).cross(rotate(turn, s - r)).try_normalize();
            let sided = across.map(|n| if n.dot(towards) < 0.0 { -n } else { n });
            weigh(sided.unwrap_or(towards));
        }
        weigh(towards);
        best.1
    }
}

/// Calls `found` with the normals of a shape that may part it from something in a direction.
fn for_normals(solid: &Solid, towards: Vec3, found: &mut dyn FnMut(Vec3)) {
    match solid.form {
        Form::Point(_) => {}
        Form::Segment([a, b]) => {
            let along = (b - a).normalize();
            let across = towards - towards.dot(along) * along;
            found(across.try_normalize().unwrap_or(towards));
        }
        Form::Hull(hull) => hull
            .faces()
            .iter()
            .for_each(|face| found(face.plane.normal)),
        Form::Frustum(frustum) => {
            found(Vec3::Y);
            found(Vec3::NEG_Y);
            let across = Vec3::new(towards.x, 0.0, towards.z);
            let out = across.try_normalize().unwrap_or(Vec3::X);
            let n = frustum.side_normal().as_vec2();
            found(n.x * out + n.y * Vec3::Y);
        }
        Form::Triangle([a, b, c]) => {
            if let Some(normal) = (b - a).cross(c - a).try_normalize() {
                found(normal);
                found(-normal);
            }
        }
    }
}
