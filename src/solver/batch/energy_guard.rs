//! Contacts give no energy to an island, solved to the end or not.
//!
//! What pushes overlap out of a sub-step is taken from the velocities again when the bodies have moved. Where sweeps end too
//! early, as under a heavy body on light ones, part of it stays: a ball of 155 kg that a stack of laths of 2.4 kg had stopped
//! was thrown back at 6 m/s. With velocities `v_0` before the contacts of the sub-step and `v_0 + g` after, in which
//! `g = M^-1 J^T lambda`, a share `s` of all their impulses leaves the kinetic energy
//!
//! ```text
//! E(s) = E_0 + s g.M v_0 + s^2 g.M g / 2
//! ```
//!
//! If `E(1)` is more than `E_0`, and more than the bodies would get by falling freely for a step, all impulses of the island
//! are taken times the `s` that makes it the larger of these: momentum is kept, and friction stays within its bound. Below,
//! bodies are all but at rest; what is left then of loads that still spread through a large pile is more than they fall with
//! in a sub-step, and a pyramid of 50 rows that was denied it sank by a tenth of a cube instead of a hundredth.
//!
//! Where joints give the bodies `g_j` in the same sub-step, motors and springs among them may give energy, and contacts are asked for
//! their own part alone: the work of their impulses at the mean of the velocities before and after, `g.M (v_0 + (g + g_j) / 2)`. With a share of
//! the impulses goes a share of what joints answered them with, so that in `E(s)` the last term has `g.M (g + g_j)`. Joints are solved
//! once more behind it.

use crate::bodies::solver_body::{BodyMass, SolverBody};
use crate::solver::batch::Batch;
use crate::solver::batch::layout::Member;
use crate::solver::graph::indices::LaneSlot;
use crate::threads::team::Team;
use crate::tuning::{MAX_LEAVES, MAX_PARTS, MIN_MEASURED_BODIES};
use glam::{Mat3, Vec3};
use std::ops::{Add, Range};

/// A closer look is taken where bodies may have more than this share of the energy that is allowed for linear motion alone.
const SUSPICIOUS: f64 = 0.5;

/// Sums over the bodies of an island: kg, J.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    mass: f64,
    /// `g.M v_0`
    work: f64,
    /// `g.M g`
    square: f64,
    /// `v_1.M v_1`, where `v_1 = v_0 + g`
    after: f64,
}

/// [`Sums`] of linear motion alone, by axis, to some 1e-4: enough to tell most islands from those that need a closer look.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LinearSums {
    mass: f32,
    /// `m g v_1`
    with_gain: Vec3,
    square: Vec3,
    after: Vec3,
    /// `m w_1^2`, for the angular velocity.
    spin: Vec3,
}

impl LinearSums {
    /// Adds what a body that is at `now` has gained.
    #[inline(always)]
    pub(crate) fn add(&mut self, now: &SolverBody, gain: &SolverBody) {
        let mass = mass_of(now);
        let momentum = mass * gain.linear;
        self.mass += mass;
        self.with_gain += momentum * now.linear;
        self.square += momentum * gain.linear;
        self.after += mass * now.linear * now.linear;
        self.spin += mass * now.angular * now.angular;
    }

    /// Whether so little energy is left that it cannot be more than is allowed. `inertia`: largest moment of inertia of a body over
    /// its mass, m2; `speed`: see [`Sums::allowed`].
    fn are_fine(&self, inertia: f32, speed: f32) -> bool {
        let total = self.total();
        let spin = f64::from(inertia) * f64::from(self.spin.element_sum());
        total.after + spin <= SUSPICIOUS * total.allowed(speed, 0.0)
    }

    fn total(&self) -> Sums {
        let [with_gain, square, after] =
            [self.with_gain, self.square, self.after].map(|v| f64::from(v.element_sum()));
        Sums {
            mass: self.mass.into(),
            work: with_gain - square,
            square,
            after,
        }
    }
}

impl Add for LinearSums {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            with_gain: self.with_gain + other.with_gain,
            square: self.square + other.square,
            after: self.after + other.after,
            spin: self.spin + other.spin,
        }
    }
}

impl Add for Sums {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            work: self.work + other.work,
            square: self.square + other.square,
            after: self.after + other.after,
        }
    }
}

impl Sums {
    /// Adds momenta and velocities, those gained and those after.
    #[inline(always)]
    fn add_body(&mut self, momentum: [Vec3; 2], velocity: [Vec3; 2]) {
        let square = f64::from(momentum[0].dot(velocity[0]));
        self.work += f64::from(momentum[0].dot(velocity[1])) - square;
        self.square += square;
        self.after += f64::from(momentum[1].dot(velocity[1]));
    }

