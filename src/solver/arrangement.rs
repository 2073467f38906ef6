//! Where the manifolds of a batch are, kept from step to step while the same bodies touch at as many points.

use super::blocks::Place;
use super::colouring::Colouring;
use super::lanes::WIDTH;
use super::schedule::{ContactOrder, Filling, Schedule};
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
    schedule: Schedule,
    colouring: Colouring,
    rule: Option<Rule>,
    /// Those that are arranged.
    joints: Vec<Joint>,
    /// Those that are to be.
    new_joints: Vec<Joint>,
    /// Indices of joints, domain by domain, and where those of each domain end.
    order: Vec<u32>,
    ends: Vec<usize>,
    outcome: Outcome,
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
    pub fn arrange(&mut self, joints: impl Iterator<Item = Joint>, rule: Rule) {
        self.new_joints.clear();
        self.new_joints.extend(joints);
        if self.rule == Some(rule) && self.joints == self.new_joints {
            return;
        }
        std::mem::swap(&mut self.joints, &mut self.new_joints);
        // So that a scene that was as large before allocates nothing, whichever of the two lists it is in then.
        self.new_joints.clear();
        self.new_joints.reserve(self.joints.len());
        self.rule = Some(rule);
        self.sort_by_domain(rule.domains);
        self.place_manifolds(rule);
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

    fn place_manifolds(&mut self, rule: Rule) {
        let Self {
            schedule,
            colouring,
            joints,
            order,
            ends,
            outcome,
            ..
        } = self;
        let domains = Domains {
            joints,
            order,
            ends,
            bodies: rule.bodies,
        };
        if rule.order == ContactOrder::Coloured {
            return domains.place(colouring, outcome);
        }
        domains.place(schedule, outcome);
        let least = joints.len().div_ceil(WIDTH);
        if rule.order == ContactOrder::Automatic && outcome.points.len() > 2 * least {
            domains.place(colouring, outcome);
        }
    }
}

/// Joints, sorted by domain.
struct Domains<'a> {
    joints: &'a [Joint],
    order: &'a [u32],
    ends: &'a [usize],
    bodies: usize,
}

impl Domains<'_> {
    /// Places the manifolds in one way, domain by domain.
    fn place(&self, filling: &mut impl Filling, outcome: &mut Outcome) {
        filling.begin(self.bodies);
        outcome.places.resize(self.joints.len(), Place::default());
        outcome.ends.clear();
        let mut first = 0;
        for &end in self.ends {
            let domain = &self.order[first..end];
            for &at in domain {
                let Joint { bodies, points, .. } = self.joints[at as usize];
                filling.add(bodies, points);
            }
            for (&at, place) in domain.iter().zip(filling.end_domain()) {
                outcome.places[at as usize] = place;
            }
            outcome.ends.push(filling.points_of_blocks().len());
            first = end;
        }
        outcome.points.clear();
        outcome.points.extend_from_slice(filling.points_of_blocks());
    }
}
