//! What a batch takes over of islands, bodies and manifolds before its sub-steps.

use crate::bodies::free_rotation::FreeRotation;
use crate::bodies::solver_body::{BodyMass, SolverBody};
use crate::bodies::store::Bodies;
use crate::contact::manifolds::Manifolds;
use crate::solver::adaptivity::{IslandRequirements, SweepBudget};
use crate::solver::batch::contacts::MovingManifold;
use crate::solver::batch::layout::Group;
use crate::solver::batch::subdomain_slices::{parts_by_body, parts_of_blocks};
use crate::solver::batch::{Batch, TurningBody};
use crate::solver::graph::indices::BodyNumber;
use crate::solver::graph::islands::{Island, Islands, MovingPair};
use crate::solver::settings::SubstepSettings;
use crate::solver::wide::block::PointImpact;
use crate::solver::wide::prepare::{Source, fill};
use crate::solver::wide::reanchor::{AnchorStart, FLAT, ReanchoredBlock, ReanchoredBlocks};
use crate::threads::parts::{front, front_mut};
use crate::threads::team::Team;
use crate::tuning::{JOINT_UPDATES, MAX_PARTS, MIN_MEASURED_PAIRS};
use glam::{Mat3, Vec3};

/// Which of two bodies carries their contact points: the smaller one, whose corners they mostly are, if it can move.
fn anchor_body(slots: [usize; 2], bodies: &Bodies) -> usize {
    let size = slots.map(|i| {
        let is_movable = bodies.velocity[i].inverse_mass > 0.0;
        if is_movable {
            bodies.radius(i as u32)
        } else {
            f32::INFINITY
        }
    });
    usize::from(size[1] <= size[0])
}

/// What batches are loaded from.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// All islands.
    pub islands: &'a Islands,
    /// All manifolds.
    pub manifolds: &'a Manifolds,
    /// All bodies.
    pub bodies: &'a Bodies,
    /// The sub-steps of an island that asks for nothing.
    pub settings: &'a SubstepSettings,
    /// Who solves the subdomains of the batch together, if it is not for one thread.
    pub team: Option<&'a Team>,
    /// Whether the solve is to be given up when a body is overloaded.
    pub may_break: bool,
}

impl Batch {
    /// Takes over the bodies and contacts of a group of islands, which ask for the same.
    pub fn load(&mut self, step: &Step, group: Group<'_>, requirements: &IslandRequirements) {
        let Step {
            islands,
            manifolds,
            bodies,
            settings,
            team,
            may_break,
        } = *step;
        self.clear();
        self.settings = settings.for_requirements(requirements);
        let layout = &mut self.layout;
        let is_kept = layout.number(islands, group, bodies, &self.settings, team);
        self.load_bodies(bodies, team);
        self.impacts.may_break = may_break;
        if !is_kept {
            let (blocks, points) = (&mut self.contacts.blocks, &mut self.contacts.points);
            let (layout, order) = (&mut self.layout, self.settings.order);
            layout.place(islands, group, &self.bodies.velocities, order, team);
            layout.name(blocks, points, team);
        }
        self.load_copies();
        self.load_driven(bodies);
        self.scale_masses(settings, requirements, manifolds, bodies);
        for member in 0..self.layout.members.len() {
            self.measure(member, team);
            self.measure_inertia(member, team);
            self.load_turning(member, bodies);
        }
        for (member, &island) in group.islands.iter().enumerate() {
            let island = &islands.list[island as usize];
            let first_place = self.layout.members[member].places.start;
            let moving = &islands.moving[island.moving.clone()];
            self.load_moving(moving, [island.manifolds.start, first_place], bodies);
        }
        self.load_limits(bodies, manifolds);
        self.mark_reanchored();
        let round_points = if bodies.any_round {
            self.contacts.anchor_starts.len()
        } else {
            0
        };
        self.contacts.curvatures.resize(round_points, FLAT);
        self.fill_blocks(manifolds, team);
        let of_group = group
            .islands
            .iter()
            .map(|&island| &islands.list[island as usize]);
        self.impacts.has_restitution = of_group.clone().any(|island| island.bounces);
        self.load_impacts(requirements.can_hit, group.is_lone);
        let updates = |island: &Island| island.points.len() + JOINT_UPDATES * island.joints.len();
        let most_updates = of_group.map(updates).max();
        self.budget = SweepBudget::new(self.settings.max_extra_updates, most_updates.unwrap_or(0));
    }

    /// Gives each point what it needs where bodies hit each other, if they can; of lone islands, only where they rebound.
    fn load_impacts(&mut self, can_hit: bool, are_lone: bool) {
        if are_lone {
            self.begin_lone();
        }
        let may_hit = can_hit && (!are_lone || self.impacts.has_restitution);
        if may_hit || self.settings.is_exact() {
            let count = self.contacts.points.len();
            self.impacts.points.resize(count, PointImpact::default());
        }
    }

