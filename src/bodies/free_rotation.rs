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

use crate::mass::MassProperties;
use crate::math::{rotate, rotate_by};
use crate::simd::dispatch::run;
use crate::simd::doubles::Doubles;
use crate::simd::lanes::{Kernel, LaneWidth, Lanes};
use crate::simd::vec3::V3;
use crate::tuning::SPINS_WORTH_LANES;
use glam::{DVec3, Quat, Vec3};

/// Turns per step (rad) below which a body's rotation is taken as steady and its pose is updated once per step.
const SLOW: f32 = 1e-4;

/// Turn, rad, that is made at once; what turns farther does so in parts. With 0.1 a splinter whose moments are as 1 to 1000
/// gains 5 % of its energy in 600 turns, and more iterations only make it worse; with 0.05 it stays below 1 %.
const MAX_TURN: f32 = 0.05;

/// Most parts: some 1.9 us for a body alone. With eight sub-steps it takes more than 380 rad/s to need more, at 60 Hz: once
/// round between two pictures, and nobody sees how.
const MAX_PARTS: u32 = 16;

/// Most iterations for the angular velocity in the middle. The first guess is off by about `(h |w|)^3` of it, and each
/// iteration gains a factor of about `h |w|`, at most [`MAX_TURN`].
const ITERATIONS: u32 = 3;

/// Part of the angular velocity that its error in the middle may be: what rounding it to `f32` adds in a step is larger than
/// this by four orders, and of either sign.
const NEGLIGIBLE: f64 = 1e-11;

/// Bodies that turn together.
pub(crate) const SPINS: usize = 8;

/// A body that turns so fast that its axes must be followed within a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeRotation {
    /// `world_from_body` now.
    pub rotation: Quat,
    /// `body_from_principal`.
    frame: Quat,
    /// Principal moments over the largest one.
    moments: DVec3,
}

impl FreeRotation {
    /// The state of a body, if it turns by more than a hair in the step of `step` seconds.
    ///
    /// - `rotation`: `world_from_body`
    /// - `mass`: read only if the body turns; most of a large scene hardly do
    /// - `omega`: angular velocity, world axes, rad/s
    pub fn of(rotation: Quat, mass: &MassProperties, omega: Vec3, step: f32) -> Option<Self> {
        if !Self::is_noticeable(omega, step) {
            return None;
        }
        let principal = mass.principal;
        let is_sphere = principal.x == principal.y && principal.y == principal.z;
        (!is_sphere).then(|| Self::new(rotation, mass))
    }

    /// The state of a body that is followed however slowly it turns.
    pub(crate) fn new(rotation: Quat, mass: &MassProperties) -> Self {
        let largest = mass.principal.max_element();
        Self {
            rotation,
            frame: mass.principal_frame,
            moments: (mass.principal / largest).as_dvec3(),
        }
    }

    /// The state of a body that is kept from turning about some axes: what it turns about does not turn with it.
    pub(crate) fn steady(rotation: Quat) -> Self {
        Self {
            rotation,
            frame: Quat::IDENTITY,
            moments: DVec3::ONE,
        }
    }

    /// Whether a body turns by more than a hair.
    #[inline]
    pub fn is_noticeable(omega: Vec3, step: f32) -> bool {
        omega.length() * step >= SLOW
    }

    /// Energy of rotation with the angular velocity `omega` (world, rad/s), as a share of what the largest moment would have.
    pub(crate) fn energy(&self, omega: Vec3) -> f64 {
        let frame = self.rotation * self.frame;
        let about_axes = rotate(frame.inverse(), omega).as_dvec3();
        self.moments.dot(about_axes * about_axes)
    }

    /// The same, without what rounding makes of a quaternion's length: what is left of it is of second order where the body turns
    /// about a principal axis.
    pub(crate) fn exact_energy(&self, omega: Vec3) -> f64 {
        let frame = self.rotation.as_dquat() * self.frame.as_dquat();
        // Of a unit quaternion: `v + 2 w (u x v) + 2 u x (u x v)`.
        let (u, w) = (-frame.xyz(), frame.w);
        let (v, square) = (omega.as_dvec3(), frame.length_squared());
        let t = 2.0 / square * u.cross(v);
        let about_axes = v + w * t + u.cross(t);
        self.moments.dot(about_axes * about_axes)
    }

    /// Turns the body for `h` seconds; returns the free angular velocity after it, from `omega` before (world, rad/s).
    pub fn advance(&mut self, omega: Vec3, h: f32) -> Vec3 {
        let (mut spin, mut omega) = ([*self], [omega]);
        advance_in_parts(&mut spin, &mut omega, h, advance);
        [*self] = spin;
        omega[0]
    }

