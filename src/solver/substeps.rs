//! One step of one island: forces, rows, motion, as many times as there are sub-steps.
//!
//! Contact geometry is found once per step. Within it, a point's gap follows the motion of the two bodies along the
//! frozen normal, `s = s_0 + J q` with the displacements `q`; where bodies move fast against each other, or turn, the rows
//! are pointed anew at each sub-step.
//!
//! ```text
//! for each sub-step of h seconds:
//!   v += h g
//!   s -> wanted velocities, compliance, rebounds
//!   solve                      impulses, warm started from the sub-step before
//!   q += h v
//!   relax                      takes the velocity that pushed overlap out from the bodies again; impacts rebound
//! ```

use super::bodies::SolverBody;
use super::exact::{self, ExactScratch};
use super::momentum::{Contacts, Momentum, PointContacts};
use super::rows::{PointRows, Side};
use super::soft_step::{self, Softness};
use super::spin::Spin;
use super::{Method, SolverConfig, pgs};
use crate::contact::manifold::{ContactPoint, Manifold};
use crate::math::rotate_by;
use glam::{Mat3, Quat, Vec3};

/// Rebounds are solved until no row changes by more than this share of the fastest one.
const REBOUND_TOLERANCE: f32 = 1e-5;

/// Share of the fastest body's speed that a sub-step need not be more precise than.
const MOVING_TOLERANCE: f32 = 0.01;

/// Most sweeps where bodies may pass through each other: no later sub-step makes up for what is left.
const FAST_SWEEPS: u32 = 256;

/// Sweeps where the exact method has no answer.
const UNCERTIFIED_SWEEPS: u32 = 200;

/// Turn within a sub-step, rad, up to which rows that have been solved may be pointed anew.
const MOST_TURN: f32 = 0.05;

/// Velocity of position feedback, m/s, that is not worth taking out again.
const NEGLIGIBLE_SPEED: f32 = 1e-4;

/// A body that turns, and its number within the island.
#[derive(Clone, Copy, Debug)]
pub struct TurningBody {
    /// Number within the island.
    pub body: u32,
    /// `world_from_body` at the start of the step.
    pub start: Quat,
    /// Its rotation.
    pub spin: Spin,
    /// Inverse inertia tensor, body's axes, 1/(kg m2).
    pub inverse_inertia: Mat3,
}

/// A manifold whose rows must follow the motion of its bodies.
#[derive(Clone, Copy, Debug)]
pub struct MovingManifold {
    /// Index of the manifold.
    pub manifold: u32,
    /// Index of its first point within the island's rows.
    pub first: u32,
    /// Places of its two bodies among those of the island that turn, if they do.
    pub turning: [Option<u32>; 2],
    /// Which of the two bodies the contact points move with: 0 for A, 1 for B.
    pub carrier: usize,
    /// If the two may pass through each other in the step: half the least extent of the carrier, m.
    pub clearance: Option<f32>,
}

/// All that the sub-steps of an island read and write.
#[derive(Debug)]
pub struct IslandProblem<'a> {
    /// Rows of its points.
    pub rows: &'a mut [PointRows],
    /// Velocities of its bodies.
    pub bodies: &'a mut [SolverBody],
    /// Displacements of its bodies since the start of the step: centre (m) and rotation vector (rad).
    pub displacements: &'a mut [SolverBody],
    /// Inverse inertia tensors of its bodies, world axes, 1/(kg m2).
    pub inverse_inertia: &'a mut [Mat3],
    /// Those of its bodies that turn.
    pub turning: &'a mut [TurningBody],
    /// Those of its manifolds whose rows follow the motion.
    pub moving: &'a [MovingManifold],
    /// All manifolds of the step.
    pub manifolds: &'a [Manifold],
    /// Whether any of its points rebounds.
    pub has_restitution: bool,
    /// Buffers.
    pub scratch: &'a mut IslandScratch,
}

