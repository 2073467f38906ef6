//! From bodies to manifolds: feeds the contact layer with the bodies' boxes, shapes and materials.
//!
//! Pairs are independent, so they are split into parts for a team of threads, if there is one. The split
//! depends on the number of pairs only, and the parts are joined in order: any number of threads gives the same bits.

use crate::contact::BodyId;
use crate::contact::broadphase::{Broadphase, Pair, Proxy, ProxyKind, ProxyShape};
use crate::contact::half_space::examine_half_space;
use crate::contact::manifold::{BodyPlace, BoundPatch, Patch};
use crate::contact::manifolds::{ManifoldHead, Manifolds, Writer};
use crate::contact::pair::{
    Pace, PairBody, PairState, PairTerm, PairView, Verdict, reach_of_test, smaller_extent,
};
use crate::contact::sat::{Found, Hint, NarrowScratch, distance_along, examine_hulls};
use crate::geometry::ConvexHull;
use crate::geometry::lanes::bounds;
use crate::math::{Aabb, Plane, Pose, rotate};
use crate::parts::{WORTH_HELP, run_parts};
use crate::prefetch::prefetch;
use crate::solver::bodies::{Bodies, RigidBody, Shape};
use crate::team::Team;
use glam::{Mat3, Quat, Vec3};
use std::ops::Range;

/// How far ahead contacts are found besides the bodies' motion, as a share of the body's least extent: far enough that a
/// body at rest keeps its contacts while it settles.
const CONTACT_MARGIN: f32 = 0.02;

/// How far the boxes kept by the broad phase reach beyond the bodies, m (it limits this for small bodies itself).
const BOX_MARGIN: f32 = 0.1;

/// For how many steps, this one included, the broad phase is told at once where a body goes that keeps its velocity.
const STEPS_TOLD: f32 = 3.0;

/// How much longer than it must be a box may be that is kept for what was fast, m.
const SPARE: f32 = 0.2 * BOX_MARGIN;

/// Pairs of a part, some 10 us of work while all are at rest, 50 us while they land.
const PAIRS_PER_PART: usize = 128;

/// Most parts, so that few buffers serve any number of pairs.
const MAX_PARTS: usize = 32;

/// Bodies from which it pays to have helpers look at them: each takes some 20 ns.
const WORTH_HELP_WITH_BODIES: usize = 1024;

/// Least bodies of a part.
const LEAST_BODIES: usize = 256;

/// How many touching pairs ahead their states and bodies are asked for.
const AHEAD: usize = 8;

/// How far ahead in time the step looks, so that contacts exist before bodies overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lookahead {
    h: f32,
    /// How far gravity moves a body in one step, m.
    fall: f32,
}

impl Lookahead {
    /// Looks ahead over a step of `h` seconds under `gravity` (m/s2).
    pub fn new(h: f32, gravity: Vec3) -> Self {
        Self {
            h,
            fall: h * h * gravity.length(),
        }
    }

    /// How far a point of the body in `slot` may turn about the centre of mass within the step, m.
    fn turn(&self, bodies: &Bodies, slot: u32) -> f32 {
        self.h * bodies.velocity[slot as usize].angular.length() * bodies.radius(slot)
    }

    /// How far the body in `slot` goes within the step, m.
    fn travel(&self, bodies: &Bodies, slot: u32) -> Vec3 {
        self.h * bodies.velocity[slot as usize].linear
    }

    /// How far ahead of a body its contacts are looked for in all directions, m.
    fn reach(&self, bodies: &Bodies, slot: u32) -> f32 {
        margin_at_rest(bodies, slot) + self.fall + self.turn(bodies, slot)
    }

