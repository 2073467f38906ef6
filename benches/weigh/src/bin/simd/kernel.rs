//! The loop that all are compared on, written once over operations on eight numbers.

use bevy_cleave::testing::simd::F8;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg32;

/// Operations on eight numbers.
pub(crate) trait Ops: Copy {
    type V: Copy;
    fn splat(self, x: f32) -> Self::V;
    fn load(self, from: &F8) -> Self::V;
    fn store(self, x: Self::V, to: &mut F8);
    fn add(self, a: Self::V, b: Self::V) -> Self::V;
    fn sub(self, a: Self::V, b: Self::V) -> Self::V;
    fn mul(self, a: Self::V, b: Self::V) -> Self::V;
    fn div(self, a: Self::V, b: Self::V) -> Self::V;
    fn max(self, a: Self::V, b: Self::V) -> Self::V;
    fn sqrt(self, a: Self::V) -> Self::V;
    /// `yes` in lanes where `a > b`, else `no`.
    fn if_above(self, a: Self::V, b: Self::V, yes: Self::V, no: Self::V) -> Self::V;
    /// Eight rows as columns.
    fn transpose(self, rows: [Self::V; 8]) -> [Self::V; 8];
}

/// A direction, what it does to the spin of either body, and effective mass.
#[derive(Clone, Copy, Default)]
struct Row {
    direction: [F8; 3],
    arm_a: [F8; 3],
    arm_b: [F8; 3],
    mass: F8,
    impulse: F8,
}

/// One contact in each lane.
#[derive(Clone, Copy, Default)]
pub(crate) struct Block {
    bodies: [[u32; 8]; 2],
    normal: Row,
    tangents: [Row; 2],
    target: F8,
    friction: F8,
}

/// Bodies (velocity, spin, inverse mass and inverse inertia) and the contacts between them.
pub(crate) struct Scene {
    bodies: Vec<F8>,
    blocks: Vec<Block>,
}

impl Scene {
    /// 512 bodies, 128 blocks, no body twice in a block; always the same.
    pub(crate) fn new() -> Self {
        let mut dice = Pcg32::seed_from_u64(29);
        let mut number = move || (dice.next_u32() >> 8) as f32 / 8_388_608.0 - 1.0;
        let mut eight = || F8(std::array::from_fn(|_| number()));
        let bodies = (0..512).map(|_| {
            let mut body = eight();
            body.0[6] = body.0[6].abs() + 0.1;
            body.0[7] = body.0[7].abs() + 0.1;
            body
        });
        let bodies = bodies.collect();
        let positive = |x: F8| F8(x.0.map(|x| 0.1 + x.abs()));
        let mut row = || Row {
            direction: [eight(), eight(), eight()],
            arm_a: [eight(), eight(), eight()],
            arm_b: [eight(), eight(), eight()],
            mass: F8(positive(eight()).0.map(|x| 0.1 * x)),
            impulse: F8::default(),
        };
        let blocks = (0..128_u32).map(|block| Block {
            bodies: [0, 1].map(|side| {
                std::array::from_fn(|lane| (block * 37 + 16 * lane as u32 + 7 * side) % 512)
            }),
            normal: row(),
            tangents: [row(), row()],
            target: F8([0.01; 8]),
            friction: F8([0.5; 8]),
        });
        let blocks = blocks.collect();
        Self { bodies, blocks }
    }

    pub(crate) fn blocks(&self) -> usize {
        self.blocks.len()
    }

    pub(crate) fn hash(&self) -> u64 {
        let bits = self.bodies.iter().flat_map(|body| body.0.map(f32::to_bits));
        bits.fold(0xcbf2_9ce4_8422_2325, |hash, bits| {
            (hash ^ u64::from(bits)).wrapping_mul(0x100_0000_01b3)
        })
    }
}

/// A body in each lane.
struct Body<V> {
    columns: [V; 8],
}

#[inline(always)]
fn gather<O: Ops>(ops: O, bodies: &[F8], index: &[u32; 8]) -> Body<O::V> {
    let rows = [
        ops.load(&bodies[index[0] as usize]),
        ops.load(&bodies[index[1] as usize]),
        ops.load(&bodies[index[2] as usize]),
        ops.load(&bodies[index[3] as usize]),
        ops.load(&bodies[index[4] as usize]),
        ops.load(&bodies[index[5] as usize]),
        ops.load(&bodies[index[6] as usize]),
        ops.load(&bodies[index[7] as usize]),
    ];
    Body {
        columns: ops.transpose(rows),
    }
}

