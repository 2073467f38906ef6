//! Cuts whose borders are of a kind.

use crate::dice::Dice;
use bevy_cleave::geometry::TriMesh;
use bevy_cleave::math::Plane;
use glam::{DVec2, Vec3};

/// Cuts of a kind.
pub(crate) struct Family {
    pub(crate) name: &'static str,
    pub(crate) cuts: Vec<(TriMesh, Plane)>,
}

pub(crate) fn all() -> Vec<Family> {
    let mut dice = Dice::new(29);
    let mut list = vec![models(&mut dice)];
    let mut family = |name, count, make: &dyn Fn(&mut Dice) -> Vec<Vec<DVec2>>| {
        let cuts = (0..count).filter_map(|_| Some((double_cones(&make(&mut dice))?, middle())));
        list.push(Family {
            name,
            cuts: cuts.collect(),
        });
    };
    family("stars with holes", 300, &|dice| stars(dice, 0.0));
    family("stars that cross themselves", 300, &|dice| stars(dice, 0.4));
    family("combs", 100, &comb);
    family("spirals", 100, &spiral);
    family("cells of a grid, corners touch", 300, &cells);
    family("almost straight sides", 300, &almost_straight);
    family("needles", 300, &needle);
    family("circles of 1000 corners", 30, &|_| vec![circle(1000, 1.0)]);
    list.push(Family {
        name: "prisms cut across",
        cuts: (0..300).map(|_| prism(&mut dice)).collect(),
    });
    list
}

fn middle() -> Plane {
    Plane::through(Vec3::ZERO, Vec3::Z)
}

/// A mesh that the plane z = 0 cuts along these loops, through its vertices: each loop is joined to a point above and one
/// below. Loops that are holes run clockwise and become cavities.
fn double_cones(loops: &[Vec<DVec2>]) -> Option<TriMesh> {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (number, ring) in loops.iter().enumerate() {
        // Apexes at one place would be welded.
        let height = 1.0 + 0.01 * number as f32;
        let first = positions.len() as u32;
        let count = ring.len() as u32;
        positions.extend(ring.iter().map(|p| p.as_vec2().extend(0.0)));
        let centre = ring.iter().sum::<DVec2>() / ring.len() as f64;
        positions.extend([height, -height].map(|z| centre.as_vec2().extend(z)));
        for k in 0..count {
            let (a, b) = (first + k, first + (k + 1) % count);
            triangles.push([a, b, first + count]);
            triangles.push([b, a, first + count + 1]);
        }
    }
    let mesh = TriMesh::new(positions, triangles).ok()?;
    mesh.is_closed().then_some(mesh)
}

fn circle(count: usize, radius: f64) -> Vec<DVec2> {
    let step = std::f64::consts::TAU / count as f64;
    (0..count)
        .map(|k| radius * DVec2::from_angle(step * k as f64))
        .collect()
}

/// A loop around a point that sees all of it, unless `shift` moves its corners.
fn star(dice: &mut Dice, centre: DVec2, radius: f64, shift: f64) -> Vec<DVec2> {
    let count = 3 + dice.below(80);
    let number = |dice: &mut Dice| f64::from(dice.unit());
    let corners = circle(count, radius).into_iter().map(|p| {
        let aside = DVec2::new(number(dice) - 0.5, number(dice) - 0.5);
        centre + p * (0.3 + 0.7 * number(dice)) + shift * radius * aside
    });
    corners.collect()
}

/// One outer loop of radius 1 at least, and up to five holes that do not touch.
fn stars(dice: &mut Dice, shift: f64) -> Vec<Vec<DVec2>> {
    let mut outer = star(dice, DVec2::ZERO, 4.0, shift);
    for p in &mut outer {
        *p = p.normalize_or_zero() * p.length().max(1.3);
    }
    let mut loops = vec![outer];
    for k in 0..dice.below(6) {
        let centre = 0.7 * DVec2::from_angle(std::f64::consts::TAU * k as f64 / 6.0);
        let mut hole = star(dice, centre, 0.3, shift);
        hole.reverse();
        loops.push(hole);
    }
    loops
}

fn comb(dice: &mut Dice) -> Vec<Vec<DVec2>> {
    let teeth = 2 + dice.below(60);
    let mut ring = vec![DVec2::new(0.0, -1.0), DVec2::new(2.0 * teeth as f64, -1.0)];
    for k in (0..teeth).rev() {
        let x = 2.0 * k as f64;
        ring.push(DVec2::new(x + 1.5, f64::from(dice.in_range(3.0, 9.0))));
        ring.push(DVec2::new(x + 1e-3, f64::from(dice.in_range(0.0, 0.1))));
    }
    vec![ring]
}

fn spiral(dice: &mut Dice) -> Vec<Vec<DVec2>> {
    let count = 20 + dice.below(300);
    let at = |k: usize, width: f64| {
        let angle = 0.2 * k as f64;
        (0.1 * angle + 0.5 + width) * DVec2::from_angle(angle)
    };
    let out = (0..count).map(|k| at(k, 0.3));
    let back = (0..count).rev().map(|k| at(k, 0.0));
    vec![out.chain(back).collect()]
}

