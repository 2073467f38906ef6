//! Threads that work through many short lists of tasks together, with almost nothing in between.
//!
//! A phase of the step is a row of passes over lists, and a sub-step of a large heap a dozen loops of some 100 us each; to hand
//! each to the task pool would take a good part of that. So helpers come for a phase: they look for tasks without rest, and
//! the thread that leads never waits for a helper that has not taken a task. Without helpers it does all tasks itself.
//!
//! To wake a helper takes some 30 us, which a step of a millisecond has not got for each of its phases. So helpers look for
//! the next phase a little longer, and only then go back to the pool.
//!
//! A thread prefers the same tasks of every list, whose data are in its cache, and takes those of others if these are late.
#![allow(
    unsafe_code,
    reason = "tasks borrow from the leader's stack, and write to parts of one list"
)]

use crate::tuning::{HELPER_LINGER, HELPER_PAUSES, HELPER_SPINS, MAX_PARTS, MAX_TASKS};
use bevy_tasks::ComputeTaskPool;
use smallvec::SmallVec;
use std::any::Any;
use std::cell::{Cell, UnsafeCell};
use std::hint::spin_loop;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread::available_parallelism;

/// A list of tasks: does the one with the given number.
type Tasks<'a> = &'a (dyn Fn(usize) + Sync);

/// The team of the compute task pool.
static TEAM: OnceLock<Team> = OnceLock::new();

/// A leader and its helpers.
pub struct Team {
    /// The present list; written by the leader only while no task of it is left.
    tasks: UnsafeCell<Tasks<'static>>,
    /// Number of the list in the upper half, a bit for each task that nobody has taken in the lower half.
    left: AtomicU64,
    /// Tasks of the present list that are done.
    done: AtomicU32,
    /// Whether somebody leads.
    is_led: AtomicBool,
    /// By helper: whether it looks for tasks, or has been called to.
    are_here: Box<[AtomicBool]>,
    /// What a helper's task panicked with.
    panic: Mutex<Option<Box<dyn Any + Send>>>,
}

impl std::fmt::Debug for Team {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Team")
            .field("threads", &self.threads())
            .finish_non_exhaustive()
    }
}

// SAFETY: `tasks` is written by the leader, of which there is one at a time, while `left` holds no task and all that were
// taken are done, so nobody reads it then; helpers read it after they took a task from `left`, which the leader filled after
// writing.
unsafe impl Sync for Team {}

impl Team {
    fn new(helpers: usize) -> Self {
        Self {
            tasks: UnsafeCell::new(&|_| {}),
            left: AtomicU64::new(0),
            done: AtomicU32::new(0),
            is_led: AtomicBool::new(false),
            are_here: (0..helpers).map(|_| AtomicBool::new(false)).collect(),
            panic: Mutex::new(None),
        }
    }

    /// Leads a team of all threads of `pool` through `work`. If another thread leads it already, the leader is alone.
    pub fn lead<R>(pool: &'static ComputeTaskPool, work: impl FnOnce(&Self) -> R) -> R {
        let team = TEAM.get_or_init(|| Self::new(pool.thread_num()));
        if team.is_led.swap(true, Ordering::Acquire) {
            return work(&Self::new(pool.thread_num()));
        }
        // However the work ends, the helpers must go.
        let _dismissal = Dismissal(&team.is_led);
        for (helper, is_here) in (1..).zip(&team.are_here) {
            if !is_here.swap(true, Ordering::AcqRel) {
                pool.spawn(async move { team.help(helper) }).detach();
            }
        }
        work(team)
    }

    /// Leads a team of all threads of the compute task pool through `work`, if there is a pool, a core for it, and the work is
    /// worth the microseconds that it takes to wake them; otherwise there is no team.
    pub fn lead_if<R>(is_worth_help: bool, work: impl FnOnce(Option<&Self>) -> R) -> R {
        let pool = ComputeTaskPool::try_get().filter(|_| is_worth_help && has_cores());
        match pool {
            Some(pool) => Self::lead(pool, |team| work(Some(team))),
            None => work(None),
        }
    }

    /// As [`lead_if`](Self::lead_if) with those helpers that have not gone yet since the last phase, if there are any: for work
    /// that is not worth waking one.
    pub fn lead_present_if<R>(is_worth_help: bool, work: impl FnOnce(Option<&Self>) -> R) -> R {
        let team = TEAM.get().filter(|team| {
            let mut helpers = team.are_here.iter();
            is_worth_help
                && helpers.any(|is_here| is_here.load(Ordering::Relaxed))
                && !team.is_led.swap(true, Ordering::Acquire)
        });
        let _dismissal = team.map(|team| Dismissal(&team.is_led));
        work(team)
    }

