//! Levels of triangles as data.

use crate::ecs::components::not_cloned;
use crate::ecs::shape_constructor::{Constructor, MeshDescription};
use crate::geometry::{HullError, MeshError, StaticMesh};
use bevy_ecs::prelude::*;

/// What a [`StaticMesh`] is made from. An entity that gets one gets the level; see
/// [`ShapeConstructor`](crate::ecs::ShapeConstructor).
#[derive(Clone, Component, Debug, Default, PartialEq)]
#[component(on_insert = Self::construct, on_remove = Self::forget, clone_behavior = Custom(not_cloned))]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct LevelConstructor {
    /// Its triangles, with their material slots.
    pub mesh: MeshDescription,
    /// Whether they are solid on both sides.
    pub is_two_sided: bool,
}

impl LevelConstructor {
    /// The description of a level, without the triangles that it left out.
    pub fn of(level: &StaticMesh) -> Self {
        Self {
            mesh: MeshDescription::of(&level.to_mesh()),
            is_two_sided: level.is_two_sided(),
        }
    }

    /// The level.
    ///
    /// # Errors
    /// As [`MeshDescription::build`] and [`StaticMesh::from_mesh`].
    pub fn build(&self) -> Result<StaticMesh, MeshError> {
        let level = StaticMesh::from_mesh(&self.mesh.build()?)?;
        Ok(if self.is_two_sided {
            level.two_sided()
        } else {
            level
        })
    }
}

impl Constructor for LevelConstructor {
    type Shape = StaticMesh;
    type Error = HullError;

    fn build(&self) -> Result<StaticMesh, HullError> {
        Ok(self.build()?)
    }

    fn describe(shape: &StaticMesh) -> Self {
        Self::of(shape)
    }
}
