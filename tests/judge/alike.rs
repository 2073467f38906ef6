//! Scenes that are two ways to say the same: they have to do the same.
//!
//! How far two runs may be apart is told by a third one: that of a scene nudged by 1e-4 of a body's size. Where a nudge
//! changes everything, so may rounding; where it does not, the bound is that of the law.

use super::laws::{Breach, Law};
use super::run::{Run, State};
use super::scene::{Actor, Role, Scene};
use bevy_cleave::testing::math::rotate;
use glam::{DVec3, Quat, Vec3};

/// Nudge, as a share of a body's size.
const NUDGE: f32 = 1e-4;

/// Turn of what slides beside its nudge, rad: a floor is the same wherever one stands on it, so that a nudge along it tells nothing of
/// what stands on an edge or a corner, and tips over when rounding has grown enough. A twelfth of a sag over a body's size.
const TILT: f32 = 1e-5;

/// How many times as much as a nudge does may be seen.
pub(crate) const TIMES: f64 = 3.0;

/// Difference of the velocities over one floor and over its pieces, as a share of the speed at the start. With friction sweeps
/// end when they change velocities by less than a hundredth of the fastest (`SolverConfig::tolerance`), and how the pressure
/// is shared between points that are more than three is open within that.
const VELOCITY: f64 = 1e-3;
const VELOCITY_WITH_FRICTION: f64 = 1e-2;

/// Difference of the heights, as a share of the body's largest extent; a contact's own sag is 1.25e-4 of the least.
const HEIGHT: f64 = 1e-3;

/// Whether what slides over many pieces does as over one.
pub(crate) fn judge_seam(scene: &Scene) -> Option<Breach> {
    let (pieces, whole) = (scene.version(Role::Here), scene.version(Role::There));
    let bounds = Bounds::new(scene);
    let up = bounds.up.as_vec3();
    let side = up.any_orthonormal_vector();
    let nudges = [side, side + up.cross(side)];
    let nudges = nudges.map(|nudge| tilted(nudged(&whole, nudge), nudge));
    let mut runs = [
        Run::new(&pieces, false)?,
        Run::new(&whole, false)?,
        Run::new(&nudges[0], false)?,
        Run::new(&nudges[1], false)?,
    ];
    let mut worst: Option<Breach> = None;
    // What a nudge has done so far: what tips over by a nudge does so by rounding too, at another time.
    let mut free = 0.0;
    for step in 1..=scene.steps {
        runs.iter_mut().for_each(Run::step);
        let [here, there, nudges @ ..] = &runs;
        let offs = nudges.iter().map(|nudge| bounds.off(nudge, there));
        free = offs.fold(free, f64::max);
        let excess = bounds.off(here, there) / (TIMES * free).max(1.0);
        if excess > worst.as_ref().map_or(1.0, |worst| worst.excess) {
            worst = Some(Breach {
                law: Law::Seam,
                excess,
                what: bounds.describe([here, there], step),
            });
        }
    }
    worst
}

/// The scene with its dynamic bodies pushed a little, one more than the other.
pub(crate) fn nudged(scene: &Scene, side: Vec3) -> Scene {
    let mut nudged = scene.clone();
    let dynamic = nudged.actors.iter_mut().filter(slides);
    for (i, actor) in dynamic.enumerate() {
        let share = [1.0, 0.5, 0.75][i % 3];
        actor.pose.position += share * NUDGE * actor.form.radius() * side;
    }
    nudged
}

/// Whether it is what moves, in both versions of the scene.
fn slides(actor: &&mut Actor) -> bool {
    actor.is_dynamic() && actor.role == Role::Both
}

/// The scene with what slides turned a little about `axis`.
fn tilted(mut scene: Scene, axis: Vec3) -> Scene {
    let tilt = Quat::from_scaled_axis(TILT * axis);
    for actor in scene.actors.iter_mut().filter(slides) {
        actor.pose.rotation = (tilt * actor.pose.rotation).normalize();
    }
    scene
}

/// What two runs may differ by.
struct Bounds {
    /// Share of the speed.
    share: f64,
    /// Speed at the start, m/s.
    speed: f64,
    /// Normal of the floor.
    up: DVec3,
}

impl Bounds {
    fn new(scene: &Scene) -> Self {
        let sliding = scene.actors.iter().filter(|a| a.role == Role::Both);
        let speed = sliding.fold(0.0_f32, |speed, a| speed.max(a.linear.length()));
        let is_smooth = scene.actors.iter().all(|actor| actor.friction == 0.0);
        let whole = scene.actors.iter().find(|a| a.role == Role::There);
        let up = whole.map_or(Vec3::Y, |whole| rotate(whole.pose.rotation, Vec3::Y));
        Self {
            share: [VELOCITY_WITH_FRICTION, VELOCITY][usize::from(is_smooth)],
            speed: speed.into(),
            up: up.as_dvec3(),
        }
    }

    /// The largest difference between the bodies of both, as a multiple of its bound.
    fn off(&self, one: &Run<'_>, other: &Run<'_>) -> f64 {
        let pairs = sliding(one).zip(sliding(other));
        pairs.fold(0.0, |worst, ((radius, a), (_, b))| {
            let bound = self.share * self.speed.max(b.linear.length());
            let velocity = (a.linear - b.linear).length() / bound;
            let height = self.up.dot(a.center - b.center).abs() / (2.0 * HEIGHT * radius);
            worst.max(velocity).max(height)
        })
    }

    /// What the first body does in both.
    fn describe(&self, [one, other]: [&Run<'_>; 2], step: u32) -> String {
        let say = |run: &Run<'_>| {
            sliding(run).next().map_or(String::new(), |(_, state)| {
                let speed = state.linear.length();
                format!("{speed:.4} m/s at {:.5} m", self.up.dot(state.center))
            })
        };
        format!("step {step}: {} on pieces, {} on one", say(one), say(other))
    }
}

/// Radius and motion of the bodies that are in both versions.
fn sliding<'r>(run: &'r Run<'_>) -> impl Iterator<Item = (f64, State)> + 'r {
    let both = run.dynamic().filter(|(_, _, a)| a.role == Role::Both);
    both.map(|(_, slot, _)| (run.size(slot).1, run.state(slot)))
}