    /// `v_0.M v_0`
    fn before(&self) -> f64 {
        self.after - 2.0 * self.work - self.square
    }

    /// Twice the energy that is allowed: what it was, less what the bodies were given by being lifted, or that of `speed`, m/s.
    fn allowed(&self, speed: f32, lift: f64) -> f64 {
        let before = self.before() - 2.0 * lift;
        before.max(self.mass * f64::from(speed * speed))
    }

    /// If there is more energy after than is allowed: twice what is to spare, which is not negative but for lifts, and the root of the
    /// equation for the share.
    fn excess(&self, speed: f32, lift: f64) -> Option<(f64, f64)> {
        let allowed = self.allowed(speed, lift);
        if self.after <= allowed {
            return None;
        }
        let spare = allowed - self.before();
        let root = (self.work * self.work + self.square * spare)
            .max(0.0)
            .sqrt();
        Some((spare, root))
    }

    /// The share of the impulses that leaves no more energy than is allowed.
    fn share(&self, speed: f32, lift: f64) -> f64 {
        match self.excess(speed, lift) {
            None => 1.0,
            Some((_, root)) => ((root - self.work) / self.square).clamp(0.0, 1.0),
        }
    }

    /// As [`share`](Self::share), where joints gave something too: `work` is `g.M v_0` and `square` `g.M (g + g_j)` then.
    fn share_beside_joints(&self, speed: f32, lift: f64) -> f64 {
        let Some((spare, root)) = self.excess(speed, lift) else {
            return 1.0;
        };
        // Joints may take all that contacts give, so nothing is divided by the square.
        let share = if self.work > 0.0 {
            spare / (root + self.work)
        } else {
            (root - self.work) / self.square
        };
        if share.is_finite() {
            share.clamp(0.0, 1.0)
        } else {
            1.0
        }
    }
}

impl Batch {
    /// Whether contacts are to add no energy: other methods leave in the velocities what pushes overlap out.
    pub(crate) fn is_passive(&self) -> bool {
        self.settings.is_relaxed()
    }

    /// Takes the impulses of an island, whose gains are known, times the share that adds no energy. `linear`: sums of linear
    /// motion alone; `island`: its number within the batch.
    pub(crate) fn guard_energy(
        &mut self,
        island: usize,
        member: &Member,
        linear: &LinearSums,
        team: Option<&Team>,
    ) {
        let speed = self.settings.gravity.length() * self.settings.step_dt();
        let inertia = self
            .bodies
            .inertias
            .get(island)
            .copied()
            .unwrap_or(f32::INFINITY);
        let is_jointed = !member.joints.is_empty();
        let is_fine = !is_jointed && linear.are_fine(inertia, speed);
        if is_fine || !self.is_passive() || self.is_driven(member) {
            return;
        }
        let lift = self.impacts.lifts.get(island).copied().unwrap_or(0.0);
        let mut sums = self.sums(member, team);
        let share = if is_jointed {
            self.add_joints(&mut sums, member);
            sums.share_beside_joints(speed, lift)
        } else {
            sums.share(speed, lift)
        };
        if share < 1.0 {
            self.scale_impulses(member, share as f32);
            self.joints.is_disturbed |= is_jointed;
        }
    }

    /// Takes into account what joints gave to the bodies while contacts did.
    fn add_joints(&self, sums: &mut Sums, member: &Member) {
        for (number, [linear, angular]) in self.given_by_joints(member) {
            let i = number.index();
            let gain = &self.bodies.contact_velocity_changes[i];
            let mut cross =
                f64::from(mass_of(&self.bodies.velocities[i]) * gain.linear.dot(linear));
            if let Some(inertia) = inertia_of(&self.bodies.masses[i]) {
                cross += f64::from((inertia * gain.angular).dot(angular));
            }
            sums.work -= cross;
            sums.square += cross;
        }
    }

    /// Finds the largest moment of inertia over mass of an island's bodies.
    pub(crate) fn measure_inertia(&mut self, member: usize, team: Option<&Team>) {
        if !self.is_passive() {
            return;
        }
        let solids = &self.bodies.masses[self.layout.members[member].bodies.clone()];
        let size = Team::part_size(team, solids.len(), MIN_MEASURED_BODIES);
        let mut most = [0.0; MAX_PARTS];
        let parts = solids.chunks(size).zip(&mut most);
        Team::each(team, parts, |(solids, most)| {
            *most = solids.iter().map(inertia_over_mass).fold(0.0, f32::max);
        });
        self.bodies
            .inertias
            .push(most.into_iter().fold(0.0, f32::max));
    }

