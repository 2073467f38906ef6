//! Where others stretch, drift or blow up.

use crate::common::scenes::{awake, awake_on_floor};
use crate::scene::{H, Random, chain, fixed, fixed_substeps, gap, heavy, largest_gap, local};
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

#[test]
fn a_rope_of_a_thousand_links_hangs_and_swings() {
    for along in [Vec3::NEG_Y, Vec3::X] {
        let mut chain = chain(1000, 1.0, along, Vec3::ZERO);
        let gap = chain.largest_gap(40, H);
        println!("1000 links along {along}: {gap:e} m");
        assert!(gap < 1e-3, "{along}: {gap}");
    }
}

/// Each sweep solves all joints of an island: few contacts may not have it make thousands of them.
#[test]
fn sweeps_of_a_rope_that_touches_the_floor_are_bounded_by_its_links() {
    let method = SoftStep::default();
    for links in [50_u16, 200, 800] {
        let hang = (f32::from(links) + 1.0 - 1e-3) * Vec3::Y;
        let mut chain = chain(usize::from(links), 1000.0, Vec3::NEG_Y, hang);
        let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
        chain.simulation.bodies.insert(floor).expect("usable");
        chain.simulation.config.measure_islands = true;
        let mut most = 0;
        for _ in 0..20 {
            chain.simulation.step(H);
            let sweeps = chain.simulation.report.islands.iter().map(|it| it.sweeps);
            most = most.max(sweeps.max().unwrap_or(0));
        }
        let least = method.max_substeps * (method.sweeps + method.relax_sweeps);
        let extra = method.max_extra_updates / (10 * u32::from(links));
        println!("rope of {links} links on the floor: {most} sweeps a step");
        assert!(most > 0 && most <= least + extra, "{links}: {most}");
    }
}

#[test]
fn chains_hold_at_all_step_rates() {
    for rate in [30.0, 60.0, 120.0, 240.0] {
        let mut chain = chain(10, 100.0, Vec3::X, Vec3::ZERO);
        let gap = chain.largest_gap(2 * rate as usize, 1.0 / rate);
        println!("{rate} Hz: {gap:e} m");
        assert!(gap < 1e-4, "{rate} Hz: {gap}");
    }
}

#[test]
fn joints_far_from_the_origin_are_off_by_no_more_than_their_coordinates_are_round() {
    for far in [1e3, 1e4] {
        let mut chain = chain(10, 10.0, Vec3::X, Vec3::new(far, -far, far));
        let gap = chain.largest_gap(120, H);
        println!("{far} m away: {gap:e} m");
        assert!(gap < f64::from(far) * 1e-6, "{far}: {gap}");
    }
}

#[test]
fn a_light_door_part_holds_a_heavy_one_by_a_hinge() {
    for ratio in [1e-3, 1e3] {
        let mut simulation = awake();
        let light = heavy(Vec3::new(1.0, 1.0, 0.1), Vec3::new(0.5, 0.0, 0.0), 1.0);
        let other = heavy(Vec3::new(1.0, 1.0, 0.1), Vec3::new(1.5, 0.0, 0.0), ratio);
        let [a, b] = [light, other].map(|body| simulation.bodies.insert(body).expect("usable"));
        let poses = [a, b].map(|slot| simulation.bodies.pose(slot));
        let hinge = |at: Vec3, poses| Joint::hinge().with_anchor(at, Vec3::Y, poses);
        let first = hinge(Vec3::ZERO, [Pose::IDENTITY, poses[0]]);
        let second = hinge(Vec3::X, poses);
        let first = simulation.join(None, a, first).expect("usable");
        let second = simulation.join(Some(a), b, second).expect("usable");
        let push = Vec3::new(0.0, 0.0, 3.0);
        simulation
            .bodies
            .set_velocity(b, push, Vec3::ZERO)
            .expect("finite");
        for _ in 0..300 {
            simulation.step(H);
            for id in [first, second] {
                let error = simulation.joints.load(id).expect("there").error;
                assert!(gap(&simulation, id) < 1e-5, "{ratio}");
                assert!(error[1] < 1e-5, "{ratio}: {error:?}");
            }
        }
    }
}

