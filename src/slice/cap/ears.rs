//! A polygon to triangles, one ear after the other.
//!
//! # References
//! - G. H. Meisters, "Polygons Have Ears", American Mathematical Monthly 82(6), 1975.

use crate::slice::attributes::mean_vertex;
use crate::slice::cap::{Filler, edges};
use glam::DVec2;

/// A corner of a polygon and how the path turns there: left (`+1`), right (`-1`), or not (`0`).
#[derive(Clone, Copy, Debug)]
pub(crate) struct CornerTurn {
    corner: u32,
    turn: i32,
    /// Place in the plane's frame, m.
    point: DVec2,
}

/// How good an ear must be.
#[derive(Clone, Copy, Debug)]
enum Ear {
    /// With area, and no other corner in it or on its edge.
    Good,
    /// Without negative area, and no other corner inside.
    Flat,
    /// Anything.
    Any,
}

impl Filler<'_> {
    /// Cuts off one triangle after the other. Good ears first, then flat ones, then any that makes no edge twice.
    pub(super) fn clip_ears(&mut self, corners: impl Iterator<Item = u32>, orientation: f64) {
        let mut polygon = std::mem::take(&mut self.cap.polygon);
        polygon.clear();
        polygon.extend(corners.map(|corner| CornerTurn {
            corner,
            turn: 0,
            point: self.cap.point(corner),
        }));
        for place in 0..polygon.len() {
            self.update_turn(&mut polygon, place, orientation);
        }
        let mut start = 0;
        while polygon.len() > 3 {
            let ear = [Ear::Good, Ear::Flat, Ear::Any]
                .into_iter()
                .find_map(|kind| self.find_ear(&polygon, start, kind, orientation));
            let Some(ear) = ear else { break };
            let [a, b, c] = around(&polygon, ear);
            self.cap.triangles.push([a, b, c]);
            self.take(a, c);
            polygon.remove(ear);
            let n = polygon.len();
            self.update_turn(&mut polygon, (ear + n - 1) % n, orientation);
            self.update_turn(&mut polygon, ear % n, orientation);
            // Going on beyond the ear's neighbor spreads the ears around the loop, which keeps triangles from becoming
            // needles about one corner.
            start = (ear + 1) % n;
        }
        match polygon[..] {
            [
                CornerTurn { corner: a, .. },
                CornerTurn { corner: b, .. },
                CornerTurn { corner: c, .. },
            ] if a != b && b != c && c != a => {
                self.cap.triangles.push([a, b, c]);
            }
            _ => self.fill_by_centers(&polygon),
        }
        self.cap.polygon = polygon;
    }

    fn update_turn(&self, polygon: &mut [CornerTurn], place: usize, orientation: f64) {
        polygon[place].turn = self.cap.turn(around(polygon, place), orientation);
    }

    fn find_ear(
        &self,
        polygon: &[CornerTurn],
        start: usize,
        kind: Ear,
        orientation: f64,
    ) -> Option<usize> {
        let n = polygon.len();
        (0..n).map(|i| (start + i) % n).find(|&i| {
            let ear = around(polygon, i);
            ear[0] != ear[2]
                && self.is_ear(polygon, i, kind, orientation)
                && !self.is_taken(ear[0], ear[2])
        })
    }

    /// Whether the corner at `place` can be cut off.
    ///
    /// A loop that does not cross itself and reaches into a triangle of its neighbors has a corner there that is not
    /// convex, so only those are looked at.
    fn is_ear(&self, polygon: &[CornerTurn], place: usize, kind: Ear, orientation: f64) -> bool {
        match (kind, polygon[place].turn) {
            (Ear::Any, _) => return true,
            (Ear::Good, 1) | (Ear::Flat, 0 | 1) => {}
            (Ear::Good | Ear::Flat, _) => return false,
        }
        let ear = around(polygon, place);
        let [a, b, c] = ear.map(|corner| self.cap.point(corner));
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let side = |p: DVec2, q: DVec2, r: DVec2| orientation * (q - p).perp_dot(r - p);
        !polygon.iter().any(|other| {
            // First, because most corners of most loops are convex.
            if other.turn > 0 {
                return false;
            }
            let p = other.point;
            let is_near = p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y;
            if !is_near || ear.contains(&other.corner) {
                return false;
            }
            let inner = side(a, b, p).min(side(b, c, p)).min(side(c, a, p));
            match kind {
                Ear::Good => inner >= 0.0,
                Ear::Flat | Ear::Any => inner > 0.0,
            }
        })
    }

    /// The last resort: a new point in the middle of each simple loop of `polygon`, which no edge can have yet.
    fn fill_by_centers(&mut self, polygon: &[CornerTurn]) {
        let mut path: Vec<u32> = Vec::new();
        for &CornerTurn { corner, .. } in polygon {
            if let Some(place) = path.iter().position(|&c| c == corner) {
                let closed = path.split_off(place);
                self.fan_about_center(&closed);
            }
            path.push(corner);
        }
        self.fan_about_center(&path);
    }

    /// Joins all edges of a loop to a new point in its middle. Two edges that are each other's reverse need nothing.
    pub(super) fn fan_about_center(&mut self, ring: &[u32]) {
        if ring.len() < 3 {
            return;
        }
        let number = self.clip.topology_count;
        self.clip.topology_count += 1;
        let around = ring
            .iter()
            .map(|&corner| self.clip.find(self.mesh, self.cap.corners[corner as usize]));
        let mean = mean_vertex(around, number);
        let vertex = self.clip.old_vertices + self.clip.new.positions.len() as u32;
        mean.push_to(&mut self.clip.new);
        let center = self.cap.corners.len() as u32;
        self.add_corner(vertex, number);
        self.cap
            .triangles
            .extend(edges(ring).map(|(a, b)| [a, b, center]));
    }
}

/// The corners before, at and after `place`.
fn around(polygon: &[CornerTurn], place: usize) -> [u32; 3] {
    let n = polygon.len();
    let before = if place == 0 { n - 1 } else { place - 1 };
    let after = if place + 1 == n { 0 } else { place + 1 };
    [before, place, after].map(|i| polygon[i].corner)
}
