//! What a fracture did to mass, momentum, angular momentum and energy.

use crate::bodies::body::{BodyDesc, Shape};
use crate::bodies::store::Bodies;
use crate::mass::VolumeIntegrals;
use glam::{DMat3, DVec3, Quat, Vec3};

/// Sums over one or several bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Invariants {
    /// kg.
    pub mass: f64,
    /// Linear momentum, N s.
    pub momentum: DVec3,
    /// Angular momentum about the parent's center of mass as it moves, N m s.
    pub angular_momentum: DVec3,
    /// Kinetic energy, J.
    pub kinetic_energy: f64,
    /// Sum of `|m v|` over the bodies, N s: what momentum errors are relative to.
    momentum_scale: f64,
    /// Sum of `|r x m v| + |I omega|`, N m s: what errors of angular momentum are relative to.
    angular_scale: f64,
}

impl Invariants {
    /// Adds the body in `slot`.
    pub(super) fn add_body(&mut self, bodies: &Bodies, slot: u32, reference: &Reference) {
        let properties = bodies.mass(slot);
        let frame = bodies.pose(slot).rotation * properties.principal_frame;
        let inertia = turned(DMat3::from_diagonal(properties.principal.as_dvec3()), frame);
        let center = bodies.center_of_mass(slot);
        let velocity = bodies.velocity(slot);
        self.add(&reference.of_rigid(properties.mass.into(), center, inertia, velocity));
    }

    /// Sums of a piece that does not become a body, whose frame is about its centroid; nothing of what is no piece.
    pub(super) fn of_piece(desc: &BodyDesc, reference: &Reference) -> Self {
        let integrals = match &desc.shape {
            Shape::Convex(mesh) => VolumeIntegrals::of_shape(mesh),
            Shape::Compound(compound) => VolumeIntegrals::of_compound(compound),
            Shape::HalfSpace(_) | Shape::Level(_) => return Self::default(),
        };
        let density = f64::from(desc.density);
        let inertia = turned(integrals.inertia * density, desc.pose.rotation);
        let velocity = (desc.linear_velocity, desc.angular_velocity);
        let mass = integrals.volume * density;
        reference.of_rigid(mass, desc.pose.position, inertia, velocity)
    }

    /// Adds other sums about the same point.
    pub fn add(&mut self, other: &Self) {
        self.mass += other.mass;
        self.momentum += other.momentum;
        self.angular_momentum += other.angular_momentum;
        self.kinetic_energy += other.kinetic_energy;
        self.momentum_scale += other.momentum_scale;
        self.angular_scale += other.angular_scale;
    }

    /// Takes away sums over some of the bodies about the same point. The scales of errors stay.
    pub(super) fn take(&mut self, other: &Self) {
        self.mass -= other.mass;
        self.momentum -= other.momentum;
        self.angular_momentum -= other.angular_momentum;
        self.kinetic_energy -= other.kinetic_energy;
    }
}

/// The parent's center of mass, as it moves: what angular momentum is about.
///
/// Where bodies stand is rounded to `f32` as the world is. Seen from a world at rest, that much of a lever times the whole momentum
/// would count as angular momentum, however slowly the body turns.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reference {
    /// World, m.
    center: DVec3,
    /// m/s.
    velocity: DVec3,
}

impl Reference {
    pub(super) fn of(bodies: &Bodies, parent: u32) -> Self {
        Self {
            center: bodies.center_of_mass(parent).as_dvec3(),
            velocity: bodies.velocity(parent).0.as_dvec3(),
        }
    }

