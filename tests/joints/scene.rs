//! What the tests build.

use crate::common::scenes::awake;
use bevy_cleave::prelude::*;
use glam::{DVec3, Quat, Vec3};
use rand_core::Rng;

/// Length of a step, s.
pub(crate) const H: f32 = 1.0 / 60.0;

pub(crate) fn cuboid(x: f32, y: f32, z: f32) -> ConvexMesh {
    ConvexMesh::cuboid(x, y, z).expect("valid size")
}

/// A cuboid of a mass, kg.
pub(crate) fn heavy(size: Vec3, at: Vec3, mass: f32) -> BodyDesc {
    BodyDesc {
        density: mass / (size.x * size.y * size.z),
        ..BodyDesc::dynamic(cuboid(size.x, size.y, size.z), at)
    }
}

pub(crate) fn fixed(at: Vec3) -> BodyDesc {
    BodyDesc {
        kind: RigidBody::Static,
        ..BodyDesc::dynamic(cuboid(0.2, 0.2, 0.2), at)
    }
}

/// Where a point of a body is, world, in double precision.
pub(crate) fn point(simulation: &Simulation, slot: u32, local: Vec3) -> DVec3 {
    let pose = simulation.bodies.pose(slot);
    pose.position.as_dvec3() + pose.rotation.as_dquat().normalize() * local.as_dvec3()
}

/// How far the anchors of a joint are apart, m.
pub(crate) fn gap(simulation: &Simulation, id: JointId) -> f64 {
    let joint = simulation.joints.get(id).expect("there");
    let [a, b] = simulation.joints.bodies(id).expect("there");
    let at_a = match a {
        Some(a) => point(simulation, a, joint.frame_a.position),
        None => joint.frame_a.position.as_dvec3(),
    };
    let at_b = point(
        simulation,
        b.expect("never the world"),
        joint.frame_b.position,
    );
    at_a.distance(at_b)
}

/// A chain of `links` of 1 m and 1 kg from the origin along x, and a load of `ratio` kg at its end; gap-free.
pub(crate) struct Chain {
    pub(crate) simulation: Simulation,
    pub(crate) joints: Vec<JointId>,
}

pub(crate) fn chain(links: usize, ratio: f32, along: Vec3, origin: Vec3) -> Chain {
    let mut simulation = awake();
    let turn = Quat::from_rotation_arc(Vec3::X, along);
    let (mut slots, mut joints) = (Vec::new(), Vec::new());
    for i in 0..=links {
        let is_load = i == links;
        let size = if is_load {
            Vec3::ONE
        } else {
            Vec3::new(1.0, 0.1, 0.1)
        };
        let mass = if is_load { ratio } else { 1.0 };
        let mut body = heavy(size, origin + along * (i as f32 + 0.5), mass);
        body.pose.rotation = turn;
        let slot = simulation.bodies.insert(body).expect("usable");
        let at = Vec3::new(0.5, 0.0, 0.0);
        let joint = Joint::ball();
        let joint = match slots.last() {
            None => joint.with_anchors(origin, -at),
            Some(_) => joint.with_anchors(at, -at),
        };
        let id = simulation.join(slots.last().copied(), slot, joint);
        joints.push(id.expect("usable"));
        slots.push(slot);
    }
    Chain { simulation, joints }
}

impl Chain {
    /// Steps, and tells the largest gap, m.
    pub(crate) fn largest_gap(&mut self, steps: usize, h: f32) -> f64 {
        let mut largest = 0.0_f64;
        for _ in 0..steps {
            self.simulation.step(h);
            for &joint in &self.joints {
                largest = largest.max(gap(&self.simulation, joint));
            }
        }
        largest
    }
}

/// The largest gap of some joints, m.
pub(crate) fn largest_gap(simulation: &Simulation, ids: &[JointId]) -> f64 {
    ids.iter()
        .map(|&id| gap(simulation, id))
        .fold(0.0, f64::max)
}

