//! Boxes against triangles, at rest and on their way, by the thirteen axes along which they can be apart: the box's own three, the
//! triangle's normal, and those across an edge of each.
//!
//! Along an axis the box reaches so far, and the triangle from here to there; while the box moves, they are together along it from one
//! moment to another. Where they are so along all axes at once, they touch. In the frame of the box the three axes across one edge of the
//! triangle need one cross product for each corner.
//!
//! # References
//! S. Gottschalk, M. Lin, D. Manocha, "OBBTree: A Hierarchical Structure for Rapid Interference Detection", SIGGRAPH 1996.

use crate::geometry::level_triangle::LevelTriangle;
use crate::query::cuboid::{Cuboid, PARALLEL, Told};
use crate::query::local::LocalCast;
use glam::{BVec3A, Mat3A, Vec3A};

/// Rounding of a gap along an axis, as a share of coordinates.
const ROUNDING: f32 = 2e-6;

/// Least rate at which a box moves along an axis: what does not move has no moment to divide by.
const STILL: f32 = 1e-30;

/// A box that sees triangles in its own frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoxView {
    /// Into the box's frame.
    turn: Mat3A,
    center: Vec3A,
    half: Vec3A,
}

/// A box and a triangle along three axes, which need not be of unit length.
struct Spans {
    /// How far the box reaches, both ways.
    reach: Vec3A,
    /// From where to where the triangle is, as seen from the middle of the box.
    low: Vec3A,
    high: Vec3A,
    /// Length of each, or up to a factor of 1.5 more.
    lengths: Vec3A,
    /// Length of what they are made from, or more: rounding is a share of this.
    scale: f32,
    /// How far the box moves along them for each metre of its way.
    rates: Vec3A,
}

impl Spans {
    /// From where to where on its way the box, with so much more around it, is together with the triangle along each axis.
    #[inline(always)]
    fn together(&self, more: f32, inverse_rates: Vec3A) -> (Vec3A, Vec3A) {
        let reach = self.reach + Vec3A::splat(more);
        let (low, high) = (self.low - reach, self.high + reach);
        let (low, high) = (low * inverse_rates, high * inverse_rates);
        (low.min(high), low.max(high))
    }
}

impl BoxView {
    pub(crate) fn of(cuboid: &Cuboid) -> Self {
        Self {
            turn: cuboid.axes.transpose().into(),
            center: cuboid.center.into(),
            half: cuboid.half.into(),
        }
    }

    /// Tells `visit` of all axes, and what rounding leaves open of a gap along one of unit length (m); `direction`: unit vector of the box's
    /// motion, its own frame.
    #[inline(always)]
    fn for_axes(
        &self,
        triangle: &LevelTriangle,
        direction: Vec3A,
        mut visit: impl FnMut(&Spans, f32),
    ) {
        let corners = triangle.corners.map(Vec3A::from);
        let size = corners
            .iter()
            .fold(self.center.abs(), |size, corner| size.max(corner.abs()));
        let slack = ROUNDING * (size.max_element() + self.half.element_sum());
        let [a, b, c] = corners.map(|corner| self.turn * (corner - self.center));
        let of_box = Spans {
            reach: self.half,
            low: a.min(b).min(c),
            high: a.max(b).max(c),
            lengths: Vec3A::ONE,
            scale: 1.0,
            rates: direction,
        };
        visit(&of_box, slack);
        let normal = self.turn * Vec3A::from(triangle.plane.normal);
        let height = Vec3A::splat(normal.dot(a));
        let across = Spans {
            reach: Vec3A::splat(normal.abs().dot(self.half)),
            low: height,
            high: height,
            lengths: Vec3A::ONE,
            scale: 1.0,
            rates: Vec3A::splat(normal.dot(direction)),
        };
        visit(&across, slack);
        for (from, to, beside) in [(a, b, c), (b, c, a), (c, a, b)] {
            let edge = to - from;
            let (own, other) = (edge.cross(from), edge.cross(beside));
            let [x, y, z] = edge.abs().to_array();
            let [hx, hy, hz] = self.half.to_array();
            let spans = Spans {
                reach: Vec3A::new(hy * z + hz * y, hx * z + hz * x, hx * y + hy * x),
                low: own.min(other),
                high: own.max(other),
                lengths: Vec3A::new(y + z, x + z, x + y),
                scale: x + y + z,
                rates: edge.cross(direction),
            };
            visit(&spans, slack);
        }
    }

