//! Random bodies that break, and what laws of different kinds ask of them.

use crate::common::dice::Dice;
pub(crate) use crate::common::scenes::{awake, awake_on_floor, energy, pattern};
use bevy_cleave::mass::VolumeIntegrals;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

pub(crate) const H: f32 = 1.0 / 60.0;

/// What a law found in a scene: how much there was to judge, or what is wrong.
pub(crate) type Verdict = Result<usize, String>;

/// Fails with a text unless something holds.
macro_rules! ask {
    ($holds:expr, $($text:tt)+) => {
        match $holds {
            true => {}
            false => return Err(format!($($text)+)),
        }
    };
}
pub(crate) use ask;

pub(crate) fn cuboid(size: Vec3) -> ConvexMesh {
    ConvexMesh::cuboid(size.x, size.y, size.z).expect("valid size")
}

/// A convex shape of some size, m: flat or round, or of points.
pub(crate) fn convex(dice: &mut Dice, size: f32) -> ConvexMesh {
    let [a, b, c] = [(); 3].map(|()| size * dice.in_range(0.3, 1.0));
    match dice.below(9) {
        0 | 1 => ConvexMesh::cuboid(a, b, c),
        2 => ConvexMesh::regular_prism(3 + dice.below(5) as u32, 0.5 * a, b),
        3 => ConvexMesh::wedge(a, b, c),
        4 => ConvexMesh::icosphere(0.5 * a, 1),
        5 => ConvexMesh::sphere(0.5 * a),
        6 => ConvexMesh::capsule(0.3 * a, b),
        7 => ConvexMesh::cylinder(0.5 * a, b),
        _ => {
            let points: Vec<Vec3> = (0..12)
                .map(|_| 0.5 * size * dice.vector(-1.0, 1.0))
                .collect();
            ConvexMesh::from_points(&points)
        }
    }
    .expect("valid sizes")
}

/// A hull with a smaller mesh in it that is drawn, of one part or of two.
pub(crate) fn with_visual(dice: &mut Dice, size: f32) -> ConvexMesh {
    let hull = cuboid(size * dice.vector(0.6, 1.0)).hull().clone();
    let drawn = ConvexMesh::icosphere(0.28 * size, 2).expect("a ball");
    let mut mesh = drawn.hull().to_mesh();
    if dice.below(2) == 0 {
        mesh = cuboid(0.5 * hull.aabb().extents()).hull().to_mesh();
    }
    let shape = ConvexMesh::from_parts(hull, Some(mesh));
    if dice.below(2) == 0 {
        shape.with_mass_of_visual()
    } else {
        shape
    }
}

/// Several convex parts in a row that overlap or lie apart a little, without bonds.
pub(crate) fn compound(dice: &mut Dice, size: f32) -> Compound {
    let count = 2 + dice.below(4);
    let parts = (0..count).map(|i| {
        let at = size * Vec3::new(0.5 * i as f32, dice.in_range(-0.1, 0.1), 0.0);
        (Pose::new(at, dice.rotation()), convex(dice, 0.6 * size))
    });
    let parts: Vec<_> = parts.collect();
    Compound::new(parts).expect("parts")
}

/// A convex body that was cut in advance and is held by bonds of `strength`, Pa.
pub(crate) fn cluster(dice: &mut Dice, size: f32, strength: f32) -> Compound {
    let sides = size * dice.vector(0.4, 1.0);
    let whole = match dice.below(3) {
        0 => ConvexMesh::regular_prism(6, 0.5 * sides.x, sides.y).expect("a prism"),
        _ => cuboid(sides),
    };
    let pattern = match dice.below(3) {
        0 => FracturePattern::Brick {
            size: sides / dice.in_range(1.6, 3.4),
        },
        1 => FracturePattern::Slabs {
            count: 2 + dice.below(5) as u8,
        },
        _ => FracturePattern::Voronoi {
            cells: 3 + dice.below(16) as u16,
            focus: 0.0,
        },
    };
    let seed = u64::from(dice.unit().to_bits());
    let cut = Cluster::cut(&whole, &pattern, seed, strength).expect("cells");
    cut.compound().expect("connected")
}

/// Breaks at `strength`, N s.
pub(crate) fn breakable(dice: &mut Dice, strength: f32) -> Fracturable {
    Fracturable {
        strength,
        pattern: pattern(dice),
        generations: 1 + dice.below(3) as u8,
        seed: u64::from(dice.unit().to_bits()),
        ..Default::default()
    }
}

/// A ball that flies at a point.
pub(crate) fn shot(dice: &mut Dice, target: Vec3, from: Vec3, mass: f32, speed: f32) -> BodyDesc {
    let radius = dice.in_range(0.05, 0.15);
    let shape = ConvexMesh::sphere(radius).expect("a ball");
    let volume = VolumeIntegrals::of_shape(&shape).volume as f32;
    BodyDesc {
        density: mass / volume,
        linear_velocity: speed * (target - from).normalize(),
        ..BodyDesc::dynamic(shape, from)
    }
}

