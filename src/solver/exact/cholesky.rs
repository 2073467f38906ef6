//! Cholesky factor of a sparse symmetric matrix of 6 x 6 blocks, one block row per body.
//!
//! The pattern is the graph of bodies joined by contacts. It is analysed once per problem: bodies are eliminated in the
//! order of least degree (bond_constraints: lower index), which also gives the pattern of the factor. The numbers are then factored
//! as often as needed, one block column after the other. Nothing depends on the machine: plain multiplications and
//! additions in a fixed order.
//!
//! # References
//! George and Liu, "The Evolution of the Minimum Degree Ordering Algorithm", SIAM Review 31(1), 1989; Davis, "Direct
//! Methods for Sparse Linear Systems", 2006.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Unknowns per body.
pub(crate) const WIDTH: usize = 6;

/// 6 x 6 numbers, column after column.
pub(crate) type DenseBlock = [f64; WIDTH * WIDTH];

const ZERO: DenseBlock = [0.0; WIDTH * WIDTH];

/// Lower triangle of the matrix, overwritten by its factor `L` with `L L^T = H`.
#[derive(Debug, Default)]
pub(crate) struct BlockCholesky {
    /// Diagonal blocks in the order of elimination; after [`factor`](Self::factor) with the reciprocals of the pivots.
    diagonal: Vec<DenseBlock>,
    /// Where each block column starts in `rows` and `blocks`; one more entry than columns.
    starts: Vec<u32>,
    /// Block rows of the blocks below the diagonal, ascending within each column.
    rows: Vec<u32>,
    /// The blocks below the diagonal.
    blocks: Vec<DenseBlock>,
    /// Place of each body in the order of elimination.
    place: Vec<u32>,
    graph: Graph,
}

/// Scratch of the analysis.
#[derive(Debug, Default)]
struct Graph {
    /// Neighbors of each node that are not yet eliminated, ascending; of an eliminated one: those it had then.
    neighbors: Vec<Vec<u32>>,
    /// (degree, node), some out of date.
    queue: BinaryHeap<Reverse<(u32, u32)>>,
    order: Vec<u32>,
    merged: Vec<u32>,
}

impl Graph {
    fn build(&mut self, nodes: usize, edges: impl Iterator<Item = [u32; 2]>) {
        self.neighbors.iter_mut().for_each(Vec::clear);
        if self.neighbors.len() < nodes {
            self.neighbors.resize_with(nodes, Vec::new);
        }
        for [a, b] in edges {
            self.neighbors[a as usize].push(b);
            self.neighbors[b as usize].push(a);
        }
        self.queue.clear();
        for (node, list) in self.neighbors[..nodes].iter_mut().enumerate() {
            list.sort_unstable();
            list.dedup();
            self.queue.push(Reverse((list.len() as u32, node as u32)));
        }
    }

    /// Eliminates all nodes; `order` lists them, `neighbors` holds the pattern of the factor's columns.
    fn eliminate(&mut self, place: &mut [u32]) {
        const OPEN: u32 = u32::MAX;
        place.fill(OPEN);
        self.order.clear();
        while let Some(Reverse((degree, node))) = self.queue.pop() {
            let list = &mut self.neighbors[node as usize];
            if place[node as usize] != OPEN || list.len() != degree as usize {
                continue;
            }
            place[node as usize] = self.order.len() as u32;
            self.order.push(node);
            let clique = std::mem::take(list);
            for &other in &clique {
                let list = &mut self.neighbors[other as usize];
                merge_without(list, &clique, [node, other], &mut self.merged);
                std::mem::swap(list, &mut self.merged);
                self.queue.push(Reverse((list.len() as u32, other)));
            }
            self.neighbors[node as usize] = clique;
        }
    }
}

/// `out` becomes the sorted union of two sorted lists without the two nodes of `except`.
fn merge_without(a: &[u32], b: &[u32], except: [u32; 2], out: &mut Vec<u32>) {
    out.clear();
    let (mut i, mut j) = (0, 0);
    loop {
        let next = match (a.get(i), b.get(j)) {
            (Some(&x), Some(&y)) => x.min(y),
            (Some(&x), None) => x,
            (None, Some(&y)) => y,
            (None, None) => return,
        };
        i += usize::from(a.get(i) == Some(&next));
        j += usize::from(b.get(j) == Some(&next));
        if !except.contains(&next) {
            out.push(next);
        }
    }
}

impl BlockCholesky {
    /// Takes over a new pattern: `nodes` bodies, and an edge for each pair of bodies that share a contact.
    pub(crate) fn analyse(&mut self, nodes: usize, edges: impl Iterator<Item = [u32; 2]>) {
        self.graph.build(nodes, edges);
        self.place.clear();
        self.place.resize(nodes, 0);
        self.graph.eliminate(&mut self.place);
        self.starts.clear();
        self.starts.push(0);
        self.rows.clear();
        for &node in &self.graph.order {
            let first = self.rows.len();
            let column = &self.graph.neighbors[node as usize];
            self.rows
                .extend(column.iter().map(|&n| self.place[n as usize]));
            self.rows[first..].sort_unstable();
            self.starts.push(self.rows.len() as u32);
        }
        self.diagonal.clear();
        self.diagonal.resize(nodes, ZERO);
        self.blocks.clear();
        self.blocks.resize(self.rows.len(), ZERO);
    }

