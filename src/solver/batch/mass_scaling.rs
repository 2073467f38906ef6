//! Mass scaling: a light body that is squeezed by many times its weight is heavier while it is.
//!
//! A contact gives way by what its effective mass is accelerated, which is that of the lighter body. Under a heavy one a pebble
//! would ask for more sub-steps than there may be, and lies half in the floor with those there are. Stiffer contacts leave the sweeps as far from
//! each other's impulses as the masses are, and what lies on them trembles (`docs/decisions/soft_step.md`). But the inertia of what is squeezed matters little to what happens to
//! it, as in explicit finite elements, where what is too stiff for the step gets more mass. So for the step it gets `k` times its mass and inertia and keeps its
//! weight, with
//!
//! ```text
//! k = s d / d_max                        d: what the last step's impulses gave a point of the body, m/s; d_max: what sub-steps bear, m/s
//! s = 1 - |sum of pushes| / sum |pushes| how much of it others push back: 1 if it is squeezed, 0 if it is thrown or only lies there
//! (k - 1) m v^2 / 2 <= c I g dt          v: how fast it moves against what squeezes it; I: half of s sum |pushes|, N s
//! ```
//!
//! The last line is for energy, which a body that is moving would have more of: not above a share of what the squeeze gains by falling
//! for a step. What is thrown about between heavy bodies keeps its mass, so.
//!
//! What is in contact with a body that may break, or with a bond, also by way of others, keeps its mass: what a blow breaks is judged by the impulse and the
//! energy that are left for it, and a pebble that strikes a wall with a thousand times its mass breaks it.

use crate::bodies::store::Bodies;
use crate::contact::manifolds::Manifolds;
use crate::contact::point::ContactPoint;
use crate::solver::adaptivity::{IslandRequirements, JointPresence};
use crate::solver::batch::Batch;
use crate::solver::rows::contact_rows::RowBody;
use crate::solver::settings::SubstepSettings;
use glam::Vec3;

/// Times [`SoftStep::sag`](crate::solver::config::SoftStep::sag) that contacts give way before the mass of what they bear upon is scaled.
const SAGS: f32 = 4.0;

/// Share of the energy that a squeeze gains by falling for a step which the mass that is added may have.
const SPARE_ENERGY: f32 = 0.25;

/// Most times its mass that a body may have.
const MAX_SCALE: f32 = 1e3;

/// What squeezed a body in the last step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Squeeze {
    /// Sum of all pushes, N s.
    total: f32,
    /// Their resultant, N s.
    resultant: Vec3,
    /// Largest velocity that one gave the point where it acted, m/s.
    velocity: f32,
    /// Sum of pushes times squares of the speeds of the two bodies against each other there, N s m2/s2.
    motion: f32,
}

impl Squeeze {
    /// Adds a push (N s, and its direction) that gives the point where it acts so much velocity (m/s), and against which the bodies move with
    /// `motion` (m/s).
    fn add(&mut self, (push, direction): (f32, Vec3), velocity: f32, motion: Vec3) {
        self.total += push;
        self.resultant += push * direction;
        self.velocity = self.velocity.max(velocity);
        self.motion += push * motion.length_squared();
    }

    /// By how much the body is to be heavier, if it is. `bearable`: largest velocity that a contact bears to be given, m/s; `fall`:
    /// what gravity gives within a step, m/s.
    fn mass_scale(&self, inverse_mass: f32, bearable: f32, fall: f32) -> Option<f32> {
        if self.total <= 0.0 {
            return None;
        }
        let share = 1.0 - self.resultant.length() / self.total;
        let asked = share * self.velocity / bearable;
        let square = self.motion / self.total;
        let added = SPARE_ENERGY * share * self.total * fall * inverse_mass / square;
        let scale = asked.min(1.0 + added).min(MAX_SCALE);
        (scale.is_finite() && scale > 1.0).then_some(scale)
    }
}

