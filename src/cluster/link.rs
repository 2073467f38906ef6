//! A part and a bond in the instant of a blow.

use crate::cluster::hit::Push;
use crate::cluster::network::Network;
use crate::geometry::PartBond;
use glam::{Mat3, Vec3};

/// Share of the way to breaking up to which a bond is elastic; it yields for the rest, so that the work is force times way.
const ELASTIC: f32 = 0.5;

/// A part in the instant of the blow, relative to the motion of the cluster.
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    pub(super) inverse_mass: f32,
    pub(super) inverse_inertia: Mat3,
    pub(super) mass: f32,
    pub(super) inertia: Mat3,
    pub(super) velocity: Vec3,
    pub(super) angular: Vec3,
    pub(super) displacement: Vec3,
    pub(super) turn: Vec3,
    pub(super) force: Vec3,
    pub(super) torque: Vec3,
}

/// A corner of a bonded face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// From the centers of both parts, m.
    pub(super) arms: [Vec3; 2],
    /// How far it has yielded: opened, and slid, m.
    pub(super) opened: f32,
    pub(super) slid: Vec3,
}

/// A bond in the instant of the blow.
#[derive(Debug)]
pub(super) struct Link {
    pub(super) bond: u32,
    pub(super) bodies: [u32; 2],
    pub(super) normal: Vec3,
    pub(super) corners: [Corner; 4],
    /// Of a corner, N/m.
    pub(super) stiffness: f32,
    /// What a corner bears in tension and in shear, N.
    pub(super) limits: [f32; 2],
    /// Share of what it bears from which on it is strained; infinite if nobody asks.
    pub(super) strained_from: f32,
    /// The most that a corner bore, as a share of what it can, if somebody asks.
    pub(super) peak: f32,
    /// How far it may yield, m.
    pub(super) way: f32,
    /// Energy that breaking it takes, or straining it if somebody asks for that, J.
    pub(super) energy: f32,
    pub(super) is_broken: bool,
}

impl Body {
    /// One that nothing moves.
    pub(super) const FIXED: Self = Self {
        inverse_mass: 0.0,
        inverse_inertia: Mat3::ZERO,
        mass: 0.0,
        inertia: Mat3::ZERO,
        velocity: Vec3::ZERO,
        angular: Vec3::ZERO,
        displacement: Vec3::ZERO,
        turn: Vec3::ZERO,
        force: Vec3::ZERO,
        torque: Vec3::ZERO,
    };

    pub(super) fn of(network: &Network, part: u32, is_held: bool) -> Self {
        if is_held {
            return Self::FIXED;
        }
        let node = &network.nodes[part as usize];
        Self {
            mass: node.mass as f32,
            inertia: node.inertia.as_mat3(),
            inverse_mass: node.mass.recip() as f32,
            inverse_inertia: node.inverse_inertia,
            ..Self::FIXED
        }
    }

    /// Is pushed.
    pub(super) fn take(&mut self, push: &Push) {
        self.velocity += self.inverse_mass * push.impulse;
        self.angular += self.inverse_inertia * push.angular_impulse;
    }

    /// Symplectic Euler.
    pub(super) fn advance(&mut self, h: f32) {
        self.velocity += h * self.inverse_mass * self.force;
        self.angular += self.inverse_inertia * (h * self.torque);
        self.displacement += h * self.velocity;
        self.turn += h * self.angular;
        (self.force, self.torque) = (Vec3::ZERO, Vec3::ZERO);
    }
}

/// What a corner of a bonded face bears in tension and in shear, N, and its stiffness, N/m. `opening`: how far the bond opens before it is
/// broken, m.
fn corner(bond: &PartBond, opening: f32) -> ([f32; 2], f32) {
    let limits = bond.strengths().map(|s| 0.25 * s * bond.area);
    (limits, limits[0].max(limits[1]) / (ELASTIC * opening))
}

/// Share of what is left of a bond's strength with which it is strained: `endurance` is one of its whole strength.
fn strained_share(bond: &PartBond, endurance: f32) -> f32 {
    let left = 1.0 - bond.damage;
    endurance.min(left) / left
}

/// Energy that it takes at least to strain a bond: that of one corner, as a spring, J.
pub(super) fn strain_energy(bond: &PartBond, opening: f32, endurance: f32) -> f32 {
    let (limits, stiffness) = corner(bond, opening);
    let force = strained_share(bond, endurance) * limits[0].min(limits[1]);
    0.5 * force * force / stiffness
}

impl Link {
    /// `endurance`: share of its whole strength from which on it is strained, infinite if nobody asks; what makes it yield strains it too.
    pub(super) fn of(
        network: &Network,
        bond: u32,
        endurance: f32,
        place: impl Fn(u32) -> u32,
    ) -> Self {
        let shape = &network.bonds[bond as usize];
        let opening = network.openings[bond as usize];
        let centers = shape
            .parts
            .map(|part| network.nodes[part as usize].center.as_vec3());
        let (limits, stiffness) = corner(shape, opening);
        let is_asked = endurance.is_finite();
        let breaking = limits[0].min(limits[1]) * opening;
        Self {
            bond,
            bodies: shape.parts.map(place),
            normal: shape.normal,
            corners: Network::corners(shape).map(|at| Corner {
                arms: centers.map(|center| at - center),
                opened: 0.0,
                slid: Vec3::ZERO,
            }),
            stiffness,
            limits,
            strained_from: if is_asked {
                strained_share(shape, endurance)
            } else {
                f32::INFINITY
            },
            peak: 0.0,
            way: (1.0 - 0.5 * ELASTIC) * opening,
            energy: if is_asked {
                strain_energy(shape, opening, endurance)
            } else {
                breaking
            },
            is_broken: false,
        }
    }
}

impl Link {
    /// Whether it has been loaded beyond its endurance.
    pub(super) fn is_strained(&self) -> bool {
        self.peak > 0.0 && self.peak >= self.strained_from
    }

    /// Notes what a corner pulls with, along the normal and across, N.
    pub(super) fn note_load(&mut self, friction: f32, (pull, shear): (f32, Vec3)) {
        if self.strained_from == f32::INFINITY {
            return;
        }
        let across = self.limits[1] + friction * (-pull).max(0.0);
        let share = (pull / self.limits[0]).max(shear.length() / across);
        // Rounding of a corner that yields.
        self.peak = self.peak.max(if share > 0.999 { 1.0 } else { share });
    }
}

impl Corner {
    /// Its pull on the first part, along the normal and across, N, if it is open and slid so far; it yields where that is more than it
    /// bears. And the work that this takes, J.
    pub(super) fn yielding(
        &mut self,
        stiffness: f32,
        limits: [f32; 2],
        friction: f32,
        (open, across): (f32, Vec3),
    ) -> ((f32, Vec3), f32) {
        let mut work = 0.0;
        let mut pull = stiffness * (open - self.opened);
        if pull > limits[0] {
            let more = (pull - limits[0]) / stiffness;
            self.opened += more;
            work += limits[0] * more;
            pull = limits[0];
        }
        let mut shear = stiffness * (across - self.slid);
        let most = limits[1] + friction * (-pull).max(0.0);
        let size = shear.length();
        if size > most {
            let more = (size - most) / stiffness;
            self.slid += shear * (more / size);
            work += most * more;
            shear *= most / size;
        }
        ((pull, shear), work)
    }
}
