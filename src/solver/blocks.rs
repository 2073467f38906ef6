//! Contacts in lanes: blocks of eight manifolds that share no body which contacts move.
//!
//! The rows of a point are those of [`rows`](super::rows), but only what a sweep needs is kept: with the velocity of B
//! against A at the point, `dv`, and `K = sum 1/m - r^ I^-1 r^` of both bodies, an impulse `P` at the point changes it by
//! `K P`. A point's friction and normal are solved from one `dv`; the normal sees what friction did through the couplings
//! `t . K n`, and the bodies get the sum of both. That is what solving one row after the other comes to, in half the work.
//!
//! Manifolds are put into blocks so that those which share a body keep their order ([`schedule`](super::schedule)): the sweep
//! over blocks does exactly what the sweep over manifolds in their order would do, whatever the number of lanes. Colouring,
//! which fills blocks better in narrow structures by giving up the order, lets a pyramid of 30 rows creep by 18 cm where this
//! one moves by 3 cm (4 sub-steps): an order from the ground up carries support through a whole stack in one sweep.

use super::bodies::SolverBody;
use super::lanes::{F8, Kernel, LaneWidth, Lanes, WIDTH, run};
use super::rows::{PointRows, Side};
use super::ties::Tie;
use super::triple::V3;
use crate::contact::manifold::{ContactPoint, MAX_POINTS, Manifold};
use crate::prefetch::prefetch;
use glam::{Mat3, Vec3};
use std::ops::Range;

/// Marks a lane without a manifold.
pub const NO_MANIFOLD: u32 = u32::MAX;

/// How many blocks ahead the manifolds that they are filled from are asked for.
const AHEAD: usize = 2;

/// Gap of points that are not there, m: far more than anything closes in a step.
pub(super) const FAR: f32 = 1e18;

/// What does not change when a body moves, and its inertia: xx, yy, zz, xy, xz and yz of the inverse tensor (world axes,
/// 1/(kg m2)), 1 / mass (1/kg), least extent (m).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Solid(pub F8);

impl Solid {
    /// From its parts; `extent`, m.
    pub fn new(inverse_mass: f32, inverse_inertia: &Mat3, extent: f32) -> Self {
        let (x, y, z) = (
            inverse_inertia.x_axis,
            inverse_inertia.y_axis,
            inverse_inertia.z_axis,
        );
        let six = [x.x, y.y, z.z, x.y, x.z, y.z];
        let [xx, yy, zz, xy, xz, yz] = six;
        Self(F8([xx, yy, zz, xy, xz, yz, inverse_mass, extent]))
    }

    /// The inverse tensor.
    pub fn inverse_inertia(&self) -> Mat3 {
        let [xx, yy, zz, xy, xz, yz, ..] = self.0.0;
        Mat3::from_cols(
            Vec3::new(xx, xy, xz),
            Vec3::new(xy, yy, yz),
            Vec3::new(xz, yz, zz),
        )
    }

    /// 1 / mass, 1/kg.
    pub fn inverse_mass(&self) -> f32 {
        self.0.0[6]
    }

    /// Least extent, m.
    pub fn extent(&self) -> f32 {
        self.0.0[7]
    }

    /// Sets the inverse tensor.
    pub fn set_inverse_inertia(&mut self, inverse_inertia: &Mat3) {
        *self = Self::new(self.inverse_mass(), inverse_inertia, self.extent());
    }
}

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

impl Block {
    /// Empties the lanes: all refer to a body that nothing happens to.
    pub fn clear(&mut self, idle: u32, points: Range<usize>) {
        self.bodies = [[idle; WIDTH]; 2];
        self.manifolds = [NO_MANIFOLD; WIDTH];
        self.points = points;
        self.used = 0;
    }

    /// Names manifold and bodies of the next lane.
    pub fn put(&mut self, lane: usize, manifold: u32, [a, b]: [u32; 2]) {
        self.manifolds[lane] = manifold;
        (self.bodies[0][lane], self.bodies[1][lane]) = (a, b);
        self.used += 1;
    }

    /// Numbers of the two bodies of a lane.
    pub fn pair(&self, lane: usize) -> [u32; 2] {
        self.bodies.map(|side| side[lane])
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
}

impl Point {
    /// Velocity of B against A along the normal of a lane, or another direction, m/s. Of displacements, how far B moved
    /// against A, m.
    pub fn normal_velocity(&self, lane: usize, normal: Vec3, [a, b]: [&SolverBody; 2]) -> f32 {
        let [to_a, to_b] = [0, 1].map(|k| vector(&self.anchors[k], lane));
        normal.dot(b.linear - a.linear) + to_b.cross(normal).dot(b.angular)
            - to_a.cross(normal).dot(a.angular)
    }

