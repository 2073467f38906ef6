//! Surface and bulk properties of a body, and the rules that make one number of two bodies' values.

use bevy_ecs::component::Component;

/// How the coefficients of two touching bodies become one.
///
/// If the two bodies ask for different rules, the later one in this list wins. The default is that of Avian and Rapier, so that numbers may
/// be brought along. Box2D and Jolt take the geometric mean of frictions and the larger restitution: a ball that is to rebound from
/// any floor as from one of its own kind asks for `Max`, ice for `Min`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum CombineRule {
    /// `(a + b) / 2`; the default.
    #[default]
    Average,
    /// `sqrt(a b)`.
    GeometricMean,
    /// The smaller of the two.
    Min,
    /// `a b`.
    Multiply,
    /// The larger of the two.
    Max,
}

impl CombineRule {
    /// The combined coefficient.
    pub fn apply(self, a: f32, b: f32) -> f32 {
        match self {
            Self::Average => 0.5 * (a + b),
            Self::GeometricMean => (a * b).sqrt(),
            Self::Min => a.min(b),
            Self::Multiply => a * b,
            Self::Max => a.max(b),
        }
    }
}

/// Why a material is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MaterialError {
    /// Friction is negative, NaN or infinite.
    #[error("the coefficient of friction must be finite and not negative, got {0}")]
    Friction(f32),
    /// Restitution is outside 0 to 1, or NaN.
    #[error("the coefficient of restitution must lie between 0 and 1, got {0}")]
    Restitution(f32),
    /// Density is zero, negative, NaN or infinite.
    #[error("density must be finite and positive, got {0} kg/m3")]
    Density(f32),
}

/// Coulomb friction of a body's surface: the friction force is at most `coefficient` times the normal force.
#[derive(Clone, Copy, Debug, PartialEq, Component)]
#[component(summary_tick)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Friction {
    /// Coefficient, 0 (ice) upwards; 0.5 unless given.
    pub coefficient: f32,
    /// How it combines with the other body's.
    pub combine: CombineRule,
}

impl Default for Friction {
    /// 0.5, averaged.
    fn default() -> Self {
        Self::new(0.5)
    }
}

impl Friction {
    /// A coefficient that is averaged with the other body's.
    pub const fn new(coefficient: f32) -> Self {
        Self {
            coefficient,
            combine: CombineRule::Average,
        }
    }

    /// The same coefficient with another rule.
    pub const fn with_combine(self, combine: CombineRule) -> Self {
        Self { combine, ..self }
    }

    /// The coefficient of two touching surfaces.
    pub fn combined(&self, other: &Self) -> f32 {
        self.combine
            .max(other.combine)
            .apply(self.coefficient, other.coefficient)
    }

    /// Whether the value can be used.
    ///
    /// # Errors
    /// [`MaterialError::Friction`] unless finite and at least 0.
    pub fn validate(&self) -> Result<(), MaterialError> {
        if self.coefficient.is_finite() && self.coefficient >= 0.0 {
            Ok(())
        } else {
            Err(MaterialError::Friction(self.coefficient))
        }
    }
}

/// Newton's restitution of a body's surface: separation speed over approach speed.
#[derive(Clone, Copy, Debug, PartialEq, Component)]
#[component(summary_tick)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Restitution {
    /// Coefficient, 0 (clay) to 1 (no loss); 0 unless given.
    pub coefficient: f32,
    /// How it combines with the other body's.
    pub combine: CombineRule,
}

impl Default for Restitution {
    /// 0, averaged.
    fn default() -> Self {
        Self::new(0.0)
    }
}

impl Restitution {
    /// A coefficient that is averaged with the other body's.
    pub const fn new(coefficient: f32) -> Self {
        Self {
            coefficient,
            combine: CombineRule::Average,
        }
    }

    /// The same coefficient with another rule.
    pub const fn with_combine(self, combine: CombineRule) -> Self {
        Self { combine, ..self }
    }

    /// The coefficient of two touching surfaces.
    pub fn combined(&self, other: &Self) -> f32 {
        self.combine
            .max(other.combine)
            .apply(self.coefficient, other.coefficient)
    }

    /// Whether the value can be used.
    ///
    /// # Errors
    /// [`MaterialError::Restitution`] unless between 0 and 1.
    pub fn validate(&self) -> Result<(), MaterialError> {
        if (0.0..=1.0).contains(&self.coefficient) {
            Ok(())
        } else {
            Err(MaterialError::Restitution(self.coefficient))
        }
    }
}

/// Density of a body, kg/m3.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Component)]
#[component(summary_tick)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Density(pub f32);

impl Default for Density {
    /// Water: 1000 kg/m3.
    fn default() -> Self {
        Self(1000.0)
    }
}

impl Density {
    /// Whether the value can be used.
    ///
    /// # Errors
    /// [`MaterialError::Density`] unless finite and positive.
    pub fn validate(&self) -> Result<(), MaterialError> {
        if self.0.is_finite() && self.0 > 0.0 {
            Ok(())
        } else {
            Err(MaterialError::Density(self.0))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rule_with_the_higher_priority_wins_in_either_order() {
        let a = Friction::new(0.2).with_combine(CombineRule::Min);
        let b = Friction::new(0.8).with_combine(CombineRule::Max);
        assert_eq!(a.combined(&b), 0.8);
        assert_eq!(b.combined(&a), 0.8);
        assert_eq!(a.combined(&Friction::new(0.8)), 0.2);
    }

    #[test]
    fn rules_are_what_their_names_say() {
        let combined = |rule: CombineRule| rule.apply(0.25, 1.0);
        assert_eq!(combined(CombineRule::Average), 0.625);
        assert_eq!(combined(CombineRule::GeometricMean), 0.5);
        assert_eq!(combined(CombineRule::Min), 0.25);
        assert_eq!(combined(CombineRule::Multiply), 0.25);
        assert_eq!(combined(CombineRule::Max), 1.0);
    }

    #[test]
    fn values_without_meaning_are_refused() {
        for bad in [-0.1, f32::NAN, f32::INFINITY] {
            assert!(Friction::new(bad).validate().is_err());
            assert!(Restitution::new(bad).validate().is_err());
            assert!(Density(bad).validate().is_err());
        }
        assert_eq!(
            Restitution::new(1.5).validate(),
            Err(MaterialError::Restitution(1.5))
        );
        assert!(Density(0.0).validate().is_err());
        assert!(Friction::new(3.0).validate().is_ok());
        assert!(Restitution::new(1.0).validate().is_ok());
        assert!(Density::default().validate().is_ok());
    }
}