/// The border of random cells: all corners on lines with others, and corners where four borders meet.
fn cells(dice: &mut Dice) -> Vec<Vec<DVec2>> {
    let n = 3 + dice.below(10) as i32;
    let solid: Vec<bool> = (0..n * n).map(|_| dice.below(2) == 0).collect();
    let is_solid =
        |x: i32, y: i32| x >= 0 && y >= 0 && x < n && y < n && solid[(x + n * y) as usize];
    let mut next = std::collections::BTreeMap::<(i32, i32), Vec<(i32, i32)>>::new();
    for (x, y) in (0..n * n)
        .map(|i| (i % n, i / n))
        .filter(|&(x, y)| is_solid(x, y))
    {
        let corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)];
        let beside = [(x, y - 1), (x + 1, y), (x, y + 1), (x - 1, y)];
        for k in 0..4 {
            if !is_solid(beside[k].0, beside[k].1) {
                next.entry(corners[k])
                    .or_default()
                    .push(corners[(k + 1) % 4]);
            }
        }
    }
    let mut loops = Vec::new();
    while let Some(&start) = next.keys().next() {
        let (mut ring, mut at) = (vec![], start);
        while let Some(ends) = next.get_mut(&at) {
            let to = ends.pop().expect("never kept empty");
            if ends.is_empty() {
                next.remove(&at);
            }
            ring.push(DVec2::new(f64::from(at.0), f64::from(at.1)));
            at = to;
            // A loop that comes to one of its corners again is two that touch there.
            let place = DVec2::new(f64::from(at.0), f64::from(at.1));
            if let Some(first) = ring.iter().position(|&p| p == place) {
                loops.push(ring.split_off(first));
            }
        }
    }
    loops
}

/// A polygon whose sides have many corners, which rounding puts beside them.
fn almost_straight(dice: &mut Dice) -> Vec<Vec<DVec2>> {
    let far = f64::from(dice.in_range(-100.0, 100.0));
    let base = star(dice, DVec2::new(far, 3.0), 1.0, 0.0);
    let parts = 2 + dice.below(20);
    let corner = |i: usize| base[i % base.len()];
    let along = |i: usize, k: usize| corner(i).lerp(corner(i + 1), k as f64 / parts as f64);
    vec![
        (0..base.len())
            .flat_map(|i| (0..parts).map(move |k| along(i, k)))
            .collect(),
    ]
}

fn needle(dice: &mut Dice) -> Vec<Vec<DVec2>> {
    let turn = DVec2::from_angle(f64::from(dice.in_range(0.0, 6.0)));
    let flat = f64::from(dice.in_range(1e-5, 1e-3));
    let ring = star(dice, DVec2::ZERO, 1.0, 0.0);
    vec![
        ring.iter()
            .map(|p| turn.rotate(*p * DVec2::new(1.0, flat)))
            .collect(),
    ]
}

/// A prism over a star, cut between its ends: the plane also meets the diagonals of its sides.
fn prism(dice: &mut Dice) -> (TriMesh, Plane) {
    let ring = star(dice, DVec2::ZERO, 1.0, 0.0);
    let count = ring.len() as u32;
    let mut positions: Vec<Vec3> = Vec::new();
    positions.extend(ring.iter().map(|p| p.as_vec2().extend(-1.0)));
    positions.extend(ring.iter().map(|p| p.as_vec2().extend(1.0)));
    positions.extend([-1.0, 1.0].map(|z| Vec3::Z * z));
    let mut triangles = Vec::new();
    for k in 0..count {
        let (a, b) = (k, (k + 1) % count);
        triangles.extend([[a, b, count + b], [a, count + b, count + a]]);
        triangles.extend([[b, a, 2 * count], [count + a, count + b, 2 * count + 1]]);
    }
    let mesh = TriMesh::new(positions, triangles).expect("a closed prism");
    let tilt = 0.2 * dice.vector(-1.0, 1.0);
    (
        mesh,
        Plane::through(Vec3::ZERO, (Vec3::Z + tilt).normalize()),
    )
}

/// Closed models under planes of random direction.
fn models(dice: &mut Dice) -> Family {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/meshes");
    let mut paths: Vec<_> = std::fs::read_dir(folder)
        .expect("the models are there")
        .map(|entry| entry.expect("readable").path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "obj"))
        .collect();
    paths.sort();
    let mut cuts = Vec::new();
    for mesh in paths.iter().filter_map(|path| model(path)) {
        let planes: Vec<_> = (0..40)
            .map(|_| dice.plane_through(mesh.positions()))
            .collect();
        cuts.extend(planes.into_iter().map(|plane| (mesh.clone(), plane)));
    }
    Family {
        name: "cuts of models",
        cuts,
    }
}

/// A closed model, positions and triangles only.
fn model(path: &std::path::Path) -> Option<TriMesh> {
    let text = std::fs::read_to_string(path).expect("readable");
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let numbers: Vec<f32> = words
                    .take(3)
                    .map(|word| word.parse().expect("a number"))
                    .collect();
                positions.push(Vec3::from_slice(&numbers));
            }
            Some("f") => {
                let corners: Vec<u32> = words
                    .map(|word| {
                        word.split('/')
                            .next()
                            .expect("a word")
                            .parse::<u32>()
                            .expect("a number")
                            - 1
                    })
                    .collect();
                triangles.extend(
                    corners[1..]
                        .windows(2)
                        .map(|pair| [corners[0], pair[0], pair[1]]),
                );
            }
            _ => {}
        }
    }
    let mesh = TriMesh::new(positions, triangles).ok()?;
    mesh.is_closed().then_some(mesh)
}
