//! The bonds of a batch: loaded before its sub-steps, judged after them.

use crate::contact::manifolds::Manifolds;
use crate::solver::batch::Batch;
use crate::solver::graph::indices::LaneSlot;
use crate::solver::wide::block::vector;
use crate::solver::wide::bond::{BondConstraint, BondedManifold};

impl Batch {
    /// Ties those of its manifolds that are in the list, which is sorted by manifolds.
    pub fn load_bonds(&mut self, bonded: &[BondedManifold], manifolds: &Manifolds) {
        if bonded.is_empty() {
            return;
        }
        let share = 1.0 / self.settings.substeps as f32;
        for i in 0..self.layout.places.len() {
            let (index, place) = self.layout.places[i];
            let Ok(at) = bonded.binary_search_by_key(&index, |bond| bond.manifold) else {
                continue;
            };
            self.bonds
                .constraints
                .resize(self.contacts.points.len(), BondConstraint::default());
            let bond = &bonded[at];
            let (block, lane) = (
                &self.contacts.blocks[place.block as usize],
                place.lane as usize,
            );
            let points = manifolds.at(index.index()).points();
            for (k, (off, from)) in bond.displacement.iter().zip(points).enumerate() {
                let at = block.points.start + k;
                self.bonds.constraints[at].load(lane, block, bond, *off, self.settings.substep_dt);
                // Shear of a bond needs no friction, without which this was left out.
                for (row, tangent) in block.tangents.iter().enumerate() {
                    let along = vector(tangent, lane).dot(share * from.friction_impulse);
                    self.contacts.points[at].impulse[row + 1].0[lane] = along;
                }
            }
        }
    }

    /// Notes in the list how far its bonds have given way.
    pub fn update_bond_damage(&self, bonded: &mut [BondedManifold]) {
        if self.bonds.constraints.is_empty() {
            return;
        }
        for &(index, place) in &self.layout.places {
            if let Ok(at) = bonded.binary_search_by_key(&index, |bond| bond.manifold) {
                bonded[at].yielded = self.yielded(place);
            }
        }
    }

    /// How far the farthest point of a manifold that bears all it can is off, m.
    fn yielded(&self, place: LaneSlot) -> f32 {
        let (block, lane) = (
            &self.contacts.blocks[place.block as usize],
            place.lane as usize,
        );
        let displacements = block
            .pair(lane)
            .map(|body| &self.bodies.displacements[body as usize]);
        let model = self.settings.friction;
        let of_point = |at: usize| {
            self.bonds.constraints[at].yielded(
                lane,
                block,
                &self.contacts.points[at],
                displacements,
                model,
            )
        };
        let points = block.points.clone().take(place.count as usize);
        points.map(of_point).fold(0.0, f32::max)
    }
}
