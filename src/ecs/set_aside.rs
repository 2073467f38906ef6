//! Entities whose bodies are no more, kept for the case that [time goes back](crate::ecs::rewind).

use crate::ecs::components::BodyHandle;
use crate::ecs::joint::{JointsOfA, JointsOfB};
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;

/// Who is kept; there is one only in apps in which time goes back.
#[derive(Debug, Default, Resource)]
pub(crate) struct Aside {
    /// Steps made, without those that were taken back.
    pub(crate) steps: u64,
    /// Entities, and the step in which the body of each went, ascending.
    entities: Vec<(u64, Entity)>,
}

/// It stands for nothing at present: neither it nor what would have been despawned with it.
#[derive(Clone, Copy, Debug, Component)]
#[component(clone_behavior = Ignore)]
pub(crate) struct SetAside {
    /// Whether the app had disabled it before.
    was_disabled: bool,
}

/// The entity, and what would be despawned with it.
fn family(world: &World, entity: Entity) -> Vec<Entity> {
    let mut family = vec![entity];
    let mut next = 0;
    while let Some(&member) = family.get(next) {
        next += 1;
        let Ok(member) = world.get_entity(member) else {
            continue;
        };
        let children = member
            .get::<Children>()
            .into_iter()
            .flat_map(|it| it.iter());
        let of_a = member
            .get::<JointsOfA>()
            .into_iter()
            .flat_map(|it| it.iter());
        let of_b = member
            .get::<JointsOfB>()
            .into_iter()
            .flat_map(|it| it.iter());
        let new: Vec<Entity> = children.chain(of_a).chain(of_b).collect();
        family.extend(new.into_iter().filter(|&it| world.get_entity(it).is_ok()));
    }
    family.sort_unstable();
    family.dedup();
    family
}

/// The body of an entity is no more: the entity goes, or is taken out of everything, as if it were despawned, as long as it may come
/// back.
pub(crate) fn leave(world: &mut World, entity: Entity) {
    if world.get_entity(entity).is_err() {
        return;
    }
    let Some(mut aside) = world.get_resource_mut::<Aside>() else {
        world.despawn(entity);
        return;
    };
    let step = aside.steps + 1;
    aside.entities.push((step, entity));
    for member in family(world, entity) {
        let Ok(mut member) = world.get_entity_mut(member) else {
            continue;
        };
        if member.contains::<SetAside>() {
            continue;
        }
        // Its body goes, if it still has one.
        member.remove::<BodyHandle>();
        let was_disabled = member.contains::<Disabled>();
        member.insert((SetAside { was_disabled }, Disabled));
    }
}

/// Brings an entity and what belongs to it back; whether it still exists.
pub(crate) fn bring_back(world: &mut World, entity: Entity) -> bool {
    let is_there = world.get_entity(entity).is_ok();
    for member in family(world, entity) {
        let Ok(mut member) = world.get_entity_mut(member) else {
            continue;
        };
        let Some(aside) = member.take::<SetAside>() else {
            continue;
        };
        if !aside.was_disabled {
            member.remove::<Disabled>();
        }
    }
    is_there
}

impl Aside {
    /// Those whose bodies went after a step; they are forgotten here.
    pub(crate) fn take_after(&mut self, step: u64) -> Vec<Entity> {
        let at = self.entities.partition_point(|&(went, _)| went <= step);
        let taken = self.entities.drain(at..);
        taken.map(|(_, entity)| entity).collect()
    }

    /// The same of those whose bodies went before its end.
    pub(crate) fn take_until(&mut self, step: u64) -> Vec<Entity> {
        let end = self.entities.partition_point(|&(went, _)| went <= step);
        let taken = self.entities.drain(..end);
        taken.map(|(_, entity)| entity).collect()
    }
}
