//! Bodies that hang on one other at most when their turn comes: eliminated by the rows that hold them, as articulated bodies.
//!
//! With `A` the inertia of a body `c` and all that hangs on it, `J_c` and `J_p` the acting rows of its joints with the one body `p` that it
//! hangs on and with what does not move, `K` their stiffness and `e` the velocities by which they are to change, the changes `x` and the
//! impulses `mu` satisfy
//!
//! ```text
//! A x_c = b_c + J_c^T mu,    mu = K (e - J_c x_c - J_p x_p)
//! T^-1 mu = e - J_c A^-1 b_c - J_p x_p,    T^-1 = K^-1 + J_c A^-1 J_c^T
//! ```
//!
//! so that `p` has `J_p^T T J_p` more inertia and `J_p^T T (e - J_c A^-1 b_c)` more impulse. This is the elimination of a block
//! `A + J_c^T K J_c` without its cancellation, since nothing here is as large as `K`, and with matrices of as many rows as act instead of six.
//! With `T^-1 = L D L^T` the rows are combined to `L^-1 J`, of which each acts for itself.
//!
//! # References
//! Featherstone, "Rigid Body Dynamics Algorithms", 2008, chapter 7 (articulated-body inertia).

use crate::solver::joint::vector6::{Block6, Vector6, add_outer, add_scaled, dot, invert, product};
use std::ops::Range;

/// Marks a body that hangs on none.
const NONE: u32 = u32::MAX;

/// A row that acts and holds the body whose turn it is.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LinkRow {
    /// Its number.
    row: u32,
    /// `K^-1`, 1/kg.
    softness: f64,
    /// `J_c`; once combined `A^-1 J_c^T`.
    own: Vector6,
    /// `J_p`.
    other: Vector6,
    /// `D^-1`, kg.
    inverse: f64,
    /// In a solution: impulse of the combined row, N s.
    impulse: f64,
}

/// Says by which rows bodies are eliminated.
pub(super) trait AddRows {
    /// Adds those of the body at a place, whose turn it is.
    fn add_rows(&self, at: usize, links: &mut Links);

    /// The most that a body at a place may have.
    fn most_rows(&self, at: usize) -> usize;
}

impl LinkRow {
    #[inline(always)]
    pub(super) fn new(row: usize, stiffness: f64, [own, other]: [Vector6; 2]) -> Self {
        Self {
            row: row as u32,
            softness: stiffness.recip(),
            own,
            other,
            inverse: 0.0,
            impulse: 0.0,
        }
    }
}

/// The rows of one body; none of one that is eliminated as a block.
#[derive(Clone, Copy, Debug)]
struct Link {
    /// Place of the one that it hangs on.
    parent: u32,
    /// Where its rows begin, and how many there are.
    first_row: u32,
    row_count: u32,
    /// Where the entries of its `L` begin.
    first_entry: u32,
}

impl Link {
    #[inline(always)]
    fn rows(&self) -> Range<usize> {
        let first = self.first_row as usize;
        first..first + self.row_count as usize
    }

    #[inline(always)]
    fn entries(&self) -> Range<usize> {
        let first = self.first_entry as usize;
        first..first + entries_of(self.row_count as usize)
    }
}

/// All of them, by place in the order of elimination.
#[derive(Debug, Default)]
pub(super) struct Links {
    links: Vec<Link>,
    rows: Vec<LinkRow>,
    /// Of each `L` what is below the diagonal, row by row.
    entries: Vec<f64>,
    /// For how many rows and entries there is room so far.
    row_end: usize,
    entry_end: usize,
}

/// Runs an expression on rows of which the compiler knows how many there are where they are those of one ball, one hinge, or two balls.
macro_rules! with_known_count {
    ($rows:ident => $run:expr) => {
        if let Ok($rows) = <&mut [LinkRow; 3]>::try_from(&mut *$rows) {
            $run
        } else if let Ok($rows) = <&mut [LinkRow; 5]>::try_from(&mut *$rows) {
            $run
        } else if let Ok($rows) = <&mut [LinkRow; 6]>::try_from(&mut *$rows) {
            $run
        } else {
            $run
        }
    };
}

impl Links {
    pub(super) fn clear(&mut self) {
        self.links.clear();
        (self.row_end, self.entry_end) = (0, 0);
    }

    /// Makes room for the rows of the next body, so many at most.
    pub(super) fn reserve(&mut self, most: usize) {
        self.links.push(Link {
            parent: NONE,
            first_row: self.row_end as u32,
            row_count: 0,
            first_entry: self.entry_end as u32,
        });
        self.row_end += most;
        self.entry_end += entries_of(most);
        if self.rows.len() < self.row_end {
            self.rows.resize(self.row_end, LinkRow::default());
        }
        if self.entries.len() < self.entry_end {
            self.entries.resize(self.entry_end, 0.0);
        }
    }

    /// Begins with the rows of the body at a place.
    #[inline(always)]
    pub(super) fn begin(&mut self, at: usize) {
        self.links[at].row_count = 0;
    }

    /// Adds a row of the body at a place.
    #[inline(always)]
    pub(super) fn push(&mut self, at: usize, row: LinkRow) {
        let link = &mut self.links[at];
        link.row_count += 1;
        let last = link.rows().end - 1;
        self.rows[last] = row;
    }

