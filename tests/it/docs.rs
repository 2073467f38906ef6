//! The documents name what is there: files that exist, and names that stand in them.

use std::fs;
use std::path::{Path, PathBuf};

/// Pages that a reader is sent to.
const PAGES: [&str; 15] = [
    "README.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "docs/architecture.md",
    "docs/demo.md",
    "docs/destructible_level.md",
    "docs/features.md",
    "docs/glossary.md",
    "docs/materials.md",
    "docs/window.md",
    "docs/report/README.md",
    "docs/report/features.md",
    "docs/report/slicing.md",
    "benches/arena/README.md",
    "demo/README.md",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Targets of the links and pictures of a page.
fn links(page: &str) -> impl Iterator<Item = &str> {
    let ends = page.split("](").skip(1);
    ends.filter_map(|rest| rest.split_once(')').map(|(target, _)| target))
}

/// What GitHub makes of a heading.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    let kept = kept
        .chars()
        .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.collect::<String>().replace(' ', "-")
}

#[test]
fn links_lead_to_files_and_headings_that_are_there() {
    for page in PAGES {
        let text = read(page);
        let folder = Path::new(page).parent().expect("pages are files");
        for link in links(&text).filter(|link| !link.contains("://")) {
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() {
                PathBuf::from(page)
            } else {
                folder.join(file)
            };
            assert!(root().join(&target).exists(), "{page} links to {link}");
            if !heading.is_empty() {
                let text = read(&target);
                let mut headings = text.lines().filter(|line| line.starts_with('#'));
                let is_there = headings.any(|line| anchor(line.trim_start_matches('#')) == heading);
                assert!(is_there, "{page} links to {link}");
            }
        }
    }
}

/// Models are closed when they are loaded, and no step knows how.
const COSTS_NO_STEP: &str = "Import";

#[test]
fn what_each_part_costs_is_measured() {
    let (features, report) = (read("docs/features.md"), read("docs/report/features.md"));
    let parts: Vec<&str> = features
        .lines()
        .filter_map(|line| line.strip_prefix("- **")?.split_once("**"))
        .map(|(name, _)| name.trim_end_matches('.'))
        .collect();
    assert!(parts.len() > 15, "{parts:?}");
    for part in parts.into_iter().filter(|&part| part != COSTS_NO_STEP) {
        assert!(report.contains(&format!("\n| {part} | ")), "{part}");
    }
}

/// Paths of all files below a folder, as they are named from there.
fn files(folder: &Path, within: &str, found: &mut Vec<String>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("readable").path();
        let name = path.file_name().expect("a name").to_string_lossy();
        let name = format!("{within}/{name}");
        if path.is_dir() {
            files(&path, &name, found);
        } else {
            found.push(name);
        }
    }
}

/// What a page puts in backticks, outside of blocks of code.
fn quoted(page: &str) -> Vec<&str> {
    let prose = page.split("```").step_by(2);
    prose
        .flat_map(|prose| prose.split('`').skip(1).step_by(2))
        .collect()
}

#[test]
fn files_that_the_documents_name_exist() {
    let mut found = Vec::new();
    for folder in ["src", "tests", "examples", "docs"] {
        files(&root().join(folder), &format!("/{folder}"), &mut found);
    }
    for page in [
        "docs/architecture.md",
        "docs/glossary.md",
        "CONTRIBUTING.md",
    ] {
        for name in quoted(&read(page)) {
            let is_path = name.ends_with(".rs") || name.starts_with("tests/");
            if is_path && !name.contains([' ', '*']) {
                let end = format!("/{}", name.trim_end_matches('/'));
                let is_there =
                    |file: &String| file.ends_with(&end) || file.contains(&format!("{end}/"));
                assert!(found.iter().any(is_there), "{page} names {name}");
            }
        }
    }
}

/// Rows of the table below a heading.
fn rows<'p>(page: &'p str, heading: &str) -> Vec<&'p str> {
    let (_, rest) = page.split_once(heading).expect("the heading is there");
    let table = rest.lines().skip_while(|line| !line.starts_with('|'));
    let rows = table.take_while(|line| line.starts_with('|'));
    rows.skip(2).collect()
}

