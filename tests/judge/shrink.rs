//! The smallest scene that still breaks a law: bodies are taken away, time is cut short, shapes and numbers made simpler, as
//! long as it is sound and still fails.
//!
//! A change must not make the scene fail for another reason: bodies must not overlap at the start, nothing may lose what it
//! stands on or become what the law is not about, and what needs time to come to rest keeps it.

use super::laws::{Law, judge};
use super::run::Run;
use super::scene::{Actor, Form, Role, Scene};
use bevy_cleave::prelude::RigidBody;
use glam::{Quat, Vec3};

/// Overlap at the start that is rounding, as a share of the smaller least extent.
const ROUNDING: f64 = 1e-3;

/// How far beyond the bound, at least, what is left breaks the law, if the scene itself does: not just so.
const CLEAR: f64 = 2.0;

/// A simpler scene, if there is one.
type Change = dyn Fn(&Scene, usize) -> Option<Scene>;

/// The scene made as small as `runs` trials allow.
pub(crate) fn shrink(scene: &Scene, law: Law, runs: usize) -> Scene {
    let mut best = Scene {
        laws: vec![law],
        ..scene.clone()
    };
    let clear = excess(&best).min(CLEAR);
    let mut trials = Trials { left: runs, clear };
    let scene_changes: [&Change; 4] = [&shorter, &less_short, &usual_rate, &upright];
    let actor_changes: [&Change; 9] = [
        &without,
        &as_box,
        &half_the_corners,
        &still,
        &straight,
        &plain,
        &denser,
        &rounded,
        &fewer_corners,
    ];
    loop {
        let before = trials.left;
        let size = best.clone();
        for change in scene_changes {
            attempt(&mut best, &mut trials, change, 0);
        }
        for change in actor_changes {
            // From the last on, so that numbers of those before stay.
            for actor in (0..best.actors.len()).rev() {
                attempt(&mut best, &mut trials, change, actor);
            }
        }
        if trials.left == 0 || best == size || trials.left == before {
            return best;
        }
    }
}

/// Trials that may still be made, and by how much each has to break the law.
struct Trials {
    left: usize,
    clear: f64,
}

/// By how much the scene breaks its law; zero if it keeps it.
fn excess(scene: &Scene) -> f64 {
    let breaches = judge(scene);
    breaches
        .iter()
        .fold(0.0, |most, breach| most.max(breach.excess))
}

fn attempt(best: &mut Scene, trials: &mut Trials, change: &Change, actor: usize) {
    while trials.left > 0 {
        let Some(simpler) = change(best, actor).filter(|simpler| simpler != best) else {
            return;
        };
        if !is_sound(&simpler) {
            return;
        }
        trials.left -= 1;
        if excess(&simpler) < trials.clear {
            return;
        }
        *best = simpler;
    }
}

/// Whether no two bodies overlap at the start and all have a shape.
fn is_sound(scene: &Scene) -> bool {
    let version = scene.version(Role::Here);
    let Some(run) = Run::new(&version, false) else {
        return false;
    };
    let solids = run.solids();
    let min_extent = |i: usize| match run.size(run.slots[i]) {
        (0.0, _) => f64::INFINITY,
        (min_extent, _) => min_extent,
    };
    run.dynamic().all(|(i, ..)| {
        (0..solids.len()).filter(|&j| j != i).all(|j| {
            let bound = -ROUNDING * min_extent(i).min(min_extent(j));
            run.gap(&solids, i, j, bound) >= bound
        })
    })
}

/// Whether the law asks for all the time that the scene was given.
fn needs_time(scene: &Scene) -> bool {
    scene.has(Law::Rest) || scene.has(Law::Sleep)
}

fn changed(scene: &Scene, change: impl FnOnce(&mut Scene)) -> Option<Scene> {
    let mut changed = scene.clone();
    change(&mut changed);
    Some(changed)
}

fn shorter(scene: &Scene, _: usize) -> Option<Scene> {
    let is_fixed = needs_time(scene) || scene.steps < 2;
    (!is_fixed).then(|| changed(scene, |s| s.steps /= 2))?
}

fn less_short(scene: &Scene, _: usize) -> Option<Scene> {
    let is_fixed = needs_time(scene) || scene.steps < 10;
    (!is_fixed).then(|| changed(scene, |s| s.steps -= s.steps / 10))?
}

/// 60 steps in a second where there are fewer: coarser ones might be too coarse.
fn usual_rate(scene: &Scene, _: usize) -> Option<Scene> {
    (scene.rate < 60.0).then(|| {
        changed(scene, |s| {
            s.steps = (s.steps as f32 * 60.0 / s.rate) as u32;
            s.rate = 60.0;
        })
    })?
}

/// Down is -y, if turning back the vector of gravity is all it takes.
fn upright(scene: &Scene, _: usize) -> Option<Scene> {
    let down = scene.gravity.try_normalize()?;
    changed(scene, |s| {
        super::generate::turn(s, Quat::from_rotation_arc(down, Vec3::NEG_Y));
    })
}

fn without(scene: &Scene, actor: usize) -> Option<Scene> {
    let gone = scene.actors.get(actor)?;
    let needed = match gone.kind {
        _ if gone.role == Role::There => true,
        _ if gone.role == Role::Here => scene.has(Law::Seam) && is_near(scene, actor),
        RigidBody::Dynamic => scene.has(Law::Stand) && touching(scene, actor) > 1,
        _ => needs_time(scene) || scene.has(Law::Stand) || scene.has(Law::Seam),
    };
    (!needed).then(|| {
        changed(scene, |s| {
            s.actors.remove(actor);
        })
    })?
}

