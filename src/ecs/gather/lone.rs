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
    SurfaceVelocity,
    (LinearDamping, AngularDamping, MaxSpeed, LockedAxes),
);

/// Entities that have some of what a part of a compound has no use for.
type HasMore = Or<(
    Or<(With<Compound>, With<HalfSpaceShape>, With<StaticMesh>)>,
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
    With<SurfaceVelocity>,
    Or<(
        With<LinearDamping>,
        With<AngularDamping>,
        With<MaxSpeed>,
        With<LockedAxes>,
    )>,
)>;

/// Entities that have some of it.
pub(crate) type HasPart = Or<(With<ConvexMesh>, HasMore)>;

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

/// What is looked at of an entity on the way up to a compound.
type Above = (
    Option<&'static ChildOf>,
    Has<CompoundOfChildren>,
    Has<RigidBody>,
);

/// What is looked at of entities that may be no bodies.
#[derive(SystemParam)]
pub(crate) struct LoneParts<'w, 's> {
    parts: Query<'w, 's, (), (HasPart, Allow<Disabled>)>,
    more: Query<'w, 's, (), (HasMore, Allow<Disabled>)>,
    above: Query<'w, 's, Above, Allow<Disabled>>,
}

impl LoneParts<'_, '_> {
    fn is_body(&self, entity: Entity) -> bool {
        self.above.get(entity).is_ok_and(|(.., is_body)| is_body)
    }

    /// Whether the entity is a part of a compound: another body between the two has parts of its own.
    fn is_part(&self, entity: Entity) -> bool {
        let above = |entity| self.above.get(entity).ok();
        let mut next = above(entity).and_then(|(child_of, ..)| child_of);
        while let Some((child_of, is_compound, is_body)) =
            next.and_then(|child_of| above(child_of.parent()))
        {
            if is_compound || is_body {
                return is_compound;
            }
            next = child_of;
        }
        false
    }

    /// What does nothing on an entity that is no body.
    fn idle(&self, entity: Entity) -> Option<BodyError> {
        if self.is_part(entity) {
            let is_idle = self.more.contains(entity);
            is_idle.then_some(BodyError::IdlePart)
        } else {
            let is_idle = self.parts.contains(entity);
            is_idle.then_some(BodyError::NoRigidBody)
        }
    }

    /// Tells of those that are queued what they are now.
    pub(super) fn tell(
        &self,
        queued: &mut Vec<Entity>,
        issues: &mut Issues,
        warnings: &mut Messages<BodyWarning>,
    ) {
        for entity in queued.drain(..) {
            if self.is_body(entity) {
                continue;
            }
            issues.mend_body(entity);
            if let Some(error) = self.idle(entity) {
                issues.raise(warnings, entity, Source::Body, error);
            }
        }
    }
}
