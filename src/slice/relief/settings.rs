//! What the relief of a cut face is.

/// Relief of the faces that cracks and cuts leave: broken rather than sawn.
///
/// The faces are moved off their planes by at most [`amplitude`](Self::amplitude), both sides of a crack by the same, so that pieces fit each
/// other and their meshes stay closed. Where faces meet each other or the outer skin they stay as they are. Only what is drawn
/// changes: the hull that collides stays flat.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Relief {
    /// Farthest that a face is moved off its plane, m. Less near its rim, and where the piece is thin.
    pub amplitude: f32,
    /// Size of the bumps, m: three triangles fit in one, so that the number of triangles grows with the inverse of its square.
    pub wavelength: f32,
}

impl Relief {
    /// Bumps of a size, a fifth as high (m).
    pub fn of_size(wavelength: f32) -> Self {
        Self {
            amplitude: 0.2 * wavelength,
            wavelength,
        }
    }

    /// Whether both lengths are positive and finite.
    pub(crate) fn is_usable(&self) -> bool {
        let is_length = |value: f32| value.is_finite() && value > 0.0;
        is_length(self.amplitude) && is_length(self.wavelength)
    }
}