/// How many bodies touch a body at the start: what is on top of a tower touches one, and nothing leans on it.
fn touching(scene: &Scene, actor: usize) -> usize {
    let Some(run) = Run::new(scene, false) else {
        return usize::MAX;
    };
    let solids = run.solids();
    let (_, radius) = run.size(run.slots[actor]);
    let others = (0..solids.len()).filter(|&other| other != actor);
    let touches = |&other: &usize| run.gap(&solids, actor, other, radius) < ROUNDING * radius;
    others.filter(touches).count()
}

/// Whether a moving body of the scene compared with comes near a piece of the floor.
fn is_near(scene: &Scene, piece: usize) -> bool {
    let whole = scene.version(Role::There);
    let alone = Scene {
        actors: vec![scene.actors[piece].clone()],
        ..scene.clone()
    };
    let (Some(mut run), Some(alone)) = (Run::new(&whole, false), Run::new(&alone, false)) else {
        return true;
    };
    let Some(piece) = alone.solid(alone.slots[0]) else {
        return true;
    };
    (0..=scene.steps).any(|_| {
        run.step();
        let mut bodies = run.dynamic();
        bodies.any(|(_, slot, _)| {
            let (_, radius) = run.size(slot);
            let speed = run.state(slot).linear.length();
            let margin = 0.5 * radius + 2.0 * speed * f64::from(scene.step_length());
            run.solid(slot)
                .is_none_or(|solid| solid.separation(&piece, margin) < margin)
        })
    })
}

fn with_actor(scene: &Scene, actor: usize, change: impl FnOnce(&mut Actor)) -> Option<Scene> {
    (actor < scene.actors.len()).then(|| changed(scene, |s| change(&mut s.actors[actor])))?
}

fn with_corners(
    scene: &Scene,
    actor: usize,
    change: impl FnOnce(&[Vec3]) -> Option<Form>,
) -> Option<Scene> {
    let actor_now = scene.actors.get(actor)?;
    // What lies on others, or is a piece of a floor, would not fit any more.
    let is_told = scene.has(Law::Stand) || scene.has(Law::Seam) && actor_now.role != Role::Both;
    let Form::Hull(corners) = &actor_now.form else {
        return None;
    };
    let form = change(corners).filter(|_| !is_told)?;
    with_actor(scene, actor, |actor| actor.form = form)
}

fn as_box(scene: &Scene, actor: usize) -> Option<Scene> {
    with_corners(scene, actor, |corners| {
        let far = corners.iter().fold(Vec3::ZERO, |far, c| far.max(c.abs()));
        Some(Form::Box(2.0 * far))
    })
}

fn half_the_corners(scene: &Scene, actor: usize) -> Option<Scene> {
    with_corners(scene, actor, |corners| {
        let half = corners.iter().step_by(2).copied().collect();
        (corners.len() >= 8).then_some(Form::Hull(half))
    })
}

/// Without the first corner whose loss does no harm is for the caller to find: this takes away the last.
fn fewer_corners(scene: &Scene, actor: usize) -> Option<Scene> {
    with_corners(scene, actor, |corners| {
        let (_, fewer) = corners.split_last()?;
        (fewer.len() >= 4).then(|| Form::Hull(fewer.to_vec()))
    })
}

fn still(scene: &Scene, actor: usize) -> Option<Scene> {
    let is_told = scene.has(Law::Cause) || scene.has(Law::Seam) || scene.has(Law::Tunnel);
    let is_carried = scene.actors.iter().any(|a| a.kind == RigidBody::Kinematic);
    let is_dynamic = scene.actors.get(actor)?.is_dynamic();
    (is_dynamic && !is_told && !is_carried).then(|| {
        with_actor(scene, actor, |a| {
            (a.linear, a.angular) = (Vec3::ZERO, Vec3::ZERO);
        })
    })?
}

fn straight(scene: &Scene, actor: usize) -> Option<Scene> {
    with_actor(scene, actor, |a| {
        let is_free = a.role == Role::Both || scene.has(Law::Cause);
        if is_free && !scene.has(Law::Stand) {
            a.pose.rotation = Quat::IDENTITY;
        }
    })
}

fn plain(scene: &Scene, actor: usize) -> Option<Scene> {
    with_actor(scene, actor, |a| {
        if !scene.has(Law::Elastic) {
            a.restitution = 0.0;
        }
        // Less friction could let slide what is to rest.
        if a.friction > 0.0 {
            a.friction = a.friction.max(0.5);
        }
    })
}

fn denser(scene: &Scene, actor: usize) -> Option<Scene> {
    with_actor(scene, actor, |a| a.density = 1000.0)
}

/// Two digits for sizes, places and speeds.
fn rounded(scene: &Scene, actor: usize) -> Option<Scene> {
    // Pieces of a floor would not be flush any more.
    let is_exact = scene.has(Law::Seam) || scene.has(Law::Stand);
    let is_told = is_exact || scene.actors.get(actor)?.role != Role::Both;
    (!is_told).then(|| {
        with_actor(scene, actor, |a| {
            if let Form::Box(size) = &mut a.form {
                *size = size.map(two_digits);
            }
            a.pose.position = a.pose.position.map(two_digits);
            a.linear = a.linear.map(two_digits);
            a.angular = a.angular.map(two_digits);
        })
    })?
}

fn two_digits(number: f32) -> f32 {
    format!("{number:.1e}").parse().expect("just written")
}
