//! Velocities that satisfy the rows: Newton's method on which of them act, each round of which is one sparse solution.

use crate::simd::dispatch::run;
use crate::simd::lanes::{Kernel, Lanes};
use crate::solver::joint::links::LinkRow;
use crate::solver::joint::row::{JointRow, RowState};
use crate::solver::joint::system::{JointEndpoint, JointSystem};
use crate::solver::joint::vector6::add_scaled;

/// Most rounds in which it is found out which rows act; in the second half of them none that has been found idle acts again.
const ROUNDS: usize = 12;

impl JointSystem {
    /// Rows that have not been asked yet act if they would alone.
    pub(super) fn guess_states(&mut self) {
        for joint in &self.joints {
            for row in &mut self.rows[joint.rows.clone()] {
                if row.state != RowState::Free {
                    let velocity = row.velocity(joint.velocities(&self.velocities));
                    let state = row.state_at(velocity);
                    self.is_factored &= state == row.state;
                    row.state = state;
                }
            }
        }
    }

    /// Finds impulses and velocities that satisfy all rows.
    pub(crate) fn solve(&mut self) {
        for round in 0..ROUNDS {
            self.missing.clear();
            for joint in &self.joints {
                let velocities = joint.velocities(&self.velocities);
                let rows = self.rows[joint.rows.clone()].iter();
                let missing = rows.map(|row| row.missing_impulse(row.velocity(velocities)));
                self.missing.extend(missing);
            }
            self.apply_missing();
            if !self.renew_states(round >= ROUNDS / 2) {
                break;
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
            let acts_alone = |row: &JointRow| joint.link.is_some() && row.acts_in_link();
            for (side, end) in joint.ends.into_iter().enumerate() {
                let JointEndpoint::Jointed(body) = end else {
                    continue;
                };
                let change = &mut self.changes[position[body as usize] as usize];
                for at in joint.rows.clone() {
                    let row = &self.rows[at];
                    if !acts_alone(row) {
                        add_scaled(change, self.missing[at], &row.jacobian[side]);
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
                let state = row.state_at(row.velocity(velocities));
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
        let (joints, rows) = (&self.joints, &self.rows);
        let (starts, numbers) = (&self.link_starts, &self.link_joints);
        self.factor.factorise(&self.sparsity, |at, links| {
            let own = starts[at] as usize..starts[at + 1] as usize;
            for &number in &numbers[own] {
                let joint = &joints[number as usize];
                let side = joint.link.unwrap_or_default();
                for number in joint.rows.clone() {
                    let row = &rows[number];
                    if row.acts_in_link() {
                        let other = match joint.ends[1 - side] {
                            JointEndpoint::Jointed(_) => &row.jacobian[1 - side],
                            JointEndpoint::Fixed(_) => &[0.0; 6],
                        };
                        let jacobians = [&row.jacobian[side], other];
                        links.push(LinkRow::new(number, row.stiffness, jacobians));
                    }
                }
            }
        });
        self.is_factored = true;
    }
}

impl JointRow {
    /// Whether it holds the body that is eliminated by it.
    #[inline(always)]
    fn acts_in_link(&self) -> bool {
        self.state == RowState::Free && self.stiffness >= f64::MIN_POSITIVE
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
