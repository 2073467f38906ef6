//! A symmetric positive system of blocks of six by six, factorised within its envelope.
//!
//! Rows are in an order of breadth-first search, reversed, which keeps the envelope of a graph that is long, or flat, narrow (E. Cuthill
//! and J. McKee, 1969; A. George, 1971). A row has its blocks from the first one that is not zero up to the diagonal.

/// Six by six, row by row.
pub(crate) type Block = [[f64; 6]; 6];

/// Six numbers.
pub(crate) type Six = [f64; 6];

/// Lower triangle within its envelope.
#[derive(Debug, Default)]
pub(crate) struct Skyline {
    /// By row: its first column.
    first: Vec<u32>,
    /// By row: where its blocks begin; behind the last one, where they end.
    starts: Vec<usize>,
    blocks: Vec<Block>,
    /// Rows that are factorised.
    done: usize,
}

impl Skyline {
    /// Zeros, from these first columns on.
    pub(crate) fn new(first: Vec<u32>) -> Self {
        let mut starts = vec![0];
        for (row, &first) in first.iter().enumerate() {
            starts.push(starts[row] + row + 1 - first as usize);
        }
        let blocks = vec![[[0.0; 6]; 6]; starts[first.len()]];
        Self {
            first,
            starts,
            blocks,
            done: 0,
        }
    }

    /// Products of blocks that factorising takes.
    pub(crate) fn work(first: &[u32]) -> usize {
        let widths = first.iter().enumerate();
        let widths = widths.map(|(row, &first)| row + 1 - first as usize);
        widths.map(|width| width * width / 2).sum()
    }

    /// The block in a row and a column no larger than the row.
    pub(crate) fn block_mut(&mut self, row: usize, column: usize) -> &mut Block {
        let at = self.starts[row] + column - self.first[row] as usize;
        &mut self.blocks[at]
    }

    /// `A = L L^T`, in place, row by row as long as `budget` has products of blocks left; whether all rows are done.
    pub(crate) fn factorise(&mut self, budget: &mut usize) -> bool {
        while self.done < self.first.len() {
            if *budget == 0 {
                return false;
            }
            let row = self.done;
            let width = row + 1 - self.first[row] as usize;
            *budget = budget.saturating_sub(width * width / 2 + 1);
            self.done += 1;
            let (done, own) = self.blocks.split_at_mut(self.starts[row]);
            let first = self.first[row] as usize;
            for column in first..row {
                let from = self.first[column] as usize;
                let start = self.starts[column];
                let common = first.max(from);
                let (before, rest) = own.split_at_mut(column - first);
                for k in common..column {
                    take_product(&mut rest[0], &before[k - first], &done[start + k - from]);
                }
                divide_by_transposed(&mut rest[0], &done[start + column - from]);
            }
            let (before, rest) = own.split_at_mut(row - first);
            for block in before.iter() {
                take_product(&mut rest[0], block, block);
            }
            factorise_block(&mut rest[0]);
        }
        true
    }

    /// Solves with the factors, in place.
    pub(crate) fn solve(&self, x: &mut [Six]) {
        let count = self.first.len();
        for row in 0..count {
            let first = self.first[row] as usize;
            let blocks = &self.blocks[self.starts[row]..self.starts[row + 1]];
            let mut own = x[row];
            for (k, block) in blocks[..row - first].iter().enumerate() {
                let known = x[first + k];
                for i in 0..6 {
                    own[i] -= (0..6).map(|j| block[i][j] * known[j]).sum::<f64>();
                }
            }
            let diagonal = &blocks[row - first];
            for i in 0..6 {
                let sum: f64 = (0..i).map(|j| diagonal[i][j] * own[j]).sum();
                own[i] = (own[i] - sum) / diagonal[i][i];
            }
            x[row] = own;
        }
        for row in (0..count).rev() {
            let first = self.first[row] as usize;
            let blocks = &self.blocks[self.starts[row]..self.starts[row + 1]];
            let diagonal = &blocks[row - first];
            let mut own = x[row];
            for i in (0..6).rev() {
                let sum: f64 = (i + 1..6).map(|j| diagonal[j][i] * own[j]).sum();
                own[i] = (own[i] - sum) / diagonal[i][i];
            }
            x[row] = own;
            for (k, block) in blocks[..row - first].iter().enumerate() {
                for i in 0..6 {
                    x[first + k][i] -= (0..6).map(|j| block[j][i] * own[j]).sum::<f64>();
                }
            }
        }
    }
}

/// `c -= a b^T`.
fn take_product(c: &mut Block, a: &Block, b: &Block) {
    for (c, a) in c.iter_mut().zip(a) {
        for (c, b) in c.iter_mut().zip(b) {
            *c -= a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5];
        }
    }
}

/// `x = x l^-T` with a lower triangle.
fn divide_by_transposed(x: &mut Block, l: &Block) {
    for row in x {
        for i in 0..6 {
            let sum: f64 = (0..i).map(|j| row[j] * l[i][j]).sum();
            row[i] = (row[i] - sum) / l[i][i];
        }
    }
}

/// Cholesky's factor of a block, in its lower triangle.
fn factorise_block(a: &mut Block) {
    for i in 0..6 {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| a[i][k] * a[j][k]).sum();
            let rest = a[i][j] - sum;
            a[i][j] = if i == j {
                // Rounding may leave nothing of what is hardly held.
                rest.max(f64::MIN_POSITIVE).sqrt()
            } else {
                rest / a[j][j]
            };
        }
    }
}
