//! Code that fits a screen: no function over 60 lines, none with more than six parameters, no file over 400 lines without its
//! tests.

use crate::sources::{code, sources, without_tests};

/// Lines of a function.
const MAX_LINES: usize = 60;

/// Parameters of a function, `self` among them.
const MAX_PARAMETERS: usize = 6;

/// Lines of a file before its tests.
const MAX_FILE: usize = 400;

/// A function as it stands in a file.
#[derive(Debug, PartialEq)]
struct Function {
    name: String,
    parameters: usize,
    /// From its name to the end of its body; one without a body has none.
    lines: usize,
}

/// Where the bracket that `text` begins with is closed. The arrow is no bracket.
fn closed_at(text: &str) -> usize {
    let (mut depth, mut before) = (0, ' ');
    for (at, c) in text.char_indices() {
        match c {
            '(' | '[' | '{' | '<' => depth += 1,
            '>' if before == '-' || before == '=' => {}
            ')' | ']' | '}' | '>' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at;
        }
        before = c;
    }
    text.len()
}

/// The same for the brace of a body, in which `<` compares.
fn body_end(text: &str) -> usize {
    let mut depth = 0;
    for (at, c) in text.char_indices() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if depth == 0 {
            return at;
        }
    }
    text.len()
}

/// How many items a list in brackets has.
fn count_items(list: &str) -> usize {
    let (mut count, mut is_empty, mut at) = (0, true, 0);
    while at < list.len() {
        let rest = &list[at..];
        if rest.starts_with(',') {
            count += usize::from(!is_empty);
            is_empty = true;
        } else if rest.starts_with(['(', '[', '{', '<']) {
            at += closed_at(rest);
            is_empty = false;
        } else if !rest.starts_with(char::is_whitespace) {
            is_empty = false;
        }
        at += list[at..].chars().next().map_or(1, char::len_utf8);
    }
    count + usize::from(!is_empty)
}

/// The functions in a text.
fn functions(text: &str) -> Vec<Function> {
    let text = code(text);
    let mut found = Vec::new();
    for (at, _) in text.match_indices("fn ") {
        let is_word = !text[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
        let head = &text[at + 3..];
        let name_end = head
            .find(|c: char| !(c.is_alphanumeric() || c == '_'))
            .unwrap_or(0);
        if !is_word || name_end == 0 {
            continue;
        }
        let mut rest = &head[name_end..];
        if rest.starts_with('<') {
            rest = &rest[closed_at(rest) + 1..];
        }
        let end = closed_at(rest);
        let after = &rest[end..];
        // A semicolon within brackets is that of an array.
        let body = after
            .find(['{', ';'])
            .filter(|&at| after[at..].starts_with('{'));
        let lines = body.map_or(0, |body| {
            let end = body + body_end(&after[body..]);
            let start = head.len() - after.len();
            1 + head[..start + end].matches('\n').count()
        });
        found.push(Function {
            name: head[..name_end].to_string(),
            parameters: count_items(&rest[1..end]),
            lines,
        });
    }
    found
}

#[test]
fn functions_and_files_fit_a_screen() {
    let mut too_large = Vec::new();
    for source in &sources() {
        let text = without_tests(&source.text);
        let (path, lines) = (source.path.display(), text.lines().count());
        if lines > MAX_FILE {
            too_large.push(format!("{path} has {lines} lines"));
        }
        for Function {
            name,
            parameters,
            lines,
        } in functions(text)
        {
            if lines > MAX_LINES {
                too_large.push(format!("{path}: {name} has {lines} lines"));
            }
            if parameters > MAX_PARAMETERS {
                too_large.push(format!("{path}: {name} has {parameters} parameters"));
            }
        }
    }
    assert!(too_large.is_empty(), "{too_large:#?}");
}

#[test]
fn functions_are_measured() {
    let text = "impl<T> A<T> {\n    /// fn no()\n    fn one<R: Fn(u8, u8) -> u8>(&mut self, (a, b): (u8, [u8; 2]), c: Map<K, V>,\n    ) -> T\n    {\n        \
                if a < b { \"}\" } else { '{' }\n    }\n}\nfn two();\nlet f: fn(u8) -> u8;\nfn three() -> u8 { 1 }\n";
    let function = |name: &str, parameters, lines| Function {
        name: name.into(),
        parameters,
        lines,
    };
    assert_eq!(
        functions(text),
        [
            function("one", 3, 5),
            function("two", 0, 0),
            function("three", 0, 1)
        ]
    );
    let long = format!("fn long(a: u8, b: u8) {{\n{}}}\n", "    a();\n".repeat(60));
    assert_eq!(functions(&long), [function("long", 2, 62)]);
    let many = "fn many(a: A, b: B, c: C, d: D, e: E, f: impl Fn(A, B), g: G) {}";
    assert_eq!(functions(many), [function("many", 7, 1)]);
}
