//! The solver against dense algebra, and the step against answers known in advance.

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use bevy_cleave::contact::ContactPoint;
use bevy_cleave::prelude::*;
use bevy_cleave::solver::Residual;
use bevy_cleave::testing::bodies::SolverBody;
use bevy_cleave::testing::pgs;
use bevy_cleave::testing::rows::{DenseMlcp, PointRows, ResidualSum, Row, Solved};
use glam::{DVec3, Quat, Vec3};

const H: f32 = 1.0 / 60.0;
const G: f32 = 9.81;

fn cube(size: f32) -> ConvexMesh {
    ConvexMesh::cuboid(size, size, size).expect("valid size")
}

fn with_floor() -> Simulation {
    let mut simulation = awake();
    let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    simulation.bodies.insert(floor).expect("usable");
    simulation
}

fn add(simulation: &mut Simulation, desc: BodyDesc) -> u32 {
    simulation.bodies.insert(desc).expect("usable")
}

fn dynamic(shape: &ConvexMesh, x: f32, y: f32, z: f32) -> BodyDesc {
    BodyDesc::dynamic(shape.clone(), Vec3::new(x, y, z))
}

/// Rows of contact points as one list, three for each point.
fn rows_of(points: &[PointRows]) -> Vec<([u32; 2], Row)> {
    let rows = points
        .iter()
        .flat_map(|p| [p.normal, p.tangents[0], p.tangents[1]].map(|r| (p.bodies, r)));
    rows.collect()
}

/// `A = J M^-1 J^T` of the rows in double precision, from Jacobians and inverse masses.
fn dense_matrix(rows: &[([u32; 2], Row)], bodies: &[SolverBody]) -> Vec<f64> {
    let n = rows.len();
    let mut a = vec![0.0; n * n];
    for (i, (bodies_i, row)) in rows.iter().enumerate() {
        for (j, (bodies_j, other)) in rows.iter().enumerate() {
            for (side, &slot) in bodies_i.iter().enumerate() {
                let Some(other_side) = bodies_j.iter().position(|&s| s == slot) else {
                    continue;
                };
                let sign = if side == other_side { 1.0 } else { -1.0 };
                let angular = [row.angular_a, row.angular_b][side].as_dvec3();
                let turn = [other.turn_a, other.turn_b][other_side].as_dvec3();
                let linear = row.direction.as_dvec3().dot(other.direction.as_dvec3());
                let inverse_mass = f64::from(bodies[slot as usize].inverse_mass);
                a[i * n + j] += sign * (linear * inverse_mass + angular.dot(turn));
            }
        }
    }
    a
}

/// A heap of a few boxes after some steps, with its rows before the next solve and the velocities `v*`.
fn heap(friction: f32) -> (Vec<PointRows>, Vec<SolverBody>) {
    let mut simulation = with_floor();
    for i in 0..5_u8 {
        let n = f32::from(i);
        let mut desc = dynamic(
            &cube(1.0),
            0.3 * n - 0.4 * (n % 2.0),
            0.5 + 0.99 * n,
            0.1 * n,
        );
        desc.friction = Friction::new(friction);
        add(&mut simulation, desc);
    }
    simulation.config = Pgs {
        sweeps: 4,
        ..Pgs::default()
    }
    .into();
    for _ in 0..20 {
        simulation.step(H);
    }
    let mut islands = simulation.contacts.solver().islands();
    let island = islands.next().expect("the boxes touch");
    assert!(islands.next().is_none(), "one heap is one island");
    let mut rows = Vec::new();
    island.rows(&mut rows);
    for point in &mut rows {
        let [t1, t2] = &mut point.tangents;
        for row in [&mut point.normal, t1, t2] {
            row.impulse = 0.0;
        }
        point.friction = friction;
    }
    let mut bodies = island.bodies.to_vec();
    for body in bodies.iter_mut().filter(|b| b.inverse_mass > 0.0) {
        body.linear.y -= G * H;
    }
    (rows, bodies)
}

/// The paper's method with the given number of sweeps.
fn paper(sweeps: u32) -> SolverConfig {
    Pgs {
        sweeps,
        ..Pgs::default()
    }
    .into()
}

fn residual(rows: &[PointRows], bodies: &[SolverBody], friction: FrictionModel) -> Residual {
    let solved = Solved {
        friction,
        is_relaxed: false,
    };
    ResidualSum::of(rows, bodies, solved).residual()
}

