//! Which registers a loop runs with: decided at run time, once for the whole crate.

use crate::simd::lanes::{Kernel, LaneWidth, Plain};
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
use crate::simd::wasm::TwoVectors;
#[cfg(target_arch = "x86_64")]
use crate::simd::x86::{Avx2, Avx512Vl, TwoRegisters};

/// Runs a loop with the widest registers that are there and allowed: AVX2 (8 lanes in one), the same with the 32 registers of
/// AVX-512VL, SSE2 or WebAssembly's `simd128` (4 lanes in each of two), or plain Rust.
#[inline]
pub fn run<K: Kernel>(width: LaneWidth, kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    match width {
        LaneWidth::Widest => {
            if K::NEEDS_32_REGISTERS
                && let Some(registers) = Avx512Vl::find()
            {
                return registers.run(kernel);
            }
            if let Some(registers) = Avx2::find() {
                return registers.run(kernel);
            }
            return kernel.run::<TwoRegisters>();
        }
        LaneWidth::Four => return kernel.run::<TwoRegisters>(),
        LaneWidth::One => {}
    }
    // What WebAssembly may use is settled when it is compiled: a program cannot ask.
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    if width != LaneWidth::One {
        return kernel.run::<TwoVectors>();
    }
    let _ = width;
    kernel.run::<Plain>()
}

/// Proof that AVX2 is there and allowed, for functions of their own that use it.
#[cfg(target_arch = "x86_64")]
#[inline]
pub(crate) fn find_avx2(width: LaneWidth) -> Option<Avx2> {
    (width == LaneWidth::Widest).then(Avx2::find).flatten()
}
