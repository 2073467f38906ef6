//! What a level is made of, material slot by material slot.

use crate::contact::material::{Friction, MaterialError, Restitution};
use bevy_ecs::component::Component;

/// Friction and restitution of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct SurfaceMaterial {
    /// Friction.
    pub friction: Friction,
    /// Restitution.
    pub restitution: Restitution,
}

/// What the triangles of a level are made of, by material slot: ice here, gravel there.
///
/// Beside a [`StaticMesh`](crate::geometry::StaticMesh) whose triangles have [slots](crate::geometry::StaticMesh::with_materials). Of
/// triangles in other slots the body's own [`Friction`] and [`Restitution`] count, and so they do of all other shapes.
#[derive(Clone, Debug, Default, PartialEq, Component)]
#[component(summary_tick)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct SurfaceMaterials {
    /// By slot, ascending.
    list: Vec<(u16, SurfaceMaterial)>,
}

impl SurfaceMaterials {
    /// None.
    pub fn new() -> Self {
        Self::default()
    }

    /// And this one in a slot, in place of the one that it may have had.
    pub fn with(mut self, slot: u16, friction: Friction, restitution: Restitution) -> Self {
        let material = SurfaceMaterial {
            friction,
            restitution,
        };
        match self.list.binary_search_by_key(&slot, |&(slot, _)| slot) {
            Ok(at) => self.list[at].1 = material,
            Err(at) => self.list.insert(at, (slot, material)),
        }
        self
    }

    /// The material of a slot, if it has one.
    pub fn get(&self, slot: u16) -> Option<&SurfaceMaterial> {
        let at = self.list.binary_search_by_key(&slot, |&(slot, _)| slot);
        at.ok().map(|at| &self.list[at].1)
    }

    /// Slots and their materials, ascending.
    pub fn iter(&self) -> impl Iterator<Item = (u16, &SurfaceMaterial)> {
        self.list.iter().map(|(slot, material)| (*slot, material))
    }

    /// Whether all values can be used.
    ///
    /// # Errors
    /// [`MaterialError`] of the first that cannot.
    pub fn validate(&self) -> Result<(), MaterialError> {
        self.iter().try_for_each(|(_, material)| {
            material.friction.validate()?;
            material.restitution.validate()
        })
    }
}