#[test]
fn rows_have_the_diagonal_and_symmetry_of_a_mass_matrix() {
    let (points, bodies) = heap(0.5);
    let rows = rows_of(&points);
    let a = dense_matrix(&rows, &bodies);
    let n = rows.len();
    assert!(n >= 30, "the heap touches, {n} rows");
    for i in 0..n {
        let diagonal = f64::from(rows[i].1.diagonal);
        assert!((a[i * n + i] - diagonal).abs() < 1e-5 * diagonal);
        for j in 0..n {
            let scale = (a[i * n + i] * a[j * n + j]).sqrt();
            assert!((a[i * n + j] - a[j * n + i]).abs() < 1e-5 * scale);
        }
    }
}

#[test]
fn gauss_seidel_without_friction_solves_the_dense_problem() {
    let (mut points, mut bodies) = heap(0.0);
    let start = bodies.clone();
    let friction = FrictionModel::Disc;
    pgs::solve(&mut points, &mut bodies, 500, friction);
    let all = rows_of(&points);
    let normals: Vec<_> = all.iter().copied().step_by(3).collect();
    let n = normals.len();
    let problem = DenseMlcp {
        a: dense_matrix(&normals, &start),
        b: normals
            .iter()
            .map(|([a, b], row)| {
                let v = row.velocity(&start[*a as usize], &start[*b as usize]);
                f64::from(row.target_velocity - v)
            })
            .collect(),
        lo: vec![0.0; n],
        hi: vec![f64::INFINITY; n],
    };
    let lambda: Vec<f64> = normals
        .iter()
        .map(|(_, row)| f64::from(row.impulse))
        .collect();
    // Relative to the largest multiplier in the same norm. The velocities carry the rounding of some 10^4 updates in f32.
    let scale = normals
        .iter()
        .map(|(_, row)| f64::from(row.impulse * row.diagonal.sqrt()));
    let scale = scale.fold(0.0, f64::max);
    let solved = problem.residual(&lambda);
    assert!(
        solved < 1e-4 * scale,
        "residual {solved} at multipliers of {scale}"
    );
    let matrix_free = residual(&points, &bodies, friction);
    assert!(
        f64::from(matrix_free.natural_map) < 1e-4 * scale,
        "{matrix_free:?}"
    );
}

#[test]
fn residual_falls_with_more_sweeps() {
    let mut last = f32::INFINITY;
    for sweeps in [1, 8, 64, 512] {
        for friction_model in [FrictionModel::Disc, FrictionModel::Box] {
            let (mut points, mut bodies) = heap(0.5);
            pgs::solve(&mut points, &mut bodies, sweeps, friction_model);
            let residual = residual(&points, &bodies, friction_model).relative;
            assert!(
                residual < last,
                "{residual} after {sweeps} sweeps, {last} before"
            );
            if friction_model == FrictionModel::Box {
                last = residual;
            }
        }
    }
    assert!(last < 1e-3, "{last}");
}

#[test]
fn friction_stays_in_its_bounds() {
    for friction_model in [FrictionModel::Disc, FrictionModel::Box] {
        let solved = |sweeps| {
            let (mut points, mut bodies) = heap(0.3);
            pgs::solve(&mut points, &mut bodies, sweeps, friction_model);
            points
        };
        // In a sweep friction comes first, so its bound is the normal impulse as the sweep before left it.
        let sweeps = Pgs::default().sweeps;
        let (before, after) = (solved(sweeps - 1), solved(sweeps));
        let mut at_the_bound = 0;
        for (before, point) in before.iter().zip(&after) {
            assert!(point.normal.impulse >= 0.0);
            let [t1, t2] = point.tangents.map(|t| f64::from(t.impulse));
            let friction = match friction_model {
                FrictionModel::Disc => (t1 * t1 + t2 * t2).sqrt(),
                FrictionModel::Box => t1.abs().max(t2.abs()),
            };
            // Scaling onto the disc rounds a few times in f32; clipping to the box does not.
            let bound = f64::from(0.3 * before.normal.impulse);
            assert!(friction <= bound * (1.0 + 1e-6), "{friction} of {bound}");
            at_the_bound += usize::from(bound > 0.0 && friction >= bound * (1.0 - 1e-6));
        }
        assert!(at_the_bound > 0, "no point slips, the bound is not tried");
    }
}

