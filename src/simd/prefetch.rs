//! Asking for memory before it is read.
//!
//! Where a list is read in another order than it lies in memory, the processor does not foresee what comes next and waits for
//! each piece; in a scene that is larger than its caches that is most of what some passes do.
#![allow(
    unsafe_code,
    reason = "the processor's hint; the block says why it is sound"
)]

/// Bytes of a cache line.
#[cfg(target_arch = "x86_64")]
const LINE: usize = 64;

/// Asks for `value` to be brought near, on processors that can be asked: it will be read soon.
#[inline(always)]
pub(crate) fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let first = std::ptr::from_ref(value).cast::<i8>();
        for at in (0..size_of::<T>()).step_by(LINE) {
            // SAFETY: `at` is within the value. A hint neither reads nor writes, and has no effect but on time.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(first.add(at)) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Under AddressSanitizer and valgrind this shows that no byte beyond the values is touched.
    #[test]
    fn values_of_any_size_stay_as_they_are() {
        let bytes: Vec<u8> = (0..=255).collect();
        bytes.iter().for_each(prefetch);
        let large = Box::new([7_u32; 100]);
        prefetch(&*large);
        prefetch(&());
        assert!(bytes.iter().copied().eq(0..=255) && large.iter().all(|&x| x == 7));
    }
}
