//! When bodies break: on request at the start of a step, and under a blow while it is solved.

use crate::bodies::body::RigidBody;
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::contact::impulses::ContactCache;
use crate::contact::manifolds::Manifolds;
use crate::fracture::budget::FractureBudget;
use crate::fracture::impact;
use crate::fracture::impact::ImpulseSum;
use crate::fracture::inheritance::{ParentState, transfer_impulses};
use crate::fracture::pieces::{BreakPlan, PieceSet, replace};
use crate::fracture::{Bonds, BreakingImpact, CutError, CutRequest, Fractures, MIN_PIECES};
use crate::geometry::predicates::check_plane;
use crate::slice::{Impact, PieceCutter, SliceError};
use crate::solver::contact_solver::ContactSolver;
use smallvec::SmallVec;

/// Bodies that broke, in one go, and their pieces.
type Lines = Vec<(ParentState, SmallVec<[u32; 8]>)>;

/// A body that was hit with more than it bears when there was no budget for it.
#[derive(Clone, Debug)]
struct PendingBreak {
    body: BodyId,
    slot: u32,
    /// What it was hit with, in its own frame.
    impact: Impact,
    /// The same for the report; all of it acted.
    blow: BreakingImpact,
}

/// A piece, and for how long it has slept.
#[derive(Clone, Copy, Debug)]
struct Alive {
    body: BodyId,
    slot: u32,
    /// s.
    slept: f32,
}

/// What is kept from step to step, and buffers.
#[derive(Debug, Default)]
pub(super) struct FractureState {
    /// Pieces made in this step.
    made: usize,
    /// Dynamic bodies that were awake when it began.
    awake: usize,
    waiting: Vec<PendingBreak>,
    alive: Vec<Alive>,
    /// By slot.
    impacts: Vec<ImpulseSum>,
    shares: Vec<f32>,
    cutter: PieceCutter,
    /// Who broke since impulses were last handed on.
    lines: Lines,
    /// Those whose impulses were handed on last.
    handed_on: Lines,
}

impl FractureState {
    /// Bodies that wait for their turn to break.
    pub(super) fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// Forgets pieces that are no more, for whatever reason.
    fn take_stock(&mut self, bodies: &Bodies) {
        self.alive
            .retain(|piece| bodies.is_current(piece.slot, piece.body));
    }

    /// Pieces that blows may still make in this step.
    pub(super) fn left(&self, budget: &FractureBudget) -> usize {
        budget.left(self.made, self.alive.len(), self.awake)
    }
}

/// What pieces take over from the bodies that they were part of.
#[derive(Debug)]
pub(crate) struct Inherited<'f> {
    /// Multipliers of contacts.
    pub cache: &'f mut ContactCache,
    /// What they are bonded to.
    pub bonds: &'f mut Bonds,
}

/// Makes the cuts that were asked for and breaks what has waited for its turn; removes pieces whose time is over.
///
/// Pieces get slots, parents lose theirs, and the parents' multipliers and bonds go to the pieces. Results are in `fractures`.
/// `step_dt`: length of the step, s.
pub(crate) fn make_cuts(
    fractures: &mut Fractures,
    bodies: &mut Bodies,
    cache: &mut ContactCache,
    bonds: &mut Bonds,
    budget: &FractureBudget,
    step_dt: f32,
) {
    fractures.done.clear();
    fractures.refused.clear();
    fractures.expired.clear();
    fractures.state.handed_on.clear();
    fractures.state.made = 0;
    fractures.state.awake = bodies.dynamic() - bodies.asleep();
    remove_old_pieces(fractures, bodies, cache, budget, step_dt);
    fractures.state.take_stock(bodies);
    if fractures.requests.is_empty() && fractures.state.waiting.is_empty() {
        return;
    }
    for (plan, requests) in collect_requests(fractures, bodies) {
        bodies.wake(plan.slot);
        // A load that the parent stood must not break a piece that was cut off, but a blow may.
        let stands = bodies.is_overloaded[plan.slot as usize];
        let division = PieceSet::new(bodies, &plan, &mut fractures.state.cutter);
        let made = division
            .and_then(|division| fractures.replace(bodies, bonds, plan.slot, division, budget));
        match made {
            Ok(fracture) => fracture
                .pieces
                .iter()
                .for_each(|&piece| bodies.is_overloaded[piece as usize] = stands),
            Err(error) => {
                let refused = requests.into_iter().map(|r| (r, error.clone()));
                fractures.refused.extend(refused);
            }
        }
    }
    break_waiting(fractures, bodies, bonds, budget);
    bodies.resume_woken(cache);
    fractures.hand_on_impulses(bodies, cache);
}

