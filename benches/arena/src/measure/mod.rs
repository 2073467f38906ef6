//! Errors computed from poses and velocities alone, in double precision, with one implementation for
//! every engine. Nothing here asks an engine for its own opinion.

use crate::engine::State;
use crate::scene::{Joint, JointKind, Scene, Truth};
use glam::{DMat3, DQuat, DVec3};
use parry3d_f64::bounding_volume::BoundingVolume;
use parry3d_f64::math::Pose;
use parry3d_f64::query;
use parry3d_f64::shape::SharedShape;

#[derive(Clone, Debug, Default)]
pub(crate) struct Report {
    /// The scene's headline error, see [`Truth`].
    pub(crate) err: f64,
    /// Deepest penetration at any measured instant \[m\].
    pub(crate) pen_max: f64,
    /// Mean depth over all overlapping pairs, measured after the warm-up \[m\].
    pub(crate) pen_mean: f64,
    /// Largest rise of mechanical energy above an earlier value: `max_t (E(t) - min_{s<t} E(s))`. As the
    /// height \[m\] it would lift the system by, or relative to the initial energy where gravity is zero.
    pub(crate) energy_gain: f64,
    /// Net energy change over the run, same unit.
    pub(crate) energy_drift: f64,
    /// Largest distance of a dynamic body from its initial position at the end \[m\].
    pub(crate) disp_max: f64,
    /// Root mean square of linear speed plus spin times radius at the end \[m/s\].
    pub(crate) rms_speed: f64,
    /// Bodies that are not where they should rest, see [`Truth`].
    pub(crate) fallen: usize,
}

#[derive(Clone, Copy)]
struct Pose64 {
    pos: DVec3,
    rot: DQuat,
    lin: DVec3,
    ang: DVec3,
}

impl From<&State> for Pose64 {
    fn from(s: &State) -> Self {
        Self {
            pos: s.pos.as_dvec3(),
            rot: s.rot.as_dquat().normalize(),
            lin: s.linvel.as_dvec3(),
            ang: s.angvel.as_dvec3(),
        }
    }
}

pub(crate) struct Meter<'s> {
    scene: &'s Scene,
    shapes: Vec<SharedShape>,
    radius: Vec<f64>,
    /// Mass and local inertia tensor per body.
    mass: Vec<(f64, DMat3)>,
    first: Vec<Pose64>,
    last: Vec<Pose64>,
    step: usize,
    energy0: f64,
    energy_min: f64,
    report: Report,
    /// A state that is not finite was seen.
    is_broken: bool,
    pen_sum: (f64, usize),
    /// Scene-specific scratch: first sample of a slide, or contact seen and apex of a bounce.
    mark: Option<Pose64>,
    apex: f64,
    /// Largest distance of the anchors of a joint, m.
    gap: f64,
    /// Largest distance from [`Scene::path`], m.
    astray: f64,
    /// Largest difference of the energy from that at first, J.
    energy_off: f64,
    /// When body 1 passed below the origin in the direction of x, s.
    passes: Vec<f64>,
}

impl<'s> Meter<'s> {
    pub(crate) fn new(scene: &'s Scene) -> Self {
        let points = |i: usize| scene.shapes[i].points.iter().map(|p| p.as_dvec3());
        let shapes: Vec<_> = (0..scene.shapes.len())
            .map(|i| match scene.shapes[i].half_extents {
                Some(h) => SharedShape::cuboid(h.x as f64, h.y as f64, h.z as f64),
                None => SharedShape::convex_hull(&points(i).collect::<Vec<_>>()).unwrap(),
            })
            .collect();
        let mass = scene.bodies.iter().map(|b| {
            let p = shapes[b.shape].mass_properties(b.density as f64);
            (p.mass(), p.reconstruct_inertia_matrix())
        });
        let first: Vec<_> = scene
            .bodies
            .iter()
            .map(|b| {
                Pose64::from(&State {
                    pos: b.pos,
                    rot: b.rot,
                    linvel: b.linvel,
                    angvel: b.angvel,
                })
            })
            .collect();
        let mut meter = Self {
            scene,
            radius: (0..shapes.len())
                .map(|i| points(i).map(|p| p.length()).fold(0.0, f64::max))
                .collect(),
            mass: mass.collect(),
            shapes,
            last: first.clone(),
            first,
            step: 0,
            energy0: 0.0,
            energy_min: 0.0,
            report: Report::default(),
            is_broken: false,
            pen_sum: (0.0, 0),
            mark: None,
            apex: 0.0,
            gap: 0.0,
            astray: 0.0,
            energy_off: 0.0,
            passes: vec![],
        };
        meter.energy0 = meter.energy();
        meter.energy_min = meter.energy0;
        meter
    }