    /// The body's box with all places it may reach within the step, and in [`STEPS_TOLD`] of them if it goes on as it does.
    fn swept_box(&self, bodies: &Bodies, slot: u32, hull: &ConvexHull) -> Aabb {
        let i = slot as usize;
        let turn = Mat3::from_quat(bodies.rotation[i]);
        // From the centre of mass, so that little is lost far from the origin.
        let shift = bodies.centre[i] - turn * bodies.mass[i].centre;
        let tight = bounds(&hull.lanes.points, &turn, shift).fattened(self.reach(bodies, slot));
        let travel = STEPS_TOLD * self.travel(bodies, slot);
        Aabb {
            min: tight.min + travel.min(Vec3::ZERO),
            max: tight.max + travel.max(Vec3::ZERO),
        }
    }
}

/// When the broad phase was last told where a body is, and for how long that will do.
#[derive(Clone, Copy, Debug)]
struct Told {
    id: BodyId,
    version: u32,
    centre: Vec3,
    rotation: Quat,
    /// [`Lookahead::reach`] and [`Lookahead::travel`] then, m.
    reach: f32,
    travel: Vec3,
    /// How far the body may leave its way, or reach farther, until the broad phase must be told again, m.
    room: f32,
}

impl Told {
    /// Tells the broad phase where the body in `slot` is now.
    fn now(broadphase: &mut Broadphase, bodies: &Bodies, slot: u32, ahead: Lookahead) -> Self {
        let i = slot as usize;
        Self {
            id: bodies.ids[i],
            version: bodies.version[i],
            centre: bodies.centre[i],
            rotation: bodies.rotation[i],
            reach: ahead.reach(bodies, slot),
            travel: ahead.travel(bodies, slot),
            room: broadphase.set(i, Some(proxy(bodies, slot, ahead)), BOX_MARGIN),
        }
    }

    /// Whether the broad phase need not be told where the body in `slot` is now.
    fn will_do(&self, bodies: &Bodies, slot: u32, ahead: Lookahead) -> bool {
        let i = slot as usize;
        let turn = (bodies.rotation[i] - self.rotation).length();
        let (reach, travel) = (ahead.reach(bodies, slot), ahead.travel(bodies, slot));
        let room = self.room - 2.0 * turn * bodies.radius(slot) - (reach - self.reach).max(0.0);
        self.id == bodies.ids[i]
            && self.version == bodies.version[i]
            && self.is_on_its_way(bodies.centre[i], travel, room)
            // A body that was fast and has become slow gets a smaller box.
            && span(self.reach, self.travel) <= span(reach, travel) + reach + SPARE
    }

    /// Whether a centre of mass that goes on by `travel` (m) in this step is nearer than `room` (m), at either end of it, to
    /// where one is that kept its velocity.
    fn is_on_its_way(&self, centre: Vec3, travel: Vec3, room: f32) -> bool {
        let (moved, faster) = (centre - self.centre, travel - self.travel);
        let is_near =
            |off: Vec3| off.length_squared().max((off + faster).length_squared()) < room * room;
        // Most bodies of a large scene are where they were. Of one that stood there is no way to be on: not a number.
        let steps = || moved.dot(self.travel) / self.travel.length_squared();
        let on_its_way = || steps().clamp(0.0, STEPS_TOLD - 1.0) * self.travel;
        room > 0.0 && (is_near(moved) || is_near(moved - on_its_way()))
    }
}

/// How far a body gets with the given [`Lookahead::reach`] and [`Lookahead::travel`] in all steps that are told, m.
fn span(reach: f32, travel: Vec3) -> f32 {
    reach + STEPS_TOLD * travel.length()
}

/// What is known of the pairs from step to step, and buffers.
#[derive(Debug, Default)]
#[allow(
    clippy::vec_box,
    reason = "states change their order, and are copied less often in boxes"
)]
pub struct NarrowPhase {
    /// What the broad phase was told of each slot.
    told: Vec<Option<Told>>,
    /// Bodies by slot.
    bodies: Vec<PairBody>,
    paces: Vec<Pace>,
    /// Pairs by name, and what is known of them: the larger part in boxes, so that the order changes without copies.
    names: Vec<(BodyId, BodyId)>,
    terms: Vec<PairTerm>,
    states: Vec<Box<PairState>>,
    /// Of the pair list that they follow.
    revision: Option<u64>,
    new_names: Vec<(BodyId, BodyId)>,
    new_terms: Vec<PairTerm>,
    new_states: Vec<Box<PairState>>,
    /// States of pairs that are gone.
    spare: Vec<Box<PairState>>,
    parts: Vec<Part>,
}

