//! Who holds on to the neighbours of a body that breaks: the pieces that lie on them.

use super::bonds::{Bonds, Joint};
use super::inheritance::Line;
use super::neighbours::touching_area;
use crate::math::Pose;
use crate::solver::bodies::Bodies;
use glam::Quat;
use smallvec::SmallVec;

impl Bonds {
    /// Divides the bonds of a body that is gone, each among the pieces that lie face to face on the bonded neighbour: by the
    /// areas over which they do, so that all of them together are as strong as it was. A bond that no piece lies at goes.
    pub(super) fn inherit(&mut self, bodies: &Bodies, parent: &Line, pieces: &[u32]) {
        let is_of_parent = |joint: &Joint| [joint.bodies.0, joint.bodies.1].contains(&parent.id());
        if !self.joints.iter().any(is_of_parent) {
            return;
        }
        let mut heirs: Vec<Joint> = Vec::new();
        for joint in self.joints.iter().filter(|joint| is_of_parent(joint)) {
            let is_first = joint.bodies.0 == parent.id();
            let other = joint.slots[usize::from(is_first)];
            if joint.is_loose || !bodies.contains(other) {
                continue;
            }
            let area = |&piece: &u32| Some((piece, touching_area(bodies, piece, other)?));
            let areas: SmallVec<[(u32, f32); 4]> = pieces.iter().filter_map(area).collect();
            let whole: f32 = areas.iter().map(|(_, area)| area).sum();
            heirs.extend(areas.into_iter().map(|(piece, area)| {
                let piece_in_parent = Pose::new(parent.origin_of(bodies, piece), Quat::IDENTITY);
                joint.handed_to(bodies, is_first, piece, &piece_in_parent, area / whole)
            }));
        }
        self.joints.retain(|joint| !is_of_parent(joint));
        self.joints.append(&mut heirs);
        self.joints.sort_by_key(|joint| joint.bodies);
    }
}

impl Joint {
    /// The share of a joint that goes to a piece of its first or its second body.
    fn handed_to(
        &self,
        bodies: &Bodies,
        is_first: bool,
        piece: u32,
        piece_in_parent: &Pose,
        share: f32,
    ) -> Self {
        let piece_id = bodies.id(piece);
        let mut bond = self.bond;
        bond.area *= share;
        let (other, other_in_parent) = if is_first {
            ((self.bodies.1, self.slots[1]), self.b_in_a)
        } else {
            ((self.bodies.0, self.slots[0]), self.b_in_a.inverse())
        };
        let other_in_piece = between(piece_in_parent, &other_in_parent);
        let ids = if piece_id < other.0 {
            (piece_id, other.0)
        } else {
            (other.0, piece_id)
        };
        let (slots, b_in_a) = if piece_id < other.0 {
            ([piece, other.1], other_in_piece)
        } else {
            ([other.1, piece], other_in_piece.inverse())
        };
        Self {
            bodies: ids,
            slots,
            bond,
            b_in_a,
            ..*self
        }
    }
}

/// A pose as seen from another one, both given in the same frame.
fn between(frame: &Pose, pose: &Pose) -> Pose {
    Pose::new(
        frame.inverse_transform_point(pose.position),
        frame.rotation.inverse() * pose.rotation,
    )
}
