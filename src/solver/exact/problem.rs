//! The contact problem in double precision, as files and tests state it.
//!
//! `w = A lambda - b`, see [`mlcp`](crate::solver::rows::mlcp), with three rows (normal, two tangents) or two (plane problems)
//! for each contact, one contact after the other. A problem comes with its bodies, so that `A = J M^-1 J^T` never needs
//! to be formed, or as a matrix.

use crate::solver::config::FrictionModel;

/// Which bounds the multipliers are kept in.
#[derive(Clone, Debug, PartialEq)]
pub enum Bounds {
    /// `lo <= lambda <= hi` for each row, whatever the normal multipliers are: a convex problem, whose `w` is unique.
    Frozen {
        /// Lower bounds, N s.
        lo: Vec<f64>,
        /// Upper bounds, N s.
        hi: Vec<f64>,
    },
    /// Friction bounded by the coefficient of friction times the normal multiplier of the same contact; normal
    /// multipliers not negative. May have several solutions.
    Coupled(FrictionModel),
}

/// A rigid body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Body {
    /// 1 / mass, 1/kg.
    pub inverse_mass: f64,
    /// Inverse inertia about the center of mass in the axes of the rows, 1/(kg m2).
    pub inverse_inertia: [[f64; 3]; 3],
    /// Linear (m/s) and angular (rad/s) velocity without contacts: `v*`.
    pub velocity: [f64; 6],
}

/// A contact of one or two bodies: three rows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// Indices of the two bodies; `None` for one that does not move.
    pub bodies: [Option<u32>; 2],
    /// For each row the six entries of `J` of the first body and those of the second.
    pub jacobian: [[[f64; 6]; 2]; 3],
    /// Wanted velocity `u` of each row, m/s.
    pub target_velocity: [f64; 3],
    /// Coefficient of friction.
    pub friction: f64,
}

/// A problem with its bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactProblem {
    /// The bodies.
    pub bodies: Vec<Body>,
    /// The contacts.
    pub contacts: Vec<Contact>,
    /// The bounds.
    pub bounds: Bounds,
}

/// A problem as a matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct DenseProblem {
    /// Rows per contact: 3, or 2 for plane problems.
    pub rows_per_contact: usize,
    /// `A`, row by row, symmetric and positive semidefinite.
    pub a: Vec<f64>,
    /// `b`, m/s.
    pub b: Vec<f64>,
    /// Coefficient of friction of each contact.
    pub friction: Vec<f64>,
    /// The bounds.
    pub bounds: Bounds,
}

impl ContactProblem {
    /// `J v - u` of all rows for the velocities `v` of the bodies.
    fn constraint_velocities(&self, v: &[[f64; 6]]) -> Vec<f64> {
        let rows = self.contacts.iter().flat_map(|contact| {
            (0..3).map(move |k| {
                let sides = contact.bodies.iter().zip(&contact.jacobian[k]);
                let velocity: f64 = sides
                    .filter_map(|(body, j)| body.map(|i| dot(j, &v[i as usize])))
                    .sum();
                velocity - contact.target_velocity[k]
            })
        });
        rows.collect()
    }

    /// `-b = J v* - u`: what `w` is without impulses, m/s.
    pub fn free_velocities(&self) -> Vec<f64> {
        let v: Vec<[f64; 6]> = self.bodies.iter().map(|b| b.velocity).collect();
        self.constraint_velocities(&v)
    }

    /// Sum of the absolute terms that the free velocity of row `k` of contact `c` is added up from, m/s.
    pub(crate) fn magnitude(&self, c: usize, k: usize) -> f64 {
        let contact = &self.contacts[c];
        let sides = contact.bodies.iter().zip(&contact.jacobian[k]);
        let terms =
            sides.filter_map(|(body, j)| body.map(|i| (&self.bodies[i as usize].velocity, j)));
        let sum: f64 = terms
            .flat_map(|(v, j)| v.iter().zip(j).map(|(v, j)| (v * j).abs()))
            .sum();
        sum + contact.target_velocity[k].abs()
    }

    /// `w = J (v* + M^-1 J^T lambda) - u`, m/s.
    pub fn w(&self, lambda: &[f64]) -> Vec<f64> {
        let mut impulse = vec![[0.0; 6]; self.bodies.len()];
        for (contact, multipliers) in self.contacts.iter().zip(lambda.chunks_exact(3)) {
            for (row, multiplier) in contact.jacobian.iter().zip(multipliers) {
                for (body, j) in contact.bodies.iter().zip(row) {
                    if let Some(i) = body {
                        (0..6).for_each(|k| impulse[*i as usize][k] += j[k] * multiplier);
                    }
                }
            }
        }
        let velocities: Vec<[f64; 6]> = self
            .bodies
            .iter()
            .zip(&impulse)
            .map(|(body, p)| {
                let change = body.inverse_mass_times(p);
                std::array::from_fn(|k| body.velocity[k] + change[k])
            })
            .collect();
        self.constraint_velocities(&velocities)
    }

    /// The same problem as a matrix.
    pub fn to_dense(&self) -> DenseProblem {
        let n = 3 * self.contacts.len();
        let free = self.free_velocities();
        let mut a = vec![0.0; n * n];
        let mut unit = vec![0.0; n];
        for j in 0..n {
            unit[j] = 1.0;
            for (i, w) in self.w(&unit).iter().enumerate() {
                a[i * n + j] = w - free[i];
            }
            unit[j] = 0.0;
        }
        DenseProblem {
            rows_per_contact: 3,
            a,
            b: free.iter().map(|w| -w).collect(),
            friction: self.contacts.iter().map(|c| c.friction).collect(),
            bounds: self.bounds.clone(),
        }
    }
}

impl Body {
    fn inverse_mass_times(&self, p: &[f64; 6]) -> [f64; 6] {
        let i = &self.inverse_inertia;
        let turn = |r: usize| i[r][0] * p[3] + i[r][1] * p[4] + i[r][2] * p[5];
        let m = self.inverse_mass;
        [m * p[0], m * p[1], m * p[2], turn(0), turn(1), turn(2)]
    }
}

impl DenseProblem {
    /// `w = A lambda - b`, m/s.
    pub fn w(&self, lambda: &[f64]) -> Vec<f64> {
        let rows = self.a.chunks_exact(self.b.len()).zip(&self.b);
        rows.map(|(row, b)| row.iter().zip(lambda).map(|(a, l)| a * l).sum::<f64>() - b)
            .collect()
    }
}

fn dot(x: &[f64; 6], y: &[f64; 6]) -> f64 {
    x.iter().zip(y).map(|(a, b)| a * b).sum()
}
