//! A symmetric positive system of blocks of six by six, factorised where parts are bonded or become neighbors by that.
//!
//! Rows are in an order of nested dissection (A. George, 1973; `dissection.rs`): the parts between two halves come after both, so that
//! neither half fills the other. Column by column, the rows that are not zero are known before anything is worked out: those of its bonds and
//! of all columns that are finished first in it (A. George and J. Liu, 1981).

/// Six by six, row by row.
pub(crate) type Block = [[f64; 6]; 6];

/// Six numbers.
pub(crate) type Six = [f64; 6];

pub(super) const NONE: u32 = u32::MAX;

/// Where the lower triangle of a system has blocks, by column.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pattern {
    /// By column: where its rows begin in `rows`; behind the last one, where they end.
    pub(super) starts: Vec<usize>,
    /// Ascending in a column; the first one is the diagonal.
    pub(super) rows: Vec<u32>,
}

/// Lower triangle of a system, or its factor.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sparse {
    pub(super) pattern: Pattern,
    pub(super) blocks: Vec<Block>,
    /// Columns that are factorised.
    done: usize,
    /// By row, what is to be taken out of the columns that are not done yet; zero but for the columns of a bond that is being taken out.
    pub(super) update: Vec<Block>,
}

impl Pattern {
    /// Of the factor of a system of so many rows; `links`: rows and columns of what is not zero in the lower triangle, but for the diagonal.
    pub(crate) fn of(count: usize, links: impl Iterator<Item = [u32; 2]>) -> Self {
        let mut by_column: Vec<[u32; 2]> = links.map(|[row, column]| [column, row]).collect();
        by_column.sort_unstable();
        let mut own = by_column.iter().peekable();
        let mut pattern = Self {
            starts: vec![0],
            rows: Vec::new(),
        };
        // Columns that are finished first in a column: a list for each.
        let (mut first, mut next) = (vec![NONE; count], vec![NONE; count]);
        let mut last_in = vec![NONE; count];
        for column in 0..count as u32 {
            let start = pattern.rows.len();
            pattern.rows.push(column);
            last_in[column as usize] = column;
            let mut add = |rows: &mut Vec<u32>, row: u32| {
                if std::mem::replace(&mut last_in[row as usize], column) != column {
                    rows.push(row);
                }
            };
            while let Some([_, row]) = own.next_if(|link| link[0] == column) {
                add(&mut pattern.rows, *row);
            }
            let mut child = first[column as usize];
            while child != NONE {
                let at = child as usize;
                for place in pattern.starts[at] + 1..pattern.starts[at + 1] {
                    let row = pattern.rows[place];
                    add(&mut pattern.rows, row);
                }
                child = next[at];
            }
            pattern.rows[start..].sort_unstable();
            if let Some(&parent) = pattern.rows.get(start + 1) {
                next[column as usize] = std::mem::replace(&mut first[parent as usize], column);
            }
            pattern.starts.push(pattern.rows.len());
        }
        pattern
    }

    /// Number of blocks.
    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    /// Products of blocks that the factor takes.
    pub(crate) fn cost(&self) -> usize {
        let columns = 0..self.starts.len() - 1;
        columns.map(|at| product_count(self.column(at).len())).sum()
    }

    pub(super) fn column(&self, column: usize) -> std::ops::Range<usize> {
        self.starts[column]..self.starts[column + 1]
    }

    /// The first column that changes when this one does; `NONE` behind the last one.
    pub(super) fn parent(&self, column: usize) -> u32 {
        let own = &self.rows[self.column(column)];
        own.get(1).copied().unwrap_or(NONE)
    }
}

/// Products of blocks that a column with so many rows takes.
fn product_count(width: usize) -> usize {
    width * width / 2 + 1
}

impl Sparse {
    /// Zeros.
    pub(crate) fn new(pattern: Pattern) -> Self {
        Self {
            blocks: vec![[[0.0; 6]; 6]; pattern.rows.len()],
            pattern,
            done: 0,
            update: Vec::new(),
        }
    }

    /// The block in a column and a row no smaller than it, if there is one.
    pub(crate) fn block_mut(&mut self, row: u32, column: u32) -> Option<&mut Block> {
        let own = self.pattern.column(column as usize);
        let place = self.pattern.rows[own.clone()].binary_search(&row).ok()?;
        Some(&mut self.blocks[own.start + place])
    }

    /// `A = L L^T`, in place, column by column as long as `budget` has products of blocks left; whether all are done.
    pub(crate) fn factorise(&mut self, budget: &mut usize) -> bool {
        while self.done + 1 < self.pattern.starts.len() {
            if *budget == 0 {
                return false;
            }
            let own = self.pattern.column(self.done);
            self.done += 1;
            *budget = budget.saturating_sub(product_count(own.len()));
            let (head, later) = self.blocks.split_at_mut(own.end);
            let (diagonal, below) = head[own.start..].split_at_mut(1);
            factorise_block(&mut diagonal[0]);
            for block in &mut *below {
                divide_by_transposed(block, &diagonal[0]);
            }
            let rows = &self.pattern.rows[own.start + 1..own.end];
            for (i, (&column, right)) in rows.iter().zip(&*below).enumerate() {
                // What is in this column from here on is in that one too.
                let mut place = self.pattern.starts[column as usize];
                let right = transposed(right);
                for (&row, left) in rows[i..].iter().zip(&below[i..]) {
                    while self.pattern.rows[place] < row {
                        place += 1;
                    }
                    take_product(&mut later[place - own.end], left, &right);
                }
            }
        }
        true
    }

