//! `Mesh3d` in step with the shape: whenever a body gets a shape, be it new, cut or broken, it gets the meshes of it.

use crate::geometry::{Compound, ConvexMesh, StaticMesh};
use bevy_asset::Assets;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::query::Allow;
use bevy_ecs::system::SystemParam;
use bevy_mesh::{Mesh, Mesh3d};
use std::borrow::Cow;
use std::sync::Arc;

/// Keeps the entity's `Mesh3d` in step with its [`ConvexMesh`], and that of its pieces: the mesh that rides in the hull, or else
/// the hull's own. Of a [`Compound`] its visual mesh or its parts are drawn, of a [`StaticMesh`] its triangles.
///
/// Materials are yours: that of the entity, which its pieces get too, and those of material slots, whose triangles are drawn by children
/// with [`SlotMesh`]. Cut faces have the slot that [`Fracturable::cut_material`] says.
///
/// ```
/// use bevy_cleave::prelude::*;
/// # #[derive(bevy_ecs::component::Component, Clone)]
/// # struct MeshMaterial3d(u32);
/// # fn porcelain() -> MeshMaterial3d { MeshMaterial3d(0) }
/// # fn clay() -> MeshMaterial3d { MeshMaterial3d(1) }
/// const CUT: u16 = 1;
/// let cup = (
///     ConvexMesh::cuboid(0.2, 0.2, 0.2)?,
///     Fracturable { cut_material: Some(CUT), ..Fracturable::with_strength(20.0) },
///     porcelain(),
///     DrawShape::new().with_slot(CUT, clay()),
/// );
/// # Ok::<(), HullError>(())
/// ```
///
/// [`Fracturable::cut_material`]: crate::slice::Fracturable::cut_material
#[derive(Clone, Component, Default)]
pub struct DrawShape {
    looks: Vec<SlotLook>,
}

/// What the child of a slot gets besides its mesh.
#[derive(Clone)]
struct SlotLook {
    slot: u16,
    dress: Arc<dyn Fn(&mut EntityCommands) + Send + Sync>,
}

/// A child that draws the triangles of one material slot of its parent's shape. Made and despawned by [`DrawShape`], and disabled
/// while its parent is.
#[derive(Clone, Copy, Component, Debug, PartialEq, Eq)]
pub struct SlotMesh(pub u16);

impl std::fmt::Debug for DrawShape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let slots = self.looks.iter().map(|look| look.slot);
        f.debug_list().entries(slots).finish()
    }
}

impl DrawShape {
    /// All of the shape with the entity's own material.
    pub fn new() -> Self {
        Self::default()
    }

    /// The triangles of `slot` with `look` instead, such as a `MeshMaterial3d` of any material.
    pub fn with_slot(mut self, slot: u16, look: impl Bundle + Clone) -> Self {
        self.looks.retain(|other| other.slot != slot);
        self.looks.push(SlotLook {
            slot,
            dress: Arc::new(move |child| {
                child.insert(look.clone());
            }),
        });
        self
    }
}

type Drawn = (
    Entity,
    AnyOf<(&'static ConvexMesh, &'static Compound, &'static StaticMesh)>,
    &'static DrawShape,
    Option<&'static Mesh3d>,
    Option<&'static Children>,
    Has<Disabled>,
);

/// Whose meshes are out of date.
type IsNew = Or<(
    Changed<ConvexMesh>,
    Changed<Compound>,
    Changed<StaticMesh>,
    Changed<DrawShape>,
)>;

/// System: meshes of shapes that are new, of disabled entities too: nobody would tell when they come back.
pub(super) fn draw_shapes(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    changed: Query<Drawn, (IsNew, Allow<Disabled>)>,
    slots: Query<(), (With<SlotMesh>, Allow<Disabled>)>,
) {
    for (entity, shape, draw, before, children, is_disabled) in &changed {
        let stale = children.into_iter().flatten().copied();
        for child in stale.filter(|&child| slots.contains(child)) {
            commands.entity(child).despawn();
        }
        let has_tangents = before
            .and_then(|mesh| meshes.get(&mesh.0))
            .is_some_and(|mesh| {
                mesh.try_contains_attribute(Mesh::ATTRIBUTE_TANGENT)
                    .unwrap_or(false)
            });
        let finish = |mut mesh: Mesh| {
            if has_tangents && let Err(error) = mesh.generate_tangents() {
                log::debug!("{entity} is drawn without tangents: {error}");
            }
            mesh
        };
        let drawn = match shape {
            (Some(shape), ..) => shape.render_mesh(),
            (None, Some(compound), _) => compound.render_mesh(),
            (None, None, Some(level)) => Cow::Owned(level.to_mesh()),
            (None, None, None) => continue,
        };
        let own = drawn.triangles_of(|slot| !draw.looks.iter().any(|look| look.slot == slot));
        if own.is_empty() {
            // All of a piece from within is of other slots.
            commands.entity(entity).remove::<Mesh3d>();
        } else {
            let own = meshes.add(finish(drawn.to_bevy(&own)));
            commands.entity(entity).insert(Mesh3d(own));
        }
        for look in &draw.looks {
            let Some(mesh) = drawn.mesh_of_slot(look.slot) else {
                continue;
            };
            let mesh = Mesh3d(meshes.add(finish(mesh)));
            let mut child = commands.spawn((SlotMesh(look.slot), ChildOf(entity), mesh));
            (look.dress)(&mut child);
            if is_disabled {
                child.insert(Disabled);
            }
        }
    }
}

/// Of those that draw slots.
type Slots = (With<SlotMesh>, Allow<Disabled>);

/// System: a piece that is not drawn does not keep what drew the cut faces of its parent.
pub(super) fn drop_strays(
    mut commands: Commands,
    moved: Query<(Entity, &ChildOf), (Changed<ChildOf>, Slots)>,
    drawn: Query<(), (With<DrawShape>, Allow<Disabled>)>,
) {
    for (slot, child_of) in &moved {
        if !drawn.contains(child_of.parent()) {
            commands.entity(slot).try_despawn();
        }
    }
}

/// What draws the slots of entities.
#[derive(SystemParam)]
pub(super) struct Drawers<'w, 's> {
    children: Query<'w, 's, &'static Children, (With<DrawShape>, Allow<Disabled>)>,
    slots: Query<'w, 's, (), Slots>,
}

impl Drawers<'_, '_> {
    fn of(&self, entity: Entity) -> impl Iterator<Item = Entity> {
        let children = self.children.get(entity).into_iter().flatten().copied();
        children.filter(|&child| self.slots.contains(child))
    }
}

/// Observer: what draws the slots of an entity is not seen while that is disabled.
pub(super) fn on_disabled(insert: On<Insert<Disabled>>, drawers: Drawers, mut commands: Commands) {
    for child in drawers.of(insert.entity) {
        commands.entity(child).try_insert(Disabled);
    }
}

/// Observer: it is seen again.
pub(super) fn on_enabled(remove: On<Remove<Disabled>>, drawers: Drawers, mut commands: Commands) {
    for child in drawers.of(remove.entity) {
        commands.entity(child).try_remove::<Disabled>();
    }
}
