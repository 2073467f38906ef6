//! Bodies under the pointer, for Bevy's picking: `Pointer<Click>`, `Pointer<Drag>` and their kin on entities with a body.

use crate::ecs::query::SpatialQuery;
use crate::query::{QueryFilter, Ray};
use bevy_app::{App, Plugin, PreUpdate};
use bevy_camera::Camera;
use bevy_ecs::prelude::*;
use bevy_picking::backend::ray::RayMap;
use bevy_picking::backend::{HitData, PointerHits};
use bevy_picking::{Pickable, PickingSystems};

/// Bodies take part in Bevy's picking: a ray of each pointer hits the shapes that collide, levels and half-spaces among them, so
/// that what is behind the ground is not picked.
///
/// Needs Bevy's `PickingPlugin` and `InputPlugin` (part of `DefaultPlugins` with picking). Sees bodies where the last step left them. `Pickable` works as elsewhere.
#[derive(Clone, Copy, Debug, Default)]
pub struct CleavePickingPlugin;

impl Plugin for CleavePickingPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            PreUpdate,
            pick.in_set(PickingSystems::Backend)
                .run_if(resource_exists::<RayMap>),
        );
    }
}

fn pick(
    rays: Res<RayMap>,
    space: SpatialQuery,
    cameras: Query<&Camera>,
    pickables: Query<&Pickable>,
    mut hits: MessageWriter<PointerHits>,
) {
    // Without the component a body is hoverable and hides what is behind it.
    let is_hoverable = |body: Entity| pickables.get(body).map_or(true, |p| p.is_hoverable);
    let filter = QueryFilter::all().with_predicate(&is_hoverable);
    for (id, ray) in rays.iter() {
        let Ok(camera) = cameras.get(id.camera) else {
            continue;
        };
        let Ok(ray) = Ray::new(ray.origin, *ray.direction, f32::INFINITY) else {
            continue;
        };
        let mut picks = Vec::new();
        for hit in space.cast_ray_all(&ray, &filter) {
            let data = HitData::new(id.camera, hit.distance, Some(hit.point), Some(hit.normal));
            picks.push((hit.body, data));
            if pickables
                .get(hit.body)
                .map_or(true, |p| p.should_block_lower)
            {
                break;
            }
        }
        if !picks.is_empty() {
            hits.write(PointerHits::new(id.pointer, picks, camera.order as f32));
        }
    }
}