    /// Place of a body in the order of elimination: the block row of its unknowns.
    pub(crate) fn place(&self, node: u32) -> u32 {
        self.place[node as usize]
    }

    /// Number of block rows.
    pub(crate) fn len(&self) -> usize {
        self.diagonal.len()
    }

    /// Index of the block that joins the block rows `low < high`, which must share a contact.
    pub(crate) fn block_index(&self, low: u32, high: u32) -> u32 {
        let column = self.column(low as usize);
        let within = self.rows[column.clone()].binary_search(&high);
        (column.start + within.expect("the two bodies share a contact")) as u32
    }

    fn column(&self, k: usize) -> std::ops::Range<usize> {
        self.starts[k] as usize..self.starts[k + 1] as usize
    }

    /// The matrix becomes the identity.
    pub(crate) fn reset(&mut self) {
        self.blocks.fill(ZERO);
        let mut identity = ZERO;
        (0..WIDTH).for_each(|i| identity[i * WIDTH + i] = 1.0);
        self.diagonal.fill(identity);
    }

    /// Adds `weight x y^T` to the block on the diagonal of block row `k`; `x y^T` must come to a symmetric sum.
    pub(crate) fn add_diagonal(&mut self, k: u32, x: &[f64; WIDTH], y: &[f64; WIDTH]) {
        add_product(&mut self.diagonal[k as usize], x, y);
    }

    /// Adds `x y^T` to a block below the diagonal: `x` on the side of the higher block row.
    pub(crate) fn add_block(&mut self, index: u32, x: &[f64; WIDTH], y: &[f64; WIDTH]) {
        add_product(&mut self.blocks[index as usize], x, y);
    }

    /// Replaces the matrix, which must not be smaller than the identity, by its factor.
    pub(crate) fn factor(&mut self) {
        for k in 0..self.len() {
            factor_block(&mut self.diagonal[k]);
            let column = self.column(k);
            for block in &mut self.blocks[column.clone()] {
                divide_by_transposed(block, &self.diagonal[k]);
            }
            for s in column.clone() {
                self.subtract_products(s, column.end);
            }
        }
    }

    /// Subtracts from the column of block `s` what the blocks `s..end` of its own column contribute to it.
    fn subtract_products(&mut self, s: usize, end: usize) {
        let i = self.rows[s] as usize;
        let right = self.blocks[s];
        subtract_product(&mut self.diagonal[i], &right, &right);
        let mut target = self.starts[i] as usize;
        for t in s + 1..end {
            // The pattern of column i holds all of these rows, in the same order.
            while self.rows[target] != self.rows[t] {
                target += 1;
            }
            let left = self.blocks[t];
            subtract_product(&mut self.blocks[target], &left, &right);
        }
    }

    /// `x <- H^-1 x`, after [`factor`](Self::factor).
    pub(crate) fn solve(&self, x: &mut [f64]) {
        for k in 0..self.len() {
            let mut own = read(x, k);
            solve_lower(&self.diagonal[k], &mut own);
            write(x, k, &own);
            for s in self.column(k) {
                let i = self.rows[s] as usize;
                let mut other = read(x, i);
                for (column, factor) in self.blocks[s].chunks_exact(WIDTH).zip(own) {
                    (0..WIDTH).for_each(|r| other[r] -= column[r] * factor);
                }
                write(x, i, &other);
            }
        }
        for k in (0..self.len()).rev() {
            let mut own = read(x, k);
            for s in self.column(k) {
                let other = read(x, self.rows[s] as usize);
                for (column, value) in self.blocks[s].chunks_exact(WIDTH).zip(&mut own) {
                    *value -= (0..WIDTH).map(|r| column[r] * other[r]).sum::<f64>();
                }
            }
            solve_upper(&self.diagonal[k], &mut own);
            write(x, k, &own);
        }
    }
}

fn read(x: &[f64], k: usize) -> [f64; WIDTH] {
    std::array::from_fn(|r| x[k * WIDTH + r])
}

fn write(x: &mut [f64], k: usize, values: &[f64; WIDTH]) {
    x[k * WIDTH..][..WIDTH].copy_from_slice(values);
}

#[inline]
fn add_product(block: &mut DenseBlock, x: &[f64; WIDTH], y: &[f64; WIDTH]) {
    for (column, factor) in block.chunks_exact_mut(WIDTH).zip(y) {
        (0..WIDTH).for_each(|r| column[r] += x[r] * factor);
    }
}

