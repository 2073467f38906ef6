//! Who began to touch and who came apart, of those bodies that somebody wants to know it of.
//!
//! A pair touches when its contact bears something or its bodies overlap, and goes on to do so until a gap opens that is larger
//! than rounding and soft contacts make: no news of a crate that trembles. Of those that fall asleep it is asked whether they are near
//! enough to count as touching asleep, so that `Contacts::dormant_pairs` lists none that had not begun. While a body sleeps its
//! pairs are as they were.

use crate::bodies::solver_body::SolverBody;
use crate::bodies::store::Bodies;
use crate::collide::narrow_phase::NarrowPhase;
use crate::collide::sensors::{Overlap, Sensing};
use crate::contact::body_id::BodyId;
use crate::contact::manifolds::{ManifoldRef, Manifolds};
use crate::contact::pairs::broad_phase::Broadphase;
use crate::fracture::Fractures;
use crate::step::contact_news::{ContactChange, ContactEvent, ContactWatch};
use crate::step::contact_place::{approach_speed, center_of, smaller_extent};
use glam::Vec3;

/// Gap at which bodies that touched have come apart, as a share of the smaller one's least extent: half of the contact margin,
/// within which a gap is known.
const APART: f32 = 0.01;

/// A pair that touches.
#[derive(Clone, Copy, Debug)]
struct TouchingPair {
    name: [BodyId; 2],
    slots: [u32; 2],
    /// Of which of the two the start was told.
    told: [bool; 2],
    /// Which limits its force is over.
    over: [bool; 2],
}

/// Where a pair is found in this step.
#[derive(Clone, Copy, Debug)]
struct Found {
    name: [BodyId; 2],
    slots: [u32; 2],
    /// Index of a manifold, or of an overlap of a sensor.
    source: Source,
    /// N s.
    impulse: f32,
    /// Least gap, m.
    gap: f32,
    /// Whether it bears something, pulls of bonds included.
    is_loaded: bool,
    /// Whether it fell asleep in this step, and touches now that it rests.
    is_dormant: bool,
}

impl Found {
    /// Another contact of the same two bodies, in another direction or with another part: the one that bears most is told of.
    fn add(&mut self, other: &Self) {
        if other.impulse > self.impulse {
            self.source = other.source;
        }
        self.impulse += other.impulse;
        self.gap = self.gap.min(other.gap);
        self.is_loaded |= other.is_loaded;
    }
}

#[derive(Clone, Copy, Debug)]
enum Source {
    Manifold(u32),
    Overlap(u32),
}

/// What bodies are watched, which of their pairs touch, and the news of the last step.
#[derive(Clone, Debug, Default)]
pub struct ContactEvents {
    /// By slot; of another body than the present one it means nothing.
    watches: Vec<(BodyId, ContactWatch)>,
    watched: usize,
    /// Sorted by name.
    touching: Vec<TouchingPair>,
    next: Vec<TouchingPair>,
    found: Vec<Found>,
    /// By slot: velocities before contacts changed them.
    before: Vec<SolverBody>,
    news: Vec<ContactEvent>,
    pub(crate) sensing: Sensing,
}

impl ContactEvents {
    /// What happened in the last step, sorted by the ids of the bodies.
    pub fn news(&self) -> &[ContactEvent] {
        &self.news
    }

    /// Asks for news of the contacts of the body in `slot`, from the end of the next step on. It ends with the body.
    pub fn watch(&mut self, bodies: &Bodies, slot: u32, watch: ContactWatch) {
        let i = slot as usize;
        let none = (BodyId::default(), ContactWatch::default());
        if i >= self.watches.len() {
            self.watches.resize(i + 1, none);
        }
        self.watched -= usize::from(self.watches[i].1.is_any());
        self.watched += usize::from(watch.is_any());
        self.watches[i] = (bodies.id(slot), watch);
    }

    /// Whether it is asked who touches the body in `slot`, if that is still the one with this id.
    pub(crate) fn asks(&self, bodies: &Bodies, (slot, id): (u32, BodyId)) -> bool {
        bodies.is_current(slot, id) && self.watch_of(bodies, slot).touches
    }

    /// Whether there is anything to look at.
    pub(crate) fn is_on(&self) -> bool {
        let is_something_left =
            !(self.touching.is_empty() && self.news.is_empty() && self.sensing.overlaps.is_empty());
        self.watched > 0 || is_something_left
    }

    /// Keeps the velocities before the step's contacts change them.
    pub(crate) fn note_velocities(&mut self, bodies: &Bodies) {
        if self.watched > 0 {
            self.before.clear();
            self.before.extend_from_slice(&bodies.velocity);
        }
    }

