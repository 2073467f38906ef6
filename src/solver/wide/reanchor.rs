//! Contact points that follow the motion of their bodies within a step.
//!
//! Contacts are found once per step. Where bodies move fast against each other, or turn, the rows of later sub-steps must
//! point at where the contact points are by then. A contact point stays at its place on one of its bodies, the anchor body, and
//! both bodies see the impulse there, or it would change the total angular momentum. The gap is what lies between the two
//! anchors, each turned with its own body.
//!
//! A manifold tells the middle between the two surfaces. That is no place of a body as long as there is a gap: metres from a
//! splinter in flight, it would sweep around with the splinter's spin and hit what the splinter does not. So what is carried
//! is the point of the anchor body's surface, half a gap away.
//!
//! Where a surface is curved the point does not stay at its place: the body rolls. What turns with it is the center of curvature, and
//! the point stays where the normal leads to from there.

use crate::bodies::solver_body::SolverBody;
use crate::contact::manifolds::Manifolds;
use crate::simd::dispatch::run;
use crate::simd::lanes::{F8, Kernel, LaneWidth, Lanes, ReadRow, WIDTH};
use crate::simd::vec3::V3;
use crate::solver::wide::block::points_of;
use crate::solver::wide::block::{Block, FAR, Point, load_anchors};
use crate::solver::wide::body_pair::{BodyPair, Frame};
use crate::solver::wide::bond::BondConstraint;
use crate::threads::parts::{front, front_mut};
use glam::Quat;

/// A block of which some lanes follow, so that its masses and couplings change within the step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ReanchoredBlock {
    /// Its index.
    pub(crate) block: u32,
    /// Its points, within the starts of all that follow.
    pub(crate) starts: [u32; 2],
    /// 1 in lanes whose points follow, else 0.
    pub(crate) moves: F8,
    /// 1 in lanes whose points stay on B, 0 where they stay on A.
    pub(crate) on_b: F8,
}

/// Blocks that follow, ascending, which are taken off part by part with the blocks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReanchoredBlocks<'a> {
    rest: &'a [ReanchoredBlock],
    /// Index of the next block.
    block: usize,
}

impl<'a> ReanchoredBlocks<'a> {
    pub(crate) fn new(reanchored: &'a [ReanchoredBlock]) -> Self {
        Self {
            rest: reanchored,
            block: 0,
        }
    }

    /// Those of the next `blocks` blocks.
    pub(crate) fn take(&mut self, blocks: usize) -> ReanchoredPart<'a> {
        let first_block = self.block;
        self.block += blocks;
        let end = self.block;
        let count = self.rest.partition_point(|f| (f.block as usize) < end);
        ReanchoredPart {
            first_block,
            list: front(&mut self.rest, count),
        }
    }
}

/// Some of the blocks that follow.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReanchoredPart<'a> {
    /// The first block of the part that they are of.
    first_block: usize,
    list: &'a [ReanchoredBlock],
}

impl<'a> ReanchoredPart<'a> {
    /// Indices of the blocks within their part.
    pub(crate) fn blocks(self) -> impl Iterator<Item = usize> + 'a {
        let first = self.first_block;
        self.list.iter().map(move |f| f.block as usize - first)
    }

    /// Number of their points.
    pub(crate) fn points(self) -> usize {
        match self.list {
            [] => 0,
            [first, ..] => (self.list[self.list.len() - 1].starts[1] - first.starts[0]) as usize,
        }
    }

    /// Notes where the points of these blocks, which are among `blocks`, are at the start of the step.
    pub(crate) fn start(self, blocks: &[Block], points: &[Point], starts: &mut [AnchorStart]) {
        let first = points_of(blocks).start;
        let points_there = self.blocks().flat_map(|block| blocks[block].points.clone());
        for (start, point) in starts.iter_mut().zip(points_there) {
            *start = AnchorStart::of(&points[point - first]);
        }
    }

    /// Notes how curved bodies are at the points of these blocks.
    pub(crate) fn load_curvatures(
        self,
        blocks: &[Block],
        manifolds: &Manifolds,
        curvatures: &mut [Curvatures],
    ) {
        let mut rest = curvatures;
        for block in self.blocks().map(|block| &blocks[block]) {
            let of_block = front_mut(&mut rest, block.points.len());
            of_block.fill(FLAT);
            for (lane, &manifold) in block.manifolds[..block.used].iter().enumerate() {
                let points = manifolds.at(manifold as usize).points();
                for (of_point, point) in of_block.iter_mut().zip(points) {
                    of_point[0].0[lane] = point.radii[0];
                    of_point[1].0[lane] = point.radii[1];
                }
            }
        }
    }
}

