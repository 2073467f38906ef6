//! Borders that nearly meet: points at almost one place, and corners on the middle of a neighbor's edge.

use crate::import::pairing;
use crate::import::pairing::{push_between, split_at};
use crate::import::soup::Soup;
use glam::Vec3;

/// Rounds after which what is still open stays so.
const ROUNDS: usize = 8;

/// Joins border points nearer to each other than `distance` (m) and divides border edges at points of the border that
/// lie on them. Sides of edges are paired before and after.
pub(super) fn close(soup: &mut Soup, distance: f32) {
    for _ in 0..ROUNDS {
        let border = Border::of(soup);
        if border.points.is_empty() {
            return;
        }
        let is_changed =
            join_points(soup, &border, distance) || divide_edges(soup, &border, distance);
        if !is_changed {
            return;
        }
        soup.drop_vanished();
        soup.drop_doubled();
        pairing::pair(soup);
    }
}

/// Divides edges at corners of others that lie on them within `distance` (m), where not as many triangles run along an edge as against it: so that
/// neighbors have whole edges in common before anything is made of that. Faces that were merged into strips have hardly one that is.
pub(super) fn divide_at_corners(soup: &mut Soup, distance: f32) {
    for _ in 0..ROUNDS {
        pairing::find_unbalanced(soup);
        let border = Border::of(soup);
        if border.points.is_empty() || !divide_edges(soup, &border, distance) {
            return;
        }
        soup.drop_vanished();
    }
}

/// The half-edges without another side, and the places at their ends, in the order of x.
struct Border {
    half_edges: Vec<u32>,
    points: Vec<(Vec3, u32)>,
}

impl Border {
    fn of(soup: &Soup) -> Self {
        let half_edges = soup.open_edges();
        let vertices = half_edges.iter().flat_map(|&h| soup.vertices(h));
        let mut points: Vec<(Vec3, u32)> = vertices
            .map(|vertex| (soup.position(vertex), soup.mesh.topology[vertex as usize]))
            .collect();
        points.sort_by(|a, b| a.0.x.total_cmp(&b.0.x).then(a.1.cmp(&b.1)));
        points.dedup_by_key(|&mut (_, place)| place);
        Self { half_edges, points }
    }

    /// The points whose x lies in a range.
    fn between(&self, low: f32, high: f32) -> &[(Vec3, u32)] {
        let first = self.points.partition_point(|(p, _)| p.x < low);
        let end = self.points.partition_point(|(p, _)| p.x <= high);
        &self.points[first..end.max(first)]
    }
}

/// Joins points nearer than `distance`; whether there were any. Each joins one at most, so that chains do not collapse.
fn join_points(soup: &mut Soup, border: &Border, distance: f32) -> bool {
    let mut joined: Vec<(u32, u32, Vec3)> = Vec::new();
    let mut is_busy = vec![false; soup.mesh.topology_count()];
    for (index, &(point, place)) in border.points.iter().enumerate() {
        let later = border.points[index + 1..].iter();
        let near = later.take_while(|(p, _)| p.x - point.x <= distance);
        for &(other, other_place) in near {
            let is_free = !is_busy[place as usize] && !is_busy[other_place as usize];
            if is_free
                && other_place != place
                && other.distance_squared(point) <= distance * distance
            {
                is_busy[place as usize] = true;
                is_busy[other_place as usize] = true;
                joined.push((other_place, place, point));
            }
        }
    }
    joined.sort_unstable_by_key(|&(from, ..)| from);
    for &h in &border.half_edges {
        let [from, _] = soup.ends(h);
        let is_joined = joined
            .binary_search_by_key(&from, |&(from, ..)| from)
            .is_ok();
        soup.repairs[h as usize / 3].joined += usize::from(is_joined);
    }
    for vertex in 0..soup.mesh.positions.len() {
        let place = soup.mesh.topology[vertex];
        if let Ok(found) = joined.binary_search_by_key(&place, |&(from, ..)| from) {
            (soup.mesh.topology[vertex], soup.mesh.positions[vertex]) =
                (joined[found].1, joined[found].2);
        }
    }
    !joined.is_empty()
}

/// Divides border edges at border points within `distance` of their inside; whether there were any.
fn divide_edges(soup: &mut Soup, border: &Border, distance: f32) -> bool {
    let mut is_busy = vec![false; soup.mesh.triangles.len()];
    let mut is_changed = false;
    for &h in &border.half_edges {
        let triangle = h as usize / 3;
        if is_busy[triangle] {
            continue;
        }
        let on = points_on(soup, border, h, distance);
        if on.is_empty() {
            continue;
        }
        is_busy[triangle] = true;
        is_changed = true;
        soup.repairs[triangle].divided += on.len();
        let ends = soup.vertices(h);
        let vertices: Vec<u32> = on
            .into_iter()
            .map(|(t, point, place)| push_between(soup, ends, t, point, place))
            .collect();
        split_at(soup, h, &vertices);
    }
    is_changed
}

/// The border points on a border edge, in order: how far along, where, and their places.
fn points_on(soup: &Soup, border: &Border, half_edge: u32, distance: f32) -> Vec<(f32, Vec3, u32)> {
    let [a, b] = soup.vertices(half_edge).map(|vertex| soup.position(vertex));
    let ends = soup.ends(half_edge);
    let opposite = soup.places(half_edge as usize / 3)[(half_edge as usize + 2) % 3];
    let along = b - a;
    let length = along.length();
    let near = border.between(a.x.min(b.x) - distance, a.x.max(b.x) + distance);
    let mut on: Vec<(f32, Vec3, u32)> = near
        .iter()
        .filter(|(_, place)| !ends.contains(place) && *place != opposite)
        .filter_map(|&(point, place)| {
            let t = (point - a).dot(along) / (length * length);
            let is_inside = t * length > distance && (1.0 - t) * length > distance;
            let is_on = is_inside && (point - a - t * along).length() <= distance;
            is_on.then_some((t, point, place))
        })
        .collect();
    on.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
    // Two points at one place along the edge would make a triangle without area.
    on.dedup_by(|b, a| (b.0 - a.0) * length <= distance);
    on
}
