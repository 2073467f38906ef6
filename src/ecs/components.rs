//! Components and messages that a user of the plugin meets.

use crate::bodies::body::BodyError;
use crate::contact::body_id::BodyId;
use crate::fracture::{Bond, BondError, CutError, Ledger};
use crate::geometry::{CompoundError, HullError};
use crate::joints::JointError;
use crate::mass::MassProperties;
use crate::math::Plane;
use bevy_ecs::change_detection::Tick;
use bevy_ecs::entity::{ComponentCloneCtx, SourceComponent};
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use bevy_math::Vec3;
use bevy_transform::components::Transform;
use smallvec::SmallVec;

/// Velocity of the center of mass, world axes, m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct LinearVelocity(pub Vec3);

/// Angular velocity, world axes, rad/s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct AngularVelocity(pub Vec3);

/// Mass properties to use instead of those that follow from shape and density.
#[derive(Clone, Copy, Debug, Default, PartialEq, Component)]
#[component(summary_tick)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct MassOverride(pub MassProperties);

/// Where the simulation keeps the body of this entity. Written by the plugin; a clone of the entity gets its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Component)]
#[component(clone_behavior = Ignore)]
pub struct BodyHandle(pub(crate) Option<(u32, BodyId)>);

impl BodyHandle {
    /// Slot and id of the body, once the entity takes part in the simulation.
    pub fn get(&self) -> Option<(u32, BodyId)> {
        self.0
    }
}

/// The body sleeps: it rests, and no step touches it until something wakes it. Written by the plugin, and a filter for
/// queries.
///
/// Remove it to wake the body and all that fell asleep with it. Insert or spawn it to let a body that rests fall asleep at
/// the end of the next step, without waiting for [`SleepConfig::time`](crate::solver::config::SleepConfig::time); it is taken
/// off again if the body or its island does not rest by then.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Sleeping;

/// The shape of this body comes later: until it does, it is no issue that there is none.
///
/// Constructors that wait for assets or children put it on and take it off; so may those of your own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Component)]
#[component(clone_behavior = Custom(not_cloned))]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct ShapeAwaited;

impl ShapeAwaited {
    /// Hook of a constructor that goes: nothing is to come any more.
    pub(crate) fn end(mut world: DeferredWorld, context: HookContext) {
        if let Ok(mut entity) = world.commands().get_entity(context.entity) {
            entity.try_remove::<Self>();
        }
    }
}

/// What broke a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum FractureCause {
    /// A cut that was asked for.
    #[default]
    Cut,
    /// A sustained load, or its own weight, that was more than bonds within it bear.
    Load,
    /// A blow.
    Impact {
        /// The entity of the body that gave most of it, if it has one.
        by: Option<Entity>,
        /// Where it acted, world, m.
        point: Vec3,
        /// Unit vector along which the body was pushed, world axes.
        direction: Vec3,
        /// Sum of the normal impulses, N s.
        impulse: f32,
        /// Kinetic energy that they would have turned into something else, J.
        energy: f32,
    },
}

/// A body became several: an event of the parent entity, which still lives then with all its components, and a message, when
/// it is despawned, unless it goes on.
#[derive(Clone, Debug, PartialEq, Message, EntityEvent)]
pub struct Fractured {
    /// The entity that breaks.
    #[event_target]
    pub parent: Entity,
    /// The entities that take its place; each has the parent's other components. Pieces of pieces that broke in the same
    /// step are among them.
    pub pieces: Vec<Entity>,
    /// What broke it.
    pub cause: FractureCause,
    /// The planes of the cut, world frame.
    pub planes: SmallVec<[Plane; 8]>,
    /// Mass, momentum, angular momentum and energy before and after the parent broke. What broke again in the same step is counted as what came
    /// of it.
    pub ledger: Ledger,
    /// Whether the parent lives on, with those of its parts that bonds still hold to where it is anchored. It is none of the pieces.
    pub goes_on: bool,
}

/// A piece of debris that will be removed, as [`DebrisRules::fade`](crate::fracture::DebrisRules::fade) says: for whoever draws it
/// to let it fade, shrink or sink. Written by the plugin in each step.
#[derive(Clone, Copy, Debug, PartialEq, Component)]
#[component(clone_behavior = Ignore)]
pub struct Fading {
    /// Time until it is removed, s.
    pub remaining: f32,
    /// Time that it has for fading altogether, s.
    pub duration: f32,
}

impl Fading {
    /// How much of it is left to be seen: from 1 at the beginning to 0.
    pub fn opacity(&self) -> f32 {
        (self.remaining / self.duration).clamp(0.0, 1.0)
    }
}

/// A piece was removed because [`DebrisRules`](crate::fracture::DebrisRules) say so. The entity is gone when this is read.
#[derive(Clone, Copy, Debug, PartialEq, Message)]
pub struct DebrisRemoved {
    /// The entity that it was.
    pub entity: Entity,
    /// What went with it, kg.
    pub mass: f32,
}

/// Two bodies that were bonded came apart, or their load passed the strength of the bond. Sent once; a bond does not heal.
#[derive(Clone, Copy, Debug, PartialEq, Message)]
pub struct BondBroken {
    /// The entities that are no longer bonded; the one whose body was made first comes first.
    pub entities: [Entity; 2],
    /// The bond that they had.
    pub bond: Bond,
}

