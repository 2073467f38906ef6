//! Characters that walk: a kinematic body that is moved by casts of its shape.

use crate::bodies::body::{RigidBody, Shape};
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::ecs::components::{BodyHandle, BodyWarning, WalkerError};
use crate::ecs::issues::Source;
use crate::ecs::kinematic::KinematicTarget;
use crate::ecs::query::IndexWish;
use crate::ecs::state::PluginState;
use crate::math::Pose;
use crate::query::movers::KinematicMovers;
use crate::query::{
    Footing, Push, QueryFilter, QueryIndex, QueryShape, Slider, WalkInput, WalkSettings, WalkState,
};
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_ecs::system::SystemParam;
use bevy_math::Vec3;
use bevy_transform::components::Transform;

/// A character: walks up slopes and steps, along walls, rides on what moves, and pushes what is in its way.
///
/// In the air it keeps the velocity of what it jumped or walked off. Dynamic bodies do not move it; it pushes them by no more than
/// [`WalkSettings::push_force`]. Kinematic ones carry it, and take it along where they come against it.
///
/// For an entity with a `RigidBody::Kinematic` and a [`ConvexMesh`](crate::geometry::ConvexMesh), mostly a capsule, or a
/// [`Compound`](crate::geometry::Compound), that is no child; `WalkerPlugin` moves it in each step. Set `velocity` to where it is to go.
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
    /// Its own velocity, m/s, without that of what it stands on; in the air with what it kept of that.
    pub velocity: Vec3,
    /// What it stands on.
    pub ground: Option<Entity>,
    /// Unit normal of what it stands on.
    pub ground_normal: Option<Vec3>,
    drift: Vec3,
    footing: Option<Footing>,
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
    &'static Transform,
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

/// What characters move among.
#[derive(SystemParam)]
pub(crate) struct Surroundings<'w, 's> {
    // First, so that the index is there when the others look for it.
    _wish: Local<'s, IndexWish>,
    bodies: ResMut<'w, Bodies>,
    state: ResMut<'w, PluginState>,
    index: ResMut<'w, QueryIndex>,
}

/// What the characters of a step share.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    /// With who has walked already.
    moving: KinematicMovers,
    /// How many kinematic bodies were told by users where to go.
    told: usize,
    /// Of the one that walks.
    pushes: Vec<Push>,
}

/// System: moves all characters, one after the other: who stands on another after that one, else by the ids of their bodies.
///
/// It comes after what users changed has been read: what is moved by its `Transform` has the velocity then that leads there.
pub(crate) fn walk(
    mut around: Surroundings,
    mut characters: Query<Character>,
    mut shared: Local<Shared>,
) {
    let mut order = Vec::new();
    for ((entity, stance), walker, walking, _) in &characters {
        let able = stance.check(walker, &around.bodies).is_ok();
        let slot = stance.slot(&around.bodies).filter(|_| able);
        if let Some(slot) = slot {
            let on = walking.footing.map(|footing| footing.body);
            order.push((around.bodies.id(slot), slot, on, entity));
        }
    }
    if order.is_empty() {
        return;
    }
    order.sort_unstable_by_key(|&(id, ..)| id);
    // What came, or was put elsewhere, since the last step is not passed through.
    around.index.refresh(&around.bodies);
    shared.told = around.state.kinematic.len();
    shared.moving.find(&around.bodies);
    for entity in from_the_ground_up(order) {
        if let Ok((_, walker, walking, transform)) = characters.get_mut(entity.1) {
            let who = (entity.0, walker, walking);
            around.move_one(who, transform, &mut shared);
        }
    }
}

/// Slots and entities so that who stands on somebody else comes after that one.
fn from_the_ground_up(mut waiting: Vec<(BodyId, u32, Option<u32>, Entity)>) -> Vec<(u32, Entity)> {
    let mut order = Vec::with_capacity(waiting.len());
    while !waiting.is_empty() {
        let mut slots: Vec<u32> = waiting.iter().map(|&(_, slot, ..)| slot).collect();
        slots.sort_unstable();
        let waits = |on: Option<u32>| on.is_some_and(|on| slots.binary_search(&on).is_ok());
        let before = waiting.len();
        waiting.retain(|&(_, slot, on, entity)| {
            let waits = waits(on);
            if !waits {
                order.push((slot, entity));
            }
            waits
        });
        if waiting.len() == before {
            // In a ring.
            order.extend(waiting.drain(..).map(|(_, slot, _, entity)| (slot, entity)));
        }
    }
    order
}

impl Surroundings<'_, '_> {
    fn move_one(
        &mut self,
        (slot, mut walker, mut walking): (u32, Mut<Walker>, Mut<Walking>),
        transform: &Transform,
        Shared {
            moving,
            told,
            pushes,
        }: &mut Shared,
    ) {
        let bodies = &*self.bodies;
        let info = bodies.info(slot);
        let Some(shape) = cast_shape(&info.shape) else {
            return;
        };
        let step_dt = self.state.settings.step_dt;
        let input = walker.input(self.state.settings.gravity.0, step_dt);
        let mut state = walking.state(transform);
        if jumps(&input, &state) {
            walker.jump = 0.0;
        }
        let slider = Slider {
            shape,
            skin: walker.settings.skin,
        };
        let counts = |other: u32| other != slot && !bodies.is_sensor(other);
        let filter = QueryFilter::all()
            .with_layers(info.layers)
            .with_predicate(&counts);
        let queries = self.index.queries(bodies);
        let how = (&slider, &walker.settings);
        queries.walk_among(moving, how, &mut state, (&input, &filter), pushes);
        let entity = |slot| self.state.entities.of(slot, bodies.id(slot));
        *walking = Walking {
            velocity: state.velocity,
            ground: state.footing.and_then(|f| entity(f.body)),
            ground_normal: state.footing.map(|f| f.normal),
            drift: state.drift,
            footing: state.footing,
        };
        let to = (slot, Pose::new(state.position, state.rotation));
        let targets = (&mut self.state.kinematic, told);
        KinematicTarget::redirect(targets, &mut self.bodies, to, step_dt);
        moving.add(&self.bodies, slot);
        for push in pushes.drain(..) {
            let refused = push.apply(&mut self.bodies, step_dt);
            debug_assert!(refused.is_ok(), "pushes are finite");
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
    /// What of it the next step goes on from.
    fn state(&self, at: &Transform) -> WalkState {
        WalkState {
            position: at.translation,
            rotation: at.rotation,
            velocity: self.velocity,
            drift: self.drift,
            footing: self.footing,
        }
    }
}
