//! What happened in a run: as a hash, and as figures that tell whether it was what the scene is for.

use bevy_cleave::contact::BodyId;
use bevy_cleave::prelude::*;
use glam::Vec3;

/// What there is to see after a step.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    pub(crate) bodies: &'a Bodies,
    pub(crate) contacts: &'a Contacts,
    pub(crate) cache: &'a ContactCache,
    pub(crate) fractures: &'a Fractures,
    pub(crate) bonds: &'a Bonds,
    pub(crate) report: &'a StepReport,
}

impl<'a> View<'a> {
    pub(crate) fn of(simulation: &'a Simulation) -> Self {
        Self {
            bodies: &simulation.bodies,
            contacts: &simulation.contacts,
            cache: &simulation.cache,
            fractures: &simulation.fractures,
            bonds: &simulation.bonds,
            report: &simulation.report,
        }
    }

    /// Slots in the order of ids.
    fn slots(&self) -> Vec<u32> {
        let mut slots: Vec<u32> = self.bodies.iter().collect();
        slots.sort_unstable_by_key(|&slot| self.bodies.id(slot));
        slots
    }
}

/// FNV-1a.
///
/// Fowler, Noll, Vo, "FNV Hash Algorithm", 1991; 64 bits.
#[derive(Clone, Copy)]
struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    fn bytes(&mut self, bytes: impl IntoIterator<Item = u8>) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn float(&mut self, x: f32) {
        self.bytes(x.to_bits().to_le_bytes());
    }

    fn floats(&mut self, numbers: &[f32]) {
        numbers.iter().for_each(|x| self.float(*x));
    }

    fn double(&mut self, x: f64) {
        self.bytes(x.to_bits().to_le_bytes());
    }

    fn count(&mut self, count: usize) {
        self.bytes((count as u64).to_le_bytes());
    }
}

/// Two hashes of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Hashes {
    /// Of the last state: positions, rotations and velocities.
    pub(crate) state: u64,
    /// Of all states, and of what the solver left beside them: manifolds with their impulses, the cache, islands and their
    /// sweeps, measured errors, who broke and slept.
    pub(crate) course: u64,
}

/// Hash of positions, rotations and velocities of all bodies in the order of their ids.
fn hash_of_state(bodies: &Bodies, slots: &[u32]) -> u64 {
    let mut hash = Fnv::default();
    for &slot in slots {
        let (pose, (v, omega)) = (bodies.pose(slot), bodies.velocity(slot));
        hash.floats(&pose.position.to_array());
        hash.floats(&pose.rotation.to_array());
        hash.floats(&v.to_array());
        hash.floats(&omega.to_array());
    }
    hash.0
}

/// What happened in a run.
#[derive(Debug, Default)]
pub(crate) struct Events {
    /// Bodies that broke or were cut.
    pub(crate) fractures: usize,
    /// Bodies that broke by a blow and had been in an island of 192 manifolds or more.
    pub(crate) fractures_in_large: usize,
    /// Bodies that broke by a blow and had been in a smaller one, or none.
    pub(crate) fractures_in_small: usize,
    /// Bodies that were cut, or had to wait for a step to break in.
    pub(crate) late_fractures: usize,
    /// Bonds that broke, and those that there are at the end.
    pub(crate) broken_bonds: usize,
    pub(crate) bonds: usize,
    /// Largest number of manifolds in a step.
    pub(crate) manifolds: usize,
    /// Manifolds of the largest island of any step.
    pub(crate) largest_island: usize,
    /// Steps in which an island of [`LARGE_ISLAND`] manifolds or more was solved.
    pub(crate) steps_with_large: usize,
    /// Times that a body fell asleep, that one woke, and those asleep at the end.
    pub(crate) slept: usize,
    pub(crate) woken: usize,
    pub(crate) asleep: usize,
    /// Pieces that were removed because they had slept for long.
    pub(crate) expired: usize,
    /// Steps whose error was measured, and is not zero.
    pub(crate) measured: usize,
    /// Fastest body at the end, m/s.
    pub(crate) speed: f32,
    /// Bodies faster than 0.5 m/s at the end.
    pub(crate) moving: usize,
    /// Fastest body at the end of any step, m/s.
    pub(crate) top_speed: f32,
    /// Lowest center of mass at the end, m.
    pub(crate) lowest: f32,
    /// Largest change of a body's angular velocity since the first step, rad/s.
    pub(crate) tumble: f32,
    /// Largest change of a body's velocity from one step to the next, m/s.
    pub(crate) jolt: f32,
}

