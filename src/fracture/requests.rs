//! Cuts that were asked for, sorted out.

use crate::bodies::store::Bodies;
use crate::fracture::pieces::BreakPlan;
use crate::fracture::{CutError, CutRequest};
use crate::geometry::predicates::check_plane;
use crate::slice::SliceError;
use smallvec::SmallVec;

/// Sorts out requests that cannot be met; several on one body become one list of planes. By id of the body.
pub(super) fn collect_requests(
    asked: &mut Vec<CutRequest>,
    refused: &mut Vec<(CutRequest, CutError)>,
    bodies: &Bodies,
) -> Vec<(BreakPlan, SmallVec<[CutRequest; 2]>)> {
    let mut plans: Vec<(BreakPlan, SmallVec<[CutRequest; 2]>)> = Vec::new();
    for request in asked.drain(..) {
        if let Err(error) = check_request(&request, bodies) {
            refused.push((request, error));
            continue;
        }
        let index = plans.iter().position(|(p, _)| p.slot == request.slot);
        let index = index.unwrap_or_else(|| {
            let plan = BreakPlan {
                slot: request.slot,
                blow: None,
                cuts: SmallVec::new(),
                most: usize::MAX,
                struck: None,
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
    if bodies.convex(request.slot).is_none() && bodies.compound(request.slot).is_none() {
        return Err(CutError::NotConvex);
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
