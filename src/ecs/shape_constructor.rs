//! Shapes as data that a scene file can hold: `ConvexMesh` itself is shared and keeps what was computed for it.

mod compound;
mod level;
mod mesh;
mod round;

pub use compound::{CompoundConstructor, PartDescription};
pub use level::LevelConstructor;
pub use mesh::MeshDescription;
pub use round::RoundForm;

use crate::ecs::components::{BodyProblem, BodyWarning, not_cloned};
use crate::ecs::issues::Source;
use crate::ecs::state::PluginState;
use crate::geometry::{ConvexMesh, HullError};
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use bevy_math::Vec3;
use std::any::TypeId;

/// What a [`ConvexMesh`] is made from. An entity that gets one gets the shape.
///
/// For scene files and inspectors: with the cargo feature `reflect` it is registered for both. It stays on the entity, so that what
/// was loaded can be saved again; other shapes are described by [`of`](Self::of). Pieces get none. [`CompoundConstructor`] and
/// [`LevelConstructor`] are the same for compounds and levels.
///
/// No shape comes of unusable numbers: then the entity gets [`BodyIssues`](crate::ecs::BodyIssues).
#[derive(Clone, Component, Debug, PartialEq)]
#[component(on_insert = Self::construct, on_remove = Self::forget, clone_behavior = Custom(not_cloned))]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum ShapeConstructor {
    /// [`ConvexMesh::cuboid`].
    Cuboid {
        /// Lengths of its edges, m.
        size: Vec3,
    },
    /// [`ConvexMesh::icosphere`].
    Icosphere {
        /// m.
        radius: f32,
        /// How often the faces of the icosahedron are divided by four.
        subdivisions: u32,
    },
    /// [`ConvexMesh::regular_prism`].
    RegularPrism {
        /// Of the polygon.
        sides: u32,
        /// Of the polygon, m.
        circumradius: f32,
        /// Along y, m.
        height: f32,
    },
    /// [`ConvexMesh::wedge`].
    Wedge {
        /// Lengths along x, y and z, m.
        size: Vec3,
    },
    /// What rolls.
    Round {
        /// What it is.
        form: RoundForm,
        /// [`ConvexMesh::with_resolution`]; the default if there is none.
        resolution: Option<u32>,
        /// What rides in it.
        visual: Option<MeshDescription>,
        /// Whether the mass is that of the mesh: [`ConvexMesh::with_mass_of_visual`].
        weighs_visual: bool,
    },
    /// Any other shape.
    Hull {
        /// Points whose hull it is, m.
        points: Vec<Vec3>,
        /// What rides in the hull.
        visual: Option<MeshDescription>,
        /// Whether the mass is that of the mesh: [`ConvexMesh::with_mass_of_visual`].
        weighs_visual: bool,
    },
}

impl Default for ShapeConstructor {
    /// A cube of one meter.
    fn default() -> Self {
        Self::Cuboid { size: Vec3::ONE }
    }
}

impl ShapeConstructor {
    /// The description of a shape.
    pub fn of(shape: &ConvexMesh) -> Self {
        let visual = shape.visual().map(MeshDescription::of);
        let weighs_visual = shape.weighs_visual();
        match RoundForm::of(shape) {
            Some(form) => Self::Round {
                form,
                resolution: shape.resolution(),
                visual,
                weighs_visual,
            },
            None => Self::Hull {
                points: shape.hull().vertices().to_vec(),
                visual,
                weighs_visual,
            },
        }
    }

    /// The shape.
    ///
    /// # Errors
    /// As the function that the variant names, or [`ConvexMesh::from_points`].
    pub fn build(&self) -> Result<ConvexMesh, HullError> {
        match self {
            Self::Cuboid { size } => ConvexMesh::cuboid(size.x, size.y, size.z),
            &Self::Icosphere {
                radius,
                subdivisions,
            } => ConvexMesh::icosphere(radius, subdivisions),
            &Self::RegularPrism {
                sides,
                circumradius,
                height,
            } => ConvexMesh::regular_prism(sides, circumradius, height),
            Self::Wedge { size } => ConvexMesh::wedge(size.x, size.y, size.z),
            Self::Round {
                form,
                resolution,
                visual,
                weighs_visual,
            } => {
                let shape = form.build()?;
                let shape = match resolution {
                    Some(sides) => shape.with_resolution(*sides)?,
                    None => shape,
                };
                let visual = visual.as_ref().map(MeshDescription::build).transpose()?;
                Ok(shape.carrying(visual, *weighs_visual))
            }
            Self::Hull {
                points,
                visual,
                weighs_visual,
            } => {
                let shape = ConvexMesh::from_points(points)?;
                let visual = visual.as_ref().map(MeshDescription::build).transpose()?;
                Ok(shape.carrying(visual, *weighs_visual))
            }
        }
    }
}

/// A component that a shape is made from.
pub(super) trait Constructor: Component + PartialEq + Sized {
    type Shape: Component;
    type Error: Into<BodyProblem> + std::fmt::Display + Send;

    fn build(&self) -> Result<Self::Shape, Self::Error>;

    fn describe(shape: &Self::Shape) -> Self;

    /// Hook: the entity gets the shape unless it has it, whether the plugin is there yet or not.
    fn construct(mut world: DeferredWorld, context: HookContext) {
        let entity = context.entity;
        let Some(constructor) = world.get::<Self>(entity) else {
            return;
        };
        let shape = world.get::<Self::Shape>(entity);
        let is_made = shape.is_some_and(|shape| Self::describe(shape) == *constructor);
        let built = (!is_made).then(|| constructor.build()).transpose();
        world.commands().queue(move |world: &mut World| {
            let found = built.map(|shape| {
                if let (Some(shape), Ok(mut entity)) = (shape, world.get_entity_mut(entity)) {
                    entity.insert(shape);
                }
            });
            note::<Self, _>(world, entity, found);
        });
    }

    /// Hook: nothing is wrong with a description that is not there.
    fn forget(mut world: DeferredWorld, context: HookContext) {
        let entity = context.entity;
        world
            .commands()
            .queue(move |world: &mut World| note::<Self, Self::Error>(world, entity, Ok(())));
    }
}

impl Constructor for ShapeConstructor {
    type Shape = ConvexMesh;
    type Error = HullError;

    fn build(&self) -> Result<ConvexMesh, HullError> {
        self.build()
    }

    fn describe(shape: &ConvexMesh) -> Self {
        Self::of(shape)
    }
}

/// Tells what is wrong with a constructor of this type, or that nothing is any more.
pub(super) fn note<C: Component, E: Into<BodyProblem> + std::fmt::Display>(
    world: &mut World,
    entity: Entity,
    found: Result<(), E>,
) {
    if !world.contains_resource::<PluginState>() {
        if let Err(error) = found {
            log::warn!("no shape for {entity} comes of its constructor: {error}");
        }
        return;
    }
    world.resource_scope(|world, mut state: Mut<PluginState>| {
        let mut warnings = world.resource_mut::<Messages<BodyWarning>>();
        let issues = &mut state.issues;
        let source = Source::Constructor(TypeId::of::<C>());
        issues.note(&mut warnings, entity, source, found);
    });
}