    /// Forgets the step before, but not who is where.
    fn clear(&mut self) {
        self.bodies.extents.clear();
        self.bodies.inertias.clear();
        self.impacts.points.clear();
        self.bonds.constraints.clear();
        self.bodies.velocities.clear();
        self.bodies.displacements.clear();
        self.bodies.masses.clear();
        self.bodies.turning.clear();
        self.contacts.moving.clear();
        self.impacts.limits.clear();
        self.impacts.overloaded.clear();
        self.impacts.cracks.clear();
        self.impacts.strains.clear();
        self.impacts.is_broken = false;
        self.lone.clear();
    }

    /// Copies the bodies, and adds a dummy one.
    fn load_bodies(&mut self, bodies: &Bodies, team: Option<&Team>) {
        let (cuts, mut slots) = (&self.layout.cuts, &self.layout.slots[..]);
        self.bodies
            .velocities
            .resize(slots.len() + 1, SolverBody::default());
        self.bodies
            .masses
            .resize(slots.len() + 1, BodyMass::new(0.0, &Mat3::ZERO, 1.0));
        let parts = parts_by_body(&mut self.bodies.velocities, cuts);
        let parts = parts.zip(parts_by_body(&mut self.bodies.masses, cuts));
        let parts = parts.map(|part| {
            let count = part.0.len().min(slots.len());
            (front(&mut slots, count), part)
        });
        Team::each(team, parts, |(slots, part)| {
            let copies = part.0.iter_mut().zip(part.1.iter_mut());
            for (&slot, (body, mass)) in slots.iter().zip(copies) {
                let i = slot as usize;
                *body = bodies.velocity[i];
                *mass = BodyMass::new(
                    body.inverse_mass,
                    &bodies.inverse_inertia[i],
                    bodies.min_extent[i],
                );
            }
        });
    }

    /// Makes the copies.
    fn load_copies(&mut self) {
        for &original in &self.layout.originals {
            self.bodies
                .velocities
                .push(self.bodies.velocities[original.index()]);
            self.bodies
                .masses
                .push(self.bodies.masses[original.index()]);
        }
        let count = self.bodies.velocities.len();
        self.bodies
            .displacements
            .resize(count, SolverBody::default());
    }

    /// Finds the largest extent that a contact of an island is measured by, if there is a tolerance that depends on it.
    fn measure(&mut self, member: usize, team: Option<&Team>) {
        if self.settings.tolerance.is_none() {
            return;
        }
        let member = &self.layout.members[member];
        let pairs = &self.layout.pairs[member.places.clone()];
        let masses = &self.bodies.masses;
        let extent = |pair: &[BodyNumber; 2]| {
            let [a, b] = pair.map(|number| masses[number.index()].extent());
            a.min(b)
        };
        let size = Team::part_size(team, pairs.len(), MIN_MEASURED_PAIRS);
        let mut most = [0.0; MAX_PARTS];
        let parts = pairs.chunks(size).zip(&mut most);
        Team::each(team, parts, |(pairs, most)| {
            *most = pairs.iter().map(extent).fold(0.0, f32::max);
        });
        self.bodies
            .extents
            .push(most.into_iter().fold(0.0, f32::max));
    }

    /// Lists the bodies of an island that turn.
    fn load_turning(&mut self, member: usize, bodies: &Bodies) {
        let step = self.settings.step_dt();
        for number in self.layout.members[member].bodies.clone() {
            // Most do not, which is seen without a look at far memory.
            if !FreeRotation::is_noticeable(self.bodies.velocities[number].angular, step) {
                continue;
            }
            let slot = self.layout.slots[number];
            if let Some(spin) = bodies.spin(slot, step) {
                let own = bodies.velocity[slot as usize].inverse_mass;
                let scale = self.bodies.velocities[number].inverse_mass / own;
                self.bodies.turning.push(TurningBody {
                    body: number as u32,
                    start: spin.rotation,
                    spin,
                    inverse_inertia: scale * bodies.mass(slot).inverse_inertia(),
                    is_jointed: false,
                    is_round: bodies.is_round(slot),
                    followed: Vec3::ZERO,
                });
            }
        }
    }

    /// Lists the manifolds of an island whose rows follow the motion. `firsts`: the first of its manifolds among those of all
    /// islands, and among those of the batch.
    fn load_moving(&mut self, moving: &[MovingPair], firsts: [usize; 2], bodies: &Bodies) {
        for pair in moving {
            let at = pair.at - firsts[0] + firsts[1];
            let (manifold, place) = self.layout.places[at];
            let numbers = self.layout.pairs[at];
            let slots = numbers.map(|number| self.layout.slots[number.index()] as usize);
            let anchor_body = anchor_body(slots, bodies);
            let extent = bodies.min_extent[slots[anchor_body]];
            self.contacts.moving.push(MovingManifold {
                manifold,
                place,
                bodies: numbers,
                anchor_body,
                ccd_radius: pair.is_fast.then_some(0.5 * extent),
            });
        }
    }

