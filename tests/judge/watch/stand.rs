//! What is in balance stays where it is: no center of mass gets farther than a tenth of its body's least extent from where
//! it was put on its floor, which may move and turn. Contacts under load sag by 1.25e-4 of an extent each, so that 80 on top of each other are allowed a hundred times
//! what they may need.

use super::Worst;
use crate::judge::laws::{Breach, Law};
use crate::judge::run::Run;
use glam::DVec3;

/// Share of the least extent.
const SHIFT: f64 = 0.1;

pub(super) struct Stand {
    /// Slot of the floor.
    floor: Option<u32>,
    /// Where each dynamic body was put, in the floor's frame, m.
    start: Vec<DVec3>,
    worst: Worst,
}

impl Stand {
    pub(super) fn new(run: &Run<'_>) -> Self {
        let mut actors = run.scene.actors.iter().zip(&run.slots);
        let floor = actors.find(|(actor, _)| !actor.is_dynamic());
        let mut stand = Self {
            floor: floor.map(|(_, &slot)| slot),
            start: Vec::new(),
            worst: Worst::default(),
        };
        let places = run.dynamic().map(|(_, slot, _)| stand.place(run, slot));
        stand.start = places.collect();
        stand
    }

    /// Centre of mass of a body in the floor's frame, m.
    fn place(&self, run: &Run<'_>, slot: u32) -> DVec3 {
        let center = run.state(slot).center;
        self.floor.map_or(center, |floor| {
            let pose = run.simulation.bodies.pose(floor);
            let turn = pose.rotation.as_dquat().normalize();
            turn.inverse() * (center - pose.position.as_dvec3())
        })
    }

    pub(super) fn look(&mut self, run: &Run<'_>, step: u32) {
        for ((i, slot, _), start) in run.dynamic().zip(&self.start) {
            let (min_extent, _) = run.size(slot);
            let shift = self.place(run, slot).distance(*start);
            self.worst.note(shift / (SHIFT * min_extent), step, i);
        }
    }

    pub(super) fn breach(&self) -> Option<Breach> {
        self.worst.breach(Law::Stand, |worst| {
            let share = SHIFT * worst.excess;
            format!(
                "body {} is {share:.2} of its extent away in step {}",
                worst.actor, worst.step
            )
        })
    }
}
