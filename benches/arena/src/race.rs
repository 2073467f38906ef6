//! Two worlds that make their steps in turns, so that both see the machine when it is fast and when it is slow.

use crate::job::cpu_ms;

/// Length of a step, s.
pub(crate) const H: f32 = 1.0 / 60.0;

/// Something that makes steps.
pub(crate) trait World {
    fn step(&mut self);
}

impl World for bevy_cleave::prelude::Simulation {
    fn step(&mut self) {
        bevy_cleave::prelude::Simulation::step(self, H);
    }
}

impl World for bevy_app::App {
    fn step(&mut self) {
        self.update();
    }
}

#[cfg(feature = "rapier")]
impl World for rapier3d::prelude::PhysicsWorld {
    fn step(&mut self) {
        rapier3d::prelude::PhysicsWorld::step(self);
    }
}

/// CPU times of steps of both from one step to another, ms: the median of each span.
pub(crate) fn race(worlds: [&mut dyn World; 2], spans: &[[usize; 2]]) -> Vec<[f64; 2]> {
    let end = spans.iter().map(|[_, end]| *end).max();
    let mut times = [Vec::new(), Vec::new()];
    for step in 0..end.unwrap_or_default() {
        for turn in 0..2 {
            let side = (turn + step) % 2;
            let begun = cpu_ms();
            worlds[side].step();
            times[side].push(cpu_ms() - begun);
        }
    }
    let median = |times: &[f64]| {
        let mut sorted = times.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    };
    let of = |&[from, to]: &[usize; 2]| [0, 1].map(|side| median(&times[side][from..to]));
    spans.iter().map(of).collect()
}
