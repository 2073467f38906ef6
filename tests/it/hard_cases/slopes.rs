//! Slopes: the threshold of sliding (case 1), tipping against sliding (case 12), the V groove (case 16).

use super::support::{G, H, discrete_stop, run, simulation, substep};
use crate::common::structures::{downhill, slope_box, v_groove};
use glam::Vec3;

/// Eight directions about the vertical, degrees.
fn headings() -> impl Iterator<Item = f64> {
    (0..8_u8).map(|k| 45.0 * f64::from(k))
}

/// How far and how fast a unit cube with friction 0.6 has gone down a slope after 1 s and after `seconds` more, m and m/s:
/// in the first second it settles from a cold start.
fn slide(degrees: f64, heading: f64, seconds: f64) -> [(f64, f64); 2] {
    let mut simulation = simulation(slope_box(Vec3::ONE, 0.6, degrees, heading));
    let start = simulation.bodies.pose(1).position;
    let down = downhill(degrees, heading);
    [1.0, seconds].map(|seconds| {
        run(&mut simulation, seconds);
        let way = (simulation.bodies.center_of_mass(1) - start).dot(down);
        let speed = simulation.bodies.velocity(1).0.dot(down);
        (f64::from(way), f64::from(speed))
    })
}

/// Hard because friction must be exactly enough while the load differs from corner to corner; the threshold is
/// `atan(0.6) = 30.9638` degrees in every direction, since Coulomb's cone is round.
#[test]
fn cube_holds_a_tenth_of_a_degree_below_the_friction_angle_in_eight_directions() {
    let threshold = 0.6_f64.atan().to_degrees();
    let [near, far] = [threshold - 0.1, 30.5].map(|degrees| {
        let ways = headings().map(|heading| slide(degrees, heading, 9.0).map(|(way, _)| way));
        let worst = ways.fold([0.0_f64; 2], |[settled, crept], [first, last]| {
            [settled.max(first.abs()), crept.max((last - first).abs())]
        });
        println!(
            "case 1: {degrees:.2} degrees: settles by {:.4} mm, then creeps {:.4} mm in 9 s",
            1e3 * worst[0],
            1e3 * worst[1]
        );
        worst
    });
    assert!(
        near[1] < 9e-4,
        "creeps {} m in 9 s a tenth of a degree below",
        near[1]
    );
    assert!(far[0] + far[1] < 1e-3, "creeps {far:?} m at 30.5 degrees");
}

/// Hard because the surplus over friction is 0.02 m/s2, a five-hundredth of gravity; `a = g (sin - mu cos)`.
#[test]
fn cube_slides_a_tenth_of_a_degree_above_the_friction_angle_in_eight_directions() {
    let threshold = 0.6_f64.atan().to_degrees();
    let worst = [threshold + 0.1, 31.4, 33.0].map(|degrees| {
        let tilt = degrees.to_radians();
        let exact = G * (tilt.sin() - 0.6 * tilt.cos());
        let errors = headings().map(|heading| {
            let [(_, first), (_, last)] = slide(degrees, heading, 2.0);
            (last - first) / 2.0 / exact - 1.0
        });
        let worst = errors.fold(0.0_f64, |a, b| a.max(b.abs()));
        println!("case 1: {degrees:.2} degrees: a = {exact:.5} m/s2, worst error {worst:.1e}");
        worst
    });
    for (error, bar) in worst.iter().zip([0.05, 0.02, 0.01]) {
        assert!(*error < bar, "accelerations {worst:?} off");
    }
}

/// Largest lean (degrees, against the slope's normal) of a box of 1 x 3 x 1 m within `seconds`, and how fast it slides then.
fn lean(mu: f32, degrees: f64, seconds: f64) -> (f64, f64) {
    let mut simulation = simulation(slope_box(Vec3::new(1.0, 3.0, 1.0), mu, degrees, 0.0));
    let upright = simulation.bodies.pose(1).rotation;
    let mut most = 0.0_f64;
    for _ in 0..super::support::steps(seconds) {
        simulation.step(H);
        let turn = simulation.bodies.pose(1).rotation.angle_between(upright);
        most = most.max(f64::from(turn).to_degrees());
    }
    let speed = simulation.bodies.velocity(1).0.dot(downhill(degrees, 0.0));
    (most, f64::from(speed))
}

/// Hard because all load goes over to one edge while nothing moves; it tips at `atan(1/3) = 18.4349` degrees, long before
/// it would slide.
#[test]
fn tall_box_tips_within_a_fifth_of_a_degree_of_its_threshold() {
    let threshold = (1.0_f64 / 3.0).atan().to_degrees();
    let (below, above) = (
        lean(0.8, threshold - 0.2, 10.0).0,
        lean(0.8, threshold + 0.2, 10.0).0,
    );
    println!(
        "case 12: lean in 10 s at -0.2 degree {below:.4} degrees, at +0.2 degree {above:.1} degrees"
    );
    assert!(below < 0.1, "leaned by {below} degrees");
    assert!(above > 45.0, "leaned by {above} degrees only");
}

/// Hard because a little too much friction tips it; with `mu < 1/3` it slides at any slope, and never tips.
#[test]
fn tall_box_with_little_friction_slides_and_does_not_tip() {
    let tilt = 25.0_f64.to_radians();
    let exact = G * (tilt.sin() - 0.3 * tilt.cos());
    let (lean, speed) = lean(0.3, 25.0, 2.0);
    let error = speed / 2.0 / exact - 1.0;
    println!(
        "case 12: mu 0.3 at 25 degrees: lean {lean:.4} degrees, acceleration {error:+.1e} off"
    );
    assert!(lean < 0.2, "leaned by {lean} degrees");
    assert!(error.abs() < 1e-2, "{error} off {exact} m/s2");
}

/// Hard because friction acts on two inclined faces whose normal forces sum to 1.414 times the weight:
/// `a = mu g / sin 45 = 4.16203 m/s2`.
#[test]
fn bar_in_a_groove_stops_where_two_inclined_faces_stop_it() {
    let mut simulation = simulation(v_groove(0.3, 3.0));
    run(&mut simulation, 2.0);
    let exact = discrete_stop(3.0, 0.3 * G * 2.0_f64.sqrt(), substep(H));
    let place = simulation.bodies.center_of_mass(2);
    let error = f64::from(place.x) / exact - 1.0;
    println!(
        "case 16: stops after {:.5} m, {error:+.1e} of {exact:.5}; aside {:.1e} m",
        place.x, place.z
    );
    assert!(error.abs() < 1e-2, "{} m, not {exact} m", place.x);
    assert!(
        place.z.abs() < 1e-3,
        "left the middle of the groove by {} m",
        place.z
    );
}