    /// The same of pieces that were made within the step.
    pub(crate) fn note_pieces(&mut self, bodies: &Bodies, fractures: &Fractures) {
        if self.watched == 0 {
            return;
        }
        self.before.resize(bodies.slots(), SolverBody::default());
        for &slot in fractures.done.iter().flat_map(|fracture| &fracture.pieces) {
            self.before[slot as usize] = bodies.velocity[slot as usize];
        }
    }

    /// What is to be told of the body in `slot`.
    fn watch_of(&self, bodies: &Bodies, slot: u32) -> ContactWatch {
        match self.watches.get(slot as usize) {
            Some(&(id, watch)) if id == bodies.id(slot) => watch,
            _ => ContactWatch::default(),
        }
    }

    /// The same once the departed are forgotten, when the body need not be looked at.
    fn current_watch(&self, slot: u32) -> ContactWatch {
        let watch = self.watches.get(slot as usize);
        watch.map_or_else(ContactWatch::default, |&(_, watch)| watch)
    }

    /// Finds the news of a step of `step_dt` seconds, which is over but for the writing.
    pub(crate) fn update(
        &mut self,
        bodies: &Bodies,
        manifolds: &Manifolds,
        (broadphase, narrow): (&Broadphase, &NarrowPhase),
        step_dt: f32,
    ) {
        self.news.clear();
        self.forget_departed(bodies);
        self.sensing.find(bodies, broadphase);
        self.find_pairs(bodies, manifolds);
        if !bodies.sleep.slept.is_empty() {
            self.mark_dormant(bodies, narrow.dormant_pairs(broadphase.pairs(), bodies));
        }
        self.next.clear();
        let before = std::mem::take(&mut self.touching);
        let found = std::mem::take(&mut self.found);
        let mut old = before.iter().peekable();
        for found in &found {
            while let Some(gone) = old.next_if(|pair| pair.name < found.name) {
                self.keep_or_end(bodies, gone);
            }
            let known = old.next_if(|pair| pair.name == found.name);
            let is_near = || found.gap <= APART * smaller_extent(bodies, found.slots);
            let touches = found.is_loaded || found.gap <= 0.0 || found.is_dormant;
            if touches || known.is_some() && is_near() {
                self.touch(bodies, manifolds, found, known, step_dt);
            } else if let Some(known) = known {
                self.end(bodies, known);
            }
        }
        old.for_each(|gone| self.keep_or_end(bodies, gone));
        (self.touching, self.found) = (before, found);
        std::mem::swap(&mut self.touching, &mut self.next);
    }

    /// Takes the watches off that the bodies' departures left.
    fn forget_departed(&mut self, bodies: &Bodies) {
        for (slot, (id, watch)) in (0..).zip(&mut self.watches) {
            if watch.is_any() && !bodies.is_current(slot, *id) {
                *watch = ContactWatch::default();
                self.watched -= 1;
            }
        }
    }

    /// Lists the pairs of watched bodies that have a contact or an overlap, by name.
    fn find_pairs(&mut self, bodies: &Bodies, manifolds: &Manifolds) {
        self.found.clear();
        let mut found = std::mem::take(&mut self.found);
        let is_watched = |slots: [u32; 2]| slots.iter().any(|&s| self.current_watch(s).is_any());
        let mut overlaps = (0..).zip(&self.sensing.overlaps).peekable();
        let name = |slots: [u32; 2]| slots.map(|slot| bodies.id(slot));
        let overlapping = |(index, overlap): (u32, &Overlap)| {
            let slots = [overlap.pair.a, overlap.pair.b];
            is_watched(slots).then(|| Found {
                name: name(slots),
                slots,
                source: Source::Overlap(index),
                impulse: 0.0,
                gap: 0.0,
                is_loaded: false,
                is_dormant: false,
            })
        };
        for (index, head) in (0..).zip(manifolds.heads()) {
            let slots = [head.a, head.b];
            if !is_watched(slots) {
                continue;
            }
            let this = name(slots);
            let is_before =
                |(_, overlap): &(u32, &Overlap)| name([overlap.pair.a, overlap.pair.b]) < this;
            while let Some(overlap) = overlaps.next_if(is_before) {
                found.extend(overlapping(overlap));
            }
            let load = load_of(manifolds.at(index as usize), this, index);
            match found.last_mut().filter(|last| last.name == this) {
                Some(last) => last.add(&load),
                None => found.push(load),
            }
        }
        overlaps.for_each(|overlap| found.extend(overlapping(overlap)));
        self.found = found;
    }

    /// Marks which of the pairs that were found are dormant. Manifolds join no sleeping bodies but those that fell asleep just now, after
    /// they were made.
    fn mark_dormant(&mut self, bodies: &Bodies, dormant: impl Iterator<Item = [u32; 2]>) {
        for slots in dormant {
            let name = slots.map(|slot| bodies.id(slot));
            if let Ok(at) = self.found.binary_search_by(|found| found.name.cmp(&name)) {
                self.found[at].is_dormant = true;
            }
        }
    }

