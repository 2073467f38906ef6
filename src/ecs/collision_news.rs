//! News of contacts, sent at the end of a step as messages and as events of entities.

use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::ecs::collisions::{CollisionEnd, CollisionStart, ContactForce};
use crate::ecs::components::BodyEntities;
use crate::ecs::options::settle_options;
use crate::ecs::state::PluginState;
use crate::step::{ContactChange, ContactEvent, Contacts, find_contact_events};
use bevy_ecs::prelude::*;

/// News of a step, by entity.
#[derive(Debug, Default)]
struct News {
    starts: Vec<CollisionStart>,
    ends: Vec<CollisionEnd>,
    forces: Vec<ContactForce>,
    /// How many of each come as messages: the first one of every pair.
    is_message: [Vec<bool>; 3],
}

impl News {
    /// `asks`: who of the two asks for news of that.
    fn add(&mut self, event: &ContactEvent, entities: [Entity; 2], asks: [bool; 2], step_dt: f32) {
        // Who asks and is not told was told before, and the message was sent then.
        let was_told = (0..2).any(|side| asks[side] && !event.of[side]);
        let mut is_first = event.change != ContactChange::Start || !was_told;
        for side in (0..2).filter(|&side| event.of[side]) {
            let (entity, other) = (entities[side], entities[1 - side]);
            let normal = [event.normal, -event.normal][side];
            let kind = match event.change {
                ContactChange::Start => {
                    self.starts.push(CollisionStart {
                        entity,
                        other,
                        point: event.point,
                        normal,
                        impulse: event.impulse,
                        approach_speed: event.approach_speed,
                    });
                    0
                }
                ContactChange::End => {
                    self.ends.push(CollisionEnd { entity, other });
                    1
                }
                ContactChange::Force { is_crossing } => {
                    self.forces.push(ContactForce {
                        entity,
                        other,
                        is_crossing: is_crossing[side],
                        force: event.impulse / step_dt,
                        impulse: event.impulse,
                        approach_speed: event.approach_speed,
                        point: event.point,
                        normal,
                    });
                    2
                }
            };
            self.is_message[kind].push(is_first);
            // Thresholds differ, so each who asked gets the message of a force.
            is_first = matches!(event.change, ContactChange::Force { .. });
        }
    }

    /// Takes out what ends and begins in one step: another body of the same entity is no news of who touches whom.
    fn settle(&mut self) {
        if self.starts.is_empty() || self.ends.is_empty() {
            return;
        }
        let starts = self.starts.iter().map(|start| (start.entity, start.other));
        let ends = self.ends.iter().map(|end| (end.entity, end.other));
        let [begun, ended] = [starts.collect::<Vec<_>>(), ends.collect()].map(|mut pairs| {
            pairs.sort_unstable();
            pairs
        });
        let [start_messages, end_messages, _] = &mut self.is_message;
        let goes_on = |pairs: &[(Entity, Entity)], pair| pairs.binary_search(&pair).is_ok();
        retain(&mut self.starts, start_messages, |start| {
            !goes_on(&ended, (start.entity, start.other))
        });
        retain(&mut self.ends, end_messages, |end| {
            !goes_on(&begun, (end.entity, end.other))
        });
        // Of a pair that goes on while one of the two began or ceased to ask there is no message either.
        let of_either =
            |pairs: &[(Entity, Entity)], (a, b)| goes_on(pairs, (a, b)) || goes_on(pairs, (b, a));
        for (start, is_message) in self.starts.iter().zip(start_messages) {
            *is_message &= !of_either(&ended, (start.entity, start.other));
        }
        for (end, is_message) in self.ends.iter().zip(end_messages) {
            *is_message &= !of_either(&begun, (end.entity, end.other));
        }
    }
}

/// Keeps those events that pass, and what is noted of them.
fn retain<E: Copy>(events: &mut Vec<E>, noted: &mut Vec<bool>, passes: impl Fn(&E) -> bool) {
    let mut kept = events.iter().map(&passes).collect::<Vec<_>>().into_iter();
    noted.retain(|_| kept.next().unwrap_or(true));
    events.retain(passes);
}

/// Command, at the end of a step with bodies that are watched: finds the news and sends them.
pub(crate) fn send_collisions(world: &mut World) {
    settle_options(world);
    let (settings, departed) = {
        let state = &mut *world.resource_mut::<PluginState>();
        (state.settings, std::mem::take(&mut state.departed))
    };
    let news = world.resource_scope(|world, mut contacts: Mut<Contacts>| {
        find_contact_events(world.resource::<Bodies>(), &mut contacts, &settings);
        let bodies = world.resource::<Bodies>();
        let entities = &world.resource::<PluginState>().entities;
        let mut news = News::default();
        for event in contacts.events().news() {
            let of = |(slot, id)| entity_of(entities, &departed, slot, id);
            if let [Some(a), Some(b)] = event.bodies.map(of) {
                let asks = event.bodies.map(|body| contacts.events.asks(bodies, body));
                news.add(event, [a, b], asks, settings.step_dt);
            }
        }
        world.resource_mut::<PluginState>().is_watching = contacts.events().is_on();
        news.settle();
        news
    });
    let [starts, ends, forces] = &news.is_message;
    send(world, &news.starts, starts);
    send(world, &news.forces, forces);
    send(world, &news.ends, ends);
}

/// The entity of a body, or the one that it had until this step.
fn entity_of(
    entities: &BodyEntities,
    departed: &[(BodyId, Entity)],
    slot: u32,
    id: BodyId,
) -> Option<Entity> {
    let former = || departed.iter().find(|(known, _)| *known == id);
    let now = entities.of(slot, id);
    now.or_else(|| former().map(|&(_, entity)| entity))
}

/// Sends events as messages, those that are to be, and to each entity that is still there.
fn send<E>(world: &mut World, events: &[E], is_message: &[bool])
where
    E: Message + Copy + EntityEvent + for<'t> Event<Trigger<'t>: Default>,
{
    if events.is_empty() {
        return;
    }
    if let Some(mut messages) = world.get_resource_mut::<Messages<E>>() {
        let chosen = events.iter().zip(is_message).filter(|(_, is)| **is);
        messages.write_batch(chosen.map(|(event, _)| *event));
    }
    let key = world.event_key::<E>();
    let is_observed = key.is_some_and(|key| world.observers().try_get_observers(key).is_some());
    for &event in events.iter().filter(|_| is_observed) {
        if world.get_entity(event.event_target()).is_ok() {
            world.trigger(event);
        }
    }
}