#[test]
fn closed_loops_and_rows_that_say_the_same_twice_do_no_harm() {
    // A parallelogram on two world pivots, with hinges all around, one of which would be enough to hold the plane; the last bar
    // has two hinges where one would do.
    let mut simulation = awake();
    let bar = |at: Vec3, size: Vec3| heavy(size, at, 2.0);
    let upright = Vec3::new(0.1, 1.0, 0.1);
    let bodies = [
        bar(Vec3::new(0.0, -0.5, 0.0), upright),
        bar(Vec3::new(1.0, -0.5, 0.0), upright),
        bar(Vec3::new(0.5, -1.0, 0.0), Vec3::new(1.0, 0.1, 0.1)),
    ];
    let slots = bodies.map(|body| simulation.bodies.insert(body).expect("usable"));
    let mut ids = Vec::new();
    for (a, b, at) in [
        (None, 0, Vec3::ZERO),
        (None, 1, Vec3::X),
        (Some(0), 2, Vec3::NEG_Y),
        (Some(1), 2, Vec3::new(1.0, -1.0, 0.0)),
        (Some(1), 2, Vec3::new(1.0, -1.0, 0.05)),
    ] {
        let a: Option<usize> = a;
        let pose = |slot: usize| simulation.bodies.pose(slots[slot]);
        let poses = [a.map_or(Pose::IDENTITY, pose), pose(b)];
        let hinge = Joint::hinge().with_anchor(at, Vec3::Z, poses);
        let id = simulation.join(a.map(|a| slots[a]), slots[b], hinge);
        ids.push(id.expect("usable"));
    }
    let spin = Vec3::new(0.0, 0.0, 2.0);
    for (slot, at) in [
        (0, Vec3::new(0.0, -0.5, 0.0)),
        (1, Vec3::new(0.0, -0.5, 0.0)),
    ] {
        let v = spin.cross(at);
        simulation
            .bodies
            .set_velocity(slots[slot], v, spin)
            .expect("finite");
    }
    let v = spin.cross(Vec3::NEG_Y);
    simulation
        .bodies
        .set_velocity(slots[2], v, Vec3::ZERO)
        .expect("finite");
    let energy = |simulation: &Simulation| {
        let of = |&slot: &u32| {
            let height = f64::from(simulation.bodies.center_of_mass(slot).y);
            simulation.bodies.kinetic_energy(slot) + 2.0 * 9.81 * height
        };
        slots.iter().map(of).sum::<f64>()
    };
    simulation.step(H);
    let before = energy(&simulation);
    for _ in 0..600 {
        simulation.step(H);
        for &id in &ids {
            assert!(gap(&simulation, id) < 1e-5, "{}", gap(&simulation, id));
        }
    }
    let change = energy(&simulation) - before;
    println!("parallelogram: {change:e} J of {before}");
    assert!(change.abs() < 0.01 * before.abs(), "{change} J");
}

/// A point of the world in a body's frame.
/// A bridge of planks of 0.5 m by two ball joints at each seam, from the origin down and up again by `slope`, both ends fixed, the second
/// one `off` m nearer than it is.
fn bridge(planks: usize, slope: f32, off: f32) -> (Simulation, Vec<JointId>) {
    let mut simulation = awake();
    let (mut last, mut end, mut ids) = (None, Vec3::ZERO, Vec::new());
    let mut join = |simulation: &mut Simulation, a: Option<u32>, b: Option<u32>, at: Vec3| {
        for side in [-1.0, 1.0] {
            let at = at + Vec3::new(0.0, 0.0, side);
            let off = if b.is_some() { 0.0 } else { off };
            let (a, b, shift) = match b {
                Some(b) => (a, b, Vec3::ZERO),
                None => (None, a.expect("there are planks"), Vec3::new(off, 0.0, 0.0)),
            };
            let joint = Joint::ball().with_anchors(
                local(simulation, a, at) - shift,
                local(simulation, Some(b), at),
            );
            ids.push(simulation.join(a, b, joint).expect("usable"));
        }
    };
    for i in 0..planks {
        let down = if 2 * i < planks { -slope } else { slope };
        let along = Vec3::new(1.0, down, 0.0).normalize();
        let mut plank = heavy(Vec3::new(0.5, 0.1, 2.0), end + 0.25 * along, 20.0);
        plank.pose.rotation = Quat::from_rotation_arc(Vec3::X, along);
        let slot = simulation.bodies.insert(plank).expect("usable");
        join(&mut simulation, last, Some(slot), end);
        last = Some(slot);
        end += 0.5 * along;
    }
    join(&mut simulation, last, None, end);
    (simulation, ids)
}

