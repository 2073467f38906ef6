//! Eight numbers at a time, with whatever the processor has.
//!
//! A loop over [`Lanes`] is written once and compiled four times: for AVX2 (8 lanes in a register), the same with the 32
//! registers of AVX-512VL, for SSE2 (2 x 4 lanes) and in plain Rust. Which one runs is decided at run time. All of them round
//! every operation on its own, in the same order, and none fuses a multiplication with an addition, so all give the same
//! bits.
#![allow(
    unsafe_code,
    reason = "processor intrinsics; every block says why it is sound"
)]

use std::cell::Cell;
use std::ops::{Add, Div, Mul, Sub};

/// Number of lanes of everything that is laid out for [`Lanes`].
pub const WIDTH: usize = 8;

/// Eight numbers in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct F8(pub [f32; WIDTH]);

/// How many lanes a register may have. All widths give the same bits; the choice is for tests and measurements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum LaneWidth {
    /// As many as the processor has: 8 with AVX2, else 4.
    #[default]
    Widest,
    /// At most 4.
    Four,
    /// One: plain Rust.
    One,
}

/// Eight numbers in registers.
pub trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// The same number in all lanes.
    fn splat(x: f32) -> Self;
    /// Reads eight numbers.
    fn load(from: &F8) -> Self;
    /// Writes eight numbers.
    fn store(self, to: &mut F8);
    /// The smaller one by lane; `other` if either is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger one by lane; `other` if either is NaN.
    fn max(self, other: Self) -> Self;
    /// Square root by lane.
    fn sqrt(self) -> Self;
    /// `yes` in lanes where `self > bound`, else `no`.
    fn if_above(self, bound: Self, yes: Self, no: Self) -> Self;
    /// Whether `self > bound` in any lane.
    fn is_any_above(self, bound: Self) -> bool;
    /// Eight rows, one of each lane, as columns; or columns as rows.
    fn transpose(rows: [Self; 8]) -> [Self; 8];

    /// Eight rows of eight numbers, one row for each lane, as columns.
    #[inline(always)]
    fn columns(rows: &[F8; WIDTH]) -> [Self; 8] {
        Self::transpose([
            Self::load(&rows[0]),
            Self::load(&rows[1]),
            Self::load(&rows[2]),
            Self::load(&rows[3]),
            Self::load(&rows[4]),
            Self::load(&rows[5]),
            Self::load(&rows[6]),
            Self::load(&rows[7]),
        ])
    }

    /// The rows that the lanes refer to, as columns.
    #[inline(always)]
    fn gather<R: ReadRow>(rows: &[R], index: &[u32; WIDTH]) -> [Self; 8] {
        Self::transpose([
            read(rows, index[0]),
            read(rows, index[1]),
            read(rows, index[2]),
            read(rows, index[3]),
            read(rows, index[4]),
            read(rows, index[5]),
            read(rows, index[6]),
            read(rows, index[7]),
        ])
    }

    /// Writes what [`gather`](Self::gather) reads, of the first `used` lanes. Those that share a row must hold the same numbers.
    #[inline(always)]
    fn scatter<R: WriteRow>(
        columns: [Self; 8],
        rows: &[Cell<R>],
        index: &[u32; WIDTH],
        used: usize,
    ) {
        let from = Self::transpose(columns);
        for lane in 0..WIDTH {
            if lane >= used {
                break;
            }
            let mut numbers = F8::default();
            from[lane].store(&mut numbers);
            rows[index[lane] as usize].set(R::of(numbers.0));
        }
    }
}

#[inline(always)]
fn read<R: ReadRow, L: Lanes>(rows: &[R], index: u32) -> L {
    L::load(&F8(rows[index as usize].numbers()))
}

/// Eight numbers that lie in a row in memory.
pub trait ReadRow {
    /// The numbers.
    fn numbers(&self) -> [f32; 8];
}

/// Eight numbers that can be written too.
pub trait WriteRow: ReadRow + Copy {
    /// A row of these numbers.
    fn of(numbers: [f32; 8]) -> Self;
}

impl<R: WriteRow> ReadRow for Cell<R> {
    #[inline(always)]
    fn numbers(&self) -> [f32; 8] {
        self.get().numbers()
    }
}

impl ReadRow for F8 {
    #[inline(always)]
    fn numbers(&self) -> [f32; 8] {
        self.0
    }
}

