//! Groups of bodies that touch each other: what can be solved on its own.
//!
//! Bodies that contacts do not move join nothing: two piles on one floor are two islands. Each island's bodies are
//! numbered from 0, so that its rows and bodies lie side by side in memory and no two islands share anything that is
//! written. A fixed body has a number of its own in every island that touches it.

use crate::bodies::store::Bodies;
use crate::contact::manifolds::ManifoldHead;
use crate::disjoint_sets::DisjointSets;
use crate::solver::graph::indices::{BodyNumber, ManifoldIndex};
use crate::solver::graph::relative_motion::RelativeMotion;
use crate::threads::team::Team;
use crate::tuning::MIN_LINKS;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Marks a body that has no number yet.
const NONE: u32 = u32::MAX;

/// One group.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Island {
    /// Its part of [`Islands::manifolds`].
    pub manifolds: Range<usize>,
    /// Its part of [`Islands::slots`].
    pub bodies: Range<usize>,
    /// Its part of the list of contact points, in the order of its manifolds.
    pub points: Range<usize>,
    /// Whether any of its manifolds has restitution.
    pub bounces: bool,
    /// Its part of [`Islands::moving`].
    pub moving: Range<usize>,
    /// Its part of the list of joints.
    pub joints: Range<usize>,
}

/// A joint, as far as islands are concerned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JointLink {
    /// Slots; `None` is the world.
    pub bodies: [Option<u32>; 2],
    /// Whether joints move them.
    pub moves: [bool; 2],
    /// Its index in the list of a step.
    pub joint: u32,
}

/// A joint of an island: its index in the list of a step, and the numbers of its bodies in the island; `None` is the world.
pub(crate) type JointedPair = (u32, [Option<BodyNumber>; 2]);

/// A manifold whose bodies move so far against each other that its rows follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MovingPair {
    /// Its place in [`Islands::manifolds`].
    pub at: usize,
    /// Whether the bodies may pass through each other in the step.
    pub is_fast: bool,
}

/// What islands need of a manifold, which is large: one after the other in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Link {
    /// Slots.
    bodies: [u32; 2],
    /// A slot of the island that it belongs to; `NONE` if it belongs to none.
    of: u32,
    /// Number of its points.
    points: u16,
    /// Whether contacts move both bodies.
    joins: bool,
    /// Whether they rebound from each other.
    bounces: bool,
}

impl Link {
    fn new(manifold: &ManifoldHead, bodies: &Bodies, is_pending: bool) -> Self {
        let (a, b) = (manifold.a, manifold.b);
        let moves = [a, b].map(|slot| bodies.velocity[slot as usize].inverse_mass > 0.0);
        let of = match moves {
            [true, _] => a,
            [false, true] => b,
            [false, false] => NONE,
        };
        Self {
            bodies: [a, b],
            of: if is_pending { of } else { NONE },
            points: manifold.count as u16,
            joins: is_pending && moves == [true; 2],
            bounces: manifold.restitution > 0.0,
        }
    }

    /// Whether it makes the same islands as another one.
    fn joins_as(&self, other: &Self) -> bool {
        let points = self.points;
        *self == Self { points, ..*other }
    }
}

impl JointLink {
    /// A slot of the island that it belongs to.
    fn of(&self) -> Option<u32> {
        let movable = |side: usize| self.bodies[side].filter(|_| self.moves[side]);
        movable(0).or(movable(1))
    }
}

/// The islands of a step, kept while the same bodies touch at as many points; buffers are reused.
#[derive(Debug, Default)]
pub struct Islands {
    /// The islands, in the order of their first manifolds.
    pub list: Vec<Island>,
    /// Indices of manifolds, island by island; ascending within an island.
    pub manifolds: Vec<ManifoldIndex>,
    /// The two bodies of each of `manifolds`, as numbers within the island.
    pub pairs: Vec<[BodyNumber; 2]>,
    /// Number of points of each of `manifolds`.
    pub counts: Vec<u32>,
    /// Slots of bodies, island by island, in the order in which the manifolds name them.
    pub slots: Vec<u32>,
    /// Those of `manifolds` whose bodies move in the step, in their order.
    pub moving: Vec<MovingPair>,
    /// Joints, island by island.
    pub(crate) joints: Vec<JointedPair>,
    /// The joints of the step, whose bodies belong together; to be set before the islands are looked for.
    pub joint_links: Vec<JointLink>,
    /// Those that the islands are made of.
    old_joint_links: Vec<JointLink>,
    /// Grows when the islands change.
    pub(crate) revision: u64,
    /// By manifold: what the islands are made of, and what the present step has.
    links: Vec<Link>,
    new_links: Vec<Link>,
    /// By manifold: the index of its island, if it belongs to one.
    island: Vec<u32>,
    /// Over slots.
    sets: DisjointSets,
    /// By slot of a root: index of its island.
    island_of: Vec<u32>,
    /// By slot: number within the island being filled.
    number: Vec<u32>,
}

