//! Which pixels a triangle covers, and work spread over the processor's cores.

use glam::{Vec2, Vec3};
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Visits the pixels of `rows` whose centers `triangle` covers, with the value of its `z` there.
///
/// `x` and `y` count pixels, `z` has to be linear over the picture (an inverse depth, or a parallel projection). A
/// center on an edge counts for both triangles that share the edge: the depth test makes one of them win.
pub fn fill_triangle(
    triangle: &[Vec3; 3],
    width: usize,
    rows: Range<usize>,
    mut visit: impl FnMut(usize, usize, f32),
) {
    let [a, b, c] = *triangle;
    let (ab, ac) = (b - a, c - a);
    let area = ab.x * ac.y - ab.y * ac.x;
    if area == 0.0 || !area.is_finite() {
        return;
    }
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    // Pixel i has its center at i + 0.5; a cast to usize saturates, so what lies outside is cut off.
    let span = |low: f32, high: f32, range: Range<usize>| {
        let first = (low - 0.5).ceil() as usize;
        let end = (high + 0.5).floor().max(0.0) as usize;
        first.max(range.start)..end.min(range.end)
    };
    let columns = span(low.x, high.x, 0..width);
    // Weights of b and c. Both change by a constant per pixel; the slack closes cracks left by rounding.
    const SLACK: f32 = 1e-5;
    let (step_b, step_c) = (ac.y / area, -ab.y / area);
    for y in span(low.y, high.y, rows) {
        let d = Vec2::new(columns.start as f32, y as f32) + 0.5 - a.truncate();
        let start_b = (d.x * ac.y - d.y * ac.x) / area;
        let start_c = (d.y * ab.x - d.x * ab.y) / area;
        for x in columns.clone() {
            let i = (x - columns.start) as f32;
            let (wb, wc) = (start_b + i * step_b, start_c + i * step_c);
            if wb >= -SLACK && wc >= -SLACK && wb + wc <= 1.0 + SLACK {
                visit(x, y, a.z + wb * ab.z + wc * ac.z);
            }
        }
    }
}

/// `[work(0), work(1), .., work(count - 1)]`, computed on all cores.
pub fn parallel<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::with_capacity(count));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads.min(count) {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    if i >= count {
                        break;
                    }
                    let result = work(i);
                    done.lock()
                        .expect("no thread panics here")
                        .push((i, result));
                }
            });
        }
    });
    let mut done = done.into_inner().expect("no thread panics here");
    done.sort_unstable_by_key(|(i, _)| *i);
    done.into_iter().map(|(_, result)| result).collect()
}
