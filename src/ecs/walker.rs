//! Characters that walk: a kinematic body that is moved by casts of its shape.

use crate::bodies::body::{RigidBody, Shape};
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::ecs::components::{BodyHandle, BodyWarning, WalkerError};
use crate::ecs::forces::AppliedForces;
use crate::ecs::issues::Source;
use crate::ecs::query::SpatialQuery;
use crate::ecs::state::PluginState;
use crate::query::{
    Footing, Push, QueryFilter, QueryShape, Slider, WalkInput, WalkSettings, WalkState,
};
use crate::solver::config::Gravity;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_math::Vec3;
use bevy_time::Time;
use bevy_transform::components::Transform;

/// A character: walks up slopes and steps, along walls, rides on what moves, and pushes what is in its way.
///
/// For an entity with a `RigidBody::Kinematic` and a [`ConvexMesh`](crate::geometry::ConvexMesh), mostly a capsule, or a
/// [`Compound`](crate::geometry::Compound), that is no child; `WalkerPlugin` moves its `Transform` before each step. Set `velocity` to where it is to go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Component)]
#[require(Walking)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Walker {
    /// How it walks.
    pub settings: WalkSettings,
    /// Where it wants to go, m/s; what of it is along `settings.up` does not count.
    pub velocity: Vec3,
    /// Speed with which it jumps off in the next step, if it stands on something then, m/s; set to 0 when it does.
    pub jump: f32,
}

impl Walker {
    fn input(&self, gravity: Vec3, step_dt: f32) -> WalkInput {
        WalkInput {
            velocity: self.velocity,
            jump: self.jump,
            gravity,
            step_dt,
        }
    }
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
    (Entity, Stance),
    &'static mut Walker,
    &'static mut Walking,
    &'static mut Transform,
);

/// What decides whether an entity can walk.
#[derive(QueryData)]
pub(crate) struct Stance {
    kind: Option<&'static RigidBody>,
    is_child: Has<ChildOf>,
    handle: Option<&'static BodyHandle>,
}

impl StanceItem<'_, '_> {
    /// Where its body is kept.
    fn slot(&self, bodies: &Bodies) -> Option<u32> {
        let handle = self.handle.and_then(BodyHandle::get);
        let current = handle.filter(|&(slot, id)| bodies.is_current(slot, id));
        current.map(|(slot, _)| slot)
    }

    /// Whether it can walk; one that has no shape yet may have one soon.
    fn check(&self, walker: &Walker, bodies: &Bodies) -> Result<(), WalkerError> {
        if self.kind != Some(&RigidBody::Kinematic) {
            return Err(WalkerError::NotKinematic);
        }
        if self.is_child {
            return Err(WalkerError::Child);
        }
        let slot = self.slot(bodies);
        if slot.is_some_and(|slot| cast_shape(&bodies.info(slot).shape).is_none()) {
            return Err(WalkerError::Shape);
        }
        if !walker.settings.is_usable() {
            return Err(WalkerError::Settings);
        }
        let is_finite = walker.velocity.is_finite() && walker.jump.is_finite();
        is_finite.then_some(()).ok_or(WalkerError::NotFinite)
    }
}

/// Whether there are [`WalkerPlugin`](crate::plugin::WalkerPlugin)s.
#[derive(Debug, Default, Resource)]
pub(crate) struct WalkersMove;

/// Observer: an entity is to walk.
pub(crate) fn on_walker_added(
    add: On<Add<Walker>>,
    plugin: Option<Res<WalkersMove>>,
    mut state: ResMut<PluginState>,
    mut warnings: ResMut<Messages<BodyWarning>>,
) {
    if plugin.is_none() {
        let (issues, error) = (&mut state.issues, WalkerError::NoPlugin);
        issues.raise(&mut warnings, add.entity, Source::Walker, error);
    }
}

/// Observer: an entity is not to walk any more.
pub(crate) fn on_walker_removed(remove: On<Remove<Walker>>, mut state: ResMut<PluginState>) {
    state.issues.mend(remove.entity, Source::Walker);
}

/// System: says who cannot walk.
pub(crate) fn check_walkers(
    walkers: Query<(Entity, Stance, &Walker)>,
    bodies: Res<Bodies>,
    mut state: ResMut<PluginState>,
    mut warnings: ResMut<Messages<BodyWarning>>,
) {
    for (entity, stance, walker) in &walkers {
        let able = stance.check(walker, &bodies);
        let issues = &mut state.issues;
        issues.note(&mut warnings, entity, Source::Walker, able);
    }
}

/// System: moves all characters, one after the other.
pub(crate) fn walk(
    (spatial, bodies): (SpatialQuery, Res<Bodies>),
    (gravity, time): (Res<Gravity>, Option<Res<Time>>),
    mut characters: Query<Character>,
    mut forces: Query<&mut AppliedForces>,
    mut pushes: Local<Vec<Push>>,
) {
    let step_dt = time.map_or(0.0, |time| time.delta_secs());
    for ((entity, stance), mut walker, mut walking, mut transform) in &mut characters {
        let Some(slot) = stance.slot(&bodies) else {
            continue;
        };
        let Some(shape) = cast_shape(&bodies.info(slot).shape) else {
            continue;
        };
        if stance.check(&walker, &bodies).is_err() {
            continue;
        }
        let mut state = walking.state(&transform, &bodies);
        let input = walker.input(gravity.0, step_dt);
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
                forces.act_at(lever, [Vec3::ZERO, push.impulse]);
            }
        }
    }
}

/// What is cast to move a shape; what has no inside cannot be.
fn cast_shape(shape: &Shape) -> Option<QueryShape<'_>> {
    match shape {
        Shape::Convex(mesh) => Some(QueryShape::from(mesh)),
        Shape::Compound(mesh) => Some(QueryShape::from(mesh)),
        Shape::HalfSpace(_) | Shape::Level(_) => None,
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