    /// Turns a body that is faster than it can be followed: about its angular momentum, without a change of the angular
    /// velocity that it sees itself. Momentum and energy stay what they are, which of all orientations it has is chance.
    fn precess(&mut self, omega: Vec3, h: f32) -> Vec3 {
        let alone = |v: DVec3| V3(v.to_array().map(Doubles::splat));
        let (moments, w) = (alone(self.moments), alone(omega.as_dvec3()));
        let axes = PrincipalAxes::<1>::of(&[*self]);
        let w = axes.inverse().turn(w);
        let momentum = axes.turn(moments.scaled(w));
        self.rotation = rotate_by(self.rotation, get(&momentum, 0), h);
        get(&PrincipalAxes::<1>::of(&[*self]).turn(w), 0)
    }
}

/// In how many parts a body turns, if it can be followed.
fn parts(omega: Vec3, h: f32) -> Option<u32> {
    let parts = ((omega.length() * h / MAX_TURN).ceil() as u32).max(1);
    (parts <= MAX_PARTS).then_some(parts)
}

impl Default for FreeRotation {
    /// A ball.
    fn default() -> Self {
        Self {
            rotation: Quat::IDENTITY,
            frame: Quat::IDENTITY,
            moments: DVec3::ONE,
        }
    }
}

/// Up to [`SPINS`] bodies that turn together.
#[derive(Default)]
pub(crate) struct FreeRotations {
    count: usize,
    spins: [FreeRotation; SPINS],
    omegas: [Vec3; SPINS],
}

impl FreeRotations {
    /// Adds a body with its angular velocity (world, rad/s). There must be room.
    pub(crate) fn push(&mut self, spin: FreeRotation, omega: Vec3) {
        self.spins[self.count] = spin;
        self.omegas[self.count] = omega;
        self.count += 1;
    }

    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// The bodies in the order in which they came, with their angular velocities.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (&FreeRotation, Vec3)> {
        self.spins[..self.count].iter().zip(self.omegas)
    }

    /// Turns all for `h` seconds, each as [`FreeRotation::advance`] does, to the same bits.
    pub(crate) fn advance(&mut self, h: f32, width: LaneWidth) {
        let Self {
            count,
            spins,
            omegas,
        } = self;
        if *count >= SPINS_WORTH_LANES {
            let all = |spins: &mut _, omegas: &mut _, h: &_| {
                run(width, AdvanceAll { spins, omegas, h });
            };
            return advance_in_parts(spins, omegas, h, all);
        }
        let (spins, lone_spin) = spins[..*count].as_chunks_mut();
        let (omegas, lone_omega) = omegas[..*count].as_chunks_mut();
        for (spins, omegas) in spins.iter_mut().zip(omegas) {
            advance_in_parts::<2>(spins, omegas, h, advance);
        }
        for (spin, omega) in lone_spin.iter_mut().zip(lone_omega) {
            *omega = spin.advance(*omega, h);
        }
    }
}

/// Turns bodies by `turn`, those that turn far in parts, and those that are too fast to be followed about their momentum.
#[inline(always)]
fn advance_in_parts<const N: usize>(
    spins: &mut [FreeRotation; N],
    omegas: &mut [Vec3; N],
    h: f32,
    turn: impl Fn(&mut [FreeRotation; N], &mut [Vec3; N], &[f32; N]),
) {
    let parts = omegas.map(|omega| parts(omega, h));
    let h_of_parts = parts.map(|parts| h / parts.unwrap_or(1) as f32);
    if parts == [Some(1); N] {
        return turn(spins, omegas, &h_of_parts);
    }
    let most = parts.into_iter().flatten().max();
    for part in 0..most.unwrap_or(0) {
        let before = (*spins, *omegas);
        turn(spins, omegas, &h_of_parts);
        for lane in (0..N).filter(|&lane| parts[lane].is_none_or(|parts| parts <= part)) {
            (spins[lane], omegas[lane]) = (before.0[lane], before.1[lane]);
        }
    }
    for lane in (0..N).filter(|&lane| parts[lane].is_none()) {
        omegas[lane] = spins[lane].precess(omegas[lane], h);
    }
}

struct AdvanceAll<'a> {
    spins: &'a mut [FreeRotation; SPINS],
    omegas: &'a mut [Vec3; SPINS],
    h: &'a [f32; SPINS],
}

impl Kernel for AdvanceAll<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        advance(self.spins, self.omegas, self.h);
    }
}

