//! Compounds cut part by part, and what of them hangs together.

use crate::geometry::{
    Compound, CompoundPart, ConvexHull, ConvexMesh, HullError, PartBond, TriMesh, groups_of,
};
use crate::math::Plane;
use crate::slice::components::split_components;
use crate::slice::cut::Cut;
use crate::slice::cutting::Cutting;
use crate::slice::mesh_slicer::MeshSlicer;
use crate::slice::roughen::CutLooks;
use crate::slice::{Piece, PieceCutter, SliceError};
use glam::Vec3;

/// Parts and a mesh that is drawn in their place, on one side of a plane.
#[derive(Default)]
struct Half {
    parts: Vec<CompoundPart>,
    /// By part: which it was, and whether it is whole.
    origins: Vec<(u32, bool)>,
    visual: Option<TriMesh>,
}

impl PieceCutter {
    /// Cuts a compound, and the mesh that is drawn in its place, by one plane after the other. A piece is what of the parts on one
    /// side of the planes hangs together; a round part that is cut becomes its polyhedron. One piece if the planes miss.
    ///
    /// # Errors
    /// [`SliceError::Mesh`] if a mesh that is drawn is not closed, [`SliceError::Hull`] if a part does not make a hull
    /// although it is not flat.
    pub(crate) fn cut_compound(
        &mut self,
        compound: &Compound,
        planes: &[Plane],
        looks: &CutLooks,
    ) -> Result<Vec<Compound>, SliceError> {
        let mut pieces = vec![compound.clone()];
        for &plane in planes {
            let mut next = Vec::with_capacity(pieces.len() + 1);
            for piece in pieces {
                match self.halves(&piece, plane, looks)? {
                    Some(halves) => {
                        for half in halves {
                            let bonds = inherited(&piece, &half.parts, &half.origins);
                            next.extend(connected(half.parts, half.visual, bonds));
                        }
                    }
                    None => next.push(piece),
                }
            }
            pieces = next;
        }
        Ok(pieces)
    }

    /// The parts below and above a plane; none if all are on one side.
    fn halves(
        &mut self,
        compound: &Compound,
        plane: Plane,
        looks: &CutLooks,
    ) -> Result<Option<[Half; 2]>, SliceError> {
        let mut halves = [Half::default(), Half::default()];
        for (index, part) in (0..).zip(compound.parts()) {
            let own = plane.in_frame_of(&part.pose);
            let cut = Cutting::Planes([own].into_iter().collect());
            let pieces = self.cut_shape(&part.shape, &cut, usize::MAX, looks)?;
            let is_whole = pieces.len() == 1;
            for piece in pieces {
                let is_above = own.distance(middle(&piece.hull)) > 0.0;
                let shape = if is_whole {
                    part.shape.clone()
                } else {
                    shape_of(piece, part.shape.weighs_visual())
                };
                let half = &mut halves[usize::from(is_above)];
                half.parts.push(CompoundPart::new(part.pose, shape));
                half.origins.push((index, is_whole));
            }
        }
        if halves.iter().any(|half| half.parts.is_empty()) {
            return Ok(None);
        }
        if let Some(mesh) = compound.visual() {
            match MeshSlicer::default().slice(mesh, plane, looks.options)? {
                Cut::Below => halves[0].visual = Some(mesh.clone()),
                Cut::Above => halves[1].visual = Some(mesh.clone()),
                Cut::Cut(cut) => {
                    halves[0].visual = Some(cut.below);
                    halves[1].visual = Some(cut.above);
                }
            }
        }
        Ok(Some(halves))
    }

    /// Divides one part of a compound as a blow does, into pieces in the compound's frame, and tells what of the other parts
    /// hangs together. Of a compound with a mesh of its own the pieces show their parts.
    ///
    /// # Errors
    /// As [`PieceCutter::cut`].
    pub(crate) fn break_part(
        &mut self,
        compound: &Compound,
        struck: usize,
        (cutting, most): (&Cutting, usize),
        looks: &CutLooks,
    ) -> Result<Vec<Compound>, SliceError> {
        let part = &compound.parts()[struck];
        let pieces = self.cut_shape(&part.shape, cutting, most, looks)?;
        if pieces.len() < 2 {
            return Ok(vec![compound.clone()]);
        }
        let weighs_visual = part.shape.weighs_visual();
        let mut all = Vec::with_capacity(pieces.len() + 1);
        for piece in pieces {
            let shape = shape_of(piece, weighs_visual);
            let part = CompoundPart::new(part.pose, shape);
            all.extend(connected(vec![part], None, None));
        }
        let rest = (0..).zip(compound.parts());
        let rest = rest.filter(|(index, _)| *index as usize != struck);
        let (origins, rest): (Vec<_>, Vec<_>) = rest
            .map(|(index, part)| ((index, true), part.clone()))
            .unzip();
        let bonds = inherited(compound, &rest, &origins);
        all.extend(connected(rest, None, bonds));
        Ok(all)
    }
}

/// The shape of a piece, weighed as what it was a part of.
pub(crate) fn shape_of(piece: Piece, weighs_visual: bool) -> ConvexMesh {
    let shape = ConvexMesh::from_parts(piece.hull, piece.visual);
    if weighs_visual {
        shape.with_mass_of_visual()
    } else {
        shape
    }
}

