//! What of the surfaces is solid: insides turned out, and all put together as a mesh with a report.

use crate::geometry::{EdgeCensus, TriMesh};
use crate::import::error::ImportError;
use crate::import::holes::Holes;
use crate::import::options::ImportOptions;
use crate::import::part_report::{nothing_solid, report};
use crate::import::report::{ImportReport, PartState};
use crate::import::soup::Soup;
use crate::import::surface::{Surface, close, corners, is_kept_closed};
use crate::slice::attributes::extend_chosen;
use crate::slice::components::{compacted, encloses};

/// Points of a surface that are looked at to see whether it lies inside another one.
const PROBES: usize = 5;

/// Decides what becomes of each surface, and puts the mesh together.
pub(super) fn build(
    soup: Soup,
    mut holes: Holes,
    options: &ImportOptions,
) -> Result<(TriMesh, ImportReport), ImportError> {
    let mut lists = vec![Vec::new(); holes.count];
    for (triangle, &surface) in (0_u32..).zip(&holes.surfaces) {
        lists[surface as usize].push(triangle);
    }
    let mut fresh = soup.mesh.topology_count() as u32;
    let mut surfaces = Vec::with_capacity(lists.len());
    for (number, triangles) in (0_u32..).zip(lists) {
        let surface = close(&soup, &mut holes, options, number, triangles, fresh);
        let numbers = surface.patch.mesh.topology_count() as u32;
        fresh = fresh.max(numbers);
        surfaces.push(surface);
    }
    turn_outwards(&soup, &mut surfaces);
    let report = report(&soup, &surfaces);
    let is_solid =
        |surface: &Surface| is_kept_closed(surface.state) && surface.state != PartState::Flat;
    if !surfaces.iter().any(is_solid) {
        return Err(nothing_solid(report));
    }
    Ok((assemble(&soup, &surfaces, options), report))
}

/// Turns surfaces that are inside out. One that lies inside a larger one of its object is the wall of a hollow and stays.
fn turn_outwards(soup: &Soup, surfaces: &mut [Surface]) {
    let (mesh, labels) = solid_mesh(soup, surfaces);
    for inner in 0..surfaces.len() {
        let surface = &surfaces[inner];
        if !is_kept_closed(surface.state)
            || surface.volume >= 0.0
            || surface.state == PartState::Flat
        {
            continue;
        }
        let object = soup.objects[surface.triangles[0] as usize];
        let step = surface.triangles.len().div_ceil(PROBES);
        let probes = || {
            surface
                .triangles
                .iter()
                .step_by(step)
                .map(|&t| soup.mesh.triangles[t as usize][0])
        };
        let is_hollow = surfaces.iter().enumerate().any(|(outer, other)| {
            other.volume.abs() > surface.volume.abs()
                && is_kept_closed(other.state)
                && soup.objects[other.triangles[0] as usize] == object
                && other.around.contains(&surface.around)
                && probes()
                    .all(|v| encloses(&mesh, &labels, outer as u32, soup.position(v).as_dvec3()))
        });
        if is_hollow && surface.state == PartState::Closed {
            surfaces[inner].state = PartState::Hollow;
        } else if !is_hollow {
            let surface = &mut surfaces[inner];
            surface.is_turned = true;
            if surface.state == PartState::Closed {
                surface.state = PartState::Repaired;
            }
        }
    }
}

/// All closed surfaces as a mesh, and the surface of each triangle.
fn solid_mesh(soup: &Soup, surfaces: &[Surface]) -> (TriMesh, Vec<u32>) {
    let mut mesh = TriMesh {
        positions: soup.mesh.positions.clone(),
        topology: soup.mesh.topology.clone(),
        ..TriMesh::default()
    };
    let mut labels = Vec::new();
    for (label, surface) in (0_u32..)
        .zip(surfaces)
        .filter(|(_, s)| is_kept_closed(s.state))
    {
        let first = mesh.positions.len() as u32;
        let patch = &surface.patch.mesh;
        mesh.positions.extend(&patch.positions);
        mesh.topology.extend(&patch.topology);
        mesh.triangles.extend(
            surface
                .triangles
                .iter()
                .map(|&t| soup.mesh.triangles[t as usize]),
        );
        mesh.triangles
            .extend(patch.triangles.iter().map(|t| t.map(|v| first + v)));
        labels.resize(mesh.triangles.len(), label);
    }
    (mesh, labels)
}

/// Turns the normals of a surface and of its new faces, whose vertices begin at `first`.
fn turn_normals(soup: &Soup, surface: &Surface, first: u32, all: &mut TriMesh) {
    let own = corners(soup, &surface.triangles);
    let mut own: Vec<u32> = own.chain(first..all.positions.len() as u32).collect();
    own.sort_unstable();
    own.dedup();
    for vertex in own {
        if let Some(normal) = all.normals.get_mut(vertex as usize) {
            *normal = -*normal;
        }
    }
}

/// The mesh of all that is kept: sheets first, then what is closed; vertices and numbers that nothing uses are left out.
fn assemble(soup: &Soup, surfaces: &[Surface], options: &ImportOptions) -> TriMesh {
    let mut all = TriMesh {
        positions: soup.mesh.positions.clone(),
        normals: soup.mesh.normals.clone(),
        colors: soup.mesh.colors.clone(),
        uvs: soup.mesh.uvs.clone(),
        topology: soup.mesh.topology.clone(),
        ..TriMesh::default()
    };
    let has_materials = !soup.mesh.materials.is_empty() || options.fill_material.is_some();
    let mut materials = Vec::new();
    let slot = |t: u32| soup.mesh.materials.get(t as usize).copied().unwrap_or(0);
    let riding = |s: &&Surface| s.state == PartState::Riding;
    for &t in surfaces.iter().filter(riding).flat_map(|s| &s.triangles) {
        all.triangles.push(soup.mesh.triangles[t as usize]);
        materials.push(slot(t));
    }
    all.sheets = all.triangles.len() as u32;
    for surface in surfaces.iter().filter(|s| is_kept_closed(s.state)) {
        let first = all.positions.len() as u32;
        let patch = &surface.patch.mesh;
        let places: Vec<u32> = (0..patch.positions.len() as u32).collect();
        extend_chosen(&mut all, patch, &places, &TriMesh::default(), [0, 0]);
        all.topology.extend(&patch.topology);
        let turn = |[a, b, c]: [u32; 3]| {
            if surface.is_turned {
                [a, c, b]
            } else {
                [a, b, c]
            }
        };
        if surface.is_turned {
            turn_normals(soup, surface, first, &mut all);
        }
        for &t in &surface.triangles {
            all.triangles.push(turn(soup.mesh.triangles[t as usize]));
            materials.push(slot(t));
        }
        for (place, corners) in patch.triangles.iter().enumerate() {
            all.triangles.push(turn(corners.map(|v| first + v)));
            let neighbor = patch.materials.get(place).copied().unwrap_or(0);
            let fill = options
                .fill_material
                .filter(|_| surface.state == PartState::Repaired);
            materials.push(fill.unwrap_or(neighbor));
        }
    }
    if has_materials {
        all.materials = materials;
    }
    let mesh = compacted(&all);
    debug_assert!(mesh.check_closed_with(&mut EdgeCensus::default()).is_ok());
    mesh
}
