//! Who is where in a batch: numbers of bodies, places of manifolds, cuts into domains.
//!
//! All of it follows from the islands and the cuts alone, so it is kept as long as these are the same; what bodies and
//! manifolds hold is loaded into it in every step.

use super::Method;
use super::arrangement::{Arrangement, Joint, Rule};
use super::blocks::{Block, Place, Point};
use super::bodies::{Bodies, SolverBody};
use super::demand::SubstepSettings;
use super::domains::{self, Domains};
use super::islands::{Island, Islands};
use super::schedule::ContactOrder;
use crate::team::Team;
use std::ops::Range;

/// An island of a batch.
#[derive(Clone, Debug, Default)]
pub struct Member {
    /// Its bodies within the batch.
    pub bodies: Range<usize>,
    /// Its manifolds within [`Layout::places`].
    pub places: Range<usize>,
    /// Number of its points.
    pub contacts: usize,
}

/// What a layout follows from, besides the cuts.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Origin {
    /// See [`Islands::revision`].
    islands: u64,
    range: Range<usize>,
    order: ContactOrder,
    method: Method,
    has_team: bool,
}

/// Who is where in a batch.
#[derive(Debug, Default)]
pub struct Layout {
    /// Its islands.
    pub members: Vec<Member>,
    /// Slots of its bodies, by number.
    pub slots: Vec<u32>,
    /// Numbers of the two bodies of each of its manifolds.
    pub(super) pairs: Vec<[u32; 2]>,
    /// Its manifolds in the order of the islands: index and place.
    pub places: Vec<(u32, Place)>,
    /// Blocks of its [`domains`], in their order.
    pub domains: Vec<Range<usize>>,
    /// Of bodies that are copies, behind all others: which ones they copy.
    pub(super) originals: Vec<u32>,
    pub(super) cuts: Domains,
    arrangement: Arrangement,
    origin: Option<Origin>,
    /// By body: the number of its copy.
    copies: Vec<Option<u32>>,
}

impl Layout {
    /// Numbers the bodies of the islands in `range`, unless the layout is theirs already; tells whether it is. If not, the
    /// manifolds are still to be [placed](Self::place) and [named](Self::name). With a `team`, domains have their own copies of
    /// fixed bodies.
    pub(super) fn number(
        &mut self,
        islands: &Islands,
        range: Range<usize>,
        bodies: &Bodies,
        settings: &SubstepSettings,
        team: Option<&Team>,
    ) -> bool {
        let config = &settings.config;
        let origin = Some(Origin {
            islands: islands.revision,
            range: range.clone(),
            order: config.order,
            method: config.method,
            has_team: team.is_some(),
        });
        let is_cut_as_before = match &islands.list[range.clone()] {
            [island] => self.cut(island, islands, bodies, settings, team),
            _ => self.cuts.keep_whole(),
        };
        let is_kept = is_cut_as_before && self.origin == origin;
        if !is_kept {
            self.number_islands(islands, range);
            self.origin = origin;
        }
        is_kept
    }

    /// Cuts a large island into domains; whether that gave the same ones as before.
    fn cut(
        &mut self,
        island: &Island,
        islands: &Islands,
        bodies: &Bodies,
        settings: &SubstepSettings,
        team: Option<&Team>,
    ) -> bool {
        let leaves = domains::leaves(island.manifolds.len());
        if leaves == 1 || settings.config.method == Method::Exact {
            return self.cuts.keep_whole();
        }
        let slots = &islands.slots[island.bodies.clone()];
        let centre = |number: usize| {
            let slot = slots[number] as usize;
            let is_movable = bodies.velocity[slot].inverse_mass > 0.0;
            is_movable.then(|| bodies.centre[slot])
        };
        self.cuts
            .cut(slots.len(), centre, settings.gravity, leaves, team)
    }

