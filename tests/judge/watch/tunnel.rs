//! Nothing gets to the other side of a plate that it is shot at.

use super::Worst;
use crate::judge::laws::{Breach, Law};
use crate::judge::run::Run;
use crate::judge::scene::{Actor, Form};
use bevy_cleave::testing::math::rotate;
use glam::{DVec3, Vec3};

/// A plate: a point in its middle and its normal, and which actor it is.
struct Plate {
    middle: DVec3,
    normal: DVec3,
}

pub(super) struct Tunnel {
    plates: Vec<Plate>,
    /// On which side of each plate each body started, m.
    start: Vec<f64>,
    worst: Worst,
}

impl Tunnel {
    pub(super) fn new(run: &Run<'_>) -> Self {
        let plates = run.scene.actors.iter().filter_map(Plate::of);
        let mut tunnel = Self {
            plates: plates.collect(),
            start: Vec::new(),
            worst: Worst::default(),
        };
        tunnel.start = tunnel.sides(run);
        tunnel
    }

    /// How far each body's center of mass is above each plate's middle, m.
    fn sides(&self, run: &Run<'_>) -> Vec<f64> {
        let bodies = run.dynamic().map(|(_, slot, _)| run.state(slot).center);
        let sides = bodies.flat_map(|center| {
            let plates = self.plates.iter();
            plates.map(move |plate| plate.normal.dot(center - plate.middle))
        });
        sides.collect()
    }

    pub(super) fn look(&mut self, run: &Run<'_>, step: u32) {
        for (now, start) in self.sides(run).into_iter().zip(&self.start) {
            if now * start < 0.0 {
                self.worst.note(f64::INFINITY, step, 0);
            }
        }
    }

    pub(super) fn breach(&self) -> Option<Breach> {
        self.worst.breach(Law::Tunnel, |worst| {
            format!("a body is behind the plate in step {}", worst.step)
        })
    }
}

impl Plate {
    fn of(actor: &Actor) -> Option<Self> {
        let Form::Box(size) = actor.form else {
            return None;
        };
        let thin = Vec3::AXES
            .into_iter()
            .min_by(|a, b| a.dot(size).total_cmp(&b.dot(size)))?;
        (!actor.is_dynamic()).then(|| Self {
            middle: actor.pose.position.as_dvec3(),
            normal: rotate(actor.pose.rotation, thin).as_dvec3(),
        })
    }
}
