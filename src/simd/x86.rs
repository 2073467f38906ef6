//! Registers of x86-64: proofs that the processor has them, and the lanes in them.
#![allow(
    unsafe_code,
    reason = "processor intrinsics; every block says why it is sound"
)]

use crate::simd::lanes::{F8, Kernel, Lanes, operators};
use std::arch::is_x86_feature_detected;
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Sub};

/// Proof that the processor has AVX2: there is none without asking it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2(());

impl Avx2 {
    /// Asks the processor.
    #[inline]
    pub(crate) fn find() -> Option<Self> {
        is_x86_feature_detected!("avx2").then_some(Self(()))
    }

    /// Runs a loop with AVX2.
    #[inline]
    pub(crate) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        // SAFETY: `self` is proof that the processor has AVX2.
        unsafe { run_avx2(kernel) }
    }
}

/// Proof that the processor has AVX-512VL, and with it AVX2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx512Vl(());

impl Avx512Vl {
    /// Asks the processor.
    #[inline]
    pub(crate) fn find() -> Option<Self> {
        is_x86_feature_detected!("avx512vl").then_some(Self(()))
    }

    /// Runs a loop with the registers of AVX2, of which there are twice as many here.
    #[inline]
    pub(crate) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        // SAFETY: `self` is proof that the processor has AVX-512VL.
        unsafe { run_avx512vl(kernel) }
    }
}

/// As [`run_avx2`], with 32 registers.
#[target_feature(enable = "avx2,avx512f,avx512vl")]
fn run_avx512vl<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<OneRegister>()
}

/// All that is inlined into this function may use AVX2.
#[target_feature(enable = "avx2")]
fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<OneRegister>()
}

/// Eight lanes in one register. Private to this module: values exist within [`run_avx2`] and [`run_avx512vl`] only.
#[derive(Clone, Copy)]
struct OneRegister(__m256);

/// Eight lanes in two registers.
#[derive(Clone, Copy)]
pub(crate) struct TwoRegisters(__m128, __m128);

// SAFETY of all blocks below for `OneRegister`: values of the type exist only within `run_avx2` and `run_avx512vl`, which run only
// where the processor has AVX2. Loads and stores are unaligned ones from and to `F8`, which is 32 bytes of `f32`.
operators! { OneRegister,
    // SAFETY: see above.
    Add add: |a, b| Self(unsafe { _mm256_add_ps(a.0, b.0) });
    // SAFETY: see above.
    Sub sub: |a, b| Self(unsafe { _mm256_sub_ps(a.0, b.0) });
    // SAFETY: see above.
    Mul mul: |a, b| Self(unsafe { _mm256_mul_ps(a.0, b.0) });
    // SAFETY: see above.
    Div div: |a, b| Self(unsafe { _mm256_div_ps(a.0, b.0) });
}

impl Lanes for OneRegister {
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
    // SAFETY: called by methods of `OneRegister` only, see above.
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
    // SAFETY: called by methods of `OneRegister` only, see above.
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

// SAFETY of all blocks below for `TwoRegisters`: SSE2 is part of x86-64. Loads and stores are unaligned ones of either half of `F8`,
// which is 32 bytes of `f32`.
operators! { TwoRegisters,
    // SAFETY: see above.
    Add add: |a, b| unsafe { Self(_mm_add_ps(a.0, b.0), _mm_add_ps(a.1, b.1)) };
    // SAFETY: see above.
    Sub sub: |a, b| unsafe { Self(_mm_sub_ps(a.0, b.0), _mm_sub_ps(a.1, b.1)) };
    // SAFETY: see above.
    Mul mul: |a, b| unsafe { Self(_mm_mul_ps(a.0, b.0), _mm_mul_ps(a.1, b.1)) };
    // SAFETY: see above.
    Div div: |a, b| unsafe { Self(_mm_div_ps(a.0, b.0), _mm_div_ps(a.1, b.1)) };
}

impl Lanes for TwoRegisters {
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
