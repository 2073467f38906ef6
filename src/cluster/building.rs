//! `Cluster`: parts and bonds as plain data, to be made in advance, changed, saved and loaded.

use crate::geometry::{
    Compound, CompoundError, CompoundPart, ConvexMesh, MAX_PARTS, PartBond, groups_of,
};
use crate::slice::compound::shape_of;
use crate::slice::roughen::CutLooks;
use crate::slice::separate::fit_hulls;
use crate::slice::{FracturePattern, Impact, Piece, PieceCutter, Relief, SliceError};
use glam::Vec3;

/// How far rounding may put a drawn corner out of its hull, as a share of the hull's size.
const ROUNDING: f32 = 1e-5;

/// Parts and the bonds between them, from which a [`Compound`] is made that breaks along its bonds.
///
/// All is plain data: to save a cluster is to save poses, corners and drawn meshes of its parts, and its bonds; the strength of each may be
/// set. [`Compound::bonds`] tells what is left of them in a running simulation, and `Cluster::from` takes all of it out again.
///
/// A body with such a compound is one body, in contacts, solve and sleep, until a blow or a load breaks bonds inside it: then it is as many
/// as there are groups of parts that bonds still hold together. A [`Static`](crate::bodies::RigidBody::Static) one stays what it
/// is, on the same entity, as far as bonds hold it to where it is [anchored](crate::bodies::Anchors); the rest falls.
///
/// ```
/// use bevy_cleave::prelude::*;
/// use glam::Vec3;
///
/// // A wall that is cut into bricks in advance, and bricks that are stronger than the mortar and break in two.
/// let wall = ConvexMesh::cuboid(2.0, 1.0, 0.1)?;
/// let size = Vec3::new(0.25, 0.1, 0.1);
/// let walled = Cluster::cut(&wall, &FracturePattern::Brick { size }, 1, 2e5)?;
/// let halves = walled.refined(&FracturePattern::Slabs { count: 2 }, 2, 2e6)?;
/// let compound = halves.compound()?;
/// assert!(compound.len() > 160);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Cluster {
    /// Convex shapes with poses.
    pub parts: Vec<CompoundPart>,
    /// What holds them together. Parts may touch without a bond.
    pub bonds: Vec<PartBond>,
}

