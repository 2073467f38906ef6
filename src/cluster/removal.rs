//! A bond that breaks is taken out of the factor of its system: only the columns change that its parts are finished before.
//!
//! `A - W C W^T` has the factor that follows column by column from that of `A`, and of each column no more than the six that `W` has is left
//! for the ones behind it (P. Gill et al., 1974, by blocks). Which columns these are is known from the pattern: after each one the first row below its
//! diagonal. Of a beam of 1300 parts that is a hundredth of what the whole factor takes.

use crate::cluster::sparse::{
    Block, NONE, Sparse, divide_by_transposed, factorise_block, solve_lower, take_product,
    transposed,
};

/// A bond that is being taken out.
#[derive(Clone, Debug)]
pub(crate) struct Removal {
    /// The rows of its parts; `NONE` of one that does not move.
    rows: [u32; 2],
    /// How the bond is strained by motions of its parts, transposed.
    strains: [Block; 2],
    /// What is added between the columns that are not done yet.
    middle: Block,
    /// The next column; `NONE` behind the last one.
    column: u32,
    has_begun: bool,
}

impl Removal {
    /// Of a bond of this stiffness, with `strains` (transposed) by motions of its parts in `rows`.
    pub(crate) fn new(rows: [u32; 2], strains: [Block; 2], stiffness: &Block) -> Self {
        Self {
            rows,
            strains,
            middle: stiffness.map(|row| row.map(|value| -value)),
            column: rows[0].min(rows[1]),
            has_begun: false,
        }
    }
}

impl Sparse {
    /// Takes a bond out of what is factorised, as long as `budget` has products of blocks left; whether that is done.
    pub(crate) fn remove(&mut self, removal: &mut Removal, budget: &mut usize) -> bool {
        if !removal.has_begun {
            removal.has_begun = true;
            self.update
                .resize(self.pattern.starts.len() - 1, [[0.0; 6]; 6]);
            for (row, strain) in removal.rows.into_iter().zip(removal.strains) {
                if row != NONE {
                    self.update[row as usize] = strain;
                }
            }
        }
        while removal.column != NONE {
            if *budget == 0 {
                return false;
            }
            let column = removal.column as usize;
            let width = self.pattern.column(column).len();
            *budget = budget.saturating_sub(3 * width);
            self.remove_from(column, &mut removal.middle);
            removal.column = self.pattern.parent(column);
        }
        true
    }

    fn remove_from(&mut self, column: usize, middle: &mut Block) {
        let own = self.pattern.column(column);
        let (diagonal, below) = self.blocks[own.clone()].split_at_mut(1);
        let before = lower(&diagonal[0]);
        let strain = std::mem::replace(&mut self.update[column], [[0.0; 6]; 6]);
        let weighted = product(&strain, middle);
        let mut after = product(&before, &transposed(&before));
        add_product(&mut after, &strain, &transposed(&weighted));
        factorise_block(&mut after);
        // What the columns behind it get.
        let share = solved(&after, &weighted);
        let by_own = solved(&before, &strain);
        let (before, weighted) = (transposed(&before), transposed(&weighted));
        for (&row, block) in self.pattern.rows[own.start + 1..own.end].iter().zip(below) {
            let other = &mut self.update[row as usize];
            let mut new = product(block, &before);
            add_product(&mut new, other, &weighted);
            divide_by_transposed(&mut new, &after);
            take_product(other, block, &by_own);
            *block = new;
        }
        diagonal[0] = after;
        take_product(middle, &transposed(&share), &share);
    }

    /// Products of blocks that it takes to take out a bond.
    pub(crate) fn cost_of(&self, removal: &Removal) -> usize {
        let mut column = removal.column;
        let mut sum = 0;
        while column != NONE {
            sum += 3 * self.pattern.column(column as usize).len();
            column = self.pattern.parent(column as usize);
        }
        sum
    }
}

fn lower(a: &Block) -> Block {
    std::array::from_fn(|i| std::array::from_fn(|j| if j <= i { a[i][j] } else { 0.0 }))
}

fn product(a: &Block, b: &Block) -> Block {
    let mut sum = [[0.0; 6]; 6];
    add_product(&mut sum, a, b);
    sum
}

/// `c += a b`.
fn add_product(c: &mut Block, a: &Block, b: &Block) {
    for (c, a) in c.iter_mut().zip(a) {
        for (a, b) in a.iter().zip(b) {
            for (c, b) in c.iter_mut().zip(b) {
                *c += a * b;
            }
        }
    }
}

/// `l^-1 x` with a lower triangle.
fn solved(l: &Block, x: &Block) -> Block {
    let mut columns = transposed(x);
    columns.iter_mut().for_each(|column| solve_lower(l, column));
    transposed(&columns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cluster::sparse::{Pattern, Six};

    /// Springs that are taken out of a factor one by one, in small bites, leave what the others make.
    #[test]
    fn what_is_taken_out_is_as_if_it_had_never_been_there() {
        let mut state = 7u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24) - 0.5
        };
        let mut taken = 0;
        for round in 0..20u32 {
            let count = 3 + round;
            let pairs = (0..count).flat_map(|row| (0..row).map(move |column| [row, column]));
            let links: Vec<[u32; 2]> = pairs.filter(|_| random() > 0.2).collect();
            // How each spring is strained by its two ends, transposed.
            let springs: Vec<[Block; 2]> = (links.iter())
                .map(|_| [(); 2].map(|()| [(); 6].map(|()| [(); 6].map(|()| random()))))
                .collect();
            let unit: Block =
                std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
            let system_of = |is_in: &dyn Fn(usize) -> bool| {
                let mut system = Sparse::new(Pattern::of(count as usize, links.iter().copied()));
                for row in 0..count {
                    *system.block_mut(row, row).expect("on the diagonal") = unit;
                }
                for (spring, (rows, strains)) in links.iter().zip(&springs).enumerate() {
                    for (a, b) in [(0, 0), (0, 1), (1, 1)] {
                        let to = system.block_mut(rows[a], rows[b]).expect("in the pattern");
                        for (i, j) in (0..6).flat_map(|i| (0..6).map(move |j| (i, j))) {
                            let products = strains[a][i].iter().zip(&strains[b][j]);
                            let sum: f64 = products.map(|(a, b)| a * b).sum();
                            to[i][j] += if is_in(spring) { sum } else { 0.0 };
                        }
                    }
                }
                while !system.factorise(&mut 5) {}
                system
            };
            let is_left = |spring: usize| spring % 3 != 1;
            let (mut system, rest) = (system_of(&|_| true), system_of(&is_left));
            for (spring, rows) in links.iter().enumerate() {
                if !is_left(spring) {
                    let mut removal = Removal::new(*rows, springs[spring], &unit);
                    while !system.remove(&mut removal, &mut 7) {}
                    taken += 1;
                }
            }
            let mut found: Vec<Six> = (0..count).map(|_| [(); 6].map(|()| random())).collect();
            let mut known = found.clone();
            system.solve(&mut found);
            rest.solve(&mut known);
            for (found, known) in found.concat().iter().zip(known.concat()) {
                assert!((found - known).abs() < 1e-9, "{round}: {found} for {known}");
            }
        }
        assert!(taken > 100, "{taken}");
    }
}