#[derive(Debug, Default)]
struct Part {
    /// Slots of bodies that the broad phase is to be told of.
    outdated: Vec<u32>,
    scratch: NarrowScratch,
    /// Indices of its pairs that touch, within the part.
    touching: Vec<u32>,
    /// Where the points of these go: from 0 on until those of the parts before are counted.
    points: Range<u32>,
}

/// Whether the contacts of `pairs` pairs are worth a team.
pub(crate) fn is_worth_help(pairs: usize) -> bool {
    pairs >= WORTH_HELP * PAIRS_PER_PART
}

/// Brings the pairs of `broadphase` up to date with the bodies.
pub fn update_pairs(
    broadphase: &mut Broadphase,
    narrow: &mut NarrowPhase,
    bodies: &Bodies,
    ahead: Lookahead,
) {
    // If all bodies were replaced, there may be fewer slots than the broad phase knows.
    for slot in bodies.slots()..narrow.told.len() {
        broadphase.set(slot, None, BOX_MARGIN);
    }
    narrow.told.resize(bodies.slots(), None);
    // Helpers that come now need not be waited for when the pairs are known.
    Team::lead_if(bodies.slots() >= WORTH_HELP_WITH_BODIES, |team| {
        narrow.find_outdated(bodies, ahead, team);
        narrow.tell(broadphase, bodies, ahead);
        broadphase.find_pairs();
    });
}

fn proxy(bodies: &Bodies, slot: u32, ahead: Lookahead) -> Proxy {
    let info = bodies.info(slot);
    let kind = if info.kind == RigidBody::Dynamic {
        ProxyKind::Moving
    } else {
        ProxyKind::Fixed
    };
    let shape = match &info.shape {
        Shape::Convex(mesh) => ProxyShape::Box(ahead.swept_box(bodies, slot, mesh.hull())),
        Shape::HalfSpace(_) => ProxyShape::HalfSpace(half_space_plane(bodies, slot)),
    };
    Proxy {
        id: bodies.id(slot),
        kind,
        layers: info.layers,
        shape,
    }
}

fn margin_at_rest(bodies: &Bodies, slot: u32) -> f32 {
    CONTACT_MARGIN * bodies.least_extent[slot as usize]
}

/// Surface of the half-space in `slot`, world frame.
fn half_space_plane(bodies: &Bodies, slot: u32) -> Plane {
    let Shape::HalfSpace(half_space) = &bodies.info(slot).shape else {
        unreachable!("asked for half-spaces only")
    };
    let pose = bodies.pose(slot);
    Plane::through(pose.position, rotate(pose.rotation, half_space.normal))
}

impl NarrowPhase {
    /// Finds the bodies that the broad phase is to be told of.
    fn find_outdated(&mut self, bodies: &Bodies, ahead: Lookahead, team: Option<&Team>) {
        let size = Team::part_size(team, self.told.len(), LEAST_BODIES);
        let count = self.told.len().div_ceil(size);
        self.parts
            .resize_with(self.parts.len().max(count), Part::default);
        let parts = self.told.chunks(size).zip(&mut self.parts);
        run_parts(team, parts.enumerate(), |(index, (told, part))| {
            let slots = (index * size) as u32..;
            for (slot, told) in slots.zip(told) {
                if bodies.is_asleep(slot) {
                    continue;
                }
                let is_active = bodies.is_active(slot);
                let will_do = match told {
                    Some(told) => is_active && told.will_do(bodies, slot, ahead),
                    None => !is_active,
                };
                if !will_do {
                    part.outdated.push(slot);
                }
            }
        });
    }

