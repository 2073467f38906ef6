//! The shapes a body can have: `ConvexMesh`, shared and immutable, and the static `HalfSpaceShape`.

use crate::geometry::hull_lanes::bounds;
use crate::geometry::moments::SolidMoments;
use crate::geometry::predicates::{FLAT_RELATIVE, PlaneError, check_plane};
use crate::geometry::round::RoundShape;
use crate::geometry::round_polyhedron::RESOLUTION;
use crate::geometry::{ConvexHull, HullError, MeshError, TriMesh, primitives};
use crate::math::{Aabb, Plane};
use bevy_ecs::component::Component;
use glam::{Mat3, Vec3};
use std::borrow::Cow;
use std::sync::Arc;

/// The shape of a body: a convex hull or a round shape, and optionally a closed mesh that rides inside it and is what is drawn.
///
/// [`sphere`](Self::sphere), [`capsule`](Self::capsule), [`cylinder`](Self::cylinder), [`cone`](Self::cone) and what is
/// [`rounded`](Self::rounded) are round: they roll, and have the mass of what they are. Where one is drawn or cut, a
/// polyhedron stands for it, whose [resolution](Self::with_resolution) can be chosen.
///
/// Shared and immutable, so cloning costs one reference count. Coordinates are metres in the entity's frame.
#[derive(Clone, Debug, Component)]
#[component(summary_tick)]
pub struct ConvexMesh(Arc<MeshParts>);

