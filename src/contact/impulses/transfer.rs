//! What becomes of a body's multipliers when it is cut: each goes to the piece that owns the contact point.
//!
//! A block that stands on its four corners leaves four corner pieces, of which each would start with a quarter of the whole
//! weight on it, and jump. What a face bore is spread over the pieces of the face evenly, by area: a piece that owns points
//! starts with its share of what they carried together. Points that are fewer than span a face stay as they are.

use crate::contact::body_id::BodyId;
use crate::contact::impulses::table::{EntryTable, PairRecord};
use crate::contact::impulses::{CacheEntry, ContactCache};
use crate::geometry::predicates::{length_scale, merge_tolerance};
use crate::geometry::{ConvexHull, KdBox, KdCode};
use crate::math::{Plane, Pose, rotate};
use crate::merge::merge;
use glam::{Quat, Vec3};

/// Cosine of the largest angle between faces that are taken for parts of one: half a degree.
const SAME_FACE: f32 = 0.99996;

/// Points that span a face.
const SPANNING: usize = 3;

/// Most that a multiplier is raised by.
const MAX_RAISE: f32 = 4.0;

/// A piece of a body that was cut.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Child<'a> {
    /// The new body.
    pub(crate) id: BodyId,
    /// Origin of its frame in the parent's frame, m; the axes of both are the same.
    pub(crate) origin: Vec3,
    /// Its shape, or that of a part of it.
    pub(crate) hull: &'a ConvexHull,
    /// Where the part is in its frame.
    pub(crate) part: Option<Pose>,
    /// The box that its contact codes refer to.
    pub(crate) code_box: KdBox,
}

/// A body that was cut, and its pieces.
#[derive(Clone, Debug)]
pub(crate) struct Split<'a> {
    /// The body that is no more.
    pub(crate) parent: BodyId,
    /// `world_from_body` of the parent and of all pieces.
    pub(crate) rotation: Quat,
    /// The box that the parent's contact codes refer to.
    pub(crate) code_box: KdBox,
    /// The pieces.
    pub(crate) children: Vec<Child<'a>>,
}

/// The planes of all faces of the pieces (parent's frame), piece by piece: a cluster of a thousand parts hands thousands of points of
/// hundreds of pairs on.
#[derive(Debug, Default)]
struct PiecePlanes {
    planes: Vec<Plane>,
    /// By piece: where its planes end.
    ends: Vec<usize>,
    /// By plane: whose it is.
    pieces: Vec<u32>,
    /// Planes by their offsets, ascending.
    by_offset: Vec<u32>,
    /// By piece: how far offsets of one face may differ, m.
    tolerances: Vec<f32>,
    /// By piece: the plane that told last that a point is not its own. It mostly tells it of the next point too.
    witnesses: Vec<usize>,
}

impl PiecePlanes {
    fn of(children: &[Child]) -> Self {
        let mut all = Self::default();
        for (piece, child) in (0..).zip(children) {
            all.witnesses.push(all.planes.len());
            all.planes.extend(child.faces());
            all.ends.push(all.planes.len());
            all.pieces.resize(all.planes.len(), piece);
            let size = length_scale(&child.hull.aabb) + child.origin.abs().max_element();
            all.tolerances.push(10.0 * merge_tolerance(size));
        }
        let offset = |&plane: &u32| all.planes[plane as usize].offset;
        let mut by_offset: Vec<u32> = (0..all.planes.len() as u32).collect();
        by_offset.sort_by(|a, b| offset(a).total_cmp(&offset(b)));
        all.by_offset = by_offset;
        all
    }

    /// Where those of one piece begin.
    fn start(&self, piece: usize) -> usize {
        piece.checked_sub(1).map_or(0, |before| self.ends[before])
    }