#[test]
fn free_fall_is_the_parabola() {
    let mut simulation = awake();
    let body = add(&mut simulation, dynamic(&cube(1.0), 0.0, 0.0, 0.0));
    for _ in 0..120 {
        simulation.step(H);
    }
    let expected = -9.81 * 2.0 * 2.0 / 2.0;
    let y = f64::from(simulation.bodies.center_of_mass(body).y);
    assert!(
        (y - expected).abs() < 1e-6 * -expected,
        "{y} instead of {expected}"
    );
}

/// Distance that a cube slides on the floor from 10 m/s in the direction `angle_rad`, m.
fn slide(config: SolverConfig, direction: Vec3) -> f32 {
    let mut simulation = with_floor();
    simulation.config = config;
    let flat = ConvexMesh::cuboid(1.0, 0.1, 1.0).expect("valid size");
    let mut desc = dynamic(&flat, 0.0, 0.05, 0.0);
    desc.linear_velocity = 10.0 * direction;
    let body = add(&mut simulation, desc);
    for _ in 0..200 {
        simulation.step(H);
    }
    let (v, _) = simulation.bodies.velocity(body);
    assert!(v.length() < 1e-3, "still sliding at {v}");
    simulation.bodies.center_of_mass(body).with_y(0.0).length()
}

#[test]
fn sliding_stops_where_coulomb_says_in_every_direction() {
    // h sum(v0 - k mu g h) while positive, with sub-steps of h and mu = 0.5; v0^2 / (2 mu g) = 10.1937 m in the limit.
    let h = H / SoftStep::default().min_substeps as f32;
    let mut expected = 0.0;
    let mut v = 10.0 - 0.5 * G * h;
    while v > 0.0 {
        expected += v * h;
        v -= 0.5 * G * h;
    }
    let diagonal = std::f32::consts::FRAC_1_SQRT_2;
    for (x, z) in [
        (1.0, 0.0),
        (diagonal, diagonal),
        (0.0, 1.0),
        (-0.8, 0.6),
        (-0.6, -0.8),
    ] {
        let d = slide(SolverConfig::default(), Vec3::new(x, 0.0, z));
        assert!(
            (d - expected).abs() < 0.001 * expected,
            "{d} m along ({x}, {z}), not {expected}"
        );
    }
}

#[test]
fn friction_that_is_taken_away_lets_go_at_once() {
    let mut simulation = awake();
    let tilt = Quat::from_rotation_z(0.3);
    let mut slope = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    slope.pose.rotation = tilt;
    add(&mut simulation, slope);
    let mut desc = BodyDesc::dynamic(cube(1.0), tilt * Vec3::new(0.0, 0.5, 0.0));
    desc.pose.rotation = tilt;
    let body = add(&mut simulation, desc.clone());
    for _ in 0..60 {
        simulation.step(H);
    }
    assert!(simulation.bodies.velocity(body).0.length() < 1e-3, "holds");
    desc.friction = Friction::new(0.0).with_combine(CombineRule::Min);
    simulation.bodies.redescribe(body, desc).expect("usable");
    for _ in 0..60 {
        simulation.step(H);
    }
    let speed = simulation.bodies.velocity(body).0.length();
    let free = G * 0.295_52;
    assert!(
        (speed - free).abs() < 0.02 * free,
        "{speed} m/s, not {free}"
    );
}

#[test]
fn box_friction_is_stronger_along_the_diagonal_of_its_tangents() {
    let normal_tangents = bevy_cleave::testing::math::tangents(Vec3::Y);
    let diagonal = (normal_tangents[0] + normal_tangents[1]).normalize();
    let boxed: SolverConfig = Pgs {
        friction: FrictionModel::Box,
        ..Pgs::default()
    }
    .into();
    let along = slide(boxed, normal_tangents[0]);
    let across = slide(boxed, diagonal);
    assert!(
        (across / along - std::f32::consts::FRAC_1_SQRT_2).abs() < 0.02,
        "{across} / {along}"
    );
}

