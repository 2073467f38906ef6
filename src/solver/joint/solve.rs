//! Velocities that satisfy the rows: Newton's method on which of them act, each round of which is one sparse solution.

use crate::simd::dispatch::run;
use crate::simd::lanes::{Kernel, Lanes};
use crate::solver::joint::links::{AddRows, LinkRow, Links};
use crate::solver::joint::row::{JointRow, RowState};
use crate::solver::joint::system::{BatchJoint, JointEndpoint, JointSystem};
use crate::solver::joint::vector6::add_scaled;

/// Most rounds in which it is found out which rows act; in the second half of them none that has been found idle acts again.
const ROUNDS: usize = 12;

impl JointSystem {
    /// Rows that have not been asked yet act if they would alone.
    pub(super) fn guess_states(&mut self) {
        for joint in &self.joints {
            let velocities = joint.velocities(&self.velocities);
            for row in &mut self.rows[joint.rows.clone()] {
                if row.state != RowState::Free {
                    let state = row.state_at(|| row.velocity(velocities));
                    self.is_factored &= state == row.state;
                    row.state = state;
                }
            }
        }
    }

    /// Finds impulses and velocities that satisfy all rows.
    pub(crate) fn solve(&mut self) {
        for round in 0..ROUNDS {
            run(self.width, FindMissing(self));
            self.apply_missing();
            if !self.renew_states(round >= ROUNDS / 2) {
                break;
            }
        }
    }

    #[inline(always)]
    fn find_missing(&mut self) {
        self.missing.resize(self.rows.len(), 0.0);
        for joint in &self.joints {
            let velocities = joint.velocities(&self.velocities);
            let rows = self.rows[joint.rows.clone()].iter();
            for (missing, row) in self.missing[joint.rows.clone()].iter_mut().zip(rows) {
                *missing = row.missing_impulse(|| row.velocity(velocities));
            }
        }
    }

    /// Gives the rows the impulses that they miss, less what they get by each other's.
    pub(crate) fn apply_missing(&mut self) {
        self.find_changes();
        let position = &self.sparsity.position;
        for joint in &self.joints {
            let rows = self.rows[joint.rows.clone()].iter_mut();
            let missing = &self.missing[joint.rows.clone()];
            if joint.link.is_some() {
                for (row, given) in rows.zip(missing) {
                    row.impulse += given;
                }
                continue;
            }
            let of = |end| match end {
                JointEndpoint::Jointed(body) => {
                    Some(&self.changes[position[body as usize] as usize])
                }
                JointEndpoint::Fixed(_) => None,
            };
            let changes = joint.ends.map(of);
            for (row, missing) in rows.zip(missing) {
                let change = row.velocity(changes) - row.fixed_velocity;
                let given = if row.state == RowState::Free {
                    missing - row.stiffness * change
                } else {
                    *missing
                };
                row.impulse += given;
            }
        }
        for (velocity, &at) in self.velocities.iter_mut().zip(position) {
            add_scaled(velocity, 1.0, &self.changes[at as usize]);
        }
    }

    /// Finds the changes of velocities, by place in the order, that the missing impulses of all rows make; rows by
    /// which bodies are eliminated miss nothing then: what they have instead is what they get.
    pub(super) fn find_changes(&mut self) {
        let width = self.width;
        if !self.is_factored {
            run(width, Factorise(self));
        }
        run(width, FindChanges(self));
    }

    #[inline(always)]
    fn solve_for_missing(&mut self) {
        self.changes.clear();
        self.changes.resize(self.bodies.len(), [0.0; 6]);
        let position = &self.sparsity.position;
        for joint in &self.joints {
            let is_link = joint.link.is_some();
            let places = joint.ends.map(|end| match end {
                JointEndpoint::Jointed(body) => Some(position[body as usize] as usize),
                JointEndpoint::Fixed(_) => None,
            });
            for at in joint.rows.clone() {
                let (row, missing) = (&self.rows[at], self.missing[at]);
                // Most rows that do not act miss nothing.
                if missing == 0.0 || is_link && row.acts_in_link() {
                    continue;
                }
                for (place, jacobian) in places.into_iter().zip(&row.jacobian) {
                    if let Some(place) = place {
                        add_scaled(&mut self.changes[place], missing, jacobian);
                    }
                }
            }
        }
        self.factor
            .solve(&self.sparsity, &mut self.changes, &mut self.missing);
    }

