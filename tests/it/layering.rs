//! The layers stay layers: lower ones do not know the ECS, and no file uses a layer above its own.

use std::fs;
use std::path::{Path, PathBuf};

/// Layers from the bottom up. `lib.rs` names them all.
const LAYERS: [&str; 14] = [
    "math", "prefetch", "team", "parts", "geometry", "mass", "slice", "contact", "solver",
    "collide", "fracture", "step", "ecs", "plugin",
];

/// The only lines in which plain data may name the ECS or reflection: derive markers.
const MARKERS: [&str; 3] = [
    "use bevy_ecs::component::Component;",
    "use bevy_ecs::resource::Resource;",
    "#[cfg_attr(feature = \"reflect\", derive(bevy_reflect::Reflect))]",
];

struct Source {
    layer: usize,
    path: PathBuf,
    text: String,
}

impl Source {
    fn read(path: PathBuf, root: &Path) -> Self {
        let within = path.strip_prefix(root).expect("below src");
        let first = within.components().next().expect("a name").as_os_str();
        let name = first.to_string_lossy();
        let layer = LAYERS
            .iter()
            .position(|l| *l == name.trim_end_matches(".rs"));
        let layer = layer.unwrap_or_else(|| panic!("{} belongs to no layer", path.display()));
        let text = fs::read_to_string(&path).expect("readable");
        Self { layer, path, text }
    }

    /// Lines of code without comments, each behind its place.
    fn code_lines(&self) -> impl Iterator<Item = (String, &str)> {
        let lines = self.text.lines().enumerate();
        lines.filter_map(|(i, line)| {
            let code = line.split("//").next().unwrap_or("").trim();
            let place = format!("{}:{}: {code}", self.path.display(), i + 1);
            (!code.is_empty()).then_some((place, code))
        })
    }
}

fn sources() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut found, mut folders) = (Vec::new(), vec![root.clone()]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("src is there") {
            let path = entry.expect("readable").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.file_name().is_some_and(|n| n != "lib.rs") {
                found.push(Source::read(path, &root));
            }
        }
    }
    found
}

#[test]
fn layers_below_the_ecs_do_not_know_it() {
    let ecs = LAYERS.iter().position(|l| *l == "ecs").expect("a layer");
    for source in sources().iter().filter(|s| s.layer < ecs) {
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

/// Whether `code` has the path `path`, as a whole: followed by no further letter of a name.
fn names(code: &str, path: &str) -> bool {
    let goes_on = |rest: &str| rest.starts_with(|c: char| c.is_alphanumeric() || c == '_');
    code.match_indices(path)
        .any(|(at, _)| !goes_on(&code[at + path.len()..]))
}

/// Layers above `layer` that a line of code uses.
fn layers_used_above(layer: usize, code: &str) -> Vec<&'static str> {
    let above = LAYERS[layer + 1..].iter().copied();
    above
        .filter(|name| names(code, &format!("crate::{name}")))
        .collect()
}

/// Ways to name a layer that a look at `crate::name` does not see: groups, the prelude, and two levels up at once.
fn hides_a_layer(code: &str) -> bool {
    let hidden = ["crate::{", "crate::*", "super::super", "super::{super"];
    hidden.iter().any(|path| code.contains(path))
        || names(code, "crate::prelude")
        || names(code, "use crate as")
}

#[test]
fn no_file_uses_a_layer_above_its_own() {
    for source in &sources() {
        for (place, line) in source.code_lines() {
            assert!(!hides_a_layer(line), "name the layer: {place}");
            let used = layers_used_above(source.layer, line);
            assert!(used.is_empty(), "a layer below {used:?} uses it: {place}");
        }
    }
}

#[test]
fn the_root_file_of_a_layer_does_not_go_up_to_the_crate() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let is_root =
        |path: &Path| path.ends_with("mod.rs") || path.parent().is_some_and(|p| p == root);
    for source in sources().iter().filter(|s| is_root(&s.path)) {
        for (place, line) in source.code_lines() {
            // The star is how a file's own test module takes its names.
            let up = line.replace("pub(super)", "").contains("super::");
            assert!(!up || line == "use super::*;", "{place}");
        }
    }
}

#[test]
fn every_way_to_use_a_layer_above_is_seen() {
    let mass = LAYERS.iter().position(|l| *l == "mass").expect("a layer");
    for code in [
        "use crate::ecs::components;",
        "use crate::ecs;",
        "use crate::ecs as up;",
        "let x = crate::ecs::f();",
    ] {
        assert_eq!(layers_used_above(mass, code), ["ecs"], "{code}");
    }
    for code in [
        "use crate::{ecs::components, math};",
        "use crate::{",
        "use crate::prelude::Bodies;",
        "use super::super::ecs;",
        "use super::{super::ecs};",
        "use crate as top;",
    ] {
        assert!(hides_a_layer(code), "{code}");
    }
    for code in [
        "use crate::math::Pose;",
        "use crate::geometry;",
        "use super::particle_inertia;",
    ] {
        assert!(
            layers_used_above(mass, code).is_empty() && !hides_a_layer(code),
            "{code}"
        );
    }
}
