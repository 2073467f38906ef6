//! Where two bodies are against each other, as a joint sees it: the value of each axis, and how it changes with their velocities.
//!
//! Symbols, all in world axes: `x` center of mass, `r` from it to the anchor, `d` from A's anchor to B's, `e_i` axes of A's frame,
//! `f_i` axes of B's, `v` and `omega` velocities. A row has the velocity `J v = j_a . (v_a, omega_a) + j_b . (v_b, omega_b)`.
//!
//! | axis | value | Jacobian of B | of A |
//! |---|---|---|---|
//! | linear | `e_i . d` | `(e_i, r_b x e_i)` | `-(e_i, (r_a + d) x e_i)`: the axis turns with A |
//! | distance | `\|d\|` | `(u, r_b x u)`, `u = d / \|d\|` | `-(u, r_a x u)` |
//! | three locked angles | `2 vec(q)`, `q` = B's frame in A's | `(0, e_i)` | `-(0, e_i)` |
//! | swings of a hinge | `-f_x . e_z`, `f_x . e_y` | `(0, e_z x f_x)`, `(0, f_x x e_y)` | the same, negative |
//! | two locked angles of what turns about another axis | the same of that axis | | |
//! | a locked swing alone | the same | | |
//! | twist | `2 atan(q_x / q_w)` | `(0, (e_x + f_x) / (1 + e_x . f_x))` | the same, negative |
//! | swing | angle `phi` of `e_x x f_x` along `e_y` or `e_z` | `(0, n_i n + t_i phi (cot(phi) t + e_x))`, `n` along `e_x x f_x`, `t = e_x x n` | the same, negative |
//! | cone | what is left of the ellipse of the two half-angles | `-(0, n)`, `n` across it | the same, negative |
//!
//! A swing changes with a turn about `e_x` too, which carries `n` along: with `e_i` alone as its Jacobian, springs about two axes are no gradient of
//! what they store, and undamped ones gained a thousand times their energy in twenty turns.
//!
//! The twist is that of the decomposition `q = swing twist`, which turns about x first. Its rate follows from `f_x` being carried
//! along without turning about itself.
//!
//! # References
//! Dobrowolski, "Swing-Twist Decomposition in Clifford Algebra", 2015; Catto, "3D Constraint Derivations for Impulse Solvers".

use crate::joints::axis::{AxisRange, JointAxis};
use crate::joints::joint::Joint;
use crate::math::atan2;
use crate::solver::joint::vector6::{Vector6, join};
use glam::{DMat3, DQuat, DVec3};
use smallvec::SmallVec;

/// A body where a joint is: center of mass and rotation, world, and the joint's frame, relative to the center of mass, body's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Place {
    pub(crate) center: DVec3,
    pub(crate) rotation: DQuat,
}

/// What one axis of a joint has come to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measure {
    /// Of the joint's seven: linear, angular, distance.
    pub(crate) axis: usize,
    /// m or rad; of a cone how much of it is left.
    pub(crate) value: f64,
    pub(crate) jacobian: [Vector6; 2],
    /// Whether the axis is held or limited there.
    pub(crate) has_range: bool,
    /// Whether the range is that of a cone: what is left is not to become negative.
    pub(crate) is_cone: bool,
    /// Whether drive and friction act there.
    pub(crate) is_driven: bool,
}

pub(crate) type Measures = SmallVec<[Measure; 10]>;

/// Number of the distance among the axes.
pub(crate) const DISTANCE: usize = 6;

/// Largest share of a turn across a swing that changes it.
const MOST_ACROSS: f64 = 10.0;

/// Smallest length that has a direction.
const TINY: f64 = 1e-9;

/// A joint's frames in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frames {
    /// From the centers of mass to the anchors, m.
    pub(crate) r: [DVec3; 2],
    /// From A's anchor to B's, m.
    pub(crate) d: DVec3,
    /// Axes of the frames.
    pub(crate) axes: [DMat3; 2],
    /// B's frame in A's, with a scalar part that is not negative.
    relative: DQuat,
}

impl Frames {
    /// `anchors`: from centers of mass, body's axes; `frames`: `body_from_joint`. Without `has_angles` nothing is to be asked about angles.
    #[inline(always)]
    pub(crate) fn of(
        places: [&Place; 2],
        anchors: [DVec3; 2],
        frames: [DQuat; 2],
        has_angles: bool,
    ) -> Self {
        let arm = |i: usize| DMat3::from_quat(places[i].rotation) * anchors[i];
        let r = [arm(0), arm(1)];
        let on_a = places[0].rotation * frames[0];
        let axes = DMat3::from_quat(on_a);
        let mut all = Self {
            r,
            d: (places[1].center - places[0].center) + (r[1] - r[0]),
            axes: [axes; 2],
            relative: DQuat::IDENTITY,
        };
        if has_angles {
            let on_b = places[1].rotation * frames[1];
            let relative = on_a.conjugate() * on_b;
            all.axes[1] = DMat3::from_quat(on_b);
            all.relative = if relative.w < 0.0 {
                -relative
            } else {
                relative
            };
        }
        all
    }

