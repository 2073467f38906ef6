//! The same scene turned, moved, mirrored and with its bodies named in another order does the same; and so it does in finer
//! steps, nearer and nearer to one answer.

use super::alike::{TIMES, nudged};
use super::generate::turn;
use super::laws::{Breach, Law};
use super::run::Run;
use super::scene::{Form, Role, Scene};
use glam::{DVec3, Quat, Vec3};

/// How far a body may be from where it is in the scene itself, as a share of its largest extent. Moved, only rounding
/// differs. Turned, mirrored or in another order, friction has other axes and sweeps go through the contacts in another
/// order; they end when they change velocities by less than a hundredth of the fastest: that much of a way of some lengths.
const ROUNDING: f64 = 1e-3;
const ORDER: f64 = 0.03;

/// How many times 1e-4 of their size bodies are nudged, for what ends of sweeps and parts of a step may change.
const BY_SWEEPS: f32 = 10.0;
const BY_STEPS: f32 = 100.0;

/// How far steps of a quarter may be from steps of a half, beyond how far these are from whole ones: what an impact that falls
/// into another part of a step changes.
const STEP: f64 = 0.03;

/// Another way to say the same scene.
struct Way {
    name: &'static str,
    turn: Quat,
    shift: Vec3,
    /// Whether x is mirrored, before all else.
    is_mirrored: bool,
    /// Whether the bodies come in the opposite order.
    is_reversed: bool,
    bound: f64,
}

impl Way {
    /// The scene as it is.
    fn plain(name: &'static str, bound: f64) -> Self {
        Self {
            name,
            turn: Quat::IDENTITY,
            shift: Vec3::ZERO,
            is_mirrored: false,
            is_reversed: false,
            bound,
        }
    }

    fn all(scene: &Scene) -> [Self; 4] {
        let size = scene.actors.iter().filter(|actor| actor.is_dynamic());
        let size = size.fold(0.0_f32, |size, actor| size.max(actor.form.radius()));
        [
            Self {
                turn: Quat::from_xyzw(0.36, -0.48, 0.64, 0.48),
                ..Self::plain("turned", ORDER)
            },
            Self {
                shift: size * Vec3::new(5.0, -3.0, 7.0),
                ..Self::plain("moved", ROUNDING)
            },
            Self {
                is_mirrored: true,
                ..Self::plain("mirrored", ORDER)
            },
            Self {
                is_reversed: true,
                ..Self::plain("renamed", ORDER)
            },
        ]
    }

    /// The scene said this way.
    fn say(&self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        if self.is_mirrored {
            mirror(&mut scene);
        }
        turn(&mut scene, self.turn);
        for actor in &mut scene.actors {
            actor.pose.position += self.shift;
        }
        if self.is_reversed {
            scene.actors.reverse();
        }
        scene
    }

    /// Where a point of the scene is, said this way.
    fn place(&self, mut point: DVec3) -> DVec3 {
        if self.is_mirrored {
            point.x = -point.x;
        }
        self.turn.as_dquat().normalize() * point + self.shift.as_dvec3()
    }

    /// How far the bodies are from where they are in the scene itself, in their largest extents.
    fn off(&self, told: &Run<'_>, scene: &Run<'_>) -> f64 {
        let mut centers: Vec<DVec3> = told
            .dynamic()
            .map(|(_, slot, _)| told.state(slot).center)
            .collect();
        if self.is_reversed {
            centers.reverse();
        }
        let right = scene.dynamic().map(|(_, slot, _)| {
            let (_, radius) = scene.size(slot);
            (self.place(scene.state(slot).center), radius)
        });
        let offs = right.zip(centers);
        offs.fold(0.0, |worst, ((right, radius), center)| {
            worst.max(right.distance(center) / (2.0 * radius))
        })
    }
}

