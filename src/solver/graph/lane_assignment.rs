//! Where the manifolds of a batch are, kept from step to step while the same bodies touch at as many points.
//!
//! Domains are placed each for itself, and only those in which something has changed: in a large heap some contact comes or
//! goes in every step, but in most of its domains none does.

use crate::simd::lanes::WIDTH;
use crate::solver::config::ContactOrder;
use crate::solver::graph::coloring::Colouring;
use crate::solver::graph::indices::Place;
use crate::solver::graph::ordered_packing::{Filling, Schedule};
use crate::threads::team::Team;
use std::ops::Range;

/// A manifold as a schedule sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Joint {
    /// Numbers of its bodies, of those that contacts move.
    pub bodies: [Option<u32>; 2],
    /// Number of its points.
    pub points: u32,
}

/// What an arrangement is made by.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// How manifolds are put into blocks.
    pub order: ContactOrder,
    /// Number of bodies.
    pub bodies: usize,
    /// Number of domains.
    pub domains: usize,
}

/// Places of manifolds; buffers are reused.
#[derive(Debug, Default)]
pub struct Arrangement {
    /// By manifold: its [domain](crate::solver::graph::partition).
    domain: Vec<u8>,
    /// Manifolds, domain by domain, and where those of each domain end.
    order: Vec<u32>,
    ends: Vec<usize>,
    /// Those that there are, and perhaps more.
    domains: Vec<Domain>,
    outcome: Outcome,
}

/// A domain, and two ways to place its manifolds in blocks of its own.
#[derive(Debug, Default)]
struct Domain {
    joints: Vec<Joint>,
    /// Those that are to be.
    new_joints: Vec<Joint>,
    kept: Way<Schedule>,
    coloured: Way<Colouring>,
}

/// A way to place the manifolds of a domain.
#[derive(Debug, Default)]
struct Way<F> {
    filling: F,
    /// By manifold.
    places: Vec<Place>,
    /// Whether these are those of the present joints.
    is_made: bool,
}

/// What has come of it.
#[derive(Debug, Default)]
struct Outcome {
    /// By manifold.
    places: Vec<Place>,
    /// By block: points of its largest manifold.
    points: Vec<u16>,
    /// By domain: the end of its blocks.
    ends: Vec<usize>,
}

impl Arrangement {
    /// Places manifolds, of which none is joined to the same body twice: `domains` are theirs, and `joint` tells what a schedule
    /// sees of each.
    pub fn arrange(
        &mut self,
        domains: impl Iterator<Item = u32>,
        joint: impl Fn(usize) -> Joint + Sync,
        rule: Rule,
        team: Option<&Team>,
    ) {
        self.sort_by_domain(domains, rule.domains);
        self.load_domains(joint, team);
        let is_coloured = match rule.order {
            ContactOrder::Kept => false,
            ContactOrder::Coloured => true,
            ContactOrder::Automatic => {
                let least = self.order.len().div_ceil(WIDTH);
                self.place(false, rule.bodies, team) > 2 * least
            }
        };
        self.place(is_coloured, rule.bodies, team);
        self.join(is_coloured);
    }

    /// Places of the manifolds, in their order.
    pub fn places(&self) -> &[Place] {
        &self.outcome.places
    }

    /// Blocks of the domains.
    pub fn domains(&self) -> impl Iterator<Item = Range<usize>> {
        ranges(&self.outcome.ends)
    }

    /// Manifolds of the domains.
    pub fn manifolds_of_domains(&self) -> impl Iterator<Item = &[u32]> {
        ranges(&self.ends).map(|range| &self.order[range])
    }

    /// By block: points of its largest manifold.
    pub fn points_of_blocks(&self) -> &[u16] {
        &self.outcome.points
    }

