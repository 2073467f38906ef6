//! Velocities that satisfy the rows: Newton's method on which of them act, each round of which is one sparse solution.

use crate::simd::dispatch::run;
use crate::simd::lanes::{Kernel, Lanes};
use crate::solver::joint::links::{AddRows, LinkRow, Links};
use crate::solver::joint::row::{JointRow, RowState};
use crate::solver::joint::system::{BatchJoint, JointEndpoint, JointSystem};
use crate::solver::joint::vector6::{Vector6, add_scaled};

/// Most rounds in which it is found out which rows act, before each is made to gain something.
const ROUNDS: usize = 8;

impl JointSystem {
    /// Rows that do not act yet do if they would alone.
    #[inline(always)]
    pub(super) fn guess_states(&mut self) {
        for joint in &self.joints {
            let velocities = joint.velocities(&self.velocities);
            let is_stale = &mut self.components[joint.component as usize].is_stale;
            for row in &mut self.rows[joint.rows.clone()] {
                if row.state != RowState::Free {
                    row.state = row.state_at(|| row.velocity(velocities));
                    *is_stale |= row.state != row.factored;
                }
            }
        }
    }

    /// Finds impulses and velocities that satisfy all rows.
    pub(crate) fn solve(&mut self) {
        for component in &mut self.components {
            component.is_asked = true;
            component.has_let_go = false;
        }
        self.remember_unsettled();
        for _ in 0..ROUNDS {
            run(self.width, FindMissing(self));
            self.apply_missing();
            if !self.renew_states() && !self.ask_contradicted() {
                return;
            }
        }
        self.settle();
    }

    /// Asks components again in which a rigid row was let go that others contradicted; whether there are any. While friction, say, held a body that
    /// was to come back from the end of its range, both got what is half of the speed times their stiffness, and what the one that acts had got of
    /// that was still in its way: such a body came back with half as much speed again.
    fn ask_contradicted(&mut self) -> bool {
        if !self.components.iter().any(|component| component.has_let_go) {
            return false;
        }
        let mut any = false;
        for joint in &self.joints {
            let component = &mut self.components[joint.component as usize];
            if !component.has_let_go {
                continue;
            }
            let velocities = joint.velocities(&self.velocities);
            let mut rows = self.rows[joint.rows.clone()].iter();
            if rows.any(|row| row.is_contradicted(velocities)) {
                component.is_asked = true;
                any = true;
            }
        }
        for component in &mut self.components {
            component.has_let_go = false;
        }
        any
    }

    #[inline(always)]
    fn find_missing(&mut self) {
        self.missing.resize(self.rows.len(), 0.0);
        for joint in &self.joints {
            if !self.is_asked(joint) {
                continue;
            }
            let velocities = joint.velocities(&self.velocities);
            let rows = self.rows[joint.rows.clone()].iter();
            for (missing, row) in self.missing[joint.rows.clone()].iter_mut().zip(rows) {
                *missing = row.missing_impulse(|| row.velocity(velocities));
            }
        }
    }

    /// Gives the rows that are asked the impulses that they miss, less what they get by each other's.
    pub(crate) fn apply_missing(&mut self) {
        self.find_changes();
        self.find_given();
        self.give(1.0);
    }

    /// Has what rows miss be what they are given, once it is known how velocities change.
    pub(super) fn find_given(&mut self) {
        let mut given = std::mem::take(&mut self.missing);
        for joint in &self.joints {
            if joint.link.is_some() || !self.is_asked(joint) {
                continue;
            }
            let changes = self.changes_of(joint);
            let rows = self.rows[joint.rows.clone()].iter();
            for (row, given) in rows.zip(&mut given[joint.rows.clone()]) {
                if row.state == RowState::Free {
                    let change = row.velocity(changes) - row.fixed_velocity;
                    *given -= row.stiffness * change;
                }
            }
        }
        self.missing = given;
    }

    /// Gives rows and bodies a share of what has been found.
    pub(super) fn give(&mut self, share: f64) {
        run(self.width, Give(self, share));
    }

    #[inline(always)]
    fn give_share(&mut self, share: f64) {
        let components = &self.components;
        let asked = |joint: &&BatchJoint| components[joint.component as usize].is_asked;
        for joint in self.joints.iter().filter(asked) {
            let rows = self.rows[joint.rows.clone()].iter_mut();
            for (row, given) in rows.zip(&self.missing[joint.rows.clone()]) {
                row.impulse += share * given;
            }
        }
        for (velocity, &at) in self.velocities.iter_mut().zip(&self.sparsity.position) {
            add_scaled(velocity, share, &self.changes[at as usize]);
        }
    }

    /// How the velocities of a joint's bodies change.
    pub(super) fn changes_of(&self, joint: &BatchJoint) -> [Option<&Vector6>; 2] {
        let position = &self.sparsity.position;
        joint.ends.map(|end| match end {
            JointEndpoint::Jointed(body) => Some(&self.changes[position[body as usize] as usize]),
            JointEndpoint::Fixed(_) => None,
        })
    }

