//! One mixed linear complementarity problem, and the methods that solve it.
//!
//! [`bodies`] holds the flat arrays of state and [`body`] what goes into them, [`rows`] turns contacts into rows of the problem that [`mlcp`] states,
//! [`pgs`] solves it, [`integrate`] moves the bodies. Nothing here knows the ECS.

pub mod bodies;
pub mod body;
pub mod integrate;
pub mod mlcp;
pub mod pgs;
pub mod rows;

use bevy_ecs::resource::Resource;
use glam::Vec3;

/// Acceleration that acts on every dynamic body, m/s2.
#[derive(Clone, Copy, Debug, PartialEq, Resource)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Gravity(pub Vec3);

impl Default for Gravity {
    /// Standard gravity along -y.
    fn default() -> Self {
        Self(Vec3::new(0.0, -9.81, 0.0))
    }
}

/// Which set the friction impulse of a point is kept in, for a normal impulse `n` and a coefficient `mu`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum FrictionModel {
    /// The disc of radius `mu n`: Coulomb's cone, the same in every direction.
    #[default]
    Disc,
    /// The square `|t1| <= mu n`, `|t2| <= mu n`: two independent bounds, as in the paper. Up to `sqrt(2)` too strong
    /// along the diagonals; 3 to 10 % off in sliding scenes.
    Box,
}

/// How the step solves contacts. The defaults are the paper's method with warm starting.
#[derive(Clone, Copy, Debug, PartialEq, Resource)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct SolverConfig {
    /// Sweeps of projected Gauss-Seidel over all rows, each step.
    pub sweeps: u32,
    /// Share of the overlap that one step removes: `beta` in the stabilisation term `zeta = -beta C / h`.
    pub baumgarte: f32,
    /// Overlap that is left alone, as a share of the smaller body's least extent, so that resting contacts stay touching.
    pub slop: f32,
    /// Fastest speed at which overlap is pushed out, m/s.
    pub push_out_speed: f32,
    /// Approach speed below which restitution is not applied, m/s; without it resting bodies would buzz.
    pub restitution_threshold: f32,
    /// Shape of the friction bound.
    pub friction_model: FrictionModel,
    /// Start each solve from the multipliers in the [`ContactCache`](crate::contact::cache::ContactCache).
    pub warm_start: bool,
    /// Measure residual, penetration and energy each step; costs one more pass over the rows. Off by default.
    pub measure_error: bool,
}

impl SolverConfig {
    /// Whether all numbers are finite and not negative.
    pub fn is_usable(&self) -> bool {
        let numbers = [
            self.baumgarte,
            self.slop,
            self.push_out_speed,
            self.restitution_threshold,
        ];
        numbers.iter().all(|n| n.is_finite() && *n >= 0.0)
    }
}

impl Default for SolverConfig {
    fn default() -> Self {
        Self {
            sweeps: 16,
            baumgarte: 0.2,
            slop: 0.002,
            push_out_speed: 3.0,
            restitution_threshold: 0.5,
            friction_model: FrictionModel::Disc,
            warm_start: true,
            measure_error: false,
        }
    }
}
