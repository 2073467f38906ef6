//! Sliding to a stop (case 2).

use crate::structures::{block, cuboid, floor};
use crate::support::{G, H, discrete_stop, run, simulation, substep};
use glam::{Vec2, Vec3};

/// Distance that a unit cube with friction 0.5 slides from 10 m/s at `degrees` to its own axes, m.
fn stop(degrees: f32) -> f32 {
    let heading = Vec2::from_angle(degrees.to_radians());
    let mut cube = block(&cuboid(Vec3::ONE), 0.5 * Vec3::Y, 0.5);
    cube.linear_velocity = 10.0 * Vec3::new(heading.x, 0.0, heading.y);
    let mut simulation = simulation([floor(0.5), cube]);
    run(&mut simulation, 3.0);
    (simulation.bodies.centre_of_mass(1) - 0.5 * Vec3::Y).length()
}

/// Hard because a pyramid of friction stops a box 29 % short along its diagonals; the distance is that of semi-implicit Euler.
#[test]
fn sliding_cube_stops_where_the_discrete_formula_says_in_eight_directions() {
    let exact = discrete_stop(10.0, 0.5 * G, substep(&Default::default(), H));
    for k in 0..8_u8 {
        let distance = f64::from(stop(45.0 * f32::from(k)));
        let error = distance / exact - 1.0;
        println!("case 2: {k} x 45 degrees: {distance:.5} m, {error:+.1e}");
        assert!(error.abs() < 1e-3, "{distance} m, not {exact} m");
    }
}
