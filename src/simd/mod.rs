//! Several numbers at a time, with whatever the processor has, and prefetching memory before it is read.
//!
//! `lanes.rs` has the trait that loops over eight numbers are written for, and its plain form; `x86.rs` the forms for AVX2, AVX-512VL and
//! SSE2, `wasm.rs` that for WebAssembly; `dispatch.rs` decides at run time which one a kernel runs with. `float4.rs` and `doubles.rs` are for geometry and rotation,
//! `vec3.rs` for vectors of any of them, `prefetch.rs` for memory.
//!
//! All forms round every operation on its own and in the same order, so they give the same bits. Must not know what the numbers
//! mean. Read `lanes.rs` first.

pub(crate) mod dispatch;
pub(crate) mod doubles;
pub(crate) mod float4;
pub(crate) mod lanes;
pub(crate) mod prefetch;
pub(crate) mod vec3;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
pub(crate) mod wasm;
#[cfg(target_arch = "x86_64")]
pub(crate) mod x86;