/// The row without what is in parentheses.
fn without_asides(row: &str) -> String {
    let parts = row.split('(').enumerate();
    let kept = parts.map(|(at, part)| match part.split_once(')') {
        Some((_, rest)) if at > 0 => rest,
        _ => part,
    });
    kept.collect()
}

/// Each name in backticks with the file that the row places it in: `A::b` and `c` in `d.rs`, or `d.rs`, `A::b` and `c`.
fn names_with_files(row: &str) -> Vec<(String, String)> {
    let parts: Vec<_> = row.split('`').collect();
    let is_list = |prose: &str| [", ", " and "].contains(&prose);
    let mut found = Vec::new();
    for at in (1..parts.len()).step_by(2) {
        let file = parts[at];
        if !file.ends_with(".rs") {
            continue;
        }
        let mut place = |name: usize| found.push((parts[name].to_owned(), file.to_owned()));
        if parts[at - 1].trim() == "in" {
            let mut name = at - 2;
            place(name);
            while name > 2 && is_list(parts[name - 1]) {
                name -= 2;
                place(name);
            }
        }
        let mut name = at + 2;
        while name < parts.len() && is_list(parts[name - 1]) && !parts[name].ends_with(".rs") {
            place(name);
            name += 2;
        }
    }
    found
}

fn has_word(text: &str, word: &str) -> bool {
    let mut words = text.split(|c: char| !(c.is_alphanumeric() || c == '_'));
    words.any(|other| other == word)
}

#[test]
fn names_that_the_tables_of_the_architecture_place_in_a_file_stand_in_it() {
    let page = read("docs/architecture.md");
    let tables = ["## A tour", "## Where is X?"];
    let rows: Vec<_> = tables
        .iter()
        .flat_map(|heading| rows(&page, heading))
        .collect();
    assert!(rows.len() > 30, "both tables are read");
    let mut checked = 0;
    for row in rows {
        for (name, file) in names_with_files(&without_asides(row)) {
            if name.contains([' ', '/', '.']) {
                continue;
            }
            let Ok(text) = fs::read_to_string(root().join("src").join(&file)) else {
                panic!("{file} is not within src: {row}");
            };
            for part in name.split("::") {
                assert!(has_word(&text, part), "{name} is not in {file}: {row}");
            }
            checked += 1;
        }
    }
    assert!(checked > 60, "only {checked} names are placed in a file");
}

#[test]
fn the_glossary_has_sixty_terms_at_most_and_says_each_in_a_line() {
    let page = read("docs/glossary.md");
    let is_row = |line: &&str| line.starts_with("| ") && !line.starts_with("| term |");
    let terms: Vec<_> = page.lines().filter(is_row).collect();
    assert!((30..=60).contains(&terms.len()), "{} terms", terms.len());
    for term in terms {
        assert_eq!(term.matches('|').count(), 4, "{term}");
        assert!(term.len() < 160, "{term}");
    }
}

/// Most lines that a small game may have to add to the crate.
const MOST_GLUE: usize = 80;

#[test]
fn the_game_needs_as_many_lines_of_glue_as_is_told() {
    let game = read("demo/examples/game.rs");
    let (_, glue) = game.split_once("\nmod glue {").expect("the last module");
    let is_code = |line: &&str| {
        let line = line.trim();
        !(line.is_empty() || line.starts_with("//"))
    };
    let count = 1 + glue.lines().filter(is_code).count();
    assert!(count <= MOST_GLUE, "{count}");
    let pages = [
        ("docs/demo.md", format!("the {count} lines that it has to")),
        (
            "docs/decisions/bevy_plugins.md",
            format!("has {count} lines of glue"),
        ),
    ];
    for (page, told) in pages {
        assert!(read(page).contains(&told), "{page}: {told}");
    }
}

#[test]
fn the_chapter_on_windows_quotes_the_example() {
    let (chapter, example) = (read("docs/window.md"), read("demo/examples/pane.rs"));
    let blocks: Vec<_> = chapter.split("```rust\n").skip(1).collect();
    assert!(!blocks.is_empty(), "the chapter shows code");
    let quoted = blocks.into_iter().map(|block| {
        let (code, _) = block.split_once("```").expect("the block ends");
        assert!(example.contains(code), "not in the example:\n{code}");
        code.matches("fn ").count()
    });
    let shown: usize = quoted.sum();
    assert_eq!(shown, example.matches("fn ").count(), "all of it is shown");
}