fn mirror(scene: &mut Scene) {
    let flip = Vec3::new(-1.0, 1.0, 1.0);
    scene.gravity *= flip;
    for actor in &mut scene.actors {
        match &mut actor.form {
            Form::Box(_) => {}
            Form::Hull(corners) => corners.iter_mut().for_each(|corner| *corner *= flip),
            Form::HalfSpace(normal) => *normal *= flip,
            Form::Smooth(..) => {}
            Form::Rounded(..) | Form::Compound(_) | Form::Ground(_) => {
                unreachable!("no family that is mirrored has them")
            }
        }
        actor.pose.position *= flip;
        actor.linear *= flip;
        let [x, y, z, w] = actor.pose.rotation.to_array();
        actor.pose.rotation = Quat::from_xyzw(x, -y, -z, w);
        // What turns is mirrored the other way.
        actor.angular *= -flip;
    }
}

/// Runs of several scenes; `None` if one cannot be set up.
fn runs(scenes: &[Scene]) -> Option<Vec<Run<'_>>> {
    scenes.iter().map(|scene| Run::new(scene, false)).collect()
}

/// The scene nudged in three directions, `times` as far as a floor's scenes are.
fn nudges(scene: &Scene, times: f32) -> [Scene; 3] {
    Vec3::AXES.map(|axis| nudged(scene, times * axis))
}

/// How far the runs of nudged scenes are from that of the scene itself, in largest extents.
fn spread(nudged: &[Run<'_>], scene: &Run<'_>) -> f64 {
    let itself = Way::plain("itself", 0.0);
    let offs = nudged.iter().map(|nudged| itself.off(nudged, scene));
    offs.fold(0.0, f64::max)
}

/// Whether all ways to say the scene do the same.
pub(crate) fn judge_same(scene: &Scene) -> Option<Breach> {
    let scene = &scene.version(Role::Here);
    let ways = Way::all(scene);
    let told = ways.each_ref().map(|way| way.say(scene));
    let nudges = nudges(scene, BY_SWEEPS);
    let mut right = Run::new(scene, false)?;
    let (mut told, mut nudged) = (runs(&told)?, runs(&nudges)?);
    let mut worst: Option<Breach> = None;
    for step in 1..=scene.steps {
        right.step();
        told.iter_mut().chain(&mut nudged).for_each(Run::step);
        let spread = spread(&nudged, &right);
        for (way, run) in ways.iter().zip(&told) {
            let off = way.off(run, &right);
            let excess = off / way.bound.max(TIMES * spread);
            if excess > worst.as_ref().map_or(1.0, |worst| worst.excess) {
                let name = way.name;
                worst = Some(Breach {
                    law: Law::Same,
                    excess,
                    what: format!(
                        "{name}: {off:.1e} of an extent away in step {step}, a nudge: {spread:.1e}"
                    ),
                });
            }
        }
    }
    worst
}

/// Whether halving the step for the second time changes no more than for the first time.
pub(crate) fn judge_finer(scene: &Scene) -> Option<Breach> {
    const PARTS: [u8; 3] = [1, 2, 4];
    let scene = &scene.version(Role::Here);
    let finer = PARTS.map(|parts| Scene {
        rate: scene.rate * f32::from(parts),
        ..scene.clone()
    });
    let nudges = nudges(scene, BY_STEPS);
    let (mut finer, mut nudged) = (runs(&finer)?, runs(&nudges)?);
    for _ in 0..scene.steps {
        for (run, parts) in finer.iter_mut().zip(PARTS) {
            (0..parts).for_each(|_| run.step());
        }
        nudged.iter_mut().for_each(Run::step);
    }
    let spread = spread(&nudged, &finer[0]);
    let itself = Way::plain("itself", STEP);
    let [first, second] = [1, 2].map(|i| itself.off(&finer[i], &finer[i - 1]));
    let excess = second / first.max(itself.bound).max(TIMES * spread);
    (excess > 1.0).then(|| Breach {
        law: Law::Finer,
        excess,
        what: format!(
            "halved once: {first:.1e} of an extent, twice: {second:.1e}, a nudge: {spread:.1e}"
        ),
    })
}
