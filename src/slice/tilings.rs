//! Cells that fill space: sectors about a line, rows and bricks, each as the planes around it.

use crate::math::{Aabb, Plane};
use crate::slice::cutting::{CellPlanes, Cutting};
use glam::Vec3;
use smallvec::smallvec;

/// What planes through one line divide space into, in the order of their turns.
///
/// Cells, so that a piece is cut by the two planes beside it only: one plane after the other divides what all planes before it
/// have left at the line, where rounding makes slivers of it.
pub(super) fn sectors(planes: &[Plane]) -> Cutting {
    if let [_] = planes {
        return Cutting::Planes(planes.iter().copied().collect());
    }
    let opposite = planes.iter().map(Plane::flipped);
    let sides: Vec<Plane> = planes.iter().copied().chain(opposite).collect();
    let pairs = sides.iter().zip(sides.iter().cycle().skip(1));
    let cells = pairs.map(|(side, &next)| smallvec![side.flipped(), next]);
    Cutting::Cells(cells.collect())
}

/// The planes around what lies between two of a row of planes, the one before and the one after place `index`.
pub(super) fn between(walls: &[Plane], index: usize) -> CellPlanes {
    let before = index.checked_sub(1).map(|wall| walls[wall].flipped());
    before
        .into_iter()
        .chain(walls.get(index).copied())
        .collect()
}

/// Boxes of the given size in a running bond that fill `aabb`; none if the size is not finite and positive.
pub(super) fn bricks(aabb: &Aabb, size: Vec3, most: u32) -> Option<Vec<CellPlanes>> {
    if !(size.is_finite() && size.min_element() > 0.0) {
        return None;
    }
    let mut size = size;
    let count = |size: Vec3| (aabb.extents() / size).ceil().max(Vec3::ONE);
    // A shifted course has one brick more. A size that overflows is larger than any body, and the only brick.
    let number = |n: Vec3| f64::from(n.x + 0.5) * f64::from(n.y) * f64::from(n.z);
    while number(count(size)) > f64::from(most) && size.is_finite() {
        size *= 2.0;
    }
    let count = count(size).as_uvec3();
    let row = |normal: Vec3, first: f32, length: f32, walls: u32| -> Vec<Plane> {
        (0..walls)
            .map(|wall| Plane {
                normal,
                offset: first + wall as f32 * length,
            })
            .collect()
    };
    let courses = row(Vec3::Y, aabb.min.y + size.y, size.y, count.y - 1);
    let depths = row(Vec3::Z, aabb.min.z + size.z, size.z, count.z - 1);
    let joints = [
        row(Vec3::X, aabb.min.x + size.x, size.x, count.x - 1),
        row(Vec3::X, aabb.min.x + 0.5 * size.x, size.x, count.x),
    ];
    let mut cells = Vec::new();
    for course in 0..=courses.len() {
        let joints = &joints[course % 2];
        for depth in 0..=depths.len() {
            for brick in 0..=joints.len() {
                let mut cell = between(&courses, course);
                cell.extend(between(&depths, depth));
                cell.extend(between(joints, brick));
                cells.push(cell);
            }
        }
    }
    Some(cells)
}
