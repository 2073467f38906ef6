//! What a sustained load does to the bonds: forces and moments as in an elastic body, and what of them is too much.
//!
//! Parts are rigid, and bonds are springs as stiff as the material of half of both parts is: along the normal in
//! proportion to `A / L`, across it to 0.4 times that, in bending to `I / L`, with the area `A`, its second moments `I`
//! and the distance `L` of the two centers. Of all forces in the bonds that bear the loads these have the least energy. The stress
//! at the corner of a face is that of a beam: `N / A + M_1 e_2 / I_1 + M_2 e_1 / I_2`. So a cantilever breaks where the moment at its
//! root is the strength times the section modulus.
//!
//! What the loads of a body that nothing holds leave over accelerates it, and inertia is a load too (d'Alembert). The bond that
//! bears most over its strength breaks, and what is left is solved anew, until nothing more breaks or something comes off.

use crate::cluster::network::Network;
use crate::cluster::skyline::{Block, Six, Skyline};
use crate::geometry::PartBond;
use crate::geometry::groups_of;
use glam::{DMat3, DVec3};

/// Shear modulus over Young's modulus: that of concrete and brick, and near that of steel.
const SHEAR: f64 = 0.4;

/// Products of blocks up to which the system is factorised; beyond, conjugate gradients are faster.
const MOST_WORK: usize = 400_000;

/// Error of the forces, relative to the loads, that conjugate gradients leave.
const TOLERANCE: f64 = 1e-4;

/// Bonds break together that bear more than this share of what the one bears that bears most over its strength.
const TOGETHER: f64 = 0.98;

const NONE: u32 = u32::MAX;

/// Force and torque about the center of a part, frame of the compound, N and N m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Wrench {
    pub(crate) force: DVec3,
    pub(crate) torque: DVec3,
}

impl Wrench {
    pub(crate) fn add(&mut self, other: Self) {
        self.force += other.force;
        self.torque += other.torque;
    }

    pub(crate) fn scale(&mut self, by: f64) {
        self.force *= by;
        self.torque *= by;
    }
}

/// What a load does.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LoadOutcome {
    /// Bonds that broke, ascending.
    pub(crate) broken: Vec<u32>,
    /// The most that a bond that is left bears, as a share of its strength.
    pub(crate) utilization: f64,
}

impl Network {
    /// What `loads` (by part) do, besides inertia. `held`: by part, whether it holds on to the world; if none does, the body turns with
    /// `spin` (rad/s, frame of the compound).
    pub(crate) fn bear(&self, loads: &[Wrench], held: &[bool], spin: DVec3) -> LoadOutcome {
        let mut outcome = LoadOutcome::default();
        let mut is_broken = vec![false; self.bonds.len()];
        let mut loads = loads.to_vec();
        if !held.contains(&true) {
            self.add_inertia(&mut loads, spin);
        }
        loop {
            let motion = self.displacements(&loads, held, &is_broken);
            let shares: Vec<f64> = (0..self.bonds.len())
                .map(|bond| {
                    if is_broken[bond] {
                        0.0
                    } else {
                        self.utilization(bond, &motion)
                    }
                })
                .collect();
            outcome.utilization = shares.iter().copied().fold(0.0, f64::max);
            // Not a number: nothing is known, and nothing breaks.
            if outcome.utilization.is_nan() || outcome.utilization <= 1.0 {
                break;
            }
            let most = TOGETHER * outcome.utilization;
            for (is_broken, share) in is_broken.iter_mut().zip(&shares) {
                *is_broken |= *share >= most.max(1.0);
            }
            let groups = groups_of(self.nodes.len(), &self.bonds, |bond| is_broken[bond]);
            if groups.iter().any(|&group| group != 0) {
                break;
            }
        }
        let broken = (0..).zip(&is_broken).filter(|(_, broken)| **broken);
        outcome.broken = broken.map(|(bond, _)| bond).collect();
        outcome
    }

    /// Mass, center of mass and inertia about it.
    fn whole(&self) -> (f64, DVec3, DMat3) {
        let mass: f64 = self.nodes.iter().map(|node| node.mass).sum();
        let first: DVec3 = self.nodes.iter().map(|node| node.mass * node.center).sum();
        let center = first / mass;
        let inertia = self.nodes.iter().map(|node| {
            let arm = node.center - center;
            let outer = DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
            node.inertia
                + (DMat3::from_diagonal(DVec3::splat(arm.length_squared())) - outer) * node.mass
        });
        (
            mass,
            center,
            inertia.fold(DMat3::ZERO, |sum, own| sum + own),
        )
    }

