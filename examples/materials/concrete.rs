//! Concrete, as `docs/materials.md` quotes it.

use super::{Error, Vec3};
use bevy_cleave::prelude::*;

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