/// Watches a run.
#[derive(Default)]
pub(crate) struct Watch {
    pub(crate) events: Events,
    hash: Fnv,
    before: Before,
}

/// What earlier steps left.
#[derive(Default)]
struct Before {
    /// Bodies that slept, ascending.
    asleep: Vec<BodyId>,
    /// Bodies in islands of [`REHEARSED`] manifolds or more, ascending.
    in_large: Vec<BodyId>,
    /// Velocities, in the order of ids.
    velocities: Vec<(BodyId, Vec3)>,
    /// Angular velocities after the first step, in the order of ids.
    first_spins: Vec<(BodyId, Vec3)>,
}

/// Manifolds from which islands are rehearsed.
const REHEARSED: usize = 192;

/// Manifolds of an island that is cut into domains.
pub(crate) const LARGE_ISLAND: usize = 4000;

impl Watch {
    /// Takes a step to the figures and to the hash.
    pub(crate) fn add(&mut self, view: &View<'_>) {
        let slots = view.slots();
        self.add_breaks(view);
        self.add_islands(view);
        self.add_sleep(view, &slots);
        self.add_motion(view, &slots);
        self.events.manifolds = self.events.manifolds.max(view.report.manifolds);
        let error = view.report.error.unwrap_or_default();
        self.events.measured += usize::from(error.residual.natural_map > 0.0);
        self.hash
            .bytes(hash_of_state(view.bodies, &slots).to_le_bytes());
        self.hash_solution(view);
        self.hash_report(view);
    }

    /// Ends the run: figures and hashes of the last state.
    pub(crate) fn end(&mut self, bodies: &Bodies) -> Hashes {
        let mut slots: Vec<u32> = bodies.iter().collect();
        slots.sort_unstable_by_key(|&slot| bodies.id(slot));
        self.events.lowest = f32::INFINITY;
        let dynamic = |&&slot: &&u32| bodies.kind(slot) == RigidBody::Dynamic;
        for &slot in slots.iter().filter(dynamic) {
            let speed = bodies.velocity(slot).0.length();
            self.events.speed = self.events.speed.max(speed);
            self.events.moving += usize::from(speed > 0.5);
            self.events.lowest = self.events.lowest.min(bodies.center_of_mass(slot).y);
        }
        Hashes {
            state: hash_of_state(bodies, &slots),
            course: self.hash.0,
        }
    }

    fn add_breaks(&mut self, view: &View<'_>) {
        let done = &view.fractures.done;
        self.events.fractures += done.len();
        let late = done.iter().filter(|fracture| fracture.blow.is_none());
        self.events.late_fractures += late.count();
        for fracture in done.iter().filter(|fracture| fracture.blow.is_some()) {
            let was_in_large = self.before.in_large.binary_search(&fracture.parent).is_ok();
            self.events.fractures_in_large += usize::from(was_in_large);
            self.events.fractures_in_small += usize::from(!was_in_large);
        }
        self.events.expired += view.fractures.expired.len();
        self.events.broken_bonds += view.bonds.broken.len();
        self.events.bonds = view.bonds.len();
    }

    /// Counts the manifolds of the islands.
    fn add_islands(&mut self, view: &View<'_>) {
        let bodies = view.bodies;
        let is_dynamic =
            |slot: u32| bodies.contains(slot) && bodies.kind(slot) == RigidBody::Dynamic;
        let mut island_of = vec![usize::MAX; bodies.slots()];
        let mut manifolds = Vec::new();
        for (number, island) in view.contacts.solver().islands().enumerate() {
            manifolds.push(0_usize);
            for &slot in island.slots.iter().filter(|&&slot| is_dynamic(slot)) {
                island_of[slot as usize] = number;
            }
        }
        for head in view.contacts.manifolds().heads() {
            let mut islands = [head.a, head.b].into_iter().map(|s| island_of[s as usize]);
            if let Some(island) = islands.find(|&island| island != usize::MAX) {
                manifolds[island] += 1;
            }
        }
        let largest = manifolds.iter().copied().max().unwrap_or(0);
        self.events.largest_island = self.events.largest_island.max(largest);
        self.events.steps_with_large += usize::from(largest >= LARGE_ISLAND);
        let is_in_large = |slot: &u32| {
            let size = manifolds.get(island_of[*slot as usize]);
            size.is_some_and(|&size| size >= REHEARSED)
        };
        let in_large = bodies.iter().filter(is_in_large);
        self.before.in_large = in_large.map(|slot| bodies.id(slot)).collect();
        self.before.in_large.sort_unstable();
    }

