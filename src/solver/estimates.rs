//! What each manifold asks of the sub-steps, and with that each island.

use crate::bodies::store::Bodies;
use crate::contact::manifolds::{ManifoldHead, ManifoldRef, Manifolds};
use crate::contact::point::ContactPoint;
use crate::solver::adaptivity::{IslandRequirements, JointPresence, LoneKind};
use crate::solver::contact_solver::{ContactEstimate, ContactSolver, Progress};
use crate::solver::graph::indices::{BodyNumber, ManifoldIndex};
use crate::solver::graph::islands::{Island, JointLink};
use crate::solver::graph::relative_motion::RelativeMotion;
use crate::solver::rows::contact_rows::{Row, RowBody};
use crate::solver::settings::{MethodKind, SubstepSettings};
use crate::solver::wide::bond::{is_bonded, is_new_bond};
use crate::threads::team::Team;
use crate::tuning::{LONE_MANIFOLDS, MIN_MANIFOLDS_OF_PART};

/// How far gravity may move a body within a step of its island, as a share of its least extent: at 60 Hz on Earth 14 cm are enough
/// for the step itself (`docs/decisions/local_steps.md`).
pub(crate) const FALL: f32 = 0.02;

/// How far a body may turn within a step of its island, rad: between the moment at which a contact is found and that at which it acts, a
/// corner must not become another one.
const TURN: f32 = 0.5;

/// Gap of points that bodies keep in a local step, as a share of the least extent: somewhat more than the margin of contacts.
const NEAR: f32 = 0.05;

impl ContactSolver {
    /// Finds the islands and what they ask for.
    pub(crate) fn find_islands(
        &mut self,
        manifolds: &Manifolds,
        bodies: &Bodies,
        settings: &SubstepSettings,
        team: Option<&Team>,
    ) {
        self.link_joints(bodies);
        let progress = &self.progress;
        let is_pending = |slot: u32| is_pending(progress, slot);
        let is_pending = |m: &ManifoldHead| is_pending(m.a) && is_pending(m.b);
        self.islands
            .find(manifolds.heads(), bodies, is_pending, team);
        self.estimate_contacts(manifolds, bodies, settings, team);
        let estimates = &self.estimates;
        let relative_motion = |manifold: ManifoldIndex| estimates[manifold.index()].relative_motion;
        self.islands.find_moving(relative_motion);
        self.requirements.clear();
        for i in 0..self.islands.list.len() {
            let requirement = self.requirement(i, manifolds, bodies, settings);
            self.requirements.push(requirement);
        }
    }

    /// Tells the islands which bodies joints hold together, of those that are not solved yet.
    fn link_joints(&mut self, bodies: &Bodies) {
        let links = &mut self.islands.joint_links;
        links.clear();
        let progress = &self.progress;
        for (joint, record) in (0..).zip(&self.joints) {
            let slots = record.ends.map(|end| end.map(|(slot, _)| slot));
            let moves = slots.map(|slot| {
                slot.is_some_and(|slot| bodies.velocity[slot as usize].inverse_mass > 0.0)
            });
            if (slots.into_iter().flatten()).all(|slot| is_pending(progress, slot)) {
                links.push(JointLink {
                    bodies: slots,
                    moves,
                    joint,
                });
            }
        }
    }

    /// Looks what each manifold asks for.
    pub(crate) fn estimate_contacts(
        &mut self,
        manifolds: &Manifolds,
        bodies: &Bodies,
        settings: &SubstepSettings,
        team: Option<&Team>,
    ) {
        let (step, depends_on_load) = (settings.step_dt(), settings.depends_on_load());
        self.estimates
            .resize(manifolds.len(), ContactEstimate::default());
        let size = Team::part_size(team, manifolds.len(), MIN_MANIFOLDS_OF_PART);
        let parts = self.estimates.chunks_mut(size).enumerate();
        Team::each_of_many(team, parts, |(part, estimates)| {
            for (index, estimate) in (part * size..).zip(estimates) {
                let head = &manifolds.heads()[index];
                let slots = [head.a as usize, head.b as usize];
                estimate.relative_motion = RelativeMotion::of(bodies, slots, step);
                if settings.max_local_steps > 1 {
                    estimate.extent = moved_extent(bodies, slots);
                    estimate.turn = step * fastest_spin(bodies, slots, TURN / step);
                }
                estimate.load = if depends_on_load {
                    load_of(manifolds.at(index), bodies, settings)
                } else {
                    0.0
                };
            }
        });
    }

