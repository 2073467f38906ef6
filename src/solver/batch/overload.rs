//! Bodies that break while a batch is being solved.
//!
//! What breaks a body is what comes above the load that it bears: of the impulse of each manifold what the same contact bore in the
//! last step is taken away, as far as its bodies rest on each other. And what breaks a body is a blow: where nothing in an island
//! approaches anything, loads may shift or grow, but nobody is hit. So a load at rest breaks nothing, however long the step is in
//! which its impulses are summed up. Bodies that bear each other may still settle, as fast as gravity moves them in a step.

use crate::bodies::breaking::{Blow, BreakingLimit, ImpactLoad, RESTING_SPEED, Rest};
use crate::bodies::store::Bodies;
use crate::contact::manifolds::{ManifoldRef, Manifolds};
use crate::contact::point::ContactPoint;
use crate::solver::batch::Batch;
use crate::solver::wide::block::vector;
use glam::Vec3;

impl Batch {
    /// Forgets what bodies were hit with: that is taken back.
    pub(crate) fn forget_blows(&mut self) {
        self.impacts.overloaded.clear();
        self.impacts.cracks.clear();
        self.impacts.strains.clear();
        self.impacts.limits.clear();
    }

    /// Lists those of its bodies that may break, and what its contacts bear.
    pub(crate) fn load_limits(&mut self, bodies: &Bodies, manifolds: &Manifolds) {
        if !bodies.any_fracturable() {
            return;
        }
        for (body, &slot) in (0..).zip(&self.layout.slots) {
            if let Some(limit) = bodies.limit(slot) {
                self.impacts.limits.push(BreakingLimit { body, ..limit });
            }
        }
        if self.impacts.limits.is_empty() {
            return;
        }
        self.impacts.start.clear();
        self.impacts
            .start
            .extend_from_slice(&self.bodies.velocities);
        let settling = self.settings.gravity.length() * self.settings.step_dt();
        let places = self.layout.places.iter();
        let rests =
            places.map(|(index, _)| rest_of(&manifolds.at(index.index()), bodies, settling));
        self.impacts.rests.clear();
        self.impacts.rests.extend(rests);
    }

    /// Notes the bodies that are overloaded by the impulses of the step until now; whether there are any.
    pub(crate) fn find_overloaded(&mut self, manifolds: &Manifolds, bodies: &Bodies) -> bool {
        self.impacts.overloaded.clear();
        if self.impacts.limits.is_empty() {
            return false;
        }
        self.sum_loads();
        let mut overloaded = Vec::new();
        for index in 0..self.impacts.limits.len() {
            let limit = self.impacts.limits[index];
            let load = self.impacts.loads[limit.body as usize];
            if !limit.is_exceeded_by(&load) {
                continue;
            }
            // What is held by bonds breaks along these first.
            let along_bonds = limit
                .is_bond_at_risk(load.energy)
                .then(|| self.judge_bonds(index, load, manifolds, bodies))
                .flatten();
            let whole = || self.blow_to(limit.body, load, manifolds);
            let blow = along_bonds.or_else(|| limit.is_body_at_risk(&load).then(whole));
            overloaded.extend(blow);
        }
        self.impacts.overloaded = overloaded;
        !self.impacts.overloaded.is_empty()
    }

    /// Sums up what each body was hit with.
    fn sum_loads(&mut self) {
        let mut loads = std::mem::take(&mut self.impacts.loads);
        loads.clear();
        loads.resize(self.bodies.velocities.len(), ImpactLoad::default());
        for member in &self.layout.members {
            let mut is_struck = false;
            for at in member.places.clone() {
                let (load, is_hit) = self.load_of(at);
                is_struck |= is_hit;
                for body in self.layout.pairs[at] {
                    loads[body.index()].add(load);
                }
            }
            if !is_struck {
                loads[member.bodies.clone()].fill(ImpactLoad::default());
            }
        }
        self.impacts.loads = loads;
    }

    /// What the manifold at a place gave its bodies, and whether they came to it.
    fn load_of(&self, at: usize) -> (ImpactLoad, bool) {
        let (mut load, mut is_hit) = (ImpactLoad::default(), false);
        let rest = self.impacts.rests[at];
        let place = self.layout.places[at].1;
        let (block, lane) = (
            &self.contacts.blocks[place.block as usize],
            place.lane as usize,
        );
        let normal = vector(&block.normal, lane);
        let pair = self.layout.pairs[at];
        let start = pair.map(|body| &self.impacts.start[body.index()]);
        let points = &self.contacts.points[block.points.clone()];
        for point in &points[..place.count as usize] {
            // Bonds pull too, but only a push is a blow.
            let impulse = point.total_normal_impulse.0[lane] + point.impulse[0].0[lane];
            if impulse > 0.0 {
                let speed = -point.normal_velocity(lane, normal, start);
                is_hit |= speed > rest.speed;
                load.impulse += impulse;
                load.add_energy(impulse, speed);
            }
        }
        load.impulse = (load.impulse - rest.impulse).max(0.0);
        (load, is_hit)
    }

