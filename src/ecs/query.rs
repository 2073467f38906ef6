//! `SpatialQuery`: questions about bodies by entity.

use crate::bodies::store::Bodies;
use crate::ecs::state::PluginState;
use crate::math::{Aabb, Pose};
use crate::query::{
    Queries, QueryError, QueryFilter, QueryHit, QueryIndex, QueryShape, Ray, ShapeCast,
};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_math::Vec3;

/// Asks for rays, casts, overlaps and what is near, by entity, in any system.
///
/// Sees bodies as the last step left them: what was spawned or moved since counts from the next step on. The first system that takes
/// it makes the plugin keep an index of where bodies are; an app without one does no work for it.
#[derive(SystemParam)]
pub struct SpatialQuery<'w, 's> {
    // First, so that the index is there when the others look for it.
    _wish: Local<'s, IndexWish>,
    bodies: Res<'w, Bodies>,
    state: Res<'w, PluginState>,
    index: Res<'w, QueryIndex>,
}

impl std::fmt::Debug for SpatialQuery<'_, '_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SpatialQuery")
            .field("index", &*self.index)
            .finish_non_exhaustive()
    }
}

/// Puts the index into the world when a system that asks is made.
#[derive(Debug)]
pub struct IndexWish;

impl FromWorld for IndexWish {
    fn from_world(world: &mut World) -> Self {
        if !world.contains_resource::<QueryIndex>() {
            let mut index = QueryIndex::default();
            if let Some(bodies) = world.get_resource::<Bodies>() {
                index.refresh(bodies);
            }
            world.insert_resource(index);
        }
        Self
    }
}

/// System: looks where the step has left the bodies.
pub(crate) fn refresh_index(mut index: ResMut<QueryIndex>, bodies: Res<Bodies>) {
    index.refresh(&bodies);
}

impl SpatialQuery<'_, '_> {
    /// The view on plain data, whose bodies are slots.
    pub fn queries(&self) -> Queries<'_> {
        self.index.queries(&self.bodies)
    }

    /// The first body that a ray hits; see [`Queries::cast_ray`].
    pub fn cast_ray(&self, ray: &Ray, filter: &QueryFilter<Entity>) -> Option<QueryHit<Entity>> {
        let hit = self.by_slot(filter, |filter| self.queries().cast_ray(ray, filter));
        hit.and_then(|hit| self.by_entity(hit))
    }

    /// All bodies that a ray hits, from near to far; see [`Queries::cast_ray_all`].
    pub fn cast_ray_all(&self, ray: &Ray, filter: &QueryFilter<Entity>) -> Vec<QueryHit<Entity>> {
        let mut hits = Vec::new();
        self.by_slot(filter, |filter| {
            self.queries().cast_ray_all(ray, filter, &mut hits);
        });
        self.all_by_entity(hits)
    }

    /// Whether a ray hits anything; see [`Queries::is_ray_blocked`].
    pub fn is_ray_blocked(&self, ray: &Ray, filter: &QueryFilter<Entity>) -> bool {
        self.by_slot(filter, |filter| self.queries().is_ray_blocked(ray, filter))
    }

    /// The first body that a moved shape touches; see [`Queries::cast_shape`].
    pub fn cast_shape(
        &self,
        cast: &ShapeCast,
        filter: &QueryFilter<Entity>,
    ) -> Option<QueryHit<Entity>> {
        let hit = self.by_slot(filter, |filter| self.queries().cast_shape(cast, filter));
        hit.and_then(|hit| self.by_entity(hit))
    }

    /// All bodies that a moved shape touches, from near to far; see [`Queries::cast_shape_all`].
    pub fn cast_shape_all(
        &self,
        cast: &ShapeCast,
        filter: &QueryFilter<Entity>,
    ) -> Vec<QueryHit<Entity>> {
        let mut hits = Vec::new();
        self.by_slot(filter, |filter| {
            self.queries().cast_shape_all(cast, filter, &mut hits);
        });
        self.all_by_entity(hits)
    }

    /// The bodies that a shape overlaps or touches, in the order in which they were made; see [`Queries::overlap_shape`].
    ///
    /// # Errors
    /// [`QueryError`] if the pose is not usable.
    pub fn overlap_shape(
        &self,
        shape: &QueryShape,
        pose: &Pose,
        filter: &QueryFilter<Entity>,
    ) -> Result<Vec<Entity>, QueryError> {
        let mut found = Vec::new();
        self.by_slot(filter, |filter| {
            self.queries()
                .overlap_shape(shape, pose, filter, &mut found)
        })?;
        Ok(self.entities(&found))
    }

    /// The bodies that overlap or touch a box along the axes of the world; see [`Queries::overlap_box`].
    ///
    /// # Errors
    /// [`QueryError`] if the box is not usable.
    pub fn overlap_box(
        &self,
        b: &Aabb,
        filter: &QueryFilter<Entity>,
    ) -> Result<Vec<Entity>, QueryError> {
        let mut found = Vec::new();
        self.by_slot(filter, |filter| {
            self.queries().overlap_box(b, filter, &mut found)
        })?;
        Ok(self.entities(&found))
    }

    /// The place on a body's surface that is nearest to a point; see [`Queries::closest_point`].
    ///
    /// # Errors
    /// [`QueryError`] if point or distance are not usable.
    pub fn closest_point(
        &self,
        point: Vec3,
        max_distance: f32,
        filter: &QueryFilter<Entity>,
    ) -> Result<Option<QueryHit<Entity>>, QueryError> {
        let hit = self.by_slot(filter, |filter| {
            self.queries().closest_point(point, max_distance, filter)
        })?;
        Ok(hit.and_then(|hit| self.by_entity(hit)))
    }

    /// The bodies that come within `radius` (m) of a point, from near to far; see [`Queries::within_radius`].
    ///
    /// # Errors
    /// [`QueryError`] if point or radius are not usable.
    pub fn within_radius(
        &self,
        point: Vec3,
        radius: f32,
        filter: &QueryFilter<Entity>,
    ) -> Result<Vec<QueryHit<Entity>>, QueryError> {
        let mut hits = Vec::new();
        self.by_slot(filter, |filter| {
            self.queries()
                .within_radius(point, radius, filter, &mut hits)
        })?;
        Ok(self.all_by_entity(hits))
    }

    pub(super) fn entity(&self, slot: u32) -> Option<Entity> {
        self.state.entities.of(slot, self.bodies.id(slot))
    }

    fn entities(&self, slots: &[u32]) -> Vec<Entity> {
        slots.iter().filter_map(|&slot| self.entity(slot)).collect()
    }

    fn by_entity(&self, hit: QueryHit) -> Option<QueryHit<Entity>> {
        Some(hit.of(self.entity(hit.body)?))
    }

    fn all_by_entity(&self, hits: Vec<QueryHit>) -> Vec<QueryHit<Entity>> {
        hits.into_iter()
            .filter_map(|hit| self.by_entity(hit))
            .collect()
    }

    /// Asks with a filter that speaks of slots. Bodies without an entity do not count.
    fn by_slot<T>(&self, filter: &QueryFilter<Entity>, ask: impl FnOnce(&QueryFilter) -> T) -> T {
        let counts = |slot: u32| {
            self.entity(slot).is_some_and(|entity| {
                !filter.excluded.contains(&entity)
                    && filter.predicate.is_none_or(|predicate| predicate(entity))
            })
        };
        ask(&QueryFilter {
            layers: filter.layers,
            excluded: &[],
            predicate: Some(&counts),
        })
    }
}
