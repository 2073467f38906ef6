//! Directed edges without a partner, joined into closed loops.

use super::clip::Clip;

const NONE: u32 = u32::MAX;

/// Joins the rim's directed edges into closed loops of vertex numbers.
///
/// No loop visits a topology number twice: where several loops touch, the walk closes a loop as soon as it comes back to
/// a point. The rim is the boundary of a set of triangles, so every point has as many edges in as out, and the walk
/// never gets stuck. Two edges that are each other's reverse cancel.
pub(super) fn loops(clip: &Clip) -> Vec<Vec<u32>> {
    let topology = &clip.vertices.topology;
    let number = |vertex: u32| topology[vertex as usize] as usize;
    let mut first_out = vec![NONE; clip.topology_count as usize];
    let mut next_out = vec![NONE; clip.rim.len()];
    for (edge, &[from, _]) in clip.rim.iter().enumerate() {
        next_out[edge] = first_out[number(from)];
        first_out[number(from)] = edge as u32;
    }

    let mut loops = Vec::new();
    let mut path: Vec<u32> = Vec::new();
    let mut place_in_path = vec![NONE; clip.topology_count as usize];
    for &[start, _] in &clip.rim {
        let mut at = start;
        loop {
            let place = place_in_path[number(at)];
            if place != NONE {
                let closed = path.split_off(place as usize);
                for &vertex in &closed {
                    place_in_path[number(vertex)] = NONE;
                }
                if closed.len() >= 3 {
                    loops.push(closed);
                }
            }
            let edge = first_out[number(at)];
            if edge == NONE {
                break;
            }
            first_out[number(at)] = next_out[edge as usize];
            place_in_path[number(at)] = path.len() as u32;
            path.push(at);
            at = clip.rim[edge as usize][1];
        }
        debug_assert!(path.is_empty(), "the rim of a closed mesh is closed");
    }
    loops
}
