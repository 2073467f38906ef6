//! Free rotation of a body: keeps the length of its angular momentum and its energy to rounding.
//!
//! In the principal frame the angular momentum `L = I w` of a free body turns against the body: `L' = C^-1 L` with the
//! rotation `C` that the body makes against the frame, here by the angular velocity in the middle of the step, implicit
//! midpoint `w_mid = (w + w') / 2`, which keeps the energy too. A rotation keeps lengths, so `|L|` cannot drift; explicit
//! integration of Euler's equations gains energy without bound, and implicit Euler loses it until the body spins about
//! its largest moment only. Double precision, because the moments of a splinter differ by a million.
//!
//! # References
//! Simo and Wong, "Unconditionally Stable Algorithms for Rigid Body Dynamics that Exactly Preserve Energy and Momentum",
//! 1991, for the midpoint form.

use crate::math::rotate_by;
use glam::{DVec3, Quat, Vec3};

/// Turns per step (rad) below which a body's rotation is taken as steady and its pose is updated once per step.
const SLOW: f32 = 1e-4;

/// Most iterations for the angular velocity in the middle. The first guess is off by about `(h |w|)^2` of it, and each
/// iteration gains a factor of about `h |w|`, less than a tenth.
const ITERATIONS: u32 = 4;

/// Part of the angular velocity that its error in the middle may be: what rounding it to `f32` adds in a step is larger than
/// this by four orders, and of either sign.
const NEGLIGIBLE: f64 = 1e-11;

/// A body that turns so fast that its axes must be followed within a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spin {
    /// `world_from_body` now.
    pub rotation: Quat,
    /// `body_from_principal`.
    frame: Quat,
    /// Principal moments over the largest one.
    moments: DVec3,
}

impl Spin {
    /// The state of a body, if it turns by more than a hair in the step of `step` seconds.
    ///
    /// - `rotation`: `world_from_body`
    /// - `frame`, `principal`: `body_from_principal` and principal moments, kg m2
    /// - `omega`: angular velocity, world axes, rad/s
    pub fn of(
        rotation: Quat,
        frame: Quat,
        principal: Vec3,
        omega: Vec3,
        step: f32,
    ) -> Option<Self> {
        let is_sphere = principal.x == principal.y && principal.y == principal.z;
        if is_sphere || omega.length() * step < SLOW {
            return None;
        }
        Some(Self {
            rotation,
            frame,
            moments: (principal / principal.max_element()).as_dvec3(),
        })
    }

    /// Turns the body for `h` seconds; returns the free angular velocity after it, from `omega` before (world, rad/s).
    pub fn advance(&mut self, omega: Vec3, h: f32) -> Vec3 {
        let step = f64::from(h);
        let w = rotate_exactly((self.rotation * self.frame).inverse(), omega.as_dvec3());
        let momentum = self.moments * w;
        let mut middle = w - 0.5 * step * w.cross(momentum) / self.moments;
        let turn = step * w.length();
        let mut error = turn * turn;
        for _ in 0..ITERATIONS {
            if error < NEGLIGIBLE {
                break;
            }
            error *= turn;
            let after = turned_back(momentum, middle, step) / self.moments;
            middle = 0.5 * (w + after);
        }
        let after = turned_back(momentum, middle, step) / self.moments;
        let middle = rotate_exactly(self.rotation * self.frame, middle);
        self.rotation = rotate_by(self.rotation, middle.as_vec3(), h);
        rotate_exactly(self.rotation * self.frame, after).as_vec3()
    }
}

/// `v` turned by `rotation`, without the change of length that the rounding of the quaternion's own length makes: it has a
/// direction, and thousands of sub-steps would add it up.
fn rotate_exactly(rotation: Quat, v: DVec3) -> DVec3 {
    let q = rotation.as_dquat();
    let u = DVec3::new(q.x, q.y, q.z);
    let t = u.cross(v);
    v + 2.0 / (u.length_squared() + q.w * q.w) * (q.w * t + u.cross(t))
}

/// `v` seen from a frame that has turned for `h` seconds with `omega`; the rotation of [`rotate_by`].
fn turned_back(v: DVec3, omega: DVec3, h: f64) -> DVec3 {
    let turn = h * omega;
    let half = 0.5 * (1.0 + turn.length_squared() / 12.0) * turn;
    // The unit quaternion (half, 1) / n, reversed: v - 2 w (u x v) + 2 u x (u x v).
    let scale = 2.0 / (1.0 + half.length_squared());
    let t = half.cross(v);
    v + scale * (half.cross(t) - t)
}
