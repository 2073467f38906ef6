//! Where bodies are, laid out for questions: a tree of four boxes a node around what they are now, and by its leaves what a walk reads
//! of a body first.
//!
//! To be looked at costs a body that stands still one comparison. One that moves gets a box with room to go on as it did, so that it
//! changes the tree every few looks only, and then the boxes above are made anew in one pass. What is new, of another shape, or gone,
//! is a stray until so many are, or have been for so long, that the tree is built anew.

use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::geometry::bvh::{RayWalk, tree_box, tree_of};
use crate::geometry::wide_tree::WideTree;
use crate::math::Aabb;
use crate::query::movers::KinematicMovers;
use crate::query::place::Place;
use crate::query::target::Target;
use bevy_ecs::resource::Resource;
use glam::{Quat, Vec3};
use obvhs::ploc::PlocSearchDistance;
use std::sync::OnceLock;

/// The tree is built anew when there are more strays than this, and than this share of what is in the tree.
const FEW: usize = 8;
const SHARE: f32 = 0.125;

/// And when the surfaces of its nodes have become so many times larger: what stood together has parted.
const LOOSE: f32 = 2.0;

/// A box has room for this many times the last motion.
const ROOM: f32 = 2.0;

/// Leaf of a body that is not in the tree.
const NONE: u32 = u32::MAX;

/// What was seen of a body.
#[derive(Clone, Copy, Debug)]
struct Seen {
    id: BodyId,
    version: u32,
    center: Vec3,
    rotation: Quat,
    radius: f32,
    /// How far it may move until it has to get another box, m.
    room: f32,
    leaf: u32,
}

impl Seen {
    const NOTHING: Self = Self {
        id: BodyId(u32::MAX),
        version: 0,
        center: Vec3::ZERO,
        rotation: Quat::IDENTITY,
        radius: 0.0,
        room: 0.0,
        leaf: NONE,
    };

    fn now(bodies: &Bodies, slot: u32, leaf: u32) -> Self {
        let i = slot as usize;
        Self {
            id: bodies.ids[i],
            version: bodies.version[i],
            center: bodies.center[i],
            rotation: bodies.rotation[i],
            radius: bodies.radius(slot),
            room: 0.0,
            leaf,
        }
    }

    /// Whether it was this body, with this shape.
    #[inline]
    fn is(&self, bodies: &Bodies, slot: u32) -> bool {
        let i = slot as usize;
        self.leaf != NONE
            && self.id == bodies.ids[i]
            && self.version == bodies.version[i]
            && self.radius == bodies.radius(slot)
    }

    /// How far a point of the body has moved since, at most, m.
    #[inline]
    fn motion(&self, bodies: &Bodies, slot: u32) -> f32 {
        let i = slot as usize;
        let moved = (bodies.center[i] - self.center).length();
        let turn = (bodies.rotation[i] - self.rotation).length();
        moved + 2.0 * turn * self.radius
    }
}

/// A body with its box.
#[derive(Clone, Debug)]
struct Leaf {
    place: Place,
    bounds: Aabb,
}

/// Where bodies are.
#[derive(Clone, Default, Resource)]
pub struct QueryIndex {
    half_spaces: Vec<Place>,
    /// By slot.
    seen: Vec<Seen>,
    tree: WideTree,
    /// By leaf of the tree; empty where the body is gone.
    places: Vec<Place>,
    bounds: Vec<Aabb>,
    /// Leaves whose bodies are gone.
    gone: usize,
    /// Surface of the nodes when the tree was built, and now, m2.
    surface: [f32; 2],
    strays: Vec<Leaf>,
    stray_tree: WideTree,
    /// How many strays have been sorted since the tree was built, each as often as it was.
    sorted: usize,
    /// Of the bodies when they were looked at.
    departures: u64,
    /// What characters look for, from the first that asks on, and the revision of velocities that this is of.
    movers: OnceLock<(u64, KinematicMovers)>,
}

impl std::fmt::Debug for QueryIndex {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("QueryIndex")
            .field("half_spaces", &self.half_spaces.len())
            .field("bodies", &(self.places.len() - self.gone))
            .field("strays", &self.strays.len())
            .finish_non_exhaustive()
    }
}

/// A tree over bodies, and they in the order of its leaves.
fn tree_over(leaves: Vec<Leaf>) -> (WideTree, Vec<Leaf>) {
    let boxes: Vec<_> = leaves.iter().map(|leaf| tree_box(&leaf.bounds)).collect();
    let mut tree = WideTree::of(&tree_of(&boxes, PlocSearchDistance::Low));
    let mut leaves: Vec<_> = leaves.into_iter().map(Some).collect();
    let order = tree.renumber().into_iter();
    let leaves = order.filter_map(|at| leaves[at as usize].take()).collect();
    (tree, leaves)
}

impl QueryIndex {
    /// Looks where the bodies are now: about 10 ns for each.
    pub fn refresh(&mut self, bodies: &Bodies) {
        self.departures = bodies.departures;
        self.movers.take();
        self.half_spaces.clear();
        self.strays.clear();
        for slot in bodies.slots()..self.seen.len() {
            self.forget(slot);
        }
        self.seen.resize(bodies.slots(), Seen::NOTHING);
        let mut is_moved = false;
        for slot in 0..bodies.slots() {
            is_moved |= self.look_at(bodies, slot as u32);
        }
        let odd = self.strays.len() + self.gone;
        let is_odd = odd > FEW && odd as f32 > SHARE * self.places.len() as f32;
        // What stays is sorted once and for all, before it has been sorted again and again at the same price.
        self.sorted += self.strays.len();
        if is_odd
            || self.sorted > self.places.len().max(FEW)
            || self.surface[1] > LOOSE * self.surface[0]
        {
            self.rebuild();
            return;
        }
        if is_moved {
            let bounds = &self.bounds;
            self.surface[1] = self.tree.refit(|leaf| bounds[leaf as usize]);
        }
        if self.strays.is_empty() {
            self.stray_tree = WideTree::default();
        } else {
            (self.stray_tree, self.strays) = tree_over(std::mem::take(&mut self.strays));
        }
    }

