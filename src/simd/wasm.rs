//! Registers of WebAssembly, in programs that are built with its `simd128`: four lanes in each of two.
#![allow(
    unsafe_code,
    reason = "loads and stores of vectors; every block says why it is sound"
)]

use crate::simd::lanes::{F8, Lanes, operators};
use std::arch::wasm32::*;
use std::ops::{Add, Div, Mul, Sub};

/// Eight lanes in two vectors.
#[derive(Clone, Copy)]
pub(crate) struct TwoVectors(v128, v128);

operators! { TwoVectors,
    Add add: |a, b| Self(f32x4_add(a.0, b.0), f32x4_add(a.1, b.1));
    Sub sub: |a, b| Self(f32x4_sub(a.0, b.0), f32x4_sub(a.1, b.1));
    Mul mul: |a, b| Self(f32x4_mul(a.0, b.0), f32x4_mul(a.1, b.1));
    Div div: |a, b| Self(f32x4_div(a.0, b.0), f32x4_div(a.1, b.1));
}

impl Lanes for TwoVectors {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self(f32x4_splat(x), f32x4_splat(x))
    }

    #[inline(always)]
    fn load(from: &F8) -> Self {
        let from = from.0.as_ptr().cast::<v128>();
        // SAFETY: `F8` is 32 bytes of `f32`, two vectors; a load need not be aligned.
        unsafe { Self(v128_load(from), v128_load(from.add(1))) }
    }

    #[inline(always)]
    fn store(self, to: &mut F8) {
        let to = to.0.as_mut_ptr().cast::<v128>();
        // SAFETY: as for a load.
        unsafe {
            v128_store(to, self.0);
            v128_store(to.add(1), self.1);
        }
    }

    // `pmin(a, b)` is `b < a ? b : a`, which with the operands exchanged is what `minps` of x86 says of ties and NaN.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(f32x4_pmin(other.0, self.0), f32x4_pmin(other.1, self.1))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(f32x4_pmax(other.0, self.0), f32x4_pmax(other.1, self.1))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(f32x4_sqrt(self.0), f32x4_sqrt(self.1))
    }

    #[inline(always)]
    fn if_above(self, bound: Self, yes: Self, no: Self) -> Self {
        Self(
            v128_bitselect(yes.0, no.0, f32x4_gt(self.0, bound.0)),
            v128_bitselect(yes.1, no.1, f32x4_gt(self.1, bound.1)),
        )
    }

    #[inline(always)]
    fn is_any_above(self, bound: Self) -> bool {
        v128_any_true(v128_or(
            f32x4_gt(self.0, bound.0),
            f32x4_gt(self.1, bound.1),
        ))
    }

    #[inline(always)]
    fn transpose([a, b, c, d, e, f, g, h]: [Self; 8]) -> [Self; 8] {
        let [p, q, r, s] = transpose_four([a.0, b.0, c.0, d.0]);
        let [t, u, v, w] = transpose_four([a.1, b.1, c.1, d.1]);
        let [i, j, k, l] = transpose_four([e.0, f.0, g.0, h.0]);
        let [m, n, o, x] = transpose_four([e.1, f.1, g.1, h.1]);
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
fn transpose_four([a, b, c, d]: [v128; 4]) -> [v128; 4] {
    let ab_low = i32x4_shuffle::<0, 4, 1, 5>(a, b);
    let ab_high = i32x4_shuffle::<2, 6, 3, 7>(a, b);
    let cd_low = i32x4_shuffle::<0, 4, 1, 5>(c, d);
    let cd_high = i32x4_shuffle::<2, 6, 3, 7>(c, d);
    [
        i64x2_shuffle::<0, 2>(ab_low, cd_low),
        i64x2_shuffle::<1, 3>(ab_low, cd_low),
        i64x2_shuffle::<0, 2>(ab_high, cd_high),
        i64x2_shuffle::<1, 3>(ab_high, cd_high),
    ]
}