    /// How the bodies of a manifold move against each other.
    pub(crate) fn relative_motion(&self, manifold: ManifoldIndex) -> RelativeMotion {
        self.estimates[manifold.index()].relative_motion
    }

    /// What an island asks for.
    pub(crate) fn requirement(
        &self,
        island: usize,
        manifolds: &Manifolds,
        bodies: &Bodies,
        settings: &SubstepSettings,
    ) -> IslandRequirements {
        let island = &self.islands.list[island];
        let mut requirement = IslandRequirements {
            load: 0.0,
            can_hit: island.bounces || !island.moving.is_empty(),
            lone: self.lone_kind(island, bodies, settings),
            joints: match (island.joints.is_empty(), island.manifolds.is_empty()) {
                (true, _) => JointPresence::None,
                (false, true) => JointPresence::Alone,
                (false, false) => JointPresence::AmongContacts,
            },
            joint_swing: None,
            substeps: 0,
            local_steps: 1,
            max_local_steps: 1,
        };
        if settings.depends_on_load() {
            for &index in &self.islands.manifolds[island.manifolds.clone()] {
                let load = if is_new_bond(&self.bonded, index) {
                    f32::INFINITY
                } else {
                    self.estimates[index.index()].load
                };
                requirement.load = requirement.load.max(load);
            }
        }
        if settings.depends_on_load() && requirement.joints == JointPresence::Alone {
            requirement.joint_swing = self.joint_swing(island, bodies, settings.step_dt());
        }
        requirement.substeps = settings.substeps_for(&requirement);
        [requirement.local_steps, requirement.max_local_steps] =
            self.local_steps(island, &requirement, manifolds, settings);
        requirement
    }

    /// See [`IslandRequirements::lone`].
    fn lone_kind(
        &self,
        island: &Island,
        bodies: &Bodies,
        settings: &SubstepSettings,
    ) -> Option<LoneKind> {
        let count = island.manifolds.len();
        if count > LONE_MANIFOLDS || settings.method != MethodKind::SoftStep {
            return None;
        }
        let may_break = |&slot: &u32| bodies.limit(slot).is_some();
        let slots = &self.islands.slots[island.bodies.clone()];
        let pairs = &self.islands.pairs[island.manifolds.clone()];
        // One that contacts move, or they would not be of one island.
        let is_in_all = |body: &BodyNumber| {
            let slot = slots[body.index()] as usize;
            bodies.velocity[slot].inverse_mass > 0.0 && pairs.iter().all(|p| p.contains(body))
        };
        let mut manifolds = self.islands.manifolds[island.manifolds.clone()].iter();
        let is_lone = island.joints.is_empty()
            && pairs.first().is_some_and(|pair| pair.iter().any(is_in_all))
            // The rows of all follow the motion, or of none.
            && (island.moving.is_empty() || island.moving.len() == count)
            // How fast what drives one of them may make it is asked for all that rebound.
            && (!island.bounces || bodies.drives.is_empty())
            && !manifolds.any(|&manifold| is_bonded(&self.bonded, manifold))
            && !(bodies.any_fracturable() && slots.iter().any(may_break));
        is_lone.then_some(LoneKind {
            moves: !island.moving.is_empty(),
            bounces: island.bounces,
        })
    }

    /// See [`IslandRequirements::joint_swing`].
    fn joint_swing(&self, island: &Island, bodies: &Bodies, step: f32) -> Option<f32> {
        let mut joints = self.islands.joints[island.joints.clone()].iter();
        if !joints.all(|&(joint, _)| self.joints[joint as usize].joint.is_free_or_rigid()) {
            return None;
        }
        let slots = self.islands.slots[island.bodies.clone()].iter();
        let spins = slots.map(|&slot| bodies.velocity[slot as usize].angular.length_squared());
        Some(step * spins.fold(0.0, f32::max).sqrt())
    }

