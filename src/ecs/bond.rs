//! Bonds between entities: requests from commands, and messages of what broke.

use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::ecs::components::*;
use crate::ecs::state::BondRequest;
use crate::ecs::state::BondRequests;
use crate::ecs::state::PluginState;
use crate::fracture::{Bond, BondError, Bonds};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;

/// Bonding on request.
pub trait BondCommands {
    /// Bonds the bodies of two entities as they lie before the next step, in place of a bond that they have.
    ///
    /// [`BondBroken`] tells when it breaks. Bonds of a body that is despawned go without a message, those of a body that is
    /// cut go to its pieces. A bond that cannot be made sends a [`BodyWarning`] about `a` with the reason.
    fn bond(&mut self, a: Entity, b: Entity, bond: Bond);

    /// Bonds all of these entities that touch face to face over their common areas, with a tensile and shear strength in
    /// Pa; see [`Bonds::bond_neighbors`]. Entities that have no body are left out with a [`BodyWarning`].
    fn bond_neighbors(&mut self, entities: impl IntoIterator<Item = Entity>, strength: f32);

    /// Takes the bond between two entities away, if they have one.
    fn unbond(&mut self, a: Entity, b: Entity);

    /// Takes all bonds of an entity away: it lets go of whatever held it.
    fn unbond_all(&mut self, entity: Entity);
}

impl BondCommands for Commands<'_, '_> {
    fn bond(&mut self, a: Entity, b: Entity, bond: Bond) {
        self.queue(BondRequest::Pair(a, b, bond).enqueue());
    }

    fn bond_neighbors(&mut self, entities: impl IntoIterator<Item = Entity>, strength: f32) {
        let entities = entities.into_iter().collect();
        self.queue(BondRequest::Neighbors(entities, strength).enqueue());
    }

    fn unbond(&mut self, a: Entity, b: Entity) {
        self.queue(BondRequest::Release(a, b).enqueue());
    }

    fn unbond_all(&mut self, entity: Entity) {
        self.queue(BondRequest::ReleaseAll(entity).enqueue());
    }
}

impl BondRequest {
    /// The command that puts it into the queue.
    fn enqueue(self) -> impl Command {
        move |world: &mut World| match world.get_resource_mut::<PluginState>() {
            Some(mut state) => state.bond_requests.0.push(self),
            None => log::warn!("a command about bonds does nothing: the app has no CleavePlugin"),
        }
    }
}

/// Makes and takes away the bonds that were asked for, once the entities have bodies.
pub(super) fn make_bonds(
    requests: &mut BondRequests,
    bodies: &mut Bodies,
    bonds: &mut Bonds,
    warnings: &mut Messages<BodyWarning>,
    handles: &Query<&BodyHandle, Allow<Disabled>>,
) {
    let slot_of = |bodies: &Bodies, entity: Entity| {
        let handle = handles.get(entity).ok().and_then(|handle| handle.0);
        let body = handle.filter(|&(slot, id)| bodies.is_current(slot, id));
        body.map(|(slot, _)| slot).ok_or(BondError::NoBody)
    };
    for request in requests.0.drain(..) {
        let (entity, outcome) = match request {
            BondRequest::Pair(a, b, bond) => {
                let slots = slot_of(bodies, a).and_then(|i| Ok((i, slot_of(bodies, b)?)));
                (a, slots.and_then(|(i, j)| bonds.bond(bodies, i, j, bond)))
            }
            BondRequest::Release(a, b) => {
                if let (Ok(i), Ok(j)) = (slot_of(bodies, a), slot_of(bodies, b)) {
                    bonds.unbond(bodies, i, j);
                }
                continue;
            }
            BondRequest::ReleaseAll(entity) => {
                if let Ok(slot) = slot_of(bodies, entity) {
                    bonds.unbond_all(bodies, slot);
                }
                continue;
            }
            BondRequest::Neighbors(entities, strength) => {
                let mut slots = Vec::with_capacity(entities.len());
                for &entity in &entities {
                    match slot_of(bodies, entity) {
                        Ok(slot) => slots.push(slot),
                        Err(error) => warn(warnings, entity, error),
                    }
                }
                let Some(&first) = entities.first() else {
                    continue;
                };
                let made = bonds.bond_neighbors(bodies, &slots, strength);
                (first, made.map(|_| ()))
            }
        };
        if let Err(error) = outcome {
            warn(warnings, entity, error);
        }
    }
}

/// Tells which bonds broke. Bonds of bodies without entities break in silence.
pub(crate) fn report_broken(
    bonds: &Bonds,
    entities: &BodyEntities,
    messages: &mut MessageWriter<BondBroken>,
) {
    for broken in &bonds.broken {
        let [i, j] = broken.slots;
        let (a, b): (BodyId, BodyId) = broken.bodies;
        if let (Some(a), Some(b)) = (entities.of(i, a), entities.of(j, b)) {
            messages.write(BondBroken {
                entities: [a, b],
                bond: broken.bond,
            });
        }
    }
}
