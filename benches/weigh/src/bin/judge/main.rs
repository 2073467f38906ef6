//! A judge of the judge: `clarabel`, an interior point solver that others wrote, against the library's exact solver on the
//! contact problems under `tests/data/mlcp`.
//!
//! `cargo run --release --bin judge` prints a table. With friction bounded by numbers, be it a box (`lo`, `hi` of the file) or a
//! disc in the plane of the two tangents, the problem is a convex one, minimise `l A l / 2 - b l`, whose velocities `A l - b` are unique.
//!
//! - Box: both solve it, and the velocities of both are compared with those in the file.
//! - Disc: the exact solver solves the problem in which the radius is `mu` times the normal multiplier; `clarabel` gets the
//!   radii that come out, as second-order cones, and must find the same velocities. That is what the solution of the
//!   problem with friction is: if the radii were wrong, the normal multipliers would not fit them.
//!
//! Errors are the largest difference of a velocity, relative to the fastest one with or without contacts.

mod file;

use bevy_cleave::prelude::FrictionModel;
use bevy_cleave::testing::exact::{Bounds, DenseProblem, ExactScratch, solve_dense};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SecondOrderConeT, SolverStatus,
    SupportedConeT,
};
use file::File;
use weigh::cpu_us;

fn main() {
    println!(
        "| file | rows | box: ours, us | error | clarabel, us | iterations | error | disc: ours certified | clarabel | they differ by |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for file in file::load_all() {
        let Some(reference) = &file.reference else {
            continue;
        };
        let bounds = Bounds::Frozen {
            lo: reference.lo.clone(),
            hi: reference.hi.clone(),
        };
        let (us, ours, _) = exact(&file, bounds);
        let theirs = clarabel(&file, &box_cones(&reference.lo, &reference.hi));
        let of_file = |w: &[f64]| file.difference(w, &reference.w);
        let (ours, their) = (of_file(&file.w(&ours)), of_file(&file.w(&theirs.lambda)));
        let disc = if file.per_contact == 3 {
            disc(&file)
        } else {
            "| | |".into()
        };
        println!(
            "| {} | {} | {us:.0} | {ours:.1e} | {:.0} | {} | {their:.1e} {} {disc}",
            file.name,
            file.b.len(),
            theirs.us,
            theirs.iterations,
            theirs.note(),
        );
    }
}

/// The columns on the disc.
fn disc(file: &File) -> String {
    let (_, lambda, converged) = exact(file, Bounds::Coupled(FrictionModel::Disc));
    let radii: Vec<f64> = file
        .friction
        .iter()
        .zip(lambda.chunks_exact(3))
        .map(|(mu, l)| mu * l[0].max(0.0))
        .collect();
    let theirs = clarabel(file, &disc_cones(&radii));
    let apart = file.difference(&file.w(&theirs.lambda), &file.w(&lambda));
    format!(
        "| {converged} | {:?}, {} iterations | {apart:.1e} |",
        theirs.status, theirs.iterations
    )
}

/// Time, multipliers and whether they are certified.
fn exact(file: &File, bounds: Bounds) -> (f64, Vec<f64>, bool) {
    let problem = DenseProblem {
        rows_per_contact: file.per_contact,
        a: file.a.clone(),
        b: file.b.clone(),
        friction: file.friction.clone(),
        bounds,
    };
    let mut lambda = vec![0.0; file.b.len()];
    let start = cpu_us();
    let certificate = solve_dense(&problem, &mut lambda, &mut ExactScratch::default());
    (cpu_us() - start, lambda, certificate.converged)
}

/// Rows of a cone: each is `offset + factor * lambda[row]`, without a row the offset alone.
struct Cone {
    rows: Vec<(f64, Option<(usize, f64)>)>,
    kind: SupportedConeT<f64>,
}

/// `lambda - lo >= 0` and `hi - lambda >= 0` where there are such bounds.
fn box_cones(lo: &[f64], hi: &[f64]) -> Vec<Cone> {
    let bounds = lo.iter().zip(hi).enumerate();
    let rows: Vec<_> = bounds
        .flat_map(|(i, (lo, hi))| [(-lo, Some((i, 1.0))), (*hi, Some((i, -1.0)))])
        .filter(|(offset, _)| offset.is_finite())
        .collect();
    let kind = NonnegativeConeT(rows.len());
    vec![Cone { rows, kind }]
}

/// `lambda_n >= 0` and `|(lambda_t1, lambda_t2)| <= radius`.
fn disc_cones(radii: &[f64]) -> Vec<Cone> {
    let normals: Vec<_> = (0..radii.len())
        .map(|c| (0.0, Some((3 * c, 1.0))))
        .collect();
    let kind = NonnegativeConeT(normals.len());
    let mut cones = vec![Cone {
        rows: normals,
        kind,
    }];
    cones.extend(radii.iter().enumerate().map(|(c, &radius)| Cone {
        rows: vec![
            (radius, None),
            (0.0, Some((3 * c + 1, 1.0))),
            (0.0, Some((3 * c + 2, 1.0))),
        ],
        kind: SecondOrderConeT(3),
    }));
    cones
}

struct Theirs {
    us: f64,
    lambda: Vec<f64>,
    iterations: u32,
    status: SolverStatus,
}

impl Theirs {
    /// What is to be said of an outcome that is not a solution.
    fn note(&self) -> String {
        match self.status {
            SolverStatus::Solved => String::new(),
            other => format!("({other:?})"),
        }
    }
}

fn clarabel(file: &File, cones: &[Cone]) -> Theirs {
    let n = file.b.len();
    let (mut at, mut number) = ((Vec::new(), Vec::new()), Vec::new());
    for column in 0..n {
        for row in 0..=column {
            let value = file.a[row * n + column];
            if value != 0.0 {
                at.0.push(row);
                at.1.push(column);
                number.push(value);
            }
        }
    }
    let p = CscMatrix::new_from_triplets(n, n, at.0, at.1, number);
    let q: Vec<f64> = file.b.iter().map(|b| -b).collect();
    let rows: Vec<_> = cones.iter().flat_map(|cone| &cone.rows).collect();
    let entries: Vec<_> = rows
        .iter()
        .enumerate()
        .filter_map(|(row, (_, entry))| Some((row, (*entry)?)))
        .collect();
    let g = CscMatrix::new_from_triplets(
        rows.len(),
        n,
        entries.iter().map(|(row, _)| *row).collect(),
        entries.iter().map(|(_, (column, _))| *column).collect(),
        entries.iter().map(|(_, (_, factor))| -factor).collect(),
    );
    let offsets: Vec<f64> = rows.iter().map(|(offset, _)| *offset).collect();
    let kinds: Vec<_> = cones.iter().map(|cone| cone.kind.clone()).collect();
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-13,
        tol_gap_rel: 1e-13,
        tol_feas: 1e-13,
        ..DefaultSettings::default()
    };
    let start = cpu_us();
    let mut solver =
        DefaultSolver::new(&p, &q, &g, &offsets, &kinds, settings).expect("a well-formed problem");
    solver.solve();
    Theirs {
        us: cpu_us() - start,
        lambda: solver.solution.x.clone(),
        iterations: solver.solution.iterations,
        status: solver.solution.status,
    }
}
