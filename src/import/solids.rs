//! What of the surfaces is solid: holes filled, insides turned out, and all put together as a mesh with a report.

use crate::geometry::{EdgeCensus, TriMesh};
use crate::import::error::ImportError;
use crate::import::holes::{Holes, Patch};
use crate::import::options::{ImportOptions, OpenParts};
use crate::import::report::{Hole, ImportReport, PartReport, PartState, Repairs};
use crate::import::soup::Soup;
use crate::import::thicken;
use crate::math::Aabb;
use crate::slice::attributes::extend_chosen;
use crate::slice::components::{compacted, encloses};
use glam::DVec3;

/// A closed surface with less volume than this times its area to the power 3/2 is flat: two faces back to back. A card of
/// thickness 1e-6 of its width has twice as much.
const FLAT_VOLUME: f64 = 2e-7;

/// Points of a surface that are looked at to see whether it lies inside another one.
const PROBES: usize = 5;

/// One surface and what becomes of it.
#[derive(Debug)]
struct Surface {
    triangles: Vec<u32>,
    patch: Patch,
    state: PartState,
    /// m3, before it is turned.
    volume: f64,
    /// m2, without new faces.
    area: f64,
    holes: Vec<Hole>,
    fill_share: f32,
    around: Aabb,
    is_turned: bool,
}

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

/// Whether a part with this state is closed in the mesh.
fn is_kept_closed(state: PartState) -> bool {
    !matches!(state, PartState::Riding | PartState::LeftOut)
}

fn close(
    soup: &Soup,
    holes: &mut Holes,
    options: &ImportOptions,
    number: u32,
    triangles: Vec<u32>,
    fresh: u32,
) -> Surface {
    let found = holes.of(number);
    let is_open = triangles.iter().any(|&t| {
        let half_edges = 3 * t as usize..3 * t as usize + 3;
        soup.twins[half_edges].contains(&crate::import::soup::NONE)
    });
    let area = area_of(soup, &triangles);
    let mut surface = Surface {
        patch: Patch::default(),
        state: PartState::Closed,
        volume: 0.0,
        area,
        fill_share: 0.0,
        around: Aabb::of_points(corners(soup, &triangles).map(|v| soup.position(v))),
        holes: found,
        is_turned: false,
        triangles,
    };
    if is_open {
        let patch = holes.fill(soup, number, &surface.triangles, fresh);
        surface.fill_share = (patch.area / area.max(f64::MIN_POSITIVE)) as f32;
        surface.state = PartState::Riding;
        if surface.fill_share <= options.max_fill && is_closed(soup, &surface.triangles, &patch) {
            surface.patch = patch;
            surface.state = PartState::Repaired;
        } else {
            give_up(soup, &mut surface, options, fresh);
        }
    } else if repairs_of(soup, &surface.triangles) != Repairs::default() {
        surface.state = PartState::Repaired;
    }
    if is_kept_closed(surface.state) {
        surface.volume = volume_of(soup, &surface);
        let whole_area = surface.area + surface.patch.area;
        if surface.volume.abs() <= FLAT_VOLUME * whole_area * whole_area.sqrt() {
            // Closed by what it lacks, a card is two faces back to back: it stays what it is.
            if surface.patch.mesh.triangles.is_empty() {
                surface.state = PartState::Flat;
                thicken_flat(soup, &mut surface, options, fresh);
            } else {
                surface.patch = Patch::default();
                give_up(soup, &mut surface, options, fresh);
                surface.volume = volume_of(soup, &surface);
            }
        }
    }
    surface
}

/// Does with an open surface what the options say.
fn give_up(soup: &Soup, surface: &mut Surface, options: &ImportOptions, fresh: u32) {
    surface.state = match options.open_parts {
        OpenParts::LeaveOut => PartState::LeftOut,
        OpenParts::Ride => PartState::Riding,
        OpenParts::Thicken(thickness) => {
            let patch = thicken::back(soup, &surface.triangles, thickness, fresh);
            if thickness > 0.0 && is_closed(soup, &surface.triangles, &patch) {
                surface.patch = patch;
                PartState::Thickened
            } else {
                PartState::Riding
            }
        }
    };
}

/// Gives two faces back to back a thickness, if open parts get one: a back behind those triangles that have a reverse.
fn thicken_flat(soup: &Soup, surface: &mut Surface, options: &ImportOptions, fresh: u32) {
    let OpenParts::Thicken(thickness) = options.open_parts else {
        return;
    };
    let key = |&t: &u32| {
        let corners = soup.mesh.triangles[t as usize];
        let mut points = corners.map(|v| (soup.position(v) + 0.0).to_array().map(f32::to_bits));
        points.sort_unstable();
        points
    };
    let mut fronts = surface.triangles.clone();
    fronts.sort_by_key(|t| (key(t), *t));
    fronts.dedup_by_key(|t| key(t));
    fronts.sort_unstable();
    let patch = thicken::back(soup, &fronts, thickness, fresh);
    if thickness > 0.0 && is_closed(soup, &fronts, &patch) {
        surface.triangles = fronts;
        surface.patch = patch;
        surface.state = PartState::Thickened;
        surface.volume = volume_of(soup, surface);
    }
}

