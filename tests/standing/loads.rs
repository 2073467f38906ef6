//! Strength is judged by what comes above the load that is borne.

use crate::scenes::*;
use bevy_cleave::prelude::*;
use glam::Vec3;

/// A crate of 125 kg on a floor, under a load of `load` kg that rests on it; after a second at rest it is struck from the side by
/// `blow` N s. Step of the first fracture after the blow, if any.
struct Struck {
    rate: f32,
    load: f32,
    strength: f32,
    blow: f32,
}

impl Struck {
    fn breaks_at(&self) -> Option<usize> {
        let mut crate_body = BodyDesc::dynamic(cuboid(Vec3::splat(0.5)), 0.25 * Vec3::Y);
        crate_body.fracturable = Some(Fracturable::with_strength(self.strength));
        let mut load = BodyDesc::dynamic(cuboid(Vec3::splat(0.4)), 0.7 * Vec3::Y);
        load.density = self.load / 0.064;
        let mut simulation = scene([floor(), crate_body, load]);
        let step_dt = 1.0 / self.rate;
        for step in 0..self.rate as usize {
            simulation.step(step_dt);
            assert!(
                simulation.fractures.done.is_empty(),
                "{} kg at {} Hz broke {} N s at rest, step {step}",
                self.load,
                self.rate,
                self.strength
            );
        }
        // So light against the crate that what it gives is its momentum.
        let speed = 40.0;
        let mut hammer = BodyDesc::dynamic(cuboid(Vec3::splat(0.2)), Vec3::new(-1.0, 0.25, 0.0));
        hammer.density = self.blow / speed / 0.008;
        hammer.linear_velocity = speed * Vec3::X;
        simulation.bodies.insert(hammer).expect("usable");
        (0..(0.2 * self.rate) as usize).find(|_| {
            simulation.step(step_dt);
            !simulation.fractures.done.is_empty()
        })
    }
}

/// A crate at rest under any load, struck by twice what it bears at any step rate, breaks; by a half, it does not; and weaker ones
/// break no later than stronger ones.
#[test]
fn a_blow_breaks_by_what_comes_above_the_load() {
    for rate in [30.0, 45.0, 60.0, 90.0, 120.0, 240.0] {
        for load in [1.0, 100.0, 3000.0, 50_000.0] {
            let mut last = Some(0);
            for strength in [0.5, 5.0, 19.0, 60.0, 150.0, 600.0, 5000.0] {
                let blow = 415.0;
                let at = Struck {
                    rate,
                    load,
                    strength,
                    blow,
                }
                .breaks_at();
                let name = format!("{load} kg, {rate} Hz, {strength} N s");
                if 2.0 * strength <= blow {
                    assert!(at.is_some(), "{name} does not break");
                }
                if strength > 4.0 * blow {
                    assert!(at.is_none(), "{name} breaks");
                }
                let rank = |at: Option<usize>| at.unwrap_or(usize::MAX);
                assert!(
                    rank(at) >= rank(last),
                    "{name} breaks sooner than a weaker one"
                );
                last = at;
            }
        }
    }
}

/// A load that rests on what stands is no part of a blow far from it.
#[test]
fn a_loaded_slab_bears_small_blows_and_breaks_by_large_ones() {
    for rate in [30.0, 60.0, 240.0] {
        for (blow, breaks) in [(30.0, false), (300.0, true)] {
            let mut slab = standing(Vec3::new(10.0, 0.2, 2.0), 2.0 * Vec3::Y);
            slab.fracturable = Some(Fracturable::with_strength(100.0));
            let mut load = BodyDesc::dynamic(cuboid(Vec3::splat(1.0)), Vec3::new(-4.0, 2.6, 0.0));
            load.density = 20_000.0;
            let mut simulation = scene([floor(), slab, load]);
            let anchors =
                Anchors::none().and_within(Vec3::new(-5.0, -1.0, -1.0), Vec3::new(-3.0, 1.0, 1.0));
            simulation
                .bodies
                .set_anchors(1, Some(anchors))
                .expect("usable");
            for _ in 0..rate as usize {
                simulation.step(1.0 / rate);
                assert!(
                    simulation.fractures.done.is_empty(),
                    "the load broke it at {rate} Hz"
                );
            }
            let mut hammer = BodyDesc::dynamic(cuboid(Vec3::splat(0.2)), Vec3::new(4.0, 3.0, 0.0));
            hammer.density = blow / 10.0 / 0.008;
            hammer.linear_velocity = -10.0 * Vec3::Y;
            simulation.bodies.insert(hammer).expect("usable");
            let broke = (0..(0.5 * rate) as usize).any(|_| {
                simulation.step(1.0 / rate);
                !simulation.fractures.done.is_empty()
            });
            assert_eq!(broke, breaks, "{blow} N s at {rate} Hz");
        }
    }
}

