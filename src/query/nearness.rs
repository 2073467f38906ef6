//! What is near a shape.

use crate::bodies::body::Shape;
use crate::geometry::distance::{Nearest, Separation, distance};
use crate::geometry::penetration::WayOut;
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
        Found::Overlap => way_out(mesh, &body, core, rounding),
    }
}

/// Where the least way leads out for a core that overlaps that of a body with a rounding (m): of those from the surface to the core's middle,
/// across the faces, and along the core's own axes.
fn way_out(mesh: &ConvexMesh, body: &Core, core: &PlacedCore, rounding: f32) -> Option<LocalHit> {
    let near = convex::closest(mesh, core.inside(), f32::MAX)?;
    let first = near.normal.as_dvec3();
    let faces = mesh.hull().faces().iter();
    let across = faces.map(|face| face.plane.normal.as_dvec3());
    let across = std::iter::once(first).chain(across);
    let axes = core.axes();
    let own = [axes.x_axis, axes.y_axis, axes.z_axis];
    let own = own.map(|axis| WayOut::least(body, core, [axis, -axis]));
    // Each leads down to another least one.
    let starts = std::iter::once(WayOut::least(body, core, across)).chain(own);
    let ways = starts.flatten().map(|way| way.turned(body, core));
    let way = ways.min_by(WayOut::order)?;
    let distance = (-(way.length as f32) - rounding).min(0.0);
    let Some(on_core) = way.on_a.filter(|_| way.normal != first) else {
        return Some(LocalHit { distance, ..near });
    };
    let normal = way.normal.as_vec3();
    let point = on_core.as_vec3() + rounding * normal;
    let found = LocalHit::at(point, normal, distance);
    Some(convex::on_surface(mesh, found))
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
