//! Vertices at one place, found by a table.

use glam::Vec3;

/// Numbers distinct positions in the order in which they first occur.
pub(super) fn weld(positions: &[Vec3]) -> Vec<u32> {
    const EMPTY: u32 = u32::MAX;
    // Adding +0.0 turns -0.0 into +0.0, after which equal numbers have equal bits.
    let bits = |position: Vec3| (position + Vec3::ZERO).to_array().map(f32::to_bits);
    // At most half full, so that runs of occupied places are short.
    let size = (2 * positions.len()).next_power_of_two();
    let mut vertex_at = vec![EMPTY; size];
    let mut topology = Vec::with_capacity(positions.len());
    let mut count = 0;
    for (vertex, &position) in (0..).zip(positions) {
        let key = bits(position);
        let mut place = scatter(key) as usize & (size - 1);
        let number = loop {
            match vertex_at[place] {
                EMPTY => {
                    vertex_at[place] = vertex;
                    count += 1;
                    break count - 1;
                }
                other if bits(positions[other as usize]) == key => {
                    break topology[other as usize];
                }
                _ => place = (place + 1) & (size - 1),
            }
        };
        topology.push(number);
    }
    topology
}

/// Spreads keys over numbers, so that those of points in a row or on a grid do not meet.
///
/// Multiplying by an odd number carries every bit of the key to the top of the product, and the shift brings the top down
/// to where the next product, or the reader, sees it. The numbers are the fractions of the golden ratio and of `sqrt(3)`.
fn scatter([x, y, z]: [u32; 3]) -> u64 {
    let mix = |word: u64, factor: u64| {
        let product = word.wrapping_mul(factor);
        product ^ product >> 32
    };
    let xy = mix(u64::from(x) << 32 | u64::from(y), 0x9e37_79b9_7f4a_7c15);
    mix(xy ^ u64::from(z), 0xbb67_ae85_84ca_a73b)
}

#[cfg(test)]
mod tests {
    use super::weld;
    use glam::Vec3;

    #[test]
    fn numbers_are_those_of_first_occurrences() {
        // Points of a grid about the origin in a mixed order, then their mirror images, whose zeros are negative.
        let grid = (0..729_u16).map(|cell| {
            let cell = cell * 64 % 729;
            let digit = |place: u16| f32::from(cell / place % 9) - 4.0;
            Vec3::new(digit(1), digit(9), digit(81))
        });
        let points: Vec<Vec3> = grid.clone().chain(grid.map(|point| -point)).collect();
        let mut distinct: Vec<Vec3> = Vec::new();
        let expected: Vec<u32> = (points.iter())
            .map(|point| {
                let known = distinct.iter().position(|p| p == point);
                known.unwrap_or_else(|| {
                    distinct.push(*point);
                    distinct.len() - 1
                }) as u32
            })
            .collect();
        assert_eq!(distinct.len(), 729);
        assert_eq!(weld(&points), expected);
        assert!(weld(&[]).is_empty());
    }
}
