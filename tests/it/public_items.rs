//! What the crate offers is what it offered: no public item of the baseline is gone or has another signature. New ones may come.
//!
//! Where something is meant to go, `PUBLIC_ITEMS=write cargo test --test it public_items` writes the baseline anew, and the change log
//! says so.

use crate::sources::{code, sources, without_tests};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::path::Path;

const BASELINE: &str = "tests/data/public_items.txt";

/// Rooms of which only `testing` lets anything out.
const INSIDE: [&str; 3] = ["solver::batch", "solver::graph", "solver::wide"];

/// A signature on one line.
fn signature(text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    let line = words.join(" ");
    // As it would stand on one line.
    line.replace("( ", "(")
        .replace(", )", ")")
        .replace(" )", ")")
        .trim_end_matches(',')
        .to_string()
}

/// Where the item ends that `text` begins with: at its body, its value, or the end of a field.
fn item_end(text: &str) -> usize {
    let mut depth = 0;
    let is_field = ![
        "pub fn",
        "pub const fn",
        "pub struct",
        "pub enum",
        "pub trait",
        "pub type",
        "pub const",
        "pub use",
        "pub mod",
        "pub macro",
    ]
    .iter()
    .any(|word| text.starts_with(word));
    let is_use = text.starts_with("pub use");
    for (at, c) in text.char_indices() {
        match c {
            '(' | '[' | '<' => depth += 1,
            '>' if text[..at].ends_with('-') || text[..at].ends_with('=') => {}
            ')' | ']' | '>' => {
                depth -= 1;
                if depth < 0 {
                    return at;
                }
            }
            '{' if !is_use => return at,
            '}' if !is_use => return at,
            ';' if depth == 0 => return at,
            '=' if depth == 0 && !text.starts_with("pub type") => return at,
            ',' if depth == 0 && is_field => return at,
            _ => {}
        }
    }
    text.len()
}

/// The name of what an `impl` or a type stands for, at the start of a line without indentation.
fn owner(line: &str) -> Option<String> {
    let starts = ["impl", "pub struct ", "pub enum ", "pub trait ", "pub mod "];
    let is_owner = starts.iter().any(|start| line.starts_with(start));
    is_owner.then(|| signature(line.split('{').next().unwrap_or(line)))
}

/// All that is public in a file, each behind its module and owner. That nothing is `pub` which cannot be reached is held by the lint
/// `unreachable_pub`.
fn public_items(module: &str, text: &str) -> Vec<String> {
    let text = code(without_tests(text));
    let mut items = Vec::new();
    let mut of = String::new();
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        if let Some(new) = owner(line) {
            of = new;
        }
        let begin = at + line.len() - line.trim_start().len();
        at += line.len();
        let item = &text[begin.min(text.len())..];
        if line.trim_start().starts_with("pub ") {
            let found = signature(&item[..item_end(item)]);
            let is_within = line.starts_with(char::is_whitespace);
            let owner = if is_within { of.as_str() } else { "" };
            // Each name of a group by itself, so that others may join it.
            let (path, names) = found.split_once('{').unwrap_or((&found, ""));
            let names = names.trim_end_matches('}').trim().trim_end_matches(',');
            for name in names.split(", ") {
                items.push(format!("{module} | {owner} | {path}{name}"));
            }
        }
    }
    items
}

/// The module and the name of everything that only `testing` lets out: inside views, no part of what is offered.
fn inside_views(root: &str) -> BTreeSet<(String, String)> {
    let (_, views) = root.split_once("pub mod testing").unwrap_or_default();
    let mut found = BTreeSet::new();
    for path in views.split("pub use crate::").skip(1) {
        let path = signature(path.split(';').next().unwrap_or(""));
        let (module, names) = path.split_once("::{").unwrap_or_else(|| {
            let (module, name) = path.rsplit_once("::").unwrap_or(("", &path));
            (module, name)
        });
        for name in names.trim_matches(['{', '}', ' ']).split(',') {
            found.insert((module.to_string(), name.trim().to_string()));
        }
    }
    found
}

fn has_word(text: &str, word: &str) -> bool {
    let mut words = text.split(|c: char| !(c.is_alphanumeric() || c == '_'));
    words.any(|other| other == word)
}

fn all_items() -> BTreeSet<String> {
    let sources = sources();
    let root = sources.iter().find(|source| source.module.is_empty());
    let hidden = inside_views(root.map_or("", |root| &root.text));
    let is_hidden = |item: &str| {
        let mut parts = item.split(" | ");
        let module = parts.next().unwrap_or("");
        let rest: Vec<&str> = parts.collect();
        let of_module = hidden
            .iter()
            .filter(|(of, _)| format!("{module}::").starts_with(&format!("{of}::")));
        let declares =
            |name: &str| has_word(rest[0], name) || rest[0].is_empty() && has_word(rest[1], name);
        of_module.into_iter().any(|(_, name)| declares(name))
    };
    let own = |text: &str| {
        let (own, _) = text.split_once("/// Inside views").unwrap_or((text, ""));
        own.to_string()
    };
    let is_inside = |module: &str| INSIDE.iter().any(|room| module.starts_with(room));
    let items = sources
        .iter()
        .filter(|source| !is_inside(&source.module))
        .flat_map(|source| public_items(&source.module, &own(&source.text)));
    items.filter(|item| !is_hidden(item)).collect()
}

#[test]
fn nothing_public_is_gone_or_changed() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(BASELINE);
    let now = all_items();
    if std::env::var("PUBLIC_ITEMS").is_ok_and(|value| value == "write") {
        let mut text = String::new();
        now.iter()
            .for_each(|item| writeln!(text, "{item}").expect("to memory"));
        fs::write(&path, text).expect("writable");
    }
    let baseline = fs::read_to_string(&path).expect("the baseline is there");
    let gone: Vec<&str> = baseline
        .lines()
        .filter(|&item| !now.contains(item))
        .collect();
    assert!(
        gone.is_empty(),
        "gone or changed, see the head of tests/it/public_items.rs:\n{}",
        gone.join("\n")
    );
    let known = [
        "plugin |  | pub struct CleavePlugin",
        "math | impl Plane | pub fn distance(&self, point: Vec3) -> f32",
    ];
    for known in known {
        assert!(
            now.iter().any(|item| item.starts_with(known)),
            "{known} is not found"
        );
    }
}

#[test]
fn items_are_found_with_their_signatures() {
    let text = "
pub struct Kept {
    /// A field.
    pub length: Vec<([f32; 3], u32)>,
    pub(crate) hidden: f32,
}

impl<T> Kept<T> {
    /// Long.
    pub fn measure(
        &self,
        to: f32,
    ) -> Result<f32, Error>
    where
        T: Clone,
    {
        0.0
    }

    pub(super) fn inner(&self) {}
    pub const LIMIT: usize = 3;
}
";
    let items = public_items("room", text);
    assert_eq!(
        items,
        [
            "room |  | pub struct Kept",
            "room | pub struct Kept | pub length: Vec<([f32; 3], u32)>",
            "room | impl<T> Kept<T> | pub fn measure(&self, to: f32) -> Result<f32, Error> where T: Clone",
            "room | impl<T> Kept<T> | pub const LIMIT: usize",
        ]
    );
}
