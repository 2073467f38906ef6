//! The way out where noise near the plane leaves no simple rim: the parts as convex hulls of their points.

use crate::geometry::hull::hull_unless_flat;
use crate::geometry::{ConvexHull, HullError};
use crate::slice::SliceError;
use crate::slice::convex::HullHalves;
use crate::slice::convex::classes::{ABOVE, BELOW};
use crate::slice::cut::Cut;
use glam::Vec3;

/// Fills `halves` with the hulls of the points on each side, or with `hull` if a part is too thin for a hull, which is
/// then no part.
pub(super) fn rebuild(
    hull: &ConvexHull,
    sides: &[u8],
    cuts: &[Vec3],
    halves: &mut HullHalves,
) -> Result<Cut, SliceError> {
    *halves = HullHalves::copies_of(hull);
    let (below, above) = (
        hull_without(hull, sides, cuts, ABOVE)?,
        hull_without(hull, sides, cuts, BELOW)?,
    );
    Ok(match (below, above) {
        (Some(below), Some(above)) => {
            *halves = HullHalves { below, above };
            Cut::Cut(())
        }
        (Some(_), None) => Cut::Below,
        (None, _) => Cut::Above,
    })
}

fn hull_without(
    hull: &ConvexHull,
    sides: &[u8],
    cuts: &[Vec3],
    dropped: u8,
) -> Result<Option<ConvexHull>, HullError> {
    let kept = hull.vertices.iter().zip(sides);
    let points: Vec<Vec3> = kept
        .filter(|&(_, &side)| side != dropped)
        .map(|(&point, _)| point)
        .chain(cuts.iter().copied())
        .collect();
    hull_unless_flat(&points)
}
