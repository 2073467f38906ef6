//! Where the manifolds of a batch are, kept from step to step while the same bodies touch at as many points.

use super::blocks::Place;
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
    rule: Option<Rule>,
    /// Those that are arranged.
    joints: Vec<Joint>,
    /// Those that are to be.
    new_joints: Vec<Joint>,
    /// Indices of joints, domain by domain, and where those of each domain end.
    order: Vec<u32>,
    ends: Vec<usize>,
    places: Vec<Place>,
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
        self.rule = Some(rule);
        self.sort_by_domain(rule.domains);
        self.place_manifolds(rule);
    }

    /// Places of the manifolds, in their order.
    pub fn places(&self) -> &[Place] {
        &self.places
    }

    /// Blocks of the domains.
    pub fn domains(&self) -> impl Iterator<Item = Range<usize>> {
        self.schedule.domains()
    }

    /// Of each block, the points of its largest manifold.
    pub fn points_of_blocks(&self) -> impl ExactSizeIterator<Item = usize> {
        self.schedule.points_of_blocks()
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
        let filling = match rule.order {
            ContactOrder::Coloured => Filling::ByColour,
            ContactOrder::Automatic | ContactOrder::Kept => Filling::Densely,
        };
        self.place_all(rule, filling);
        let least = self.places.len().div_ceil(WIDTH);
        if rule.order == ContactOrder::Automatic && self.schedule.blocks() > 2 * least {
            self.place_all(rule, Filling::ByColour);
        }
        self.schedule.finish(self.places.iter_mut());
    }

    fn place_all(&mut self, rule: Rule, filling: Filling) {
        let Self {
            schedule,
            joints,
            places,
            order,
            ends,
            ..
        } = self;
        schedule.begin(rule.bodies, filling);
        places.clear();
        places.resize(joints.len(), Place::default());
        let mut first = 0;
        for &end in ends.iter() {
            for &at in &order[first..end] {
                let joint = &joints[at as usize];
                places[at as usize] = schedule.place(joint.bodies, joint.points);
            }
            first = end;
            schedule.end_domain();
        }
    }
}
