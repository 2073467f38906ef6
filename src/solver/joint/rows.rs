//! Which rows a joint has, and what they aim at in the two halves of a sub-step.
//!
//! A sub-step of the bodies of joints is a leapfrog with constraints (RATTLE): half of the forces, velocities with which the bodies
//! are joined at its *end*, the motion, the other half of the forces, velocities that do not leave the joints. It is symmetric in
//! time, so a pendulum keeps its energy over any time, and its places and velocities are of second order in `h`.
//!
//! # References
//! Andersen, "Rattle: A 'Velocity' Version of the Shake Algorithm", J. Comput. Phys. 52, 1983; Leimkuhler and Skeel, "Symplectic
//! Numerical Integrators in Constrained Hamiltonian Systems", 1994.

use crate::joints::axis::{AxisRange, DriveTarget, JointAxis, JointDrive, JointSpring};
use crate::joints::joint::Joint;
use crate::solver::joint::measure::{DISTANCE, Frames, Measure};
use crate::solver::joint::row::{EPSILON, JointRow, RowKind, RowState};

/// Which rows of an axis there are: what holds it or its lower end, its upper end, drive, friction.
const HOLD: usize = 0;
const UPPER: usize = 1;
const DRIVE: usize = 2;
const FRICTION: usize = 3;

/// Share of a joint's levers (or angle, rad) from which it is apart by more than motion makes.
const FAR: f64 = 1e-4;

/// Share of the way of a sub-step that is left to a limit that is reached.
const NEAR: f64 = 1e-3;

/// A speed that nothing has, m/s or rad/s.
const BEYOND: f64 = 1e30;

/// What the rows of half a sub-step are told.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HalfSettings {
    /// Length of the sub-step, s.
    pub(crate) substep_dt: f64,
    /// For how long forces act in this half, s.
    pub(crate) kick: f64,
    /// Fastest speed at which what is apart is brought together, m/s and rad/s.
    pub(crate) push_out_speed: f64,
    /// Speed below which nothing comes back from a limit, m/s and rad/s, where bounces are long.
    pub(crate) restitution_threshold: f64,
    /// Speeds that gravity and forces give within the shortest bounce, and to what rests, m/s.
    pub(crate) short_and_rest: [f64; 2],
    /// Rebounds that lose less than this share of the speed are the less left out the less they lose.
    pub(crate) elastic: f64,
}

impl HalfSettings {
    /// Speed below which a row does not come back from its limit, as of contacts (`SubstepSettings::rebound_threshold`). `arm`: of the smaller body, m.
    fn rebound_threshold(&self, row: &JointRow, arm: f64) -> f64 {
        let asked = self.restitution_threshold;
        if row.restitution == 0.0 {
            return asked;
        }
        let arm = if row.is_angular { arm } else { 1.0 };
        let [short, rest] = self.short_and_rest.map(|speed| speed / arm);
        let share = ((1.0 - row.restitution) / self.elastic).min(1.0);
        (share * short.min(asked)).max(rest).min(asked)
    }
}

/// The axis of a joint by its number.
#[inline(always)]
pub(crate) fn axis_of(joint: &Joint, number: usize) -> &JointAxis {
    match number {
        DISTANCE => &joint.distance,
        3.. => &joint.angular[number - 3],
        _ => &joint.linear[number],
    }
}

/// Whether an axis has a spring.
#[inline]
pub(crate) fn has_spring(axis: &JointAxis) -> bool {
    let is_driven = |drive: &JointDrive| matches!(drive.target, DriveTarget::Position { .. });
    axis.softness.is_some() || axis.drive.as_ref().is_some_and(is_driven)
}

/// Whether an axis does not move.
pub(crate) fn is_held(axis: &JointAxis) -> bool {
    match axis.range {
        AxisRange::Locked => true,
        AxisRange::Limited { min, max } => min == max,
        AxisRange::Free => false,
    }
}

