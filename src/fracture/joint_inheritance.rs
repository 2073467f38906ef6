//! Who holds on to the joints of a body that breaks: the pieces that own their anchors.

use crate::bodies::store::Bodies;
use crate::fracture::Fractures;
use crate::fracture::inheritance::ParentState;
use crate::geometry::ConvexHull;
use crate::joints::Joints;
use glam::Vec3;

impl Joints {
    /// Gives the joints of bodies that broke since this was last asked to the pieces that their anchors are in, or nearest to.
    pub(crate) fn inherit(&mut self, bodies: &mut Bodies, fractures: &Fractures) {
        if self.is_empty() {
            return;
        }
        for (parent, pieces) in fractures.handed_on() {
            for record in &mut self.list {
                for side in 0..2 {
                    if record.ends[side].is_none_or(|(_, id)| id != parent.id()) {
                        continue;
                    }
                    let frame = if side == 0 {
                        &mut record.joint.frame_a
                    } else {
                        &mut record.joint.frame_b
                    };
                    let anchor = frame.position;
                    let Some((piece, origin)) = owner(bodies, parent, pieces, anchor) else {
                        continue;
                    };
                    frame.position -= origin;
                    record.ends[side] = Some((piece, bodies.id(piece)));
                    record.is_inherited = true;
                    bodies.wake(piece);
                    self.is_outdated = true;
                }
            }
        }
    }
}

/// The piece that a point of the parent's frame is in or nearest to, and where its frame is in that of the parent, m.
fn owner(
    bodies: &Bodies,
    parent: &ParentState,
    pieces: &[u32],
    anchor: Vec3,
) -> Option<(u32, Vec3)> {
    let distance = |origin: Vec3, piece: u32| {
        let above = |hull: &ConvexHull, at: Vec3| {
            let heights = hull.faces().iter().map(|face| face.plane.distance(at));
            heights.fold(f32::NEG_INFINITY, f32::max)
        };
        let at = anchor - origin;
        if let Some(compound) = bodies.compound(piece) {
            let parts = compound.parts().iter();
            let heights =
                parts.map(|part| above(part.shape.hull(), part.pose.inverse_transform_point(at)));
            return heights.reduce(f32::min);
        }
        Some(above(bodies.convex(piece)?.hull(), at))
    };
    let mut nearest: Option<(f32, u32, Vec3)> = None;
    for &piece in pieces.iter().filter(|&&piece| bodies.contains(piece)) {
        let origin = parent.origin_of(bodies, piece);
        let Some(distance) = distance(origin, piece) else {
            continue;
        };
        if nearest.is_none_or(|(least, ..)| distance < least) {
            nearest = Some((distance, piece, origin));
        }
    }
    nearest.map(|(_, piece, origin)| (piece, origin))
}
