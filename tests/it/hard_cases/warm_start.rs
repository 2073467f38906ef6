//! What a contact cache is worth: off, on, and keyed by KD codes against matched by features.

use super::support::*;
use crate::common::dice::Dice;
use crate::common::structures::*;
use bevy_cleave::contact::{
    BodyId, CacheStats, ContactCache, ContactPoint, ManifoldHead, Manifolds,
};
use bevy_cleave::geometry::ConvexHull;
use bevy_cleave::prelude::*;
use bevy_cleave::step;
use bevy_cleave::testing::math::rotate;
use glam::{Quat, Vec3};

/// Where the multipliers that a step starts from come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Start {
    /// Zero.
    Cold,
    /// The crate's cache.
    KdCode,
    /// The point of the step before that touched with the same features of the same bodies. A feature is the corner, edge
    /// or face of a body's hull that the point lies on, the smallest within [`NEAR`] of it; a point's two features are
    /// its name, as in engines that clip by feature ids.
    Feature,
}

const STARTS: [Start; 3] = [Start::Cold, Start::KdCode, Start::Feature];

/// How near a point must be to a corner or an edge to be on it, as a share of the hull's longest edge.
const NEAR: f32 = 2e-3;

/// How far a point may move on both bodies within a step and still be the same, m.
const FAR: f32 = 0.005;

/// What a point touches a body with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Feature {
    Corner(usize),
    Edge(usize),
    Face(usize),
}

/// The feature of `hull` that `point` (hull's frame) is on.
fn feature_at(hull: &ConvexHull, point: Vec3) -> Feature {
    let near = NEAR * hull.aabb().extents().max_element();
    let corners = hull.vertices();
    if let Some(corner) = corners.iter().position(|c| c.distance(point) <= near) {
        return Feature::Corner(corner);
    }
    let from_edge = |ends: [u32; 2]| {
        let [a, b] = ends.map(|v| corners[v as usize]);
        let share = (point - a).dot(b - a) / (b - a).length_squared();
        point.distance(a.lerp(b, share.clamp(0.0, 1.0)))
    };
    let edges = hull.edges();
    if let Some(edge) = edges.iter().position(|e| from_edge(e.vertices) <= near) {
        return Feature::Edge(edge);
    }
    let distance = |k: usize| hull.faces()[k].plane.distance(point).abs();
    let nearest = (0..hull.faces().len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
    Feature::Face(nearest.expect("a hull has faces"))
}

/// A contact point of the step before.
#[derive(Clone, Copy, Debug)]
struct Known {
    bodies: [BodyId; 2],
    features: [Feature; 2],
    /// On the surfaces of the two bodies, in their frames, m.
    places: [Vec3; 2],
    normal_impulse: f32,
    /// A's frame, N s.
    friction_impulse: Vec3,
}

/// `point` of the manifold `m`, with names that outlive the step.
fn known(bodies: &Bodies, m: &ManifoldHead, point: &ContactPoint) -> Known {
    let slots = [m.a, m.b];
    // Anchors are midway between the two surfaces.
    let half_gap = 0.5 * point.separation * m.normal;
    let anchors = [point.anchor_a - half_gap, point.anchor_b + half_gap];
    let places = [0, 1].map(|k| {
        let to_body = bodies.pose(slots[k]).rotation.inverse();
        rotate(to_body, anchors[k]) + bodies.mass(slots[k]).center
    });
    let features = [0, 1].map(|k| match bodies.convex(slots[k]) {
        Some(mesh) => feature_at(mesh.hull(), places[k]),
        None => Feature::Face(0),
    });
    Known {
        bodies: slots.map(|slot| bodies.id(slot)),
        features,
        places,
        normal_impulse: point.normal_impulse,
        friction_impulse: rotate(bodies.pose(m.a).rotation.inverse(), point.friction_impulse),
    }
}

impl Known {
    /// How far this point is from `other` on the body on which it moved less, m.
    fn moved(&self, other: &Self) -> f32 {
        let [a, b] = [0, 1].map(|k| self.places[k].distance(other.places[k]));
        a.min(b)
    }
}

/// How points were matched to those of the step before.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    points: usize,
    hits: usize,
    /// Hits whose point had moved by more than 5 mm on both bodies: another contact's multiplier.
    wrong: usize,
}

