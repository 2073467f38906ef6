//! What of a body that stood goes on standing when it breaks: the pieces that hold on to the world.
//!
//! Each piece is looked at by itself, because all that are not one piece are divided by cracks. It holds on where it lies face to face
//! on something that stands, or reaches into it (`hold_area.rs`): the regions that its [`Anchors`] name, or static bodies around it,
//! but never what was once a part of the same body.
//!
//! Nothing hangs on what hangs on nothing. Bodies that stand for themselves are the ground; those that may break, and pieces, stand as
//! long as a chain of contacts leads from them to the ground. When one of them breaks, what it bore is looked at anew: of what
//! had its ground through it, and has none any more, all falls. What hung in the air from the start was put there, and stays.

use crate::bodies::anchors::{AnchorRegion, Anchors, Hold};
use crate::bodies::body::{BodyDesc, RigidBody, Shape};
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::fracture::hold_area::{Standing, holds};
use crate::geometry::primitives::cuboid;
use crate::geometry::{Compound, CompoundPart, ConvexHull};
use crate::math::{Aabb, Plane, Pose, rotate};
use glam::{Quat, Vec3};
use smallvec::SmallVec;

/// Default of [`Anchors::reach`], as a share of the geometric mean of the least and the largest extent.
const REACH_SHARE: f32 = 0.01;

/// A body that stands before it breaks, and what is around it.
#[derive(Debug)]
pub(super) struct Foothold {
    slot: u32,
    kind: RigidBody,
    anchors: Anchors,
    /// m.
    reach: f32,
    /// What it once was a piece of, or it itself.
    origin: BodyId,
    /// Static bodies near it, by slot.
    neighbors: Vec<u32>,
    /// Those of them that it touches.
    touching: Vec<u32>,
    /// Whether it had a chain of contacts to the ground.
    had_ground: bool,
}

impl Foothold {
    /// How the body in `slot` stands, and what stands on it; `None` if it is dynamic.
    pub(super) fn of(bodies: &Bodies, slot: u32) -> Option<Self> {
        let (mut foothold, mut ground) = Self::among(bodies, slot)?;
        let mut touching = ground.around(slot, &foothold.neighbors, foothold.reach);
        touching.extend(ground.hanging_on(slot));
        touching.sort_unstable();
        touching.dedup();
        foothold.touching = touching;
        foothold.had_ground = foothold.kind == RigidBody::Static && ground.reaches(slot);
        Some(foothold)
    }

    /// The same, without what stands on it: enough to tell which parts hold on.
    pub(super) fn of_parts(bodies: &Bodies, slot: u32) -> Option<Self> {
        Self::among(bodies, slot).map(|(foothold, _)| foothold)
    }

    fn among(bodies: &Bodies, slot: u32) -> Option<(Self, Ground<'_>)> {
        let kind = bodies.kind(slot);
        let aabb = hulls_box(&bodies.info(slot).shape).filter(|_| kind != RigidBody::Dynamic)?;
        let unsaid = if kind == RigidBody::Static {
            Anchors::touching()
        } else {
            Anchors::none()
        };
        let anchors = bodies.anchors(slot).cloned().unwrap_or(unsaid);
        let reach = reach_of(&anchors, &aabb);
        let ground = Ground::new(bodies, true);
        let foothold = Self {
            slot,
            kind,
            anchors,
            reach,
            origin: origin_of(bodies, slot),
            neighbors: ground.near(slot, reach),
            touching: Vec::new(),
            had_ground: false,
        };
        Some((foothold, ground))
    }

    /// Makes those of the pieces that hold on what the body was; how they hold on, by piece.
    pub(super) fn keep(&self, bodies: &Bodies, pieces: &mut [BodyDesc]) -> Vec<Option<Hold>> {
        let body = bodies.pose(self.slot);
        let look = |piece: &mut BodyDesc| {
            let origin = body.inverse_transform_point(piece.pose.position);
            let anchors = self.anchors.seen_from(origin);
            let mut hulls = hulls_of(&piece.shape).into_iter();
            let is_held = hulls.any(|hull| self.is_held(bodies, hull, &piece.pose, &anchors));
            drop(hulls);
            is_held.then(|| {
                piece.kind = self.kind;
                Hold {
                    anchors: Some(anchors.with_reach(self.reach)),
                    origin: Some(self.origin),
                }
            })
        };
        pieces.iter_mut().map(look).collect()
    }

