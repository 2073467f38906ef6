//! Shapes for entities whose `Mesh3d` is yet to be loaded.

use super::convert::{MeshConversionError, unread_attributes};
use super::draw::SlotMesh;
use crate::bodies::body::RigidBody;
use crate::ecs::components::not_cloned;
use crate::ecs::{CompoundOfChildren, ShapeAwaited};
use crate::geometry::{
    Compound, ConvexMesh, HalfSpaceShape, HullError, MeshError, StaticMesh, TriMesh,
};
use crate::import::{Import, ImportError, ImportOptions, Model, ModelObject};
use crate::slice::{DecompositionError, DecompositionOptions};
use bevy_asset::{AssetServer, Assets, LoadState};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::query::Allow;
use bevy_math::Vec3;
use bevy_mesh::{Mesh, Mesh3d};
#[cfg(feature = "reflect")]
use bevy_reflect::std_traits::ReflectDefault;

/// Makes the shape of a body from the entity's `Mesh3d`, as soon as that is loaded; goes when it is done.
///
/// While the mesh loads it is no issue that there is no shape ([`ShapeAwaited`]). What cannot be made leaves a [`ShapeRefused`] on the
/// entity, and a warning in the log; a mesh that could not be loaded, or is missing, may still come.
#[derive(Clone, Copy, Component, Debug, Default, PartialEq)]
#[require(ShapeAwaited)]
#[component(on_remove = ShapeAwaited::end, clone_behavior = Custom(not_cloned))]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "reflect", reflect(Component, Default))]
pub enum ShapeFromMesh {
    /// The convex hull. Pieces look like it.
    #[default]
    Hull,
    /// The convex hull, with the mesh riding in it: pieces look like parts of the mesh. What is not closed is mended as
    /// [`Model::import`] does, by default options; its report goes to the log.
    HullWithVisual,
    /// The convex parts of a mesh that is not convex, which rides in them; mended as above. To find them takes a fraction of a second
    /// for a mesh of a thousand triangles, seconds for many more: see [`decompose`](crate::slice::decompose).
    Compound(DecompositionOptions),
    /// A level of triangles, for bodies that are not dynamic.
    Static {
        /// Whether what comes from behind a triangle collides with it too.
        is_two_sided: bool,
    },
}

/// No shape came of a [`ShapeFromMesh`].
#[derive(Clone, Component, Debug, PartialEq)]
#[component(clone_behavior = Ignore)]
pub struct ShapeRefused(pub ShapeFromMeshError);

