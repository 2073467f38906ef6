//! Who is where in a batch: numbers of bodies, places of manifolds, cuts into subdomains.
//!
//! All of it follows from the islands and the cuts alone, so it is kept as long as these are the same; what bodies and
//! manifolds hold is loaded into it in every step.

use crate::bodies::solver_body::SolverBody;
use crate::bodies::store::Bodies;
use crate::solver::graph::contact_order::ContactOrder;
use crate::solver::graph::indices::{BodyNumber, LaneSlot, ManifoldIndex};
use crate::solver::graph::islands::{Island, Islands, JointedPair};
use crate::solver::graph::lane_assignment::{AssignmentRule, ContactEdge, LaneAssignment};
use crate::solver::graph::partition;
use crate::solver::graph::partition::Partition;
use crate::solver::settings::{MethodKind, SubstepSettings};
use crate::solver::wide::block::{Block, Point};
use crate::threads::parts::front_mut;
use crate::threads::team::Team;
use std::ops::Range;

/// An island of a batch.
#[derive(Clone, Debug, Default)]
pub struct Member {
    /// Its index in the list of the step.
    pub(crate) island: u32,
    /// Its bodies within the batch.
    pub bodies: Range<usize>,
    /// Its manifolds within [`Layout::places`].
    pub places: Range<usize>,
    /// Number of its points.
    pub contacts: usize,
    /// Its joints within [`Layout::joints`].
    pub joints: Range<usize>,
}

/// An island in the batch that has solved it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct SolvedMember {
    /// Its index in the list of the round.
    pub(crate) island: u32,
    pub(crate) batch: u32,
    /// Its number in the batch.
    pub(crate) member: u32,
}

/// Islands that are solved together.
#[derive(Clone, Copy, Debug)]
pub struct Group<'a> {
    /// Their indices in the list of a step.
    pub islands: &'a [u32],
    /// Whether all contacts of each share a body, and it is solved as if it were alone.
    pub is_lone: bool,
}

impl<'a> Group<'a> {
    /// Islands that are solved as one.
    pub fn one(islands: &'a [u32]) -> Self {
        Self {
            islands,
            is_lone: false,
        }
    }
}

/// What a layout follows from, besides the cuts.
#[derive(Debug)]
struct Origin {
    /// See [`Islands::revision`].
    islands: u64,
    members: Vec<u32>,
    is_lone: bool,
    order: ContactOrder,
    method: MethodKind,
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
    pub(crate) pairs: Vec<[BodyNumber; 2]>,
    /// Number of points of each of them.
    counts: Vec<u32>,
    /// Its manifolds in the order of the islands: index and place.
    pub places: Vec<(ManifoldIndex, LaneSlot)>,
    /// Its joints, with numbers of bodies in the batch.
    pub(crate) joints: Vec<JointedPair>,
    /// Blocks of its [`subdomains`], in their order.
    pub subdomains: Vec<Range<usize>>,
    /// Of bodies that are copies, behind all others: which ones they copy.
    pub(crate) originals: Vec<BodyNumber>,
    pub(crate) cuts: Partition,
    lane_assignment: LaneAssignment,
    origin: Option<Origin>,
    /// By subdomain but the first one and fixed body: the number of its copy.
    copies: Vec<Option<BodyNumber>>,
}

impl Layout {
    /// Numbers the bodies of the islands in `group`, unless the layout is theirs already; tells whether it is. If not, the
    /// manifolds are still to be [placed](Self::place) and [named](Self::name). With a `team`, subdomains have their own copies of
    /// fixed bodies.
    pub(crate) fn number(
        &mut self,
        islands: &Islands,
        group: Group<'_>,
        bodies: &Bodies,
        settings: &SubstepSettings,
        team: Option<&Team>,
    ) -> bool {
        let is_cut_as_before = match group.islands {
            [island] => {
                let island = &islands.list[*island as usize];
                self.cut(island, islands, bodies, settings, team)
            }
            _ => self.cuts.keep_whole(),
        };
        let is_kept = is_cut_as_before
            && self.origin.as_ref().is_some_and(|origin| {
                origin.islands == islands.revision
                    && origin.members == group.islands
                    && origin.is_lone == group.is_lone
                    && origin.order == settings.order
                    && origin.method == settings.method
                    && origin.has_team == team.is_some()
            });
        if !is_kept {
            self.number_islands(islands, group.islands);
            let mut members = self.origin.take().map_or(Vec::new(), |old| old.members);
            members.clear();
            members.extend_from_slice(group.islands);
            self.origin = Some(Origin {
                islands: islands.revision,
                members,
                is_lone: group.is_lone,
                order: settings.order,
                method: settings.method,
                has_team: team.is_some(),
            });
        }
        is_kept
    }

