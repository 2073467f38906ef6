//! What a sustained load does to the bonds: forces and moments as in an elastic body, and what of them is too much.
//!
//! Parts are rigid, and bonds are springs as stiff as the material of half of both parts is: along the normal in
//! proportion to `A / L`, across it to 0.4 times that, in bending to `I / L`, with the area `A`, its second moments `I`
//! and the distance `L` of the two centers. Of all forces in the bonds that bear the loads these have the least energy. The stress
//! at the corner of a face is that of a beam: `N / A + M_1 e_2 / I_1 + M_2 e_1 / I_2`. So a cantilever breaks where the moment at its
//! root is the strength times the section modulus.
//!
//! What the loads of a body that nothing holds leave over accelerates it, and inertia is a load too (d'Alembert). The bond that
//! bears most over its strength breaks, and what is left is solved anew, until nothing more breaks or something comes off.

use crate::cluster::elastic::{Elastic, Wrench};
use crate::cluster::network::Network;
use crate::cluster::sparse::Six;
use crate::geometry::PartBond;
use crate::geometry::groups_of;
use glam::DVec3;

/// Bonds break together that bear more than this share of what the one bears that bears most over its strength.
const TOGETHER: f64 = 0.98;

/// What a load does.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LoadOutcome {
    /// Bonds that broke, ascending.
    pub(crate) broken: Vec<u32>,
    /// The most that a bond that is left bears, as a share of its strength.
    pub(crate) utilization: f64,
}

impl LoadOutcome {
    fn of(is_broken: &[bool], utilization: f64) -> Self {
        let broken = (0..).zip(is_broken).filter(|(_, broken)| **broken);
        Self {
            broken: broken.map(|(bond, _)| bond).collect(),
            utilization,
        }
    }
}

impl Network {
    /// What `loads` (by part) do, besides inertia. `held`: by part, whether it holds on to the world; if none does, the body turns with
    /// `spin` (rad/s, frame of the compound). `elastic`: the system, if it is known; without the bonds that broke afterwards, and none if something
    /// comes off.
    ///
    /// None if `budget` (products of blocks) is used up before the system is ready: it goes on from there the next time. Where it is
    /// used up later, what has broken until then is told; if `is_first`, no more than what breaks first, with the system as it was.
    pub(crate) fn bear(
        &self,
        elastic: &mut Option<Box<Elastic>>,
        loads: &[Wrench],
        (held, spin): (&[bool], DVec3),
        (is_first, budget): (bool, &mut usize),
    ) -> Option<LoadOutcome> {
        let mut loads = loads.to_vec();
        if !held.contains(&true) {
            self.add_inertia(&mut loads, spin);
        }
        let none = vec![false; self.bonds.len()];
        let mut system =
            (elastic.take()).unwrap_or_else(|| Box::new(Elastic::new(self, held, &none)));
        let (mut broken, mut has_broken, mut utilization) = (none, false, 0.0);
        loop {
            if !system.prepare(budget) {
                if has_broken {
                    break;
                }
                *elastic = Some(system);
                return None;
            }
            *budget = budget.saturating_sub(system.cost_of_displacements());
            broken.copy_from_slice(system.is_broken());
            let shares = self.utilizations(&system, &loads);
            utilization = shares.iter().copied().fold(0.0, f64::max);
            if system.is_updated() && shares.iter().any(|share| share.is_nan()) {
                // Bonds that were taken out one by one have left nothing but rounding.
                *system = Elastic::new(self, held, &broken);
                continue;
            }
            // Where nothing is a number, nothing is known, and nothing breaks.
            if utilization <= 1.0 {
                break;
            }
            let most = (TOGETHER * utilization).max(1.0);
            let torn = (0..self.bonds.len()).filter(|&bond| shares[bond] >= most);
            torn.clone().for_each(|bond| broken[bond] = true);
            has_broken = true;
            if is_first {
                break;
            }
            let groups = groups_of(self.nodes.len(), &self.bonds, |bond| broken[bond]);
            if groups.iter().any(|&group| group != 0) {
                return Some(LoadOutcome::of(&broken, utilization));
            }
            system.leave_out(self, torn);
        }
        *elastic = Some(system);
        if !has_broken {
            broken.fill(false);
        }
        Some(LoadOutcome::of(&broken, utilization))
    }

    /// What each bond bears under these loads, as a share of its strength; nothing of what is broken.
    fn utilizations(&self, system: &Elastic, loads: &[Wrench]) -> Vec<f64> {
        let motion = system.displacements(self, loads);
        let shares = (0..).zip(system.is_broken()).map(|(bond, &is_broken)| {
            if is_broken {
                0.0
            } else {
                self.utilization(bond, &motion)
            }
        });
        shares.collect()
    }

    /// Adds what inertia does to each part of a body that the loads move.
    fn add_inertia(&self, loads: &mut [Wrench], spin: DVec3) {
        let (mass, center, inertia) = self.sum(0..self.nodes.len() as u32);
        let mut sum = Wrench::default();
        for (load, node) in loads.iter().zip(&self.nodes) {
            sum.force += load.force;
            sum.torque += load.torque + (node.center - center).cross(load.force);
        }
        let acceleration = sum.force / mass;
        let turning = inertia.inverse() * (sum.torque - spin.cross(inertia * spin));
        for (load, node) in loads.iter_mut().zip(&self.nodes) {
            let arm = node.center - center;
            let own = acceleration + turning.cross(arm) + spin.cross(spin.cross(arm));
            load.force -= node.mass * own;
            load.torque -= node.inertia * turning + spin.cross(node.inertia * spin);
        }
    }

    /// What a bond bears after these motions, as a share of its strength.
    fn utilization(&self, bond: usize, motion: &[Six]) -> f64 {
        let PartBond {
            normal,
            axis,
            half_extents,
            area,
            parts,
            ..
        } = &self.bonds[bond];
        let [strength, shear_strength] = self.bonds[bond].strengths().map(f64::from);
        let moved = parts.map(|part| motion[part as usize]);
        let split = |six: Six| {
            (
                DVec3::new(six[0], six[1], six[2]),
                DVec3::new(six[3], six[4], six[5]),
            )
        };
        let [(from_a, turn_a), (from_b, turn_b)] = moved.map(split);
        let [arm_a, arm_b] = self.arms(bond);
        let spring = self.spring(bond);
        let opened = (from_b + turn_b.cross(arm_b)) - (from_a + turn_a.cross(arm_a));
        let force = spring.along * opened;
        let moment = spring.turning * (turn_b - turn_a);
        let (normal, axis) = (normal.as_dvec3(), axis.as_dvec3());
        let across = normal.cross(axis);
        let (area, sides) = (f64::from(*area), half_extents.as_dvec2());
        let mean = force.dot(normal) / area;
        let bent = moment.dot(axis).abs() / sides.y + moment.dot(across).abs() / sides.x;
        let tension = mean + 3.0 * bent / area;
        let twisted = 3.0 * moment.dot(normal).abs() / (area * sides.length());
        let shear = force.reject_from_normalized(normal).length() / area + twisted;
        let bears = shear_strength + f64::from(self.friction) * (-mean).max(0.0);
        (tension / strength).max(shear / bears)
    }
}
