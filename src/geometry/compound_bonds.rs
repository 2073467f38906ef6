//! Compounds whose parts are held by bonds: a cluster. Which of them hang together, and what is left when some come off.

use crate::disjoint_sets::DisjointSets;
use crate::geometry::compound::{Compound, CompoundError, CompoundShape};
use crate::geometry::compound_part::CompoundPart;
use crate::geometry::part_bond::{BOND_GAP, PartBond, WORN_OUT};
use crate::math::{Aabb, Pose};
use glam::Vec3;
use std::sync::Arc;

/// Marks a part of no group.
const NONE: u32 = u32::MAX;

impl Compound {
    /// The same parts held by these bonds: a cluster, one body until a blow or a load breaks bonds, then as many as there are groups of
    /// parts that bonds hold together.
    ///
    /// # Errors
    /// [`CompoundError::Bond`] if a bond is not usable, [`CompoundError::Unbonded`] if the bonds leave parts on their own.
    pub fn with_bonds(self, bonds: impl Into<Vec<PartBond>>) -> Result<Self, CompoundError> {
        let held = self.with_bonds_of_groups(bonds)?;
        let groups = groups_of(held.len(), held.bonds(), |_| false);
        if let Some(part) = groups.iter().position(|&group| group != 0) {
            return Err(CompoundError::Unbonded { part });
        }
        Ok(held)
    }

    /// The same if the bonds may leave several groups, which come apart as soon as a body has them.
    pub(crate) fn with_bonds_of_groups(
        self,
        bonds: impl Into<Vec<PartBond>>,
    ) -> Result<Self, CompoundError> {
        let bonds: Vec<PartBond> = bonds.into();
        let count = self.len() as u32;
        let is_wrong = |bond: &PartBond| {
            let is_there = bond.parts.iter().all(|&part| part < count);
            !(is_there && bond.is_usable())
        };
        if let Some(bond) = bonds.iter().position(is_wrong) {
            return Err(CompoundError::Bond { bond });
        }
        Ok(self.holding(bonds))
    }

    /// The same parts held wherever two share a face, with a tensile and shear strength (Pa); see [`PartBond::between`].
    ///
    /// # Errors
    /// As [`with_bonds`](Self::with_bonds).
    pub fn bonded(self, strength: f32) -> Result<Self, CompoundError> {
        let bonds = self.shared_faces(strength);
        self.with_bonds(bonds)
    }

    /// A bond of this strength (Pa) for each two parts that share a face, in order of the parts.
    pub fn shared_faces(&self, strength: f32) -> Vec<PartBond> {
        let mut bonds = Vec::new();
        let mut near = Vec::new();
        for (index, part) in (0..).zip(self.parts()) {
            let extent = part.shape.aabb().extents().min_element();
            let around = self.0.boxes[index as usize].fattened(BOND_GAP * extent);
            near.clear();
            self.within(&around, |other| near.push(other));
            near.retain(|&other| other > index);
            near.sort_unstable();
            let found = near.iter();
            bonds
                .extend(found.filter_map(|&other| {
                    PartBond::between(self.parts(), [index, other], strength)
                }));
        }
        bonds
    }

    /// What holds the parts together, if they are held by bonds.
    pub fn bonds(&self) -> &[PartBond] {
        self.0.bonds.as_deref().unwrap_or_default()
    }

    /// Whether the parts are held by bonds, which may break.
    pub fn is_bonded(&self) -> bool {
        self.0.bonds.is_some()
    }

    /// The part that a point of the compound's frame is in, or nearest to by the planes of its faces; the first on a tie.
    pub(crate) fn part_at(&self, point: Vec3) -> u32 {
        let height = |part: u32| self.parts()[part as usize].height_of(point);
        let mut reach = 0.01 * self.min_extent();
        let most = self.aabb().diagonal().max(self.min_extent());
        while reach < most {
            let around = Aabb {
                min: point - reach,
                max: point + reach,
            };
            let mut nearest: Option<(f32, u32)> = None;
            self.within(&around, |part| {
                let own = (height(part), part);
                if nearest.is_none_or(|least| own < least) {
                    nearest = Some(own);
                }
            });
            if let Some((_, part)) = nearest {
                return part;
            }
            reach *= 4.0;
        }
        let all = (0..self.len() as u32).map(|part| (height(part), part));
        let nearest = all.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        nearest.map_or(0, |(_, part)| part)
    }

    /// The same parts held by bonds that are known to be usable, but may leave parts on their own.
    pub(crate) fn holding(self, bonds: Vec<PartBond>) -> Self {
        let mut shape = Arc::unwrap_or_clone(self.0);
        shape.bonds = Some(bonds.into());
        Self(Arc::new(shape))
    }

    /// The same without some of its bonds, by index.
    pub(crate) fn without_bonds(&self, broken: &[u32]) -> Self {
        let bonds = (0..).zip(self.bonds());
        let left = bonds.filter(|(index, _)| !broken.contains(index));
        let left = left.map(|(_, bond)| *bond).collect();
        self.clone().holding(left)
    }

