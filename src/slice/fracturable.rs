//! What makes a body breakable: strength, pattern, and limits for the pieces.

use crate::geometry::ConvexHull;
use crate::slice::SliceOptions;
use crate::slice::crack_area::cells_for_energy;
use crate::slice::cutting::Cutting;
use crate::slice::pattern::{FracturePattern, Impact};
use crate::slice::relief::settings::Relief;
use crate::slice::roughen::CutLooks;
use bevy_ecs::component::Component;
use glam::Vec4;

/// Makes a body break when it is hit hard enough: a dynamic one, and one that stands or is moved, of which the component `Anchors`
/// says which pieces stay.
#[derive(Clone, Debug, PartialEq, Component)]
#[component(summary_tick)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Fracturable {
    /// The body breaks when a blow exceeds this, N s: its contact impulses of one step, summed over all contacts, as far as they
    /// are more than what the same contacts bore in the step before. What rests on it is no blow, whatever it weighs. On a body
    /// that contacts do not move, the contacts of each island count by themselves.
    pub strength: f32,
    /// The energy that the impact must have besides; J. 0 leaves it to the strength alone.
    pub min_energy: f32,
    /// How it breaks.
    pub pattern: FracturePattern,
    /// Energy that it takes to make cracks, J per m2 of crack: the harder the impact, the more pieces, and none if it
    /// does not pay for one crack. At 0 there are as many pieces as the pattern says.
    ///
    /// The energy release rate of fracture mechanics is about 10 for glass, 100 for concrete. Much of an impact goes
    /// elsewhere, so larger values look right.
    pub toughness: f32,
    /// Most pieces that one impact makes.
    pub max_pieces: u16,
    /// Pieces smaller than this are not spawned, and the ledger says so; m3.
    pub min_volume: f32,
    /// How many times a piece may break again. At 0 the pieces are ordinary bodies; cuts of them that are asked for look as these do.
    pub generations: u8,
    /// Start of the random numbers of the pattern; the same seed gives the same pieces.
    pub seed: u64,
    /// Color of the cut faces; `None` carries the surface's colors over the rim.
    pub cut_color: Option<Vec4>,
    /// Material slot of the cut faces (see [`TriMesh::materials`](crate::geometry::TriMesh::materials)); `None` for no
    /// slots, or 0 if the mesh has some. A body without a visual mesh of its own gets the mesh of its hull when it is cut.
    pub cut_material: Option<u16>,
    /// Relief of the cut faces, from the [`seed`](Self::seed); `None` leaves them flat. A body without a visual mesh of its own gets the
    /// mesh of its hull when it breaks. Only what is drawn changes, and with it the mass only of what weighs as its
    /// mesh does ([`with_mass_of_visual`](crate::geometry::ConvexMesh::with_mass_of_visual)).
    pub cut_relief: Option<Relief>,
    /// Whether pieces whose visual meshes are in several parts come apart, as [`PieceCutter::separate`] says. To be switched off
    /// for models that are built of parts which only touch and are to hold together.
    ///
    /// [`PieceCutter::separate`]: crate::slice::PieceCutter::separate
    pub separate_parts: bool,
}