    /// Asks each row whether it acts; whether any has changed. With `only_less`, none begins to.
    fn renew_states(&mut self, only_less: bool) -> bool {
        let mut has_changed = false;
        for joint in &self.joints {
            let velocities = joint.velocities(&self.velocities);
            for row in &mut self.rows[joint.rows.clone()] {
                if row.always_acts() {
                    continue;
                }
                let state = row.state_at(|| row.velocity(velocities));
                let begins = state == RowState::Free || row.state != RowState::Free;
                if state != row.state && !(only_less && begins) {
                    row.state = state;
                    has_changed = true;
                }
            }
        }
        self.is_factored &= !has_changed;
        has_changed
    }

    #[inline(always)]
    fn factorise(&mut self) {
        self.factor.clear(&self.sparsity);
        for (body, &at) in self.bodies.iter().zip(&self.sparsity.position) {
            let block = self.factor.diagonal_mut(at as usize);
            for i in 0..3 {
                block[i][i] = body.mass;
                for j in 0..3 {
                    block[3 + i][3 + j] = body.inertia.col(j)[i];
                }
            }
        }
        for joint in self.joints.iter().filter(|joint| joint.link.is_none()) {
            for row in &self.rows[joint.rows.clone()] {
                if row.state != RowState::Free {
                    continue;
                }
                for (side, end) in joint.ends.into_iter().enumerate() {
                    if let JointEndpoint::Jointed(body) = end {
                        let at = self.sparsity.position[body as usize] as usize;
                        self.factor.add(at, row.stiffness, &row.jacobian[side]);
                    }
                }
                if let Some(edge) = joint.edge {
                    let [a, b] = &row.jacobian;
                    self.factor.couple(edge, row.stiffness, [a, b]);
                }
            }
        }
        let rows = RowsOfLinks {
            joints: &self.joints,
            rows: &self.rows,
            starts: &self.link_starts,
            numbers: &self.link_joints,
        };
        self.factor.factorise(&self.sparsity, &rows);
        self.is_factored = true;
    }
}

/// The rows by which bodies are eliminated.
struct RowsOfLinks<'a> {
    joints: &'a [BatchJoint],
    rows: &'a [JointRow],
    /// By place: where its joints begin, and the end of all; and these.
    starts: &'a [u32],
    numbers: &'a [u32],
}

impl AddRows for RowsOfLinks<'_> {
    #[inline(always)]
    fn add_rows(&self, at: usize, links: &mut Links) {
        let own = self.starts[at] as usize..self.starts[at + 1] as usize;
        for &number in &self.numbers[own] {
            let joint = &self.joints[number as usize];
            let side = joint.link.unwrap_or_default();
            let is_alone = matches!(joint.ends[1 - side], JointEndpoint::Fixed(_));
            for number in joint.rows.clone() {
                let row = &self.rows[number];
                if row.acts_in_link() {
                    let mut jacobians = [row.jacobian[side], row.jacobian[1 - side]];
                    if is_alone {
                        jacobians[1] = [0.0; 6];
                    }
                    links.push(LinkRow::new(number, row.stiffness, jacobians));
                }
            }
        }
    }
}

impl JointRow {
    /// Whether it holds the body that is eliminated by it.
    #[inline(always)]
    fn acts_in_link(&self) -> bool {
        self.state == RowState::Free && self.stiffness >= f64::MIN_POSITIVE
    }
}

/// Finds what rows miss.
struct FindMissing<'a>(&'a mut JointSystem);

impl Kernel for FindMissing<'_> {
    type Output = ();
    const NEEDS_32_REGISTERS: bool = false;

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.0.find_missing();
    }
}

/// Makes the factor.
struct Factorise<'a>(&'a mut JointSystem);

impl Kernel for Factorise<'_> {
    type Output = ();
    const NEEDS_32_REGISTERS: bool = false;

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.0.factorise();
    }
}

/// Solves with it.
struct FindChanges<'a>(&'a mut JointSystem);

impl Kernel for FindChanges<'_> {
    type Output = ();
    const NEEDS_32_REGISTERS: bool = false;

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.0.solve_for_missing();
    }
}
