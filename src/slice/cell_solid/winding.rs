//! Whether a point is in a closed mesh.

use crate::geometry::TriMesh;
use glam::{DVec3, Vec3};

/// Whether `point` is in the mesh, by how often a ray along +x leaves more than it enters. None if the ray meets an edge, the point is
/// nearer than `tolerance` (m) to where it meets a triangle, or the surface runs through itself.
pub(super) fn is_inside(mesh: &TriMesh, point: Vec3, tolerance: f32) -> Option<bool> {
    let mut count = 0;
    let p = point.as_dvec3();
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|v| mesh.positions[v as usize]);
        let low = a.min(b).min(c);
        let high = a.max(b).max(c);
        let is_missed = low.y > point.y
            || high.y < point.y
            || low.z > point.z
            || high.z < point.z
            || high.x < point.x - tolerance;
        if is_missed {
            continue;
        }
        let sides = [(a, b), (b, c), (c, a)].map(|(a, b)| side(p, a, b));
        let sum: f64 = sides.iter().sum();
        if sides.iter().all(|&s| s * sum > 0.0) {
            let weighted = sides[1] * f64::from(a.x) + sides[2] * f64::from(b.x);
            let x = (weighted + sides[0] * f64::from(c.x)) / sum;
            if (x - p.x).abs() <= f64::from(tolerance) {
                return None;
            }
            if x > p.x {
                count += if sum > 0.0 { 1 } else { -1 };
            }
        } else if sides.contains(&0.0) {
            return None;
        }
    }
    match count {
        0 => Some(false),
        1 => Some(true),
        _ => None,
    }
}

/// On which side of the line from `a` to `b` the point is, seen along x: twice the area of the triangle, m2. The same number the other way round, negated.
fn side(p: DVec3, a: Vec3, b: Vec3) -> f64 {
    let is_ordered = (a.y, a.z) < (b.y, b.z);
    let (low, high) = if is_ordered { (a, b) } else { (b, a) };
    let (u, v) = (low.as_dvec3() - p, high.as_dvec3() - p);
    let area = u.y * v.z - u.z * v.y;
    if is_ordered { area } else { -area }
}
