//! Small mathematics that `glam` does not have: poses, boxes, symmetric matrices, rotation update.

use glam::{DMat3, DVec3, Mat3, Quat, Vec3};

/// A rigid transform: `world_from_body` or `a_from_b`, depending on the name of the variable that holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Pose {
    /// Origin of the inner frame in the outer frame, m.
    pub position: Vec3,
    /// Rotation from the inner to the outer frame, a unit quaternion.
    pub rotation: Quat,
}

impl Pose {
    /// The pose that changes nothing.
    pub const IDENTITY: Self = Self {
        position: Vec3::ZERO,
        rotation: Quat::IDENTITY,
    };

    /// A pose from its two parts.
    pub fn new(position: Vec3, rotation: Quat) -> Self {
        Self { position, rotation }
    }

    /// A place without a turn.
    pub fn from_position(position: Vec3) -> Self {
        Self::new(position, Quat::IDENTITY)
    }

    /// A point of the inner frame, seen from the outer one.
    pub fn transform_point(&self, point: Vec3) -> Vec3 {
        rotate(self.rotation, point) + self.position
    }

    /// A point of the outer frame, seen from the inner one.
    pub fn inverse_transform_point(&self, point: Vec3) -> Vec3 {
        rotate(self.rotation.inverse(), point - self.position)
    }

    /// The inverse transform.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.inverse();
        Self {
            position: rotate(rotation, -self.position),
            rotation,
        }
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        self.position.is_finite() && self.rotation.is_finite()
    }
}

/// A pose in a frame that is itself at a pose: `outer_from_inner * inner_from_innermost`.
impl std::ops::Mul for Pose {
    type Output = Self;

    fn mul(self, inner: Self) -> Self {
        Self::new(
            self.transform_point(inner.position),
            (self.rotation * inner.rotation).normalize(),
        )
    }
}

impl Default for Pose {
    fn default() -> Self {
        Self::IDENTITY
    }
}

/// `a b^T`.
pub(crate) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// An axis-aligned box, m. Empty while `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Lower corner.
    pub min: Vec3,
    /// Upper corner.
    pub max: Vec3,
}

impl Aabb {
    /// The box that holds nothing.
    pub const EMPTY: Self = Self {
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
    };

    /// The smallest box around `points`.
    pub fn of_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self {
            min: b.min.min(p),
            max: b.max.max(p),
        })
    }

    /// Edge lengths.
    pub fn extents(&self) -> Vec3 {
        self.max - self.min
    }

    /// Length of the space diagonal: the "size" that tolerances are relative to.
    pub fn diagonal(&self) -> f32 {
        self.extents().length()
    }

    /// Midpoint.
    pub fn center(&self) -> Vec3 {
        0.5 * (self.min + self.max)
    }

    /// The box grown by `margin` on all sides.
    pub fn fattened(&self, margin: f32) -> Self {
        Self {
            min: self.min - margin,
            max: self.max + margin,
        }
    }

    /// The box of all places on a straight way, m.
    pub(crate) fn swept(&self, way: Vec3) -> Self {
        Self {
            min: self.min + way.min(Vec3::ZERO),
            max: self.max + way.max(Vec3::ZERO),
        }
    }

    /// Whether the two boxes touch or overlap.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// Whether `other` lies within this box.
    pub fn contains(&self, other: &Self) -> bool {
        self.min.cmple(other.min).all() && other.max.cmple(self.max).all()
    }
}

impl Default for Aabb {
    /// The box that holds nothing.
    fn default() -> Self {
        Self::EMPTY
    }
}

/// The plane of points `p` with `normal . p = offset`; the positive side is where the normal points.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Plane {
    /// Unit normal.
    pub normal: Vec3,
    /// Signed distance of the plane from the origin along the normal, m.
    pub offset: f32,
}

