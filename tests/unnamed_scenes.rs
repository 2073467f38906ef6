//! Scenes that nobody named keep the laws of `judge`, or no more of them fail than are known to.
//!
//! `cargo run --release --example judge` judges more of them and makes failing ones small. Files in `data/judge` are such.

mod judge;

use bevy_cleave::prelude::{Gravity, Pose, RigidBody, Shape, Simulation};
use glam::Vec3;
use judge::dice::Dice;
use judge::file;
use judge::generate::compounds::compound;
use judge::generate::{FAMILIES, forms, scene};
use judge::laws::{Breach, judge as judge_scene};
use judge::scene::{Actor, Form};
use judge::solid::Solid;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What is known of a family.
struct Known {
    family: &'static str,
    /// How many scenes are judged: seeds from 0 on.
    scenes: usize,
    /// How many of them break a law. To be lowered with each mend; all families together are never raised.
    failing: usize,
}

/// Most scenes of a family, and of one whose scenes cost more.
const MANY: usize = 16;
const FEW: usize = 6;

const fn known(family: &'static str, scenes: usize, failing: usize) -> Known {
    Known {
        family,
        scenes,
        failing,
    }
}

const KNOWN: [Known; FAMILIES.len()] = [
    known("boxes", MANY, 0),
    known("hulls", MANY, 0),
    known("round", FEW, 0),
    known("plates", FEW, 1),
    known("rods", FEW, 0),
    known("needles", FEW, 1),
    known("wedges", MANY, 1),
    known("sizes", MANY, 1),
    known("masses", MANY, 0),
    known("broken", MANY, 0),
    known("stacks", MANY, 0),
    known("lifts", MANY, 0),
    known("towers", MANY, 0),
    known("decks", MANY, 0),
    known("slopes", MANY, 0),
    known("turntables", FEW, 1),
    known("arches", MANY, 0),
    known("houses", MANY, 0),
    known("soft_houses", MANY, 1),
    known("soft_arches", MANY, 0),
    known("bounces", MANY, 1),
    known("swarms", MANY, 1),
    known("shots", MANY, 0),
    known("ledges", MANY, 0),
    known("slides", MANY, 0),
    known("passes", MANY, 0),
    known("copies", MANY, 2),
    known("steps", MANY, 0),
    known("compounds", MANY, 1),
    known("terrains", MANY, 0),
    known("mixtures", MANY, 0),
];

/// Files in `data/judge` that break a law: all of these and no others. A mend takes them off the list; none is added but with a
/// new file.
const OPEN: [&str; 1] = ["slides_seam_184"];

fn list(breaches: &[Breach]) -> String {
    let say = |breach: &Breach| format!("{}: {}", breach.law.name(), breach.what);
    breaches.iter().map(say).collect::<Vec<_>>().join("; ")
}

/// What is found for each of `count` numbers, by all processors.
fn of_each<T: Send>(count: usize, find: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let (next, found) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= count {
                        return;
                    }
                    let result = find(number);
                    found
                        .lock()
                        .expect("no thread panics")
                        .push((number, result));
                }
            });
        }
    });
    let mut found = found.into_inner().expect("no thread panics");
    found.sort_by_key(|(number, _)| *number);
    found.into_iter().map(|(_, result)| result).collect()
}

#[test]
fn no_more_scenes_break_a_law_than_are_known_to() {
    let families = FAMILIES.map(|(name, _)| name);
    let listed = KNOWN.each_ref().map(|known| known.family);
    assert_eq!(families, listed, "one entry for each family, in order");
    let scenes = KNOWN.iter().flat_map(|known| {
        let seeds = 0..known.scenes as u64;
        seeds.map(|seed| (known.family, seed))
    });
    let scenes: Vec<(&str, u64)> = scenes.collect();
    let verdicts = of_each(scenes.len(), |number| {
        let (family, seed) = scenes[number];
        judge_scene(&scene(family, seed).expect("families are listed"))
    });
    let judged: Vec<_> = scenes.into_iter().zip(verdicts).collect();
    let mut worse = Vec::new();
    for known in &KNOWN {
        let of_family = judged
            .iter()
            .filter(|((family, _), _)| *family == known.family);
        let failing = of_family.filter(|(_, breaches)| !breaches.is_empty());
        let failing: Vec<_> = failing
            .map(|((_, seed), breaches)| format!("  seed {seed}: {}", list(breaches)))
            .collect();
        let (found, allowed) = (failing.len(), known.failing);
        if found > allowed {
            let (family, failing) = (known.family, failing.join("\n"));
            worse.push(format!(
                "{family}: {found} fail, known {allowed}\n{failing}"
            ));
        }
    }
    assert!(worse.is_empty(), "{}", worse.join("\n"));
}

fn files() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/judge");
    let entries = fs::read_dir(folder).expect("the folder is there");
    let paths = entries.map(|entry| entry.expect("readable").path());
    let mut texts: Vec<_> = paths
        .filter(|path| path.extension().is_some_and(|e| e == "txt"))
        .collect();
    texts.sort();
    texts
}

