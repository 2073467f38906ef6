//! What a user may choose: gravity, the method, its effort, and when islands sleep.

use crate::simd::lanes::LaneWidth;
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

/// How the rows of a sub-step are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum Method {
    /// Soft contacts, a sweep with position bias before the bodies move and one without after it.
    #[default]
    SoftStep,
    /// Projected Gauss-Seidel with a Baumgarte term: the paper's method.
    Pgs,
    /// To rounding in double precision, whatever it takes: the judge of the others, and for small scenes that must be right.
    Exact,
}

/// How the step solves contacts. The figures that decided the defaults are in `docs/decisions.md` and `docs/report/`.
#[derive(Clone, Copy, Debug, PartialEq, Resource)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct SolverConfig {
    /// What solves the rows of a sub-step.
    pub method: Method,
    /// Least number of parts that each step is solved and integrated in; contact geometry is found once per step.
    pub substeps: u32,
    /// Most parts. An island takes as many as keep the sag of its soft contacts below [`sag`](Self::sag) under the load that
    /// they bore in the last step ([`Method::SoftStep`] only).
    pub max_substeps: u32,
    /// How far a soft contact may give way under a resting load, as a share of the smaller body's least extent.
    pub sag: f32,
    /// Sweeps over all rows in each sub-step, before the bodies move; the exact method needs none.
    pub sweeps: u32,
    /// Sweeps without position bias in each sub-step, after the bodies have moved ([`Method::SoftStep`] only).
    pub relax_sweeps: u32,
    /// Natural frequency of soft contacts as a share of the sub-step rate ([`Method::SoftStep`] only).
    pub contact_frequency: f32,
    /// Damping ratio of soft contacts ([`Method::SoftStep`] only).
    pub damping_ratio: f32,
    /// Share of the overlap that one sub-step removes: `beta` in the stabilisation term `zeta = -beta C / h`.
    pub baumgarte: f32,
    /// Overlap that is left alone, as a share of the smaller body's least extent, so that resting contacts stay touching.
    pub slop: f32,
    /// Fastest speed at which overlap is pushed out, m/s.
    pub push_out_speed: f32,
    /// Approach speed below which restitution is not applied, m/s; without it resting bodies would buzz.
    pub restitution_threshold: f32,
    /// Shape of the friction bound.
    pub friction_model: FrictionModel,
    /// Start each solve from the multipliers in the [`ContactCache`](crate::contact::impulses::ContactCache).
    pub warm_start: bool,
    /// Largest velocity change, m/s, that a sweep may still make to bodies of 1 m when the sweeps of a sub-step end; for other
    /// sizes it grows with the square root of the least extent, as speeds under gravity do. Where bodies move, a hundredth of the
    /// fastest one's speed is enough. Each island goes on until it is met, or [`max_sweeps`](Self::max_sweeps) or
    /// [`max_extra_updates`](Self::max_extra_updates) are done; the report names islands that are left above it. `None`: no more sweeps
    /// than the least numbers.
    pub tolerance: Option<f32>,
    /// Most sweeps of a sub-step, before and after the bodies move each, with a [`tolerance`](Self::tolerance).
    pub max_sweeps: u32,
    /// Most updates of contact points that an island's sweeps beyond the least numbers may take in a step: small islands are
    /// solved to the tolerance, and a heap of thousands costs what it may. 30 000 are about a millisecond.
    pub max_extra_updates: u32,
    /// In which order the contacts of an island are solved.
    pub order: ContactOrder,
    /// How many numbers the solver calculates with at a time. The results are the same.
    pub lane_width: LaneWidth,
    /// Measure residual, penetration and energy each step; costs one more pass over the rows. Off by default.
    pub measure_error: bool,
    /// List the islands in the report; with `measure_error`, each with its own residual. Off by default.
    pub measure_islands: bool,
    /// When islands at rest are left out of the step. Off by default.
    pub sleep: SleepConfig,
}

impl SolverConfig {
    /// The paper's method: one step, 16 sweeps of projected Gauss-Seidel, Baumgarte term, warm start.
    pub fn paper() -> Self {
        Self {
            method: Method::Pgs,
            substeps: 1,
            sweeps: 16,
            relax_sweeps: 0,
            slop: 0.002,
            tolerance: None,
            order: ContactOrder::Ordered,
            ..Self::default()
        }
    }

    /// The exact method in one step.
    pub fn exact() -> Self {
        Self {
            method: Method::Exact,
            substeps: 1,
            ..Self::default()
        }
    }

    /// Whether all numbers are finite and not negative.
    pub fn is_usable(&self) -> bool {
        let numbers = [
            self.baumgarte,
            self.slop,
            self.push_out_speed,
            self.restitution_threshold,
            self.contact_frequency,
            self.sag,
            self.damping_ratio,
        ];
        let tolerance = self.tolerance.is_none_or(|t| t.is_finite() && t > 0.0);
        self.substeps > 0
            && tolerance
            && self.sleep.is_usable()
            && numbers.iter().all(|n| n.is_finite() && *n >= 0.0)
    }
}

impl Default for SolverConfig {
    fn default() -> Self {
        Self {
            method: Method::SoftStep,
            substeps: 8,
            max_substeps: 32,
            sag: 1.25e-4,
            sweeps: 1,
            relax_sweeps: 1,
            contact_frequency: 0.2,
            damping_ratio: 10.0,
            baumgarte: 0.2,
            slop: 0.0,
            push_out_speed: 3.0,
            restitution_threshold: 0.5,
            friction_model: FrictionModel::Disc,
            warm_start: true,
            tolerance: Some(1e-3),
            max_sweeps: 32,
            max_extra_updates: 30_000,
            order: ContactOrder::Automatic,
            lane_width: LaneWidth::Widest,
            measure_error: false,
            measure_islands: false,
            sleep: SleepConfig::default(),
        }
    }
}

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

/// When islands fall asleep.
///
/// Speeds and distances are shares of what is natural for a body's size, so that a scene and its model in another scale
/// fall asleep alike: without gravity only what does not move at all rests.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct SleepConfig {
    /// Whether islands fall asleep at all. Turning it off wakes all that sleep.
    pub enabled: bool,
    /// Fastest speed of a body at rest, its points' on account of rotation included, as a share of `sqrt(g L)` with its
    /// least extent `L`: the speed after a fall by half of `L`.
    pub speed: f32,
    /// How far a body at rest may get from where it came to rest, as a share of its least extent. Tells rest from creep,
    /// which is slow but goes on.
    pub drift: f32,
    /// How long all bodies of an island must have been at rest, s.
    pub time: f32,
}

impl Default for SleepConfig {
    fn default() -> Self {
        Self {
            enabled: false,
            speed: 0.01,
            drift: 5e-4,
            time: 0.5,
        }
    }
}

impl SleepConfig {
    /// The default limits, with sleeping on.
    pub fn on() -> Self {
        Self {
            enabled: true,
            ..Self::default()
        }
    }

    /// Whether all numbers are finite and not negative.
    pub fn is_usable(&self) -> bool {
        let numbers = [self.speed, self.drift, self.time];
        numbers.iter().all(|n| n.is_finite() && *n >= 0.0)
    }
}
