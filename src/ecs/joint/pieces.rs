//! Joints of what broke.

use crate::contact::body_id::BodyId;
use crate::ecs::joint::{JointA, JointB};
use crate::ecs::state::PluginState;
use crate::joints::Joints;
use bevy_ecs::prelude::*;

/// Command: relates the joints that pieces have inherited to the entities of these, before the parents' go.
pub(crate) fn follow_pieces(world: &mut World) {
    let mut inherited = Vec::new();
    world.resource_scope(|world, mut joints: Mut<Joints>| {
        let state = world.resource::<PluginState>();
        // What broke after its body did is told of with the piece that had it.
        let broken = joints.broken.iter();
        let broken: Vec<_> = broken.map(|it| (it.id, it.bodies, it.joint)).collect();
        let records = joints.take_inherited();
        let records = records.map(|record| (record.id, record.ends, record.joint));
        for (id, ends, joint) in records.chain(broken) {
            let known = &state.joints.entities;
            let Ok(at) = known.binary_search_by_key(&id, |(id, _)| *id) else {
                continue;
            };
            let entity_of =
                |end: Option<(u32, BodyId)>| end.and_then(|(slot, id)| state.entities.of(slot, id));
            inherited.push((known[at].1, ends.map(entity_of), joint));
        }
    });
    for (entity, [a, b], joint) in inherited {
        let Ok(mut entity) = world.get_entity_mut(entity) else {
            continue;
        };
        entity.insert(joint);
        if let Some(a) = a {
            entity.insert(JointA(a));
        }
        if let Some(b) = b {
            entity.insert(JointB(b));
        }
    }
}
