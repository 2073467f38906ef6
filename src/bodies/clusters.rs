//! Bodies whose parts are held by bonds: what is known of each besides its shape.
//!
//! Few bodies are, so they are a list by slot that grows with the last of them; the others are asked for nothing.

use crate::bodies::body::{RigidBody, Shape};
use crate::bodies::cluster_state::{ClusterState, PartLoad};
use crate::bodies::store::Bodies;
use crate::cluster::network::Network;
use crate::geometry::{Compound, groups_of};
use crate::mass::MassError;
use std::sync::Arc;

impl Bodies {
    /// What is known of a body whose parts are held by bonds; none of others.
    #[inline]
    pub(crate) fn cluster(&self, slot: u32) -> Option<&ClusterState> {
        self.clusters.get(slot as usize)?.as_deref()
    }

    /// The same, to be changed.
    pub(crate) fn cluster_mut(&mut self, slot: u32) -> Option<&mut ClusterState> {
        self.clusters.get_mut(slot as usize)?.as_deref_mut()
    }

    /// Slots of all of them, ascending; by a look at each slot up to the last of them.
    pub(crate) fn cluster_slots(&self) -> impl Iterator<Item = u32> + '_ {
        let slots = (0..).zip(&self.clusters);
        slots.filter_map(|(slot, state)| state.is_some().then_some(slot))
    }

    /// Behind the slot of the last of them.
    pub(crate) fn cluster_end(&self) -> u32 {
        self.clusters.len() as u32
    }

    /// Changes with each body that is added.
    pub(crate) fn newest(&self) -> u32 {
        self.next_id
    }

    /// Whether there are any.
    pub(crate) fn any_cluster(&self) -> bool {
        !self.clusters.is_empty()
    }

    /// Notes that the parts of a static cluster may hold on elsewhere than they did.
    pub(crate) fn doubt_holds(&mut self, slot: u32) {
        if self.cluster(slot).is_some() {
            self.unheld_clusters.push(slot);
        }
    }

    /// After shape, density or kind changed: parts and bonds as they are now, whose loads and holds are not known.
    pub(super) fn renew_cluster(&mut self, slot: u32) -> Result<(), MassError> {
        let info = self.info(slot);
        let bonded = info.shape.compound().filter(|it| it.is_bonded());
        let Some(compound) = bonded else {
            self.forget_cluster(slot);
            return Ok(());
        };
        let network = Network::new(compound, info.density, info.friction.coefficient)?;
        let groups = groups_of(compound.len(), compound.bonds(), |_| false);
        let is_divided = groups.iter().any(|&group| group != 0);
        let held = if info.kind == RigidBody::Static {
            self.unheld_clusters.push(slot);
            None
        } else {
            Some(vec![false; compound.len()])
        };
        let needed = self.clusters.len().max(slot as usize + 1);
        self.clusters.resize_with(needed, || None);
        self.clusters[slot as usize] = Some(Box::new(ClusterState {
            network: Arc::new(network),
            held,
            looked_at: None,
            bearings: Vec::new(),
            loads: Vec::new(),
            judged: None,
            overloaded: 0.0,
            elastic: None,
        }));
        if is_divided {
            self.divided_clusters.push((slot, self.id(slot)));
        }
        Ok(())
    }

    pub(super) fn forget_cluster(&mut self, slot: u32) {
        if let Some(state) = self.clusters.get_mut(slot as usize) {
            *state = None;
            // Whoever asks whether there are any looks no farther than the last one.
            while self.clusters.last().is_some_and(Option::is_none) {
                self.clusters.pop();
            }
        }
    }

    /// Takes bonds (by index) away that hold nothing together any more which others do not.
    pub(crate) fn crack(&mut self, slot: u32, broken: &[u32]) {
        let Some(compound) = self.compound(slot) else {
            return;
        };
        let cracked = compound.without_bonds(broken);
        let held = self.cluster(slot).and_then(|state| state.held.clone());
        let loaded = self.cluster(slot);
        let loaded = loaded.map(|it| (it.loads.clone(), it.bearings.clone(), it.overloaded));
        let elastic = self.cluster_mut(slot).and_then(|state| {
            let elastic = state.elastic.take()?;
            elastic.cracked(&state.network, broken).map(Box::new)
        });
        self.set_compound(slot, cracked);
        if self.renew_cluster(slot).is_err() {
            return;
        }
        if let Some(state) = self.cluster_mut(slot) {
            state.held = held;
            // What is too much for it does not begin anew with each bond.
            (state.loads, state.bearings, state.overloaded) = loaded.unwrap_or_default();
            // Nor is what moves its parts worked out anew.
            state.elastic = elastic;
        }
        self.cracked.push((slot, self.id(slot)));
    }

    /// Wears bonds (by index, with the most that each bore as a share of what it can) by a blow that takes a share of a bond's strength that
    /// bears all it can: from the others as much less as they have held energy. Those of them that are worn out.
    pub(crate) fn wear_bonds(&mut self, slot: u32, worn: &[(u32, f32)], share: f32) -> Vec<u32> {
        let Some(compound) = self.compound(slot) else {
            return Vec::new();
        };
        let compound = compound.worn(worn, share);
        if let Some(state) = self.cluster_mut(slot) {
            Arc::make_mut(&mut state.network).wear(compound.bonds());
            // What bears it is weaker than it was.
            state.judged = None;
        }
        let gone = worn.iter().map(|&(bond, _)| bond);
        let gone = gone.filter(|&bond| compound.bonds()[bond as usize].is_worn_out());
        let gone = gone.collect();
        self.set_compound(slot, compound);
        self.cracked.push((slot, self.id(slot)));
        gone
    }

    /// Leaves of a body only some of its parts (ascending), whose bonds are those of `cracked`; its frame, id and slot stay, and so does
    /// what is known of its contacts.
    pub(crate) fn keep_parts(
        &mut self,
        slot: u32,
        cracked: &Compound,
        kept: &[u32],
    ) -> Result<(), MassError> {
        let rest = cracked.subset(kept);
        let held = self.cluster(slot).and_then(|state| state.held.as_ref());
        let held = held.map(|held| kept.iter().map(|&part| held[part as usize]).collect());
        let loads = self.cluster(slot).map(|state| {
            let loads = state.loads.iter().filter_map(|load| {
                let part = kept.binary_search(&load.from.1).ok()? as u32;
                Some(PartLoad {
                    from: (load.from.0, part),
                    ..*load
                })
            });
            loads.collect()
        });
        let code_box = self.kd_box[slot as usize];
        self.disturb(slot);
        self.set_compound(slot, rest);
        self.mark_shape_changed(slot);
        // Codes of contacts go on meaning what they did.
        self.kd_box[slot as usize] = code_box;
        self.refresh_mass(slot)?;
        self.stale_mass.pop();
        if let Some(state) = self.cluster_mut(slot) {
            state.held = held;
            state.loads = loads.unwrap_or_default();
        }
        self.cracked.push((slot, self.id(slot)));
        Ok(())
    }

    fn set_compound(&mut self, slot: u32, compound: Compound) {
        if let Some(info) = &mut self.info[slot as usize] {
            info.shape = Shape::Compound(compound);
        }
    }

    /// Energy that a blow must have to break a bond of the body, J; infinite if nothing of it is held by bonds.
    pub(super) fn bond_energy(&self, slot: u32) -> f32 {
        let state = self.cluster(slot);
        state.map_or(f32::INFINITY, |state| state.network.least_energy)
    }
}