    /// How far B's anchor is from A's, axes of A's frame, m.
    pub(crate) fn translation(&self) -> DVec3 {
        self.axes[0].transpose() * self.d
    }

    /// Twist, the nearest to `last` of those that are the same but for full turns, rad.
    pub(crate) fn twist(&self, last: f64) -> f64 {
        const TURN: f64 = std::f64::consts::TAU;
        let angle = 2.0 * atan2(self.relative.x, self.relative.w);
        angle + TURN * ((last - angle) / TURN).round()
    }

    /// What the axes of a joint have come to that do anything. `last`: twist in the last step, rad.
    #[inline(always)]
    pub(crate) fn measure(&self, joint: &Joint, last: f64) -> Measures {
        let mut measures = Measures::new();
        for (i, axis) in joint.linear.iter().enumerate() {
            if does_anything(axis) {
                let e = self.axes[0].col(i);
                let on_a = join(-e, e.cross(self.r[0] + self.d));
                measures.push(both(i, e.dot(self.d), [on_a, join(e, self.r[1].cross(e))]));
            }
        }
        if does_anything(&joint.distance) {
            let length = self.d.length();
            let u = if length > TINY {
                self.d / length
            } else {
                self.axes[0].x_axis
            };
            let jacobian = [join(-u, u.cross(self.r[0])), join(u, self.r[1].cross(u))];
            measures.push(both(DISTANCE, length, jacobian));
        }
        if has_angles(joint) {
            self.measure_angles(joint, last, &mut measures);
        }
        measures
    }

    /// What the axis of a row that keeps a place has come to, as [`measure`](Self::measure) says; whether that is what is left of a cone.
    #[inline(always)]
    pub(crate) fn value(&self, joint: &Joint, axis: usize, last: f64) -> Option<(f64, bool)> {
        match axis {
            DISTANCE => Some((self.d.length(), false)),
            0..3 => Some((self.axes[0].col(axis).dot(self.d), false)),
            _ => self.angle_value(joint, axis, last),
        }
    }

    /// The same of an angle.
    fn angle_value(&self, joint: &Joint, axis: usize, last: f64) -> Option<(f64, bool)> {
        let value = match axis {
            _ if is_fixed(joint) => self.small_angles()[axis - 3],
            _ => match (self.held_by(joint, axis - 3), cone_of(joint)) {
                (Some(of), _) => {
                    let (across, sign) = self.across(axis - 3, of);
                    sign * self.axes[1].col(of).dot(across)
                }
                _ if axis == 3 => self.twist(last),
                (None, Some(_)) if axis > 4 => return None,
                (None, Some(half_angles)) => {
                    let measure = self.cone(self.swing(), half_angles)?;
                    return Some((measure.value, true));
                }
                (None, None) => self.swing()[axis - 4],
            },
        };
        Some((value, false))
    }

    /// Angles about A's axes, of a joint that lets none move.
    fn small_angles(&self) -> [f64; 3] {
        [self.relative.x, self.relative.y, self.relative.z].map(|error| 2.0 * error)
    }

    /// Which axis of B's frame is to stay across one of A's that holds an angle, if that is how the angle is measured: where two are held the axis
    /// of the third, about which B turns; where only a swing is held the first, which stays in a plane. Unlike twist and swings that says
    /// what is held after half a turn too.
    fn held_by(&self, joint: &Joint, i: usize) -> Option<usize> {
        let is_locked = |i: usize| joint.angular[i % 3].range == AxisRange::Locked;
        match [is_locked(i), is_locked(i + 1), is_locked(i + 2)] {
            [true, true, false] => self.turns_about((i + 2) % 3),
            [true, false, true] => self.turns_about((i + 1) % 3),
            [true, false, false] if i > 0 => Some(0),
            _ => None,
        }
    }

    /// An axis of both frames, unless they point against each other.
    fn turns_about(&self, i: usize) -> Option<usize> {
        let [on_a, on_b] = self.axes.map(|axes| axes.col(i));
        (on_a.dot(on_b) > 0.0).then_some(i)
    }

    /// The axis of A's towards which axis `of` of B's frame goes as B turns about axis `i`, and in which direction.
    fn across(&self, i: usize, of: usize) -> (DVec3, f64) {
        let is_next = (of + 1) % 3 == i;
        let sign = if is_next { -1.0 } else { 1.0 };
        (self.axes[0].col(3 - i - of), sign)
    }

