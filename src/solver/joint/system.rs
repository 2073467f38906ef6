//! The bodies and joints of a batch, and the velocities that satisfy them.

use crate::joints::joint::Joint;
use crate::simd::lanes::LaneWidth;
use crate::solver::joint::body::{FixedBody, JointedBody};
use crate::solver::joint::borne::Borne;
use crate::solver::joint::factor::Factor;
use crate::solver::joint::measure::{Frames, Place, has_angles};
use crate::solver::joint::rounds::Rounds;
use crate::solver::joint::row::JointRow;
use crate::solver::joint::sparsity::{EdgeBlock, Sparsity};
use crate::solver::joint::stiffening::Stiffening;
use crate::solver::joint::vector6::Vector6;
use glam::{DQuat, DVec3, Vec3};
use std::ops::Range;

/// What a joint holds on to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum JointEndpoint {
    /// One of the jointed bodies.
    Jointed(u32),
    /// One of the fixed ones.
    Fixed(u32),
}

/// A joint in a batch.
#[derive(Clone, Debug)]
pub(crate) struct BatchJoint {
    pub(crate) joint: Joint,
    pub(crate) ends: [JointEndpoint; 2],
    /// From the centers of mass to the anchors, body's axes, m.
    pub(crate) anchors: [DVec3; 2],
    /// `body_from_joint`.
    pub(crate) frames: [DQuat; 2],
    /// Length of its levers, m; of anchors at centers of mass as long as what it joins is large.
    pub(super) levers: f64,
    /// From the center of mass of the smaller body to its anchor, or to where its mass is, m.
    pub(super) arm: f64,
    /// Whether angles make rows of it.
    pub(crate) has_angles: bool,
    /// The component of connected bodies that it belongs to.
    pub(super) component: u32,
    /// Its rows.
    pub(crate) rows: Range<usize>,
    /// The block that couples its bodies.
    pub(super) edge: Option<EdgeBlock>,
    /// Which of its ends is eliminated by its rows, if one is.
    pub(super) link: Option<usize>,
    /// Where it is now.
    pub(crate) now: Option<Frames>,
    /// Twist, counted on over full turns, rad.
    pub(crate) angle: f64,
    /// Force on B at its anchor that may make bodies hard to turn, N.
    pub(crate) tension: Vec3,
    /// Impulse on B in the step, and about B's anchor, N s and N m s.
    pub(crate) impulse: [DVec3; 2],
    /// Largest error of what is held in the step, m and rad.
    pub(crate) error: [f64; 2],
    /// What rounding of places leaves open, m.
    pub(crate) slack: f64,
}

/// Where the solution of a component of connected bodies has come to.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Component {
    /// Whether it is to be solved for.
    pub(super) is_asked: bool,
    /// Whether it was, in the round before.
    pub(super) was_asked: bool,
    /// Whether the factor is not that of its rows as they are.
    pub(super) is_stale: bool,
    /// Whether its factor is being made.
    pub(super) is_renewed: bool,
    /// Whether a rigid row that acted no longer does, since the search for those that act began.
    pub(super) has_let_go: bool,
}

/// A step as it ended.
#[derive(Debug, Default)]
pub(super) struct Ended {
    /// Whether the rows are those of these joints and bodies.
    pub(super) is_written: bool,
    pub(super) bodies: Vec<JointedBody>,
    pub(super) fixed: Vec<FixedBody>,
    pub(super) joints: Vec<BatchJoint>,
}

/// The problem.
#[derive(Debug, Default)]
pub(crate) struct JointSystem {
    pub(crate) bodies: Vec<JointedBody>,
    pub(crate) velocities: Vec<Vector6>,
    pub(crate) fixed: Vec<FixedBody>,
    pub(crate) joints: Vec<BatchJoint>,
    pub(crate) rows: Vec<JointRow>,
    pub(super) old_rows: Vec<JointRow>,
    /// The step before, whose rows are still there.
    pub(super) before: Ended,
    /// Whether the rows are those of the joints where they are.
    pub(super) is_written: bool,
    /// Whether the rows know how much what turns is pulled inward.
    pub(super) is_bent: bool,
    edges: Vec<[u32; 2]>,
    /// By body: whether joints hold it to what they do not move.
    held: Vec<bool>,
    /// By place: where the joints begin by whose rows the body is eliminated, and the end of all; and these.
    pub(super) link_starts: Vec<u32>,
    pub(super) link_joints: Vec<u32>,
    /// Softness of rows that push, as [`EPSILON`](super::row::EPSILON).
    pub(crate) push_softness: f64,
    /// Registers of loops over bodies and rows.
    pub(crate) width: LaneWidth,
    pub(super) sparsity: Sparsity,
    pub(super) factor: Factor,
    pub(super) components: Vec<Component>,
    /// Whether there are springs among the rows.
    pub(super) has_springs: bool,
    /// Whether there are rows that do not always act.
    pub(super) has_bounds: bool,
    /// Time for which springs act in the factor, and length of its sub-step, s.
    pub(super) factored_for: [f64; 2],
    /// What its bodies bear that turns them.
    pub(super) stiffening: Stiffening,
    /// Changes of velocities, by place in the order.
    pub(super) changes: Vec<Vector6>,
    /// By body: velocities that it is pushed with in this sub-step, and does not keep; empty if none is.
    pub(crate) pushes: Vec<Vector6>,
    /// Impulses that rows miss.
    pub(super) missing: Vec<f64>,
    /// The search for where bodies are to go.
    pub(super) rounds: Rounds,
    /// What joints in loops bear.
    pub(super) borne: Borne,
}

