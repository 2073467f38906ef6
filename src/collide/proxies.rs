//! What the broad phase is told of the bodies, and when.

use crate::bodies::body::{RigidBody, Shape};
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::contact::pairs::broad_phase::{Broadphase, Proxy, ProxyKind, ProxyShape};
use crate::geometry::StaticMesh;
use crate::geometry::support::Core;
use crate::math::{Aabb, Plane, rotate};
use crate::threads::team::Team;
use crate::tuning::{MIN_PROXIES, PROXIES_WORTH_HELP};
use glam::{Mat3, Quat, Vec3};

/// How far ahead contacts are found besides the bodies' motion, as a share of the body's least extent: far enough that a
/// body at rest keeps its contacts while it settles.
pub(crate) const CONTACT_MARGIN: f32 = 0.02;

/// How far the boxes kept by the broad phase reach beyond the bodies, m (it limits this for small bodies itself).
const BOX_MARGIN: f32 = 0.1;

/// For how many steps, this one included, the broad phase is told at once where a body goes that keeps its velocity.
const STEPS_TOLD: f32 = 3.0;

/// How much longer than it must be a box may be that is kept for what was fast, m.
const SPARE: f32 = 0.2 * BOX_MARGIN;

/// Turn within a step, rad, from which the axis of a slender body is followed, and not its angular velocity.
const FAST_SPIN: f32 = 1.0;

/// Least moment of inertia over the next one, up to which a body is slender: a box of 1 : 2.
const SLENDER: f32 = 0.25;

/// The turn of a slender body.
struct Swing {
    /// Of its axis, world axes, rad.
    of_axis: Vec3,
    /// About its axis, over how much nearer to that its surface is than to the center, rad: a bound for bodies up to twice as far from the
    /// axis as a box of these moments.
    about_axis: f32,
}

/// How far ahead in time the step looks, so that contacts exist before bodies overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lookahead {
    step_dt: f32,
    /// How far gravity moves a body in one step, m.
    pub(crate) fall: f32,
}

/// The box around a body's convex parts where it is; none for a half-space or a level.
pub(super) fn tight_box(bodies: &Bodies, slot: u32) -> Option<Aabb> {
    let i = slot as usize;
    let turn = Mat3::from_quat(bodies.rotation[i]);
    let place = bodies.center[i] - turn * bodies.mass[i].center;
    match &bodies.info(slot).shape {
        Shape::Convex(mesh) => Some(mesh.bounds(&turn, place)),
        Shape::Compound(compound) => Some(compound.bounds(&turn, place)),
        Shape::HalfSpace(_) | Shape::Level(_) => None,
    }
}

impl Lookahead {
    /// Looks ahead over a step of `step_dt` seconds under `gravity` (m/s2).
    pub fn new(step_dt: f32, gravity: Vec3) -> Self {
        Self {
            step_dt,
            fall: step_dt * step_dt * gravity.length(),
        }
    }

    /// How far a point of the body in `slot` may turn about the center of mass within the step, m.
    pub(crate) fn turn(&self, bodies: &Bodies, slot: u32) -> f32 {
        let radius = bodies.radius(slot);
        match self.swing(bodies, slot) {
            Some(Swing {
                of_axis,
                about_axis,
            }) => radius * (of_axis.length() + about_axis),
            None => self.step_dt * bodies.velocity[slot as usize].angular.length() * radius,
        }
    }

    /// How the body in `slot` turns within the step, world axes, rad.
    pub(super) fn spin(&self, bodies: &Bodies, slot: u32) -> Vec3 {
        match self.swing(bodies, slot) {
            Some(swing) => swing.of_axis,
            None => self.step_dt * bodies.velocity[slot as usize].angular,
        }
    }