    fn add_sleep(&mut self, view: &View<'_>, slots: &[u32]) {
        let bodies = view.bodies;
        let asleep = slots.iter().filter(|&&slot| bodies.is_asleep(slot));
        let asleep: Vec<BodyId> = asleep.map(|&slot| bodies.id(slot)).collect();
        let before = &mut self.before.asleep;
        let slept_before = |id: &&BodyId| before.binary_search(id).is_ok();
        let stayed = asleep.iter().filter(slept_before).count();
        self.events.slept += asleep.len() - stayed;
        self.events.woken += before.len() - stayed;
        self.events.asleep = asleep.len();
        *before = asleep;
    }

    fn add_motion(&mut self, view: &View<'_>, slots: &[u32]) {
        let velocities = slots.iter().map(|&slot| {
            let (v, omega) = view.bodies.velocity(slot);
            (view.bodies.id(slot), v, omega)
        });
        let all: Vec<(BodyId, Vec3, Vec3)> = velocities.collect();
        let Before {
            velocities,
            first_spins,
            ..
        } = &mut self.before;
        if first_spins.is_empty() {
            first_spins.extend(all.iter().map(|&(id, _, omega)| (id, omega)));
        }
        let earlier = |list: &[(BodyId, Vec3)], id: BodyId| {
            let found = list.binary_search_by_key(&id, |entry| entry.0);
            found.ok().map(|at| list[at].1)
        };
        for &(id, v, omega) in &all {
            let jolt = earlier(velocities, id).map_or(0.0, |before| v.distance(before));
            let tumble = earlier(first_spins, id).map_or(0.0, |first| omega.distance(first));
            self.events.jolt = self.events.jolt.max(jolt);
            self.events.tumble = self.events.tumble.max(tumble);
            self.events.top_speed = self.events.top_speed.max(v.length());
        }
        velocities.clear();
        velocities.extend(all.iter().map(|&(id, v, _)| (id, v)));
    }

    /// Impulses of the step as the solver left them and as the cache keeps them, and what solving took.
    fn hash_solution(&mut self, view: &View<'_>) {
        let hash = &mut self.hash;
        let manifolds = view.contacts.manifolds();
        hash.count(manifolds.len());
        for manifold in manifolds.iter() {
            hash.floats(&manifold.normal.to_array());
            hash.count(manifold.points().len());
            for point in manifold.points() {
                hash.floats(&[point.separation, point.normal_impulse, point.total_impulse]);
                hash.floats(&point.friction_impulse.to_array());
            }
        }
        let cache = view.cache;
        for entry in cache.pairs().flat_map(|(a, b)| cache.entries_of(a, b)) {
            hash.float(entry.normal_impulse);
            hash.floats(&entry.friction_impulse.to_array());
            hash.count(entry.age as usize);
        }
        for island in view.contacts.solver().islands() {
            hash.count(island.bodies.len());
            hash.count(island.contacts);
            hash.count(island.budget.sweeps as usize);
            hash.count(usize::from(island.budget.is_unconverged));
        }
    }

    /// What the step says that it did.
    fn hash_report(&mut self, view: &View<'_>) {
        let (hash, report) = (&mut self.hash, view.report);
        let cache = &report.cache;
        for count in [
            report.manifolds,
            report.contacts,
            report.awake,
            report.asleep,
            view.fractures.done.len(),
            view.fractures.waiting(),
            view.fractures.expired.len(),
            view.bonds.broken.len(),
        ] {
            hash.count(count);
        }
        for count in [
            cache.points,
            cache.exact_hits,
            cache.near_hits,
            cache.stale_hits,
            cache.misses,
        ] {
            hash.count(count as usize);
        }
        if let Some(error) = report.error {
            let residual = error.residual;
            hash.floats(&[
                residual.natural_map,
                residual.relative,
                residual.approach_speed,
                residual.velocity_error,
                error.penetration,
            ]);
            hash.double(error.kinetic_energy);
            hash.double(error.potential_energy);
            hash.double(error.energy_change);
        }
    }
}
