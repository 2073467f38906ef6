//! The operations of the other crates.

use crate::kernel::{self, Ops, Scene};
use bevy_cleave::testing::simd::F8;
use fearless_simd::prelude::*;
use fearless_simd::{Level, f32x8};
use pulp::x86::V3;
use std::arch::x86_64::__m256;

#[derive(Clone, Copy)]
struct Fearless<S>(S);

impl<S: fearless_simd::Simd> Ops for Fearless<S> {
    type V = f32x8<S>;

    #[inline(always)]
    fn splat(self, x: f32) -> Self::V {
        self.0.splat_f32x8(x)
    }

    #[inline(always)]
    fn load(self, from: &F8) -> Self::V {
        f32x8::load_array_ref(self.0, &from.0)
    }

    #[inline(always)]
    fn store(self, x: Self::V, to: &mut F8) {
        x.store_array(&mut to.0);
    }

    #[inline(always)]
    fn add(self, a: Self::V, b: Self::V) -> Self::V {
        self.0.add_f32x8(a, b)
    }

    #[inline(always)]
    fn sub(self, a: Self::V, b: Self::V) -> Self::V {
        self.0.sub_f32x8(a, b)
    }

    #[inline(always)]
    fn mul(self, a: Self::V, b: Self::V) -> Self::V {
        self.0.mul_f32x8(a, b)
    }

    #[inline(always)]
    fn div(self, a: Self::V, b: Self::V) -> Self::V {
        self.0.div_f32x8(a, b)
    }

    #[inline(always)]
    fn max(self, a: Self::V, b: Self::V) -> Self::V {
        self.0.max_f32x8(a, b)
    }

    #[inline(always)]
    fn sqrt(self, a: Self::V) -> Self::V {
        self.0.sqrt_f32x8(a)
    }

    #[inline(always)]
    fn if_above(self, a: Self::V, b: Self::V, yes: Self::V, no: Self::V) -> Self::V {
        self.0.select_f32x8(self.0.simd_gt_f32x8(a, b), yes, no)
    }

    /// There is none: three rounds of rows interleaved with those four further on.
    #[inline(always)]
    fn transpose(self, rows: [Self::V; 8]) -> [Self::V; 8] {
        self.round(self.round(self.round(rows)))
    }
}

impl<S: fearless_simd::Simd> Fearless<S> {
    #[inline(always)]
    fn round(self, r: [f32x8<S>; 8]) -> [f32x8<S>; 8] {
        let (a, b) = self.0.interleave_f32x8(r[0], r[4]);
        let (c, d) = self.0.interleave_f32x8(r[1], r[5]);
        let (e, f) = self.0.interleave_f32x8(r[2], r[6]);
        let (g, h) = self.0.interleave_f32x8(r[3], r[7]);
        [a, b, c, d, e, f, g, h]
    }
}

pub(crate) fn fearless(scene: &mut Scene, level: Level) {
    fearless_simd::dispatch!(level, simd => kernel::sweep(Fearless(simd), scene));
}

/// Any of its kinds whose numbers come in eights.
#[derive(Clone, Copy)]
struct Pulp<S>(S);

impl<S: Turn> Ops for Pulp<S> {
    type V = pulp::f32x8;

    #[inline(always)]
    fn splat(self, x: f32) -> Self::V {
        self.0.splat_f32s(x)
    }

    #[inline(always)]
    fn load(self, from: &F8) -> Self::V {
        pulp::cast(from.0)
    }

    #[inline(always)]
    fn store(self, x: Self::V, to: &mut F8) {
        to.0 = pulp::cast(x);
    }

    #[inline(always)]
    fn add(self, a: Self::V, b: Self::V) -> Self::V {
        self.0.add_f32s(a, b)
    }

    #[inline(always)]
    fn sub(self, a: Self::V, b: Self::V) -> Self::V {
        self.0.sub_f32s(a, b)
    }

    #[inline(always)]
    fn mul(self, a: Self::V, b: Self::V) -> Self::V {
        self.0.mul_f32s(a, b)
    }

