//! Clusters that break: the groups of parts that bonds still hold together, and which of them goes on as the body.

use crate::bodies::body::{BodyDesc, RigidBody};
use crate::bodies::fatigue::Fatigue;
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::fracture::budget::FractureBudget;
use crate::fracture::conservation::{keep_mass_of_group, keep_momentum};
use crate::fracture::holding::Foothold;
use crate::fracture::ledger::{Ledger, Reference};
use crate::fracture::pieces::{compound_desc, insert};
use crate::fracture::{CutError, Fracture, MIN_PIECES};
use crate::geometry::{Compound, groups_of};
use crate::slice::SliceError;
use crate::slice::fracturable::Fracturable;
use crate::solver::contact_solver::ContactSolver;

/// Bonds of a body that are to break, by index, and how many it had then: another number, and these are not they.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BrokenBonds {
    pub(super) of: usize,
    pub(super) bonds: Vec<u32>,
}

/// What a cluster falls into, as parts by index, ascending.
#[derive(Clone, Debug)]
pub(super) struct Groups {
    /// Those that come off, by their first parts.
    pub(super) pieces: Vec<Vec<u32>>,
    /// What goes on as the body.
    rest: Option<Vec<u32>>,
    /// Bonds that are gone.
    broken: Vec<u32>,
    /// Whether the last piece is several groups, which come apart later.
    pub(super) is_joined: bool,
}

impl Groups {
    /// What is left when bonds break; none if nothing comes off. Of a body that stands, the largest group that holds on to the world
    /// goes on as the body.
    pub(super) fn of(bodies: &Bodies, slot: u32, broken: &[u32]) -> Option<Self> {
        let state = bodies.cluster(slot)?;
        let network = &state.network;
        let is_broken = |bond: usize| broken.contains(&(bond as u32));
        let groups = groups_of(network.nodes.len(), &network.bonds, is_broken);
        let count = groups.iter().max().map_or(0, |&last| last as usize + 1);
        if count < 2 {
            return None;
        }
        let mut pieces: Vec<Vec<u32>> = vec![Vec::new(); count];
        for (part, &group) in (0..).zip(&groups) {
            pieces[group as usize].push(part);
        }
        // What it held on to may be gone: asked of one part of each group that is known to.
        let foothold = Foothold::of_parts(bodies, slot);
        let shapes = bodies.compound(slot).map_or(&[][..], Compound::parts);
        let still_holds = |part: u32| {
            let foothold = foothold.as_ref();
            foothold.is_some_and(|it| it.holds_part(bodies, &shapes[part as usize]))
        };
        let holds =
            |parts: &Vec<u32>| (parts.iter()).any(|&part| state.holds(part) && still_holds(part));
        let held = (0..count).filter(|&group| holds(&pieces[group]));
        let largest = held.max_by_key(|&group| (pieces[group].len(), count - group));
        let rest = largest.map(|group| pieces.remove(group));
        Some(Self {
            pieces,
            rest,
            broken: broken.to_vec(),
            is_joined: false,
        })
    }

    /// At most `most` pieces, or the fewest that something can break into: the last one is all that would be more, and comes apart when
    /// its turn comes.
    pub(super) fn limited(mut self, most: usize) -> Self {
        let most = most.max(MIN_PIECES);
        if self.pieces.len() > most {
            let mut others: Vec<u32> = self.pieces.drain(most - 1..).flatten().collect();
            others.sort_unstable();
            self.pieces.push(others);
            self.is_joined = true;
        }
        self
    }

    /// What comes off, as bodies that weigh what their parts did.
    fn bodies(
        &self,
        bodies: &Bodies,
        slot: u32,
        cracked: &Compound,
    ) -> Result<Vec<BodyDesc>, CutError> {
        let state = bodies.cluster(slot).ok_or(CutError::NotConvex)?;
        let nodes = &state.network.nodes;
        let described = self.pieces.iter().enumerate().map(|(number, parts)| {
            let piece = cracked.subset(parts);
            let mut desc = compound_desc(bodies, slot, &piece).map_err(SliceError::from)?;
            let mass = parts.iter().map(|&part| nodes[part as usize].mass).sum();
            keep_mass_of_group(&mut desc, mass);
            Ok(BodyDesc {
                fracturable: fracturable_of(bodies, slot, number),
                ..desc
            })
        });
        described.collect()
    }
}