    /// Whether a part of the body holds on.
    pub(super) fn holds_part(&self, bodies: &Bodies, part: &CompoundPart) -> bool {
        let hull = HullOf(part.shape.hull(), Some(part.pose));
        self.is_held(bodies, hull, &bodies.pose(self.slot), &self.anchors)
    }

    /// Whether a hull of a piece at `pose` holds on; the anchors are in the frame of the piece.
    fn is_held(&self, bodies: &Bodies, hull: HullOf, pose: &Pose, anchors: &Anchors) -> bool {
        if holds_in_regions(anchors, hull, self.reach) {
            return true;
        }
        let (hull, pose) = (hull.0, &hull.seen_from(*pose));
        let mut neighbors = self
            .neighbors
            .iter()
            .filter(|&&other| anchors.is_touching && origin_of(bodies, other) != self.origin);
        neighbors.any(|&other| holds(hull, &Standing::of(bodies, other, pose), self.reach))
    }

    /// After the body broke into `pieces`: lets those of them, and of what stood on it, fall that have no ground; who that was.
    pub(super) fn let_fall(self, bodies: &mut Bodies, pieces: &[u32]) -> Vec<u32> {
        if self.kind != RigidBody::Static {
            return Vec::new();
        }
        let mut fallen = Vec::new();
        let mut ground = Ground::new(bodies, self.had_ground);
        let mut asked: Vec<u32> = pieces.iter().chain(&self.touching).copied().collect();
        let mut next = 0;
        while let Some(&slot) = asked.get(next) {
            next += 1;
            let is_known = fallen.contains(&slot) || bodies.kind(slot) != RigidBody::Static;
            if !is_known && !ground.reaches(slot) {
                // All that a search went through hangs on nothing, and what hangs on that may have nothing else.
                let lost = ground.searched.iter();
                asked.extend(lost.flat_map(|&slot| ground.hanging_on(slot)));
                fallen.append(&mut ground.searched);
            }
        }
        fallen.sort_by_key(|&slot| bodies.id(slot));
        fallen.dedup();
        fallen.iter().for_each(|&slot| bodies.let_fall(slot));
        self.touching
            .iter()
            .for_each(|&slot| bodies.doubt_holds(slot));
        fallen
    }
}

/// What a body once was a piece of, or it itself: a cluster that goes on is no other body than what came off of it.
fn origin_of(bodies: &Bodies, slot: u32) -> BodyId {
    let hold = bodies.hold(slot);
    hold.and_then(|hold| hold.origin).unwrap_or(bodies.id(slot))
}

/// A hull of a body, and of a part its pose in the body's frame.
#[derive(Clone, Copy, Debug)]
struct HullOf<'s>(&'s ConvexHull, Option<Pose>);

impl HullOf<'_> {
    /// Where it is if the body is at `pose`.
    fn seen_from(&self, pose: Pose) -> Pose {
        self.1.map_or(pose, |part| pose * part)
    }
}

/// The hulls that a shape is made of.
fn hulls_of(shape: &Shape) -> SmallVec<[HullOf<'_>; 1]> {
    let parts = shape.compound().map_or(&[][..], Compound::parts).iter();
    let parts = parts.map(|part| HullOf(part.shape.hull(), Some(part.pose)));
    let whole = shape.convex().map(|mesh| HullOf(mesh.hull(), None));
    whole.into_iter().chain(parts).collect()
}

/// The box around them.
fn hulls_box(shape: &Shape) -> Option<Aabb> {
    match shape {
        Shape::Convex(mesh) => Some(mesh.hull().aabb()),
        Shape::Compound(compound) => Some(compound.aabb()),
        Shape::HalfSpace(_) | Shape::Level(_) => None,
    }
}

/// The gap over which a body whose hull has this box holds on, m.
fn reach_of(anchors: &Anchors, aabb: &Aabb) -> f32 {
    let extents = aabb.extents();
    let mean = (extents.min_element() * extents.max_element()).sqrt();
    anchors.reach.unwrap_or(REACH_SHARE * mean)
}

