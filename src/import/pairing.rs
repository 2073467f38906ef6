//! The two sides of each edge, where two triangles or more meet; and surfaces that only touch, taken apart.

use crate::disjoint_sets::DisjointSets;
use crate::import::soup::{NONE, Soup};
use crate::slice::attributes::extend_chosen;
use glam::DVec3;
use std::collections::HashMap;

/// A full turn, where an angle is measured by the sum of the coordinates' sizes and not by the circle: nothing but the order
/// matters, and this is the same everywhere.
const TURN: f64 = 4.0;

/// Triangles at one edge whose directions differ by less than this (of [`TURN`]) lie on each other.
const SAME_DIRECTION: f64 = 1e-4;

/// Finds the other side of each half-edge: within its object, then among what is left of all.
///
/// Where two triangles meet they are the two sides. Where more meet, the solid between them decides: going around the edge
/// one enters it through a triangle and leaves it through the next.
pub(super) fn pair(soup: &mut Soup) {
    soup.twins.clear();
    soup.twins.resize(3 * soup.mesh.triangles.len(), NONE);
    for run in soup.sorted_edges().chunk_by(|a, b| a.0 == b.0) {
        let mut half_edges: Vec<u32> = run.iter().map(|&(_, half_edge)| half_edge).collect();
        half_edges.sort_by_key(|&h| (soup.objects[h as usize / 3], h));
        let object = |h: &u32| soup.objects[*h as usize / 3];
        let groups: Vec<Vec<u32>> = half_edges
            .chunk_by(|a, b| object(a) == object(b))
            .map(<[u32]>::to_vec)
            .collect();
        for group in &groups {
            pair_group(soup, group);
        }
        half_edges.retain(|&h| soup.twins[h as usize] == NONE);
        pair_group(soup, &half_edges);
    }
}

/// Leaves those half-edges without another side along whose edge not as many run one way as the other; the others get some side or other.
pub(super) fn find_unbalanced(soup: &mut Soup) {
    soup.twins.clear();
    soup.twins.resize(3 * soup.mesh.triangles.len(), NONE);
    for run in soup.sorted_edges().chunk_by(|a, b| a.0 == b.0) {
        let is_along = |half_edge: u32| soup.ends(half_edge)[0] == run[0].0[0];
        let along = run.iter().filter(|&&(_, h)| is_along(h)).count();
        if 2 * along == run.len() {
            run.iter().for_each(|&(_, h)| soup.twins[h as usize] = h);
        }
    }
}

fn pair_group(soup: &mut Soup, group: &[u32]) {
    match *group {
        [] | [_] => {}
        [a, b] => {
            if soup.ends(a) != soup.ends(b) {
                join(soup, a, b);
            }
        }
        _ => {
            for (a, b) in pairs_around(soup, group) {
                join(soup, a, b);
                soup.repairs[a as usize / 3].paired += 1;
            }
        }
    }
}

fn join(soup: &mut Soup, a: u32, b: u32) {
    soup.twins[a as usize] = b;
    soup.twins[b as usize] = a;
}

/// The pairs of half-edges at one edge between which the solid is.
///
/// Seen along the edge from its end with the smaller number, with angles counter-clockwise: a triangle whose half-edge runs
/// along has the solid on the side of smaller angles, one that runs against on that of larger ones. So walking around, a
/// half-edge against opens a wedge of solid, one along closes the last one that is open.
fn pairs_around(soup: &Soup, group: &[u32]) -> Vec<(u32, u32)> {
    let along = |h: u32| {
        let [from, to] = soup.ends(h);
        from < to
    };
    let mut around: Vec<(f64, bool, u32)> = (angles(soup, group).into_iter())
        .zip(group)
        .map(|(angle, &h)| (angle, along(h), h))
        .collect();
    around.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
    // The widest gap is where the walk begins, so that none of those that lie on each other are torn apart.
    let n = around.len();
    let gap = |i: usize| (around[i].0 - around[(i + n - 1) % n].0).rem_euclid(TURN);
    let start = (0..n)
        .max_by(|&a, &b| gap(a).total_cmp(&gap(b)))
        .unwrap_or(0);
    around.rotate_left(start);
    // Of those that lie on each other the closing ones come first: a wedge without thickness is none.
    let mut first = 0;
    for i in 1..=n {
        let apart = |i: usize| (around[i].0 - around[i - 1].0).rem_euclid(TURN) > SAME_DIRECTION;
        if i == n || apart(i) {
            around[first..i].sort_by_key(|&(_, along, h)| (!along, h));
            first = i;
        }
    }
    let mut pairs = Vec::new();
    let (mut open, mut is_paired) = (Vec::new(), vec![false; n]);
    for place in (0..n).chain(0..n) {
        let (_, along, h) = around[place];
        if is_paired[place] || open.contains(&place) {
            continue;
        }
        if !along {
            open.push(place);
        } else if let Some(opener) = open.pop() {
            is_paired[place] = true;
            is_paired[opener] = true;
            pairs.push((around[opener].2, h));
        }
    }
    pairs
}

