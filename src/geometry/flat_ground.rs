//! Where a level of triangles is a plane: what is asked of a floor there costs what it costs of a plane, however many triangles it has.
//!
//! A box sees a plane if each triangle in it lies in that plane, and what of their edges is in it has a triangle of the plane on the
//! other side too: then they leave no gap there, for a box is convex. Whole nodes of the tree are known to be so from the start.

use crate::geometry::level_triangle::{EdgeKind, LevelTriangle};
use crate::geometry::wide_tree::{Visit, WideTree};
use crate::math::{Aabb, Plane};
use glam::Vec3;

/// Rounding of coordinates that make a plane, as a share of the largest of them.
const ROUNDING: f32 = 2.0 * f32::EPSILON;

/// How far triangles may be off one plane in a box, as a share of its diagonal.
const OFF: f32 = 1e-5;

/// Of a node below which not all is one plane.
const NONE: u32 = u32::MAX;

/// What is below a node of the tree.
#[derive(Clone, Copy, Debug)]
struct Below {
    /// A triangle in whose plane all is that is below, or [`NONE`].
    triangle: u32,
    /// How far it may be off that plane, m.
    off: f32,
}

impl Default for Below {
    fn default() -> Self {
        Self {
            triangle: NONE,
            off: 0.0,
        }
    }
}

/// By node and child of the tree of a level: a triangle in whose plane all is that is below, or [`NONE`].
#[derive(Clone, Debug, Default)]
pub(crate) struct FlatNodes(Vec<[u32; 4]>);

/// A place where a level is a plane, as something in a box of it sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FlatGround {
    /// A point of the plane, m.
    pub(crate) at: Vec3,
    pub(crate) normal: Vec3,
    /// Material slot of all triangles there.
    pub(crate) slot: Option<u16>,
}

/// How far two planes may be from each other in a box, m.
fn gap_in(b: &Aabb, one: &Plane, other: &Plane) -> f32 {
    let turn = one.normal - other.normal;
    let middle = turn.dot(b.center()) - (one.offset - other.offset);
    middle.abs() + 0.5 * turn.length() * b.diagonal()
}

/// The largest coordinate, m.
fn farthest(b: &Aabb) -> f32 {
    b.min.abs().max(b.max.abs()).max_element()
}

impl FlatNodes {
    /// Of triangles under a tree; `slot` tells the material of one.
    pub(crate) fn of(
        triangles: &[LevelTriangle],
        tree: &WideTree,
        slot: impl Fn(&LevelTriangle) -> Option<u16>,
    ) -> Self {
        let leaf = |number: u32| {
            let is_inside = triangles[number as usize].edges == [EdgeKind::Flat; 3];
            Below {
                triangle: if is_inside { number } else { NONE },
                off: 0.0,
            }
        };
        let join = |parts: &[(Aabb, Below)]| {
            let first = parts[0].1.triangle;
            let (mut off, mut reaches) = (0.0_f32, 0.0_f32);
            let is_one = parts.iter().all(|(around, part)| {
                let [a, b] = [first, part.triangle].map(|t| triangles.get(t as usize));
                let (Some(a), Some(b)) = (a, b) else {
                    return false;
                };
                off = off.max(part.off + gap_in(around, &a.plane, &b.plane));
                reaches = reaches.max(farthest(around));
                slot(a) == slot(b)
            });
            if is_one && off <= ROUNDING * reaches {
                Below {
                    triangle: first,
                    off,
                }
            } else {
                Below::default()
            }
        };
        let below = tree.fold_up(leaf, join).into_iter();
        Self(below.map(|node| node.map(|child| child.triangle)).collect())
    }

    /// The plane that a box sees of the triangles, if it sees nothing else, and if `slot` says the same of all it sees.
    pub(crate) fn ground(
        &self,
        triangles: &[LevelTriangle],
        tree: &WideTree,
        b: &Aabb,
        slot: impl Fn(&LevelTriangle) -> Option<u16>,
    ) -> Option<FlatGround> {
        let most = OFF * b.diagonal() + ROUNDING * farthest(b);
        let mut found: Option<&LevelTriangle> = None;
        let mut is_flat = true;
        tree.visit_within(b, |node, child, leaf| {
            let whole = self.0[node][child];
            let number = match leaf {
                _ if whole != NONE => whole,
                Some(leaf) => leaf,
                None => return Visit::Below,
            };
            let triangle = &triangles[number as usize];
            let first = *found.get_or_insert(triangle);
            let is_same = gap_in(b, &first.plane, &triangle.plane) <= most;
            is_flat = is_same
                && slot(first) == slot(triangle)
                && (whole != NONE || ends_outside(triangle, b));
            if is_flat { Visit::Next } else { Visit::End }
        });
        let first = found.filter(|_| is_flat)?;
        Some(FlatGround {
            at: first.corners[0],
            normal: first.plane.normal,
            slot: slot(first),
        })
    }
}

/// Whether each edge beyond which the plane of a triangle does not go on is outside of a box.
fn ends_outside(triangle: &LevelTriangle, b: &Aabb) -> bool {
    (0..3).all(|edge| {
        let ends = [edge, (edge + 1) % 3].map(|k| triangle.corners[k]);
        triangle.edges[edge] == EdgeKind::Flat || !Aabb::of_points(ends).overlaps(b)
    })
}