#[derive(Clone, Debug)]
struct MeshParts {
    hull: ConvexHull,
    visual: Option<TriMesh>,
    weighs_visual: bool,
    /// The shape, if the hull only stands for it, and how many sides a circle has in the hull.
    round: Option<(RoundShape, u32)>,
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
            round: None,
        }))
    }

    /// A round shape, for which a polyhedron stands that has so many sides around.
    fn of_round(shape: RoundShape, resolution: u32) -> Result<Self, HullError> {
        Ok(Self(Arc::new(MeshParts {
            hull: shape.polyhedron(resolution)?,
            visual: None,
            weighs_visual: false,
            round: Some((shape, resolution)),
        })))
    }

    /// The shape with the mass, center and inertia of the mesh that rides in it instead of those of its hull, and so with its
    /// pieces: a cup weighs its wall and not the air in it. A mesh that encloses nothing leaves it at the hull.
    pub fn with_mass_of_visual(self) -> Self {
        let parts = Arc::unwrap_or_clone(self.0);
        Self(Arc::new(MeshParts {
            weighs_visual: true,
            ..parts
        }))
    }

    /// The shape with a mesh that rides in it, if there is one, and whether the mass is that of the mesh.
    pub(crate) fn carrying(self, visual: Option<TriMesh>, weighs_visual: bool) -> Self {
        let parts = Arc::unwrap_or_clone(self.0);
        Self(Arc::new(MeshParts {
            visual,
            weighs_visual,
            ..parts
        }))
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

    /// A sphere around the origin.
    ///
    /// # Errors
    /// [`HullError`] if the radius (m) is not positive and finite, too small or too large.
    pub fn sphere(radius: f32) -> Result<Self, HullError> {
        Self::of_round(RoundShape::sphere(radius)?, RESOLUTION)
    }

    /// A capsule along y: all that is within `radius` (m) of a segment of `length` (m) around the origin.
    ///
    /// # Errors
    /// [`HullError`] if a size is not positive and finite, or the capsule too small or large, or too thin for its length.
    pub fn capsule(radius: f32, length: f32) -> Result<Self, HullError> {
        Self::of_round(RoundShape::capsule(radius, length)?, RESOLUTION)
    }

    /// A cylinder along y around the origin, with a circular section: it rolls on its side and stands on its caps. Sizes in m.
    ///
    /// # Errors
    /// [`HullError`] if a size is not positive and finite, or the cylinder too flat, small or large.
    pub fn cylinder(radius: f32, height: f32) -> Result<Self, HullError> {
        Self::of_round(RoundShape::frustum(radius, radius, height)?, RESOLUTION)
    }

    /// A cone along y, its tip up, its base and its tip half of the height from the origin. Sizes in m.
    ///
    /// # Errors
    /// [`HullError`] if a size is not positive and finite, or the cone too flat, small or large.
    pub fn cone(radius: f32, height: f32) -> Result<Self, HullError> {
        Self::of_round(RoundShape::frustum(radius, 0.0, height)?, RESOLUTION)
    }

    /// All that is within `radius` (m) of this shape: a box gets round edges and corners outside of it. A cylinder or a cone is
    /// taken as the polyhedron that stands for it. A mesh that rides inside stays what is drawn.
    ///
    /// # Errors
    /// [`HullError`] if the radius is not positive and finite, or the shape too large.
    pub fn rounded(&self, radius: f32) -> Result<Self, HullError> {
        primitives::check_length("radius", radius)?;
        let resolution = self.resolution().unwrap_or(RESOLUTION);
        let rounded = match self.round().and_then(|round| round.rounded(radius)) {
            Some(rounded) => rounded,
            None => RoundShape::hull(self.hull().clone(), radius)?,
        };
        let parts = Arc::unwrap_or_clone(Self::of_round(rounded, resolution)?.0);
        Ok(Self(Arc::new(MeshParts {
            visual: self.0.visual.clone(),
            weighs_visual: self.0.weighs_visual,
            ..parts
        })))
    }

    /// The same shape with another polyhedron to be cut and drawn, in which a whole circle has about so many sides. A hull stays what
    /// it is.
    ///
    /// # Errors
    /// [`HullError::Count`] if that is not within [`RESOLUTIONS`](crate::geometry::RESOLUTIONS), and what
    /// [`ConvexHull::from_points`] says of the result.
    pub fn with_resolution(&self, sides: u32) -> Result<Self, HullError> {
        let Some((round, _)) = &self.0.round else {
            return Ok(self.clone());
        };
        Ok(Self(Arc::new(MeshParts {
            hull: round.polyhedron(sides)?,
            round: Some((round.clone(), sides)),
            ..MeshParts::clone(&self.0)
        })))
    }

    /// About how many sides a circle has in the polyhedron that stands for a round shape; none of a hull.
    pub fn resolution(&self) -> Option<u32> {
        self.0.round.as_ref().map(|(_, resolution)| *resolution)
    }

    /// Whether the surface is curved, so that [`hull`](Self::hull) only stands for the shape.
    pub fn is_round(&self) -> bool {
        self.0.round.is_some()
    }

    /// The round shape, if it is one.
    #[inline]
    pub(crate) fn round(&self) -> Option<&RoundShape> {
        self.0.round.as_ref().map(|(shape, _)| shape)
    }

    /// Volume, first and second moments of the solid.
    pub(crate) fn moments(&self) -> &SolidMoments {
        self.round()
            .map_or(&self.hull().moments, |round| &round.moments)
    }

    /// The box around the shape in another frame.
    pub(crate) fn bounds(&self, turn: &Mat3, shift: Vec3) -> Aabb {
        match self.round() {
            Some(round) => round.bounds(turn, shift),
            None => bounds(&self.hull().lanes.points, turn, shift),
        }
    }

    /// Largest distance of the surface from a point, m.
    pub(crate) fn farthest_from(&self, point: Vec3) -> f32 {
        if let Some(round) = self.round() {
            return round.farthest_from(point);
        }
        let away = self
            .hull()
            .vertices()
            .iter()
            .map(|v| v.distance_squared(point));
        away.fold(0.0, f32::max).sqrt()
    }

    /// A sphere of triangles, which does not roll as [`sphere`](Self::sphere) does; see [`primitives::icosphere`].
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

    /// The shape scaled about its origin by `factor` along x, y and z. A round shape stays round where it is of the same kind then:
    /// a sphere with equal factors, a cylinder with equal factors along x and z; otherwise it becomes its polyhedron.
    ///
    /// # Errors
    /// [`MeshError::BadScale`] if a factor is not finite and positive, and what
    /// [`ConvexHull::from_points`] says of the result.
    pub fn scaled(&self, factor: Vec3) -> Result<Self, HullError> {
        if !(factor.is_finite() && factor.min_element() > 0.0) {
            return Err(crate::geometry::MeshError::BadScale { factor }.into());
        }
        if let Some((round, resolution)) = &self.0.round
            && let Some(scaled) = round.scaled(factor)
        {
            let parts = Arc::unwrap_or_clone(Self::of_round(scaled, *resolution)?.0);
            let visual = self.visual().map(|mesh| mesh.clone().scaled(factor));
            return Ok(Self(Arc::new(MeshParts {
                visual: visual.transpose()?,
                weighs_visual: self.0.weighs_visual,
                ..parts
            })));
        }
        let points: Vec<Vec3> = self.hull().vertices().iter().map(|v| *v * factor).collect();
        let visual = self
            .visual()
            .map(|mesh| mesh.clone().scaled(factor))
            .transpose()?;
        let hull = ConvexHull::from_points(&points)?;
        Ok(Self::assemble(hull, visual, self.0.weighs_visual))
    }

    /// The hull that collides and carries the mass; of a [round](Self::is_round) shape the polyhedron that stands for it where it is
    /// cut or drawn, which has its corners on the surface.
    pub fn hull(&self) -> &ConvexHull {
        &self.0.hull
    }

    /// The mesh that rides inside the hull, if one was given.
    pub fn visual(&self) -> Option<&TriMesh> {
        self.0.visual.as_ref()
    }

    /// The mesh to draw: the one that rides inside, or else the hull's own, flat-shaded; of a round shape with its normals.
    pub fn render_mesh(&self) -> Cow<'_, TriMesh> {
        match (&self.0.visual, self.round()) {
            (Some(mesh), _) => Cow::Borrowed(mesh),
            (None, Some(round)) => Cow::Owned(round.smooth_mesh(self.hull())),
            (None, None) => Cow::Owned(self.0.hull.to_mesh()),
        }
    }

    /// Bounding box of the shape in the entity's frame.
    pub fn aabb(&self) -> Aabb {
        self.round().map_or(self.0.hull.aabb(), |round| round.aabb)
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

impl Default for HalfSpaceShape {
    /// A floor.
    fn default() -> Self {
        Self { normal: Vec3::Y }
    }
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
