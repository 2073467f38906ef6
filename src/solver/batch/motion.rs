//! How the bodies of a batch move within a sub-step.

use crate::bodies::free_rotation::{FreeRotation, FreeRotations, SPINS};
use crate::bodies::solver_body::SolverBody;
use crate::contact::manifolds::Manifolds;
use crate::contact::point::ContactPoint;
use crate::math::rotate_by;
use crate::simd::lanes::LaneWidth;
use crate::solver::batch::layout::{Layout, Member};
use crate::solver::batch::subdomain_slices::{each_part, parts_by_body};
use crate::solver::batch::targets::Targets;
use crate::solver::batch::{Batch, TurningBody};
use crate::threads::parts::{front, front_mut};
use crate::threads::team::Team;
use crate::tuning::MAX_LEAVES;
use glam::{Mat3, Vec3};

/// Share of the angles that a turn is the difference of, below which it is their rounding.
const ROUNDING: f32 = 1e-6;

/// Turn in a sub-step, rad, beyond which rows that were not pointed anew within it say nothing of where a body gets to.
const MAX_PUSH: f32 = 1.0;

impl Batch {
    /// The velocities that gravity gives, and if a tolerance depends on it, how fast the bodies of each island are then.
    pub(crate) fn apply_gravity(&mut self, team: Option<&Team>) {
        let settings = &self.settings;
        let change = settings.gravity * (self.gravity_share() * settings.substep_dt);
        let is_asked = settings.tolerance.is_some();
        let Layout { cuts, members, .. } = &self.layout;
        let fastest = &mut self.bodies.fastest;
        fastest.clear();
        if cuts.leaves().is_empty() {
            fall(&mut self.bodies.velocities, change);
            let asked = if is_asked { &members[..] } else { &[] };
            let bodies = |member: &Member| &self.bodies.velocities[member.bodies.clone()];
            fastest.extend(asked.iter().map(|member| fastest_of(bodies(member))));
            return;
        }
        let mut of_parts = [0.0; MAX_LEAVES];
        let parts = parts_by_body(&mut self.bodies.velocities, cuts).zip(&mut of_parts);
        Team::each(team, parts, |(bodies, fastest)| {
            fall(bodies, change);
            if is_asked {
                *fastest = fastest_of(bodies);
            }
        });
        fastest.push(of_parts.into_iter().fold(0.0, f32::max));
    }

    /// Moves the bodies by their velocities.
    pub(crate) fn move_bodies(&mut self, manifolds: &Manifolds, team: Option<&Team>) {
        let h = self.settings.substep_dt;
        let lists = (
            &mut self.bodies.displacements[..],
            &mut self.bodies.velocities[..],
        );
        each_part(&self.layout.cuts, team, lists, |qs, vs| {
            for (q, v) in qs.iter_mut().zip(vs.iter()) {
                q.linear += h * v.linear;
                q.angular += h * v.angular;
            }
        });
        if self.impacts.has_restitution {
            self.correct_flight();
        }
        self.clamp_tunnelling(manifolds);
    }

    /// Stops the center of a fast body in front of the face that it was in front of.
    ///
    /// The rows hold the points that were nearest at the start of the step. A thin body that hits with one corner turns at
    /// thousands of radians per second, and no frozen row sees the rest of it come round. Where joints hold a body, what it hangs on
    /// keeps it from that, and to stop it alone would tear it off.
    fn clamp_tunnelling(&mut self, manifolds: &Manifolds) {
        for moving in &self.contacts.moving {
            let Some(ccd_radius) = moving.ccd_radius else {
                continue;
            };
            let manifold = manifolds.at(moving.manifold.index());
            let pair = moving.bodies;
            if self.joints.hold(pair[moving.anchor_body]) {
                continue;
            }
            let [a, b] = pair.map(|body| self.bodies.displacements[body.index()].linear);
            let away = [-manifold.normal, manifold.normal][moving.anchor_body];
            let height = |point: &ContactPoint| {
                let anchor = [point.anchor_a, point.anchor_b][moving.anchor_body];
                0.5 * point.separation - away.dot(anchor)
            };
            let before = manifold.points().iter().map(height);
            let before = before.fold(f32::INFINITY, f32::min);
            let after = before + manifold.normal.dot(b - a);
            let least = before.min(ccd_radius);
            if before > 0.0 && after < least {
                let body = pair[moving.anchor_body].index();
                self.bodies.displacements[body].linear += (least - after) * away;
            }
        }
    }

    /// Bodies that nothing pushes fly: `x += h v - h^2 g / 2` with the velocity after the sub-step is the parabola. A body that
    /// rebounds low would lose height otherwise while it is near the ground.
    pub(super) fn correct_flight(&mut self) {
        let settings = &self.settings;
        let is_pushed = &mut self.scratch.is_pushed;
        is_pushed.clear();
        is_pushed.resize(self.bodies.velocities.len(), false);
        for block in &self.contacts.blocks {
            for point in &self.contacts.points[block.points.clone()] {
                let is_held = |&lane: &usize| point.impulse[0].0[lane].abs() > 0.0;
                for lane in (0..block.used).filter(is_held) {
                    for body in block.pair(lane) {
                        is_pushed[body as usize] = true;
                    }
                }
            }
        }
        let fall = 0.5 * settings.substep_dt * settings.substep_dt * settings.gravity;
        let bodies = self.bodies.velocities.iter().zip(is_pushed.iter());
        for (q, (body, is_pushed)) in self.bodies.displacements.iter_mut().zip(bodies) {
            if body.inverse_mass > 0.0 && !is_pushed {
                q.linear -= fall;
            }
        }
        if !self.bodies.driven.is_empty() {
            let is_pushed = std::mem::take(&mut self.scratch.is_pushed);
            self.correct_driven_flight(&is_pushed);
            self.scratch.is_pushed = is_pushed;
        }
    }

