//! `MeshSlicer`: clip, border and cap put together into the two parts of a mesh, in memory that is kept.

use crate::geometry::predicates::{check_plane, length_scale, plane_tolerance};
use crate::geometry::{EdgeCensus, MeshError, TriMesh};
use crate::math::{Plane, tangents};
use crate::slice::attributes;
use crate::slice::attributes::CapStyle;
use crate::slice::border::Border;
use crate::slice::cap::CapFill;
use crate::slice::cap_planes::CapPlanes;
use crate::slice::clip::Clip;
use crate::slice::cut::Cut;
use crate::slice::merge_faces::FaceMerger;
use crate::slice::{Cap, CapNormals, Halves, SliceError, SliceOptions};
use glam::Vec4;

/// Number of a position that was not asked for yet.
const UNUSED: u32 = u32::MAX;

/// Cuts meshes one after the other, keeping its working memory.
#[derive(Clone, Debug, Default)]
pub struct MeshSlicer {
    census: EdgeCensus,
    clip: Clip,
    border: Border,
    cap: CapFill,
    numbers: VertexNumbers,
    merger: FaceMerger,
    /// The caps that were made since the numbers of their faces began.
    pub(super) caps: CapPlanes,
    /// Number of the face that the cap is.
    cap_face: u32,
}

impl MeshSlicer {
    /// As [`slice_mesh`](crate::slice::slice_mesh).
    ///
    /// # Errors
    /// As [`slice_mesh`](crate::slice::slice_mesh).
    pub fn slice(
        &mut self,
        mesh: &TriMesh,
        plane: Plane,
        options: SliceOptions,
    ) -> Result<Cut<Box<Halves>>, SliceError> {
        self.check(mesh, &plane)?;
        self.caps.begin(mesh.faces.first_free(mesh.triangles.len()));
        let mut cut = self.slice_closed(mesh, &plane, options);
        if let Cut::Cut(halves) = &mut cut {
            self.merge_old_faces(mesh, halves);
        }
        Ok(cut)
    }

    /// As [`slice`](Self::slice), into the memory of `halves`: once that and the slicer's own suffice, the cut of a mesh that is no
    /// part of an earlier cut allocates nothing; of others, faces are merged in new memory. Unless the verdict is [`Cut::Cut`], `halves` stay as they are.
    ///
    /// # Errors
    /// As [`slice_mesh`](crate::slice::slice_mesh).
    pub fn slice_into(
        &mut self,
        mesh: &TriMesh,
        plane: Plane,
        options: SliceOptions,
        halves: &mut Halves,
    ) -> Result<Cut, SliceError> {
        self.check(mesh, &plane)?;
        self.caps.begin(mesh.faces.first_free(mesh.triangles.len()));
        let verdict = self.divide(mesh, &plane);
        if verdict.is_cut() {
            self.collect(mesh, &plane, options, halves);
            self.merge_old_faces(mesh, halves);
        }
        Ok(verdict)
    }

    /// Merges what earlier cuts and this one have divided; the new cap is the same for both halves, and stays.
    fn merge_old_faces(&mut self, mesh: &TriMesh, halves: &mut Halves) {
        if !mesh.faces.0.is_empty() {
            for half in [&mut halves.below, &mut halves.above] {
                self.merger.merge(half, Some(self.cap_face));
            }
        }
    }

    fn check(&mut self, mesh: &TriMesh, plane: &Plane) -> Result<(), SliceError> {
        check_plane(plane)?;
        if mesh.triangles.is_empty() {
            return Err(MeshError::Empty.into());
        }
        mesh.check_closed_with(&mut self.census)?;
        Ok(())
    }

    /// As [`slice`](Self::slice), for a mesh that is known to be closed, a checked plane, and numbers of caps that have begun.
    pub(super) fn slice_closed(
        &mut self,
        mesh: &TriMesh,
        plane: &Plane,
        options: SliceOptions,
    ) -> Cut<Box<Halves>> {
        self.divide(mesh, plane).map(|()| {
            let mut halves = Box::default();
            self.collect(mesh, plane, options, &mut halves);
            halves
        })
    }

    /// Finds the triangles of both parts and of the cap.
    pub(super) fn divide(&mut self, mesh: &TriMesh, plane: &Plane) -> Cut {
        let tolerance = plane_tolerance(length_scale(&mesh.aabb()));
        let verdict = self.clip.run(mesh, plane, tolerance);
        if verdict.is_cut() {
            self.border.run(mesh, &self.clip);
            self.cap.run(mesh, &mut self.clip, &self.border, plane);
            self.cap_face = self.caps.add(plane, self.cap.triangles.len());
        }
        verdict
    }