/// `block -= left right^T`.
#[inline]
fn subtract_product(block: &mut DenseBlock, left: &DenseBlock, right: &DenseBlock) {
    for c in 0..WIDTH {
        let mut column: [f64; WIDTH] = std::array::from_fn(|r| block[c * WIDTH + r]);
        for k in 0..WIDTH {
            let factor = right[k * WIDTH + c];
            (0..WIDTH).for_each(|r| column[r] -= left[k * WIDTH + r] * factor);
        }
        block[c * WIDTH..][..WIDTH].copy_from_slice(&column);
    }
}

/// Cholesky factor in the lower triangle, with the reciprocals of the pivots on the diagonal.
///
/// All pivots of a matrix that is at least the identity are at least 1; less can only be rounding.
fn factor_block(block: &mut DenseBlock) {
    for c in 0..WIDTH {
        let inverse = 1.0 / block[c * WIDTH + c].max(1.0).sqrt();
        block[c * WIDTH + c] = inverse;
        for r in c + 1..WIDTH {
            block[c * WIDTH + r] *= inverse;
        }
        for d in c + 1..WIDTH {
            let factor = block[c * WIDTH + d];
            for r in d..WIDTH {
                block[d * WIDTH + r] -= block[c * WIDTH + r] * factor;
            }
        }
    }
}

/// `block <- block L^-T`.
#[inline]
fn divide_by_transposed(block: &mut DenseBlock, lower: &DenseBlock) {
    for c in 0..WIDTH {
        let mut column: [f64; WIDTH] = std::array::from_fn(|r| block[c * WIDTH + r]);
        for k in 0..c {
            let factor = lower[k * WIDTH + c];
            (0..WIDTH).for_each(|r| column[r] -= block[k * WIDTH + r] * factor);
        }
        let inverse = lower[c * WIDTH + c];
        (0..WIDTH).for_each(|r| block[c * WIDTH + r] = column[r] * inverse);
    }
}

/// `x <- L^-1 x`.
fn solve_lower(lower: &DenseBlock, x: &mut [f64; WIDTH]) {
    for c in 0..WIDTH {
        x[c] *= lower[c * WIDTH + c];
        for r in c + 1..WIDTH {
            x[r] -= lower[c * WIDTH + r] * x[c];
        }
    }
}

/// `x <- L^-T x`.
fn solve_upper(lower: &DenseBlock, x: &mut [f64; WIDTH]) {
    for c in (0..WIDTH).rev() {
        for r in c + 1..WIDTH {
            x[c] -= lower[c * WIDTH + r] * x[r];
        }
        x[c] *= lower[c * WIDTH + c];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix on a ring of bodies with one chord, built from vectors that join two bodies each.
    fn ring(nodes: u32) -> (BlockCholesky, Vec<Vec<f64>>) {
        let mut edges: Vec<[u32; 2]> = (0..nodes).map(|i| [i, (i + 1) % nodes]).collect();
        edges.push([0, nodes / 2]);
        let mut sparse = BlockCholesky::default();
        sparse.analyse(nodes as usize, edges.iter().copied());
        sparse.reset();
        let n = nodes as usize * WIDTH;
        let mut dense = vec![vec![0.0; n]; n];
        (0..n).for_each(|i| dense[i][i] = 1.0);
        for (e, edge) in edges.iter().enumerate() {
            let places = edge.map(|node| sparse.place(node));
            let (low, high) = (places[0].min(places[1]), places[0].max(places[1]));
            for k in 0..3 {
                let x: [f64; WIDTH] =
                    std::array::from_fn(|r| ((e * 7 + k * 3 + r * 5) % 11) as f64 - 5.0);
                let y: [f64; WIDTH] =
                    std::array::from_fn(|r| ((e * 5 + k * 2 + r * 3) % 13) as f64 - 6.0);
                sparse.add_diagonal(low, &x, &x);
                sparse.add_diagonal(high, &y, &y);
                sparse.add_block(sparse.block_index(low, high), &y, &x);
                let mut whole = vec![0.0; n];
                whole[low as usize * WIDTH..][..WIDTH].copy_from_slice(&x);
                whole[high as usize * WIDTH..][..WIDTH].copy_from_slice(&y);
                for i in 0..n {
                    (0..n).for_each(|j| dense[i][j] += whole[i] * whole[j]);
                }
            }
        }
        (sparse, dense)
    }

    #[test]
    fn factor_solves_what_the_dense_matrix_says() {
        let (mut sparse, dense) = ring(9);
        let target_velocity: Vec<f64> = (0..dense.len())
            .map(|i| (i * i % 17) as f64 - 8.0)
            .collect();
        let mut x: Vec<f64> = dense
            .iter()
            .map(|row| row.iter().zip(&target_velocity).map(|(a, b)| a * b).sum())
            .collect();
        sparse.factor();
        sparse.solve(&mut x);
        let worst = x
            .iter()
            .zip(&target_velocity)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(worst < 1e-10, "worst error {worst:e}");
    }

    #[test]
    fn a_chain_has_no_fill() {
        let mut sparse = BlockCholesky::default();
        sparse.analyse(50, (0..49).map(|i| [i, i + 1]));
        assert_eq!(sparse.blocks.len(), 49);
    }
}