/// Buffers of the sub-steps, shared by all islands.
#[derive(Debug, Default)]
pub struct IslandScratch {
    exact: ExactScratch,
    momentum: Momentum<f32, SolverBody>,
    /// By body: whether a contact pushes it.
    is_pushed: Vec<bool>,
    /// Impulses that the exact method starts from, by point.
    start: Vec<[f32; 3]>,
    /// Velocities without contact impulses.
    free: Vec<SolverBody>,
}

/// What an island took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Sweeps of all sub-steps together.
    pub sweeps: u32,
    /// Whether a sub-step ended above the tolerance.
    pub hit_cap: bool,
    /// Sweeps beyond the least numbers that are left for this step, and for this sub-step: evenly, for sub-steps that are
    /// more precise than the next ones shake a stack.
    spare: u32,
    share: u32,
}

impl Effort {
    /// For an island with the given number of points.
    fn new(config: &SolverConfig, points: usize) -> Self {
        Self {
            spare: config.spare_updates / (points as u32).max(1),
            ..Self::default()
        }
    }

    /// Begins a sub-step, with `to_go` of them left.
    fn begin(&mut self, to_go: u32) {
        self.share = self.spare / to_go;
    }

    /// Sweeps `least` times, then with [`momentum`](super::momentum) until a sweep changes no velocity by more than `tolerance`,
    /// but not more than `most` times in all, nor than is left for the step.
    fn sweep(
        &mut self,
        [least, most]: [u32; 2],
        tolerance: Option<f32>,
        contacts: &mut impl Contacts<Real = f32, Velocity = SolverBody>,
        momentum: &mut Momentum<f32, SolverBody>,
    ) {
        let mut change = 0.0;
        let mut done = 0;
        let most = most.min(least + self.share);
        momentum.restart();
        while done < least || tolerance.is_some_and(|t| change > t) && done < most {
            change = if done < least {
                contacts.sweep()
            } else {
                momentum.sweep(contacts)
            };
            done += 1;
        }
        self.sweeps += done;
        self.share -= done - least;
        self.spare -= done - least;
        self.hit_cap |= tolerance.is_some_and(|t| change > t);
    }
}

/// What an island asks of its sub-steps.
#[derive(Clone, Copy, Debug, Default)]
pub struct Demand {
    /// Largest velocity that a contact gave its effective mass in the last step, over the smaller body's least extent, 1/s.
    pub load: f32,
    /// Whether two bodies are so fast that they may pass through each other in the step.
    pub is_fast: bool,
}

/// What the sub-steps are told.
#[derive(Clone, Copy, Debug)]
pub struct SubstepSettings {
    /// How to solve.
    pub config: SolverConfig,
    /// Acceleration of dynamic bodies, m/s2.
    pub gravity: Vec3,
    /// Length of a sub-step, s.
    pub h: f32,
}

impl SubstepSettings {
    /// The sub-steps of a step of `step` seconds.
    pub fn new(config: SolverConfig, gravity: Vec3, step: f32) -> Self {
        Self {
            config,
            gravity,
            h: step / config.substeps as f32,
        }
    }

    /// The same step in as many parts as an island asks for.
    ///
    /// A soft contact under a load that gives its effective mass the acceleration `a` gives way by `s = a h^2 / (h omega)^2`,
    /// which is to stay below the share [`SolverConfig::sag`] of an extent. Bodies that are fast enough to pass through each
    /// other get the step as one: the contact points found at its start are good for one impact, after which the bodies may turn
    /// about another.
    pub fn for_demand(&self, demand: Demand) -> Self {
        let config = &self.config;
        if config.method != Method::SoftStep {
            return *self;
        }
        let step = self.step();
        let per_radian = step / (std::f32::consts::TAU * config.contact_frequency);
        let parts = per_radian * (demand.load / (step * config.sag)).sqrt();
        let substeps = if demand.is_fast {
            1
        } else {
            // A number that is not finite becomes one end of the range.
            (parts.ceil() as u32).clamp(config.substeps, config.max_substeps.max(config.substeps))
        };
        let max_sweeps = if demand.is_fast {
            config.max_sweeps.max(FAST_SWEEPS)
        } else {
            config.max_sweeps
        };
        let config = SolverConfig {
            substeps,
            max_sweeps,
            ..*config
        };
        Self::new(config, self.gravity, step)
    }

