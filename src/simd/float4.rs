//! Four `f32` in a register that all processors of x86-64 have, where the compiler does not find the instruction by itself.
#![allow(
    unsafe_code,
    reason = "processor intrinsics; every block says why it is sound"
)]

use glam::{Vec3, Vec4};

/// The smaller number of each lane, the first one on a tie.
#[inline(always)]
pub(crate) fn lower(a: Vec4, b: Vec4) -> Vec4 {
    // What `minps` says of a tie and of NaN is the same; the compiler does not find it by itself.
    #[cfg(target_arch = "x86_64")]
    // SAFETY: all processors of this kind have SSE.
    return unsafe { std::arch::x86_64::_mm_min_ps(b.into(), a.into()).into() };
    #[cfg(not(target_arch = "x86_64"))]
    Vec4::select(b.cmplt(a), b, a)
}

/// The larger number of each lane, the first one on a tie.
#[inline(always)]
pub(crate) fn higher(a: Vec4, b: Vec4) -> Vec4 {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: all processors of this kind have SSE.
    return unsafe { std::arch::x86_64::_mm_max_ps(b.into(), a.into()).into() };
    #[cfg(not(target_arch = "x86_64"))]
    Vec4::select(b.cmpgt(a), b, a)
}

/// Coordinates of four points, one axis after the other.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(crate) fn columns(points: [&Vec3; 4]) -> [[f32; 4]; 3] {
    use std::arch::x86_64::*;
    let [a, b, c, d] = points;
    // SAFETY: all processors of this kind have SSE2.
    let (x, y) = unsafe {
        let low = _mm_castsi128_ps(_mm_set_epi64x(x_and_y(b), x_and_y(a)));
        let high = _mm_castsi128_ps(_mm_set_epi64x(x_and_y(d), x_and_y(c)));
        (
            _mm_shuffle_ps::<0b10_00_10_00>(low, high),
            _mm_shuffle_ps::<0b11_01_11_01>(low, high),
        )
    };
    let [x, y] = [Vec4::from(x).to_array(), Vec4::from(y).to_array()];
    [x, y, [a.z, b.z, c.z, d.z]]
}

/// The first two coordinates of a point as they stand in memory.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn x_and_y(point: &Vec3) -> i64 {
    // SAFETY: a point is three `f32` (`repr(C)`), of which these eight bytes are the first two.
    unsafe { std::ptr::from_ref(point).cast::<i64>().read_unaligned() }
}

/// Coordinates of four points, one axis after the other.
#[cfg(not(target_arch = "x86_64"))]
#[inline(always)]
pub(crate) fn columns(points: [&Vec3; 4]) -> [[f32; 4]; 3] {
    [
        points.map(|point| point.x),
        points.map(|point| point.y),
        points.map(|point| point.z),
    ]
}