    /// Tells the broad phase of them.
    fn tell(&mut self, broadphase: &mut Broadphase, bodies: &Bodies, ahead: Lookahead) {
        for slot in self.parts.iter_mut().flat_map(|p| p.outdated.drain(..)) {
            let told = &mut self.told[slot as usize];
            if bodies.is_active(slot) {
                *told = Some(Told::now(broadphase, bodies, slot, ahead));
            } else {
                *told = None;
                broadphase.set(slot as usize, None, BOX_MARGIN);
            }
        }
    }

    /// Fills `manifolds` with the contacts of all pairs, in their order. Impulses are zero.
    pub fn collide(
        &mut self,
        bodies: &Bodies,
        broadphase: &Broadphase,
        ahead: Lookahead,
        manifolds: &mut Manifolds,
        team: Option<&Team>,
    ) {
        self.carry_states(bodies, broadphase);
        self.load_bodies(bodies, ahead, team);
        let pairs = broadphase.pairs();
        let part_count = pairs.len().div_ceil(PAIRS_PER_PART).clamp(1, MAX_PARTS);
        let part_size = pairs.len().div_ceil(part_count).max(1);
        self.parts
            .resize_with(self.parts.len().max(part_count), Part::default);
        let scene = &Scene {
            bodies,
            seen: &self.bodies,
            paces: &self.paces,
            fall: ahead.fall,
        };
        let parts = self.parts.iter_mut().zip(pairs.chunks(part_size));
        let known = self.terms.chunks_mut(part_size);
        let known = known.zip(self.states.chunks_mut(part_size));
        run_parts(
            team,
            parts.zip(known),
            |((part, pairs), (terms, states))| part.test(scene, pairs, terms, states),
        );
        let parts = &mut self.parts[..pairs.len().div_ceil(part_size)];
        let mut first = 0;
        for part in parts.iter_mut() {
            part.points = first..first + part.points.end;
            first = part.points.end;
        }
        let sizes = parts
            .iter()
            .map(|part| (part.touching.len(), part.points.clone()));
        let writers = manifolds.writers(sizes);
        let pairs = pairs.chunks(part_size).zip(self.states.chunks(part_size));
        let parts = parts.iter().zip(pairs);
        run_parts(
            team,
            writers.zip(parts),
            |(writer, (part, (pairs, states)))| {
                write_manifolds(scene, pairs, states, &part.touching, writer)
            },
        );
    }

    /// Brings `states` into the order of the pairs; new pairs get a blank one.
    fn carry_states(&mut self, bodies: &Bodies, broadphase: &Broadphase) {
        if self.revision == Some(broadphase.revision()) {
            return;
        }
        self.revision = Some(broadphase.revision());
        let pairs = broadphase.pairs();
        self.new_names.clear();
        self.new_names
            .extend(pairs.iter().map(|p| (bodies.id(p.a), bodies.id(p.b))));
        self.new_terms.clear();
        let known = self.terms.iter().zip(self.states.drain(..));
        let mut old = self.names.iter().zip(known).peekable();
        for name in &self.new_names {
            while let Some((_, (_, state))) = old.next_if(|(old, _)| *old < name) {
                self.spare.push(state);
            }
            let (term, state) = match old.next_if(|(old, _)| *old == name) {
                Some((_, (term, state))) => (*term, state),
                None => (PairTerm::default(), self.spare.pop().unwrap_or_default()),
            };
            self.new_terms.push(term);
            self.new_states.push(state);
        }
        self.spare.extend(old.map(|(_, (_, state))| state));
        std::mem::swap(&mut self.names, &mut self.new_names);
        std::mem::swap(&mut self.terms, &mut self.new_terms);
        std::mem::swap(&mut self.states, &mut self.new_states);
    }

