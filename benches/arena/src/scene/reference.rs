//! Closed forms and double-precision solutions of scenes with joints. Units: metres, kilograms, seconds, radians.

use std::f64::consts::{FRAC_PI_2, PI};

pub(super) const GRAVITY: f64 = 9.81;

/// Steps of a reference in one of a scene.
const FINENESS: usize = 200;

/// A state, and how it changes.
type Rates<const N: usize> = fn(&[f64], [f64; N]) -> [f64; N];

/// States after each of `steps` steps of 1/60 s, by the classical method of Runge and Kutta.
fn solve<const N: usize>(
    rates: Rates<N>,
    numbers: &[f64],
    start: [f64; N],
    steps: usize,
) -> Vec<[f64; N]> {
    let h = 1.0 / 60.0 / FINENESS as f64;
    let mut state = start;
    let mut fine = |_| {
        let along = |rates: [f64; N], h: f64| std::array::from_fn(|i| state[i] + h * rates[i]);
        let a = rates(numbers, state);
        let b = rates(numbers, along(a, 0.5 * h));
        let c = rates(numbers, along(b, 0.5 * h));
        let d = rates(numbers, along(c, h));
        state =
            std::array::from_fn(|i| state[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
        state
    };
    (0..steps)
        .map(|_| (0..FINENESS).map(&mut fine).last().expect("some"))
        .collect()
}

/// Period of a body of moment of inertia `inertia` about its axis and of the weight times its distance `torque`, that swings by
/// `angle` to both sides: `2 pi sqrt(I / (m g d)) / agm(1, cos(angle / 2))`.
pub(super) fn period(inertia: f64, torque: f64, angle: f64) -> f64 {
    let (mut a, mut b) = (1.0, (0.5 * angle).cos());
    for _ in 0..10 {
        (a, b) = (0.5 * (a + b), f64::sqrt(a * b));
    }
    2.0 * PI * (inertia / torque).sqrt() / a
}

/// Angles of two bars, each of length 1 and of the moment `moment` of a unit mass about its middle, that hang on each other, from the
/// vertical, and their velocities; both are released at `angle`.
pub(super) fn double_pendulum(moment: f64, angle: f64, steps: usize) -> Vec<[f64; 4]> {
    // (I + 1/4 + 1) t1'' + (1/2) cos(t1 - t2) t2'' = -(1/2) sin(t1 - t2) w2^2 - (3/2) g sin t1,
    // (I + 1/4) t2'' + (1/2) cos(t1 - t2) t1'' = (1/2) sin(t1 - t2) w1^2 - (1/2) g sin t2.
    let rates: Rates<4> = |numbers, [t1, t2, w1, w2]| {
        let (sine, cosine) = (t1 - t2).sin_cos();
        let b1 = -0.5 * sine * w2 * w2 - 1.5 * GRAVITY * t1.sin();
        let b2 = 0.5 * sine * w1 * w1 - 0.5 * GRAVITY * t2.sin();
        let (a11, a12, a22) = (numbers[0] + 1.25, 0.5 * cosine, numbers[0] + 0.25);
        let determinant = a11 * a22 - a12 * a12;
        [
            w1,
            w2,
            (a22 * b1 - a12 * b2) / determinant,
            (a11 * b2 - a12 * b1) / determinant,
        ]
    };
    solve(rates, &[moment], [angle, angle, 0.0, 0.0], steps)
}

/// Angles above the level of an arm that hangs at first and is turned by a constant torque, all torques over its moment of inertia.
pub(super) fn lifted(torque: f64, weight: f64, steps: usize) -> Vec<f64> {
    let rates: Rates<2> = |numbers, [t, w]| [w, numbers[0] - numbers[1] * t.cos()];
    let states = solve(rates, &[torque, weight], [-FRAC_PI_2, 0.0], steps);
    states.into_iter().map(|[angle, _]| angle).collect()
}

/// How far a weight has sunk on a damped spring that began to bear it `t` seconds ago, over how far it hangs in the end.
pub(super) fn sunk(hertz: f64, damping_ratio: f64, t: f64) -> f64 {
    let omega = 2.0 * PI * hertz;
    let (decay, swing) = (
        damping_ratio * omega,
        omega * (1.0 - damping_ratio.powi(2)).sqrt(),
    );
    let (sine, cosine) = (swing * t).sin_cos();
    1.0 - (-decay * t).exp() * (cosine + decay / swing * sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_swings_have_the_period_of_a_spring() {
        let exact = 2.0 * PI / GRAVITY.sqrt();
        assert!((period(1.0, GRAVITY, 1e-3) / exact - 1.0).abs() < 1e-6);
        // 4 K(sin 45 deg).
        let level = 4.0 * 1.854_074_677_301_372;
        assert!((period(1.0, 1.0, FRAC_PI_2) / level - 1.0).abs() < 1e-12);
    }

    #[test]
    fn references_keep_their_energy() {
        let energy = |[t1, t2, w1, w2]: [f64; 4]| {
            let moment = 1.0 / 12.0;
            let kinetic = 0.5 * (moment + 1.25) * w1 * w1
                + 0.5 * (moment + 0.25) * w2 * w2
                + 0.5 * (t1 - t2).cos() * w1 * w2;
            kinetic - GRAVITY * (1.5 * t1.cos() + 0.5 * t2.cos())
        };
        let states = double_pendulum(1.0 / 12.0, 1.0, 300);
        let first = energy([1.0, 1.0, 0.0, 0.0]);
        assert!((energy(states[299]) - first).abs() < 1e-9);
        assert!(states[299][0] != 1.0);
    }

    #[test]
    fn a_weight_on_a_spring_sinks_to_its_rest() {
        assert_eq!(sunk(1.0, 0.1, 0.0), 0.0);
        assert!((sunk(1.0, 0.1, 0.5) - 1.0).abs() > 0.5);
        assert!((sunk(1.0, 0.1, 60.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_torque_that_cannot_lift_is_borne_halfway() {
        let angles = lifted(0.5, 1.0, 1800);
        let highest = angles.iter().copied().fold(f64::MIN, f64::max);
        assert!(highest < 0.0 && highest > -FRAC_PI_2 + 0.5, "{highest}");
    }
}