fn corners<'a>(soup: &'a Soup, triangles: &'a [u32]) -> impl Iterator<Item = u32> + 'a {
    triangles
        .iter()
        .flat_map(|&t| soup.mesh.triangles[t as usize])
}

fn area_of(soup: &Soup, triangles: &[u32]) -> f64 {
    let area = |&t: &u32| {
        let [a, b, c] = soup.mesh.triangles[t as usize].map(|v| soup.position(v).as_dvec3());
        0.5 * (b - a).cross(c - a).length()
    };
    triangles.iter().map(area).sum()
}

fn repairs_of(soup: &Soup, triangles: &[u32]) -> Repairs {
    let mut all = Repairs::default();
    triangles
        .iter()
        .for_each(|&t| all.add(&soup.repairs[t as usize]));
    all
}

/// Signed volume of a closed surface, m3.
fn volume_of(soup: &Soup, surface: &Surface) -> f64 {
    let apex = surface.around.center().as_dvec3();
    let own = surface
        .triangles
        .iter()
        .map(|&t| soup.mesh.triangles[t as usize].map(|v| soup.position(v)));
    let patch = &surface.patch.mesh;
    let new = patch
        .triangles
        .iter()
        .map(|t| t.map(|v| patch.positions[v as usize]));
    let six_volumes: f64 = (own.chain(new))
        .map(|t| t.map(|p| p.as_dvec3() - apex))
        .map(|[a, b, c]| a.dot(b.cross(c)))
        .sum();
    six_volumes / 6.0
}

/// Whether a surface with its new faces is closed by number.
fn is_closed(soup: &Soup, triangles: &[u32], patch: &Patch) -> bool {
    let own = triangles.iter().map(|&t| soup.places(t as usize));
    let new = patch
        .mesh
        .triangles
        .iter()
        .map(|t| t.map(|v| patch.mesh.topology[v as usize]));
    let all: Vec<[u32; 3]> = own.chain(new).collect();
    let mut edges: Vec<[u32; 2]> = all
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .collect();
    edges.sort_unstable();
    let is_once = edges.windows(2).all(|pair| pair[0] != pair[1]);
    is_once
        && edges
            .iter()
            .all(|&[a, b]| a != b && edges.binary_search(&[b, a]).is_ok())
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
        let mut own = corners(soup, &surface.triangles);
        if surface.is_turned && !all.normals.is_empty() {
            let mut own: Vec<u32> = own
                .by_ref()
                .chain(first..all.positions.len() as u32)
                .collect();
            own.sort_unstable();
            own.dedup();
            own.iter().for_each(|&v| all.normals[v as usize] *= -1.0);
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

/// An entry for each surface, but one for all the open ones of an object.
fn report(soup: &Soup, surfaces: &[Surface]) -> ImportReport {
    let mut parts: Vec<PartReport> = Vec::new();
    for (object, name) in (0_u32..).zip(&soup.names) {
        let own = || {
            surfaces
                .iter()
                .filter(|s| soup.objects[s.triangles[0] as usize] == object)
        };
        let open = own().filter(|s| !is_kept_closed(s.state)).count();
        let entries = own().count() - open + open.min(1);
        let mut merged: Option<usize> = None;
        let mut number = 0;
        for surface in own() {
            let is_open = !is_kept_closed(surface.state);
            if let Some(place) = merged.filter(|_| is_open) {
                add_open(soup, &mut parts[place], surface);
                continue;
            }
            number += 1;
            let mut part = part_report(soup, surface);
            part.name = match entries {
                1 => name.clone(),
                _ => format!("{name}, part {number} of {entries}"),
            };
            if is_open {
                merged = Some(parts.len());
            }
            parts.push(part);
        }
    }
    ImportReport {
        parts,
        notes: Vec::new(),
    }
}

fn part_report(soup: &Soup, surface: &Surface) -> PartReport {
    let mut repairs = repairs_of(soup, &surface.triangles);
    repairs.inside_out = surface.is_turned;
    PartReport {
        name: String::new(),
        center: surface.around.center(),
        size: surface.around.extents(),
        triangles: surface.triangles.len(),
        state: surface.state,
        repairs,
        holes: surface.holes.clone(),
        fill_share: surface.fill_share,
    }
}

/// Adds an open surface to the entry of those before it.
fn add_open(soup: &Soup, part: &mut PartReport, surface: &Surface) {
    let half = 0.5 * part.size;
    let mut around = Aabb {
        min: part.center - half,
        max: part.center + half,
    };
    around.min = around.min.min(surface.around.min);
    around.max = around.max.max(surface.around.max);
    (part.center, part.size) = (around.center(), around.extents());
    part.triangles += surface.triangles.len();
    part.repairs.add(&repairs_of(soup, &surface.triangles));
    part.holes.extend_from_slice(&surface.holes);
    part.fill_share = part.fill_share.max(surface.fill_share);
}

fn nothing_solid(report: ImportReport) -> ImportError {
    let size = |part: &&PartReport| part.size.as_dvec3().dot(DVec3::ONE);
    let largest = report
        .parts
        .iter()
        .max_by(|a, b| size(a).total_cmp(&size(b)));
    let (name, center, share) = largest.map_or_else(Default::default, |part| {
        (part.name.clone(), part.center, part.fill_share)
    });
    ImportError::NothingSolid {
        name,
        center,
        share,
        report: Box::new(report),
    }
}