    /// Of a slender body that spins fast about its length: how that axis swings.
    ///
    /// The angular velocity of such a body turns with it, the angular momentum `L` does not. Of principal moments `I_x << I_y = I_z` a
    /// free body turns by `exp(t L / I_z)` in the world, and in that about its own axis by `(1 - I_x / I_z) w_x t`. A rod with
    /// 1000 rad/s about its axis and 80 across it swings round by the 80; about the sum of both it would only tremble.
    fn swing(&self, bodies: &Bodies, slot: u32) -> Option<Swing> {
        let i = slot as usize;
        let body = &bodies.velocity[i];
        let spin = self.step_dt * body.angular;
        if spin.length_squared() < FAST_SPIN * FAST_SPIN || body.inverse_mass == 0.0 {
            return None;
        }
        let mass = bodies.mass(slot);
        let moments = mass.principal / mass.principal.z;
        let is_slender = moments.x < SLENDER * moments.y && moments.y > 0.5;
        if !is_slender || bodies.drives.has_locked_turns(slot) || bodies.is_jointed(slot) {
            return None;
        }
        let frame = bodies.rotation[i] * mass.principal_frame;
        let about_axes = rotate(frame.inverse(), spin);
        Some(Swing {
            of_axis: rotate(frame, moments * about_axes),
            about_axis: 2.0 * moments.x.sqrt() * about_axes.x.abs(),
        })
    }

    /// How far the body in `slot` goes within the step, m.
    pub(crate) fn travel(&self, bodies: &Bodies, slot: u32) -> Vec3 {
        let travel = self.step_dt * bodies.velocity[slot as usize].linear;
        if bodies.drives.is_empty() {
            return travel;
        }
        // Of the fall by gravity the margins know.
        let driven = bodies.drive_of(slot, Vec3::ZERO);
        let gain = driven.map_or(Vec3::ZERO, |drive| drive.acceleration);
        travel + self.step_dt * self.step_dt * gain
    }

    /// How far ahead of a body its contacts are looked for in all directions, m.
    fn reach(&self, bodies: &Bodies, slot: u32) -> f32 {
        margin_at_rest(bodies, slot) + self.fall + self.turn(bodies, slot)
    }

    /// Whether two bodies that contacts move may be at one place within the step, even if something stops one of them.
    pub(crate) fn may_meet(&self, bodies: &Bodies, slots: [u32; 2]) -> bool {
        let boxes = slots.map(|slot| {
            let tight = tight_box(bodies, slot)?;
            let tight = tight.fattened(margin_at_rest(bodies, slot) + self.fall);
            Some(tight.swept(self.travel(bodies, slot)))
        });
        matches!(boxes, [Some(a), Some(b)] if a.overlaps(&b))
    }

    /// The body's box with all places it may reach within the step, and in [`STEPS_TOLD`] of them if it goes on as it does.
    /// `bounds`: the box around its shape in a frame.
    fn swept_box(
        &self,
        bodies: &Bodies,
        slot: u32,
        bounds: impl FnOnce(&Mat3, Vec3) -> Aabb,
    ) -> Aabb {
        let i = slot as usize;
        let turn = Mat3::from_quat(bodies.rotation[i]);
        // From the center of mass, so that little is lost far from the origin.
        let shift = bodies.center[i] - turn * bodies.mass[i].center;
        let tight = bounds(&turn, shift).fattened(self.reach(bodies, slot));
        tight.swept(STEPS_TOLD * self.travel(bodies, slot))
    }
}

impl Lookahead {
    /// The same for a level, whose margin is that of what comes near.
    fn swept_level(&self, bodies: &Bodies, slot: u32, mesh: &StaticMesh) -> Aabb {
        let turn = Mat3::from_quat(bodies.rotation[slot as usize]);
        let tight = Core::Box(mesh.aabb()).bounds(&turn, bodies.pose(slot).position);
        let tight = tight.fattened(self.turn(bodies, slot));
        tight.swept(STEPS_TOLD * self.travel(bodies, slot))
    }
}