    /// Whether bodies that contacts do not move, but that move or whose surfaces run, may give energy.
    pub(super) fn is_driven(&self, member: &Member) -> bool {
        let moves = |body: &SolverBody| body.linear != Vec3::ZERO || body.angular != Vec3::ZERO;
        // Contacts move those in leaves.
        let leaves = self.layout.cuts.leaves();
        let first = leaves.last().map_or(member.bodies.start, |leaf| leaf.end);
        let mut bodies = self.bodies.velocities[first..member.bodies.end].iter();
        bodies.any(|body| body.inverse_mass == 0.0 && moves(body)) || self.has_running(member)
    }

    /// Whether an island touches running surfaces.
    fn has_running(&self, member: &Member) -> bool {
        let constraints = &self.bonds.constraints;
        let is_running = |place: &LaneSlot| {
            let points = self.contacts.blocks[place.block as usize].points.clone();
            let of_place = &constraints[points];
            of_place.iter().any(|it| it.is_running(place.lane as usize))
        };
        let mut places = self.layout.places[member.places.clone()].iter();
        !constraints.is_empty() && places.any(|(_, place)| is_running(place))
    }

    fn sums(&self, member: &Member, team: Option<&Team>) -> Sums {
        let cuts = &self.layout.cuts;
        if cuts.leaves().is_empty() {
            return self.sums_of(member.bodies.clone());
        }
        let mut sums = [Sums::default(); MAX_LEAVES];
        let parts = cuts.slices_of_bodies(member.bodies.len()).zip(&mut sums);
        Team::each(team, parts, |(bodies, sums)| *sums = self.sums_of(bodies));
        sums.into_iter().fold(Sums::default(), Sums::add)
    }

    fn sums_of(&self, bodies: Range<usize>) -> Sums {
        let mut sums = Sums::default();
        for i in bodies {
            let (gain, now, solid) = (
                &self.bodies.contact_velocity_changes[i],
                &self.bodies.velocities[i],
                &self.bodies.masses[i],
            );
            let mass = mass_of(now);
            sums.mass += f64::from(mass);
            let velocities = [gain.linear, now.linear];
            sums.add_body(velocities.map(|v| mass * v), velocities);
            if let Some(inertia) = inertia_of(solid) {
                let velocities = [gain.angular, now.angular];
                sums.add_body(velocities.map(|v| inertia * v), velocities);
            }
        }
        sums
    }

    fn scale_impulses(&mut self, member: &Member, share: f32) {
        let contact_velocity_changes =
            &mut self.bodies.contact_velocity_changes[member.bodies.clone()];
        for (body, gain) in self.bodies.velocities[member.bodies.clone()]
            .iter_mut()
            .zip(contact_velocity_changes)
        {
            body.linear -= (1.0 - share) * gain.linear;
            body.angular -= (1.0 - share) * gain.angular;
            gain.linear *= share;
            gain.angular *= share;
        }
        for &(_, place) in &self.layout.places[member.places.clone()] {
            let lane = place.lane as usize;
            let points = self.contacts.blocks[place.block as usize].points.clone();
            for point in &mut self.contacts.points[points] {
                point.impulse.iter_mut().for_each(|x| x.0[lane] *= share);
            }
        }
    }
}

/// The sum of the principal moments, which no moment is above, over the mass, m2; from the invariants of the inverse tensor: with
/// principal moments `a`, `b`, `c` the sum of its minors is `(a + b + c) / (a b c)`.
fn inertia_over_mass(body: &BodyMass) -> f32 {
    let [xx, yy, zz, xy, xz, yz, inverse_mass, _] = body.0.0;
    let minors = [yy * zz - yz * yz, xx * zz - xz * xz, xx * yy - xy * xy];
    let determinant = xx * minors[0] + xy * (xz * yz - xy * zz) + xz * (xy * yz - xz * yy);
    if determinant > 0.0 {
        inverse_mass * (minors[0] + minors[1] + minors[2]) / determinant
    } else {
        0.0
    }
}

/// Inertia tensor, kg m2; none of bodies that contacts do not turn.
#[inline(always)]
pub(super) fn inertia_of(body: &BodyMass) -> Option<Mat3> {
    let inverse = body.inverse_inertia();
    // Of what is smaller the reciprocal is not finite.
    (inverse.determinant() >= f32::MIN_POSITIVE).then(|| inverse.inverse())
}

/// Mass, kg; zero where contacts give nothing.
#[inline(always)]
pub(super) fn mass_of(body: &SolverBody) -> f32 {
    if body.inverse_mass > 0.0 {
        body.inverse_mass.recip()
    } else {
        0.0
    }
}
