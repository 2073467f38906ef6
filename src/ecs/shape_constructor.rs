//! Shapes as data that a scene file can hold: `ConvexMesh` itself is shared and keeps what was computed for it.

use crate::ecs::components::BodyWarning;
use crate::ecs::issues::Source;
use crate::ecs::state::PluginState;
use crate::geometry::{ConvexHull, ConvexMesh, HullError, MeshError, TriMesh};
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use bevy_math::{Vec2, Vec3, Vec4};

/// What a [`ConvexMesh`] is made from. An entity that gets one gets the shape.
///
/// For scene files and inspectors: with the cargo feature `reflect` it is registered for both. It stays on the entity, so that what
/// was loaded can be saved again; other shapes are described by [`of`](Self::of). Pieces get none.
///
/// No shape comes of unusable numbers: then the entity gets [`BodyIssues`](crate::ecs::BodyIssues).
#[derive(Clone, Component, Debug, PartialEq)]
#[component(on_insert = construct, on_remove = forget, clone_behavior = Ignore)]
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

/// A [`TriMesh`] as data. Attributes have one entry per vertex or none, slots one per triangle or none.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct MeshDescription {
    /// m.
    pub positions: Vec<Vec3>,
    /// Unit vectors.
    pub normals: Vec<Vec3>,
    /// Linear RGBA.
    pub colors: Vec<Vec4>,
    /// Texture coordinates.
    pub uvs: Vec<Vec2>,
    /// Vertex numbers, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Material slots.
    pub materials: Vec<u16>,
    /// How many triangles, the first ones, are sheets.
    pub sheets: u32,
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
        Self::Hull {
            points: shape.hull().vertices().to_vec(),
            visual: shape.visual().map(MeshDescription::of),
            weighs_visual: shape.weighs_visual(),
        }
    }

    /// The shape.
    ///
    /// # Errors
    /// As the function that the variant names, or [`ConvexHull::from_points`].
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
            Self::Hull {
                points,
                visual,
                weighs_visual,
            } => {
                let visual = visual.as_ref().map(MeshDescription::build).transpose()?;
                let shape = ConvexMesh::from_parts(ConvexHull::from_points(points)?, visual);
                Ok(if *weighs_visual {
                    shape.with_mass_of_visual()
                } else {
                    shape
                })
            }
        }
    }
}

impl MeshDescription {
    /// The description of a mesh.
    pub fn of(mesh: &TriMesh) -> Self {
        Self {
            positions: mesh.positions().to_vec(),
            normals: mesh.normals().to_vec(),
            colors: mesh.colors().to_vec(),
            uvs: mesh.uvs().to_vec(),
            triangles: mesh.triangles().to_vec(),
            materials: mesh.materials().to_vec(),
            sheets: mesh.sheets() as u32,
        }
    }

    /// The mesh.
    ///
    /// # Errors
    /// As [`TriMesh::new`] and the functions that set attributes.
    pub fn build(&self) -> Result<TriMesh, MeshError> {
        let mut mesh = TriMesh::new(self.positions.clone(), self.triangles.clone())?;
        if !self.normals.is_empty() {
            mesh = mesh.with_normals(self.normals.clone())?;
        }
        if !self.colors.is_empty() {
            mesh = mesh.with_colors(self.colors.clone())?;
        }
        if !self.uvs.is_empty() {
            mesh = mesh.with_uvs(self.uvs.clone())?;
        }
        if !self.materials.is_empty() {
            mesh = mesh.with_materials(self.materials.clone())?;
        }
        mesh.with_sheets(self.sheets as usize)
    }
}

/// Hook: the entity gets the shape, whether the plugin is there yet or not.
fn construct(mut world: DeferredWorld, context: HookContext) {
    let entity = context.entity;
    let built = (world.get::<ShapeConstructor>(entity)).map(ShapeConstructor::build);
    let Some(built) = built else {
        return;
    };
    world.commands().queue(move |world: &mut World| {
        let found = built.map(|shape| {
            if let Ok(mut entity) = world.get_entity_mut(entity) {
                entity.insert(shape);
            }
        });
        note(world, entity, found);
    });
}

/// Hook: nothing is wrong with a description that is not there.
fn forget(mut world: DeferredWorld, context: HookContext) {
    let entity = context.entity;
    world
        .commands()
        .queue(move |world: &mut World| note(world, entity, Ok(())));
}

/// Tells what is wrong with it, or that nothing is any more.
fn note(world: &mut World, entity: Entity, found: Result<(), HullError>) {
    if !world.contains_resource::<PluginState>() {
        if let Err(error) = found {
            log::warn!("no shape for {entity} comes of its ShapeConstructor: {error}");
        }
        return;
    }
    world.resource_scope(|world, mut state: Mut<PluginState>| {
        let mut warnings = world.resource_mut::<Messages<BodyWarning>>();
        let issues = &mut state.issues;
        issues.note(&mut warnings, entity, Source::Constructor, found);
    });
}