    /// Finds the changes of velocities, by place in the order, that the missing impulses of all rows make; rows by
    /// which bodies are eliminated miss nothing then: what they have instead is what they get.
    pub(super) fn find_changes(&mut self) {
        self.renew_factor();
        run(self.width, FindChanges(self));
    }

    /// Makes the factor of what is asked, where it is none of the rows any more.
    pub(super) fn renew_factor(&mut self) {
        let mut components = self.components.iter();
        if components.any(|component| component.is_asked && component.is_stale) {
            run(self.width, Factorise(self));
        }
    }

    #[inline(always)]
    fn solve_for_missing(&mut self) {
        self.changes.clear();
        self.changes.resize(self.bodies.len(), [0.0; 6]);
        let position = &self.sparsity.position;
        for joint in &self.joints {
            if !self.is_asked(joint) {
                continue;
            }
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
        self.solve_for_changes();
    }

    /// Solves for the changes of velocities, and the impulses of rows by which bodies are eliminated, in the place of what is given and missing.
    #[inline(always)]
    pub(super) fn solve_for_changes(&mut self) {
        let (sparsity, components) = (&self.sparsity, &self.components);
        let is_asked = |at: usize| components[sparsity.component_at(at)].is_asked;
        let (changes, missing) = (&mut self.changes, &mut self.missing);
        self.factor.solve(sparsity, changes, missing, is_asked);
    }

    /// Asks each row whether it acts; only components of which any has changed are asked further, if there are some.
    fn renew_states(&mut self) -> bool {
        for component in &mut self.components {
            component.was_asked = std::mem::take(&mut component.is_asked);
        }
        if !self.has_bounds {
            return false;
        }
        let mut has_changed = false;
        for joint in &self.joints {
            let component = &mut self.components[joint.component as usize];
            if !component.was_asked {
                continue;
            }
            let velocities = joint.velocities(&self.velocities);
            for row in &mut self.rows[joint.rows.clone()] {
                if row.always_acts() {
                    continue;
                }
                let state = row.state_at(|| row.velocity(velocities));
                if state != row.state {
                    component.has_let_go |= row.state == RowState::Free && row.is_rigid();
                    row.state = state;
                    component.is_stale |= state != row.factored;
                    component.is_asked = true;
                    has_changed = true;
                }
            }
        }
        has_changed
    }

    /// Makes the factor of what is asked and has changed.
    #[inline(always)]
    fn factorise(&mut self) {
        let (sparsity, components) = (&self.sparsity, &mut self.components);
        for component in components.iter_mut() {
            component.is_renewed = component.is_asked && component.is_stale;
            component.is_stale &= !component.is_renewed;
        }
        let is_renewed = |at: usize| components[sparsity.component_at(at)].is_renewed;
        for (body, &at) in self.bodies.iter().zip(&sparsity.position) {
            if is_renewed(at as usize) {
                self.factor
                    .begin(at as usize, sparsity, body.spatial_inertia());
            }
        }
        for joint in &self.joints {
            if !components[joint.component as usize].is_renewed {
                continue;
            }
            for row in &mut self.rows[joint.rows.clone()] {
                row.factored = row.state;
                if row.state != RowState::Free || joint.link.is_some() {
                    continue;
                }
                for (side, end) in joint.ends.into_iter().enumerate() {
                    if let JointEndpoint::Jointed(body) = end {
                        let at = sparsity.position[body as usize] as usize;
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
        self.factor.factorise(sparsity, &rows, is_renewed);
    }

    /// Makes room for a factor, whichever rows act.
    pub(super) fn lay_out_factor(&mut self) {
        let rows = RowsOfLinks {
            joints: &self.joints,
            rows: &self.rows,
            starts: &self.link_starts,
            numbers: &self.link_joints,
        };
        self.factor.lay_out(&self.sparsity, &rows);
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

impl RowsOfLinks<'_> {
    /// The joints of the body at a place.
    #[inline(always)]
    fn joints_at(&self, at: usize) -> impl Iterator<Item = &BatchJoint> {
        let own = self.starts[at] as usize..self.starts[at + 1] as usize;
        let numbers = self.numbers[own].iter();
        numbers.map(|&number| &self.joints[number as usize])
    }
}

impl AddRows for RowsOfLinks<'_> {
    #[inline(always)]
    fn add_rows(&self, at: usize, links: &mut Links) {
        for joint in self.joints_at(at) {
            let side = joint.link.unwrap_or_default();
            let is_alone = matches!(joint.ends[1 - side], JointEndpoint::Fixed(_));
            for number in joint.rows.clone() {
                let row = &self.rows[number];
                if row.acts_in_link() {
                    let mut jacobians = [row.jacobian[side], row.jacobian[1 - side]];
                    if is_alone {
                        jacobians[1] = [0.0; 6];
                    }
                    links.push(at, LinkRow::new(number, row.stiffness, jacobians));
                }
            }
        }
    }

    fn most_rows(&self, at: usize) -> usize {
        self.joints_at(at).map(|joint| joint.rows.len()).sum()
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

/// Gives a share of what has been found.
struct Give<'a>(&'a mut JointSystem, f64);

impl Kernel for Give<'_> {
    type Output = ();
    const NEEDS_32_REGISTERS: bool = false;

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.0.give_share(self.1);
    }
}