    fn collect(
        &mut self,
        mesh: &TriMesh,
        plane: &Plane,
        options: SliceOptions,
        halves: &mut Halves,
    ) {
        self.collect_below(mesh, plane, options, &mut halves.below);
        self.collect_part(1, mesh, plane, options, &mut halves.above);
        halves.cap = Cap {
            area: self.cap.area,
            loops: self.border.len(),
            triangles: self.cap.triangles.len(),
        };
    }

    /// Collects the part below the plane that [`divide`](Self::divide) found.
    pub(super) fn collect_below(
        &mut self,
        mesh: &TriMesh,
        plane: &Plane,
        options: SliceOptions,
        below: &mut TriMesh,
    ) {
        self.collect_part(0, mesh, plane, options, below);
    }

    /// Collects one part: the vertices that its triangles use, renumbered, and its cap.
    fn collect_part(
        &mut self,
        index: usize,
        mesh: &TriMesh,
        plane: &Plane,
        options: SliceOptions,
        part: &mut TriMesh,
    ) {
        attributes::clear(part);
        self.collect_triangles(index, mesh, part);
        let counts = [self.clip.cut_vertices, self.cap.corners.len()];
        let (chosen, new) = (self.numbers.chosen(), &self.clip.new);
        attributes::extend_chosen(part, mesh, chosen, new, counts);
        part.topology.reserve(part.positions.len() + counts[1]);
        let new = &new.topology[..counts[0]];
        self.numbers
            .extend_topology(part, mesh, new, self.clip.topology_count as usize);
        if options.cap_color.is_some() && mesh.colors.is_empty() {
            part.colors.resize(part.positions.len(), Vec4::ONE);
        }
        let first = self.collect_cap_vertices(index, mesh, plane, options, part);
        let cap = self.cap.triangles.iter().map(|t| t.map(|c| first + c));
        if index == 0 {
            part.triangles.extend(cap);
        } else {
            part.triangles.extend(cap.map(|[a, b, c]| [a, c, b]));
        }
        self.collect_materials(index, mesh, options.cap_material, part);
        self.collect_faces(index, mesh, options, part);
        part.known_closed.set();
    }

    fn collect_triangles(&mut self, index: usize, mesh: &TriMesh, part: &mut TriMesh) {
        let (whole, cut) = (&self.clip.whole[index], &self.clip.cut[index]);
        part.triangles
            .reserve(whole.len() + cut.len() + self.cap.triangles.len());
        let numbers = &mut self.numbers;
        numbers.reset(mesh.positions.len());
        part.triangles.extend(whole.iter().map(|&t| {
            let [a, b, c] = mesh.triangles[t as usize];
            [numbers.of(a), numbers.of(b), numbers.of(c)]
        }));
        let old_vertices = self.clip.old_vertices;
        for corner in cut.iter().flat_map(|cut| cut.corners) {
            if corner < old_vertices {
                numbers.of(corner);
            }
        }
        let first_new = numbers.count as u32;
        part.triangles.extend(cut.iter().map(|cut| {
            cut.corners
                .map(|corner| match corner.checked_sub(old_vertices) {
                    None => numbers.of(corner),
                    Some(new) => first_new + new,
                })
        }));
        self.sheets_first(index, &mut part.triangles);
        let sheets = self.clip.sheets[index];
        part.sheets = (sheets.whole + sheets.cut) as u32;
    }

    /// Brings a list of whole triangles and then cut ones into the order of a mesh, whose sheets come first.
    fn sheets_first<T>(&self, index: usize, list: &mut [T]) {
        let sheets = self.clip.sheets[index];
        let whole = self.clip.whole[index].len();
        list[sheets.whole..whole + sheets.cut].rotate_left(whole - sheets.whole);
    }

    /// Appends the vertices of the cap; returns the number of the first.
    fn collect_cap_vertices(
        &mut self,
        index: usize,
        mesh: &TriMesh,
        plane: &Plane,
        options: SliceOptions,
        part: &mut TriMesh,
    ) -> u32 {
        let style = CapStyle {
            normal: if index == 0 {
                plane.normal
            } else {
                -plane.normal
            },
            normals: options.cap_normals,
            tangents: tangents(plane.normal),
            color: options.cap_color,
        };
        let first = part.positions.len() as u32;
        for &vertex in &self.cap.corners {
            let (source, place) = self.clip.find(mesh, vertex);
            let topology = self.numbers.position(source.topology[place]);
            attributes::push_cap(part, source, place, topology, &style);
        }
        first
    }

