//! Surfaces that run along themselves, such as a conveyor belt's: friction brings what touches one to its velocity instead of to that of
//! the body. What it runs into or over, overlap and rebounds are those of the body.
//!
//! The contact is told as one that holds nothing, with a velocity along the tangents that its points should have; see
//! [`bond`](crate::solver::wide::bond). Nothing is looked at where no surface ever ran.

use crate::bodies::store::Bodies;
use crate::contact::manifolds::Manifolds;
use crate::solver::graph::indices::ManifoldIndex;
use crate::solver::wide::bond::{BondedManifold, is_bonded};

/// Adds the contacts with such surfaces to those that are bonded, of which the list is sorted by manifolds.
pub(super) fn attach(bodies: &Bodies, manifolds: &Manifolds, bonded: &mut Vec<BondedManifold>) {
    if !bodies.has_running_surfaces() {
        return;
    }
    let count = bonded.len();
    for (index, head) in manifolds.heads().iter().enumerate() {
        let [a, b] = [head.a, head.b].map(|slot| bodies.surface_velocity(slot));
        let manifold = ManifoldIndex(index as u32);
        if a != b && !is_bonded(&bonded[..count], manifold) {
            bonded.push(BondedManifold {
                manifold,
                bodies: (bodies.id(head.a), bodies.id(head.b)),
                // Both surfaces are as fast where B is as much slower than A.
                slip: a - b,
                ..BondedManifold::default()
            });
        }
    }
    bonded.sort_unstable_by_key(|bond| bond.manifold);
}