    /// Cuts a large island into subdomains; whether that gave the same ones as before.
    fn cut(
        &mut self,
        island: &Island,
        islands: &Islands,
        bodies: &Bodies,
        settings: &SubstepSettings,
        team: Option<&Team>,
    ) -> bool {
        let leaves = partition::leaves(island.manifolds.len());
        if leaves == 1 || settings.is_exact() {
            return self.cuts.keep_whole();
        }
        let slots = &islands.slots[island.bodies.clone()];
        let center = |number: usize| {
            let slot = slots[number] as usize;
            let is_movable = bodies.velocity[slot].inverse_mass > 0.0;
            is_movable.then(|| bodies.center[slot])
        };
        self.cuts
            .cut(slots.len(), center, settings.gravity, leaves, team)
    }

    fn number_islands(&mut self, islands: &Islands, group: &[u32]) {
        self.members.clear();
        self.slots.clear();
        self.pairs.clear();
        self.counts.clear();
        self.joints.clear();
        for &index in group {
            let island = &islands.list[index as usize];
            let offset = self.slots.len() as u32;
            self.slots
                .extend_from_slice(&islands.slots[island.bodies.clone()]);
            let pairs = islands.pairs[island.manifolds.clone()].iter();
            self.pairs
                .extend(pairs.map(|pair| pair.map(|number| BodyNumber(number.0 + offset))));
            let first_joint = self.joints.len();
            let joints = islands.joints[island.joints.clone()].iter();
            let number = |body: BodyNumber| BodyNumber(body.0 + offset);
            self.joints.extend(
                joints.map(|(joint, bodies)| (*joint, bodies.map(|body| body.map(number)))),
            );
            let first_place = self.counts.len();
            self.counts
                .extend_from_slice(&islands.counts[island.manifolds.clone()]);
            self.members.push(Member {
                island: index,
                bodies: offset as usize..self.slots.len(),
                places: first_place..self.counts.len(),
                contacts: island.points.len(),
                joints: first_joint..self.joints.len(),
            });
        }
        self.cuts.sort(&mut self.slots, &mut self.pairs);
        for body in self.joints.iter_mut().flat_map(|(_, bodies)| bodies) {
            *body = body.map(|body| self.cuts.renamed(body));
        }
    }

    /// Gives each manifold of the islands in `group`, which are numbered, a lane. `bodies`: by number, of which the last is dummy,
    /// for the lanes that are not used.
    pub(crate) fn place(
        &mut self,
        islands: &Islands,
        group: Group<'_>,
        bodies: &[SolverBody],
        order: ContactOrder,
        team: Option<&Team>,
    ) {
        let rule = AssignmentRule {
            order,
            bodies: bodies.len(),
            subdomains: self.cuts.count(),
        };
        let (cuts, pairs, counts) = (&self.cuts, &self.pairs, &self.counts);
        if group.is_lone {
            let islands = self.members.iter().map(|member| member.places.clone());
            self.lane_assignment.arrange_lone(counts, islands);
        } else {
            let subdomains = pairs.iter().map(|pair| cuts.of(*pair));
            let edge = |at: usize| {
                let is_movable = |body: BodyNumber| bodies[body.index()].inverse_mass > 0.0;
                ContactEdge {
                    bodies: pairs[at].map(|body| is_movable(body).then_some(body.0)),
                    points: counts[at],
                }
            };
            self.lane_assignment.arrange(subdomains, edge, rule, team);
        }
        let places = self.lane_assignment.places().iter().copied();
        let manifolds = |&island: &u32| islands.list[island as usize].manifolds.clone();
        let names = group.islands.iter().flat_map(manifolds);
        let names = names.map(|at| islands.manifolds[at]);
        self.places.clear();
        self.places.extend(names.zip(places));
        self.subdomains.clear();
        self.subdomains.extend(self.lane_assignment.subdomains());
    }

