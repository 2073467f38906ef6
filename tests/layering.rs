//! The layers stay layers: lower ones do not know the ECS, and no file uses a layer above its own.

use std::fs;
use std::path::{Path, PathBuf};

/// Layers from the bottom up. `lib.rs` names them all.
const LAYERS: [&str; 11] = [
    "math", "geometry", "mass", "slice", "contact", "solver", "collide", "fracture", "step", "ecs",
    "plugin",
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

#[test]
fn no_file_uses_a_layer_above_its_own() {
    for source in &sources() {
        for (place, line) in source.code_lines() {
            for name in &LAYERS[source.layer + 1..] {
                let used = line.contains(&format!("crate::{name}::"))
                    || line.contains(&format!("crate::{name};"));
                assert!(!used, "a layer below {name} uses it: {place}");
            }
        }
    }
}
