//! Contacts in lanes: blocks of eight manifolds that share no body which contacts move.
//!
//! The rows of a point are those of [`rows`](super::rows), but only what a sweep needs is kept: with the velocity of B
//! against A at the point, `dv`, and `K = sum 1/m - r^ I^-1 r^` of both bodies, an impulse `P` at the point changes it by
//! `K P`. A point's friction and normal are solved from one `dv`; the normal sees what friction did through the couplings
//! `t . K n`, and the bodies get the sum of both. That is what solving one row after the other comes to, in half the work.
//!
//! Manifolds are put into blocks in their order: each into the first block behind all blocks that hold an earlier manifold
//! of one of its bodies and that has a lane left. So the sweep over blocks does exactly what the sweep over manifolds in
//! their order would do, whatever the number of lanes. Colouring, which fills blocks better by giving up the order, lets a
//! pyramid of 30 rows creep by 18 cm where this one moves by 3 cm (4 sub-steps): an order from the ground up carries
//! support through a whole stack in one sweep.

use super::bodies::SolverBody;
use super::lanes::{F8, Kernel, LaneWidth, Lanes, WIDTH, run};
use super::rows::{PointRows, Side};
use crate::contact::manifold::{ContactPoint, Manifold};
use crate::math::tangents;
use glam::{Mat3, Vec3};
use std::ops::Range;

/// Marks a lane without a manifold.
pub const NO_MANIFOLD: u32 = u32::MAX;

/// Where a manifold is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Its block.
    pub block: u32,
    /// Its lane.
    pub lane: u16,
    /// Number of its points.
    pub count: u16,
}

/// What the points of eight manifolds share.
#[derive(Clone, Debug)]
pub struct Block {
    /// Numbers of the bodies A and B.
    pub bodies: [[u32; WIDTH]; 2],
    /// Its points: each is the same one of all eight manifolds.
    pub points: Range<usize>,
    /// Indices of the manifolds.
    pub manifolds: [u32; WIDTH],
    /// Lanes in use, which are the first ones.
    pub used: usize,
    /// Unit normal from A to B.
    pub normal: [F8; 3],
    /// The two tangents.
    pub tangents: [[F8; 3]; 2],
    /// Coefficient of friction.
    pub friction: F8,
    /// Coefficient of restitution.
    pub restitution: F8,
    /// 1 / mass of A and B, 1/kg.
    pub inverse_mass: [F8; 2],
    /// Inverse inertia of A and B, world axes: xx, yy, zz, xy, xz, yz, 1/(kg m2).
    pub inverse_inertia: [[F8; 6]; 2],
    /// Overlap that is left alone, m.
    pub slop: F8,
    /// See [`PointRows::speed_scale`].
    pub speed_scale: F8,
}

/// One point of each manifold of a block. Unused lanes have no mass and get no impulse.
#[derive(Clone, Copy, Debug, Default)]
pub struct Point {
    /// From the centres of mass of A and B to the point, world axes, m.
    pub anchors: [[F8; 3]; 2],
    /// Gap along the normal less what displacements of the bodies add to it, m.
    pub separation: F8,
    /// `1 / (n . K n)`, kg.
    pub normal_mass: F8,
    /// The lesser of `1 / (t . K t)`, kg.
    pub tangent_mass: F8,
    /// `t . K n`, 1/kg.
    pub coupling: [F8; 2],
    /// Along the normal and both tangents, N s.
    pub impulse: [F8; 3],
    /// Normal velocity that the point should have, m/s.
    pub wanted: F8,
    /// Sum of the normal impulses of the sub-steps that are over, N s.
    pub total: F8,
}

/// What a point needs where bodies hit each other.
#[derive(Clone, Copy, Debug, Default)]
pub struct Blow {
    /// Normal velocity after the bodies have moved; 0 if the point does not rebound, m/s.
    pub rebound: F8,
    /// Impulses before the blow, N s.
    pub before: [F8; 3],
}

impl Default for Block {
    fn default() -> Self {
        Self {
            bodies: [[0; WIDTH]; 2],
            points: 0..0,
            manifolds: [NO_MANIFOLD; WIDTH],
            used: 0,
            normal: Default::default(),
            tangents: Default::default(),
            friction: F8::default(),
            restitution: F8::default(),
            inverse_mass: Default::default(),
            inverse_inertia: Default::default(),
            slop: F8::default(),
            speed_scale: F8::default(),
        }
    }
}

/// A vector of one lane.
pub fn vector(lanes: &[F8; 3], lane: usize) -> Vec3 {
    Vec3::from(lanes.each_ref().map(|x| x.0[lane]))
}

/// Sets a vector of one lane.
pub fn set_vector(lanes: &mut [F8; 3], lane: usize, value: Vec3) {
    for (lanes, value) in lanes.iter_mut().zip(value.to_array()) {
        lanes.0[lane] = value;
    }
}

/// The six different entries of a symmetric matrix.
pub fn entries(m: &Mat3) -> [f32; 6] {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    [x.x, y.y, z.z, x.y, x.z, y.z]
}

