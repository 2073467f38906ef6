//! A large island cut into domains, so that several threads sweep over it at a time without touching each other's bodies.
//!
//! Bodies are halved by planes, and the halves again. What joins two bodies of one leaf belongs to it, what crosses a cut
//! belongs to the separator there:
//!
//! ```text
//! stage 0   leaf 0   leaf 1   leaf 2   leaf 3      side by side
//! stage 1     separator 0|1     separator 2|3      side by side
//! stage 2         separator 01|23                  alone
//! ```
//!
//! A sweep goes through the domains in this order on any number of threads: which domains there are follows from the scene
//! alone. Each domain keeps the order of its manifolds. A thread keeps to its leaves, whose data stay in its cache; stages of
//! a colouring would hand half of all bodies to the other core dozens of times per sweep.

use glam::Vec3;

/// Least manifolds of a leaf, on average: some 50 us of a sweep, a hundred times what threads need to meet.
pub const LEAST_MANIFOLDS: usize = 1000;

/// Most leaves.
const MOST_LEAVES: usize = 8;

/// Places for a cut along an axis. Odd, so that none is in the middle, where symmetric structures have bodies that rounding
/// would move across.
const SLABS: usize = 61;

/// Number of leaves of an island with `manifolds` manifolds: a power of two.
pub fn leaves(manifolds: usize) -> usize {
    let most = (manifolds / LEAST_MANIFOLDS).clamp(1, MOST_LEAVES);
    1 << most.ilog2()
}

/// Which bodies are in which leaf; buffers are reused.
#[derive(Debug, Default)]
pub struct Domains {
    leaves: usize,
    /// By number of a body.
    leaf: Vec<u8>,
    /// By half that is being cut.
    cuts: Vec<Cut>,
}

/// A cut of some bodies in two.
#[derive(Clone, Debug)]
struct Cut {
    min: Vec3,
    max: Vec3,
    axis: usize,
    /// Bodies by slab.
    counts: [u32; SLABS],
    /// The first slab of the second half.
    slab: usize,
}

impl Default for Cut {
    fn default() -> Self {
        Self {
            min: Vec3::INFINITY,
            max: Vec3::NEG_INFINITY,
            axis: 0,
            counts: [0; SLABS],
            slab: 0,
        }
    }
}

impl Cut {
    /// Across the longest way. Cuts along gravity are preferred: within a domain, a sweep carries support up.
    fn choose_axis(&mut self, gravity: Vec3) {
        let along = gravity.normalize_or_zero().abs();
        let way = (self.max - self.min) * (Vec3::ONE - 0.5 * along);
        self.axis = way.max_position();
    }

    fn slab_of(&self, centre: Vec3) -> usize {
        let (from, to) = (self.min[self.axis], self.max[self.axis]);
        let share = (centre[self.axis] - from) / (to - from);
        ((SLABS as f32 * share) as usize).min(SLABS - 1)
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

impl Domains {
    /// Cuts bodies into `leaves` leaves, by their centres of mass, m; those that contacts do not move have none (`None`), and
    /// are in no leaf.
    pub fn cut(
        &mut self,
        centres: impl Iterator<Item = Option<Vec3>> + Clone,
        gravity: Vec3,
        leaves: usize,
    ) {
        self.leaves = leaves;
        self.leaf.clear();
        self.leaf.extend(centres.clone().map(|_| 0));
        for level in 0..leaves.ilog2() {
            self.halve(centres.clone(), gravity, 1 << level);
        }
    }

    /// Cuts each of `count` parts in two.
    fn halve(
        &mut self,
        centres: impl Iterator<Item = Option<Vec3>> + Clone,
        gravity: Vec3,
        count: usize,
    ) {
        let Self { leaf, cuts, .. } = self;
        cuts.clear();
        cuts.resize(count, Cut::default());
        for (leaf, centre) in leaf.iter().zip(centres.clone()) {
            if let Some(centre) = centre {
                let cut = &mut cuts[*leaf as usize];
                cut.min = cut.min.min(centre);
                cut.max = cut.max.max(centre);
            }
        }
        cuts.iter_mut().for_each(|cut| cut.choose_axis(gravity));
        for (leaf, centre) in leaf.iter().zip(centres.clone()) {
            if let Some(centre) = centre {
                let cut = &mut cuts[*leaf as usize];
                let slab = cut.slab_of(centre);
                cut.counts[slab] += 1;
            }
        }
        cuts.iter_mut().for_each(Cut::choose_slab);
        for (leaf, centre) in leaf.iter_mut().zip(centres) {
            let cut = &cuts[*leaf as usize];
            let is_second = centre.is_some_and(|centre| cut.slab_of(centre) >= cut.slab);
            *leaf = 2 * *leaf + u8::from(is_second);
        }
    }

    /// The domain of a manifold that joins these bodies; of bodies that contacts do not move, `None`.
    pub fn of(&self, bodies: [Option<u32>; 2]) -> u32 {
        let [Some(a), Some(b)] = bodies else {
            let body = bodies.into_iter().flatten().next();
            return body.map_or(0, |body| u32::from(self.leaf[body as usize]));
        };
        let [a, b] = [a, b].map(|body| u32::from(self.leaf[body as usize]));
        // The stage that brings both together; before it come `n + n / 2 + ...` domains.
        let stage = u32::BITS - (a ^ b).leading_zeros();
        let count = self.leaves as u32;
        2 * count - (2 * count >> stage) + (a >> stage)
    }

    /// Number of domains.
    pub fn count(&self) -> usize {
        2 * self.leaves - 1
    }
}

/// Number of domains of each stage of an island with `domains` domains.
pub fn stages(domains: usize) -> impl Iterator<Item = usize> {
    let leaves = domains.div_ceil(2);
    (0..=leaves.ilog2()).map(move |stage| leaves >> stage)
}
