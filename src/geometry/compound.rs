//! `Compound`: a shape of several convex parts, shared and immutable.

use crate::geometry::bvh::{tree_box, tree_of, within};
use crate::geometry::compound_cover::Cover;
use crate::geometry::compound_part::CompoundPart;
use crate::geometry::part_bond::PartBond;
use crate::geometry::{HullError, MeshError, TriMesh};
use crate::math::{Aabb, Pose};
use bevy_ecs::component::Component;
use glam::{Mat3, Quat, Vec3};
use obvhs::bvh2::Bvh2;
use obvhs::ploc::PlocSearchDistance;
use std::borrow::Cow;
use std::sync::Arc;

/// Most parts of a compound.
pub const MAX_PARTS: usize = 1 << 16;

/// Parts up to which their boxes are looked at one after the other: a tree is no faster for so few.
const FLAT_SEARCH: usize = 8;

/// How far the length of the quaternion of a part's rotation may be off 1: rounding of products of rotations. It is scaled to 1.
const UNIT: f32 = 1e-3;

/// The shape of a body that is not convex: several convex parts, each with a pose. A table, an arch, a cup.
///
/// Parts may touch each other, which is usual, or overlap, or be apart; they are one body all the same. Where a part's face is
/// covered by another part, nothing catches on it: what slides over flush parts slides as over one. Mass, center and
/// inertia are the sums of those of the parts, so that where parts overlap the material counts for each of them.
///
/// A plane cuts it part by part, and the mesh that is drawn with it; parts that hang together, because they touch, stay one body. What
/// breaks it by a blow divides the part that is struck, and pieces then show their parts: the mesh is gone.
///
/// Shared and immutable, so cloning costs one reference count, and so are the shapes of the parts. Coordinates are meters in the
/// entity's frame.
///
/// ```
/// use bevy_cleave::prelude::*;
/// use glam::Vec3;
///
/// let top = ConvexMesh::cuboid(1.0, 0.05, 0.6)?;
/// let leg = ConvexMesh::cuboid(0.05, 0.7, 0.05)?;
/// let at = |x, y, z| Pose::from_position(Vec3::new(x, y, z));
/// let mut parts = vec![(at(0.0, 0.725, 0.0), top)];
/// for (x, z) in [(-0.45, -0.25), (0.45, -0.25), (-0.45, 0.25), (0.45, 0.25)] {
///     parts.push((at(x, 0.35, z), leg.clone()));
/// }
/// let table = Compound::new(parts)?;
/// assert_eq!(table.len(), 5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Component)]
#[component(summary_tick)]
pub struct Compound(pub(super) Arc<CompoundShape>);

/// Why parts make no compound.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CompoundError {
    /// There are no parts.
    #[error("a compound needs at least one part")]
    Empty,
    /// There are more than [`MAX_PARTS`].
    #[error("{count} parts are more than {MAX_PARTS}")]
    TooMany {
        /// How many there are.
        count: usize,
    },
    /// A pose is NaN or infinite.
    #[error("the pose of part {part} is not finite")]
    NotFinite {
        /// Index of the part.
        part: usize,
    },
    /// The rotation of a pose is not a unit quaternion.
    #[error("the rotation of part {part} is not a unit quaternion (length {length})")]
    NotUnitRotation {
        /// Index of the part.
        part: usize,
        /// Length of the quaternion.
        length: f32,
    },
    /// A part does not stand what is to be done to it, as being scaled.
    #[error("part {part}: {error}")]
    Part {
        /// Index of the part.
        part: usize,
        /// What is wrong.
        error: HullError,
    },
    /// A bond names a part that is not there or the same twice, or has a number that is not finite and positive.
    #[error("bond {bond} names no two parts, or has a number that is not finite and positive")]
    Bond {
        /// Index of the bond.
        bond: usize,
    },
    /// Parts are to be held by bonds, and one is not.
    #[error("no bonds lead from the first part to part {part}")]
    Unbonded {
        /// Index of the part.
        part: usize,
    },
    /// The mesh that is drawn does not stand it.
    #[error(transparent)]
    Visual(#[from] MeshError),
}