impl Tally {
    fn add(&mut self, moved: Option<f32>) {
        self.points += 1;
        self.hits += usize::from(moved.is_some());
        self.wrong += usize::from(moved.is_some_and(|distance| distance > FAR));
    }

    fn hit_rate(&self) -> f64 {
        self.hits as f64 / self.points.max(1) as f64
    }

    fn wrong_rate(&self) -> f64 {
        self.wrong as f64 / self.hits.max(1) as f64
    }
}

/// A simulation whose multipliers come from where `start` says.
struct Runner {
    simulation: Simulation,
    start: Start,
    before: Vec<Known>,
    tally: Tally,
}

impl Runner {
    fn new(mut simulation: Simulation, start: Start) -> Self {
        simulation.config.warm_start = start != Start::Cold;
        Self {
            simulation,
            start,
            before: Vec::new(),
            tally: Tally::default(),
        }
    }

    /// [`Simulation::step`], phase by phase, with a look at the contacts before they are solved.
    fn step(&mut self) {
        let settings = &self.simulation.settings(H);
        let Simulation {
            bodies,
            contacts,
            cache,
            fractures,
            bonds,
            joints,
            report,
            ..
        } = &mut self.simulation;
        step::mass_properties(bodies, report);
        step::cut(bodies, cache, fractures, bonds, settings);
        step::broadphase(bodies, contacts, settings, report);
        if self.start == Start::Feature {
            step::generate_contacts(bodies, contacts, &mut ContactCache::new(), settings, report);
            *cache = match_features(&self.before, bodies, contacts.manifolds(), &mut self.tally);
        }
        step::generate_contacts(bodies, contacts, cache, settings, report);
        if self.start == Start::KdCode {
            tally_warm_points(
                &self.before,
                bodies,
                contacts.manifolds(),
                &report.cache,
                &mut self.tally,
            );
        }
        step::solve(bodies, contacts, fractures, settings, report);
        self.before.clear();
        for m in contacts.manifolds().iter() {
            let points = m.points().iter();
            self.before
                .extend(points.map(|point| known(bodies, &m, point)));
        }
        let breakable = step::Breakable {
            cache,
            fractures,
            bonds,
            joints,
        };
        step::fracture(bodies, contacts, breakable, settings, report);
        step::integrate(bodies, contacts, report);
        step::age_cache(bodies, contacts, cache, settings);
    }
}

/// A cache that gives each of the (cold) `manifolds`' points what the point of the same features had the step before.
fn match_features(
    before: &[Known],
    bodies: &Bodies,
    manifolds: &Manifolds,
    tally: &mut Tally,
) -> ContactCache {
    let mut taken = vec![false; before.len()];
    let mut warm = manifolds.clone();
    for (head, points) in warm.iter_mut() {
        let rotation = bodies.pose(head.a).rotation;
        for point in points {
            let new = known(bodies, head, point);
            let is_same = |k: usize| {
                !taken[k] && before[k].bodies == new.bodies && before[k].features == new.features
            };
            let found = (0..before.len()).find(|&k| is_same(k));
            tally.add(found.map(|k| new.moved(&before[k])));
            if let Some(k) = found {
                taken[k] = true;
                point.normal_impulse = before[k].normal_impulse;
                point.friction_impulse = rotate(rotation, before[k].friction_impulse);
            }
        }
    }
    let slots = 0..bodies.slots() as u32;
    let ids: Vec<BodyId> = slots.clone().map(|slot| bodies.id(slot)).collect();
    let rotations: Vec<Quat> = slots.map(|slot| bodies.pose(slot).rotation).collect();
    let mut cache = ContactCache::new();
    cache.store_and_age(&warm, &ids, &rotations, H);
    cache
}

