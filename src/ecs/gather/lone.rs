//! What is said of a body on an entity that is none: it does nothing, and the entity says so for as long as that lasts.

use crate::bodies::anchors::Anchors;
use crate::bodies::body::{BodyError, RigidBody};
use crate::bodies::drive::LockedAxes;
use crate::bodies::fatigue::Fatigue;
use crate::contact::surface::SurfaceMaterials;
use crate::ecs::collisions::{CollisionEvents, ContactForceEvents, Sensor};
use crate::ecs::components::*;
use crate::ecs::forces::*;
use crate::ecs::issues::{Issues, Source};
use crate::ecs::parts::CompoundOfChildren;
use crate::ecs::state::PluginState;
use crate::geometry::{Compound, ConvexMesh, HalfSpaceShape, StaticMesh};
use crate::slice::fracturable::Fracturable;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::query::Allow;
use bevy_ecs::system::SystemParam;

/// What mends nothing and does nothing without a [`RigidBody`]. Not among them: what a body that is no more leaves behind, such as its
/// density and its velocities.
type Parts = (
    (ConvexMesh, Compound, HalfSpaceShape, StaticMesh),
    (Fracturable, Anchors, Fatigue, SurfaceMaterials),
    (Sensor, CollisionEvents, ContactForceEvents),
    (
        Mass,
        MassOverride,
        GravityScale,
        ConstantForce,
        ConstantTorque,
    ),
    (LinearDamping, AngularDamping, MaxSpeed, LockedAxes),
);

/// Entities that have some of it.
pub(crate) type HasPart = Or<(
    Or<(
        With<ConvexMesh>,
        With<Compound>,
        With<HalfSpaceShape>,
        With<StaticMesh>,
    )>,
    Or<(
        With<Fracturable>,
        With<Anchors>,
        With<Fatigue>,
        With<SurfaceMaterials>,
    )>,
    Or<(
        With<Sensor>,
        With<CollisionEvents>,
        With<ContactForceEvents>,
    )>,
    Or<(
        With<Mass>,
        With<MassOverride>,
        With<GravityScale>,
        With<ConstantForce>,
        With<ConstantTorque>,
    )>,
    Or<(
        With<LinearDamping>,
        With<AngularDamping>,
        With<MaxSpeed>,
        With<LockedAxes>,
    )>,
)>;

/// Observer: an entity that is no body got something of one.
pub(crate) fn on_lone_part_added(
    add: On<Add<Parts>>,
    bodies: Query<(), (With<RigidBody>, Allow<Disabled>)>,
    state: ResMut<PluginState>,
) {
    queue(add.entity, &bodies, state);
}

/// Observer: an entity that is no body lost something of one.
pub(crate) fn on_lone_part_removed(
    remove: On<Remove<Parts>>,
    bodies: Query<(), (With<RigidBody>, Allow<Disabled>)>,
    state: ResMut<PluginState>,
) {
    queue(remove.entity, &bodies, state);
}

fn queue(
    entity: Entity,
    bodies: &Query<(), (With<RigidBody>, Allow<Disabled>)>,
    mut state: ResMut<PluginState>,
) {
    let lone = &mut state.queue.lone_parts;
    // One bundle may have several.
    if lone.last() != Some(&entity) && !bodies.contains(entity) {
        lone.push(entity);
    }
}

/// What is looked at of entities that may be no bodies.
#[derive(SystemParam)]
pub(crate) struct LoneParts<'w, 's> {
    parts: Query<'w, 's, Has<RigidBody>, (HasPart, Allow<Disabled>)>,
    bodies: Query<'w, 's, (), (With<RigidBody>, Allow<Disabled>)>,
    above: Query<'w, 's, (Option<&'static ChildOf>, Has<CompoundOfChildren>), Allow<Disabled>>,
}

impl LoneParts<'_, '_> {
    /// Whether something does nothing: the entity has no body, and is part of none.
    fn is_idle(&self, entity: Entity) -> bool {
        let mut next = Some(entity);
        while let Some((child_of, is_compound)) = next.and_then(|at| self.above.get(at).ok()) {
            if is_compound {
                return false;
            }
            next = child_of.map(ChildOf::parent);
        }
        self.parts.get(entity).is_ok_and(|is_body| !is_body)
    }

    /// Tells of those that are queued what they are now.
    pub(super) fn tell(
        &self,
        queued: &mut Vec<Entity>,
        issues: &mut Issues,
        warnings: &mut Messages<BodyWarning>,
    ) {
        for entity in queued.drain(..) {
            if self.bodies.contains(entity) {
                continue;
            }
            issues.mend_body(entity);
            if self.is_idle(entity) {
                issues.raise(warnings, entity, Source::Body, BodyError::NoRigidBody);
            }
        }
    }
}
