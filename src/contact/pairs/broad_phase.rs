//! Boxes -> sorted pairs of bodies that may touch.
//!
//! Each body's box is kept a little larger than asked for, and is renewed only when the body leaves it, so that resting
//! and slow bodies cost one comparison per step. Boxes lie in a bounding volume hierarchy (crate `obvhs`), which is only
//! searched for renewed boxes. The tree proposes, an exact test of the two kept boxes decides, and the list is sorted by
//! body id: pairs depend on how each body moved, but not on the tree's history nor on where bodies are stored.

use crate::contact::body_id::BodyId;
use crate::contact::layers::CollisionLayers;
use crate::contact::pairs::box_tree::BoxTree;
use crate::geometry::bvh::tree_box;
use crate::math::{Aabb, Plane};
use crate::merge::{Merged, merge};
use glam::Vec3;
use obvhs::bvh2::Bvh2;

/// A kept box exceeds the one asked for by at most this share of its longest edge, whatever the margin.
///
/// Otherwise splinters of a millimetre would pair with everything within a margin made for crates.
const MARGIN_SHARE: f32 = 0.25;

/// A kept box is renewed when an edge is this many times longer than a fresh one's: after a body was fast.
const SHRINK: f32 = 1.1;

/// Coordinates are cut to this inside the tree, whose cost estimates multiply them (m); the exact test is not affected.
const TREE_LIMIT: f32 = 1e15;

/// Whether a body can be pushed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProxyKind {
    /// Pairs with everything.
    Moving,
    /// Static or kinematic: pairs with moving bodies only.
    Fixed,
}

/// What the broad phase knows of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProxyShape {
    /// A world-axes box around all places where the body may be until the next [`Broadphase::set`], m.
    Box(Aabb),
    /// Everything below a plane of the world frame. Never pairs with another half-space.
    HalfSpace(Plane),
}

/// A body as the broad phase sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proxy {
    /// Name of the body.
    pub id: BodyId,
    /// Whether it can be pushed.
    pub kind: ProxyKind,
    /// What it collides with.
    pub layers: CollisionLayers,
    /// Where it is.
    pub shape: ProxyShape,
}

impl Proxy {
    /// Whether all numbers are usable; other proxies are treated as absent.
    fn is_usable(&self) -> bool {
        match self.shape {
            ProxyShape::Box(b) => {
                b.min.is_finite() && b.max.is_finite() && b.min.cmple(b.max).all()
            }
            ProxyShape::HalfSpace(plane) => plane.normal.is_finite() && plane.offset.is_finite(),
        }
    }
}

/// Two bodies that may touch, as slots; the one with the smaller id is `a`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair {
    /// Slot of the body with the smaller id.
    pub a: u32,
    /// Slot of the other body.
    pub b: u32,
}

/// A proxy with the box that is kept for it.
#[derive(Clone, Copy, Debug)]
struct KeptProxy {
    proxy: Proxy,
    /// For a box: the larger box. For a half-space: empty.
    fat: Aabb,
}

impl KeptProxy {
    /// Its box in the tree, if it has one.
    fn in_tree(&self) -> Option<obvhs::aabb::Aabb> {
        matches!(self.proxy.shape, ProxyShape::Box(_)).then(|| cut_box(&self.fat))
    }
}

/// Finds pairs; lives as long as the world.
#[derive(Clone, Default)]
pub struct Broadphase {
    kept: Vec<Option<KeptProxy>>,
    tree: BoxTree,
    pub(super) half_spaces: Vec<u32>,
    pairs: Vec<Pair>,
    revision: u64,
    /// Slots whose pairs are found anew in this step, as a list and as flags.
    renewed: Vec<u32>,
    is_renewed: Vec<bool>,
    fresh: Vec<Pair>,
    merged: Vec<Pair>,
    stack: Vec<u32>,
}

impl std::fmt::Debug for Broadphase {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Broadphase")
            .field("bodies", &self.kept.iter().flatten().count())
            .field("tree_nodes", &self.tree.tree().nodes.len())
            .field("pairs", &self.pairs.len())
            .finish_non_exhaustive()
    }
}

impl Broadphase {
    /// A broad phase without bodies.
    pub fn new() -> Self {
        Self::default()
    }

    /// Pairs whose kept boxes overlap, sorted by the ids of `(a, b)`.
    pub fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// Changes whenever [`pairs`](Self::pairs) may have changed.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// The tree of the kept boxes; its leaves are slots.
    pub(crate) fn tree(&self) -> &Bvh2 {
        self.tree.tree()
    }

    /// The box kept for the body in `slot`, if it has one.
    pub fn kept_box(&self, slot: u32) -> Option<Aabb> {
        let kept = self.kept.get(slot as usize)?.as_ref()?;
        matches!(kept.proxy.shape, ProxyShape::Box(_)).then_some(kept.fat)
    }