    /// Lists the blocks, and marks the lanes and the bodies, of moving manifolds.
    fn mark_reanchored(&mut self) {
        self.contacts.reanchored.clear();
        self.mark_reanchored_bodies();
        if self.contacts.moving.is_empty() {
            return;
        }
        self.list_reanchored_blocks();
        let number = &self.contacts.reanchored_number;
        for moving in &self.contacts.moving {
            let (place, lane) = (moving.place, moving.place.lane as usize);
            let Some(number) = number[place.block as usize] else {
                continue;
            };
            let reanchored = &mut self.contacts.reanchored[number as usize];
            reanchored.moves.0[lane] = 1.0;
            reanchored.on_b.0[lane] = f32::from(moving.anchor_body == 1);
        }
    }

    /// Marks the bodies of moving manifolds, and of those the ones that turn.
    fn mark_reanchored_bodies(&mut self) {
        let is_reanchored = &mut self.contacts.is_reanchored;
        let has_new_inertia = &mut self.contacts.has_new_inertia;
        is_reanchored.clear();
        has_new_inertia.clear();
        if !self.bodies.turning.is_empty() {
            has_new_inertia.resize(self.bodies.velocities.len(), false);
        }
        if self.contacts.moving.is_empty() {
            return;
        }
        // Rows may name copies of fixed bodies.
        let bodies = self.bodies.velocities.iter();
        is_reanchored.extend(bodies.map(|body| body.inverse_mass == 0.0));
        for body in self.contacts.moving.iter().flat_map(|moving| moving.bodies) {
            is_reanchored[body.index()] = true;
        }
        for turning in &self.bodies.turning {
            has_new_inertia[turning.body as usize] = is_reanchored[turning.body as usize];
        }
    }

    /// Lists the blocks of moving manifolds, and of bodies whose inertia turns with them: rows whose masses are of another inertia than
    /// the one that impulses act on make sweeps grow without bound, of a rod of 1 : 700 from a turn of some 2e-3 rad on.
    fn list_reanchored_blocks(&mut self) {
        let number = &mut self.contacts.reanchored_number;
        number.clear();
        number.resize(self.contacts.blocks.len(), None);
        let has_new_inertia = &self.contacts.has_new_inertia;
        let pairs = self.layout.places.iter().zip(&self.layout.pairs);
        for (&(_, place), pair) in pairs {
            if pair
                .iter()
                .any(|body| has_new_inertia.get(body.index()) == Some(&true))
            {
                number[place.block as usize] = Some(0);
            }
        }
        for moving in &self.contacts.moving {
            number[moving.place.block as usize] = Some(0);
        }
        let mut points = 0;
        let named = (0..).zip(number.iter_mut().zip(&self.contacts.blocks));
        for (block, (number, named)) in named.filter(|(_, (number, _))| number.is_some()) {
            *number = Some(self.contacts.reanchored.len() as u32);
            let first = points;
            points += named.points.len() as u32;
            self.contacts.reanchored.push(ReanchoredBlock {
                block,
                starts: [first, points],
                ..ReanchoredBlock::default()
            });
        }
        self.contacts
            .anchor_starts
            .resize(points as usize, AnchorStart::default());
    }

    fn fill_blocks(&mut self, manifolds: &Manifolds, team: Option<&Team>) {
        let settings = &self.settings;
        let source = Source {
            manifolds,
            masses: &self.bodies.masses,
            share: 1.0 / settings.substeps as f32,
            slop: settings.slop,
        };
        let width = settings.lane_width;
        let (mut reanchored, mut starts, mut curvatures) = (
            ReanchoredBlocks::new(&self.contacts.reanchored),
            &mut self.contacts.anchor_starts[..],
            &mut self.contacts.curvatures[..],
        );
        let is_round = !curvatures.is_empty();
        let (blocks, points) = (&mut self.contacts.blocks, &mut self.contacts.points);
        let parts = parts_of_blocks(blocks, points, &self.layout.subdomains, team);
        let parts = parts.map(|(blocks, points)| {
            let reanchored = reanchored.take(blocks.len());
            let starts = front_mut(&mut starts, reanchored.points());
            let round_points = if is_round { starts.len() } else { 0 };
            let curvatures = front_mut(&mut curvatures, round_points);
            (blocks, points, reanchored, starts, curvatures)
        });
        Team::each(team, parts, |part| {
            let (blocks, points, reanchored, starts, curvatures) = part;
            fill(blocks, points, source, width);
            reanchored.start(blocks, points, starts);
            if is_round {
                reanchored.load_curvatures(blocks, manifolds, curvatures);
            }
        });
    }
}
