//! How much new surface it takes to break a body into cells, and how many cells an energy pays for.
//!
//! A Poisson-Voronoi tessellation with `n` cells in a large volume `V` has cells of mean surface `5.821 (V / n)^(2/3)`.
//! Each wall is shared by two cells, so the walls have the area `2.91 V^(2/3) n^(1/3)`, less a part of the outer surface,
//! which was there before. For a box with edges `L_i` and cells of size `d = (V / n)^(1/3)` that is the sum over the three
//! directions of `(0.970 L_i / d - 0.8) V / L_i`: the walls across each direction, of which there is about one less than
//! cells. Not quite one, because cells at the surface of a body reach farther; 0.8 is what tessellations of cubes have.
//!
//! Written like that it also holds for plates and bars: a direction along which the body is thinner than a cell has no
//! walls across it and counts as one cell.
//!
//! # References
//! - A. Okabe, B. Boots, K. Sugihara, S. N. Chiu, *Spatial Tessellations: Concepts and Applications of Voronoi Diagrams*,
//!   2nd ed., 2000, section 5.5 (Poisson-Voronoi cells; the mean surface is `(256 pi / 3)^(1/3) Gamma(5/3)`).
//! - J. L. Meijering, "Interface area, edge length, and number of vertices in crystal aggregates with random nucleation",
//!   Philips Research Reports 8, 1953.

use crate::geometry::ConvexHull;
use crate::mass::{VolumeIntegrals, principal_axes};

/// Walls per cell along each direction: `5.821 / 6`.
const WALLS_PER_CELL: f64 = 0.970;

/// How many walls less there are along each direction than in a body without a surface.
const WALLS_AT_SURFACE: f64 = 0.8;

/// How the area of the walls between cells grows with their number, for one body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrackArea {
    /// Volume, m3.
    volume: f64,
    /// Edges of the box with the volume and the proportions of the body, m, in descending order.
    edges: [f64; 3],
}

impl CrackArea {
    /// For a body with this hull.
    ///
    /// The box has the ratios of the hull's second moments: those of a box with edge `L` are `V L^2 / 12`.
    pub fn of_hull(hull: &ConvexHull) -> Self {
        let integrals = VolumeIntegrals::of_hull(hull);
        let (inertia, _) = principal_axes(integrals.inertia);
        let half_trace = 0.5 * inertia.element_sum();
        let volume = integrals.volume;
        let mut edges = [inertia.x, inertia.y, inertia.z]
            .map(|moment| (12.0 * (half_trace - moment).max(0.0) / volume).sqrt());
        edges.sort_by(|a, b| b.total_cmp(a));
        let factor = cube_root(volume / (edges[0] * edges[1] * edges[2]));
        Self {
            volume,
            edges: edges.map(|edge| factor * edge),
        }
    }

    /// Area of the walls (m2) between cells of size `spacing` (m). Each makes two new faces of this area.
    pub fn walls(&self, spacing: f64) -> f64 {
        self.edges
            .iter()
            .map(|edge| (WALLS_PER_CELL * edge / spacing - WALLS_AT_SURFACE, edge))
            .map(|(count, edge)| count.max(0.0) * self.volume / edge)
            .sum()
    }

    /// Number of cells of size `spacing` (m).
    pub fn cells(&self, spacing: f64) -> f64 {
        self.edges
            .iter()
            .map(|edge| (edge / spacing).max(1.0))
            .product()
    }

    /// Size of the cells (m) whose walls have the area `walls` (m2), the inverse of [`walls`](Self::walls).
    ///
    /// The area is piecewise linear in `1 / spacing`; it grows faster once there are walls across another direction.
    pub fn spacing(&self, walls: f64) -> f64 {
        let mut sections = 0.0;
        let mut per_metre = f64::INFINITY;
        for (index, edge) in self.edges.iter().enumerate() {
            if WALLS_PER_CELL * edge * per_metre <= WALLS_AT_SURFACE {
                break;
            }
            sections += WALLS_AT_SURFACE * self.volume / edge;
            let slope = WALLS_PER_CELL * self.volume * (index + 1) as f64;
            per_metre = (walls + sections) / slope;
        }
        1.0 / per_metre
    }
}

/// How many cells of `hull` an impact makes that has `energy` (J) to spend on cracks, at `toughness` (J) per m2 of crack.
///
/// At least one: then nothing breaks. A toughness of zero or an energy without bounds gives the largest number there is.
pub fn cells_for_energy(energy: f64, toughness: f64, hull: &ConvexHull) -> u32 {
    let walls = energy / toughness;
    if walls.is_nan() || walls <= 0.0 {
        return 1;
    }
    let area = CrackArea::of_hull(hull);
    // The conversion saturates.
    (area.cells(area.spacing(walls)) as u32).max(1)
}

/// The cube root of a number near one, by Newton's method.
fn cube_root(number: f64) -> f64 {
    (0..40).fold(1.0, |x, _| (2.0 * x + number / (x * x)) / 3.0)
}
