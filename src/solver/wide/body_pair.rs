//! Two bodies and the frame of their contact in each lane.

use crate::bodies::solver_body::SolverBody;
use crate::simd::lanes::{F8, Lanes, ReadRow};
use crate::simd::vec3::V3;
use crate::solver::config::FrictionModel;
use crate::solver::wide::block::Block;
use std::cell::Cell;

/// Two bodies in each lane.
pub(crate) struct BodyPair<L> {
    columns: [[L; 8]; 2],
}

impl<L: Lanes> BodyPair<L> {
    #[inline(always)]
    pub(crate) fn gather<N: ReadRow>(bodies: &[N], block: &Block) -> Self {
        let [a, b] = &block.bodies;
        Self {
            columns: [L::gather(bodies, a), L::gather(bodies, b)],
        }
    }

    #[inline(always)]
    pub(crate) fn scatter(self, bodies: &[Cell<SolverBody>], block: &Block) {
        let [a, b] = self.columns;
        L::scatter(a, bodies, &block.bodies[0], block.used);
        L::scatter(b, bodies, &block.bodies[1], block.used);
    }

    #[inline(always)]
    pub(crate) fn linear(&self, side: usize) -> V3<L> {
        let c = &self.columns[side];
        V3([c[0], c[1], c[2]])
    }

    #[inline(always)]
    fn angular(&self, side: usize) -> V3<L> {
        let c = &self.columns[side];
        V3([c[4], c[5], c[6]])
    }

    #[inline(always)]
    fn set(&mut self, side: usize, linear: V3<L>, angular: V3<L>) {
        let c = &mut self.columns[side];
        [c[0], c[1], c[2]] = linear.0;
        [c[4], c[5], c[6]] = angular.0;
    }

    /// Velocity of B against A at the ends of the anchors.
    #[inline(always)]
    pub(crate) fn relative(&self, anchors: &[V3<L>; 2]) -> V3<L> {
        let a = self.linear(0).plus(self.angular(0).cross(anchors[0]));
        let b = self.linear(1).plus(self.angular(1).cross(anchors[1]));
        b.minus(a)
    }

    /// Velocity of B against A along `direction` at the ends of the anchors.
    #[inline(always)]
    pub(crate) fn along(&self, direction: V3<L>, anchors: &[V3<L>; 2]) -> L {
        let linear = direction.dot(self.linear(1).minus(self.linear(0)));
        let of_a = anchors[0].cross(direction).dot(self.angular(0));
        let of_b = anchors[1].cross(direction).dot(self.angular(1));
        linear + of_b - of_a
    }

    /// Adds an impulse on B at the ends of the anchors, and its opposite on A.
    #[inline(always)]
    pub(crate) fn push(&mut self, masses: &Masses<L>, anchors: &[V3<L>; 2], impulse: V3<L>) {
        let angular = [anchors[0].cross(impulse), anchors[1].cross(impulse)];
        self.apply(masses, impulse, angular);
    }

    /// Adds an impulse on B, and its opposite on A, with the angular impulses about the centers of mass.
    #[inline(always)]
    pub(crate) fn apply(&mut self, masses: &Masses<L>, impulse: V3<L>, angular: [V3<L>; 2]) {
        let turn_a = symmetric(&masses.inertia[0], angular[0]);
        let turn_b = symmetric(&masses.inertia[1], angular[1]);
        let (shift_a, shift_b) = (impulse.times(masses.mass[0]), impulse.times(masses.mass[1]));
        self.set(
            0,
            self.linear(0).minus(shift_a),
            self.angular(0).minus(turn_a),
        );
        self.set(
            1,
            self.linear(1).plus(shift_b),
            self.angular(1).plus(turn_b),
        );
    }
}

/// Inverse masses and inertias of two bodies in each lane.
pub(crate) struct Masses<L> {
    pub(crate) mass: [L; 2],
    pub(crate) inertia: [[L; 6]; 2],
}

impl<L: Lanes> Masses<L> {
    #[inline(always)]
    pub(crate) fn load(block: &Block) -> Self {
        Self {
            mass: [
                L::load(&block.inverse_mass[0]),
                L::load(&block.inverse_mass[1]),
            ],
            inertia: [
                load_six(&block.inverse_inertia[0]),
                load_six(&block.inverse_inertia[1]),
            ],
        }
    }

