//! What a blast gives to what it breaks.

use crate::common::dice::Dice;
use crate::kit::{Verdict, ask, breakable, check_ledgers, convex, in_space};
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