#[test]
fn resting_bodies_stay_and_their_contacts_carry_their_weight() {
    // The paper's 16 sweeps do not converge before the column has settled by millimetres; 32 do.
    let configs = [
        (SolverConfig::default(), 0.001),
        (paper(16), 0.02),
        (paper(32), 0.002),
    ];
    for (config, drift) in configs {
        let mut simulation = with_floor();
        simulation.config = SolverConfig {
            sleep: SleepConfig::off(),
            ..config
        };
        let column: Vec<u32> = (0..5_u8)
            .map(|i| {
                add(
                    &mut simulation,
                    dynamic(&cube(1.0), 0.0, 0.5 + f32::from(i), 0.0),
                )
            })
            .collect();
        for _ in 0..600 {
            simulation.step(H);
        }
        let moved = simulation.bodies.center_of_mass(column[4]) - Vec3::new(0.0, 4.5, 0.0);
        assert!(moved.length() < drift, "{moved} with {config:?}");
        let floor_contact = simulation.contacts.manifolds().get(0).expect("it stands");
        let carried: f32 = floor_contact
            .points()
            .iter()
            .map(|p| p.normal_impulse)
            .sum();
        let weight = 5.0 * 1000.0 * G * H;
        assert!(
            (carried - weight).abs() < 1e-3 * weight,
            "{carried} N s carried of {weight}"
        );
    }
}

/// Heights at the ends of the steps around the apexes (the last ones on the way up) of a point that falls from `height` (m) on a
/// floor, in steps of `H` without relax sweeps, by the scheme itself in f64.
///
/// The step in which the free motion would close the gap gives the point `e` times the speed that it would have there; if it is
/// slower than the threshold, the speed that closes the gap. A point that nothing pushes follows the parabola.
fn discrete_apexes(height: f64, e: f64, steps: usize) -> Vec<f64> {
    let (h, g) = (f64::from(H), f64::from(G));
    let threshold = f64::from(SolverConfig::paper().restitution_threshold);
    let (mut y, mut v, mut apexes) = (height, 0.0_f64, Vec::new());
    for _ in 0..steps {
        let (y_before, v_before) = (y, v);
        let free = v - g * h;
        let target_velocity = if -free > threshold && -free * h > y {
            e * (v * v + 2.0 * g * y).sqrt()
        } else {
            -y / h
        };
        v = free.max(target_velocity);
        let flight = if target_velocity > free {
            0.0
        } else {
            0.5 * g * h * h
        };
        y += v * h + flight;
        if v_before > 0.0 && v <= 0.0 {
            apexes.push(y_before);
        }
    }
    apexes
}

/// Drops a flat cube with `e = 0.5` (1 combined with the floor's 0 by averaging) from 1 m; returns for each apex the height at the
/// end of the last step on the way up and that of the parabola from there, m. It must not turn faster than `spin` after a
/// rebound, nor than five times that when it has come to rest.
fn apexes(config: SolverConfig, spin: f32) -> Vec<[f64; 2]> {
    let mut simulation = with_floor();
    simulation.config = config;
    let mut desc = dynamic(&cube(1.0), 0.0, 1.5, 0.0);
    desc.restitution = Restitution::new(1.0);
    let body = add(&mut simulation, desc);
    let mut apexes = Vec::new();
    let mut last_speed = 0.0;
    for _ in 0..200 {
        let height = f64::from(simulation.bodies.center_of_mass(body).y - 0.5);
        let speed = f64::from(simulation.bodies.velocity(body).0.y);
        simulation.step(H);
        let (v, omega) = simulation.bodies.velocity(body);
        assert!(
            omega.length() < if v.y > 0.3 { spin } else { 5.0 * spin },
            "a flat impact must not spin the cube: {omega}"
        );
        if last_speed > 0.0 && v.y <= 0.0 {
            apexes.push([height, height + speed * speed / (2.0 * f64::from(G))]);
        }
        last_speed = v.y;
    }
    apexes
}

#[test]
fn rebound_has_the_speed_of_the_coefficient() {
    let apexes = apexes(SolverConfig::default(), 1e-3);
    assert!(apexes.len() >= 2);
    for ([_, apex], expected) in apexes.into_iter().zip([0.25, 0.0625]) {
        assert!(
            (apex - expected).abs() < 0.01 * expected,
            "{apex} m, not {expected}"
        );
    }
}

#[test]
fn rebound_of_the_papers_method_is_that_of_its_scheme() {
    let (apexes, expected) = (apexes(paper(64), 2e-3), discrete_apexes(1.0, 0.5, 200));
    assert!(expected.len() >= 3 && apexes.len() >= expected.len());
    // Each rebound takes over what rounding in f32 did to the one before: 1.2e-5 m at the third, whatever the sweeps.
    for (bounces, ([apex, _], expected)) in (1..).zip(apexes.into_iter().zip(expected)) {
        let bound = 1e-5 * f64::from(bounces);
        assert!((apex - expected).abs() < bound, "{apex} m, not {expected}");
    }
}

