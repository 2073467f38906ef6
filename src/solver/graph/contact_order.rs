//! In which order the contacts of an island are solved.

/// How manifolds are put into blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum ContactOrder {
    /// Kept where that fills at least half of the lanes, else by colors.
    #[default]
    Automatic,
    /// In their order: a sweep carries support up through a whole stack that was built from the ground.
    Ordered,
    /// By colors: those of one color share no body. Blocks are full and few, and a sweep carries support from a body to its
    /// neighbors only.
    Colored,
}
