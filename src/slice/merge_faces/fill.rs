//! The outlines of faces to triangles, and the merged mesh.

use crate::geometry::TriMesh;
use crate::slice::attributes;
use crate::slice::merge_faces::{FaceMerger, NONE};
use crate::slice::rim_fill::RimCorner;
use glam::DVec3;

impl FaceMerger {
    /// Writes the merged mesh; whether there is anything to merge.
    pub(super) fn fill(&mut self, mesh: &TriMesh, kept: Option<u32>) -> bool {
        let changed = self.find_changed(mesh, kept);
        if changed.is_empty() {
            return false;
        }
        let mut triangles = std::mem::take(&mut self.merged.triangles);
        triangles.clear();
        triangles.extend_from_slice(&mesh.triangles[..mesh.sheets()]);
        let mut sources: Vec<u32> = (0..mesh.sheets).collect();
        let mut added = TriMesh::default();
        let old = mesh.positions.len() as u32;
        let mut next_changed = changed.iter().copied().peekable();
        for number in 0..self.faces.len() {
            let [first, end] = self.faces[number].triangles.map(|t| t as usize);
            if next_changed.next_if_eq(&number).is_some() {
                self.fill_face(mesh, number, &mut triangles, &mut added, old);
            } else {
                triangles.extend(
                    self.order[first..end]
                        .iter()
                        .map(|&t| mesh.triangles[t as usize]),
                );
            }
            let source = self.order[first];
            sources.resize(triangles.len(), source);
        }
        let mut all = TriMesh {
            sheets: mesh.sheets,
            ..TriMesh::default()
        };
        let count = added.positions.len();
        self.compact(mesh, &added, &mut all, triangles, [old as usize, count]);
        all.materials.extend(
            sources
                .iter()
                .filter_map(|&t| mesh.materials.get(t as usize)),
        );
        all.faces
            .0
            .extend(sources.iter().map(|&t| mesh.faces.0[t as usize]));
        if mesh.known_closed.is_set() {
            all.known_closed.set();
        }
        self.merged = all;
        true
    }

    /// The faces that have triangles or corners too many. Takes note of the inner edges of the others, which must not be made again.
    fn find_changed(&mut self, mesh: &TriMesh, kept: Option<u32>) -> Vec<usize> {
        let mut changed = Vec::new();
        for number in 0..self.faces.len() {
            let face = self.faces[number];
            let [first, end] = face.triangles.map(|t| t as usize);
            let own = &self.order[first..end];
            let is_kept = kept == Some(mesh.faces.0[own[0] as usize]);
            // A polygon of n corners with h holes has n + 2 h - 2 triangles.
            let outline = face.outline[1] - face.outline[0];
            let fewest = (outline + 2 * face.loops).saturating_sub(4);
            let is_whole = face.border[1] - face.border[0] == outline;
            if is_kept || (is_whole && own.len() as u32 <= fewest) {
                self.note_edges(mesh, first..end);
            } else {
                changed.push(number);
            }
        }
        changed
    }

    /// The vertices that `triangles` use, renumbered in the order of their use.
    fn compact(
        &mut self,
        mesh: &TriMesh,
        added: &TriMesh,
        all: &mut TriMesh,
        mut triangles: Vec<[u32; 3]>,
        [old, new]: [usize; 2],
    ) {
        let mut renumber = vec![NONE; old + new];
        let (mut chosen, mut chosen_new) = (Vec::new(), Vec::new());
        for &vertex in triangles.iter().flatten() {
            let entry = &mut renumber[vertex as usize];
            if *entry == NONE {
                *entry = 0;
                match (vertex as usize).checked_sub(old) {
                    None => chosen.push(vertex),
                    Some(place) => chosen_new.push(place as u32),
                }
            }
        }
        for (number, &vertex) in (0..).zip(&chosen) {
            renumber[vertex as usize] = number;
        }
        for (number, &place) in (chosen.len() as u32..).zip(&chosen_new) {
            renumber[old + place as usize] = number;
        }
        for corner in triangles.iter_mut().flatten() {
            *corner = renumber[*corner as usize];
        }
        attributes::extend_chosen(all, mesh, &chosen, &TriMesh::default(), [0, 0]);
        attributes::extend_chosen(all, added, &chosen_new, &TriMesh::default(), [0, 0]);
        let numbers = chosen.iter().map(|&v| mesh.topology[v as usize]);
        let numbers = numbers.chain(chosen_new.iter().map(|&v| added.topology[v as usize]));
        self.next.clear();
        self.next.resize(self.points.len() + new, NONE);
        let mut count = 0;
        for number in numbers {
            let entry = &mut self.next[number as usize];
            if *entry == NONE {
                *entry = count;
                count += 1;
            }
            all.topology.push(*entry);
        }
        all.triangles = triangles;
    }

