//! `arena ask`: questions to a scene, by ours and, with the features `rapier` and `avian`, by Rapier and Avian: rays, moved shapes, nearest points, overlaps.
//!
//! The same questions to the same bodies. Kinds of questions in turns, several rounds, the least time of each; how often the answers
//! differ is told beside it.

#[cfg(feature = "avian")]
mod avian;
mod ours;
#[cfg(feature = "rapier")]
mod rapier;

use crate::Error;
use crate::cli::{self, Arguments};
use crate::job::cpu_ms;
use crate::scene::random::Rng;
use glam::{Quat, Vec3};

/// Bodies of a scene: a third each of boxes, hulls of 16 points and balls, at rest anywhere in a cube of which they fill a share.
pub(super) struct Site {
    pub(super) bodies: Vec<(Thing, Vec3, Quat)>,
    /// A terrain of triangles: heights of a grid, with this many in a row, and their distance (m).
    pub(super) level: Option<(Vec<f32>, usize, f32)>,
    /// Half of the edge of the cube, m.
    half: f32,
}

/// A shape.
#[derive(Clone)]
pub(super) enum Thing {
    Box(Vec3),
    Hull(Vec<Vec3>),
    Ball(f32),
}

/// A question.
#[derive(Clone, Copy)]
pub(super) struct Question {
    pub(super) at: Vec3,
    pub(super) direction: Vec3,
    pub(super) turn: Quat,
}

/// What is asked.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Kind {
    /// The first hit along a ray, with its normal.
    Ray,
    /// The first hit of a moved ball.
    MovedBall,
    /// The first hit of a moved box, turned any way.
    MovedBox,
    /// The nearest place of a surface.
    Nearest,
    /// How many bodies overlap a box.
    Overlap,
}

const KINDS: [(Kind, &str); 5] = [
    (Kind::Ray, "ray"),
    (Kind::MovedBall, "moved ball"),
    (Kind::MovedBox, "moved box"),
    (Kind::Nearest, "nearest"),
    (Kind::Overlap, "overlap"),
];

/// m.
pub(super) const RADIUS: f32 = 0.3;
pub(super) const EDGES: Vec3 = Vec3::new(0.8, 0.4, 0.6);
/// How far is asked, m.
pub(super) const REACH: f32 = 50.0;

/// Who answers.
pub(super) trait Oracle {
    /// Distance (m) or number that answers a question; none for no hit.
    fn answer(&self, kind: Kind, question: &Question) -> Option<f32>;
}

impl Site {
    /// Corners (m) and triangles of the terrain.
    #[cfg(any(feature = "rapier", feature = "avian"))]
    fn triangles(&self) -> Option<(Vec<Vec3>, Vec<[u32; 3]>)> {
        let (heights, columns, spacing) = self.level.as_ref()?;
        let place = |(i, &height): (usize, &f32)| {
            let (x, z) = ((i % columns) as f32, (i / columns) as f32);
            Vec3::new(spacing * x - self.half, height, spacing * z - self.half)
        };
        let points = heights.iter().enumerate().map(place).collect();
        let corner = |x: usize, z: usize| (z * columns + x) as u32;
        let cells = (0..columns - 1).flat_map(|z| (0..columns - 1).map(move |x| (x, z)));
        let triangles = cells.flat_map(|(x, z)| {
            let [a, b] = [corner(x, z), corner(x + 1, z)];
            let [c, d] = [corner(x, z + 1), corner(x + 1, z + 1)];
            [[a, c, d], [a, d, b]]
        });
        Some((points, triangles.collect()))
    }
}

fn site(count: usize, triangles: usize, rng: &mut Rng) -> Site {
    // A body in each 8 m3.
    let half = (count as f32).cbrt();
    let bodies = (0..count).map(|i| {
        let thing = match i % 3 {
            0 => Thing::Box(Vec3::new(
                rng.range(0.4, 1.0),
                rng.range(0.4, 1.0),
                rng.range(0.4, 1.0),
            )),
            1 => Thing::Hull((0..16).map(|_| 0.5 * rng.direction()).collect()),
            _ => Thing::Ball(rng.range(0.2, 0.5)),
        };
        let at = Vec3::new(
            rng.range(-half, half),
            rng.range(-half, half),
            rng.range(-half, half),
        );
        (thing, at, rng.rotation())
    });
    let bodies = bodies.collect();
    let level = (triangles > 0).then(|| {
        let columns = ((triangles / 2) as f32).sqrt() as usize + 1;
        let height = |i: usize| {
            let (x, z) = ((i % columns) as f32, (i / columns) as f32);
            (0.11 * x).sin() * (0.07 * z).cos() * 3.0 + (1.3 * x).sin() * (1.1 * z).sin() * 0.2
        };
        let heights = (0..columns * columns).map(height).collect();
        (heights, columns, 0.5)
    });
    let half = match &level {
        Some((_, columns, spacing)) => 0.5 * spacing * (*columns - 1) as f32,
        None => half,
    };
    Site {
        bodies,
        level,
        half,
    }
}

