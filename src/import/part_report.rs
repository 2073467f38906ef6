//! The report of an import, from its surfaces.

use crate::import::error::ImportError;
use crate::import::report::{ImportReport, PartReport};
use crate::import::soup::Soup;
use crate::import::surface::{Surface, is_kept_closed, repairs_of};
use crate::math::Aabb;
use glam::DVec3;

/// An entry for each surface, but one for all the open ones of an object.
pub(super) fn report(soup: &Soup, surfaces: &[Surface]) -> ImportReport {
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

/// Why a model without a solid part is refused, by its largest part.
pub(super) fn nothing_solid(report: ImportReport) -> ImportError {
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