/// Whether a piece, in whose frame the anchors are, reaches into one of their regions.
fn holds_in_regions(anchors: &Anchors, HullOf(hull, part): HullOf, reach: f32) -> bool {
    anchors.regions.iter().any(|region| match *region {
        AnchorRegion::Behind { normal, offset } => {
            let normal = normal.normalize_or(Vec3::Y);
            let plane = Plane { normal, offset };
            let plane = part.map_or(plane, |part| plane.in_frame_of(&part));
            holds(hull, &Standing::HalfSpace(plane), reach)
        }
        AnchorRegion::Within { min, max } => {
            let at = Pose::new(0.5 * (min + max), Quat::IDENTITY);
            let at = part.map_or(at, |part| part.inverse() * at);
            let size = max - min;
            let region = cuboid(size.x, size.y, size.z);
            region.is_ok_and(|region| holds(hull, &Standing::Hull(&region, at), reach))
        }
    })
}

/// The box of a body's shape, world, m; `None` for a half-space.
fn world_box(bodies: &Bodies, slot: u32) -> Option<Aabb> {
    let local = match &bodies.info(slot).shape {
        Shape::Convex(mesh) => mesh.hull().aabb(),
        Shape::Level(level) => level.aabb(),
        Shape::Compound(compound) => compound.aabb(),
        Shape::HalfSpace(_) => return None,
    };
    let pose = bodies.pose(slot);
    let corner = |i: u8| {
        let choose = |bit: u8, min: f32, max: f32| if i & bit == 0 { min } else { max };
        let Aabb { min, max } = local;
        pose.transform_point(Vec3::new(
            choose(1, min.x, max.x),
            choose(2, min.y, max.y),
            choose(4, min.z, max.z),
        ))
    };
    Some(Aabb::of_points((0..8).map(corner)))
}

/// Searches for the ground along contacts of what stands.
struct Ground<'b> {
    bodies: &'b Bodies,
    /// Static bodies, by slot, and their boxes in the world; half-spaces have none.
    standing: Vec<(u32, Option<Aabb>)>,
    /// Whether whole bodies that may break need a chain of contacts to it. If what they hung on had none, they were put there.
    need_chains: bool,
    /// By slot: whether a chain leads from it to the ground, of those that are on one which was found.
    is_known: Vec<bool>,
    /// Bodies of the last search, in the order in which they were found.
    searched: Vec<u32>,
    /// For each of them, from which one it was found, by its place among them.
    came_from: Vec<usize>,
}

impl<'b> Ground<'b> {
    fn new(bodies: &'b Bodies, need_chains: bool) -> Self {
        let standing = bodies.iter().filter(|&slot| {
            let is_static = bodies.kind(slot) == RigidBody::Static;
            is_static && bodies.is_active(slot) && !bodies.is_sensor(slot)
        });
        Self {
            bodies,
            standing: standing
                .map(|slot| (slot, world_box(bodies, slot)))
                .collect(),
            need_chains,
            is_known: vec![false; bodies.slots()],
            searched: Vec::new(),
            came_from: Vec::new(),
        }
    }

    /// Whether a static body stands for itself.
    fn is_ground(&self, slot: u32) -> bool {
        if hulls_box(&self.bodies.info(slot).shape).is_none() {
            // It has no inside, and never falls, whatever is said of its anchors.
            return true;
        }
        let anchors = self.bodies.anchors(slot);
        if anchors.is_some_and(|anchors| self.is_in_region(slot, anchors)) {
            return true;
        }
        let hold = self.bodies.hold(slot);
        let is_piece = hold.is_some_and(|hold| hold.origin.is_some());
        let is_breakable =
            self.bodies.fracturable(slot).is_some() || self.bodies.cluster(slot).is_some();
        let is_fragile = is_breakable || anchors.is_some();
        !(is_piece || is_fragile && self.need_chains)
    }

    /// Whether a body reaches into a region of its anchors. Pieces keep those of the whole, wherever they come from.
    fn is_in_region(&self, slot: u32, anchors: &Anchors) -> bool {
        if anchors.regions.is_empty() {
            return false;
        }
        let reach = self.reach_of(slot);
        let hulls = hulls_of(&self.bodies.info(slot).shape);
        hulls
            .into_iter()
            .any(|hull| holds_in_regions(anchors, hull, reach))
    }

