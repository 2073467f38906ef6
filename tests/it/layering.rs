//! Floors and rooms stay what they are: lower ones do not know the ECS, no file uses a floor above its own, rooms know those
//! rooms only that they are built on, and no two files import each other.

use crate::sources::{Source, imports, sources};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Floors from the bottom up. `lib.rs` names them all.
const FLOORS: [&str; 22] = [
    "tuning",
    "math",
    "merge",
    "disjoint_sets",
    "simd",
    "threads",
    "geometry",
    "mass",
    "slice",
    "import",
    "cluster",
    "contact",
    "bodies",
    "joints",
    "solver",
    "collide",
    "query",
    "fracture",
    "step",
    "ecs",
    "plugin",
    "extras",
];

/// What a room may use of its own floor, and nothing else of it; and what of the floors below it must not.
struct Room {
    name: &'static str,
    may_use: &'static [&'static str],
    must_not_use: &'static [&'static str],
}

/// Rooms with walls. Files and folders that are not named here are the landing: they put the rooms together.
const ROOMS: [Room; 11] = [
    // State and motion: knows what a body is made of, but no contact.
    Room {
        name: "bodies",
        may_use: &[],
        must_not_use: &[
            "contact::narrow",
            "contact::pairs",
            "contact::impulses",
            "contact::manifolds",
        ],
    },
    // How two shapes touch: knows neither which pairs there are nor what they bore.
    Room {
        name: "contact::narrow",
        may_use: &[
            "contact::local_manifold",
            "contact::point",
            "contact::reduce",
        ],
        must_not_use: &["threads"],
    },
    // Which pairs there are, and what is known of each: knows no impulses.
    Room {
        name: "contact::pairs",
        may_use: &[
            "contact::body_id",
            "contact::body_manifold",
            "contact::layers",
            "contact::local_manifold",
            "contact::narrow",
        ],
        must_not_use: &["threads"],
    },
    // What contacts bore: knows neither how they were found nor what solves them.
    Room {
        name: "contact::impulses",
        may_use: &["contact::body_id", "contact::manifolds", "contact::point"],
        must_not_use: &[],
    },
    // The problem that a step poses.
    Room {
        name: "solver::rows",
        may_use: &["solver::config"],
        must_not_use: &["threads"],
    },
    // Who is solved with whom: knows no impulses, and not what is done with eight contacts.
    Room {
        name: "solver::graph",
        may_use: &[],
        must_not_use: &["contact::impulses"],
    },
    // What eight contacts do: knows neither islands nor batches, and does not share work out. Of the graph it knows what the
    // numbers of bodies and contacts are called.
    Room {
        name: "solver::wide",
        may_use: &["solver::config", "solver::rows", "solver::graph::indices"],
        must_not_use: &["threads::team", "contact::impulses", "contact::pairs"],
    },
    // Joints as rows, and their solution: knows neither contacts nor batches.
    Room {
        name: "solver::joint",
        may_use: &[],
        must_not_use: &["contact", "threads"],
    },
    // The problem solved to the end, by other means.
    Room {
        name: "solver::exact",
        may_use: &["solver::config", "solver::rows"],
        must_not_use: &["threads", "simd"],
    },
    // Time: the sub-steps of some islands.
    Room {
        name: "solver::batch",
        may_use: &[
            "solver::adaptivity",
            "solver::config",
            "solver::settings",
            "solver::exact",
            "solver::graph",
            "solver::joint",
            "solver::rows",
            "solver::wide",
        ],
        must_not_use: &["contact::impulses", "contact::pairs"],
    },
    // The one surgery on hulls: knows nothing of meshes and patterns.
    Room {
        name: "slice::convex",
        may_use: &["slice::cut"],
        must_not_use: &["threads"],
    },
];

/// The only lines in which plain data may name the ECS or reflection: derive markers.
const MARKERS: [&str; 3] = [
    "use bevy_ecs::component::Component;",
    "use bevy_ecs::resource::Resource;",
    "#[cfg_attr(feature = \"reflect\", derive(bevy_reflect::Reflect))]",
];

/// The number of a module's floor, from the bottom up.
fn floor(module: &str) -> usize {
    let name = module.split("::").next().unwrap_or("");
    let floor = FLOORS.iter().position(|floor| *floor == name);
    floor.unwrap_or_else(|| panic!("{module} is on no floor"))
}

fn on_floors() -> Vec<Source> {
    let mut all = sources();
    all.retain(|source| !source.module.is_empty());
    all
}

fn modules(all: &[Source]) -> BTreeSet<&str> {
    all.iter().map(|source| source.module.as_str()).collect()
}

/// Whether a module is another one or inside it.
fn is_in(module: &str, room: &str) -> bool {
    module
        .strip_prefix(room)
        .is_some_and(|rest| rest.is_empty() || rest.starts_with("::"))
}

/// What stands between a module and something that it uses, if anything does.
fn wall(module: &str, used: &str) -> Option<String> {
    if floor(used) > floor(module) {
        return Some(format!("{module} uses {used}, which is on a floor above"));
    }
    let room = ROOMS.iter().find(|room| is_in(module, room.name))?;
    let allows = |list: &[&str]| list.iter().any(|name| is_in(used, name));
    let is_at_home = is_in(used, room.name) || is_in(room.name, used);
    let may = is_at_home || floor(used) < floor(module) || allows(room.may_use);
    let message = || format!("{module} uses {used}, which {} knows nothing of", room.name);
    (!may || allows(room.must_not_use)).then(message)
}

