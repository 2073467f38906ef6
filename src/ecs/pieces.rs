//! Pieces as entities: each is born whole, by one insertion, while its parent still lives.
//!
//! A piece is a clone of the parent in which the components of the body are the piece's own. The clone is made in one go, so
//! whoever observes that any of them is added sees all of them.

use crate::bodies::anchors::Anchors;
use crate::bodies::body::RigidBody;
use crate::bodies::fatigue::Fatigue;
use crate::bodies::store::Bodies;
use crate::contact::material::Density;
use crate::ecs::components::*;
use crate::ecs::cut::let_fall;
use crate::ecs::families::{Families, families, sync_cracked};
use crate::ecs::forces::{ConstantForce, ConstantTorque, Mass, SurfaceVelocity};
use crate::ecs::issues::BodyIssues;
use crate::ecs::joint::{JointsOfA, JointsOfB, follow_pieces};
use crate::ecs::parents::{local_of, parent_of};
use crate::ecs::piece_children::hand_on_children;
use crate::ecs::set_aside::leave;
use crate::ecs::state::PluginState;
use crate::ecs::uncloned::name_uncloned;
use crate::fracture::Fractures;
use crate::geometry::{Compound, ConvexMesh};
use crate::mass::MassProperties;
use crate::math::Pose;
use crate::slice::fracturable::Fracturable;
use bevy_ecs::component::ComponentCloneBehavior;
use bevy_ecs::entity::{
    ComponentCloneCtx, EntityCloner, EntityClonerBuilder, OptOut, SourceComponent,
};
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_transform::components::{GlobalTransform, Transform};
use std::cell::RefCell;

/// The entity that stands for what this one is a piece of. Pieces of pieces belong to the same, and so do clones of pieces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Component)]
#[relationship(relationship_target = Pieces)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct PieceOf(pub Entity);

/// The pieces of what once was one body. Despawning this entity despawns them all; it goes when the last of them goes.
#[derive(Debug, Default, Component)]
#[relationship_target(relationship = PieceOf, linked_spawn)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Pieces(Vec<Entity>);

/// What the pieces of an entity with [`Pieces`] were.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Remains {
    /// The entity that first broke. It is no more.
    pub of: Entity,
}

/// Which components pieces do not get from what they were, besides those that the plugin gives them or takes from them.
#[derive(Debug, Default, Resource)]
pub struct PieceRules {
    dropped: Vec<fn(&mut EntityClonerBuilder<OptOut>)>,
}

impl PieceRules {
    /// Pieces do not get `C`.
    pub fn drop_component<C: Component>(&mut self) -> &mut Self {
        self.dropped.push(|builder| {
            builder.deny::<C>();
        });
        self
    }
}

/// The body's components of the piece that is being cloned.
struct Staged {
    kind: RigidBody,
    mesh: Option<ConvexMesh>,
    compound: Option<Compound>,
    transform: Transform,
    /// Whether the parent's parent is its parent too.
    is_child: bool,
    global: GlobalTransform,
    linear: LinearVelocity,
    angular: AngularVelocity,
    density: Density,
    mass: MassProperties,
    handle: BodyHandle,
    fracturable: Option<Fracturable>,
    anchors: Option<Anchors>,
}

thread_local! {
    /// What functions that clone a component read: they are given nothing but the component.
    static STAGED: RefCell<Option<Staged>> = const { RefCell::new(None) };
}

/// Clones of `C` are what `part` says of the piece.
fn stage<C: Component>(
    builder: &mut EntityClonerBuilder<OptOut>,
    clone: fn(&SourceComponent, &mut ComponentCloneCtx),
) {
    builder.override_clone_behavior::<C>(ComponentCloneBehavior::Custom(clone));
}

/// A function that writes a part of the piece in place of a clone.
macro_rules! staged {
    ($part:ident) => {
        |_, target| {
            STAGED.with_borrow(|staged| {
                if let Some(staged) = staged {
                    target.write_target_component(staged.$part.clone());
                }
            })
        }
    };
}

/// The same of a part that a piece may have none of.
macro_rules! staged_if_any {
    ($part:ident) => {
        |_, target| {
            STAGED.with_borrow(|staged| {
                let own = staged.as_ref().and_then(|staged| staged.$part.clone());
                own.into_iter()
                    .for_each(|own| target.write_target_component(own));
            })
        }
    };
}