    /// Number of threads, the leader among them.
    pub fn threads(&self) -> usize {
        self.are_here.len() + 1
    }

    /// How many parts to cut a list of `count` elements into, if a part is to have `least` of them: one without a team.
    pub fn parts(team: Option<&Self>, count: usize, least: usize) -> usize {
        let most = team.map_or(1, |team| team.threads().min(MAX_PARTS));
        (count / least).clamp(1, most)
    }

    /// Length of these parts, but for the last one; at least one.
    pub fn part_size(team: Option<&Self>, count: usize, least: usize) -> usize {
        count.div_ceil(Self::parts(team, count, least)).max(1)
    }

    /// Does `work` on each of some parts, of which there may be 32, in any order and on any thread. Without a team, one after
    /// the other as they come. A thread prefers the parts with the same numbers in every list.
    ///
    /// How a list is cut into parts must depend on the scene only, never on who does which, and what parts find is put together
    /// in their order: then any number of threads gives the same bits.
    ///
    /// # Panics
    /// If a team is given more.
    pub fn each<P: Send>(
        team: Option<&Self>,
        parts: impl Iterator<Item = P>,
        work: impl Fn(P) + Sync,
    ) {
        let Some(team) = team else {
            return parts.for_each(work);
        };
        // Filled where it is: to move it would take longer than a small part.
        let mut list = SmallVec::<[Option<P>; MAX_TASKS]>::new();
        list.extend(parts.map(Some));
        let shared = Shared::new(&mut list);
        // SAFETY: each task is done once, and touches its own part only.
        team.run(shared.0.len(), &|task| unsafe {
            let part = shared.part(task..task + 1).iter_mut();
            part.filter_map(Option::take).for_each(&work);
        });
    }

    /// As [`each`](Self::each), for any number of parts: each thread is a part of that, and takes one part after the other, the
    /// leader from the front and helpers from the back. In the next step, or the next pass over the list, each finds much of
    /// what it works on in its own cache.
    pub(crate) fn each_of_many<I>(team: Option<&Self>, parts: I, work: impl Fn(I::Item) + Sync)
    where
        I: ExactSizeIterator<Item: Send> + DoubleEndedIterator + Send,
    {
        let Some(team) = team.filter(|_| parts.len() > 1) else {
            return parts.for_each(work);
        };
        let parts = Mutex::new(parts);
        let run_all = |take: fn(&mut I) -> Option<I::Item>| {
            // The lock is let go of before the work. No part is half taken, whoever panicked.
            let next = || take(&mut parts.lock().unwrap_or_else(PoisonError::into_inner));
            std::iter::from_fn(next).for_each(&work);
        };
        let takers = 0..team.threads().min(MAX_TASKS);
        Self::each(Some(team), takers, |taker| match taker {
            0 => run_all(I::next),
            _ => run_all(I::next_back),
        });
    }

    /// Does tasks `0..count`, of which there may be 32, in any order and on any thread, and returns when all are done. For the
    /// leader only, and not from within a task.
    ///
    /// # Panics
    /// If there are more.
    pub fn run(&self, count: usize, tasks: Tasks<'_>) {
        assert!(count <= MAX_TASKS, "a list has 32 tasks at most");
        if count <= 1 {
            return (0..count).for_each(tasks);
        }
        let list = (self.left.load(Ordering::Relaxed) >> 32).wrapping_add(1);
        self.done.store(0, Ordering::Relaxed);
        // SAFETY: the list before is done, so nobody reads `tasks` (see `Sync`). That this one is borrowed for longer than it
        // lives does not matter: it is called by those who took one of its tasks only, and this function does not return, nor
        // unwind, before all of them are done.
        unsafe { *self.tasks.get() = std::mem::transmute::<Tasks<'_>, Tasks<'static>>(tasks) };
        // The first one is the leader's from the start.
        let others = ((1_u64 << count) - 1) & !1;
        self.left.store(list << 32 | others, Ordering::Release);
        let wait = WaitForAll {
            team: self,
            count: count as u32,
        };
        {
            let _done = CountDone(&self.done);
            tasks(0);
        }
        while self.take_one(0) {}
        drop(wait);
        let panic = self.panicked().take();
        if let Some(panic) = panic {
            resume_unwind(panic);
        }
    }