/// When the broad phase was last told where a body is, and for how long that will do.
#[derive(Clone, Copy, Debug)]
struct ProxyState {
    id: BodyId,
    version: u32,
    center: Vec3,
    rotation: Quat,
    /// [`Lookahead::reach`] and [`Lookahead::travel`] then, m.
    reach: f32,
    travel: Vec3,
    /// [`span`] then, m.
    span: f32,
    /// How far the body may leave its way, or reach farther, until the broad phase must be told again, m.
    slack: f32,
}

impl ProxyState {
    /// Tells the broad phase where the body in `slot` is now.
    fn now(broadphase: &mut Broadphase, bodies: &Bodies, slot: u32, ahead: Lookahead) -> Self {
        let i = slot as usize;
        let (reach, travel) = (ahead.reach(bodies, slot), ahead.travel(bodies, slot));
        Self {
            id: bodies.ids[i],
            version: bodies.version[i],
            center: bodies.center[i],
            rotation: bodies.rotation[i],
            reach,
            travel,
            span: span(reach, travel),
            slack: broadphase.set(i, Some(proxy(bodies, slot, ahead)), BOX_MARGIN),
        }
    }

    /// Whether the broad phase need not be told where the body in `slot` is now.
    fn still_valid(&self, bodies: &Bodies, slot: u32, ahead: Lookahead) -> bool {
        let i = slot as usize;
        let turn = (bodies.rotation[i] - self.rotation).length();
        let (reach, travel) = (ahead.reach(bodies, slot), ahead.travel(bodies, slot));
        let slack = self.slack - 2.0 * turn * bodies.radius(slot) - (reach - self.reach).max(0.0);
        self.id == bodies.ids[i]
            && self.version == bodies.version[i]
            && self.is_on_its_way(bodies.center[i], travel, slack)
            // A body that was fast and has become slow gets a smaller box.
            && self.span <= span(reach, travel) + reach + SPARE
    }

    /// Whether a center of mass that goes on by `travel` (m) in this step is nearer than `slack` (m), at either end of it, to
    /// where one is that kept its velocity.
    fn is_on_its_way(&self, center: Vec3, travel: Vec3, slack: f32) -> bool {
        let (moved, faster) = (center - self.center, travel - self.travel);
        let is_near =
            |off: Vec3| off.length_squared().max((off + faster).length_squared()) < slack * slack;
        // Most bodies of a large scene are where they were. Of one that stood there is no way to be on: not a number.
        let steps = || moved.dot(self.travel) / self.travel.length_squared();
        let on_its_way = || steps().clamp(0.0, STEPS_TOLD - 1.0) * self.travel;
        slack > 0.0 && (is_near(moved) || is_near(moved - on_its_way()))
    }
}

/// How far a body gets with the given [`Lookahead::reach`] and [`Lookahead::travel`] in all steps that are told, m.
fn span(reach: f32, travel: Vec3) -> f32 {
    reach + STEPS_TOLD * travel.length()
}

/// What the broad phase knows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Boxes {
    /// What it was told of each slot.
    told: Vec<Option<ProxyState>>,
    /// By part of the bodies: slots that it is to be told of.
    outdated: Vec<Vec<u32>>,
}

impl Boxes {
    /// Brings the pairs of `broadphase` up to date with the bodies.
    pub(crate) fn update(
        &mut self,
        broadphase: &mut Broadphase,
        bodies: &Bodies,
        ahead: Lookahead,
    ) {
        // If all bodies were replaced, there may be fewer slots than the broad phase knows.
        for slot in bodies.slots()..self.told.len() {
            broadphase.set(slot, None, BOX_MARGIN);
        }
        self.told.resize(bodies.slots(), None);
        // Helpers that come now need not be waited for when the pairs are known.
        Team::lead_if(bodies.slots() >= PROXIES_WORTH_HELP, |team| {
            self.find_outdated(bodies, ahead, team);
            self.tell(broadphase, bodies, ahead);
            broadphase.find_pairs();
        });
    }

