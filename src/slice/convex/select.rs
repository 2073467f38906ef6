//! Selecting from lists by side, eight elements at a time and without branches.
//!
//! There is no guessing which elements a part has, so that a branch for each costs more than the work. Of the eight
//! elements of a group there is one bit each in two bytes, one byte for each part; what is wanted of them is a byte again,
//! which names a row of a table.

use crate::simd::dispatch::run;
use crate::simd::lanes::{Kernel, LaneWidth, Lanes};

/// Elements of a group.
pub(super) const GROUP: usize = 8;

/// For each part a bit for each element of a group: whether the part has it. The first element's bit is the lowest; there
/// are none of elements beyond the end of a list.
pub(super) type Bits = [u8; 2];

/// One in each byte.
const ONES: u64 = 0x0101_0101_0101_0101;

/// Makes the lowest bits of eight bytes the bits of the highest byte, the first byte's lowest: byte `i` is multiplied by
/// `2^(56 - 7 i)`, which puts its bit at `56 + i`, and no two products meet in one bit.
const COLLECT: u64 = 0x0102_0408_1020_4080;

/// The bits of eight elements with these sides.
#[inline]
pub(super) fn bits_of(sides: [u8; GROUP]) -> Bits {
    let sides = u64::from_le_bytes(sides);
    [sides, sides >> 1].map(|part| ((part & ONES).wrapping_mul(COLLECT) >> 56) as u8)
}

/// Fills `bits` with those of elements with these sides.
pub(super) fn collect(sides: &[u8], bits: &mut Vec<Bits>) {
    let (groups, rest) = sides.as_chunks();
    bits.clear();
    bits.extend(groups.iter().map(|group| bits_of(*group)));
    if !rest.is_empty() {
        let mut last = [0; GROUP];
        last[..rest.len()].copy_from_slice(rest);
        bits.push(bits_of(last));
    }
}

/// What both parts have.
pub(super) fn both([below, above]: Bits) -> u8 {
    below & above
}

/// What no part has.
pub(super) fn neither([below, above]: Bits) -> u8 {
    !(below | above)
}

/// What only the part below has, what only the part above has, and what both or none have.
pub(super) fn each([below, above]: Bits) -> [u8; 3] {
    [below & !above, above & !below, !(below ^ above)]
}

/// For each byte the places of the bits that are set, ascending.
static PLACES: [[u32; GROUP]; 256] = places();

/// For each byte and place how many bits are set below it.
static RANKS: [[u32; GROUP]; 256] = ranks();

/// For each byte how many bits are set.
static COUNTS: [u8; 256] = counts();

const fn places() -> [[u32; GROUP]; 256] {
    let mut table = [[0; GROUP]; 256];
    let mut bits = 0;
    while bits < 256 {
        let (mut place, mut found) = (0, 0);
        while place < GROUP {
            if bits >> place & 1 == 1 {
                table[bits][found] = place as u32;
                found += 1;
            }
            place += 1;
        }
        bits += 1;
    }
    table
}

const fn ranks() -> [[u32; GROUP]; 256] {
    let mut table = [[0; GROUP]; 256];
    let mut bits = 0;
    while bits < 256 {
        let mut place = 1;
        while place < GROUP {
            table[bits][place] = table[bits][place - 1] + (bits >> (place - 1) & 1) as u32;
            place += 1;
        }
        bits += 1;
    }
    table
}

const fn counts() -> [u8; 256] {
    let mut table = [0; 256];
    let mut bits = 0;
    while bits < 256 {
        table[bits] = bits.count_ones() as u8;
        bits += 1;
    }
    table
}

/// Indices of the elements of a list that were selected, ascending.
#[derive(Clone, Debug, Default)]
pub(super) struct Selection {
    /// The indices, and behind them room.
    indices: Vec<u32>,
    count: usize,
}

/// Selects from a list of `count` elements with these bits; `wanted` says what of a group each selection gets.
#[inline]
pub(super) fn select<const N: usize>(
    selections: [&mut Selection; N],
    count: usize,
    bits: &[Bits],
    wanted: impl Fn(Bits) -> [u8; N],
) {
    let mut counts = [0; N];
    let mut lists = selections;
    if let Some((last, whole)) = bits.split_last() {
        let rooms = lists.each_mut().map(|list| list.restart(count));
        let mut first = 0;
        for &bits in whole {
            let wanted = wanted(bits);
            for list in 0..N {
                counts[list] += push(&mut rooms[list][counts[list]..], first, wanted[list]);
            }
            first += GROUP as u32;
        }
        let wanted = wanted(*last);
        let beyond = bits.len() * GROUP - count;
        for list in 0..N {
            let wanted = wanted[list] & u8::MAX >> beyond;
            counts[list] += push(&mut rooms[list][counts[list]..], first, wanted);
        }
    }
    for (list, count) in lists.into_iter().zip(counts) {
        list.count = count;
    }
}