    /// Call after every step with the states the engine reports.
    pub(crate) fn sample(&mut self, states: &[State]) {
        self.step += 1;
        if states
            .iter()
            .any(|s| !(s.pos.is_finite() && s.rot.is_finite() && s.linvel.is_finite()))
        {
            self.is_broken = true;
            return;
        }
        let before = std::mem::replace(&mut self.last, states.iter().map(Pose64::from).collect());
        let e = self.energy();
        self.report.energy_gain = self.report.energy_gain.max(e - self.energy_min);
        self.energy_min = self.energy_min.min(e);
        self.energy_off = self.energy_off.max((e - self.energy0).abs());
        if self.step.is_multiple_of(self.scene.deep_every) || self.step == self.scene.steps {
            self.penetration();
        }
        self.gap = self
            .scene
            .joints
            .iter()
            .map(|joint| self.gap_of(joint))
            .fold(self.gap, f64::max);
        match self.scene.truth {
            Truth::Slide if self.step == 60 => self.mark = Some(self.last[1]),
            Truth::Bounce { .. } if before[1].lin.y < 0.0 && self.last[1].lin.y > 0.0 => {
                self.mark = Some(before[1])
            }
            Truth::Path { body, .. } => {
                let off = self.last[body].pos.distance(self.scene.path[self.step - 1]);
                self.astray = self.astray.max(off);
            }
            Truth::Period { .. } => self.passes.extend(self.pass(before[1].pos.x)),
            _ => {}
        }
        if self.mark.is_some() {
            self.apex = self.apex.max(self.last.get(1).map_or(0.0, |p| p.pos.y));
        }
    }

    /// The errors of the run; the headline one is infinite if the run broke, or `is_late` and did not come to its end.
    pub(crate) fn finish(mut self, is_late: bool) -> Report {
        let shifts = self.dynamic().map(|i| self.shift(i));
        self.report.disp_max = shifts.fold(0.0, f64::max);
        self.report.rms_speed = self.rms_speed();
        self.report.pen_mean = self.pen_sum.0 / self.pen_sum.1.max(1) as f64;
        self.report.fallen = self.fallen();
        self.report.err = if self.is_broken || is_late {
            f64::INFINITY
        } else {
            self.headline()
        };
        // Energies in Joule until here.
        let g = self.scene.gravity.as_dvec3().length();
        let weight = self.dynamic().map(|i| self.mass[i].0).sum::<f64>() * g;
        let unit = if weight > 0.0 { weight } else { self.energy0 };
        self.report.energy_gain /= unit;
        self.report.energy_drift = (self.energy() - self.energy0) / unit;
        self.report
    }

    fn dynamic(&self) -> impl Iterator<Item = usize> {
        (0..self.scene.bodies.len()).filter(|&i| !self.scene.bodies[i].fixed)
    }

    /// Distance of a body from where it began, m.
    fn shift(&self, i: usize) -> f64 {
        self.last[i].pos.distance(self.first[i].pos)
    }

    fn rms_speed(&self) -> f64 {
        let squares = self.dynamic().map(|i| {
            let (p, radius) = (self.last[i], self.radius[self.scene.bodies[i].shape]);
            (p.lin.length() + p.ang.length() * radius).powi(2)
        });
        (squares.sum::<f64>() / self.scene.num_dynamic() as f64).sqrt()
    }

    fn fallen(&self) -> usize {
        let is_out = |i: &usize| match self.scene.truth {
            Truth::Rest { fell } => self.shift(*i) > fell as f64,
            Truth::Settle { walls } => {
                let p = self.last[*i].pos;
                p.y < 0.0 || p.x.abs().max(p.z.abs()) > walls as f64
            }
            _ => false,
        };
        self.dynamic().filter(is_out).count()
    }