/// The directions in which the triangles of half-edges on one edge lie around it, of [`TURN`].
fn angles(soup: &Soup, group: &[u32]) -> Vec<f64> {
    let position = |vertex: u32| soup.position(vertex).as_dvec3();
    let [mut a, mut b] = soup.vertices(group[0]).map(position);
    let [from, to] = soup.ends(group[0]);
    if from > to {
        std::mem::swap(&mut a, &mut b);
    }
    let axis = (b - a).normalize_or(DVec3::X);
    let u = axis.any_orthonormal_vector();
    let v = axis.cross(u);
    let angle = |&h: &u32| {
        let opposite = soup.mesh.triangles[h as usize / 3][(h as usize + 2) % 3];
        let out = position(opposite) - a;
        let (x, y) = (u.dot(out), v.dot(out));
        let slope = y / (x.abs() + y.abs()).max(f64::MIN_POSITIVE);
        if x < 0.0 { 2.0 - slope } else { slope }
    };
    group.iter().map(angle).collect()
}

/// Numbers positions anew, by surface: corners at one place have one number if a way leads from one to the other across
/// edges whose two sides are known. Surfaces that only touch are taken apart by that. Then edges that have one number twice
/// are divided, and what is left of the twins is found by number.
pub(super) fn number_fans(soup: &mut Soup) {
    loop {
        assign_fans(soup);
        if !join_reversed(soup) {
            break;
        }
    }
    divide_repeated(soup);
    pair_by_number(soup);
}

/// Gives each fan of corners a number, and each vertex of several fans a copy for each.
fn assign_fans(soup: &mut Soup) {
    let corners = 3 * soup.mesh.triangles.len();
    let mut fans = DisjointSets::new(corners);
    let next = |h: u32| h - h % 3 + (h + 1) % 3;
    for (h, &twin) in (0_u32..).zip(&soup.twins) {
        if twin != NONE {
            fans.join(h, next(twin));
            fans.join(next(h), twin);
        }
    }
    let (mut numbers, mut copies) = (HashMap::new(), HashMap::new());
    let (mut chosen, mut topology) = (Vec::new(), Vec::new());
    let mesh = &mut soup.mesh;
    for (corner, vertex) in (0_u32..).zip(mesh.triangles.iter_mut().flatten()) {
        let count = numbers.len() as u32;
        let number = *numbers.entry(fans.root(corner)).or_insert(count);
        let copy = chosen.len() as u32;
        let old = *vertex;
        *vertex = *copies.entry((old, number)).or_insert_with(|| {
            chosen.push(old);
            topology.push(number);
            copy
        });
    }
    let old = std::mem::take(mesh);
    extend_chosen(
        mesh,
        &old,
        &chosen,
        &crate::geometry::TriMesh::default(),
        [0, 0],
    );
    mesh.topology = topology;
    mesh.triangles = old.triangles;
    mesh.materials = old.materials;
}

/// Joins open half-edges that are each other's reverse; whether there were any.
fn join_reversed(soup: &mut Soup) -> bool {
    let open: HashMap<[u32; 2], u32> = (soup.open_edges().into_iter())
        .map(|h| (soup.ends(h), h))
        .collect();
    let mut found = false;
    for h in soup.open_edges() {
        let [from, to] = soup.ends(h);
        let reverse = open.get(&[to, from]).copied();
        let is_open = |h: u32| soup.twins[h as usize] == NONE;
        if let Some(reverse) = reverse.filter(|&r| is_open(r) && is_open(h)) {
            join(soup, h, reverse);
            found = true;
        }
    }
    found
}