fn questions(site: &Site, count: usize, rng: &mut Rng) -> Vec<Question> {
    let half = site.half;
    // Over a terrain from a little above it; else from anywhere.
    let (low, high) = if site.level.is_some() {
        (2.0, 6.0)
    } else {
        (-half, half)
    };
    let next = |_| Question {
        at: Vec3::new(
            rng.range(-half, half),
            rng.range(low, high),
            rng.range(-half, half),
        ),
        direction: rng.direction(),
        turn: rng.rotation(),
    };
    (0..count).map(next).collect()
}

/// Asks all questions of a kind: CPU time for each (s), and the answers.
fn ask(
    oracle: &dyn Oracle,
    kind: Kind,
    questions: &[Question],
    answers: &mut Vec<Option<f32>>,
) -> f64 {
    answers.clear();
    let begun = cpu_ms();
    answers.extend(
        questions
            .iter()
            .map(|question| oracle.answer(kind, question)),
    );
    1e-3 * (cpu_ms() - begun) / questions.len() as f64
}

/// Share of the answers that differ.
fn differing(a: &[Option<f32>], b: &[Option<f32>]) -> f64 {
    let is_same = |(a, b): &(&Option<f32>, &Option<f32>)| match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() <= 1e-3 + 1e-3 * a.abs(),
        (a, b) => a == b,
    };
    let count = a.iter().zip(b).filter(|pair| !is_same(pair)).count();
    count as f64 / a.len() as f64
}

/// Runs what the command line says.
pub(crate) fn run(mut words: Arguments) -> Result<(), Error> {
    let (mut bodies, mut triangles) = (vec![1000, 10_000, 100_000], vec![500_000]);
    let (mut count, mut rounds, mut asked) = (20_000, 5, Vec::<String>::new());
    while let Some(flag) = words.word() {
        match flag.as_str() {
            "--bodies" => bodies = words.list(&flag)?,
            "--triangles" => triangles = words.list(&flag)?,
            "--questions" => count = words.value(&flag)?,
            "--kinds" => asked = words.list(&flag)?,
            "--repeats" => rounds = words.value(&flag)?,
            _ => return Err(cli::unknown(&flag)),
        }
    }
    println!(
        "| scene | question | beside | ours, a second | theirs, a second | ratio | answers that differ |"
    );
    println!("|---|---|---|---|---|---|---|");
    let scenes = bodies.iter().map(|&bodies| (bodies, 0));
    for (bodies, triangles) in scenes.chain(triangles.iter().map(|&triangles| (0, triangles))) {
        let mut rng = Rng(7);
        let site = site(bodies, triangles, &mut rng);
        let questions = questions(&site, count, &mut rng);
        let name = match triangles {
            0 => format!("{bodies} bodies"),
            _ => format!("level of {triangles} triangles"),
        };
        let is_asked =
            |name: &str| asked.is_empty() || asked.iter().any(|asked| name.ends_with(asked));
        let mut ours = ours::Ours::new(&site)?;
        let ours = ours.oracle();
        #[cfg(feature = "rapier")]
        let rapier = rapier::Rapier::new(&site)?;
        #[cfg(feature = "avian")]
        let mut avian = avian::Avian::new(&site)?;
        #[cfg(feature = "avian")]
        let avian = avian.oracle()?;
        let others: &[(&str, &dyn Oracle)] = &[
            #[cfg(feature = "rapier")]
            ("Rapier", &rapier),
            #[cfg(feature = "avian")]
            ("Avian", &avian),
        ];
        for (kind, question) in KINDS.into_iter().filter(|kind| is_asked(kind.1)) {
            for &(other, theirs) in others {
                let timed = compare([&ours, theirs], kind, &questions, rounds);
                let ([own, theirs], differ) = (timed.0, 100.0 * timed.1);
                let ratio = own / theirs;
                println!(
                    "| {name} | {question} | {other} | {own:.3e} | {theirs:.3e} | {ratio:.2} | {differ:.2} % |"
                );
            }
        }
    }
    Ok(())
}

/// Questions that both answer in a second, in turns, at the best of all rounds, and the share of the answers that differ.
fn compare(
    oracles: [&dyn Oracle; 2],
    kind: Kind,
    questions: &[Question],
    rounds: usize,
) -> ([f64; 2], f64) {
    let mut least = [f64::INFINITY; 2];
    let mut answers = [Vec::new(), Vec::new()];
    for _ in 0..rounds {
        for (i, oracle) in oracles.into_iter().enumerate() {
            least[i] = least[i].min(ask(oracle, kind, questions, &mut answers[i]));
        }
    }
    let differ = differing(&answers[0], &answers[1]);
    (least.map(|seconds| 1.0 / seconds), differ)
}