    /// The piece that owns a point of the parent (parent's frame, m): the one that it is deepest in, or nearest to; the first of
    /// several.
    fn owner(&mut self, point: Vec3) -> Option<usize> {
        let (mut best, mut least, mut first) = (0, f32::INFINITY, 0);
        for (piece, &end) in self.ends.iter().enumerate() {
            let witness = &mut self.witnesses[piece];
            // Above one face by as much as that, it is above the surface by as much.
            let is_above = self.planes[first..end]
                .get(witness.wrapping_sub(first))
                .is_some_and(|plane| plane.distance(point) >= least);
            if !is_above {
                let mut height = f32::NEG_INFINITY;
                for (index, plane) in (first..end).zip(&self.planes[first..end]) {
                    height = height.max(plane.distance(point));
                    if height >= least {
                        *witness = index;
                        break;
                    }
                }
                if height < least {
                    (best, least) = (piece, height);
                }
            }
            first = end;
        }
        (!self.ends.is_empty()).then_some(best)
    }

    /// By piece: area of its part of a face of the parent (parent's frame), m2.
    fn areas_in(&self, parent: &Plane, children: &[Child]) -> Vec<f32> {
        let widest = self.tolerances.iter().copied().fold(0.0, f32::max);
        let offset = |plane: u32| self.planes[plane as usize].offset;
        let near = |plane: &u32| offset(*plane) <= parent.offset + widest;
        let from =
            (self.by_offset).partition_point(|&plane| offset(plane) < parent.offset - widest);
        let parts = self.by_offset[from..].iter().copied().take_while(near);
        let mut parts: Vec<u32> = parts
            .filter(|&plane| {
                let tolerance = self.tolerances[self.pieces[plane as usize] as usize];
                let plane = &self.planes[plane as usize];
                plane.normal.dot(parent.normal) > SAME_FACE
                    && (plane.offset - parent.offset).abs() < tolerance
            })
            .collect();
        parts.sort_unstable();
        // What an empty sum is.
        let mut areas = vec![-0.0; children.len()];
        for plane in parts {
            let piece = self.pieces[plane as usize] as usize;
            let hull = children[piece].hull;
            let face = &hull.faces[plane as usize - self.start(piece)];
            areas[piece] += hull.face_area(face) as f32;
        }
        areas
    }
}

impl Split<'_> {
    /// For the entries of one pair: which piece has each, and what its impulses are multiplied with.
    fn shares(
        &self,
        planes: &mut PiecePlanes,
        entries: &[CacheEntry],
        codes: impl Fn(&CacheEntry) -> KdCode,
    ) -> Vec<PieceShare> {
        let point = |entry| self.code_box.decode_center(codes(entry));
        let owned = entries.iter().filter_map(|entry| {
            let point = point(entry);
            let is_in_use = entry.age == 0;
            let impulse = if is_in_use { entry.normal_impulse } else { 0.0 };
            Some((planes.owner(point)?, point, impulse.max(0.0)))
        });
        let owned: Vec<_> = owned.collect();
        let face = common_face(planes, &owned);
        let areas = match face {
            Some(face) => planes.areas_in(&face, &self.children),
            None => vec![0.0; self.children.len()],
        };
        let (area, total): (f32, f32) = (areas.iter().sum(), owned.iter().map(|o| o.2).sum());
        let factor = |child: usize| {
            let own: f32 = (owned.iter().filter(|o| o.0 == child).map(|o| o.2)).sum();
            let fair = total * areas[child] / area;
            // Where there is nothing to go by, all stays as it was.
            if own > 0.0 && fair.is_finite() {
                fair / own
            } else {
                1.0
            }
        };
        let shares = owned.iter().map(|&(child, point, _)| PieceShare {
            child,
            point,
            factor: factor(child).min(MAX_RAISE),
        });
        shares.collect()
    }
}

/// The face (parent's frame) of a piece that owns points in which all points lie best; none for points that span none.
fn common_face(planes: &PiecePlanes, owned: &[(usize, Vec3, f32)]) -> Option<Plane> {
    if owned.len() < SPANNING {
        return None;
    }
    let off = |plane: &Plane| -> f32 {
        let distances = owned.iter().map(|(_, point, _)| plane.distance(*point));
        distances.map(f32::abs).sum()
    };
    let mut owners: Vec<usize> = owned.iter().map(|o| o.0).collect();
    owners.sort_unstable();
    owners.dedup();
    let of_piece = |piece: usize| &planes.planes[planes.start(piece)..planes.ends[piece]];
    let faces = owners.into_iter().flat_map(of_piece);
    faces.copied().min_by(|a, b| off(a).total_cmp(&off(b)))
}

