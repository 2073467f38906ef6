//! What sleeps does not hang in the air, whatever has become of what it rested on: made afresh and awake it stays where it is.

use crate::random_world::{Deed, RandomWorld, story};
use crate::twins::{body_of, place_of, twin};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;

/// How far a body that slept may settle in a quarter of a second without what is known of its contacts, m; in free fall it is 0.3 m.
const SETTLING: f32 = 0.1;

/// How many sleepers stay where they are.
fn sleepers(deeds: &[Deed]) -> Result<usize, String> {
    let mut scene = RandomWorld::new(false);
    scene.lay_floor();
    let mut config = scene.app.world_mut().resource_mut::<SolverConfig>();
    config.sleep.time = 0.1;
    for &deed in deeds {
        scene.run(deed);
        if matches!(deed, Deed::Frame(2..)) {
            (0..40).for_each(|_| scene.run(Deed::Frame(1)));
        }
    }
    // Who is to wake does so with the step after the one that sees why.
    (0..3).for_each(|_| scene.run(Deed::Frame(1)));
    let world = scene.app.world();
    // Bonds have no entities that could be copied.
    if !world.resource::<Bonds>().is_empty() {
        return Ok(0);
    }
    let (mut other, twins) = twin(&scene);
    other.world_mut().resource_mut::<SolverConfig>().sleep = SleepConfig::off();
    (0..15).for_each(|_| other.update());
    // What was refused is not there afresh, or is something else.
    let body = |world: &World, entity| {
        let bodies = world.resource::<Bodies>();
        body_of(world, entity).map(|slot| (bodies.kind(slot), bodies.is_active(slot)))
    };
    let is_alike =
        |(&entity, &copy): (&Entity, &Entity)| body(world, entity) == body(other.world(), copy);
    if !twins.iter().all(is_alike) {
        return Ok(0);
    }
    let mut count = 0;
    for (&entity, &copy) in &twins {
        let is_asleep = world.entity(entity).contains::<Sleeping>();
        let places = [place_of(world, entity), place_of(other.world(), copy)];
        if let (true, [Some(before), Some(after)]) = (is_asleep, places) {
            count += 1;
            if before.distance(after) > SETTLING {
                return Err(format!(
                    "{entity} slept at {before}, and moves to {after}: {:#?}",
                    scene.said
                ));
            }
        }
    }
    Ok(count)
}

#[test]
fn what_sleeps_stays_where_it_is_when_it_is_made_afresh() {
    let mut count = 0;
    for seed in 0..60 {
        let stay = sleepers(&story(seed, 40));
        count += stay.unwrap_or_else(|error| panic!("seed {seed}: {error}"));
    }
    assert!(count > 15, "{count} sleepers are too few to tell");
}
