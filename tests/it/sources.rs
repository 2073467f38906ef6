//! The crate's own sources, for tests about their shape: code without comments and tests, and the modules that it names.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// A file of `src`.
pub(crate) struct Source {
    pub(crate) path: PathBuf,
    /// Its module, as `solver::wide::pass`; nothing for `lib.rs`.
    pub(crate) module: String,
    pub(crate) text: String,
}

impl Source {
    fn read(path: PathBuf, root: &Path) -> Self {
        let within = path.strip_prefix(root).expect("below src");
        let names = within.with_extension("");
        let names = names
            .iter()
            .map(|name| name.to_str().expect("a plain name"));
        let names: Vec<_> = names
            .filter(|name| !["mod", "lib"].contains(name))
            .collect();
        let module = names.join("::");
        let text = fs::read_to_string(&path).expect("readable");
        Self { path, module, text }
    }

    /// Lines of code without comments, each behind its place.
    pub(crate) fn code_lines(&self) -> impl Iterator<Item = (String, &str)> {
        let lines = self.text.lines().enumerate();
        lines.filter_map(|(i, line)| {
            let code = line.split("//").next().unwrap_or("").trim();
            let place = format!("{}:{}: {code}", self.path.display(), i + 1);
            (!code.is_empty()).then_some((place, code))
        })
    }

    /// The text before the file's tests.
    pub(crate) fn without_tests(&self) -> &str {
        without_tests(&self.text)
    }

    /// The modules that the code before the tests names by `crate::` or `super::`, of those that there are.
    pub(crate) fn imports(&self, modules: &BTreeSet<&str>) -> BTreeSet<String> {
        imports(&self.module, self.without_tests(), modules)
    }
}

/// All files of `src`, in order.
pub(crate) fn sources() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut found, mut folders) = (Vec::new(), vec![root.clone()]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("src is there") {
            let path = entry.expect("readable").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                found.push(Source::read(path, &root));
            }
        }
    }
    found.sort_by(|a, b| a.path.cmp(&b.path));
    found
}

/// A file before its module of tests.
pub(crate) fn without_tests(text: &str) -> &str {
    text.split("\n#[cfg(test)]\n").next().unwrap_or("")
}

/// Code without comments, and with empty strings and characters in place of all others.
pub(crate) fn code(text: &str) -> String {
    let mut code = String::new();
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        let is_character = c == '\'' && {
            let mut ahead = rest.clone();
            let first = ahead.next();
            first == Some('\\') || ahead.next() == Some('\'')
        };
        if c == '/' && rest.peek() == Some(&'/') {
            while rest.next_if(|&c| c != '\n').is_some() {}
        } else if c == '"' || is_character {
            code.extend([c, c]);
            while let Some(inner) = rest.next() {
                match inner {
                    '\\' => drop(rest.next()),
                    '\n' => code.push('\n'),
                    end if end == c => break,
                    _ => {}
                }
            }
        } else {
            code.push(c);
        }
    }
    code
}

/// The modules that the code of `module` names, of those that there are; groups in braces are taken apart.
pub(crate) fn imports(module: &str, text: &str, modules: &BTreeSet<&str>) -> BTreeSet<String> {
    let code = code(text);
    let mut paths = Vec::new();
    for root in ["crate::", "super::"] {
        for (at, _) in code.match_indices(root) {
            let before = &code[..at];
            let is_whole = !before.ends_with(|c: char| c.is_alphanumeric() || c == '_');
            if is_whole && !before.ends_with("super::") {
                expand(&mut &code[at..], "", &mut paths);
            }
        }
    }
    let absolute = paths.iter().map(|path| absolute(module, path));
    let known = absolute.filter_map(|path| longest_module(&path, modules));
    known.filter(|found| found != module).collect()
}

/// Takes the names of one path or group of paths off `text`.
fn expand(text: &mut &str, before: &str, paths: &mut Vec<String>) {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut path = before.to_string();
    loop {
        *text = text.trim_start();
        if let Some(inside) = text.strip_prefix('{') {
            *text = inside;
            while !text.trim_start().starts_with('}') && !text.trim().is_empty() {
                expand(text, &path, paths);
                *text = text.trim_start().trim_start_matches(',');
            }
            *text = text.trim_start().trim_start_matches('}');
            return;
        }
        let end = text.find(|c| !is_name(c)).unwrap_or(text.len());
        if end == 0 {
            // A star, or something that is no path: the next comma or brace ends it.
            paths.push(path);
            let end = text.find([',', '}', ';']).unwrap_or(text.len());
            *text = &text[end..];
            return;
        }
        path.push_str(&text[..end]);
        *text = &text[end..];
        let Some(after) = text.strip_prefix("::") else {
            paths.push(path);
            // What it is called here does not matter.
            if text.starts_with(" as ") {
                let end = text.find([',', '}', ';']).unwrap_or(text.len());
                *text = &text[end..];
            }
            return;
        };
        path.push_str("::");
        *text = after;
    }
}

/// A path from the root of the crate.
fn absolute(module: &str, path: &str) -> String {
    let mut names: Vec<&str> = Vec::new();
    if path.starts_with("super::") {
        names.extend(module.split("::"));
    }
    for name in path.split("::") {
        match name {
            "crate" | "" => {}
            "super" => drop(names.pop()),
            name => names.push(name),
        }
    }
    names.join("::")
}

/// The module that a path leads into.
fn longest_module(path: &str, modules: &BTreeSet<&str>) -> Option<String> {
    let mut path = path;
    while !modules.contains(path) {
        path = path.rsplit_once("::")?.0;
    }
    (!path.is_empty()).then(|| path.to_string())
}

#[test]
fn imports_are_seen_in_every_form() {
    let modules = BTreeSet::from(["", "a", "a::b", "a::c", "a::b::d", "e", "e::f"]);
    let found = |module: &str, text: &str| -> Vec<String> {
        imports(module, text, &modules).into_iter().collect()
    };
    assert_eq!(found("e", "use crate::a::b::Name;"), ["a::b"]);
    assert_eq!(
        found("e", "use crate::a::{b::{Name, d::*}, c as see};"),
        ["a::b", "a::b::d", "a::c"]
    );
    assert_eq!(
        found("e", "use crate::{a::{\n    c,\n}, e::f::X};"),
        ["a::c", "e::f"]
    );
    assert_eq!(
        found("a::b::d", "use super::super::c; use super::Name;"),
        ["a::b", "a::c"]
    );
    assert_eq!(
        found("e", "let x = crate::a::c::make(crate::a::b::N);"),
        ["a::b", "a::c"]
    );
    assert!(
        found(
            "e",
            "// use crate::a;\nlet s = \"crate::a\"; let c = '\"'; my_crate::a();"
        )
        .is_empty()
    );
}
