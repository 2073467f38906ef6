//! How far the faces on one plane are moved off it, node by node: the same for both sides of the crack.

use crate::geometry::TriMesh;
use crate::geometry::triangle_distance::nearest_on_triangle;
use crate::slice::relief::lattice::Lattice;
use crate::slice::relief::noise;
use crate::slice::relief::settings::Relief;
use glam::{DVec2, DVec3};

/// Width of the rim that stays flat, in spacings. More than one, so that all triangles of a moved node are inside of the face.
const RIM: f64 = 1.25;

/// Share of a square of a distance that it has in spite of rounding.
const CERTAIN: f64 = 1.0 - 1e-9;

/// The heights over the nodes of a lattice.
#[derive(Clone, Debug)]
pub(super) struct Heights {
    /// Distance to what else bounds the pieces on this plane, as far as it matters, m.
    room: Vec<f64>,
    /// Farthest distance that matters, m.
    reach: f64,
    /// m.
    pub(super) over: Vec<f64>,
}

impl Heights {
    pub(super) fn new(lattice: &Lattice, relief: &Relief) -> Self {
        let reach = RIM * lattice.spacing + 2.0 * f64::from(relief.amplitude);
        Self {
            room: vec![reach; lattice.len()],
            reach,
            over: Vec::new(),
        }
    }

    /// Takes note of a triangle of a piece that is on no face of this plane.
    pub(super) fn keep_off(&mut self, lattice: &Lattice, corners: [DVec3; 3]) {
        let heights = corners.map(|p| lattice.height(p));
        let low = heights.into_iter().fold(f64::INFINITY, f64::min);
        let high = heights.into_iter().fold(f64::NEG_INFINITY, f64::max);
        if low > self.reach || high < -self.reach {
            return;
        }
        // How far the plane is from all of the triangle.
        let apart = low.max(-high).max(0.0);
        let flat = corners.map(|p| lattice.flat(p));
        let low = flat[0].min(flat[1]).min(flat[2]);
        let high = flat[0].max(flat[1]).max(flat[2]);
        let around = DVec2::splat(self.reach);
        let rim = RIM * lattice.spacing;
        for node in lattice.nodes_within(low - around, high + around) {
            let room = &mut self.room[node as usize];
            let flat = lattice.flat_node(node);
            let beside = (low - flat).max(flat - high).max(DVec2::ZERO);
            // Nothing nearer than the triangle's box is; and what is on the rim does not move, however near something is.
            let least = beside.length_squared() + apart * apart;
            if *room <= rim || least * CERTAIN > *room * *room {
                continue;
            }
            let place = lattice.place(node, 0.0);
            *room = room.min(place.distance(nearest_on_triangle(corners, place)));
        }
    }

    /// Whether a node is far enough from all rims to be moved.
    pub(super) fn is_moved(&self, lattice: &Lattice, node: u32) -> bool {
        self.room[node as usize] > RIM * lattice.spacing && lattice.is_inner(node)
    }

    /// Finds the heights. None is more than half of the room beyond the rim, so that two faces of one piece, whatever their angle and
    /// distance, keep to their own sides of the middle between them.
    pub(super) fn find(&mut self, lattice: &Lattice, relief: &Relief, seed: u64) {
        let amplitude = f64::from(relief.amplitude);
        let scale = 1.0 / f64::from(relief.wavelength);
        let nodes = 0..lattice.len() as u32;
        let height = |node: u32| {
            if !self.is_moved(lattice, node) {
                return 0.0;
            }
            let spare = 0.5 * (self.room[node as usize] - RIM * lattice.spacing);
            amplitude.min(spare) * noise::height(scale * lattice.place(node, 0.0), seed)
        };
        self.over = nodes.map(height).collect();
    }
}

/// The corners of a triangle of a mesh, m.
pub(super) fn corners_of(mesh: &TriMesh, triangle: u32) -> [DVec3; 3] {
    mesh.triangles[triangle as usize].map(|v| mesh.positions[v as usize].as_dvec3())
}
