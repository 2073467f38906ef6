//! What a user may choose: gravity, the method and its effort, and when islands sleep.

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

/// How the step solves contacts. The figures that decided the defaults are in `docs/decisions/` and `docs/report/`.
///
/// [`fast`](Self::fast), [`default`](Self::default) and [`precise`](Self::precise) are the same method with more and more
/// effort; [`paper`](Self::paper) and `exact` are what it is measured against.
#[derive(Clone, Copy, Debug, PartialEq, Resource)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct SolverConfig {
    /// What solves the rows of a sub-step, and with how much effort.
    pub method: Method,
    /// Fastest speed at which overlap is pushed out, m/s.
    pub push_out_speed: f32,
    /// Approach speed below which restitution is not applied, m/s; without it resting bodies would buzz. It is less where gravity is
    /// weak, steps are short or bodies small, so that bounces of a few steps count as such, and for a restitution above 0.75, so that what
    /// hardly loses speed goes on bouncing.
    pub restitution_threshold: f32,
    /// Start each solve from the multipliers in the [`ContactCache`](crate::contact::impulses::ContactCache).
    pub warm_start: bool,
    /// Measure residual, penetration and energy each step; costs one more pass over the rows. Off by default.
    pub measure_error: bool,
    /// List the islands in the report; with `measure_error`, each with its own residual. Off by default.
    pub measure_islands: bool,
    /// When islands at rest are left out of the step. On by default; [`SleepConfig::off`] turns it off.
    pub sleep: SleepConfig,
}

/// How the rows of a sub-step are solved.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum Method {
    /// Soft contacts, a sweep with position bias before the bodies move and one without after it.
    SoftStep(SoftStep),
    /// Projected Gauss-Seidel with a Baumgarte term: the paper's method.
    Pgs(Pgs),
    /// To rounding in double precision, whatever it takes: the judge of the others, and for small scenes that must be right.
    #[cfg(feature = "exact")]
    Exact(Exact),
}

/// The effort of [`Method::SoftStep`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct SoftStep {
    /// Least number of parts that each step is solved and integrated in; contact geometry is found once per step. Where
    /// [`max_substeps`](Self::max_substeps) is larger, bodies that only rigid joints hold take a quarter of it while they turn slowly.
    pub min_substeps: u32,
    /// Most parts. An island takes as many as keep the sag of its soft contacts below [`sag`](Self::sag) under the load that
    /// they bore in the last step.
    pub max_substeps: u32,
    /// How far a soft contact may give way under a resting load, as a share of the smaller body's least extent; 16 times that where
    /// joints are in the island.
    pub sag: f32,
    /// Most local steps that an island takes within a step: steps one after the other, each with contacts and sub-steps of its own.
    /// As many as gravity asks for that moves bodies far for their size, or as bodies with corners ask for that turn by more than half a
    /// radian, and as [`max_extra_updates`](Self::max_extra_updates) allow; a power of two. 1: none but the step itself.
    pub max_local_steps: u32,
    /// Sweeps over all rows in each sub-step, before the bodies move.
    pub sweeps: u32,
    /// Sweeps without position bias in each sub-step, after the bodies have moved.
    pub relax_sweeps: u32,
    /// Natural frequency of soft contacts as a share of the sub-step rate.
    pub contact_frequency: f32,
    /// Damping ratio of soft contacts; `None` for 10 with a [`tolerance`](Self::tolerance), which lets towers stop swaying sooner,
    /// and 1.5 where the number of sweeps is fixed: impulses that so few sweeps leave swing against the velocities, and more
    /// damping drives them (`docs/decisions/soft_step.md`).
    pub damping_ratio: Option<f32>,
    /// Largest velocity change, m/s, that a sweep may still make to bodies of 1 m when the sweeps of a sub-step end; for other
    /// sizes it grows with the square root of the least extent, as speeds under gravity do. Where bodies move, a hundredth of the
    /// fastest one's speed is enough. Each island goes on until it is met, or [`max_sweeps`](Self::max_sweeps) or
    /// [`max_extra_updates`](Self::max_extra_updates) are done; the report names islands that are left above it. `None`: no more
    /// sweeps than the least numbers.
    pub tolerance: Option<f32>,
    /// Most sweeps of a sub-step, before and after the bodies move each, with a [`tolerance`](Self::tolerance).
    pub max_sweeps: u32,
    /// Most updates of contact points that an island's sweeps beyond the least numbers may take in a step, where a joint counts as
    /// ten: small islands are solved to the tolerance, and a heap of thousands costs what it may. 30 000 are about a millisecond.
    pub max_extra_updates: u32,
}