/// Breaks the bodies that have waited longest, as far as the budget goes. What was cut in this step waits no more.
fn break_waiting(
    fractures: &mut Fractures,
    bodies: &mut Bodies,
    bonds: &mut Bonds,
    budget: &FractureBudget,
) {
    let mut waiting = std::mem::take(&mut fractures.state.waiting);
    waiting.retain(|entry| {
        let slot = entry.slot;
        if !(bodies.is_current(slot, entry.body) && bodies.is_active(slot)) {
            return false;
        }
        let left = fractures.state.left(budget);
        if left < MIN_PIECES {
            return true;
        }
        bodies.wake(slot);
        // One that makes no pieces bears it.
        let cutter = &mut fractures.state.cutter;
        if let Some(division) = divide(bodies, slot, &entry.impact, left, cutter)
            && let Ok(fracture) = fractures.replace(bodies, bonds, slot, division, budget)
        {
            fracture.waited = Some(entry.blow);
        }
        false
    });
    fractures.state.waiting = waiting;
}

/// Breaks the bodies whose solve was given up because they were hit with more than they bear.
///
/// `manifolds` hold the impulses until then. They act on the bodies that wait as far as what breaks bears them; the rest is
/// for the pieces. Results are added to `fractures`.
pub(crate) fn break_overloaded(
    fractures: &mut Fractures,
    bodies: &mut Bodies,
    manifolds: &Manifolds,
    Inherited { cache, bonds }: Inherited<'_>,
    budget: &FractureBudget,
    solver: &ContactSolver,
) {
    let state = &mut fractures.state;
    impact::sum_impulses(&mut state.impacts, bodies, manifolds);
    state.shares.clear();
    state.shares.resize(bodies.slots(), 0.0);
    state.take_stock(bodies);
    let mut left = state.left(budget);
    let mut divisions = Vec::new();
    let mut hit: Vec<_> = (0..bodies.slots() as u32)
        .filter(|&slot| solver.is_deferred(slot))
        .filter(|&slot| state.impacts[slot as usize].is_too_much(bodies, slot))
        .collect();
    hit.sort_by_key(|&slot| bodies.id(slot));
    for slot in hit {
        // If it cannot be broken now, it has to bear everything.
        bodies.is_overloaded[slot as usize] = true;
        let sum = state.impacts[slot as usize];
        if left < MIN_PIECES {
            state.waiting.extend(wait(bodies, slot, &sum));
            continue;
        }
        let impact = sum.impact(bodies, slot);
        if let Some(division) = divide(bodies, slot, &impact, left, &mut state.cutter) {
            left = left.saturating_sub(division.len());
            let withstood = sum.withstood(bodies, slot, &division);
            state.shares[slot as usize] = withstood;
            divisions.push((slot, division, sum.blow(bodies, slot, withstood)));
        }
    }
    impact::apply_shares(&state.shares, bodies, manifolds);
    for (slot, division, blow) in divisions {
        if let Ok(fracture) = fractures.replace(bodies, bonds, slot, division, budget) {
            fracture.blow = Some(blow);
        }
    }
    fractures.hand_on_impulses(bodies, cache);
}

/// After the last round: notes which bodies have got through the step although its impulses were more than they bear, and
/// lets those break later that would have, had there been a budget or a round for them.
pub(crate) fn note_loads(
    fractures: &mut Fractures,
    bodies: &mut Bodies,
    manifolds: &Manifolds,
    solver: &ContactSolver,
) {
    if !bodies.any_fracturable() {
        return;
    }
    let state = &mut fractures.state;
    impact::sum_impulses(&mut state.impacts, bodies, manifolds);
    for (slot, blow) in solver.overloaded() {
        let sum = state.impacts[slot as usize].with_energy(blow.energy);
        state.waiting.extend(wait(bodies, slot, &sum));
    }
    for (slot, sum) in (0..).zip(&state.impacts) {
        if let Some(fracturable) = bodies.fracturable(slot) {
            bodies.is_overloaded[slot as usize] = sum.impulse() > fracturable.strength;
        }
    }
    // Another blow does not break them twice.
    for entry in &state.waiting {
        if bodies.is_current(entry.slot, entry.body) {
            bodies.is_overloaded[entry.slot as usize] = true;
        }
    }
}

/// What a blow makes of the body in `slot` where `left` pieces may be made; nothing if it bears it.
fn divide(
    bodies: &Bodies,
    slot: u32,
    impact: &Impact,
    left: usize,
    cutter: &mut PieceCutter,
) -> Option<PieceSet> {
    let most = bodies.max_pieces(slot).min(left);
    let plan = BreakPlan {
        slot,
        blow: Some(impact::cutting(bodies, slot, impact, most)?),
        cuts: SmallVec::new(),
        most,
    };
    PieceSet::new(bodies, &plan, cutter).ok()
}

