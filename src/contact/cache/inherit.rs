//! What becomes of a body's multipliers when it is cut: each goes to the piece that owns the contact point.

use super::{CacheEntry, ContactCache, PairRecord, Table};
use crate::contact::BodyId;
use crate::geometry::{ConvexHull, KdBox};
use crate::math::rotate;
use glam::{Quat, Vec3};

/// A piece of a body that was cut.
#[derive(Clone, Copy, Debug)]
pub struct Heir<'a> {
    /// The new body.
    pub id: BodyId,
    /// Origin of its frame in the parent's frame, m; the axes of both are the same.
    pub origin: Vec3,
    /// Its shape.
    pub hull: &'a ConvexHull,
    /// The box that its contact codes refer to.
    pub code_box: KdBox,
}

/// A body that was cut, and its pieces.
#[derive(Clone, Debug)]
pub struct Family<'a> {
    /// The body that is no more.
    pub parent: BodyId,
    /// `world_from_body` of the parent and of all pieces.
    pub rotation: Quat,
    /// The box that the parent's contact codes refer to.
    pub code_box: KdBox,
    /// The pieces.
    pub heirs: Vec<Heir<'a>>,
}

impl Family<'_> {
    /// The piece that owns a point of the parent (parent's frame, m): the one that it is deepest in, or nearest to.
    fn owner(&self, point: Vec3) -> Option<&Heir<'_>> {
        let distance = |heir: &Heir| {
            let faces = heir.hull.faces.iter();
            let place = point - heir.origin;
            let heights = faces.map(|face| face.plane.distance(place));
            heights.fold(f32::NEG_INFINITY, f32::max)
        };
        let by_distance = |a: &&Heir, b: &&Heir| distance(a).total_cmp(&distance(b));
        self.heirs.iter().min_by(by_distance)
    }
}

/// An entry with the pair that it belongs to.
type Named = ((BodyId, BodyId), CacheEntry);

impl ContactCache {
    /// Hands the entries of bodies that were cut to their pieces. `rotation_of` tells `world_from_body` of any body that
    /// has entries; it is not asked for parents.
    ///
    /// A point is known by its cell, so that it may be off by half a cell when its piece is looked for. Pieces have higher
    /// ids than all other bodies.
    pub fn inherit(&mut self, families: &[Family], rotation_of: impl Fn(BodyId) -> Quat) {
        let rotation = |id: BodyId| {
            let family = families.iter().find(|family| family.parent == id);
            family.map_or_else(|| rotation_of(id), |family| family.rotation)
        };
        for family in families {
            let Self { current, next, .. } = self;
            let is_of = |pair: &&PairRecord| {
                pair.bodies.0 == family.parent || pair.bodies.1 == family.parent
            };
            let mut passed: Vec<Named> = Vec::new();
            for pair in current.pairs.iter().filter(is_of) {
                let entries = &current.entries[pair.range()];
                let pass = |entry| pass_on(family, pair.bodies, entry, rotation);
                passed.extend(entries.iter().filter_map(pass));
            }
            passed.sort_by_key(|&(bodies, _)| bodies);
            next.clear();
            let mut passed = passed.chunk_by(|a, b| a.0 == b.0).peekable();
            for pair in current.pairs.iter().filter(|pair| !is_of(pair)) {
                while let Some(new) = passed.next_if(|new| new[0].0 < pair.bodies) {
                    next.push_pair(new);
                }
                next.copy_pair(current, pair, 1.0);
            }
            passed.for_each(|new| next.push_pair(new));
            std::mem::swap(current, next);
        }
    }
}

impl Table {
    fn push_pair(&mut self, named: &[Named]) {
        let first = self.entries.len();
        self.entries.extend(named.iter().map(|(_, entry)| *entry));
        self.close_pair(named[0].0, first);
    }
}

/// The entry of a pair of the parent as that of a pair of the piece that owns its point.
fn pass_on(
    family: &Family,
    (a, b): (BodyId, BodyId),
    entry: &CacheEntry,
    rotation_of: impl Fn(BodyId) -> Quat,
) -> Option<Named> {
    let (other, codes) = if a == family.parent {
        (b, [entry.code_a, entry.code_b])
    } else {
        (a, [entry.code_b, entry.code_a])
    };
    let point = family.code_box.decode_centre(codes[0]);
    let heir = family.owner(point)?;
    let own_code = heir.code_box.encode(point - heir.origin);
    // The friction impulse is that on B, in A's frame. The piece, whose id is higher, is B.
    let on_b = rotate(rotation_of(a), entry.friction_impulse);
    let on_heir = if a == family.parent { -on_b } else { on_b };
    let passed = CacheEntry {
        code_a: codes[1],
        code_b: own_code,
        friction_impulse: rotate(rotation_of(other).inverse(), on_heir),
        ..*entry
    };
    Some(((other, heir.id), passed))
}