/// A point at the start of the step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct AnchorStart {
    anchors: [[F8; 3]; 2],
    separation: F8,
}

impl AnchorStart {
    /// The place of a point that has not moved yet.
    pub(crate) fn of(point: &Point) -> Self {
        Self {
            anchors: point.anchors,
            separation: point.separation,
        }
    }
}

/// Radii of curvature of A and B at a point, m.
pub(crate) type Curvatures = [F8; 2];

/// Of what does not roll.
pub(crate) const FLAT: Curvatures = [F8([0.0; WIDTH]); 2];

/// How a body has turned since the start of the step: the quaternion x, y, z, w, then 1 if its points may follow, else 0.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BodyRotation(F8);

impl BodyRotation {
    pub(crate) fn new(rotation: Quat, may_follow: bool) -> Self {
        let [x, y, z, w] = rotation.to_array();
        Self(F8([x, y, z, w, f32::from(may_follow), 0.0, 0.0, 0.0]))
    }
}

impl ReadRow for BodyRotation {
    #[inline(always)]
    fn numbers(&self) -> [f32; 8] {
        self.0.0
    }
}

/// Some blocks, and all that is about their points.
pub(crate) struct Reanchor<'a> {
    pub(crate) blocks: &'a [Block],
    pub(crate) reanchored: ReanchoredPart<'a>,
    pub(crate) points: &'a mut [Point],
    /// Empty where nothing is bonded.
    pub(crate) bond_constraints: &'a mut [BondConstraint],
    /// Of the points of those blocks that follow.
    pub(crate) starts: &'a [AnchorStart],
    /// Of the same points; empty where nothing is round.
    pub(crate) curvatures: &'a [Curvatures],
    pub(crate) turns: &'a [BodyRotation],
    pub(crate) displacements: &'a [SolverBody],
}

impl Reanchor<'_> {
    pub(crate) fn run(&mut self, width: LaneWidth) {
        match (self.bond_constraints.is_empty(), self.curvatures.is_empty()) {
            (true, true) => run(width, Follow::<false, false>(self)),
            (true, false) => run(width, Follow::<false, true>(self)),
            (false, true) => run(width, Follow::<true, false>(self)),
            (false, false) => run(width, Follow::<true, true>(self)),
        }
    }
}

struct Follow<'p, 'a, const BONDED: bool, const ROUND: bool>(&'p mut Reanchor<'a>);

impl<const BONDED: bool, const ROUND: bool> Kernel for Follow<'_, '_, BONDED, ROUND> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Reanchor {
            blocks,
            reanchored,
            points,
            bond_constraints,
            starts,
            curvatures,
            turns,
            displacements,
        } = self.0;
        let first = points_of(blocks).start;
        let mut starts = starts.iter();
        let mut curvatures = curvatures.iter();
        for (at, reanchored) in reanchored.blocks().zip(reanchored.list) {
            let block = &blocks[at];
            let carried = AnchorMotion::<L>::load(block, reanchored, turns, displacements);
            let of_block = block.points.start - first..block.points.end - first;
            for (i, start) in of_block.zip(&mut starts) {
                let curvatures = match ROUND {
                    true => curvatures.next().unwrap_or(&FLAT),
                    false => &FLAT,
                };
                let (follows, between) = carried.follow::<ROUND>(start, curvatures, &mut points[i]);
                if BONDED {
                    carried.reanchor_bond(&mut bond_constraints[i], &points[i], follows, &between);
                }
            }
        }
    }
}

/// The bodies of a block, with how they have moved and turned since the start of the step.
struct AnchorMotion<L> {
    frame: Frame<L>,
    moved: BodyPair<L>,
    turns: [[V3<L>; 3]; 2],
    /// 1 in lanes whose points follow.
    moves: L,
    on_b: L,
}

