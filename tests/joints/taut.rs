//! Light links that bear heavy loads swing faster than sub-steps can follow: that neither grows nor takes energy from the load.

use crate::common::scenes::energy;
use crate::scene::{Chain, H, Random, chain};
use glam::Vec3;

/// A chain under a load of 300 to 1500 links that swings from some 30 degrees, its links with random velocities across; and the energy of that, J.
fn shaken_chain(seed: u64) -> (Chain, f64) {
    let mut random = Random::new(seed);
    let links = 6 + (seed % 25) as usize;
    let ratio = random.range(300.0, 1500.0);
    let aside = Vec3::new(random.range(-0.5, 0.5), -1.0, random.range(-0.5, 0.5));
    let along = aside.normalize();
    let mut chain = chain(links, ratio, along, Vec3::ZERO);
    let bodies = &mut chain.simulation.bodies;
    let slots: Vec<u32> = bodies.iter().take(links).collect();
    for slot in slots {
        let kick = random.vector(-1.0, 1.0);
        let spin = kick - kick.dot(along) * along;
        let set = bodies.set_velocity(slot, Vec3::ZERO, spin);
        set.expect("usable");
    }
    let swing = f64::from(ratio * 9.81) * links as f64 * f64::from(1.0 + along.y);
    (chain, swing)
}

#[test]
fn loads_on_light_links_keep_their_energy() {
    let (mut loss, mut gain, mut gap) = (0.0_f64, 0.0_f64, 0.0_f64);
    for seed in 0..24 {
        let (mut chain, swing) = shaken_chain(seed);
        chain.simulation.step(1e-4);
        let start = energy(&chain.simulation);
        gap = gap.max(chain.largest_gap(240, H));
        let change = (energy(&chain.simulation) - start) / swing;
        (gain, loss) = (gain.max(change), loss.max(-change));
    }
    println!(
        "light links: energy of the swing {gain:+.1e} and {:+.1e}, gaps {gap:.1e} m",
        -loss
    );
    assert!(gain < 0.01 && loss < 0.02, "{gain}, {loss}");
    assert!(gap < 1e-4, "{gap}");
}
