//! Characters that walk: a kinematic body that is moved by casts of its shape.

use crate::bodies::body::Shape;
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::ecs::components::BodyHandle;
use crate::ecs::forces::AppliedForces;
use crate::ecs::query::SpatialQuery;
use crate::query::{
    Footing, Push, QueryFilter, QueryShape, Slider, WalkInput, WalkSettings, WalkState,
};
use crate::solver::config::Gravity;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_time::Time;
use bevy_transform::components::Transform;

/// A character: walks up slopes and steps, along walls, rides on what moves, and pushes what is in its way.
///
/// For an entity with a `RigidBody::Kinematic` and a [`ConvexMesh`](crate::geometry::ConvexMesh), mostly a capsule, or a
/// [`Compound`](crate::geometry::Compound), that is no child; `WalkerPlugin` moves its `Transform` before each step. Set `velocity` to where it is to go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Component)]
#[require(Walking)]
pub struct Walker {
    /// How it walks.
    pub settings: WalkSettings,
    /// Where it wants to go, m/s; what of it is along `settings.up` does not count.
    pub velocity: Vec3,
    /// Speed with which it jumps off in the next step, if it stands on something then, m/s; set to 0 when it does.
    pub jump: f32,
}

/// How a [`Walker`] moves. Written by the plugin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Component)]
pub struct Walking {
    /// Its own velocity, m/s, without that of what it stands on.
    pub velocity: Vec3,
    /// What it stands on.
    pub ground: Option<Entity>,
    /// Unit normal of what it stands on.
    pub ground_normal: Option<Vec3>,
    footing: Option<(Footing, BodyId)>,
}

impl Walking {
    /// Whether it stands on something.
    pub fn is_on_ground(&self) -> bool {
        self.ground_normal.is_some()
    }
}

/// What a character is made of.
type Character = (
    Entity,
    &'static BodyHandle,
    &'static mut Walker,
    &'static mut Walking,
    &'static mut Transform,
);

/// System: moves all characters, one after the other.
pub(crate) fn walk(
    spatial: SpatialQuery,
    bodies: Res<Bodies>,
    (gravity, time): (Res<Gravity>, Option<Res<Time>>),
    mut characters: Query<Character>,
    mut forces: Query<&mut AppliedForces>,
    mut pushes: Local<Vec<Push>>,
) {
    let step_dt = time.map_or(0.0, |time| time.delta_secs());
    for (entity, handle, mut walker, mut walking, mut transform) in &mut characters {
        let Some((slot, _)) = handle
            .get()
            .filter(|&(slot, id)| bodies.is_current(slot, id))
        else {
            continue;
        };
        let shape = match &bodies.info(slot).shape {
            Shape::Convex(mesh) => QueryShape::from(mesh),
            Shape::Compound(mesh) => QueryShape::from(mesh),
            // What has no inside cannot be moved by casts of it.
            Shape::HalfSpace(_) | Shape::Level(_) => continue,
        };
        let mut state = walking.state(&transform, &bodies);
        let input = WalkInput {
            velocity: walker.velocity,
            jump: walker.jump,
            gravity: gravity.0,
            step_dt,
        };
        if jumps(&input, &state) {
            walker.jump = 0.0;
        }
        let slider = Slider {
            shape,
            skin: walker.settings.skin,
        };
        let counts = |other: u32| other != slot && !bodies.is_sensor(other);
        let filter = QueryFilter::all()
            .with_layers(bodies.info(slot).layers)
            .with_predicate(&counts);
        let queries = spatial.queries();
        let how = (&slider, &walker.settings);
        queries.walk(how, &mut state, &input, &filter, &mut pushes);
        (transform.translation, transform.rotation) = (state.position, state.rotation);
        *walking = Walking {
            velocity: state.velocity,
            ground: state.footing.and_then(|f| spatial.entity(f.body)),
            ground_normal: state.footing.map(|f| f.normal),
            footing: state.footing.map(|f| (f, bodies.id(f.body))),
        };
        for push in pushes.drain(..) {
            let pushed = spatial.entity(push.body).filter(|&other| other != entity);
            let pushed = pushed.and_then(|pushed| forces.get_mut(pushed).ok());
            if let Some(mut forces) = pushed {
                let lever = push.point - bodies.pose(push.body).position;
                forces.push_at(push.impulse, lever);
            }
        }
    }
}

/// Whether a character is to be told that it has jumped.
fn jumps(input: &WalkInput, state: &WalkState) -> bool {
    input.jump > 0.0 && state.footing.is_some()
}

impl Walking {
    /// What of it the next step goes on from, if what it stands on is still there.
    fn state(&self, at: &Transform, bodies: &Bodies) -> WalkState {
        let is_there = |(footing, id): (Footing, BodyId)| {
            bodies.is_current(footing.body, id).then_some(footing)
        };
        WalkState {
            position: at.translation,
            rotation: at.rotation,
            velocity: self.velocity,
            footing: self.footing.and_then(is_there),
        }
    }
}
