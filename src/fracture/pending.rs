//! Bodies that wait for their turn to break, and what becomes of one whose turn it is.

use crate::bodies::breaking::Blow;
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::fracture::budget::FractureBudget;
use crate::fracture::cluster::{BrokenBonds, Groups};
use crate::fracture::gradual::GradualCut;
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

/// How far a body is whose turn it is.
#[derive(Debug)]
pub(super) enum Progress {
    /// It comes apart.
    Breaks(Box<Division>),
    /// It has to wait for another step.
    Waits,
    /// It makes no pieces, and stays as it is.
    Bears,
}

impl Progress {
    /// Of a body that is divided now; nothing if it bears it.
    pub(super) fn of(division: Option<Division>) -> Self {
        division.map_or(Self::Bears, |division| Self::Breaks(Box::new(division)))
    }
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
    /// It was hit, and its mesh is large: what has been cut of it until now.
    Gradual(Box<GradualCut>),
    /// It is several groups of parts, which came off together because there was no budget for all; of a blow, if that broke the bonds. And
    /// what broke of it since.
    Rest(Option<BreakingImpact>, Option<BrokenBonds>),
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
    /// What comes off of a cluster when bonds break, in at most `left` pieces; nothing if nothing does.
    pub(super) fn of_groups(
        bodies: &Bodies,
        slot: u32,
        broken: &[u32],
        left: usize,
    ) -> Option<Self> {
        let groups = Groups::of(bodies, slot, broken)?;
        Some(Self::Groups(groups.limited(left)))
    }

    /// Number of pieces.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Cut(pieces) => pieces.len(),
            Self::Groups(groups) => groups.pieces.len(),
        }
    }

    /// Whether the last piece is several, which come apart later.
    pub(super) fn is_joined(&self) -> bool {
        matches!(self, Self::Groups(groups) if groups.is_joined)
    }
}

/// Triangles of the mesh that a blow to the body in `slot` cuts.
pub(super) fn cut_triangles(bodies: &Bodies, slot: u32, impact: &Impact) -> usize {
    let shape = match bodies.compound(slot) {
        Some(compound) => {
            let struck = impact::struck_part(compound, impact.point);
            Some(&compound.parts()[struck].shape)
        }
        None => bodies.convex(slot),
    };
    let mesh = shape.and_then(|shape| shape.visual());
    mesh.map_or(0, |mesh| mesh.triangles().len())
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
    /// Triangles that are gone through when it breaks.
    pub(super) fn triangles(&self, bodies: &Bodies) -> usize {
        match &self.cause {
            PendingCause::Blow {
                bonds: None,
                impact,
                ..
            } => cut_triangles(bodies, self.slot, impact),
            _ => 0,
        }
    }

    /// What becomes of the body now; nothing if it bears it.
    pub(super) fn divide(
        &self,
        bodies: &Bodies,
        left: usize,
        cutter: &mut PieceCutter,
    ) -> Option<Division> {
        let groups = |broken: &[u32]| Division::of_groups(bodies, self.slot, broken, left);
        match &self.cause {
            PendingCause::Rest(_, Some(since)) if since.is_of(bodies, self.slot) => {
                groups(&since.bonds)
            }
            PendingCause::Rest(..) => groups(&[]),
            PendingCause::Load(bonds)
            | PendingCause::Blow {
                bonds: Some(bonds), ..
            } if bonds.is_of(bodies, self.slot) => groups(&bonds.bonds),
            PendingCause::Load(_) | PendingCause::Blow { bonds: Some(_), .. } => None,
            PendingCause::Blow { impact, .. } => divide(bodies, self.slot, impact, left, cutter),
            PendingCause::Gradual(_) => None,
        }
    }

    /// Adds bonds to those that are to break when it is the body's turn.
    fn add_bonds(&mut self, more: BrokenBonds) {
        match &mut self.cause {
            PendingCause::Load(known)
            | PendingCause::Blow {
                bonds: Some(known), ..
            }
            | PendingCause::Rest(_, Some(known)) => known.add(&more),
            PendingCause::Rest(_, since) => *since = Some(more),
            // What it is cut into is told by the blow.
            PendingCause::Blow { bonds: None, .. } | PendingCause::Gradual(_) => {}
        }
    }

    /// Whether its mesh has more triangles than a step may cut, so that it is cut over several.
    pub(super) fn is_gradual(&self, bodies: &Bodies, budget: &FractureBudget) -> bool {
        matches!(self.cause, PendingCause::Gradual(_))
            || self.triangles(bodies) > budget.triangles_per_step
    }

    /// Does a step's work of a body whose mesh is cut over several, which is to make at most `left` pieces.
    pub(super) fn work(
        &mut self,
        bodies: &Bodies,
        (left, budget): (usize, &FractureBudget),
        cutter: &mut PieceCutter,
    ) -> Progress {
        if let PendingCause::Blow {
            bonds: None,
            impact,
            blow,
        } = &self.cause
        {
            match GradualCut::begin(bodies, self.slot, (impact, *blow), left) {
                Some(cut) => self.cause = PendingCause::Gradual(Box::new(cut)),
                None => return Progress::of(self.divide(bodies, left, cutter)),
            }
        }
        match &mut self.cause {
            PendingCause::Gradual(cut) => {
                let is_done = cut.work(budget.triangles_per_step);
                cutter.add_gone_through(cut.take_gone_through());
                if is_done && cut.len() <= left.max(MIN_PIECES) {
                    Progress::of(cut.finish(bodies).map(Division::Cut))
                } else {
                    Progress::Waits
                }
            }
            _ => Progress::Bears,
        }
    }

    /// The blow that it was hit with, if it was one.
    pub(super) fn blow(&self) -> Option<BreakingImpact> {
        match &self.cause {
            PendingCause::Blow { blow, .. } => Some(*blow),
            PendingCause::Gradual(cut) => Some(cut.blow),
            PendingCause::Load(_) => None,
            PendingCause::Rest(blow, _) => *blow,
        }
    }
}

