//! Closing the caps of cuts: the library's against `earcutr` and `spade`, by what is wrong with the caps and by time.
//!
//! `cargo run --release --bin caps` prints a table. All get the same borders, those that the library's slicer finds, in the
//! same numbers. What a cap must do is judged here and not by any of them: each border edge is used once, each other edge
//! once from either side, no triangle faces backwards, and the area is that of the border.

#[path = "../../../../../tests/common/dice.rs"]
mod dice;
mod families;
mod others;

use bevy_cleave::geometry::TriMesh;
use bevy_cleave::math::Plane;
use bevy_cleave::slice::{Cut, MeshSlicer, SliceOptions};
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use weigh::cpu_us;

/// A border: points in the plane, loops over them (outer ones counter-clockwise, holes clockwise).
#[derive(Clone, Debug, Default)]
pub(crate) struct Border {
    points: Vec<DVec2>,
    loops: Vec<Vec<u32>>,
}

/// Triangles over the points of a border.
type Cap = Vec<[u32; 3]>;

/// What is wrong with a cap.
#[derive(Clone, Copy, Debug, Default)]
struct Faults {
    /// The part would not be closed.
    open: bool,
    /// More than a millionth of the area is missing or twice there.
    area: bool,
    /// More than a millionth of the area faces backwards.
    flipped: bool,
}

/// One who fills borders.
#[derive(Clone, Debug, Default)]
struct Tally {
    none: usize,
    open: usize,
    area: usize,
    flipped: usize,
    us: f64,
}

fn main() {
    println!("| borders | points | | no answer | open | wrong area | flipped | us each |");
    println!("|---|---|---|---|---|---|---|---|");
    for family in families::all() {
        let mut tallies = [(); 3].map(|()| Tally::default());
        let mut points = 0;
        for (mesh, plane) in &family.cuts {
            let mut slicer = MeshSlicer::default();
            let cut = || slicer.slice(mesh, *plane, SliceOptions::default());
            let (us, slice) = least_time(cut);
            let Ok(Cut::Cut(halves)) = slice else {
                continue;
            };
            let (border, ours) = split(&halves.below, halves.cap.triangles, plane);
            points += border.points.len();
            let (earcut_us, earcut) = least_time(|| others::earcut(&border));
            let (spade_us, spade) = least_time(|| others::spade(&border));
            let answers = [(us, Some(ours)), (earcut_us, earcut), (spade_us, spade)];
            for (tally, (us, cap)) in tallies.iter_mut().zip(answers) {
                tally.add(us, cap.map(|cap| judge(&border, &cap)));
            }
        }
        let count = family.cuts.len() as f64;
        let (name, mean) = (family.name, points as f64 / count);
        let names = [
            "the whole cut, ours",
            "earcutr, cap only",
            "spade, cap only",
        ];
        for (who, t) in names.iter().zip(tallies) {
            let Tally {
                none,
                open,
                area,
                flipped,
                us,
            } = t;
            println!(
                "| {count} {name} | {mean:.0} | {who} | {none} | {open} | {area} | {flipped} | {:.1} |",
                us / count
            );
        }
    }
}

/// The outcome of some work, and the least of three times, us.
fn least_time<T>(mut work: impl FnMut() -> T) -> (f64, T) {
    let mut timed = || {
        let start = cpu_us();
        let outcome = work();
        (cpu_us() - start, outcome)
    };
    let first = timed();
    let second = timed();
    let (us, outcome) = timed();
    (us.min(first.0).min(second.0), outcome)
}

impl Tally {
    fn add(&mut self, us: f64, faults: Option<Faults>) {
        self.us += us;
        let Some(faults) = faults else {
            self.none += 1;
            return;
        };
        self.open += usize::from(faults.open);
        self.area += usize::from(faults.area);
        self.flipped += usize::from(faults.flipped);
    }
}

/// The border that the last `count` triangles of a part fill, and these in its numbers.
fn split(part: &TriMesh, count: usize, plane: &Plane) -> (Border, Cap) {
    let topology = part.topology();
    let (rest, cap) = part.triangles().split_at(part.triangles().len() - count);
    let rest: Vec<_> = rest
        .iter()
        .map(|t| t.map(|v| topology[v as usize]))
        .collect();
    let mut place = HashMap::new();
    for (vertex, &number) in topology.iter().enumerate() {
        place.entry(number).or_insert(part.positions()[vertex]);
    }
    let edges = |t: &[u32; 3]| [0, 1, 2].map(|k| (t[k], t[(k + 1) % 3]));
    let all: std::collections::HashSet<_> = rest.iter().flat_map(edges).collect();
    let mut open: Vec<_> = rest
        .iter()
        .flat_map(edges)
        .filter(|&(a, b)| !all.contains(&(b, a)))
        .collect();
    open.sort_unstable();
    // The cap runs along the open edges the other way.
    let mut next: HashMap<u32, Vec<u32>> = HashMap::new();
    for &(a, b) in &open {
        next.entry(b).or_default().push(a);
    }
    let normal = plane.normal.as_dvec3();
    let axis = normal.any_orthonormal_vector();
    let axes = [axis, normal.cross(axis)];
    let mut border = Border::default();
    let mut corner_of = HashMap::new();
    let mut corner = |number: u32, points: &mut Vec<DVec2>| {
        *corner_of.entry(number).or_insert_with(|| {
            let position: DVec3 = place[&number].as_dvec3();
            points.push(DVec2::new(axes[0].dot(position), axes[1].dot(position)));
            points.len() as u32 - 1
        })
    };
    for &(_, start) in &open {
        let mut at = start;
        let mut ring = Vec::new();
        while let Some(to) = next.get_mut(&at).and_then(Vec::pop) {
            ring.push(corner(at, &mut border.points));
            at = to;
        }
        if !ring.is_empty() {
            border.loops.push(ring);
        }
    }
    let cap = cap
        .iter()
        .map(|t| {
            t.map(|v| {
                let number = topology[v as usize];
                corner(number, &mut border.points)
            })
        })
        .collect();
    (border, cap)
}

fn judge(border: &Border, cap: &Cap) -> Faults {
    let cross = |a: DVec2, b: DVec2| a.perp_dot(b);
    let mut uses: HashMap<(u32, u32), i32> = HashMap::new();
    let mut wanted = 0.0;
    for ring in &border.loops {
        for (k, &a) in ring.iter().enumerate() {
            let b = ring[(k + 1) % ring.len()];
            *uses.entry((b, a)).or_default() += 1;
            wanted += 0.5 * cross(border.points[a as usize], border.points[b as usize]);
        }
    }
    let (mut area, mut backwards) = (0.0, 0.0);
    for t in cap {
        for k in 0..3 {
            *uses.entry((t[k], t[(k + 1) % 3])).or_default() += 1;
        }
        let [a, b, c] = t.map(|corner| border.points[corner as usize]);
        let twice = cross(b - a, c - a);
        area += 0.5 * twice;
        backwards += 0.5 * (-twice).max(0.0);
    }
    let is_paired =
        |(&(a, b), &count): (&(u32, u32), &i32)| count == 1 && uses.get(&(b, a)) == Some(&1);
    let scale = wanted.abs().max(f64::MIN_POSITIVE);
    Faults {
        open: !uses.iter().all(is_paired),
        area: (area - wanted).abs() > 1e-6 * scale,
        flipped: backwards > 1e-6 * scale,
    }
}