    /// Whether all bodies that were found are still there.
    pub(super) fn is_current(&self, bodies: &Bodies) -> bool {
        self.departures == bodies.departures
    }

    /// The kinematic bodies that move: to find them takes a look at each body, once after each [`refresh`](Self::refresh). None where
    /// others may move since then.
    pub(super) fn movers(&self, bodies: &Bodies) -> Option<&KinematicMovers> {
        let found = || (bodies.velocities_set, KinematicMovers::of(bodies));
        let (revision, movers) = self.movers.get_or_init(found);
        (*revision == bodies.velocities_set).then_some(movers)
    }

    /// Looks where a body is; whether its box has changed.
    #[inline]
    fn look_at(&mut self, bodies: &Bodies, slot: u32) -> bool {
        let i = slot as usize;
        if !bodies.is_active(slot) {
            self.forget(i);
            return false;
        }
        if !self.seen[i].is(bodies, slot) {
            self.forget(i);
            self.take_in(bodies, slot);
            return false;
        }
        let seen = &mut self.seen[i];
        let motion = seen.motion(bodies, slot);
        if motion == 0.0 {
            return false;
        }
        let place = &mut self.places[seen.leaf as usize];
        place.follow(bodies);
        let room = seen.room - motion;
        *seen = Seen::now(bodies, slot, seen.leaf);
        // Not a number counts as far.
        if room >= 0.0 {
            seen.room = room;
            return false;
        }
        match Target::at(place).bounds().filter(is_finite) {
            Some(b) => {
                seen.room = (ROOM * motion).min(b.diagonal());
                self.bounds[seen.leaf as usize] = b.fattened(seen.room);
                true
            }
            None => {
                self.forget(i);
                false
            }
        }
    }

    /// A body that is not in the tree.
    fn take_in(&mut self, bodies: &Bodies, slot: u32) {
        let place = Place::of(bodies, slot);
        match Target::at(&place).bounds() {
            None => self.half_spaces.push(place),
            Some(bounds) if is_finite(&bounds) => self.strays.push(Leaf { place, bounds }),
            Some(_) => {}
        }
        self.seen[slot as usize] = Seen::now(bodies, slot, NONE);
    }

    /// Takes a body out of the tree, if it is there.
    fn forget(&mut self, slot: usize) {
        let leaf = std::mem::replace(&mut self.seen[slot].leaf, NONE);
        if leaf != NONE {
            self.places[leaf as usize].clear();
            self.gone += 1;
        }
    }

    /// Builds the tree anew, with all strays in it.
    fn rebuild(&mut self) {
        let known = self.places.drain(..).zip(self.bounds.drain(..));
        let known = known.map(|(place, bounds)| Leaf { place, bounds });
        let all = known
            .filter(|leaf| !leaf.place.is_empty())
            .chain(self.strays.drain(..))
            .collect();
        let leaves;
        (self.tree, leaves) = tree_over(all);
        for (number, leaf) in (0..).zip(leaves) {
            self.seen[leaf.place.slot as usize].leaf = number;
            self.places.push(leaf.place);
            self.bounds.push(leaf.bounds);
        }
        (self.stray_tree, self.gone, self.sorted) = (WideTree::default(), 0, 0);
        let bounds = &self.bounds;
        let surface = self.tree.refit(|leaf| bounds[leaf as usize]);
        self.surface = [surface; 2];
    }

    /// Visits what may lie along a way up to `end` (m), roughly from near to far. `visit` is given the present end and returns the new
    /// one.
    pub(super) fn along<'q>(
        &'q self,
        walk: RayWalk,
        mut end: f32,
        mut visit: impl FnMut(&'q Place, f32) -> f32,
    ) {
        for place in &self.half_spaces {
            end = visit(place, end);
        }
        self.stray_tree
            .along_ray(&self.strays, walk, end, |leaf, now| {
                end = visit(&self.strays[leaf as usize].place, now);
                end
            });
        self.tree.along_ray(&self.places, walk, end, |leaf, now| {
            visit(&self.places[leaf as usize], now)
        });
    }

    /// Visits what may lie in a box.
    pub(super) fn inside<'q>(&'q self, b: &Aabb, mut visit: impl FnMut(&'q Place)) {
        self.half_spaces.iter().for_each(&mut visit);
        self.stray_tree.within(&self.strays, b, |leaf| {
            visit(&self.strays[leaf as usize].place)
        });
        self.tree
            .within(&self.places, b, |leaf| visit(&self.places[leaf as usize]));
    }

    /// Visits what may be within `limit` (m) of a point, roughly from near to far. `visit` is given the present limit and returns the
    /// new one; what holds the point is visited all the same.
    pub(super) fn near<'q>(
        &'q self,
        point: Vec3,
        mut limit: f32,
        mut visit: impl FnMut(&'q Place, f32) -> f32,
    ) {
        for place in &self.half_spaces {
            limit = visit(place, limit);
        }
        self.stray_tree
            .around(&self.strays, point, limit, |leaf, now| {
                limit = visit(&self.strays[leaf as usize].place, now);
                limit
            });
        self.tree.around(&self.places, point, limit, |leaf, now| {
            visit(&self.places[leaf as usize], now)
        });
    }
}

fn is_finite(b: &Aabb) -> bool {
    b.min.is_finite() && b.max.is_finite()
}
