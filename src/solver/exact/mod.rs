//! The contact problem solved to rounding in double precision: the judge of the other methods, and at run time the
//! choice for islands that must be right.
//!
//! Which problem: the one that [`mlcp`](crate::solver::rows::mlcp) states, with friction either between frozen bounds (a convex
//! problem, whose velocities are unique) or bounded by the disc or the box of the current normal impulses. The coupled
//! problem may have several solutions, and need not have one; it is solved as a sequence of problems with bounds from
//! the normal impulses of the solution before, until they agree.
//!
//! How: an interior point method (`interior`) comes near to the solution in about ten factorisations, whatever the mass
//! ratios and however many contacts are redundant. A multiplier iteration with Newton's method (`newton`) finds the last
//! digits in one or two more, and does all of the work where the start is good already. Both need only systems with
//! `I + K^T D K` on the velocities, a block-sparse matrix (`cholesky`) with one block row per body. The
//! `driver` puts them in order and certifies the answer by the residual.
//!
//! A problem without solution (a body pushed out of two walls at once) gets the impulses of very stiff springs, which
//! are finite and do not depend on the start.
//!
//! Must not know time, batches or lanes. Read `problem.rs` first, then `driver.rs`.

mod blocks;
mod cholesky;
mod dense;
mod driver;
mod interior;
mod newton;
pub(crate) mod problem;
mod rows;
mod velocity;

use crate::bodies::solver_body::SolverBody;
use crate::solver::config::FrictionModel;
use crate::solver::rows::contact_rows::{PointRows, Row};
use blocks::{BodySpace, FIXED, MassRoot};
use dense::DenseSpace;
use driver::Driver;
use glam::{Mat3, Vec3};
use problem::{Bounds, ContactProblem, DenseProblem};
use rows::{ExactRows, Law};
use velocity::{VelocitySpace, zeros};

/// Residual up to which a solution is certified.
pub const CERTIFIED: f64 = 1e-10;

/// What the solver says of its own answer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Certificate {
    /// Euclidean norm of the natural map in the mass norm, relative to the mass norm of what the impulses do. Where that
    /// is next to nothing, relative to what rounding of the velocities amounts to, times 1e10.
    pub residual: f64,
    /// Matrices that were factored: what the time goes into.
    pub iterations: u32,
    /// Whether the residual is at most [`CERTIFIED`].
    pub converged: bool,
}

/// Buffers of the solver, reused from call to call.
#[derive(Debug, Default)]
pub struct ExactScratch {
    space: BodySpace,
    rows: ExactRows,
    driver: Driver,
    lambda: Vec<f64>,
    velocities: Vec<f64>,
    /// Of each body that contacts move: its slot, and the root of its inverse mass.
    slots: Vec<u32>,
    roots: Vec<MassRoot>,
    /// Index into `slots` by slot; `FIXED` outside a solve.
    local: Vec<u32>,
}

/// Solves the rows of any part of the bodies (an island, or all): impulses in `rows`, velocities in `bodies`.
///
/// The impulses found in `rows` are the start; `bodies` (by slot, as is `inverse_inertia`, world axes, 1/(kg m2)) have the
/// velocities without any of these impulses before, and with the impulses found after. Bodies with `inverse_mass` 0
/// keep their velocity. Impulses and velocities are rounded to single precision in the end only; the certificate is for
/// the solution before that.
pub fn solve(
    rows: &mut [PointRows],
    bodies: &mut [SolverBody],
    inverse_inertia: &[Mat3],
    friction: FrictionModel,
    scratch: &mut ExactScratch,
) -> Certificate {
    scratch.take_bodies(rows, bodies, inverse_inertia);
    scratch.take_rows(rows, bodies, friction);
    let ExactScratch {
        space,
        rows: bounds,
        driver,
        lambda,
        ..
    } = scratch;
    let certificate = driver.solve(space, bounds, lambda);
    for (point, lambda) in rows.iter_mut().zip(scratch.lambda.chunks_exact(3)) {
        let [t1, t2] = &mut point.tangents;
        for (row, lambda) in [&mut point.normal, t1, t2].into_iter().zip(lambda) {
            row.impulse = *lambda as f32;
        }
    }
    scratch.give_velocities(bodies);
    certificate
}