/// A body that waits for its turn to break, unless it bears the blow.
fn wait(bodies: &Bodies, slot: u32, sum: &ImpulseSum) -> Option<PendingBreak> {
    let impact = sum.impact(bodies, slot);
    // Whether it breaks does not depend on the number of pieces, and how it does is found when its turn comes.
    let most = bodies.max_pieces(slot).min(MIN_PIECES);
    impact::cutting(bodies, slot, &impact, most)?;
    Some(PendingBreak {
        body: bodies.id(slot),
        slot,
        impact,
        blow: sum.blow(bodies, slot, 1.0),
    })
}

impl Fractures {
    /// Replaces a body by its pieces and takes note of it.
    fn replace(
        &mut self,
        bodies: &mut Bodies,
        bonds: &mut Bonds,
        slot: u32,
        division: PieceSet,
        budget: &FractureBudget,
    ) -> Result<&mut crate::fracture::Fracture, CutError> {
        let line = ParentState::of(bodies, slot);
        let drive = bodies.drive(slot);
        let fracture = replace(bodies, slot, division, budget)?;
        bonds.inherit(bodies, &line, &fracture.pieces);
        bodies.drive_pieces(drive, &fracture.pieces);
        let state = &mut self.state;
        state.lines.push((line, fracture.pieces.clone()));
        state.made += fracture.pieces.len();
        let pieces = fracture.pieces.iter().zip(&fracture.ids);
        state.alive.extend(pieces.map(|(&slot, &body)| Alive {
            body,
            slot,
            slept: 0.0,
        }));
        self.done.push(fracture);
        Ok(self.done.last_mut().expect("just pushed"))
    }

    /// Hands the impulses of all that broke on to its pieces.
    fn hand_on_impulses(&mut self, bodies: &Bodies, cache: &mut ContactCache) {
        self.state.handed_on = std::mem::take(&mut self.state.lines);
        transfer_impulses(&self.state.handed_on, bodies, cache);
    }

    /// Bodies that broke, and their pieces, since impulses were last handed on.
    pub(super) fn handed_on(&self) -> &[(ParentState, SmallVec<[u32; 8]>)] {
        &self.state.handed_on
    }
}

/// Sorts out requests that cannot be met; several on one body become one list of planes. By id of the body.
fn collect_requests(
    fractures: &mut Fractures,
    bodies: &Bodies,
) -> Vec<(BreakPlan, SmallVec<[CutRequest; 2]>)> {
    let mut plans: Vec<(BreakPlan, SmallVec<[CutRequest; 2]>)> = Vec::new();
    for request in fractures.requests.drain(..) {
        if let Err(error) = check_request(&request, bodies) {
            fractures.refused.push((request, error));
            continue;
        }
        let index = plans.iter().position(|(p, _)| p.slot == request.slot);
        let index = index.unwrap_or_else(|| {
            let plan = BreakPlan {
                slot: request.slot,
                blow: None,
                cuts: SmallVec::new(),
                most: usize::MAX,
            };
            plans.push((plan, SmallVec::new()));
            plans.len() - 1
        });
        plans[index].0.cuts.push(request.plane);
        plans[index].1.push(request);
    }
    plans.sort_by_key(|(plan, _)| bodies.id(plan.slot));
    plans
}

fn check_request(request: &CutRequest, bodies: &Bodies) -> Result<(), CutError> {
    if !bodies.is_current(request.slot, request.body) {
        return Err(CutError::NoBody);
    }
    if bodies.kind(request.slot) != RigidBody::Dynamic {
        return Err(CutError::NotDynamic);
    }
    if !bodies.is_active(request.slot) {
        return Err(CutError::Frozen);
    }
    if bodies.has_mass_override(request.slot) {
        return Err(CutError::MassOverride);
    }
    check_plane(&request.plane).map_err(SliceError::from)?;
    Ok(())
}

/// Removes pieces that have slept for longer than the budget allows.
fn remove_old_pieces(
    fractures: &mut Fractures,
    bodies: &mut Bodies,
    cache: &mut ContactCache,
    budget: &FractureBudget,
    step_dt: f32,
) {
    if budget.lifetime.is_infinite() {
        return;
    }
    let expired = &mut fractures.expired;
    fractures.state.alive.retain_mut(|piece| {
        let is_there = bodies.is_current(piece.slot, piece.body);
        let is_asleep = is_there && bodies.is_asleep(piece.slot);
        piece.slept = if is_asleep {
            piece.slept + step_dt
        } else {
            0.0
        };
        let is_old = piece.slept > budget.lifetime;
        if is_old {
            expired.push((piece.slot, piece.body));
        }
        is_there && !is_old
    });
    for &(slot, _) in expired.iter() {
        bodies.remove(slot);
    }
    if !expired.is_empty() {
        expired.sort_unstable_by_key(|&(_, id)| id);
        cache.remove_bodies(|id| expired.binary_search_by_key(&id, |&(_, id)| id).is_ok());
    }
}
