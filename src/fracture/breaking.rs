//! When bodies break: on request at the start of a step, and under a blow while it is solved.

use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::contact::impulses::ContactCache;
use crate::contact::manifolds::Manifolds;
use crate::fracture::budget::FractureBudget;
use crate::fracture::cluster::{BrokenBonds, Groups, apply_cracks, replace_groups};
use crate::fracture::cluster_loads::{
    LOOK_INTERVAL, StepLoads, follow_loads, judge_loads, work_out_loads,
};
use crate::fracture::debris::Debris;
use crate::fracture::impact;
use crate::fracture::inheritance::{ParentState, note_heirs, transfer_impulses};
use crate::fracture::pending::{
    Division, PendingBreak, PendingCause, Progress, await_divided, break_later, cut_triangles,
    divide, wait,
};
use crate::fracture::pieces::{PieceSet, replace};
use crate::fracture::requests::collect_requests;
use crate::fracture::shares::apply_shares;
use crate::fracture::{Bonds, BreakingImpact, CutError, Fractures, MIN_PIECES};
use crate::slice::PieceCutter;
use crate::solver::contact_solver::ContactSolver;
use smallvec::SmallVec;

/// How much harder than a blow that nothing came of another one must be to be tried, as long as what is borne stays above the
/// strength: a press on what cannot be divided any more would try it anew in every step.
const RETRIED: f32 = 2.0;

/// Bodies that broke, in one go, and their pieces.
type Lines = Vec<(ParentState, SmallVec<[u32; 8]>)>;

/// What is kept from step to step, and buffers.
#[derive(Clone, Debug, Default)]
pub(super) struct FractureState {
    /// Pieces made in this step.
    made: usize,
    /// Triangles of meshes that blows have cut in this step.
    pub(super) cut: usize,
    /// Dynamic bodies that were awake when it began.
    awake: usize,
    pub(super) waiting: Vec<PendingBreak>,
    /// Time since loads of clusters were last looked at, s.
    load_time: f32,
    debris: Debris,
    /// Bodies that must not break by some blows, see [`Bodies::borne_impulse`].
    spared: Vec<(u32, BodyId)>,
    pub(super) cutter: PieceCutter,
    /// Who broke since impulses were last handed on.
    lines: Lines,
    /// Those whose impulses were handed on last.
    handed_on: Lines,
}

impl FractureState {
    /// Triangles of meshes that planes were held against since this was asked last.
    pub(super) fn take_gone_through(&mut self) -> usize {
        self.cutter.take_gone_through()
    }

    /// Bodies that wait for their turn to break.
    pub(super) fn waiting(&self) -> usize {
        self.waiting.len()
    }

    /// Lets a body bear blows up to `impulse`, N s.
    fn spare(&mut self, bodies: &mut Bodies, slot: u32, impulse: f32) {
        let body = (slot, bodies.id(slot));
        if !self.spared.contains(&body) {
            self.spared.push(body);
        }
        bodies.borne_impulse[slot as usize] = impulse;
    }

    /// Breaks bonds of a body: at once if nothing comes off, else when its turn comes, with what it waits for already.
    pub(super) fn break_later(&mut self, bodies: &mut Bodies, slot: u32, bonds: BrokenBonds) {
        break_later(&mut self.waiting, bodies, slot, bonds);
    }