impl WriteRow for F8 {
    #[inline(always)]
    fn of(numbers: [f32; 8]) -> Self {
        Self(numbers)
    }
}

/// A loop that is compiled for each kind of lanes. `run` and all that it calls must be `#[inline(always)]`, so that they
/// become part of the function that has the processor's features.
pub trait Kernel {
    /// What the loop comes to.
    type Output;
    /// The loop.
    fn run<L: Lanes>(self) -> Self::Output;
}

/// Runs a loop with the widest lanes that are there and allowed.
#[inline]
pub fn run<K: Kernel>(width: LaneWidth, kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    match width {
        LaneWidth::Widest if std::arch::is_x86_feature_detected!("avx512vl") => {
            // SAFETY: the processor has AVX-512VL, as was just found out, and with it AVX2.
            return unsafe { x86::run_avx512vl(kernel) };
        }
        LaneWidth::Widest if std::arch::is_x86_feature_detected!("avx2") => {
            // SAFETY: the processor has AVX2, as was just found out.
            return unsafe { x86::run_avx2(kernel) };
        }
        LaneWidth::Widest | LaneWidth::Four => return kernel.run::<x86::Sse2>(),
        LaneWidth::One => {}
    }
    let _ = width;
    kernel.run::<Plain>()
}

/// Lanes in plain Rust.
#[derive(Clone, Copy, Debug)]
pub struct Plain([f32; WIDTH]);

impl Plain {
    #[inline(always)]
    fn zip(mut self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        // A loop, because calls of the library within the kernels are not always inlined.
        for (x, y) in self.0.iter_mut().zip(other.0) {
            *x = f(*x, y);
        }
        self
    }
}

/// The operators of a kind of lanes, from expressions.
macro_rules! operators {
    ($type:ty, $($trait:ident $name:ident: |$a:ident, $b:ident| $value:expr;)*) => {$(
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                let ($a, $b) = (self, other);
                $value
            }
        }
    )*};
}

operators! { Plain,
    Add add: |a, b| a.zip(b, |x, y| x + y);
    Sub sub: |a, b| a.zip(b, |x, y| x - y);
    Mul mul: |a, b| a.zip(b, |x, y| x * y);
    Div div: |a, b| a.zip(b, |x, y| x / y);
}

