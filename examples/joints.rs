//! One joint of each kind, and a crane whose ball breaks a wall.
//!
//! Look for the errors: what a joint holds stays where it is to some millionths of a meter, the chain of the crane too when its ball
//! of half a ton goes through the wall. Pictures are in `target/joints`.
#![expect(clippy::print_stdout, reason = "an example prints what it shows")]
#[path = "support/mod.rs"]
mod support;

use bevy_cleave::prelude::*;
use glam::Vec3;
use support::Error;
use support::render::{Camera, Scene, palette};

const FOLDER: &str = "target/joints";
const H: f32 = 1.0 / 60.0;

fn main() -> Result<(), Error> {
    std::fs::create_dir_all(FOLDER)?;
    kinds()?;
    crane()
}

/// Bars of 10 kg that each hang on the world by another kind of joint, at their left ends.
fn kinds() -> Result<(), Error> {
    let spring = JointSpring::Frequency {
        hertz: 1.0,
        damping_ratio: 0.1,
    };
    let motor = JointDrive::velocity(1.0, 200.0);
    let kinds = [
        ("fixed", Joint::fixed()),
        ("ball", Joint::ball()),
        ("hinge", Joint::hinge()),
        (
            "hinge, limits",
            Joint::hinge().with_angular_limits(-0.5, 0.5),
        ),
        ("hinge, motor", Joint::hinge().with_angular_drive(motor)),
        ("slider, spring", {
            Joint::slider().with_linear_drive(JointDrive::spring(0.0, spring))
        }),
        (
            "cylindrical",
            Joint::cylindrical().with_linear_limits(-0.5, 0.5),
        ),
        ("cone-twist", Joint::cone_twist(0.6, 0.3)),
        ("rod", Joint::rod(0.5)),
        ("rope", Joint::rope(0.5)),
        ("spring", Joint::spring(0.5, spring)),
    ];
    let mut simulation = Simulation::default();
    let mut joints = Vec::new();
    for (i, (name, joint)) in kinds.into_iter().enumerate() {
        let at = Vec3::new(0.0, 3.0, 1.2 * i as f32);
        let bar = BodyDesc {
            density: 10.0 / (0.2 * 0.2),
            ..BodyDesc::dynamic(ConvexMesh::cuboid(1.0, 0.2, 0.2)?, at)
        };
        let slot = simulation.bodies.insert(bar)?;
        let poses = [Pose::IDENTITY, simulation.bodies.pose(slot)];
        // Sliders slide downwards, all others turn about z.
        let axis = if name.starts_with("slider") || name == "cylindrical" {
            Vec3::NEG_Y
        } else {
            Vec3::Z
        };
        let mut joint = joint.with_anchor(at - 0.5 * Vec3::X, axis, poses);
        if ["rod", "rope", "spring"].contains(&name) {
            joint.frame_a.position += 0.5 * Vec3::Y;
        }
        joints.push((name, simulation.join(None, slot, joint)?));
    }
    let mut worst = vec![0.0_f32; joints.len()];
    for _ in 0..240 {
        simulation.step(H);
        for (worst, (_, id)) in worst.iter_mut().zip(&joints) {
            let error = simulation
                .joints
                .load(*id)
                .map_or([0.0; 2], |load| load.error);
            *worst = worst.max(error[0]).max(error[1]);
        }
    }
    println!("kind             largest error in 4 s, m or rad   force, N");
    for ((name, id), worst) in joints.iter().zip(worst) {
        let force = simulation
            .joints
            .load(*id)
            .map_or(0.0, |load| load.force.length());
        println!("{name:16} {worst:12.1e} {force:30.1}");
    }
    picture(
        &simulation,
        "kinds",
        Vec3::new(9.0, 5.0, -4.0),
        Vec3::new(0.0, 2.2, 6.0),
    )
}

/// A ball on a chain that swings into a wall of bonded bricks.
fn crane() -> Result<(), Error> {
    let mut simulation = Simulation::default();
    let floor = HalfSpaceShape { normal: Vec3::Y };
    simulation.bodies.insert(BodyDesc::floor(floor))?;
    let mut bricks = Vec::new();
    for (row, column) in (0..8).flat_map(|row| (0..8).map(move |column| (row, column))) {
        let shift = 0.25 * (row % 2) as f32;
        let at = Vec3::new(
            0.8,
            0.125 + 0.25 * row as f32,
            0.5 * column as f32 - 1.75 + shift,
        );
        let brick = BodyDesc::dynamic(ConvexMesh::cuboid(0.25, 0.25, 0.5)?, at);
        bricks.push(simulation.bodies.insert(brick)?);
    }
    let bonds = simulation.bond_neighbors(&bricks, 2e4)?;
    // Level with the hook, so that it comes down with some speed.
    let hook = Vec3::new(0.0, 6.0, 0.0);
    let (mut last, mut ids) = (None, Vec::new());
    for i in 0..=9 {
        let is_ball = i == 9;
        let size = if is_ball {
            Vec3::splat(0.6)
        } else {
            Vec3::new(0.5, 0.08, 0.08)
        };
        let mut at = hook - (0.25 + 0.5 * i as f32) * Vec3::X;
        at.x -= if is_ball { 0.05 } else { 0.0 };
        let mass = if is_ball { 500.0 } else { 2.0 };
        let link = BodyDesc {
            density: mass / size.element_product(),
            ..BodyDesc::dynamic(ConvexMesh::cuboid(size.x, size.y, size.z)?, at)
        };
        let slot = simulation.bodies.insert(link)?;
        let right = Vec3::new(0.5 * size.x, 0.0, 0.0);
        let on_a = if last.is_some() {
            Vec3::new(-0.25, 0.0, 0.0)
        } else {
            hook
        };
        ids.push(simulation.join(last, slot, Joint::ball().with_anchors(on_a, right))?);
        last = Some(slot);
    }
    let mut worst = 0.0_f32;
    for step in 0..180 {
        simulation.step(H);
        for id in &ids {
            worst = worst.max(
                simulation
                    .joints
                    .load(*id)
                    .map_or(0.0, |load| load.error[0]),
            );
        }
        if [1, 80, 100, 179].contains(&step) {
            let name = format!("crane_{step:03}");
            picture(
                &simulation,
                &name,
                Vec3::new(5.0, 4.0, 11.0),
                Vec3::new(-0.5, 3.0, 0.0),
            )?;
        }
    }
    let broken = bonds - simulation.bonds.len();
    println!("crane: {broken} of {bonds} bonds broken, largest gap in the chain {worst:.1e} m");
    Ok(())
}

fn picture(simulation: &Simulation, name: &str, eye: Vec3, target: Vec3) -> Result<(), Error> {
    let mut scene = Scene::default();
    let bodies = &simulation.bodies;
    for slot in bodies.iter() {
        if let Some(mesh) = bodies.convex(slot) {
            let mesh = mesh.hull().to_mesh();
            scene.draw(&mesh, bodies.pose(slot), palette(slot as usize));
        }
    }
    let camera = Camera::look_at(eye, target, Vec3::Y, 50.0, 800, 640);
    scene.render(&camera).save(format!("{FOLDER}/{name}.png"))
}