impl Islands {
    /// Finds the islands of those of `manifolds`, which hold slots of `bodies`, that `is_pending` tells. Manifolds of two fixed
    /// bodies are left out.
    pub fn find(
        &mut self,
        manifolds: &[ManifoldHead],
        bodies: &Bodies,
        is_pending: impl Fn(&ManifoldHead) -> bool + Sync,
        team: Option<&Team>,
    ) {
        self.new_links.resize(manifolds.len(), Link::default());
        let old_links = &self.links;
        let is_as_many = old_links.len() == manifolds.len();
        // Other points, and other islands.
        let is_other = !is_as_many || self.joint_links != self.old_joint_links;
        let [have_changed, are_new] = [0; 2].map(|_| AtomicBool::new(is_other));
        let size = Team::part_size(team, manifolds.len(), MIN_LINKS);
        let parts = self.new_links.chunks_mut(size).zip(manifolds.chunks(size));
        Team::each_of_many(team, parts.enumerate(), |(part, (links, manifolds))| {
            for (link, manifold) in links.iter_mut().zip(manifolds) {
                *link = Link::new(manifold, bodies, is_pending(manifold));
            }
            let first = part * size;
            let old = old_links.get(first..first + links.len());
            if let Some(old) = old.filter(|old| *old != links) {
                have_changed.store(true, Ordering::Relaxed);
                if !old.iter().zip(&*links).all(|(old, new)| old.joins_as(new)) {
                    are_new.store(true, Ordering::Relaxed);
                }
            }
        });
        if !have_changed.into_inner() {
            return;
        }
        self.revision += 1;
        std::mem::swap(&mut self.links, &mut self.new_links);
        if !are_new.into_inner() {
            return self.count_points();
        }
        self.sets.reset(bodies.slots());
        for &Link { bodies: [a, b], .. } in self.links.iter().filter(|link| link.joins) {
            self.sets.join(a, b);
        }
        self.old_joint_links.clone_from(&self.joint_links);
        for link in self
            .joint_links
            .iter()
            .filter(|link| link.moves == [true; 2])
        {
            if let [Some(a), Some(b)] = link.bodies {
                self.sets.join(a, b);
            }
        }
        self.count();
        self.sort();
        self.sort_joints();
        self.number_bodies(bodies.slots());
    }

    /// Counts points anew where the islands are as they were.
    fn count_points(&mut self) {
        let links = self
            .manifolds
            .iter()
            .map(|&index| &self.links[index.index()]);
        for (count, link) in self.counts.iter_mut().zip(links) {
            *count = u32::from(link.points);
        }
        let mut end = 0;
        for island in &mut self.list {
            let first = end;
            end += self.counts[island.manifolds.clone()].iter().sum::<u32>() as usize;
            island.points = first..end;
        }
    }

    /// Number of manifolds of some of the islands, by their indices.
    pub(crate) fn manifolds_of(&self, group: &[u32]) -> usize {
        let list = group.iter().map(|&island| &self.list[island as usize]);
        list.map(|island| island.manifolds.len()).sum()
    }

    /// Finds the manifolds whose rows follow the motion of their bodies; `relative_motion` tells how these move, by index of a manifold.
    pub fn find_moving(&mut self, relative_motion: impl Fn(ManifoldIndex) -> RelativeMotion) {
        self.moving.clear();
        for island in &mut self.list {
            let first = self.moving.len();
            for at in island.manifolds.clone() {
                let relative_motion = relative_motion(self.manifolds[at]);
                if relative_motion.is_noticeable {
                    let is_fast = relative_motion.is_fast;
                    self.moving.push(MovingPair { at, is_fast });
                }
            }
            island.moving = first..self.moving.len();
        }
    }