#[inline(always)]
fn scatter<O: Ops>(ops: O, body: Body<O::V>, bodies: &mut [F8], index: &[u32; 8]) {
    let rows = ops.transpose(body.columns);
    for lane in 0..8 {
        ops.store(rows[lane], &mut bodies[index[lane] as usize]);
    }
}

#[inline(always)]
fn dot<O: Ops>(ops: O, row: &[F8; 3], [x, y, z]: [O::V; 3]) -> O::V {
    let xy = ops.add(ops.mul(ops.load(&row[0]), x), ops.mul(ops.load(&row[1]), y));
    ops.add(xy, ops.mul(ops.load(&row[2]), z))
}

impl<V: Copy> Body<V> {
    /// Velocity along a row.
    #[inline(always)]
    fn along<O: Ops<V = V>>(&self, ops: O, direction: &[F8; 3], arm: &[F8; 3]) -> V {
        let [vx, vy, vz, wx, wy, wz, _, _] = self.columns;
        ops.add(
            dot(ops, direction, [vx, vy, vz]),
            dot(ops, arm, [wx, wy, wz]),
        )
    }

    /// An impulse along a row.
    #[inline(always)]
    fn push<O: Ops<V = V>>(&mut self, ops: O, direction: &[F8; 3], arm: &[F8; 3], impulse: V) {
        let linear = ops.mul(impulse, self.columns[6]);
        let angular = ops.mul(impulse, self.columns[7]);
        for k in 0..3 {
            self.columns[k] = ops.add(self.columns[k], ops.mul(ops.load(&direction[k]), linear));
            self.columns[3 + k] = ops.add(self.columns[3 + k], ops.mul(ops.load(&arm[k]), angular));
        }
    }
}

#[inline(always)]
fn slip<O: Ops>(ops: O, row: &Row, a: &Body<O::V>, b: &Body<O::V>) -> O::V {
    let on_b = b.along(ops, &row.direction, &row.arm_b);
    ops.sub(on_b, a.along(ops, &row.direction, &row.arm_a))
}

/// The impulse that stops a slip.
#[inline(always)]
fn stick<O: Ops>(ops: O, row: &Row, a: &Body<O::V>, b: &Body<O::V>) -> O::V {
    let change = ops.mul(slip(ops, row, a, b), ops.load(&row.mass));
    ops.sub(ops.load(&row.impulse), change)
}

#[inline(always)]
fn apply<O: Ops>(ops: O, row: &mut Row, a: &mut Body<O::V>, b: &mut Body<O::V>, impulse: O::V) {
    let change = ops.sub(impulse, ops.load(&row.impulse));
    ops.store(impulse, &mut row.impulse);
    b.push(ops, &row.direction, &row.arm_b, change);
    a.push(
        ops,
        &row.direction,
        &row.arm_a,
        ops.sub(ops.splat(0.0), change),
    );
}

/// One sweep over all blocks. No closures: within functions for a kind of processor those that the standard library calls are
/// not always inlined, and then pass registers through memory.
#[inline(always)]
pub(crate) fn sweep<O: Ops>(ops: O, Scene { bodies, blocks }: &mut Scene) {
    let zero = ops.splat(0.0);
    for block in blocks {
        let mut a = gather(ops, bodies, &block.bodies[0]);
        let mut b = gather(ops, bodies, &block.bodies[1]);
        let normal = &mut block.normal;
        let lacking = ops.sub(ops.load(&block.target), slip(ops, normal, &a, &b));
        let wish = ops.add(
            ops.load(&normal.impulse),
            ops.mul(lacking, ops.load(&normal.mass)),
        );
        let pressure = ops.max(wish, zero);
        apply(ops, normal, &mut a, &mut b, pressure);
        let [first, second] = &mut block.tangents;
        let wishes = [stick(ops, first, &a, &b), stick(ops, second, &a, &b)];
        let radius = ops.mul(ops.load(&block.friction), pressure);
        let length =
            ops.sqrt(ops.add(ops.mul(wishes[0], wishes[0]), ops.mul(wishes[1], wishes[1])));
        let scale = ops.if_above(length, radius, ops.div(radius, length), ops.splat(1.0));
        apply(ops, first, &mut a, &mut b, ops.mul(wishes[0], scale));
        apply(ops, second, &mut a, &mut b, ops.mul(wishes[1], scale));
        scatter(ops, a, bodies, &block.bodies[0]);
        scatter(ops, b, bodies, &block.bodies[1]);
    }
}