/// Solves a problem with bodies; `lambda` (N s, three rows per contact) is the start and the answer.
pub fn solve_bodies(
    problem: &ContactProblem,
    lambda: &mut [f64],
    scratch: &mut ExactScratch,
) -> Certificate {
    let bodies = &problem.bodies;
    let roots = bodies
        .iter()
        .map(|b| MassRoot::new(b.inverse_mass, &b.inverse_inertia));
    scratch.roots.clear();
    scratch.roots.extend(roots);
    let contacts = &problem.contacts;
    let pairs = contacts
        .iter()
        .map(|c| c.bodies.map(|b| b.unwrap_or(FIXED)));
    scratch.space.begin(bodies.len(), pairs.clone());
    begin(&mut scratch.rows, 3, &problem.bounds);
    let free = problem.free_velocities();
    for (c, (contact, pair)) in contacts.iter().zip(pairs).enumerate() {
        let scaled = contact
            .jacobian
            .map(|sides| scale_row(&scratch.roots, pair, &sides));
        let diagonal = scratch.space.push(pair, scaled);
        for (k, diagonal) in diagonal.into_iter().enumerate() {
            let magnitude = problem.magnitude(c, k);
            scratch.rows.push(free[3 * c + k], magnitude, diagonal);
        }
        scratch.rows.friction.push(contact.friction);
    }
    scratch.rows.finish();
    scratch
        .driver
        .solve(&mut scratch.space, &mut scratch.rows, lambda)
}

/// Solves a problem given as a matrix; `lambda` (N s) is the start and the answer.
pub fn solve_dense(
    problem: &DenseProblem,
    lambda: &mut [f64],
    scratch: &mut ExactScratch,
) -> Certificate {
    let n = problem.b.len();
    let mut space = DenseSpace::new(&problem.a, n, problem.rows_per_contact);
    let rows = &mut scratch.rows;
    begin(rows, problem.rows_per_contact, &problem.bounds);
    for (i, b) in problem.b.iter().enumerate() {
        rows.push(-b, b.abs(), problem.a[i * n + i]);
    }
    rows.friction.extend_from_slice(&problem.friction);
    rows.finish();
    scratch.driver.solve(&mut space, rows, lambda)
}

fn begin(rows: &mut ExactRows, per_contact: usize, bounds: &Bounds) {
    match bounds {
        Bounds::Frozen { lo, hi } => {
            rows.begin(per_contact, Law::Frozen);
            rows.lo.extend_from_slice(lo);
            rows.hi.extend_from_slice(hi);
        }
        Bounds::Coupled(model) => rows.begin(per_contact, law_of(*model, per_contact)),
    }
}

fn law_of(model: FrictionModel, per_contact: usize) -> Law {
    match model {
        // In the plane a disc is an interval.
        FrictionModel::Disc if per_contact == 3 => Law::Disc,
        FrictionModel::Disc | FrictionModel::Box => Law::Box,
    }
}

/// One row of `K = J S`.
fn scale_row(roots: &[MassRoot], pair: [u32; 2], sides: &[[f64; 6]; 2]) -> [[f64; 6]; 2] {
    [0, 1].map(|side| match pair[side] {
        FIXED => [0.0; 6],
        body => roots[body as usize].scale(&sides[side]),
    })
}

