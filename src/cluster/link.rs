//! A bond in the instant of a blow.

use crate::cluster::moving_part::Body;
use crate::cluster::network::Network;
use crate::geometry::PartBond;
use crate::simd::float4::{higher, lower};
use crate::simd::vec3::V3;
use glam::{Mat3, Vec3, Vec4};

/// Share of the way to breaking up to which a bond is elastic; it yields for the rest, so that the work is force times way.
const ELASTIC: f32 = 0.5;

/// Share of the square of what bears up to which its root surely does not exceed it.
const SURELY: f32 = 0.999;

/// The corners of a bonded face, one in each lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corners {
    /// From the centers of both parts, m.
    pub(super) arms: [V3<Vec4>; 2],
    /// How far they have yielded: opened, and slid, m.
    opened: Vec4,
    slid: V3<Vec4>,
}

/// A bonded face as its corners act together as long as none has yielded, or none touches.
#[derive(Clone, Copy, Debug)]
struct Face {
    /// From the centers of both parts to its own, m.
    arms: [Vec3; 2],
    /// Torque of the corners about its center by turn and stiffness, m2.
    spread: Mat3,
    /// Square of the way from its center to a corner, m2.
    square: f32,
}

/// How far the second part has moved from the first one.
#[derive(Clone, Copy, Debug)]
struct Parting {
    /// At the center of the face, m.
    way: Vec3,
    turn: Vec3,
}

/// A bond in the instant of the blow.
#[derive(Debug)]
pub(super) struct Link {
    pub(super) bond: u32,
    pub(super) bodies: [u32; 2],
    pub(super) normal: Vec3,
    pub(super) corners: Corners,
    face: Face,
    /// Whether a corner has yielded.
    has_yielded: bool,
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
            face: Face::of(shape, centers),
            has_yielded: false,
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
        let parting = self.face.parting([a, b]);
        if let Some((force, torques)) = self.pull_of_face(&parting) {
            return (force, torques, 0.0);
        }
        let moved = self.corners.moved([a, b]);
        let normal = splat(self.normal);
        let open = moved.dot(normal);
        let mut work = 0.0;
        let pull = if self.is_broken {
            normal.times(lower(self.stiffness * open, Vec4::ZERO))
        } else {
            let across = moved.minus(normal.times(open));
            let way = (open, across);
            let elastic = (self.corners).elastic(self.stiffness, self.limits, way);
            let (pull, shear) = elastic.unwrap_or_else(|| {
                let (pull, shear, done) =
                    (self.corners).yielding(self.stiffness, self.limits, friction, way);
                work = sum(done);
                self.has_yielded |= work > 0.0;
                self.is_broken = self.corners.farthest().cmpgt(Vec4::splat(self.way)).any();
                (pull, shear)
            });
            self.note_load(friction, (pull, shear));
            normal.times(pull).plus(shear)
        };
        let pull = finite(pull);
        let [arm_a, arm_b] = self.corners.arms.map(|arm| arm.cross(pull));
        (sums(pull), [sums(arm_a), -sums(arm_b)], work)
    }

    /// What [`pull`](Self::pull) tells of most bonds in most time steps, without a look at each corner: whole, none of which has yielded or may now,
    /// and broken ones that are open. None of others.
    fn pull_of_face(&self, Parting { way, turn }: &Parting) -> Option<(Vec3, [Vec3; 2])> {
        let swing = turn.length_squared() * self.face.square;
        if self.is_broken {
            let open = way.dot(self.normal);
            let is_open = open >= 0.0 && open * open >= swing;
            return is_open.then_some((Vec3::ZERO, [Vec3::ZERO; 2]));
        }
        if self.has_yielded || self.strained_from < f32::INFINITY {
            return None;
        }
        // No corner moves farther than the sum of both ways, whose square is at most twice the sum of their squares.
        let bears = self.limits[0].min(self.limits[1]) / self.stiffness;
        if 2.0 * (way.length_squared() + swing) > bears * bears {
            return None;
        }
        let force = 4.0 * self.stiffness * *way;
        let torque = self.stiffness * (self.face.spread * *turn);
        let [arm_a, arm_b] = self.face.arms.map(|arm| arm.cross(force));
        Some((force, [arm_a + torque, -arm_b - torque]))
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
        if !(self.is_broken || self.has_yielded) {
            let Parting { way, turn } = self.face.parting(parts);
            let by_turn = turn.dot(self.face.spread * turn);
            return 0.5 * self.stiffness * (4.0 * way.length_squared() + by_turn);
        }
        let corners = &self.corners;
        let normal = splat(self.normal);
        let moved = corners.moved(parts);
        let square = if self.is_broken {
            // It still holds what is pressed, and nothing across.
            let pressed = lower(moved.dot(normal), Vec4::ZERO);
            pressed * pressed
        } else {
            let yielded = corners.slid.plus(normal.times(corners.opened));
            let stretched = moved.minus(yielded);
            stretched.dot(stretched)
        };
        sum(0.5 * self.stiffness * square)
    }
}

impl Face {
    /// `centers`: of the parts.
    fn of(bond: &PartBond, centers: [Vec3; 2]) -> Self {
        let ways = Network::corners(bond).map(|corner| corner - bond.center);
        let outer = |way: Vec3| Mat3::from_cols(way.x * way, way.y * way, way.z * way);
        // w x (turn x w) = (w^2 - w w^T) turn, summed.
        let spread =
            ways.map(|way| Mat3::from_diagonal(Vec3::splat(way.length_squared())) - outer(way));
        Self {
            arms: centers.map(|center| bond.center - center),
            spread: spread.into_iter().fold(Mat3::ZERO, |sum, own| sum + own),
            square: ways[0].length_squared().max(ways[1].length_squared()),
        }
    }

    fn parting(&self, [a, b]: [&Body; 2]) -> Parting {
        let [arm_a, arm_b] = self.arms;
        let ways = [
            a.displacement + a.turn.cross(arm_a),
            b.displacement + b.turn.cross(arm_b),
        ];
        Parting {
            way: ways[1] - ways[0],
            turn: b.turn - a.turn,
        }
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

    /// What [`yielding`](Self::yielding) tells, where no corner is so loaded that it may yield: to the bit, without roots and divisions. Friction, which
    /// makes shear bear more, is left out.
    fn elastic(
        &self,
        stiffness: f32,
        [tension, shear_limit]: [f32; 2],
        (open, across): (Vec4, V3<Vec4>),
    ) -> Option<(Vec4, V3<Vec4>)> {
        let pull = stiffness * (open - self.opened);
        let shear = across.minus(self.slid).times(Vec4::splat(stiffness));
        let most = SURELY * shear_limit * shear_limit;
        let bears = pull.cmple(Vec4::splat(tension)) & shear.dot(shear).cmple(Vec4::splat(most));
        bears.all().then_some((pull, shear))
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
