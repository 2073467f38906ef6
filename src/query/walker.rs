//! What a character that walks is told, and what it tells.

use crate::bodies::body::BodyError;
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use glam::{Quat, Vec3};

/// How a character walks.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct WalkSettings {
    /// Unit vector against gravity.
    pub up: Vec3,
    /// Rise over run of the steepest ground that it stands on and walks up: 1 is 45 degrees.
    pub max_slope: f32,
    /// Height of the highest step that it goes up, and down without falling, m.
    pub step_height: f32,
    /// Gap that it keeps from everything, m.
    pub skin: f32,
    /// Largest force with which it pushes dynamic bodies in its way, N.
    pub push_force: f32,
}

impl WalkSettings {
    /// Whether they mean something: `up` has length 1, and nothing is NaN, negative or, but for the slope, infinite.
    pub fn is_usable(&self) -> bool {
        let lengths = [self.step_height, self.skin, self.push_force];
        self.up.is_normalized()
            && self.max_slope >= 0.0
            && lengths.iter().all(|it| *it >= 0.0 && it.is_finite())
    }
}

impl Default for WalkSettings {
    /// Slopes of 45 degrees, steps of 0.3 m, a push of 500 N, against a gravity along -y.
    fn default() -> Self {
        Self {
            up: Vec3::Y,
            max_slope: 1.0,
            step_height: 0.3,
            skin: 0.01,
            push_force: 500.0,
        }
    }
}

/// What a character stands on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footing {
    /// Slot of the body.
    pub body: u32,
    /// Its id.
    pub id: BodyId,
    /// Its unit normal there.
    pub normal: Vec3,
    /// Where, world, m, with the body where it will be after the step.
    pub point: Vec3,
    /// The same as the body sees it, and its rotation then.
    pub(crate) place: Vec3,
    pub(crate) rotation: Quat,
}

/// What a character pushes in a step: at a point of a dynamic body, along the way into it.
///
/// The impulse is what would make the body as fast as the character there if nothing else held it, but no more than
/// [`WalkSettings::push_force`] gives in the step. Each body is pushed once a step. [`apply`](Self::apply) lets it act.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// Slot of the body.
    pub body: u32,
    /// Where, world, m.
    pub point: Vec3,
    /// N s.
    pub impulse: Vec3,
}

impl Push {
    /// Lets it act in the next step, which takes `step_dt` (s). On a cluster it acts as the force that it is, which loads bonds: as a blow
    /// it would shoot off a splinter.
    ///
    /// # Errors
    /// [`BodyError::Drive`] if a number is not finite; nothing acts then.
    pub fn apply(&self, bodies: &mut Bodies, step_dt: f32) -> Result<(), BodyError> {
        let amounts = match bodies.cluster(self.body) {
            Some(_) => [self.impulse / step_dt, Vec3::ZERO],
            None => [Vec3::ZERO, self.impulse],
        };
        bodies.apply_at(self.body, self.point, amounts)
    }
}

/// Where a character is and how it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WalkState {
    /// Position of its frame, m.
    pub position: Vec3,
    /// Its rotation; turned by what it stands on.
    pub rotation: Quat,
    /// Its own velocity, m/s, without that of what it stands on.
    pub velocity: Vec3,
    /// What it keeps in the air of the velocity of the ground that it left, across `up`, m/s; zero on the ground. It is part of `velocity`,
    /// and added to where it wants to go.
    pub drift: Vec3,
    /// What it stands on; nothing in the air.
    pub footing: Option<Footing>,
}

/// What a character does in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WalkInput {
    /// Where it wants to go, m/s; what of it is along `up` does not count.
    pub velocity: Vec3,
    /// Speed with which it jumps off, if it stands on something, m/s; 0 for no jump.
    pub jump: f32,
    /// m/s2.
    pub gravity: Vec3,
    /// Length of the step, s.
    pub step_dt: f32,
}
