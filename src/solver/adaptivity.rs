//! What islands ask of the sub-steps: how many, how many sweeps, and whether they must look out for impacts.

/// Whether an island has joints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum JointPresence {
    /// It has contacts only.
    #[default]
    None,
    /// It has nothing else.
    Alone,
    /// It has contacts too.
    AmongContacts,
}

/// Of small islands whose contacts all share a body: those of a kind are solved side by side, each as if it were alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LoneKind {
    /// Whether the rows follow the motion.
    pub moves: bool,
    /// Whether the bodies rebound from each other.
    pub bounces: bool,
}

/// What an island asks of its sub-steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IslandRequirements {
    /// Largest velocity that a contact gave its effective mass in the last step, over the smaller body's least extent, 1/s.
    /// Infinite where a bond is new: what it will bear must be found before it gives way.
    pub load: f32,
    /// Whether bodies may hit each other: some move, or rebound.
    pub can_hit: bool,
    /// If all its contacts share a body, are few, and need nothing but sweeps: what kind of island it is.
    pub lone: Option<LoneKind>,
    /// What holds its bodies at a distance: joints alone are solved otherwise than among contacts.
    pub joints: JointPresence,
    /// Fastest turn of a body within the step, rad, where nothing but joints acts between the bodies, and each axis of theirs is free or rigid:
    /// sub-steps need only follow that turn. `None` for all others.
    pub joint_swing: Option<f32>,
    /// Sub-steps that follow from all that.
    pub substeps: u32,
    /// Steps that it takes within the step, each with contacts of its own; 1 for the step itself.
    pub local_steps: u32,
    /// Most of them that it may take, if what it meets takes more.
    pub max_local_steps: u32,
}

impl IslandRequirements {
    /// Whether islands with the two requirements can be solved together.
    pub fn is_solved_like(&self, other: &Self) -> bool {
        self.substeps == other.substeps
            && self.can_hit == other.can_hit
            && self.joints == other.joints
    }
}

/// What a batch took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SweepBudget {
    /// Sweeps of all sub-steps together.
    pub sweeps: u32,
    /// Whether a sub-step ended above the tolerance.
    pub is_unconverged: bool,
    /// Sweeps beyond the least numbers that are left for this step, and for this sub-step: evenly, for sub-steps that are
    /// more precise than the next ones shake a stack.
    spare: u32,
    share: u32,
}

impl SweepBudget {
    /// At most `max_extra_updates` beyond the least numbers, for a batch in whose largest island a sweep makes the given number.
    pub fn new(max_extra_updates: u32, updates: usize) -> Self {
        Self {
            spare: max_extra_updates / (updates as u32).max(1),
            ..Self::default()
        }
    }

    /// Begins a sub-step, with `to_go` of them left.
    pub fn begin(&mut self, to_go: u32) {
        self.share = self.spare / to_go;
    }

    /// Most sweeps beyond the least number that this sub-step may still have.
    pub fn share(&self) -> u32 {
        self.share
    }

    /// Takes note of sweeps, `extra` of them beyond the least number, and whether they ended above the tolerance.
    pub fn note(&mut self, sweeps: u32, extra: u32, is_unconverged: bool) {
        self.sweeps += sweeps;
        self.share -= extra;
        self.spare -= extra;
        self.is_unconverged |= is_unconverged;
    }
}
