//! What one core of the machine can do at most: numbers calculated, and bytes read and written.
//!
//! Through the solver's own [`Lanes`], so that it is the same kind of code: no multiplication is fused with an addition.

use bevy_cleave::testing::simd::{F8, Kernel, LaneWidth, Lanes, WIDTH, run};
use std::hint::black_box;
use std::time::Instant;

/// Widths and what the report calls them.
pub(crate) const WIDTHS: [(LaneWidth, &str); 3] = [
    (LaneWidth::Widest, "8"),
    (LaneWidth::Four, "4"),
    (LaneWidth::One, "1"),
];

/// Levels of memory, and a number of bytes that fits there and not in the one before.
pub(crate) const LEVELS: [(&str, usize); 4] = [
    ("L1", 24 << 10),
    ("L2", 1 << 20),
    ("L3", 24 << 20),
    ("memory", 768 << 20),
];

/// What was measured.
pub(crate) struct Limits {
    /// Clock, GHz.
    pub(crate) clock: f64,
    /// By width, 1e9 operations per second: additions and multiplications, and pairs of a square root and a division.
    pub(crate) flops: [f64; 3],
    pub(crate) roots: [f64; 3],
    /// By level, 1e9 bytes per second.
    pub(crate) read: [f64; 4],
    pub(crate) triad: [f64; 4],
}

impl Limits {
    pub(crate) fn measure() -> Self {
        let by_width = |measure: fn(LaneWidth) -> f64| WIDTHS.map(|(width, _)| measure(width));
        let by_level = |measure: fn(usize) -> f64| LEVELS.map(|(_, bytes)| measure(bytes));
        Self {
            clock: clock(),
            flops: by_width(flops),
            roots: by_width(roots),
            read: by_level(read),
            triad: by_level(triad),
        }
    }

    /// The better of two measurements each, since the other load of the machine differs between them.
    pub(crate) fn or(self, other: &Self) -> Self {
        fn best<const N: usize>(a: [f64; N], b: [f64; N]) -> [f64; N] {
            std::array::from_fn(|k| a[k].max(b[k]))
        }
        Self {
            clock: self.clock.max(other.clock),
            flops: best(self.flops, other.flops),
            roots: best(self.roots, other.roots),
            read: best(self.read, other.read),
            triad: best(self.triad, other.triad),
        }
    }
}

/// Shortest time of many runs, s: what else runs on the machine only makes them longer.
pub(crate) fn shortest(mut work: impl FnMut()) -> f64 {
    work();
    let begin = Instant::now();
    let mut best = f64::INFINITY;
    let mut runs = 0;
    while runs < 5 || begin.elapsed().as_secs_f64() < 0.3 {
        let clock = Instant::now();
        work();
        best = best.min(clock.elapsed().as_secs_f64());
        runs += 1;
    }
    best
}

/// Clock in GHz from a chain of multiplications of integers, 3 cycles, and exclusive ors, 1 cycle: neither the compiler nor the
/// renaming of registers, which adds constants in no time on some processors, makes it shorter.
fn clock() -> f64 {
    const ROUNDS: u32 = 1_000_000;
    let factor = black_box(0x5851_f42d_4c95_7f2d_u64);
    let seconds = shortest(|| {
        let mut x = black_box(1_u64);
        for _ in 0..ROUNDS {
            x = (x ^ factor).wrapping_mul(factor);
        }
        black_box(x);
    });
    4e-9 * f64::from(ROUNDS) / seconds
}

/// Rounds of the kernels that calculate.
const ROUNDS: usize = 20_000;

/// `x <- x a + b` in chains that do not depend on each other.
struct Chains<const N: usize>;

impl<const N: usize> Kernel for Chains<N> {
    type Output = F8;

    #[inline(always)]
    fn run<L: Lanes>(self) -> F8 {
        let [a, b] = [L::splat(black_box(0.5)), L::splat(black_box(1.0))];
        let mut x = [L::splat(black_box(0.1)); N];
        for _ in 0..ROUNDS {
            for x in &mut x {
                *x = *x * a + b;
            }
        }
        let sum = x.into_iter().fold(b, |sum, x| sum + x);
        let mut to = F8::default();
        sum.store(&mut to);
        to
    }
}

/// The best number of chains is as many as the registers hold, which differs between the widths.
fn flops(width: LaneWidth) -> f64 {
    fn of<const N: usize>(width: LaneWidth) -> f64 {
        let seconds = shortest(|| {
            black_box(run(width, Chains::<N>));
        });
        1e-9 * (2 * N * WIDTH * ROUNDS) as f64 / seconds
    }
    let all = [
        of::<1>(width),
        of::<2>(width),
        of::<4>(width),
        of::<6>(width),
    ];
    all.into_iter().chain([of::<12>(width)]).fold(0.0, f64::max)
}

/// `1 / sqrt(x)` of numbers that do not depend on each other.
struct Roots<'a>(&'a mut [F8]);

impl Kernel for Roots<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let one = L::splat(1.0);
        for x in self.0 {
            (one / L::load(x).sqrt()).store(x);
        }
    }
}

fn roots(width: LaneWidth) -> f64 {
    let mut numbers = vec![F8([2.0; WIDTH]); 512];
    let seconds = shortest(|| (0..64).for_each(|_| run(width, Roots(&mut numbers))));
    1e-9 * (64 * numbers.len() * WIDTH) as f64 / seconds
}

struct Read<'a>(&'a [F8]);

impl Kernel for Read<'_> {
    type Output = F8;

    #[inline(always)]
    fn run<L: Lanes>(self) -> F8 {
        let mut sums = [L::splat(0.0); 8];
        for numbers in self.0.chunks_exact(8) {
            for (sum, x) in sums.iter_mut().zip(numbers) {
                *sum = *sum + L::load(x);
            }
        }
        let sum = sums.into_iter().fold(L::splat(0.0), |sum, x| sum + x);
        let mut to = F8::default();
        sum.store(&mut to);
        to
    }
}

/// Times that a buffer is gone through in one timed run, so that a run takes long enough to be timed.
fn passes(bytes: usize) -> usize {
    ((16 << 20) / bytes).max(1)
}

fn read(bytes: usize) -> f64 {
    let numbers = vec![F8([1.0; WIDTH]); bytes / size_of::<F8>()];
    let passes = passes(bytes);
    let seconds = shortest(|| {
        for _ in 0..passes {
            black_box(run(LaneWidth::Widest, Read(black_box(&numbers))));
        }
    });
    1e-9 * (passes * bytes) as f64 / seconds
}

/// `a = b + s c`.
struct Triad<'a> {
    a: &'a mut [F8],
    b: &'a [F8],
    c: &'a [F8],
}

impl Kernel for Triad<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let s = L::splat(black_box(0.5));
        for ((a, b), c) in self.a.iter_mut().zip(self.b).zip(self.c) {
            (L::load(b) + s * L::load(c)).store(a);
        }
    }
}

/// Bytes that the program reads and writes; that a written line is read first is not counted.
fn triad(bytes: usize) -> f64 {
    let third = bytes / 3 / size_of::<F8>();
    let [mut a, b, c] = [(); 3].map(|()| vec![F8([1.0; WIDTH]); third]);
    let passes = passes(bytes);
    let seconds = shortest(|| {
        for _ in 0..passes {
            let (a, b, c) = (&mut a[..], black_box(&b[..]), &c[..]);
            run(LaneWidth::Widest, Triad { a, b, c });
        }
    });
    1e-9 * (passes * 3 * third * size_of::<F8>()) as f64 / seconds
}