    /// Finds the bodies that the broad phase is to be told of.
    fn find_outdated(&mut self, bodies: &Bodies, ahead: Lookahead, team: Option<&Team>) {
        if bodies.local.is_on {
            self.outdated.resize(self.outdated.len().max(1), Vec::new());
            let told = &self.told;
            let is_outdated =
                |&slot: &u32| is_outdated(told[slot as usize].as_ref(), bodies, slot, ahead);
            let slots = bodies.local.slots.iter().copied();
            return self.outdated[0].extend(slots.filter(is_outdated));
        }
        let size = Team::part_size(team, self.told.len(), MIN_PROXIES);
        let count = self.told.len().div_ceil(size);
        self.outdated
            .resize(self.outdated.len().max(count), Vec::new());
        let parts = self.told.chunks(size).zip(&mut self.outdated);
        Team::each_of_many(team, parts.enumerate(), |(index, (told, outdated))| {
            let slots = (index * size) as u32..;
            for (slot, told) in slots.zip(told) {
                if !bodies.is_asleep(slot) && is_outdated(told.as_ref(), bodies, slot, ahead) {
                    outdated.push(slot);
                }
            }
        });
    }

    /// Tells the broad phase of them.
    fn tell(&mut self, broadphase: &mut Broadphase, bodies: &Bodies, ahead: Lookahead) {
        for slot in self.outdated.iter_mut().flat_map(|slots| slots.drain(..)) {
            let told = &mut self.told[slot as usize];
            // Sensors look for their pairs themselves.
            if bodies.is_active(slot) && !bodies.is_sensor(slot) {
                *told = Some(ProxyState::now(broadphase, bodies, slot, ahead));
            } else {
                *told = None;
                broadphase.set(slot as usize, None, BOX_MARGIN);
            }
        }
    }
}

/// Whether the broad phase is to be told anew of a body that it was told this of.
#[inline(always)]
fn is_outdated(told: Option<&ProxyState>, bodies: &Bodies, slot: u32, ahead: Lookahead) -> bool {
    let is_active = bodies.is_active(slot);
    match told {
        Some(told) => !is_active || !told.still_valid(bodies, slot, ahead),
        None => is_active,
    }
}

fn proxy(bodies: &Bodies, slot: u32, ahead: Lookahead) -> Proxy {
    let info = bodies.info(slot);
    let kind = if info.kind == RigidBody::Dynamic {
        ProxyKind::Moving
    } else {
        ProxyKind::Fixed
    };
    let shape = match &info.shape {
        Shape::Convex(mesh) => {
            ProxyShape::Box(ahead.swept_box(bodies, slot, |turn, shift| mesh.bounds(turn, shift)))
        }
        Shape::Compound(compound) => {
            ProxyShape::Box(
                ahead.swept_box(bodies, slot, |turn, shift| compound.bounds(turn, shift)),
            )
        }
        Shape::Level(mesh) => ProxyShape::Box(ahead.swept_level(bodies, slot, mesh)),
        Shape::HalfSpace(_) => ProxyShape::HalfSpace(half_space_plane(bodies, slot)),
    };
    Proxy {
        id: bodies.id(slot),
        kind,
        layers: info.layers,
        shape,
    }
}

fn margin_at_rest(bodies: &Bodies, slot: u32) -> f32 {
    CONTACT_MARGIN * bodies.min_extent[slot as usize]
}

/// Surface of the half-space in `slot`, world frame.
fn half_space_plane(bodies: &Bodies, slot: u32) -> Plane {
    let Shape::HalfSpace(half_space) = &bodies.info(slot).shape else {
        unreachable!("asked for half-spaces only")
    };
    let pose = bodies.pose(slot);
    Plane::through(pose.position, rotate(pose.rotation, half_space.normal))
}
