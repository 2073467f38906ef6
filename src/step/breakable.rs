//! What of a scene changes where bodies break.

use crate::contact::impulses::ContactCache;
use crate::fracture::{Bonds, Fractures};
use crate::joints::Joints;

/// What a body that breaks hands on to its pieces.
#[derive(Debug)]
pub struct Breakable<'s> {
    /// Its contacts' multipliers.
    pub cache: &'s mut ContactCache,
    /// What waits to break, and what broke.
    pub fractures: &'s mut Fractures,
    /// Its bonds.
    pub bonds: &'s mut Bonds,
    /// Its joints.
    pub joints: &'s mut Joints,
}

impl Breakable<'_> {
    /// The same, for a part of the step.
    pub(super) fn again(&mut self) -> Breakable<'_> {
        Breakable {
            cache: self.cache,
            fractures: self.fractures,
            bonds: self.bonds,
            joints: self.joints,
        }
    }
}
