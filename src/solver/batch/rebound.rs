//! Rebounds: which points of contact hit in a sub-step, and how fast they leave.
//!
//! A point hits if the free motion closes its gap within the sub-step; Newton's law has it leave with `-e w`, where `w < 0` is its
//! normal velocity when the gap is closed. The sweeps that stop the point act along the rows as they were before the bodies moved,
//! `J`, and those that let it leave along the rows after that, `J'`. In a sub-step that takes a lone point from `w` to `s`, moves
//! the bodies, and takes it from `s' = J' v` to `w'`, the contact has changed the kinetic energy by
//!
//! ```text
//! (s^2 - w^2) / (2 A) + (w'^2 - s'^2) / (2 A'),    A = J M^-1 J^T
//! ```
//!
//! and Newton's law takes `(1 - e^2) w^2 / (2 A)` out of it, so `w'^2 = s'^2 + (e^2 w^2 - s^2) A' / A`. That is exact for a body
//! however it is tilted and turns, and `w' = -e w` where rows stay what they are, as in a fall flat on a face. Several points that
//! hit at once change it by `sum lambda_i (w_i + w'_i) / 2`, so the same holds for each.
//!
//! Gravity gives the bodies its velocity at once when the sub-step begins, but until the gap is closed they have only fallen
//! through the way that they move. With the change of the gap's speed `f = h n.(g_B - g_A)` for those that fall, `(w - f)^2 + 2 f s`
//! stands for `w^2` above: the speed at the place where the gap is closed, by energy.
//!
//! Newton's law is about points that touch. A point that does not, and that a rebound turns towards its gap, is let go; it hits in
//! a later sub-step. If it were braked, as at other contacts, so that it just closes its gap, the energy of that would be lost.
//! So it would be if a point were held that had been leaving: it may come as fast as it left.

use crate::bodies::solver_body::SolverBody;
use crate::solver::batch::layout::Member;
use crate::solver::batch::{Batch, BatchBodies, BatchScratch};
use crate::solver::graph::indices::LaneSlot;
use crate::solver::settings::SubstepSettings;
use crate::solver::wide::block::{Block, Point, PointImpact, vector};
use glam::Vec3;

/// Speed with which a point that is let go may close its gap, m/s: any.
const LET_GO: f32 = 1e4;

/// A manifold of points that may rebound.
struct Bouncing<'a> {
    lane: usize,
    normal: Vec3,
    restitution: f32,
    /// Approach speed below which points do not rebound, m/s.
    threshold: f32,
    /// Numbers of its bodies.
    bodies: [u32; 2],
    /// How much gravity changes the speed of the gap in a sub-step, m/s.
    fall: f32,
    points: &'a mut [Point],
    impacts: &'a mut [PointImpact],
}

