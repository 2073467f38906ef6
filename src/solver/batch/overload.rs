//! Bodies that break while a batch is being solved.

use crate::bodies::breaking::{BreakingLimit, ImpactLoad};
use crate::bodies::store::Bodies;
use crate::solver::batch::Batch;
use crate::solver::wide::block::vector;

impl Batch {
    /// Lists those of its bodies that may break.
    pub(crate) fn load_limits(&mut self, bodies: &Bodies) {
        if !bodies.any_fracturable() {
            return;
        }
        for (body, &slot) in (0..).zip(&self.layout.slots) {
            if let Some(limit) = bodies.limit(slot) {
                self.impacts.limits.push(BreakingLimit { body, ..limit });
            }
        }
        if !self.impacts.limits.is_empty() {
            self.impacts.start.clear();
            self.impacts
                .start
                .extend_from_slice(&self.bodies.velocities);
        }
    }

    /// Notes the bodies that are overloaded by the impulses of the step until now; whether there are any.
    pub(crate) fn find_overloaded(&mut self) -> bool {
        self.impacts.overloaded.clear();
        if self.impacts.limits.is_empty() {
            return false;
        }
        let mut loads = std::mem::take(&mut self.impacts.loads);
        loads.clear();
        loads.resize(self.bodies.velocities.len(), ImpactLoad::default());
        for block in &self.contacts.blocks {
            for lane in 0..block.used {
                let (pair, normal) = (block.pair(lane), vector(&block.normal, lane));
                let start = pair.map(|body| &self.impacts.start[body as usize]);
                for point in &self.contacts.points[block.points.clone()] {
                    let impulse = point.total_normal_impulse.0[lane] + point.impulse[0].0[lane];
                    if impulse > 0.0 {
                        let speed = -point.normal_velocity(lane, normal, start);
                        pair.iter()
                            .for_each(|&body| loads[body as usize].add(impulse, speed));
                    }
                }
            }
        }
        let overloaded = self.impacts.limits.iter().filter_map(|limit| {
            let load = loads[limit.body as usize];
            let is_over = limit.is_exceeded_by(&load);
            is_over.then_some((self.layout.slots[limit.body as usize], load))
        });
        self.impacts.overloaded.extend(overloaded);
        self.impacts.loads = loads;
        !self.impacts.overloaded.is_empty()
    }
}