impl<L: Lanes> AnchorMotion<L> {
    #[inline(always)]
    fn load(
        block: &Block,
        reanchored: &ReanchoredBlock,
        turns: &[BodyRotation],
        displacements: &[SolverBody],
    ) -> Self {
        let [a, b] = &block.bodies;
        let (a, b) = (L::gather(turns, a), L::gather(turns, b));
        Self {
            frame: Frame::load(block),
            moved: BodyPair::gather(displacements, block),
            turns: [matrix(&a), matrix(&b)],
            moves: L::load(&reanchored.moves) * a[4] * b[4],
            on_b: L::load(&reanchored.on_b),
        }
    }

    /// Moves a point; returns in which lanes it is there and follows, and how far B has gone against A there, m.
    #[inline(always)]
    fn follow<const ROUND: bool>(
        &self,
        start: &AnchorStart,
        curvatures: &Curvatures,
        point: &mut Point,
    ) -> (L, V3<L>) {
        let (zero, normal) = (L::splat(0.0), &self.frame.normal);
        let gap = L::load(&start.separation);
        let follows = L::splat(FAR).if_above(gap, self.moves, zero);
        // On B it is where the normal points to.
        let half = L::splat(0.5) * gap;
        let to_surface = normal.times(self.on_b.if_above(zero, half, zero - half));
        let [from_a, from_b] = [
            V3::load(&start.anchors[0]).plus(to_surface),
            V3::load(&start.anchors[1]).plus(to_surface),
        ];
        let [to_a, to_b] = if ROUND {
            let inward = [
                normal.times(zero - L::load(&curvatures[0])),
                normal.times(L::load(&curvatures[1])),
            ];
            [
                rolled(&self.turns[0], from_a, inward[0]),
                rolled(&self.turns[1], from_b, inward[1]),
            ]
        } else {
            [
                turned(&self.turns[0], from_a),
                turned(&self.turns[1], from_b),
            ]
        };
        let apart = self.moved.linear(1).minus(self.moved.linear(0));
        let between = apart.plus(to_b.minus(from_b)).minus(to_a.minus(from_a));
        let on_a = to_b.minus(between);
        let on_b = to_a.plus(between);
        let anchors = [select(self.on_b, on_b, to_a), select(self.on_b, to_b, on_a)];
        let gap = gap + normal.dot(between) - self.moved.along(*normal, &anchors);
        let before = load_anchors::<L>(point);
        select(follows, anchors[0], before[0]).store(&mut point.anchors[0]);
        select(follows, anchors[1], before[1]).store(&mut point.anchors[1]);
        follows
            .if_above(zero, gap, L::load(&point.separation))
            .store(&mut point.separation);
        (follows, between)
    }

    /// Bonded lanes: how far B is off along the tangents, less what displacements add to it.
    #[inline(always)]
    fn reanchor_bond(
        &self,
        constraint: &mut BondConstraint,
        point: &Point,
        follows: L,
        between: &V3<L>,
    ) {
        let anchors = load_anchors(point);
        for k in 0..2 {
            let tangent = self.frame.tangents[k];
            let shift = self.moved.along(tangent, &anchors);
            let slide = L::load(&constraint.start[k]) + tangent.dot(*between) - shift;
            follows
                .if_above(L::splat(0.0), slide, L::load(&constraint.slide[k]))
                .store(&mut constraint.slide[k]);
        }
    }
}

/// Where a point of a curved surface is after a turn about the center of curvature, `inward` of it. No closure: those are not always
/// put in line, and lanes are wide only in line.
#[inline(always)]
fn rolled<L: Lanes>(turn: &[V3<L>; 3], from: V3<L>, inward: V3<L>) -> V3<L> {
    turned(turn, from.plus(inward)).minus(inward)
}

/// `yes` in lanes where `mask` is 1, `no` where it is 0.
#[inline(always)]
fn select<L: Lanes>(mask: L, yes: V3<L>, no: V3<L>) -> V3<L> {
    let zero = L::splat(0.0);
    let ([a, b, c], [x, y, z]) = (yes.0, no.0);
    V3([
        mask.if_above(zero, a, x),
        mask.if_above(zero, b, y),
        mask.if_above(zero, c, z),
    ])
}

