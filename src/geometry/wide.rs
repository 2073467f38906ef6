//! Loops that registers of 256 bits make faster, where the processor has them.
//!
//! What a loop computes does not depend on the registers: there are no fused operations and no sums in another order. So
//! which one runs is decided at run time, and tests compare both.
#![allow(
    unsafe_code,
    reason = "processor intrinsics; every block says why it is sound"
)]

use crate::geometry::Edge;
use glam::{Vec3, Vec4};

/// Proof that the processor has AVX2: there is none without asking it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2(());

impl Avx2 {
    /// Asks the processor.
    #[inline]
    pub(crate) fn find() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            return Some(Self(()));
        }
        None
    }

    /// Runs a loop with AVX2.
    #[inline]
    pub(crate) fn run<L: Loop>(self, work: L) -> L::Output {
        #[cfg(target_arch = "x86_64")]
        {
            // SAFETY: `self` is proof that the processor has AVX2.
            unsafe { x86::run(work) }
        }
        #[cfg(not(target_arch = "x86_64"))]
        work.run()
    }
}

/// A loop that the compiler makes wider instructions of where they are there. `run` and all that it calls must be
/// `#[inline(always)]`, so that they become part of the function that has the processor's features.
pub(crate) trait Loop {
    /// What the loop comes to.
    type Output;
    /// The loop.
    fn run(self) -> Self::Output;
}

/// Runs a loop with the widest registers that are allowed.
#[inline]
pub(crate) fn run<L: Loop>(wide: Option<Avx2>, work: L) -> L::Output {
    match wide {
        Some(wide) => wide.run(work),
        None => work.run(),
    }
}

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

/// Triangles whose corners are all in a list of points, so that they are looked up without asking again.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TrianglesOf<'a> {
    points: &'a [Vec3],
    fours: &'a [[[u32; 3]; 4]],
}

impl<'a> TrianglesOf<'a> {
    /// Panics if there is no point for one of the corners.
    #[inline(always)]
    pub(crate) fn new(points: &'a [Vec3], fours: &'a [[[u32; 3]; 4]]) -> Self {
        let corners = fours.as_flattened().as_flattened();
        let last = corners.iter().fold(0, |last, &corner| last.max(corner));
        assert!(
            corners.is_empty() || (last as usize) < points.len(),
            "there is no point {last}"
        );
        Self { points, fours }
    }

    /// How many fours there are.
    #[inline(always)]
    pub(crate) fn len(self) -> usize {
        self.fours.len()
    }

    /// Coordinates of corner `k` of four triangles, one axis after the other.
    #[inline(always)]
    pub(crate) fn columns(self, four: usize, k: usize) -> [[f32; 4]; 3] {
        let [a, b, c, d] = self.fours[four];
        // SAFETY: `new` found that there is a point for every corner.
        unsafe {
            columns([
                self.points.get_unchecked(a[k] as usize),
                self.points.get_unchecked(b[k] as usize),
                self.points.get_unchecked(c[k] as usize),
                self.points.get_unchecked(d[k] as usize),
            ])
        }
    }
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

/// Numbers or edges that are looked up side by side.
const GROUP: usize = 8;

/// Exchanges numbers for those that a table has for them. The table has every number.
pub(crate) fn renumber(wide: Option<Avx2>, numbers: &mut [u32], table: &[u32]) {
    #[cfg(target_arch = "x86_64")]
    if let (Some(_), Some(table)) = (wide, x86::GatherTable::new(table)) {
        // SAFETY: there is a proof that the processor has AVX2.
        return unsafe { x86::renumber(numbers, table) };
    }
    let _ = wide;
    let (groups, rest) = numbers.as_chunks_mut::<GROUP>();
    for group in groups {
        for number in group {
            *number = table[*number as usize];
        }
    }
    for number in rest {
        *number = table[*number as usize];
    }
}

/// New numbers of vertices and of faces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeRenumbering<'t> {
    /// Those of the vertices, and from `first_face` on those of the faces.
    pub(crate) numbers: &'t [u32],
    /// Where the faces begin.
    pub(crate) first_face: usize,
}

impl<'t> EdgeRenumbering<'t> {
    /// New numbers of the vertices, and those of the faces.
    #[inline]
    pub(crate) fn split(&self) -> (&'t [u32], &'t [u32]) {
        self.numbers.split_at(self.first_face)
    }

    /// An edge under its new numbers.
    #[inline]
    pub(crate) fn look_up(&self, edge: &Edge) -> Edge {
        let (vertices, faces) = self.split();
        Edge {
            vertices: edge.vertices.map(|vertex| vertices[vertex as usize]),
            faces: edge.faces.map(|face| faces[face as usize]),
        }
    }
}

/// Fills `out` with the edges whose indices are given, under their new numbers. The table has every number.
pub(crate) fn select_edges(
    wide: Option<Avx2>,
    edges: &[Edge],
    indices: &[u32],
    table: EdgeRenumbering<'_>,
    out: &mut [Edge],
) {
    #[cfg(target_arch = "x86_64")]
    if let (Some(_), Some(numbers)) = (wide, x86::GatherTable::new(table.numbers)) {
        // SAFETY: there is a proof that the processor has AVX2.
        return unsafe { x86::select_edges(edges, indices, table, numbers, out) };
    }
    let _ = wide;
    for (&index, out) in indices.iter().zip(out) {
        *out = table.look_up(&edges[index as usize]);
    }
}