/// A point of the world in the frame of a body, or of the world.
pub(crate) fn local(simulation: &Simulation, slot: Option<u32>, at: Vec3) -> Vec3 {
    let pose = slot.map_or(Pose::IDENTITY, |slot| simulation.bodies.pose(slot));
    pose.inverse_transform_point(at)
}

/// So many sub-steps, whatever they leave amiss.
pub(crate) fn fixed_substeps(count: u32) -> SolverConfig {
    SolverConfig::from(SoftStep {
        min_substeps: count,
        max_substeps: count,
        tolerance: None,
        ..SoftStep::default()
    })
}

/// A bridge of planks that hangs between two fixed ends, or a rope of them with one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bridge {
    pub(crate) planks: u8,
    /// m
    pub(crate) plank: Vec3,
    /// Of a plank, kg.
    pub(crate) mass: f32,
    /// Height of the ends, m.
    pub(crate) height: f32,
    /// How far the middle is below the ends, m: what is straight between two fixed ends cannot bear anything across.
    pub(crate) sag: f32,
    /// Ball joints of a seam.
    pub(crate) per_seam: u8,
    pub(crate) has_far_end: bool,
}

impl Bridge {
    /// Half of its length, m.
    pub(crate) fn half(&self) -> f32 {
        0.5 * f32::from(self.planks) * self.plank.x
    }

    /// Where a seam is: on a parabola.
    pub(crate) fn seam(&self, i: u8) -> Vec3 {
        let half = self.half();
        let x = f32::from(i) * self.plank.x - half;
        let share = x / half;
        Vec3::new(x, self.height - self.sag * (1.0 - share * share), 0.0)
    }

    /// Puts it up; its joints.
    pub(crate) fn add(&self, simulation: &mut Simulation) -> Vec<JointId> {
        let mut ids = Vec::new();
        let mut last: Option<u32> = None;
        for i in 0..=self.planks {
            let plank = (i < self.planks).then(|| {
                let (from, to) = (self.seam(i), self.seam(i + 1));
                let size = Vec3::new(0.95 * from.distance(to), self.plank.y, self.plank.z);
                let mut plank = heavy(size, 0.5 * (from + to), self.mass);
                plank.pose.rotation = Quat::from_rotation_arc(Vec3::X, (to - from).normalize());
                simulation.bodies.insert(plank).expect("usable")
            });
            if plank.is_none() && !self.has_far_end {
                break;
            }
            for k in 0..self.per_seam {
                let from_middle = f32::from(k) - 0.5 * f32::from(self.per_seam - 1);
                let at = self.seam(i) + 0.9 * self.plank.z * from_middle * Vec3::Z;
                let (a, b) = match plank {
                    Some(plank) => (last, plank),
                    None => (None, last.expect("there are planks")),
                };
                let anchors = [a, Some(b)].map(|slot| local(simulation, slot, at));
                let joint = Joint::ball().with_anchors(anchors[0], anchors[1]);
                ids.push(simulation.join(a, b, joint).expect("usable"));
            }
            last = plank;
        }
        ids
    }
}

/// Random numbers that are the same everywhere.
pub(crate) struct Random(rand_pcg::Pcg32);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(rand_pcg::Pcg32::new(seed, 1))
    }

    pub(crate) fn range(&mut self, from: f32, to: f32) -> f32 {
        let unit = (self.0.next_u32() >> 8) as f32 / (1 << 24) as f32;
        from + (to - from) * unit
    }

    pub(crate) fn vector(&mut self, from: f32, to: f32) -> Vec3 {
        Vec3::from_array([0; 3].map(|_| self.range(from, to)))
    }

    pub(crate) fn rotation(&mut self) -> Quat {
        let [x, y, z, w] = [0; 4].map(|_| self.range(-1.0, 1.0));
        Quat::from_xyzw(x, y, z, w + 0.1).normalize()
    }
}