    #[inline(always)]
    fn div(self, a: Self::V, b: Self::V) -> Self::V {
        self.0.div_f32s(a, b)
    }

    #[inline(always)]
    fn max(self, a: Self::V, b: Self::V) -> Self::V {
        self.0.max_f32s(a, b)
    }

    #[inline(always)]
    fn sqrt(self, a: Self::V) -> Self::V {
        self.0.sqrt_f32s(a)
    }

    #[inline(always)]
    fn if_above(self, a: Self::V, b: Self::V, yes: Self::V, no: Self::V) -> Self::V {
        self.0.select_f32s(self.0.greater_than_f32s(a, b), yes, no)
    }

    #[inline(always)]
    fn transpose(self, rows: [Self::V; 8]) -> [Self::V; 8] {
        self.0.turn(rows)
    }
}

/// Rows to columns: there is none, nor anything that all of its kinds have that it could be made of.
trait Turn: pulp::Simd<f32s = pulp::f32x8> {
    fn turn(self, rows: [pulp::f32x8; 8]) -> [pulp::f32x8; 8];
}

impl Turn for pulp::Scalar256b {
    #[inline(always)]
    fn turn(self, rows: [pulp::f32x8; 8]) -> [pulp::f32x8; 8] {
        let rows: [[f32; 8]; 8] = pulp::cast(rows);
        let mut columns = [[0.0_f32; 8]; 8];
        for (at, row) in rows.iter().enumerate() {
            for (column, number) in columns.iter_mut().zip(row) {
                column[at] = *number;
            }
        }
        pulp::cast(columns)
    }
}

impl Turn for V3 {
    /// Of the processor's instructions, which its tokens make safe to call.
    #[inline(always)]
    fn turn(self, rows: [pulp::f32x8; 8]) -> [pulp::f32x8; 8] {
        let r: [__m256; 8] = pulp::cast(rows);
        let [p, q, s, t] = four_by_four(self, [r[0], r[1], r[2], r[3]]);
        let [u, v, w, x] = four_by_four(self, [r[4], r[5], r[6], r[7]]);
        let avx = self.avx;
        pulp::cast([
            avx._mm256_permute2f128_ps::<0x20>(p, u),
            avx._mm256_permute2f128_ps::<0x20>(q, v),
            avx._mm256_permute2f128_ps::<0x20>(s, w),
            avx._mm256_permute2f128_ps::<0x20>(t, x),
            avx._mm256_permute2f128_ps::<0x31>(p, u),
            avx._mm256_permute2f128_ps::<0x31>(q, v),
            avx._mm256_permute2f128_ps::<0x31>(s, w),
            avx._mm256_permute2f128_ps::<0x31>(t, x),
        ])
    }
}

/// Four rows to four columns, in each half of the registers.
#[inline(always)]
fn four_by_four(v3: V3, [a, b, c, d]: [__m256; 4]) -> [__m256; 4] {
    let avx = v3.avx;
    let (ab, cd) = (avx._mm256_unpacklo_ps(a, b), avx._mm256_unpacklo_ps(c, d));
    let (ab_high, cd_high) = (avx._mm256_unpackhi_ps(a, b), avx._mm256_unpackhi_ps(c, d));
    [
        avx._mm256_shuffle_ps::<0x44>(ab, cd),
        avx._mm256_shuffle_ps::<0xEE>(ab, cd),
        avx._mm256_shuffle_ps::<0x44>(ab_high, cd_high),
        avx._mm256_shuffle_ps::<0xEE>(ab_high, cd_high),
    ]
}

/// A sweep that becomes part of the function with the processor's features, as a closure would not.
struct Sweep<'s, S>(&'s mut Scene, S);

impl<S: Turn> pulp::NullaryFnOnce for Sweep<'_, S> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        kernel::sweep(Pulp(self.1), self.0);
    }
}

pub(crate) fn pulp_avx2(scene: &mut Scene, v3: V3) {
    v3.vectorize(Sweep(scene, v3));
}

pub(crate) fn pulp_scalar(scene: &mut Scene) {
    pulp::NullaryFnOnce::call(Sweep(scene, pulp::Scalar256b));
}
