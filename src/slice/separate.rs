//! Pieces whose visual meshes fall apart, as a piece for each part.
//!
//! A plane through a table's legs leaves four stumps in one half of the table's hull. Each of them gets the convex hull
//! around itself, and falls on its own. Parts whose hulls reach into each other, such as the links of a chain or a ball in
//! a bowl, would be pushed apart as soon as they were bodies; they stay one piece, with the hull around all of them.

use crate::geometry::hull::hull_unless_flat;
use crate::geometry::{ConvexHull, TriMesh};
use crate::slice::cell_clip::{CellClipper, CutPlane};
use crate::slice::components::{label_count, labels, meshes_of};
use crate::slice::cut::Cut;
use crate::slice::{Piece, SliceError};
use glam::Vec3;

/// A hull with more air than this share of it is made anew.
const FITTING_SHARE: f64 = 1e-3;

/// How far a corner of a hull that is left as it is may be from all that is seen, as a share of the hull's size: a tip of this length has next
/// to no volume, and what lies on it would float.
const TIP_SHARE: f32 = 3e-3;

/// As [`PieceCutter::separate`](crate::slice::PieceCutter::separate).
pub(super) fn separate(
    pieces: &mut Vec<Piece>,
    clipper: &mut CellClipper,
) -> Result<(), SliceError> {
    let mut separate = Vec::with_capacity(pieces.len());
    for piece in pieces.drain(..) {
        match &piece.visual {
            Some(mesh) => match parts_of(mesh, clipper)? {
                parts if parts.len() > 1 => separate.extend(parts),
                _ => separate.push(piece),
            },
            None => separate.push(piece),
        }
    }
    *pieces = separate;
    Ok(())
}

/// As [`PieceCutter::fit_hulls`](crate::slice::PieceCutter::fit_hulls), where faces may lie within the hulls by `slack` (m), as relief of
/// earlier cuts does.
pub(crate) fn fit_hulls(pieces: &mut [Piece], slack: f64) -> Result<bool, SliceError> {
    let mut is_changed = false;
    for piece in pieces {
        let seen = piece.visual.as_ref().filter(|m| !m.triangles.is_empty());
        let loose = seen.filter(|mesh| is_loose(piece, mesh, slack));
        let Some(mesh) = loose else { continue };
        if let Some(hull) = hull_unless_flat(&mesh.used_positions())? {
            piece.volume = hull.volume();
            piece.hull = hull;
            is_changed = true;
        }
    }
    Ok(is_changed)
}

/// Whether a piece's hull holds air, or has a tip that does.
fn is_loose(piece: &Piece, mesh: &TriMesh, slack: f64) -> bool {
    // No area is asked for where nothing is slack.
    let filled = match slack {
        0.0 => mesh.volume(),
        _ => mesh.volume() + slack * mesh.area(),
    };
    let air = 1.0 - filled / piece.volume;
    air > FITTING_SHARE || has_tip(&piece.hull, mesh, slack as f32)
}

/// Whether a corner of the hull is far from all corners of the mesh in it.
fn has_tip(hull: &ConvexHull, mesh: &TriMesh, slack: f32) -> bool {
    let near = slack + TIP_SHARE * hull.aabb().extents().max_element();
    let is_near = |corner: Vec3| {
        let mut seen = mesh.positions.iter();
        seen.any(|&position| position.distance_squared(corner) <= near * near)
    };
    !hull.vertices().iter().all(|&corner| is_near(corner))
}

/// A piece for each part of a mesh; none if the mesh is in one part.
fn parts_of(mesh: &TriMesh, clipper: &mut CellClipper) -> Result<Vec<Piece>, SliceError> {
    let mut labels = labels(mesh);
    let mut parts = ComponentParts::new(mesh, &labels)?;
    if parts.hulls.iter().flatten().count() < 2 {
        return Ok(Vec::new());
    }
    parts.join_thin_ones(mesh, &mut labels)?;
    let joined = parts.join_overlapping(&mut labels, clipper)?;
    for part in joined {
        parts.hulls[part] = hull_around(mesh, &labels, part as u32)?;
    }
    let hulls = parts.hulls.into_iter().flatten();
    let pieces = hulls
        .zip(meshes_of(mesh, &labels))
        .map(|(hull, visual)| Piece {
            volume: hull.volume(),
            hull,
            visual: Some(visual),
        });
    Ok(pieces.collect())
}

/// The hulls around the parts of a mesh, by label.
struct ComponentParts {
    /// None for a label without triangles, and for a part too thin for a hull.
    hulls: Vec<Option<ConvexHull>>,
}

