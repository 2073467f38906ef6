//! Triangles that face against their neighbors.

use crate::import::soup::Soup;

/// Turns triangles so that neighbors across an edge of two triangles of one object agree about outside, as far as a surface
/// has two sides; of those that disagree the smaller area is turned. Whether the whole is inside out is asked later.
pub(super) fn face_alike(soup: &mut Soup) {
    let neighbors = neighbors(soup);
    let count = soup.mesh.triangles.len();
    let mut is_turned = vec![None; count];
    let mut members = Vec::new();
    for first in 0..count {
        if is_turned[first].is_some() {
            continue;
        }
        members.clear();
        members.push(first);
        is_turned[first] = Some(false);
        let mut next = 0;
        while next < members.len() {
            let triangle = members[next];
            next += 1;
            for &(across, disagrees) in neighbors[triangle].iter().flatten() {
                if is_turned[across].is_none() {
                    is_turned[across] = is_turned[triangle].map(|turned| turned != disagrees);
                    members.push(across);
                }
            }
        }
        turn_smaller(soup, &members, &is_turned);
    }
}

/// For each triangle those across its edges, and whether the two disagree about outside.
fn neighbors(soup: &Soup) -> Vec<[Option<(usize, bool)>; 3]> {
    let mut neighbors = vec![[None; 3]; soup.mesh.triangles.len()];
    let mut edges: Vec<_> = (soup.sorted_edges().into_iter())
        .map(|(ends, half_edge)| (ends, soup.objects[half_edge as usize / 3], half_edge))
        .collect();
    edges.sort_unstable();
    for run in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        if let [(_, _, a), (_, _, b)] = *run {
            let disagrees = soup.ends(a) == soup.ends(b);
            for (own, other) in [(a, b), (b, a)] {
                neighbors[own as usize / 3][own as usize % 3] =
                    Some((other as usize / 3, disagrees));
            }
        }
    }
    neighbors
}

fn turn_smaller(soup: &mut Soup, members: &[usize], is_turned: &[Option<bool>]) {
    let area = |&triangle: &usize| {
        let [a, b, c] = soup.mesh.triangles[triangle].map(|vertex| soup.position(vertex));
        (b - a).cross(c - a).length()
    };
    let sum = |turned: bool| -> f32 {
        let own = members.iter().filter(|&&t| is_turned[t] == Some(turned));
        own.map(area).sum()
    };
    let smaller = sum(true) <= sum(false);
    for &triangle in members {
        if is_turned[triangle] == Some(smaller) {
            soup.mesh.triangles[triangle].swap(1, 2);
            soup.repairs[triangle].turned += 1;
        }
    }
}
