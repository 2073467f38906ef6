//! Large meshes, which are cut over several steps.

use crate::bodies::store::Bodies;
use crate::fracture::BreakingImpact;
use crate::fracture::impact;
use crate::fracture::pieces::{BreakPlan, PieceSet};
use crate::slice::cut_job::CutJob;
use crate::slice::{Cutting, Impact};
use crate::tuning::PASSES_OF_A_CUT;
use smallvec::SmallVec;

/// A body that a blow has broken, while the mesh that rides in it is cut.
#[derive(Clone, Debug)]
pub(super) struct GradualCut {
    plan: BreakPlan,
    /// What broke it; all of it acted.
    pub(super) blow: BreakingImpact,
    job: CutJob,
}

impl GradualCut {
    /// Begins to cut the body in `slot` into at most `left` pieces; none where that is not done over several steps: of one of several parts, and
    /// by planes, which are few.
    pub(super) fn begin(
        bodies: &Bodies,
        slot: u32,
        (impact, blow): (&Impact, BreakingImpact),
        left: usize,
    ) -> Option<Self> {
        let shape = bodies.convex(slot)?;
        let visual = shape.visual()?;
        let most = bodies.max_pieces(slot).min(left);
        let cutting = impact::cutting(bodies, slot, impact, most)?;
        if matches!(cutting, Cutting::Planes(_)) {
            return None;
        }
        let options = bodies.cut_looks(slot).options;
        let job = CutJob::begin(shape.hull(), visual, (&cutting, most), options).ok()?;
        let plan = BreakPlan {
            slot,
            blow: Some(cutting),
            cuts: SmallVec::new(),
            most,
            struck: None,
        };
        Some(Self { plan, blow, job })
    }

    /// Does what a step may: of a cut of `triangles`; whether all is done.
    pub(super) fn work(&mut self, triangles: usize) -> bool {
        self.job.work(triangles.saturating_mul(PASSES_OF_A_CUT))
    }

    /// Number of pieces that it makes.
    pub(super) fn len(&self) -> usize {
        self.job.len()
    }

    /// Triangles that planes were held against since this was asked last.
    pub(super) fn take_gone_through(&mut self) -> usize {
        self.job.take_gone_through()
    }

    /// The pieces, once all is done; none if they are no division.
    pub(super) fn finish(&mut self, bodies: &Bodies) -> Option<PieceSet> {
        let (pieces, mut cutter) = std::mem::take(&mut self.job).finish();
        PieceSet::of_pieces(bodies, &self.plan, pieces, &mut cutter).ok()
    }
}