    /// Takes note of the inner edges of triangles that stay.
    fn note_edges(&mut self, mesh: &TriMesh, range: std::ops::Range<usize>) {
        if range.len() < 2 {
            return;
        }
        for &t in &self.order[range] {
            let [a, b, c] = mesh.triangles[t as usize].map(|v| mesh.topology[v as usize]);
            for (from, to) in [(a, b), (b, c), (c, a)] {
                if self.edges.get(from, to).is_none() {
                    self.edges.insert(from, to, 3);
                }
            }
        }
    }

    /// Fills the outline of a face: a fan where one corner sees all others, otherwise as caps are filled.
    fn fill_face(
        &mut self,
        mesh: &TriMesh,
        number: usize,
        triangles: &mut Vec<[u32; 3]>,
        added: &mut TriMesh,
        old: u32,
    ) {
        let face = self.faces[number];
        let outline = face.outline[0] as usize..face.outline[1] as usize;
        let [first, end] = face.triangles.map(|t| t as usize);
        let area: DVec3 = self.order[first..end]
            .iter()
            .map(|&t| area_vector(mesh, mesh.triangles[t as usize]))
            .sum();
        let normal = area.normalize_or_zero();
        let begin = triangles.len();
        if !(face.loops == 1
            && face.is_simple
            && self.fan(mesh, outline.clone(), normal, triangles))
        {
            triangles.truncate(begin);
            self.filler
                .load(mesh, self.outline[outline.clone()].iter().copied());
            for &[from, _] in &self.outline[outline] {
                let from = mesh.topology[from as usize];
                let filler = &mut self.filler;
                self.edges
                    .for_each_above(from, |to| filler.exclude_edge(from, to));
            }
            self.filler.run(normal.as_vec3());
            let first_new = old + added.positions.len() as u32;
            let corner = |corner: RimCorner| match corner {
                RimCorner::Vertex(vertex) => vertex,
                RimCorner::New(place) => first_new + place,
            };
            triangles.extend(self.filler.triangles().map(|t| t.map(corner)));
            let new = self.filler.new_vertices();
            let count = new.positions.len();
            attributes::extend_chosen(added, mesh, &[], new, [count, 0]);
            let fresh = self.points.len() as u32 + added.topology.len() as u32;
            added.topology.extend(fresh..fresh + count as u32);
        }
        let numbers = |vertex: u32| mesh.topology.get(vertex as usize).copied();
        for t in &triangles[begin..] {
            for k in 0..3 {
                if let (Some(a), Some(b)) = (numbers(t[k]), numbers(t[(k + 1) % 3]))
                    && self.edges.get(a, b).is_none()
                {
                    self.edges.insert(a, b, 3);
                }
            }
        }
    }

    /// A fan over an outline of one loop from the first corner from which all triangles face along `normal`, and whose
    /// diagonals are free.
    fn fan(
        &mut self,
        mesh: &TriMesh,
        outline: std::ops::Range<usize>,
        normal: DVec3,
        triangles: &mut Vec<[u32; 3]>,
    ) -> bool {
        let own = &self.outline[outline];
        let number = |vertex: u32| mesh.topology[vertex as usize];
        for (place, &[from, _]) in (0_u32..).zip(own) {
            self.next[number(from) as usize] = place;
        }
        self.chain.clear();
        let mut at = own[0][0];
        for _ in 0..own.len() {
            self.chain.push(at);
            at = own[self.next[number(at) as usize] as usize][1];
        }
        let n = self.chain.len();
        for apex in 0..n {
            let corner = |i: usize| self.chain[(apex + i) % n];
            let faces_along = |i: usize| {
                let area = area_vector(mesh, [corner(0), corner(i), corner(i + 1)]);
                let longest = (1..3).map(|k| {
                    let [a, b] = [corner(0), corner(i + k - 1)]
                        .map(|v| mesh.positions[v as usize].as_dvec3());
                    a.distance_squared(b)
                });
                let longest = longest.fold(0.0, f64::max);
                // A triangle without area is none worth making.
                area.dot(normal) > 1e-7 * longest
            };
            let is_free = |i: usize| {
                self.edges
                    .get(number(corner(0)), number(corner(i)))
                    .is_none()
            };
            if (1..n - 1).all(faces_along) && (2..n - 1).all(is_free) {
                triangles.extend((1..n - 1).map(|i| [corner(0), corner(i), corner(i + 1)]));
                return true;
            }
        }
        false
    }
}

/// Twice the area of a triangle along its normal, m2.
fn area_vector(mesh: &TriMesh, triangle: [u32; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|v| mesh.positions[v as usize].as_dvec3());
    (b - a).cross(c - a)
}