    fn number_islands(&mut self, islands: &Islands, range: Range<usize>) {
        self.members.clear();
        self.slots.clear();
        self.pairs.clear();
        let first = islands.list[range.start].manifolds.start;
        for island in &islands.list[range] {
            let offset = self.slots.len() as u32;
            self.slots
                .extend_from_slice(&islands.slots[island.bodies.clone()]);
            let pairs = islands.pairs[island.manifolds.clone()].iter();
            self.pairs
                .extend(pairs.map(|pair| pair.map(|number| number + offset)));
            let Range { start, end } = island.manifolds;
            self.members.push(Member {
                bodies: offset as usize..self.slots.len(),
                places: start - first..end - first,
                contacts: island.points.len(),
            });
        }
        self.cuts.sort(&mut self.slots, &mut self.pairs);
    }

    /// Gives each manifold of the islands in `range` a lane. `bodies`: by number, of which the last is idle, for the lanes that
    /// are not used.
    pub(super) fn place(
        &mut self,
        islands: &Islands,
        range: Range<usize>,
        bodies: &[SolverBody],
        order: ContactOrder,
        team: Option<&Team>,
    ) {
        let rule = Rule {
            order,
            bodies: bodies.len(),
            domains: self.cuts.count(),
        };
        let of_batch = islands.list[range]
            .iter()
            .flat_map(|island| island.manifolds.clone());
        let cuts = &self.cuts;
        let joints = self.pairs.iter().zip(of_batch.clone()).map(|(pair, at)| {
            let is_movable = |body: u32| bodies[body as usize].inverse_mass > 0.0;
            let bodies = pair.map(|body| is_movable(body).then_some(body));
            Joint {
                bodies,
                points: islands.counts[at],
                domain: cuts.of(bodies),
            }
        });
        self.arrangement.arrange(joints, rule, team);
        let names = of_batch.map(|at| islands.manifolds[at]);
        let places = self.arrangement.places().iter().copied();
        self.places.clear();
        self.places.extend(names.zip(places));
        self.domains.clear();
        self.domains.extend(self.arrangement.domains());
    }

    /// Makes the blocks: names the bodies and manifolds of their lanes. What else they hold from another step is overwritten
    /// when they are filled.
    pub(super) fn name(
        &mut self,
        bodies: &[SolverBody],
        blocks: &mut Vec<Block>,
        points: &mut Vec<Point>,
        team: Option<&Team>,
    ) {
        let idle = self.slots.len() as u32;
        let counts = self.arrangement.points_of_blocks();
        blocks.resize_with(counts.len(), Block::default);
        let mut end = 0;
        for (block, count) in blocks.iter_mut().zip(counts) {
            block.clear(idle, end..end + count);
            end += count;
        }
        points.resize(end, Point::default());
        for (pair, &(index, place)) in self.pairs.iter().zip(&self.places) {
            let block = &mut blocks[place.block as usize];
            block.put(place.lane as usize, index, *pair);
        }
        self.originals.clear();
        if team.is_some() {
            self.name_copies(bodies, blocks);
        }
    }

    /// Gives each domain its own copies of the fixed bodies and of the idle one, so that domains of a stage, which different
    /// threads solve, write to different bodies.
    fn name_copies(&mut self, bodies: &[SolverBody], blocks: &mut [Block]) {
        for domain in &self.domains[1..] {
            self.copies.clear();
            self.copies.resize(bodies.len(), None);
            for block in &mut blocks[domain.clone()] {
                for number in block.bodies.as_flattened_mut() {
                    if bodies[*number as usize].inverse_mass > 0.0 {
                        continue;
                    }
                    let original = *number;
                    *number = *self.copies[original as usize].get_or_insert_with(|| {
                        self.originals.push(original);
                        (bodies.len() + self.originals.len()) as u32 - 1
                    });
                }
            }
        }
    }

    /// The body itself, or the one that it is a copy of.
    pub(super) fn original(&self, body: u32) -> u32 {
        // The idle body comes between bodies and copies.
        let first_copy = self.slots.len() + 1;
        let copy = (body as usize).checked_sub(first_copy);
        copy.map_or(body, |copy| self.originals[copy])
    }
}
