//! Bodies that wait for their turn to break, and what becomes of one whose turn it is.

use crate::bodies::breaking::Blow;
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::fracture::cluster::{BrokenBonds, Groups};
use crate::fracture::impact;
use crate::fracture::pieces::{BreakPlan, PieceSet};
use crate::fracture::{BreakingImpact, MIN_PIECES};
use crate::slice::{Impact, PieceCutter};
use smallvec::SmallVec;

/// A body that is to break and waits for it.
#[derive(Clone, Debug)]
pub(super) struct PendingBreak {
    pub(super) body: BodyId,
    pub(super) slot: u32,
    pub(super) cause: PendingCause,
}

/// What is to break a body.
#[derive(Clone, Debug)]
pub(super) enum PendingCause {
    /// It was hit with more than it bears when there was no budget for it.
    Blow {
        /// What it was hit with, in its own frame.
        impact: Impact,
        /// The same for the report; all of it acted.
        blow: BreakingImpact,
        /// The bonds within it that this breaks.
        bonds: Option<BrokenBonds>,
    },
    /// Bonds within it bore too much for too long.
    Load(BrokenBonds),
}

/// What becomes of a body.
#[derive(Debug)]
pub(super) enum Division {
    /// It is cut.
    Cut(PieceSet),
    /// Parts of it come off.
    Groups(Groups),
}

impl Division {
    /// Number of pieces.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Cut(pieces) => pieces.len(),
            Self::Groups(groups) => groups.pieces.len(),
        }
    }
}

/// What a blow makes of the body in `slot` where `left` pieces may be made; nothing if it bears it.
pub(super) fn divide(
    bodies: &Bodies,
    slot: u32,
    impact: &Impact,
    left: usize,
    cutter: &mut PieceCutter,
) -> Option<Division> {
    let most = bodies.max_pieces(slot).min(left);
    let plan = BreakPlan {
        slot,
        blow: Some(impact::cutting(bodies, slot, impact, most)?),
        cuts: SmallVec::new(),
        most,
        struck: (bodies.compound(slot)).map(|it| impact::struck_part(it, impact.point)),
    };
    PieceSet::new(bodies, &plan, cutter).ok().map(Division::Cut)
}

impl PendingBreak {
    /// What becomes of the body now; nothing if it bears it.
    pub(super) fn divide(
        &self,
        bodies: &Bodies,
        left: usize,
        cutter: &mut PieceCutter,
    ) -> Option<Division> {
        let groups = |broken: &BrokenBonds| {
            let is_known = broken.is_of(bodies, self.slot);
            let groups = is_known.then(|| Groups::of(bodies, self.slot, &broken.bonds));
            groups.flatten().map(Division::Groups)
        };
        match &self.cause {
            PendingCause::Load(bonds)
            | PendingCause::Blow {
                bonds: Some(bonds), ..
            } => groups(bonds),
            PendingCause::Blow { impact, .. } => divide(bodies, self.slot, impact, left, cutter),
        }
    }
}

/// A body that waits for its turn to break, unless it bears the blow.
pub(super) fn wait(bodies: &Bodies, blow: &Blow) -> Option<PendingBreak> {
    let slot = blow.slot;
    let impact = blow.impact(bodies);
    let bonds = (!blow.bonds.is_empty()).then(|| BrokenBonds {
        of: bodies.cluster(slot).map_or(0, |it| it.network.bonds.len()),
        bonds: blow.bonds.clone(),
    });
    // Whether it breaks does not depend on the number of pieces, and how it does is found when its turn comes.
    let most = bodies.max_pieces(slot).min(MIN_PIECES);
    if bonds.is_none() {
        impact::cutting(bodies, slot, &impact, most)?;
    }
    Some(PendingBreak {
        body: bodies.id(slot),
        slot,
        cause: PendingCause::Blow {
            impact,
            blow: blow.report(bodies, 1.0),
            bonds,
        },
    })
}