    /// A pair that was not found any more: it is as it was if one of its bodies slept and nobody looked.
    fn keep_or_end(&mut self, bodies: &Bodies, pair: &TouchingPair) {
        let [(a, a_id), (b, b_id)] = [0, 1].map(|side| (pair.slots[side], pair.name[side]));
        let slept = |slot: u32, id: BodyId| {
            bodies.is_asleep(slot) && bodies.sleep.slept.binary_search(&id).is_err()
        };
        let is_there = |slot: u32, id: BodyId| {
            bodies.is_current(slot, id) && (bodies.is_active(slot) || bodies.is_asleep(slot))
        };
        let is_contact = || !bodies.is_sensor(a) && !bodies.is_sensor(b);
        let is_kept = is_there(a, a_id)
            && is_there(b, b_id)
            && (slept(a, a_id) || slept(b, b_id))
            && is_contact();
        if is_kept {
            self.next.push(*pair);
        } else {
            self.end(bodies, pair);
        }
    }

    fn end(&mut self, bodies: &Bodies, pair: &TouchingPair) {
        let still_asked = |side: usize| {
            let (slot, id) = (pair.slots[side], pair.name[side]);
            // Of a body that is gone its end is told still.
            !bodies.is_current(slot, id) || self.watch_of(bodies, slot).touches
        };
        let of = [0, 1].map(|side| pair.told[side] && still_asked(side));
        if of != [false; 2] {
            self.news.push(ContactEvent {
                change: ContactChange::End,
                bodies: [0, 1].map(|side| (pair.slots[side], pair.name[side])),
                of,
                point: Vec3::ZERO,
                normal: Vec3::ZERO,
                impulse: 0.0,
                approach_speed: 0.0,
            });
        }
    }

    /// A pair that touches: tells whom it is news to.
    fn touch(
        &mut self,
        bodies: &Bodies,
        manifolds: &Manifolds,
        found: &Found,
        known: Option<&TouchingPair>,
        step_dt: f32,
    ) {
        let watches = found.slots.map(|slot| self.current_watch(slot));
        let (told, over) = known.map_or(([false; 2], [false; 2]), |pair| (pair.told, pair.over));
        let force = found.impulse / step_dt;
        let is_over = watches.map(|watch| force > watch.force);
        let wants = watches.map(|watch| watch.touches);
        let starts = [0, 1].map(|side| wants[side] && !told[side]);
        self.next.push(TouchingPair {
            name: found.name,
            slots: found.slots,
            told: wants,
            over: is_over,
        });
        if starts == [false; 2] && is_over == [false; 2] {
            return;
        }
        let event = self.describe(bodies, manifolds, found);
        if starts != [false; 2] {
            self.news.push(ContactEvent {
                of: starts,
                ..event
            });
        }
        if is_over != [false; 2] {
            let is_crossing = [0, 1].map(|side| is_over[side] && !over[side]);
            self.news.push(ContactEvent {
                change: ContactChange::Force { is_crossing },
                of: is_over,
                ..event
            });
        }
    }

    /// The start of a pair's contact as it is in this step.
    fn describe(&self, bodies: &Bodies, manifolds: &Manifolds, found: &Found) -> ContactEvent {
        let (point, normal, approach_speed) = match found.source {
            Source::Manifold(index) => {
                let manifold = manifolds.at(index as usize);
                let speed = approach_speed(&self.before, manifold);
                (center_of(bodies, manifold), manifold.normal, speed)
            }
            Source::Overlap(index) => {
                let overlap = &self.sensing.overlaps[index as usize];
                let [a, b] = found.slots.map(|slot| bodies.velocity(slot).0);
                (
                    overlap.point,
                    overlap.normal,
                    overlap.normal.dot(a - b).max(0.0),
                )
            }
        };
        ContactEvent {
            change: ContactChange::Start,
            bodies: [0, 1].map(|side| (found.slots[side], found.name[side])),
            of: [false; 2],
            point,
            normal,
            impulse: found.impulse,
            approach_speed,
        }
    }
}

fn load_of(manifold: ManifoldRef, name: [BodyId; 2], index: u32) -> Found {
    let mut found = Found {
        name,
        slots: [manifold.a, manifold.b],
        source: Source::Manifold(index),
        impulse: 0.0,
        gap: f32::INFINITY,
        is_loaded: false,
        is_dormant: false,
    };
    for point in manifold.points() {
        found.impulse += point.total_impulse;
        found.gap = found.gap.min(point.separation);
        found.is_loaded |= point.total_impulse != 0.0;
    }
    found
}
