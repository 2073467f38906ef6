//! Clusters: in a heap, and a wall of many parts beside it.

use crate::heaps::{ASIDE, H, beside, cluster, every_second, heap, insert, plain, run, step};
use crate::pair::{Pair, Row};
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Of a brick, m.
const BRICK: Vec3 = Vec3::new(0.25, 0.1, 0.12);

/// The heap, half of which is of two parts with a bond.
fn bonded() -> Simulation {
    let change = every_second(Shape::Compound(cluster()));
    heap(&change, SolverConfig::default())
}

/// A wall of 500 bricks that stands.
fn wall() -> BodyDesc {
    let size = BRICK * Vec3::new(20.0, 25.0, 1.0);
    let whole = ConvexMesh::cuboid(size.x, size.y, size.z).expect("valid size");
    let bricks = Cluster::cut(&whole, &FracturePattern::Brick { size: BRICK }, 1, 1e6);
    let shape = bricks.and_then(|it| Ok(it.compound()?)).expect("usable");
    BodyDesc {
        pose: Pose::from_position(ASIDE + 0.5 * size.y * Vec3::Y),
        ..BodyDesc::new(RigidBody::Static, Shape::Compound(shape))
    }
}

/// The heap beside a wall, and the same with an explosion at the wall in each step that breaks nothing of it.
fn besieged() -> Pair {
    let scene = || {
        let mut simulation = plain();
        insert(&mut simulation, wall());
        run(&mut simulation, 10);
        simulation
    };
    let mut simulation = scene();
    let explosion = Explosion {
        center: ASIDE + Vec3::new(0.5, 1.0, 0.5),
        radius: 1.0,
        impulse: 1e-3,
    };
    let with = Box::new(move || {
        simulation.bodies.explode(explosion).expect("usable");
        simulation.step(H);
    });
    Pair::new(step(scene()), with)
}

pub(crate) fn rows() -> Vec<Row> {
    let row = |difference, make| Row::new("Clusters", difference, make);
    vec![
        row(
            "half of them wear out, without: two parts with a bond",
            || {
                let mut worn = bonded();
                for slot in 1..worn.bodies.slots() as u32 {
                    let fatigue = worn.bodies.compound(slot).map(|_| Fatigue::new(1e9));
                    worn.bodies.set_fatigue(slot, fatigue).expect("usable");
                }
                Pair::new(step(bonded()), step(worn))
            },
        ),
        row("a wall of 500 bricks aside, which stands", || {
            beside(|s| {
                insert(s, wall());
            })
        }),
        row(
            "an explosion at that wall in each step, without: the wall",
            besieged,
        ),
    ]
}
