//! `A = M + J^T K J`, symmetric and positive definite, factored body by body: by the rows that hold a body where it hangs on one other, else
//! as `L L^T` by blocks.

use crate::solver::joint::links::{AddRows, Links};
use crate::solver::joint::sparsity::{EdgeBlock, Elimination, Sparsity};
use crate::solver::joint::vector6::{Block6, Vector6, add_outer, add_scaled, dot};

const ZERO: Block6 = [[0.0; 6]; 6];

/// The matrix, and then its factor in its place.
#[derive(Debug, Default)]
pub(crate) struct Factor {
    /// By place in the order: on the diagonal. Then of a body that is eliminated by rows the inverse of what hangs on it, of others the lower
    /// triangle of the factor, with the inverses of its diagonal.
    diagonal: Vec<Block6>,
    /// By number of a block.
    beside: Vec<Block6>,
    /// What is eliminated by rows.
    links: Links,
}

impl Factor {
    /// Makes room for the factor of such a matrix.
    pub(crate) fn lay_out(&mut self, sparsity: &Sparsity, rows: &impl AddRows) {
        self.diagonal.resize(sparsity.order.len(), ZERO);
        self.beside.resize(sparsity.columns.len(), ZERO);
        self.links.clear();
        for at in 0..sparsity.order.len() {
            self.links.reserve(rows.most_rows(at));
        }
    }

    /// Begins with zero for the body at a place, but for its inertia.
    #[inline(always)]
    pub(crate) fn begin(&mut self, at: usize, sparsity: &Sparsity, inertia: Block6) {
        self.diagonal[at] = inertia;
        for column in sparsity.columns_of(at) {
            self.beside[column.block as usize] = ZERO;
        }
    }

    /// Adds `stiffness j j^T` of a row of the body at a place.
    pub(crate) fn add(&mut self, at: usize, stiffness: f64, row: &Vector6) {
        add_outer(&mut self.diagonal[at], stiffness, row, row);
    }

    /// Adds what a row couples.
    pub(crate) fn couple(&mut self, edge: EdgeBlock, stiffness: f64, rows: [&Vector6; 2]) {
        let [first, second] = if edge.is_flipped {
            [rows[1], rows[0]]
        } else {
            rows
        };
        add_outer(
            &mut self.beside[edge.block as usize],
            stiffness,
            first,
            second,
        );
    }

    /// Makes the factor; `rows`: those by which bodies are eliminated, `is_asked`: of which components.
    #[inline(always)]
    pub(crate) fn factorise(
        &mut self,
        sparsity: &Sparsity,
        rows: &impl AddRows,
        is_asked: impl Fn(usize) -> bool,
    ) {
        let mut updates = sparsity.updates.iter();
        for at in 0..self.diagonal.len() {
            if !is_asked(at) {
                let columns = sparsity.columns_of(at).len();
                if columns > 1 {
                    updates.nth(columns * (columns - 1) / 2 - 1);
                }
                continue;
            }
            if let Elimination::Rows(parent) = sparsity.eliminations[at] {
                self.links.begin(at);
                rows.add_rows(at, &mut self.links);
                let (done, later) = self.diagonal.split_at_mut(at + 1);
                let parent = parent.map(|place| (place, &mut later[place as usize - at - 1]));
                self.links.eliminate(at, &mut done[at], parent);
                continue;
            }
            cholesky(&mut self.diagonal[at]);
            let triangle = self.diagonal[at];
            let columns = sparsity.columns_of(at);
            for column in columns {
                let divided = &mut self.beside[column.block as usize];
                divide(&triangle, divided);
                let divided = *divided;
                take_product(&mut self.diagonal[column.to as usize], &divided, &divided);
            }
            for (k, first) in columns.iter().enumerate() {
                for second in &columns[k + 1..] {
                    let Some(&target) = updates.next() else {
                        return;
                    };
                    let (a, b) = (
                        self.beside[first.block as usize],
                        self.beside[second.block as usize],
                    );
                    take_product(&mut self.beside[target as usize], &a, &b);
                }
            }
        }
    }