impl<'a> Bouncing<'a> {
    /// A manifold, if its points may rebound at all.
    fn new(
        (place, block): (LaneSlot, &'a Block),
        points: &'a mut [Point],
        impacts: &'a mut [PointImpact],
        bodies: &[SolverBody],
        settings: &SubstepSettings,
        acceleration: f32,
    ) -> Option<Self> {
        let lane = place.lane as usize;
        let restitution = block.restitution.0[lane];
        if restitution == 0.0 {
            return None;
        }
        let range = block.points.start..block.points.start + place.count as usize;
        let (normal, pair) = (vector(&block.normal, lane), block.pair(lane));
        let falls = |body: u32| f32::from(u8::from(bodies[body as usize].inverse_mass > 0.0));
        let [a, b] = pair.map(falls);
        Some(Self {
            lane,
            normal,
            restitution,
            threshold: settings.rebound_threshold(acceleration, restitution),
            bodies: pair,
            fall: settings.substep_dt * normal.dot(settings.gravity) * (b - a),
            points: &mut points[range.clone()],
            impacts: &mut impacts[range],
        })
    }

    /// Normal velocity of a point, m/s.
    fn velocity(&self, point: usize, bodies: &[SolverBody]) -> f32 {
        let pair = self.bodies.map(|body| &bodies[body as usize]);
        self.points[point].normal_velocity(self.lane, self.normal, pair)
    }

    /// Finds the points that hit in this sub-step, and about how fast they leave; returns the fastest, m/s.
    fn find_hits(&mut self, bodies: &[SolverBody], settings: &SubstepSettings) -> f32 {
        let h = settings.substep_dt;
        let hits = |this: &Self, i: usize, h: f32| {
            let speed = -this.velocity(i, bodies);
            speed > this.threshold && speed * h > this.gap(i, settings)
        };
        // Corners of a face that all but lie at one height hit together, or the face would start to rock.
        let any = (0..self.points.len()).any(|i| hits(self, i, h));
        let reach = if any { 2.0 * h } else { 0.0 };
        let mut fastest = 0.0_f32;
        for i in 0..self.points.len() {
            let mut rebound = 0.0;
            if hits(self, i, reach) {
                let (came, gap) = (self.velocity(i, bodies), self.gap(i, settings));
                let square = self.square_at_contact(came, -gap / h);
                rebound = self.restitution * square.max(0.0).sqrt();
                let target = &mut self.points[i].target_velocity.0[self.lane];
                if settings.relax_sweeps == 0 {
                    *target = target.max(rebound);
                }
            }
            self.impacts[i].rebound.0[self.lane] = rebound;
            fastest = fastest.max(rebound);
        }
        fastest
    }

    /// Gap of a point whose target velocity is known, or 0 if there is none, m.
    fn gap(&self, point: usize, settings: &SubstepSettings) -> f32 {
        (-self.points[point].target_velocity.0[self.lane] * settings.substep_dt).max(0.0)
    }

    /// Square of the speed of a point where it has got to: it `came` with gravity's share of the sub-step, and `closes` its gap
    /// within it; m2/s2.
    fn square_at_contact(&self, came: f32, closes: f32) -> f32 {
        let before = came - self.fall;
        before * before + 2.0 * self.fall * closes
    }

    /// Says what becomes of each point, once those that hit have been stopped: by the velocities `before` the contacts acted, and
    /// those now in `bodies`.
    fn weigh(&mut self, before: &[SolverBody], bodies: &[SolverBody]) {
        let (e, threshold) = (self.restitution, self.threshold);
        for i in 0..self.points.len() {
            let (came, stopped) = (self.velocity(i, before), self.velocity(i, bodies));
            let square = e * e * self.square_at_contact(came, stopped);
            let (point, impact, lane) = (&self.points[i], &mut self.impacts[i], self.lane);
            let is_pushed = point.impulse[0].0[lane] > 0.0;
            let rebound = &mut impact.rebound.0[lane];
            if *rebound > 0.0 || is_pushed && came < -threshold {
                impact.spare.0[lane] = point.normal_mass.0[lane] * (square - stopped * stopped);
                *rebound = rebound.max(f32::MIN_POSITIVE);
            } else if is_pushed {
                *rebound = (-e * came).min(0.0);
            } else if point.target_velocity.0[lane] < 0.0 {
                *rebound = -LET_GO;
            }
        }
    }

    /// Finds how fast the points leave along the rows as they are now.
    fn aim(&mut self, bodies: &[SolverBody]) {
        for i in 0..self.points.len() {
            let stopped = self.velocity(i, bodies);
            let (point, impact, lane) = (&self.points[i], &mut self.impacts[i], self.lane);
            let rebound = &mut impact.rebound.0[lane];
            let mass = point.normal_mass.0[lane];
            if *rebound > 0.0 && mass > 0.0 {
                let square = stopped * stopped + impact.spare.0[lane] / mass;
                *rebound = square.max(0.0).sqrt();
            }
        }
    }
}

impl Batch {
    /// Finds the points that hit in this sub-step, whose target velocities are known; returns how fast the fastest leaves, scaled
    /// to a size of 1 m, m/s.
    pub(crate) fn find_hits(&mut self) -> f32 {
        let mut fastest = 0.0_f32;
        if self.impacts.has_restitution {
            let settings = self.settings;
            self.each_bouncing(|bouncing, scale, bodies, _| {
                fastest = fastest.max(scale * bouncing.find_hits(bodies, &settings));
            });
        }
        fastest
    }

