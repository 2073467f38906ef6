//! Gauss-Seidel sweeps with momentum: Nesterov's accelerated gradients with a sweep in place of the gradient step.
//!
//! A sweep alone takes away the errors between neighbors at once, those that stretch over many contacts slowly: what it
//! changes then points the same way sweep after sweep. So each sweep starts from impulses that have gone on in that
//! direction,
//!
//! ```text
//! x_(k+1) = sweep(P(x_k + beta_k (x_k - x_(k-1)))),   beta_k = min(k / (k + 3), 0.7)
//! ```
//!
//! - `x_k`: impulses after `k` sweeps, N s; `beta_0 = 0`
//! - `P`: projection of each contact on what its impulses may be, so that no sweep starts from a pull or beyond friction
//!
//! Momentum can overshoot. When a sweep has to change the velocities more than the one before, the direction was wrong: `k`
//! starts at 0 again, so the sweep that follows is a plain one, which cannot make things worse. The last word is always
//! that of a sweep, never of an extrapolation.
//!
//! Nonsmooth nonlinear conjugate gradients (Silcowitz-Hansen, Niebe, Erleben 2010), which take the weight from the lengths
//! of two changes, solved no more of 41 problems to 1 % at 8, 16 and 32 sweeps (41, 56 and 66 %; these 49, 56 and 71 %; plain
//! sweeps 39, 51 and 59 %), and cost one more pass.
//!
//! # References
//! Nesterov, "A Method for Solving the Convex Programming Problem with Convergence Rate O(1/k^2)", 1983; O'Donoghue and
//! Candes, "Adaptive Restart for Accelerated Gradient Schemes", Foundations of Computational Mathematics 15, 2015; Mazhar,
//! Heyn, Negrut and Tasora, "Using Nesterov's Method to Accelerate Multibody Dynamics with Friction and Contact", 2015.

use crate::bodies::solver_body::SolverBody;
use crate::solver::config::FrictionModel;
use crate::solver::rows::contact_rows::PointRows;
use crate::solver::rows::mlcp;
use crate::solver::rows::pgs;
use crate::solver::rows::pgs::Real;
use glam::Vec2;
use std::ops::{Add, Div};

/// Largest weight of the momentum. Without a bound up to 5 more of 100 problems from files are solved in 32 to 128 sweeps; but
/// columns on their way to rest, where each sub-step is a slightly different problem, took up to a fifth more sweeps.
const MAX_WEIGHT: f32 = 0.7;

/// What momentum calculates with.
pub trait Number: Real + Add<Output = Self> + Div<Output = Self> + PartialOrd + From<f32> {}

impl<T: Real + Add<Output = T> + Div<Output = T> + PartialOrd + From<f32>> Number for T {}

/// A problem that is solved by sweeps over its contacts: impulses and the velocities that follow from them.
///
/// The same method runs in single precision on the bodies of a step and in double precision on problems from files.
pub trait ImpulseSystem {
    /// The numbers it calculates with.
    type Real: Number;
    /// A velocity, or those of a body.
    type Velocity: Copy;
    /// Number of contacts.
    fn count(&self) -> usize;
    /// Impulses of a contact along its normal and tangents, N s; zero where it has fewer than two.
    fn impulses(&self, contact: usize) -> [Self::Real; 3];
    /// The velocities that the impulses have led to.
    fn velocities(&mut self) -> &mut [Self::Velocity];
    /// `now + weight (now - last)`.
    fn ahead(now: Self::Velocity, last: Self::Velocity, weight: Self::Real) -> Self::Velocity;
    /// Sets the impulses of a contact to the nearest to `impulses` that it may have. The velocities are those with
    /// `impulses`; what the contact may not have is taken out of them.
    fn place(&mut self, contact: usize, impulses: [Self::Real; 3]);
    /// Solves all rows once; returns the largest velocity change of a row.
    fn sweep(&mut self) -> Self::Real;
}

/// Where impulses and velocities were, and how far the momentum has grown; buffers are reused.
#[derive(Clone, Debug, Default)]
pub struct Momentum<T, V> {
    /// `x_(k-1)` by contact, N s.
    impulses: Vec<[T; 3]>,
    /// The velocities with them.
    velocities: Vec<V>,
    pace: AccelerationWeight<T>,
}

/// How far the momentum has grown.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct AccelerationWeight<T> {
    /// `k`, counted anew from every restart.
    kept: u16,
    /// What the last sweep changed.
    change: T,
}

impl<T: Number> AccelerationWeight<T> {
    /// Forgets the sweeps before.
    pub(crate) fn restart(&mut self) {
        self.kept = 0;
    }