    /// Length of the step, s.
    pub fn step(&self) -> f32 {
        self.h * self.config.substeps as f32
    }
}

impl IslandProblem<'_> {
    /// Advances the island by a step.
    pub fn solve(&mut self, settings: &SubstepSettings) -> Effort {
        let mut effort = Effort::new(&settings.config, self.rows.len());
        for substep in 0..settings.config.substeps {
            if substep > 0 {
                self.follow_motion(f32::INFINITY);
                self.add_impulses();
            }
            effort.begin(settings.config.substeps - substep);
            self.apply_gravity(settings);
            self.solve_substep(settings, &mut effort);
        }
        effort
    }

    /// From targets to the end of a sub-step.
    fn solve_substep(&mut self, settings: &SubstepSettings, effort: &mut Effort) {
        let fastest = self.set_targets(settings);
        let is_hit = fastest > 0.0 || self.is_hit(settings);
        if is_hit {
            self.rows.iter_mut().for_each(PointRows::save_impulses);
        }
        let tolerance = tolerance(&settings.config, self.rows, self.bodies, fastest);
        self.solve_rows(settings, tolerance, effort);
        self.move_bodies(settings);
        if is_hit {
            // What follows acts where the bodies are now: blows are large enough to matter for the angular momentum.
            self.follow_motion(MOST_TURN / settings.h);
        }
        self.relax(settings, tolerance, effort);
        if is_hit {
            // A blow says nothing about the next sub-step, what was before it does.
            self.rows.iter_mut().for_each(PointRows::restore_impulses);
        }
        self.turn_bodies(settings.h);
    }

    /// Adds the impulses of the sub-step that is over to the step's.
    fn add_impulses(&mut self) {
        for point in self.rows.iter_mut() {
            point.total += point.normal.impulse;
        }
    }

    fn apply_gravity(&mut self, settings: &SubstepSettings) {
        let change = settings.gravity * settings.h;
        for body in self.bodies.iter_mut().filter(|b| b.inverse_mass > 0.0) {
            body.linear += change;
        }
    }

    /// Fills the wanted velocities; returns the fastest rebound, scaled to a size of 1 m, m/s.
    fn set_targets(&mut self, settings: &SubstepSettings) -> f32 {
        let SubstepSettings { config, h, .. } = settings;
        let softness = Softness::new(config, *h);
        let (rate, is_soft) = match config.method {
            Method::SoftStep => (softness.rate, true),
            Method::Pgs | Method::Exact => (config.baumgarte / h, false),
        };
        for point in self.rows.iter_mut() {
            let [i, j] = point.bodies.map(|b| b as usize);
            let q = [&self.displacements[i], &self.displacements[j]];
            let gap = point.separation + point.normal.velocity(q[0], q[1]);
            let overlap = -gap - point.slop;
            point.is_soft = is_soft && gap <= 0.0;
            point.normal.wanted = if gap > 0.0 {
                -gap / h
            } else {
                (rate * overlap.max(0.0)).min(config.push_out_speed)
            };
        }
        if self.has_restitution {
            self.set_rebounds(settings)
        } else {
            0.0
        }
    }

    /// Finds the points that hit in this sub-step, and how fast they leave; returns the fastest,
    /// scaled to a size of 1 m, m/s.
    ///
    /// A point hits if the free motion closes its gap `s` within the sub-step. The speed at that moment follows from
    /// energy: `v^2 = v_0^2 + 2 a s` with the acceleration `a` of the gap. It leaves with `e v` from where the gap is closed.
    fn set_rebounds(&mut self, settings: &SubstepSettings) -> f32 {
        let SubstepSettings {
            config, gravity, h, ..
        } = settings;
        let mut fastest = 0.0_f32;
        for manifold in self.rows.chunk_by_mut(|p, q| p.bodies == q.bodies) {
            let [a, b] = manifold[0].bodies.map(|b| &self.bodies[b as usize]);
            let falls = |body: &SolverBody| f32::from(u8::from(body.inverse_mass > 0.0));
            let direction = manifold[0].normal.direction;
            let acceleration = -direction.dot(*gravity) * (falls(b) - falls(a));
            let gap = |point: &PointRows| (-point.normal.wanted * h).max(0.0);
            let speed = |point: &PointRows| -point.normal.velocity(a, b);
            let hits = |point: &PointRows, h: f32| {
                let speed = speed(point);
                point.restitution > 0.0
                    && speed > config.restitution_threshold
                    && speed * h > gap(point)
            };
            // Corners of a face that all but lie at one height hit together, or the face would start to rock.
            let reach = if manifold.iter().any(|point| hits(point, *h)) {
                2.0 * h
            } else {
                0.0
            };
            for point in manifold {
                point.rebound = 0.0;
                if hits(point, reach) {
                    let before = speed(point) - acceleration * h;
                    let squared = before * before + 2.0 * acceleration * gap(point);
                    point.rebound = point.restitution * squared.max(0.0).sqrt();
                    fastest = fastest.max(point.rebound * point.speed_scale);
                }
                if config.relax_sweeps == 0 && point.rebound > 0.0 {
                    point.normal.wanted = point.normal.wanted.max(point.rebound);
                }
            }
        }
        fastest
    }

    /// Whether bodies hit each other in this sub-step, so fast that their impulses are those of a blow.
    fn is_hit(&self, settings: &SubstepSettings) -> bool {
        let threshold = settings.config.restitution_threshold;
        self.moving.iter().any(|moving| {
            let count = self.manifolds[moving.manifold as usize].count as usize;
            let rows = &self.rows[moving.first as usize..][..count];
            rows.iter().any(|point| {
                let [a, b] = point.bodies.map(|b| &self.bodies[b as usize]);
                let speed = -point.normal.velocity(a, b);
                speed > threshold.max(-point.normal.wanted)
            })
        })
    }

    fn solve_rows(
        &mut self,
        settings: &SubstepSettings,
        tolerance: Option<f32>,
        effort: &mut Effort,
    ) {
        let SubstepSettings { config, h, .. } = settings;
        if config.method == Method::Exact {
            self.keep_free_velocities();
            return self.solve_exactly(config, effort);
        }
        let softness = Softness::new(config, *h);
        pgs::apply_impulses(self.rows, self.bodies);
        let sweep = |rows: &mut [PointRows], bodies: &mut [SolverBody]| {
            if config.method == Method::SoftStep {
                soft_step::sweep(rows, bodies, &softness, config)
            } else {
                pgs::sweep(rows, bodies, &pgs::Hard, config.friction_model)
            }
        };
        let number = [config.sweeps, config.max_sweeps];
        self.sweep(number, tolerance, config, sweep, effort);
    }

    fn keep_free_velocities(&mut self) {
        self.scratch.free.clear();
        self.scratch.free.extend_from_slice(self.bodies);
    }

    /// Solves to rounding from the free velocities. What cannot be certified (there may be no solution with friction) is not
    /// used: sweeps, which never gain energy, have the word then.
    fn solve_exactly(&mut self, config: &SolverConfig, effort: &mut Effort) {
        let start = &mut self.scratch.start;
        start.clear();
        start.extend(self.rows.iter().map(PointRows::impulses));
        let certificate = exact::solve(
            self.rows,
            self.bodies,
            self.inverse_inertia,
            config,
            &mut self.scratch.exact,
        );
        effort.sweeps += certificate.iterations;
        if !certificate.converged {
            self.bodies.copy_from_slice(&self.scratch.free);
            for (point, start) in self.rows.iter_mut().zip(&self.scratch.start) {
                point.set_impulses(*start);
            }
            let config = SolverConfig {
                sweeps: UNCERTIFIED_SWEEPS,
                ..*config
            };
            pgs::solve(self.rows, self.bodies, &config);
            effort.sweeps += UNCERTIFIED_SWEEPS;
            effort.hit_cap = true;
        }
    }

    /// Solves the rows once more from the free velocities, with what they should have after the motion.
    fn relax_exactly(&mut self, settings: &SubstepSettings, effort: &mut Effort) {
        let mut difference = 0.0_f32;
        for point in self.rows.iter_mut() {
            let relaxed = soft_step::relaxed_velocity(point);
            difference = difference.max((point.normal.wanted - relaxed).abs());
            point.normal.wanted = relaxed;
        }
        if difference > NEGLIGIBLE_SPEED {
            self.bodies.copy_from_slice(&self.scratch.free);
            self.solve_exactly(&settings.config, effort);
        }
    }

    fn move_bodies(&mut self, settings: &SubstepSettings) {
        let h = settings.h;
        for (q, v) in self.displacements.iter_mut().zip(self.bodies.iter()) {
            q.linear += h * v.linear;
            q.angular += h * v.angular;
        }
        if self.has_restitution {
            self.correct_flight(settings);
        }
        self.keep_in_front();
    }

    /// Stops the centre of a fast body in front of the face that it was in front of.
    ///
    /// The rows hold the points that were nearest at the start of the step. A thin body that hits with one corner turns at
    /// thousands of radians per second, and no frozen row sees the rest of it come round.
    fn keep_in_front(&mut self) {
        for moving in self.moving {
            let Some(clearance) = moving.clearance else {
                continue;
            };
            let manifold = &self.manifolds[moving.manifold as usize];
            let pair = self.rows[moving.first as usize].bodies;
            let [a, b] = pair.map(|body| self.displacements[body as usize].linear);
            let away = [-manifold.normal, manifold.normal][moving.carrier];
            let height = |point: &ContactPoint| {
                let anchor = [point.anchor_a, point.anchor_b][moving.carrier];
                0.5 * point.separation - away.dot(anchor)
            };
            let before = manifold.points().iter().map(height);
            let before = before.fold(f32::INFINITY, f32::min);
            let after = before + manifold.normal.dot(b - a);
            let least = before.min(clearance);
            if before > 0.0 && after < least {
                let body = pair[moving.carrier] as usize;
                self.displacements[body].linear += (least - after) * away;
            }
        }
    }

    /// Bodies that nothing pushes fly: `x += h v - h^2 g / 2` with the velocity after the sub-step is the parabola. A body that
    /// rebounds low would lose height otherwise while it is near the ground.
    fn correct_flight(&mut self, settings: &SubstepSettings) {
        let is_pushed = &mut self.scratch.is_pushed;
        is_pushed.clear();
        is_pushed.resize(self.bodies.len(), false);
        for point in self.rows.iter().filter(|p| p.normal.impulse > 0.0) {
            for body in point.bodies {
                is_pushed[body as usize] = true;
            }
        }
        let fall = 0.5 * settings.h * settings.h * settings.gravity;
        let bodies = self.bodies.iter().zip(is_pushed.iter());
        for (q, (body, is_pushed)) in self.displacements.iter_mut().zip(bodies) {
            if body.inverse_mass > 0.0 && !is_pushed {
                q.linear -= fall;
            }
        }
    }

    fn relax(&mut self, settings: &SubstepSettings, tolerance: Option<f32>, effort: &mut Effort) {
        let config = &settings.config;
        if config.relax_sweeps == 0 {
            return;
        }
        if config.method == Method::Exact {
            return self.relax_exactly(settings, effort);
        }
        let sweep = |rows: &mut [PointRows], bodies: &mut [SolverBody]| {
            soft_step::relax(rows, bodies, config)
        };
        let number = [config.relax_sweeps, config.max_sweeps];
        self.sweep(number, tolerance, config, sweep, effort);
    }

    /// Solves the rows by sweeps; see [`Effort::sweep`].
    fn sweep(
        &mut self,
        number: [u32; 2],
        tolerance: Option<f32>,
        config: &SolverConfig,
        sweep: impl FnMut(&mut [PointRows], &mut [SolverBody]) -> f32,
        effort: &mut Effort,
    ) {
        let mut contacts = PointContacts {
            rows: self.rows,
            bodies: self.bodies,
            friction_model: config.friction_model,
            sweep,
        };
        let momentum = &mut self.scratch.momentum;
        effort.sweep(number, tolerance, &mut contacts, momentum);
    }

    /// Turns the bodies that spin, and their inertia with them.
    fn turn_bodies(&mut self, h: f32) {
        for turning in self.turning.iter_mut() {
            let i = turning.body as usize;
            let omega = &mut self.bodies[i].angular;
            *omega = turning.spin.advance(*omega, h);
            let r = Mat3::from_quat(turning.spin.rotation);
            self.inverse_inertia[i] = r * turning.inverse_inertia * r.transpose();
        }
    }

    /// Points the rows of moving manifolds at where their contact points are now.
    ///
    /// A contact point stays at its place on the carrier, and both bodies see the impulse there, or it would change the total
    /// angular momentum. The gap is what lies between the two anchors, each turned with its own body.
    ///
    /// Manifolds of bodies that turn faster than `most` (rad/s) are left as they are: impulses that have acted along the old
    /// rows could not be taken back along the new ones.
    fn follow_motion(&mut self, most: f32) {
        for moving in self.moving {
            let manifold = &self.manifolds[moving.manifold as usize];
            let first = moving.first as usize;
            let pair = self.rows[first].bodies;
            let [i, j] = pair.map(|b| b as usize);
            if self.bodies[i].angular.length() > most || self.bodies[j].angular.length() > most {
                continue;
            }
            let turns = [0, 1].map(|side| self.turn_of(pair[side], moving.turning[side]));
            let sides = [i, j].map(|k| Side {
                inverse_mass: self.bodies[k].inverse_mass,
                inverse_inertia: self.inverse_inertia[k],
            });
            let q = [&self.displacements[i], &self.displacements[j]];
            let rows = &mut self.rows[first..first + manifold.count as usize];
            for (row, point) in rows.iter_mut().zip(manifold.points()) {
                let mut anchors = [turns[0] * point.anchor_a, turns[1] * point.anchor_b];
                let between = (q[1].linear - q[0].linear) + (anchors[1] - point.anchor_b)
                    - (anchors[0] - point.anchor_a);
                if moving.carrier == 0 {
                    anchors[1] -= between;
                } else {
                    anchors[0] += between;
                }
                row.set_geometry(manifold.normal, anchors, sides);
                let gap = point.separation + manifold.normal.dot(between);
                row.separation = gap - row.normal.velocity(q[0], q[1]);
            }
        }
    }

    /// Rotation of a body since the start of the step; `turning` is its place among those that turn.
    fn turn_of(&self, body: u32, turning: Option<u32>) -> Mat3 {
        let turn = match turning.map(|place| &self.turning[place as usize]) {
            Some(t) => t.spin.rotation * t.start.inverse(),
            None => {
                let vector = self.displacements[body as usize].angular;
                rotate_by(Quat::IDENTITY, vector, 1.0)
            }
        };
        Mat3::from_quat(turn)
    }
}

/// The tolerance of a sub-step, m/s: the user's or, where bodies move, a share of the speed of the fastest; or that of its
/// rebounds, the fastest of which has the speed `rebound`.
fn tolerance(
    config: &SolverConfig,
    rows: &[PointRows],
    bodies: &[SolverBody],
    rebound: f32,
) -> Option<f32> {
    let squares = bodies.iter().map(|body| body.linear.length_squared());
    let scales = rows.iter().map(|point| point.speed_scale);
    let fastest = squares.fold(0.0, f32::max).sqrt() * scales.fold(f32::INFINITY, f32::min);
    let asked = config.tolerance.map(|t| t.max(MOVING_TOLERANCE * fastest));
    let of_rebounds = (rebound > 0.0).then_some(REBOUND_TOLERANCE * rebound);
    match (asked, of_rebounds) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}