/// Momentum, angular momentum about the origin and kinetic energy of all bodies.
fn totals(simulation: &Simulation) -> (DVec3, DVec3, f64) {
    let bodies = &simulation.bodies;
    bodies
        .iter()
        .fold((DVec3::ZERO, DVec3::ZERO, 0.0), |(p, l, e), slot| {
            let (v, omega) = bodies.velocity(slot);
            let mass = bodies.mass(slot);
            let rotation = (bodies.pose(slot).rotation * mass.principal_frame)
                .as_dquat()
                .normalize();
            let momentum = f64::from(mass.mass) * v.as_dvec3();
            let spin =
                rotation * (mass.principal.as_dvec3() * (rotation.inverse() * omega.as_dvec3()));
            let orbit = bodies.center_of_mass(slot).as_dvec3().cross(momentum);
            (
                p + momentum,
                l + orbit + spin,
                e + bodies.kinetic_energy(slot),
            )
        })
}

#[test]
fn contacts_conserve_momentum_and_lose_energy_in_a_zero_g_cloud() {
    let mut simulation = Simulation {
        gravity: Gravity(Vec3::ZERO),
        ..awake()
    };
    let mut dice = Dice::new(7);
    let shape = cube(0.5);
    for i in 0..64_u8 {
        let grid = Vec3::new(f32::from(i % 4), f32::from(i / 4 % 4), f32::from(i / 16)) - 1.5;
        let mut desc = BodyDesc::dynamic(shape.clone(), 0.9 * grid);
        desc.linear_velocity = dice.vector(-1.0, 1.0) - 0.5 * grid;
        desc.angular_velocity = 3.0 * dice.vector(-1.0, 1.0);
        desc.restitution = Restitution::new(0.5);
        add(&mut simulation, desc);
    }
    simulation.step(H);
    let (p0, l0, e0) = totals(&simulation);
    let bodies = &simulation.bodies;
    let scales = bodies.iter().map(|s| {
        let (v, omega) = bodies.velocity(s);
        let mass = bodies.mass(s);
        let momentum = f64::from(mass.mass) * v.as_dvec3();
        let orbit = bodies.center_of_mass(s).as_dvec3().cross(momentum);
        // Of a cube: one moment about all axes.
        let spin = f64::from(mass.principal.x) * omega.as_dvec3();
        (momentum.length(), orbit.length() + spin.length())
    });
    let (scale, angular_scale) = scales.fold((0.0, 0.0), |(p, l), (dp, dl)| (p + dp, l + dl));
    for _ in 0..300 {
        simulation.step(H);
    }
    let (p, l, e) = totals(&simulation);
    assert!(
        simulation.report.bodies == 64 && e < 0.9 * e0,
        "they collide: {e0} J, then {e} J"
    );
    // Measured: 2e-8 and 8e-6 of the sums of magnitudes at the start: rounding, and contact points that follow the motion by sub-steps.
    assert!(
        (p - p0).length() < 1e-6 * scale,
        "momentum {}",
        (p - p0).length() / scale
    );
    assert!(
        (l - l0).length() < 2e-5 * angular_scale,
        "angular momentum {}",
        (l - l0).length() / angular_scale
    );
}

#[test]
fn tumbling_body_keeps_flipping_and_does_not_gain_energy() {
    let mut simulation = Simulation {
        gravity: Gravity(Vec3::ZERO),
        ..awake()
    };
    let plate = ConvexMesh::cuboid(1.0, 0.5, 0.2).expect("valid size");
    let mut desc = BodyDesc::dynamic(plate, Vec3::ZERO);
    desc.angular_velocity = Vec3::new(0.01, 10.0, 0.01);
    let body = add(&mut simulation, desc);
    simulation.step(H);
    let (_, l0, e0) = totals(&simulation);
    let (mut flips, mut side) = (0, true);
    for _ in 0..10 * 60 {
        simulation.step(H);
        let (_, _, e) = totals(&simulation);
        assert!((e - e0).abs() < 1e-3 * e0, "energy: {e0} J, then {e} J");
        let axis_spin = (simulation.bodies.pose(body).rotation.inverse()
            * simulation.bodies.velocity(body).1)
            .y;
        if (axis_spin > 0.0) != side && axis_spin.abs() > 5.0 {
            (flips, side) = (flips + 1, !side);
        }
    }
    let (_, l, _) = totals(&simulation);
    assert!(
        flips >= 2,
        "the intermediate axis is unstable: {flips} flips"
    );
    assert!((l - l0).length() < 1e-3 * l0.length(), "{l0} became {l}");
}

