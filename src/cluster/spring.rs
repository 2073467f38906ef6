//! Bonds as springs: how stiff they are, and what motions of their parts do.

use crate::cluster::network::Network;
use crate::cluster::sparse::{Block, transposed};
use crate::geometry::PartBond;
use glam::{DMat3, DVec3};

/// Shear modulus over Young's modulus: that of concrete and brick, and near that of steel.
const SHEAR: f64 = 0.4;

impl Network {
    /// Stiffness of the bonds: by bond, forces on its two parts by motions of its two parts.
    pub(super) fn springs<'n>(
        &'n self,
        is_broken: &'n [bool],
    ) -> impl Iterator<Item = (usize, [[Block; 2]; 2])> + 'n {
        let whole = (0..self.bonds.len()).filter(|&bond| !is_broken[bond]);
        whole.map(|bond| {
            let spring = self.spring(bond);
            let arms = self.arms(bond);
            let sides = arms.map(|arm| skew(-arm));
            let block = |i: usize, j: usize| {
                let sign = if i == j { 1.0 } else { -1.0 };
                // B = [1, -[r]x], and K = B^T diag(k, 0) B + diag(0, c).
                let (left, right) = (sides[i].transpose(), sides[j]);
                let corner = left * spring.along * right + spring.turning;
                blocks(
                    spring.along,
                    spring.along * right,
                    left * spring.along,
                    corner,
                    sign,
                )
            };
            (
                bond,
                [[block(0, 0), block(0, 1)], [block(1, 0), block(1, 1)]],
            )
        })
    }

    /// How motions of its parts strain a bond, transposed, and its stiffness.
    pub(super) fn strains(&self, bond: usize) -> ([Block; 2], Block) {
        let spring = self.spring(bond);
        let [a, b] = self.arms(bond).map(|arm| skew(-arm));
        let strain = |side: DMat3, sign: f64| {
            transposed(&blocks(
                DMat3::IDENTITY,
                side,
                DMat3::ZERO,
                DMat3::IDENTITY,
                sign,
            ))
        };
        let stiffness = blocks(spring.along, DMat3::ZERO, DMat3::ZERO, spring.turning, 1.0);
        ([strain(a, 1.0), strain(b, -1.0)], stiffness)
    }

    /// From the centers of its parts to the center of a bond, m.
    pub(super) fn arms(&self, bond: usize) -> [DVec3; 2] {
        let PartBond { center, parts, .. } = &self.bonds[bond];
        parts.map(|part| center.as_dvec3() - self.nodes[part as usize].center)
    }

    pub(super) fn spring(&self, bond: usize) -> Spring {
        let PartBond {
            normal,
            axis,
            half_extents,
            area,
            ..
        } = &self.bonds[bond];
        let (normal, axis) = (normal.as_dvec3(), axis.as_dvec3());
        let across = normal.cross(axis);
        let [a, b] = self.arms(bond);
        let length = (a - b).dot(normal).abs();
        let sides = half_extents.as_dvec2();
        let length = length.max(0.1 * sides.min_element());
        let area = f64::from(*area);
        let moments = area / 3.0 * sides * sides;
        let outer = |v: DVec3| DMat3::from_cols(v * v.x, v * v.y, v * v.z);
        let (n, u, v) = (outer(normal), outer(axis), outer(across));
        Spring {
            along: (n + (u + v) * SHEAR) * (area / length),
            turning: (u * moments.y + v * moments.x + n * (SHEAR * (moments.x + moments.y)))
                * (1.0 / length),
        }
    }
}

/// Stiffness of a bond at its center.
pub(super) struct Spring {
    /// Force by displacement.
    pub(super) along: DMat3,
    /// Moment by turn.
    pub(super) turning: DMat3,
}

/// `[v]x`.
fn skew(v: DVec3) -> DMat3 {
    DMat3::from_cols(
        DVec3::new(0.0, v.z, -v.y),
        DVec3::new(-v.z, 0.0, v.x),
        DVec3::new(v.y, -v.x, 0.0),
    )
}

/// Four blocks of three by three as one, times a sign.
fn blocks(a: DMat3, b: DMat3, c: DMat3, d: DMat3, sign: f64) -> Block {
    let mut block = [[0.0; 6]; 6];
    for i in 0..3 {
        for j in 0..3 {
            block[i][j] = sign * a.col(j)[i];
            block[i][j + 3] = sign * b.col(j)[i];
            block[i + 3][j] = sign * c.col(j)[i];
            block[i + 3][j + 3] = sign * d.col(j)[i];
        }
    }
    block
}
