//! Bodies that are cut while they move or carry: nothing may be lost, and nothing that rested may start to move.

use super::scene::*;
use super::support::*;
use crate::common::dice::Dice;
use crate::common::structures::*;
use bevy_cleave::geometry::ConvexHull;
use bevy_cleave::prelude::*;
use bevy_cleave::slice::{Cut, slice_hull};
use bevy_cleave::step;
use glam::{DMat3, DVec3, Vec3};

/// Mass, momentum, angular momentum and inertia about a point, and twice the kinetic energy, of several bodies.
#[derive(Debug, Default)]
struct Totals {
    mass: f64,
    momentum: DVec3,
    angular: DVec3,
    inertia: DMat3,
    energy: f64,
}

fn totals(simulation: &Simulation, about: DVec3) -> Totals {
    let mut totals = Totals::default();
    let bodies = &simulation.bodies;
    for slot in bodies.iter() {
        let mass = bodies.mass(slot);
        let m = f64::from(mass.mass);
        let frame = (bodies.pose(slot).rotation * mass.principal_frame).as_dquat();
        let axes = DMat3::from_quat(frame.normalize());
        let own = axes * DMat3::from_diagonal(mass.principal.as_dvec3()) * axes.transpose();
        let d = bodies.center_of_mass(slot).as_dvec3() - about;
        let (v, omega) = bodies.velocity(slot);
        let (v, omega) = (v.as_dvec3(), omega.as_dvec3());
        totals.mass += m;
        totals.momentum += m * v;
        totals.angular += d.cross(m * v) + own * omega;
        totals.energy += m * v.length_squared() + omega.dot(own * omega);
        let outer = DMat3::from_cols(d * d.x, d * d.y, d * d.z);
        totals.inertia += own + m * (d.length_squared() * DMat3::IDENTITY - outer);
    }
    totals
}

/// Largest entry of the difference of two matrices against the largest of the second.
fn matrix_error(a: DMat3, b: DMat3) -> f64 {
    let most = |m: DMat3| {
        m.to_cols_array()
            .into_iter()
            .fold(0.0, |x: f64, y| x.max(y.abs()))
    };
    most(a - b) / most(b)
}

/// Hard because each of fifty pieces is rounded by itself: v_i = v + omega x r_i and omega_i = omega conserve momentum,
/// angular momentum and energy exactly, volumes add up, and inertia does by the parallel-axis theorem.
#[test]
fn body_cut_into_fifty_moving_pieces_loses_nothing() {
    let mut dice = Dice::new(27);
    let mut desc = block(
        &cuboid(Vec3::new(1.2, 0.9, 0.7)),
        Vec3::new(4.0, 2.0, -3.0),
        0.5,
    );
    desc.pose.rotation = dice.rotation();
    desc.linear_velocity = Vec3::new(3.0, 1.0, -2.0);
    desc.angular_velocity = Vec3::new(2.0, -5.0, 1.0);
    let mut simulation = weightless([desc]);
    let center = simulation.bodies.center_of_mass(0);
    for _ in 0..10 {
        let plane = Plane::through(center + 0.2 * dice.vector(-1.0, 1.0), dice.direction());
        simulation.slice(0, plane).expect("a body");
    }
    weigh(&mut simulation);
    let about = center.as_dvec3();
    let before = totals(&simulation, about);
    let settings = simulation.settings(H);
    step::cut(
        &mut simulation.bodies,
        &mut simulation.cache,
        &mut simulation.fractures,
        &mut simulation.bonds,
        &settings,
    );
    let pieces = simulation.bodies.len();
    let after = totals(&simulation, about);
    let errors = [
        (after.mass / before.mass - 1.0).abs(),
        (after.momentum - before.momentum).length() / before.momentum.length(),
        (after.angular - before.angular).length() / before.angular.length(),
        (after.energy / before.energy - 1.0).abs(),
        matrix_error(after.inertia, before.inertia),
    ];
    println!("27 {pieces} pieces: errors of mass, P, L, T, inertia {errors:?}");
    assert!(pieces >= 50, "{pieces} pieces");
    assert!(errors[..4].iter().all(|&e| e < 1e-5), "{errors:?}");
    assert!(errors[4] < 1e-4, "{errors:?}");
}

