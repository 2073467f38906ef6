//! Up to four corners of the difference of two convex shapes, and the point of their hull that is nearest to the origin.

use glam::DVec3;

/// A corner of the difference B - A.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Corner {
    on_a: DVec3,
    on_b: DVec3,
    /// From the one to the other.
    pub(crate) apart: DVec3,
}

impl Corner {
    pub(crate) fn new(on_a: DVec3, on_b: DVec3) -> Self {
        Self {
            on_a,
            on_b,
            apart: on_b - on_a,
        }
    }
}

/// Corners with weights: the nearest point is their weighted sum.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Simplex {
    corners: [Corner; 4],
    weights: [f64; 4],
    count: usize,
}

impl Simplex {
    pub(crate) fn new(corner: Corner) -> Self {
        Self {
            corners: [corner; 4],
            weights: [1.0, 0.0, 0.0, 0.0],
            count: 1,
        }
    }

    /// The point nearest to the origin.
    pub(crate) fn nearest(&self) -> DVec3 {
        self.sum(|corner| corner.apart)
    }

    /// The point of A that it comes from.
    pub(crate) fn point_on_a(&self) -> DVec3 {
        self.sum(|corner| corner.on_a)
    }

    fn sum(&self, of: impl Fn(&Corner) -> DVec3) -> DVec3 {
        let parts = self.corners.iter().zip(self.weights).take(self.count);
        parts.map(|(corner, weight)| weight * of(corner)).sum()
    }

    /// Whether the origin is inside.
    pub(crate) fn is_full(&self) -> bool {
        self.count == 4
    }

    /// Largest coordinate of a corner, m.
    pub(crate) fn extent(&self) -> f64 {
        let largest = |corner: &Corner| corner.on_a.abs().max(corner.on_b.abs()).max_element();
        let corners = self.corners[..self.count].iter();
        corners.map(largest).fold(0.0, f64::max)
    }

    pub(crate) fn has(&self, corner: &Corner) -> bool {
        self.corners[..self.count].contains(corner)
    }

    /// Adds a corner and drops those that the nearest point does not need; false, and nothing changes, if that brings it no nearer.
    pub(crate) fn add(&mut self, corner: Corner) -> bool {
        let before = self.nearest().length_squared();
        let mut at = self.corners.map(|corner| corner.apart);
        let count = self.count + 1;
        at[count - 1] = corner.apart;
        let weights = match count {
            2 => on_segment([at[0], at[1]]).to_vec4(),
            3 => on_triangle([at[0], at[1], at[2]]).to_vec4(),
            _ => on_tetrahedron(at),
        };
        let needed = || (0..count).filter(|&i| weights[i] > 0.0);
        let nearest: DVec3 = needed().map(|i| weights[i] * at[i]).sum();
        let is_nearer = needed().count() == 4 || nearest.length_squared() < before;
        if !is_nearer {
            return false;
        }
        self.corners[count - 1] = corner;
        self.count = 0;
        for i in needed() {
            self.corners[self.count] = self.corners[i];
            self.weights[self.count] = weights[i];
            self.count += 1;
        }
        true
    }

    /// The same where B has moved by `by` (m): still corners of the difference, of which the nearest point is another.
    pub(crate) fn moved(&self, by: DVec3) -> Self {
        let moved = |corner: Corner| Corner::new(corner.on_a, corner.on_b + by);
        let mut simplex = Self::new(moved(self.corners[0]));
        for &corner in &self.corners[1..self.count] {
            simplex.add(moved(corner));
        }
        simplex
    }
}

/// Weights of fewer corners, filled up with nothing.
trait Weights {
    fn to_vec4(self) -> [f64; 4];
}

impl<const N: usize> Weights for [f64; N] {
    fn to_vec4(self) -> [f64; 4] {
        let mut all = [0.0; 4];
        all[..N].copy_from_slice(&self);
        all
    }
}

fn on_segment([a, b]: [DVec3; 2]) -> [f64; 2] {
    let along = b - a;
    let share = -a.dot(along) / along.length_squared();
    // Not a number where both are one.
    if share > 0.0 {
        let share = share.min(1.0);
        [1.0 - share, share]
    } else {
        [1.0, 0.0]
    }
}

/// Of the segments between corners, the one that is nearest.
fn on_outline(corners: [DVec3; 3]) -> [f64; 3] {
    let mut best = (f64::INFINITY, [1.0, 0.0, 0.0]);
    for [i, j] in [[0, 1], [1, 2], [2, 0]] {
        let [u, v] = on_segment([corners[i], corners[j]]);
        let distance = (u * corners[i] + v * corners[j]).length_squared();
        if distance < best.0 {
            best = (distance, [0.0; 3]);
            (best.1[i], best.1[j]) = (u, v);
        }
    }
    best.1
}

fn on_triangle(corners: [DVec3; 3]) -> [f64; 3] {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    // The areas that the origin's projection makes with the edges.
    let areas = [b.cross(c), c.cross(a), a.cross(b)].map(|area| area.dot(normal));
    if areas.iter().all(|&area| area > 0.0) {
        let sum = areas[0] + areas[1] + areas[2];
        areas.map(|area| area / sum)
    } else {
        on_outline(corners)
    }
}

fn on_tetrahedron(corners: [DVec3; 4]) -> [f64; 4] {
    let [a, b, c, d] = corners;
    let volume = |p: DVec3, q: DVec3, r: DVec3| p.dot(q.cross(r));
    let whole = volume(b - a, c - a, d - a);
    let parts = [
        volume(b, c, d),
        -volume(a, c, d),
        volume(a, b, d),
        -volume(a, b, c),
    ];
    if whole != 0.0 && parts.iter().all(|part| part / whole > 0.0) {
        return parts.map(|part| part / whole);
    }
    let mut best = (f64::INFINITY, [1.0, 0.0, 0.0, 0.0]);
    for face in [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]] {
        let weights = on_triangle(face.map(|i| corners[i]));
        let at: DVec3 = (face.iter().zip(weights))
            .map(|(&i, w)| w * corners[i])
            .sum();
        if at.length_squared() < best.0 {
            best = (at.length_squared(), [0.0; 4]);
            face.iter().zip(weights).for_each(|(&i, w)| best.1[i] = w);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::{Corner, Simplex};
    use glam::DVec3;

    #[test]
    fn corners_come_nearer_to_the_origin() {
        let at = |x, y, z| Corner::new(DVec3::ZERO, DVec3::new(x, y, z));
        let mut simplex = Simplex::new(at(1.0, 1.0, 1.0));
        assert!(simplex.add(at(1.0, -1.0, 1.0)));
        assert_eq!(simplex.nearest(), DVec3::new(1.0, 0.0, 1.0));
        assert!(simplex.add(at(1.0, 0.0, -3.0)));
        assert_eq!(simplex.nearest(), DVec3::X);
        assert!(!simplex.add(at(2.0, 0.0, 0.0)));
        assert!(simplex.add(at(-5.0, 0.0, 0.0)));
        assert!(simplex.is_full());
    }
}
