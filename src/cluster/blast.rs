//! What pushes on single parts do to what comes off.

use crate::cluster::elastic::Wrench;
use crate::cluster::hit::Push;
use crate::cluster::network::Network;
use glam::{DMat3, DVec3};

/// Some of the parts as one rigid body: what it weighs, and what it is pushed with.
#[derive(Clone, Copy, Debug)]
struct Group {
    mass: f64,
    center: DVec3,
    inertia: DMat3,
    /// Impulse and angular impulse about the center, N s and N m s.
    pushed: Wrench,
}

impl Group {
    fn of(network: &Network, parts: &[u32], pushes: &[Push]) -> Self {
        let (mass, center, inertia) = network.sum(parts.iter().copied());
        let mut pushed = Wrench::default();
        for push in pushes {
            if parts.binary_search(&push.part).is_ok() {
                let arm = network.nodes[push.part as usize].center - center;
                let force = push.impulse.as_dvec3();
                let torque = push.angular_impulse.as_dvec3() + arm.cross(force);
                pushed.add(Wrench { force, torque });
            }
        }
        Self {
            mass,
            center,
            inertia,
            pushed,
        }
    }

    /// What it takes to move with the whole.
    fn share_of(&self, whole: &Self) -> Wrench {
        let turning = whole.inertia.inverse() * whole.pushed.torque;
        let arm = self.center - whole.center;
        Wrench {
            force: self.mass * (whole.pushed.force / whole.mass + turning.cross(arm)),
            torque: self.inertia * turning,
        }
    }

    /// Energy that impulses give it while it rests, J.
    fn energy(&self, given: &Wrench) -> f64 {
        let spin = given.torque.dot(self.inertia.inverse() * given.torque);
        0.5 * (given.force.length_squared() / self.mass + spin)
    }
}

impl Network {
    /// Energy that pushes give to their parts, as if nothing held these, J.
    pub(crate) fn push_energy(&self, pushes: &[Push], is_held: impl Fn(u32) -> bool) -> f32 {
        let free = pushes.iter().filter(|push| !is_held(push.part));
        let energies = free.map(|push| {
            let group = Group::of(self, &[push.part], &[*push]);
            group.energy(&group.pushed)
        });
        energies.sum::<f64>() as f32
    }

    /// What each group of parts that comes off gets of the pushes, about its center, when the bonds took `work` (J).
    ///
    /// A group gets what its parts were pushed with, less so much of what moves it against the others that the work is taken out of that
    /// motion. The groups of a body that nothing holds (`is_free`) are all of it, and their impulses add up to those of the pushes, as do
    /// their moments; a body that stands bears the rest.
    pub(crate) fn pushed(
        &self,
        groups: &[Vec<u32>],
        pushes: &[Push],
        (is_free, work): (bool, f64),
    ) -> Vec<Wrench> {
        let all: Vec<u32> = (0..self.nodes.len() as u32).collect();
        let whole = Group::of(self, &all, pushes);
        let groups = groups.iter().map(|parts| Group::of(self, parts, pushes));
        let groups: Vec<Group> = groups.collect();
        let commons = groups.iter().map(|group| match is_free {
            true => group.share_of(&whole),
            false => Wrench::default(),
        });
        let commons: Vec<Wrench> = commons.collect();
        let owns = groups.iter().zip(&commons).map(|(group, common)| {
            let mut own = *common;
            own.scale(-1.0);
            own.add(group.pushed);
            own
        });
        let mut owns: Vec<Wrench> = owns.collect();
        let energies = groups.iter().zip(&owns);
        let energy: f64 = energies.map(|(group, own)| group.energy(own)).sum();
        let left = if energy > 0.0 {
            (1.0 - work / energy).max(0.0).sqrt()
        } else {
            0.0
        };
        for (own, common) in owns.iter_mut().zip(&commons) {
            own.scale(left);
            own.add(*common);
        }
        owns
    }
}