impl ExactScratch {
    /// Numbers the bodies of the rows that contacts move, and analyses which touch which.
    fn take_bodies(&mut self, rows: &[PointRows], bodies: &[SolverBody], inverse_inertia: &[Mat3]) {
        self.slots.clear();
        self.roots.clear();
        self.local.resize(bodies.len().max(self.local.len()), FIXED);
        for slot in rows.iter().flat_map(|point| point.bodies) {
            let i = slot as usize;
            if bodies[i].inverse_mass > 0.0 && self.local[i] == FIXED {
                self.local[i] = self.slots.len() as u32;
                self.slots.push(slot);
                let inertia = inverse_inertia[i].transpose().to_cols_array_2d();
                let inertia = inertia.map(|row| row.map(f64::from));
                let mass = f64::from(bodies[i].inverse_mass);
                self.roots.push(MassRoot::new(mass, &inertia));
            }
        }
        let local = &self.local;
        let pairs = rows
            .iter()
            .map(|point| point.bodies.map(|slot| local[slot as usize]));
        self.space.begin(self.slots.len(), pairs);
    }

    fn take_rows(&mut self, points: &[PointRows], bodies: &[SolverBody], model: FrictionModel) {
        self.rows.begin(3, law_of(model, 3));
        self.lambda.clear();
        for point in points {
            let pair = point.bodies.map(|slot| self.local[slot as usize]);
            let rows = [&point.normal, &point.tangents[0], &point.tangents[1]];
            let jacobian = rows.map(jacobian);
            let scaled = jacobian.map(|sides| scale_row(&self.roots, pair, &sides));
            let diagonal = self.space.push(pair, scaled);
            let velocities = point.bodies.map(|slot| velocity(&bodies[slot as usize]));
            for ((row, sides), diagonal) in rows.iter().zip(&jacobian).zip(diagonal) {
                let terms = sides.iter().zip(&velocities);
                let terms = terms.flat_map(|(j, v)| j.iter().zip(v).map(|(j, v)| j * v));
                let target_velocity = f64::from(row.target_velocity);
                let free = terms.clone().sum::<f64>() - target_velocity;
                let magnitude = terms.map(f64::abs).sum::<f64>() + target_velocity.abs();
                self.rows.push(free, magnitude, diagonal);
                self.lambda.push(f64::from(row.impulse));
            }
            self.rows.friction.push(f64::from(point.friction));
            self.rows.cohesion.push(f64::from(point.shear));
        }
        self.rows.finish();
        for (lo, point) in self.rows.lo.iter_mut().step_by(3).zip(points) {
            *lo = f64::from(point.min_normal());
        }
    }

    /// Adds `M^-1 J^T lambda` to the velocities, and forgets the numbering.
    fn give_velocities(&mut self, bodies: &mut [SolverBody]) {
        zeros(&mut self.velocities, self.space.dimension());
        self.space.impulses(&self.lambda, &mut self.velocities);
        for (local, &slot) in self.slots.iter().enumerate() {
            let body = &mut bodies[slot as usize];
            let y = &self.velocities[self.space.offset(local as u32)..][..6];
            let change = self.roots[local].unscale(y);
            body.linear = sum(body.linear, &change[..3]);
            body.angular = sum(body.angular, &change[3..]);
            self.local[slot as usize] = FIXED;
        }
    }
}

/// `v + change`, rounded once.
fn sum(v: Vec3, change: &[f64]) -> Vec3 {
    let [x, y, z] = v.to_array().map(f64::from);
    Vec3::new(
        (x + change[0]) as f32,
        (y + change[1]) as f32,
        (z + change[2]) as f32,
    )
}

fn velocity(body: &SolverBody) -> [f64; 6] {
    let (v, w) = (body.linear, body.angular);
    [v.x, v.y, v.z, w.x, w.y, w.z].map(f64::from)
}

/// The row of `J`: for A and for B.
fn jacobian(row: &Row) -> [[f64; 6]; 2] {
    let (d, a, b) = (row.direction, row.angular_a, row.angular_b);
    [
        [-d.x, -d.y, -d.z, -a.x, -a.y, -a.z].map(f64::from),
        [d.x, d.y, d.z, b.x, b.y, b.z].map(f64::from),
    ]
}