/// Counts hits as the cache does, and finds whose multiplier each point has by its impulse, which is passed on bit for
/// bit: the nearest of those with the same. (A multiplier of zero is nobody's.)
fn tally_warm_points(
    before: &[Known],
    bodies: &Bodies,
    manifolds: &Manifolds,
    stats: &CacheStats,
    tally: &mut Tally,
) {
    tally.points += stats.points as usize;
    tally.hits += (stats.exact_hits + stats.near_hits) as usize;
    for m in manifolds.iter() {
        for point in m.points().iter().filter(|p| p.normal_impulse != 0.0) {
            let new = known(bodies, &m, point);
            let giver = before
                .iter()
                .filter(|old| old.bodies == new.bodies && old.normal_impulse == new.normal_impulse);
            let moved = giver
                .map(|old| new.moved(old))
                .fold(f32::INFINITY, f32::min);
            tally.wrong += usize::from(moved > FAR);
        }
    }
}

/// A hexagonal prism with its axis along z that rolls down a slope of 15 degrees, mu 1.
fn rolling_prism() -> Simulation {
    let tilt = Quat::from_rotation_z(-15.0_f32.to_radians());
    let upright = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let shape = ConvexMesh::regular_prism(12, 0.5, 1.0).expect("valid size");
    let mut prism = block(&shape, tilt * Vec3::new(0.0, 0.5, 0.0), 1.0);
    prism.pose.rotation = tilt * upright;
    prism.linear_velocity = tilt * Vec3::X;
    prism.angular_velocity = -2.0 * Vec3::Z;
    simulation([half_space(tilt * Vec3::Y, 1.0), prism])
}

/// Ten cubes that slide side by side at 0.4 to 4 m/s, and turn.
fn sliding_cubes() -> Simulation {
    let shape = cuboid(Vec3::ONE);
    let cubes = (0..10_u8).map(|i| {
        let mut cube = block(&shape, Vec3::new(0.0, 0.5, 2.0 * f32::from(i)), 0.2);
        cube.linear_velocity = 0.4 * f32::from(i + 1) * Vec3::X;
        cube.angular_velocity = 0.2 * f32::from(i) * Vec3::Y;
        cube
    });
    simulation(std::iter::once(floor(0.2)).chain(cubes))
}

/// Sixty boxes of different sizes that fall on a heap.
fn heap() -> Simulation {
    let mut dice = Dice::new(31);
    let boxes = (0..60_u8).map(|i| {
        let shape = cuboid(dice.vector(0.3, 0.8));
        let cell = Vec3::new(
            f32::from(i % 3),
            1.0 + f32::from(i / 9),
            f32::from(i / 3 % 3),
        );
        let mut desc = block(&shape, 0.9 * cell, 0.5);
        desc.pose.rotation = dice.rotation();
        desc
    });
    simulation(std::iter::once(floor(0.5)).chain(boxes).collect::<Vec<_>>())
}

/// A column of four cubes of which the lowest is cut upright in the first step.
fn cut_column() -> Simulation {
    let mut simulation = simulation(tower(4));
    let plane = Plane::through(0.1 * Vec3::X, Vec3::X);
    simulation.slice(1, plane).expect("a body");
    simulation
}

/// Hit rates in two seconds of a scene, by KD code and by feature.
fn hit_rates(name: &str, scene: fn() -> Simulation) -> [Tally; 2] {
    let tallies = [Start::KdCode, Start::Feature].map(|start| {
        let mut runner = Runner::new(scene(), start);
        (0..120).for_each(|_| runner.step());
        runner.tally
    });
    let [kd, feature] = &tallies;
    println!(
        "31 {name}: hit rate by KD code {:.4} (wrong {:.4}), by feature {:.4} (wrong {:.4}), {} points",
        kd.hit_rate(),
        kd.wrong_rate(),
        feature.hit_rate(),
        feature.wrong_rate(),
        kd.points
    );
    tallies
}

