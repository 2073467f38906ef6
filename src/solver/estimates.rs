//! What each manifold asks of the sub-steps, and with that each island.

use crate::bodies::store::Bodies;
use crate::contact::manifolds::{ManifoldHead, ManifoldRef, Manifolds};
use crate::contact::point::ContactPoint;
use crate::solver::adaptivity::{IslandRequirements, JointPresence};
use crate::solver::contact_solver::{ContactEstimate, ContactSolver, Progress};
use crate::solver::graph::indices::ManifoldIndex;
use crate::solver::graph::islands::JointLink;
use crate::solver::graph::relative_motion::RelativeMotion;
use crate::solver::rows::contact_rows::{Row, RowBody};
use crate::solver::settings::SubstepSettings;
use crate::solver::wide::bond::is_new_bond;
use crate::threads::team::Team;
use crate::tuning::MIN_MANIFOLDS_OF_PART;

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
        let is_pending = |slot: u32| progress.get(slot as usize) != Some(&Progress::Solved);
        let is_pending = |m: &ManifoldHead| is_pending(m.a) && is_pending(m.b);
        self.islands
            .find(manifolds.heads(), bodies, is_pending, team);
        self.estimate_contacts(manifolds, bodies, settings, team);
        let estimates = &self.estimates;
        let relative_motion = |manifold: ManifoldIndex| estimates[manifold.index()].relative_motion;
        self.islands.find_moving(relative_motion);
        self.requirements.clear();
        for i in 0..self.islands.list.len() {
            let requirement = self.requirement(i, settings);
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
            let is_solved = |slot: u32| progress.get(slot as usize) == Some(&Progress::Solved);
            if !slots.into_iter().flatten().any(is_solved) {
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
        settings: &SubstepSettings,
    ) -> IslandRequirements {
        let island = &self.islands.list[island];
        let mut requirement = IslandRequirements {
            load: 0.0,
            can_hit: island.bounces || !island.moving.is_empty(),
            joints: match (island.joints.is_empty(), island.manifolds.is_empty()) {
                (true, _) => JointPresence::None,
                (false, true) => JointPresence::Alone,
                (false, false) => JointPresence::AmongContacts,
            },
            substeps: 0,
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
        requirement.substeps = settings.substeps_for(&requirement);
        requirement
    }
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