    /// Says what becomes of the points of contacts that may rebound, after the solve and before their rows move.
    pub(crate) fn weigh_rebounds(&mut self) {
        if !self.has_rebounds() {
            return;
        }
        let settings = self.settings;
        self.each_bouncing(|bouncing, _, bodies, before| {
            bouncing.weigh(before, bodies);
        });
        let mut lifts = std::mem::take(&mut self.impacts.lifts);
        let (now, before) = (&self.bodies.velocities, self.velocities_before());
        let lift = |member: &Member| {
            let bodies = member.bodies.clone();
            let pairs = now[bodies.clone()].iter().zip(&before[bodies]);
            let lifts = pairs.map(|(now, before)| lift(now, before, &settings));
            lifts.sum::<f64>()
        };
        lifts.extend(self.layout.members.iter().map(lift));
        self.impacts.lifts = lifts;
    }

    /// Aims the rebounds at where the rows are by now.
    pub(crate) fn aim_rebounds(&mut self) {
        if self.has_rebounds() {
            self.each_bouncing(|bouncing, _, bodies, _| bouncing.aim(bodies));
        }
    }

    /// Whether points rebound in the relax sweeps, and the velocities before the contacts acted are known.
    fn has_rebounds(&self) -> bool {
        let relaxes = self.settings.relax_sweeps > 0;
        self.impacts.has_restitution && relaxes && !self.velocities_before().is_empty()
    }

    /// The velocities before the contacts acted; empty if they are not known.
    fn velocities_before(&self) -> &[SolverBody] {
        velocities_before(&self.settings, &self.bodies, &self.scratch)
    }

    /// Looks at each manifold whose points may rebound, with its speed scale, the velocities now and those before the contacts
    /// acted.
    fn each_bouncing(
        &mut self,
        mut look: impl FnMut(&mut Bouncing<'_>, f32, &[SolverBody], &[SolverBody]),
    ) {
        let acceleration = self.fastest_acceleration();
        let settings = &self.settings;
        let before = velocities_before(settings, &self.bodies, &self.scratch);
        let points = &mut self.contacts.points[..];
        let (impacts, bodies) = (&mut self.impacts.points[..], &self.bodies.velocities);
        for &(_, place) in &self.layout.places {
            let block = &self.contacts.blocks[place.block as usize];
            let bouncing = Bouncing::new(
                (place, block),
                points,
                impacts,
                bodies,
                settings,
                acceleration,
            );
            if let Some(mut bouncing) = bouncing {
                let scale = block.speed_scale.0[place.lane as usize];
                look(&mut bouncing, scale, bodies, before);
            }
        }
    }
}

#[cfg_attr(
    not(feature = "exact"),
    expect(unused_variables, reason = "other methods have them with the bodies")
)]
fn velocities_before<'a>(
    settings: &SubstepSettings,
    bodies: &'a BatchBodies,
    scratch: &'a BatchScratch,
) -> &'a [SolverBody] {
    #[cfg(feature = "exact")]
    if settings.is_exact() {
        return &scratch.exact.free;
    }
    &bodies.contact_velocity_changes
}

/// Energy that a body has been given by moving as it does now and not as it did before its contacts acted, J: it has not fallen so
/// far, but has got the velocity of the fall.
fn lift(now: &SolverBody, before: &SolverBody, settings: &SubstepSettings) -> f64 {
    if now.inverse_mass == 0.0 {
        return 0.0;
    }
    let work = settings.gravity.dot(before.linear - now.linear) / now.inverse_mass;
    f64::from(settings.substep_dt * work)
}
