//! What turns is pulled inward: how much anchors are, before the motion has shown it.

use crate::solver::joint::system::{JointEndpoint, JointSystem};
use crate::solver::joint::vector6::split;

/// Largest turn in a sub-step that is expanded, rad.
const MOST_BEND: f64 = 0.25;

impl JointSystem {
    /// Tells the rows of anchors how much these are pulled inward as the bodies turn now: after `h` seconds they are off by
    /// `h^2 / 2 (omega_b x (omega_b x r_b) - omega_a x (omega_a x r_a))`, as long as the turn is small.
    pub(super) fn bend_rows(&mut self, h: f64) {
        for joint in &self.joints {
            let Some(now) = &joint.now else {
                continue;
            };
            let pull = [0, 1].map(|side| {
                let velocity = match joint.ends[side] {
                    JointEndpoint::Jointed(body) => &self.velocities[body as usize],
                    JointEndpoint::Fixed(body) => &self.fixed[body as usize].velocity,
                };
                let omega = split(velocity)[1];
                let is_small = (h * omega).length_squared() < MOST_BEND * MOST_BEND;
                is_small.then(|| omega.cross(omega.cross(now.r[side])))
            });
            let [Some(pull_on_a), Some(pull_on_b)] = pull else {
                continue;
            };
            let apart = 0.5 * (pull_on_b - pull_on_a);
            for row in &mut self.rows[joint.rows.clone()] {
                if row.is_of_anchor() {
                    row.curve = -split(&row.jacobian[1])[0].dot(apart);
                }
            }
        }
    }
}
