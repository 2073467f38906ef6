//! The materials of `docs/materials.md`: each constructor here is quoted there. The playground in `demo/` has them from here, too, so that they use
//! nothing but the crate.

use bevy_cleave::prelude::*;
use bevy_cleave::step::Simulation;

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