    /// Steps that an island takes within the step: so many that gravity moves nothing by more than [`FALL`] of its least extent in
    /// one, and nothing turns by more than [`TURN`], as far as they do not make the island cost more than its sweeps may; and the most that
    /// it may take.
    fn local_steps(
        &self,
        island: &Island,
        requirement: &IslandRequirements,
        manifolds: &Manifolds,
        settings: &SubstepSettings,
    ) -> [u32; 2] {
        let is_held = requirement.joints != JointPresence::None;
        if settings.max_local_steps <= 1 || is_held {
            return [1; 2];
        }
        let indices = &self.islands.manifolds[island.manifolds.clone()];
        let estimates = indices.iter().map(|m| &self.estimates[m.index()]);
        let [least, turn] = estimates.fold([f32::INFINITY, 0.0], |[least, turn], estimate| {
            [least.min(estimate.extent), turn.max(estimate.turn)]
        });
        let fall = settings.gravity.length() * settings.step_dt() * settings.step_dt();
        let wanted = (fall / (FALL * least)).sqrt().max(turn / TURN).ceil();
        if wanted <= 1.0 {
            return [1; 2];
        }
        // Those that a local step will have: it looks less far.
        let near = |&index: &ManifoldIndex| {
            let most = NEAR * self.estimates[index.index()].extent;
            let points = manifolds.at(index.index()).points().iter();
            points.filter(|point| point.separation < most).count() as u32
        };
        let points: u32 = indices.iter().map(near).sum();
        let most = settings.affordable_local_steps(points);
        let is_bonded = || indices.iter().any(|&index| is_bonded(&self.bonded, index));
        if most == 1 || is_bonded() {
            return [1; 2];
        }
        [(wanted as u32).min(most).next_power_of_two(), most]
    }
}

/// Whether the body in `slot` waits for nothing but the solve.
fn is_pending(progress: &[Progress], slot: u32) -> bool {
    !matches!(
        progress.get(slot as usize),
        Some(Progress::Solved | Progress::PutOff)
    )
}

/// Least extent of those of two bodies that contacts move, m.
fn moved_extent(bodies: &Bodies, slots: [usize; 2]) -> f32 {
    let extents = slots.map(|i| match bodies.velocity[i].inverse_mass > 0.0 {
        true => bodies.min_extent[i],
        false => f32::INFINITY,
    });
    extents[0].min(extents[1])
}

/// Angular speed of the faster of those of two bodies that contacts move and that have corners, if it is above `least`, else 0, rad/s.
fn fastest_spin(bodies: &Bodies, slots: [usize; 2], least: f32) -> f32 {
    let spins = slots.map(|i| {
        let body = &bodies.velocity[i];
        let square = body.angular.length_squared();
        let counts = square > least * least && body.inverse_mass > 0.0;
        if counts && !bodies.is_round(i as u32) {
            square.sqrt()
        } else {
            0.0
        }
    });
    spins[0].max(spins[1])
}

/// Largest velocity that a contact of the manifold gave its effective mass in the last step, over the smaller body's least
/// extent, 1/s. What has just landed bears at least its own weight.
fn load_of(manifold: ManifoldRef, bodies: &Bodies, settings: &SubstepSettings) -> f32 {
    let slots = [manifold.a, manifold.b].map(|slot| slot as usize);
    let weight = settings.gravity.length() * settings.step_dt();
    let sides = slots.map(|i| RowBody::of(bodies, i));
    let velocity = |point: &ContactPoint| {
        let anchors = [point.anchor_a, point.anchor_b];
        let row = Row::new(manifold.normal, anchors, sides);
        (point.normal_impulse * row.diagonal).abs()
    };
    let velocities = manifold.points().iter().map(velocity);
    let [a, b] = slots.map(|i| bodies.min_extent[i]);
    velocities.fold(weight, f32::max) / a.min(b)
}