#[test]
fn kept_scenes_keep_their_laws_but_for_those_listed() {
    let files = files();
    let verdicts = of_each(files.len(), |number| {
        let text = fs::read_to_string(&files[number]).expect("readable");
        let scene =
            file::read(&text).unwrap_or_else(|error| panic!("{:?}: {error}", files[number]));
        judge_scene(&scene)
    });
    let named = files.iter().zip(verdicts);
    let failing = named
        .filter(|(_, breaches)| !breaches.is_empty())
        .map(|(path, breaches)| {
            let name = path
                .file_stem()
                .expect("a name")
                .to_string_lossy()
                .into_owned();
            (name, list(&breaches))
        });
    let failing: Vec<_> = failing.collect();
    let is_failing = |name: &str| failing.iter().any(|(failing, _)| failing == name);
    let mended: Vec<_> = OPEN.iter().filter(|name| !is_failing(name)).collect();
    assert!(
        mended.is_empty(),
        "no longer open, or without a file: {mended:?}"
    );
    let new = |(name, _): &&(String, String)| !OPEN.contains(&name.as_str());
    let new: Vec<_> = failing.iter().filter(new).collect();
    assert!(new.is_empty(), "{new:#?}");
}

#[test]
fn a_scene_is_read_back_as_it_was_written() {
    for (family, _) in FAMILIES {
        for seed in 0..4 {
            let scene = scene(family, seed).expect("families are listed");
            let text = file::write(&scene, &["why".into()]);
            assert_eq!(file::read(&text).as_ref(), Ok(&scene), "{family} {seed}");
        }
    }
}

/// The depth of two bodies by trying many axes, each of which gives at most the right one. The best of many is not far below it.
#[test]
fn depth_of_overlap_is_the_least_over_all_axes() {
    let mut dice = Dice::new(1);
    let mut overlapping = 0;
    for _ in 0..60 {
        let mut solid = |at: f32| {
            let form = forms::of_all_kinds(&mut dice);
            let Some(Shape::Convex(mesh)) = form.shape() else {
                unreachable!("all kinds have an inside")
            };
            let pose = Pose::new(at * dice.direction(), dice.rotation());
            Solid::new(mesh.hull(), &pose)
        };
        let (a, b) = (solid(0.0), solid(0.3));
        let right = a.separation(&b, f64::MAX);
        let sampled = (0..10_000).map(|_| {
            let axis = dice.direction().as_dvec3();
            b.lowest(axis) + a.lowest(-axis)
        });
        let best = sampled.fold(f64::MIN, f64::max);
        // Two bodies apart may have corners as their nearest points, across which no face or edge is.
        if right < 0.0 {
            overlapping += 1;
            assert!(best <= right + 1e-9, "{right} {best}");
            assert!(right - best < 0.03, "{right} {best}");
        } else {
            assert!(best > 0.0 || right < 0.03, "{right} {best}");
        }
    }
    assert!(overlapping >= 20, "{overlapping}");
}

/// Where a body overlaps a compound, there is a contact that is about as deep, wherever parts meet.
#[test]
fn what_overlaps_a_compound_touches_it() {
    const SCENES: usize = 160;
    const DEPTH: f64 = 0.03;
    let found = of_each(SCENES, |i| {
        let mut dice = Dice::new(i as u64);
        let forms = [compound(&mut dice), against(&mut dice)];
        let turns = [dice.rotation(), dice.rotation()];
        let (along, off) = (dice.direction(), 0.3 * dice.vector(-1.0, 1.0));
        let poses = |way: f32| {
            [
                Pose::new(Vec3::ZERO, turns[0]),
                Pose::new(off + way * along, turns[1]),
            ]
        };
        let gap = |way: f32| {
            let solid = |side: usize| {
                let shape = forms[side].shape().expect("usable");
                Solid::of(&shape, &poses(way)[side]).expect("has an inside")
            };
            solid(0).separation(&solid(1), f64::MAX)
        };
        let (way, right) = first_overlap(gap, DEPTH)?;
        Some((right, deepest_contact(&forms, poses(way))))
    });
    let found: Vec<_> = found.into_iter().flatten().collect();
    assert!(found.len() > SCENES * 9 / 10, "{} overlap", found.len());
    for (right, found) in found {
        assert!(found < 0.3 * right, "{found} instead of {right}");
    }
}

fn against(dice: &mut Dice) -> Form {
    match dice.below(4) {
        0 => forms::rod(dice),
        1 => forms::plate(dice),
        _ => forms::any(dice),
    }
}

/// From how far on the way from outside two bodies overlap by a depth, and their gap there.
fn first_overlap(gap: impl Fn(f32) -> f64, depth: f64) -> Option<(f32, f64)> {
    let ways = (0..3000).map(|i| 3.0 - 2e-3 * i as f32);
    let mut inside = ways.into_iter().find(|&way| gap(way) < -depth)?;
    let mut outside = inside + 2e-3;
    for _ in 0..20 {
        let middle = 0.5 * (inside + outside);
        if gap(middle) < -depth {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    Some((inside, gap(inside)))
}

/// Least separation of the contacts of two bodies, the first of them static, m; infinite if there is none.
fn deepest_contact(forms: &[Form; 2], poses: [Pose; 2]) -> f64 {
    let mut simulation = Simulation {
        gravity: Gravity(Vec3::ZERO),
        ..Simulation::default()
    };
    for (i, (form, pose)) in forms.iter().zip(poses).enumerate() {
        let mut actor = Actor::new(form.clone(), pose.position);
        actor.pose = pose;
        if i == 0 {
            actor.kind = RigidBody::Static;
        }
        let desc = actor.desc().expect("usable");
        simulation.bodies.insert(desc).expect("usable");
    }
    simulation.step(1e-5);
    let manifolds = simulation.contacts.manifolds().iter();
    let points = manifolds.flat_map(|manifold| manifold.points());
    points.fold(f64::INFINITY, |least, point| {
        least.min(f64::from(point.separation))
    })
}