impl Plane {
    /// The plane through `point` with the given normal; the normal is scaled to unit length.
    ///
    /// A zero or non-finite normal gives a plane of NaNs, which whatever uses the plane refuses.
    pub fn through(point: Vec3, normal: Vec3) -> Self {
        let normal = normal / normal.length();
        Self {
            normal,
            offset: normal.dot(point),
        }
    }

    /// Signed distance of `point`, positive on the side of the normal, m.
    pub fn distance(&self, point: Vec3) -> f32 {
        self.normal.dot(point) - self.offset
    }

    /// The same plane with its sides exchanged.
    pub fn flipped(&self) -> Self {
        Self {
            normal: -self.normal,
            offset: -self.offset,
        }
    }

    /// The plane seen from the inner frame of `pose`, if `self` is given in the outer one.
    pub fn in_frame_of(&self, pose: &Pose) -> Self {
        Self {
            normal: rotate(pose.rotation.inverse(), self.normal),
            offset: self.offset - self.normal.dot(pose.position),
        }
    }
}

/// The matrix `s` with `s * v = a x v`.
pub fn skew(a: Vec3) -> Mat3 {
    Mat3::from_cols(
        Vec3::new(0.0, a.z, -a.y),
        Vec3::new(-a.z, 0.0, a.x),
        Vec3::new(a.y, -a.x, 0.0),
    )
}

/// Two unit vectors that form a right-handed orthonormal frame `(n, t1, t2)` with the unit vector `n`.
///
/// Branch-free apart from one sign; Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
pub fn tangents(n: Vec3) -> [Vec3; 2] {
    let sign = 1.0_f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    [
        Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        Vec3::new(b, sign + n.y * n.y * a, -n.y),
    ]
}

/// `v` turned by the unit quaternion `rotation`: `v + 2 w (u x v) + 2 u x (u x v)` with `rotation = (u, w)`.
///
/// Used in place of the product of `glam`, which fuses multiplications and additions where the compiler is allowed to, so
/// that a build for a newer processor would give other bits.
pub fn rotate(rotation: Quat, v: Vec3) -> Vec3 {
    let u = rotation.xyz();
    let t = 2.0 * u.cross(v);
    v + rotation.w * t + u.cross(t)
}

/// Angle of the point `(x, y)` from the x axis, rad, in `-pi..=pi`; 0 at the origin. To some 1e-15.
///
/// Halving the angle twice, `tan(phi / 2) = t / (1 + sqrt(1 + t^2))`, leaves a tangent of at most 0.2, for which the series is short.
/// Stands in for the function of the platform's library, which differs between platforms.
pub(crate) fn atan2(y: f64, x: f64) -> f64 {
    use std::f64::consts::{FRAC_PI_2, PI};
    let (small, large) = (x.abs().min(y.abs()), x.abs().max(y.abs()));
    if large == 0.0 {
        return 0.0;
    }
    let half = |t: f64| t / (1.0 + (1.0 + t * t).sqrt());
    let t = half(half(small / large));
    let square = t * t;
    let series = (0..12)
        .rev()
        .fold(0.0, |sum, k| 1.0 / f64::from(2 * k + 1) - square * sum);
    let octant = 4.0 * t * series;
    let quadrant = if y.abs() > x.abs() {
        FRAC_PI_2 - octant
    } else {
        octant
    };
    let angle = if x < 0.0 { PI - quadrant } else { quadrant };
    angle.copysign(y)
}

/// `rotation` after turning for `h` seconds with the world-frame angular velocity `omega` (rad/s).
///
/// The increment is `q = (1, tan(phi / 2))` about `omega`, normalised, with two terms of the series of the tangent: exact
/// to `phi^5 / 120` for an angle `phi = h |omega|`, and without any transcendental function.
pub fn rotate_by(rotation: Quat, omega: Vec3, h: f32) -> Quat {
    let turn = h * omega;
    let half = 0.5 * (1.0 + turn.length_squared() / 12.0) * turn;
    (Quat::from_xyzw(half.x, half.y, half.z, 1.0) * rotation).normalize()
}