    /// Pieces that blows may still make in this step.
    pub(super) fn left(&self, budget: &FractureBudget) -> usize {
        budget.left(self.made, self.debris.len(), self.awake)
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

/// Makes the cuts that were asked for, breaks what has waited for its turn, and lets explosions act; removes pieces whose time is over.
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
    fractures.fading.clear();
    fractures.state.handed_on.clear();
    fractures.state.made = 0;
    fractures.state.cut = 0;
    bodies.free_retired();
    bodies.cracked.clear();
    bodies.begin_wearing();
    fractures.state.awake = bodies.dynamic() - bodies.asleep();
    let Fractures {
        expired,
        fading,
        removed,
        state,
        ..
    } = &mut *fractures;
    (state.debris).pass(bodies, &budget.debris, step_dt, (expired, fading));
    removed.remove(expired, bodies, cache);
    fractures.state.debris.take_stock(bodies);
    await_divided(&mut fractures.state.waiting, bodies);
    let is_quiet = fractures.requests.is_empty() && fractures.state.waiting.is_empty();
    let is_pushed = !(bodies.pushes.explosions.is_empty() && bodies.pushes.impulses.is_empty());
    if is_quiet && !is_pushed {
        return;
    }
    for (plan, requests) in
        collect_requests(&mut fractures.requests, &mut fractures.refused, bodies)
    {
        bodies.wake(plan.slot);
        let division = PieceSet::new(bodies, &plan, &mut fractures.state.cutter);
        let division = division.map(Division::Cut);
        let made = division
            .and_then(|division| fractures.replace(bodies, bonds, plan.slot, division, budget));
        if let Err(error) = made {
            let refused = requests.into_iter().map(|r| (r, error.clone()));
            fractures.refused.extend(refused);
        }
    }
    break_waiting(fractures, bodies, bonds, budget);
    fractures.push_at_points(bodies, bonds, budget);
    fractures.explode(bodies, bonds, budget);
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
    waiting.retain_mut(|entry| {
        let slot = entry.slot;
        if !bodies.is_current(slot, entry.body) {
            return false;
        }
        if !bodies.is_active(slot) {
            // Who is left out for a while breaks when it is back.
            return true;
        }
        let left = fractures.state.left(budget);
        let is_gradual = entry.is_gradual(bodies, budget);
        let triangles = match is_gradual {
            true => budget.triangles_per_step.max(1),
            false => entry.triangles(bodies),
        };
        let is_its_turn = budget.may_cut(fractures.state.cut, triangles)
            || is_gradual && fractures.state.cut == 0;
        if left < MIN_PIECES || !is_its_turn {
            return true;
        }
        fractures.state.cut += triangles;
        bodies.wake(slot);
        let cutter = &mut fractures.state.cutter;
        let progress = match is_gradual {
            true => entry.work(bodies, (left, budget), cutter),
            false => Progress::of(entry.divide(bodies, left, cutter)),
        };
        let division = match progress {
            Progress::Breaks(division) => *division,
            Progress::Waits => return true,
            Progress::Bears => return false,
        };
        let is_joined = division.is_joined();
        if let Ok(fracture) = fractures.replace(bodies, bonds, slot, division, budget) {
            let blow = entry.blow();
            (fracture.waited, fracture.is_load) = (blow, blow.is_none());
            if is_joined {
                fractures.await_rest(bodies, blow);
            }
        }
        false
    });
    waiting.append(&mut fractures.state.waiting);
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
    state.debris.take_stock(bodies);
    let mut left = state.left(budget);
    let (mut divisions, mut shares) = (Vec::new(), Vec::new());
    for blow in impact::hardest_blows(bodies, solver) {
        // If it cannot be broken now, it has to bear everything.
        state.spare(bodies, blow.slot, f32::INFINITY);
        let impact = blow.bonds.is_empty().then(|| blow.impact(bodies));
        let cut = impact.map_or(0, |impact| cut_triangles(bodies, blow.slot, &impact));
        if left < MIN_PIECES || !budget.may_cut(state.cut, cut) {
            state.waiting.extend(wait(bodies, blow));
            continue;
        }
        state.cut += cut;
        let division = match impact {
            Some(impact) => divide(bodies, blow.slot, &impact, left, &mut state.cutter),
            None => {
                let broken = impact::wear_others(bodies, blow);
                Division::of_groups(bodies, blow.slot, &broken, left)
            }
        };
        let Some(division) = division else {
            state.spare(bodies, blow.slot, RETRIED * blow.load.impulse);
            continue;
        };
        left = left.saturating_sub(division.len());
        let withstood = match &division {
            Division::Cut(pieces) => blow.withstood(bodies, pieces),
            Division::Groups(_) => blow.withstood_by_bonds(),
        };
        shares.extend(blow.shares(withstood));
        divisions.push((division, blow.report(bodies, withstood), blow));
    }
    let acted = apply_shares(shares, bodies, manifolds);
    for (division, mut report, blow) in divisions {
        report.withstood = blow.acted(report.withstood, &acted);
        let is_joined = division.is_joined();
        match fractures.replace(bodies, bonds, blow.slot, division, budget) {
            Ok(fracture) => {
                fracture.blow = Some(report);
                if is_joined {
                    fractures.await_rest(bodies, Some(report));
                }
            }
            Err(_) => bodies.borne_impulse[blow.slot as usize] = RETRIED * blow.load.impulse,
        }
    }
    fractures.hand_on_impulses(bodies, cache);
}

/// After the last round, of the batches from a number on: lets those break later that would have, had there been a budget or a round.
pub(crate) fn note_blows(
    fractures: &mut Fractures,
    bodies: &mut Bodies,
    solver: &ContactSolver,
    first_batch: usize,
) {
    if !bodies.wearing.is_empty() {
        bodies.wear_out(solver.borne_loads(first_batch));
    }
    let fading = &mut fractures.fading;
    fading.retain(|piece| bodies.is_current(piece.slot, piece.body));
    let state = &mut fractures.state;
    let is_waiting = |body: BodyId| state.waiting.iter().any(|entry| entry.body == body);
    for (slot, bonds) in apply_cracks(bodies, solver, first_batch, is_waiting) {
        state.break_later(bodies, slot, bonds);
    }
    for blow in solver.overloaded(first_batch) {
        match wait(bodies, blow) {
            Some(pending) => {
                state.waiting.push(pending);
                state.spare(bodies, blow.slot, f32::INFINITY);
            }
            None => state.spare(bodies, blow.slot, RETRIED * blow.load.impulse),
        }
    }
}

/// At the end of a step: bonds within bodies that bear too much for too long break; what comes off does so at the start of the next step.
pub(crate) fn break_under_loads(fractures: &mut Fractures, bodies: &mut Bodies, step: &StepLoads) {
    if bodies.any_cluster() {
        look_at_loads(fractures, bodies, step);
    }
    bodies.pushes.forces.clear();
}

fn look_at_loads(fractures: &mut Fractures, bodies: &mut Bodies, step: &StepLoads) {
    // Loads are means over a longer time.
    let elapsed = fractures.state.load_time + step.step_dt;
    fractures.state.load_time = elapsed;
    if elapsed < LOOK_INTERVAL {
        follow_loads(bodies, step);
        return work_out_loads(bodies);
    }
    fractures.state.load_time = 0.0;
    for (slot, bonds) in judge_loads(bodies, step, elapsed) {
        fractures.state.break_later(bodies, slot, bonds);
    }
}

/// At the end of a step: those that bore a blow which nothing came of are asked again by the next one.
pub(crate) fn end_loads(fractures: &mut Fractures, bodies: &mut Bodies, solver: &ContactSolver) {
    let state = &mut fractures.state;
    if state.spared.is_empty() {
        return;
    }
    let waiting = &state.waiting;
    state.spared.retain(|&(slot, id)| {
        if !bodies.is_current(slot, id) {
            return false;
        }
        if waiting.iter().any(|entry| entry.body == id) {
            return true;
        }
        let loads = solver.borne_loads(0).filter(|&(hit, _)| hit == slot);
        let most = loads.map(|(_, load)| load.impulse).fold(0.0, f32::max);
        if most > bodies.strength(slot) && bodies.borne_impulse[slot as usize].is_finite() {
            return true;
        }
        bodies.borne_impulse[slot as usize] = 0.0;
        false
    });
}

impl Fractures {
    /// Replaces a body by its pieces and takes note of it.
    pub(super) fn replace(
        &mut self,
        bodies: &mut Bodies,
        bonds: &mut Bonds,
        slot: u32,
        division: Division,
        budget: &FractureBudget,
    ) -> Result<&mut crate::fracture::Fracture, CutError> {
        let line = ParentState::of(bodies, slot);
        let (drive, fatigue) = (bodies.drive(slot), bodies.fatigue(slot).copied());
        let fracture = match division {
            Division::Cut(pieces) => replace(bodies, slot, pieces, budget)?,
            Division::Groups(groups) => replace_groups(bodies, slot, groups, budget)?,
        };
        let mut heirs = fracture.pieces.clone();
        heirs.extend(fracture.goes_on.then_some(slot));
        bonds.inherit(bodies, &line, &heirs);
        bodies.drive_pieces(drive, &fracture.pieces);
        if let Some(fatigue) = fatigue {
            bodies.wear_pieces(fatigue, &fracture.pieces);
        }
        let state = &mut self.state;
        note_heirs(&mut state.lines, (line, slot), heirs);
        state.made += fracture.pieces.len();
        state.debris.add(bodies, &fracture.pieces);
        self.done.push(fracture);
        Ok(self.done.last_mut().expect("just pushed"))
    }

    /// Lets the last piece of what broke last, which came off as one for want of budget, wait until it comes apart. Of a blow, if that
    /// broke its bonds.
    pub(super) fn await_rest(&mut self, bodies: &Bodies, blow: Option<BreakingImpact>) {
        let last = self.done.last().and_then(|fracture| fracture.pieces.last());
        let joined = last.filter(|&&slot| Groups::of(bodies, slot, &[]).is_some());
        self.state.waiting.extend(joined.map(|&slot| PendingBreak {
            body: bodies.id(slot),
            slot,
            cause: PendingCause::Rest(blow, None),
        }));
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