impl Default for Fracturable {
    /// Breaks at 100 N s by the paper's single plane, pieces break once more, nothing under a cubic centimetre.
    fn default() -> Self {
        Self {
            strength: 100.0,
            min_energy: 0.0,
            pattern: FracturePattern::default(),
            toughness: 0.0,
            max_pieces: 256,
            min_volume: 1e-6,
            generations: 1,
            seed: 0,
            cut_color: None,
            cut_material: None,
            cut_relief: None,
            separate_parts: true,
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
    /// The least energy is negative or NaN.
    #[error("the least energy must not be negative, got {0} J")]
    LeastEnergy(f32),
    /// The toughness is negative or NaN.
    #[error("the toughness must not be negative, got {0} J/m2")]
    Toughness(f32),
    /// The least volume is negative, infinite or NaN.
    #[error("the least volume must be finite and not negative, got {0} m3")]
    LeastVolume(f32),
    /// A length of the relief is not positive, infinite or NaN.
    #[error("amplitude and wavelength of the relief must be positive and finite, got {} and {} m", .0.amplitude, .0.wavelength)]
    Relief(Relief),
}

impl Fracturable {
    /// Whether the values can be used. An infinite strength means that only cuts on request are made.
    ///
    /// # Errors
    /// [`FracturableError`] says which value is not.
    pub fn validate(&self) -> Result<(), FracturableError> {
        let is_negative = |value: f32| value.is_nan() || value < 0.0;
        if is_negative(self.strength) {
            return Err(FracturableError::Strength(self.strength));
        }
        if is_negative(self.min_energy) {
            return Err(FracturableError::LeastEnergy(self.min_energy));
        }
        if is_negative(self.toughness) {
            return Err(FracturableError::Toughness(self.toughness));
        }
        if !(self.min_volume.is_finite() && self.min_volume >= 0.0) {
            return Err(FracturableError::LeastVolume(self.min_volume));
        }
        if let Some(relief) = self.cut_relief.filter(|relief| !relief.is_usable()) {
            return Err(FracturableError::Relief(relief));
        }
        Ok(())
    }

    /// Whether a blow can make two pieces of a body, by the numbers that are said. With an infinite strength only cuts on request
    /// are made, whatever the pattern is.
    pub(crate) fn makes_pieces(&self) -> bool {
        let has_two = match &self.pattern {
            FracturePattern::Voronoi { cells, .. } | FracturePattern::EvenVoronoi { cells } => {
                *cells >= 2
            }
            FracturePattern::Slabs { count } => *count >= 2,
            FracturePattern::Brick { size } => size.is_finite() && size.min_element() > 0.0,
            FracturePattern::Planes(planes) => !planes.is_empty(),
            _ => true,
        };
        self.strength.is_infinite() || has_two && self.max_pieces >= 2
    }

    /// Breaks at `strength` (N s); everything else as by default.
    pub fn with_strength(strength: f32) -> Self {
        Self {
            strength,
            ..Self::default()
        }
    }

    /// As this, but breaking by `pattern`.
    pub fn with_pattern(self, pattern: FracturePattern) -> Self {
        Self { pattern, ..self }
    }

    /// As this, but with a number of pieces that follows the energy of the impact, at `toughness` (J per m2 of crack), up
    /// to `max_pieces`.
    pub fn with_toughness(self, toughness: f32, max_pieces: u16) -> Self {
        Self {
            toughness,
            max_pieces,
            ..self
        }
    }

    /// As this, but with cut faces that have a relief.
    pub fn with_relief(self, relief: Relief) -> Self {
        Self {
            cut_relief: Some(relief),
            ..self
        }
    }

    /// How a body with this hull (body frame) breaks under `impact`, into at most `most` pieces; nothing if it bears it.
    pub fn cutting(&self, impact: &Impact, hull: &ConvexHull, most: u32) -> Option<Cutting> {
        let is_enough = impact.impulse > self.strength && impact.energy >= self.min_energy;
        if !is_enough {
            return None;
        }
        let most = most.min(self.max_pieces.into());
        let affordable = if self.toughness > 0.0 {
            cells_for_energy(impact.energy.into(), self.toughness.into(), hull)
        } else {
            most
        };
        self.pattern
            .cutting(impact, hull, self.seed, most.min(affordable))
    }

    /// What the faces of its cuts look like.
    pub(crate) fn cut_looks(&self) -> CutLooks {
        CutLooks {
            options: SliceOptions {
                cap_color: self.cut_color,
                cap_material: self.cut_material,
                ..SliceOptions::default()
            },
            relief: self.cut_relief.map(|relief| (relief, self.seed)),
            keeps_parts: !self.separate_parts,
        }
    }

    /// What piece number `index` inherits: one generation less, random numbers of its own.
    pub(crate) fn for_piece(&self, index: usize) -> Option<Self> {
        let generations = self.generations.checked_sub(1)?;
        // Weyl step with the golden ratio, as in SplitMix64: distinct streams for distinct pieces.
        let seed = self
            .seed
            .wrapping_mul(31)
            .wrapping_add((index as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
        Some(Self {
            generations,
            seed,
            ..self.clone()
        })
    }
}
