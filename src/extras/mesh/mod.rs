//! Meshes of Bevy: read as shapes, written from shapes, and kept in step with them. No renderer is needed.
//!
//! | file | holds |
//! |---|---|
//! | `convert.rs` | `TriMesh` from and to `Mesh` |
//! | `construct.rs` | shapes for entities whose `Mesh3d` is yet to be loaded, one by one or for a whole scene |
//! | `draw.rs` | `Mesh3d` in step with the shape, one for each material slot |

mod construct;
mod convert;
mod draw;

pub use construct::{ShapeFromMesh, ShapeFromMeshError, ShapeRefused, ShapesOfScene};
pub use convert::{MeshConversionError, unread_attributes};
pub use draw::{DrawShape, SlotMesh};

use bevy_app::{App, Plugin, PostUpdate, PreUpdate};
use bevy_asset::Assets;
use bevy_ecs::prelude::*;
use bevy_mesh::Mesh;
use bevy_transform::TransformSystems;

/// Shapes from meshes ([`ShapeFromMesh`], [`ShapesOfScene`]) and meshes from shapes ([`DrawShape`]).
///
/// Needs Bevy's `AssetPlugin` and `MeshPlugin` (part of `DefaultPlugins`).
#[derive(Clone, Copy, Debug, Default)]
pub struct CleaveMeshPlugin;

impl Plugin for CleaveMeshPlugin {
    fn build(&self, app: &mut App) {
        let construct = (construct::ask_for_shapes, construct::construct_shapes).chain();
        app.add_systems(PreUpdate, construct.run_if(resource_exists::<Assets<Mesh>>))
            .add_systems(
                PostUpdate,
                (draw::drop_strays, draw::draw_shapes)
                    .chain()
                    .run_if(resource_exists::<Assets<Mesh>>)
                    .before(TransformSystems::Propagate),
            )
            .add_observer(draw::on_disabled)
            .add_observer(draw::on_enabled);
        #[cfg(feature = "reflect")]
        app.register_type::<ShapeFromMesh>()
            .register_type::<ShapesOfScene>();
    }

    fn finish(&self, app: &mut App) {
        if !app.world().contains_resource::<Assets<Mesh>>() {
            log::warn!(
                "CleaveMeshPlugin does nothing: the app has no meshes; add AssetPlugin and MeshPlugin (part of DefaultPlugins)"
            );
        }
    }
}