    /// Brings the pairs up to date with `proxies`, indexed by slot; `None` and non-finite ones are absent.
    ///
    /// `margin` (m): how far a new box reaches beyond the proxy's, at most a quarter of the proxy's longest edge.
    pub fn update(&mut self, proxies: &[Option<Proxy>], margin: f32) {
        let slots = proxies.len().max(self.kept.len());
        for slot in 0..slots {
            self.set(slot, proxies.get(slot).copied().flatten(), margin);
        }
        self.find_pairs();
    }

    /// Tells where the body of one slot is now, or that there is none; [`find_pairs`](Self::find_pairs) must follow.
    ///
    /// Slots that are not told of stay as they are. Returns how far the body may move, or its proxy's box may grow, in any
    /// direction until the slot must be told again, m; 0 for a half-space.
    pub fn set(&mut self, slot: usize, proxy: Option<Proxy>, margin: f32) -> f32 {
        if slot >= self.kept.len() {
            self.kept.resize(slot + 1, None);
        }
        self.update_slot(slot, proxy.filter(Proxy::is_usable), margin);
        match self.kept[slot].map(|kept| (kept.proxy.shape, kept.fat)) {
            Some((ProxyShape::Box(tight), fat)) => {
                let room = (tight.min - fat.min).min(fat.max - tight.max);
                room.min_element()
            }
            _ => 0.0,
        }
    }

    /// Brings the pairs up to date with what [`set`](Self::set) told.
    pub fn find_pairs(&mut self) {
        if self.renewed.is_empty() {
            return;
        }
        let kept = self.kept.iter().map(Option::as_ref);
        self.tree
            .tidy(kept.map(|kept| kept.and_then(KeptProxy::in_tree)));
        self.is_renewed.clear();
        self.is_renewed.resize(self.kept.len(), false);
        for &slot in &self.renewed {
            self.is_renewed[slot as usize] = true;
        }
        self.fresh.clear();
        for i in 0..self.renewed.len() {
            self.find_pairs_of(self.renewed[i]);
        }
        self.merge_fresh_pairs();
        self.renewed.clear();
    }

    /// Compares one slot with what is kept for it, and renews it if needed.
    fn update_slot(&mut self, slot: usize, proxy: Option<Proxy>, margin: f32) {
        let Some(proxy) = proxy else {
            if self.kept[slot].is_some() {
                self.remove(slot);
                self.mark(slot);
            }
            return;
        };
        match self.kept[slot] {
            Some(kept) if still_fits(&kept, &proxy, margin) => {
                self.kept[slot] = Some(KeptProxy { proxy, ..kept });
            }
            Some(kept)
                if matches!(kept.proxy.shape, ProxyShape::Box(_))
                    && matches!(proxy.shape, ProxyShape::Box(_)) =>
            {
                let fat = fat_box(&proxy, margin);
                self.tree.set(cut_box(&fat), slot as u32);
                self.kept[slot] = Some(KeptProxy { proxy, fat });
                self.mark(slot);
            }
            old => {
                if old.is_some() {
                    self.remove(slot);
                }
                self.insert(slot, proxy, margin);
                self.mark(slot);
            }
        }
    }

    fn mark(&mut self, slot: usize) {
        self.renewed.push(slot as u32);
    }

    fn insert(&mut self, slot: usize, proxy: Proxy, margin: f32) {
        let fat = fat_box(&proxy, margin);
        match proxy.shape {
            ProxyShape::Box(_) => {
                self.tree.insert(cut_box(&fat), slot as u32);
            }
            ProxyShape::HalfSpace(_) => self.half_spaces.push(slot as u32),
        }
        self.kept[slot] = Some(KeptProxy { proxy, fat });
    }

    fn remove(&mut self, slot: usize) {
        match self.kept[slot].take().map(|kept| kept.proxy.shape) {
            Some(ProxyShape::Box(_)) => self.tree.remove(slot as u32),
            Some(ProxyShape::HalfSpace(_)) => self.half_spaces.retain(|&s| s as usize != slot),
            None => {}
        }
    }

    /// Appends the pairs of a renewed slot to `fresh`. Of two renewed bodies with boxes the lower slot reports the
    /// pair; of a body and a renewed half-space, the half-space does.
    fn find_pairs_of(&mut self, slot: u32) {
        let Some(kept) = self.kept[slot as usize] else {
            return;
        };
        if matches!(kept.proxy.shape, ProxyShape::HalfSpace(_)) {
            for other in 0..self.kept.len() as u32 {
                self.push_if_touching(slot, other);
            }
            return;
        }
        for i in 0..self.half_spaces.len() {
            let other = self.half_spaces[i];
            if !self.is_renewed[other as usize] {
                self.push_if_touching(slot, other);
            }
        }
        let fat = cut_box(&kept.fat);
        self.stack.clear();
        self.stack.push(0);
        while let Some(index) = self.stack.pop() {
            let node = self.tree.tree().nodes[index as usize];
            if !node.aabb().intersect_aabb(&fat) {
                continue;
            }
            if node.is_leaf() {
                // There is one box to each leaf.
                let other = self.tree.tree().primitive_indices[node.first_index as usize];
                if !self.is_renewed[other as usize] || slot < other {
                    self.push_if_touching(slot, other);
                }
            } else {
                self.stack.extend([node.first_index, node.first_index + 1]);
            }
        }
    }