/// Turns bodies, one in each lane, for so many seconds each, and takes their angular velocities (world, rad/s) to those after
/// it.
#[inline(always)]
fn advance<const N: usize>(spins: &mut [FreeRotation; N], omegas: &mut [Vec3; N], h: &[f32; N]) {
    let (zero, half) = (Doubles::splat(0.0), Doubles::splat(0.5));
    let mut step = zero;
    for (lane, &h) in h.iter().enumerate() {
        step.set(lane, f64::from(h));
    }
    let mut moments = V3([zero; 3]);
    for (lane, spin) in spins.iter().enumerate() {
        set(&mut moments, lane, spin.moments);
    }
    let per_moments = V3([Doubles::splat(1.0); 3]).over(moments);
    let axes = PrincipalAxes::of(spins);
    let mut omega = V3([zero; 3]);
    for (lane, w) in omegas.iter().enumerate() {
        set(&mut omega, lane, w.as_dvec3());
    }
    let w = axes.inverse().turn(omega);
    let momentum = moments.scaled(w);
    let mut middle = first_guess(w, momentum, per_moments, half * step);
    let turn = step * w.dot(w).sqrt();
    let mut error = turn * turn * turn;
    for _ in 0..ITERATIONS {
        if error.is_below(NEGLIGIBLE) {
            break;
        }
        let after = turned_back(momentum, middle, step).scaled(per_moments);
        let better = w.plus(after).times(half);
        middle = if_below(error, NEGLIGIBLE, middle, better);
        error = error * turn;
    }
    let after = turned_back(momentum, middle, step).scaled(per_moments);
    let middle = axes.turn(middle);
    for (lane, (spin, &h)) in spins.iter_mut().zip(h).enumerate() {
        spin.rotation = rotate_by(spin.rotation, get(&middle, lane), h);
    }
    let after = PrincipalAxes::of(spins).turn(after);
    for (lane, omega) in omegas.iter_mut().enumerate() {
        *omega = get(&after, lane);
    }
}

/// The angular velocity in the middle of the step to second order, from `w` at its start (principal frame, rad/s): with
/// `L' = L x w` and `w' = I^-1 L'`, the mean of `w` and `w + h w' + h^2 w'' / 2`. `half_step`: `h / 2`.
#[inline(always)]
fn first_guess<const N: usize>(
    w: V3<Doubles<N>>,
    momentum: V3<Doubles<N>>,
    per_moments: V3<Doubles<N>>,
    half_step: Doubles<N>,
) -> V3<Doubles<N>> {
    let torque = momentum.cross(w).times(half_step);
    let change = torque.scaled(per_moments);
    let second = torque.cross(w).plus(momentum.cross(change));
    let second = second.times(half_step).scaled(per_moments);
    w.plus(change.plus(second))
}

/// `yes` in lanes where `test` is below `bound`, else `no`.
#[inline(always)]
fn if_below<const N: usize>(
    test: Doubles<N>,
    bound: f64,
    yes: V3<Doubles<N>>,
    no: V3<Doubles<N>>,
) -> V3<Doubles<N>> {
    let ([a, b, c], [x, y, z]) = (yes.0, no.0);
    V3([
        test.if_below(bound, a, x),
        test.if_below(bound, b, y),
        test.if_below(bound, c, z),
    ])
}

#[inline(always)]
fn set<const N: usize>(to: &mut V3<Doubles<N>>, lane: usize, v: DVec3) {
    to.0[0].set(lane, v.x);
    to.0[1].set(lane, v.y);
    to.0[2].set(lane, v.z);
}

#[inline(always)]
fn get<const N: usize>(from: &V3<Doubles<N>>, lane: usize) -> Vec3 {
    let [x, y, z] = &from.0;
    DVec3::new(x.get(lane), y.get(lane), z.get(lane)).as_vec3()
}

/// `world_from_principal`: a quaternion in each lane.
#[derive(Clone, Copy)]
struct PrincipalAxes<const N: usize> {
    vector: V3<Doubles<N>>,
    scalar: Doubles<N>,
}

impl<const N: usize> PrincipalAxes<N> {
    #[inline(always)]
    fn of(spins: &[FreeRotation; N]) -> Self {
        let zero = Doubles::splat(0.0);
        let (mut vector, mut scalar) = (V3([zero; 3]), zero);
        for (lane, spin) in spins.iter().enumerate() {
            let q = (spin.rotation * spin.frame).as_dquat();
            set(&mut vector, lane, DVec3::new(q.x, q.y, q.z));
            scalar.set(lane, q.w);
        }
        Self { vector, scalar }
    }

    #[inline(always)]
    fn inverse(self) -> Self {
        let zero = Doubles::splat(0.0);
        Self {
            vector: V3([zero; 3]).minus(self.vector),
            ..self
        }
    }

    /// `v` turned, without the change of length that the rounding of the quaternion's own length makes: it has a direction,
    /// and thousands of sub-steps would add it up.
    #[inline(always)]
    fn turn(self, v: V3<Doubles<N>>) -> V3<Doubles<N>> {
        let Self {
            vector: u,
            scalar: w,
        } = self;
        let t = u.cross(v);
        let scale = Doubles::splat(2.0) / (u.dot(u) + w * w);
        v.plus(t.times(w).plus(u.cross(t)).times(scale))
    }
}

