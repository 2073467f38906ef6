//! The rows of what moves within a step, pointed at where its contact points are by then.

use crate::math::rotate_by;
use crate::solver::batch::subdomain_slices::subdomain_slices;
use crate::solver::batch::targets::Targets;
use crate::solver::batch::{Batch, TurningBody};
use crate::solver::wide::block::points_of;
use crate::solver::wide::reanchor::{BodyRotation, Reanchor, ReanchoredBlocks};
use crate::threads::parts::{front, front_mut};
use crate::threads::team::Team;
use glam::{Quat, Vec3};

/// Turn within a sub-step, rad, up to which rows that have been solved may be pointed anew.
const MAX_TURN: f32 = 0.05;

impl Batch {
    /// Points the rows anew where bodies hit each other: what follows acts where they are now, and impacts are large enough to
    /// matter for the angular momentum.
    pub(crate) fn reanchor_hits(&mut self, targets: &Targets, team: Option<&Team>) {
        self.impacts.lifts.clear();
        if targets.hits.any {
            self.weigh_rebounds();
            self.reanchor(MAX_TURN / self.settings.substep_dt, team);
            self.aim_rebounds();
        }
    }

    /// Points the rows of moving manifolds at where their contact points are now.
    ///
    /// Between two sub-steps `most` is infinite. Within one, when the bodies have moved but not [turned](Self::turn_bodies) yet,
    /// points stay where they are on their bodies, and manifolds of bodies that turn faster than `most` (rad/s) are left as they
    /// are: impulses that have acted along the old rows could not be taken back along the new ones.
    pub(crate) fn reanchor(&mut self, most: f32, team: Option<&Team>) {
        if self.contacts.moving.is_empty() {
            return;
        }
        self.find_turns(most, team);
        self.reanchor_blocks(team);
        let (masses, width) = (&self.bodies.masses, self.settings.lane_width);
        self.contacts
            .derive_masses(masses, &self.layout, width, team);
    }

    /// How each body of a moving manifold has turned since the start of the step, and each that is fixed.
    fn find_turns(&mut self, most: f32, team: Option<&Team>) {
        self.contacts
            .rotations
            .resize(self.bodies.velocities.len(), BodyRotation::default());
        let ahead = if most.is_finite() {
            self.settings.substep_dt
        } else {
            0.0
        };
        let mut rest = (
            &mut self.contacts.rotations[..],
            &self.bodies.velocities[..],
            &self.bodies.displacements[..],
            &self.bodies.turning[..],
            &self.contacts.is_reanchored[..],
        );
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
                let small_turn = || small_turn(moved.angular - ahead * body.angular);
                let rotation = spins.map_or_else(small_turn, TurningBody::turn);
                *turn = BodyRotation::new(rotation, body.angular.length() <= most);
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
