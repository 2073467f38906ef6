//! What a blow breaks: the parts around it as free bodies for the instant of the blow, held by bonds that yield.
//!
//! A blow of rigid bodies has no duration, and the inside of a body that it breaks is not rigid. So what hits the cluster
//! meets the struck part alone, and the part its neighbors through their bonds. A corner of a bonded face pulls back in proportion to how
//! far it has opened, up to its share of strength times area; from there on it yields, until the work is strength times area
//! times the [way](crate::cluster::network::BREAKING_SHARE) that breaking takes. Pressed together, faces give no way, bonded or not. The motion is
//! followed in time steps of the fastest vibration until what is left of the energy cannot break a bond any more. So it is
//! inertia, and not the length of the simulation's step, that says how much of the blow each bond gets.
//!
//! Only parts near the blow take part, as long as those behind them have not heard of it; else more of them, as many as what a step may follow is
//! enough for ([`FOLLOWED_PER_STEP`]): beyond that, blows break only what is near them.

use crate::cluster::hit::Hit;
use crate::cluster::instant::{Instant, MOST_STEPS};
use crate::cluster::link::strain_energy;
use crate::cluster::network::Network;

/// Parts that take part at first; those around them stay where they are. If those are pulled at, four times as many do.
const FIRST_PARTS: usize = 64;

/// Parts that take part in a blow even if no more bonds may be followed in the step.
const FEWEST_PARTS: usize = 16;

/// Bonds times time steps that a step may follow, 15 to 25 ns each: as much as one hard blow to 400 bricks, or to 200 cells. As many parts as can be
/// afforded take part, nearest first; the others stay where they are. Where hundreds of large pieces hit each other, a step would take seconds.
pub(crate) const FOLLOWED_PER_STEP: usize = 1_000_000;

/// What became of the bonds.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct BlowOutcome {
    /// Bonds that broke, ascending.
    pub(crate) broken: Vec<u32>,
    /// Work that all bonds took, J.
    pub(crate) work: f32,
}

impl Network {
    /// What a blow makes of the bonds. `is_held`: parts that hold on to the world; `left`: of [`FOLLOWED_PER_STEP`].
    pub(crate) fn blow(
        &self,
        hit: Hit,
        is_held: impl Fn(u32) -> bool,
        left: &mut usize,
    ) -> BlowOutcome {
        let instant = self.follow((hit, f32::INFINITY), is_held, left);
        let links = instant.links.iter().filter(|link| link.is_broken);
        let mut broken: Vec<u32> = links.map(|link| link.bond).collect();
        broken.sort_unstable();
        BlowOutcome {
            broken,
            work: instant.work,
        }
    }

    /// Bonds that a blow loads with at least a share of their strengths, as long as it leaves them whole, but for those that are known to be `broken`
    /// (ascending); the most that each bore, as a share of what it can. Ascending.
    pub(crate) fn strained(
        &self,
        hit: Hit,
        endurance: f32,
        is_held: impl Fn(u32) -> bool,
        broken: &[u32],
        left: &mut usize,
    ) -> Vec<(u32, f32)> {
        let instant = self.follow((hit, endurance), is_held, left);
        let links = instant.links.iter();
        let strained = links.filter(|link| {
            link.is_strained() && !link.is_broken && broken.binary_search(&link.bond).is_err()
        });
        let mut bonds: Vec<(u32, f32)> = strained.map(|link| (link.bond, link.peak)).collect();
        bonds.sort_unstable_by_key(|&(bond, _)| bond);
        bonds
    }

    /// Energy that a blow must have to load a bond with this share of its strength, J.
    pub(crate) fn least_strain(&self, endurance: f32) -> f32 {
        let bonds = self.bonds.iter().zip(&self.openings);
        let energies = bonds.map(|(bond, &opening)| strain_energy(bond, opening, endurance));
        energies.fold(f32::INFINITY, f32::min)
    }

    /// The instant of a blow, with as many parts as hear of it, as far as they may be followed.
    fn follow(&self, blow: (Hit, f32), is_held: impl Fn(u32) -> bool, left: &mut usize) -> Instant {
        let mut most = FIRST_PARTS.min(self.affordable(*left));
        loop {
            let near = neighborhood(self, blow.0, &is_held, most);
            let mut instant = Instant::new(self, blow, &is_held, &near);
            let more = (4 * most).min(self.affordable(*left));
            let is_whole = instant.run(more > near.len());
            *left = left.saturating_sub(instant.followed);
            if is_whole {
                return instant;
            }
            most = more;
        }
    }

    /// How many parts may take part in a blow if so many bonds times time steps may be followed.
    fn affordable(&self, left: usize) -> usize {
        let links = left / MOST_STEPS;
        (links * self.nodes.len() / self.bonds.len().max(1)).max(FEWEST_PARTS)
    }
}