/// `v` seen from a frame that has turned for `h` seconds with `omega`; the rotation of [`rotate_by`].
#[inline(always)]
fn turned_back<const N: usize>(
    v: V3<Doubles<N>>,
    omega: V3<Doubles<N>>,
    h: Doubles<N>,
) -> V3<Doubles<N>> {
    let one = Doubles::splat(1.0);
    let turn = omega.times(h);
    let series = Doubles::splat(0.5) + turn.dot(turn) * Doubles::splat(1.0 / 24.0);
    let half = turn.times(series);
    // The unit quaternion (half, 1) / n, reversed: v - 2 w (u x v) + 2 u x (u x v).
    let scale = Doubles::splat(2.0) / (one + half.dot(half));
    let t = half.cross(v);
    v.plus(half.cross(t).minus(t).times(scale))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice the energy, and the angular momentum, over the largest moment.
    fn invariants(spin: &FreeRotation, omega: Vec3) -> (f64, DVec3) {
        let axes = (spin.rotation * spin.frame).as_dquat().normalize();
        let w = axes.inverse() * omega.as_dvec3();
        (w.dot(spin.moments * w), axes * (spin.moments * w))
    }

    /// Splinters that spin at up to 10 000 rad/s gained energy up to tenfold while a turn was made at once.
    #[test]
    fn energy_and_momentum_stay_at_any_speed() {
        // Of a needle, the rounding and the end of the iteration are divided by a moment of a thousandth.
        let shapes = [
            ([1.0, 0.92, 0.087], 1e-4),
            ([1.0, 0.99, 1e-3], 1e-2),
            ([1.0, 0.5, 0.5], 1e-4),
        ];
        for (shape, (moments, bound)) in shapes.into_iter().enumerate() {
            for speed in [3.0, 30.0, 100.0, 300.0, 1e3, 3e3, 1e4, 1e5] {
                for h in [1.0 / 60.0, 1.0 / 480.0] {
                    let mut spin = FreeRotation {
                        rotation: rotate_by(Quat::IDENTITY, Vec3::new(0.4, shape as f32, 0.2), 1.0),
                        frame: rotate_by(Quat::IDENTITY, Vec3::new(0.1, 0.2, -0.3), 1.0),
                        moments: DVec3::from(moments),
                    };
                    let mut omega = speed * Vec3::new(0.48, 0.6, 0.64);
                    let (energy, momentum) = invariants(&spin, omega);
                    for _ in 0..600 {
                        omega = spin.advance(omega, h);
                    }
                    let (after, sleep_changes) = invariants(&spin, omega);
                    let drift = after / energy - 1.0;
                    let turn = (sleep_changes - momentum).length() / momentum.length();
                    let case = format!("{moments:?} at {speed} rad/s, {h} s");
                    assert!(drift.abs() < bound, "{case}: energy drifts by {drift}");
                    assert!(turn < 2e-5, "{case}: momentum by {turn}");
                }
            }
        }
    }

    /// Bodies of all shapes, some fast and some slow, turn the same alone and together, with lanes of any width.
    #[test]
    fn many_turn_as_each_alone() {
        let spin = |i: usize| FreeRotation {
            rotation: rotate_by(Quat::IDENTITY, Vec3::new(i as f32, 0.3, -0.7), 0.1),
            frame: rotate_by(Quat::IDENTITY, Vec3::new(0.2, i as f32, 0.1), 0.1),
            moments: DVec3::new(1.0, 0.9 / (1 + i) as f64, 0.3),
        };
        let spins: [FreeRotation; SPINS] = std::array::from_fn(spin);
        let speeds = [1e-4, 1e-2, 0.1, 1.0, 10.0, 100.0, 1000.0, 1e5];
        let omegas = speeds.map(|speed| speed * Vec3::new(1.0, -0.4, 0.6));
        let h = 1.0 / 240.0;
        for width in [LaneWidth::Widest, LaneWidth::Four, LaneWidth::One] {
            for count in 0..=SPINS {
                let mut together = FreeRotations::default();
                for (spin, omega) in spins.into_iter().zip(omegas).take(count) {
                    together.push(spin, omega);
                }
                together.advance(h, width);
                assert_eq!(together.iter().count(), count);
                for (i, (spin, omega)) in together.iter().enumerate() {
                    let mut alone = spins[i];
                    let after = alone.advance(omegas[i], h);
                    let case = format!("body {i} of {count}, {width:?}");
                    assert_eq!((after, alone), (omega, *spin), "{case}");
                }
            }
        }
    }
}
