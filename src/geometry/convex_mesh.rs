//! The shapes a body can have: `ConvexMesh`, shared and immutable, and the static `HalfSpaceShape`.

use crate::geometry::predicates::{FLAT_RELATIVE, PlaneError, check_plane};
use crate::geometry::{ConvexHull, HullError, MeshError, TriMesh, primitives};
use crate::math::{Aabb, Plane};
use bevy_ecs::component::Component;
use glam::Vec3;
use std::borrow::Cow;
use std::sync::Arc;

/// The shape of a body: a convex hull, and optionally a closed mesh that rides inside it and is what is drawn.
///
/// Shared and immutable, so cloning costs one reference count. Coordinates are metres in the entity's frame.
#[derive(Clone, Debug, Component)]
#[component(summary_tick)]
pub struct ConvexMesh(Arc<MeshParts>);

#[derive(Debug)]
struct MeshParts {
    hull: ConvexHull,
    visual: Option<TriMesh>,
    weighs_visual: bool,
}

impl ConvexMesh {
    /// A shape from a hull and the mesh that rides in it.
    ///
    /// That the mesh is closed and lies inside the hull is for the caller to see to; [`from_mesh`](Self::from_mesh) does.
    pub fn from_parts(hull: ConvexHull, visual: Option<TriMesh>) -> Self {
        Self::assemble(hull, visual, false)
    }

    fn assemble(hull: ConvexHull, visual: Option<TriMesh>, weighs_visual: bool) -> Self {
        Self(Arc::new(MeshParts {
            hull,
            visual,
            weighs_visual,
        }))
    }

    /// The shape with the mass, center and inertia of the mesh that rides in it instead of those of its hull, and so with its
    /// pieces: a cup weighs its wall and not the air in it. A mesh that encloses nothing leaves it at the hull.
    pub fn with_mass_of_visual(self) -> Self {
        match Arc::try_unwrap(self.0) {
            Ok(parts) => Self::assemble(parts.hull, parts.visual, true),
            Err(shared) => Self::assemble(shared.hull.clone(), shared.visual.clone(), true),
        }
    }

    /// The mesh that gives the body its mass, if that is asked for and the mesh encloses something.
    pub fn weighed_visual(&self) -> Option<&TriMesh> {
        Self::weighed_part(self.hull(), self.visual(), self.0.weighs_visual)
    }