/// Columns of the rotation matrices of quaternions.
#[inline(always)]
fn matrix<L: Lanes>(turn: &[L; 8]) -> [V3<L>; 3] {
    let [x, y, z, w, ..] = *turn;
    let (one, x2, y2, z2) = (L::splat(1.0), x + x, y + y, z + z);
    let (xx, xy, xz) = (x * x2, x * y2, x * z2);
    let (yy, yz, zz) = (y * y2, y * z2, z * z2);
    let (wx, wy, wz) = (w * x2, w * y2, w * z2);
    [
        V3([one - (yy + zz), xy + wz, xz - wy]),
        V3([xy - wz, one - (xx + zz), yz + wx]),
        V3([xz + wy, yz - wx, one - (xx + yy)]),
    ]
}

#[inline(always)]
fn turned<L: Lanes>(columns: &[V3<L>; 3], v: V3<L>) -> V3<L> {
    let [x, y, z] = v.0;
    let sum = columns[0].times(x).plus(columns[1].times(y));
    sum.plus(columns[2].times(z))
}

#[cfg(test)]
mod tests {
    use super::{
        AnchorStart, BodyRotation, Curvatures, Reanchor, ReanchoredBlock, ReanchoredBlocks,
    };
    use crate::bodies::solver_body::SolverBody;
    use crate::simd::lanes::{F8, LaneWidth, WIDTH};
    use crate::solver::wide::block::{Block, FAR, Point, set_vector, vector};
    use crate::solver::wide::bond::BondConstraint;
    use glam::{Mat3, Quat, Vec3};
    use rand_core::Rng;
    use rand_pcg::Pcg32;

    /// From [-1, 1].
    fn signed(random: &mut Pcg32) -> f32 {
        (random.next_u32() >> 8) as f32 / 8_388_608.0 - 1.0
    }

    fn direction(random: &mut Pcg32) -> Vec3 {
        [(); 3].map(|()| signed(random)).into()
    }

    /// Bodies that have moved and turned, the last of which turns too fast to be followed.
    fn bodies(random: &mut Pcg32, count: usize) -> (Vec<SolverBody>, Vec<Quat>) {
        let moved = (0..count).map(|_| SolverBody {
            linear: direction(random),
            angular: direction(random),
            ..SolverBody::default()
        });
        let moved = moved.collect();
        let turn = || Quat::from_vec4(direction(random).extend(1.0)).normalize();
        (moved, std::iter::repeat_with(turn).take(count).collect())
    }

    /// A block of manifolds with one to three points; the last lane does not follow, and every other one stays on B.
    fn block(
        random: &mut Pcg32,
        bodies: u32,
    ) -> (Block, Vec<Point>, Vec<BondConstraint>, ReanchoredBlock) {
        let (mut block, mut reanchored) = (Block::default(), ReanchoredBlock::default());
        block.points = 0..3;
        let (mut points, mut bond_constraints) = (
            vec![Point::default(); 3],
            vec![BondConstraint::default(); 3],
        );
        for lane in 0..WIDTH {
            block.put(lane, 0, [0; 2].map(|_: u32| random.next_u32() % bodies));
            set_vector(&mut block.normal, lane, direction(random).normalize());
            for k in 0..2 {
                set_vector(&mut block.tangents[k], lane, direction(random));
            }
            reanchored.moves.0[lane] = f32::from(u8::from(lane + 1 < WIDTH));
            reanchored.on_b.0[lane] = (lane % 2) as f32;
            for (k, (point, constraint)) in points.iter_mut().zip(&mut bond_constraints).enumerate()
            {
                point.separation.0[lane] = if k <= lane % 3 { signed(random) } else { FAR };
                for anchor in &mut point.anchors {
                    set_vector(anchor, lane, direction(random));
                }
                constraint.start[0].0[lane] = signed(random);
            }
        }
        (block, points, bond_constraints, reanchored)
    }

    /// Of three points, if anything is round.
    fn curvatures(random: &mut Pcg32, is_round: bool) -> Vec<Curvatures> {
        let mut lanes = || F8([(); WIDTH].map(|()| signed(random).max(0.0)));
        let all = (0..3).map(|_| [lanes(), lanes()]);
        all.filter(|_| is_round).collect()
    }

