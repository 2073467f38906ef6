//! One run of a scene, with sleep on, and the laws that can be read off it.

mod energy;
mod momentum;
mod overlap;
mod rest;
mod stand;
mod tunnel;

use super::laws::{Breach, Law};
use super::run::Run;
use super::scene::{Role, Scene};
use energy::Energy;
use momentum::Momentum;
use overlap::Overlap;
use rest::Rest;
use stand::Stand;
use tunnel::Tunnel;

/// The laws of one run that the scene breaks.
pub(crate) fn judge(scene: &Scene) -> Vec<Breach> {
    let scene = &scene.version(Role::Here);
    let Some(mut run) = Run::new(scene, true) else {
        // The shrinker tries shapes that are none.
        return Vec::new();
    };
    run.weigh();
    let mut watches = Watches::new(&run);
    for step in 1..=scene.steps {
        run.step();
        if let Some(breach) = not_finite(&run, step) {
            return vec![breach];
        }
        watches.look(&run, step);
        if watches.rest.is_over() {
            break;
        }
    }
    let breaches = watches.breaches(&run).into_iter().flatten();
    breaches.filter(|breach| scene.has(breach.law)).collect()
}

/// What is looked at in each step.
pub(crate) struct Watches {
    energy: Energy,
    momentum: Momentum,
    overlap: Option<Overlap>,
    rest: Rest,
    stand: Stand,
    tunnel: Tunnel,
}

impl Watches {
    pub(crate) fn new(run: &Run<'_>) -> Self {
        Self {
            energy: Energy::new(run),
            momentum: Momentum::new(run),
            // The only one that costs much.
            overlap: run.scene.has(Law::Overlap).then(|| Overlap::new(run)),
            rest: Rest::new(run),
            stand: Stand::new(run),
            tunnel: Tunnel::new(run),
        }
    }

    pub(crate) fn look(&mut self, run: &Run<'_>, step: u32) {
        self.energy.look(run, step);
        self.momentum.look(run, step);
        self.stand.look(run, step);
        self.tunnel.look(run, step);
        self.rest.look(run, step);
        if let Some(overlap) = &mut self.overlap {
            overlap.look(run, step);
        }
    }

    pub(crate) fn breaches(self, run: &Run<'_>) -> [Option<Breach>; 7] {
        [
            self.energy.breach(),
            self.energy.loss(),
            self.momentum.breach(),
            self.overlap.and_then(|overlap| overlap.breach(run)),
            self.stand.breach(),
            self.tunnel.breach(),
            self.rest.breach(run),
        ]
    }
}

/// Whether a body has no state any more or was left out.
fn not_finite(run: &Run<'_>, step: u32) -> Option<Breach> {
    let is_finite = run
        .dynamic()
        .all(|(_, slot, _)| run.state(slot).is_finite());
    (run.had_problems || !is_finite).then(|| Breach {
        law: Law::Finite,
        excess: f64::INFINITY,
        what: format!("a body was left out or is nowhere in step {step}"),
    })
}

/// The worst that was seen of something, as a multiple of its bound.
#[derive(Clone, Copy, Debug, Default)]
struct Worst {
    excess: f64,
    step: u32,
    actor: usize,
}

impl Worst {
    fn note(&mut self, excess: f64, step: u32, actor: usize) {
        if excess > self.excess {
            *self = Self {
                excess,
                step,
                actor,
            };
        }
    }

    /// A breach if the bound was passed.
    fn breach(&self, law: Law, what: impl Fn(&Self) -> String) -> Option<Breach> {
        (self.excess > 1.0).then(|| Breach {
            law,
            excess: self.excess,
            what: what(self),
        })
    }
}
