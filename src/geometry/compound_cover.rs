//! What of a compound's parts is covered by other parts, so that nothing catches on it.
//!
//! A part's face that lies on a neighbor is inside of the body; and where the face goes on in a neighbor's, the edge between them is
//! none. Both are told apart from what is really there when a contact is found: a place and a direction on a part are admitted where
//! the surface of the whole has such a direction.
//!
//! - Along the normal of a face that is so where the face is open: what is left of it when the neighbors, a little thickened,
//!   are cut out.
//! - Along any other direction, as an edge or a corner has them, no neighbor that is at the place may reach farther: where parts
//!   go on beyond an edge, flat or upwards, the edge has no direction but those of faces.

use crate::geometry::compound_part::CompoundPart;
use crate::geometry::distance::{Separation, distance};
use crate::geometry::polygon::{Polygon, area_of, behind};
use crate::geometry::support::{Core, PlacedCore};
use crate::geometry::{ConvexHull, ConvexMesh};
use crate::math::{Aabb, Pose, rotate};
use glam::{Quat, Vec3};
use std::ops::Range;

/// Gap between parts, or step between their faces, that counts as none, as a share of the smaller part's least extent.
const GAP: f32 = 5e-4;

/// Cosine of the angle up to which a direction is that of a face: 1e-3 rad.
const SAME: f32 = 1.0 - 5e-7;

/// Share of its diagonal by which a neighbor may reach farther along a direction than the place: the same angle.
const FLAT: f32 = 1e-3;

/// Rounding of places, as a share of the neighbor's diagonal.
const ROUNDING: f32 = 1e-6;

/// What is left of a face, and less than this share of it, is rounding.
const SLIVER: f32 = 1e-5;

/// What is left of a face.
#[derive(Clone, Debug)]
pub(crate) enum Left {
    /// All of it.
    Whole,
    /// These of the polygons; nothing if it is covered.
    Some(Range<u32>),
}

/// Which parts touch which, and what of their faces is open.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cover {
    /// By part: where its neighbors begin; behind the last one, where they end.
    starts: Vec<u32>,
    neighbors: Vec<u32>,
    /// By part: its faces; none where it has no neighbors.
    faces: Vec<Range<u32>>,
    left: Vec<Left>,
    polygons: Vec<Polygon>,
    /// By part: its least extent, m.
    extents: Vec<f32>,
}

impl Cover {
    /// Of these parts; `within` visits those whose boxes meet a box.
    pub(crate) fn of(parts: &[CompoundPart], within: impl Fn(&Aabb, &mut dyn FnMut(u32))) -> Self {
        let extent = |part: &CompoundPart| part.shape.aabb().extents().min_element();
        let mut cover = Self {
            extents: parts.iter().map(extent).collect(),
            starts: vec![0],
            ..Self::default()
        };
        let mut near = Vec::new();
        for (index, part) in parts.iter().enumerate() {
            near.clear();
            let turn = glam::Mat3::from_quat(part.pose.rotation);
            let bounds = part.shape.bounds(&turn, part.pose.position);
            within(&bounds.fattened(GAP * cover.extents[index]), &mut |other| {
                near.push(other);
            });
            near.sort_unstable();
            near.retain(|&other| {
                let other = other as usize;
                other != index && parts_touch([part, &parts[other]], cover.gap(index, other))
            });
            cover.neighbors.extend_from_slice(&near);
            cover.starts.push(cover.neighbors.len() as u32);
        }
        for index in 0..parts.len() {
            cover.add_faces(parts, index);
        }
        cover
    }

    /// Of some of the parts (`parts`, which were `kept`): only those that have lost a neighbor are looked at anew. `number`: by old
    /// part, which it is now.
    pub(crate) fn subset(&self, parts: &[CompoundPart], kept: &[u32], number: &[u32]) -> Self {
        let mut cover = Self {
            extents: kept.iter().map(|&old| self.extents[old as usize]).collect(),
            starts: vec![0],
            ..Self::default()
        };
        for &old in kept {
            let neighbors = self.neighbors(old as usize).iter();
            let neighbors = neighbors.map(|&other| number[other as usize]);
            let is_kept = |other: &u32| *other != u32::MAX;
            cover.neighbors.extend(neighbors.filter(is_kept));
            cover.starts.push(cover.neighbors.len() as u32);
        }
        for (new, &old) in kept.iter().enumerate() {
            let old = old as usize;
            if cover.neighbors(new).len() == self.neighbors(old).len() {
                cover.copy_faces(self, old);
            } else {
                cover.add_faces(parts, new);
            }
        }
        cover
    }

