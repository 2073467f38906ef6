//! What blasts do to bodies, and to the parts of clusters.

use crate::bodies::blast_shares::{Reached, shares};
use crate::bodies::body::BodyError;
use crate::bodies::breaking::ImpactLoad;
use crate::bodies::drive::StepForces;
use crate::bodies::explosion::Explosion;
use crate::bodies::store::Bodies;
use crate::cluster::hit::Push;
use crate::math::{Aabb, Pose, rotate};
use glam::Vec3;

/// The fastest that a blast makes a point of a body that it drives as a whole, m/s: the gas that drives it is not faster. By the impulse alone a
/// splinter of a milligram flies at a thousandth of the speed of light, and what it hits overflows with it.
const GAS_SPEED: f32 = 1e4;

impl Explosion {
    /// Impulse, and angular impulse about the center, that the body in `slot` gets, world.
    pub(crate) fn push_on(&self, bodies: &Bodies, slot: u32) -> Option<[Vec3; 2]> {
        let nearest = self.nearest_of(bodies, slot)?;
        let center = bodies.center_of_mass(slot);
        let share = self.share_at(nearest);
        let impulse = share * self.impulse * self.away(nearest, center);
        (share > 0.0).then(|| [impulse, (nearest - center).cross(impulse)])
    }

    /// The pressure on the body in `slot` as a blow, and the point (world, m) and the direction in which it pushes; nothing if it does not reach it.
    ///
    /// Its energy is what the impulse gives to the material if nothing holds it.
    pub(crate) fn blow_to(&self, bodies: &Bodies, slot: u32) -> Option<(ImpactLoad, [Vec3; 2])> {
        let [impulse, angular] = self.push_on(bodies, slot)?;
        let mass = bodies.mass(slot).mass;
        let spin = angular.dot(bodies.inverse_inertia[slot as usize] * angular);
        let load = ImpactLoad {
            impulse: impulse.length(),
            energy: 0.5 * (impulse.length_squared() / mass + spin),
        };
        let direction = impulse.try_normalize()?;
        let is_usable = mass > 0.0 && load.energy.is_finite();
        is_usable.then_some((load, [self.nearest_of(bodies, slot)?, direction]))
    }

    /// How much the body in `slot` gets of it beside others: by its distance, and by the area that it turns to it, m2.
    pub(crate) fn weight_on(&self, bodies: &Bodies, slot: u32) -> f32 {
        let share = self.nearest_of(bodies, slot).map(|it| self.share_at(it));
        let Some(aabb) = bodies.info(slot).shape.solid_aabb() else {
            return 0.0;
        };
        let from = bodies.pose(slot).inverse_transform_point(self.center);
        let sides = aabb.extents();
        let toward = (from - aabb.center()).normalize_or(Vec3::Y).abs();
        let area = toward.dot(Vec3::new(
            sides.y * sides.z,
            sides.z * sides.x,
            sides.x * sides.y,
        ));
        share.unwrap_or(0.0).max(0.0) * area
    }

    /// What it does to the parts of the cluster in `slot`; nothing if it does not reach it.
    pub(crate) fn pushes_on(&self, bodies: &Bodies, slot: u32) -> Vec<Push> {
        let nearest = self.nearest_of(bodies, slot).map(|it| self.share_at(it));
        let whole = nearest.unwrap_or(0.0).max(0.0) * self.impulse;
        let (Some(compound), Some(state)) = (bodies.compound(slot), bodies.cluster(slot)) else {
            return Vec::new();
        };
        let body = bodies.pose(slot);
        let local = Self {
            center: body.inverse_transform_point(self.center),
            ..*self
        };
        let reached = |part: u32, is_open: bool| {
            let at = &compound.parts()[part as usize];
            let point = local.nearest_in(&at.shape.aabb(), &at.pose);
            let share = local.share_at(point);
            if share <= 0.0 {
                return None;
            }
            let area = compound.area_seen(part as usize, local.center, is_open);
            let it = Reached {
                weight: (share * area).into(),
                mass: state.network.nodes[part as usize].mass,
            };
            (area > 0.0).then_some((part, point, it))
        };
        let parts = 0..compound.len() as u32;
        let mut found: Vec<_> = parts.clone().filter_map(|it| reached(it, true)).collect();
        if found.is_empty() {
            // It is inside of the material.
            found = parts.filter_map(|it| reached(it, false)).collect();
        }
        let given = shares(&found.iter().map(|&(.., it)| it).collect::<Vec<_>>());
        let pushes = found.into_iter().zip(given);
        let pushes = pushes.map(|((part, point, _), share)| {
            let center = state.network.nodes[part as usize].center.as_vec3();
            let impulse = whole * share as f32 * local.away(point, center);
            Push {
                part,
                impulse,
                angular_impulse: (point - center).cross(impulse),
            }
        });
        pushes.filter(|push| push.impulse != Vec3::ZERO).collect()
    }

    /// Point of the box around a body that is nearest to it, world.
    fn nearest_of(&self, bodies: &Bodies, slot: u32) -> Option<Vec3> {
        let aabb = bodies.info(slot).shape.solid_aabb()?;
        Some(self.nearest_in(&aabb, &bodies.pose(slot)))
    }

    /// Point of a box at a pose that is nearest to it.
    fn nearest_in(&self, aabb: &Aabb, pose: &Pose) -> Vec3 {
        let local = pose.inverse_transform_point(self.center);
        pose.transform_point(local.clamp(aabb.min, aabb.max))
    }
}

impl Bodies {
    /// Lets a blast act in the next step, before its contacts.
    ///
    /// # Errors
    /// [`BodyError::Drive`] if its numbers mean nothing; none acts then.
    pub fn explode(&mut self, explosion: Explosion) -> Result<(), BodyError> {
        explosion.validate()?;
        self.pushes.explosions.push(explosion);
        Ok(())
    }

    /// All that pushes on parts of a cluster do to it as a whole.
    pub(crate) fn push_whole(&mut self, slot: u32, pushes: &[Push]) {
        let Some(state) = self.cluster(slot) else {
            return;
        };
        let center = self.mass(slot).center;
        let (mut impulse, mut angular_impulse) = (Vec3::ZERO, Vec3::ZERO);
        for push in pushes {
            let arm = state.network.nodes[push.part as usize].center.as_vec3() - center;
            impulse += push.impulse;
            angular_impulse += push.angular_impulse + arm.cross(push.impulse);
        }
        let turn = self.pose(slot).rotation;
        self.push(slot, [impulse, angular_impulse].map(|v| rotate(turn, v)));
    }

    /// Gives a body as much of an impulse and angular impulse about its center (world) as a blast can.
    pub(crate) fn push_by_blast(&mut self, slot: u32, given: [Vec3; 2]) {
        let [v, omega] = [
            given[0].length() / self.mass(slot).mass,
            (self.inverse_inertia[slot as usize] * given[1]).length(),
        ];
        // What is not moved at all has no speed, and gets all of it.
        let share = (GAS_SPEED / (v + omega * self.radius(slot))).min(1.0);
        self.push(slot, given.map(|it| share * it));
    }

    /// Gives a body impulse and angular impulse about its center, world.
    pub(crate) fn push(&mut self, slot: u32, [impulse, angular_impulse]: [Vec3; 2]) {
        let forces = StepForces {
            impulse,
            angular_impulse,
            ..StepForces::default()
        };
        // Of finite numbers, but their product may not be.
        let _ = self.apply(slot, &forces);
    }
}
