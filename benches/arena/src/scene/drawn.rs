//! Scenes of the library's judge as scenes of the arena.

use super::{Scene, Truth};
use crate::judge::scene::{Form, Scene as Drawn};
use glam::{Quat, Vec3};

/// A drawn scene for all engines.
pub(crate) struct Heap {
    pub(crate) scene: Scene,
    /// Of each body: where in its frame the drawn body has its center of mass, which is the origin here, m.
    pub(crate) centers: Vec<Vec3>,
}

/// Half of the edge of the box that stands for a half-space, in largest distances of a body from the origin.
const WIDE: f32 = 4.0;

/// The scene with a wide box for each half-space, which not all engines have. `None` where a floor moves or materials differ, or where
/// a form is neither a box nor a hull.
pub(crate) fn with_boxes(drawn: &Drawn) -> Option<Drawn> {
    let mut scene = drawn.clone();
    let first = scene.actors.first()?;
    let material = (first.friction, first.restitution);
    let reach = scene.actors.iter().fold(0.0_f32, |reach, actor| {
        reach.max(actor.pose.position.length() + actor.form.radius())
    });
    for actor in &mut scene.actors {
        let is_still = (actor.linear, actor.angular) == (Vec3::ZERO, Vec3::ZERO);
        if (actor.friction, actor.restitution) != material || !(is_still || actor.is_dynamic()) {
            return None;
        }
        match actor.form {
            Form::Box(_) | Form::Hull(_) => {}
            Form::HalfSpace(normal) => {
                let half = WIDE * reach;
                actor.form = Form::Box(Vec3::splat(2.0 * half));
                actor.pose.position -= half * (actor.pose.rotation * normal.normalize());
                actor.pose.rotation *= Quat::from_rotation_arc(Vec3::Y, normal.normalize());
            }
            Form::Smooth(..) | Form::Rounded(..) | Form::Compound(_) | Form::Ground(_) => {
                return None;
            }
        }
    }
    Some(scene)
}

/// What [`with_boxes`] gives, for all engines.
pub(crate) fn heap(drawn: &Drawn) -> Heap {
    let mut scene = Scene::new(&drawn.family, Truth::Settle { walls: 0.0 });
    scene.gravity = drawn.gravity;
    scene.dt = drawn.step_length();
    scene.steps = drawn.steps as usize;
    (scene.friction, scene.restitution) = drawn
        .actors
        .first()
        .map_or((0.0, 0.0), |actor| (actor.friction, actor.restitution));
    let mut centers = Vec::new();
    for actor in &drawn.actors {
        let (shape, center) = match &actor.form {
            Form::Box(size) => (scene.boxed(0.5 * *size), Vec3::ZERO),
            Form::Hull(points) => scene.hull(points),
            Form::HalfSpace(_)
            | Form::Smooth(..)
            | Form::Rounded(..)
            | Form::Compound(_)
            | Form::Ground(_) => unreachable!("`with_boxes` gives boxes and hulls"),
        };
        centers.push(center);
        let at = actor.pose.transform_point(center);
        let body = scene.add(shape, at);
        body.fixed = !actor.is_dynamic();
        body.density = actor.density;
        body.rot = actor.pose.rotation;
        (body.linvel, body.angvel) = (actor.linear, actor.angular);
    }
    Heap { scene, centers }
}