/// Selects from a list and numbers what is selected in order; `wanted` says what of a group that is. The numbers of the
/// others mean nothing.
pub(super) fn select_and_number(
    width: LaneWidth,
    selection: &mut Selection,
    bits: &[Bits],
    wanted: impl Fn(Bits) -> u8,
    numbers: &mut [u32],
) {
    let numbering = Numbering {
        room: selection.restart(numbers.len()),
        bits,
        wanted,
        numbers,
    };
    selection.count = run(width, numbering);
}

/// What [`select_and_number`] works on.
struct Numbering<'a, W> {
    room: &'a mut [u32],
    bits: &'a [Bits],
    wanted: W,
    numbers: &'a mut [u32],
}

impl<W: Fn(Bits) -> u8> Kernel for Numbering<'_, W> {
    /// How many were selected.
    type Output = usize;
    const NEEDS_32_REGISTERS: bool = false;

    #[inline(always)]
    fn run<L: Lanes>(self) -> usize {
        let (groups, rest) = self.numbers.as_chunks_mut();
        let (mut first, mut count) = (0, 0);
        for (bits, numbers) in self.bits.iter().zip(groups) {
            let bits = (self.wanted)(*bits);
            *numbers = sums(&RANKS[usize::from(bits)], count as u32);
            count += push(&mut self.room[count..], first, bits);
            first += GROUP as u32;
        }
        if let (Some(bits), false) = (self.bits.last(), rest.is_empty()) {
            let bits = (self.wanted)(*bits);
            let ranks = sums(&RANKS[usize::from(bits)], count as u32);
            rest.copy_from_slice(&ranks[..rest.len()]);
            count += push(&mut self.room[count..], first, bits);
        }
        count
    }
}

/// Writes the elements of a group of which there are bits, and says how many. Behind them are others that are none, which
/// the next group writes over.
#[inline(always)]
fn push(room: &mut [u32], first: u32, bits: u8) -> usize {
    if let Some(room) = room.first_chunk_mut() {
        *room = sums(&PLACES[usize::from(bits)], first);
    }
    usize::from(COUNTS[usize::from(bits)])
}

/// Eight numbers with the same added to each.
#[inline(always)]
fn sums(numbers: &[u32; GROUP], added: u32) -> [u32; GROUP] {
    let mut sums = *numbers;
    for sum in &mut sums {
        *sum += added;
    }
    sums
}

impl Selection {
    /// The indices.
    pub(super) fn indices(&self) -> &[u32] {
        &self.indices[..self.count]
    }

    /// How many were selected.
    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// Room for `count` indices, and for those that the last group writes over the end.
    fn restart(&mut self, count: usize) -> &mut [u32] {
        if self.indices.len() < count + GROUP {
            self.indices.resize(count + GROUP, 0);
        }
        &mut self.indices
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::Rng;
    use rand_pcg::Pcg32;

    fn indices_where(sides: &[u8], is_wanted: impl Fn(u8) -> bool) -> Vec<u32> {
        let wanted = (0..).zip(sides).filter(|&(_, &side)| is_wanted(side));
        wanted.map(|(index, _)| index).collect()
    }

    #[test]
    fn what_is_selected_is_what_a_loop_finds() {
        let mut dice = Pcg32::new(1, 1);
        let (mut bits, mut a, mut b, mut c) =
            <(Vec<_>, Selection, Selection, Selection)>::default();
        for count in 0..100 {
            let sides: Vec<u8> = (0..count)
                .map(|_| (dice.next_u32() >> 16) as u8 & 3)
                .collect();
            collect(&sides, &mut bits);
            select([&mut a, &mut b, &mut c], count, &bits, each);
            assert_eq!(a.indices(), indices_where(&sides, |s| s == 1));
            assert_eq!(b.indices(), indices_where(&sides, |s| s == 2));
            assert_eq!(c.indices(), indices_where(&sides, |s| s == 0 || s == 3));
            select([&mut a, &mut b], count, &bits, |bits| {
                [both(bits), neither(bits)]
            });
            assert_eq!(a.indices(), indices_where(&sides, |s| s == 3));
            assert_eq!(b.indices(), indices_where(&sides, |s| s == 0));
        }
    }

    #[test]
    fn what_is_numbered_has_its_place_in_the_selection() {
        let mut dice = Pcg32::new(1, 1);
        let (mut bits, mut selection) = <(Vec<_>, Selection)>::default();
        for count in 0..100 {
            let sides: Vec<u8> = (0..count)
                .map(|_| (dice.next_u32() >> 16) as u8 & 3)
                .collect();
            collect(&sides, &mut bits);
            let widths = [LaneWidth::Four, LaneWidth::Widest];
            for (part, width) in [0, 1]
                .into_iter()
                .flat_map(|part| widths.map(|w| (part, w)))
            {
                let mut numbers = vec![u32::MAX; count];
                let has = |bits: Bits| bits[part];
                select_and_number(width, &mut selection, &bits, has, &mut numbers);
                let expected = indices_where(&sides, |side| side >> part & 1 == 1);
                assert_eq!(selection.indices(), expected);
                for (number, &index) in (0..).zip(&expected) {
                    assert_eq!(numbers[index as usize], number);
                }
            }
        }
    }
}