/// Where several pairs of triangles have one edge by number, all but the first get a corner in its middle.
fn divide_repeated(soup: &mut Soup) {
    loop {
        let mut marked: Vec<[u32; 2]> = Vec::new();
        for run in soup.sorted_edges().chunk_by(|a, b| a.0 == b.0) {
            let mut sides: Vec<[u32; 2]> = (run.iter())
                .map(|&(_, h)| [h, soup.twins[h as usize]])
                .filter(|&[h, twin]| h < twin)
                .collect();
            sides.sort_unstable();
            marked.extend(sides.into_iter().skip(1));
        }
        // One edge of a triangle at a time; the others come in the next round.
        let mut is_busy = vec![false; soup.mesh.triangles.len()];
        marked.retain(|sides| {
            let mut triangles = sides
                .iter()
                .filter(|&&h| h != NONE)
                .map(|h| *h as usize / 3);
            let is_free = triangles.clone().all(|t| !is_busy[t]);
            if is_free {
                triangles.by_ref().for_each(|t| is_busy[t] = true);
            }
            is_free
        });
        if marked.is_empty() {
            return;
        }
        for sides in marked {
            divide(soup, sides);
        }
        rejoin(soup);
    }
}

/// Divides the triangles of an edge at its middle.
fn divide(soup: &mut Soup, sides: [u32; 2]) {
    let number = soup.mesh.topology_count() as u32;
    let mut middle = None;
    for half_edge in sides.into_iter().filter(|&h| h != NONE) {
        let [a, b] = soup.vertices(half_edge);
        let at = *middle.get_or_insert(0.5 * (soup.position(a) + soup.position(b)));
        let vertex = push_between(soup, [a, b], 0.5, at, number);
        split_at(soup, half_edge, &[vertex]);
        soup.repairs[half_edge as usize / 3].paired += 1;
    }
}

/// Adds a vertex between two others.
pub(super) fn push_between(
    soup: &mut Soup,
    ends: [u32; 2],
    t: f32,
    position: glam::Vec3,
    number: u32,
) -> u32 {
    let mut one = crate::geometry::TriMesh::default();
    crate::slice::attributes::push_between(&mut one, &soup.mesh, ends, t, position, number);
    let mesh = &mut soup.mesh;
    mesh.positions.append(&mut one.positions);
    mesh.normals.append(&mut one.normals);
    mesh.colors.append(&mut one.colors);
    mesh.uvs.append(&mut one.uvs);
    mesh.topology.append(&mut one.topology);
    mesh.positions.len() as u32 - 1
}

/// Divides the triangle of a half-edge at vertices that lie along it.
pub(super) fn split_at(soup: &mut Soup, half_edge: u32, vertices: &[u32]) {
    let triangle = half_edge as usize / 3;
    let [a, b] = soup.vertices(half_edge);
    let c = soup.mesh.triangles[triangle][(half_edge as usize + 2) % 3];
    let Some(&first) = vertices.first() else {
        return;
    };
    soup.mesh.triangles[triangle] = [a, first, c];
    let ends = vertices[1..].iter().copied().chain([b]);
    for (&from, to) in vertices.iter().zip(ends) {
        soup.push_like([from, to, c], triangle);
    }
}

/// Finds the twins again after triangles were divided: those that still fit stay, the rest is found among what is left.
fn rejoin(soup: &mut Soup) {
    let old = std::mem::take(&mut soup.twins);
    soup.twins.resize(3 * soup.mesh.triangles.len(), NONE);
    let fits = |soup: &Soup, a: u32, b: u32| {
        let ([a_from, a_to], [b_from, b_to]) = (soup.ends(a), soup.ends(b));
        a_from == b_to && a_to == b_from
    };
    for (h, &twin) in (0_u32..).zip(&old) {
        if twin != NONE && h < twin && fits(soup, h, twin) {
            join(soup, h, twin);
        }
    }
    join_reversed(soup);
}

/// Twins by number alone: an edge has one half-edge in each direction at most, or none of them is sure.
fn pair_by_number(soup: &mut Soup) {
    soup.twins.clear();
    soup.twins.resize(3 * soup.mesh.triangles.len(), NONE);
    for run in soup.sorted_edges().chunk_by(|a, b| a.0 == b.0) {
        if let [(_, a), (_, b)] = *run
            && soup.ends(a) != soup.ends(b)
        {
            join(soup, a, b);
        }
    }
}
