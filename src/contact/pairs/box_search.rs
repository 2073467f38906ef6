//! Who is near a box, for those who ask without being a body that collides.

use crate::contact::pairs::broad_phase::Broadphase;
use crate::geometry::bvh::within;
use crate::math::Aabb;

impl Broadphase {
    /// Appends to `found` the slots whose kept boxes overlap `region`, in no order, and those of all half-spaces.
    pub(crate) fn search_box(&self, region: &Aabb, found: &mut Vec<u32>) {
        found.extend_from_slice(&self.half_spaces);
        within(self.tree(), region, |slot| found.push(slot));
    }
}
