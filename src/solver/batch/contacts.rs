//! The contacts of a batch: eight manifolds in each block, and those among them whose rows follow the motion.

use crate::bodies::solver_body::BodyMass;
use crate::simd::lanes::LaneWidth;
use crate::solver::batch::layout::Layout;
use crate::solver::batch::subdomain_slices::parts_of_blocks;
use crate::solver::graph::indices::{BodyNumber, LaneSlot, ManifoldIndex};
use crate::solver::wide::block::{Block, Point};
use crate::solver::wide::prepare::derive_stale;
use crate::solver::wide::reanchor::{
    AnchorStart, BodyRotation, Curvatures, ReanchoredBlock, ReanchoredBlocks,
};
use crate::threads::team::Team;

/// Contacts in lanes.
#[derive(Debug, Default)]
pub struct BatchContacts {
    /// Blocks of manifolds.
    pub blocks: Vec<Block>,
    /// Points of the blocks.
    pub points: Vec<Point>,
    /// Manifolds whose rows follow the motion.
    pub moving: Vec<MovingManifold>,
    /// Blocks in which a manifold moves, or a body has a new inertia, ascending.
    pub(crate) reanchored: Vec<ReanchoredBlock>,
    /// Where the points of these were at the start of the step.
    pub(crate) anchor_starts: Vec<AnchorStart>,
    /// How curved bodies are there; empty where none is round.
    pub(crate) curvatures: Vec<Curvatures>,
    /// By body: how it has turned since the start of the step, if any of its manifolds moves.
    pub(crate) rotations: Vec<BodyRotation>,
    /// By body: whether its turn within the step matters to the rows.
    pub(crate) is_reanchored: Vec<bool>,
    /// By body: whether its inertia changes within the step, and the masses of its rows with it.
    pub(crate) has_new_inertia: Vec<bool>,
    /// By block, while these are marked: its number among the reanchored ones.
    pub(crate) reanchored_number: Vec<Option<u32>>,
}

/// A manifold whose rows must follow the motion of its bodies.
#[derive(Clone, Copy, Debug)]
pub struct MovingManifold {
    /// Index of the manifold.
    pub manifold: ManifoldIndex,
    /// Where it is.
    pub place: LaneSlot,
    /// Numbers of its bodies within the batch.
    pub bodies: [BodyNumber; 2],
    /// Which of the two bodies the contact points move with: 0 for A, 1 for B.
    pub anchor_body: usize,
    /// If the two may pass through each other in the step: half the least extent of the anchor body, m.
    pub ccd_radius: Option<f32>,
}

impl BatchContacts {
    /// Computes masses and couplings anew where anchors and inertias have changed.
    pub(crate) fn derive_masses(
        &mut self,
        masses: &[BodyMass],
        layout: &Layout,
        width: LaneWidth,
        team: Option<&Team>,
    ) {
        let mut reanchored = ReanchoredBlocks::new(&self.reanchored);
        let parts = parts_of_blocks(&mut self.blocks, &mut self.points, &layout.subdomains, team);
        let parts = parts.map(|(blocks, points)| {
            let reanchored = reanchored.take(blocks.len());
            (blocks, points, reanchored)
        });
        Team::each(team, parts, |(blocks, points, reanchored)| {
            derive_stale(blocks, points, masses, reanchored.blocks(), width);
        });
    }
}
