//! Where the manifolds of a batch are, ordered from step to step while the same bodies touch at as many points.
//!
//! Subdomains are placed each for itself, and only those in which something has changed: in a large heap some contact comes or
//! goes in every step, but in most of its subdomains none does.

use crate::simd::lanes::WIDTH;
use crate::solver::graph::coloring::Coloring;
use crate::solver::graph::contact_order::ContactOrder;
use crate::solver::graph::indices::LaneSlot;
use crate::solver::graph::ordered_packing::{OrderedPacking, Packer};
use crate::threads::team::Team;
use std::ops::Range;

/// A manifold as a schedule sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ContactEdge {
    /// Numbers of its bodies, of those that contacts move.
    pub bodies: [Option<u32>; 2],
    /// Number of its points.
    pub points: u32,
}

/// What an assignment is made by.
#[derive(Clone, Copy, Debug)]
pub struct AssignmentRule {
    /// How manifolds are put into blocks.
    pub order: ContactOrder,
    /// Number of bodies.
    pub bodies: usize,
    /// Number of subdomains.
    pub subdomains: usize,
}

/// Places of manifolds; buffers are reused.
#[derive(Debug, Default)]
pub struct LaneAssignment {
    /// By manifold: its [subdomain](crate::solver::graph::partition).
    subdomain: Vec<u8>,
    /// Manifolds, subdomain by subdomain, and where those of each subdomain end.
    order: Vec<u32>,
    ends: Vec<usize>,
    /// Those that there are, and perhaps more.
    subdomains: Vec<Subdomain>,
    /// Manifolds of islands that share no body.
    lone: Vec<Range<usize>>,
    outcome: Outcome,
}

/// A subdomain, and two ways to place its manifolds in blocks of its own.
#[derive(Debug, Default)]
struct Subdomain {
    edges: Vec<ContactEdge>,
    /// Those that are to be.
    new_edges: Vec<ContactEdge>,
    ordered: PackedSubdomain<OrderedPacking>,
    colored: PackedSubdomain<Coloring>,
}

/// A way to place the manifolds of a subdomain.
#[derive(Debug, Default)]
struct PackedSubdomain<F> {
    filling: F,
    /// By manifold.
    places: Vec<LaneSlot>,
    /// Whether these are those of the present edges.
    is_made: bool,
}

/// What has come of it.
#[derive(Debug, Default)]
struct Outcome {
    /// By manifold.
    places: Vec<LaneSlot>,
    /// By block: points of its largest manifold.
    points: Vec<u16>,
    /// By subdomain: the end of its blocks.
    ends: Vec<usize>,
}

impl LaneAssignment {
    /// Places manifolds, of which none is joined to the same body twice: `subdomains` are theirs, and `edge` tells what a schedule
    /// sees of each.
    pub fn arrange(
        &mut self,
        subdomains: impl Iterator<Item = u32>,
        edge: impl Fn(usize) -> ContactEdge + Sync,
        rule: AssignmentRule,
        team: Option<&Team>,
    ) {
        self.sort_by_subdomain(subdomains, rule.subdomains);
        self.load_subdomains(edge, team);
        let is_colored = match rule.order {
            ContactOrder::Ordered => false,
            ContactOrder::Colored => true,
            ContactOrder::Automatic => {
                let least = self.order.len().div_ceil(WIDTH);
                self.place(false, rule.bodies, team) > 2 * least
            }
        };
        self.place(is_colored, rule.bodies, team);
        self.join(is_colored);
    }

    /// Places the manifolds of islands that share no body, with as many points each as `counts` tells: those of an island one after the
    /// other, in one lane of as many blocks. Islands of one manifold are in blocks of as many points only.
    pub fn arrange_lone(&mut self, counts: &[u32], islands: impl Iterator<Item = Range<usize>>) {
        self.lone.clear();
        self.lone.extend(islands);
        // Beside each other, those that have as many points, so that blocks have few rows that are not used.
        let shape = |island: &Range<usize>| (island.len(), &counts[island.clone()]);
        self.lone
            .sort_unstable_by(|a, b| shape(a).cmp(&shape(b)).then(a.start.cmp(&b.start)));
        self.order.clear();
        self.order.extend(0..counts.len() as u32);
        self.ends.clear();
        self.ends.push(counts.len());
        let Outcome {
            places,
            points,
            ends,
        } = &mut self.outcome;
        places.clear();
        places.resize(counts.len(), LaneSlot::default());
        points.clear();
        ends.clear();
        let is_alike = |a: &Range<usize>, b: &Range<usize>| {
            a.len() == b.len() && (a.len() > 1 || counts[a.start] == counts[b.start])
        };
        let alike = self.lone.chunk_by(is_alike);
        for side_by_side in alike.flat_map(|islands| islands.chunks(WIDTH)) {
            let first = points.len();
            points.resize(first + side_by_side[0].len(), 0);
            for (lane, island) in (0..).zip(side_by_side) {
                for (block, at) in (first..).zip(island.clone()) {
                    let count = counts[at] as u16;
                    points[block] = points[block].max(count);
                    places[at] = LaneSlot {
                        block: block as u32,
                        lane,
                        count,
                    };
                }
            }
        }
        ends.push(points.len());
    }