    /// Adds the faces of a part as they are in another cover.
    fn copy_faces(&mut self, from: &Self, part: usize) {
        let first = self.left.len() as u32;
        let faces = from.faces[part].start as usize..from.faces[part].end as usize;
        for left in &from.left[faces] {
            self.left.push(match left {
                Left::Whole => Left::Whole,
                Left::Some(range) => {
                    let start = self.polygons.len() as u32;
                    let range = range.start as usize..range.end as usize;
                    self.polygons.extend_from_slice(&from.polygons[range]);
                    Left::Some(start..self.polygons.len() as u32)
                }
            });
        }
        self.faces.push(first..self.left.len() as u32);
    }

    /// Gap between two parts that counts as none, m.
    fn gap(&self, part: usize, other: usize) -> f32 {
        GAP * self.extents[part].min(self.extents[other])
    }

    /// Parts that touch or overlap a part.
    pub(crate) fn neighbors(&self, part: usize) -> &[u32] {
        let range = part..part + 2;
        match self.starts.get(range) {
            Some(&[first, end]) => &self.neighbors[first as usize..end as usize],
            _ => &[],
        }
    }

    /// What is left of a face; all of it where the part has no neighbors.
    fn left(&self, part: usize, face: usize) -> &Left {
        let faces = &self.faces[part];
        let at = faces.start as usize + face;
        let has = at < faces.end as usize;
        if has { &self.left[at] } else { &Left::Whole }
    }

    /// Whether anything of a face is open.
    pub(crate) fn is_open(&self, part: usize, face: usize) -> bool {
        match self.left(part, face) {
            Left::Whole => true,
            Left::Some(range) => !range.is_empty(),
        }
    }

    /// What is left of a face, part's frame; none where it is all of it.
    pub(crate) fn open_polygons(
        &self,
        part: usize,
        face: usize,
    ) -> Option<impl Iterator<Item = &[Vec3]>> {
        match self.left(part, face) {
            Left::Whole => None,
            Left::Some(range) => {
                let range = range.start as usize..range.end as usize;
                Some(self.polygons[range].iter().map(|polygon| &polygon[..]))
            }
        }
    }

    /// Cuts the neighbors out of the faces of a part.
    fn add_faces(&mut self, parts: &[CompoundPart], index: usize) {
        let first = self.left.len() as u32;
        let neighbors = self.starts[index] as usize..self.starts[index + 1] as usize;
        if neighbors.is_empty() {
            self.faces.push(first..first);
            return;
        }
        let part = &parts[index];
        let coverers: Vec<Coverer> = self.neighbors[neighbors]
            .iter()
            .map(|&other| {
                let (other, it) = (other as usize, &parts[other as usize]);
                Coverer {
                    hull: it.shape.hull(),
                    pose: part.pose.inverse() * it.pose,
                    gap: self.gap(index, other),
                }
            })
            .collect();
        let hull = part.shape.hull();
        for face in hull.faces() {
            let corners = hull.face_loop(face).iter();
            let whole: Polygon = corners.map(|&v| hull.vertices()[v as usize]).collect();
            let area = area_of(&whole);
            let mut open: Vec<Polygon> = vec![whole];
            let mut is_cut = false;
            for coverer in &coverers {
                let mut rest = Vec::with_capacity(open.len());
                for polygon in open.drain(..) {
                    is_cut |= subtract(polygon, face.plane.normal, coverer, &mut rest);
                }
                open = rest;
            }
            open.retain(|polygon| area_of(polygon) > SLIVER * area);
            self.left.push(if is_cut {
                let from = self.polygons.len() as u32;
                self.polygons.append(&mut open);
                Left::Some(from..self.polygons.len() as u32)
            } else {
                Left::Whole
            });
        }
        self.faces.push(first..self.left.len() as u32);
    }

    /// Whether the surface of the whole has the outward direction `normal` at a place on a part, part's frame. `overlap`: how deep
    /// another body is in there, m: so far the place may be beside what is open.
    pub(crate) fn admits(
        &self,
        parts: &[CompoundPart],
        part: usize,
        (at, normal): (Vec3, Vec3),
        overlap: f32,
    ) -> bool {
        let neighbors = self.neighbors(part);
        if neighbors.is_empty() {
            return true;
        }
        let CompoundPart { pose, shape } = &parts[part];
        if !shape.is_round()
            && let Some(face) = face_along(shape.hull(), normal)
        {
            let reach = 2.0 * GAP * self.extents[part] + overlap.max(0.0);
            return match self.open_polygons(part, face) {
                None => true,
                Some(mut open) => open.any(|polygon| is_near(polygon, normal, at, reach)),
            };
        }
        let (at, normal) = (pose.transform_point(at), rotate(pose.rotation, normal));
        neighbors.iter().all(|&other| {
            let gap = self.gap(part, other as usize);
            !goes_on(&parts[other as usize], at, normal, gap)
        })
    }
}