/// Replaces the body in `slot` by what comes off of it, and leaves the rest of one that stands.
pub(super) fn replace_groups(
    bodies: &mut Bodies,
    slot: u32,
    mut groups: Groups,
    budget: &FractureBudget,
) -> Result<Fracture, CutError> {
    let reference = Reference::of(bodies, slot);
    let foothold = Foothold::of(bodies, slot);
    if foothold.is_none() {
        // It stood when it was divided, and was let fall since by what broke before it.
        groups.pieces.splice(0..0, groups.rest.take());
    }
    let cracked = bodies.compound(slot).ok_or(CutError::NotConvex)?;
    let cracked = cracked.without_bonds(&groups.broken);
    let mut pieces = groups.bodies(bodies, slot, &cracked)?;
    let mut ledger = Ledger::default();
    ledger.before.add_body(bodies, slot, &reference);
    let holds = match &foothold {
        Some(foothold) => foothold.keep(bodies, &mut pieces),
        None => vec![None; pieces.len()],
    };
    let pieces: Vec<(BodyDesc, _)> = pieces.into_iter().zip(holds).collect();
    let (kept, numbers) = insert(bodies, slot, pieces, budget, &mut ledger, &reference);
    if groups.rest.is_none() && kept.is_empty() {
        return Err(CutError::TooSmall);
    }
    let parent = bodies.id(slot);
    if bodies.kind(slot) == RigidBody::Dynamic {
        keep_momentum(bodies, &kept, &mut ledger, &reference);
    }
    if let Some(rest) = &groups.rest {
        // Its parts had a mass.
        let _ = bodies.keep_parts(slot, &cracked, rest);
        ledger.after.add_body(bodies, slot, &reference);
    }
    let mut fracture = Fracture {
        parent,
        parent_slot: slot,
        ids: kept.iter().map(|&piece| bodies.id(piece)).collect(),
        pieces: kept,
        numbers,
        planes: Default::default(),
        ledger,
        fallen: Vec::new(),
        blow: None,
        waited: None,
        is_load: false,
        goes_on: groups.rest.is_some(),
    };
    match foothold {
        None => bodies.remove(slot),
        Some(foothold) => {
            if groups.rest.is_none() {
                bodies.retire(slot);
            }
            fracture.fallen = foothold.let_fall(bodies, &fracture.pieces);
        }
    }
    Ok(fracture)
}

/// How a group breaks: as the body did, for it is none of its pieces.
fn fracturable_of(bodies: &Bodies, slot: u32, number: usize) -> Option<Fracturable> {
    let whole = bodies.fracturable(slot)?;
    let piece = whole.for_piece(number).unwrap_or_else(|| whole.clone());
    Some(Fracturable {
        generations: whole.generations,
        ..piece
    })
}

/// Finds out which parts of static clusters hold on to the world, where it is not known, or where nothing was there to hold on to.
pub(crate) fn find_holds(bodies: &mut Bodies) {
    if !bodies.any_cluster() {
        return;
    }
    let newest = bodies.newest();
    let lonely = bodies.cluster_slots().filter(|&slot| {
        let state = bodies.cluster(slot);
        state.is_some_and(|state| state.looked_at.is_some_and(|then| then != newest))
    });
    let lonely: Vec<u32> = lonely.collect();
    let mut unheld = std::mem::take(&mut bodies.unheld_clusters);
    unheld.extend(lonely);
    unheld.sort_unstable();
    unheld.dedup();
    for slot in unheld.drain(..) {
        let is_static = bodies.contains(slot) && bodies.kind(slot) == RigidBody::Static;
        let Some(compound) = bodies.compound(slot).filter(|_| is_static).cloned() else {
            continue;
        };
        let Some(foothold) = Foothold::of_parts(bodies, slot) else {
            continue;
        };
        let held: Vec<bool> = (compound.parts().iter())
            .map(|part| foothold.holds_part(bodies, part))
            .collect();
        if let Some(state) = bodies.cluster_mut(slot) {
            state.looked_at = (!held.contains(&true)).then_some(newest);
            if state.held.as_ref() != Some(&held) {
                (state.judged, state.elastic) = (None, None);
            }
            state.held = Some(held);
        }
    }
    bodies.unheld_clusters = unheld;
}