impl Block {
    /// An empty block whose lanes all refer to a body that nothing happens to.
    pub fn empty(idle: u32, first_point: usize) -> Self {
        Self {
            bodies: [[idle; WIDTH]; 2],
            points: first_point..first_point,
            ..Self::default()
        }
    }

    /// Numbers of the two bodies of a lane.
    pub fn pair(&self, lane: usize) -> [u32; 2] {
        self.bodies.map(|side| side[lane])
    }

    /// Sets masses and inertias of a lane.
    pub fn set_sides(&mut self, lane: usize, sides: &[Side; 2]) {
        for (k, side) in sides.iter().enumerate() {
            self.inverse_mass[k].0[lane] = side.inverse_mass;
            let lanes = self.inverse_inertia[k].iter_mut();
            for (lanes, entry) in lanes.zip(entries(&side.inverse_inertia)) {
                lanes.0[lane] = entry;
            }
        }
    }

    /// Masses and inertias of a lane.
    pub fn sides(&self, lane: usize) -> [Side; 2] {
        [0, 1].map(|k| {
            let [xx, yy, zz, xy, xz, yz] = self.inverse_inertia[k].map(|lanes| lanes.0[lane]);
            Side {
                inverse_mass: self.inverse_mass[k].0[lane],
                inverse_inertia: Mat3::from_cols(
                    Vec3::new(xx, xy, xz),
                    Vec3::new(xy, yy, yz),
                    Vec3::new(xz, yz, zz),
                ),
            }
        })
    }

    /// Puts a manifold with its masses into a lane.
    pub fn set_manifold(
        &mut self,
        lane: usize,
        manifold: &Manifold,
        sides: &[Side; 2],
        extent: f32,
        slop: f32,
    ) {
        set_vector(&mut self.normal, lane, manifold.normal);
        let directions = tangents(manifold.normal);
        for (lanes, direction) in self.tangents.iter_mut().zip(directions) {
            set_vector(lanes, lane, direction);
        }
        self.friction.0[lane] = manifold.friction;
        self.restitution.0[lane] = manifold.restitution;
        self.slop.0[lane] = slop * extent;
        self.speed_scale.0[lane] = 1.0 / extent.sqrt();
        self.set_sides(lane, sides);
    }
}

impl Point {
    /// Puts a contact point into a lane of a block, with `share` of its impulses; masses come with [`derive`].
    pub fn set(&mut self, lane: usize, block: &Block, point: &ContactPoint, share: f32) {
        for (lanes, anchor) in self.anchors.iter_mut().zip([point.anchor_a, point.anchor_b]) {
            set_vector(lanes, lane, anchor);
        }
        self.separation.0[lane] = point.separation;
        let along = |k: usize| point.friction_impulse.dot(vector(&block.tangents[k], lane));
        // Without friction nothing must be left in the rows from when there was some.
        let has_friction = block.friction.0[lane] > 0.0;
        let [t1, t2] = [0, 1].map(|k| if has_friction { share * along(k) } else { 0.0 });
        let impulses = [share * point.normal_impulse, t1, t2];
        for (lanes, impulse) in self.impulse.iter_mut().zip(impulses) {
            lanes.0[lane] = impulse;
        }
    }

    /// Velocity of B against A along the normal of a lane, m/s. Of displacements, how far B moved against A, m.
    pub fn normal_velocity(&self, lane: usize, normal: Vec3, [a, b]: [&SolverBody; 2]) -> f32 {
        let [to_a, to_b] = [0, 1].map(|k| vector(&self.anchors[k], lane));
        normal.dot(b.linear - a.linear) + to_b.cross(normal).dot(b.angular)
            - to_a.cross(normal).dot(a.angular)
    }

    /// Moves the point of a lane to the ends of other anchors, with the `gap` that is there now after the displacements.
    pub fn follow(
        &mut self,
        lane: usize,
        normal: Vec3,
        anchors: [Vec3; 2],
        gap: f32,
        displacements: [&SolverBody; 2],
    ) {
        for (lanes, anchor) in self.anchors.iter_mut().zip(anchors) {
            set_vector(lanes, lane, anchor);
        }
        self.separation.0[lane] = gap - self.normal_velocity(lane, normal, displacements);
    }

    /// The point of a lane as rows.
    pub fn rows(&self, lane: usize, block: &Block, rebound: f32) -> PointRows {
        let anchors = [0, 1].map(|k| vector(&self.anchors[k], lane));
        let mut rows = PointRows {
            bodies: block.pair(lane),
            friction: block.friction.0[lane],
            restitution: block.restitution.0[lane],
            separation: self.separation.0[lane],
            slop: block.slop.0[lane],
            speed_scale: block.speed_scale.0[lane],
            rebound,
            total: self.total.0[lane],
            ..PointRows::default()
        };
        rows.set_geometry(vector(&block.normal, lane), anchors, block.sides(lane));
        rows.set_impulses(self.impulse.map(|lanes| lanes.0[lane]));
        rows.normal.wanted = self.wanted.0[lane];
        rows
    }

