//! Tables of a hull's edges with the gathers of AVX2.
#![allow(
    unsafe_code,
    reason = "processor intrinsics; every block says why it is sound"
)]

use crate::geometry::Edge;
use crate::geometry::edge_tables::{EdgeRenumbering, GROUP};
use std::arch::x86_64::*;

/// A list that eight numbers at a time are looked up in.
#[derive(Clone, Copy)]
pub(super) struct GatherTable<'t> {
    numbers: &'t [u32],
    /// The last place in the list.
    last: i32,
}

impl<'t> GatherTable<'t> {
    /// Nothing if the list has no last place that is a signed number of 32 bits, as the places of a gather are.
    #[inline]
    pub(super) fn new(numbers: &'t [u32]) -> Option<Self> {
        let last = i32::try_from(numbers.len().checked_sub(1)?).ok()?;
        Some(Self { numbers, last })
    }

    /// The numbers at eight places; the last one for a place that is not in the list.
    #[target_feature(enable = "avx2")]
    #[inline]
    fn look_up(self, places: __m256i) -> __m256i {
        let places = _mm256_min_epu32(places, _mm256_set1_epi32(self.last));
        // SAFETY: no place is negative or beyond the last one, which is in the list.
        unsafe { _mm256_i32gather_epi32::<4>(self.numbers.as_ptr().cast(), places) }
    }
}

#[target_feature(enable = "avx2")]
pub(super) fn renumber(numbers: &mut [u32], table: GatherTable<'_>) {
    let (groups, rest) = numbers.as_chunks_mut::<GROUP>();
    for group in groups {
        // SAFETY: eight `u32` are 32 bytes, which need no alignment here.
        let places = unsafe { _mm256_loadu_si256(group.as_ptr().cast()) };
        let found = table.look_up(places);
        // SAFETY: as above.
        unsafe { _mm256_storeu_si256(group.as_mut_ptr().cast(), found) };
    }
    for number in rest {
        *number = table.numbers[*number as usize];
    }
}

#[target_feature(enable = "avx2")]
pub(super) fn select_edges(
    edges: &[Edge],
    indices: &[u32],
    table: EdgeRenumbering<'_>,
    numbers: GatherTable<'_>,
    out: &mut [Edge],
) {
    let face = table.first_face as i32;
    let firsts = _mm256_setr_epi32(0, 0, face, face, 0, 0, face, face);
    let (pairs, last) = indices.as_chunks::<2>();
    let (out_pairs, out_last) = out[..indices.len()].as_chunks_mut::<2>();
    for (pair, out) in pairs.iter().zip(out_pairs) {
        let [a, b] = [&edges[pair[0] as usize], &edges[pair[1] as usize]];
        let places = _mm256_add_epi32(load_two(a, b), firsts);
        let found = numbers.look_up(places);
        // SAFETY: an `Edge` is four `u32`, its vertices and then its faces (`repr(C)`), any four are one, and two are
        // 32 bytes, which need no alignment here.
        unsafe { _mm256_storeu_si256(out.as_mut_ptr().cast(), found) };
    }
    for (&index, out) in last.iter().zip(out_last) {
        *out = table.look_up(&edges[index as usize]);
    }
}

/// A list of bytes that are looked up eight at a time.
#[derive(Clone, Copy)]
pub(super) struct Bytes<'t> {
    bytes: &'t [u8],
    /// Where the last four bytes begin.
    last: i32,
}

impl<'t> Bytes<'t> {
    /// Nothing if there are not four, or more than signed numbers of 32 bits can count.
    #[inline]
    pub(super) fn new(bytes: &'t [u8]) -> Option<Self> {
        let last = i32::try_from(bytes.len().checked_sub(4)?).ok()?;
        Some(Self { bytes, last })
    }

    /// The bytes at eight places, with others above them; zero for a place that is not in the list.
    #[target_feature(enable = "avx2")]
    #[inline]
    fn look_up(self, places: __m256i) -> __m256i {
        let from = _mm256_min_epu32(places, _mm256_set1_epi32(self.last));
        // SAFETY: four bytes are read from each place, none of which is negative or beyond the last four.
        let four = unsafe { _mm256_i32gather_epi32::<1>(self.bytes.as_ptr().cast(), from) };
        let bits_before = _mm256_slli_epi32::<3>(_mm256_sub_epi32(places, from));
        _mm256_srlv_epi32(four, bits_before)
    }
}

#[target_feature(enable = "avx2")]
pub(super) fn find_ends(groups: &[[Edge; GROUP]], sides: Bytes<'_>, bits: &mut [[u8; 2]]) {
    // Edges 0, 2, 4, 6 are in the lower halves, and 1, 3, 5, 7 in the upper ones.
    let order = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);
    for (group, bits) in groups.iter().zip(bits) {
        let [a, b, c, d] = [0, 2, 4, 6].map(|k| load_two(&group[k], &group[k + 1]));
        let lower = look_up_ends(sides, a, b);
        let upper = look_up_ends(sides, c, d);
        let from = _mm256_shuffle_ps::<0b10_00_10_00>(lower, upper);
        let to = _mm256_shuffle_ps::<0b11_01_11_01>(lower, upper);
        let either = _mm256_castps_si256(_mm256_or_ps(from, to));
        let either = _mm256_permutevar8x32_epi32(either, order);
        *bits = [
            _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_slli_epi32::<31>(either))) as u8,
            _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_slli_epi32::<30>(either))) as u8,
        ];
    }
}

/// Sides of the ends of four edges.
#[target_feature(enable = "avx2")]
#[inline]
fn look_up_ends(sides: Bytes<'_>, a: __m256i, b: __m256i) -> __m256 {
    let (a, b) = (_mm256_castsi256_ps(a), _mm256_castsi256_ps(b));
    let ends = _mm256_shuffle_ps::<0b01_00_01_00>(a, b);
    _mm256_castsi256_ps(sides.look_up(_mm256_castps_si256(ends)))
}

/// The numbers of two edges.
#[target_feature(enable = "avx2")]
#[inline]
fn load_two(a: &Edge, b: &Edge) -> __m256i {
    _mm256_set_m128i(load(b), load(a))
}

/// The numbers of an edge: its vertices, and then its faces.
#[target_feature(enable = "avx2")]
#[inline]
fn load(edge: &Edge) -> __m128i {
    // SAFETY: an `Edge` is four `u32` (`repr(C)`), which are 16 bytes and need no alignment here.
    unsafe { _mm_loadu_si128(std::ptr::from_ref(edge).cast()) }
}