    /// Makes the islands and counts their manifolds and points.
    fn count(&mut self) {
        self.list.clear();
        self.island_of.clear();
        self.island_of.resize(self.sets.len(), NONE);
        self.island.clear();
        for at in 0..self.links.len() {
            let link = self.links[at];
            if link.of == NONE {
                self.island.push(NONE);
                continue;
            }
            let number = self.island_with(link.of);
            self.island.push(number);
            let island = &mut self.list[number as usize];
            island.manifolds.end += 1;
            island.points.end += usize::from(link.points);
            island.bounces |= link.bounces;
        }
        for at in 0..self.joint_links.len() {
            if let Some(slot) = self.joint_links[at].of() {
                let number = self.island_with(slot);
                self.list[number as usize].joints.end += 1;
            }
        }
        let (mut manifolds, mut points) = (0, 0);
        for island in &mut self.list {
            // Ends grow again as the manifolds are put in their places.
            let count = island.manifolds.end;
            island.manifolds = manifolds..manifolds;
            manifolds += count;
            island.points = points..points + island.points.end;
            points = island.points.end;
        }
    }

    /// The island of a slot, a new one if it has none.
    fn island_with(&mut self, slot: u32) -> u32 {
        let root = self.sets.root(slot);
        let island = &mut self.island_of[root as usize];
        if *island == NONE {
            *island = self.list.len() as u32;
            self.list.push(Island::default());
        }
        *island
    }

    /// Sorts the joints by island.
    fn sort_joints(&mut self) {
        let mut end = 0;
        for island in &mut self.list {
            let count = island.joints.end;
            island.joints = end..end;
            end += count;
        }
        self.joints.clear();
        self.joints.resize(end, JointedPair::default());
        for at in 0..self.joint_links.len() {
            let link = self.joint_links[at];
            let Some(slot) = link.of() else {
                continue;
            };
            let number = self.island_with(slot);
            let island = &mut self.list[number as usize];
            // Numbers of the island come once its bodies have some.
            let bodies = link.bodies.map(|slot| slot.map(BodyNumber));
            self.joints[island.joints.end] = (link.joint, bodies);
            island.joints.end += 1;
        }
    }

    /// Sorts the manifolds by island.
    fn sort(&mut self) {
        let islands = (0..).zip(&self.island);
        let islands = islands.filter(|(_, island)| **island != NONE);
        self.manifolds.clear();
        self.manifolds
            .resize(islands.clone().count(), ManifoldIndex::default());
        for (index, &island) in islands {
            let island = &mut self.list[island as usize];
            self.manifolds[island.manifolds.end] = ManifoldIndex(index);
            island.manifolds.end += 1;
        }
    }

    /// Numbers the bodies of each island.
    fn number_bodies(&mut self, slots: usize) {
        self.slots.clear();
        self.pairs.clear();
        self.counts.clear();
        self.number.clear();
        self.number.resize(slots, NONE);
        for island in &mut self.list {
            let first = self.slots.len();
            for &index in &self.manifolds[island.manifolds.clone()] {
                let link = &self.links[index.index()];
                let pair = link.bodies.map(|slot| {
                    let number = &mut self.number[slot as usize];
                    if *number == NONE {
                        *number = (self.slots.len() - first) as u32;
                        self.slots.push(slot);
                    }
                    BodyNumber(*number)
                });
                self.pairs.push(pair);
                self.counts.push(u32::from(link.points));
            }
            for (_, bodies) in &mut self.joints[island.joints.clone()] {
                for body in bodies.iter_mut().flatten() {
                    let slot = body.0;
                    let number = &mut self.number[slot as usize];
                    if *number == NONE {
                        *number = (self.slots.len() - first) as u32;
                        self.slots.push(slot);
                    }
                    *body = BodyNumber(*number);
                }
            }
            island.bodies = first..self.slots.len();
            for &slot in &self.slots[island.bodies.clone()] {
                self.number[slot as usize] = NONE;
            }
        }
    }
}