#[test]
fn no_file_uses_a_floor_above_or_a_room_behind_a_wall() {
    let all = on_floors();
    let modules = modules(&all);
    let mut crossed = Vec::new();
    for source in &all {
        // Tests of a file may use the rooms around it, but no floor above.
        for used in imports(&source.module, &source.text, &modules) {
            assert!(
                floor(&used) <= floor(&source.module),
                "{} uses {used}",
                source.module
            );
        }
        let used = source.imports(&modules);
        crossed.extend(used.iter().filter_map(|used| wall(&source.module, used)));
    }
    assert!(crossed.is_empty(), "{crossed:#?}");
}

#[test]
fn walls_stand_where_the_list_says() {
    for (module, used, is_allowed) in [
        ("mass", "ecs::components", false),
        ("mass::approximate", "geometry", true),
        ("solver::wide::sweep", "solver::batch::layout", false),
        ("solver::wide::sweep", "solver::graph::islands", false),
        ("solver::wide::sweep", "threads::team", false),
        ("solver::wide::sweep", "solver::wide::block", true),
        ("solver::wide::sweep", "solver::rows::pgs", true),
        ("solver::graph::islands", "contact::impulses", false),
        ("solver::graph::islands", "solver::wide::block", false),
        ("solver::rows::pgs", "solver::batch", false),
        ("solver::batch::motion", "solver::wide::pass", true),
        ("solver::batch::motion", "solver::graph::partition", true),
        ("solver::batch::motion", "solver::contact_solver", false),
        ("contact::pairs::store", "contact::impulses", false),
        ("contact::impulses::update", "contact::pairs::store", false),
        ("contact::narrow::sat", "contact::pairs", false),
        ("contact::manifolds", "contact::point", true),
        ("step::contacts", "solver::contact_solver", true),
    ] {
        assert_eq!(
            wall(module, used).is_none(),
            is_allowed,
            "{module} and {used}"
        );
    }
}

#[test]
fn floors_below_the_ecs_do_not_know_it() {
    for source in on_floors()
        .iter()
        .filter(|s| floor(&s.module) < floor("ecs"))
    {
        for (place, line) in source.code_lines() {
            let foreign = ["bevy_app", "bevy_time", "bevy_transform"];
            assert!(!foreign.iter().any(|name| line.contains(name)), "{place}");
            let marked = ["bevy_ecs", "bevy_reflect"];
            assert!(
                !marked.iter().any(|name| line.contains(name)) || MARKERS.contains(&line),
                "{place}"
            );
        }
    }
}

/// Ways to name a floor that a look at `crate::name` does not see.
fn hides_a_floor(code: &str) -> bool {
    ["crate::*", "crate::prelude", "use crate as", "use super as"]
        .iter()
        .any(|way| code.contains(way))
}

#[test]
fn floors_are_named() {
    for source in &on_floors() {
        for (place, line) in source.code_lines() {
            assert!(!hides_a_floor(line), "name the floor: {place}");
        }
    }
    for code in [
        "use crate::*;",
        "use crate::prelude::Bodies;",
        "use crate as top;",
    ] {
        assert!(hides_a_floor(code), "{code}");
    }
    assert!(!hides_a_floor("use crate::math::Pose;"));
}

#[test]
fn the_root_file_of_a_floor_does_not_go_up_to_the_crate() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let is_root =
        |path: &Path| path.ends_with("mod.rs") || path.parent().is_some_and(|p| p == root);
    for source in on_floors().iter().filter(|s| is_root(&s.path)) {
        for (place, line) in source.code_lines() {
            // The star is how a file's own test module takes its names.
            let up = line.replace("pub(super)", "").contains("super::");
            assert!(!up || line == "use super::*;", "{place}");
        }
    }
}

/// All that can be reached from a module by going from import to import.
fn reached<'a>(from: &str, edges: &'a BTreeMap<String, BTreeSet<String>>) -> BTreeSet<&'a str> {
    let (mut found, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(module) = open.pop() {
        for next in edges.get(module).into_iter().flatten() {
            if found.insert(next.as_str()) {
                open.push(next);
            }
        }
    }
    found
}

/// Pairs of files in one circle of imports, but for a module and its own parent.
fn circles(edges: &BTreeMap<String, BTreeSet<String>>) -> Vec<(String, String)> {
    let is_parent = |a: &str, b: &str| b.rsplit_once("::").is_some_and(|(parent, _)| parent == a);
    let mut found = Vec::new();
    for a in edges.keys() {
        for b in reached(a, edges) {
            let is_circle = a.as_str() < b && reached(b, edges).contains(a.as_str());
            if is_circle && !is_parent(a, b) {
                found.push((a.clone(), b.to_string()));
            }
        }
    }
    found
}

#[test]
fn no_files_import_each_other() {
    let all = on_floors();
    let modules = modules(&all);
    let edges = all
        .iter()
        .map(|source| (source.module.clone(), source.imports(&modules)));
    let found = circles(&edges.collect());
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn circles_of_any_length_are_found() {
    let modules = BTreeSet::from(["a", "a::b", "a::c", "d"]);
    let circles_of = |files: &[(&str, &str)]| {
        let edges = files
            .iter()
            .map(|&(module, text)| (module.into(), imports(module, text, &modules)));
        circles(&edges.collect()).len()
    };
    let (b, c) = (
        ("a::b", "use crate::a::c::X;"),
        ("a::c", "use super::b::Y;"),
    );
    assert_eq!(circles_of(&[b, c]), 1);
    assert_eq!(
        circles_of(&[
            b,
            ("a::c", "use crate::d::Z;"),
            ("d", "use crate::a::{b::Y};")
        ]),
        3
    );
    // A parent and its child, and a child that uses another by way of no one.
    assert_eq!(
        circles_of(&[("a", "use crate::a::b::X;"), ("a::b", "use crate::a::Y;")]),
        0
    );
    assert_eq!(circles_of(&[b, ("a::c", "use crate::d::Z;")]), 0);
}