/// Hard because a contact that rests keeps its cell only if rounding does not move it over a border, one that slides or
/// rolls leaves its cell each step, and a cut renames its bodies. A hit whose point moved by more than 5 mm on both bodies
/// is somebody else's multiplier.
#[test]
fn kd_codes_find_contacts_as_often_as_features_do() {
    type Scene = (&'static str, fn() -> Simulation, f64);
    let scenes: [Scene; 5] = [
        ("tower of 10 at rest", || simulation(tower(10)), 0.99),
        ("sliding cubes", sliding_cubes, 0.98),
        ("rolling prism", rolling_prism, 0.7),
        ("falling heap", heap, 0.8),
        ("column with a cube cut", cut_column, 0.95),
    ];
    for (name, scene, least) in scenes {
        let [kd, feature] = hit_rates(name, scene);
        assert!(kd.hit_rate() >= least, "{name}: {kd:?}");
        assert!(kd.wrong_rate() < 0.02, "{name}: {kd:?}");
        let right = [kd, feature].map(|tally| tally.hit_rate() * (1.0 - tally.wrong_rate()));
        assert!(right[0] >= right[1] - 0.02, "{name}: right hits {right:?}");
    }
}

/// Whether nothing moves by more than 5 cm within ten seconds.
fn stands(bodies: Vec<BodyDesc>, config: SolverConfig, start: Start) -> bool {
    let mut runner = Runner::new(simulation_with(config, bodies), start);
    let placed = frames(&runner.simulation);
    (0..10).all(|_| {
        (0..60).for_each(|_| runner.step());
        displacement(&runner.simulation, &placed) <= 0.05
    })
}

/// The least effort of `efforts` at which the scene stands; `None` if none does.
fn least_effort(
    scene: fn() -> Vec<BodyDesc>,
    efforts: &[u32],
    config: fn(u32) -> SolverConfig,
    start: Start,
) -> Option<u32> {
    let is_enough = |&effort: &u32| stands(scene(), config(effort), start);
    efforts.iter().copied().find(is_enough)
}

/// The paper's method with `sweeps` sweeps.
fn paper(sweeps: u32) -> SolverConfig {
    Pgs {
        sweeps,
        ..Pgs::default()
    }
    .into()
}

/// The default with `sweeps` sweeps in all: each sub-step has one with and one without position bias.
fn soft(sweeps: u32) -> SolverConfig {
    SoftStep {
        min_substeps: sweeps / 2,
        ..SoftStep::default()
    }
    .into()
}

/// Hard because cold sweeps carry a load up a column by one body each: the fewest sweeps in a step with which the column
/// and the load stand. In two dimensions a column of 10 fell cold at up to 32 sweeps and stood warm at 8.
#[test]
fn warm_start_saves_sweeps_on_towers_and_loads() {
    type Scene = (&'static str, fn() -> Vec<BodyDesc>);
    type Way = (&'static str, fn(u32) -> SolverConfig);
    let scenes: [Scene; 4] = [
        ("tower of 10", || tower(10)),
        ("tower of 40", || tower(40)),
        ("4 cubes under 100 times their load", || mass_ratio(100.0)),
        ("4 cubes under 1000 times their load", || mass_ratio(1000.0)),
    ];
    let methods: [Way; 2] = [("paper", paper), ("default", soft)];
    let efforts = [2, 4, 8, 16, 24, 32, 64, 128];
    let default = SoftStep::default();
    let of_default = default.min_substeps * (default.sweeps + default.relax_sweeps);
    let mut fails = Vec::new();
    for (name, scene) in scenes {
        for (method, config) in methods {
            let least = STARTS.map(|start| least_effort(scene, &efforts, config, start));
            println!(
                "31 {name}, {method}: sweeps that keep it standing: cold, by KD code, by feature {least:?}"
            );
            let [cold, kd, feature] = least.map(|sweeps| sweeps.unwrap_or(u32::MAX));
            let is_good = kd <= cold && kd <= feature && (method == "paper" || kd <= of_default);
            if !is_good {
                fails.push((name, method, least));
            }
        }
    }
    assert!(fails.is_empty(), "cold, by KD code, by feature: {fails:?}");
}