#[derive(Clone)]
pub(super) struct CompoundShape {
    pub(super) parts: Vec<CompoundPart>,
    /// Around the parts, in the compound's frame.
    pub(super) boxes: Vec<Aabb>,
    /// Over the boxes, if there are many.
    tree: Option<Bvh2>,
    aabb: Aabb,
    min_extent: f32,
    has_round: bool,
    pub(super) cover: Cover,
    visual: Option<TriMesh>,
    /// What holds the parts together, if it may break.
    pub(super) bonds: Option<Arc<[PartBond]>>,
}

impl std::fmt::Debug for CompoundShape {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("CompoundShape")
            .field("parts", &self.parts)
            .field("visual", &self.visual)
            .finish_non_exhaustive()
    }
}

impl Compound {
    /// A compound of these parts: shapes with poses, or shapes that are in the compound's frame already, as those that a mesh was
    /// decomposed into.
    ///
    /// # Errors
    /// [`CompoundError`] if there are none or too many, or if a pose is not usable.
    pub fn new<P: Into<CompoundPart>>(
        parts: impl IntoIterator<Item = P>,
    ) -> Result<Self, CompoundError> {
        let mut parts: Vec<CompoundPart> = parts.into_iter().map(Into::into).collect();
        match parts.len() {
            0 => return Err(CompoundError::Empty),
            count if count > MAX_PARTS => return Err(CompoundError::TooMany { count }),
            _ => {}
        }
        for (part, CompoundPart { pose, .. }) in parts.iter_mut().enumerate() {
            if !pose.is_finite() {
                return Err(CompoundError::NotFinite { part });
            }
            let length = pose.rotation.length();
            let is_unit = (length - 1.0).abs() <= UNIT;
            if !is_unit {
                return Err(CompoundError::NotUnitRotation { part, length });
            }
            if !pose.rotation.is_normalized() {
                pose.rotation = pose.rotation.normalize();
            }
        }
        Ok(Self::assemble(parts, None))
    }

    fn assemble(parts: Vec<CompoundPart>, visual: Option<TriMesh>) -> Self {
        let mut shape = CompoundShape::uncovered(parts, visual);
        shape.cover = Cover::of(&shape.parts, |b, visit| shape.within(b, visit));
        Self(Arc::new(shape))
    }

    /// The same compound with a mesh that is drawn in place of the parts; in the compound's frame.
    pub fn with_visual(self, mesh: TriMesh) -> Self {
        let shape = Arc::unwrap_or_clone(self.0);
        Self(Arc::new(CompoundShape {
            visual: Some(mesh),
            ..shape
        }))
    }

    /// The same compound scaled about its origin by `factor` along x, y and z. Parts that are turned and scaled unequally are hulls
    /// then, round ones their polyhedra.
    ///
    /// # Errors
    /// [`CompoundError`] if a factor is not finite and positive, or a part is none any more.
    pub fn scaled(&self, factor: Vec3) -> Result<Self, CompoundError> {
        let is_even = factor.x == factor.y && factor.y == factor.z;
        let scaled = |part: &CompoundPart| {
            if is_even || part.pose.rotation == Quat::IDENTITY {
                let shape = part.shape.scaled(factor)?;
                let pose = Pose::new(factor * part.pose.position, part.pose.rotation);
                return Ok(CompoundPart::new(pose, shape));
            }
            part.in_place()?.scaled(factor).map(CompoundPart::from)
        };
        let parts = (self.0.parts.iter().enumerate())
            .map(|(part, it)| scaled(it).map_err(|error| CompoundError::Part { part, error }))
            .collect::<Result<Vec<_>, _>>()?;
        let visual = self.0.visual.clone();
        let visual = visual.map(|mesh| mesh.scaled(factor)).transpose()?;
        let mut shape = Arc::unwrap_or_clone(Self::assemble(parts, visual).0);
        let bonds = self.0.bonds.as_ref();
        shape.bonds = bonds.map(|bonds| bonds.iter().map(|bond| bond.scaled(factor)).collect());
        Ok(Self(Arc::new(shape)))
    }

    /// The parts, in the order in which they were given: what hits and contacts number.
    pub fn parts(&self) -> &[CompoundPart] {
        &self.0.parts
    }

    /// Number of parts.
    pub fn len(&self) -> usize {
        self.0.parts.len()
    }

    /// Whether there are none, which cannot be.
    pub fn is_empty(&self) -> bool {
        self.0.parts.is_empty()
    }

