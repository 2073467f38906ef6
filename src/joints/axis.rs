//! One direction in which a joint may let its bodies move.

use crate::joints::error::JointError;

/// How far B may move against A along or about an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum AxisRange {
    /// Not at all.
    #[default]
    Locked,
    /// As far as it likes.
    Free,
    /// Between two places, m or rad. If they are the same, it stays there.
    Limited {
        /// Least.
        min: f32,
        /// Largest, not less.
        max: f32,
    },
}

/// Stiffness and damping.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum JointSpring {
    /// By how the two bodies alone swing on it, as the joint lets them: about a hinge with all that turns about the hinge, whatever else hangs on
    /// them.
    Frequency {
        /// Without damping, Hz.
        hertz: f32,
        /// 1: goes back as fast as it can without swinging past.
        damping_ratio: f32,
    },
    /// By force.
    Coefficients {
        /// N/m, or N m/rad.
        stiffness: f32,
        /// N s/m, or N m s/rad.
        damping: f32,
    },
}

/// What a drive aims at.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum DriveTarget {
    /// A velocity of B against A, m/s or rad/s, as far as the force allows.
    Velocity(f32),
    /// A place, by a spring.
    Position {
        /// m or rad.
        position: f32,
        /// How hard it pulls there.
        spring: JointSpring,
    },
}

/// A motor or a spring along or about an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct JointDrive {
    /// What it aims at.
    pub target: DriveTarget,
    /// Largest force, N, or torque, N m. May be infinite.
    pub max_force: f32,
}

impl JointDrive {
    /// A motor that keeps up a velocity (m/s or rad/s) with at most `max_force` (N or N m).
    pub fn velocity(velocity: f32, max_force: f32) -> Self {
        Self {
            target: DriveTarget::Velocity(velocity),
            max_force,
        }
    }

    /// A spring towards a place (m or rad), of unbounded force.
    pub fn spring(position: f32, spring: JointSpring) -> Self {
        Self {
            target: DriveTarget::Position { position, spring },
            max_force: f32::INFINITY,
        }
    }
}

/// What B may do against A along or about one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct JointAxis {
    /// How far.
    pub range: AxisRange,
    /// What gives way where the range ends, instead of stopping at once; it brakes nothing before that. Locked axes are always rigid: a spring that
    /// holds a place is a [`drive`](Self::drive).
    pub softness: Option<JointSpring>,
    /// Share of the speed with which it comes back from the ends of its range.
    pub restitution: f32,
    /// What moves it.
    pub drive: Option<JointDrive>,
    /// Largest force (N) or torque (N m) that brakes it.
    pub friction: f32,
}

impl JointAxis {
    /// Does not move.
    pub const LOCKED: Self = Self {
        range: AxisRange::Locked,
        softness: None,
        restitution: 0.0,
        drive: None,
        friction: 0.0,
    };

    /// Moves as it likes.
    pub const FREE: Self = Self {
        range: AxisRange::Free,
        ..Self::LOCKED
    };

    /// Moves between two places, m or rad.
    pub const fn limited(min: f32, max: f32) -> Self {
        Self {
            range: AxisRange::Limited { min, max },
            ..Self::LOCKED
        }
    }

    /// The same with a drive.
    pub fn with_drive(self, drive: JointDrive) -> Self {
        Self {
            drive: Some(drive),
            ..self
        }
    }

    /// The same with friction, N or N m.
    pub fn with_friction(self, friction: f32) -> Self {
        Self { friction, ..self }
    }

    pub(crate) fn check(&self) -> Result<(), JointError> {
        if let AxisRange::Limited { min, max } = self.range
            && !(min.is_finite() && max.is_finite() && min <= max)
        {
            return Err(JointError::Range { min, max });
        }
        let drive = self.drive.map(|drive| drive.target);
        let (aim, of_drive) = match drive {
            Some(DriveTarget::Velocity(velocity)) => (velocity, None),
            Some(DriveTarget::Position { position, spring }) => (position, Some(spring)),
            None => (0.0, None),
        };
        let springs = [self.softness, of_drive].into_iter().flatten();
        let of_springs = springs.flat_map(|spring| match spring {
            JointSpring::Frequency {
                hertz,
                damping_ratio,
            } => [hertz, damping_ratio],
            JointSpring::Coefficients { stiffness, damping } => [stiffness, damping],
        });
        let is_usable = |x: &f32| x.is_finite() && *x >= 0.0;
        let numbers = [self.friction, self.restitution].into_iter();
        if let Some(number) = numbers.chain(of_springs).find(|x| !is_usable(x)) {
            return Err(JointError::Coefficient { number });
        }
        if !aim.is_finite() {
            return Err(JointError::NotFinite("the target of a drive"));
        }
        match self.drive {
            Some(drive) if drive.max_force.is_nan() || drive.max_force < 0.0 => {
                Err(JointError::Coefficient {
                    number: drive.max_force,
                })
            }
            _ => Ok(()),
        }
    }
}