#[cfg(test)]
mod tests {
    use super::FlatGround;
    use crate::geometry::StaticMesh;
    use crate::math::Aabb;
    use glam::{Quat, Vec3};
    use rand_core::Rng;
    use rand_pcg::Pcg32;

    const CELLS: usize = 24;

    fn unit(random: &mut Pcg32) -> f32 {
        (random.next_u32() >> 8) as f32 / (1 << 24) as f32
    }

    /// A square of 24 m around the origin whose heights are none, but for some corners; some cells are missing.
    fn ground(random: &mut Pcg32, bumps: f32, holes: f32, turn: Quat) -> StaticMesh {
        let side = CELLS + 1;
        let mut positions = Vec::new();
        for i in 0..side * side {
            let [x, z] = [i % side, i / side].map(|k| k as f32 - 0.5 * CELLS as f32);
            let y = if unit(random) < bumps { 0.2 } else { 0.0 };
            positions.push(turn * Vec3::new(x, y, z));
        }
        let corner = |x: usize, z: usize| (z * side + x) as u32;
        let mut triangles = Vec::new();
        for (x, z) in (0..CELLS).flat_map(|z| (0..CELLS).map(move |x| (x, z))) {
            let [a, b, c, d] = [
                corner(x, z),
                corner(x + 1, z),
                corner(x, z + 1),
                corner(x + 1, z + 1),
            ];
            if unit(random) >= holes {
                triangles.extend([[a, c, d], [a, d, b]]);
            }
        }
        StaticMesh::new(&positions, &triangles).expect("a usable ground")
    }

    /// Whether a point of a plane is on a triangle that lies in it, by asking each of them.
    fn is_covered(level: &StaticMesh, ground: &FlatGround, at: Vec3) -> bool {
        level.triangles().iter().any(|triangle| {
            let is_same = triangle.plane.normal.dot(ground.normal) > 0.999_999;
            is_same
                && (0..3).all(|k| {
                    let [from, to] = [k, (k + 1) % 3].map(|k| triangle.corners[k]);
                    triangle.plane.normal.cross(to - from).dot(at - from) >= -1e-4
                })
        })
    }

    #[test]
    fn where_a_box_sees_a_plane_there_is_no_gap_and_nothing_else() {
        let mut random = Pcg32::new(5, 1);
        let mut seen = [0; 2];
        for round in 0..60 {
            let turn = [Quat::IDENTITY, Quat::from_rotation_x(0.4)][round % 2];
            let (bumps, holes) = [(0.0, 0.0), (0.02, 0.0), (0.0, 0.03)][round % 3];
            let level = ground(&mut random, bumps, holes, turn);
            for _ in 0..200 {
                let mut place = || 26.0 * unit(&mut random) - 13.0;
                let middle = turn * Vec3::new(place(), 0.1, place());
                let half = Vec3::splat(0.2) + Vec3::splat(1.5) * unit(&mut random);
                let b = Aabb {
                    min: middle - half,
                    max: middle + half,
                };
                let Some(found) = level.flat_ground(&b, false) else {
                    seen[0] += 1;
                    continue;
                };
                seen[1] += 1;
                let boxes = level.triangles().iter();
                let near = boxes.filter(|t| Aabb::of_points(t.corners).overlaps(&b));
                for triangle in near {
                    for corner in triangle.corners {
                        let off = found.normal.dot(corner - found.at);
                        assert!(off.abs() < 1e-4, "{off} m off the plane");
                    }
                }
                for _ in 0..30 {
                    let share = Vec3::new(unit(&mut random), unit(&mut random), unit(&mut random));
                    let at = b.min + share * b.extents();
                    let at = at - found.normal.dot(at - found.at) * found.normal;
                    let is_inside = b.contains(&Aabb::of_points([at]));
                    assert!(
                        !is_inside || is_covered(&level, &found, at),
                        "a gap at {at}"
                    );
                }
            }
        }
        assert!(seen[0] > 2000 && seen[1] > 2000, "{seen:?}");
    }

    #[test]
    fn materials_part_what_a_box_sees() {
        let level = ground(&mut Pcg32::new(2, 1), 0.0, 0.0, Quat::IDENTITY);
        let slots = (0..level.len())
            .map(|t| u16::from(t > level.len() / 2))
            .collect();
        let level = level.with_materials(slots).expect("one for each triangle");
        let at = |z: f32| Aabb {
            min: Vec3::new(-1.0, -1.0, z - 1.0),
            max: Vec3::new(1.0, 1.0, z + 1.0),
        };
        let slot = |z: f32| level.flat_ground(&at(z), true).map(|ground| ground.slot);
        assert_eq!(slot(-8.0), Some(Some(0)));
        assert_eq!(slot(8.0), Some(Some(1)));
        assert_eq!(slot(0.0), None);
        assert!(level.flat_ground(&at(0.0), false).is_some());
    }

    #[test]
    fn a_triangle_folded_back_is_no_neighbor() {
        let corners = [Vec3::ZERO, Vec3::Z, Vec3::X, 0.5 * (Vec3::X + Vec3::Z)];
        let level = StaticMesh::new(&corners, &[[0, 1, 2], [0, 1, 3]]).expect("usable");
        let b = Aabb {
            min: Vec3::new(-0.5, -0.1, 0.1),
            max: Vec3::new(0.1, 0.1, 0.3),
        };
        assert_eq!(level.flat_ground(&b, false), None);
    }
}