    /// The exact decision about two slots.
    fn push_if_touching(&mut self, s: u32, t: u32) {
        let (Some(k), Some(l)) = (&self.kept[s as usize], &self.kept[t as usize]) else {
            return;
        };
        if s != t && may_touch(k, l) {
            self.fresh.push(if k.proxy.id < l.proxy.id {
                Pair { a: s, b: t }
            } else {
                Pair { a: t, b: s }
            });
        }
    }

    /// Replaces the pairs of renewed slots by the fresh ones, keeping the order by id.
    fn merge_fresh_pairs(&mut self) {
        let kept = &self.kept;
        let key = |pair: &Pair| {
            [pair.a, pair.b].map(|slot| kept[slot as usize].as_ref().map(|k| k.proxy.id))
        };
        self.fresh.sort_unstable_by_key(key);
        self.merged.clear();
        let stays =
            |pair: &&Pair| !self.is_renewed[pair.a as usize] && !self.is_renewed[pair.b as usize];
        let old = self.pairs.iter().filter(stays);
        for pair in merge(old, &self.fresh, |old, fresh| key(old).cmp(&key(fresh))) {
            match pair {
                Merged::Left(pair) | Merged::Right(pair) => self.merged.push(*pair),
                // Not both: a fresh pair has a renewed slot.
                Merged::Both(old, fresh) => self.merged.extend([old, fresh]),
            }
        }
        std::mem::swap(&mut self.pairs, &mut self.merged);
        self.revision += 1;
    }
}

/// Whether two bodies' kept boxes overlap and the bodies collide at all.
fn may_touch(a: &KeptProxy, b: &KeptProxy) -> bool {
    let some_moves = a.proxy.kind == ProxyKind::Moving || b.proxy.kind == ProxyKind::Moving;
    some_moves
        && a.proxy.layers.interact(&b.proxy.layers)
        && match (a.proxy.shape, b.proxy.shape) {
            (ProxyShape::Box(_), ProxyShape::Box(_)) => a.fat.overlaps(&b.fat),
            (ProxyShape::HalfSpace(plane), ProxyShape::Box(_)) => reaches(&b.fat, &plane),
            (ProxyShape::Box(_), ProxyShape::HalfSpace(plane)) => reaches(&a.fat, &plane),
            (ProxyShape::HalfSpace(_), ProxyShape::HalfSpace(_)) => false,
        }
}

/// Whether a box has a point on or below a plane.
fn reaches(b: &Aabb, plane: &Plane) -> bool {
    let lowest = Vec3::select(plane.normal.cmpgt(Vec3::ZERO), b.min, b.max);
    plane.distance(lowest) <= 0.0
}

/// Whether nothing about a body changed that its pairs depend on.
fn still_fits(kept: &KeptProxy, proxy: &Proxy, margin: f32) -> bool {
    let same_body = kept.proxy.id == proxy.id
        && kept.proxy.kind == proxy.kind
        && kept.proxy.layers == proxy.layers;
    same_body
        && match (kept.proxy.shape, proxy.shape) {
            (ProxyShape::Box(_), ProxyShape::Box(tight)) => {
                let fresh = fat_box(proxy, margin);
                let allowed = SHRINK * fresh.extents();
                kept.fat.contains(&tight) && kept.fat.extents().cmple(allowed).all()
            }
            (ProxyShape::HalfSpace(old), ProxyShape::HalfSpace(new)) => old == new,
            _ => false,
        }
}

/// The box to keep for a proxy.
fn fat_box(proxy: &Proxy, margin: f32) -> Aabb {
    match proxy.shape {
        ProxyShape::Box(tight) => {
            let longest = tight.extents().max_element();
            tight.fattened(margin.min(MARGIN_SHARE * longest))
        }
        ProxyShape::HalfSpace(_) => Aabb::EMPTY,
    }
}

/// A box as the tree takes it.
fn cut_box(b: &Aabb) -> obvhs::aabb::Aabb {
    let cut = |corner: Vec3| corner.clamp(Vec3::splat(-TREE_LIMIT), Vec3::splat(TREE_LIMIT));
    tree_box(&Aabb {
        min: cut(b.min),
        max: cut(b.max),
    })
}

/// Two bodies by id, in the order of the pairs.
pub(crate) type PairName = (BodyId, BodyId);

/// What the pair is called.
#[inline]
pub(crate) fn name_of(pair: Pair, ids: &[BodyId]) -> PairName {
    (ids[pair.a as usize], ids[pair.b as usize])
}
