//! Where Newton's method on which rows act goes round in circles: the same with steps as long as they gain.
//!
//! What is looked for is the least of a convex function of the velocities (`row.rs`), so a step is right in its direction, and where the function is
//! least along it something is gained. Friction about many axes of one joint asks for it, and rows along which nearly nothing moves, as the
//! twist of a joint whose first axes point against each other.

use crate::solver::joint::row::JointRow;
use crate::solver::joint::system::JointSystem;

/// Most steps towards what is least for given impulses of rigid rows, and how often these are renewed: each time what the softness of these
/// rows leaves amiss is multiplied by it.
const STEPS: usize = 30;
const RENEWALS: usize = 2;

/// How often a step is halved in the search for its length.
const BISECTIONS: usize = 40;

/// Share of a slope that rounding leaves.
const FLAT: f64 = 1e-6;

impl JointSystem {
    /// Takes note of where the search begins, if there are rows that may not act.
    pub(super) fn remember_unsettled(&mut self) {
        if self.has_bounds {
            let before = &mut self.rounds;
            before.velocities.clone_from(&self.velocities);
            before.impulses.clear();
            before
                .impulses
                .extend(self.rows.iter().map(|row| row.impulse));
        }
    }

    /// Begins again with the components that are still asked.
    pub(super) fn settle(&mut self) {
        for component in &mut self.components {
            component.was_asked = std::mem::take(&mut component.is_asked);
        }
        for number in 0..self.components.len() {
            if !self.components[number].was_asked {
                continue;
            }
            self.components[number].is_asked = true;
            self.go_back(number);
            for _ in 0..RENEWALS {
                self.descend();
            }
            self.components[number].is_asked = false;
        }
    }

    fn go_back(&mut self, component: usize) {
        let before = &self.rounds;
        let is_own = |of: u32| of as usize == component;
        let bodies = self.velocities.iter_mut().zip(&before.velocities);
        for ((now, before), &of) in bodies.zip(&self.sparsity.components) {
            if is_own(of) {
                *now = *before;
            }
        }
        for joint in self.joints.iter().filter(|joint| is_own(joint.component)) {
            let rows = self.rows[joint.rows.clone()].iter_mut();
            for (row, before) in rows.zip(&before.impulses[joint.rows.clone()]) {
                row.impulse = *before;
            }
        }
    }

    /// Goes to where the function is least, with the impulses that rigid rows have got so far.
    fn descend(&mut self) {
        for joint in &self.joints {
            if self.components[joint.component as usize].is_asked {
                let rows = self.rows[joint.rows.clone()].iter_mut();
                rows.filter(|row| row.is_rigid())
                    .for_each(|row| row.base = row.impulse);
            }
        }
        let mut is_there = false;
        for _ in 0..STEPS {
            if !self.look_ahead() && is_there {
                break;
            }
            self.find_changes();
            self.find_given();
            let share = self.share_of_step();
            self.give(share);
            is_there = share == 1.0;
        }
    }

    /// Has each row act or not as its velocity says, and finds what it misses; whether that is another state than it had.
    fn look_ahead(&mut self) -> bool {
        let mut has_changed = false;
        self.missing.clear();
        self.missing.resize(self.rows.len(), 0.0);
        for joint in &self.joints {
            let component = &mut self.components[joint.component as usize];
            if !component.is_asked {
                continue;
            }
            let velocities = joint.velocities(&self.velocities);
            let rows = self.rows[joint.rows.clone()].iter_mut();
            for (row, missing) in rows.zip(&mut self.missing[joint.rows.clone()]) {
                let wanted = row.wanted(row.velocity(velocities));
                let state = row.state_of(wanted);
                has_changed |= state != row.state;
                component.is_stale |= state != row.factored;
                row.state = state;
                *missing = row.within_bounds(wanted) - row.impulse;
            }
        }
        has_changed
    }

    /// How much of a step leads to where the function is least along it; not more than all.
    fn share_of_step(&self) -> f64 {
        if self.slope(1.0) <= FLAT * self.slope(0.0).abs() {
            return 1.0;
        }
        let (mut from, mut to) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (from + to);
            if self.slope(middle) > 0.0 {
                to = middle;
            } else {
                from = middle;
            }
        }
        to
    }

    /// How steep the function is after a share of the step, J.
    fn slope(&self, share: f64) -> f64 {
        let mut slope = 0.0;
        for joint in &self.joints {
            if !self.is_asked(joint) {
                continue;
            }
            let velocities = joint.velocities(&self.velocities);
            let changes = self.changes_of(joint);
            let rows = self.rows[joint.rows.clone()].iter();
            for (row, given) in rows.zip(&self.missing[joint.rows.clone()]) {
                let change = row.velocity(changes) - row.fixed_velocity;
                let wanted = row.wanted(row.velocity(velocities) + share * change);
                let missing = row.within_bounds(wanted) - (row.impulse + share * given);
                slope -= missing * change;
            }
        }
        slope
    }
}

impl JointRow {
    /// Impulse at a velocity, without bounds, of a row whose `base` is that of a rigid one too.
    fn wanted(&self, velocity: f64) -> f64 {
        self.unbounded_from(self.base, velocity)
    }

    fn within_bounds(&self, impulse: f64) -> f64 {
        impulse.max(self.bounds[0]).min(self.bounds[1])
    }
}