/// The effort of [`Method::Pgs`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Pgs {
    /// Parts that each step is solved and integrated in.
    pub substeps: u32,
    /// Sweeps over all rows in each sub-step.
    pub sweeps: u32,
    /// Share of the overlap that one sub-step removes: `beta` in the stabilization term `zeta = -beta C / h`.
    pub baumgarte: f32,
    /// Overlap that is left alone, as a share of the smaller body's least extent, so that resting contacts stay touching.
    pub slop: f32,
    /// Shape of the friction bound.
    pub friction: FrictionModel,
    /// As [`SoftStep::tolerance`].
    pub tolerance: Option<f32>,
    /// As [`SoftStep::max_sweeps`].
    pub max_sweeps: u32,
}

/// The effort of `Method::Exact`.
#[cfg(feature = "exact")]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Exact {
    /// Parts that each step is solved and integrated in.
    pub substeps: u32,
    /// As [`Pgs::baumgarte`].
    pub baumgarte: f32,
    /// Shape of the friction bound.
    pub friction: FrictionModel,
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
    /// least extent `L`: the speed after a fall by half of `L`. What stays in place by [`drift`](Self::drift) may tremble there: sub-steps
    /// end with errors of velocities that come to nothing.
    pub speed: f32,
    /// How far a body at rest may get from where it came to rest, as a share of its least extent `L`. Tells rest from creep,
    /// which is slow but goes on. What is small falls by more than `L` in [`time`](Self::time); for it, this is a share of the way
    /// that it goes in that time with `sqrt(g L / 2)`, so that creep is told from rest by its speed. What is thin may go farther, by the square
    /// root of its length over its thickness, up to four times; what rocks on the spot, eight times as far for twice as long.
    pub drift: f32,
    /// How long all bodies of an island must have been at rest, s.
    pub time: f32,
}

impl SolverConfig {
    /// For many bodies at the price of precision: four sub-steps of one sweep each, whatever the load. Stacks of more than
    /// some ten bodies, and loads of more than ten to one, give way visibly.
    pub fn fast() -> Self {
        SoftStep {
            min_substeps: 4,
            max_substeps: 4,
            max_local_steps: 1,
            tolerance: None,
            ..SoftStep::default()
        }
        .into()
    }

    /// For structures that must not give way: a quarter of the default's sag and a tenth of its tolerance, for two to ten times
    /// its time.
    pub fn precise() -> Self {
        let SoftStep {
            max_substeps,
            sag,
            max_sweeps,
            max_extra_updates,
            ..
        } = SoftStep::default();
        SoftStep {
            max_substeps: 2 * max_substeps,
            sag: 0.25 * sag,
            tolerance: Some(1e-4),
            max_sweeps: 4 * max_sweeps,
            max_extra_updates: 10 * max_extra_updates,
            ..SoftStep::default()
        }
        .into()
    }

    /// The paper's method: one step, 16 sweeps of projected Gauss-Seidel, Baumgarte term, warm start.
    pub fn paper() -> Self {
        Pgs::default().into()
    }

    /// The exact method in one step.
    #[cfg(feature = "exact")]
    pub fn exact() -> Self {
        Exact::default().into()
    }

    /// Whether all numbers are finite and not negative.
    pub fn is_usable(&self) -> bool {
        are_usable(&[self.push_out_speed, self.restitution_threshold])
            && self.method.is_usable()
            && self.sleep.is_usable()
    }
}