    /// Collects what pairs read of the bodies.
    fn load_bodies(&mut self, bodies: &Bodies, ahead: Lookahead, team: Option<&Team>) {
        self.bodies.resize(bodies.slots(), PairBody::default());
        self.paces.resize(bodies.slots(), Pace::default());
        let size = Team::part_size(team, bodies.slots(), LEAST_BODIES);
        let parts = self.bodies.chunks_mut(size);
        let parts = parts.zip(self.paces.chunks_mut(size)).enumerate();
        run_parts(team, parts, |(index, (seen, paces))| {
            let slots = ((index * size) as u32..).zip(seen.iter_mut().zip(paces));
            // What sleeps has not moved.
            for (slot, (body, pace)) in slots.filter(|&(slot, _)| !bodies.is_asleep(slot)) {
                let now = pair_body(bodies, slot, ahead);
                let motion = now.motion_since(body);
                pace.walk(motion);
                pace.ahead = now.travel.length() + now.turning;
                pace.least_extent = bodies.least_extent[slot as usize];
                pace.version = bodies.version[slot as usize];
                *body = now;
            }
        });
    }
}

fn pair_body(bodies: &Bodies, slot: u32, ahead: Lookahead) -> PairBody {
    let i = slot as usize;
    let is_half_space = bodies.least_extent[i] == f32::INFINITY;
    PairBody {
        place: BodyPlace {
            centre: bodies.centre[i],
            turn: Mat3::from_quat(bodies.rotation[i]),
        },
        rotation: bodies.rotation[i],
        radius: if is_half_space {
            f32::INFINITY
        } else {
            bodies.radius(slot)
        },
        travel: ahead.travel(bodies, slot),
        turning: ahead.turn(bodies, slot),
    }
}

/// What all parts read.
struct Scene<'s> {
    bodies: &'s Bodies,
    seen: &'s [PairBody],
    paces: &'s [Pace],
    fall: f32,
}

impl Scene<'_> {
    fn pair(&self, pair: Pair) -> [&PairBody; 2] {
        [&self.seen[pair.a as usize], &self.seen[pair.b as usize]]
    }

    fn paces(&self, pair: Pair) -> [&Pace; 2] {
        [&self.paces[pair.a as usize], &self.paces[pair.b as usize]]
    }

    /// Bodies farther apart than this, m, cannot touch within the step, if they approach by no more than `approach`.
    fn margin(&self, paces: [&Pace; 2], approach: f32) -> f32 {
        CONTACT_MARGIN * smaller_extent(paces) + self.fall + approach
    }
}

impl Part {
    /// Tests the pairs that must be, and counts those that touch.
    fn test(
        &mut self,
        scene: &Scene,
        pairs: &[Pair],
        terms: &mut [PairTerm],
        states: &mut [Box<PairState>],
    ) {
        self.touching.clear();
        self.points = 0..0;
        for (index, ((&pair, term), state)) in (0..).zip(pairs.iter().zip(terms).zip(states)) {
            if !scene.bodies.needs_look(pair) {
                continue;
            }
            let paces = scene.paces(pair);
            let margin = scene.margin(paces, paces[0].ahead + paces[1].ahead);
            if !term.surely_holds(paces, margin) {
                let bodies = scene.pair(pair);
                let view = PairView {
                    bodies,
                    paces,
                    term,
                    state,
                };
                self.renew(scene, pair, view);
            }
            if term.points > 0 {
                self.touching.push(index);
                self.points.end += term.points;
            }
        }
    }

    /// Looks closer at a pair, and tests it if that does not help.
    fn renew(&mut self, scene: &Scene, pair: Pair, mut view: PairView) {
        let bodies = scene.bodies;
        let [a, b] = view.bodies;
        let approach = (b.travel - a.travel).length() + a.turning + b.turning;
        let margin = scene.margin(view.paces, approach);
        let Verdict::Unknown(axis) = view.verdict(margin) else {
            return;
        };
        let reach = reach_of_test(view.paces, margin);
        let b_in_a = relative_pose(bodies, pair.a, pair.b);
        if let Some(axis) = axis
            && let Some(distance) = distance_of(bodies, pair, &b_in_a, axis)
            && distance > reach
        {
            view.set_apart(axis, distance);
            return;
        }
        let slots = [pair.a as usize, pair.b as usize];
        let centres = slots.map(|i| bodies.mass[i].centre);
        let hint = view.hint(&b_in_a, centres);
        match examine_pair(bodies, pair, b_in_a, reach, hint, &mut self.scratch) {
            Found::Apart { axis, distance } => view.set_apart(axis, distance),
            Found::Near(patch) => {
                let boxes = slots.map(|i| bodies.kd_box[i]);
                let patch = BoundPatch::new(&patch, b_in_a.rotation, centres, boxes);
                view.set_near(patch, reach);
                view.state.faces = self.scratch.best_faces;
                let [a, b] = [pair.a, pair.b].map(|slot| bodies.info(slot));
                view.state.friction = a.friction.combined(&b.friction);
                view.state.restitution = a.restitution.combined(&b.restitution);
            }
        }
    }
}

