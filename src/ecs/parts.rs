//! Bodies whose parts are their children.

use crate::bodies::body::{BodyError, RigidBody};
use crate::contact::layers::CollisionLayers;
use crate::contact::material::{Density, Friction, Restitution};
use crate::ecs::components::{BodyProblem, BodyWarning, ShapeAwaited, not_cloned};
use crate::ecs::issues::{Issues, Source};
use crate::ecs::parents::place;
use crate::ecs::shape_constructor::note;
use crate::ecs::state::PluginState;
use crate::geometry::{Compound, CompoundPart, ConvexMesh};
use crate::math::Pose;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::query::{Allow, QueryData};
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
/// If no part is usable the entity gets [`BodyIssues`](crate::ecs::BodyIssues), and so does a part with something that is for the whole body:
/// materials, layers, mass and the like belong to this entity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Component)]
#[require(MadeOf)]
#[component(on_remove = Self::forget, clone_behavior = Custom(not_cloned))]
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
            if let (Some(made_of), Some(mut state)) =
                (made_of, world.get_resource_mut::<PluginState>())
            {
                for part in made_of.chosen {
                    state.issues.mend(part, Source::PartMaterial);
                }
                let parts = made_of.made.map(|made| made.entities);
                state.queue.lone_parts.extend(parts.into_iter().flatten());
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
    /// Parts for which somebody chose a material, which does nothing there.
    chosen: Vec<Entity>,
}

impl MadeOf {
    /// Tells of the parts that have materials of their own, and that the others have none any more.
    fn choose(
        &mut self,
        chosen: Vec<Entity>,
        issues: &mut Issues,
        warnings: &mut Messages<BodyWarning>,
    ) {
        if self.chosen == chosen {
            return;
        }
        for &part in self.chosen.iter().filter(|part| !chosen.contains(part)) {
            issues.mend(part, Source::PartMaterial);
        }
        for &part in chosen.iter().filter(|part| !self.chosen.contains(part)) {
            issues.raise(warnings, part, Source::PartMaterial, BodyError::IdlePart);
        }
        self.chosen = chosen;
    }
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
    (Has<ShapeAwaited>, Has<Disabled>),
);

type Member = (
    Option<&'static Transform>,
    Option<&'static ConvexMesh>,
    Option<&'static Children>,
    Has<ShapeAwaited>,
    Materials,
);

/// Materials of an entity, which may be left from when it was a body.
#[derive(QueryData)]
pub(crate) struct Materials {
    density: Option<&'static Density>,
    friction: Option<&'static Friction>,
    restitution: Option<&'static Restitution>,
    layers: Option<&'static CollisionLayers>,
}

impl MaterialsItem<'_, '_> {
    /// Whether somebody chose one: bodies come with the others.
    fn is_chosen(&self) -> bool {
        fn is_other<T: Default + PartialEq>(material: Option<&T>) -> bool {
            material.is_some_and(|material| *material != T::default())
        }
        is_other(self.density)
            || is_other(self.friction)
            || is_other(self.restitution)
            || is_other(self.layers)
    }
}

/// Run condition of [`make_compounds`].
pub(crate) fn any(roots: Query<(), (With<CompoundOfChildren>, Allow<Disabled>)>) -> bool {
    !roots.is_empty()
}

/// System: makes compounds of children that are new or have changed.
pub(crate) fn make_compounds(
    mut commands: Commands,
    mut state: ResMut<PluginState>,
    mut warnings: ResMut<Messages<BodyWarning>>,
    mut roots: Query<Root, (With<CompoundOfChildren>, Allow<Disabled>)>,
    members: Query<Member, Without<RigidBody>>,
) {
    for (entity, children, mut made_of, compound, (is_awaited, is_disabled)) in &mut roots {
        if is_disabled {
            made_of.choose(Vec::new(), &mut state.issues, &mut warnings);
            continue;
        }
        let mut found = Found::below(children, &members);
        let chosen = std::mem::take(&mut found.chosen);
        made_of.choose(chosen, &mut state.issues, &mut warnings);
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
    /// Those of them for which somebody chose a material.
    chosen: Vec<Entity>,
    error: Option<BodyError>,
    /// Whether the shape of a part is still to come.
    is_incomplete: bool,
}

impl Found {
    /// The parts of a compound that has these children.
    fn below(children: Option<&Children>, members: &Query<Member, Without<RigidBody>>) -> Self {
        let children = children.into_iter().flatten();
        let ways = children.map(|&child| (child, Affine3A::IDENTITY));
        let mut found = Self::default();
        found.collect(ways.collect(), members);
        found
    }

    /// Goes through entities, each with the frame of its parent, and what is below them, in order.
    fn collect(
        &mut self,
        mut ways: Vec<(Entity, Affine3A)>,
        members: &Query<Member, Without<RigidBody>>,
    ) {
        ways.reverse();
        while let Some((entity, above)) = ways.pop() {
            let Ok((transform, shape, children, is_awaited, materials)) = members.get(entity)
            else {
                continue;
            };
            let own = transform.copied().unwrap_or_default();
            self.is_incomplete |= is_awaited;
            if let Some(shape) = shape {
                self.entities.push(entity);
                if materials.is_chosen() {
                    self.chosen.push(entity);
                }
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
