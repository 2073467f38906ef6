//! 32-bit implicit KD-tree code of a point in a body's box.
//!
//! A box is halved 32 times, in turn along x, y, z, x, ...; bit 31 says on which side of the first split plane a point
//! lies, bit 0 on which side of the last. No tree is stored: the code is the path to a leaf. x and y are halved 11
//! times and z 10 times, so a leaf of a box with edges `L` measures `(L.x / 2^11, L.y / 2^11, L.z / 2^10)`.
//!
//! # References
//! "Constraint-Based Physics With Real-Time Object Slicing", which names contacts by this code to find last step's
//! multipliers again. The shifted grid of [`KdBox::around`] is ours.

use crate::math::Aabb;
use glam::{DVec3, UVec3, Vec3};

/// Halvings along x, y, z.
const BITS: [u32; 3] = [11, 11, 10];

/// Cells along x, y, z: `2^11`, `2^11`, `2^10`.
pub(crate) const CELLS: UVec3 = UVec3::new(1 << BITS[0], 1 << BITS[1], 1 << BITS[2]);

/// How far the code box reaches below the hull's box, as a fraction of its edge: `(sqrt 3 - 1) / 40`.
///
/// Together with [`PAD_ABOVE`] it keeps every point of the hull's box at a fraction n/2, n/3, n/4, n/6 or n/8 of an
/// edge (corners, middles, thirds: where boxes, bricks and their pieces touch) at least 0.40 cells of an edge's 2048
/// away from a split plane (0.20 cells of 1024). On an unshifted grid such a point lies exactly on a split plane and
/// jitter of any size changes its code every other step.
pub(crate) const PAD_BELOW: f32 = 0.018_301_27;

/// How far the code box reaches above the hull's box, as a fraction of its edge: `(sqrt 5 - 2) / 24`.
pub(crate) const PAD_ABOVE: f32 = 0.009_836_166;

/// The path to a leaf of the implicit KD-tree over a box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct KdCode(pub u32);

impl KdCode {
    /// The code of the leaf that is number `cell.x` along x, `cell.y` along y, `cell.z` along z, each clamped to the
    /// leaves that exist (`CELLS`).
    pub fn from_cell(cell: UVec3) -> Self {
        let cell = cell.min(CELLS - 1);
        Self(
            spread(cell.x) << 1 // x ends at bit 1: splits 0, 3, ..., 30 of 32
                | spread(cell.y) // y ends at bit 0: splits 1, 4, ..., 31
                | spread(cell.z) << 2, // z ends at bit 2: splits 2, 5, ..., 29
        )
    }

    /// Number of the leaf along x, y, z.
    pub fn cell(self) -> UVec3 {
        UVec3::new(gather(self.0 >> 1), gather(self.0), gather(self.0 >> 2))
    }
}

/// The box that codes refer to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KdBox {
    /// Lower corner, m.
    pub min: Vec3,
    /// Edge lengths, m.
    pub extents: Vec3,
}

impl KdBox {
    /// The code box of a body whose hull has the given bounding box.
    ///
    /// Larger than `aabb` by `PAD_BELOW` and `PAD_ABOVE`, so that contacts on the boundary lie inside and
    /// symmetric places stay away from split planes.
    pub fn around(aabb: Aabb) -> Self {
        let edges = aabb.extents();
        Self {
            min: aabb.min - PAD_BELOW * edges,
            extents: edges * (1.0 + PAD_BELOW + PAD_ABOVE),
        }
    }

    /// Edge lengths of a leaf: `(L.x / 2^11, L.y / 2^11, L.z / 2^10)`, m.
    pub fn cell_size(&self) -> Vec3 {
        self.extents / CELLS.as_vec3()
    }

    /// The code of the leaf that contains `point` (m, frame of the box); points outside go to the nearest leaf.
    ///
    /// A NaN coordinate, or a box without extent along an axis, gives leaf 0 on that axis.
    pub fn encode(&self, point: Vec3) -> KdCode {
        // In f64 the difference is exact to 2^-53, so that rounding never moves a point by more than 1e-12 of a leaf.
        let inside = (point.as_dvec3() - self.min.as_dvec3()) / self.extents.as_dvec3();
        let scaled = inside * CELLS.as_dvec3();
        // `as` maps NaN and negative numbers to 0 and saturates at the other end.
        KdCode::from_cell(UVec3::new(
            scaled.x as u32,
            scaled.y as u32,
            scaled.z as u32,
        ))
    }

    /// The leaf that `code` names, m, frame of the box.
    pub fn decode(&self, code: KdCode) -> Aabb {
        let lower = code.cell();
        Aabb {
            min: self.corner(lower),
            max: self.corner(lower + 1),
        }
    }

    /// Midpoint of the leaf that `code` names, m, frame of the box.
    pub fn decode_center(&self, code: KdCode) -> Vec3 {
        self.min + (code.cell().as_vec3() + 0.5) * self.cell_size()
    }

    /// Point of the grid of leaves.
    fn corner(&self, number: UVec3) -> Vec3 {
        let fraction: DVec3 = number.as_dvec3() / CELLS.as_dvec3();
        (self.min.as_dvec3() + fraction * self.extents.as_dvec3()).as_vec3()
    }
}

/// Bit i of an 11-bit number moved to bit 3 i, in four doublings of the gaps.
fn spread(bits: u32) -> u32 {
    let word = (bits | bits << 16) & 0x0700_00ff;
    let word = (word | word << 8) & 0x0700_f00f;
    let word = (word | word << 4) & 0x430c_30c3;
    (word | word << 2) & 0x4924_9249
}

