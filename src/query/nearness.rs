//! What is near a shape.

use crate::bodies::body::Shape;
use crate::geometry::distance::{Nearest, Separation, distance};
use crate::geometry::support::{Core, PlacedCore};
use crate::geometry::{Compound, ConvexMesh, StaticMesh};
use crate::query::local::LocalHit;
use crate::query::{compound, convex, half_space};

/// Where a body is nearest to a core with a radius (m), if it is within `limit` (m); its frame. The distance is negative where they
/// overlap.
pub(crate) fn nearest_to(
    shape: &Shape,
    core: &PlacedCore,
    radius: f32,
    limit: f32,
) -> Option<LocalHit> {
    let found = match shape {
        Shape::Convex(mesh) => of_mesh(mesh, core, radius + limit),
        Shape::Compound(mesh) => of_compound(mesh, core, radius + limit),
        Shape::HalfSpace(below) => {
            let (height, at) = half_space::lowest(below.normal, core);
            let on_plane = at.as_vec3() - height as f32 * below.normal;
            Some(LocalHit::at(on_plane, below.normal, height as f32))
        }
        Shape::Level(mesh) => of_level(mesh, core, radius + limit),
    }?;
    let distance = found.distance - radius;
    (distance <= limit).then_some(LocalHit { distance, ..found })
}

fn of_mesh(mesh: &ConvexMesh, core: &PlacedCore, limit: f32) -> Option<LocalHit> {
    let (body, rounding) = match mesh.round() {
        Some(round) => (round.core(), round.radius),
        None => (Core::of_hull(mesh.hull()), 0.0),
    };
    match of_core(&body, core, limit + rounding) {
        Found::Far => None,
        Found::Near(near) => Some(LocalHit {
            point: near.point + rounding * near.normal,
            distance: near.distance - rounding,
            ..near
        }),
        // The way out leads from the surface to the middle, and is as long as it takes all of the core.
        Found::Overlap => {
            let near = convex::closest(mesh, core.inside(), f32::MAX)?;
            let out = near.normal.as_dvec3();
            let top = out.dot(body.exact_support(out)) as f32 + rounding;
            let lowest = out.dot(core.support(-out)) as f32;
            let distance = (lowest - top).min(0.0);
            Some(LocalHit { distance, ..near })
        }
    }
}

fn of_compound(mesh: &Compound, core: &PlacedCore, limit: f32) -> Option<LocalHit> {
    let mut best = None;
    compound::near(mesh, core, limit, |index| {
        let part = &mesh.parts()[index as usize];
        if let Some(hit) = of_mesh(&part.shape, &core.seen_from(&part.pose), limit) {
            compound::keep_first(&mut best, compound::on_part(part, index, hit));
        }
    });
    best
}

fn of_level(mesh: &StaticMesh, core: &PlacedCore, limit: f32) -> Option<LocalHit> {
    let mut best: Option<LocalHit> = None;
    let middle = core.inside();
    mesh.tree()
        .within(mesh.triangles(), &core.bounds().fattened(limit), |leaf| {
            let triangle = &mesh.triangles()[leaf as usize];
            let is_behind = triangle.plane.distance(middle) < 0.0;
            if is_behind && !mesh.is_two_sided() {
                return;
            }
            let near = match of_core(&Core::of_triangle(triangle.corners), core, limit) {
                Found::Far => return,
                Found::Near(near) => near,
                Found::Overlap if is_behind => LocalHit::at(middle, -triangle.plane.normal, 0.0),
                Found::Overlap => LocalHit::at(middle, triangle.plane.normal, 0.0),
            };
            let near = LocalHit {
                triangle: Some(triangle.index),
                ..near
            };
            let order = |hit: &LocalHit| (hit.distance, hit.triangle);
            if best.as_ref().is_none_or(|best| order(&near) < order(best)) {
                best = Some(near);
            }
        });
    best
}

enum Found {
    Far,
    Near(LocalHit),
    Overlap,
}

fn of_core(body: &Core, core: &PlacedCore, limit: f32) -> Found {
    match distance(body, core, f64::from(limit)) {
        Separation::Far => Found::Far,
        Separation::Overlap => Found::Overlap,
        Separation::Near(Nearest {
            normal,
            distance,
            on_a,
        }) => Found::Near(LocalHit::at(
            on_a.as_vec3(),
            normal.as_vec3(),
            distance as f32,
        )),
    }
}