    /// The definition: anchors on A and B, gap and first slide of a point that has followed.
    fn followed(
        [from_a, from_b]: [Vec3; 2],
        inward: [Vec3; 2],
        turns: [Quat; 2],
        [a, b]: [&SolverBody; 2],
        is_on_b: bool,
    ) -> ([Vec3; 2], Vec3) {
        let [to_a, to_b] = [
            Mat3::from_quat(turns[0]) * (from_a + inward[0]) - inward[0],
            Mat3::from_quat(turns[1]) * (from_b + inward[1]) - inward[1],
        ];
        let between = (b.linear - a.linear) + (to_b - from_b) - (to_a - from_a);
        let anchors = if is_on_b {
            [to_a + between, to_b]
        } else {
            [to_a, to_b - between]
        };
        (anchors, between)
    }

    #[test]
    fn points_follow_their_carriers_in_lanes_as_one_by_one() {
        let mut random = Pcg32::new(3, 5);
        for round in 0..300 {
            let (moved, turns) = bodies(&mut random, 5);
            let lanes_of = |turn: &Quat, is_slow| BodyRotation::new(*turn, is_slow);
            let turn_rows: Vec<BodyRotation> = (0..5).map(|i| lanes_of(&turns[i], i < 4)).collect();
            let (block, before, bond_constraints, reanchored) = block(&mut random, 5);
            let starts: Vec<AnchorStart> = before.iter().map(AnchorStart::of).collect();
            let (mut points, mut new_ties) = (before.clone(), bond_constraints.clone());
            let width = [LaneWidth::Widest, LaneWidth::Four, LaneWidth::One][round % 3];
            let curvatures = curvatures(&mut random, round % 2 == 1);
            let reanchored = [reanchored];
            let mut follow = Reanchor {
                blocks: std::slice::from_ref(&block),
                reanchored: ReanchoredBlocks::new(&reanchored).take(1),
                points: &mut points,
                bond_constraints: &mut new_ties,
                starts: &starts,
                curvatures: &curvatures,
                turns: &turn_rows,
                displacements: &moved,
            };
            follow.run(width);
            for lane in 0..WIDTH {
                let pair = block.pair(lane).map(|body| body as usize);
                let stays = lane + 1 == WIDTH || pair.contains(&4);
                for (k, point) in points.iter().enumerate() {
                    let anchors = [0, 1].map(|side| vector(&before[k].anchors[side], lane));
                    let new = [0, 1].map(|side| vector(&point.anchors[side], lane));
                    let gap = before[k].separation.0[lane];
                    if stays || gap == FAR {
                        assert_eq!((new, point.separation.0[lane]), (anchors, gap));
                        assert_eq!(
                            new_ties[k].slide[0].0[lane],
                            bond_constraints[k].slide[0].0[lane]
                        );
                        continue;
                    }
                    let bodies = pair.map(|body| &moved[body]);
                    let is_on_b = lane % 2 == 1;
                    let turns = pair.map(|body| turns[body]);
                    let normal = vector(&block.normal, lane);
                    let to_surface = normal * if is_on_b { 0.5 * gap } else { -0.5 * gap };
                    let from = anchors.map(|anchor| anchor + to_surface);
                    let inward = [-normal, normal].map(|n| n.to_array());
                    let inward = [0, 1].map(|side| {
                        let radius = curvatures.get(k).map_or(0.0, |c| c[side].0[lane]);
                        radius * Vec3::from(inward[side])
                    });
                    let (expected, between) = followed(from, inward, turns, bodies, is_on_b);
                    assert_eq!(new, expected);
                    let shift = point.normal_velocity(lane, normal, bodies);
                    let expected = gap + normal.dot(between) - shift;
                    assert_eq!(point.separation.0[lane], expected);
                    let tangent = vector(&block.tangents[0], lane);
                    let shift = point.normal_velocity(lane, tangent, bodies);
                    let expected =
                        bond_constraints[k].start[0].0[lane] + tangent.dot(between) - shift;
                    assert_eq!(new_ties[k].slide[0].0[lane], expected);
                }
            }
        }
    }
}