#[test]
fn a_bridge_fixed_at_both_ends_keeps_its_joints() {
    let (mut simulation, ids) = bridge(100, 0.3, 0.0);
    let mut largest = 0.0_f64;
    for _ in 0..240 {
        simulation.step(H);
        largest = largest.max(largest_gap(&simulation, &ids));
    }
    println!("bridge: {largest:e} m");
    assert!(largest < 1e-4, "{largest}");
}

#[test]
fn a_bridge_whose_ends_are_too_near_comes_together() {
    let (mut simulation, ids) = bridge(20, 0.1, 1.0);
    for _ in 0..300 {
        simulation.step(H);
    }
    let largest = largest_gap(&simulation, &ids);
    println!("bridge that is put together wrongly: {largest:e} m");
    assert!(largest < 1e-4, "{largest}");
}

fn with_substeps(simulation: &mut Simulation, count: u32) {
    simulation.config = SolverConfig {
        sleep: simulation.config.sleep,
        ..fixed_substeps(count)
    };
}

/// Nothing that is straight between two fixed ends can bear a load across: it opens as far as it must, and stays together.
#[test]
fn a_straight_bridge_under_a_load_stays_together() {
    for (count, bound) in [
        (None, 1e-4),
        (Some(16), 1e-4),
        (Some(4), 0.5),
        (Some(1), 3.0),
    ] {
        let (mut simulation, ids) = bridge(40, 0.0, 0.0);
        if let Some(count) = count {
            with_substeps(&mut simulation, count);
        }
        let load = heavy(Vec3::new(2.0, 1.0, 1.6), Vec3::new(10.0, 0.6, 0.0), 5000.0);
        let load = simulation.bodies.insert(load).expect("usable");
        let (mut largest, mut highest) = (0.0_f64, 0.0_f32);
        for _ in 0..300 {
            simulation.step(H);
            largest = largest.max(largest_gap(&simulation, &ids));
            highest = highest.max(simulation.bodies.center_of_mass(load).y);
        }
        let at = simulation.bodies.center_of_mass(load);
        println!(
            "straight bridge, {count:?} sub-steps: {largest:e} m, load up to {highest} m, at {at}"
        );
        assert!(largest < bound, "{count:?}: {largest}");
        assert!(highest < 0.7, "{count:?}: {highest}");
    }
}

/// Of 28 random chains with 300 to 1500 times a link at their end, let go level, how many come open by a hundredth of a link in 15 s: none is the aim.
/// Of the first 60, 10 do (11 with eight sub-steps throughout, of which 4 are among the first 28).
const KNOWN_OPEN: usize = 6;

#[test]
fn heavy_loads_swing_on_chains() {
    let (mut open, mut worst) = (0, 0.0_f64);
    for seed in 0..28 {
        let mut random = Random::new(seed);
        let links = 8 + (seed % 6) as usize;
        let ratio = random.range(300.0, 1500.0);
        let along = Vec3::new(1.0, random.range(-0.5, 0.5), random.range(-0.5, 0.5)).normalize();
        let gap = chain(links, ratio, along, Vec3::ZERO).largest_gap(900, H);
        open += usize::from(gap > 1e-2);
        worst = worst.max(gap);
    }
    println!("heavy loads on chains: {open} of 28 come open, the worst by {worst:e} m");
    assert!(open <= KNOWN_OPEN && worst < 3.0, "{open}, {worst}");
}