/// A piece of the recursive cut, and the sides of the planes that it lies behind.
struct Fragment {
    hull: ConvexHull,
    behind: Vec<Plane>,
}

impl Fragment {
    /// A point inside: random weights on the corners.
    fn inside(&self, dice: &mut Dice) -> Vec3 {
        let corners = self.hull.vertices();
        let weights: Vec<f32> = corners.iter().map(|_| dice.unit() + 1e-3).collect();
        let sum: f32 = weights.iter().sum();
        let point: Vec3 = corners.iter().zip(&weights).map(|(&c, &w)| w * c).sum();
        point / sum
    }

    fn below(hull: ConvexHull, parent: &Self, plane: Plane) -> Self {
        let mut behind = parent.behind.clone();
        behind.push(plane);
        Self { hull, behind }
    }

    /// How far a corner lies on the wrong side of a plane, m.
    fn outside(&self) -> f32 {
        let distance = |p: &Plane| {
            let corners = self.hull.vertices().iter();
            corners.map(|&v| p.distance(v)).fold(0.0, f32::max)
        };
        self.behind.iter().map(distance).fold(0.0, f32::max)
    }
}

/// Hard because rounding of a thousand cuts adds up, and pieces of pieces become slivers thinner than the tolerance.
/// Volumes sum to 1 within 1e-5; every piece is closed, convex, of positive volume, and on its side of all its planes.
#[test]
fn thousand_recursive_cuts_leave_sound_pieces_that_fill_the_cube() {
    let mut dice = Dice::new(28);
    let mut pieces = vec![Fragment {
        hull: cuboid(Vec3::ONE).hull().clone(),
        behind: Vec::new(),
    }];
    let mut missed = 0;
    while pieces.len() <= 1000 {
        let index = dice.below(pieces.len());
        let plane = Plane::through(pieces[index].inside(&mut dice), dice.direction());
        match slice_hull(&pieces[index].hull, plane).expect("a usable plane") {
            Cut::Cut(halves) => {
                let parent = pieces.swap_remove(index);
                pieces.push(Fragment::below(halves.below, &parent, plane));
                pieces.push(Fragment::below(halves.above, &parent, plane.flipped()));
            }
            Cut::Below | Cut::Above => missed += 1,
        }
        assert!(missed < 1000, "pieces too thin to cut: {missed}");
    }
    let (mut volume, mut slivers, mut outside) = (0.0, 0, 0.0_f32);
    for piece in &pieces {
        piece.hull.validate().expect("closed and convex");
        piece.hull.to_mesh().check_closed().expect("closed");
        let own = piece.hull.volume();
        assert!(own > 0.0, "volume {own}");
        volume += own;
        slivers += usize::from(own < 1e-9);
        outside = outside.max(piece.outside());
    }
    println!(
        "28 {} pieces: volume - 1 = {:.1e}, {slivers} below 1e-9 m3, {missed} planes missed, {outside:.1e} m on the wrong side",
        pieces.len(),
        volume - 1.0
    );
    assert!((volume - 1.0).abs() <= 1e-5, "volume {volume}");
    assert!(outside < 2e-6, "{outside} m on the wrong side of a plane");
}

/// A block of 4 x 2 x 4 m at rest on a floor, cut in place by seven planes into 4 x 2 x 4 pieces, the planes out of true
/// by up to `tilt`.
fn cut_block(tilt: f32) -> Simulation {
    let mut simulation = with_floor(0.6);
    let slot = add(
        &mut simulation,
        block(&cuboid(Vec3::new(4.0, 2.0, 4.0)), Vec3::Y, 0.6),
    );
    (0..30).for_each(|_| simulation.step(H));
    let mut dice = Dice::new(29);
    for (at, normal) in cuts_of_block() {
        let turned = normal + tilt * dice.vector(-1.0, 1.0);
        let through = at * normal + Vec3::Y * (1.0 - normal.y);
        simulation
            .slice(slot, Plane::through(through, turned))
            .expect("a body");
    }
    simulation.step(H);
    simulation
}

