//! Bodies whose parts are their children.

use crate::bodies::body::{BodyError, RigidBody};
use crate::ecs::components::{BodyProblem, BodyWarning, ShapeAwaited};
use crate::ecs::issues::Source;
use crate::ecs::parents::place;
use crate::ecs::shape_constructor::note;
use crate::ecs::state::PluginState;
use crate::geometry::{Compound, CompoundPart, ConvexMesh};
use crate::math::Pose;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::query::Allow;
use bevy_ecs::world::DeferredWorld;
use bevy_math::{Affine3A, Vec3};
use bevy_transform::components::Transform;
use std::any::TypeId;

/// The [`Compound`] of a body is made of its children: each that has a [`ConvexMesh`] and no [`RigidBody`] is a part, and so are
/// their children. Made as soon as none of them waits for its shape ([`ShapeAwaited`]), and anew whenever their shapes or `Transform`s
/// change, or children come or go. A [`Compound`] that somebody else puts there is replaced.
///
/// ```
/// use bevy_cleave::prelude::*;
/// # use bevy_ecs::prelude::*;
/// # use bevy_transform::components::Transform;
/// # let mut world = World::new();
/// world.spawn((
///     RigidBody::Dynamic,
///     CompoundOfChildren,
///     children![
///         bevy_cleave::cuboid!(1.0, 0.1, 1.0),
///         (bevy_cleave::cuboid!(0.1, 1.0, 0.1), Transform::from_xyz(0.0, -0.55, 0.0)),
///     ],
/// ));
/// ```
///
/// If no part is usable the entity gets [`BodyIssues`](crate::ecs::BodyIssues).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Component)]
#[require(MadeOf)]
#[component(on_remove = Self::forget, clone_behavior = Ignore)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct CompoundOfChildren;

impl CompoundOfChildren {
    /// Hook: nothing is to come any more, and nothing is wrong with what is not there.
    fn forget(mut world: DeferredWorld, context: HookContext) {
        let entity = context.entity;
        ShapeAwaited::end(world.reborrow(), context);
        world.commands().queue(move |world: &mut World| {
            let made_of = world.get_entity_mut(entity).ok().and_then(|mut entity| {
                let is_gone = !entity.contains::<Self>();
                is_gone.then(|| entity.take::<MadeOf>()).flatten()
            });
            let parts = made_of.and_then(|made_of| made_of.made);
            if let (Some(parts), Some(mut state)) = (parts, world.get_resource_mut::<PluginState>())
            {
                state.queue.lone_parts.extend(parts.entities);
            }
            note::<Self, BodyError>(world, entity, Ok(()));
        });
    }
}

/// What the compound was made of, and what became of it.
#[derive(Clone, Debug, Default, Component)]
#[component(clone_behavior = Ignore)]
pub(crate) struct MadeOf {
    made: Option<Made>,
    /// Whether a part was there whose shape was yet to come.
    has_waited: bool,
}

/// Parts, and what they made.
#[derive(Clone, Debug)]
struct Made {
    children: Vec<Child>,
    entities: Vec<Entity>,
    compound: Option<Compound>,
}

impl Made {
    /// Whether an entity has what these children make.
    fn is_current(&self, found: &Found, compound: Option<&Compound>) -> bool {
        let is_made = match (&self.compound, compound) {
            (Some(made), Some(compound)) => made.is_same(compound),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        };
        let mut both = self.children.iter().zip(&found.children);
        let is_as_many = self.children.len() == found.children.len();
        is_made && is_as_many && self.entities == found.entities && both.all(|(a, b)| a.is_same(b))
    }
}

/// A part as its entity has it.
#[derive(Clone, Debug)]
struct Child {
    pose: Pose,
    scale: Vec3,
    shape: ConvexMesh,
}

impl Child {
    fn is_same(&self, other: &Self) -> bool {
        self.pose == other.pose && self.scale == other.scale && self.shape.is_same(&other.shape)
    }

    fn part(&self) -> Result<CompoundPart, BodyError> {
        let shape = if self.scale == Vec3::ONE {
            self.shape.clone()
        } else {
            let scaled = self.shape.scaled(self.scale);
            scaled.map_err(|_| BodyError::Scaled(self.scale))?
        };
        Ok(CompoundPart::new(self.pose, shape))
    }
}

