//! Surfaces, the holes in them, and the faces that close these.

use crate::disjoint_sets::DisjointSets;
use crate::geometry::TriMesh;
use crate::import::report::Hole;
use crate::import::soup::{NONE, Soup};
use crate::slice::attributes::extend_chosen;
use crate::slice::rim_fill::{RimCorner, RimFill};
use glam::{DVec3, Vec3};

/// How far the corners of a hole may lie from its plane for it to count as flat, as a share of the model's size. Flat
/// holes in one plane are closed together, so that the bottom of a tube becomes a ring.
const FLAT_SHARE: f64 = 1e-4;

/// Cosine of the angle between the planes of two flat holes above which they are one plane.
const SAME_PLANE: f64 = 1.0 - 1e-5;

/// The surfaces of a soup and their holes.
#[derive(Debug, Default)]
pub(super) struct Holes {
    /// By triangle: its surface.
    pub(super) surfaces: Vec<u32>,
    /// Number of surfaces.
    pub(super) count: usize,
    loops: Vec<HoleLoop>,
    filler: RimFill,
    /// m.
    tolerance: f64,
}

/// The border of a hole, in the direction of the faces that close it.
#[derive(Clone, Debug)]
struct HoleLoop {
    surface: u32,
    vertices: Vec<u32>,
    /// Twice the area of the hole along its normal, m2.
    area: DVec3,
    center: DVec3,
    is_flat: bool,
    /// A triangle at its border.
    neighbor: u32,
}

/// New faces, not yet part of the mesh.
#[derive(Debug, Default)]
pub(super) struct Patch {
    /// Vertices of its own; topology numbers from `fresh` on are new.
    pub(super) mesh: TriMesh,
    /// m2.
    pub(super) area: f64,
}

impl Holes {
    /// Finds the surfaces and the holes of a soup whose positions are numbered by surface.
    pub(super) fn find(soup: &Soup) -> Self {
        let share = FLAT_SHARE * f64::from(soup.size());
        let mut holes = Self {
            tolerance: share.max(f64::from(soup.rounding())),
            ..Self::default()
        };
        holes.label(soup);
        holes.find_loops(soup);
        holes
    }

    fn label(&mut self, soup: &Soup) {
        let count = soup.mesh.triangles.len();
        let mut sets = DisjointSets::new(count);
        for (h, &twin) in (0_u32..).zip(&soup.twins) {
            if twin != NONE {
                sets.join(h / 3, twin / 3);
            }
        }
        for triangle in 0..count as u32 {
            let root = sets.root(triangle);
            let label = if root == triangle {
                self.count as u32
            } else {
                self.surfaces[root as usize]
            };
            self.count += usize::from(root == triangle);
            self.surfaces.push(label);
        }
    }

    /// A surface at a place has one border edge in and one out at most, so borders are followed without a choice.
    fn find_loops(&mut self, soup: &Soup) {
        let open = soup.open_edges();
        let mut from = vec![NONE; soup.mesh.topology_count()];
        for &h in &open {
            from[soup.ends(h)[0] as usize] = h;
        }
        let mut is_done = vec![false; soup.twins.len()];
        for &start in &open {
            let (mut at, mut vertices) = (start, Vec::new());
            while at != NONE && !is_done[at as usize] {
                is_done[at as usize] = true;
                vertices.push(soup.vertices(at)[0]);
                at = from[soup.ends(at)[1] as usize];
            }
            if vertices.len() >= 3 && at == start {
                vertices.reverse();
                self.push_loop(soup, vertices, start / 3);
            }
        }
        self.loops.sort_by_key(|hole| hole.surface);
    }

    fn push_loop(&mut self, soup: &Soup, vertices: Vec<u32>, neighbor: u32) {
        let points: Vec<DVec3> = vertices
            .iter()
            .map(|&v| soup.position(v).as_dvec3())
            .collect();
        let center = points.iter().sum::<DVec3>() / points.len() as f64;
        let next = points.iter().cycle().skip(1);
        let sides = points.iter().zip(next);
        let area: DVec3 = sides.map(|(a, b)| (a - center).cross(b - center)).sum();
        let normal = area.normalize_or_zero();
        let is_flat = normal != DVec3::ZERO
            && points
                .iter()
                .all(|p| normal.dot(p - center).abs() <= self.tolerance);
        self.loops.push(HoleLoop {
            surface: self.surfaces[neighbor as usize],
            vertices,
            area,
            center,
            is_flat,
            neighbor,
        });
    }

    fn loops_of(&self, surface: u32) -> &[HoleLoop] {
        let first = self.loops.partition_point(|hole| hole.surface < surface);
        let end = self.loops.partition_point(|hole| hole.surface <= surface);
        &self.loops[first..end]
    }