impl Batch {
    /// Gives bodies that are squeezed more mass for the step. `all`: of islands that ask for nothing.
    pub(super) fn scale_masses(
        &mut self,
        all: &SubstepSettings,
        requirements: &IslandRequirements,
        manifolds: &Manifolds,
        bodies: &Bodies,
    ) {
        let has_joints = requirements.joints != JointPresence::None;
        let has_most = requirements.substeps >= all.max_substeps;
        if !all.depends_on_load() || has_joints || !has_most {
            return;
        }
        let bearable = SAGS * self.settings.bearable_load();
        // What more than one island asks for is known of the first one only.
        if self.layout.members.len() == 1 && requirements.load <= bearable {
            return;
        }
        let squeezes = &mut self.scratch.squeezes;
        squeezes.clear();
        squeezes.resize(self.layout.slots.len(), Squeeze::default());
        for member in 0..self.layout.members.len() {
            if !self.touches_breakable(member, manifolds, bodies) {
                self.find_squeezes(member, manifolds);
                self.scale_masses_of(member, bearable);
            }
        }
    }

    /// Scales the masses of one island's bodies. `bearable`: velocity that a contact bears to be given for each meter of a body's extent, 1/s.
    fn scale_masses_of(&mut self, member: usize, bearable: f32) {
        let fall = self.settings.gravity.length() * self.settings.step_dt();
        for number in self.layout.members[member].bodies.clone() {
            let (body, mass) = (
                &mut self.bodies.velocities[number],
                &mut self.bodies.masses[number],
            );
            let squeeze = &self.scratch.squeezes[number];
            let bearable = bearable * mass.extent();
            let Some(scale) = squeeze.mass_scale(body.inverse_mass, bearable, fall) else {
                continue;
            };
            body.inverse_mass /= scale;
            *mass = mass.scaled(scale.recip());
            self.scale_drive(number as u32, scale.recip());
        }
    }

    /// Whether anything in an island touches a body that may break, static ones among them, or is held by a bond.
    fn touches_breakable(&self, member: usize, manifolds: &Manifolds, bodies: &Bodies) -> bool {
        let is_breakable =
            |slot: u32| bodies.fracturable(slot).is_some() || bodies.cluster(slot).is_some();
        let any_breakable = bodies.any_fracturable();
        let places = self.layout.members[member].places.clone();
        self.layout.places[places].iter().any(|&(index, _)| {
            let manifold = manifolds.at(index.index());
            let [a, b] = [manifold.a, manifold.b];
            any_breakable && (is_breakable(a) || is_breakable(b)) || bodies.are_bonded(a, b)
        })
    }

    /// Sums up what contacts gave the bodies of one island in the last step.
    fn find_squeezes(&mut self, member: usize, manifolds: &Manifolds) {
        let squeezes = &mut self.scratch.squeezes;
        let (bodies, masses) = (&self.bodies.velocities, &self.bodies.masses);
        let range = self.layout.members[member].places.clone();
        let (places, pairs) = (
            &self.layout.places[range.clone()],
            &self.layout.pairs[range],
        );
        for (&(index, _), pair) in places.iter().zip(pairs) {
            let manifold = manifolds.at(index.index());
            let normal = manifold.normal;
            let pair = pair.map(|body| body.index());
            let sides = pair.map(|number| RowBody {
                inverse_mass: bodies[number].inverse_mass,
                inverse_inertia: masses[number].inverse_inertia(),
            });
            let velocity = |side: usize, anchor: Vec3| {
                let body = &bodies[pair[side]];
                body.linear + body.angular.cross(anchor)
            };
            let pushing = |point: &&ContactPoint| point.normal_impulse > 0.0;
            for point in manifold.points().iter().filter(pushing) {
                let (push, anchors) = (point.normal_impulse, [point.anchor_a, point.anchor_b]);
                let motion = velocity(0, anchors[0]) - velocity(1, anchors[1]);
                for (side, body) in sides.iter().enumerate() {
                    let given = push * body.inverse_mass_at(anchors[side].cross(normal));
                    let direction = [-normal, normal][side];
                    squeezes[pair[side]].add((push, direction), given, motion);
                }
            }
        }
    }
}