    /// Lists the manifolds of each domain in their order.
    fn sort_by_domain(&mut self, domains: impl Iterator<Item = u32>, count: usize) {
        self.domain.clear();
        self.domain.extend(domains.map(|domain| domain as u8));
        self.order.resize(self.domain.len(), 0);
        self.ends.clear();
        self.ends.resize(count, 0);
        for domain in &self.domain {
            self.ends[*domain as usize] += 1;
        }
        let mut first = 0;
        for end in &mut self.ends {
            first += std::mem::replace(end, first);
        }
        for (index, domain) in (0..).zip(&self.domain) {
            let end = &mut self.ends[*domain as usize];
            self.order[*end] = index;
            *end += 1;
        }
    }

    /// Gives each domain its joints.
    fn load_domains(&mut self, joint: impl Fn(usize) -> Joint + Sync, team: Option<&Team>) {
        let count = self.ends.len().max(self.domains.len());
        self.domains.resize_with(count, Domain::default);
        let of_domains = ranges(&self.ends).map(|range| &self.order[range]);
        let parts = self.domains.iter_mut().zip(of_domains);
        Team::each(team, parts, |(domain, order)| {
            domain.load(order.iter().map(|&at| joint(at as usize)));
        });
    }

    /// Places the manifolds of all domains in one way; returns the number of blocks.
    fn place(&mut self, is_coloured: bool, bodies: usize, team: Option<&Team>) -> usize {
        let domains = &mut self.domains[..self.ends.len()];
        Team::each(team, domains.iter_mut(), |domain| {
            domain.place(is_coloured, bodies);
        });
        let blocks = domains.iter().map(|domain| domain.placed(is_coloured).1);
        blocks.map(<[u16]>::len).sum()
    }

    /// Puts the blocks of the domains one behind the other.
    fn join(&mut self, is_coloured: bool) {
        let Outcome {
            places,
            points,
            ends,
        } = &mut self.outcome;
        places.resize(self.order.len(), Place::default());
        points.clear();
        ends.clear();
        let mut order = self.order.iter();
        for domain in &self.domains[..self.ends.len()] {
            let (of_manifolds, of_blocks) = domain.placed(is_coloured);
            let first = points.len() as u32;
            for (place, &at) in of_manifolds.iter().zip(&mut order) {
                let block = first + place.block;
                places[at as usize] = Place { block, ..*place };
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

impl Domain {
    /// Takes its joints over; what is known of them is kept if they are the same.
    fn load(&mut self, joints: impl Iterator<Item = Joint>) {
        self.new_joints.clear();
        self.new_joints.extend(joints);
        if self.joints == self.new_joints {
            return;
        }
        std::mem::swap(&mut self.joints, &mut self.new_joints);
        // So that a scene that was as large before allocates nothing, whichever of the two lists it is in then.
        self.new_joints.clear();
        self.new_joints.reserve(self.joints.len());
        (self.kept.is_made, self.coloured.is_made) = (false, false);
    }

    fn place(&mut self, is_coloured: bool, bodies: usize) {
        if is_coloured {
            self.coloured.make(&self.joints, bodies);
        } else {
            self.kept.make(&self.joints, bodies);
        }
    }

    /// Places of its manifolds and, of each block, the points of its largest manifold.
    fn placed(&self, is_coloured: bool) -> (&[Place], &[u16]) {
        if is_coloured {
            self.coloured.placed()
        } else {
            self.kept.placed()
        }
    }
}

impl<F: Filling> Way<F> {
    /// Places the manifolds of joints between `bodies` bodies, unless that is done.
    fn make(&mut self, joints: &[Joint], bodies: usize) {
        if self.is_made {
            return;
        }
        self.is_made = true;
        self.filling.begin(bodies);
        for joint in joints {
            self.filling.add(joint.bodies, joint.points);
        }
        self.places.clear();
        self.places.extend(self.filling.place());
    }

    fn placed(&self) -> (&[Place], &[u16]) {
        (&self.places, self.filling.points_of_blocks())
    }
}
