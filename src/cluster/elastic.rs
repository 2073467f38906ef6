//! The parts of a cluster as rigid bodies on elastic bonds: how loads move them.

use crate::cluster::network::Network;
use crate::cluster::removal::Removal;
use crate::cluster::sparse::{Block, NONE, Pattern, Six, Sparse};
use glam::DVec3;

/// Blocks that a factor may have, 144 MB: that of a cluster of some 5000 parts which is as thick as it is long, or of 10 000 in a wall. Beyond,
/// conjugate gradients are used, which need a hundredth of that, and as much time as it takes.
const MOST_BLOCKS: usize = 500_000;

/// Error of the forces, relative to the loads, that conjugate gradients leave.
const TOLERANCE: f64 = 1e-4;

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

/// The system that tells how loads move the parts, for Young's modulus 1; it serves as long as the parts and what is held are the same.
#[derive(Clone, Debug)]
pub(crate) struct Elastic {
    /// By bond, whether it is left out.
    is_broken: Vec<bool>,
    /// The parts that move.
    order: Vec<u32>,
    /// By part: its number among them.
    number: Vec<u32>,
    /// None where there are too many parts.
    system: Option<Sparse>,
    /// Bonds that are still to be taken out of its factor; the first one may have begun.
    removals: Vec<Removal>,
    /// Whether some have been.
    is_updated: bool,
}

impl Elastic {
    pub(super) fn new(network: &Network, held: &[bool], is_broken: &[bool]) -> Self {
        let (order, number) = network.order(held, is_broken);
        let springs = || network.springs(is_broken);
        let at = |bond: usize| network.bonds[bond].parts.map(|part| number[part as usize]);
        let whole = (0..network.bonds.len()).filter(|&bond| !is_broken[bond]);
        let links = whole.filter(|&bond| !at(bond).contains(&NONE)).map(|bond| {
            let [a, b] = at(bond);
            [a.max(b), a.min(b)]
        });
        let pattern = Pattern::of(order.len(), links);
        let system = (pattern.len() <= MOST_BLOCKS).then(|| {
            let mut system = Sparse::new(pattern);
            for (bond, blocks) in springs() {
                let at = at(bond);
                for (i, &row) in at.iter().enumerate() {
                    for (j, &column) in at.iter().enumerate() {
                        if row != NONE
                            && column != NONE
                            && row >= column
                            && let Some(to) = system.block_mut(row, column)
                        {
                            add_block(to, &blocks[i][j]);
                        }
                    }
                }
            }
            system
        });
        Self {
            is_broken: is_broken.to_vec(),
            order,
            number,
            system,
            removals: Vec::new(),
            is_updated: false,
        }
    }

    /// By bond, whether it is left out.
    pub(super) fn is_broken(&self) -> &[bool] {
        &self.is_broken
    }

    /// Whether it was not made without the bonds that it leaves out now.
    pub(super) fn is_updated(&self) -> bool {
        self.is_updated
    }

    /// Leaves more bonds (by index) out, which hold nothing together that others do not; made anew if that is less work.
    pub(super) fn leave_out(&mut self, network: &Network, bonds: impl Iterator<Item = usize>) {
        for bond in bonds {
            if std::mem::replace(&mut self.is_broken[bond], true) {
                continue;
            }
            let rows = network.bonds[bond]
                .parts
                .map(|part| self.number[part as usize]);
            if self.system.is_some() && rows != [NONE; 2] {
                let (strains, stiffness) = network.strains(bond);
                self.removals.push(Removal::new(rows, strains, &stiffness));
            }
        }
        self.is_updated = true;
        let Some(system) = &self.system else {
            return;
        };
        let mut left = system.pattern.cost();
        let is_much = self.removals.iter().any(|removal| {
            let cost = system.cost_of(removal);
            left = left.saturating_sub(cost);
            left == 0
        });
        if is_much {
            let held = self.number.iter().map(|&number| number == NONE);
            let held: Vec<bool> = held.collect();
            *self = Self::new(network, &held, &self.is_broken);
        }
    }

