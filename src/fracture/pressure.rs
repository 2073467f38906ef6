//! Explosions beside bodies that are no clusters: the pressure on what they turn to it is a blow, which breaks them as another one would.
//!
//! The body bears a share of the blow before it breaks, and its pieces share the rest.

use crate::bodies::blast_shares::{Reached, shares};
use crate::bodies::body::RigidBody;
use crate::bodies::explosion::Explosion;
use crate::bodies::store::Bodies;
use crate::fracture::budget::FractureBudget;
use crate::fracture::pending::{Division, cut_triangles, divide, wait_for};
use crate::fracture::{Bonds, BreakingImpact, Fractures, MIN_PIECES, impact};
use crate::math::rotate;
use crate::slice::Impact;
use glam::Vec3;

impl Fractures {
    /// Lets an explosion act on a body that is no cluster.
    pub(super) fn press(
        &mut self,
        bodies: &mut Bodies,
        slot: u32,
        (bonds, budget): (&mut Bonds, &FractureBudget),
        explosion: &Explosion,
    ) {
        let limit = bodies.limit(slot);
        let blow = limit.and_then(|limit| {
            let blow = explosion.blow_to(bodies, slot)?;
            bodies.add_blow(slot, blow.0);
            limit.is_body_at_risk(&blow.0).then_some(blow)
        });
        let Some((load, [point, direction])) = blow else {
            return push(bodies, slot, explosion, 1.0);
        };
        let to_body = bodies.pose(slot);
        let impact = Impact {
            point: to_body.inverse_transform_point(point),
            normal: rotate(to_body.rotation.inverse(), direction),
            impulse: load.impulse,
            energy: load.energy,
        };
        let report = |withstood| BreakingImpact {
            impulse: load.impulse,
            energy: load.energy,
            withstood,
            by: None,
            point,
            direction,
        };
        let left = self.state.left(budget);
        let triangles = cut_triangles(bodies, slot, &impact);
        if left < MIN_PIECES || !budget.may_cut(self.state.cut, triangles) {
            let is_known = (self.state.waiting.iter()).any(|it| it.body == bodies.id(slot));
            let turn = wait_for(bodies, slot, (impact, report(1.0)), None);
            self.state.waiting.extend(turn.filter(|_| !is_known));
            // All of it acts on what waits.
            return push(bodies, slot, explosion, 1.0);
        }
        let division = divide(bodies, slot, &impact, left, &mut self.state.cutter);
        let Some(Division::Cut(pieces)) = division else {
            return push(bodies, slot, explosion, 1.0);
        };
        self.state.cut += triangles;
        let withstood = impact::withstood(bodies, slot, load, &pieces);
        bodies.wake(slot);
        push(bodies, slot, explosion, withstood);
        match self.replace(bodies, bonds, slot, Division::Cut(pieces), budget) {
            Ok(fracture) => {
                fracture.blow = Some(report(withstood));
                let pieces = fracture.pieces.clone();
                share_out(bodies, &pieces, explosion, (1.0 - withstood) * load.impulse);
            }
            Err(_) => push(bodies, slot, explosion, 1.0 - withstood),
        }
    }
}

/// Pushes a body with a share of what an explosion gives it.
fn push(bodies: &mut Bodies, slot: u32, explosion: &Explosion, share: f32) {
    if bodies.kind(slot) == RigidBody::Dynamic
        && let Some(given) = explosion.push_on(bodies, slot)
    {
        bodies.push_by_blast(slot, given.map(|v| share * v));
    }
}

/// Pushes pieces away from an explosion with an impulse (N s) together, if all that stay where they are had their share as well.
fn share_out(bodies: &mut Bodies, pieces: &[u32], explosion: &Explosion, impulse: f32) {
    let reached = pieces.iter().map(|&it| Reached {
        weight: explosion.weight_on(bodies, it).into(),
        mass: bodies.mass(it).mass.into(),
    });
    let given = shares(&reached.collect::<Vec<_>>());
    for (&piece, share) in pieces.iter().zip(given) {
        if bodies.kind(piece) == RigidBody::Dynamic {
            let away = bodies.center_of_mass(piece) - explosion.center;
            let given = share as f32 * impulse.copysign(explosion.impulse);
            bodies.push_by_blast(piece, [given * away.normalize_or(Vec3::Y), Vec3::ZERO]);
        }
    }
}