/// Something about one entity is not usable. The rest of the scene goes on as if the entity were not there.
///
/// Sent once when the problem appears; it is also logged as a warning.
#[derive(Clone, Debug, PartialEq, Message)]
pub struct BodyWarning {
    /// The entity.
    pub entity: Entity,
    /// What is wrong.
    pub problem: BodyProblem,
}

/// What is wrong with an entity.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BodyProblem {
    /// Its state or material is not usable.
    #[error(transparent)]
    Body(#[from] BodyError),
    /// No shape comes of its `ShapeConstructor` or `LevelConstructor`.
    #[error("no shape comes of its constructor: {0}")]
    Shape(#[from] HullError),
    /// Its children, or the parts of its `CompoundConstructor`, make no compound.
    #[error("no shape comes of its children or parts: {0}")]
    Compound(#[from] CompoundError),
    /// A cut of it was refused.
    #[error("the cut was not made: {0}")]
    Cut(#[from] CutError),
    /// It broke, and its pieces could not get a component of it.
    #[error(
        "pieces do not get the component {0}, which is not Clone; PieceRules::drop_component says that this is meant"
    )]
    NotCloned(String),
    /// A bond was not made.
    #[error("the bond was not made: {0}")]
    Bond(#[from] BondError),
    /// A joint does not hold.
    #[error("the joint does not hold: {0}")]
    Joint(#[from] JointError),
    /// A character stands still.
    #[error("the Walker does nothing: {0}")]
    Walker(#[from] WalkerError),
}

/// Why a [`Walker`](crate::ecs::Walker) does not walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WalkerError {
    /// Nobody moves it.
    #[error("the app has no WalkerPlugin")]
    NoPlugin,
    /// It has no body, or one that moves by itself or not at all.
    #[error("it needs RigidBody::Kinematic")]
    NotKinematic,
    /// A half-space or a level of triangles has no inside to cast.
    #[error("it needs a ConvexMesh or a Compound")]
    Shape,
    /// It is moved in the world, and a child in its parent.
    #[error("it must not be a child")]
    Child,
    /// Its velocity or its jump is NaN or infinite.
    #[error("its velocity or its jump is not finite")]
    NotFinite,
    /// Its [`WalkSettings`](crate::query::WalkSettings) mean nothing.
    #[error(
        "its settings mean nothing: up needs length 1, and no other is NaN, negative or infinite but the slope"
    )]
    Settings,
}

/// What clones get of components that are data, but belong to one entity: nothing. Bevy reads no scene file's components that say `Ignore`.
pub(crate) fn not_cloned(_: &SourceComponent, _: &mut ComponentCloneCtx) {}

/// Entities of the bodies, by slot, and what is needed to tell the user's changes from the plugin's own.
#[derive(Clone, Debug, Default)]
pub(crate) struct BodyEntities {
    /// With the id of the body, because a slot may have been given to another body since.
    entity: Vec<Option<(BodyId, Entity)>>,
    /// Place in the world and scale as last read from the user.
    pub(crate) seen: Vec<Transform>,
    /// Of bodies with parents: the parent, and the `Transform` as last read or written; empty unless there are some.
    local: Vec<Option<(Entity, Transform)>>,
    /// Tick of the last write-back: components that bear it were written by the plugin.
    pub(crate) written: Tick,
    /// Tick at which components were last read: what changed since is for the next step, and not to be written over.
    pub(crate) read: Tick,
}

impl BodyEntities {
    /// The entity of a body; `None` for one that was put into `Bodies` without an entity.
    pub(crate) fn of(&self, slot: u32, id: BodyId) -> Option<Entity> {
        let known = self.entity.get(slot as usize).copied().flatten();
        known
            .filter(|(owner, _)| *owner == id)
            .map(|(_, entity)| entity)
    }

    /// The parent of a body that has one, and its `Transform` as it was last read or written.
    pub(crate) fn local(&self, slot: u32) -> Option<(Entity, Transform)> {
        self.local.get(slot as usize).copied().flatten()
    }

    pub(crate) fn set_local(&mut self, slot: u32, parent: Entity, local: Transform) {
        let needed = self.local.len().max(slot as usize + 1);
        self.local.resize(needed, None);
        self.local[slot as usize] = Some((parent, local));
    }

    /// The body has no parent.
    pub(crate) fn forget_local(&mut self, slot: u32) {
        if let Some(local) = self.local.get_mut(slot as usize) {
            *local = None;
        }
    }

    pub(crate) fn set(&mut self, slot: u32, id: BodyId, entity: Entity, seen: Transform) {
        let needed = self.entity.len().max(slot as usize + 1);
        self.entity.resize(needed, None);
        self.seen.resize(needed, Transform::IDENTITY);
        self.entity[slot as usize] = Some((id, entity));
        self.seen[slot as usize] = seen;
        self.forget_local(slot);
    }
}

/// Sends a warning about `entity` both to the log and as a message.
pub(crate) fn warn(
    warnings: &mut Messages<BodyWarning>,
    entity: Entity,
    problem: impl Into<BodyProblem>,
) {
    let problem = problem.into();
    log::warn!("physics body {entity}: {problem}");
    warnings.write(BodyWarning { entity, problem });
}
