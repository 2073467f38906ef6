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

impl Network {
    /// What `loads` (by part) do, besides inertia. `held`: by part, whether it holds on to the world; if none does, the body turns with
    /// `spin` (rad/s, frame of the compound). `elastic`: the system, if it is known; none afterwards if bonds broke.
    ///
    /// None if `budget` (products of blocks) is used up before the system is ready: it goes on from there the next time. Where it is
    /// used up later, what has broken until then is told; if `is_first`, no more than what breaks first, with the system kept.
    pub(crate) fn bear(
        &self,
        elastic: &mut Option<Box<Elastic>>,
        loads: &[Wrench],
        (held, spin): (&[bool], DVec3),
        (is_first, budget): (bool, &mut usize),
    ) -> Option<LoadOutcome> {
        let mut is_broken = vec![false; self.bonds.len()];
        let mut loads = loads.to_vec();
        if !held.contains(&true) {
            self.add_inertia(&mut loads, spin);
        }
        let mut utilization = 0.0;
        loop {
            let known = elastic.take();
            let mut system =
                known.unwrap_or_else(|| Box::new(Elastic::new(self, held, &is_broken)));
            if !system.prepare(budget) {
                if is_broken.contains(&true) {
                    break;
                }
                *elastic = Some(system);
                return None;
            }
            let motion = system.displacements(self, &loads);
            let shares: Vec<f64> = (0..self.bonds.len())
                .map(|bond| {
                    if is_broken[bond] {
                        0.0
                    } else {
                        self.utilization(bond, &motion)
                    }
                })
                .collect();
            utilization = shares.iter().copied().fold(0.0, f64::max);
            // Not a number: nothing is known, and nothing breaks.
            if utilization.is_nan() || utilization <= 1.0 {
                *elastic = (!is_broken.contains(&true)).then_some(system);
                break;
            }
            let most = TOGETHER * utilization;
            for (is_broken, share) in is_broken.iter_mut().zip(&shares) {
                *is_broken |= *share >= most.max(1.0);
            }
            if is_first {
                *elastic = Some(system);
                break;
            }
            let groups = groups_of(self.nodes.len(), &self.bonds, |bond| is_broken[bond]);
            if groups.iter().any(|&group| group != 0) {
                break;
            }
        }
        let broken = (0..).zip(&is_broken).filter(|(_, broken)| **broken);
        Some(LoadOutcome {
            broken: broken.map(|(bond, _)| bond).collect(),
            utilization,
        })
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
