//! Several numbers at a time, with whatever the processor has, and asking for memory before it is read.
//!
//! A loop is written once ([`lanes`]) and run with the registers that [`dispatch`] finds. Must not know what the numbers mean.

pub mod dispatch;
pub mod doubles;
pub(crate) mod float4;
pub mod lanes;
pub mod prefetch;
pub mod vec3;
#[cfg(target_arch = "x86_64")]
pub(crate) mod x86;
