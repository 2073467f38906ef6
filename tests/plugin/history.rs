//! What an entity is and says follows from its components, whatever was done to it before.

use crate::random_world::{Deed, RandomWorld};
use crate::twins::{body_of, check, texts, twin};
use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;

/// What a body is, as text.
fn state(world: &World, entity: Entity) -> Option<String> {
    let slot = body_of(world, entity)?;
    let bodies = world.resource::<Bodies>();
    Some(format!(
        "{:?} active {} sensor {} mass {:.2e} drive {:?} fracturable {:?} anchors {:?} fatigue {:?}",
        bodies.kind(slot),
        bodies.is_active(slot),
        bodies.is_sensor(slot),
        bodies.mass(slot).mass,
        bodies.drive(slot),
        bodies.fracturable(slot),
        bodies.anchors(slot),
        bodies.fatigue(slot).map(|it| it.energy),
    ))
}

/// What is wrong with a joint, and whether it holds.
fn joint(world: &World, entity: Entity) -> (Option<String>, bool) {
    let problem = world.get::<JointProblem>(entity);
    let handle = world.get::<JointHandle>(entity);
    (
        problem.map(|problem| problem.0.to_string()),
        handle.is_some_and(|handle| handle.get().is_some()),
    )
}

/// One step; whether nothing broke.
fn is_quiet(scene: &mut RandomWorld) -> bool {
    scene.run(Deed::Frame(1));
    let broken = scene.app.world().resource::<Messages<Fractured>>();
    broken.iter_current_update_messages().next().is_none()
}

fn no_history(deeds: &[Deed]) -> Result<(), String> {
    let mut scene = RandomWorld::new(true);
    deeds.iter().for_each(|&deed| scene.run(deed));
    // What breaks in the last step is read in the next.
    scene.run(Deed::Frame(1));
    if !(0..20).any(|_| is_quiet(&mut scene)) {
        return Ok(());
    }
    let (mut other, twins) = twin(&scene);
    other.update();
    compare(scene.app.world(), &other, &twins)
        .map_err(|error| format!("{error}\n{:#?}", scene.said))
}

fn compare(world: &World, other: &App, twins: &EntityHashMap<Entity>) -> Result<(), String> {
    let fresh_world = other.world();
    for (&entity, &copy) in twins {
        // What is disabled is not looked at.
        if fresh_world.get_entity(copy).is_err() || world.entity(entity).contains::<Disabled>() {
            continue;
        }
        let (own, fresh) = (texts(world, entity), texts(fresh_world, copy));
        let (a, b) = (state(world, entity), state(fresh_world, copy));
        // A body is what it was while its next shape is still to come.
        if b.is_none() && fresh_world.entity(copy).contains::<ShapeAwaited>() {
            continue;
        }
        // Who is refused says what was found first. A body that was there before says all.
        let is_refused = b.is_none() && !fresh.is_empty();
        let said_alike = if is_refused {
            !own.is_empty()
        } else {
            own == fresh
        };
        if !said_alike {
            return Err(format!("{entity} says {own:?}, afresh {fresh:?}"));
        }
        if !is_refused && own.is_empty() && a != b {
            return Err(format!("{entity} is {a:?}, afresh {b:?}"));
        }
        let ends = [
            world.get::<JointA>(entity).map(|a| a.0),
            world.get::<JointB>(entity).map(|b| b.0),
        ];
        // A body that got unusable later, or is disabled, is still held; afresh there is none.
        let is_sound = |end: Entity| {
            let is_there = fresh_world.get_entity(twins[&end]).is_ok();
            is_there && texts(world, end).is_empty() && !world.entity(end).contains::<Disabled>()
        };
        let broke = world.entity(entity).contains::<Joint>()
            != fresh_world.entity(copy).contains::<Joint>();
        let (a, b) = (joint(world, entity), joint(fresh_world, copy));
        if ends.into_iter().flatten().all(is_sound) && !broke && a != b {
            return Err(format!("joint {entity} is {a:?}, afresh {b:?}"));
        }
    }
    Ok(())
}

#[test]
fn entities_are_what_their_components_say_whatever_was_done_before() {
    check(no_history, 40, 0..300);
    check(no_history, 120, 3100..3180);
}
