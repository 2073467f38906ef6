//! Who holds on to the joints of a body that breaks: the pieces that own their anchors.

use crate::bodies::store::Bodies;
use crate::fracture::Fractures;
use crate::fracture::inheritance::ParentState;
use crate::joints::Joints;
use glam::Vec3;

impl Joints {
    /// Gives the joints of bodies that broke since this was last asked to the pieces that their anchors are in, or nearest to, with
    /// their multipliers.
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
        let faces = bodies.convex(piece)?.hull().faces().iter();
        let above = faces.map(|face| face.plane.distance(anchor - origin));
        Some(above.fold(f32::NEG_INFINITY, f32::max))
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