    /// Places of the manifolds, in their order.
    pub fn places(&self) -> &[LaneSlot] {
        &self.outcome.places
    }

    /// Blocks of the subdomains.
    pub fn subdomains(&self) -> impl Iterator<Item = Range<usize>> {
        ranges(&self.outcome.ends)
    }

    /// Manifolds of the subdomains.
    pub fn manifolds_of_subdomains(&self) -> impl Iterator<Item = &[u32]> {
        ranges(&self.ends).map(|range| &self.order[range])
    }

    /// By block: points of its largest manifold.
    pub fn points_of_blocks(&self) -> &[u16] {
        &self.outcome.points
    }

    /// Lists the manifolds of each subdomain in their order.
    fn sort_by_subdomain(&mut self, subdomains: impl Iterator<Item = u32>, count: usize) {
        self.subdomain.clear();
        self.subdomain
            .extend(subdomains.map(|subdomain| subdomain as u8));
        self.order.resize(self.subdomain.len(), 0);
        self.ends.clear();
        self.ends.resize(count, 0);
        for subdomain in &self.subdomain {
            self.ends[*subdomain as usize] += 1;
        }
        let mut first = 0;
        for end in &mut self.ends {
            first += std::mem::replace(end, first);
        }
        for (index, subdomain) in (0..).zip(&self.subdomain) {
            let end = &mut self.ends[*subdomain as usize];
            self.order[*end] = index;
            *end += 1;
        }
    }

    /// Gives each subdomain its edges.
    fn load_subdomains(&mut self, edge: impl Fn(usize) -> ContactEdge + Sync, team: Option<&Team>) {
        let count = self.ends.len().max(self.subdomains.len());
        self.subdomains.resize_with(count, Subdomain::default);
        let of_subdomains = ranges(&self.ends).map(|range| &self.order[range]);
        let parts = self.subdomains.iter_mut().zip(of_subdomains);
        Team::each(team, parts, |(subdomain, order)| {
            subdomain.load(order.iter().map(|&at| edge(at as usize)));
        });
    }

    /// Places the manifolds of all subdomains in one way; returns the number of blocks.
    fn place(&mut self, is_colored: bool, bodies: usize, team: Option<&Team>) -> usize {
        let subdomains = &mut self.subdomains[..self.ends.len()];
        Team::each(team, subdomains.iter_mut(), |subdomain| {
            subdomain.place(is_colored, bodies);
        });
        let blocks = subdomains
            .iter()
            .map(|subdomain| subdomain.placed(is_colored).1);
        blocks.map(<[u16]>::len).sum()
    }

    /// Puts the blocks of the subdomains one behind the other.
    fn join(&mut self, is_colored: bool) {
        let Outcome {
            places,
            points,
            ends,
        } = &mut self.outcome;
        places.resize(self.order.len(), LaneSlot::default());
        points.clear();
        ends.clear();
        let mut order = self.order.iter();
        for subdomain in &self.subdomains[..self.ends.len()] {
            let (of_manifolds, of_blocks) = subdomain.placed(is_colored);
            let first = points.len() as u32;
            for (place, &at) in of_manifolds.iter().zip(&mut order) {
                let block = first + place.block;
                places[at as usize] = LaneSlot { block, ..*place };
            }
            points.extend_from_slice(of_blocks);
            ends.push(points.len());
        }
    }
}

/// Ranges that follow each other, by their ends.
fn ranges(ends: &[usize]) -> impl Iterator<Item = Range<usize>> {
    let firsts = std::iter::once(&0).chain(ends);
    firsts.zip(ends).map(|(first, end)| *first..*end)
}

impl Subdomain {
    /// Takes its edges over; what is known of them is ordered if they are the same.
    fn load(&mut self, edges: impl Iterator<Item = ContactEdge>) {
        self.new_edges.clear();
        self.new_edges.extend(edges);
        if self.edges == self.new_edges {
            return;
        }
        std::mem::swap(&mut self.edges, &mut self.new_edges);
        // So that a scene that was as large before allocates nothing, whichever of the two lists it is in then.
        self.new_edges.clear();
        self.new_edges.reserve(self.edges.len());
        (self.ordered.is_made, self.colored.is_made) = (false, false);
    }

    fn place(&mut self, is_colored: bool, bodies: usize) {
        if is_colored {
            self.colored.make(&self.edges, bodies);
        } else {
            self.ordered.make(&self.edges, bodies);
        }
    }

    /// Places of its manifolds and, of each block, the points of its largest manifold.
    fn placed(&self, is_colored: bool) -> (&[LaneSlot], &[u16]) {
        if is_colored {
            self.colored.placed()
        } else {
            self.ordered.placed()
        }
    }
}

impl<F: Packer> PackedSubdomain<F> {
    /// Places the manifolds of edges between `bodies` bodies, unless that is done.
    fn make(&mut self, edges: &[ContactEdge], bodies: usize) {
        if self.is_made {
            return;
        }
        self.is_made = true;
        self.filling.begin(bodies);
        for edge in edges {
            self.filling.add(edge.bodies, edge.points);
        }
        self.places.clear();
        self.places.extend(self.filling.place());
    }

    fn placed(&self) -> (&[LaneSlot], &[u16]) {
        (&self.places, self.filling.points_of_blocks())
    }
}
