//! Who holds on to the neighbors of a body that breaks: the pieces that lie on them.

use crate::bodies::store::Bodies;
use crate::fracture::bonded_pair::BondedPair;
use crate::fracture::bonds::Bonds;
use crate::fracture::inheritance::ParentState;
use crate::fracture::neighbors::area_in_pose;
use crate::math::Pose;
use smallvec::SmallVec;

impl Bonds {
    /// Divides the bonds of a body that is gone, each among the pieces that lie face to face on the bonded neighbor: by the
    /// areas over which they do, so that all of them together are as strong as it was. A bond that no piece lies at goes.
    pub(super) fn inherit(&mut self, bodies: &Bodies, parent: &ParentState, pieces: &[u32]) {
        let is_of_parent =
            |joint: &BondedPair| [joint.bodies.0, joint.bodies.1].contains(&parent.id());
        if !self.joints.iter().any(is_of_parent) {
            return;
        }
        let mut children: Vec<BondedPair> = Vec::new();
        for joint in self.joints.iter().filter(|joint| is_of_parent(joint)) {
            let is_first = joint.bodies.0 == parent.id();
            let other = joint.slots[usize::from(is_first)];
            if joint.is_loose || !bodies.contains(other) {
                continue;
            }
            let other_in_parent = if is_first {
                joint.b_in_a
            } else {
                joint.b_in_a.inverse()
            };
            // As they were bonded: since then, both may have moved a little.
            let places = pieces.iter().filter_map(|&piece| {
                let origin = parent.origin_of(bodies, piece);
                let pose = Pose::new(other_in_parent.position - origin, other_in_parent.rotation);
                let area = area_in_pose(bodies, piece, other, &pose)?;
                Some((piece, pose, area))
            });
            let places: SmallVec<[(u32, Pose, f32); 4]> = places.collect();
            let whole: f32 = places.iter().map(|(_, _, area)| area).sum();
            children.extend(places.into_iter().map(|(piece, pose, area)| {
                joint.between(bodies, [piece, other], pose, area / whole)
            }));
        }
        self.joints.retain(|joint| !is_of_parent(joint));
        self.joints.append(&mut children);
        self.joints.sort_by_key(|joint| joint.bodies);
    }
}

impl BondedPair {
    /// A share of a joint for two bodies; `pose` is that of the second in the frame of the first.
    fn between(&self, bodies: &Bodies, slots: [u32; 2], pose: Pose, share: f32) -> Self {
        let [i, j] = slots.map(|slot| bodies.id(slot));
        let (bodies, slots, b_in_a) = if i < j {
            ((i, j), slots, pose)
        } else {
            ((j, i), [slots[1], slots[0]], pose.inverse())
        };
        let mut bond = self.bond;
        bond.area *= share;
        Self {
            bodies,
            slots,
            bond,
            b_in_a,
            ..*self
        }
    }
}