    /// Whether the box overlaps a triangle or touches it.
    pub(crate) fn against(&self, triangle: &LevelTriangle) -> Told {
        let (mut is_apart, mut is_sure) = (BVec3A::FALSE, BVec3A::TRUE);
        self.for_axes(triangle, Vec3A::ZERO, |spans, slack| {
            let gaps = spans.low.max(-spans.high) - spans.reach;
            let slack = Vec3A::splat(spans.scale * slack);
            is_apart |= gaps.cmpgt(slack);
            // Edges that are parallel to those of the box tell nothing that the other axes do not.
            let is_void = spans.lengths.cmple(Vec3A::splat(PARALLEL * spans.scale));
            is_sure &= gaps.cmplt(-slack) | is_void;
        });
        match (is_apart.any(), is_sure.all()) {
            (true, _) => Told::Apart,
            (false, true) => Told::Overlap,
            (false, false) => Told::Nothing(triangle.plane.normal),
        }
    }
}

/// A box that moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoxSweep {
    view: BoxView,
    /// Unit vector, the box's frame.
    direction: Vec3A,
    /// The radius around the box, and gaps that count as none, m.
    touch: f32,
}

impl BoxSweep {
    /// The sweep that a cast of a box, with any radius, is.
    pub(crate) fn of(cast: &LocalCast) -> Option<Self> {
        let view = BoxView::of(&Cuboid::of(&cast.core)?);
        Some(Self {
            view,
            direction: view.turn * Vec3A::from(cast.direction),
            touch: cast.radius + 2.0 * cast.touch,
        })
    }

    /// When the box meets a triangle, if it may do so up to `end` (m).
    pub(crate) fn meeting(&self, triangle: &LevelTriangle, end: f32) -> Option<Meeting> {
        let (mut first, mut last) = (Vec3A::ZERO, Vec3A::splat(end));
        let (mut sure_first, mut sure_last) = (first, last);
        self.view
            .for_axes(triangle, self.direction, |spans, slack| {
                let is_still = spans.rates.abs().cmplt(Vec3A::splat(STILL));
                let inverse = Vec3A::select(is_still, Vec3A::splat(STILL), spans.rates).recip();
                let (begin, end) = spans.together(spans.scale * (self.touch + slack), inverse);
                (first, last) = (first.max(begin), last.min(end));
                let (begin, end) = spans.together(-spans.scale * slack, inverse);
                (sure_first, sure_last) = (sure_first.max(begin), sure_last.min(end));
            });
        let soonest = first.max_element();
        let surely = sure_first.max_element();
        (soonest <= last.min_element()).then_some(Meeting {
            soonest,
            latest: if surely <= sure_last.min_element() {
                surely
            } else {
                f32::INFINITY
            },
        })
    }
}

/// When a box meets a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    /// It touches nothing before, m.
    pub(crate) soonest: f32,
    /// It has met it by then, m; infinite if rounding leaves open whether it does.
    pub(crate) latest: f32,
}

#[cfg(test)]
mod tests {
    use super::{BoxSweep, BoxView};
    use crate::geometry::distance::{CoreCast, Separation, distance};
    use crate::geometry::level_triangle::{EdgeKind, LevelTriangle};
    use crate::geometry::support::{Core, PlacedCore};
    use crate::math::{Aabb, Plane, Pose};
    use crate::query::cuboid::{Cuboid, Told};
    use crate::query::local::LocalCast;
    use glam::{Quat, Vec3};

    /// Random boxes and triangles, of which a part is thin, lies along the axes, or far away.
    struct Members {
        state: u32,
        /// Where they are, m.
        place: Vec3,
    }

    impl Members {
        fn new(seed: u32) -> Self {
            Self {
                state: seed,
                place: Vec3::ZERO,
            }
        }

        /// From -1 to 1.
        fn number(&mut self) -> f32 {
            let next = self.state.wrapping_mul(1_664_525);
            self.state = next.wrapping_add(1_013_904_223);
            2.0 * (self.state >> 8) as f32 / (1 << 24) as f32 - 1.0
        }

        fn vector(&mut self) -> Vec3 {
            Vec3::new(self.number(), self.number(), self.number())
        }

        fn one_in(&mut self, count: u32) -> bool {
            self.number();
            (self.state >> 16).is_multiple_of(count)
        }

        /// What rounding leaves open of a distance, m.
        fn rounding(&self) -> f32 {
            1e-5 * (1.0 + self.place.length())
        }

        /// The next ones are elsewhere.
        fn go(&mut self) {
            let is_far = self.one_in(4);
            self.place = if is_far { 30.0 } else { 0.0 } * self.vector();
        }

