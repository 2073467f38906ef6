//! Velocity space of bodies: six unknowns each, scaled so that the mass matrix becomes the identity.
//!
//! With `S S^T = M^-1` block by block, velocities are `v = v* + S y`, the scaled Jacobian is `K = J S`, and
//! `A = K K^T`. Neither the mass matrix nor its inverse is needed, so bodies that only turn, or only move, are no special
//! case.

use crate::solver::exact::cholesky::{BlockCholesky, WIDTH};
use crate::solver::exact::rows::Weight;
use crate::solver::exact::velocity::VelocitySpace;

/// `S` of one body: the root of the inverse mass, and the lower triangle of that of the inverse inertia.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MassRoot {
    linear: f64,
    /// `[xx, yx, yy, zx, zy, zz]`.
    angular: [f64; 6],
}

impl MassRoot {
    /// `inverse_inertia` need not be of full rank: what is smaller than rounding in its largest entry counts as zero.
    pub(crate) fn new(inverse_mass: f64, inverse_inertia: &[[f64; 3]; 3]) -> Self {
        let i = inverse_inertia;
        let least = 1e-12 * i[0][0].max(i[1][1]).max(i[2][2]);
        let root = |pivot: f64| if pivot > least { pivot.sqrt() } else { 0.0 };
        let over = |x: f64, pivot: f64| if pivot > 0.0 { x / pivot } else { 0.0 };
        let xx = root(i[0][0]);
        let (yx, zx) = (over(i[1][0], xx), over(i[2][0], xx));
        let yy = root(i[1][1] - yx * yx);
        let zy = over(i[2][1] - zx * yx, yy);
        let zz = root(i[2][2] - zx * zx - zy * zy);
        Self {
            linear: inverse_mass.sqrt(),
            angular: [xx, yx, yy, zx, zy, zz],
        }
    }

    /// `S^T j`: one side of a row of `J` becomes that of `K`.
    pub(crate) fn scale(&self, j: &[f64; WIDTH]) -> [f64; WIDTH] {
        let [xx, yx, yy, zx, zy, zz] = self.angular;
        [
            self.linear * j[0],
            self.linear * j[1],
            self.linear * j[2],
            xx * j[3] + yx * j[4] + zx * j[5],
            yy * j[4] + zy * j[5],
            zz * j[5],
        ]
    }

    /// `S y`: change of linear and angular velocity.
    pub(crate) fn unscale(&self, y: &[f64]) -> [f64; WIDTH] {
        let [xx, yx, yy, zx, zy, zz] = self.angular;
        [
            self.linear * y[0],
            self.linear * y[1],
            self.linear * y[2],
            xx * y[3],
            yx * y[3] + yy * y[4],
            zx * y[3] + zy * y[4] + zz * y[5],
        ]
    }
}

/// Stands for a body that contacts do not move.
pub(crate) const FIXED: u32 = u32::MAX;

/// One contact: block rows of its bodies and its rows of `K`.
#[derive(Clone, Copy, Debug)]
struct ScaledContact {
    /// Block rows, or [`FIXED`].
    places: [u32; 2],
    /// The block that joins the two, if both move.
    block: u32,
    jacobian: [[[f64; WIDTH]; 2]; 3],
}

/// The contacts and the factor of `I + K^T D K`.
#[derive(Debug, Default)]
pub(crate) struct BodySpace {
    contacts: Vec<ScaledContact>,
    factor: BlockCholesky,
}

impl BodySpace {
    /// Takes over the pattern: `pairs` holds two of the `bodies` indices for each contact, or [`FIXED`].
    pub(crate) fn begin(&mut self, bodies: usize, pairs: impl Iterator<Item = [u32; 2]> + Clone) {
        self.contacts.clear();
        self.factor
            .analyse(bodies, pairs.filter(|pair| !pair.contains(&FIXED)));
    }

    /// Adds the next contact of the `pairs` given before, with its rows of `K`; sides of fixed bodies must be zero.
    /// Returns `A_ii` of the three rows.
    pub(crate) fn push(&mut self, pair: [u32; 2], jacobian: [[[f64; WIDTH]; 2]; 3]) -> [f64; 3] {
        let places = pair.map(|body| match body {
            FIXED => FIXED,
            body => self.factor.place(body),
        });
        let block = if places.contains(&FIXED) {
            FIXED
        } else {
            let [p, q] = places;
            self.factor.block_index(p.min(q), p.max(q))
        };
        self.contacts.push(ScaledContact {
            places,
            block,
            jacobian,
        });
        jacobian.map(|sides| sides.iter().flatten().map(|k| k * k).sum())
    }

    /// Where the unknowns of a body begin.
    pub(crate) fn offset(&self, body: u32) -> usize {
        self.factor.place(body) as usize * WIDTH
    }
}

impl ScaledContact {
    /// `D K` of the contact: each row is a weighted sum of its rows of `K`.
    fn weighted(&self, weight: &Weight) -> [[[f64; WIDTH]; 2]; 3] {
        let [n, t, s] = &self.jacobian;
        let [tt, ts, ss] = weight.tangents;
        let each = |f: &dyn Fn(usize, usize) -> f64| {
            std::array::from_fn(|side| std::array::from_fn(|k| f(side, k)))
        };
        [
            each(&|side, k| weight.normal * n[side][k]),
            each(&|side, k| tt * t[side][k] + ts * s[side][k]),
            each(&|side, k| ts * t[side][k] + ss * s[side][k]),
        ]
    }

    fn add_to(&self, factor: &mut BlockCholesky, weight: &Weight) {
        let weighted = self.weighted(weight);
        for (k, (row, weighted)) in self.jacobian.iter().zip(&weighted).enumerate() {
            if weight.is_zero(k) {
                continue;
            }
            for side in 0..2 {
                if self.places[side] != FIXED {
                    factor.add_diagonal(self.places[side], &row[side], &weighted[side]);
                }
            }
            if self.block != FIXED {
                let high = usize::from(self.places[1] > self.places[0]);
                factor.add_block(self.block, &row[high], &weighted[1 - high]);
            }
        }
    }
}

impl VelocitySpace for BodySpace {
    fn dimension(&self) -> usize {
        self.factor.len() * WIDTH
    }

    fn velocities(&self, y: &[f64], out: &mut [f64]) {
        for (contact, out) in self.contacts.iter().zip(out.chunks_exact_mut(3)) {
            out.fill(0.0);
            for (side, &place) in contact.places.iter().enumerate() {
                if place == FIXED {
                    continue;
                }
                let y = &y[place as usize * WIDTH..][..WIDTH];
                for (value, row) in out.iter_mut().zip(&contact.jacobian) {
                    *value += row[side].iter().zip(y).map(|(k, y)| k * y).sum::<f64>();
                }
            }
        }
    }

    fn impulses(&self, lambda: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for (contact, lambda) in self.contacts.iter().zip(lambda.chunks_exact(3)) {
            for (side, &place) in contact.places.iter().enumerate() {
                if place == FIXED {
                    continue;
                }
                let out = &mut out[place as usize * WIDTH..][..WIDTH];
                for (row, multiplier) in contact.jacobian.iter().zip(lambda) {
                    (0..WIDTH).for_each(|k| out[k] += row[side][k] * multiplier);
                }
            }
        }
    }

    fn factor(&mut self, weights: &[Weight]) {
        self.factor.reset();
        for (contact, weight) in self.contacts.iter().zip(weights) {
            contact.add_to(&mut self.factor, weight);
        }
        self.factor.factor();
    }

    fn solve(&self, x: &mut [f64]) {
        self.factor.solve(x);
    }
}