/// A tonne on three plates of 2 kg, each 2 cm deep in the next, with single sweeps: what pushes them apart was left in the
/// velocity of the heavy one, 2 m/s within four steps.
#[test]
fn overlap_that_is_not_solved_to_the_end_gives_no_energy() {
    let mut simulation = Simulation {
        gravity: Gravity(Vec3::ZERO),
        ..awake()
    };
    simulation.config.method = SoftStep {
        tolerance: None,
        ..SoftStep::default()
    }
    .into();
    let mut floor = dynamic(&cube(1.0), 0.0, -0.5, 0.0);
    floor.kind = RigidBody::Static;
    add(&mut simulation, floor);
    let plate = ConvexMesh::cuboid(1.0, 0.1, 1.0).expect("valid size");
    for i in 0..3_u8 {
        let mut desc = dynamic(&plate, 0.0, 0.03 + 0.08 * f32::from(i), 0.0);
        desc.density = 20.0;
        add(&mut simulation, desc);
    }
    let mut heavy = dynamic(&cube(1.0), 0.0, 0.72, 0.0);
    heavy.density = 1000.0;
    let heavy = add(&mut simulation, heavy);
    let start = simulation.bodies.center_of_mass(heavy).y;
    for _ in 0..30 {
        simulation.step(H);
        let (_, _, energy) = totals(&simulation);
        assert!(energy < 1e-6, "{energy} J");
    }
    let pushed = simulation.bodies.center_of_mass(heavy).y - start;
    assert!(pushed > 0.0, "{pushed} m");
}

#[test]
fn overlapping_bodies_part_without_an_explosion() {
    let mut simulation = Simulation {
        gravity: Gravity(Vec3::ZERO),
        ..awake()
    };
    let bodies = [0.0, 0.5].map(|x| add(&mut simulation, dynamic(&cube(1.0), x, 0.0, 0.0)));
    for _ in 0..120 {
        simulation.step(H);
        let speed = bodies.map(|b| simulation.bodies.velocity(b).0.length());
        assert!(
            speed
                .iter()
                .all(|s| *s <= simulation.config.push_out_speed + 1e-3),
            "{speed:?}"
        );
    }
    let [a, b] = bodies.map(|b| simulation.bodies.center_of_mass(b));
    assert!((b - a).x.abs() > 0.99, "parted: {a} {b}");
}

#[test]
fn stable_motion_far_from_the_origin_is_the_same_as_near_it() {
    let request_sleep = |offset: Vec3| {
        let mut simulation = awake();
        let mut floor = dynamic(
            &ConvexMesh::cuboid(10.0, 1.0, 10.0).expect("valid size"),
            0.0,
            -0.5,
            0.0,
        );
        floor.kind = RigidBody::Static;
        floor.pose.position += offset;
        add(&mut simulation, floor);
        let mut desc = dynamic(&cube(1.0), 0.0, 1.0, 0.0);
        desc.pose = Pose::new(desc.pose.position + offset, Quat::from_rotation_z(0.2));
        let body = add(&mut simulation, desc);
        for _ in 0..300 {
            simulation.step(H);
        }
        (
            simulation.bodies.center_of_mass(body) - offset,
            simulation.bodies.velocity(body).0,
        )
    };
    let (near, _) = request_sleep(Vec3::ZERO);
    let (far, v) = request_sleep(Vec3::new(1024.0, 0.0, -1024.0));
    assert!((near - far).length() < 0.02, "{near} and {far}");
    assert!(
        (far.y - 0.5).abs() < 0.01 && v.length() < 0.01,
        "at rest: {far}, {v}"
    );
}