    /// The error that the scene is judged by.
    fn headline(&self) -> f64 {
        let (scene, first, last) = (self.scene, &self.first, &self.last);
        let (t, g) = (
            scene.dt as f64 * scene.steps as f64,
            scene.gravity.as_dvec3(),
        );
        match scene.truth {
            Truth::Rest { .. } => self.report.disp_max,
            Truth::Settle { .. } => self.report.pen_mean,
            Truth::Fall => (last[1].pos - first[1].pos - 0.5 * g * t * t).length(),
            Truth::Slide => self.slide(),
            Truth::FreeRotation => {
                let exact = free_rotation(&self.mass[0].1, &first[0], t);
                last[0].rot.angle_between(exact)
            }
            Truth::Bounce { height } => {
                let rest = first[1].pos.y - height as f64 * 4.0; // dropped from height / 0.5²
                ((self.apex - rest) / height as f64 - 1.0).abs()
            }
            Truth::Isolated => {
                let (p0, l0) = self.momentum(first);
                let (p1, l1) = self.momentum(last);
                ((p1 - p0).length() / p0.length()).max((l1 - l0).length() / l0.length())
            }
            Truth::Topple => {
                let stands = |i: &usize| (last[*i].rot * DVec3::Y).y > 0.8;
                self.dynamic().filter(stands).count() as f64 / scene.num_dynamic() as f64
            }
            Truth::Joints => self.gap,
            Truth::Path { scale, .. } => self.astray / scale,
            Truth::Period { period } => (self.period() / period - 1.0).abs(),
            Truth::Energy { scale } => self.energy_off / scale,
            Truth::Wall => (last[1].pos.x > 0.0) as u8 as f64,
        }
    }

    /// When in the last step body 1 passed the origin in the direction of x, if it did, s. There it goes fastest, and evenly.
    fn pass(&self, from: f64) -> Option<f64> {
        let to = self.last[1].pos.x;
        let share = (from < 0.0 && to >= 0.0).then(|| -from / (to - from))?;
        Some(f64::from(self.scene.dt) * ((self.step - 1) as f64 + share))
    }

    /// Mean time between passes, s; infinite if there are not two.
    fn period(&self) -> f64 {
        match self.passes[..] {
            [first, .., last] => (last - first) / (self.passes.len() - 1) as f64,
            _ => f64::INFINITY,
        }
    }

    /// How far the anchors of a joint are apart, m; for a slider, across its axis.
    fn gap_of(&self, joint: &Joint) -> f64 {
        let anchor = |side: usize| {
            let body = &self.last[joint.bodies[side]];
            body.pos + body.rot * joint.frames[side].pos.as_dvec3()
        };
        if let JointKind::Slider { .. } = joint.kind {
            let axis = self.last[joint.bodies[0]].rot * joint.frames[0].rot.as_dquat() * DVec3::X;
            return (anchor(1) - anchor(0)).reject_from(axis).length();
        }
        anchor(0).distance(anchor(1))
    }

    /// Relative error of the acceleration of body 1 after the mark.
    fn slide(&self) -> f64 {
        let (scene, g) = (self.scene, self.scene.gravity.as_dvec3());
        let down = DVec3::new(g.x, 0.0, g.z);
        let exact = down + down.normalize() * (scene.friction as f64 * g.y);
        let span = scene.dt as f64 * (scene.steps - 60) as f64;
        let a = (self.last[1].lin - self.mark.map_or(DVec3::ZERO, |m| m.lin)) / span;
        (a - exact).length() / exact.length()
    }

    fn energy(&self) -> f64 {
        let g = self.scene.gravity.as_dvec3();
        (0..self.last.len())
            .filter(|&i| !self.scene.bodies[i].fixed)
            .map(|i| {
                let (p, (m, inertia)) = (self.last[i], self.mass[i]);
                let w = p.rot.inverse() * p.ang;
                0.5 * m * p.lin.length_squared() + 0.5 * w.dot(inertia * w) - m * g.dot(p.pos)
            })
            .sum()
    }

    /// Linear momentum, and angular momentum about the origin.
    fn momentum(&self, at: &[Pose64]) -> (DVec3, DVec3) {
        (0..at.len()).fold((DVec3::ZERO, DVec3::ZERO), |(lin, ang), i| {
            let (p, (m, inertia)) = (at[i], self.mass[i]);
            let spin = p.rot * (inertia * (p.rot.inverse() * p.ang));
            (lin + m * p.lin, ang + p.pos.cross(m * p.lin) + spin)
        })
    }

