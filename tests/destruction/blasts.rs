//! What a blast gives to what it breaks.

use crate::common::dice::Dice;
use crate::kit::{
    H, Verdict, ask, awake_on_floor, breakable, check_ledgers, convex, cuboid, in_space,
};
use bevy_cleave::prelude::*;
use glam::Vec3;

/// How fast a piece may be beside the whole body under the same impulse, with what the whole body has of it before it breaks.
const FASTEST: f32 = 5.0;

/// A body in free space breaks beside a blast that reaches all of it, or draws it in: how many pieces fly.
pub(crate) fn judge(seed: u64) -> Verdict {
    let mut dice = Dice::new(0x77_0000 + seed);
    let mut simulation = in_space();
    let size = 10.0_f32.powf(dice.in_range(-1.0, 1.0));
    let shape = convex(&mut dice, size);
    let desc = BodyDesc::dynamic(shape, Vec3::ZERO);
    let slot = simulation.bodies.insert(desc).expect("usable");
    // Its mass is known from then on.
    simulation.step(1e-6);
    let mass = simulation.bodies.mass(slot).mass;
    // Of the speed of the whole body, m/s.
    let speed = 10.0_f32.powf(dice.in_range(-1.0, 1.5));
    let strength = speed * mass * dice.in_range(0.01, 0.5);
    let fracturable = breakable(&mut dice, strength);
    simulation.bodies.set_fracturable(slot, Some(fracturable));
    let sign = if dice.below(3) == 0 { -1.0 } else { 1.0 };
    let blast = Explosion {
        center: size * dice.in_range(0.8, 2.0) * dice.vector(-1.0, 1.0).normalize(),
        radius: 10.0 * size,
        impulse: sign * speed * mass,
    };
    simulation.bodies.explode(blast).expect("usable");
    simulation.step(1e-4);
    check_ledgers(&simulation)?;
    let bodies = &simulation.bodies;
    let (mut outward, mut sum, mut pieces) = (0.0, Vec3::ZERO, 0);
    for piece in bodies.iter() {
        let (velocity, _) = bodies.velocity(piece);
        let momentum = bodies.mass(piece).mass * velocity;
        let fastest = velocity.length();
        ask!(
            fastest <= FASTEST * speed,
            "a piece of {:.1e} of the body flies with {fastest} m/s, all of it would with {speed}",
            bodies.mass(piece).mass / mass
        );
        let away = bodies.center_of_mass(piece) - blast.center;
        outward += momentum.dot(away.normalize());
        sum += momentum;
        pieces += 1;
    }
    let whole = blast.impulse.abs();
    ask!(sum.length() <= 1.001 * whole, "{sum} of {whole}");
    ask!(outward * sign > 0.3 * whole, "{outward} of {whole}");
    Ok(pieces - 1)
}

/// A heap in which light splinters lie: however hard the blast is, none gets faster than what drives it, and nothing overflows.
pub(crate) fn judge_dust(seed: u64) -> Verdict {
    let dice = &mut Dice::new(seed);
    let mut simulation = awake_on_floor();
    let (size, least) = (dice.in_range(0.05, 0.4), dice.in_range(-2.0, -1.0));
    let count = 5 + dice.below(25);
    for _ in 0..count {
        let size = size * 10.0_f32.powf(dice.in_range(least, 0.0)) * dice.vector(0.2, 1.0);
        let at = dice.vector(-0.3, 0.3) + 0.4 * Vec3::Y;
        let mut desc = BodyDesc::dynamic(cuboid(size), at);
        desc.pose.rotation = dice.rotation();
        simulation.bodies.insert(desc).expect("usable");
    }
    (0..10).for_each(|_| simulation.step(H));
    let explosion = Explosion {
        center: dice.vector(-0.3, 0.3) + 0.2 * Vec3::Y,
        radius: 1.5,
        impulse: 10.0_f32.powf(dice.in_range(1.0, 3.5)),
    };
    simulation.bodies.explode(explosion).expect("usable");
    for number in 0..5 {
        simulation.step(H);
        let problems = &simulation.report.problems;
        ask!(problems.is_empty(), "step {number}: {problems:?}");
        let bodies = &simulation.bodies;
        let speeds = bodies.iter().map(|slot| bodies.velocity(slot).0.length());
        // What is struck by it may be faster: a ball that a wall strikes is twice as fast as the wall.
        let fastest = speeds.fold(0.0, f32::max);
        ask!(fastest < 2e4, "step {number}: {fastest} m/s");
    }
    Ok(count)
}
