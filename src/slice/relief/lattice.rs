//! Triangles of one size that cover a part of a plane.
//!
//! Nodes are in rows; every second row is shifted by half a spacing. Numbers go along the rows.

use crate::math::{Plane, tangents};
use glam::{DVec2, DVec3};

/// Most nodes of a lattice; a larger face has larger triangles.
const MAX_NODES: f64 = 16_384.0;

/// Distance of two rows in spacings: the height of an equilateral triangle, sqrt(3) / 2.
const ROW: f64 = 0.866_025_403_784_438_6;

/// A lattice over a part of a plane.
#[derive(Clone, Debug)]
pub(super) struct Lattice {
    /// Of node 0, m.
    origin: DVec3,
    /// Unit vectors along and across the rows; with the normal a right-handed frame.
    axes: [DVec3; 2],
    pub(super) normal: DVec3,
    /// Length of an edge, m.
    pub(super) spacing: f64,
    columns: usize,
    rows: usize,
}

impl Lattice {
    /// A lattice with edges of `spacing` (m), or longer ones, that reaches beyond all points by an edge.
    pub(super) fn covering(
        plane: &Plane,
        points: impl Iterator<Item = DVec3>,
        spacing: f64,
    ) -> Self {
        let normal = plane.normal.as_dvec3().normalize();
        let along = tangents(plane.normal)[0].as_dvec3();
        let along = (along - along.dot(normal) * normal).normalize();
        let axes = [along, normal.cross(along)];
        let (low, high) = points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
            let flat = DVec2::from(axes.map(|axis| axis.dot(p)));
            (low.min(flat), high.max(flat))
        });
        let extents = (high - low).max(DVec2::ZERO);
        // The box of the points has at most so many nodes; the frame around it adds few.
        let finest = (extents.x * extents.y / (ROW * MAX_NODES)).sqrt();
        let longest = extents.max_element() / MAX_NODES;
        let spacing = spacing.max(finest).max(longest);
        let corner = low - DVec2::splat(spacing);
        let count = |extent: f64, step: f64| ((extent + 2.0 * spacing) / step).ceil() as usize + 2;
        let height = f64::from(plane.offset) / f64::from(plane.normal.length());
        Self {
            origin: height * normal + corner.x * axes[0] + corner.y * axes[1],
            axes,
            normal,
            spacing,
            columns: count(extents.x, spacing),
            rows: count(extents.y, ROW * spacing),
        }
    }

    /// Number of nodes.
    pub(super) fn len(&self) -> usize {
        self.columns * self.rows
    }

    /// Coordinates of a point in the plane from node 0 on, m.
    pub(super) fn flat(&self, point: DVec3) -> DVec2 {
        DVec2::from(self.axes.map(|axis| axis.dot(point - self.origin)))
    }

    /// Distance of a point from the plane, m.
    pub(super) fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point - self.origin)
    }

    /// Coordinates of a node, m.
    pub(super) fn flat_node(&self, node: u32) -> DVec2 {
        let (row, column) = self.row_column(node);
        let shift = 0.5 * (row % 2) as f64;
        self.spacing * DVec2::new(column as f64 + shift, ROW * row as f64)
    }

    /// The place of a node moved by a height along the normal, m.
    pub(super) fn place(&self, node: u32, height: f64) -> DVec3 {
        let flat = self.flat_node(node);
        self.origin + flat.x * self.axes[0] + flat.y * self.axes[1] + height * self.normal
    }

    fn row_column(&self, node: u32) -> (usize, usize) {
        (node as usize / self.columns, node as usize % self.columns)
    }

    /// The nodes in a box of coordinates, m.
    pub(super) fn nodes_within(&self, low: DVec2, high: DVec2) -> impl Iterator<Item = u32> + '_ {
        let clamp = |value: f64, count: usize| (value.max(0.0) as usize).min(count);
        let step = ROW * self.spacing;
        let rows = clamp((low.y / step).ceil(), self.rows)..clamp(high.y / step + 1.0, self.rows);
        rows.flat_map(move |row| {
            let shift = 0.5 * (row % 2) as f64;
            let first = clamp((low.x / self.spacing - shift).ceil(), self.columns);
            let end = (high.x / self.spacing - shift).floor() + 1.0;
            let end = clamp(end, self.columns).max(first);
            (first..end).map(move |column| (row * self.columns + column) as u32)
        })
    }

    /// The six nodes around one that is not on the rim of the lattice, with the directions to them as coordinates.
    pub(super) fn around(&self, node: u32) -> [(u32, DVec2); 6] {
        let width = self.columns as u32;
        let odd = (self.row_column(node).0 % 2) as u32;
        let (up, down) = (node + width + odd, node - width + odd);
        [
            (node + 1, DVec2::new(1.0, 0.0)),
            (up, DVec2::new(0.5, ROW)),
            (up - 1, DVec2::new(-0.5, ROW)),
            (node - 1, DVec2::new(-1.0, 0.0)),
            (down - 1, DVec2::new(-0.5, -ROW)),
            (down, DVec2::new(0.5, -ROW)),
        ]
    }

    /// Whether a node has six around it.
    pub(super) fn is_inner(&self, node: u32) -> bool {
        let (row, column) = self.row_column(node);
        (1..self.rows - 1).contains(&row) && (1..self.columns - 1).contains(&column)
    }

    /// All triangles, counter-clockwise seen from where the normal points.
    pub(super) fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        let width = self.columns as u32;
        (0..self.rows as u32 - 1).flat_map(move |row| {
            (0..width - 1).flat_map(move |column| {
                let low = row * width + column;
                let high = low + width;
                if row % 2 == 0 {
                    [[low, low + 1, high], [low + 1, high + 1, high]]
                } else {
                    [[low, low + 1, high + 1], [low, high + 1, high]]
                }
            })
        })
    }

    /// The unit normal of the surface over a node, from the heights of those around: the least-squares slope `g` is a third of the sum of heights
    /// times directions over the spacing, and the normal is along `n - g`.
    pub(super) fn normal_at(&self, node: u32, heights: &[f64]) -> DVec3 {
        let around = self.around(node);
        let sum: DVec2 = around
            .iter()
            .map(|&(other, direction)| heights[other as usize] * direction)
            .sum();
        let slope = sum / (3.0 * self.spacing);
        (self.normal - slope.x * self.axes[0] - slope.y * self.axes[1]).normalize()
    }
}