    fn penetration(&mut self) {
        let bodies = &self.scene.bodies;
        let poses: Vec<_> = self
            .last
            .iter()
            .map(|p| Pose::from_parts(p.pos, p.rot))
            .collect();
        let boxes: Vec<_> = (0..bodies.len())
            .map(|i| self.shapes[bodies[i].shape].compute_aabb(&poses[i]))
            .collect();
        let mut order: Vec<usize> = (0..bodies.len()).collect();
        order.sort_by(|&a, &b| boxes[a].mins.x.total_cmp(&boxes[b].mins.x));
        let mut active: Vec<usize> = Vec::new();
        for &i in &order {
            active.retain(|&j| boxes[j].maxs.x >= boxes[i].mins.x);
            for &j in &active {
                if (bodies[i].fixed && bodies[j].fixed) || !boxes[i].intersects(&boxes[j]) {
                    continue;
                }
                let (a, b) = (&self.shapes[bodies[i].shape], &self.shapes[bodies[j].shape]);
                let Ok(Some(c)) = query::contact(&poses[i], &**a, &poses[j], &**b, 0.0) else {
                    continue;
                };
                let depth = (-c.dist).max(0.0);
                self.report.pen_max = self.report.pen_max.max(depth);
                if self.step > self.scene.warmup && depth > 0.0 {
                    self.pen_sum.0 += depth;
                    self.pen_sum.1 += 1;
                }
            }
            active.push(i);
        }
    }
}

/// Orientation after torque-free rotation for time `t`: classical Runge-Kutta in double precision.
fn free_rotation(inertia: &DMat3, start: &Pose64, t: f64) -> DQuat {
    let inverse = inertia.inverse();
    let momentum = start.rot * (*inertia * (start.rot.inverse() * start.ang));
    let rate = |q: DQuat| {
        let w = q * (inverse * (q.inverse() * momentum));
        DQuat::from_xyzw(w.x, w.y, w.z, 0.0) * q * 0.5
    };
    let n = (t * 2000.0) as usize;
    let h = t / n as f64;
    let mut q = start.rot;
    for _ in 0..n {
        let a = rate(q);
        let b = rate(q + a * (0.5 * h));
        let c = rate(q + b * (0.5 * h));
        let d = rate(q + c * h);
        q = (q + (a + (b + c) * 2.0 + d) * (h / 6.0)).normalize();
    }
    q
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;

    /// Feeds hand-made states to the meter.
    fn report(spec: &str, edit: impl Fn(usize, &mut State)) -> Report {
        let mut s = scene::build(spec).unwrap();
        (s.steps, s.warmup, s.deep_every) = (2, 0, 1);
        let mut m = Meter::new(&s);
        for step in 1..=2 {
            let states = s.bodies.iter().enumerate().map(|(i, b)| {
                let mut st = State {
                    pos: b.pos,
                    rot: b.rot,
                    linvel: b.linvel,
                    angvel: b.angvel,
                };
                edit(i * (step - 1), &mut st);
                st
            });
            m.sample(&states.collect::<Vec<_>>());
        }
        m.finish(false)
    }

    #[test]
    fn resting_scenes_start_in_touch() {
        for spec in [
            "pyramid:5",
            "tower:5",
            "arch:15",
            "massratio:10",
            "stick",
            "cards:3",
            "pyramids:2",
            "dominoes:4",
        ] {
            let r = report(spec, |_, _| {});
            assert!(r.pen_max < 1e-6, "{spec}: {r:?}");
            assert!(
                r.energy_gain == 0.0 || spec.starts_with("dominoes"),
                "{spec}: {r:?}"
            );
        }
    }

    #[test]
    fn sinking_and_lifting_are_seen() {
        let sunk = report("tower:3", |i, s| s.pos.y -= if i == 1 { 0.01 } else { 0.0 });
        assert!(
            (sunk.pen_max - 0.01).abs() < 1e-6 && (sunk.disp_max - 0.01).abs() < 1e-6,
            "{sunk:?}"
        );
        let lifted = report("tower:3", |i, s| s.pos.y += if i == 3 { 0.3 } else { 0.0 });
        assert!((lifted.energy_gain - 0.1).abs() < 1e-6, "{lifted:?}");
    }

    #[test]
    fn reference_rotation_conserves_energy_and_flips() {
        let s = scene::build("spin").unwrap();
        let m = Meter::new(&s);
        let (inertia, first) = (m.mass[0].1, m.first[0]);
        let l = first.rot * (inertia * (first.rot.inverse() * first.ang));
        let mut flipped = false;
        for k in 1..20 {
            let q = free_rotation(&inertia, &first, 0.5 * k as f64);
            let w = inertia.inverse() * (q.inverse() * l);
            assert!((0.5 * w.dot(inertia * w) / m.energy0 - 1.0).abs() < 1e-9);
            flipped |= w.z < -4.0;
        }
        assert!(flipped, "not the unstable axis");
    }
}
