//! The materials of `docs/materials.md`: each constructor here is quoted there.

use crate::support::Error;
use bevy_cleave::prelude::*;
use bevy_cleave::step::Simulation;
use glam::Vec3;

/// Of a window pane, about 1 cm thick. Density 2500 kg/m3.
pub(crate) fn glass() -> Fracturable {
    Fracturable {
        strength: 20.0,
        pattern: FracturePattern::Radial { rays: 16, rings: 8 },
        toughness: 8.0,
        max_pieces: 144,
        min_volume: 1e-7,
        generations: 0,
        ..Fracturable::default()
    }
}

/// Of a clay brick. Density 1900 kg/m3.
pub(crate) fn brick(seed: u64) -> Fracturable {
    Fracturable {
        strength: 12.0,
        min_energy: 60.0,
        pattern: FracturePattern::Voronoi {
            cells: 9,
            focus: 0.3,
        },
        toughness: 80.0,
        max_pieces: 9,
        min_volume: 1e-6,
        generations: 1,
        seed,
        ..Fracturable::default()
    }
}

/// What mortar bears in tension and in shear, Pa.
pub(crate) const MORTAR: f32 = 3.0e5;

/// Lays mortar into all joints of a wall; the number of joints.
pub(crate) fn lay(simulation: &mut Simulation, bricks: &[u32]) -> Result<usize, BondError> {
    simulation.bond_neighbors(bricks, MORTAR)
}

/// Of a lath of pine, the grain along its longest side: it breaks across, and not easily. Density 450 kg/m3.
pub(crate) fn lath(seed: u64) -> Fracturable {
    Fracturable {
        strength: 60.0,
        min_energy: 150.0,
        pattern: FracturePattern::Slabs { count: 2 },
        toughness: 1.0e4,
        max_pieces: 2,
        generations: 2,
        seed,
        ..Fracturable::default()
    }
}

/// Glues the laths of a beam side by side: along the grain, wood splits at a fraction of what breaks it across.
pub(crate) fn grow(simulation: &mut Simulation, laths: &[u32]) -> Result<(), BondError> {
    let (tension_across, shear_along) = (2.5e6, 7.0e6);
    simulation.bond_neighbors(laths, tension_across)?;
    let made = simulation.bonds.iter();
    let made: Vec<_> = made.map(|(slots, bond)| (slots, *bond)).collect();
    for ([a, b], bond) in made {
        let grown = Bond {
            shear_strength: shear_along,
            ..bond
        };
        simulation.bond(a, b, grown)?;
    }
    Ok(())
}

/// Of a boulder of granite. Density 2650 kg/m3.
pub(crate) fn stone() -> Fracturable {
    Fracturable {
        strength: 2000.0,
        min_energy: 1500.0,
        pattern: FracturePattern::Voronoi {
            cells: 24,
            focus: 0.5,
        },
        toughness: 100.0,
        max_pieces: 24,
        min_volume: 1e-4,
        generations: 1,
        seed: 5,
        cut_relief: Some(Relief {
            amplitude: 0.02,
            wavelength: 0.07,
        }),
        ..Fracturable::default()
    }
}

/// What concrete bears in tension and in shear, Pa. Density 2400 kg/m3.
pub(crate) const CONCRETE: f32 = 2.0e6;

/// Thickness of a bar of steel, m.
pub(crate) const BAR: f32 = 0.024;

/// A wall of concrete about the middle of its frame, cast around a grid of bars: lumps in front and behind, and fillings between the bars; and
/// the bars.
pub(crate) fn concrete(size: Vec3, spacing: f32) -> Result<(Cluster, Vec<CompoundPart>), Error> {
    let depth = 0.5 * size.z - BAR;
    let leaf = ConvexMesh::cuboid(size.x, size.y, depth)?;
    let lumps = FracturePattern::EvenVoronoi { cells: 160 };
    let relief = Relief::of_size(0.05);
    let (mut parts, mut bars) = (Vec::new(), Vec::new());
    for side in [-1.0, 1.0] {
        let seed = u64::from(side > 0.0);
        let lumps = Cluster::cut_rough(&leaf, &lumps, seed, CONCRETE, relief)?;
        let out = side * (0.5 * depth + BAR) * Vec3::Z;
        let lumps = lumps.parts.into_iter();
        parts.extend(lumps.map(|part| CompoundPart::new(Pose::from_position(out), part.shape)));
    }
    for (across, along, side) in [(Vec3::X, Vec3::Y, -0.5), (Vec3::Y, Vec3::X, 0.5)] {
        let (width, length) = (size.dot(across), size.dot(along));
        let count = (width / spacing).round();
        let step = width / count;
        for row in 0..count as u16 {
            let at = (f32::from(row) + 0.5) * step - 0.5 * width;
            let put = |to: &mut Vec<CompoundPart>, at: [f32; 2], size: [f32; 2]| {
                let size = size[0] * across + size[1] * along + BAR * Vec3::Z;
                let shape = ConvexMesh::cuboid(size.x, size.y, size.z)?;
                let at = at[0] * across + at[1] * along + side * BAR * Vec3::Z;
                to.push(CompoundPart::new(Pose::from_position(at), shape));
                Ok::<(), Error>(())
            };
            put(&mut bars, [at, 0.0], [BAR, length])?;
            let pieces = (length / spacing).round();
            let long = length / pieces;
            for piece in 0..pieces as u16 {
                let along = (f32::from(piece) + 0.5) * long - 0.5 * length;
                let filling = 0.5 * (step - BAR);
                for beside in [-0.5, 0.5] {
                    put(
                        &mut parts,
                        [at + beside * (filling + BAR), along],
                        [filling, long],
                    )?;
                }
            }
        }
    }
    Ok((Cluster::new(parts, CONCRETE)?, bars))
}