    /// The faces of the triangles: those that they are parts of, and one for the cap if its attributes are those of one face.
    fn collect_faces(
        &self,
        index: usize,
        mesh: &TriMesh,
        options: SliceOptions,
        part: &mut TriMesh,
    ) {
        let whole = self.clip.whole[index].iter().copied();
        let cut = self.clip.cut[index].iter().map(|cut| cut.source);
        let faces = whole.chain(cut).map(|triangle| mesh.faces.of(triangle));
        part.faces.0.extend(faces);
        self.sheets_first(index, &mut part.faces.0);
        let first_corner = part.positions.len() - self.cap.corners.len();
        let is_flat_shaded = part.normals.is_empty() || options.cap_normals == CapNormals::Flat;
        let mut colors = part.colors.iter().skip(first_corner);
        let first_color = colors.next();
        let is_one = is_flat_shaded && colors.all(|color| Some(color) == first_color);
        let triangles = 0..self.cap.triangles.len() as u32;
        let number = |place: u32| self.cap_face + if is_one { 0 } else { place };
        part.faces.0.extend(triangles.map(number));
    }

    fn collect_materials(
        &self,
        index: usize,
        mesh: &TriMesh,
        cap_material: Option<u16>,
        part: &mut TriMesh,
    ) {
        if mesh.materials.is_empty() && cap_material.is_none() {
            return;
        }
        let slot = |triangle: u32| mesh.materials.get(triangle as usize).copied();
        let whole = self.clip.whole[index].iter().copied();
        let cut = self.clip.cut[index].iter().map(|cut| cut.source);
        part.materials
            .extend(whole.chain(cut).map(|t| slot(t).unwrap_or(0)));
        self.sheets_first(index, &mut part.materials);
        part.materials
            .resize(part.triangles.len(), cap_material.unwrap_or(0));
    }
}

/// What vertices and positions of a mesh are called in a part of it: numbers in the order in which they are first asked
/// for.
#[derive(Clone, Debug, Default)]
pub(super) struct VertexNumbers {
    /// By old vertex.
    table: Vec<u32>,
    /// The old vertices that have numbers, in order, and behind so many nothing of use.
    chosen: Vec<u32>,
    count: usize,
    positions: Positions,
}

impl VertexNumbers {
    /// Forgets all numbers; there are `vertices` old ones.
    pub(super) fn reset(&mut self, vertices: usize) {
        self.table.clear();
        self.table.resize(vertices, UNUSED);
        // One more, for the last one that is asked for again.
        self.chosen.resize(vertices + 1, 0);
        self.count = 0;
    }

    /// The old vertices that were asked for, in order.
    pub(super) fn chosen(&self) -> &[u32] {
        &self.chosen[..self.count]
    }

    /// The new number of a vertex.
    ///
    /// Without branches, because there is no guessing which vertex comes for the first time.
    #[inline]
    pub(super) fn of(&mut self, old: u32) -> u32 {
        let entry = &mut self.table[old as usize];
        let is_first_time = *entry == UNUSED;
        self.chosen[self.count] = old;
        *entry = if is_first_time {
            self.count as u32
        } else {
            *entry
        };
        self.count += usize::from(is_first_time);
        *entry
    }

    /// Gives `part` the topology numbers of all vertices asked for, and of new ones with the old numbers `new`; all old
    /// numbers are below `count`.
    pub(super) fn extend_topology(
        &mut self,
        part: &mut TriMesh,
        mesh: &TriMesh,
        new: &[u32],
        count: usize,
    ) {
        let Self {
            chosen, positions, ..
        } = self;
        positions.reset(count);
        let of_old = chosen[..self.count]
            .iter()
            .map(|&vertex| mesh.topology[vertex as usize]);
        let all = of_old.chain(new.iter().copied());
        part.topology.extend(all.map(|number| positions.of(number)));
    }

    /// The new number of a position.
    pub(super) fn position(&mut self, old: u32) -> u32 {
        self.positions.of(old)
    }
}

/// New numbers of positions, in the order in which old ones are first asked for.
#[derive(Clone, Debug, Default)]
struct Positions {
    table: Vec<u32>,
    used: u32,
}

impl Positions {
    fn reset(&mut self, count: usize) {
        self.table.clear();
        self.table.resize(count, UNUSED);
        self.used = 0;
    }

    #[inline]
    fn of(&mut self, old: u32) -> u32 {
        let entry = &mut self.table[old as usize];
        let is_first_time = *entry == UNUSED;
        *entry = if is_first_time { self.used } else { *entry };
        self.used += u32::from(is_first_time);
        *entry
    }
}
