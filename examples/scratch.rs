#![allow(warnings, clippy::all, unsafe_code)]
#[path = "/tmp/scr/scene.rs"]
mod scene;
use bevy_cleave::prelude::*;
use bevy_cleave::solver::*;
use bevy_cleave::step::{self, Simulation, StepSettings};
use glam::{Quat, Vec3};
#[repr(C)] struct Ts { s: i64, n: i64 }
unsafe extern "C" { fn clock_gettime(id: i32, t: *mut Ts) -> i32; }
#[derive(Clone, Copy)]
struct Instant(f64);
impl Instant {
    fn now() -> Self { let id = if std::env::var("WALL").is_ok() { 1 } else { 2 }; let mut t = Ts { s: 0, n: 0 }; unsafe { clock_gettime(id, &mut t); } Self(t.s as f64 + t.n as f64 * 1e-9) }
    fn elapsed(&self) -> std::time::Duration { std::time::Duration::from_secs_f64(Self::now().0 - self.0) }
}
fn arg(name: &str, default: f32) -> f32 {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default)
}
fn main() {
    let spec = std::env::args().nth(1).unwrap_or("pyramid:30".into());
    let threads = arg("T", 1.0) as usize;
    if threads > 1 {
        bevy_tasks::ComputeTaskPool::get_or_init(|| bevy_tasks::TaskPoolBuilder::new().num_threads(threads - 1).build());
    }
    let sc = scene::build(&spec).unwrap();
    let mut sim = Simulation::default();
    sim.gravity = Gravity(sc.gravity);
    let sub = arg("SUB", 0.0) as u32;
    let mut c = SolverConfig::default();
    if sub > 0 { c.substeps = sub; c.max_substeps = arg("MAX", sub as f32) as u32; c.tolerance = None; }
    if arg("PAPER", 0.0) > 0.0 { c = SolverConfig::paper(); c.sweeps = arg("PAPER", 0.0) as u32; }
    if arg("EXACT", 0.0) > 0.0 { c = SolverConfig::exact(); }
    c.sweeps = arg("SW", c.sweeps as f32) as u32;
    c.relax_sweeps = arg("RSW", c.relax_sweeps as f32) as u32;
    c.contact_frequency = arg("FREQ", c.contact_frequency);
    c.damping_ratio = arg("DAMP", c.damping_ratio);
    c.sag = arg("SAG", c.sag);
    if arg("TOL", 0.0) > 0.0 { c.tolerance = Some(arg("TOL", 0.0)); }
    if arg("TOL", 0.0) < 0.0 { c.tolerance = None; }
    sim.config = c;
    let shapes: Vec<ConvexMesh> = sc.shapes.iter().map(|s| match s.half_extents {
        Some(h) => ConvexMesh::cuboid(2.0 * h.x, 2.0 * h.y, 2.0 * h.z).unwrap(),
        None => ConvexMesh::from_points(&s.points).unwrap(),
    }).collect();
    let mut slots = vec![];
    for b in &sc.bodies {
        let mut d = BodyDesc::dynamic(shapes[b.shape].clone(), b.pos);
        if b.fixed { d.kind = RigidBody::Static; }
        d.pose.rotation = b.rot;
        d.linear_velocity = b.linvel; d.angular_velocity = b.angvel; d.density = b.density;
        d.friction = Friction::new(sc.friction); d.restitution = Restitution::new(sc.restitution);
        slots.push(sim.bodies.insert(d).unwrap());
    }
    let h = sc.dt;
    let mut t: [Vec<f64>; 7] = Default::default();
    let mut tot = vec![];
    let phases = arg("PH", 1.0) > 0.0;
    let mut pen = (0.0f64, 0usize);
    let mut sweeps = vec![];
    let steps = arg("STEPS", sc.steps as f32) as usize;
    sim.config.measure_islands = arg("MI", 0.0) > 0.0;
    for i in 0..steps {
        let start = Instant::now();
        if phases {
            let settings = &sim.settings(h);
            let Simulation { bodies, contacts, cache, fractures, bonds, report, .. } = &mut sim;
            let mut s = Instant::now();
            let mut mark = |k: usize| { t[k].push(s.elapsed().as_secs_f64() * 1e6); s = Instant::now(); };
            step::mass_properties(bodies, report); step::cut(bodies, cache, fractures, bonds, settings); mark(0);
            step::broadphase(bodies, contacts, settings, report); mark(1);
            step::generate_contacts(bodies, contacts, cache, settings, report); step::attach_bonds(bodies, contacts, bonds); mark(2);
            step::solve(bodies, contacts, fractures, settings, report); mark(3);
            step::fracture(bodies, contacts, cache, fractures, bonds, settings, report); step::break_bonds(bodies, contacts, bonds); mark(6);
            step::integrate(bodies, report); mark(4);
            step::age_cache(bodies, contacts, cache, settings); step::sleep(bodies, contacts, cache, settings, report); mark(5);
        } else { sim.step(h); }
        tot.push(start.elapsed().as_secs_f64() * 1e6);
        if i >= sc.warmup {
            if i % sc.deep_every == 0 { for m in sim.contacts.manifolds() {
                let d = m.points().iter().map(|p| -p.separation).fold(0.0f32, f32::max);
                if d > 0.0 { pen.0 += d as f64; pen.1 += 1; }
            } }
            if sim.config.measure_islands { sweeps.push(sim.report.islands.iter().map(|i| i.sweeps).max().unwrap_or(0) as f64); }
        }
    }
    let med = |v: &[f64]| { let mut v = v[sc.warmup.min(v.len()-1)..].to_vec(); v.sort_by(f64::total_cmp); v[v.len() / 2] };
    let mut disp = 0.0f32;
    for (b, s) in sc.bodies.iter().zip(&slots) {
        let m = sim.bodies.pose(*s).position.distance(b.pos);
        if !b.fixed { disp = disp.max(m); }
    }
    print!("{spec} sub {sub}: total {:.1} us", med(&tot));
    if phases { for (k, n) in ["mass", "broad", "narrow", "solve", "integ", "cache", "frac"].iter().enumerate() { print!(" {n} {:.1}", med(&t[k])); } }
    sweeps.sort_by(f64::total_cmp);
    println!(" | disp {disp:.2e} pen {:.2e} contacts {} manifolds {} pairs {} sweeps {:?} state {:016x}", pen.0 / pen.1.max(1) as f64, sim.report.contacts, sim.report.manifolds, sim.report.pairs, sweeps.get(sweeps.len()/2), hash(&sim, &slots));
}
fn hash(sim: &Simulation, slots: &[u32]) -> u64 {
    let mut h = 0xcbf29ce484222325u64;
    for s in slots {
        let p = sim.bodies.pose(*s);
        for x in p.position.to_array().into_iter().chain(p.rotation.to_array()) {
            h = (h ^ x.to_bits() as u64).wrapping_mul(0x100000001b3);
        }
    }
    h
}