/// What moved after a cut, over `steps`: fastest body in the first tenth of a second and after it (m/s), and the
/// farthest way of a piece (m).
fn unrest(simulation: &mut Simulation, steps: usize) -> [f32; 3] {
    let start = frames(simulation);
    let (mut early, mut late) = (0.0_f32, 0.0_f32);
    for step in 0..steps {
        simulation.step(H);
        let bodies = &simulation.bodies;
        let speeds = bodies.iter().map(|s| bodies.velocity(s).0.length());
        let record = if step < 6 { &mut early } else { &mut late };
        *record = speeds.fold(*record, f32::max);
    }
    [early, late, displacement(simulation, &start)]
}

/// Hard because all contacts are new in one step, none has a multiplier to start from, and faces that rounding made
/// overlap are pushed apart. At most 2 g h at any time, 0.05 m/s after a tenth of a second, and 1 mm in a second.
#[test]
fn pieces_of_a_resting_block_stay_in_place() {
    for tilt in [0.0, 0.05] {
        let mut simulation = cut_block(tilt);
        assert_eq!(
            simulation.bodies.len(),
            33,
            "4 x 2 x 4 pieces and the floor"
        );
        let [early, late, moved] = unrest(&mut simulation, 60);
        println!(
            "29 block cut in place, tilt {tilt}: {early:.4} m/s at first, {late:.2e} later, moved {moved:.2e} m"
        );
        assert!(early <= 0.327, "{early} m/s after the cut");
        assert!(late <= 0.05, "{late} m/s a tenth of a second after the cut");
        assert!(moved < 0.001, "moved {moved} m within a second");
    }
}

/// Ten unit cubes in a column, settled for a second.
fn column() -> Simulation {
    let shape = cuboid(Vec3::ONE);
    let cubes = (0..10_u8).map(|i| block(&shape, (0.5 + f32::from(i)) * Vec3::Y, 0.6));
    let mut simulation = simulation(std::iter::once(floor(0.6)).chain(cubes));
    run(&mut simulation, 1.0);
    simulation
}

/// Hard because it leaves two columns ten cubes high, one of them 0.3 of a cube thick: slender, but each with its center
/// of mass over its base, so both stay within 5 mm.
#[test]
fn column_cut_by_a_vertical_plane_stays_as_two_columns() {
    let mut simulation = column();
    let plane = Plane::through(-0.2 * Vec3::X, Vec3::X);
    for slot in 1..=10 {
        simulation.slice(slot, plane).expect("a body");
    }
    simulation.step(H);
    assert_eq!(simulation.bodies.len(), 21, "twenty pieces and the floor");
    let [early, late, moved] = unrest(&mut simulation, 600);
    println!(
        "30 column cut vertically: {early:.4} m/s at first, {late:.2e} later, moved {moved:.2e} m"
    );
    assert!(moved < 0.005, "moved {moved} m in 10 s");
}

/// Hard because the half that stays carries five and a half cubes on a face that did not exist a step before.
#[test]
fn column_cut_horizontally_does_not_move() {
    let mut simulation = column();
    simulation
        .slice(5, Plane::through(4.5 * Vec3::Y, Vec3::Y))
        .expect("a body");
    simulation.step(H);
    assert_eq!(simulation.bodies.len(), 12, "eleven pieces and the floor");
    let [early, late, moved] = unrest(&mut simulation, 600);
    println!(
        "30 column cut horizontally: {early:.4} m/s at first, {late:.2e} later, moved {moved:.2e} m"
    );
    assert!(moved < 0.001, "moved {moved} m in 10 s");
}
