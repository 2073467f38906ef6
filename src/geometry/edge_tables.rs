//! Lists of a hull's edges and faces, looked up and renumbered eight at a time where the processor can.
#![allow(
    unsafe_code,
    reason = "calls of functions that need AVX2; every block says why it is sound"
)]

#[cfg(target_arch = "x86_64")]
mod x86;

use crate::geometry::Edge;
#[cfg(target_arch = "x86_64")]
use crate::simd::dispatch::find_avx2;
use crate::simd::lanes::LaneWidth;

/// Numbers or edges that are looked up side by side.
const GROUP: usize = 8;

/// Exchanges numbers for those that a table has for them. The table has every number.
pub(crate) fn renumber(width: LaneWidth, numbers: &mut [u32], table: &[u32]) {
    #[cfg(target_arch = "x86_64")]
    if let (Some(_), Some(table)) = (find_avx2(width), x86::GatherTable::new(table)) {
        // SAFETY: there is a proof that the processor has AVX2.
        return unsafe { x86::renumber(numbers, table) };
    }
    let _ = width;
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
    width: LaneWidth,
    edges: &[Edge],
    indices: &[u32],
    table: EdgeRenumbering<'_>,
    out: &mut [Edge],
) {
    #[cfg(target_arch = "x86_64")]
    if let (Some(_), Some(numbers)) = (find_avx2(width), x86::GatherTable::new(table.numbers)) {
        // SAFETY: there is a proof that the processor has AVX2.
        return unsafe { x86::select_edges(edges, indices, table, numbers, out) };
    }
    let _ = width;
    for (&index, out) in indices.iter().zip(out) {
        *out = table.look_up(&edges[index as usize]);
    }
}

/// For each of eight edges whether one of its ends has bit 0 in `sides`, and whether one has bit 1; as bits of two bytes,
/// that of the first edge the lowest. The last group may have fewer edges.
pub(crate) fn find_ends(width: LaneWidth, edges: &[Edge], sides: &[u8], bits: &mut [[u8; 2]]) {
    let (groups, rest) = edges.as_chunks::<GROUP>();
    #[cfg(target_arch = "x86_64")]
    let done = match (find_avx2(width), x86::Bytes::new(sides)) {
        (Some(_), Some(sides)) => {
            // SAFETY: there is a proof that the processor has AVX2.
            unsafe { x86::find_ends(groups, sides, bits) };
            groups.len()
        }
        _ => 0,
    };
    #[cfg(not(target_arch = "x86_64"))]
    let done = 0;
    let _ = width;
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

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::Rng;
    use rand_pcg::Pcg32;

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
            for width in [LaneWidth::Four, LaneWidth::Widest] {
                let mut found = numbers.clone();
                renumber(width, &mut found, &table);
                assert_eq!(found, expected);
                let mut ends = vec![[0; 2]; edges.len().div_ceil(GROUP)];
                find_ends(width, &edges, &sides, &mut ends);
                assert_eq!(ends, expected_ends);
                let mut found = vec![edges[0]; indices.len()];
                select_edges(width, &edges, &indices, of_edges, &mut found);
                assert_eq!(found, expected_edges);
            }
        }
    }
}
