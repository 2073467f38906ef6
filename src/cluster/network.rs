//! `Network`: the parts of a cluster and its bonds as masses and springs.

use crate::geometry::{Compound, PartBond};
use crate::mass::{MassError, MassProperties, VolumeIntegrals};
use crate::math::outer;
use glam::{DMat3, DVec3, Mat3, Vec3};

/// How far a bond that bears all it can may open or slide before it is broken, as a share of the smaller body's or part's least
/// extent. The energy that breaking takes is strength times area times this way.
pub const BREAKING_SHARE: f32 = 1e-3;

/// A part as a rigid body, frame of the compound.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    /// kg.
    pub(crate) mass: f64,
    /// Center of mass, m.
    pub(crate) center: DVec3,
    /// Inertia about it, kg m2.
    pub(crate) inertia: DMat3,
    /// Its inverse.
    pub(crate) inverse_inertia: Mat3,
}

/// The parts of a cluster and what holds them together.
#[derive(Clone, Debug)]
pub(crate) struct Network {
    pub(crate) nodes: Vec<Node>,
    pub(crate) bonds: Vec<PartBond>,
    /// By bond: how far it opens before it is broken, m.
    pub(crate) openings: Vec<f32>,
    /// By part: where its bonds begin in `bonds_of`; behind the last one, where they end.
    starts: Vec<u32>,
    bonds_of: Vec<u32>,
    /// Coefficient of friction between its parts.
    pub(crate) friction: f32,
    /// The longest lever there is, m.
    reach: f64,
    /// Energy that it takes to break the bond that takes least, J. What has less breaks nothing.
    pub(crate) least_energy: f32,
    /// Forces that together are less than this one break no bond, N: along the longest lever there is.
    pub(crate) least_force: f64,
}

impl Network {
    /// Of a compound whose parts are held by bonds.
    ///
    /// # Errors
    /// [`MassError`] if a part has no usable mass.
    pub(crate) fn new(compound: &Compound, density: f32, friction: f32) -> Result<Self, MassError> {
        let nodes = compound.parts().iter().map(|part| {
            let integrals = VolumeIntegrals::of_shape(&part.shape).seen_from(&part.pose);
            let inertia = integrals.inertia * f64::from(density);
            let mass = integrals.volume * f64::from(density);
            if !(mass > 0.0 && mass.is_finite()) {
                // Says what is wrong.
                MassProperties::from_integrals(&integrals, density)?;
            }
            Ok(Node {
                mass,
                center: integrals.centroid,
                inertia,
                inverse_inertia: inertia.inverse().as_mat3(),
            })
        });
        let nodes = nodes.collect::<Result<Vec<_>, MassError>>()?;
        let bonds = compound.bonds().to_vec();
        let extent = |part: u32| {
            let shape = &compound.parts()[part as usize].shape;
            shape.aabb().extents().min_element()
        };
        let opening = |bond: &PartBond| {
            let [a, b] = bond.parts.map(extent);
            BREAKING_SHARE * a.min(b)
        };
        let openings: Vec<f32> = bonds.iter().map(opening).collect();
        let reach = f64::from(compound.aabb().diagonal());
        let (starts, bonds_of) = adjacency(nodes.len(), &bonds);
        let mut network = Self {
            nodes,
            bonds,
            openings,
            starts,
            bonds_of,
            friction,
            reach,
            least_energy: 0.0,
            least_force: 0.0,
        };
        network.find_weakest();
        Ok(network)
    }

    /// Takes over how far its bonds are worn, which are as many as they were.
    pub(crate) fn wear(&mut self, bonds: &[PartBond]) {
        self.bonds.copy_from_slice(bonds);
        self.find_weakest();
    }

    /// What it takes at least to break a bond.
    fn find_weakest(&mut self) {
        let weaker = |bond: &PartBond| {
            let [tension, shear] = bond.strengths();
            tension.min(shear) * bond.area
        };
        let energies = self.bonds.iter().zip(&self.openings);
        let energies = energies.map(|(bond, opening)| weaker(bond) * opening);
        let force = |bond: &PartBond| {
            let side = f64::from(bond.half_extents.min_element());
            let per_area = 1.0 + 6.0 * self.reach / side;
            f64::from(weaker(bond)) / per_area
        };
        let forces = self.bonds.iter().map(force);
        (self.least_energy, self.least_force) = (
            energies.fold(f32::INFINITY, f32::min),
            forces.fold(f64::INFINITY, f64::min),
        );
    }

    /// Mass, center of mass and inertia about it of some of the parts.
    pub(super) fn sum(&self, parts: impl Iterator<Item = u32> + Clone) -> (f64, DVec3, DMat3) {
        let nodes = || parts.clone().map(|part| &self.nodes[part as usize]);
        let mass: f64 = nodes().map(|node| node.mass).sum();
        let first: DVec3 = nodes().map(|node| node.mass * node.center).sum();
        let center = first / mass;
        let inertia = nodes().map(|node| {
            let arm = node.center - center;
            let square = DMat3::from_diagonal(DVec3::splat(arm.length_squared()));
            node.inertia + (square - outer(arm, arm)) * node.mass
        });
        let inertia = inertia.fold(DMat3::ZERO, |sum, own| sum + own);
        (mass, center, inertia)
    }

    /// The bonds of a part.
    pub(crate) fn bonds_of(&self, part: u32) -> &[u32] {
        let [first, end] = [0, 1].map(|next| self.starts[part as usize + next] as usize);
        &self.bonds_of[first..end]
    }

    /// What a bond of a part leads to.
    pub(crate) fn other(&self, bond: u32, part: u32) -> u32 {
        let [a, b] = self.bonds[bond as usize].parts;
        if a == part { b } else { a }
    }

    /// The corners of the face of a bond, m.
    pub(crate) fn corners(bond: &PartBond) -> [Vec3; 4] {
        let across = bond.normal.cross(bond.axis);
        let (u, v) = (
            bond.half_extents.x * bond.axis,
            bond.half_extents.y * across,
        );
        [u + v, u - v, -u - v, v - u].map(|way| bond.center + way)
    }
}

/// Bonds by part.
fn adjacency(parts: usize, bonds: &[PartBond]) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0u32; parts + 1];
    for part in bonds.iter().flat_map(|bond| bond.parts) {
        starts[part as usize + 1] += 1;
    }
    for part in 0..parts {
        starts[part + 1] += starts[part];
    }
    let mut next = starts.clone();
    let mut bonds_of = vec![0; 2 * bonds.len()];
    for (index, bond) in (0..).zip(bonds) {
        for part in bond.parts {
            let at = &mut next[part as usize];
            bonds_of[*at as usize] = index;
            *at += 1;
        }
    }
    (starts, bonds_of)
}
