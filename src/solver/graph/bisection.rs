//! Halves of a cloud of bodies, cut by planes across its axes.
//!
//! Each level takes two passes over the bodies: one counts them by slab of their half, one puts them on their side of the cut and
//! measures the new halves. Parts of the bodies are gone through side by side; counts and boxes come out the same however
//! many parts there are.

use crate::threads::parts::front_mut;
use crate::threads::team::Team;
use crate::tuning::{CUT_PLACES, MAX_LEAVES, MAX_PARTS, MIN_BISECTED_BODIES};
use glam::Vec3;
use smallvec::SmallVec;

/// The bodies of a half, and the cut through it.
#[derive(Clone, Copy, Debug)]
struct Half {
    min: Vec3,
    max: Vec3,
    axis: usize,
    /// Bodies by slab.
    counts: [u32; CUT_PLACES],
    /// The first slab of the second half.
    slab: usize,
}

impl Default for Half {
    fn default() -> Self {
        Self {
            min: Vec3::INFINITY,
            max: Vec3::NEG_INFINITY,
            axis: 0,
            counts: [0; CUT_PLACES],
            slab: 0,
        }
    }
}

impl Half {
    fn contain(&mut self, center: Vec3) {
        self.min = self.min.min(center);
        self.max = self.max.max(center);
    }

    /// Across the longest way. Cuts along gravity are preferred: within a subdomain, a sweep carries support up.
    fn choose_axis(&mut self, gravity: Vec3) {
        let along = gravity.normalize_or_zero().abs();
        let way = (self.max - self.min) * (Vec3::ONE - 0.5 * along);
        self.axis = way.max_position();
    }

    fn slab_of(&self, center: Vec3) -> usize {
        let (from, to) = (self.min[self.axis], self.max[self.axis]);
        let share = (center[self.axis] - from) / (to - from);
        ((CUT_PLACES as f32 * share) as usize).min(CUT_PLACES - 1)
    }

    /// Cuts where the halves are most nearly of a size.
    fn choose_slab(&mut self) {
        let all: u32 = self.counts.iter().sum();
        let mut below = 0;
        let mut least = u32::MAX;
        for (slab, count) in self.counts.iter().enumerate() {
            below += count;
            let difference = all.abs_diff(2 * below);
            if difference < least {
                (least, self.slab) = (difference, slab + 1);
            }
        }
    }
}

/// The halves of a level; what is behind them is not used.
type Level = [Half; MAX_LEAVES];

/// A body that is sorted into halves.
#[derive(Clone, Copy, Debug, Default)]
struct Sorted {
    /// Its center, m, if contacts move it.
    center: Option<Vec3>,
    half: u8,
    slab: u8,
}

/// Some of the bodies, and what is known of them alone.
struct BisectionPart<'a> {
    first: usize,
    bodies: &'a mut [Sorted],
    level: Level,
}

impl BisectionPart<'_> {
    fn load(&mut self, center: impl Fn(usize) -> Option<Vec3>) {
        for (number, body) in (self.first..).zip(&mut *self.bodies) {
            *body = Sorted {
                center: center(number),
                ..Sorted::default()
            };
            if let Some(center) = body.center {
                self.level[0].contain(center);
            }
        }
    }

    fn count(&mut self, level: &Level) {
        for body in &mut *self.bodies {
            if let Some(center) = body.center {
                let half = body.half as usize;
                let slab = level[half].slab_of(center);
                self.level[half].counts[slab] += 1;
                body.slab = slab as u8;
            }
        }
    }

    fn halve(&mut self, level: &Level) {
        self.level = Level::default();
        for body in &mut *self.bodies {
            if let Some(center) = body.center {
                let is_second = usize::from(body.slab) >= level[body.half as usize].slab;
                body.half = 2 * body.half + u8::from(is_second);
                self.level[body.half as usize].contain(center);
            }
        }
    }
}

/// Bodies in halves of halves; buffers are reused.
#[derive(Debug, Default)]
pub(crate) struct Bisection {
    bodies: Vec<Sorted>,
}

impl Bisection {
    /// Cuts `count` bodies into `leaves` leaves by their centers of mass, m; those that contacts do not move have none. Which
    /// leaf each body is in: for these the number of leaves.
    pub(crate) fn cut(
        &mut self,
        count: usize,
        center: impl Fn(usize) -> Option<Vec3> + Sync,
        gravity: Vec3,
        leaves: usize,
        team: Option<&Team>,
    ) -> impl Iterator<Item = u8> {
        self.bodies.resize(count, Sorted::default());
        let mut parts = self.parts(team);
        Team::each(team, parts.iter_mut(), |part| part.load(&center));
        for depth in 0..leaves.ilog2() {
            let mut level = Level::default();
            let halves = &mut level[..1 << depth];
            for (i, half) in halves.iter_mut().enumerate() {
                for part in &parts {
                    half.min = half.min.min(part.level[i].min);
                    half.max = half.max.max(part.level[i].max);
                }
                half.choose_axis(gravity);
            }
            Team::each(team, parts.iter_mut(), |part| part.count(&level));
            for (i, half) in level[..1 << depth].iter_mut().enumerate() {
                for part in &parts {
                    let counts = half.counts.iter_mut().zip(part.level[i].counts);
                    counts.for_each(|(all, count)| *all += count);
                }
                half.choose_slab();
            }
            Team::each(team, parts.iter_mut(), |part| part.halve(&level));
        }
        drop(parts);
        let leaf = move |body: &Sorted| body.center.map_or(leaves as u8, |_| body.half);
        self.bodies.iter().map(leaf)
    }

    fn parts(&mut self, team: Option<&Team>) -> SmallVec<[BisectionPart<'_>; MAX_PARTS]> {
        let count = self.bodies.len();
        let size = Team::part_size(team, count, MIN_BISECTED_BODIES);
        let mut rest = &mut self.bodies[..];
        let parts = (0..count).step_by(size).map(|first| BisectionPart {
            first,
            bodies: front_mut(&mut rest, size.min(count - first)),
            level: Level::default(),
        });
        parts.collect()
    }
}