    /// The holes of a surface.
    pub(super) fn of(&self, surface: u32) -> Vec<Hole> {
        let hole = |hole: &HoleLoop| Hole {
            center: hole.center.as_vec3(),
            edges: hole.vertices.len(),
        };
        self.loops_of(surface).iter().map(hole).collect()
    }

    /// The faces that close all holes of a surface with these triangles. Topology numbers of new positions go on from
    /// `fresh`.
    pub(super) fn fill(
        &mut self,
        soup: &Soup,
        surface: u32,
        triangles: &[u32],
        fresh: u32,
    ) -> Patch {
        let loops = self.loops_of(surface).to_vec();
        let mut is_done = vec![false; loops.len()];
        let mut patch = Patch::default();
        let mut fresh = fresh;
        for first in 0..loops.len() {
            if is_done[first] {
                continue;
            }
            let group: Vec<usize> = (first..loops.len())
                .filter(|&other| !is_done[other])
                .filter(|&other| other == first || self.is_one_plane(&loops[first], &loops[other]))
                .collect();
            group.iter().for_each(|&hole| is_done[hole] = true);
            let group: Vec<&HoleLoop> = group.into_iter().map(|hole| &loops[hole]).collect();
            self.fill_group(soup, &group, triangles, &mut fresh, &mut patch);
        }
        patch
    }

    fn is_one_plane(&self, a: &HoleLoop, b: &HoleLoop) -> bool {
        let [n, m] = [a, b].map(|hole| hole.area.normalize_or_zero());
        a.is_flat
            && b.is_flat
            && n.dot(m).abs() >= SAME_PLANE
            && n.dot(b.center - a.center).abs() <= 2.0 * self.tolerance
    }

    /// Closes loops that lie in one plane, or a single one.
    fn fill_group(
        &mut self,
        soup: &Soup,
        group: &[&HoleLoop],
        triangles: &[u32],
        fresh: &mut u32,
        patch: &mut Patch,
    ) {
        let rim = group.iter().flat_map(|hole| {
            let next = hole.vertices.iter().cycle().skip(1);
            hole.vertices.iter().zip(next).map(|(&a, &b)| [a, b])
        });
        self.filler.load(&soup.mesh, rim);
        let own = triangles.iter().map(|&t| soup.places(t as usize));
        let patched = patch
            .mesh
            .triangles
            .iter()
            .map(|t| t.map(|v| patch.mesh.topology[v as usize]));
        for [a, b, c] in own.chain(patched) {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                self.filler.exclude_edge(from, to);
            }
            self.filler.exclude_triangle([a, b, c]);
        }
        let normal = group.iter().map(|hole| hole.area).sum::<DVec3>();
        let normal = normal.try_normalize().unwrap_or(DVec3::Y).as_vec3();
        self.filler.run(normal);
        self.append(soup, normal, group[0].neighbor, fresh, patch);
    }

    /// Adds the faces to the patch: flat, otherwise with the attributes of the border.
    fn append(&self, soup: &Soup, normal: Vec3, neighbor: u32, fresh: &mut u32, patch: &mut Patch) {
        let new = self.filler.new_vertices();
        let first = patch.mesh.positions.len() as u32;
        let mut chosen: Vec<u32> = Vec::new();
        let mut corners: Vec<[u32; 3]> = Vec::new();
        for triangle in self.filler.triangles() {
            corners.push(triangle.map(|corner| match corner {
                RimCorner::Vertex(vertex) => {
                    let known = chosen.iter().position(|&v| v == vertex);
                    known.unwrap_or_else(|| {
                        chosen.push(vertex);
                        chosen.len() - 1
                    }) as u32
                }
                RimCorner::New(place) => NONE - place,
            }));
        }
        let middle = first + chosen.len() as u32;
        extend_chosen(
            &mut patch.mesh,
            &soup.mesh,
            &chosen,
            new,
            [new.positions.len(), 0],
        );
        let numbers = chosen
            .iter()
            .map(|&vertex| soup.mesh.topology[vertex as usize]);
        let new_numbers = *fresh..*fresh + new.positions.len() as u32;
        *fresh = new_numbers.end;
        patch.mesh.topology.extend(numbers.chain(new_numbers));
        if !patch.mesh.normals.is_empty() {
            patch.mesh.normals[first as usize..].fill(normal);
        }
        let is_old = |corner: u32| (corner as usize) < chosen.len();
        let vertex = |corner: u32| {
            if is_old(corner) {
                first + corner
            } else {
                middle + (NONE - corner)
            }
        };
        let material = soup.mesh.materials.get(neighbor as usize).copied();
        for triangle in corners {
            let triangle = triangle.map(vertex);
            let [a, b, c] = triangle.map(|v| patch.mesh.positions[v as usize].as_dvec3());
            patch.area += 0.5 * (b - a).cross(c - a).length();
            patch.mesh.triangles.push(triangle);
            patch.mesh.materials.extend(material);
        }
    }
}
