//! What holds two bodies together.

/// What holds two bodies together.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Bond {
    /// Tensile strength, Pa. `f32::MAX` for a joint that does not break.
    pub strength: f32,
    /// Shear strength without pressure, Pa; pressure adds friction to it.
    pub shear_strength: f32,
    /// Bonded area, m2.
    pub area: f32,
}

impl Bond {
    /// As strong in shear as in tension.
    pub fn new(strength: f32, area: f32) -> Self {
        Self {
            strength,
            shear_strength: strength,
            area,
        }
    }

    pub(super) fn check(&self) -> Result<(), BondError> {
        let is_usable = |x: f32| x.is_finite() && x > 0.0;
        if let Some(strength) = [self.strength, self.shear_strength]
            .into_iter()
            .find(|&s| !is_usable(s))
        {
            return Err(BondError::Strength { strength });
        }
        if !is_usable(self.area) {
            return Err(BondError::Area { area: self.area });
        }
        Ok(())
    }
}

/// Why a bond was not made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BondError {
    /// There is no such body.
    #[error("there is no such body")]
    NoBody,
    /// A body cannot be bonded to itself.
    #[error("a body cannot be bonded to itself")]
    SameBody,
    /// Neither body is dynamic.
    #[error("neither of the two bodies is dynamic")]
    NothingMoves,
    /// A strength is not finite and positive.
    #[error("a strength of {strength} Pa is not finite and positive")]
    Strength {
        /// Pa.
        strength: f32,
    },
    /// The pose has a number that is not finite, or a rotation that is no unit quaternion.
    #[error("the pose has a number that is not finite, or a rotation that is no unit quaternion")]
    Pose,
    /// The area is not finite and positive.
    #[error("an area of {area} m2 is not finite and positive")]
    Area {
        /// m2.
        area: f32,
    },
}