/// Every third bit of `word`, bit 3 i moved to bit i: the inverse of [`spread`].
fn gather(word: u32) -> u32 {
    let word = word & 0x4924_9249;
    let word = (word | word >> 2) & 0x430c_30c3;
    let word = (word | word >> 4) & 0x0700_f00f;
    let word = (word | word >> 8) & 0x0700_00ff;
    (word | word >> 16) & 0x7ff
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in `0..1` that do not need a crate: Weyl sequences of three irrational steps.
    fn points() -> impl Iterator<Item = Vec3> {
        (1..4000).map(|i| {
            let step = |a: f64| (i as f64 * a).fract() as f32;
            Vec3::new(
                step(0.819_172_513),
                step(0.671_043_606),
                step(0.549_700_477),
            )
        })
    }

    fn a_box() -> KdBox {
        KdBox::around(Aabb {
            min: Vec3::new(-0.3, -2.0, 4.0),
            max: Vec3::new(0.7, 1.0, 4.5),
        })
    }

    /// The definition: halve the box 32 times along x, y, z, x, ... and write down the sides.
    fn code_by_bisection(b: &KdBox, point: Vec3) -> u32 {
        let (mut min, mut size) = (b.min.as_dvec3(), b.extents.as_dvec3());
        (0..32).fold(0, |code, level| {
            let axis = level % 3;
            size[axis] *= 0.5;
            let upper = f64::from(point[axis]) >= min[axis] + size[axis];
            if upper {
                min[axis] += size[axis];
            }
            code << 1 | u32::from(upper)
        })
    }

    #[test]
    fn code_is_the_sequence_of_bisections() {
        let b = a_box();
        for p in points() {
            let point = b.min + p * b.extents;
            assert_eq!(b.encode(point).0, code_by_bisection(&b, point), "{point}");
        }
    }

    #[test]
    fn decoded_cell_contains_the_point() {
        let b = a_box();
        // Corners of a leaf are rounded to f32: half an ulp of the largest coordinate of the box.
        let rounding = 0.5 * f32::EPSILON * 8.0;
        for p in points() {
            let point = b.min + p * b.extents;
            let cell = b.decode(b.encode(point));
            assert!(
                cell.fattened(rounding).contains(&Aabb::of_points([point])),
                "{point} {cell:?}"
            );
            assert_eq!(b.encode(cell.center()), b.encode(point));
        }
    }

    #[test]
    fn cell_measures_the_box_over_2048_2048_1024() {
        let b = KdBox {
            min: Vec3::ZERO,
            extents: Vec3::new(2048.0, 4096.0, 1024.0),
        };
        assert_eq!(b.cell_size(), Vec3::new(1.0, 2.0, 1.0));
        assert_eq!(b.decode(KdCode(u32::MAX)).max, b.extents);
        assert_eq!(b.decode(KdCode(0)).extents(), b.cell_size());
        assert_eq!(
            b.decode(KdCode(u32::MAX)).min,
            Vec3::new(2047.0, 4094.0, 1023.0)
        );
    }

    #[test]
    fn neighbors_share_a_face() {
        let b = a_box();
        for p in points().take(500) {
            let cell = b.encode(b.min + p * b.extents).cell();
            for axis in 0..3 {
                if cell[axis] + 1 == CELLS[axis] {
                    continue;
                }
                let mut next = cell;
                next[axis] += 1;
                let (here, there) = (
                    b.decode(KdCode::from_cell(cell)),
                    b.decode(KdCode::from_cell(next)),
                );
                assert_eq!(KdCode::from_cell(next).cell(), next);
                assert_eq!(here.max[axis], there.min[axis]);
            }
        }
    }

    #[test]
    fn points_outside_go_to_the_nearest_leaf() {
        let b = a_box();
        let far = Vec3::splat(1e9);
        assert_eq!(b.encode(far), KdCode(u32::MAX));
        assert_eq!(b.encode(-far), KdCode(0));
        assert_eq!(b.encode(Vec3::INFINITY), KdCode(u32::MAX));
    }

    #[test]
    fn nan_and_flat_boxes_are_safe() {
        let b = a_box();
        assert_eq!(b.encode(Vec3::NAN), KdCode(0));
        let flat = KdBox::around(Aabb {
            min: Vec3::ZERO,
            max: Vec3::new(1.0, 0.0, 1.0),
        });
        let code = flat.encode(Vec3::new(0.5, 0.0, 0.5));
        assert_eq!(code.cell().y, 0);
        assert!(flat.decode(code).min.is_finite());
        let nowhere = KdBox::around(Aabb::EMPTY);
        assert_eq!(nowhere.encode(Vec3::ONE), KdCode(0));
    }

    #[test]
    fn symmetric_places_stay_away_from_split_planes() {
        let b = KdBox::around(Aabb {
            min: Vec3::ZERO,
            max: Vec3::ONE,
        });
        for parts in [2, 3, 4, 6, 8] {
            for n in 0..=parts {
                let place = Vec3::splat(n as f32 / parts as f32);
                let cells = (place - b.min) / b.cell_size();
                let gap = (cells - cells.round()).abs();
                assert!(gap.x > 0.39 && gap.z > 0.19, "{n}/{parts}: {gap}");
            }
        }
    }
}