    /// Those that hold on to a body where they touch it, which need not be those that it holds on to: what is enough depends on who holds.
    fn hanging_on(&self, slot: u32) -> Vec<u32> {
        let around = world_box(self.bodies, slot);
        let others = self.standing.iter().filter(|&&(other, aabb)| {
            let is_near = around.zip(aabb).is_some_and(|(around, aabb)| {
                aabb.fattened(self.reach_of(other)).overlaps(&around)
            });
            let is_other = other != slot && is_near && !self.is_ground(other);
            is_other && !self.touched(other, &[slot]).is_empty()
        });
        others.map(|&(other, _)| other).collect()
    }

    /// Whether a chain of contacts leads from a static body to one that stands for itself, if it is none.
    fn reaches(&mut self, slot: u32) -> bool {
        self.searched.clear();
        self.came_from.clear();
        self.searched.push(slot);
        self.came_from.push(0);
        let mut at = 0;
        while let Some(&from) = self.searched.get(at) {
            if self.is_known[from as usize] || self.is_ground(from) {
                self.note_chain(at);
                return true;
            }
            let near = self.near(from, self.reach_of(from));
            for other in self.touched(from, &near) {
                if !self.searched.contains(&other) {
                    self.searched.push(other);
                    self.came_from.push(at);
                }
            }
            at += 1;
        }
        false
    }

    /// Notes those through whom the last search came to this one. The others that it found may hold on to nothing themselves: who holds on
    /// to another one need not be held by that one.
    fn note_chain(&mut self, mut at: usize) {
        self.is_known[self.searched[at] as usize] = true;
        while at > 0 {
            at = self.came_from[at];
            self.is_known[self.searched[at] as usize] = true;
        }
    }

    /// The gap over which a body holds on, m.
    fn reach_of(&self, slot: u32) -> f32 {
        let touching = Anchors::touching();
        let anchors = self.bodies.anchors(slot).unwrap_or(&touching);
        let aabb = hulls_box(&self.bodies.info(slot).shape);
        aabb.map_or(0.0, |aabb| reach_of(anchors, &aabb))
    }

    /// Static bodies whose boxes come within `reach` (m) of that of a body.
    fn near(&self, slot: u32, reach: f32) -> Vec<u32> {
        let Some(around) = world_box(self.bodies, slot) else {
            return Vec::new();
        };
        let around = around.fattened(reach);
        let (half, center) = (0.5 * around.extents(), around.center());
        let is_near = |other: u32, aabb: &Option<Aabb>| match (aabb, &self.bodies.info(other).shape)
        {
            (Some(aabb), _) => aabb.overlaps(&around),
            (None, Shape::HalfSpace(half_space)) => {
                let pose = self.bodies.pose(other);
                let normal = rotate(pose.rotation, half_space.normal);
                let plane = Plane::through(pose.position, normal);
                plane.distance(center) <= plane.normal.abs().dot(half)
            }
            (None, _) => false,
        };
        let others = self.standing.iter();
        let near = others.filter(|(other, aabb)| *other != slot && is_near(*other, aabb));
        near.map(|&(other, _)| other).collect()
    }

    /// Those of `others` that a body holds on to where it touches them.
    fn touched(&self, slot: u32, others: &[u32]) -> Vec<u32> {
        let anchors = self.bodies.anchors(slot);
        if anchors.is_some_and(|anchors| !anchors.is_touching) {
            return Vec::new();
        }
        self.around(slot, others, self.reach_of(slot))
    }

    /// Those of `others` that a body touches over a gap of at most `reach` (m), and that were never part of the same one.
    fn around(&self, slot: u32, others: &[u32], reach: f32) -> Vec<u32> {
        let bodies = self.bodies;
        let hulls = hulls_of(&bodies.info(slot).shape);
        let pose = bodies.pose(slot);
        let origin = |slot: u32| origin_of(bodies, slot);
        let others = others.iter().copied().filter(|&other| {
            let is_sibling = origin(slot) == origin(other);
            let holds = |hull: &HullOf| {
                let seen = hull.seen_from(pose);
                holds(hull.0, &Standing::of(bodies, other, &seen), reach)
            };
            !is_sibling && hulls.iter().any(holds)
        });
        others.collect()
    }
}