/// Why no shape came of a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShapeFromMeshError {
    /// The entity has no `Mesh3d`.
    #[error("the entity has no Mesh3d")]
    NoMesh,
    /// The mesh could not be loaded.
    #[error("its mesh was not loaded: {0}")]
    NotLoaded(String),
    /// The mesh cannot be read.
    #[error(transparent)]
    Conversion(#[from] MeshConversionError),
    /// It cannot be mended.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// It has no hull.
    #[error(transparent)]
    Hull(#[from] HullError),
    /// It is no level.
    #[error(transparent)]
    Level(#[from] MeshError),
    /// It has no convex parts.
    #[error(transparent)]
    Decomposition(#[from] DecompositionError),
}

/// Makes bodies of all entities with `Mesh3d` below this one, as they come: put it on the root of a scene that is being loaded.
///
/// Entities that have a [`RigidBody`], a shape or a [`ShapeFromMesh`] of their own are left as they are. On or below an entity with
/// [`CompoundOfChildren`] they become parts of its body instead: with `Hull` or `HullWithVisual` a whole scene is one.
#[derive(Clone, Copy, Component, Debug, Default, PartialEq)]
#[require(ShapeAwaited)]
#[component(on_remove = ShapeAwaited::end)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "reflect", reflect(Component, Default))]
pub struct ShapesOfScene {
    /// What kind of bodies they become.
    pub body: RigidBody,
    /// How their shapes are made.
    pub shape: ShapeFromMesh,
}

/// Entities whose shape is for others to see to.
type Alone = (
    With<Mesh3d>,
    Without<SlotMesh>,
    Without<RigidBody>,
    (
        Without<ConvexMesh>,
        Without<Compound>,
        Without<StaticMesh>,
        Without<HalfSpaceShape>,
    ),
    Without<ShapeFromMesh>,
    Allow<Disabled>,
);

/// What may be below a [`ShapesOfScene`] now and was not before.
type IsNew = Or<(Added<ShapesOfScene>, Added<Mesh3d>, Changed<ChildOf>)>;

/// What is looked at on the way up from a mesh.
type Above = (
    Option<&'static ShapesOfScene>,
    Has<CompoundOfChildren>,
    Has<RigidBody>,
);

/// Who is above and below whom, disabled or not.
type Relatives<'w, 's> = (
    Query<'w, 's, &'static ChildOf, Allow<Disabled>>,
    Query<'w, 's, &'static Children, Allow<Disabled>>,
);

/// System: entities that come below a [`ShapesOfScene`], or were there when it came, ask for their shapes. Whoever is disabled asks too.
pub(super) fn ask_for_shapes(
    mut commands: Commands,
    scenes: Query<(), (With<ShapesOfScene>, Allow<Disabled>)>,
    new: Query<Entity, (IsNew, Allow<Disabled>)>,
    meshes: Query<(), Alone>,
    above: Query<Above, Allow<Disabled>>,
    (up, down): Relatives,
) {
    if scenes.is_empty() {
        return;
    }
    let with_below = |at| std::iter::once(at).chain(down.iter_descendants(at));
    let asking = new.iter().flat_map(with_below);
    let mut asking: Vec<Entity> = asking.filter(|&at| meshes.contains(at)).collect();
    // Who came with its parent is found from both.
    asking.sort_unstable();
    asking.dedup();
    for entity in asking {
        let ancestors = || up.iter_ancestors(entity);
        let scene_of = |at| {
            above
                .get(at)
                .ok()
                .and_then(|(scene, ..)| scene.zip(Some(at)))
        };
        let Some((scene, root)) = ancestors().find_map(scene_of) else {
            continue;
        };
        // Another body between a compound and its part has parts of its own.
        let owner_of = |at| {
            let (_, is_compound, is_body) = above.get(at).ok()?;
            (is_compound || is_body).then_some(is_compound)
        };
        if ancestors().find_map(owner_of) == Some(true) {
            commands.entity(entity).insert(scene.shape);
        } else {
            commands.entity(entity).insert((scene.body, scene.shape));
        }
        // That of a compound goes when it is made.
        if above
            .get(root)
            .is_ok_and(|(_, is_compound, _)| !is_compound)
        {
            commands.entity(root).remove::<ShapeAwaited>();
        }
    }
}

/// What waits for its shape.
type Waiting = (
    Entity,
    &'static ShapeFromMesh,
    Option<&'static Mesh3d>,
    Option<&'static ShapeRefused>,
    Has<ShapeAwaited>,
);

/// System: shapes of those whose meshes are loaded.
pub(super) fn construct_shapes(
    mut commands: Commands,
    meshes: Res<Assets<Mesh>>,
    server: Option<Res<AssetServer>>,
    waiting: Query<Waiting, Allow<Disabled>>,
) {
    for (entity, wish, handle, refused, is_awaited) in &waiting {
        let mesh = handle.map(|handle| (handle, meshes.get(&handle.0)));
        let mut entity = commands.entity(entity);
        let wanting = match mesh {
            Some((_, Some(mesh))) => {
                wish.finish(mesh, &mut entity);
                continue;
            }
            Some((handle, None)) => failure(server.as_deref(), handle),
            None => Some(ShapeFromMeshError::NoMesh),
        };
        if refused.map(|refused| &refused.0) == wanting.as_ref() && is_awaited == wanting.is_none()
        {
            continue;
        }
        match wanting {
            Some(error) => {
                log::warn!("no shape for {} comes of its mesh: {error}", entity.id());
                entity.remove::<ShapeAwaited>().insert(ShapeRefused(error));
            }
            None => {
                entity.remove::<ShapeRefused>().insert(ShapeAwaited);
            }
        }
    }
}

/// Why a mesh does not come, if that is known.
fn failure(server: Option<&AssetServer>, handle: &Mesh3d) -> Option<ShapeFromMeshError> {
    match server?.get_load_state(&handle.0)? {
        LoadState::Failed(error) => Some(ShapeFromMeshError::NotLoaded(error.to_string())),
        LoadState::NotLoaded | LoadState::Loading | LoadState::Loaded => None,
    }
}

impl ShapeFromMesh {
    /// Gives the entity what comes of its mesh, a shape or the reason why there is none.
    fn finish(self, mesh: &Mesh, entity: &mut EntityCommands) {
        let unread = unread_attributes(mesh);
        let is_riding = matches!(self, Self::HullWithVisual | Self::Compound(_));
        if is_riding && !unread.is_empty() {
            let entity = entity.id();
            log::info!("pieces of {entity} will not have the attributes {unread:?} of its mesh");
        }
        entity.remove::<(Self, ShapeRefused)>();
        if let Err(error) = self.construct(mesh, entity) {
            log::warn!("no shape for {} comes of its mesh: {error}", entity.id());
            entity.insert(ShapeRefused(error));
        }
    }

    fn construct(self, mesh: &Mesh, entity: &mut EntityCommands) -> Result<(), ShapeFromMeshError> {
        match self {
            Self::Hull => {
                let object = ModelObject::try_from(mesh)?;
                let corners = object.triangles.as_flattened().iter();
                let used = corners.filter_map(|&v| object.positions.get(v as usize));
                let points: Vec<Vec3> = used.copied().collect();
                entity.insert(ConvexMesh::from_points(&points)?);
            }
            Self::HullWithVisual => {
                entity.insert(mended(mesh, entity.id())?.shape()?);
            }
            Self::Compound(options) => {
                let mesh = mended(mesh, entity.id())?.mesh;
                entity.insert(Compound::from_mesh(mesh, options)?);
            }
            Self::Static { is_two_sided } => {
                let level = StaticMesh::from_mesh(&TriMesh::try_from(mesh)?)?;
                entity.insert(if is_two_sided {
                    level.two_sided()
                } else {
                    level
                });
            }
        }
        Ok(())
    }
}

/// The mesh, closed.
fn mended(mesh: &Mesh, entity: Entity) -> Result<Import, ShapeFromMeshError> {
    let model = Model::from_object(ModelObject::try_from(mesh)?);
    let import = model.import(&ImportOptions::default())?;
    if !import.report.is_untouched() {
        log::info!("the mesh of {entity} was mended:\n{}", import.report);
    }
    Ok(import)
}