    /// How both bodies turn by a unit impulse along `d` at the ends of the arms.
    #[inline(always)]
    pub(crate) fn turns(&self, arms: &[V3<L>; 2], d: V3<L>) -> [V3<L>; 2] {
        [
            symmetric(&self.inertia[0], arms[0].cross(d)),
            symmetric(&self.inertia[1], arms[1].cross(d)),
        ]
    }

    /// Velocity along `d` at the ends of the arms of bodies that turn.
    #[inline(always)]
    pub(crate) fn effect(&self, arms: &[V3<L>; 2], d: V3<L>, turns: &[V3<L>; 2]) -> L {
        arms[0].cross(d).dot(turns[0]) + arms[1].cross(d).dot(turns[1])
    }
}

/// The product of a symmetric matrix (entries as in [`BodyMass`](crate::bodies::solver_body::BodyMass)) and a vector.
#[inline(always)]
fn symmetric<L: Lanes>(m: &[L; 6], v: V3<L>) -> V3<L> {
    let ([xx, yy, zz, xy, xz, yz], [x, y, z]) = (*m, v.0);
    V3([
        xx * x + xy * y + xz * z,
        xy * x + yy * y + yz * z,
        xz * x + yz * y + zz * z,
    ])
}

#[inline(always)]
fn load_six<L: Lanes>(from: &[F8; 6]) -> [L; 6] {
    [
        L::load(&from[0]),
        L::load(&from[1]),
        L::load(&from[2]),
        L::load(&from[3]),
        L::load(&from[4]),
        L::load(&from[5]),
    ]
}

/// Normal and tangents in each lane.
pub(crate) struct Frame<L> {
    pub(crate) normal: V3<L>,
    pub(crate) tangents: [V3<L>; 2],
}

impl<L: Lanes> Frame<L> {
    #[inline(always)]
    pub(crate) fn load(block: &Block) -> Self {
        Self {
            normal: V3::load(&block.normal),
            tangents: [V3::load(&block.tangents[0]), V3::load(&block.tangents[1])],
        }
    }

    /// The parts of a vector along the normal and the tangents.
    #[inline(always)]
    pub(crate) fn components(&self, vector: V3<L>) -> [L; 3] {
        [
            self.normal.dot(vector),
            self.tangents[0].dot(vector),
            self.tangents[1].dot(vector),
        ]
    }

    /// The impulse with the given parts.
    #[inline(always)]
    pub(crate) fn impulse(&self, [normal, t1, t2]: [L; 3]) -> V3<L> {
        let [d1, d2] = &self.tangents;
        let friction = d1.times(t1).plus(d2.times(t2));
        self.normal.times(normal).plus(friction)
    }
}

#[inline(always)]
pub(crate) fn load_three<L: Lanes>(from: &[F8; 3]) -> [L; 3] {
    [L::load(&from[0]), L::load(&from[1]), L::load(&from[2])]
}

#[inline(always)]
pub(crate) fn store_three<L: Lanes>(values: [L; 3], to: &mut [F8; 3]) {
    values[0].store(&mut to[0]);
    values[1].store(&mut to[1]);
    values[2].store(&mut to[2]);
}

/// The nearest friction to `unbounded` within the bound `radius`.
#[inline(always)]
pub(crate) fn project<L: Lanes>(model: FrictionModel, unbounded: [L; 2], radius: L) -> [L; 2] {
    match model {
        FrictionModel::Disc => {
            let (squared, bound) = (
                unbounded[0] * unbounded[0] + unbounded[1] * unbounded[1],
                radius * radius,
            );
            // Where all lanes stick, as they do at rest, nothing has to wait for root and division.
            if !squared.is_any_above(bound) {
                return unbounded;
            }
            let shrink = squared.if_above(bound, radius / squared.sqrt(), L::splat(1.0));
            [unbounded[0] * shrink, unbounded[1] * shrink]
        }
        FrictionModel::Box => {
            let least = L::splat(0.0) - radius;
            [
                unbounded[0].min(radius).max(least),
                unbounded[1].min(radius).max(least),
            ]
        }
    }
}
