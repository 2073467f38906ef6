//! From a fracture to the contact cache: which body had which pieces.

use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::contact::impulses::{Child, ContactCache, Split};
use crate::geometry::{Compound, KdBox};
use crate::math::rotate;
use glam::{Quat, Vec3};
use smallvec::SmallVec;

/// What must be known of a body after it is gone.
#[derive(Clone, Copy, Debug)]
pub(super) struct ParentState {
    id: BodyId,
    rotation: Quat,
    /// World, m.
    center_of_mass: Vec3,
    /// Body's frame, m.
    center: Vec3,
    code_box: Option<KdBox>,
}

impl ParentState {
    pub(super) fn of(bodies: &Bodies, slot: u32) -> Self {
        Self {
            id: bodies.id(slot),
            rotation: bodies.pose(slot).rotation,
            center_of_mass: bodies.center_of_mass(slot),
            center: bodies.mass(slot).center,
            code_box: bodies.kd_box[slot as usize],
        }
    }

    pub(super) fn id(&self) -> BodyId {
        self.id
    }

    /// Where the frame of a piece is in that of the parent, along whose axes it lies, m.
    pub(super) fn origin_of(&self, bodies: &Bodies, piece: u32) -> Vec3 {
        let way = bodies.pose(piece).position - self.center_of_mass;
        self.center + rotate(self.rotation.inverse(), way)
    }

    fn split<'a>(&self, pieces: &[u32], bodies: &'a Bodies) -> Option<Split<'a>> {
        let children = |&slot: &u32| {
            let shape = &bodies.info(slot).shape;
            let parts = shape.compound().map_or(&[][..], Compound::parts).iter();
            let parts = parts.map(|part| (part.shape.hull(), Some(part.pose)));
            let whole = shape.convex().map(|mesh| (mesh.hull(), None));
            let (id, origin) = (bodies.id(slot), self.origin_of(bodies, slot));
            let code_box = bodies.kd_box[slot as usize];
            whole
                .into_iter()
                .chain(parts)
                .filter_map(move |(hull, part)| {
                    Some(Child {
                        id,
                        origin,
                        part,
                        hull,
                        code_box: code_box?,
                    })
                })
        };
        Some(Split {
            parent: self.id,
            rotation: self.rotation,
            code_box: self.code_box?,
            children: pieces.iter().flat_map(children).collect(),
        })
    }
}

/// Notes who has what a body was, which was in `slot`: if it came to be since impulses were handed on, it had nothing yet, and its own
/// pieces take its place among the heirs of the body that it was part of.
pub(super) fn note_heirs(
    lines: &mut Vec<(ParentState, SmallVec<[u32; 8]>)>,
    (parent, slot): (ParentState, u32),
    heirs: SmallVec<[u32; 8]>,
) {
    let place = lines.iter_mut().find_map(|(_, known)| {
        let at = known.iter().position(|&heir| heir == slot)?;
        Some((known, at))
    });
    match place {
        Some((known, at)) => {
            known.remove(at);
            known.insert_many(at, heirs);
        }
        None => lines.push((parent, heirs)),
    }
}

/// Gives the multipliers of bodies that are gone to their pieces, by slot.
pub(super) fn transfer_impulses(
    parents: &[(ParentState, SmallVec<[u32; 8]>)],
    bodies: &Bodies,
    cache: &mut ContactCache,
) {
    if parents.is_empty() {
        return;
    }
    let splits = parents.iter();
    let splits: Vec<_> = splits
        .filter_map(|(parent, pieces)| parent.split(pieces, bodies))
        .collect();
    let mut slots: Vec<_> = bodies.iter().map(|slot| (bodies.id(slot), slot)).collect();
    slots.sort_unstable();
    let rotation_of = |id| {
        let found = slots.binary_search_by_key(&id, |&(id, _)| id);
        // A body that left since the last step has entries still; nobody will ask for them.
        found.map_or(Quat::IDENTITY, |at| bodies.rotation[slots[at].1 as usize])
    };
    cache.transfer(&splits, rotation_of);
}
