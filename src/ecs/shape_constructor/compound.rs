//! Compounds as data.

use crate::ecs::components::not_cloned;
use crate::ecs::shape_constructor::{Constructor, MeshDescription, ShapeConstructor};
use crate::geometry::{Compound, CompoundError, CompoundPart, PartBond};
use crate::math::Pose;
use bevy_ecs::prelude::*;

/// What a [`Compound`] is made from. An entity that gets one gets the compound; see [`ShapeConstructor`].
#[derive(Clone, Component, Debug, Default, PartialEq)]
#[component(on_insert = Self::construct, on_remove = Self::forget, clone_behavior = Custom(not_cloned))]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct CompoundConstructor {
    /// In order.
    pub parts: Vec<PartDescription>,
    /// What holds the parts together, if it may break.
    pub bonds: Option<Vec<PartBond>>,
    /// What is drawn in place of the parts.
    pub visual: Option<MeshDescription>,
}

/// A [`CompoundPart`] as data.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct PartDescription {
    /// Where the frame of its shape is in that of the compound.
    pub pose: Pose,
    /// Its shape.
    pub shape: ShapeConstructor,
}

impl Default for PartDescription {
    /// A cube of one meter around the origin.
    fn default() -> Self {
        Self {
            pose: Pose::IDENTITY,
            shape: ShapeConstructor::default(),
        }
    }
}

impl CompoundConstructor {
    /// The description of a compound.
    pub fn of(compound: &Compound) -> Self {
        let parts = compound.parts().iter().map(|part| PartDescription {
            pose: part.pose,
            shape: ShapeConstructor::of(&part.shape),
        });
        Self {
            parts: parts.collect(),
            bonds: compound.is_bonded().then(|| compound.bonds().to_vec()),
            visual: compound.visual().map(MeshDescription::of),
        }
    }

    /// The compound. Bonds may hold several groups of parts together, as of a body that was saved while it broke: they come apart at once.
    ///
    /// # Errors
    /// [`CompoundError`] if a part has no shape, or as [`Compound::new`] and [`Compound::with_bonds`].
    pub fn build(&self) -> Result<Compound, CompoundError> {
        let part = |(part, described): (usize, &PartDescription)| {
            let shape = described.shape.build();
            let shape = shape.map_err(|error| CompoundError::Part { part, error })?;
            Ok(CompoundPart::new(described.pose, shape))
        };
        let parts = self.parts.iter().enumerate().map(part);
        let mut compound = Compound::new(parts.collect::<Result<Vec<_>, CompoundError>>()?)?;
        if let Some(visual) = &self.visual {
            compound = compound.with_visual(visual.build()?);
        }
        match &self.bonds {
            Some(bonds) => compound.with_bonds_of_groups(bonds.clone()),
            None => Ok(compound),
        }
    }
}

impl Constructor for CompoundConstructor {
    type Shape = Compound;
    type Error = CompoundError;

    fn build(&self) -> Result<Compound, CompoundError> {
        self.build()
    }

    fn describe(shape: &Compound) -> Self {
        Self::of(shape)
    }
}