/// With fewer sub-steps than a heavy load at the end of a chain asks for, joints open; nothing gains energy.
#[test]
fn few_substeps_open_a_chain_and_do_not_blow_it_up() {
    for (count, ratio) in [1, 2, 3, 4]
        .into_iter()
        .flat_map(|n| [(n, 100.0), (n, 1000.0)])
    {
        let mut simulation = awake();
        with_substeps(&mut simulation, count);
        let mut last = None;
        let mut slots = Vec::new();
        for i in 0..=10_u8 {
            let is_load = i == 10;
            let mass = if is_load { ratio } else { 1.0 };
            let side = if is_load { 1.0 } else { 0.1 };
            let at = Vec3::new(f32::from(i) + 0.5, 0.0, 0.0);
            let link = heavy(Vec3::new(1.0, side, side), at, mass);
            let slot = simulation.bodies.insert(link).expect("usable");
            let seam = Vec3::new(f32::from(i), 0.0, 0.0);
            let anchors = [last, Some(slot)].map(|slot| local(&simulation, slot, seam));
            let joint = Joint::ball().with_anchors(anchors[0], anchors[1]);
            simulation.join(last, slot, joint).expect("usable");
            slots.push((slot, f64::from(mass)));
            last = Some(slot);
        }
        let mut most = 0.0_f64;
        for _ in 0..240 {
            simulation.step(H);
            let of = |&(slot, mass): &(u32, f64)| {
                let height = f64::from(simulation.bodies.center_of_mass(slot).y);
                simulation.bodies.kinetic_energy(slot) + mass * 9.81 * height
            };
            most = most.max(slots.iter().map(of).sum());
        }
        let height = most / (9.81 * (f64::from(ratio) + 10.0));
        println!("{count} sub-steps, load {ratio}: energy of {height:e} m at most");
        assert!(height < 0.05, "{count}, {ratio}: {height}");
    }
}

#[test]
fn a_box_on_a_chain_rests_on_the_floor_and_on_the_chain() {
    // Contacts and joints of one island: the load lies on the floor, and a kinematic body drags it by a chain.
    let mut simulation = awake_on_floor();
    let mut random = Random::new(1);
    let mut hand = BodyDesc {
        kind: RigidBody::Kinematic,
        ..fixed(Vec3::new(-0.1, 0.5, 0.0))
    };
    hand.linear_velocity = Vec3::new(-1.0, 0.0, 0.0);
    let hand = simulation.bodies.insert(hand).expect("usable");
    let mut last = (hand, Vec3::new(0.1, 0.0, 0.0));
    let mut ids = Vec::new();
    for i in 0..5 {
        let size = Vec3::new(0.4, 0.05, 0.05);
        let at = Vec3::new(0.2 + 0.4 * i as f32, 0.5, 0.0);
        let slot = simulation
            .bodies
            .insert(heavy(size, at, 0.5))
            .expect("usable");
        let half = Vec3::new(0.2, 0.0, 0.0);
        let joint = Joint::ball().with_anchors(last.1, -half);
        ids.push(simulation.join(Some(last.0), slot, joint).expect("usable"));
        last = (slot, half);
    }
    let load = heavy(
        Vec3::ONE,
        Vec3::new(2.5, 0.5, 0.0),
        random.range(49.0, 50.0),
    );
    let load = simulation.bodies.insert(load).expect("usable");
    let joint = Joint::ball().with_anchors(last.1, Vec3::new(-0.5, 0.0, 0.0));
    ids.push(simulation.join(Some(last.0), load, joint).expect("usable"));
    let mut largest = 0.0_f64;
    for _ in 0..240 {
        simulation.step(H);
        largest = ids
            .iter()
            .map(|&id| gap(&simulation, id))
            .fold(largest, f64::max);
    }
    let (v, _) = simulation.bodies.velocity(load);
    let height = simulation.bodies.center_of_mass(load).y;
    println!("dragged: gap {largest:e} m, v {v}, height {height}");
    assert!(largest < 1e-4, "{largest}");
    assert!((v.x + 1.0).abs() < 0.05, "{v}");
    assert!((height - 0.5).abs() < 0.01, "{height}");
}

#[test]
fn a_steady_step_with_joints_allocates_nothing() {
    let mut chain = chain(20, 10.0, Vec3::X, Vec3::ZERO);
    chain.largest_gap(30, H);
    let simulation = &mut chain.simulation;
    let allocated = allocation_counter::measure(|| (0..60).for_each(|_| simulation.step(H)));
    assert_eq!(allocated.count_total, 0, "{allocated:?}");
}