/// A press that moves on breaks what it is driven into, at any strength.
#[test]
fn a_press_breaks_what_it_is_driven_into() {
    for (speed, strength) in [(0.05, 1000.0), (0.5, 1000.0), (0.2, 20_000.0)] {
        let mut block = BodyDesc::dynamic(cuboid(Vec3::splat(1.0)), 0.5 * Vec3::Y);
        block.fracturable = Some(Fracturable::with_strength(strength));
        let mut press = standing(Vec3::new(2.0, 0.5, 2.0), 1.3 * Vec3::Y);
        press.kind = RigidBody::Kinematic;
        press.linear_velocity = -speed * Vec3::Y;
        let mut simulation = scene([floor(), block, press]);
        let done = run(&mut simulation, 0.2 / speed);
        assert!(!done.is_empty(), "{speed} m/s, {strength} N s");
    }
}

/// Blows of the same energy, each a third of the strength; how many a crate bears. `step_dt` in s.
fn blows_borne(fatigue: Option<Fatigue>, step_dt: f32) -> usize {
    let mut block = BodyDesc::dynamic(cuboid(Vec3::splat(0.5)), 0.25 * Vec3::Y);
    block.fracturable = Some(Fracturable::with_strength(600.0));
    let mut simulation = scene([floor(), block]);
    simulation.bodies.set_fatigue(1, fatigue).expect("usable");
    for blow in 0..40 {
        let mut hammer = BodyDesc::dynamic(cuboid(Vec3::splat(0.1)), Vec3::new(0.0, 0.6, 0.0));
        hammer.density = 5000.0;
        hammer.linear_velocity = -20.0 * Vec3::Y;
        let slot = simulation.bodies.insert(hammer).expect("usable");
        for _ in 0..(0.3 / step_dt) as usize {
            simulation.step(step_dt);
            if !simulation.fractures.done.is_empty() {
                return blow;
            }
        }
        simulation.bodies.remove(slot);
    }
    40
}

/// 5 kg at 20 m/s bring some 1000 J.
#[test]
fn blows_wear_out_what_they_do_not_break() {
    for rate in [60.0, 240.0] {
        let borne = |fatigue| blows_borne(fatigue, 1.0 / rate);
        assert_eq!(borne(None), 40, "{rate} Hz");
        let counts = [20_000.0, 10_000.0, 5000.0].map(|energy| borne(Some(Fatigue::new(energy))));
        assert!(
            counts[0] > counts[1] && counts[1] > counts[2] && counts[2] >= 1,
            "{counts:?} at {rate} Hz"
        );
        assert!(counts[0] < 30, "{counts:?}");
        let tough = Fatigue {
            endurance: 1.0,
            ..Fatigue::new(5000.0)
        };
        assert_eq!(borne(Some(tough)), 40, "below the endurance limit");
    }
    let worn = Fatigue {
        damage: 0.9,
        ..Fatigue::new(1e9)
    };
    assert_eq!(blows_borne(Some(worn), H), 0, "what was saved counts");
}

#[test]
fn a_load_at_rest_wears_nothing_out() {
    let mut slab = BodyDesc::dynamic(cuboid(Vec3::new(2.0, 0.2, 2.0)), 0.1 * Vec3::Y);
    slab.fracturable = Some(Fracturable::with_strength(100.0));
    let mut load = BodyDesc::dynamic(cuboid(Vec3::splat(1.0)), 0.7 * Vec3::Y);
    load.density = 4000.0;
    let mut simulation = scene([floor(), slab, load]);
    simulation
        .bodies
        .set_fatigue(1, Some(Fatigue::new(1.0)))
        .expect("usable");
    let done = run(&mut simulation, 20.0);
    assert!(done.is_empty());
    let damage = simulation.bodies.fatigue(1).expect("it has some").damage;
    assert_eq!(damage, 0.0);
}