    /// The same of a network in which the bonds that are left out are gone, and `broken` (ascending) with them; none if others are left out than
    /// those.
    pub(crate) fn cracked(mut self, network: &Network, broken: &[u32]) -> Option<Self> {
        self.leave_out(network, broken.iter().map(|&bond| bond as usize));
        let count = self
            .is_broken
            .iter()
            .filter(|is_broken| **is_broken)
            .count();
        self.is_broken.retain(|is_broken| !is_broken);
        (count == broken.len()).then_some(self)
    }

    /// Prepares it, as long as `budget` has products of blocks left; whether it is ready.
    pub(crate) fn prepare(&mut self, budget: &mut usize) -> bool {
        let Some(system) = &mut self.system else {
            return true;
        };
        if !system.factorise(budget) {
            return false;
        }
        let mut done = 0;
        let mut removals = self.removals.iter_mut();
        let is_ready = removals.all(|removal| {
            let is_done = system.remove(removal, budget);
            done += usize::from(is_done);
            is_done
        });
        self.removals.drain(..done);
        is_ready
    }

    /// Products of blocks that it takes to tell what loads do.
    pub(super) fn cost_of_displacements(&self) -> usize {
        let system = self.system.as_ref();
        system.map_or(0, |system| system.pattern.len() / 3)
    }

    /// How the loads move the parts: displacements and turns. It must be ready.
    pub(super) fn displacements(&self, network: &Network, loads: &[Wrench]) -> Vec<Six> {
        let mut rows: Vec<Six> = (self.order.iter())
            .map(|&part| {
                let Wrench { force, torque } = loads[part as usize];
                [force.x, force.y, force.z, torque.x, torque.y, torque.z]
            })
            .collect();
        match &self.system {
            Some(system) => system.solve(&mut rows),
            None => network.iterate(&mut rows, &self.number, &self.is_broken),
        }
        let mut motion = vec![[0.0; 6]; network.nodes.len()];
        for (row, &part) in rows.iter().zip(&self.order) {
            motion[part as usize] = *row;
        }
        motion
    }
}

impl Network {
    /// The parts that move, all that hang together with what is held, or with a first part that then does not move; and by part its number in this
    /// order.
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
        self.search(&mut order, &mut seen, is_broken);
        let order = self.dissected(order.split_off(fixed), is_broken);
        let mut number = vec![NONE; self.nodes.len()];
        for (index, &part) in (0..).zip(&order) {
            number[part as usize] = index;
        }
        (order, number)
    }

    /// Goes on with a search by breadth over bonds that are not broken, from the parts in `order` on.
    fn search(&self, order: &mut Vec<u32>, seen: &mut [bool], is_broken: &[bool]) {
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
    }

    /// A part at an end of what hangs together with the first one.
    fn far_part(&self, is_broken: &[bool]) -> u32 {
        let mut seen = vec![false; self.nodes.len()];
        let mut order = vec![0];
        seen[0] = true;
        self.search(&mut order, &mut seen, is_broken);
        order.last().copied().unwrap_or(0)
    }

    /// Conjugate gradients, preconditioned by the blocks of the diagonal.
    fn iterate(&self, rows: &mut [Six], number: &[u32], is_broken: &[bool]) {
        let springs: Vec<_> = self.springs(is_broken).collect();
        let mut diagonal = Sparse::new(Pattern::of(rows.len(), std::iter::empty()));
        for (bond, blocks) in &springs {
            for (side, part) in self.bonds[*bond].parts.into_iter().enumerate() {
                let row = number[part as usize];
                if row != NONE
                    && let Some(own) = diagonal.block_mut(row, row)
                {
                    add_block(own, &blocks[side][side]);
                }
            }
        }
        diagonal.factorise(&mut usize::MAX.clone());
        let precondition = |r: &[Six]| {
            let mut z = r.to_vec();
            diagonal.solve(&mut z);
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