impl Lanes for Plain {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; WIDTH])
    }

    #[inline(always)]
    fn load(from: &F8) -> Self {
        Self(from.0)
    }

    #[inline(always)]
    fn store(self, to: &mut F8) {
        to.0 = self.0;
    }

    // The comparisons are those of the x86 instructions, which are not those of `f32::min` and `f32::max` for NaN.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, |x, y| if x < y { x } else { y })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |x, y| if x > y { x } else { y })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }

    #[inline(always)]
    fn if_above(self, bound: Self, yes: Self, no: Self) -> Self {
        Self(std::array::from_fn(|i| {
            if self.0[i] > bound.0[i] {
                yes.0[i]
            } else {
                no.0[i]
            }
        }))
    }

    #[inline(always)]
    fn is_any_above(self, bound: Self) -> bool {
        self.0.iter().zip(&bound.0).any(|(x, bound)| x > bound)
    }

    #[inline(always)]
    fn transpose(rows: [Self; 8]) -> [Self; 8] {
        std::array::from_fn(|column| Self(rows.map(|row| row.0[column])))
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Add, Div, F8, Kernel, Lanes, Mul, Sub};
    use std::arch::x86_64::*;

    /// As [`run_avx2`], with twice as many registers: two bodies and the frame of a contact do not fit 16.
    #[target_feature(enable = "avx2,avx512f,avx512vl")]
    pub(crate) fn run_avx512vl<K: Kernel>(kernel: K) -> K::Output {
        kernel.run::<Avx2>()
    }

    /// All that is inlined into this function may use AVX2.
    #[target_feature(enable = "avx2")]
    pub(crate) fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
        kernel.run::<Avx2>()
    }

    /// Eight lanes in one register. Private to this module: values exist within [`run_avx2`] and [`run_avx512vl`] only.
    #[derive(Clone, Copy)]
    pub(crate) struct Avx2(__m256);

    /// Eight lanes in two registers.
    #[derive(Clone, Copy)]
    pub(crate) struct Sse2(__m128, __m128);

    // SAFETY of all blocks below for `Avx2`: values of the type exist only within `run_avx2` and `run_avx512vl`, which run only
    // where the processor has AVX2. Loads and stores are unaligned ones from and to `F8`, which is 32 bytes of `f32`.
    operators! { Avx2,
        // SAFETY: see above.
        Add add: |a, b| Self(unsafe { _mm256_add_ps(a.0, b.0) });
        // SAFETY: see above.
        Sub sub: |a, b| Self(unsafe { _mm256_sub_ps(a.0, b.0) });
        // SAFETY: see above.
        Mul mul: |a, b| Self(unsafe { _mm256_mul_ps(a.0, b.0) });
        // SAFETY: see above.
        Div div: |a, b| Self(unsafe { _mm256_div_ps(a.0, b.0) });
    }

    impl Lanes for Avx2 {
        #[inline(always)]
        fn splat(x: f32) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_set1_ps(x) })
        }

        #[inline(always)]
        fn load(from: &F8) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_loadu_ps(from.0.as_ptr()) })
        }

        #[inline(always)]
        fn store(self, to: &mut F8) {
            // SAFETY: see above.
            unsafe { _mm256_storeu_ps(to.0.as_mut_ptr(), self.0) }
        }

        #[inline(always)]
        fn min(self, other: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_min_ps(self.0, other.0) })
        }

        #[inline(always)]
        fn max(self, other: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_max_ps(self.0, other.0) })
        }

        #[inline(always)]
        fn sqrt(self) -> Self {
            // SAFETY: see above.
            Self(unsafe { _mm256_sqrt_ps(self.0) })
        }

        #[inline(always)]
        fn if_above(self, bound: Self, yes: Self, no: Self) -> Self {
            // SAFETY: see above.
            Self(unsafe {
                let is_above = _mm256_cmp_ps::<_CMP_GT_OQ>(self.0, bound.0);
                _mm256_blendv_ps(no.0, yes.0, is_above)
            })
        }

        #[inline(always)]
        fn is_any_above(self, bound: Self) -> bool {
            // SAFETY: see above.
            unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(self.0, bound.0)) != 0 }
        }

        #[inline(always)]
        fn transpose([a, b, c, d, e, f, g, h]: [Self; 8]) -> [Self; 8] {
            let [a, b, c, d, e, f, g, h] = transpose_avx2([a.0, b.0, c.0, d.0, e.0, f.0, g.0, h.0]);
            [
                Self(a),
                Self(b),
                Self(c),
                Self(d),
                Self(e),
                Self(f),
                Self(g),
                Self(h),
            ]
        }
    }

    /// Four rows to four columns, in each half of the registers.
    #[inline(always)]
    fn transpose_halves([a, b, c, d]: [__m256; 4]) -> [__m256; 4] {
        // SAFETY: called by methods of `Avx2` only, see above.
        unsafe {
            let (ab_lo, ab_hi) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
            let (cd_lo, cd_hi) = (_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
            [
                _mm256_shuffle_ps::<0x44>(ab_lo, cd_lo),
                _mm256_shuffle_ps::<0xEE>(ab_lo, cd_lo),
                _mm256_shuffle_ps::<0x44>(ab_hi, cd_hi),
                _mm256_shuffle_ps::<0xEE>(ab_hi, cd_hi),
            ]
        }
    }

    /// Rows to columns.
    #[inline(always)]
    fn transpose_avx2([a, b, c, d, e, f, g, h]: [__m256; 8]) -> [__m256; 8] {
        let [p, q, r, s] = transpose_halves([a, b, c, d]);
        let [t, u, v, w] = transpose_halves([e, f, g, h]);
        // SAFETY: called by methods of `Avx2` only, see above.
        unsafe {
            [
                _mm256_permute2f128_ps::<0x20>(p, t),
                _mm256_permute2f128_ps::<0x20>(q, u),
                _mm256_permute2f128_ps::<0x20>(r, v),
                _mm256_permute2f128_ps::<0x20>(s, w),
                _mm256_permute2f128_ps::<0x31>(p, t),
                _mm256_permute2f128_ps::<0x31>(q, u),
                _mm256_permute2f128_ps::<0x31>(r, v),
                _mm256_permute2f128_ps::<0x31>(s, w),
            ]
        }
    }

    // SAFETY of all blocks below for `Sse2`: SSE2 is part of x86-64. Loads and stores are unaligned ones of either half of `F8`,
    // which is 32 bytes of `f32`.
    operators! { Sse2,
        // SAFETY: see above.
        Add add: |a, b| unsafe { Self(_mm_add_ps(a.0, b.0), _mm_add_ps(a.1, b.1)) };
        // SAFETY: see above.
        Sub sub: |a, b| unsafe { Self(_mm_sub_ps(a.0, b.0), _mm_sub_ps(a.1, b.1)) };
        // SAFETY: see above.
        Mul mul: |a, b| unsafe { Self(_mm_mul_ps(a.0, b.0), _mm_mul_ps(a.1, b.1)) };
        // SAFETY: see above.
        Div div: |a, b| unsafe { Self(_mm_div_ps(a.0, b.0), _mm_div_ps(a.1, b.1)) };
    }

    impl Lanes for Sse2 {
        #[inline(always)]
        fn splat(x: f32) -> Self {
            // SAFETY: see above.
            let x = unsafe { _mm_set1_ps(x) };
            Self(x, x)
        }

        #[inline(always)]
        fn load(from: &F8) -> Self {
            let from = from.0.as_ptr();
            // SAFETY: see above.
            unsafe { Self(_mm_loadu_ps(from), _mm_loadu_ps(from.add(4))) }
        }

        #[inline(always)]
        fn store(self, to: &mut F8) {
            let to = to.0.as_mut_ptr();
            // SAFETY: see above.
            unsafe {
                _mm_storeu_ps(to, self.0);
                _mm_storeu_ps(to.add(4), self.1);
            }
        }

        #[inline(always)]
        fn min(self, other: Self) -> Self {
            // SAFETY: see above.
            unsafe { Self(_mm_min_ps(self.0, other.0), _mm_min_ps(self.1, other.1)) }
        }

        #[inline(always)]
        fn max(self, other: Self) -> Self {
            // SAFETY: see above.
            unsafe { Self(_mm_max_ps(self.0, other.0), _mm_max_ps(self.1, other.1)) }
        }

        #[inline(always)]
        fn sqrt(self) -> Self {
            // SAFETY: see above.
            unsafe { Self(_mm_sqrt_ps(self.0), _mm_sqrt_ps(self.1)) }
        }

        #[inline(always)]
        fn if_above(self, bound: Self, yes: Self, no: Self) -> Self {
            // SAFETY: see above.
            let select = |a, b, yes, no| unsafe {
                let is_above = _mm_cmpgt_ps(a, b);
                _mm_or_ps(_mm_and_ps(is_above, yes), _mm_andnot_ps(is_above, no))
            };
            Self(
                select(self.0, bound.0, yes.0, no.0),
                select(self.1, bound.1, yes.1, no.1),
            )
        }

        #[inline(always)]
        fn is_any_above(self, bound: Self) -> bool {
            // SAFETY: see above.
            let above = |a, b| unsafe { _mm_movemask_ps(_mm_cmpgt_ps(a, b)) };
            above(self.0, bound.0) | above(self.1, bound.1) != 0
        }

        #[inline(always)]
        fn transpose([a, b, c, d, e, f, g, h]: [Self; 8]) -> [Self; 8] {
            let [p, q, r, s] = transpose_sse2([a.0, b.0, c.0, d.0]);
            let [t, u, v, w] = transpose_sse2([a.1, b.1, c.1, d.1]);
            let [i, j, k, l] = transpose_sse2([e.0, f.0, g.0, h.0]);
            let [m, n, o, x] = transpose_sse2([e.1, f.1, g.1, h.1]);
            [
                Self(p, i),
                Self(q, j),
                Self(r, k),
                Self(s, l),
                Self(t, m),
                Self(u, n),
                Self(v, o),
                Self(w, x),
            ]
        }
    }

    /// Rows to columns.
    #[inline(always)]
    fn transpose_sse2([a, b, c, d]: [__m128; 4]) -> [__m128; 4] {
        // SAFETY: see above.
        unsafe {
            let (ab_lo, ab_hi) = (_mm_unpacklo_ps(a, b), _mm_unpackhi_ps(a, b));
            let (cd_lo, cd_hi) = (_mm_unpacklo_ps(c, d), _mm_unpackhi_ps(c, d));
            [
                _mm_movelh_ps(ab_lo, cd_lo),
                _mm_movehl_ps(cd_lo, ab_lo),
                _mm_movelh_ps(ab_hi, cd_hi),
                _mm_movehl_ps(cd_hi, ab_hi),
            ]
        }
    }
}