    /// The same of a shape that is yet to be made.
    pub(crate) fn weighed_part<'a>(
        hull: &ConvexHull,
        visual: Option<&'a TriMesh>,
        weighs_visual: bool,
    ) -> Option<&'a TriMesh> {
        let visual = visual.filter(|_| weighs_visual)?;
        // Below what a hull must have to be one.
        let is_solid = visual.volume() > f64::from(FLAT_RELATIVE) * hull.volume();
        is_solid.then_some(visual)
    }

    /// Whether the mass is that of the mesh that rides inside, as far as there is one.
    pub(crate) fn weighs_visual(&self) -> bool {
        self.0.weighs_visual
    }

    /// The shape of a hull, which is also what is drawn.
    pub fn from_hull(hull: ConvexHull) -> Self {
        Self::from_parts(hull, None)
    }

    /// The convex hull of points (m).
    ///
    /// # Errors
    /// As [`ConvexHull::from_points`].
    pub fn from_points(points: &[Vec3]) -> Result<Self, HullError> {
        Ok(Self::from_hull(ConvexHull::from_points(points)?))
    }

    /// The convex hull of a closed mesh, with the mesh riding inside as the one that is drawn.
    ///
    /// # Errors
    /// [`HullError::Mesh`] names the edge at which the mesh is open, or says that it encloses no volume;
    /// otherwise as [`ConvexHull::from_points`].
    pub fn from_mesh(mesh: TriMesh) -> Result<Self, HullError> {
        mesh.check_closed()?;
        let volume = mesh.volume();
        let outward = volume > 0.0;
        if !outward {
            return Err(MeshError::NoVolume { volume }.into());
        }
        let points = mesh.used_positions();
        Ok(Self::from_parts(
            ConvexHull::from_points(&points)?,
            Some(mesh),
        ))
    }

    /// A box with edges of length `x`, `y`, `z` (m); see [`primitives::cuboid`].
    ///
    /// # Errors
    /// As [`primitives::cuboid`].
    pub fn cuboid(x: f32, y: f32, z: f32) -> Result<Self, HullError> {
        primitives::cuboid(x, y, z).map(Self::from_hull)
    }

    /// A prism over a regular polygon, its axis along y; see [`primitives::regular_prism`].
    ///
    /// # Errors
    /// As [`primitives::regular_prism`].
    pub fn regular_prism(sides: u32, circumradius: f32, height: f32) -> Result<Self, HullError> {
        primitives::regular_prism(sides, circumradius, height).map(Self::from_hull)
    }

    /// A sphere of triangles; see [`primitives::icosphere`].
    ///
    /// # Errors
    /// As [`primitives::icosphere`].
    pub fn icosphere(radius: f32, subdivisions: u32) -> Result<Self, HullError> {
        primitives::icosphere(radius, subdivisions).map(Self::from_hull)
    }

    /// A ramp that falls along x; see [`primitives::wedge`].
    ///
    /// # Errors
    /// As [`primitives::wedge`].
    pub fn wedge(x: f32, y: f32, z: f32) -> Result<Self, HullError> {
        primitives::wedge(x, y, z).map(Self::from_hull)
    }

    /// The shape scaled about its origin by `factor` along x, y and z.
    ///
    /// # Errors
    /// [`MeshError::BadScale`] if a factor is not finite and positive, and what
    /// [`ConvexHull::from_points`] says of the result.
    pub fn scaled(&self, factor: Vec3) -> Result<Self, HullError> {
        if !(factor.is_finite() && factor.min_element() > 0.0) {
            return Err(crate::geometry::MeshError::BadScale { factor }.into());
        }
        let points: Vec<Vec3> = self.hull().vertices().iter().map(|v| *v * factor).collect();
        let visual = self
            .visual()
            .map(|mesh| mesh.clone().scaled(factor))
            .transpose()?;
        let hull = ConvexHull::from_points(&points)?;
        Ok(Self::assemble(hull, visual, self.0.weighs_visual))
    }

    /// The hull that collides and carries the mass.
    pub fn hull(&self) -> &ConvexHull {
        &self.0.hull
    }

    /// The mesh that rides inside the hull, if one was given.
    pub fn visual(&self) -> Option<&TriMesh> {
        self.0.visual.as_ref()
    }

    /// The mesh to draw: the one that rides inside, or else the hull's own, flat-shaded.
    pub fn render_mesh(&self) -> Cow<'_, TriMesh> {
        match &self.0.visual {
            Some(mesh) => Cow::Borrowed(mesh),
            None => Cow::Owned(self.0.hull.to_mesh()),
        }
    }

    /// Bounding box of the hull in the entity's frame.
    pub fn aabb(&self) -> Aabb {
        self.0.hull.aabb()
    }

    /// Whether two handles are the same shape in memory.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// A static half-space: everything on the far side of the plane is solid. For a floor or a wall without end.
#[derive(Clone, Copy, Debug, PartialEq, Component)]
#[component(summary_tick)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct HalfSpaceShape {
    /// Outward unit normal in the entity's frame; the plane goes through the entity's origin.
    pub normal: Vec3,
}

impl HalfSpaceShape {
    /// The half-space below the plane through the entity's origin with this outward normal, which is scaled to unit
    /// length.
    ///
    /// # Errors
    /// [`PlaneError`] if the normal is zero or not finite.
    pub fn new(normal: Vec3) -> Result<Self, PlaneError> {
        if normal == Vec3::ZERO {
            return Err(PlaneError::ZeroNormal);
        }
        // In f64, so that the length of no f32 vector overflows or vanishes.
        let plane = Plane {
            normal: normal.as_dvec3().normalize_or(glam::DVec3::NAN).as_vec3(),
            offset: 0.0,
        };
        check_plane(&plane)?;
        Ok(Self {
            normal: plane.normal,
        })
    }
}
