//! Motion between fixed steps: what is drawn lies between the last two of them, at any frame rate and in slow motion.
//!
//! After the steps of a frame each `Transform` is put between the two poses, before the next ones it is put back, so that the
//! physics finds what it wrote. Whoever moves a body in between has the last word: it is there at once, without a streak.

use crate::bodies::body::RigidBody;
use crate::ecs::components::{AngularVelocity, LinearVelocity};
use crate::ecs::rewind::{PhysicsHistory, Rewound};
use crate::mass::MassProperties;
use crate::plugin::{PhysicsSchedule, PhysicsSystems};
use bevy_app::{App, FixedPreUpdate, Plugin, RunFixedMainLoop, RunFixedMainLoopSystems};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::query::Allow;
use bevy_math::Quat;
#[cfg(feature = "reflect")]
use bevy_reflect::std_traits::ReflectDefault;
use bevy_time::{Fixed, Time};
use bevy_transform::components::Transform;

/// Bodies move smoothly at any frame rate: between fixed steps their `Transform` lies between the last two poses, so they are
/// drawn up to one step late.
///
/// For a [`CleavePlugin`](crate::plugin::CleavePlugin) that runs in fixed time steps, as it does by default. Pieces go on from where
/// they were cut. A body whose `Transform` is set is there at once; a kinematic one that is moved in `FixedUpdate` goes
/// there smoothly. Systems in fixed schedules read poses of steps, others what is drawn.
#[derive(Clone, Copy, Debug, Default)]
pub struct InterpolationPlugin;

/// This body jumps from step to step, in an app with [`InterpolationPlugin`].
#[derive(Clone, Copy, Component, Debug, Default)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "reflect", reflect(Component, Default))]
pub struct NoInterpolation;

/// Poses of a body. A piece is no continuation of the body that it was cut from, so it begins anew.
#[derive(Clone, Copy, Component, Debug, Default)]
#[component(clone_behavior = Ignore)]
struct Motion {
    /// Before the last step.
    past: Option<Place>,
    /// After it, and what is drawn.
    moved: Option<(Transform, Transform)>,
}

/// A pose beneath a parent, if there is one: beneath another one the same numbers are another place.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    parent: Option<Entity>,
    local: Transform,
}

impl Place {
    fn new(local: Transform, child_of: Option<&ChildOf>) -> Self {
        Self {
            parent: child_of.map(ChildOf::parent),
            local,
        }
    }
}

impl Plugin for InterpolationPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            RunFixedMainLoop,
            (
                (begin, put_back)
                    .chain()
                    .in_set(RunFixedMainLoopSystems::BeforeFixedMainLoop),
                (begin, ease)
                    .chain()
                    .in_set(RunFixedMainLoopSystems::AfterFixedMainLoop),
            ),
        )
        .add_systems(FixedPreUpdate, remember)
        .add_systems(
            PhysicsSchedule,
            forget_jumps.before(PhysicsSystems::MassProperties),
        );
        #[cfg(feature = "reflect")]
        app.register_type::<NoInterpolation>();
    }

    /// Where time may go back, bodies are where that puts them.
    fn finish(&self, app: &mut App) {
        if app.world().contains_resource::<PhysicsHistory>() {
            app.add_observer(begin_anew);
        }
    }
}

/// What moves, and has no [`Motion`] yet.
type New = (
    With<MassProperties>,
    Without<Motion>,
    Without<NoInterpolation>,
);

fn begin(mut commands: Commands, bodies: Query<(Entity, &RigidBody), New>) {
    for (entity, kind) in &bodies {
        if *kind != RigidBody::Static {
            commands.entity(entity).insert(Motion::default());
        }
    }
}

/// Of bodies that are disabled too: they stay where the physics left them.
fn put_back(mut bodies: Query<(&mut Transform, &mut Motion), Allow<Disabled>>) {
    for (mut transform, mut motion) in &mut bodies {
        if let Some((now, shown)) = motion.moved.take() {
            if *transform == shown {
                transform.set_if_neq(now);
            } else {
                motion.past = None;
            }
        }
    }
}

/// Observer: where bodies were taken back to they are at once.
fn begin_anew(_: On<Rewound>, mut bodies: Query<&mut Motion, Allow<Disabled>>) {
    for mut motion in &mut bodies {
        *motion = Motion::default();
    }
}

fn remember(mut bodies: Query<(&Transform, Option<&ChildOf>, &mut Motion)>) {
    for (transform, child_of, mut motion) in &mut bodies {
        motion.past = Some(Place::new(*transform, child_of));
    }
}

type Stepped = (
    &'static Transform,
    Option<&'static ChildOf>,
    &'static RigidBody,
    &'static mut Motion,
);

/// A body that was set elsewhere before the step did not move there. A kinematic one did.
fn forget_jumps(mut bodies: Query<Stepped>) {
    for (transform, child_of, kind, mut motion) in &mut bodies {
        let place = Place::new(*transform, child_of);
        let is_moved = motion.past.is_some_and(|past| {
            let goes_there = *kind == RigidBody::Kinematic && past.parent == place.parent;
            past != place && !goes_there
        });
        if is_moved {
            motion.past = Some(place);
        }
    }
}

type Moving = (
    &'static mut Transform,
    &'static mut Motion,
    &'static LinearVelocity,
    &'static AngularVelocity,
    &'static MassProperties,
    Option<&'static ChildOf>,
);

fn ease(fixed: Res<Time<Fixed>>, mut bodies: Query<Moving, Without<NoInterpolation>>) {
    let share = fixed.overstep_fraction();
    let step = fixed.timestep().as_secs_f32();
    for (mut transform, mut motion, velocity, spin, mass, child_of) in &mut bodies {
        let now = *transform;
        let place = Place::new(now, child_of);
        let past = motion.past.filter(|past| past.parent == place.parent);
        // Velocities are in world axes, and so is only what has no parent.
        let past = past.map(|past| past.local).unwrap_or_else(|| {
            if child_of.is_some() {
                now
            } else {
                a_step_ago(&now, [velocity.0, spin.0].map(|v| step * v), mass)
            }
        });
        let mut shown = now;
        // Rounding would move what rests.
        if past != now {
            shown.translation = past.translation.lerp(now.translation, share);
            shown.rotation = past.rotation.slerp(now.rotation, share);
        }
        motion.past = Some(Place {
            local: past,
            ..place
        });
        motion.moved = Some((now, shown));
        transform.set_if_neq(shown);
    }
}

/// Where a body that is new came from, by the way (m) and turn (rad) of a step: a piece moves as what it was part of did.
fn a_step_ago(
    now: &Transform,
    [way, turn]: [bevy_math::Vec3; 2],
    mass: &MassProperties,
) -> Transform {
    let rotation = Quat::from_scaled_axis(-turn) * now.rotation;
    let center = now.translation + now.rotation * mass.center;
    Transform {
        translation: center - way - rotation * mass.center,
        rotation,
        ..*now
    }
}