    /// Solves with the factor, in place.
    pub(crate) fn solve(&self, x: &mut [Six]) {
        for column in 0..x.len() {
            let own = self.pattern.column(column);
            solve_lower(&self.blocks[own.start], &mut x[column]);
            let known = x[column];
            for place in own.start + 1..own.end {
                let to = &mut x[self.pattern.rows[place] as usize];
                for (to, row) in to.iter_mut().zip(&self.blocks[place]) {
                    *to -= row.iter().zip(&known).map(|(a, x)| a * x).sum::<f64>();
                }
            }
        }
        for column in (0..x.len()).rev() {
            let own = self.pattern.column(column);
            let mut sum = x[column];
            for place in own.start + 1..own.end {
                let known = &x[self.pattern.rows[place] as usize];
                for (row, known) in self.blocks[place].iter().zip(known) {
                    for (sum, a) in sum.iter_mut().zip(row) {
                        *sum -= a * known;
                    }
                }
            }
            solve_upper(&self.blocks[own.start], &mut sum);
            x[column] = sum;
        }
    }
}

pub(super) fn transposed(a: &Block) -> Block {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}

/// `c -= a b`, row by row of `b`: as many columns at a time as a register holds.
pub(super) fn take_product(c: &mut Block, a: &Block, b: &Block) {
    for (c, a) in c.iter_mut().zip(a) {
        let mut sum = b[0].map(|b| a[0] * b);
        for (a, b) in a.iter().zip(b).skip(1) {
            for (sum, b) in sum.iter_mut().zip(b) {
                *sum += a * b;
            }
        }
        for (c, sum) in c.iter_mut().zip(sum) {
            *c -= sum;
        }
    }
}

/// `x = x l^-T` with a lower triangle.
pub(super) fn divide_by_transposed(x: &mut Block, l: &Block) {
    for row in x {
        solve_lower(l, row);
    }
}

/// `x = l^-1 x` with a lower triangle.
pub(super) fn solve_lower(l: &Block, x: &mut Six) {
    for i in 0..6 {
        let sum: f64 = (0..i).map(|j| l[i][j] * x[j]).sum();
        x[i] = (x[i] - sum) / l[i][i];
    }
}

/// `x = l^-T x` with a lower triangle.
fn solve_upper(l: &Block, x: &mut Six) {
    for i in (0..6).rev() {
        let sum: f64 = (i + 1..6).map(|j| l[j][i] * x[j]).sum();
        x[i] = (x[i] - sum) / l[i][i];
    }
}

/// Cholesky's factor of a block, in its lower triangle.
pub(super) fn factorise_block(a: &mut Block) {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A system of blocks that are linked at random, as a matrix of numbers too: factor and solution are those of a naive twin.
    #[test]
    fn solves_what_is_linked_at_random() {
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24) - 0.5
        };
        for round in 0..20u32 {
            let count = 2 + round;
            let mut links = Vec::new();
            for row in 0..count {
                for column in 0..row {
                    if random() > 0.3 || column + 1 == row && random() > 0.0 {
                        links.push([row, column]);
                    }
                }
            }
            let mut system = Sparse::new(Pattern::of(count as usize, links.iter().copied()));
            let size = 6 * count as usize;
            let mut dense = vec![vec![0.0; size]; size];
            let all = links.iter().copied().chain((0..count).map(|i| [i, i]));
            for [row, column] in all {
                let [low, left] = [row, column].map(|number| 6 * number as usize);
                for (a, b) in (low..low + 6).flat_map(|a| (left..left + 6).map(move |b| (a, b))) {
                    if a >= b {
                        let on_diagonal = 8.0 * f64::from(count);
                        let value = if a == b { on_diagonal } else { random() };
                        (dense[a][b], dense[b][a]) = (value, value);
                    }
                }
                let block = system.block_mut(row, column).expect("in the pattern");
                let value = |i: usize, j: usize| dense[low + i][left + j];
                *block = std::array::from_fn(|i| std::array::from_fn(|j| value(i, j)));
            }
            let loads: Vec<Six> = (0..count).map(|_| [(); 6].map(|()| random())).collect();
            let mut found = loads.clone();
            // In small bites.
            while !system.factorise(&mut 3) {}
            system.solve(&mut found);
            let flat: Vec<f64> = found.concat();
            for (row, load) in dense.iter().zip(loads.concat()) {
                let sum: f64 = row.iter().zip(&flat).map(|(a, x)| a * x).sum();
                assert!((sum - load).abs() < 1e-12, "{round}: {sum} for {load}");
            }
        }
    }
}
