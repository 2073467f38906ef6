//! Whether a surface is closed, in one pass over its edges.

/// Counts directed edges by their end with the smaller number, keeping its working memory.
///
/// Edges are sorted into one list per vertex (a counting sort), so the time is linear in the number of triangles while
/// few edges meet at each vertex, and never worse than sorting them all.
#[derive(Clone, Debug, Default)]
pub(crate) struct EdgeCensus {
    /// By vertex: where its list begins; while it is filled, where the next edge goes.
    starts: Vec<u32>,
    /// Twice the end with the larger number, plus one if the edge begins there.
    edges: Vec<u32>,
}

impl EdgeCensus {
    /// Whether each directed edge of `triangles` occurs exactly once and so does its reverse.
    ///
    /// `topology` numbers the positions of the vertices, all below `count`.
    pub(crate) fn is_closed(
        &mut self,
        triangles: &[[u32; 3]],
        topology: &[u32],
        count: usize,
    ) -> bool {
        // What an edge and a place in the lists are packed into must hold them.
        if count > u32::MAX as usize / 2 || triangles.len() > u32::MAX as usize / 3 {
            return false;
        }
        self.starts.clear();
        self.starts.resize(count + 1, 0);
        for corners in triangles {
            let [a, b, c] = corners.map(|v| topology[v as usize]);
            for low in [a.min(b), b.min(c), c.min(a)] {
                self.starts[low as usize + 1] += 1;
            }
        }
        // Shifted by one entry: filling a list moves its start to the start of the next.
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        self.fill(triangles, topology);
        let mut first = 0;
        self.starts[..count].iter().all(|&end| {
            let list = &mut self.edges[first..end as usize];
            first = end as usize;
            list.sort_unstable();
            let is_paired = |pair: &[u32]| matches!(*pair, [a, b] if a % 2 == 0 && b == a + 1);
            list.chunks(2).all(is_paired)
        })
    }

    fn fill(&mut self, triangles: &[[u32; 3]], topology: &[u32]) {
        self.edges.clear();
        self.edges.resize(3 * triangles.len(), 0);
        for corners in triangles {
            let [a, b, c] = corners.map(|v| topology[v as usize]);
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let place = &mut self.starts[from.min(to) as usize];
                self.edges[*place as usize] = 2 * from.max(to) + u32::from(from > to);
                *place += 1;
            }
        }
    }
}