/// Takes the bonds away that broke in the step without anything coming off, or were worn out, of the batches from this number on; what comes
/// off after all, because several blows cracked it, and of those that wait.
pub(super) fn apply_cracks(
    bodies: &mut Bodies,
    solver: &ContactSolver,
    first_batch: usize,
    is_waiting: impl Fn(BodyId) -> bool,
) -> Vec<(u32, BrokenBonds)> {
    let mut broken = wear_bonds(bodies, solver, first_batch);
    for crack in solver.cracks(first_batch) {
        add_broken(&mut broken, crack.slot, crack.of, &crack.bonds);
    }
    broken.retain(|(slot, broken)| broken.is_of(bodies, *slot));
    broken.retain(|(slot, broken)| {
        // Bonds that it waits for are known by their numbers, which a crack would change.
        let waits = is_waiting(bodies.id(*slot));
        if waits || Groups::of(bodies, *slot, &broken.bonds).is_some() {
            return true;
        }
        bodies.crack(*slot, &broken.bonds);
        false
    });
    broken
}

/// Wears the bonds that blows have strained, and left whole, by the energies of the blows; those of which nothing is left.
fn wear_bonds(
    bodies: &mut Bodies,
    solver: &ContactSolver,
    first_batch: usize,
) -> Vec<(u32, BrokenBonds)> {
    let mut worn_out = Vec::new();
    for strain in solver.strains(first_batch) {
        let slot = strain.slot;
        let fatigue = bodies.contains(slot).then(|| bodies.fatigue(slot));
        let Some(&Fatigue { energy, .. }) = fatigue.flatten() else {
            continue;
        };
        if bond_count(bodies, slot) == Some(strain.of) {
            let gone = bodies.wear_bonds(slot, &strain.bonds, strain.energy / energy);
            add_broken(&mut worn_out, slot, strain.of, &gone);
        }
    }
    worn_out
}

/// Adds bonds of a body to those that are to break.
fn add_broken(broken: &mut Vec<(u32, BrokenBonds)>, slot: u32, of: usize, bonds: &[u32]) {
    if bonds.is_empty() {
        return;
    }
    let known = broken.iter_mut().find(|(body, _)| *body == slot);
    match known {
        Some((_, broken)) => broken.add(&BrokenBonds {
            of,
            bonds: bonds.to_vec(),
        }),
        None => {
            let bonds = bonds.to_vec();
            broken.push((slot, BrokenBonds { of, bonds }));
        }
    }
}

/// Number of bonds within the body in `slot`, if there is one and bonds hold its parts.
fn bond_count(bodies: &Bodies, slot: u32) -> Option<usize> {
    let state = bodies.contains(slot).then(|| bodies.cluster(slot));
    state.flatten().map(|state| state.network.bonds.len())
}

impl BrokenBonds {
    /// Adds others of the same body, as long as it has the same bonds.
    pub(super) fn add(&mut self, more: &Self) {
        if self.of == more.of {
            self.bonds.extend_from_slice(&more.bonds);
            self.bonds.sort_unstable();
            self.bonds.dedup();
        }
    }

    /// Whether they are bonds of the body in `slot` as it is.
    pub(super) fn is_of(&self, bodies: &Bodies, slot: u32) -> bool {
        bond_count(bodies, slot) == Some(self.of)
    }
}