    /// Turns the bodies that spin, and their inertia with them: freely with the velocities that the sub-step ends with, and by what
    /// pushed overlap out, which these no longer have.
    pub(crate) fn turn_bodies(&mut self, targets: &Targets, team: Option<&Team>) {
        if self.bodies.turning.is_empty() {
            return;
        }
        let count = self.bodies.velocities.len();
        let (h, width) = (self.settings.substep_dt, self.settings.lane_width);
        let any_rebounds = targets.hits.any && self.impacts.has_restitution;
        let is_hit = if any_rebounds {
            &self.impacts.is_hit[..]
        } else {
            &[]
        };
        // What tore bonds pull back turns too far: the pieces of a beam gained 6 % of the energy of the blow.
        let follows_push = !self.bonds.any();
        // Where no rows follow the inertia stays what their masses are of.
        let has_new_inertia = &self.contacts.has_new_inertia;
        let mut rest = (
            &mut self.bodies.velocities[..],
            &mut self.bodies.masses[..],
            &mut self.bodies.turning[..],
            &self.bodies.displacements[..],
        );
        let parts = self.layout.cuts.slices_of_bodies(count).map(|range| {
            let spinning = rest.2.partition_point(|t| (t.body as usize) < range.end);
            (
                range.start,
                front_mut(&mut rest.0, range.len()),
                front_mut(&mut rest.1, range.len()),
                front_mut(&mut rest.2, spinning),
                front(&mut rest.3, range.len()),
            )
        });
        Team::each(team, parts, |(first, bodies, masses, turning, moved)| {
            for turning in turning.chunks_mut(SPINS) {
                for turning in turning.iter_mut().filter(|turning| !turning.is_jointed) {
                    let at = turning.body as usize - first;
                    // What rebounds has moved as it was stopped, and turns as it leaves.
                    let rebounds = is_hit.get(turning.body as usize) == Some(&true);
                    if rebounds || !follows_push {
                        turning.followed = moved[at].angular;
                    } else {
                        turning.follow_push(moved[at].angular, &mut bodies[at].angular, h);
                    }
                }
                turn_together(turning, first, bodies, h, width);
                let turned = turning.iter_mut().filter(|turning| !turning.is_jointed);
                for turning in turned.filter(|t| has_new_inertia[t.body as usize]) {
                    let r = Mat3::from_quat(turning.spin.rotation);
                    let inertia = r * turning.inverse_inertia * r.transpose();
                    masses[turning.body as usize - first].set_inverse_inertia(&inertia);
                }
            }
        });
    }
}

impl TurningBody {
    /// Turns as far as the body has `moved` (rad) since the last time, but for what it turns freely in `h` seconds with its
    /// `velocity` (rad/s), which comes by itself. Where it would have more energy then, it gets slower.
    fn follow_push(&mut self, moved: Vec3, velocity: &mut Vec3, h: f32) {
        let free = h * *velocity;
        let push = moved - self.followed - free;
        self.followed = moved;
        let noise = ROUNDING * (moved.abs() + free.abs()).element_sum();
        let square = push.length_squared();
        if square > noise * noise && square < MAX_PUSH * MAX_PUSH {
            let energy = match self.is_round {
                true => FreeRotation::exact_energy,
                false => FreeRotation::energy,
            };
            let before = energy(&self.spin, *velocity);
            self.spin.rotation = rotate_by(self.spin.rotation, push, 1.0);
            let after = energy(&self.spin, *velocity);
            if after > before {
                *velocity *= (before / after).sqrt() as f32;
            }
        }
    }
}

fn fall(bodies: &mut [SolverBody], change: Vec3) {
    for body in bodies.iter_mut().filter(|b| b.inverse_mass > 0.0) {
        body.linear += change;
    }
}

/// Square of the largest speed, m2/s2.
fn fastest_of(bodies: &[SolverBody]) -> f32 {
    let squares = bodies.iter().map(|body| body.linear.length_squared());
    squares.fold(0.0, f32::max)
}

/// Turns up to eight bodies; `first`: number of the first one of `bodies`.
fn turn_together(
    turning: &mut [TurningBody],
    first: usize,
    bodies: &mut [SolverBody],
    h: f32,
    width: LaneWidth,
) {
    let mut spins = FreeRotations::default();
    for turning in turning.iter().filter(|turning| !turning.is_jointed) {
        spins.push(turning.spin, bodies[turning.body as usize - first].angular);
    }
    spins.advance(h, width);
    let turning = turning.iter_mut().filter(|turning| !turning.is_jointed);
    for (turning, (spin, omega)) in turning.zip(spins.iter()) {
        turning.spin = *spin;
        bodies[turning.body as usize - first].angular = omega;
    }
}
