//! `use bevy::prelude::*; use bevy_cleave::prelude::*;` leaves no name ambiguous.

use std::collections::BTreeSet;

/// Names of Bevy's prelude; the file says how they were collected.
fn bevy_names() -> BTreeSet<&'static str> {
    let lines = include_str!("../data/bevy_prelude_0_20.txt").lines();
    lines.filter(|line| !line.starts_with('#')).collect()
}

/// The text of the module `prelude` in the source of a crate's root.
fn prelude_of(source: &str) -> &str {
    let (_, rest) = source
        .split_once("pub mod prelude {")
        .expect("there is a prelude");
    rest.split_once("\n}").expect("it ends").0
}

/// The names that the `pub use` of `prelude` bring in, which are all that is in it.
fn names_in(prelude: &str) -> BTreeSet<&str> {
    assert!(!prelude.contains('*'), "name what the prelude exports");
    let lines = prelude.lines().map(str::trim);
    let code = lines.filter(|line| !line.starts_with("//") && !line.starts_with("#["));
    let mut names = BTreeSet::new();
    for line in code {
        let line = line.strip_prefix("pub use ").unwrap_or(line);
        let items = line.split_once('{').map_or(line, |(_, items)| items);
        for item in items.split(',') {
            let item = item.trim_matches([' ', '}', ';']);
            let path = item.rsplit(" as ").next().unwrap_or(item);
            names.extend(path.rsplit("::").next().filter(|name| !name.is_empty()));
        }
    }
    names
}

#[test]
fn no_name_is_in_bevys_prelude_too() {
    let ours = names_in(prelude_of(include_str!("../../src/lib.rs")));
    let theirs = bevy_names();
    for known in ["RigidBody", "ConvexMesh", "SliceCommands", "Simulation"] {
        assert!(ours.contains(known), "{known} is not found among {ours:?}");
    }
    for known in ["Transform", "Component", "Vec3", "HalfSpace", "Sprite"] {
        assert!(theirs.contains(known), "{known} is not in the list");
    }
    let common: Vec<_> = ours.intersection(&theirs).collect();
    assert!(common.is_empty(), "rename {common:?}");
}

#[test]
fn names_are_found_however_they_are_brought_in() {
    let source = "pub mod prelude {
    /// Shapes.
    pub use crate::a::Alone;
    pub use crate::b::{First, c::Second};
    #[cfg(feature = \"exact\")]
    pub use crate::d::{
        Third as Fourth,
        Fifth,
    };
}
";
    let names = names_in(prelude_of(source));
    let all = ["Alone", "Fifth", "First", "Fourth", "Second"];
    assert_eq!(names, BTreeSet::from(all));
}