impl JointSystem {
    /// Begins a step. What the one before has written is kept, and in which order bodies are eliminated.
    pub(crate) fn clear(&mut self) {
        std::mem::swap(&mut self.bodies, &mut self.before.bodies);
        std::mem::swap(&mut self.fixed, &mut self.before.fixed);
        std::mem::swap(&mut self.joints, &mut self.before.joints);
        self.before.is_written = std::mem::take(&mut self.is_written);
        self.bodies.clear();
        self.velocities.clear();
        self.fixed.clear();
        self.joints.clear();
    }

    /// Adds a joint.
    pub(crate) fn add_joint(
        &mut self,
        joint: Joint,
        ends: [JointEndpoint; 2],
        anchors: [DVec3; 2],
        angle: f64,
    ) {
        let frames = [joint.frame_a, joint.frame_b].map(|frame| frame.rotation.as_dquat());
        let arm = |side: usize| match ends[side] {
            JointEndpoint::Jointed(body) => {
                let extent = self.bodies[body as usize].gyration();
                anchors[side].length().max(extent)
            }
            JointEndpoint::Fixed(_) => f64::INFINITY,
        };
        let arm = arm(0).min(arm(1));
        self.joints.push(BatchJoint {
            levers: (anchors[0].length() + anchors[1].length()).max(arm),
            arm,
            has_angles: has_angles(&joint),
            joint: joint.with_directions(),
            ends,
            anchors,
            frames: frames.map(DQuat::normalize),
            component: 0,
            rows: 0..0,
            edge: None,
            link: None,
            now: None,
            angle,
            tension: Vec3::ZERO,
            impulse: [DVec3::ZERO; 2],
            error: [0.0; 2],
            slack: 0.0,
        });
    }

    /// Orders the bodies, once all are there.
    pub(crate) fn analyse(&mut self) {
        self.edges.clear();
        let pairs = self.joints.iter().filter_map(BatchJoint::pair);
        self.edges.extend(pairs);
        self.held.clear();
        self.held.resize(self.bodies.len(), false);
        for joint in self.joints.iter().filter(|joint| joint.pair().is_none()) {
            for body in joint.jointed() {
                self.held[body] = true;
            }
        }
        self.sparsity.analyse(&self.held, &self.edges);
        let mut blocks = self.sparsity.edge_blocks.iter();
        for joint in &mut self.joints {
            joint.edge = joint.pair().and_then(|_| blocks.next().copied());
            let body = joint.jointed().next();
            joint.component = body.map_or(0, |body| self.sparsity.components[body]);
        }
        self.find_links();
        self.find_loops();
    }

    /// Where an end of a joint is, as its rows are written.
    #[inline(always)]
    pub(super) fn place(&self, end: JointEndpoint) -> Place {
        match end {
            JointEndpoint::Jointed(body) => {
                let body = &self.bodies[body as usize];
                Place {
                    center: body.center,
                    rotation: body.rotation,
                }
            }
            JointEndpoint::Fixed(body) => self.fixed[body as usize].place,
        }
    }

    /// Twist of a joint, rad; of one without rows of angles it is counted on from step to step only.
    pub(crate) fn angle(&self, joint: &BatchJoint) -> f64 {
        if joint.has_angles {
            return joint.angle;
        }
        let [a, b] = joint.ends.map(|end| self.place(end));
        let frames = Frames::of([&a, &b], joint.anchors, joint.frames, true);
        frames.twist(joint.angle)
    }

    /// The factor is none of the rows any more.
    pub(super) fn outdate(&mut self) {
        for component in &mut self.components {
            component.is_stale = true;
        }
    }

    /// Whether a joint is among those that are to be solved.
    #[inline(always)]
    pub(super) fn is_asked(&self, joint: &BatchJoint) -> bool {
        self.components[joint.component as usize].is_asked
    }

    /// Ends a sub-step: takes note of how far off the joints are too.
    pub(crate) fn end_substep(&mut self, are_alone: bool) {
        self.note_impulses(are_alone);
        for joint in &mut self.joints {
            for row in &self.rows[joint.rows.clone()] {
                if row.side == 0.0 && row.is_position() {
                    let error = &mut joint.error[usize::from(row.is_angular)];
                    *error = error.max(row.position.abs());
                }
            }
        }
    }
}

impl BatchJoint {
    /// Its bodies that joints move.
    pub(super) fn jointed(&self) -> impl Iterator<Item = usize> + use<> {
        let ends = self.ends.into_iter();
        ends.filter_map(|end| match end {
            JointEndpoint::Jointed(body) => Some(body as usize),
            JointEndpoint::Fixed(_) => None,
        })
    }

    /// Its bodies, if joints move both.
    pub(super) fn pair(&self) -> Option<[u32; 2]> {
        match self.ends {
            [JointEndpoint::Jointed(a), JointEndpoint::Jointed(b)] => Some([a, b]),
            _ => None,
        }
    }

    /// Velocities of its bodies that joints move.
    #[inline(always)]
    pub(crate) fn velocities<'v>(&self, velocities: &'v [Vector6]) -> [Option<&'v Vector6>; 2] {
        self.ends.map(|end| match end {
            JointEndpoint::Jointed(body) => Some(&velocities[body as usize]),
            JointEndpoint::Fixed(_) => None,
        })
    }
}