    /// Adds what inertia does to each part of a body that the loads move.
    fn add_inertia(&self, loads: &mut [Wrench], spin: DVec3) {
        let (mass, center, inertia) = self.whole();
        let mut sum = Wrench::default();
        for (load, node) in loads.iter().zip(&self.nodes) {
            sum.force += load.force;
            sum.torque += load.torque + (node.center - center).cross(load.force);
        }
        let acceleration = sum.force / mass;
        let turning = inertia.inverse() * (sum.torque - spin.cross(inertia * spin));
        for (load, node) in loads.iter_mut().zip(&self.nodes) {
            let arm = node.center - center;
            let own = acceleration + turning.cross(arm) + spin.cross(spin.cross(arm));
            load.force -= node.mass * own;
            load.torque -= node.inertia * turning + spin.cross(node.inertia * spin);
        }
    }

    /// How the loads move the parts, for Young's modulus 1: displacements and turns.
    fn displacements(&self, loads: &[Wrench], held: &[bool], is_broken: &[bool]) -> Vec<Six> {
        let (order, number) = self.order(held, is_broken);
        let mut rows: Vec<Six> = order
            .iter()
            .map(|&part| {
                let Wrench { force, torque } = loads[part as usize];
                [force.x, force.y, force.z, torque.x, torque.y, torque.z]
            })
            .collect();
        let first = self.envelope(&order, &number, is_broken);
        if Skyline::work(&first) <= MOST_WORK {
            let mut system = Skyline::new(first);
            for (bond, blocks) in self.springs(is_broken) {
                let at = self.bonds[bond].parts.map(|part| number[part as usize]);
                for (i, &row) in at.iter().enumerate() {
                    for (j, &column) in at.iter().enumerate() {
                        if row != NONE && column != NONE && row >= column {
                            let to = system.block_mut(row as usize, column as usize);
                            add_block(to, &blocks[i][j]);
                        }
                    }
                }
            }
            system.factorise();
            system.solve(&mut rows);
        } else {
            self.iterate(&mut rows, &number, is_broken);
        }
        let mut motion = vec![[0.0; 6]; self.nodes.len()];
        for (row, &part) in rows.iter().zip(&order) {
            motion[part as usize] = *row;
        }
        motion
    }

    /// The parts that move, reversed from a search by breadth from what is held, or from a first part that then does not move; and by
    /// part its number in this order.
    fn order(&self, held: &[bool], is_broken: &[bool]) -> (Vec<u32>, Vec<u32>) {
        let count = self.nodes.len() as u32;
        let mut seen: Vec<bool> = held.to_vec();
        let mut order: Vec<u32> = (0..count).filter(|&part| held[part as usize]).collect();
        if order.is_empty() {
            let start = self.far_part(is_broken);
            seen[start as usize] = true;
            order.push(start);
        }
        let fixed = order.len();
        let mut next = 0;
        while let Some(&part) = order.get(next) {
            next += 1;
            for &bond in self.bonds_of(part) {
                let other = self.other(bond, part);
                if !is_broken[bond as usize] && !std::mem::replace(&mut seen[other as usize], true)
                {
                    order.push(other);
                }
            }
        }
        let mut order = order.split_off(fixed);
        order.reverse();
        let mut number = vec![NONE; self.nodes.len()];
        for (index, &part) in (0..).zip(&order) {
            number[part as usize] = index;
        }
        (order, number)
    }

    /// A part at an end of what hangs together with the first one.
    fn far_part(&self, is_broken: &[bool]) -> u32 {
        let mut seen = vec![false; self.nodes.len()];
        let mut order = vec![0];
        seen[0] = true;
        let mut next = 0;
        while let Some(&part) = order.get(next) {
            next += 1;
            for &bond in self.bonds_of(part) {
                let other = self.other(bond, part);
                if !is_broken[bond as usize] && !std::mem::replace(&mut seen[other as usize], true)
                {
                    order.push(other);
                }
            }
        }
        order.last().copied().unwrap_or(0)
    }

    fn envelope(&self, order: &[u32], number: &[u32], is_broken: &[bool]) -> Vec<u32> {
        (0..)
            .zip(order)
            .map(|(row, &part)| {
                let bonds = self.bonds_of(part).iter();
                let bonds = bonds.filter(|&&bond| !is_broken[bond as usize]);
                let columns = bonds.map(|&bond| number[self.other(bond, part) as usize]);
                columns.fold(row, u32::min)
            })
            .collect()
    }

    /// Stiffness of the bonds: by bond, forces on its two parts by motions of its two parts.
    fn springs<'n>(
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

    /// From the centers of its parts to the center of a bond, m.
    fn arms(&self, bond: usize) -> [DVec3; 2] {
        let PartBond { center, parts, .. } = &self.bonds[bond];
        parts.map(|part| center.as_dvec3() - self.nodes[part as usize].center)
    }