pub(crate) fn in_space() -> Simulation {
    let mut simulation = awake();
    simulation.gravity = Gravity(Vec3::ZERO);
    simulation
}

/// Shapes of a body with their poses in the world.
pub(crate) fn hulls(bodies: &Bodies, slot: u32) -> Vec<(Pose, ConvexMesh)> {
    let pose = bodies.pose(slot);
    if let Some(compound) = bodies.compound(slot) {
        let parts = compound.parts().iter();
        return parts
            .map(|part| (pose * part.pose, part.shape.clone()))
            .collect();
    }
    let convex = bodies.convex(slot).map(|shape| (pose, shape.clone()));
    convex.into_iter().collect()
}

/// Corners of all hulls of a body, world, m.
pub(crate) fn corners(bodies: &Bodies, slot: u32) -> Vec<Vec3> {
    let hulls = hulls(bodies, slot).into_iter();
    hulls
        .flat_map(|(pose, shape)| {
            let corners = shape.hull().vertices().iter();
            corners
                .map(|&v| pose.transform_point(v))
                .collect::<Vec<_>>()
        })
        .collect()
}

pub(crate) fn is_solid(bodies: &Bodies, slot: u32) -> bool {
    bodies.convex(slot).is_some() || bodies.compound(slot).is_some()
}

/// Mass of all bodies with an inside, kg.
pub(crate) fn mass(bodies: &Bodies) -> f64 {
    let solid = bodies.iter().filter(|&slot| is_solid(bodies, slot));
    solid.map(|slot| f64::from(bodies.mass(slot).mass)).sum()
}

/// Checks what each fracture of the last step says of itself; the mass that was dropped, kg.
pub(crate) fn check_ledgers(simulation: &Simulation) -> Result<f64, String> {
    let mut dropped = 0.0;
    for fracture in &simulation.fractures.done {
        let ledger = &fracture.ledger;
        ask!(
            ledger.mass_error() < 1e-6,
            "mass error {:.1e}",
            ledger.mass_error()
        );
        let momentum = ledger.momentum_error();
        ask!(momentum < 1e-5, "momentum error {momentum:.1e}");
        dropped += ledger.dropped.mass;
    }
    Ok(dropped)
}

/// Bonds hold all parts of each cluster together, but for those that wait to come apart.
pub(crate) fn check_connected(simulation: &Simulation) -> Result<(), String> {
    let bodies = &simulation.bodies;
    for slot in bodies.iter() {
        let Some(shape) = bodies.compound(slot).filter(|it| it.is_bonded()) else {
            continue;
        };
        let groups = Cluster::from(shape).separated().len();
        ask!(groups == 1, "the cluster in {slot} is {groups} groups");
    }
    Ok(())
}

/// A body's mass, center and inertia are the sum over its parts.
pub(crate) fn check_mass_of_parts(bodies: &Bodies, slot: u32) -> Result<(), String> {
    let Some(compound) = bodies.compound(slot) else {
        return Ok(());
    };
    let sum = VolumeIntegrals::of_compound(compound);
    let density = f64::from(bodies.density(slot));
    let properties = bodies.mass(slot);
    let whole = sum.volume * density;
    let error = (f64::from(properties.mass) - whole).abs() / whole;
    ask!(
        error < 2e-6,
        "{slot}: mass {} of parts of {whole}",
        properties.mass
    );
    let off = (properties.center.as_dvec3() - sum.centroid).length();
    let size = f64::from(compound.aabb().diagonal());
    ask!(off < 1e-5 * size, "{slot}: center is {off} m off");
    let inertia = properties.inertia();
    let expected = (sum.inertia * density).as_mat3();
    let scale = properties.principal.max_element();
    let error = (inertia - expected).abs_diff_eq(glam::Mat3::ZERO, 1e-4 * scale);
    ask!(error, "{slot}: inertia {inertia} against {expected}");
    Ok(())
}

/// Has a static body be held by the lowest tenth of its box.
pub(crate) fn hold_foot(simulation: &mut Simulation, slot: u32, shape: &Compound) {
    let aabb = shape.aabb();
    let foot = Anchors::none().and_behind(Vec3::Y, aabb.min.y + 0.1 * aabb.extents().y);
    simulation
        .bodies
        .set_anchors(slot, Some(foot))
        .expect("usable");
}

pub(crate) fn turned(dice: &mut Dice, at: Vec3) -> Pose {
    Pose::new(
        at,
        if dice.below(2) == 0 {
            dice.rotation()
        } else {
            Quat::IDENTITY
        },
    )
}