    /// Makes the blocks: names the bodies and manifolds of their lanes. What else they hold from another step is overwritten
    /// when they are filled.
    pub(crate) fn name(
        &mut self,
        blocks: &mut Vec<Block>,
        points: &mut Vec<Point>,
        team: Option<&Team>,
    ) {
        let dummy = self.slots.len() as u32;
        let counts = self.lane_assignment.points_of_blocks();
        blocks.resize_with(counts.len(), Block::default);
        let has_copies = team.is_some();
        let (mut rest, mut end, mut first) = (&mut blocks[..], 0, 0);
        let subdomains = self.subdomains.iter().enumerate();
        let parts = subdomains.zip(self.lane_assignment.manifolds_of_subdomains());
        let parts = parts.map(|((subdomain, blocks), manifolds)| {
            let counts = &counts[blocks.clone()];
            first = end;
            end += counts
                .iter()
                .map(|&count| usize::from(count))
                .sum::<usize>();
            Naming {
                first_block: blocks.start,
                blocks: front_mut(&mut rest, blocks.len()),
                counts,
                first_point: first,
                manifolds,
                // See `name_copies`.
                dummy: dummy + if has_copies { subdomain as u32 } else { 0 },
            }
        });
        Team::each(team, parts, |part| part.name(&self.pairs, &self.places));
        points.resize(end, Point::default());
        self.originals.clear();
        if has_copies {
            self.name_copies(blocks);
        }
    }

    /// Gives each subdomain its own copies of the fixed bodies and of the dummy one, so that subdomains of a stage, which different
    /// threads solve, write to different bodies. Those of the dummy one come first, in the order of the subdomains.
    fn name_copies(&mut self, blocks: &mut [Block]) {
        let (dummy, first_fixed) = (self.slots.len() as u32, self.cuts.first_fixed());
        let others = self.subdomains.len() - 1;
        self.originals
            .extend(std::iter::repeat_n(BodyNumber(dummy), others));
        if others == 0 {
            return;
        }
        let fixed = self.slots.len() - first_fixed;
        self.copies.clear();
        self.copies.resize(others * fixed, None);
        for (pair, (_, place)) in self.pairs.iter().zip(&self.places) {
            let is_fixed = |&side: &usize| pair[side].index() >= first_fixed;
            let Some(side) = (0..2).find(is_fixed) else {
                continue;
            };
            let Some(other) = (self.cuts.of(*pair) as usize).checked_sub(1) else {
                continue;
            };
            let copy = &mut self.copies[other * fixed + pair[side].index() - first_fixed];
            let number = *copy.get_or_insert_with(|| {
                self.originals.push(pair[side]);
                BodyNumber(dummy + self.originals.len() as u32)
            });
            let block = &mut blocks[place.block as usize];
            block.bodies[side][place.lane as usize] = number.0;
        }
    }

    /// Takes islands out, by their numbers in the group, of which the results are not wanted.
    pub(crate) fn leave_out(&mut self, is_left: &[bool]) {
        let mut is_left = is_left.iter();
        self.members.retain(|_| is_left.next() != Some(&true));
        self.origin = None;
    }

    /// The body itself, or the one that it is a copy of.
    pub fn original(&self, body: BodyNumber) -> BodyNumber {
        // The dummy body comes between bodies and copies.
        let first_copy = self.slots.len() + 1;
        let copy = body.index().checked_sub(first_copy);
        copy.map_or(body, |copy| self.originals[copy])
    }
}

/// The blocks of a subdomain that are to be named.
struct Naming<'a> {
    /// The first of them within the batch.
    first_block: usize,
    blocks: &'a mut [Block],
    /// By block: points of its largest manifold.
    counts: &'a [u16],
    /// The first of its points within the batch.
    first_point: usize,
    /// Its manifolds.
    manifolds: &'a [u32],
    /// Number of the body of lanes that are not used.
    dummy: u32,
}

impl Naming<'_> {
    fn name(self, pairs: &[[BodyNumber; 2]], places: &[(ManifoldIndex, LaneSlot)]) {
        let mut end = self.first_point;
        for (block, &count) in self.blocks.iter_mut().zip(self.counts) {
            let first = end;
            end += usize::from(count);
            block.clear(self.dummy, first..end);
        }
        for &at in self.manifolds {
            let (index, place) = places[at as usize];
            let block = &mut self.blocks[place.block as usize - self.first_block];
            let bodies = pairs[at as usize].map(|body| body.0);
            block.put(place.lane as usize, index.0, bodies);
        }
    }
}
