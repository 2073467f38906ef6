//! What only some bodies have: events of their contacts, and what drives them. Read when it changes; a scene in which no entity
//! ever had any of it is not looked at.

use crate::bodies::anchors::Anchors;
use crate::bodies::body::{BodyError, RigidBody};
use crate::bodies::drive::{BodyDrive, LockedAxes};
use crate::bodies::fatigue::Fatigue;
use crate::bodies::store::Bodies;
use crate::ecs::collisions::{CollisionEvents, ContactForceEvents};
use crate::ecs::components::*;
use crate::ecs::forces::*;
use crate::ecs::issues::{Issues, Source};
use crate::ecs::state::{OptionQueue, PluginState};
use crate::geometry::Compound;
use crate::slice::fracturable::Fracturable;
use crate::step::{ContactEvents, ContactWatch, Contacts};
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_math::Vec3;

/// The components that are options.
type Options = (
    (CollisionEvents, ContactForceEvents, LockedAxes, MaxSpeed),
    (GravityScale, LinearDamping, AngularDamping),
    (ConstantForce, ConstantTorque, Anchors, Fatigue),
    SurfaceVelocity,
);

/// What may have changed of them without having come or gone.
pub(crate) type ChangedOptions = Or<(
    Changed<ContactForceEvents>,
    Changed<LockedAxes>,
    Changed<MaxSpeed>,
    Changed<GravityScale>,
    Changed<LinearDamping>,
    Changed<AngularDamping>,
    Changed<ConstantForce>,
    Changed<ConstantTorque>,
    Changed<SurfaceVelocity>,
    Changed<Anchors>,
    Changed<Fatigue>,
    // Whether it can wear out depends on them.
    (With<Fatigue>, Changed<Fracturable>),
    (With<Fatigue>, Changed<Compound>),
)>;

/// All of them.
#[derive(QueryData)]
pub(crate) struct BodyOptions {
    handle: &'static BodyHandle,
    touches: Has<CollisionEvents>,
    force_events: Option<&'static ContactForceEvents>,
    locked: Option<&'static LockedAxes>,
    max_speed: Option<&'static MaxSpeed>,
    gravity_scale: Option<&'static GravityScale>,
    linear_damping: Option<&'static LinearDamping>,
    angular_damping: Option<&'static AngularDamping>,
    force: Option<&'static ConstantForce>,
    torque: Option<&'static ConstantTorque>,
    surface_velocity: Option<&'static SurfaceVelocity>,
    anchors: Option<&'static Anchors>,
    fatigue: Option<&'static Fatigue>,
}

/// Observer: a body got an option.
pub(crate) fn on_option_inserted(insert: On<Insert<Options>>, mut state: ResMut<PluginState>) {
    state.options.is_used = true;
    state.options.entities.push(insert.entity);
}

/// Observer: a body lost an option.
pub(crate) fn on_option_removed(remove: On<Remove<Options>>, mut state: ResMut<PluginState>) {
    state.options.entities.push(remove.entity);
}

/// Reads the options of entities that were queued or changed.
pub(crate) fn read_options(
    queue: &mut OptionQueue,
    (bodies, entities): (&mut Bodies, &BodyEntities),
    (issues, warnings): (&mut Issues, &mut Messages<BodyWarning>),
    changed: &Query<Entity, (ChangedOptions, With<BodyHandle>)>,
    options: &Query<BodyOptions>,
) {
    if !queue.is_used {
        return;
    }
    let queued = std::mem::take(&mut queue.entities);
    for entity in queued.into_iter().chain(changed) {
        if let Ok(item) = options.get(entity) {
            read_option(queue, (bodies, entities), (issues, warnings), entity, &item);
        }
    }
}