    /// Weight `beta_k` of the momentum before the next sweep; `None` where there is none yet.
    pub(crate) fn weight(&self) -> Option<T> {
        let k = T::from(f32::from(self.kept));
        (self.kept > 0).then(|| (k / (k + T::from(3.0))).min(T::from(MAX_WEIGHT)))
    }

    /// Takes note of the largest velocity change of a sweep.
    pub(crate) fn note(&mut self, change: T) {
        let is_worse = self.kept > 1 && change > self.change;
        self.kept = if is_worse { 0 } else { self.kept + 1 };
        self.change = change;
    }
}

impl<T: Number, V: Copy> Momentum<T, V> {
    /// Forgets the problem solved before.
    pub fn restart(&mut self) {
        self.pace.restart();
    }

    /// One sweep, from where the last ones were going; returns the largest velocity change of a row.
    pub fn sweep<C: ImpulseSystem<Real = T, Velocity = V>>(&mut self, contacts: &mut C) -> T {
        match self.pace.weight() {
            None => self.remember(contacts),
            Some(weight) => self.extrapolate(contacts, weight),
        }
        let change = contacts.sweep();
        self.pace.note(change);
        change
    }

    fn remember<C: ImpulseSystem<Real = T, Velocity = V>>(&mut self, contacts: &mut C) {
        self.impulses.clear();
        let impulses = (0..contacts.count()).map(|i| contacts.impulses(i));
        self.impulses.extend(impulses);
        self.velocities.clear();
        self.velocities.extend_from_slice(contacts.velocities());
    }

    /// Moves the impulses on in the direction of their last change. The velocities are linear in them, so they move on alike;
    /// only where impulses are clipped do the rows have to be looked at.
    fn extrapolate<C: ImpulseSystem<Real = T, Velocity = V>>(
        &mut self,
        contacts: &mut C,
        weight: T,
    ) {
        for (velocity, last) in contacts.velocities().iter_mut().zip(&mut self.velocities) {
            let now = *velocity;
            *velocity = C::ahead(now, *last, weight);
            *last = now;
        }
        for (i, last) in self.impulses.iter_mut().enumerate() {
            let now = contacts.impulses(i);
            contacts.place(
                i,
                [0, 1, 2].map(|row| now[row] + weight * (now[row] - last[row])),
            );
            *last = now;
        }
    }
}

/// The points of a step with their bodies, and what solves them once.
#[derive(Debug)]
pub struct PointContacts<'a, F> {
    /// Rows of the points.
    pub rows: &'a mut [PointRows],
    /// Velocities of the bodies that the numbers in the rows refer to.
    pub bodies: &'a mut [SolverBody],
    /// Shape of the friction bound.
    pub friction_model: FrictionModel,
    /// One sweep; returns the largest velocity change of a row.
    pub sweep: F,
}

impl<F: FnMut(&mut [PointRows], &mut [SolverBody]) -> f32> ImpulseSystem for PointContacts<'_, F> {
    type Real = f32;
    type Velocity = SolverBody;

    fn count(&self) -> usize {
        self.rows.len()
    }

    fn impulses(&self, contact: usize) -> [f32; 3] {
        self.rows[contact].impulses()
    }

    fn velocities(&mut self) -> &mut [SolverBody] {
        self.bodies
    }

    #[inline]
    fn ahead(now: SolverBody, last: SolverBody, weight: f32) -> SolverBody {
        SolverBody {
            linear: now.linear + weight * (now.linear - last.linear),
            angular: now.angular + weight * (now.angular - last.angular),
            ..now
        }
    }

    #[inline]
    fn place(&mut self, contact: usize, unbounded: [f32; 3]) {
        let point = &mut self.rows[contact];
        let normal = unbounded[0].max(point.min_normal());
        let radius = point.friction_bound(normal);
        let unbounded_friction = Vec2::new(unbounded[1], unbounded[2]);
        let tangents = match self.friction_model {
            FrictionModel::Disc => mlcp::project_to_disc(unbounded_friction, radius),
            FrictionModel::Box => {
                unbounded_friction.clamp(Vec2::splat(-radius), Vec2::splat(radius))
            }
        };
        point.set_impulses([normal, tangents.x, tangents.y]);
        if normal != unbounded[0] || tangents != unbounded_friction {
            let [a, b] = pgs::pair(self.bodies, point.bodies);
            for (row, unbounded) in point.rows().into_iter().zip(unbounded) {
                row.apply(row.impulse - unbounded, a, b);
            }
        }
    }

    fn sweep(&mut self) -> f32 {
        (self.sweep)(self.rows, self.bodies)
    }
}
