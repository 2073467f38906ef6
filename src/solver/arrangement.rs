//! Where the manifolds of a batch are, kept from step to step while the same bodies touch at as many points.

use super::blocks::Place;
use super::lanes::WIDTH;
use super::schedule::{ContactOrder, Filling, Schedule};
use std::ops::Range;

/// Blocks of a stage, on average, from which a team is faster than one thread with fuller blocks.
const WIDE_STAGE: usize = 8;

/// A manifold as a schedule sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Joint {
    /// Numbers of its bodies, of those that contacts move.
    pub bodies: [Option<u32>; 2],
    /// Number of its points.
    pub points: u32,
}

/// What an arrangement is made by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rule {
    /// How manifolds are put into blocks.
    pub order: ContactOrder,
    /// Whether several threads are to solve the blocks together, in stages.
    pub has_team: bool,
    /// Number of bodies.
    pub bodies: usize,
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
    places: Vec<Place>,
    stages: Vec<Range<usize>>,
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
        self.place_manifolds(rule);
    }

    /// Places of the manifolds, in their order.
    pub fn places(&self) -> &[Place] {
        &self.places
    }

    /// Parts of the blocks that share no body, for a team; empty if one thread is to solve them.
    pub fn stages(&self) -> &[Range<usize>] {
        &self.stages
    }

    /// Of each block, the points of its largest manifold.
    pub fn points_of_blocks(&self) -> impl ExactSizeIterator<Item = usize> {
        self.schedule.points_of_blocks()
    }

    fn place_manifolds(&mut self, rule: Rule) {
        let mut filling = match rule.order {
            ContactOrder::Coloured => Filling::ByColour,
            ContactOrder::Automatic | ContactOrder::Kept => Filling::Densely,
        };
        self.place_all(rule.bodies, filling);
        let least = self.places.len().div_ceil(WIDTH);
        if rule.order == ContactOrder::Automatic && self.schedule.blocks() > 2 * least {
            filling = Filling::ByColour;
            self.place_all(rule.bodies, filling);
        }
        let mut has_team = rule.has_team;
        if has_team && filling == Filling::Densely {
            // The same sweeps in the same order, whatever the filling; worth it where stages are wide.
            self.place_all(rule.bodies, Filling::ByStage);
            if self.schedule.blocks() < WIDE_STAGE * self.schedule.stage_count() {
                has_team = false;
                self.place_all(rule.bodies, filling);
            }
        }
        self.schedule.finish(self.places.iter_mut());
        self.stages.clear();
        if has_team {
            self.schedule.stages(&mut self.stages);
        }
    }

    fn place_all(&mut self, bodies: usize, filling: Filling) {
        let Self {
            schedule, joints, ..
        } = self;
        schedule.begin(bodies, filling);
        self.places.clear();
        let places = joints.iter().map(|j| schedule.place(j.bodies, j.points));
        self.places.extend(places);
    }
}