#[test]
fn kinematic_body_pushes_and_is_not_pushed() {
    let mut simulation = with_floor();
    let mut pusher = dynamic(&cube(1.0), -2.0, 0.55, 0.0);
    pusher.kind = RigidBody::Kinematic;
    pusher.linear_velocity = Vec3::new(1.0, 0.0, 0.0);
    let pusher = add(&mut simulation, pusher);
    let pushed = add(&mut simulation, dynamic(&cube(1.0), 0.0, 0.5, 0.0));
    for _ in 0..180 {
        simulation.step(H);
    }
    let [a, b] = [pusher, pushed].map(|slot| simulation.bodies.center_of_mass(slot));
    assert!((a - Vec3::new(1.0, 0.55, 0.0)).length() < 1e-4, "{a}");
    assert!((b.x - 2.0).abs() < 0.01 && b.z.abs() < 0.01, "{b}");
}

#[test]
fn bodies_of_layers_that_do_not_meet_pass_through_each_other() {
    let mut simulation = with_floor();
    let layers = CollisionLayers {
        memberships: 0b10,
        filters: 0b01,
    };
    let mut fallen = [0.5, 2.0].map(|y| dynamic(&cube(1.0), 0.0, y, 0.0));
    for desc in &mut fallen {
        desc.layers = layers;
    }
    let fallen = fallen.map(|desc| add(&mut simulation, desc));
    for _ in 0..120 {
        simulation.step(H);
    }
    for slot in fallen {
        let y = simulation.bodies.center_of_mass(slot).y;
        assert!(
            (y - 0.5).abs() < 0.01,
            "rests on the floor, inside the other: {y}"
        );
    }
}

/// A step that is one sub-step, whatever the load asks for.
fn one_substep() -> Method {
    SoftStep {
        min_substeps: 1,
        max_substeps: 1,
        ..SoftStep::default()
    }
    .into()
}

#[test]
fn a_blow_leaves_contacts_that_it_does_not_reach_their_impulses() {
    let mut simulation = with_floor();
    simulation.config.method = one_substep();
    let beam = ConvexMesh::cuboid(20.0, 1.0, 1.0).expect("valid size");
    let beam = add(&mut simulation, dynamic(&beam, 0.0, 0.5, 0.0));
    let [lower, upper] = [1.5, 2.5].map(|y| dynamic(&cube(1.0), -9.0, y, 0.0));
    let [lower, upper] = [lower, upper].map(|desc| add(&mut simulation, desc));
    let mut falling = dynamic(&cube(1.0), 9.0, 1.51, 0.0);
    falling.linear_velocity = Vec3::new(0.0, -3.0, 0.0);
    let falling = add(&mut simulation, falling);
    // Nothing is known of any contact before this step.
    simulation.step(H);
    let bears = |a: u32, b: u32| {
        let manifolds = simulation.contacts.manifolds().iter();
        let mut of_pair = manifolds.filter(|m| [m.a, m.b] == [a, b]);
        let points = of_pair.next().expect("they touch").points();
        let sum = |of: fn(&ContactPoint) -> f32| points.iter().map(of).sum::<f32>();
        [sum(|p| p.normal_impulse), sum(|p| p.total_impulse)]
    };
    let [next, blow] = bears(beam, falling);
    assert!(next == 0.0 && blow > 1000.0, "{next} {blow}");
    let [next, weight] = bears(beam, lower);
    assert!(next == 0.0 && weight > 0.0, "{next} {weight}");
    let [next, weight] = bears(lower, upper);
    assert!(next > 0.0 && next == weight, "{next} {weight}");
}

#[test]
fn a_blow_is_forgotten_by_all_contacts_that_it_went_through() {
    let mut simulation = with_floor();
    simulation.config.method = one_substep();
    let column = [0.5, 1.5, 2.5].map(|y| dynamic(&cube(1.0), 0.0, y, 0.0));
    let [lower, middle, _] = column.map(|desc| add(&mut simulation, desc));
    let mut falling = dynamic(&cube(1.0), 0.0, 3.51, 0.0);
    falling.linear_velocity = Vec3::new(0.0, -3.0, 0.0);
    add(&mut simulation, falling);
    simulation.step(H);
    let bears = |body: u32| {
        let manifolds = simulation.contacts.manifolds().iter();
        let mut below = manifolds.filter(|m| m.b == body && m.a < body);
        let points = below.next().expect("it stands on something").points();
        let sum = |of: fn(&ContactPoint) -> f32| points.iter().map(of).sum::<f32>();
        [sum(|p| p.normal_impulse), sum(|p| p.total_impulse)]
    };
    for body in [lower, middle] {
        let [next, blow] = bears(body);
        assert!(next == 0.0 && blow > 1000.0, "{next} {blow}");
    }
}
