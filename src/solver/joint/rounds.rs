//! Rounds of the search for a motion at whose end joints hold: each component of connected bodies for as long as it gains.
//!
//! Impulses act along the rows of where the bodies are, which is symmetric in time, and what is amiss after a motion shrinks by a factor of
//! some `h omega` with each round. Where bodies turn by much in a sub-step, or a chain is nearly straight, so that to close what is amiss
//! asks for a motion to the side as large as the one that left it, it grows instead. Such a round is taken back, and the search goes on
//! along the rows of where the bodies would be: Newton's method, with steps that are halved until they gain. What is amiss where
//! that ends too is left to the next sub-step.

use crate::solver::joint::vector6::Vector6;

/// How often a step is halved.
const HALVINGS: u8 = 4;

/// Largest share of what was amiss that a step may leave.
const MOST_LEFT: f64 = 0.9;

/// Along which rows a component searches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Along {
    /// Of where the bodies are.
    Start,
    /// Of where they would be, after so many halvings of the last step.
    End(u8),
}

/// What a component does next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Move {
    /// Another step.
    Step,
    /// Goes back by a share of the last step, and looks again.
    Retreat(f64),
    /// Nothing more: the joints hold, or what is left is left.
    Stop,
}

/// Rounds of a component.
#[derive(Clone, Copy, Debug)]
pub(super) struct Progress {
    along: Along,
    next: Move,
    has_stopped: bool,
    /// Whether joints are pushed together, from farther apart than motion makes.
    is_pushed: bool,
    /// Whether no motion was found at whose end the joints hold.
    is_lost: bool,
    /// Whether the last step was not taken.
    is_taken_back: bool,
    /// The most that was amiss before the last step, in tolerances.
    last: f64,
    /// The most that is amiss now.
    worst: f64,
}

impl Progress {
    const START: Self = Self {
        along: Along::Start,
        next: Move::Step,
        has_stopped: false,
        is_pushed: false,
        is_lost: false,
        is_taken_back: false,
        last: f64::INFINITY,
        worst: 0.0,
    };

    /// Whether the search is along the rows of where the bodies would be.
    pub(super) fn is_along_end(&self) -> bool {
        self.along != Along::Start
    }

    /// Takes note of what is amiss in a row, in tolerances.
    pub(super) fn note(&mut self, amiss: f64) {
        let amiss = if amiss.is_nan() { f64::INFINITY } else { amiss };
        self.worst = self.worst.max(amiss);
    }

    /// Another row acts than before the last step, with which this one cannot be compared.
    pub(super) fn forget(&mut self) {
        self.last = f64::INFINITY;
    }

    /// Takes note of a joint that is pushed together from farther apart than motion makes.
    pub(super) fn note_push(&mut self) {
        self.is_pushed = true;
    }

    /// Whether none was found, as far as is known, of joints that are not pushed.
    fn is_lost(&self) -> bool {
        !self.is_pushed && (self.is_lost || !self.has_stopped)
    }

    fn judge(&mut self) {
        let worst = std::mem::take(&mut self.worst);
        self.is_taken_back = false;
        if worst <= 1.0 {
            return self.stop(Move::Stop);
        }
        if worst < MOST_LEFT * self.last {
            self.last = worst;
            self.next = Move::Step;
            if self.is_along_end() {
                self.along = Along::End(0);
            }
            return;
        }
        if self.last == f64::INFINITY {
            // What is not finite at the start has nothing to go back to.
            self.is_lost = true;
            return self.stop(Move::Stop);
        }
        match self.along {
            Along::Start => {
                self.along = Along::End(0);
                self.next = Move::Retreat(1.0);
                self.forget();
            }
            Along::End(HALVINGS) => {
                self.is_lost = true;
                self.stop(Move::Retreat(1.0));
            }
            Along::End(halvings) => {
                self.along = Along::End(halvings + 1);
                self.next = Move::Retreat(0.5);
            }
        }
    }

    fn stop(&mut self, next: Move) {
        self.has_stopped = true;
        self.next = next;
    }
}

/// Rounds of all components.
#[derive(Debug, Default)]
pub(super) struct Rounds {
    /// By component.
    progress: Vec<Progress>,
    /// By body and by row: before the last step, or the search for the rows that act.
    pub(super) velocities: Vec<Vector6>,
    pub(super) impulses: Vec<f64>,
}

impl Rounds {
    /// Begins the rounds of so many components.
    pub(super) fn begin(&mut self, components: usize) {
        self.progress.clear();
        self.progress.resize(components, Progress::START);
    }

    /// The progress of a component that has not stopped.
    pub(super) fn going_on(&mut self, component: u32) -> Option<&mut Progress> {
        let progress = &mut self.progress[component as usize];
        (!progress.has_stopped).then_some(progress)
    }

    /// Finds what each component does next; whether any goes on, and whether any retreats.
    pub(super) fn judge(&mut self) -> [bool; 2] {
        let mut any = [false; 2];
        for progress in &mut self.progress {
            if progress.has_stopped {
                progress.next = Move::Stop;
                continue;
            }
            progress.judge();
            any[0] |= !progress.has_stopped;
            any[1] |= matches!(progress.next, Move::Retreat(_));
        }
        any
    }

    /// Whether joints of any component are lost.
    pub(super) fn any_lost(&self) -> bool {
        self.progress.iter().any(Progress::is_lost)
    }

    /// Whether joints of a component stay open at the end of the motion.
    pub(super) fn leave_open(&self, component: u32) -> bool {
        let progress = &self.progress[component as usize];
        progress.is_pushed || progress.is_lost || !progress.has_stopped
    }

    /// Whether a component searches along the rows of where the bodies would be.
    #[inline(always)]
    pub(super) fn is_along_end(&self, component: u32) -> bool {
        self.progress[component as usize].is_along_end()
    }

    /// Whether the bodies of a component go elsewhere than in the last round.
    #[inline(always)]
    pub(super) fn moves(&self, component: u32) -> bool {
        self.next(component) != Move::Stop
    }

    /// The last step of a component is not taken.
    pub(super) fn take_back(&mut self, component: u32) {
        let progress = &mut self.progress[component as usize];
        progress.forget();
        progress.is_taken_back = true;
    }

    /// Whether the last step of a component was not taken.
    pub(super) fn is_taken_back(&self, component: u32) -> bool {
        self.progress[component as usize].is_taken_back
    }

    /// What a component does next.
    #[inline(always)]
    pub(super) fn next(&self, component: u32) -> Move {
        self.progress[component as usize].next
    }
}