/// What distances read of a shape, and the radius around it, m.
pub(crate) fn core_of(shape: &ConvexMesh) -> (Core<'_>, f32) {
    match shape.round() {
        Some(round) => (round.core(), round.radius),
        None => (Core::of_hull(shape.hull()), 0.0),
    }
}

/// Whether two parts are no farther apart than `gap` (m).
fn parts_touch([a, b]: [&CompoundPart; 2], gap: f32) -> bool {
    let b_in_a = a.pose.inverse() * b.pose;
    let ((a, of_a), (b, of_b)) = (core_of(&a.shape), core_of(&b.shape));
    let most = f64::from(gap + of_a + of_b);
    match distance(&a, &PlacedCore::new(b, &b_in_a), most) {
        Separation::Far => false,
        Separation::Near(near) => near.distance <= most,
        Separation::Overlap => true,
    }
}

/// Whether a neighbor is at a place and goes on from there along a direction, compound's frame: not only far away, where it counts as flat
/// that reaches farther by little.
fn goes_on(other: &CompoundPart, at: Vec3, normal: Vec3, gap: f32) -> bool {
    let at = other.pose.inverse_transform_point(at);
    let normal = rotate(other.pose.rotation.inverse(), normal);
    let (core, radius) = core_of(&other.shape);
    let height = normal.dot(core.support(normal) - at) + radius;
    let size = other.shape.aabb();
    if height <= gap {
        return false;
    }
    let is_at = match nearest(&core, at) {
        Some((_, away)) => away <= radius + gap,
        None => true,
    };
    if !is_at || height > gap + FLAT * size.diagonal() {
        return is_at;
    }
    let ahead = at + size.extents().min_element() * normal;
    let Some((on_core, away)) = nearest(&core, ahead) else {
        return true;
    };
    let along = on_core + radius / away * (ahead - on_core) - at;
    normal.dot(along) > FLAT * along.length() + ROUNDING * size.diagonal()
}

/// The point of a core that is nearest to a place, and how far away it is, m; none if the place is inside.
fn nearest(core: &Core, at: Vec3) -> Option<(Vec3, f32)> {
    let there = Pose::new(at, Quat::IDENTITY);
    let place = PlacedCore::new(Core::of_point(Vec3::ZERO), &there);
    match distance(core, &place, f64::INFINITY) {
        Separation::Near(near) => Some((near.on_a.as_vec3(), near.distance as f32)),
        Separation::Overlap | Separation::Far => None,
    }
}

/// The face with a normal.
fn face_along(hull: &ConvexHull, normal: Vec3) -> Option<usize> {
    let faces = hull.faces().iter();
    faces
        .map(|face| face.plane.normal.dot(normal))
        .position(|along| along > SAME)
}

/// A neighbor that may cover a face.
struct Coverer<'p> {
    hull: &'p ConvexHull,
    /// In the frame of the face.
    pose: Pose,
    /// Gap that counts as none, m.
    gap: f32,
}

/// Adds to `rest` what of a polygon with this normal is not covered; whether anything is. What is covered has a neighbor just above it,
/// and not one that ends at the same height.
fn subtract(polygon: Polygon, above: Vec3, coverer: &Coverer, rest: &mut Vec<Polygon>) -> bool {
    let Coverer { hull, pose, gap } = coverer;
    let outside = rest.len();
    let mut inside = polygon.clone();
    for face in hull.faces() {
        let normal = rotate(pose.rotation, face.plane.normal);
        let offset = face.plane.offset + normal.dot(pose.position) + gap;
        let offset = offset - 2.0 * gap * normal.dot(above);
        let height = |at: Vec3| normal.dot(at) - offset;
        if inside.iter().all(|&at| height(at) <= 0.0) {
            continue;
        }
        let out = behind(&inside, |at| -height(at));
        inside = behind(&inside, height);
        if out.len() > 2 {
            rest.push(out);
        }
        if inside.len() < 3 {
            rest.truncate(outside);
            rest.push(polygon);
            return false;
        }
    }
    true
}

/// Whether a place is no farther than `reach` (m) from a convex polygon with a normal.
fn is_near(polygon: &[Vec3], normal: Vec3, at: Vec3, reach: f32) -> bool {
    let count = polygon.len();
    let mut is_inside = true;
    let mut nearest = f32::INFINITY;
    for i in 0..count {
        let (from, to) = (polygon[i], polygon[(i + 1) % count]);
        let (along, offset) = (to - from, at - from);
        is_inside &= along.cross(normal).dot(offset) <= 0.0;
        let share = along.dot(offset) / along.length_squared().max(f32::MIN_POSITIVE);
        let to_edge = offset - share.clamp(0.0, 1.0) * along;
        nearest = nearest.min(to_edge.reject_from_normalized(normal).length_squared());
    }
    is_inside || nearest <= reach * reach
}