type Root = (
    Entity,
    Option<&'static Children>,
    &'static mut MadeOf,
    Option<&'static mut Compound>,
    Has<ShapeAwaited>,
);

type Member = (
    Option<&'static Transform>,
    Option<&'static ConvexMesh>,
    Option<&'static Children>,
    Has<ShapeAwaited>,
);

/// Run condition of [`make_compounds`].
pub(crate) fn any(roots: Query<(), (With<CompoundOfChildren>, Allow<Disabled>)>) -> bool {
    !roots.is_empty()
}

/// System: makes compounds of children that are new or have changed.
pub(crate) fn make_compounds(
    mut commands: Commands,
    mut state: ResMut<PluginState>,
    mut warnings: ResMut<Messages<BodyWarning>>,
    mut roots: Query<Root, With<CompoundOfChildren>>,
    members: Query<Member, Without<RigidBody>>,
) {
    for (entity, children, mut made_of, compound, is_awaited) in &mut roots {
        let mut found = Found::default();
        let children = children.into_iter().flatten();
        let ways = children.map(|&child| (child, Affine3A::IDENTITY));
        found.collect(ways.collect(), &members);
        // What begins to move has all of its parts.
        if found.is_incomplete && compound.is_none() {
            made_of.has_waited = true;
            if !is_awaited {
                commands.entity(entity).insert(ShapeAwaited);
            }
            continue;
        }
        // Somebody else says that there will be parts, such as those of a scene that is loaded.
        if is_awaited && found.entities.is_empty() && !made_of.has_waited {
            continue;
        }
        let before = made_of.made.as_ref();
        if before.is_some_and(|made| made.is_current(&found, compound.as_deref())) {
            continue;
        }
        // What became a part, or is none any more, may do nothing on its own.
        let known = before.map_or(&[][..], |made| &made.entities);
        if known != found.entities {
            let lone = &mut state.queue.lone_parts;
            lone.extend(found.entities.iter().chain(known));
        }
        let made = found.compound();
        let source = Source::Constructor(TypeId::of::<CompoundOfChildren>());
        let made = state.issues.note(&mut warnings, entity, source, made);
        match (made.clone(), compound) {
            (Some(made), Some(mut compound)) => *compound = made,
            (Some(made), None) => {
                commands.entity(entity).insert(made);
            }
            (None, Some(_)) => {
                commands.entity(entity).remove::<Compound>();
            }
            (None, None) => {}
        }
        if is_awaited {
            commands.entity(entity).remove::<ShapeAwaited>();
        }
        made_of.made = Some(Made {
            children: found.children,
            entities: found.entities,
            compound: made,
        });
    }
}

/// The parts that were found, and whose they are.
#[derive(Default)]
struct Found {
    children: Vec<Child>,
    entities: Vec<Entity>,
    error: Option<BodyError>,
    /// Whether the shape of a part is still to come.
    is_incomplete: bool,
}

impl Found {
    /// Goes through entities, each with the frame of its parent, and what is below them, in order.
    fn collect(
        &mut self,
        mut ways: Vec<(Entity, Affine3A)>,
        members: &Query<Member, Without<RigidBody>>,
    ) {
        ways.reverse();
        while let Some((entity, above)) = ways.pop() {
            let Ok((transform, shape, children, is_awaited)) = members.get(entity) else {
                continue;
            };
            let own = transform.copied().unwrap_or_default();
            self.is_incomplete |= is_awaited;
            if let Some(shape) = shape {
                self.entities.push(entity);
                match place(&own, Some(above)) {
                    Ok((pose, scale)) => self.children.push(Child {
                        pose,
                        scale,
                        shape: shape.clone(),
                    }),
                    Err(error) => self.error = Some(error),
                }
            }
            let below = above * own.compute_affine();
            let children = children.into_iter().flatten();
            let first = ways.len();
            ways.extend(children.map(|&child| (child, below)));
            ways[first..].reverse();
        }
    }

    fn compound(&self) -> Result<Compound, BodyProblem> {
        if let Some(error) = self.error {
            return Err(error.into());
        }
        let parts = self.children.iter().map(Child::part);
        let parts = parts.collect::<Result<Vec<_>, _>>()?;
        Ok(Compound::new(parts)?)
    }
}