/// Adds the rows that a measure stands for. Mobilities: `J M^-1 J^T`, 1/kg, of the two bodies as they are, and for springs where what the joint
/// holds is held.
#[inline(always)]
pub(crate) fn add_rows(
    rows: &mut Vec<JointRow>,
    joint: &Joint,
    measure: &Measure,
    [mobility, of_spring]: [f64; 2],
) {
    let axis = axis_of(joint, measure.axis);
    let number = measure.axis;
    let row = |part: usize, kind: RowKind, position: f64| JointRow {
        slot: (4 * number + part) as u8,
        kind,
        is_angular: (3..DISTANCE).contains(&number),
        jacobian: measure.jacobian,
        position,
        restitution: f64::from(axis.restitution),
        mobility: match kind {
            RowKind::Spring(_) => of_spring,
            _ => mobility,
        },
        max_force: f64::INFINITY,
        ..JointRow::default()
    };
    let coefficients = |spring: JointSpring| coefficients(spring, of_spring);
    if measure.has_range {
        let limit = |part: usize, side: f64, position: f64| match axis.softness {
            Some(spring) => JointRow {
                side,
                ..row(part, RowKind::Spring(coefficients(spring)), position)
            },
            None => JointRow {
                side,
                ..row(part, RowKind::Limit, position)
            },
        };
        match axis.range {
            _ if measure.is_cone => rows.push(limit(HOLD, 1.0, measure.value)),
            AxisRange::Free => {}
            AxisRange::Locked => rows.push(row(HOLD, RowKind::Equality, measure.value)),
            AxisRange::Limited { min, max } if min == max => {
                let position = measure.value - f64::from(min);
                rows.push(row(HOLD, RowKind::Equality, position));
            }
            AxisRange::Limited { min, max } => {
                // No distance is less than none: anchors of a rope pass each other.
                if number != DISTANCE || min > 0.0 {
                    rows.push(limit(HOLD, 1.0, measure.value - f64::from(min)));
                }
                rows.push(limit(UPPER, -1.0, measure.value - f64::from(max)));
            }
        }
    }
    if measure.is_driven {
        add_drive(rows, axis, (measure.value, of_spring), &row);
    }
}

/// Adds the rows of a drive and of friction; `row` makes those of the axis.
fn add_drive(
    rows: &mut Vec<JointRow>,
    axis: &JointAxis,
    (value, of_spring): (f64, f64),
    row: &impl Fn(usize, RowKind, f64) -> JointRow,
) {
    if let Some(drive) = axis.drive {
        let (kind, position) = match drive.target {
            DriveTarget::Velocity(velocity) => (RowKind::Velocity(velocity.into()), 0.0),
            DriveTarget::Position { position, spring } => {
                let kind = RowKind::Spring(coefficients(spring, of_spring));
                (kind, value - f64::from(position))
            }
        };
        rows.push(JointRow {
            max_force: drive.max_force.into(),
            ..row(DRIVE, kind, position)
        });
    }
    if axis.friction > 0.0 {
        rows.push(JointRow {
            max_force: axis.friction.into(),
            ..row(FRICTION, RowKind::Velocity(0.0), 0.0)
        });
    }
}

/// What keeps a row's place, among other measures of its joint.
pub(crate) fn measure_of<'m>(measures: &'m [Measure], row: &JointRow) -> Option<&'m Measure> {
    measures
        .iter()
        .find(|measure| measure.axis == row.axis() && measure.has_range)
}

/// How far a row that keeps a place is from where it should be, elsewhere than where it was written.
#[inline(always)]
pub(crate) fn position_of(
    joint: &Joint,
    frames: &Frames,
    last: f64,
    row: &JointRow,
) -> Option<f64> {
    let (value, is_cone) = frames.value(joint, row.axis(), last)?;
    let part = usize::from(row.slot) % 4;
    let place = match axis_of(joint, row.axis()).range {
        AxisRange::Limited { min, .. } if part == HOLD && !is_cone => min,
        AxisRange::Limited { max, .. } if !is_cone => max,
        _ => 0.0,
    };
    Some(value - f64::from(place))
}

/// Stiffness and damping of a spring on a row.
fn coefficients(spring: JointSpring, mobility: f64) -> [f64; 2] {
    match spring {
        JointSpring::Frequency {
            hertz,
            damping_ratio,
        } => {
            let omega = std::f64::consts::TAU * f64::from(hertz);
            let mass = if mobility > 0.0 { 1.0 / mobility } else { 0.0 };
            [
                mass * omega * omega,
                2.0 * f64::from(damping_ratio) * omega * mass,
            ]
        }
        JointSpring::Coefficients { stiffness, damping } => [stiffness.into(), damping.into()],
    }
}

impl JointRow {
    /// Number of its axis.
    #[inline(always)]
    fn axis(&self) -> usize {
        usize::from(self.slot) / 4
    }

    /// Whether it holds an anchor along an axis.
    #[inline(always)]
    pub(crate) fn is_of_anchor(&self) -> bool {
        self.axis() < 3 && self.always_acts()
    }

