//! Loops with holes: each hole is joined to the outer loop by a bridge, and what has become one polygon is clipped.

use crate::slice::cap::{Filler, Ring, edges};
use std::ops::Range;

impl Filler<'_> {
    /// Joins each hole to the outer loop, then clips ears of what has become one polygon.
    pub(super) fn fill_with_holes(
        &mut self,
        outer: &Range<usize>,
        holes: &mut [Ring],
        corners: &mut [u32],
    ) {
        let all = || holes.iter().map(|hole| &hole.corners).chain([outer]);
        for &corner in all().flat_map(|range| &corners[range.clone()]) {
            self.cap.shared[corner as usize] = true;
        }
        for (a, b) in all().flat_map(|range| edges(&corners[range.clone()])) {
            self.take(a, b);
        }
        for hole in &mut *holes {
            self.start_at_rightmost(&mut corners[hole.corners.clone()]);
        }
        let x = |hole: &Ring| self.cap.point(corners[hole.corners.start]).x;
        holes.sort_by(|a, b| x(b).total_cmp(&x(a)));
        let mut polygon = std::mem::take(&mut self.cap.joined);
        polygon.clear();
        polygon.extend_from_slice(&corners[outer.clone()]);
        for index in 0..holes.len() {
            let hole = &corners[holes[index].corners.clone()];
            let rest = holes[index..]
                .iter()
                .flat_map(|ring| edges(&corners[ring.corners.clone()]));
            if let Some((place, from)) = common_corner(&polygon, hole) {
                splice(&mut polygon, place, hole, from, false);
            } else if let Some(place) = self.bridge(&polygon, hole[0], rest) {
                self.take(polygon[place], hole[0]);
                splice(&mut polygon, place, hole, 0, true);
            } else {
                self.fill_ring(hole, -1.0);
            }
        }
        self.clip_ears(polygon.iter().copied(), 1.0);
        self.cap.joined = polygon;
    }

    fn start_at_rightmost(&self, hole: &mut [u32]) {
        let x = |place: &usize| self.cap.point(hole[*place]).x;
        let rightmost = (0..hole.len())
            .max_by(|a, b| x(a).total_cmp(&x(b)))
            .unwrap_or(0);
        hole.rotate_left(rightmost);
    }

    /// The place in `polygon` of the nearest corner that sees `target`, the first corner of a hole, past the edges of all
    /// holes to come; without one, the nearest to which an edge is free.
    fn bridge(
        &mut self,
        polygon: &[u32],
        target: u32,
        rest: impl Iterator<Item = (u32, u32)> + Clone,
    ) -> Option<usize> {
        let mut places = std::mem::take(&mut self.cap.places);
        places.clear();
        let is_free = |&place: &u32| !self.is_taken(polygon[place as usize], target);
        places.extend((0..polygon.len() as u32).filter(is_free));
        let to = self.cap.point(target);
        let distance = |place: u32| self.cap.point(polygon[place as usize]).distance_squared(to);
        places.sort_unstable_by(|&a, &b| distance(a).total_cmp(&distance(b)).then(a.cmp(&b)));
        let is_seen = |&place: &u32| {
            let place = place as usize;
            self.opens_towards(polygon, place, target)
                && self
                    .cap
                    .sees(polygon[place], target, edges(polygon).chain(rest.clone()))
        };
        let found = places
            .iter()
            .copied()
            .find(is_seen)
            .or(places.first().copied());
        self.cap.places = places;
        found.map(|place| place as usize)
    }

    /// Whether the direction to `target` lies inside the polygon's angle at `place`.
    fn opens_towards(&self, polygon: &[u32], place: usize, target: u32) -> bool {
        let n = polygon.len();
        let (before, at, after) = (
            polygon[(place + n - 1) % n],
            polygon[place],
            polygon[(place + 1) % n],
        );
        let left_of_out = self.cap.twice_area([at, after, target]) > 0.0;
        let left_of_in = self.cap.twice_area([before, at, target]) > 0.0;
        if self.cap.twice_area([before, at, after]) >= 0.0 {
            left_of_in && left_of_out
        } else {
            left_of_in || left_of_out
        }
    }
}

/// Places of a corner that both loops have.
fn common_corner(polygon: &[u32], hole: &[u32]) -> Option<(usize, usize)> {
    hole.iter().enumerate().find_map(|(from, corner)| {
        let place = polygon.iter().position(|c| c == corner)?;
        Some((place, from))
    })
}

/// Inserts `hole`, starting at its place `from`, after `place` of `polygon`. With a bridge the walk goes there and back;
/// without, the two places are the same corner.
fn splice(polygon: &mut Vec<u32>, place: usize, hole: &[u32], from: usize, bridged: bool) {
    let first = usize::from(!bridged);
    let around = (first..hole.len()).map(|i| hole[(from + i) % hole.len()]);
    let back = bridged.then_some(hole[from]).into_iter();
    let detour = around.chain(back).chain([polygon[place]]);
    polygon.splice(place + 1..place + 1, detour);
}