/// The parts around a blow, nearest first: by the number of bonds between, then by index.
fn neighborhood(
    network: &Network,
    hit: Hit,
    is_held: &impl Fn(u32) -> bool,
    most: usize,
) -> Vec<u32> {
    let struck = hit.strikers.iter().map(|striker| striker.part);
    let mut members: Vec<u32> = struck.chain(hit.pushes.iter().map(|it| it.part)).collect();
    members.sort_unstable();
    members.dedup();
    let mut is_member = vec![false; network.nodes.len()];
    members
        .iter()
        .for_each(|&part| is_member[part as usize] = true);
    let mut next = 0;
    while let Some(&part) = members.get(next) {
        next += 1;
        // Nothing gets through what is held.
        if members.len() >= most || is_held(part) {
            continue;
        }
        for &bond in network.bonds_of(part) {
            let other = network.other(bond, part);
            if !std::mem::replace(&mut is_member[other as usize], true) {
                members.push(other);
            }
        }
    }
    members
}

#[cfg(test)]
mod tests {
    use super::{FEWEST_PARTS, FIRST_PARTS, MOST_STEPS, neighborhood};
    use crate::cluster::Cluster;
    use crate::cluster::hit::{Hit, Striker};
    use crate::cluster::network::Network;
    use crate::geometry::ConvexMesh;
    use crate::math::Pose;
    use glam::{UVec3, Vec3};

    /// A block of 10 x 8 x 6 bonded cubes of 0.2 m.
    fn block() -> Network {
        let cube = ConvexMesh::cuboid(0.2, 0.2, 0.2).unwrap();
        let size = UVec3::new(10, 8, 6);
        let places = (0..size.element_product())
            .map(|i| UVec3::new(i % size.x, i / size.x % size.y, i / (size.x * size.y)));
        let parts = places.map(|at| (Pose::from_position(0.2 * at.as_vec3()), cube.clone()));
        let compound = Cluster::new(parts, 1e5).unwrap().compound().unwrap();
        Network::new(&compound, 2000.0, 0.5).unwrap()
    }

    /// Symptom: 1179 parts took 2 to 4 s in some steps, as hundreds of pieces of up to 600 parts hit each other in each.
    #[test]
    fn beyond_what_a_step_may_follow_blows_break_what_is_near() {
        let network = block();
        let striker = Striker {
            part: 0,
            point: Vec3::new(-0.1, 0.0, 0.0),
            direction: Vec3::X,
            speed: 60.0,
            inverse_mass: 0.01,
        };
        let hit = Hit::of(std::slice::from_ref(&striker));
        let blow = |mut left: usize| network.blow(hit, |_| false, &mut left);
        let whole = blow(usize::MAX);
        for (most, left) in [
            (FEWEST_PARTS, 0),
            (FIRST_PARTS, FIRST_PARTS * 3 * MOST_STEPS),
        ] {
            let near = blow(left);
            let members = neighborhood(&network, hit, &|_| false, most);
            let is_near = |bond: &u32| {
                let parts = network.bonds[*bond as usize].parts;
                parts.iter().any(|part| members.contains(part))
            };
            assert!(near.broken.iter().all(is_near), "{most}");
            assert!(!whole.broken.iter().all(is_near), "{most}");
            // Around the blow, two thirds of what breaks without a limit.
            let around = whole.broken.iter().filter(|bond| is_near(bond)).count();
            let share = near.broken.len() as f32 / around as f32;
            assert!((0.5..1.5).contains(&share), "{most}: {share}");
        }
    }

    /// Symptom: each blow was followed to its end if anything was left when it began: 120 to 320 ms for one shot at a thousand parts.
    #[test]
    fn a_blow_follows_hardly_more_than_a_step_may() {
        let network = block();
        for part in (0..480).step_by(37) {
            for (speed, left) in [(3.0, 0), (20.0, 50_000), (60.0, 200_000), (300.0, 600_000)] {
                let striker = Striker {
                    part,
                    point: network.nodes[part as usize].center.as_vec3(),
                    direction: Vec3::X,
                    speed,
                    inverse_mass: 0.01,
                };
                let hit = Hit::of(std::slice::from_ref(&striker));
                let followed = |most: usize| {
                    let mut left = most;
                    network
                        .follow((hit, f32::INFINITY), |_| false, &mut left)
                        .followed
                };
                // Bonds to parts that stay where they are come on top, and what was followed of fewer parts before.
                let least = FEWEST_PARTS * 6 * MOST_STEPS;
                assert!(followed(left) <= least.max(2 * left), "{part}: {left}");
            }
        }
    }
}