    fn panicked(&self) -> MutexGuard<'_, Option<Box<dyn Any + Send>>> {
        self.panic.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Looks for tasks until nobody has led for a while.
    fn help(&self, thread: usize) {
        let _leave = Dismissal(&self.are_here[thread - 1]);
        let mut idle = 0;
        while idle < HELPER_LINGER || self.is_led.load(Ordering::Acquire) {
            if self.take_one(thread) {
                idle = 0;
            } else if idle < HELPER_SPINS {
                idle += 1;
                // Long pauses: a core's other thread may be the leader's.
                (0..HELPER_PAUSES).for_each(|_| spin_loop());
            } else {
                std::thread::yield_now();
            }
        }
    }

    /// Does a task that nobody has taken, one of the thread's own if there is any; whether there was one.
    fn take_one(&self, thread: usize) -> bool {
        let seen = self.left.load(Ordering::Acquire);
        let open = seen as u32;
        if open == 0 {
            return false;
        }
        let own = (thread..MAX_TASKS).step_by(self.threads());
        let own = own.map(|task| open & 1 << task).find(|&bit| bit != 0);
        let task = own.unwrap_or(open).trailing_zeros();
        // The number of the list keeps this from taking a task of a later one.
        let taken = self.left.compare_exchange_weak(
            seen,
            seen & !(1 << task),
            Ordering::Acquire,
            Ordering::Relaxed,
        );
        if taken.is_ok() {
            // SAFETY: a task has been taken and is not done yet, so the leader does not write (see `Sync`).
            let tasks = unsafe { *self.tasks.get() };
            let _done = CountDone(&self.done);
            if thread == 0 {
                tasks(task as usize);
            } else if let Err(panic) = catch_unwind(AssertUnwindSafe(|| tasks(task as usize))) {
                // It is the leader's to tell, once all others are done.
                self.panicked().get_or_insert(panic);
            }
        }
        true
    }
}

/// Whether there is a core for a helper: on a single one it would only keep the leader from its work.
fn has_cores() -> bool {
    static CORES: OnceLock<usize> = OnceLock::new();
    *CORES.get_or_init(|| available_parallelism().map_or(1, usize::from)) > 1
}

/// Says that a leader or helper is gone when dropped.
struct Dismissal<'a>(&'a AtomicBool);

impl Drop for Dismissal<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Release);
    }
}

/// Counts a task as done when dropped, also if it panics.
struct CountDone<'a>(&'a AtomicU32);

impl Drop for CountDone<'_> {
    fn drop(&mut self) {
        self.0.fetch_add(1, Ordering::Release);
    }
}

/// When dropped, does what is left of the present list and waits for those who have taken a task.
struct WaitForAll<'a> {
    team: &'a Team,
    count: u32,
}

impl Drop for WaitForAll<'_> {
    fn drop(&mut self) {
        // Tasks that nobody will do any more, if the leader's own panicked.
        let left = self.team.left.load(Ordering::Acquire);
        let forgotten = self.team.left.swap(left >> 32 << 32, Ordering::AcqRel) as u32;
        self.team
            .done
            .fetch_add(forgotten.count_ones(), Ordering::Release);
        let mut spins = 0;
        while self.team.done.load(Ordering::Acquire) < self.count {
            if spins < HELPER_SPINS {
                spins += 1;
                spin_loop();
            } else {
                std::thread::yield_now();
            }
        }
    }
}

/// A list whose parts are written by different tasks.
pub struct Shared<'a, T>(&'a [Cell<T>]);

impl<T> std::fmt::Debug for Shared<'_, T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Shared")
            .field("len", &self.0.len())
            .finish_non_exhaustive()
    }
}

// SAFETY: cells are reached through `unsafe` functions only, whose callers promise that no two tasks use the same one.
unsafe impl<T: Send> Sync for Shared<'_, T> {}

impl<'a, T> Shared<'a, T> {
    /// Shares a list.
    pub fn new(list: &'a mut [T]) -> Self {
        Self(Cell::from_mut(list).as_slice_of_cells())
    }

    /// All of the list.
    ///
    /// # Safety
    /// While several threads hold it, no element that one of them writes may be touched by another.
    pub unsafe fn cells(&self) -> &'a [Cell<T>] {
        self.0
    }

    /// A part of the list.
    ///
    /// # Safety
    /// Nothing else may touch this part as long as the result lives.
    #[allow(
        clippy::mut_from_ref,
        reason = "that no two of these overlap is what the caller promises"
    )]
    pub unsafe fn part(&self, range: Range<usize>) -> &'a mut [T] {
        let part = &self.0[range];
        // SAFETY: `Cell<T>` has the layout of `T` and may be written through a shared reference; nothing else touches this
        // part, as the caller promises.
        unsafe { std::slice::from_raw_parts_mut(part.as_ptr().cast_mut().cast(), part.len()) }
    }
}
