//! What makes a body breakable: strength, pattern, and limits for the pieces.

use super::pattern::FracturePattern;
use bevy_ecs::component::Component;
use glam::Vec4;

/// Makes a body break when it is hit hard enough.
#[derive(Clone, Copy, Debug, PartialEq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Fracturable {
    /// The body breaks when its contact impulses of one step, summed over all contacts, exceed this; N s.
    pub strength: f32,
    /// Through which planes it breaks.
    pub pattern: FracturePattern,
    /// Pieces smaller than this are not spawned, and the ledger says so; m3.
    pub least_volume: f32,
    /// How many times a piece may break again. At 0 the pieces are ordinary bodies.
    pub generations: u8,
    /// Start of the random numbers of the pattern; the same seed gives the same pieces.
    pub seed: u64,
    /// Colour of the cut faces; `None` carries the surface's colours over the rim.
    pub cut_colour: Option<Vec4>,
}

impl Default for Fracturable {
    /// Breaks at 100 N s by the paper's single plane, pieces break once more, nothing under a cubic centimetre.
    fn default() -> Self {
        Self {
            strength: 100.0,
            pattern: FracturePattern::default(),
            least_volume: 1e-6,
            generations: 1,
            seed: 0,
            cut_colour: None,
        }
    }
}

/// Why a [`Fracturable`] is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FracturableError {
    /// The strength is negative or NaN.
    #[error("the strength must not be negative, got {0} N s")]
    Strength(f32),
    /// The least volume is negative, infinite or NaN.
    #[error("the least volume must be finite and not negative, got {0} m3")]
    LeastVolume(f32),
}

impl Fracturable {
    /// Whether the values can be used. An infinite strength means that only cuts on request are made.
    ///
    /// # Errors
    /// [`FracturableError`] says which value is not.
    pub fn validate(&self) -> Result<(), FracturableError> {
        if self.strength.is_nan() || self.strength < 0.0 {
            return Err(FracturableError::Strength(self.strength));
        }
        if !(self.least_volume.is_finite() && self.least_volume >= 0.0) {
            return Err(FracturableError::LeastVolume(self.least_volume));
        }
        Ok(())
    }

    /// Breaks at `strength` (N s); everything else as by default.
    pub fn with_strength(strength: f32) -> Self {
        Self {
            strength,
            ..Self::default()
        }
    }

    /// What piece number `index` inherits: one generation less, random numbers of its own.
    pub(crate) fn for_piece(self, index: usize) -> Option<Self> {
        let generations = self.generations.checked_sub(1)?;
        // Weyl step with the golden ratio, as in SplitMix64: distinct streams for distinct pieces.
        let seed = self
            .seed
            .wrapping_mul(31)
            .wrapping_add((index as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
        Some(Self {
            generations,
            seed,
            ..self
        })
    }
}
