//! One surface: whether it is closed, can be, or stays open.

use crate::import::holes::{Holes, Patch};
use crate::import::options::{ImportOptions, OpenParts};
use crate::import::report::{Hole, PartState, Repairs};
use crate::import::soup::{NONE, Soup};
use crate::import::thicken;
use crate::math::Aabb;

/// A closed surface with less volume than this times its area to the power 3/2 is flat: two faces back to back. A card of
/// thickness 1e-6 of its width has twice as much.
const FLAT_VOLUME: f64 = 2e-7;

/// One surface and what becomes of it.
#[derive(Debug)]
pub(super) struct Surface {
    pub(super) triangles: Vec<u32>,
    pub(super) patch: Patch,
    pub(super) state: PartState,
    /// m3, before it is turned.
    pub(super) volume: f64,
    /// m2, without new faces.
    pub(super) area: f64,
    pub(super) holes: Vec<Hole>,
    pub(super) fill_share: f32,
    pub(super) around: Aabb,
    pub(super) is_turned: bool,
}

/// Whether a part with this state is closed in the mesh.
pub(super) fn is_kept_closed(state: PartState) -> bool {
    !matches!(state, PartState::Riding | PartState::LeftOut)
}

/// Finds out whether a surface is closed, and closes it if the options allow that. Topology numbers of new positions go on from
/// `fresh`.
pub(super) fn close(
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
        soup.twins[half_edges].contains(&NONE)
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

pub(super) fn corners<'a>(soup: &'a Soup, triangles: &'a [u32]) -> impl Iterator<Item = u32> + 'a {
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

pub(super) fn repairs_of(soup: &Soup, triangles: &[u32]) -> Repairs {
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