impl Staged {
    fn of(world: &World, parent: Entity, slot: u32) -> Option<Self> {
        let bodies = world.resource::<Bodies>();
        let (pose, (v, omega)) = (bodies.pose(slot), bodies.velocity(slot));
        let in_world = Transform {
            translation: pose.position,
            rotation: pose.rotation,
            ..Transform::IDENTITY
        };
        let above = parent_of(world, parent);
        // The shape is as large as it is in the world: beneath a scaled parent it must be scaled back.
        let local = above.map(|above| {
            let (scale, ..) = above.to_scale_rotation_translation();
            local_of(&above, pose, scale.recip())
        });
        // Beneath one that is scaled to nothing there is no place.
        let local = local.filter(Transform::is_finite);
        Some(Self {
            kind: bodies.kind(slot),
            mesh: bodies.convex(slot).cloned(),
            compound: bodies.compound(slot).cloned(),
            transform: local.unwrap_or(in_world),
            is_child: local.is_some(),
            global: in_world.into(),
            linear: LinearVelocity(v),
            angular: AngularVelocity(omega),
            density: Density(bodies.density(slot)),
            mass: *bodies.mass(slot),
            handle: BodyHandle(Some((slot, bodies.id(slot)))),
            fracturable: bodies.fracturable(slot).cloned(),
            anchors: bodies.anchors(slot).cloned(),
        })
    }

    /// Puts what the parent had not, and so was not cloned, onto the piece.
    fn complete(self, world: &mut World, piece: Entity) {
        let Ok(mut piece) = world.get_entity_mut(piece) else {
            return;
        };
        if let Some(mesh) = self.mesh.filter(|_| !piece.contains::<ConvexMesh>()) {
            piece.insert(mesh);
        }
        if let Some(compound) = self.compound.filter(|_| !piece.contains::<Compound>()) {
            piece.insert(compound);
        }
        if let Some(fracturable) = self
            .fracturable
            .filter(|_| !piece.contains::<Fracturable>())
        {
            piece.insert(fracturable);
        }
        if let Some(anchors) = self.anchors {
            piece.insert(anchors);
        }
        // What is there already is not touched.
        let motion = (
            self.transform,
            self.linear,
            self.angular,
            self.density,
            self.mass,
        );
        piece.insert_if_new((self.kind, motion, self.handle));
    }
}

/// Command: spawns an entity for every piece, tells what happened, despawns the parents.
///
/// A piece that broke again in the same step never was an entity: its pieces are told of as those of the first parent.
/// Pieces of a body without an entity stay bodies without entities; those of an entity that went in the same step go too.
pub(super) fn spawn_pieces(world: &mut World) {
    let done = std::mem::take(&mut world.resource_mut::<Fractures>().done);
    let_fall(world, &done);
    let Families { told, orphans } = families(world, &done);
    orphans.iter().for_each(|&slot| forget_body(world, slot));
    let events: Vec<Fractured> = told
        .into_iter()
        .map(|(event, slots)| Fractured {
            pieces: spawn_family(world, (event.parent, event.goes_on), slots),
            ..event
        })
        .collect();
    follow_pieces(world);
    // Who is told of it finds what goes on as it is now.
    sync_cracked(world);
    for event in events {
        world.trigger(event.clone());
        if !event.goes_on {
            leave(world, event.parent);
        }
        world.write_message(event);
    }
    world.resource_mut::<Fractures>().done = done;
}

/// The pieces of one parent, which get what it leaves.
fn spawn_family(
    world: &mut World,
    (parent, goes_on): (Entity, bool),
    slots: Vec<u32>,
) -> Vec<Entity> {
    let remains = remains_of(world, parent);
    let pieces: Vec<(u32, Entity)> = (slots.into_iter())
        .filter_map(|slot| {
            let piece = spawn_piece(world, parent, remains, slot);
            if piece.is_none() {
                forget_body(world, slot);
            }
            piece
        })
        .collect();
    if world.get::<Pieces>(remains).is_none() {
        // Nothing came off that is large enough to be a piece, or observers have taken it away.
        world.try_despawn(remains).ok();
    }
    name_uncloned(world, parent, pieces.first().map(|&(_, piece)| piece));
    let mut heirs = pieces.clone();
    let handle = world.get::<BodyHandle>(parent).and_then(|handle| handle.0);
    heirs.extend(handle.filter(|_| goes_on).map(|(slot, _)| (slot, parent)));
    hand_on_children(world, parent, &heirs);
    pieces.into_iter().map(|(_, piece)| piece).collect()
}

/// The entity that stands for what `parent` was or is a piece of.
fn remains_of(world: &mut World, parent: Entity) -> Entity {
    let known = world.get::<PieceOf>(parent).map(|of| of.0);
    known.unwrap_or_else(|| world.spawn(Remains { of: parent }).id())
}

/// Observer: the last of the pieces is gone.
pub(crate) fn on_last_piece_gone(remove: On<Remove<Pieces>>, mut commands: Commands) {
    commands.entity(remove.entity).try_despawn();
}