fn read_option(
    queue: &mut OptionQueue,
    (bodies, entities): (&mut Bodies, &BodyEntities),
    (issues, warnings): (&mut Issues, &mut Messages<BodyWarning>),
    entity: Entity,
    item: &BodyOptionsItem,
) {
    let Some((slot, id)) = item
        .handle
        .0
        .filter(|&(slot, id)| bodies.is_current(slot, id))
    else {
        return;
    };
    let drive = BodyDrive {
        gravity_scale: item.gravity_scale.map_or(1.0, |scale| scale.0),
        linear_damping: item.linear_damping.map_or(0.0, |damping| damping.0),
        angular_damping: item.angular_damping.map_or(0.0, |damping| damping.0),
        max_speed: item.max_speed.map_or(f32::INFINITY, |most| most.linear),
        max_angular_speed: item.max_speed.map_or(f32::INFINITY, |most| most.angular),
        locked: item.locked.copied().unwrap_or_default(),
        force: item.force.map_or(Vec3::ZERO, |force| force.0),
        torque: item.torque.map_or(Vec3::ZERO, |torque| torque.0),
        surface_velocity: (item.surface_velocity).map_or(Vec3::ZERO, |velocity| velocity.0),
    };
    let force = (item.force_events).map_or(f32::INFINITY, |events| events.threshold);
    let is_usable = (!force.is_nan()).then_some(());
    let taken = is_usable.ok_or(BodyError::Drive("ContactForceEvents"));
    let taken = taken.and(bodies.set_drive(slot, drive));
    let taken = taken.and(idle_force(bodies.kind(slot), &drive));
    issues.note(warnings, entity, Source::Options, taken);
    let scale = entities.seen[slot as usize].scale;
    let held = read_anchors(bodies, slot, item.anchors, scale);
    issues.note(warnings, entity, Source::Anchors, held);
    let worn = bodies.set_fatigue(slot, item.fatigue.copied());
    let can_wear = bodies.fracturable(slot).is_some() || bodies.is_bonded(slot);
    let is_idle = item.fatigue.is_some() && !can_wear;
    let is_idle = is_idle.then_some(Err(BodyError::IdleFatigue));
    let worn = worn.and(is_idle.unwrap_or(Ok(())));
    issues.note(warnings, entity, Source::Fatigue, worn);
    let watch = ContactWatch {
        touches: item.touches,
        force: if force.is_nan() { f32::INFINITY } else { force },
    };
    queue.watches.push((slot, id, watch));
}

/// A push that does nothing. What bounds a motion is no such thing: what stands still keeps to it.
fn idle_force(kind: RigidBody, drive: &BodyDrive) -> Result<(), BodyError> {
    let is_pushed = (drive.force, drive.torque) != (Vec3::ZERO, Vec3::ZERO);
    if is_pushed && kind != RigidBody::Dynamic {
        return Err(BodyError::IdleForce);
    }
    Ok(())
}

/// Takes over where a body holds on to the world.
fn read_anchors(
    bodies: &mut Bodies,
    slot: u32,
    anchors: Option<&Anchors>,
    scale: Vec3,
) -> Result<(), BodyError> {
    let scaled = anchors.map(|anchors| anchors.scaled(scale));
    bodies.set_anchors(slot, scaled)?;
    if anchors.is_some() && bodies.kind(slot) == RigidBody::Dynamic {
        return Err(BodyError::Anchors("a Dynamic body holds on to nothing"));
    }
    Ok(())
}

/// Says whose contacts are to be watched.
pub(crate) fn set_watches(queue: &mut OptionQueue, bodies: &Bodies, events: &mut ContactEvents) {
    for (slot, id, watch) in queue.watches.drain(..) {
        if bodies.is_current(slot, id) {
            events.watch(bodies, slot, watch);
        }
    }
}

/// Reads the options of pieces that were made in this step, before their first news.
pub(super) fn settle_options(world: &mut World) {
    let state = &mut *world.resource_mut::<PluginState>();
    let mut queue = std::mem::take(&mut state.options);
    let mut issues = std::mem::take(&mut state.issues);
    let entities = std::mem::take(&mut state.entities);
    if !queue.entities.is_empty() {
        let mut options = world.query::<BodyOptions>();
        world.resource_scope(|world, mut bodies: Mut<Bodies>| {
            world.resource_scope(|world, mut warnings: Mut<Messages<BodyWarning>>| {
                for entity in std::mem::take(&mut queue.entities) {
                    if let Ok(item) = options.get(world, entity) {
                        let tell = (&mut issues, &mut *warnings);
                        read_option(&mut queue, (&mut bodies, &entities), tell, entity, &item);
                    }
                }
            });
            let mut contacts = world.resource_mut::<Contacts>();
            set_watches(&mut queue, &bodies, &mut contacts.events);
        });
    }
    let state = &mut *world.resource_mut::<PluginState>();
    (state.options, state.issues, state.entities) = (queue, issues, entities);
}