/// Why a cluster was not made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ClusterError {
    /// A strength is not finite and positive.
    #[error("a strength of {strength} Pa is not finite and positive")]
    Strength {
        /// Pa.
        strength: f32,
    },
    /// A length of the relief is not positive, infinite or NaN.
    #[error("amplitude and wavelength of the relief must be positive and finite, got {} and {} m", .0.amplitude, .0.wavelength)]
    Relief(Relief),
    /// The pattern does not divide the body.
    #[error("the pattern makes no two pieces")]
    NoPieces,
    /// The body cannot be cut.
    #[error(transparent)]
    Slice(#[from] SliceError),
    /// Parts or bonds make no compound.
    #[error(transparent)]
    Compound(#[from] CompoundError),
}

impl Cluster {
    /// Parts that are held wherever two of them share a face, with this tensile and shear strength (Pa); see [`PartBond::between`].
    ///
    /// # Errors
    /// [`ClusterError`] if the parts make no compound, or the strength is not usable.
    pub fn new<P: Into<CompoundPart>>(
        parts: impl IntoIterator<Item = P>,
        strength: f32,
    ) -> Result<Self, ClusterError> {
        check(strength)?;
        let compound = Compound::new(parts)?;
        Ok(Self {
            bonds: compound.shared_faces(strength),
            parts: compound.parts().to_vec(),
        })
    }

    /// A body that is cut in advance, with the mesh that is drawn, and held together where it was cut. The same mesh, pattern and seed give the
    /// same parts.
    ///
    /// # Errors
    /// [`ClusterError::NoPieces`] if the pattern does not divide it, [`ClusterError::Slice`] if it cannot be cut.
    pub fn cut(
        mesh: &ConvexMesh,
        pattern: &FracturePattern,
        seed: u64,
        strength: f32,
    ) -> Result<Self, ClusterError> {
        Self::cut_with(mesh, pattern, seed, (strength, None))
    }

    /// As [`cut`](Self::cut), with a relief on the faces of the cuts, which is seen when they come apart. A body without a mesh of its own gets
    /// that of its hull to be drawn. Parts are what they would be without it.
    ///
    /// # Errors
    /// As [`cut`](Self::cut), and [`ClusterError::Relief`] if the lengths of the relief are not positive and finite.
    pub fn cut_rough(
        mesh: &ConvexMesh,
        pattern: &FracturePattern,
        seed: u64,
        strength: f32,
        relief: Relief,
    ) -> Result<Self, ClusterError> {
        Self::cut_with(mesh, pattern, seed, (strength, Some(relief)))
    }

    fn cut_with(
        mesh: &ConvexMesh,
        pattern: &FracturePattern,
        seed: u64,
        (strength, relief): (f32, Option<Relief>),
    ) -> Result<Self, ClusterError> {
        check_relief(relief)?;
        check(strength)?;
        let looks = CellLooks { relief, slack: 0.0 };
        let parts = divided(&CompoundPart::from(mesh.clone()), pattern, seed, looks)?;
        if parts.len() < 2 {
            return Err(ClusterError::NoPieces);
        }
        Self::new(parts, strength)
    }

    /// The next level: each part is cut anew, in its own frame, and its pieces are held together with `strength` (Pa). What held two parts
    /// together holds their pieces with the strengths that it had, as far as it is worn. Parts that the pattern does not divide stay whole.
    ///
    /// # Errors
    /// As [`Cluster::cut`], but for `NoPieces`.
    pub fn refined(
        &self,
        pattern: &FracturePattern,
        seed: u64,
        strength: f32,
    ) -> Result<Self, ClusterError> {
        self.refined_with(pattern, seed, (strength, None))
    }

    /// As [`refined`](Self::refined), with a relief on the faces of the new cuts, each part with one of its own. Relief that parts have
    /// already stays, in either. Parts are what they would be without it.
    ///
    /// # Errors
    /// As [`Cluster::refined`], and [`ClusterError::Relief`] if the lengths of the relief are not positive and finite.
    pub fn refined_rough(
        &self,
        pattern: &FracturePattern,
        seed: u64,
        strength: f32,
        relief: Relief,
    ) -> Result<Self, ClusterError> {
        self.refined_with(pattern, seed, (strength, Some(relief)))
    }

    fn refined_with(
        &self,
        pattern: &FracturePattern,
        seed: u64,
        (strength, relief): (f32, Option<Relief>),
    ) -> Result<Self, ClusterError> {
        check_relief(relief)?;
        check(strength)?;
        let looks = CellLooks {
            relief,
            slack: roughness(&self.parts),
        };
        let mut parts = Vec::new();
        let mut origins = Vec::new();
        for (index, part) in self.parts.iter().enumerate() {
            // A stream of its own for each part.
            let seed = seed
                .wrapping_mul(0x9e37_79b9_7f4a_7c15)
                .wrapping_add(index as u64);
            let pieces = divided(part, pattern, seed, looks)?;
            origins.extend(pieces.iter().map(|_| index as u32));
            parts.extend(pieces);
        }
        let fine = Self::new(parts, strength)?;
        let bonds = fine.bonds.into_iter().filter_map(|bond| {
            let [a, b] = bond.parts.map(|part| origins[part as usize]);
            if a == b {
                return Some(bond);
            }
            let held = |coarse: &&PartBond| coarse.parts == [a, b] || coarse.parts == [b, a];
            let coarse = self.bonds.iter().find(held)?;
            Some(PartBond {
                strength: coarse.strength,
                shear_strength: coarse.shear_strength,
                damage: coarse.damage,
                ..bond
            })
        });
        Ok(Self {
            bonds: bonds.collect(),
            parts: fine.parts,
        })
    }

    /// The body, to be spawned with a [`RigidBody`](crate::bodies::RigidBody).
    ///
    /// # Errors
    /// [`CompoundError`]; `Unbonded` where bonds do not hold all of it together, see [`Cluster::separated`].
    pub fn compound(&self) -> Result<Compound, CompoundError> {
        Compound::new(self.parts.iter().cloned())?.with_bonds(&self.bonds[..])
    }

    /// A cluster for each group of parts that bonds hold together.
    pub fn separated(self) -> Vec<Self> {
        let is_there = |bond: &PartBond| {
            let parts = bond.parts.iter();
            parts
                .clone()
                .all(|&part| (part as usize) < self.parts.len())
        };
        let bonds: Vec<PartBond> = self.bonds.into_iter().filter(is_there).collect();
        let groups = groups_of(self.parts.len(), &bonds, |_| false);
        let count = groups.iter().max().map_or(0, |&last| last as usize + 1);
        let mut clusters = vec![Self::default(); count];
        let mut number = Vec::with_capacity(self.parts.len());
        for (part, &group) in self.parts.into_iter().zip(&groups) {
            let own = &mut clusters[group as usize].parts;
            number.push(own.len() as u32);
            own.push(part);
        }
        for bond in bonds {
            let group = groups[bond.parts[0] as usize] as usize;
            let parts = bond.parts.map(|part| number[part as usize]);
            clusters[group].bonds.push(PartBond { parts, ..bond });
        }
        clusters
    }
}

impl From<&Compound> for Cluster {
    /// What a compound is made of, and what is left of its bonds.
    fn from(compound: &Compound) -> Self {
        Self {
            parts: compound.parts().to_vec(),
            bonds: compound.bonds().to_vec(),
        }
    }
}

fn check(strength: f32) -> Result<(), ClusterError> {
    let is_usable = strength.is_finite() && strength > 0.0;
    is_usable
        .then_some(())
        .ok_or(ClusterError::Strength { strength })
}

fn check_relief(relief: Option<Relief>) -> Result<(), ClusterError> {
    match relief {
        Some(relief) if !relief.is_usable() => Err(ClusterError::Relief(relief)),
        _ => Ok(()),
    }
}

/// What the cells of a part look like.
#[derive(Clone, Copy, Debug)]
struct CellLooks {
    /// Of the faces of the cuts.
    relief: Option<Relief>,
    /// How far faces that were cut before may lie within hulls, m.
    slack: f64,
}

/// The farthest that a drawn corner is outside of the hull of its part, m: the height of the relief that parts have. Both sides of a crack were moved by
/// the same, so that none lies deeper within its own.
fn roughness(parts: &[CompoundPart]) -> f64 {
    let outside = |part: &CompoundPart| {
        let mesh = part.shape.visual()?;
        let faces = part.shape.hull().faces();
        let height = |&p: &Vec3| {
            let heights = faces.iter().map(|face| face.plane.distance(p));
            heights.fold(f32::NEG_INFINITY, f32::max)
        };
        let height = mesh.positions().iter().map(height).fold(0.0, f32::max);
        let rounding = ROUNDING * part.shape.hull().aabb().extents().max_element();
        (height > rounding).then_some(height)
    };
    f64::from(parts.iter().filter_map(outside).fold(0.0, f32::max))
}

/// The pieces of a part, in its own frame.
fn divided(
    part: &CompoundPart,
    pattern: &FracturePattern,
    seed: u64,
    cells: CellLooks,
) -> Result<Vec<CompoundPart>, ClusterError> {
    let hull = part.shape.hull();
    let impact = Impact {
        point: hull.middle_inside(),
        normal: Vec3::Y,
        impulse: 0.0,
        energy: 0.0,
    };
    let Some(cutting) = pattern.cutting(&impact, hull, seed, MAX_PARTS as u32) else {
        return Ok(vec![part.clone()]);
    };
    let looks = CutLooks {
        relief: cells.relief.map(|relief| (relief, seed)),
        ..CutLooks::default()
    };
    let visual = looks.visual_of(&part.shape);
    let visual = visual.as_deref();
    let mut cutter = PieceCutter::default();
    let mut pieces = cutter.cut(hull, visual, &cutting, MAX_PARTS, looks.options)?;
    if part.shape.visual().is_some() {
        pieces.retain(Piece::is_seen);
        cutter.separate(&mut pieces)?;
        fit_hulls(&mut pieces, cells.slack)?;
    }
    if let Some(relief) = &cells.relief {
        // Last: hulls are what they would be without it.
        cutter.roughen(&mut pieces, relief, seed);
    }
    if pieces.len() < 2 {
        return Ok(vec![part.clone()]);
    }
    let weighs_visual = part.shape.weighs_visual();
    let shapes = pieces
        .into_iter()
        .map(|piece| shape_of(piece, weighs_visual));
    Ok(shapes
        .map(|shape| CompoundPart::new(part.pose, shape))
        .collect())
}
