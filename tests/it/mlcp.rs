//! Contact problems from files: the exact method solves them all, and says so itself.
#![expect(
    clippy::print_stdout,
    reason = "tables for those who ask with --nocapture"
)]

use crate::common::scenes::awake;
use crate::mlcp_files::sweeps::{Method, Profile};
use crate::mlcp_files::{File, Problem, load_all};
use bevy_cleave::contact::ContactPoint;
use bevy_cleave::prelude::*;
use bevy_cleave::solver::FrictionModel;
use bevy_cleave::testing::bodies::SolverBody;
use bevy_cleave::testing::exact::{Bounds, CERTIFIED, Certificate, ExactScratch};
use bevy_cleave::testing::rows::{
    ImpulseSystem, Momentum, PointContacts, PointRows, ResidualSum, RowBody, Solved,
};
use bevy_cleave::testing::{exact, pgs};
use glam::{Mat3, Vec3};
use std::time::Instant;

/// Largest difference of two lists.
fn distance(x: &[f64], y: &[f64]) -> f64 {
    let pairs = x.iter().zip(y);
    pairs.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

/// A problem's own velocity scale: the fastest constraint velocity with or without the contacts, in the file's unit.
fn velocity_scale(file: &File, w: &[f64]) -> f64 {
    file.b
        .iter()
        .chain(w)
        .fold(0.0, |m, v| f64::max(m, v.abs()))
}

/// Largest error of `w` relative to the velocity scale, beyond the rounding of the sums that `w` comes from.
///
/// Rounding matters in one file, `scale_mix`, where cubes of 1 g carry impulses half a million times their own momentum:
/// even the stored multipliers give velocities that differ from the stored ones by 7e-10 of the scale.
fn error_of_w(file: &File, problem: &Problem, lambda: &[f64]) -> f64 {
    let reference = file.reference.as_ref().expect("solvable");
    let scale = velocity_scale(file, &reference.w);
    let (w, magnitude) = (problem.w(lambda), problem.magnitude(lambda));
    let rows = w.iter().zip(&reference.w).zip(&magnitude);
    let beyond =
        |w: f64, target_velocity: f64, m: f64| (w - target_velocity).abs() - f64::EPSILON * m;
    rows.map(|((&w, &target_velocity), &m)| beyond(w, target_velocity, m) / scale)
        .fold(0.0, f64::max)
}

/// Solves from `start`; returns the certificate, the error of `w`, and microseconds.
fn judge(file: &File, start: &[f64], scratch: &mut ExactScratch) -> (Certificate, f64, f64) {
    let mut lambda = start.to_vec();
    let clock = Instant::now();
    let certificate = file.problem.solve(&mut lambda, scratch);
    let micros = clock.elapsed().as_secs_f64() * 1e6;
    (
        certificate,
        error_of_w(file, &file.problem, &lambda),
        micros,
    )
}

/// Solvable files with the frozen bounds of their reference.
fn frozen_files() -> Vec<File> {
    let mut files = load_all();
    files.retain(|file| file.reference.is_some());
    for file in &mut files {
        let reference = file.reference.as_ref().expect("retained");
        file.problem.set_bounds(reference.bounds.clone());
    }
    files
}

#[test]
fn the_set_is_complete() {
    let files = load_all();
    assert_eq!(files.len(), 42);
    let unsolvable: Vec<_> = files.iter().filter(|f| f.reference.is_none()).collect();
    assert_eq!(unsolvable.len(), 1);
    assert_eq!(unsolvable[0].name, "squeeze_infeasible");
}

#[test]
fn exact_finds_the_velocities_of_all_files_cold_and_certifies_them() {
    println!("file | rows | factorisations | us | residual | error of w");
    for file in frozen_files() {
        let start = vec![0.0; file.b.len()];
        let (certificate, error, micros) = judge(&file, &start, &mut ExactScratch::default());
        let (name, rows) = (&file.name, file.b.len());
        let Certificate {
            residual,
            iterations,
            ..
        } = certificate;
        println!("{name} | {rows} | {iterations} | {micros:.0} | {residual:.1e} | {error:.1e}");
        assert!(certificate.converged, "{name}: {certificate:?}");
        assert!(residual <= CERTIFIED, "{name}: residual {residual:e}");
        assert!(error <= 1e-9, "{name}: w differs by {error:e}");
    }
}

#[test]
fn exact_finds_the_same_velocities_from_the_step_before() {
    let mut scratch = ExactScratch::default();
    println!("file | factorisations | us | residual | error of w");
    let mut starts = 0;
    for file in frozen_files() {
        let Some(warm) = file.reference.as_ref().and_then(|r| r.warm.clone()) else {
            continue;
        };
        starts += 1;
        let (certificate, error, micros) = judge(&file, &warm, &mut scratch);
        let (name, residual) = (&file.name, certificate.residual);
        let iterations = certificate.iterations;
        println!("{name} | {iterations} | {micros:.0} | {residual:.1e} | {error:.1e}");
        assert!(certificate.converged, "{name}: {certificate:?}");
        assert!(error <= 1e-9, "{name}: w differs by {error:e}");
    }
    assert_eq!(starts, 20);
}

#[test]
fn reference_solutions_are_certified_as_they_are() {
    for file in frozen_files() {
        let lambda = file.reference.as_ref().expect("solvable").lambda.clone();
        let (certificate, error, _) = judge(&file, &lambda, &mut ExactScratch::default());
        assert!(certificate.converged, "{}: {certificate:?}", file.name);
        assert!(error <= 1e-9, "{}: w differs by {error:e}", file.name);
    }
}

#[test]
fn bodies_and_matrix_give_the_same_velocities() {
    let mut compared = 0;
    for file in frozen_files() {
        let Problem::Bodies(problem) = &file.problem else {
            continue;
        };
        if file.b.len() > 120 {
            continue;
        }
        compared += 1;
        let dense = Problem::Dense(problem.to_dense());
        let mut lambda = vec![0.0; file.b.len()];
        let certificate = dense.solve(&mut lambda, &mut ExactScratch::default());
        let error = error_of_w(&file, &dense, &lambda);
        assert!(certificate.converged, "{}: {certificate:?}", file.name);
        assert!(error <= 1e-9, "{}: w differs by {error:e}", file.name);
    }
    assert!(compared >= 15, "only {compared} problems");
}

/// With friction bounds that follow the normal multipliers no solution is promised to be found; these are not.
const NOT_COUPLED: [(FrictionModel, &[&str]); 2] = [
    (
        FrictionModel::Box,
        &["Capsules-i101-404", "OneObject-i100000-316"],
    ),
    (
        FrictionModel::Disc,
        &[
            "Box_Stacks-i0122-82-5",
            "Capsules-i101-404",
            "OneObject-i1028-138",
        ],
    ),
];

#[test]
fn exact_finds_a_solution_with_bounds_that_follow_the_normal_multipliers() {
    let mut scratch = ExactScratch::default();
    for (model, left_out) in NOT_COUPLED {
        println!("{model:?}: file | factorisations | us | residual");
        for mut file in frozen_files() {
            if left_out.contains(&file.name.as_str()) {
                continue;
            }
            file.problem.set_bounds(Bounds::Coupled(model));
            let start = vec![0.0; file.b.len()];
            let (certificate, _, micros) = judge(&file, &start, &mut scratch);
            let (name, residual) = (&file.name, certificate.residual);
            let iterations = certificate.iterations;
            println!("{name} | {iterations} | {micros:.0} | {residual:.1e}");
            assert!(certificate.converged, "{name} {model:?}: {certificate:?}");
        }
    }
}

#[test]
fn a_problem_without_solution_gets_bounded_multipliers_whatever_the_start() {
    let files = load_all();
    let file = files
        .iter()
        .find(|f| f.reference.is_none())
        .expect("in the set");
    let mut scratch = ExactScratch::default();
    let mut lambda = vec![0.0; file.b.len()];
    let first = file.problem.solve(&mut lambda, &mut scratch);
    assert!(!first.converged && first.residual.is_finite(), "{first:?}");
    let once = lambda.clone();
    // A step of 1 / 60 s under gravity takes 0.16 m/s; the walls push at up to 0.05 m/s.
    let fastest = file
        .problem
        .w(&lambda)
        .iter()
        .fold(0.0, |m, w| f64::max(m, w.abs()));
    assert!(fastest <= 1.0, "constraint velocity {fastest} m/s");
    for _ in 0..20 {
        file.problem.solve(&mut lambda, &mut scratch);
    }
    let drift = distance(&lambda, &once);
    let size = once.iter().fold(0.0, |m: f64, l| m.max(l.abs()));
    assert!(size < 1e6, "multipliers up to {size} N s");
    assert!(drift <= 1e-6 * size, "drift {drift:e} N s of {size:e}");
}

const H: f32 = 1.0 / 60.0;

/// Rows without impulses, velocities `v*` and inverse inertias of a scene; bodies by slot.
type Scene = (Vec<PointRows>, Vec<SolverBody>, Vec<Mat3>);

/// Two columns of three cubes that touch a floor.
fn two_columns() -> Scene {
    let mut simulation = awake();
    let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    simulation.bodies.insert(floor).expect("usable");
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
    for i in 0..6_u8 {
        let (level, column) = (f32::from(i / 2), f32::from(i % 2));
        let place = Vec3::new(10.0 * column + 0.1 * level, 0.5 + level, 0.0);
        let desc = BodyDesc::dynamic(cube.clone(), place);
        simulation.bodies.insert(desc).expect("usable");
    }
    scene(simulation)
}

/// A column of cubes that touch a floor, the highest `factor` times as heavy as the others.
fn column(count: u8, factor: f32) -> Scene {
    let mut simulation = awake();
    let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    simulation.bodies.insert(floor).expect("usable");
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
    for i in 0..count {
        let mut desc = BodyDesc::dynamic(cube.clone(), Vec3::Y * (0.5 + f32::from(i)));
        if i + 1 == count {
            desc.density *= factor;
        }
        simulation.bodies.insert(desc).expect("usable");
    }
    scene(simulation)
}

/// The contacts of cubes after a step, pulled down and aside from rest.
fn scene(mut simulation: Simulation) -> Scene {
    simulation.step(H);
    let (mut bodies, mut inertia) = (simulation.bodies.solver_bodies().to_vec(), Vec::new());
    for (slot, body) in bodies.iter_mut().enumerate() {
        body.angular = Vec3::ZERO;
        body.linear = Vec3::ZERO;
        let mut inverse = 0.0;
        if body.inverse_mass > 0.0 {
            body.linear = Vec3::new(0.02, -9.81 * H, 0.01);
            // A cube is the same about all axes.
            inverse = 1.0 / simulation.bodies.mass(slot as u32).principal.x;
        }
        inertia.push(Mat3::from_diagonal(Vec3::splat(inverse)));
    }
    let mut rows = Vec::new();
    for manifold in simulation.contacts.manifolds().iter() {
        let sides = [manifold.a, manifold.b].map(|slot| RowBody {
            inverse_mass: bodies[slot as usize].inverse_mass,
            inverse_inertia: inertia[slot as usize],
        });
        for point in manifold.points() {
            let cold = ContactPoint {
                normal_impulse: 0.0,
                friction_impulse: Vec3::ZERO,
                ..*point
            };
            let pair = [manifold.a, manifold.b];
            rows.push(PointRows::new(&manifold, &cold, pair, sides, 1.0, 0.0));
        }
    }
    (rows, bodies, inertia)
}

#[test]
fn rows_of_a_step_are_solved_to_single_precision_and_again_from_their_own_impulses() {
    let (without_impulses, start, inertia) = two_columns();
    assert_eq!(without_impulses.len(), 24, "four points per contact");
    let mut scratch = ExactScratch::default();
    for model in [FrictionModel::Disc, FrictionModel::Box] {
        let solved = Solved {
            friction: model,
            is_relaxed: false,
        };
        let (mut rows, mut bodies) = (without_impulses.clone(), start.clone());
        let cold = exact::solve(&mut rows, &mut bodies, &inertia, model, &mut scratch);
        assert!(cold.converged, "{model:?} cold: {cold:?}");
        let residual = ResidualSum::of(&rows, &bodies, solved).residual();
        assert!(residual.relative < 1e-5, "{model:?}: {residual:?}");
        let mut again = start.clone();
        let warm = exact::solve(&mut rows, &mut again, &inertia, model, &mut scratch);
        assert!(warm.converged, "{model:?} warm: {warm:?}");
        for (x, y) in bodies.iter().zip(&again) {
            let apart = x.linear.distance(y.linear) + x.angular.distance(y.angular);
            assert!(apart < 1e-6, "{model:?}: {apart} m/s apart");
        }
        println!("{model:?}: cold {cold:?}, warm {warm:?}");
    }
}

/// Sweeps, plain or with momentum, until the relative residual is at most `level`; 20 000 if it never is.
fn sweeps_needed(with_momentum: bool, scene: &Scene, model: FrictionModel, level: f32) -> u32 {
    let (mut rows, mut bodies, _) = scene.clone();
    let solved = Solved {
        friction: model,
        is_relaxed: false,
    };
    let mut contacts = PointContacts {
        rows: &mut rows,
        bodies: &mut bodies,
        friction_model: model,
        sweep: |rows: &mut [PointRows], bodies: &mut [SolverBody]| pgs::sweep(rows, bodies, model),
    };
    let mut momentum = Momentum::default();
    for sweeps in 1..20_000 {
        if with_momentum {
            momentum.sweep(&mut contacts);
        } else {
            contacts.sweep();
        }
        let sum = ResidualSum::of(contacts.rows, contacts.bodies, solved);
        if sum.residual().relative <= level {
            return sweeps;
        }
    }
    20_000
}

#[test]
fn momentum_takes_fewer_sweeps_in_single_precision() {
    for model in [FrictionModel::Disc, FrictionModel::Box] {
        for (name, scene) in [
            ("10 cubes", column(10, 1.0)),
            ("4 cubes under 100 times their mass", column(5, 100.0)),
        ] {
            for level in [1e-2, 1e-3, 1e-4] {
                let needed = |on| sweeps_needed(on, &scene, model, level);
                let [plain, fast] = [false, true].map(needed);
                println!("{model:?}, {name}, {level:e}: {plain} sweeps, {fast} with momentum");
                assert!(fast < plain, "{name} {level:e}: {fast} for {plain}");
            }
        }
    }
}

/// Momentum of all bodies, kg m/s.
fn total_momentum(bodies: &[SolverBody]) -> Vec3 {
    let movable = bodies.iter().filter(|b| b.inverse_mass > 0.0);
    movable.map(|b| b.linear / b.inverse_mass).sum()
}

#[test]
fn velocities_stay_those_of_the_impulses_under_momentum() {
    let (mut rows, start, _) = column(10, 1.0);
    let mut bodies = start.clone();
    let mut contacts = PointContacts {
        rows: &mut rows,
        bodies: &mut bodies,
        friction_model: FrictionModel::Disc,
        sweep: |rows: &mut [PointRows], bodies: &mut [SolverBody]| {
            pgs::sweep(rows, bodies, FrictionModel::Disc)
        },
    };
    let mut momentum = Momentum::default();
    for _ in 0..200 {
        momentum.sweep(&mut contacts);
    }
    let mut again = start.clone();
    pgs::apply_impulses(&rows, &mut again);
    for (x, y) in bodies.iter().zip(&again) {
        let apart = x.linear.distance(y.linear) + x.angular.distance(y.angular);
        assert!(apart < 1e-4, "{apart} m/s apart");
    }
    let apart = total_momentum(&bodies).distance(total_momentum(&again));
    assert!(
        apart < 1e-4 * total_momentum(&start).length(),
        "{apart} N s apart"
    );
}

#[test]
fn a_part_of_the_rows_moves_only_its_own_bodies_and_as_if_solved_with_the_rest() {
    let (rows, start, inertia) = two_columns();
    let model = FrictionModel::Disc;
    let mut scratch = ExactScratch::default();
    let mut all = (rows.clone(), start.clone());
    exact::solve(&mut all.0, &mut all.1, &inertia, model, &mut scratch);
    let x = |point: &PointRows, bodies: &[SolverBody]| {
        point
            .bodies
            .map(|slot| (slot, bodies[slot as usize].inverse_mass > 0.0))
    };
    // Columns alternate in the order of insertion: slots 1, 3, 5 and 2, 4, 6.
    let in_first = |point: &PointRows| {
        x(point, &start)
            .iter()
            .any(|(s, moves)| *moves && s % 2 == 1)
    };
    let mut first: Vec<PointRows> = rows.into_iter().filter(in_first).collect();
    assert_eq!(first.len(), 12);
    let mut bodies = start.clone();
    let certificate = exact::solve(&mut first, &mut bodies, &inertia, model, &mut scratch);
    assert!(certificate.converged, "{certificate:?}");
    for slot in 0..bodies.len() {
        if slot % 2 == 1 {
            let apart = bodies[slot].linear.distance(all.1[slot].linear);
            assert!(apart < 1e-6, "body {slot}: {apart} m/s apart");
        } else {
            assert_eq!(bodies[slot], start[slot], "body {slot} was touched");
        }
    }
}

const LEVELS: [f64; 3] = [1e-1, 1e-2, 1e-3];

/// Shares solved at 8, 16, 32, 64 and 128 sweeps to each of [`LEVELS`] that were measured before on 58 problems, 39 of
/// one's own and 19 public ones. This set lacks 19 of the former, mostly the larger twins of those it has.
const PUBLISHED: [[f64; 5]; 3] = [
    [55.0, 60.0, 67.0, 71.0, 79.0],
    [31.0, 45.0, 53.0, 64.0, 66.0],
    [17.0, 31.0, 43.0, 48.0, 53.0],
];

fn profile(method: Method, files: &[File], matrices: &[Vec<f64>], warm: bool) -> Profile {
    let profile = Profile::measure(method, files, matrices, warm, &[8, 16, 32, 64, 128]);
    let start = if warm { "warm" } else { "cold" };
    for level in LEVELS {
        let shares = profile.shares(level);
        let shares: Vec<_> = shares.iter().map(|s| format!("{s:3.0}")).collect();
        println!("{method:?} {start} {level:.0e}: {} %", shares.join(" "));
    }
    profile
}

/// On a file the default method is what it does with the rows of one sub-step: sweeps with momentum, in the source of the
/// run time, with as many sweeps as each column says in place of its tolerance. The problem of a file has no time to divide,
/// so its sub-steps have no place here; what they do to one is shown beside it.
#[test]
fn sweeps_solve_the_published_shares_and_those_of_the_default_solve_more() {
    let files = frozen_files();
    let matrices: Vec<_> = files.iter().map(|f| f.problem.matrix()).collect();
    println!("default method on a file = {:?}", Method::Momentum);
    let cold = |method| profile(method, &files, &matrices, false);
    let (pgs, default) = (cold(Method::Pgs), cold(Method::Momentum));
    cold(Method::Substeps);
    for (level, published) in LEVELS.iter().zip(PUBLISHED) {
        for (share, published) in pgs.shares(*level).iter().zip(published) {
            let more = share - published;
            assert!(
                (0.0..=12.0).contains(&more),
                "{level:e}: {share} % for {published} %"
            );
        }
        let (more, base) = (default.solved(*level), pgs.solved(*level));
        for (k, sweeps) in pgs.sweeps.iter().enumerate() {
            let (more, base) = (more[k], base[k]);
            assert!(
                more > base,
                "{sweeps} sweeps, {level:e}: {more} files solved, {base} by plain sweeps"
            );
        }
    }
}

#[test]
fn a_start_from_the_step_before_solves_more_at_few_sweeps() {
    let mut files = frozen_files();
    files.retain(|f| f.reference.as_ref().is_some_and(|r| r.warm.is_some()));
    let matrices: Vec<_> = files.iter().map(|f| f.problem.matrix()).collect();
    for method in [Method::Pgs, Method::Momentum, Method::Substeps] {
        let [cold, warm] = [false, true].map(|warm| profile(method, &files, &matrices, warm));
        let (cold, warm) = (cold.solved(1e-1)[0], warm.solved(1e-1)[0]);
        assert!(
            warm > cold,
            "{method:?}: {warm} warm, {cold} cold, of {}",
            files.len()
        );
    }
}
