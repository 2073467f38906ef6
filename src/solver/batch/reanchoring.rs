//! The rows of what moves within a step, pointed at where its contact points are by then.

use crate::math::rotate_by;
use crate::solver::batch::subdomain_slices::subdomain_slices;
use crate::solver::batch::targets::Targets;
use crate::solver::batch::{Batch, TurningBody};
use crate::solver::graph::indices::BodyNumber;
use crate::solver::wide::block::points_of;
use crate::solver::wide::reanchor::{BodyRotation, Reanchor, ReanchoredBlocks};
use crate::threads::parts::{front, front_mut};
use crate::threads::team::Team;
use glam::{Quat, Vec3};

/// Turn within a sub-step, rad, up to which rows of what joints hold may be pointed anew that have been solved: what acted along the old
/// ones, and went on through the joints, is not taken back along the new ones.
const MAX_JOINTED_TURN: f32 = 0.05;

impl Batch {
    /// Points the rows anew where bodies hit each other: what follows acts where they are now, and impacts are large enough to
    /// matter for the angular momentum.
    pub(crate) fn reanchor_hits(&mut self, targets: &Targets, team: Option<&Team>) {
        self.impacts.lifts.clear();
        if targets.hits.any {
            self.weigh_rebounds();
            self.reanchor(self.settings.substep_dt, team);
            self.aim_rebounds();
        }
    }

    /// Points the rows of moving manifolds at where their contact points are now.
    ///
    /// `unturned`: for how long, s, bodies have moved without having [turned](Self::turn_bodies) yet: within a sub-step its length,
    /// between two of them 0. Points stay where they are on their bodies then, and manifolds of what joints hold are left as they are if
    /// it turns by more than [`MAX_JOINTED_TURN`].
    pub(crate) fn reanchor(&mut self, unturned: f32, team: Option<&Team>) {
        if self.contacts.moving.is_empty() {
            return;
        }
        self.find_turns(unturned, team);
        self.reanchor_blocks(team);
        let (masses, width) = (&self.bodies.masses, self.settings.lane_width);
        self.contacts
            .derive_masses(masses, &self.layout, width, team);
    }

    /// How each body of a moving manifold has turned since the start of the step, and each that is fixed.
    fn find_turns(&mut self, unturned: f32, team: Option<&Team>) {
        self.contacts
            .rotations
            .resize(self.bodies.velocities.len(), BodyRotation::default());
        let mut rest = (
            &mut self.contacts.rotations[..],
            &self.bodies.velocities[..],
            &self.bodies.displacements[..],
            &self.bodies.turning[..],
            &self.contacts.is_reanchored[..],
        );
        let joints = &self.joints;
        let parts = self
            .layout
            .cuts
            .slices_of_bodies(self.bodies.velocities.len());
        let parts = parts.map(|range| {
            let spinning = rest.3.partition_point(|t| (t.body as usize) < range.end);
            (
                range.start as u32,
                front_mut(&mut rest.0, range.len()),
                front(&mut rest.1, range.len()),
                front(&mut rest.2, range.len()),
                front(&mut rest.3, spinning),
                front(&mut rest.4, range.len()),
            )
        });
        Team::each(team, parts, |part| {
            let (first, turns, bodies, displacements, turning, is_reanchored) = part;
            let mut turning = turning.iter().peekable();
            let bodies = bodies.iter().zip(displacements.iter());
            let bodies = bodies.zip(is_reanchored.iter());
            let turns = (first..).zip(turns.iter_mut().zip(bodies));
            for (number, (turn, ((body, moved), is_reanchored))) in turns {
                let spins = turning.next_if(|t| t.body == number);
                if !is_reanchored {
                    continue;
                }
                let small_turn = || small_turn(moved.angular - unturned * body.angular);
                let rotation = spins.map_or_else(small_turn, TurningBody::turn);
                let is_fast = || unturned * body.angular.length() > MAX_JOINTED_TURN;
                let may_follow = !(is_fast() && joints.hold(BodyNumber(number)));
                *turn = BodyRotation::new(rotation, may_follow);
            }
        });
    }

    fn reanchor_blocks(&mut self, team: Option<&Team>) {
        let width = self.settings.lane_width;
        let blocks = &self.contacts.blocks;
        let (mut points, mut bond_constraints) = (
            &mut self.contacts.points[..],
            &mut self.bonds.constraints[..],
        );
        let (turns, displacements) = (&self.contacts.rotations, &self.bodies.displacements);
        let (mut reanchored, mut starts, mut curvatures) = (
            ReanchoredBlocks::new(&self.contacts.reanchored),
            &self.contacts.anchor_starts[..],
            &self.contacts.curvatures[..],
        );
        let is_round = !curvatures.is_empty();
        let subdomain_slices = subdomain_slices(&self.layout.subdomains, blocks.len(), team);
        let parts = subdomain_slices.map(|share| {
            let of_points = points_of(&blocks[share.clone()]);
            let ties_there = if bond_constraints.is_empty() {
                0
            } else {
                of_points.len()
            };
            let reanchored = reanchored.take(share.len());
            let round_points = if is_round { reanchored.points() } else { 0 };
            Reanchor {
                blocks: &blocks[share],
                reanchored,
                points: front_mut(&mut points, of_points.len()),
                bond_constraints: front_mut(&mut bond_constraints, ties_there),
                starts: front(&mut starts, reanchored.points()),
                curvatures: front(&mut curvatures, round_points),
                turns,
                displacements,
            }
        });
        Team::each(team, parts, |mut part| part.run(width));
    }
}

/// The turn of a body whose axes need not be followed.
fn small_turn(angle: Vec3) -> Quat {
    rotate_by(Quat::IDENTITY, angle, 1.0)
}
