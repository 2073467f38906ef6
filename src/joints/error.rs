//! Why a joint is not usable.

/// Why a joint is not usable.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum JointError {
    /// There is no such body.
    #[error("there is no such body")]
    NoBody,
    /// A body cannot be joined to itself.
    #[error("a body cannot be joined to itself")]
    SameBody,
    /// Neither body is dynamic.
    #[error("neither of the two bodies is dynamic")]
    NothingMoves,
    /// A frame or a target is NaN or infinite.
    #[error("{0} is not finite")]
    NotFinite(&'static str),
    /// The axis of a joint is zero, or the rotation of a frame no unit quaternion.
    #[error("the rotation of a frame is not a unit quaternion (length {length}); is an axis zero?")]
    Axis {
        /// Length of the quaternion.
        length: f32,
    },
    /// A range is upside down or not finite.
    #[error("a range from {min} to {max} is empty or not finite")]
    Range {
        /// m or rad.
        min: f32,
        /// m or rad.
        max: f32,
    },
    /// A spring, friction, restitution, or a force is negative or not finite.
    #[error("a coefficient of {number} is negative or not finite")]
    Coefficient {
        /// As given.
        number: f32,
    },
}
