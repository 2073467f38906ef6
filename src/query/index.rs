//! What questions are answered from besides the tree of the broad phase.
//!
//! The broad phase was told where bodies are before the last step moved them, and knows nothing of what came or was moved since. Its
//! boxes reach so far that most bodies are still inside; the few that are not are strays, and have a tree of their own.

use crate::bodies::store::Bodies;
use crate::collide::narrow_phase::NarrowPhase;
use crate::contact::pairs::broad_phase::Broadphase;
use crate::geometry::bvh::{tree_box, tree_of};
use crate::math::Aabb;
use crate::query::target::Target;
use bevy_ecs::resource::Resource;
use obvhs::bvh2::Bvh2;
use obvhs::ploc::PlocSearchDistance;

/// Where bodies are that the tree of the broad phase does not hold.
#[derive(Default, Resource)]
pub struct QueryIndex {
    half_spaces: Vec<u32>,
    strays: Vec<u32>,
    boxes: Vec<obvhs::aabb::Aabb>,
    tree: Bvh2,
}

impl std::fmt::Debug for QueryIndex {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("QueryIndex")
            .field("half_spaces", &self.half_spaces.len())
            .field("strays", &self.strays.len())
            .finish_non_exhaustive()
    }
}

impl QueryIndex {
    /// Looks where the bodies are now: 10 to 15 ns for each.
    pub(crate) fn refresh(
        &mut self,
        bodies: &Bodies,
        broadphase: &Broadphase,
        narrow: &NarrowPhase,
    ) {
        self.half_spaces.clear();
        self.strays.clear();
        self.boxes.clear();
        for slot in (0..bodies.slots() as u32).filter(|&slot| bodies.is_active(slot)) {
            let has_extent = bodies.min_extent[slot as usize] < f32::INFINITY;
            if has_extent && narrow.surely_holds(bodies, slot) {
                continue;
            }
            let Some(bounds) = Target::of(bodies, slot).bounds() else {
                self.half_spaces.push(slot);
                continue;
            };
            if !broadphase.holds(slot, bodies.id(slot), &bounds) && is_finite(&bounds) {
                self.strays.push(slot);
                self.boxes.push(tree_box(&bounds));
            }
        }
        self.tree = if self.strays.is_empty() {
            Bvh2::default()
        } else {
            tree_of(&self.boxes, PlocSearchDistance::Minimum)
        };
    }

    pub(crate) fn half_spaces(&self) -> &[u32] {
        &self.half_spaces
    }

    /// Leaves are places in [`strays`](Self::strays).
    pub(crate) fn tree(&self) -> &Bvh2 {
        &self.tree
    }

    pub(crate) fn strays(&self) -> &[u32] {
        &self.strays
    }
}

fn is_finite(b: &Aabb) -> bool {
    b.min.is_finite() && b.max.is_finite()
}
