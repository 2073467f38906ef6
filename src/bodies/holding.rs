//! How bodies that stand hold on to the world, and how they come to fall.

use crate::bodies::anchors::{Anchors, Hold};
use crate::bodies::body::{BodyError, RigidBody};
use crate::bodies::store::Bodies;

impl Bodies {
    /// Where the body was said to hold on to the world.
    pub fn anchors(&self, slot: u32) -> Option<&Anchors> {
        self.hold(slot)?.anchors.as_ref()
    }

    /// Says where the body holds on to the world, or takes that back. Nothing comes of it while the body is dynamic.
    ///
    /// # Errors
    /// [`BodyError::Anchors`] if the numbers mean nothing; it holds on as before then.
    pub fn set_anchors(&mut self, slot: u32, anchors: Option<Anchors>) -> Result<(), BodyError> {
        anchors.iter().try_for_each(Anchors::validate)?;
        if self.anchors(slot) != anchors.as_ref() {
            self.hold_mut(slot).anchors = anchors;
            self.doubt_holds(slot);
        }
        Ok(())
    }

    /// What is known of how the body holds on.
    pub(crate) fn hold(&self, slot: u32) -> Option<&Hold> {
        self.holds.get(slot as usize)?.as_deref()
    }

    /// The same, to be changed.
    pub(crate) fn hold_mut(&mut self, slot: u32) -> &mut Hold {
        let needed = self.holds.len().max(slot as usize + 1);
        self.holds.resize(needed, None);
        self.holds[slot as usize].get_or_insert_default()
    }

    /// Makes a body dynamic that has lost what it held on to, and gives it its mass.
    pub(crate) fn let_fall(&mut self, slot: u32) {
        if self.set_kind(slot, RigidBody::Dynamic).is_ok() {
            // What stood had a mass already.
            let _ = self.refresh_mass(slot);
            let entry = self.stale_mass.pop();
            debug_assert_eq!(entry, Some(slot));
            self.hold_mut(slot).anchors = None;
        }
    }
}