    /// The point of a lane as rows.
    pub fn rows(&self, lane: usize, block: &Block, tie: Option<&Tie>, rebound: f32) -> PointRows {
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
            adhesion: tie.map_or(0.0, |tie| tie.adhesion.0[lane]),
            shear: tie.map_or(0.0, |tie| tie.shear.0[lane]),
            ..PointRows::default()
        };
        rows.set_geometry(vector(&block.normal, lane), anchors, block.sides(lane));
        rows.set_impulses(self.impulse.map(|lanes| lanes.0[lane]));
        rows.normal.wanted = self.wanted.0[lane];
        for (k, row) in rows.tangents.iter_mut().enumerate() {
            row.wanted = tie.map_or(0.0, |tie| tie.wanted[k].0[lane]);
        }
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

/// The product of a symmetric matrix (entries as in [`Solid`]) and a vector.
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

#[inline(always)]
pub(super) fn load_anchors<L: Lanes>(point: &Point) -> [V3<L>; 2] {
    [V3::load(&point.anchors[0]), V3::load(&point.anchors[1])]
}

/// What blocks are filled from.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// All manifolds of the step.
    pub manifolds: &'a [Manifold],
    /// By number of a body.
    pub solids: &'a [Solid],
    /// Part of the impulses of the last step that a sub-step starts from.
    pub share: f32,
    /// Overlap that is left alone, as a share of the least extent.
    pub slop: f32,
}

/// Fills blocks, whose bodies and manifolds are known, and their points, which are all of `points`; masses come with
/// [`derive()`].
pub fn fill(blocks: &mut [Block], points: &mut [Point], source: Source<'_>, width: LaneWidth) {
    let kernel = Fill {
        blocks,
        points,
        source,
    };
    run(width, kernel);
}

/// Computes masses and couplings of the points of blocks, which are all of `points`, from anchors and inertias.
pub fn derive(blocks: &mut [Block], points: &mut [Point], solids: &[Solid], width: LaneWidth) {
    let all = std::iter::repeat(true);
    derive_stale(blocks, points, solids, all, width);
}

/// As [`derive()`], for those blocks of which `is_stale` says so, one after the other.
pub(super) fn derive_stale(
    blocks: &mut [Block],
    points: &mut [Point],
    solids: &[Solid],
    is_stale: impl Iterator<Item = bool>,
    width: LaneWidth,
) {
    let kernel = Derive {
        blocks,
        points,
        solids,
        is_stale,
    };
    run(width, kernel);
}

struct Fill<'a> {
    blocks: &'a mut [Block],
    points: &'a mut [Point],
    source: Source<'a>,
}

/// A point that is not there.
const NO_POINT: F8 = F8([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, FAR, 0.0]);

/// Anchors and gap.
#[inline(always)]
fn geometry_row(point: &ContactPoint) -> F8 {
    let (a, b) = (point.anchor_a, point.anchor_b);
    F8([a.x, a.y, a.z, b.x, b.y, b.z, point.separation, 0.0])
}

/// Impulses.
#[inline(always)]
fn impulse_row(point: &ContactPoint) -> F8 {
    let (n, t) = (point.normal_impulse, point.friction_impulse);
    F8([n, t.x, t.y, t.z, 0.0, 0.0, 0.0, 0.0])
}

impl Kernel for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let mut rest = self.points;
        for i in 0..self.blocks.len() {
            if let Some(next) = self.blocks.get(i + AHEAD) {
                let next = &next.manifolds[..next.used];
                next.iter()
                    .for_each(|&m| prefetch(&self.source.manifolds[m as usize]));
            }
            let block = &mut self.blocks[i];
            let (points, after) = rest.split_at_mut(block.points.len());
            rest = after;
            fill_block::<L>(block, points, &self.source);
        }
    }
}