        fn triangle(&mut self) -> LevelTriangle {
            let mut corners = [self.vector(), self.vector(), self.vector()];
            if self.one_in(3) {
                // With edges along the axes, as floors have them.
                let [a, b, _] = corners;
                corners[1] = Vec3::new(b.x, a.y, a.z);
                corners[2] = Vec3::new(a.x, a.y, b.z);
            }
            if self.one_in(5) {
                corners[2] = corners[0].lerp(corners[1], 0.3) + 1e-3 * corners[2];
            }
            let corners = corners.map(|corner| self.place + corner);
            let [a, b, c] = corners;
            let normal = (b - a).cross(c - a).normalize_or(Vec3::Y);
            LevelTriangle {
                corners,
                plane: Plane::through(a, normal),
                edges: [EdgeKind::Open; 3],
                index: 0,
            }
        }

        /// A box, as an aligned one at a pose.
        fn cuboid(&mut self, away: f32) -> PlacedCore<'static> {
            let mut half = self.vector().abs() + Vec3::splat(1e-3);
            if self.one_in(4) {
                half.y *= 1e-3;
            }
            let turn = if self.one_in(3) {
                Quat::IDENTITY
            } else {
                Quat::from_scaled_axis(3.0 * self.vector())
            };
            let bounds = Aabb {
                min: -half,
                max: half,
            };
            let place = Pose::new(self.place + away * self.vector(), turn);
            PlacedCore::new(Core::Box(bounds), &place)
        }
    }

    #[test]
    fn what_axes_tell_of_a_box_and_a_triangle_is_so() {
        let mut members = Members::new(3);
        let mut told = [0; 3];
        for _ in 0..20_000 {
            members.go();
            let (triangle, core) = (members.triangle(), members.cuboid(1.5));
            let view = BoxView::of(&Cuboid::of(&core).expect("a box"));
            let found = distance(&Core::of_triangle(triangle.corners), &core, f64::INFINITY);
            let gap = match found {
                Separation::Near(nearest) => nearest.distance,
                Separation::Overlap | Separation::Far => 0.0,
            };
            match view.against(&triangle) {
                Told::Apart => {
                    assert!(gap > 0.0, "{triangle:?} {core:?}");
                    told[0] += 1;
                }
                Told::Overlap => {
                    assert!(
                        (gap as f32) < members.rounding(),
                        "{gap} {triangle:?} {core:?}"
                    );
                    told[1] += 1;
                }
                Told::Nothing(_) => told[2] += 1,
            }
        }
        assert!(
            told[0] > 5000 && told[1] > 2000 && told[2] < 100,
            "{told:?}"
        );
    }

    #[test]
    fn boxes_meet_triangles_when_axes_say_so() {
        let mut members = Members::new(4);
        let mut met = [0; 2];
        for _ in 0..50_000 {
            members.go();
            let (triangle, core) = (members.triangle(), members.cuboid(6.0));
            let middle = core.middle().as_vec3();
            let to = triangle.corners[0] + members.vector() - middle;
            let Some(direction) = to.try_normalize() else {
                continue;
            };
            let (end, touch) = (12.0, 4e-6_f32);
            let cast = LocalCast {
                core,
                radius: 0.0,
                direction,
                free: 0.0,
                end,
                touch,
            };
            let meeting = BoxSweep::of(&cast).expect("a box").meeting(&triangle, end);
            let exact = CoreCast {
                direction: direction.as_dvec3(),
                free: 0.0,
                length: f64::from(end),
                radius: 0.0,
                touch: f64::from(touch),
            };
            let exact = exact.first_touch(&Core::of_triangle(triangle.corners), &core);
            let Some(touch) = exact else {
                let latest = meeting.map_or(f32::INFINITY, |meeting| meeting.latest);
                assert!(latest == f32::INFINITY, "{meeting:?} {triangle:?} {cast:?}");
                continue;
            };
            let meeting = meeting.expect("it touches");
            let distance = touch.distance as f32;
            // A gap of rounding is closed in so much more of the way where the motion hardly leads into the triangle.
            let rate = touch
                .nearest
                .map_or(1.0, |nearest| -nearest.normal.dot(direction.as_dvec3()));
            let slack = members.rounding() * (1.0 + 2.0 / rate.max(1e-4) as f32);
            assert!(meeting.soonest <= distance + slack, "{meeting:?} {touch:?}");
            assert!(distance <= meeting.latest + slack, "{meeting:?} {touch:?}");
            met[usize::from(meeting.latest.is_finite())] += 1;
        }
        assert!(met[1] > 10_000 && met[0] < 100, "{met:?}");
    }
}
