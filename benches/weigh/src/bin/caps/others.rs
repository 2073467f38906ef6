//! What the library's code would shrink to with another crate below it.

use crate::{Border, Cap};
use glam::DVec2;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

fn area(border: &Border, ring: &[u32]) -> f64 {
    let point = |i: usize| border.points[ring[i % ring.len()] as usize];
    (0..ring.len())
        .map(|i| 0.5 * point(i).perp_dot(point(i + 1)))
        .sum()
}

/// Whether a point lies inside a loop: crossing number of a ray along +x.
fn is_inside(border: &Border, ring: &[u32], p: DVec2) -> bool {
    let point = |i: usize| border.points[ring[i % ring.len()] as usize];
    let crosses = |i: &usize| {
        let (a, b) = (point(*i), point(i + 1));
        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    (0..ring.len()).filter(crosses).count() % 2 == 1
}

/// Ear clipping with holes joined by bridges, as in Mapbox's library: it wants to know which hole is whose.
pub(crate) fn earcut(border: &Border) -> Option<Cap> {
    let areas: Vec<f64> = border.loops.iter().map(|ring| area(border, ring)).collect();
    let mut outers: Vec<usize> = (0..areas.len()).filter(|&i| areas[i] > 0.0).collect();
    outers.sort_by(|&a, &b| areas[a].total_cmp(&areas[b]));
    let mut holes = vec![Vec::new(); areas.len()];
    for hole in (0..areas.len()).filter(|&i| areas[i] <= 0.0) {
        let is_around = |&&outer: &&usize| {
            let ring = &border.loops[outer];
            let probe = border.loops[hole]
                .iter()
                .find(|corner| !ring.contains(corner));
            areas[outer] > -areas[hole]
                && probe
                    .is_some_and(|&probe| is_inside(border, ring, border.points[probe as usize]))
        };
        if let Some(&outer) = outers.iter().find(is_around) {
            holes[outer].push(hole);
        }
    }
    let mut cap = Vec::new();
    for outer in outers {
        let mut corners = Vec::new();
        let mut starts = Vec::new();
        for &ring in [outer].iter().chain(&holes[outer]) {
            if ring != outer {
                starts.push(corners.len());
            }
            corners.extend(&border.loops[ring]);
        }
        let numbers: Vec<f64> = corners
            .iter()
            .flat_map(|&c| border.points[c as usize].to_array())
            .collect();
        let triangles = earcutr::earcut(&numbers, &starts, 2).ok()?;
        // Its triangles are clockwise.
        let corner = |k: usize| corners[k];
        cap.extend(
            triangles
                .chunks_exact(3)
                .map(|t| [corner(t[0]), corner(t[2]), corner(t[1])]),
        );
    }
    let signed: f64 = cap.iter().map(|t| area(border, t)).sum();
    if signed < 0.0 {
        cap.iter_mut().for_each(|t| t.swap(1, 2));
    }
    Some(cap)
}

/// A constrained Delaunay triangulation of all loops together; what is inside is found from its outer face inwards, and
/// becomes the other with each border edge that is crossed. No answer where border edges cross each other.
pub(crate) fn spade(border: &Border) -> Option<Cap> {
    let points = border
        .points
        .iter()
        .map(|p| Point2::new(p.x, p.y))
        .collect();
    let edges = border.loops.iter().flat_map(|ring| {
        (0..ring.len()).map(move |k| [ring[k] as usize, ring[(k + 1) % ring.len()] as usize])
    });
    let mut conflicts = 0;
    let cdt = ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(
        points,
        edges.collect(),
        |_| {
            conflicts += 1;
        },
    )
    .ok()?;
    // Points at the same place became one, and the numbers of the border are no longer those of its vertices.
    if conflicts > 0 || cdt.num_vertices() != border.points.len() {
        return None;
    }
    let mut is_inside = vec![None; cdt.num_all_faces()];
    let outer = cdt.outer_face().fix();
    is_inside[outer.index()] = Some(false);
    let mut front: Vec<_> = cdt
        .directed_edges()
        .filter(|e| e.face().is_outer())
        .map(|e| e.fix())
        .collect();
    while let Some(edge) = front.pop() {
        let edge = cdt.directed_edge(edge);
        let (here, beyond) = (edge.face().fix().index(), edge.rev().face());
        let index = beyond.fix().index();
        if is_inside[index].is_some() {
            continue;
        }
        let side = is_inside[here].unwrap_or(false) != edge.is_constraint_edge();
        is_inside[index] = Some(side);
        let others = [edge.rev().next(), edge.rev().prev()];
        front.extend(others.iter().map(|e| e.fix()));
    }
    let inner = cdt
        .inner_faces()
        .filter(|face| is_inside[face.fix().index()] == Some(true));
    Some(
        inner
            .map(|face| face.vertices().map(|v| v.fix().index() as u32))
            .collect(),
    )
}
