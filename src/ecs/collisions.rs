//! Who touches whom: events for those that ask, and all contacts of the last step for those that look.

use crate::bodies::store::Bodies;
use crate::contact::manifolds::ManifoldRef;
use crate::ecs::state::PluginState;
use crate::step::Contacts;
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_math::Vec3;

/// Asks for [`CollisionStart`] and [`CollisionEnd`] of this body.
///
/// Both come as messages, once for a pair, and as events of each entity that has this component. Kinematic and static bodies
/// do not collide with each other. While a body sleeps there is no news of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct CollisionEvents;

/// Asks for [`ContactForce`] of this body's contacts that bear more than a threshold.
#[derive(Clone, Copy, Debug, PartialEq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct ContactForceEvents {
    /// Normal force between two bodies, N: their impulse of a step over its length.
    pub threshold: f32,
}

impl Default for ContactForceEvents {
    /// All that bears anything.
    fn default() -> Self {
        Self { threshold: 0.0 }
    }
}

/// A body that neither pushes nor is pushed, and tells who is inside it. Collision layers hold for it too; what is static
/// does not see what is static.
///
/// Sensors notice what flew through them within a step. They wake nobody.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Component)]
#[component(summary_tick)]
#[require(CollisionEvents)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Sensor;

/// Two bodies touch that did not before, or somebody began to ask.
#[derive(Clone, Copy, Debug, PartialEq, Message, EntityEvent)]
pub struct CollisionStart {
    /// The entity whose event this is; in messages, of two that ask, the one whose body was made first.
    pub entity: Entity,
    /// The entity that it touches.
    pub other: Entity,
    /// Where, world, m.
    pub point: Vec3,
    /// Unit normal from `entity` to `other`.
    pub normal: Vec3,
    /// Normal impulse of the step, N s; zero for sensors.
    pub impulse: f32,
    /// Speed at which they approached along the normal before the step, m/s.
    pub approach_speed: f32,
}

/// Two bodies do not touch any more, or one is gone; then its entity may be, too.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Message, EntityEvent)]
pub struct CollisionEnd {
    /// The entity whose event this is.
    pub entity: Entity,
    /// The entity that it touched.
    pub other: Entity,
}

/// A contact bore more than was asked for, in this step.
#[derive(Clone, Copy, Debug, PartialEq, Message, EntityEvent)]
pub struct ContactForce {
    /// The entity whose event this is.
    pub entity: Entity,
    /// The entity that it touches.
    pub other: Entity,
    /// Whether it bore less in the step before: a blow, and not the load that follows.
    pub is_crossing: bool,
    /// Normal force, mean of the step, N.
    pub force: f32,
    /// Normal impulse of the step, N s.
    pub impulse: f32,
    /// Speed at which they approached along the normal before the step, m/s.
    pub approach_speed: f32,
    /// Where, world, m.
    pub point: Vec3,
    /// Unit normal from `entity` to `other`.
    pub normal: Vec3,
}

/// All that touches after the last step, whether events of it are asked for or not.
#[derive(Debug, SystemParam)]
pub struct Collisions<'w> {
    contacts: Res<'w, Contacts>,
    bodies: Res<'w, Bodies>,
    state: Res<'w, PluginState>,
}

/// A pair of bodies that touch.
#[derive(Clone, Copy, Debug)]
pub struct Collision<'w> {
    /// The entity whose body was made first.
    pub a: Entity,
    /// The other one.
    pub b: Entity,
    manifold: Option<ManifoldRef<'w>>,
    is_sensor: bool,
}

impl Collision<'_> {
    /// The entity that `entity` touches; nothing if it is not one of the two.
    pub fn other(&self, entity: Entity) -> Option<Entity> {
        match (self.a == entity, self.b == entity) {
            (true, _) => Some(self.b),
            (_, true) => Some(self.a),
            _ => None,
        }
    }

    /// Whether one of the two is a [`Sensor`], so that they do not push each other.
    pub fn is_sensor(&self) -> bool {
        self.is_sensor
    }

    /// Unit normal from `a` to `b`, world axes; nothing of bodies that sleep, and of sensors.
    pub fn normal(&self) -> Option<Vec3> {
        self.manifold.map(|manifold| manifold.normal)
    }

    /// Normal impulse of the last step, N s; zero of bodies that sleep, and of sensors.
    pub fn impulse(&self) -> f32 {
        let points = self.manifold.map_or(&[][..], ManifoldRef::points);
        points.iter().map(|point| point.total_impulse).sum()
    }

    /// Deepest overlap before the last step, m; not negative.
    pub fn penetration(&self) -> f32 {
        let points = self.manifold.map_or(&[][..], ManifoldRef::points);
        points
            .iter()
            .map(|point| -point.separation)
            .fold(0.0, f32::max)
    }
}

impl Collisions<'_> {
    /// All pairs that touch: those that bear something or overlap, those that sleep in contact, and who is inside a sensor.
    pub fn iter(&self) -> impl Iterator<Item = Collision<'_>> {
        let manifolds = self.contacts.manifolds().iter();
        let touching = manifolds.filter(|manifold| {
            let points = manifold.points().iter();
            points
                .into_iter()
                .any(|p| p.total_impulse != 0.0 || p.separation <= 0.0)
        });
        let touching = touching.filter_map(|m| self.collision([m.a, m.b], Some(m)));
        let dormant = self.contacts.dormant_pairs(&self.bodies);
        let dormant = dormant.filter_map(|slots| self.collision(slots, None));
        let sensed = self.contacts.sensed_pairs();
        let sensed = sensed.filter_map(|slots| self.collision(slots, None));
        touching.chain(dormant).chain(sensed)
    }

    /// The pairs that `entity` belongs to. Goes through all pairs of the scene.
    pub fn of(&self, entity: Entity) -> impl Iterator<Item = Collision<'_>> {
        let is_of = move |pair: &Collision| pair.other(entity).is_some();
        self.iter().filter(is_of)
    }

    /// The contact of two entities, if they touch. Goes through all pairs of the scene.
    pub fn between(&self, a: Entity, b: Entity) -> Option<Collision<'_>> {
        self.of(a).find(|pair| pair.other(a) == Some(b))
    }

    fn collision<'s>(
        &'s self,
        slots: [u32; 2],
        manifold: Option<ManifoldRef<'s>>,
    ) -> Option<Collision<'s>> {
        let entity = |slot: u32| {
            let is_there = self.bodies.contains(slot);
            is_there.then(|| self.state.entities.of(slot, self.bodies.id(slot)))
        };
        let [a, b] = slots.map(entity);
        Some(Collision {
            a: a??,
            b: b??,
            manifold,
            is_sensor: slots.iter().any(|&slot| self.bodies.is_sensor(slot)),
        })
    }
}