    /// Sums of a rigid body: `center` in the world (m), `inertia` about it, along world axes.
    fn of_rigid(
        &self,
        mass: f64,
        center: Vec3,
        inertia: DMat3,
        (v, omega): (Vec3, Vec3),
    ) -> Invariants {
        let (v, omega) = (v.as_dvec3(), omega.as_dvec3());
        let lever = center.as_dvec3() - self.center;
        let (orbit, spin) = (lever.cross(mass * (v - self.velocity)), inertia * omega);
        Invariants {
            mass,
            momentum: mass * v,
            angular_momentum: orbit + spin,
            kinetic_energy: 0.5 * (mass * v.length_squared() + omega.dot(spin)),
            momentum_scale: mass * v.length(),
            angular_scale: lever.cross(mass * v).length() + spin.length(),
        }
    }
}

/// Before and after of one fracture. What was there before is in `after` or in `dropped`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Ledger {
    /// The parent.
    pub before: Invariants,
    /// The pieces that were spawned.
    pub after: Invariants,
    /// The pieces that were too small to be spawned, and the air between parts that came apart.
    pub dropped: Invariants,
    /// How many pieces were dropped.
    pub dropped_pieces: u32,
}

impl Ledger {
    /// Counts what came of one of those after it, which broke too, in its place.
    pub(crate) fn go_on(&mut self, later: &Self) {
        self.after.add(&later.after);
        self.after.take(&later.before);
        self.dropped.add(&later.dropped);
        self.dropped_pieces += later.dropped_pieces;
    }

    fn accounted(&self) -> Invariants {
        let mut sum = self.after;
        sum.add(&self.dropped);
        sum
    }

    /// Momentum of the parent that is nowhere, N s.
    pub(super) fn missing_momentum(&self) -> DVec3 {
        self.before.momentum - self.accounted().momentum
    }

    /// `|after + dropped - before| / before` of the mass: at most 1e-6.
    ///
    /// Corners of pieces are rounded to `f32`. Where that takes or gives more than half of this, because the body is hardly thicker than
    /// the rounding, the density of the pieces makes up for it.
    pub fn mass_error(&self) -> f64 {
        relative(
            (self.accounted().mass - self.before.mass).abs(),
            self.before.mass,
        )
    }

    /// Error of the momentum, relative to the sum of the pieces' `|m v|`: at most 1e-5.
    ///
    /// Where centroids of pieces are rounded so much that it would be more than half of this, a velocity, the same for all pieces, makes
    /// up for it.
    pub fn momentum_error(&self) -> f64 {
        let sum = self.accounted();
        relative(
            (sum.momentum - self.before.momentum).length(),
            sum.momentum_scale,
        )
    }

    /// Error of the angular momentum about the parent's center as it moves, relative to the sum of the pieces' own in the world.
    ///
    /// No more than rounding of `f32` positions and velocities makes it. Near the origin that is below 1e-5 for a body that is not
    /// thinner than a hundredth of its length and for two generations of its pieces; of the third, splinters of some millimetres may
    /// exceed it. At 100 m pieces smaller than a centimetre may, and at 10 km, where positions are a millimetre apart, most do.
    pub fn angular_momentum_error(&self) -> f64 {
        let sum = self.accounted();
        relative(
            (sum.angular_momentum - self.before.angular_momentum).length(),
            sum.angular_scale,
        )
    }

    /// `(after + dropped - before) / before` of the kinetic energy; positive if energy was gained.
    ///
    /// Pieces move as the parts of the body did, so that this is rounding, near the origin below 1e-5 as the error of the angular momentum
    /// is. What it takes to break a body is taken by the solve, before ([`BreakingImpact::borne_energy`](crate::fracture::BreakingImpact::borne_energy)).
    pub fn energy_gain(&self) -> f64 {
        let gained = self.accounted().kinetic_energy - self.before.kinetic_energy;
        relative(gained, self.before.kinetic_energy)
    }
}

/// `inertia` along the axes of the outer frame of `rotation`.
fn turned(inertia: DMat3, rotation: Quat) -> DMat3 {
    let turn = DMat3::from_quat(rotation.as_dquat().normalize());
    turn * inertia * turn.transpose()
}

fn relative(error: f64, scale: f64) -> f64 {
    if scale > 0.0 { error / scale } else { error }
}