/// What one piece gets of an entry.
#[derive(Clone, Copy, Debug)]
struct PieceShare {
    child: usize,
    /// The contact point, parent's frame, m.
    point: Vec3,
    /// What its impulses are multiplied with.
    factor: f32,
}

impl Child<'_> {
    /// Planes of its faces in the parent's frame.
    fn faces(&self) -> impl Iterator<Item = Plane> {
        self.hull.faces.iter().map(|face| {
            let plane = match &self.part {
                Some(pose) => face.plane.in_frame_of(&pose.inverse()),
                None => face.plane,
            };
            Plane {
                offset: plane.offset + plane.normal.dot(self.origin),
                ..plane
            }
        })
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
    pub(crate) fn transfer(&mut self, splits: &[Split], rotation_of: impl Fn(BodyId) -> Quat) {
        let rotation = |id: BodyId| {
            let split = splits.iter().find(|split| split.parent == id);
            split.map_or_else(|| rotation_of(id), |split| split.rotation)
        };
        for split in splits {
            let Self { current, next, .. } = self;
            let is_of =
                |pair: &&PairRecord| pair.bodies.0 == split.parent || pair.bodies.1 == split.parent;
            let mut passed: Vec<Named> = Vec::new();
            let mut pairs = current.pairs.iter().filter(is_of).peekable();
            // What touches nothing hands nothing on.
            let children = pairs.peek().map_or(&[][..], |_| &split.children);
            let mut planes = PiecePlanes::of(children);
            for pair in pairs {
                let entries = &current.entries[pair.range()];
                let is_a = pair.bodies.0 == split.parent;
                let code = |e: &CacheEntry| if is_a { e.code_a } else { e.code_b };
                let shares = split.shares(&mut planes, entries, code);
                let pass = |(entry, share)| pass_on(split, pair.bodies, entry, share, rotation);
                passed.extend(entries.iter().zip(&shares).map(pass));
            }
            passed.sort_by_key(|&(bodies, _)| bodies);
            next.clear();
            let kept = current.pairs.iter().filter(|pair| !is_of(pair));
            let passed = passed.chunk_by(|a, b| a.0 == b.0);
            for pair in merge(kept, passed, |kept, passed| kept.bodies.cmp(&passed[0].0)) {
                let (kept, passed) = pair.into_options();
                kept.into_iter()
                    .for_each(|pair| next.copy_pair(current, pair, 1.0));
                passed.into_iter().for_each(|new| next.push_pair(new));
            }
            std::mem::swap(current, next);
        }
    }
}

impl EntryTable {
    fn push_pair(&mut self, named: &[Named]) {
        let first = self.entries.len();
        self.entries.extend(named.iter().map(|(_, entry)| *entry));
        self.close_pair(named[0].0, first);
    }
}

/// The entry of a pair of the parent as that of a pair of the piece that owns its point.
fn pass_on(
    split: &Split,
    (a, b): (BodyId, BodyId),
    entry: &CacheEntry,
    share: &PieceShare,
    rotation_of: impl Fn(BodyId) -> Quat,
) -> Named {
    let (other, code_of_other) = if a == split.parent {
        (b, entry.code_b)
    } else {
        (a, entry.code_a)
    };
    let child = &split.children[share.child];
    if child.id == split.parent {
        // What goes on as the body has the codes that it had.
        let kept = CacheEntry {
            normal_impulse: share.factor * entry.normal_impulse,
            friction_impulse: share.factor * entry.friction_impulse,
            ..*entry
        };
        return ((a, b), kept);
    }
    let own_code = child.code_box.encode(share.point - child.origin);
    // The friction impulse is that on B, in A's frame. The piece, whose id is higher, is B.
    let on_b = rotate(rotation_of(a), share.factor * entry.friction_impulse);
    let on_child = if a == split.parent { -on_b } else { on_b };
    let passed = CacheEntry {
        code_a: code_of_other,
        code_b: own_code,
        normal_impulse: share.factor * entry.normal_impulse,
        friction_impulse: rotate(rotation_of(other).inverse(), on_child),
        ..*entry
    };
    ((other, child.id), passed)
}