    fn spring(&self, bond: usize) -> Spring {
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

    /// What a bond bears after these motions, as a share of its strength.
    fn utilization(&self, bond: usize, motion: &[Six]) -> f64 {
        let PartBond {
            normal,
            axis,
            half_extents,
            area,
            strength,
            shear_strength,
            parts,
            ..
        } = &self.bonds[bond];
        let moved = parts.map(|part| motion[part as usize]);
        let split = |six: Six| {
            (
                DVec3::new(six[0], six[1], six[2]),
                DVec3::new(six[3], six[4], six[5]),
            )
        };
        let [(from_a, turn_a), (from_b, turn_b)] = moved.map(split);
        let [arm_a, arm_b] = self.arms(bond);
        let spring = self.spring(bond);
        let opened = (from_b + turn_b.cross(arm_b)) - (from_a + turn_a.cross(arm_a));
        let force = spring.along * opened;
        let moment = spring.turning * (turn_b - turn_a);
        let (normal, axis) = (normal.as_dvec3(), axis.as_dvec3());
        let across = normal.cross(axis);
        let (area, sides) = (f64::from(*area), half_extents.as_dvec2());
        let mean = force.dot(normal) / area;
        let bent = moment.dot(axis).abs() / sides.y + moment.dot(across).abs() / sides.x;
        let tension = mean + 3.0 * bent / area;
        let twisted = 3.0 * moment.dot(normal).abs() / (area * sides.length());
        let shear = force.reject_from_normalized(normal).length() / area + twisted;
        let bears = f64::from(*shear_strength) + f64::from(self.friction) * (-mean).max(0.0);
        (tension / f64::from(*strength)).max(shear / bears)
    }

    /// Conjugate gradients, preconditioned by the blocks of the diagonal.
    fn iterate(&self, rows: &mut [Six], number: &[u32], is_broken: &[bool]) {
        let springs: Vec<_> = self.springs(is_broken).collect();
        let mut diagonal: Vec<Skyline> = (0..rows.len()).map(|_| Skyline::new(vec![0])).collect();
        for (bond, blocks) in &springs {
            for (side, part) in self.bonds[*bond].parts.into_iter().enumerate() {
                if let Some(own) = diagonal.get_mut(number[part as usize] as usize) {
                    add_block(own.block_mut(0, 0), &blocks[side][side]);
                }
            }
        }
        diagonal.iter_mut().for_each(Skyline::factorise);
        let precondition = |r: &[Six]| {
            let mut z = r.to_vec();
            for (z, own) in z.iter_mut().zip(&diagonal) {
                own.solve(std::slice::from_mut(z));
            }
            z
        };
        let multiply = |x: &[Six]| {
            let mut y = vec![[0.0; 6]; x.len()];
            for (bond, blocks) in &springs {
                let at = self.bonds[*bond].parts.map(|part| number[part as usize]);
                for (i, &row) in at.iter().enumerate() {
                    for (j, &column) in at.iter().enumerate() {
                        if row != NONE && column != NONE {
                            add_product(&mut y[row as usize], &blocks[i][j], &x[column as usize]);
                        }
                    }
                }
            }
            y
        };
        let mut r = rows.to_vec();
        rows.fill([0.0; 6]);
        let mut z = precondition(&r);
        let mut p = z.clone();
        let mut square = dot(&r, &z);
        let goal = TOLERANCE * TOLERANCE * square;
        for _ in 0..6 * rows.len() {
            if square <= goal {
                break;
            }
            let ap = multiply(&p);
            let step = square / dot(&p, &ap);
            add_scaled(rows, &p, step);
            add_scaled(&mut r, &ap, -step);
            z = precondition(&r);
            let next = dot(&r, &z);
            let keep = next / square;
            for (p, z) in p.iter_mut().zip(&z) {
                for (p, z) in p.iter_mut().zip(z) {
                    *p = z + keep * *p;
                }
            }
            square = next;
        }
    }
}

/// Stiffness of a bond at its center.
struct Spring {
    /// Force by displacement.
    along: DMat3,
    /// Moment by turn.
    turning: DMat3,
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

fn add_block(to: &mut Block, block: &Block) {
    for (to, from) in to.iter_mut().flatten().zip(block.iter().flatten()) {
        *to += from;
    }
}

fn add_product(to: &mut Six, block: &Block, x: &Six) {
    for (to, row) in to.iter_mut().zip(block) {
        *to += row.iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
    }
}

fn add_scaled(to: &mut [Six], from: &[Six], scale: f64) {
    for (to, from) in to.iter_mut().flatten().zip(from.iter().flatten()) {
        *to += scale * from;
    }
}

fn dot(a: &[Six], b: &[Six]) -> f64 {
    let products = a.iter().flatten().zip(b.iter().flatten());
    products.map(|(a, b)| a * b).sum()
}
