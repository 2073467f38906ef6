//! Clusters that several tests take.

use bevy_cleave::prelude::*;
use glam::Vec3;

/// A row of cubes (m) along x, from the origin on.
pub(crate) fn row(count: usize, size: Vec3, strength: f32) -> Compound {
    let brick = ConvexMesh::cuboid(size.x, size.y, size.z).expect("a box");
    let at = |i: usize| Pose::from_position(Vec3::X * size.x * (i as f32 + 0.5));
    let parts = (0..count).map(|i| (at(i), brick.clone()));
    Cluster::new(parts, strength)
        .and_then(|cluster| Ok(cluster.compound()?))
        .expect("a row")
}

/// A wall of bricks (0.25 by 0.1 by 0.12 m) in courses, every second one shifted by half a brick; its foot is in the plane y = 0.
pub(crate) fn wall(bricks: usize, courses: usize, strength: f32) -> Compound {
    let (x, y, z) = (0.25, 0.1, 0.12);
    let size = Vec3::new(x * bricks as f32, y * courses as f32, z);
    let whole = ConvexMesh::cuboid(size.x, size.y, size.z).expect("a box");
    let pattern = FracturePattern::Brick {
        size: Vec3::new(x, y, z),
    };
    let cluster = Cluster::cut(&whole, &pattern, 1, strength).expect("bricks");
    let compound = cluster.compound().expect("one wall");
    // From the middle to the foot.
    let lift = Vec3::Y * 0.5 * size.y;
    let parts = compound.parts().iter().map(|part| {
        let pose = Pose::new(part.pose.position + lift, part.pose.rotation);
        CompoundPart::new(pose, part.shape.clone())
    });
    let bonds = compound.bonds().iter().map(|bond| PartBond {
        center: bond.center + lift,
        ..*bond
    });
    let lifted = Compound::new(parts).expect("parts");
    lifted
        .with_bonds(bonds.collect::<Vec<_>>())
        .expect("one wall")
}

/// A static body.
pub(crate) fn standing(shape: Compound) -> BodyDesc {
    BodyDesc::new(RigidBody::Static, Shape::Compound(shape))
}

/// Number of parts of the body in a slot.
pub(crate) fn parts_of(simulation: &Simulation, slot: u32) -> usize {
    simulation.bodies.compound(slot).map_or(1, Compound::len)
}

/// A ball that flies.
pub(crate) fn ball(radius: f32, density: f32, at: Vec3, velocity: Vec3) -> BodyDesc {
    let shape = ConvexMesh::sphere(radius).expect("a ball");
    BodyDesc {
        linear_velocity: velocity,
        density,
        ..BodyDesc::dynamic(shape, at)
    }
}