    /// Eliminates the body at a place by its rows. `inertia` becomes its inverse; `parent`: place and inertia of the one that it hangs on.
    #[inline(always)]
    pub(super) fn eliminate(
        &mut self,
        at: usize,
        inertia: &mut Block6,
        parent: Option<(u32, &mut Block6)>,
    ) {
        let link = &mut self.links[at];
        let (place, of_parent) = parent.unzip();
        link.parent = place.unwrap_or(NONE);
        let rows = &mut self.rows[link.rows()];
        let entries = &mut self.entries[link.entries()];
        invert(inertia);
        with_known_count!(rows => combine(rows, entries, inertia, of_parent));
    }

    /// Takes what the body at a place has got, and its rows miss, to the one that it hangs on. `x`: by place, `b` so far; of this one
    /// `A^-1 b` then.
    #[inline(always)]
    pub(super) fn pass_on(
        &mut self,
        at: usize,
        inverse: &Block6,
        missing: &[f64],
        x: &mut [Vector6],
    ) {
        let link = self.links[at];
        let rows = &mut self.rows[link.rows()];
        let entries = &self.entries[link.entries()];
        let b = x[at];
        let passed = with_known_count!(rows => load(rows, entries, missing, &b));
        if let Some(parent) = x.get_mut(link.parent as usize) {
            add_scaled(parent, 1.0, &passed);
        }
        x[at] = product(inverse, &b);
    }

    /// Goes back: finds the change of the body at a place and the impulses of its rows.
    #[inline(always)]
    pub(super) fn resolve(&mut self, at: usize, x: &mut [Vector6], impulses: &mut [f64]) {
        let link = self.links[at];
        let rows = &mut self.rows[link.rows()];
        let entries = &self.entries[link.entries()];
        let parent = x.get(link.parent as usize).copied();
        let own = &mut x[at];
        with_known_count!(rows => unload(rows, entries, parent.as_ref(), (own, impulses)));
    }
}

/// How many entries are below the diagonal.
#[inline(always)]
fn entries_of(rows: usize) -> usize {
    rows * rows.saturating_sub(1) / 2
}

/// Combines the rows of a body; `inverse`: of its inertia. Adds to the inertia of the one that it hangs on.
#[inline(always)]
fn combine(
    rows: &mut [LinkRow],
    entries: &mut [f64],
    inverse: &Block6,
    of_parent: Option<&mut Block6>,
) {
    for at in 0..rows.len() {
        let (combined, rest) = rows.split_at_mut(at);
        let row = &mut rest[0];
        let j = row.own;
        row.own = product(inverse, &j);
        let entries = &mut entries[entries_of(at)..entries_of(at + 1)];
        for (before, entry) in combined.iter().zip(entries) {
            *entry = dot(&j, &before.own) * before.inverse;
            add_scaled(&mut row.own, -*entry, &before.own);
            add_scaled(&mut row.other, -*entry, &before.other);
        }
        let pivot = row.softness + dot(&j, &row.own);
        // Positive but for rounding: what is left of it then bears nothing.
        row.inverse = if pivot > 0.0 { pivot.recip() } else { 0.0 };
    }
    if let Some(of_parent) = of_parent {
        let mut sum = *of_parent;
        for row in rows {
            add_outer(&mut sum, row.inverse, &row.other, &row.other);
        }
        *of_parent = sum;
    }
}

/// What the rows of a body pass on: with what they miss, and the `b` of the body.
#[inline(always)]
fn load(rows: &mut [LinkRow], entries: &[f64], missing: &[f64], b: &Vector6) -> Vector6 {
    for at in 0..rows.len() {
        let (combined, rest) = rows.split_at_mut(at);
        let mut lacking = missing[rest[0].row as usize] * rest[0].softness;
        let entries = &entries[entries_of(at)..entries_of(at + 1)];
        for (before, entry) in combined.iter().zip(entries) {
            lacking -= entry * before.impulse;
        }
        rest[0].impulse = lacking;
    }
    let mut passed = [0.0; 6];
    for row in rows {
        row.impulse = (row.impulse - dot(&row.own, b)) * row.inverse;
        add_scaled(&mut passed, row.impulse, &row.other);
    }
    passed
}

/// Changes a body by its rows, and finds their impulses, once the change of the one that it hangs on is known.
#[inline(always)]
fn unload(
    rows: &mut [LinkRow],
    entries: &[f64],
    parent: Option<&Vector6>,
    (own, impulses): (&mut Vector6, &mut [f64]),
) {
    let mut change = *own;
    for row in &mut *rows {
        if let Some(parent) = parent {
            row.impulse -= row.inverse * dot(&row.other, parent);
        }
        add_scaled(&mut change, row.impulse, &row.own);
    }
    *own = change;
    for at in (0..rows.len()).rev() {
        let (before, rest) = rows.split_at_mut(at);
        let impulse = rest[0].impulse;
        let entries = &entries[entries_of(at)..entries_of(at + 1)];
        for (before, entry) in before.iter_mut().zip(entries) {
            before.impulse -= entry * impulse;
        }
        impulses[rest[0].row as usize] = impulse;
    }
}