/// Writes the manifolds of the pairs that touch.
fn write_manifolds(
    scene: &Scene,
    pairs: &[Pair],
    states: &[Box<PairState>],
    touching: &[u32],
    mut writer: Writer<'_>,
) {
    for (k, &at) in touching.iter().enumerate() {
        if let Some(&next) = touching.get(k + AHEAD) {
            prefetch(&states[next as usize].patch);
            for body in scene.pair(pairs[next as usize]) {
                prefetch(&body.place);
            }
        }
        let (pair, state) = (&pairs[at as usize], &states[at as usize]);
        let Some((head, points)) = writer.next(state.patch.count) else {
            return;
        };
        let [a, b] = scene.pair(*pair);
        *head = ManifoldHead {
            a: pair.a,
            b: pair.b,
            normal: state.patch.write(&a.place, &b.place, points),
            friction: state.friction,
            restitution: state.restitution,
            count: state.patch.count,
        };
    }
}

/// Distance of two hulls along a unit vector from A to B (A's frame), m; `None` if one is a half-space, which is tested
/// as fast.
fn distance_of(bodies: &Bodies, pair: Pair, b_in_a: &Pose, axis: Vec3) -> Option<f32> {
    let [a, b] = [pair.a, pair.b].map(|slot| bodies.convex(slot));
    Some(distance_along(a?.hull(), b?.hull(), b_in_a, axis))
}

/// Contact of one pair in A's frame, normal from A to B.
fn examine_pair(
    bodies: &Bodies,
    pair: Pair,
    b_in_a: Pose,
    reach: f32,
    hint: Hint,
    scratch: &mut NarrowScratch,
) -> Found {
    match (&bodies.info(pair.a).shape, &bodies.info(pair.b).shape) {
        (Shape::Convex(a), Shape::Convex(b)) => {
            examine_hulls(a.hull(), b.hull(), b_in_a, reach, hint, scratch)
        }
        (Shape::Convex(a), Shape::HalfSpace(b)) => {
            let plane = Plane::through(b_in_a.position, rotate(b_in_a.rotation, b.normal));
            examine_half_space(a.hull(), plane, b_in_a, reach, scratch)
        }
        (Shape::HalfSpace(a), Shape::Convex(b)) => {
            let a_in_b = relative_pose(bodies, pair.b, pair.a);
            let plane = Plane::through(a_in_b.position, rotate(a_in_b.rotation, a.normal));
            match examine_half_space(b.hull(), plane, a_in_b, reach, scratch) {
                Found::Near(patch) => Found::Near(patch.swapped(&a_in_b)),
                Found::Apart { distance, .. } => Found::Apart {
                    axis: a.normal,
                    distance,
                },
            }
        }
        (Shape::HalfSpace(_), Shape::HalfSpace(_)) => Found::Near(Patch::default()),
    }
}

/// `a_from_b`, from the difference of the centres of mass, which is exact far from the origin too.
pub(crate) fn relative_pose(bodies: &Bodies, a: u32, b: u32) -> Pose {
    let (i, j) = (a as usize, b as usize);
    let a_from_world = bodies.rotation[i].inverse();
    let rotation = a_from_world * bodies.rotation[j];
    let centres = rotate(a_from_world, bodies.centre[j] - bodies.centre[i]);
    Pose::new(
        centres + bodies.mass[i].centre - rotate(rotation, bodies.mass[j].centre),
        rotation,
    )
}