impl ComponentParts {
    fn new(mesh: &TriMesh, labels: &[u32]) -> Result<Self, SliceError> {
        let hulls = (0..label_count(labels) as u32).map(|label| hull_around(mesh, labels, label));
        Ok(Self {
            hulls: hulls.collect::<Result<_, _>>()?,
        })
    }

    /// Joins parts without a hull to the largest one.
    fn join_thin_ones(&mut self, mesh: &TriMesh, labels: &mut [u32]) -> Result<(), SliceError> {
        let volume = |part: &usize| self.hulls[*part].as_ref().map_or(0.0, ConvexHull::volume);
        let largest = (0..self.hulls.len()).max_by(|a, b| volume(a).total_cmp(&volume(b)));
        let Some(largest) = largest else {
            return Ok(());
        };
        let mut is_grown = false;
        for label in &mut *labels {
            if self.hulls[*label as usize].is_none() {
                *label = largest as u32;
                is_grown = true;
            }
        }
        if is_grown {
            self.hulls[largest] = hull_around(mesh, labels, largest as u32)?;
        }
        Ok(())
    }

    /// Joins parts whose hulls reach into each other, in the order of the first of both, until none do; which have grown.
    fn join_overlapping(
        &mut self,
        labels: &mut [u32],
        clipper: &mut CellClipper,
    ) -> Result<Vec<usize>, SliceError> {
        // Which part each has become a part of.
        let mut kept: Vec<usize> = (0..self.hulls.len()).collect();
        let (mut part, mut from) = (0, 1);
        while part < self.hulls.len() {
            match self.find_overlap(part, from, clipper) {
                // Grown, it may reach into those before it; others have been held against them already.
                Some([first, second]) => {
                    kept[second] = first;
                    self.join([first, second])?;
                    (part, from) = (first, 0);
                }
                None => (part, from) = (part + 1, part + 2),
            }
        }
        // One only becomes a part of one before it.
        for part in 0..kept.len() {
            kept[part] = kept[kept[part]];
        }
        for label in labels {
            *label = kept[*label as usize] as u32;
        }
        let grown = (0..kept.len()).filter(|&part| kept[part] != part);
        let mut grown: Vec<usize> = grown.map(|part| kept[part]).collect();
        grown.sort_unstable();
        grown.dedup();
        Ok(grown)
    }

    /// A part and another one, number `from` or later, whose hulls reach into each other, ascending.
    fn find_overlap(
        &self,
        part: usize,
        from: usize,
        clipper: &mut CellClipper,
    ) -> Option<[usize; 2]> {
        let own = self.hulls[part].as_ref()?;
        let mut others = (from..self.hulls.len()).filter(|&other| other != part);
        let other = others.find(|&other| {
            let hull = self.hulls[other].as_ref();
            hull.is_some_and(|hull| {
                let [a, b] = if other < part {
                    [hull, own]
                } else {
                    [own, hull]
                };
                overlap(a, b, clipper)
            })
        })?;
        Some([part.min(other), part.max(other)])
    }

    /// Makes one part of two, within the hull around both hulls: fewer points than those of their meshes.
    fn join(&mut self, [kept, joined]: [usize; 2]) -> Result<(), SliceError> {
        let both = [self.hulls[kept].take(), self.hulls[joined].take()];
        let corners = both.iter().flatten().flat_map(|hull| hull.vertices());
        let corners: Vec<Vec3> = corners.copied().collect();
        self.hulls[kept] = hull_unless_flat(&corners)?;
        Ok(())
    }
}

/// The hull around the triangles with one label; none if there are none, or they are too thin.
fn hull_around(
    mesh: &TriMesh,
    labels: &[u32],
    label: u32,
) -> Result<Option<ConvexHull>, SliceError> {
    let own = mesh.triangles.iter().zip(labels);
    let own = own.filter(|&(_, &l)| l == label);
    let mut used: Vec<u32> = own.flat_map(|(corners, _)| *corners).collect();
    used.sort_unstable();
    used.dedup();
    let points: Vec<Vec3> = (used.into_iter())
        .map(|vertex| mesh.positions[vertex as usize])
        .collect();
    Ok(hull_unless_flat(&points)?)
}

/// Whether two hulls have more in common than the thickness of a plane.
fn overlap(a: &ConvexHull, b: &ConvexHull, clipper: &mut CellClipper) -> bool {
    if !a.aabb().overlaps(&b.aabb()) {
        return false;
    }
    clipper.load(a);
    let mut planes = b.faces().iter().map(|face| CutPlane::from(face.plane));
    planes.all(|plane| clipper.clip(plane) != Cut::Above)
}