    /// Aims at where the bodies are to be at the end of the sub-step. `swing`: `h^2 k J M^-1 J^T` of all springs of the two bodies;
    /// `slack`: what rounding of places leaves open, m or rad; `size`: the joint's levers, m, or 1 rad.
    ///
    /// What motion leaves open is so little that it is closed on the way. More than that was not made by motion: bodies were put
    /// where they are, and are pushed to where they belong without getting the velocity.
    #[inline(always)]
    pub(crate) fn aim_ahead(&mut self, half: &HalfSettings, swing: f64, [slack, size]: [f64; 2]) {
        let h = half.substep_dt;
        self.act_for(half.kick);
        match self.kind {
            RowKind::Equality | RowKind::Limit => {
                let most = half.push_out_speed * h;
                let is_inside = self.side * self.position > 0.0;
                let off = self.position.abs();
                let is_far = !is_inside && off > slack + FAR * size;
                let is_round = !is_inside && off <= slack;
                self.goal = if is_far || is_round {
                    self.position
                } else {
                    0.0
                };
                self.push = if is_far {
                    -self.position.clamp(-most, most)
                } else {
                    0.0
                };
                if is_far {
                    self.curve = 0.0;
                }
                self.target = (self.goal - self.position) / h + self.curve * h;
                self.stiffness = rigid(self.mobility);
            }
            RowKind::Velocity(velocity) => {
                self.target = velocity;
                self.stiffness = rigid(self.mobility);
            }
            RowKind::Spring(_) => self.pull(half, swing),
        }
    }

    /// Aims at velocities that do not leave the joint, where the bodies are now.
    /// `arm`: of the joint, m.
    #[inline(always)]
    pub(crate) fn aim_along(&mut self, half: &HalfSettings, swing: f64, arm: f64) {
        let is_fresh = half.kick > 0.0;
        let has_acted = self.side * self.impulse > 0.0;
        if is_fresh {
            self.spent = self.impulse;
            self.impulse = 0.0;
        }
        // Beside contacts no force acts in the second half, and those of the first stay within their bounds.
        if is_fresh || self.is_position() {
            self.act_for(half.kick);
        }
        match self.kind {
            RowKind::Equality => {
                self.target = 0.0;
                self.stiffness = rigid(self.mobility);
            }
            RowKind::Limit => {
                let approach = -self.side * self.velocity_before;
                let is_there = self.side * self.position <= NEAR * approach * half.substep_dt;
                let returns =
                    (has_acted || is_there) && approach > half.rebound_threshold(self, arm);
                self.target = if returns {
                    self.side * self.restitution * approach
                } else if !has_acted && self.side * self.position > 0.0 {
                    // What is to come back comes to the end with all of its speed.
                    if self.restitution > 0.0 {
                        self.let_go();
                        -self.side * BEYOND
                    } else {
                        -self.position / half.substep_dt
                    }
                } else {
                    0.0
                };
                self.stiffness = rigid(self.mobility);
            }
            RowKind::Velocity(velocity) => {
                self.target = velocity;
                self.stiffness = rigid(self.mobility);
            }
            RowKind::Spring(_) if is_fresh => self.pull(half, swing),
            RowKind::Spring(_) => {
                self.base = self.impulse;
                self.stiffness = 0.0;
            }
        }
    }

    /// Has a limit not act. One that did, as where a motion was looked for at which it is reached, would be asked for a speed that nothing has:
    /// a body was turned by 1e14 rad/s.
    fn let_go(&mut self) {
        self.state = if self.side > 0.0 {
            RowState::AtLeast
        } else {
            RowState::AtMost
        };
    }

    /// Sets the bounds of what forces may do in a time.
    #[inline(always)]
    fn act_for(&mut self, kick: f64) {
        let most = match self.kind {
            RowKind::Velocity(_) | RowKind::Spring(_) => kick * self.max_force,
            RowKind::Equality | RowKind::Limit => f64::INFINITY,
        };
        let least = if self.side > 0.0 { 0.0 } else { -most };
        let most = if self.side < 0.0 { 0.0 } else { most };
        self.bounds = [least, most];
    }

    fn pull(&mut self, half: &HalfSettings, swing: f64) {
        let RowKind::Spring([stiffness, damping]) = self.kind else {
            return;
        };
        let theta = swing / (1.0 + swing);
        // What gives way at an end damps nothing before that is reached.
        let is_inside = self.side * self.position > 0.0;
        let damping = if is_inside { 0.0 } else { damping };
        self.base = -half.kick * stiffness * self.position;
        self.stiffness = half.kick * (damping + theta * half.substep_dt * stiffness);
        self.target = 0.0;
    }

    /// `h^2 k J M^-1 J^T` of a spring.
    pub(crate) fn swing(&self, substep_dt: f64) -> f64 {
        match self.kind {
            RowKind::Spring([stiffness, _]) => substep_dt * substep_dt * stiffness * self.mobility,
            _ => 0.0,
        }
    }

    /// Energy in a spring, J.
    pub(crate) fn stored_energy(&self) -> f64 {
        match self.kind {
            RowKind::Spring([stiffness, _]) if self.state == RowState::Free => {
                0.5 * stiffness * self.position * self.position
            }
            _ => 0.0,
        }
    }
}

/// Stiffness of a rigid row; nothing acts on what nothing moves.
#[inline(always)]
fn rigid(mobility: f64) -> f64 {
    if mobility > 0.0 {
        1.0 / (EPSILON * mobility)
    } else {
        0.0
    }
}