    /// Solves `A x = b`, by places, in the place of `b`, which is without the rows that bodies are eliminated by: `impulses` has what these miss,
    /// and then what they get. `is_asked`: of which components.
    #[inline(always)]
    pub(crate) fn solve(
        &mut self,
        sparsity: &Sparsity,
        x: &mut [Vector6],
        impulses: &mut [f64],
        is_asked: impl Fn(usize) -> bool,
    ) {
        let asked = |&(at, _): &(usize, &Block6)| is_asked(at);
        for (at, triangle) in self.diagonal.iter().enumerate().filter(asked) {
            if let Elimination::Rows(_) = sparsity.eliminations[at] {
                self.links.pass_on(at, triangle, impulses, x);
                continue;
            }
            let now = forward(triangle, &x[at]);
            x[at] = now;
            for column in sparsity.columns_of(at) {
                let block = &self.beside[column.block as usize];
                let to = &mut x[column.to as usize];
                for (row, now) in block.iter().zip(now) {
                    add_scaled(to, -now, row);
                }
            }
        }
        for (at, triangle) in self.diagonal.iter().enumerate().rev().filter(asked) {
            if let Elimination::Rows(_) = sparsity.eliminations[at] {
                self.links.resolve(at, x, impulses);
                continue;
            }
            let mut now = x[at];
            for column in sparsity.columns_of(at) {
                let block = &self.beside[column.block as usize];
                let from = &x[column.to as usize];
                for (now, row) in now.iter_mut().zip(block) {
                    *now -= dot(row, from);
                }
            }
            x[at] = backward(triangle, &now);
        }
    }
}

/// The lower triangle of a factor, with the inverses of its diagonal.
#[inline(always)]
fn cholesky(a: &mut Block6) {
    for i in 0..6 {
        for j in 0..i {
            let rest = a[i][j] - dot_of_first(j, &a[i], &a[j]);
            a[i][j] = rest * a[j][j];
        }
        let rest = a[i][i] - dot_of_first(i, &a[i], &a[i]);
        // Positive but for rounding: what is left of it then does not move.
        a[i][i] = if rest > 0.0 { rest.sqrt().recip() } else { 0.0 };
    }
}

#[inline(always)]
fn dot_of_first(count: usize, a: &Vector6, b: &Vector6) -> f64 {
    let products = a[..count].iter().zip(&b[..count]).map(|(a, b)| a * b);
    products.sum()
}

/// `L^-1 B` in the place of `B`.
#[inline(always)]
fn divide(triangle: &Block6, b: &mut Block6) {
    for i in 0..6 {
        let mut row = b[i];
        for k in 0..i {
            add_scaled(&mut row, -triangle[i][k], &b[k]);
        }
        b[i] = row.map(|x| x * triangle[i][i]);
    }
}

/// `to -= A^T B`
#[inline(always)]
fn take_product(to: &mut Block6, a: &Block6, b: &Block6) {
    for (a, b) in a.iter().zip(b) {
        add_outer(to, -1.0, a, b);
    }
}

/// `L^-1 b`
#[inline(always)]
fn forward(triangle: &Block6, b: &Vector6) -> Vector6 {
    let mut x = *b;
    for i in 0..6 {
        for k in 0..i {
            x[i] -= triangle[i][k] * x[k];
        }
        x[i] *= triangle[i][i];
    }
    x
}

/// `L^-T b`
#[inline(always)]
fn backward(triangle: &Block6, b: &Vector6) -> Vector6 {
    let mut x = *b;
    for i in (0..6).rev() {
        for k in i + 1..6 {
            x[i] -= triangle[k][i] * x[k];
        }
        x[i] *= triangle[i][i];
    }
    x
}