/// One piece: its slot and its entity. Nothing if an observer of its birth despawned it.
fn spawn_piece(
    world: &mut World,
    parent: Entity,
    remains: Entity,
    slot: u32,
) -> Option<(u32, Entity)> {
    // An observer of another piece may have taken the parent away.
    world.get_entity(parent).ok()?;
    let staged = Staged::of(world, parent, slot)?;
    let transform = staged.transform;
    let keeps_breaking = staged.fracturable.is_some();
    let is_child = staged.is_child;
    let piece = world.spawn_empty().id();
    let bodies = world.resource::<Bodies>();
    let (id, seen) = (bodies.id(slot), seen_at(bodies.pose(slot)));
    let wears_out = keeps_breaking || bodies.is_bonded(slot);
    let above = world.get::<ChildOf>(parent).map(ChildOf::parent);
    let above = above.filter(|_| is_child);
    let state = &mut *world.resource_mut::<PluginState>();
    state.entities.set(slot, id, piece, seen);
    if let Some(above) = above {
        state.entities.set_local(slot, above, transform);
        state.children.push(piece); // What is above it is not written yet.
    }
    if state.options.is_used {
        state.options.entities.push(piece);
    }
    let dropped = world
        .get_resource::<PieceRules>()
        .map(|rules| rules.dropped.clone());
    STAGED.set(Some(staged));
    let mut builder = EntityCloner::build_opt_out(world);
    keep_apart(&mut builder, keeps_breaking);
    if !is_child {
        builder.deny::<ChildOf>();
    }
    (dropped.iter().flatten()).for_each(|deny| deny(&mut builder));
    builder.clone_entity(parent, piece);
    let staged = STAGED.take();
    if world.get_entity(piece).is_err() {
        return None;
    }
    if let Some(staged) = staged {
        staged.complete(world, piece);
    }
    if let Some(mut fatigue) = world.get_mut::<Fatigue>(piece) {
        if wears_out {
            fatigue.damage = 0.0;
        } else {
            world.entity_mut(piece).remove::<Fatigue>();
        }
    }
    toggle_if_disabled(world, piece);
    // Whole before it is said to be a piece.
    let mut born = world.get_entity_mut(piece).ok()?;
    born.insert(PieceOf(remains));
    world.get_entity(piece).is_ok().then_some((slot, piece))
}

/// A body that never got its entity goes.
fn forget_body(world: &mut World, slot: u32) {
    let bodies = world.resource::<Bodies>();
    if bodies.contains(slot) {
        let body = (slot, bodies.id(slot));
        world.resource_mut::<PluginState>().queue.left.push(body);
    }
}

/// A pose as the `Transform` that was last read of a body.
fn seen_at(pose: Pose) -> Transform {
    Transform {
        translation: pose.position,
        rotation: pose.rotation,
        scale: Vec3::ONE,
    }
}

/// A piece of an entity that was disabled while it broke takes no part either.
fn toggle_if_disabled(world: &mut World, piece: Entity) {
    let Ok(entity) = world.get_entity(piece) else {
        return;
    };
    if entity.contains::<bevy_ecs::entity_disabling::Disabled>() {
        let state = &mut *world.resource_mut::<PluginState>();
        state.queue.toggled.push(piece);
    }
}

/// What of the parent a piece does not get, and what it has of its own instead.
fn keep_apart(builder: &mut EntityClonerBuilder<OptOut>, keeps_breaking: bool) {
    builder.add_observers(true);
    // Whatever requires one of these is denied too: nothing that `RigidBody` requires may be among them.
    builder.deny::<(
        (
            MassOverride,
            Mass,
            ConstantForce,
            ConstantTorque,
            Anchors,
            SurfaceVelocity,
        ),
        (Sleeping, Children, BodyIssues, PieceOf),
        (JointsOfA, JointsOfB),
    )>();
    stage::<RigidBody>(builder, staged!(kind));
    stage::<ConvexMesh>(builder, staged_if_any!(mesh));
    stage::<Compound>(builder, staged_if_any!(compound));
    stage::<Transform>(builder, staged!(transform));
    stage::<GlobalTransform>(builder, staged!(global));
    stage::<LinearVelocity>(builder, staged!(linear));
    stage::<AngularVelocity>(builder, staged!(angular));
    stage::<Density>(builder, staged!(density));
    stage::<MassProperties>(builder, staged!(mass));
    stage::<BodyHandle>(builder, staged!(handle));
    if keeps_breaking {
        stage::<Fracturable>(builder, staged_if_any!(fracturable));
    } else {
        builder.deny::<Fracturable>();
    }
}