    fn measure_angles(&self, joint: &Joint, last: f64, measures: &mut Measures) {
        if is_fixed(joint) {
            for (i, angle) in self.small_angles().into_iter().enumerate() {
                let jacobian = about(self.axes[0].col(i));
                measures.push(both(3 + i, angle, jacobian));
            }
            return;
        }
        let (e, f) = (&self.axes[0], self.axes[1].x_axis);
        let cone = cone_of(joint);
        for i in 0..3 {
            let axis = &joint.angular[i];
            if !does_anything(axis) {
                continue;
            }
            let measure = if let Some(of) = self.held_by(joint, i) {
                let (across, sign) = self.across(i, of);
                let f = self.axes[1].col(of);
                let value = sign * f.dot(across);
                both(3 + i, value, about(sign * f.cross(across)))
            } else if i == 0 {
                let share = (1.0 + e.x_axis.dot(f)).max(TINY);
                let jacobian = about((e.x_axis + f) / share);
                both(3, self.twist(last), jacobian)
            } else {
                both(3 + i, self.swing()[i - 1], about(self.swing_rate(i)))
            };
            let has_range = measure.has_range && (i == 0 || cone.is_none());
            measures.push(Measure {
                has_range,
                ..measure
            });
        }
        if let Some(half_angles) = cone {
            measures.extend(self.cone(self.swing(), half_angles));
        }
    }

    /// The rotation that takes A's x axis to B's, along A's y and z axes, rad.
    fn swing(&self) -> [f64; 2] {
        let (e, f) = (&self.axes[0], self.axes[1].x_axis);
        let axis = e.x_axis.cross(f);
        let sine = axis.length();
        let cosine = e.x_axis.dot(f);
        if sine < TINY {
            let angle = if cosine < 0.0 {
                std::f64::consts::PI
            } else {
                0.0
            };
            return [angle, 0.0];
        }
        let angle = atan2(sine, cosine) / sine;
        [angle * axis.dot(e.y_axis), angle * axis.dot(e.z_axis)]
    }

    /// The direction such that the swing about axis 1 or 2 changes with a turn of B along it.
    fn swing_rate(&self, i: usize) -> DVec3 {
        let (e, f) = (&self.axes[0], self.axes[1].x_axis);
        let axis = e.x_axis.cross(f);
        let (sine, cosine) = (axis.length(), e.x_axis.dot(f));
        if sine < TINY {
            return e.col(i);
        }
        let n = axis / sine;
        let t = e.x_axis.cross(n);
        let angle = atan2(sine, cosine);
        // Where the axes point against each other any swing is as good.
        let across = (angle * cosine / sine).max(-MOST_ACROSS);
        n * n.dot(e.col(i)) + t.dot(e.col(i)) * (across * t + angle * e.x_axis)
    }

    /// How much is left between a swing and the ellipse of the half-angles, across the ellipse.
    fn cone(&self, swing: [f64; 2], half_angles: [f64; 2]) -> Option<Measure> {
        let scaled = [0, 1].map(|i| swing[i] / half_angles[i]);
        let size = (scaled[0] * scaled[0] + scaled[1] * scaled[1]).sqrt();
        if size < TINY {
            return None;
        }
        let gradient = [0, 1].map(|i| scaled[i] / (half_angles[i] * size));
        let steepness = (gradient[0] * gradient[0] + gradient[1] * gradient[1]).sqrt();
        let [y, z] = gradient.map(|g| g / steepness);
        let across = self.axes[0].y_axis * y + self.axes[0].z_axis * z;
        Some(Measure {
            is_cone: true,
            is_driven: false,
            ..both(4, (1.0 - size) / steepness, about(-across))
        })
    }
}

/// Half-angles of the cone that two swings with limits make, rad.
fn cone_of(joint: &Joint) -> Option<[f64; 2]> {
    let half = |axis: &JointAxis| match axis.range {
        AxisRange::Limited { min, max } if min == -max && max > 0.0 => Some(f64::from(max)),
        _ => None,
    };
    Some([half(&joint.angular[1])?, half(&joint.angular[2])?])
}

/// Whether no angle may change.
fn is_fixed(joint: &Joint) -> bool {
    let mut axes = joint.angular.iter();
    axes.all(|axis| axis.range == AxisRange::Locked)
}

/// Whether angles make rows.
#[inline(always)]
pub(crate) fn has_angles(joint: &Joint) -> bool {
    joint.angular.iter().any(does_anything)
}

/// Whether an axis makes rows.
#[inline(always)]
fn does_anything(axis: &JointAxis) -> bool {
    axis.range != AxisRange::Free || axis.drive.is_some() || axis.friction > 0.0
}

#[inline(always)]
fn both(axis: usize, value: f64, jacobian: [Vector6; 2]) -> Measure {
    Measure {
        axis,
        value,
        jacobian,
        has_range: true,
        is_cone: false,
        is_driven: true,
    }
}

/// The Jacobian of a turn of B against A about an axis.
fn about(axis: DVec3) -> [Vector6; 2] {
    [join(DVec3::ZERO, -axis), join(DVec3::ZERO, axis)]
}
