//! What a plane does to a shape.

/// What a plane does to a shape, and if it cuts it, what of the result: the parts, or nothing where they are written
/// elsewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut<T = ()> {
    /// Missed: at least one vertex is below the plane and none is above, or what is above is too thin to be a body.
    Below,
    /// Missed: no vertex is below the plane, or what is below is too thin to be a body.
    Above,
    /// Cut in two.
    Cut(T),
}

impl Cut {
    /// Whether the plane cuts the shape.
    pub fn is_cut(self) -> bool {
        self == Self::Cut(())
    }
}

impl<T> Cut<T> {
    /// The same with something else of the result.
    pub fn map<U>(self, of: impl FnOnce(T) -> U) -> Cut<U> {
        match self {
            Self::Below => Cut::Below,
            Self::Above => Cut::Above,
            Self::Cut(result) => Cut::Cut(of(result)),
        }
    }
}

impl<T> Cut<Box<T>> {
    /// The two parts, if there are two.
    pub fn halves(self) -> Option<T> {
        match self {
            Self::Cut(halves) => Some(*halves),
            Self::Below | Self::Above => None,
        }
    }
}