    /// Writes what the last sub-step found back into the contact point: as impulses of a whole step.
    pub fn store(&self, lane: usize, block: &Block, point: &mut ContactPoint, substeps: u32) {
        let n = substeps as f32;
        let [normal, t1, t2] = self.impulse.map(|lanes| lanes.0[lane]);
        let directions = [0, 1].map(|k| vector(&block.tangents[k], lane));
        point.normal_impulse = n * normal;
        point.friction_impulse = n * (directions[0] * t1 + directions[1] * t2);
        point.total_impulse = self.total.0[lane] + normal;
    }
}

/// Three numbers in each lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct V3<L>(pub(super) [L; 3]);

impl<L: Lanes> V3<L> {
    #[inline(always)]
    pub(super) fn load(from: &[F8; 3]) -> Self {
        Self([L::load(&from[0]), L::load(&from[1]), L::load(&from[2])])
    }

    #[inline(always)]
    pub(super) fn plus(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a + x, b + y, c + z])
    }

    #[inline(always)]
    pub(super) fn minus(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a - x, b - y, c - z])
    }

    #[inline(always)]
    pub(super) fn times(self, factor: L) -> Self {
        let [x, y, z] = self.0;
        Self([x * factor, y * factor, z * factor])
    }

    #[inline(always)]
    pub(super) fn dot(self, other: Self) -> L {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        a * x + b * y + c * z
    }

    #[inline(always)]
    pub(super) fn cross(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }
}

/// The product of a symmetric matrix (entries as in [`entries`]) and a vector.
#[inline(always)]
pub(super) fn symmetric<L: Lanes>(m: &[L; 6], v: V3<L>) -> V3<L> {
    let ([xx, yy, zz, xy, xz, yz], [x, y, z]) = (*m, v.0);
    V3([
        xx * x + xy * y + xz * z,
        xy * x + yy * y + yz * z,
        xz * x + yz * y + zz * z,
    ])
}

#[inline(always)]
pub(super) fn load_six<L: Lanes>(from: &[F8; 6]) -> [L; 6] {
    [
        L::load(&from[0]),
        L::load(&from[1]),
        L::load(&from[2]),
        L::load(&from[3]),
        L::load(&from[4]),
        L::load(&from[5]),
    ]
}

/// Computes masses and couplings of the points from the anchors.
pub fn derive(blocks: &[Block], points: &mut [Point], width: LaneWidth) {
    run(width, Derive { blocks, points });
}

struct Derive<'a> {
    blocks: &'a [Block],
    points: &'a mut [Point],
}

impl Kernel for Derive<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for block in self.blocks {
            let solid = Solid::<L>::load(block);
            let normal = V3::<L>::load(&block.normal);
            let (t1, t2) = (V3::load(&block.tangents[0]), V3::load(&block.tangents[1]));
            for point in &mut self.points[block.points.clone()] {
                let arms = [V3::<L>::load(&point.anchors[0]), V3::load(&point.anchors[1])];
                let along_normal = solid.turns(&arms, normal);
                let of_normal = solid.effect(&arms, normal, &along_normal);
                let of_t1 = solid.effect(&arms, t1, &solid.turns(&arms, t1));
                let of_t2 = solid.effect(&arms, t2, &solid.turns(&arms, t2));
                inverse(solid.mass + of_normal).store(&mut point.normal_mass);
                inverse(solid.mass + of_t1.max(of_t2)).store(&mut point.tangent_mass);
                let of_both = solid.effect(&arms, t1, &along_normal);
                of_both.store(&mut point.coupling[0]);
                let of_both = solid.effect(&arms, t2, &along_normal);
                of_both.store(&mut point.coupling[1]);
            }
        }
    }
}

/// `1 / x`, or 0.
#[inline(always)]
fn inverse<L: Lanes>(x: L) -> L {
    let zero = L::splat(0.0);
    x.if_above(zero, L::splat(1.0) / x, zero)
}

/// Two bodies in each lane.
struct Solid<L> {
    /// Sum of the inverse masses, 1/kg.
    mass: L,
    inertia: [[L; 6]; 2],
}

impl<L: Lanes> Solid<L> {
    #[inline(always)]
    fn load(block: &Block) -> Self {
        let [a, b] = &block.inverse_mass;
        Self {
            mass: L::load(a) + L::load(b),
            inertia: [
                load_six(&block.inverse_inertia[0]),
                load_six(&block.inverse_inertia[1]),
            ],
        }
    }

    /// How both bodies turn by a unit impulse along `d` at the ends of the arms.
    #[inline(always)]
    fn turns(&self, arms: &[V3<L>; 2], d: V3<L>) -> [V3<L>; 2] {
        [
            symmetric(&self.inertia[0], arms[0].cross(d)),
            symmetric(&self.inertia[1], arms[1].cross(d)),
        ]
    }

    /// Velocity along `d` at the ends of the arms of bodies that turn.
    #[inline(always)]
    fn effect(&self, arms: &[V3<L>; 2], d: V3<L>, turns: &[V3<L>; 2]) -> L {
        arms[0].cross(d).dot(turns[0]) + arms[1].cross(d).dot(turns[1])
    }
}
