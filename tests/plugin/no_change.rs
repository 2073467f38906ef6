//! What changes nothing changes no bit: components that are set anew as they are, what is disabled and enabled within a frame,
//! bodies that are drawn between steps, and those that are described to be saved.

use crate::common::dice::Dice;
use crate::random_world::{Deed, NAMES, RandomWorld};
use crate::twins::{body_of, check, texts};
use bevy_app::Plugin;
use bevy_cleave::prelude::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::Vec3;

/// What a name stands for, as text.
fn seen(scene: &RandomWorld, name: usize) -> Option<String> {
    let entity = scene.entity(name)?;
    let world = scene.app.world();
    let bodies = world.resource::<Bodies>();
    let slot = body_of(world, entity);
    let motion = slot.map(|slot| {
        let (v, omega) = bodies.velocity(slot);
        // A zero's sign is no motion.
        let velocity = (v + Vec3::ZERO, omega + Vec3::ZERO);
        (bodies.pose(slot), velocity, bodies.is_asleep(slot))
    });
    Some(format!("{entity} {motion:?} {:?}", texts(world, entity)))
}

/// Sets a component anew as it is, if the entity has it.
fn again<C: Component + Clone>(entity: &mut EntityWorldMut) {
    if let Some(value) = entity.get::<C>().cloned() {
        entity.insert(value);
    }
}

/// Does something to everybody that changes nothing.
fn do_nothing(scene: &mut RandomWorld, dice: &mut Dice) {
    for name in 0..NAMES {
        let Some(entity) = scene.entity(name) else {
            continue;
        };
        let mut it = scene.app.world_mut().entity_mut(entity);
        let is_on = !it.contains::<Disabled>();
        match dice.below(24) {
            0 => again::<RigidBody>(&mut it),
            1 => again::<ConvexMesh>(&mut it),
            2 => again::<Transform>(&mut it),
            3 => again::<LinearVelocity>(&mut it),
            4 => again::<AngularVelocity>(&mut it),
            5 => again::<Fracturable>(&mut it),
            6 => again::<CollisionLayers>(&mut it),
            7 => again::<Density>(&mut it),
            8 => again::<GravityScale>(&mut it),
            9 => again::<LockedAxes>(&mut it),
            10 => again::<Anchors>(&mut it),
            11 => again::<Compound>(&mut it),
            12 => again::<StaticMesh>(&mut it),
            13 => again::<HalfSpaceShape>(&mut it),
            14 => again::<Mass>(&mut it),
            15 => again::<Friction>(&mut it),
            16 => again::<Sensor>(&mut it),
            17 => again::<CollisionEvents>(&mut it),
            18 => again::<ConstantForce>(&mut it),
            19 if is_on => drop(it.insert(Disabled).remove::<Disabled>()),
            20 if !is_on => drop(it.remove::<Disabled>().insert(Disabled)),
            21 => {
                if let Some(kind) = it.get::<RigidBody>().copied() {
                    let others = [RigidBody::Kinematic, RigidBody::Dynamic, RigidBody::Static];
                    it.insert(others[dice.below(3)]).insert(kind);
                }
            }
            _ => {}
        }
    }
}

/// Lets two worlds go the same way and looks where they differ.
fn compare(
    [mut plain, mut other]: [RandomWorld; 2],
    deeds: &[Deed],
    mut before_frame: impl FnMut(&mut RandomWorld),
) -> Result<(), String> {
    for (at, &deed) in deeds.iter().enumerate() {
        if matches!(deed, Deed::Frame(_)) {
            before_frame(&mut other);
        }
        plain.run(deed);
        other.run(deed);
        for name in 0..NAMES {
            let [a, b] = [&plain, &other].map(|scene| seen(scene, name));
            if a != b {
                return Err(format!(
                    "deed {at}, name {name}:\n{a:?}\n{b:?}\n{:#?}",
                    plain.said
                ));
            }
        }
    }
    Ok(())
}

fn nothing_is_nothing(deeds: &[Deed]) -> Result<(), String> {
    let mut dice = Dice::new(deeds.len() as u64);
    let scenes = [(); 2].map(|()| RandomWorld::new(false));
    compare(scenes, deeds, |scene| do_nothing(scene, &mut dice))
}

fn drawing_moves_nothing(deeds: &[Deed]) -> Result<(), String> {
    let mut scenes = [(); 2].map(|()| RandomWorld::new(false));
    // A clone is where its original is drawn.
    scenes.iter_mut().for_each(|scene| scene.clones = false);
    // The app is finished already.
    InterpolationPlugin.build(&mut scenes[1].app);
    compare(scenes, deeds, |_| {})
}

fn saving_moves_nothing(deeds: &[Deed]) -> Result<(), String> {
    let scenes = [(); 2].map(|()| RandomWorld::new(false));
    compare(scenes, deeds, |scene| {
        describe_bodies(scene.app.world_mut())
    })
}

#[test]
fn what_is_set_anew_as_it_is_changes_no_bit() {
    check(nothing_is_nothing, 40, 200..400);
}

#[test]
fn to_draw_bodies_between_steps_changes_no_bit() {
    check(drawing_moves_nothing, 40, 200..320);
}

#[test]
fn to_describe_bodies_changes_no_bit() {
    check(saving_moves_nothing, 40, 200..260);
}