/// A point inside of a hull.
fn middle(hull: &ConvexHull) -> Vec3 {
    hull.vertices().iter().sum::<Vec3>() / hull.vertices().len() as f32
}

/// The bonds of a compound between what is left of its parts: over the faces that they still share. None if it has none.
fn inherited(
    compound: &Compound,
    parts: &[CompoundPart],
    origins: &[(u32, bool)],
) -> Option<Vec<PartBond>> {
    if !compound.is_bonded() {
        return None;
    }
    // Parts are in the order of those that they were.
    let of = |part: u32| {
        let first = origins.partition_point(|&(origin, _)| origin < part);
        let own = origins[first..].iter();
        let count = own.take_while(|&&(origin, _)| origin == part).count();
        first..first + count
    };
    let mut bonds = Vec::new();
    for bond in compound.bonds() {
        let [a, b] = bond.parts.map(of);
        for (i, j) in a.flat_map(|i| b.clone().map(move |j| (i, j))) {
            let names = [i as u32, j as u32];
            if origins[i].1 && origins[j].1 {
                bonds.push(PartBond {
                    parts: names,
                    ..*bond
                });
                continue;
            }
            let shared = PartBond::between(parts, names, bond.strength);
            bonds.extend(shared.map(|shared| PartBond {
                shear_strength: bond.shear_strength,
                damage: bond.damage,
                ..shared
            }));
        }
    }
    Some(bonds)
}

/// A compound for each group of parts that hang together: that bonds hold, or, where there are none, that touch or overlap, or are
/// connected by others that do.
fn connected(
    parts: Vec<CompoundPart>,
    visual: Option<TriMesh>,
    bonds: Option<Vec<PartBond>>,
) -> Vec<Compound> {
    let Ok(whole) = Compound::new(parts) else {
        return Vec::new();
    };
    let (groups, whole) = match bonds {
        Some(bonds) => (
            groups_of(whole.len(), &bonds, |_| false),
            whole.holding(bonds),
        ),
        None => (touching_groups(&whole), whole),
    };
    let number = groups.iter().max().map_or(0, |&last| last as usize + 1);
    if number == 1 {
        return vec![match visual {
            Some(mesh) => whole.with_visual(mesh),
            None => whole,
        }];
    }
    let mut meshes = visual.map(|mesh| meshes_of(&mesh, &whole, &groups, number));
    let pieces = (0..number).map(|group| {
        let parts = (0..).zip(&groups);
        let own = parts.filter(|(_, of)| **of as usize == group);
        let piece = whole.subset(&own.map(|(part, _)| part).collect::<Vec<u32>>());
        match &mut meshes {
            Some(meshes) => piece.with_visual(std::mem::take(&mut meshes[group])),
            None => piece,
        }
    });
    pieces.collect()
}

/// By part: its group of parts that touch. Groups are numbered by their first parts.
fn touching_groups(whole: &Compound) -> Vec<u32> {
    let mut groups = vec![u32::MAX; whole.len()];
    let mut number = 0;
    for first in 0..whole.len() {
        if groups[first] != u32::MAX {
            continue;
        }
        let mut waiting = vec![first];
        while let Some(part) = waiting.pop() {
            if groups[part] == u32::MAX {
                groups[part] = number;
                let neighbors = whole.neighbors(part).iter();
                waiting.extend(neighbors.map(|&other| other as usize));
            }
        }
        number += 1;
    }
    groups
}

/// For each group what of a mesh belongs to it: of what hangs together in the mesh, that whose corners are nearest to its parts.
fn meshes_of(mesh: &TriMesh, whole: &Compound, groups: &[u32], count: usize) -> Vec<TriMesh> {
    let mut found: Vec<Vec<TriMesh>> = vec![Vec::new(); count];
    for component in split_components(mesh) {
        let at = component.positions.first().copied().unwrap_or_default();
        let height = |part: &CompoundPart| {
            let own = part.pose.inverse_transform_point(at);
            let faces = part.shape.hull().faces().iter();
            let heights = faces.map(|face| face.plane.distance(own));
            heights.fold(f32::NEG_INFINITY, f32::max)
        };
        let parts = whole.parts().iter().zip(groups);
        let nearest = parts.map(|(part, &group)| (height(part), group));
        let nearest = nearest.min_by(|(a, _), (b, _)| a.total_cmp(b));
        if let Some((_, group)) = nearest {
            found[group as usize].push(component);
        }
    }
    found.iter().map(|meshes| TriMesh::joined(meshes)).collect()
}

impl Compound {
    /// The hull of the one part and the mesh to draw, compound's frame; none if there are several, or the part is round.
    pub(crate) fn single_hull(&self) -> Result<Option<ConvexMesh>, HullError> {
        let [part] = self.parts() else {
            return Ok(None);
        };
        if part.shape.is_round() {
            return Ok(None);
        }
        let shape = part.in_place()?;
        let Some(mesh) = self.visual() else {
            return Ok(Some(shape));
        };
        let shape = ConvexMesh::from_parts(shape.hull().clone(), Some(mesh.clone()));
        Ok(Some(shape))
    }
}