/// Lets bodies wait that came as several groups of parts, unless they do already.
pub(super) fn await_divided(waiting: &mut Vec<PendingBreak>, bodies: &mut Bodies) {
    let mut divided = std::mem::take(&mut bodies.divided_clusters);
    for (slot, body) in divided.drain(..) {
        let waits = waiting.iter().any(|entry| entry.body == body);
        if bodies.is_current(slot, body) && !waits {
            let cause = PendingCause::Rest(None, None);
            waiting.push(PendingBreak { body, slot, cause });
        }
    }
    bodies.divided_clusters = divided;
}

/// Breaks bonds of a body: at once if nothing comes off, else when its turn comes, with what it waits for already.
pub(super) fn break_later(
    waiting: &mut Vec<PendingBreak>,
    bodies: &mut Bodies,
    slot: u32,
    bonds: BrokenBonds,
) {
    let body = bodies.id(slot);
    if bonds.bonds.is_empty() {
        return;
    }
    if let Some(entry) = waiting.iter_mut().find(|entry| entry.body == body) {
        return entry.add_bonds(bonds);
    }
    if Groups::of(bodies, slot, &bonds.bonds).is_none() {
        return bodies.crack(slot, &bonds.bonds);
    }
    let cause = PendingCause::Load(bonds);
    waiting.push(PendingBreak { body, slot, cause });
}

/// A body that waits for its turn to break, unless it bears the blow.
pub(super) fn wait(bodies: &Bodies, blow: &Blow) -> Option<PendingBreak> {
    let bonds = (!blow.bonds.is_empty()).then(|| BrokenBonds {
        of: (bodies.cluster(blow.slot)).map_or(0, |it| it.network.bonds.len()),
        bonds: blow.bonds.clone(),
    });
    let (impact, report) = (blow.impact(bodies), blow.report(bodies, 1.0));
    wait_for(bodies, blow.slot, (impact, report), bonds)
}

/// The same of a blow to the body in `slot` with its report, which says that all of it acted, and of the bonds within the body that it breaks.
pub(super) fn wait_for(
    bodies: &Bodies,
    slot: u32,
    (impact, blow): (Impact, BreakingImpact),
    bonds: Option<BrokenBonds>,
) -> Option<PendingBreak> {
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
            blow,
            bonds,
        },
    })
}