    /// The same with some of its bonds (by index, with the most that each bore as a share of what it can) worn by `share` times the square of
    /// that.
    pub(crate) fn worn(&self, worn: &[(u32, f32)], share: f32) -> Self {
        let mut bonds = self.bonds().to_vec();
        for &(index, peak) in worn {
            let bond = &mut bonds[index as usize];
            bond.damage = (bond.damage + share * peak * peak).min(WORN_OUT);
        }
        self.clone().holding(bonds)
    }

    /// Some of its parts (ascending) with the bonds between them, in the same frame. The mesh that was drawn for all of them is gone.
    pub(crate) fn subset(&self, kept: &[u32]) -> Self {
        let parts = kept.iter().map(|&part| self.parts()[part as usize].clone());
        let mut number = vec![NONE; self.len()];
        for (new, &old) in (0..).zip(kept) {
            number[old as usize] = new;
        }
        let mut shape = CompoundShape::uncovered(parts.collect(), None);
        shape.cover = self.0.cover.subset(&shape.parts, kept, &number);
        shape.bonds = self.0.bonds.as_ref().map(|bonds| {
            let renamed = bonds.iter().map(|bond| PartBond {
                parts: bond.parts.map(|part| number[part as usize]),
                ..*bond
            });
            renamed.filter(|bond| !bond.parts.contains(&NONE)).collect()
        });
        Self(Arc::new(shape))
    }

    /// The same compound in a frame that is shifted: what was at a place is at that place plus `offset` (m).
    pub(crate) fn translated(&self, offset: Vec3) -> Self {
        let parts = self.parts().iter().map(|part| {
            let pose = Pose::new(part.pose.position + offset, part.pose.rotation);
            CompoundPart::new(pose, part.shape.clone())
        });
        let visual = self.visual().cloned();
        let visual = visual.map(|mesh| mesh.transformed(&Pose::from_position(offset)));
        let mut shape = CompoundShape::uncovered(parts.collect(), visual);
        // What is covered is told in the frames of the parts.
        shape.cover = self.0.cover.clone();
        let bonds = self.0.bonds.as_ref();
        shape.bonds = bonds.map(|bonds| bonds.iter().map(|b| b.translated(offset)).collect());
        Self(Arc::new(shape))
    }
}

/// By part: which group of parts it belongs to that bonds hold together, but for those that are broken. Groups are numbered by
/// their first parts.
pub(crate) fn groups_of(
    count: usize,
    bonds: &[PartBond],
    is_broken: impl Fn(usize) -> bool,
) -> Vec<u32> {
    let mut sets = DisjointSets::new(count);
    for (index, bond) in bonds.iter().enumerate() {
        if !is_broken(index) {
            sets.join(bond.parts[0], bond.parts[1]);
        }
    }
    let mut groups = vec![NONE; count];
    let mut next = 0;
    for part in 0..count as u32 {
        let root = sets.root(part) as usize;
        if groups[root] == NONE {
            groups[root] = next;
            next += 1;
        }
        groups[part as usize] = groups[root];
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::ConvexMesh;

    fn row(count: usize) -> Compound {
        let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a box");
        let at = |i: usize| Pose::from_position(Vec3::X * i as f32);
        Compound::new((0..count).map(|i| (at(i), cube.clone()))).expect("parts")
    }

    #[test]
    fn a_subset_is_the_compound_of_its_parts() {
        let whole = row(12).bonded(1e5).expect("a row");
        assert_eq!(whole.bonds().len(), 11);
        let kept = [2, 3, 4, 8, 9];
        let some = whole.subset(&kept);
        let anew = Compound::new(kept.map(|part| whole.parts()[part as usize].clone()));
        let anew = anew.expect("parts");
        assert_eq!(some.bonds().len(), 3);
        for part in 0..kept.len() {
            assert_eq!(some.neighbors(part), anew.neighbors(part));
            for face in 0..6 {
                let polygons = |of: &Compound| {
                    let open = of.cover().open_polygons(part, face);
                    open.map(|open| open.map(<[Vec3]>::to_vec).collect::<Vec<_>>())
                };
                assert_eq!(polygons(&some), polygons(&anew), "part {part}, face {face}");
            }
        }
    }

    #[test]
    fn parts_without_a_bond_are_refused() {
        let lone = |part| Err(CompoundError::Unbonded { part });
        let bonds = row(4).shared_faces(1.0);
        assert_eq!(row(4).with_bonds(&bonds[..2]).map(|c| c.len()), lone(3));
        let wrong = PartBond {
            area: f32::NAN,
            ..bonds[0]
        };
        let error = row(2).with_bonds([wrong]).map(|c| c.len());
        assert_eq!(error, Err(CompoundError::Bond { bond: 0 }));
    }
}