#[inline(always)]
fn fill_block<L: Lanes>(block: &mut Block, points: &mut [Point], source: &Source<'_>) {
    let mut headers = [F8::default(); WIDTH];
    let mut geometry = [[NO_POINT; WIDTH]; MAX_POINTS];
    let mut impulses = [[F8::default(); WIDTH]; MAX_POINTS];
    for lane in 0..block.used {
        let manifold = &source.manifolds[block.manifolds[lane] as usize];
        let (n, mu, e) = (manifold.normal, manifold.friction, manifold.restitution);
        headers[lane] = F8([n.x, n.y, n.z, mu, e, 0.0, 0.0, 0.0]);
        for (k, point) in manifold.points().iter().enumerate() {
            geometry[k][lane] = geometry_row(point);
            impulses[k][lane] = impulse_row(point);
        }
    }
    let [x, y, z, friction, restitution, ..] = L::columns(&headers);
    let normal = V3([x, y, z]);
    let [t1, t2] = tangents(normal);
    normal.store(&mut block.normal);
    t1.store(&mut block.tangents[0]);
    t2.store(&mut block.tangents[1]);
    friction.store(&mut block.friction);
    restitution.store(&mut block.restitution);
    let extents = [0, 1].map(|side| source.extents(&block.bodies[side]));
    let extent = L::load(&extents[0]).min(L::load(&extents[1]));
    (L::splat(source.slop) * extent).store(&mut block.slop);
    (L::splat(1.0) / extent.sqrt()).store(&mut block.speed_scale);
    for (k, point) in points.iter_mut().enumerate() {
        let [ax, ay, az, bx, by, bz, gap, _] = L::columns(&geometry[k]);
        V3([ax, ay, az]).store(&mut point.anchors[0]);
        V3([bx, by, bz]).store(&mut point.anchors[1]);
        gap.store(&mut point.separation);
        let [n, fx, fy, fz, ..] = L::columns(&impulses[k]);
        let (share, zero) = (L::splat(source.share), L::splat(0.0));
        let tangential = V3([fx, fy, fz]).times(share);
        // Without friction nothing must be left in the rows from when there was some.
        let along = [tangential.dot(t1), tangential.dot(t2)];
        (n * share).store(&mut point.impulse[0]);
        let [f1, f2] = along;
        friction
            .if_above(zero, f1, zero)
            .store(&mut point.impulse[1]);
        friction
            .if_above(zero, f2, zero)
            .store(&mut point.impulse[2]);
        zero.store(&mut point.wanted);
        zero.store(&mut point.total);
    }
}

impl Source<'_> {
    /// Least extents of the bodies in lanes.
    fn extents(&self, bodies: &[u32; WIDTH]) -> F8 {
        F8(bodies.map(|body| self.solids[body as usize].extent()))
    }
}

/// Two unit vectors that form a right-handed frame with the unit vector `n`: [`tangents`](crate::math::tangents) in lanes.
#[inline(always)]
fn tangents<L: Lanes>(n: V3<L>) -> [V3<L>; 2] {
    let [x, y, z] = n.0;
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let sign = zero.if_above(z, L::splat(-1.0), one);
    let a = L::splat(-1.0) / (sign + z);
    let b = x * y * a;
    [
        V3([one + sign * x * x * a, sign * b, zero - sign * x]),
        V3([b, sign + y * y * a, zero - y]),
    ]
}

struct Derive<'a, S> {
    blocks: &'a mut [Block],
    points: &'a mut [Point],
    solids: &'a [Solid],
    is_stale: S,
}

impl<S: Iterator<Item = bool>> Kernel for Derive<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let mut rest = self.points;
        for (block, is_stale) in self.blocks.iter_mut().zip(self.is_stale) {
            let (points, after) = rest.split_at_mut(block.points.len());
            rest = after;
            if !is_stale {
                continue;
            }
            load_masses::<L>(block, self.solids);
            let pair = Masses::<L>::load(block);
            let mass = pair.mass[0] + pair.mass[1];
            let normal = V3::<L>::load(&block.normal);
            let (t1, t2) = (V3::load(&block.tangents[0]), V3::load(&block.tangents[1]));
            for point in points {
                let arms = load_anchors(point);
                let along_normal = pair.turns(&arms, normal);
                let of_normal = pair.effect(&arms, normal, &along_normal);
                let of_t1 = pair.effect(&arms, t1, &pair.turns(&arms, t1));
                let of_t2 = pair.effect(&arms, t2, &pair.turns(&arms, t2));
                inverse(mass + of_normal).store(&mut point.normal_mass);
                inverse(mass + of_t1.max(of_t2)).store(&mut point.tangent_mass);
                let of_both = pair.effect(&arms, t1, &along_normal);
                of_both.store(&mut point.coupling[0]);
                let of_both = pair.effect(&arms, t2, &along_normal);
                of_both.store(&mut point.coupling[1]);
            }
        }
    }
}

/// Copies masses and inertias of the bodies into a block.
#[inline(always)]
fn load_masses<L: Lanes>(block: &mut Block, solids: &[Solid]) {
    for side in 0..2 {
        let [xx, yy, zz, xy, xz, yz, mass, _] = L::gather(solids, &block.bodies[side]);
        mass.store(&mut block.inverse_mass[side]);
        let six = &mut block.inverse_inertia[side];
        xx.store(&mut six[0]);
        yy.store(&mut six[1]);
        zz.store(&mut six[2]);
        xy.store(&mut six[3]);
        xz.store(&mut six[4]);
        yz.store(&mut six[5]);
    }
}

/// `1 / x`, or 0.
#[inline(always)]
fn inverse<L: Lanes>(x: L) -> L {
    let zero = L::splat(0.0);
    x.if_above(zero, L::splat(1.0) / x, zero)
}

/// Inverse masses and inertias of two bodies in each lane.
pub(super) struct Masses<L> {
    pub(super) mass: [L; 2],
    pub(super) inertia: [[L; 6]; 2],
}

impl<L: Lanes> Masses<L> {
    #[inline(always)]
    pub(super) fn load(block: &Block) -> Self {
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