    /// The whole of what a body was hit with.
    pub(super) fn blow_to(&self, number: u32, load: ImpactLoad, manifolds: &Manifolds) -> Blow {
        let mut blow = Blow {
            slot: self.layout.slots[number as usize],
            load,
            ..Blow::default()
        };
        for (at, &pair) in self.layout.pairs.iter().enumerate() {
            let Some(side) = pair.iter().position(|body| body.0 == number) else {
                continue;
            };
            let given = self.load_of(at).0.impulse;
            if given == 0.0 {
                continue;
            }
            let (index, place) = self.layout.places[at];
            let lane = place.lane as usize;
            let block = &self.contacts.blocks[place.block as usize];
            let points = &self.contacts.points[block.points.clone()];
            let pushes = points.iter().map(|point| {
                let impulse = point.total_normal_impulse.0[lane] + point.impulse[0].0[lane];
                impulse.max(0.0)
            });
            let total: f32 = pushes.clone().take(place.count as usize).sum();
            let share = given / total;
            let manifold = manifolds.at(index.index());
            let direction = if side == 0 {
                -manifold.normal
            } else {
                manifold.normal
            };
            for (number, (point, push)) in manifold.points().iter().zip(pushes).enumerate() {
                let anchor = [point.anchor_a, point.anchor_b][side];
                let way = self.way_to_strike((at, number), &manifold, side);
                blow.moment += (anchor + way) * (share * push);
            }
            blow.direction += direction * given;
            blow.contacts.push((index.0, share));
            if blow.strongest.is_none_or(|(_, most)| given > most) {
                let giver = [manifold.b, manifold.a][side];
                blow.strongest = Some((giver, given));
            }
        }
        blow
    }

    /// From a point of the manifold at a place, which is midway between the bodies as they were when the step began, to where the body on one
    /// side is struck: on its surface, and so much farther along it as the other one goes until it gets there. World axes, m.
    ///
    /// What is fast comes from far away: the point may be over the next part but one.
    pub(super) fn way_to_strike(
        &self,
        (at, point): (usize, usize),
        manifold: &ManifoldRef,
        side: usize,
    ) -> Vec3 {
        let normal = manifold.normal;
        let ContactPoint {
            separation,
            anchor_a,
            anchor_b,
            radii,
            ..
        } = manifold.points()[point];
        if separation <= 0.0 {
            return Vec3::ZERO;
        }
        // What is round touches with another point when it has turned.
        let arms = [anchor_a - radii[0] * normal, anchor_b + radii[1] * normal];
        let starts = self.layout.pairs[at].map(|body| &self.impacts.start[body.index()]);
        let [a, b] = [0, 1].map(|k| starts[k].linear + starts[k].angular.cross(arms[k]));
        let velocity = b - a;
        let approach = -velocity.dot(normal);
        let time = if approach > 0.0 {
            (separation / approach).min(self.settings.step_dt())
        } else {
            0.0
        };
        let along = time * (velocity + approach * normal);
        let [out, along] = if side == 0 {
            [normal, along]
        } else {
            [-normal, -along]
        };
        along - 0.5 * separation * out
    }
}

/// How the bodies of a manifold rest on each other, which settle by up to `settling` (m/s) in a step.
fn rest_of(manifold: &ManifoldRef, bodies: &Bodies, settling: f32) -> Rest {
    let [a, b] = [manifold.a, manifold.b].map(|slot| &bodies.velocity[slot as usize]);
    let borne = |point: &ContactPoint| point.normal_impulse.max(0.0);
    let total: f32 = manifold.points().iter().map(borne).sum();
    // What is moved by force does not settle.
    let is_driven = [a, b].iter().any(|body| {
        let moves = body.linear != Vec3::ZERO || body.angular != Vec3::ZERO;
        body.inverse_mass == 0.0 && moves
    });
    let speed = if total > 0.0 && !is_driven {
        settling.max(RESTING_SPEED)
    } else {
        RESTING_SPEED
    };
    let rests = |point: &&ContactPoint| {
        let on_a = a.linear + a.angular.cross(point.anchor_a);
        let on_b = b.linear + b.angular.cross(point.anchor_b);
        manifold.normal.dot(on_a - on_b) <= speed
    };
    let resting = manifold.points().iter().filter(rests);
    Rest {
        impulse: resting.map(borne).sum(),
        speed,
    }
}
