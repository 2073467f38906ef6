//! From manifolds to lanes: what blocks hold at the start of a step, and the masses that follow from where bodies are.

use crate::bodies::solver_body::BodyMass;
use crate::contact::manifolds::Manifolds;
use crate::contact::point::{ContactPoint, MAX_POINTS};
use crate::simd::dispatch::run;
use crate::simd::lanes::{F8, Kernel, LaneWidth, Lanes, WIDTH};
use crate::simd::prefetch::prefetch;
use crate::simd::vec3::V3;
use crate::solver::wide::block::points_of;
use crate::solver::wide::block::{Block, FAR, Point, load_anchors};
use crate::solver::wide::body_pair::Masses;
use crate::tuning::{FILLED_BLOCKS_AHEAD, FILLED_POINTS_AHEAD};

/// What blocks are filled from.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// All manifolds of the step.
    pub manifolds: &'a Manifolds,
    /// By number of a body.
    pub masses: &'a [BodyMass],
    /// Part of the impulses of the last step that a sub-step starts from.
    pub share: f32,
    /// Overlap that is left alone, as a share of the least extent.
    pub slop: f32,
}

/// Fills blocks, whose bodies and manifolds are known, and their points, which are all of `points`.
pub fn fill(blocks: &mut [Block], points: &mut [Point], source: Source<'_>, width: LaneWidth) {
    let kernel = Fill {
        blocks,
        points,
        source,
    };
    run(width, kernel);
}

/// Computes masses and couplings of the points of blocks, which are all of `points`, anew from anchors and inertias: for
/// the `stale` ones, by index.
pub(crate) fn derive_stale(
    blocks: &mut [Block],
    points: &mut [Point],
    masses: &[BodyMass],
    stale: impl Iterator<Item = usize>,
    width: LaneWidth,
) {
    let kernel = Derive {
        blocks,
        points,
        masses,
        stale,
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
            if let Some(next) = self.blocks.get(i + FILLED_BLOCKS_AHEAD) {
                prefetch(next);
                for &manifold in &next.manifolds[..next.used] {
                    let manifolds = self.source.manifolds;
                    manifolds.prefetch(manifold as usize, next.points.len());
                }
            }
            if let Some(next) = rest.get(FILLED_POINTS_AHEAD) {
                prefetch(next);
            }
            let block = &mut self.blocks[i];
            let (points, after) = rest.split_at_mut(block.points.len());
            rest = after;
            fill_block::<L>(block, points, &self.source);
            let [a, b] = load_masses::<L>(block, self.source.masses);
            let extent = a.min(b);
            (L::splat(self.source.slop) * extent).store(&mut block.slop);
            (L::splat(1.0) / extent.sqrt()).store(&mut block.speed_scale);
            derive::<L>(block, points);
        }
    }
}

#[inline(always)]
fn fill_block<L: Lanes>(block: &mut Block, points: &mut [Point], source: &Source<'_>) {
    let mut headers = [F8::default(); WIDTH];
    let mut geometry = [[NO_POINT; WIDTH]; MAX_POINTS];
    let mut impulses = [[F8::default(); WIDTH]; MAX_POINTS];
    for lane in 0..block.used {
        let manifold = source.manifolds.at(block.manifolds[lane] as usize);
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
        zero.store(&mut point.target_velocity);
        zero.store(&mut point.total_normal_impulse);
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
    masses: &'a [BodyMass],
    stale: S,
}

impl<S: Iterator<Item = usize>> Kernel for Derive<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let first = points_of(self.blocks).start;
        for at in self.stale {
            let block = &mut self.blocks[at];
            let points = &mut self.points[block.points.start - first..block.points.end - first];
            load_masses::<L>(block, self.masses);
            derive::<L>(block, points);
        }
    }
}

/// Computes masses and couplings of the points of a block.
#[inline(always)]
fn derive<L: Lanes>(block: &Block, points: &mut [Point]) {
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

/// Copies masses and inertias of the bodies into a block; returns their least extents.
#[inline(always)]
fn load_masses<L: Lanes>(block: &mut Block, masses: &[BodyMass]) -> [L; 2] {
    let mut extents = [L::splat(0.0); 2];
    for (side, min_extent) in extents.iter_mut().enumerate() {
        let [xx, yy, zz, xy, xz, yz, mass, extent] = L::gather(masses, &block.bodies[side]);
        *min_extent = extent;
        mass.store(&mut block.inverse_mass[side]);
        let six = &mut block.inverse_inertia[side];
        xx.store(&mut six[0]);
        yy.store(&mut six[1]);
        zz.store(&mut six[2]);
        xy.store(&mut six[3]);
        xz.store(&mut six[4]);
        yz.store(&mut six[5]);
    }
    extents
}

/// `1 / x`, or 0.
#[inline(always)]
fn inverse<L: Lanes>(x: L) -> L {
    let zero = L::splat(0.0);
    x.if_above(zero, L::splat(1.0) / x, zero)
}
