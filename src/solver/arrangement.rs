//! Where the manifolds of a batch are, kept from step to step while the same bodies touch at as many points.
//!
//! Domains are placed each for itself, and only those in which something has changed: in a large heap some contact comes or
//! goes in every step, but in most of its domains none does.

use super::blocks::Place;
use super::colouring::Colouring;
use super::lanes::WIDTH;
use super::schedule::{ContactOrder, Filling, Schedule};
use crate::parts::front;
use crate::team::Team;
use std::ops::Range;

/// A manifold as a schedule sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Joint {
    /// Numbers of its bodies, of those that contacts move.
    pub bodies: [Option<u32>; 2],
    /// Number of its points.
    pub points: u32,
    /// Number of its [domain](super::domains).
    pub domain: u32,
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
    joints: Vec<Joint>,
    /// Indices of joints, domain by domain, and where those of each domain end.
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
    /// Places manifolds, of which none is joined to the same body twice.
    pub fn arrange(
        &mut self,
        joints: impl Iterator<Item = Joint>,
        rule: Rule,
        team: Option<&Team>,
    ) {
        self.joints.clear();
        self.joints.extend(joints);
        self.sort_by_domain(rule.domains);
        self.load_domains(team);
        let is_coloured = match rule.order {
            ContactOrder::Kept => false,
            ContactOrder::Coloured => true,
            ContactOrder::Automatic => {
                let least = self.joints.len().div_ceil(WIDTH);
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
        let ends = &self.outcome.ends;
        let firsts = std::iter::once(&0).chain(ends);
        firsts.zip(ends).map(|(first, end)| *first..*end)
    }

    /// Of each block, the points of its largest manifold.
    pub fn points_of_blocks(&self) -> impl ExactSizeIterator<Item = usize> {
        self.outcome
            .points
            .iter()
            .map(|&points| usize::from(points))
    }

    /// Lists the joints of each domain in their order.
    fn sort_by_domain(&mut self, domains: usize) {
        self.order.resize(self.joints.len(), 0);
        self.ends.clear();
        self.ends.resize(domains, 0);
        for joint in &self.joints {
            self.ends[joint.domain as usize] += 1;
        }
        let mut first = 0;
        for end in &mut self.ends {
            first += std::mem::replace(end, first);
        }
        for (index, joint) in (0..).zip(&self.joints) {
            let end = &mut self.ends[joint.domain as usize];
            self.order[*end] = index;
            *end += 1;
        }
    }

    /// Gives each domain its joints.
    fn load_domains(&mut self, team: Option<&Team>) {
        let count = self.ends.len().max(self.domains.len());
        self.domains.resize_with(count, Domain::default);
        let (joints, mut order, mut first) = (&self.joints, &self.order[..], 0);
        let parts = self
            .domains
            .iter_mut()
            .zip(&self.ends)
            .map(|(domain, end)| {
                let of_domain = front(&mut order, end - std::mem::replace(&mut first, *end));
                (domain, of_domain)
            });
        Team::each(team, parts, |(domain, order)| {
            domain.load(order.iter().map(|&at| joints[at as usize]));
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
        places.resize(self.joints.len(), Place::default());
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