impl Default for SolverConfig {
    fn default() -> Self {
        Self {
            method: Method::default(),
            push_out_speed: 3.0,
            restitution_threshold: 0.5,
            warm_start: true,
            measure_error: false,
            measure_islands: false,
            sleep: SleepConfig::default(),
        }
    }
}

impl<M: Into<Method>> From<M> for SolverConfig {
    /// The method, with the defaults of all else.
    fn from(method: M) -> Self {
        Self {
            method: method.into(),
            ..Self::default()
        }
    }
}

impl Method {
    fn is_usable(&self) -> bool {
        match self {
            Self::SoftStep(soft_step) => soft_step.is_usable(),
            Self::Pgs(pgs) => pgs.is_usable(),
            #[cfg(feature = "exact")]
            Self::Exact(exact) => exact.substeps > 0 && are_usable(&[exact.baumgarte]),
        }
    }
}

impl Default for Method {
    fn default() -> Self {
        Self::SoftStep(SoftStep::default())
    }
}

impl From<SoftStep> for Method {
    fn from(soft_step: SoftStep) -> Self {
        Self::SoftStep(soft_step)
    }
}

impl From<Pgs> for Method {
    fn from(pgs: Pgs) -> Self {
        Self::Pgs(pgs)
    }
}

#[cfg(feature = "exact")]
impl From<Exact> for Method {
    fn from(exact: Exact) -> Self {
        Self::Exact(exact)
    }
}

impl SoftStep {
    fn is_usable(&self) -> bool {
        self.min_substeps > 0
            && is_tolerance(self.tolerance)
            && are_usable(&[self.sag, self.contact_frequency, self.damping_ratio()])
    }

    /// Damping ratio of soft contacts.
    pub(crate) fn damping_ratio(&self) -> f32 {
        let default = match self.tolerance {
            Some(_) => 10.0,
            None => 1.5,
        };
        self.damping_ratio.unwrap_or(default)
    }
}

impl Default for SoftStep {
    fn default() -> Self {
        Self {
            min_substeps: 8,
            max_substeps: 32,
            sag: 1.25e-4,
            max_local_steps: 16,
            sweeps: 1,
            relax_sweeps: 1,
            contact_frequency: 0.2,
            damping_ratio: None,
            tolerance: Some(1e-3),
            max_sweeps: 32,
            max_extra_updates: 30_000,
        }
    }
}

impl Pgs {
    fn is_usable(&self) -> bool {
        self.substeps > 0
            && is_tolerance(self.tolerance)
            && are_usable(&[self.baumgarte, self.slop])
    }
}

impl Default for Pgs {
    fn default() -> Self {
        Self {
            substeps: 1,
            sweeps: 16,
            baumgarte: 0.2,
            slop: 0.002,
            friction: FrictionModel::Disc,
            tolerance: None,
            max_sweeps: 32,
        }
    }
}

#[cfg(feature = "exact")]
impl Default for Exact {
    fn default() -> Self {
        Self {
            substeps: 1,
            baumgarte: 0.2,
            friction: FrictionModel::Disc,
        }
    }
}

impl SleepConfig {
    /// Nothing falls asleep: for measurements of what bodies at rest cost, and of how still they lie.
    pub fn off() -> Self {
        Self {
            enabled: false,
            ..Self::default()
        }
    }

    /// Whether all numbers are finite and not negative.
    pub fn is_usable(&self) -> bool {
        are_usable(&[self.speed, self.drift, self.time])
    }
}

impl Default for SleepConfig {
    fn default() -> Self {
        Self {
            enabled: true,
            speed: 0.1,
            drift: 5e-4,
            time: 0.5,
        }
    }
}

/// Whether all numbers are finite and not negative.
fn are_usable(numbers: &[f32]) -> bool {
    numbers.iter().all(|n| n.is_finite() && *n >= 0.0)
}

fn is_tolerance(tolerance: Option<f32>) -> bool {
    tolerance.is_none_or(|t| t.is_finite() && t > 0.0)
}