    /// Bounding box in the entity's frame.
    pub fn aabb(&self) -> Aabb {
        self.0.aabb
    }

    /// The mesh that is drawn, if one was given.
    pub fn visual(&self) -> Option<&TriMesh> {
        self.0.visual.as_ref()
    }

    /// The mesh to draw: the one that was given, or else those of the parts.
    pub fn render_mesh(&self) -> Cow<'_, TriMesh> {
        if let Some(mesh) = self.visual() {
            return Cow::Borrowed(mesh);
        }
        let meshes = self.0.parts.iter().map(|part| {
            let mesh = part.shape.render_mesh().into_owned();
            mesh.transformed(&part.pose)
        });
        Cow::Owned(TriMesh::joined(&meshes.collect::<Vec<_>>()))
    }

    /// Whether two handles are the same shape in memory.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// Parts that touch the part with this index, or overlap it.
    pub fn neighbors(&self, part: usize) -> &[u32] {
        self.0.cover.neighbors(part)
    }

    /// Boxes around the parts, in the compound's frame.
    pub(crate) fn boxes(&self) -> &[Aabb] {
        &self.0.boxes
    }

    /// Over the boxes, if there are many parts.
    pub(crate) fn tree(&self) -> Option<&Bvh2> {
        self.0.tree.as_ref()
    }

    /// Which faces are covered by other parts.
    pub(crate) fn cover(&self) -> &Cover {
        &self.0.cover
    }

    /// Least extent of a part, m.
    pub(crate) fn min_extent(&self) -> f32 {
        self.0.min_extent
    }

    /// Whether a part has a curved surface.
    pub(crate) fn has_round(&self) -> bool {
        self.0.has_round
    }

    /// Visits the parts whose boxes meet a box, in no order.
    pub(crate) fn within(&self, b: &Aabb, visit: impl FnMut(u32)) {
        self.0.within(b, visit);
    }

    /// The box around the compound in another frame.
    pub(crate) fn bounds(&self, turn: &Mat3, shift: Vec3) -> Aabb {
        let parts = self.0.parts.iter();
        let boxes = parts.map(|part| part.bounds(turn, shift));
        boxes.fold(Aabb::EMPTY, |a, b| box_around(&[a, b]))
    }

    /// Largest distance of the surface from a point, m.
    pub(crate) fn farthest_from(&self, point: Vec3) -> f32 {
        let away = |part: &CompoundPart| {
            let point = part.pose.inverse_transform_point(point);
            part.shape.farthest_from(point)
        };
        self.0.parts.iter().map(away).fold(0.0, f32::max)
    }
}

impl CompoundShape {
    /// Of these parts, without a look at what they cover of each other.
    pub(super) fn uncovered(parts: Vec<CompoundPart>, visual: Option<TriMesh>) -> Self {
        let bounds = |part: &CompoundPart| part.bounds(&Mat3::IDENTITY, Vec3::ZERO);
        let boxes: Vec<Aabb> = parts.iter().map(bounds).collect();
        let tree = (parts.len() > FLAT_SEARCH).then(|| {
            let boxes: Vec<_> = boxes.iter().map(tree_box).collect();
            tree_of(&boxes, PlocSearchDistance::Low)
        });
        let extents = parts
            .iter()
            .map(|part| part.shape.aabb().extents().min_element());
        Self {
            aabb: box_around(&boxes),
            min_extent: extents.fold(f32::INFINITY, f32::min),
            has_round: parts.iter().any(|part| part.shape.is_round()),
            cover: Cover::default(),
            parts,
            boxes,
            tree,
            visual,
            bonds: None,
        }
    }

    pub(super) fn within(&self, b: &Aabb, mut visit: impl FnMut(u32)) {
        if let Some(tree) = &self.tree {
            within(tree, b, visit);
            return;
        }
        for (part, other) in (0..).zip(&self.boxes) {
            if other.overlaps(b) {
                visit(part);
            }
        }
    }
}

/// The box around boxes.
fn box_around(boxes: &[Aabb]) -> Aabb {
    boxes.iter().fold(Aabb::EMPTY, |all, b| Aabb {
        min: all.min.min(b.min),
        max: all.max.max(b.max),
    })
}