/// For each of eight edges whether one of its ends has bit 0 in `sides`, and whether one has bit 1; as bits of two bytes,
/// that of the first edge the lowest. The last group may have fewer edges.
pub(crate) fn find_ends(wide: Option<Avx2>, edges: &[Edge], sides: &[u8], bits: &mut [[u8; 2]]) {
    let (groups, rest) = edges.as_chunks::<GROUP>();
    #[cfg(target_arch = "x86_64")]
    let done = match (wide, x86::Bytes::new(sides)) {
        (Some(_), Some(sides)) => {
            // SAFETY: there is a proof that the processor has AVX2.
            unsafe { x86::find_ends(groups, sides, bits) };
            groups.len()
        }
        _ => 0,
    };
    #[cfg(not(target_arch = "x86_64"))]
    let done = 0;
    let _ = wide;
    let groups = groups[done..].iter().map(<[Edge; GROUP]>::as_slice);
    for (edges, bits) in groups.chain([rest]).zip(&mut bits[done..]) {
        let mut found = [0; 2];
        for (place, edge) in edges.iter().enumerate() {
            let [a, b] = edge.vertices.map(|vertex| sides[vertex as usize]);
            found[0] |= ((a | b) & 1) << place;
            found[1] |= ((a | b) >> 1 & 1) << place;
        }
        *bits = found;
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Edge, EdgeRenumbering, GROUP, Loop};
    use std::arch::x86_64::*;

    /// All that is inlined into this function may use AVX2.
    #[target_feature(enable = "avx2")]
    pub(super) fn run<L: Loop>(work: L) -> L::Output {
        work.run()
    }

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
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::Rng;
    use rand_pcg::Pcg32;

    #[test]
    fn corners_of_triangles_are_the_points_they_name() {
        let points: Vec<Vec3> = (0..7_u8)
            .map(|k| Vec3::new(0.0, 10.0, 20.0) + f32::from(k))
            .collect();
        let fours = [[[0, 1, 2], [3, 6, 4], [5, 0, 6], [6, 2, 1]]];
        let triangles = TrianglesOf::new(&points, &fours);
        for k in 0..3 {
            let expected = fours[0].map(|triangle| points[triangle[k] as usize]);
            let [x, y, z] = triangles.columns(0, k);
            for lane in 0..4 {
                assert_eq!(Vec3::new(x[lane], y[lane], z[lane]), expected[lane]);
            }
        }
    }

    #[test]
    #[should_panic(expected = "there is no point 7")]
    fn a_corner_without_a_point_is_found() {
        let _ = TrianglesOf::new(
            &[Vec3::ZERO; 7],
            &[[[0, 1, 2], [3, 6, 4], [5, 0, 6], [6, 7, 1]]],
        );
    }

    #[test]
    fn wide_and_narrow_registers_find_the_same_numbers() {
        let mut dice = Pcg32::new(1, 1);
        let mut below = |count: usize| (dice.next_u64() % count as u64) as u32;
        for count in 1..80_usize {
            let table: Vec<u32> = (0..count).map(|_| below(1 << 20)).collect();
            let numbers: Vec<u32> = (0..2 * count + 3).map(|_| below(count)).collect();
            let expected: Vec<u32> = numbers.iter().map(|&n| table[n as usize]).collect();
            let first_face = 1 + below(count) as usize;
            let table_of_edges: Vec<u32> = table.iter().copied().chain([7]).collect();
            let of_edges = EdgeRenumbering {
                numbers: &table_of_edges,
                first_face,
            };
            let faces = count + 1 - first_face;
            let edges: Vec<Edge> = (0..count + 3)
                .map(|_| Edge {
                    vertices: [0; 2].map(|_: u32| below(first_face)),
                    faces: [0; 2].map(|_: u32| below(faces)),
                })
                .collect();
            let indices: Vec<u32> = (0..count).map(|_| below(edges.len())).collect();
            let expected_edges: Vec<Edge> = (indices.iter())
                .map(|&index| of_edges.look_up(&edges[index as usize]))
                .collect();
            let sides: Vec<u8> = (0..first_face).map(|_| below(4) as u8).collect();
            let expected_ends: Vec<[u8; 2]> = (edges.chunks(GROUP))
                .map(|edges| {
                    let has = |edge: &Edge, bit: u8| {
                        (edge.vertices)
                            .map(|v| sides[v as usize] >> bit & 1)
                            .contains(&1)
                    };
                    [0, 1].map(|bit| {
                        let bits = (0..)
                            .zip(edges)
                            .map(|(k, edge)| u8::from(has(edge, bit)) << k);
                        bits.sum()
                    })
                })
                .collect();
            for wide in [None, Avx2::find()] {
                let mut found = numbers.clone();
                renumber(wide, &mut found, &table);
                assert_eq!(found, expected);
                let mut ends = vec![[0; 2]; edges.len().div_ceil(GROUP)];
                find_ends(wide, &edges, &sides, &mut ends);
                assert_eq!(ends, expected_ends);
                let mut found = vec![edges[0]; indices.len()];
                select_edges(wide, &edges, &indices, of_edges, &mut found);
                assert_eq!(found, expected_edges);
            }
        }
    }
}
