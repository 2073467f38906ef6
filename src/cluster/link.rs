//! A part and a bond in the instant of a blow.

use crate::cluster::hit::Push;
use crate::cluster::network::Network;
use crate::geometry::PartBond;
use crate::simd::float4::{higher, lower};
use crate::simd::vec3::V3;
use glam::{Mat3, Vec3, Vec4};

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

/// The corners of a bonded face, one in each lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corners {
    /// From the centers of both parts, m.
    pub(super) arms: [V3<Vec4>; 2],
    /// How far they have yielded: opened, and slid, m.
    opened: Vec4,
    slid: V3<Vec4>,
}

/// A bond in the instant of the blow.
#[derive(Debug)]
pub(super) struct Link {
    pub(super) bond: u32,
    pub(super) bodies: [u32; 2],
    pub(super) normal: Vec3,
    pub(super) corners: Corners,
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

    /// Makes it heavier; it keeps its momentum.
    pub(super) fn enlarge(&mut self, factor: f32) {
        self.mass *= factor;
        self.inertia *= factor;
        self.inverse_mass /= factor;
        self.inverse_inertia *= factor.recip();
        self.velocity /= factor;
        self.angular /= factor;
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
        let corners = Network::corners(shape);
        let (limits, stiffness) = corner(shape, opening);
        let is_asked = endurance.is_finite();
        let breaking = limits[0].min(limits[1]) * opening;
        Self {
            bond,
            bodies: shape.parts.map(place),
            normal: shape.normal,
            corners: Corners {
                arms: centers.map(|center| by_axis(corners.map(|at| at - center))),
                opened: Vec4::ZERO,
                slid: splat(Vec3::ZERO),
            },
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

    /// How it pulls at the first part, and the opposite at the second one: a force, and torques on both; and the work that it takes to let it
    /// yield, J. What that tears is broken.
    pub(super) fn pull(&mut self, friction: f32, [a, b]: [&Body; 2]) -> (Vec3, [Vec3; 2], f32) {
        let moved = self.corners.moved([a, b]);
        let normal = splat(self.normal);
        let open = moved.dot(normal);
        let mut work = 0.0;
        let pull = if self.is_broken {
            normal.times(lower(self.stiffness * open, Vec4::ZERO))
        } else {
            let across = moved.minus(normal.times(open));
            let way = (open, across);
            let (pull, shear, done) =
                (self.corners).yielding(self.stiffness, self.limits, friction, way);
            work = sum(done);
            self.is_broken = self.corners.farthest().cmpgt(Vec4::splat(self.way)).any();
            self.note_load(friction, (pull, shear));
            normal.times(pull).plus(shear)
        };
        let pull = finite(pull);
        let [arm_a, arm_b] = self.corners.arms.map(|arm| arm.cross(pull));
        (sums(pull), [sums(arm_a), -sums(arm_b)], work)
    }

    /// Notes what the corners pull with, along the normal and across, N.
    fn note_load(&mut self, friction: f32, (pull, shear): (Vec4, V3<Vec4>)) {
        if self.strained_from == f32::INFINITY {
            return;
        }
        let across = self.limits[1] + friction * higher(-pull, Vec4::ZERO);
        let share = higher(pull / self.limits[0], length(shear) / across);
        let most = share.to_array().into_iter().fold(0.0, f32::max);
        // Rounding of a corner that yields.
        self.peak = self.peak.max(if most > 0.999 { 1.0 } else { most });
    }

    /// What its springs hold, J.
    pub(super) fn held_energy(&self, parts: [&Body; 2]) -> f32 {
        let corners = &self.corners;
        let normal = splat(self.normal);
        let yielded = corners.slid.plus(normal.times(corners.opened));
        let stretched = corners.moved(parts).minus(yielded);
        let energy = 0.5 * self.stiffness * stretched.dot(stretched);
        // Broken, it still holds what is pressed.
        let holds = stretched.dot(normal).cmplt(Vec4::ZERO);
        sum(if self.is_broken {
            Vec4::select(holds, energy, Vec4::ZERO)
        } else {
            energy
        })
    }
}

impl Corners {
    /// How far they have moved apart, m.
    pub(super) fn moved(&self, parts: [&Body; 2]) -> V3<Vec4> {
        let [a, b] = [0, 1].map(|side: usize| {
            let Body {
                displacement, turn, ..
            } = parts[side];
            splat(*displacement).plus(splat(*turn).cross(self.arms[side]))
        });
        b.minus(a)
    }

    /// How far each has yielded in the one or the other way, m.
    fn farthest(&self) -> Vec4 {
        higher(self.opened, length(self.slid))
    }

    /// Their pulls on the first part, along the normal and across, N, if they are open and slid so far; they yield where that is more than they
    /// bear. And the work that this takes, J.
    fn yielding(
        &mut self,
        stiffness: f32,
        limits: [f32; 2],
        friction: f32,
        (open, across): (Vec4, V3<Vec4>),
    ) -> (Vec4, V3<Vec4>, Vec4) {
        let [tension, shear_limit] = limits.map(Vec4::splat);
        let wanted = stiffness * (open - self.opened);
        let opened = higher(wanted - tension, Vec4::ZERO) / stiffness;
        self.opened += opened;
        let pull = lower(wanted, tension);
        let shear = across.minus(self.slid).times(Vec4::splat(stiffness));
        let most = shear_limit + friction * higher(-pull, Vec4::ZERO);
        let size = length(shear);
        let is_over = size.cmpgt(most);
        let slid = higher(size - most, Vec4::ZERO) / stiffness;
        let along = Vec4::select(is_over, slid / size, Vec4::ZERO);
        self.slid = self.slid.plus(shear.times(along));
        let kept = Vec4::select(is_over, most / size, Vec4::ONE);
        (pull, shear.times(kept), tension * opened + most * slid)
    }
}

/// The same vector in all lanes.
fn splat(v: Vec3) -> V3<Vec4> {
    V3(v.to_array().map(Vec4::splat))
}

/// A vector in each lane.
fn by_axis(v: [Vec3; 4]) -> V3<Vec4> {
    let axis = |axis: usize| Vec4::from_array(v.map(|v| v[axis]));
    V3([axis(0), axis(1), axis(2)])
}

pub(super) fn length(v: V3<Vec4>) -> Vec4 {
    v.dot(v).sqrt()
}

/// Zero in lanes that are not finite.
fn finite(v: V3<Vec4>) -> V3<Vec4> {
    let is_finite = v.0.map(Vec4::is_finite_mask);
    let all = is_finite[0] & is_finite[1] & is_finite[2];
    V3(v.0.map(|x| Vec4::select(all, x, Vec4::ZERO)))
}

/// From the first lane to the last.
fn sum(v: Vec4) -> f32 {
    v.x + v.y + v.z + v.w
}

fn sums(v: V3<Vec4>) -> Vec3 {
    Vec3::from_array(v.0.map(sum))
}
