//! `docs/materials.md` shows what the example compiles.

use std::fs;
use std::path::Path;

fn read(path: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    fs::read_to_string(root.join(path)).expect("the file is there")
}

#[test]
fn the_chapter_on_materials_quotes_the_example() {
    let chapter = read("docs/materials.md");
    let example = read("examples/materials/recipes.rs") + &read("examples/materials/concrete.rs");
    let blocks: Vec<_> = chapter.split("```rust\n").skip(1).collect();
    assert_eq!(blocks.len(), 5, "one for each material");
    for block in blocks {
        let (code, _) = block.split_once("```").expect("the block ends");
        assert!(example.contains(code), "not in the example:\n{code}");
    }
    let constructors = example.matches("pub(crate) fn").count();
    assert_eq!(chapter.matches("pub(crate) fn").count(), constructors);
}

/// `demo/` has the recipes from the example, and is not built with the crate: what it does not have would be missed there unseen.
#[test]
fn recipes_use_nothing_but_the_crate() {
    let recipes = read("examples/materials/recipes.rs");
    for line in recipes.lines().filter(|line| line.contains("use ")) {
        assert!(line.starts_with("use bevy_cleave::"), "{line}");
    }
}

#[test]
fn the_pictures_of_the_chapter_are_there() {
    let chapter = read("docs/materials.md");
    let pictures: Vec<_> = chapter.split("](material_").skip(1).collect();
    assert_eq!(pictures.len(), 5);
    for rest in pictures {
        let (name, _) = rest.split_once(')').expect("the link ends");
        let path = format!("{}/docs/material_{name}", env!("CARGO_MANIFEST_DIR"));
        assert!(Path::new(&path).is_file(), "{path}");
    }
}
