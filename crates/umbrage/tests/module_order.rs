//! A module uses only modules that `lib.rs` declares before it: `id` and `progress` first, then the stages in the order
//! of the pipeline.
//!
//! Idea: read the order from `lib.rs`, then read every source file as a stream of names and punctuation, follow the
//! paths that begin with `crate`, `self` or `super`, groups in braces included, and see where in the crate they lead.
//! It is no compiler: macros that build paths would escape it, and there are none.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};

/// A path that leads where it must not.
#[derive(Debug, PartialEq)]
struct Violation {
    file: String,
    line: usize,
    from: String,
    to: String,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, line, from, to } = self;
        write!(f, "{file}:{line}: `{from}` uses `{to}`, which comes after it or is no module")
    }
}

/// A name, or one character of punctuation (`:` stands for `::`), and its line.
type Token<'a> = (&'a str, usize);

/// Names and the punctuation that matters, without comments, strings and characters.
fn tokens(source: &str) -> Vec<Token<'_>> {
    let bytes = source.as_bytes();
    let (mut tokens, mut at, mut line) = (Vec::new(), 0, 1);
    let is_name = |b: u8| b.is_ascii_alphanumeric() || b == b'_' || b >= 0x80;
    while at < bytes.len() {
        let rest = &source[at..];
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            block_comment(rest)
        } else if let Some(length) = string(rest) {
            length
        } else if is_name(bytes[at]) {
            let length = bytes[at..].iter().position(|&b| !is_name(b)).unwrap_or(rest.len());
            tokens.push((&rest[..length], line));
            length
        } else if rest.starts_with("::") {
            tokens.push((":", line));
            2
        } else {
            if matches!(bytes[at], b'{' | b'}' | b',' | b';' | b'*') {
                tokens.push((&rest[..1], line));
            }
            1
        };
        line += rest[..length].matches('\n').count();
        at += length;
    }
    tokens
}

/// Length of a block comment, nested ones included.
fn block_comment(rest: &str) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < rest.len() {
        let (step, change) = match &rest.as_bytes()[at..] {
            [b'/', b'*', ..] => (2, 1),
            [b'*', b'/', ..] => (2, -1),
            _ => (1, 0),
        };
        depth += change;
        at += step;
        if depth == 0 {
            break;
        }
    }
    at
}

/// Length of a string or character literal at the beginning of `rest`, if one is there.
fn string(rest: &str) -> Option<usize> {
    let raw = rest.trim_start_matches(['b', 'c']);
    if let Some(hashes) = raw.strip_prefix('r').map(|raw| raw.len() - raw.trim_start_matches('#').len()) {
        let prefix = rest.len() - raw.len() + 1 + hashes;
        if rest.as_bytes().get(prefix) == Some(&b'"') && rest.len() - raw.len() <= 1 {
            let end = format!("\"{}", "#".repeat(hashes));
            return Some(rest[prefix + 1..].find(&end).map_or(rest.len(), |n| prefix + 1 + n + end.len()));
        }
    }
    let quote = if let Some(inner) = rest.strip_prefix('"') {
        (inner, '"')
    } else if let Some(inner) = rest.strip_prefix('\'') {
        // 'a is a lifetime, 'a' and '\n' are characters.
        let mut chars = inner.chars();
        let escaped = chars.next()? == '\\';
        if !escaped && chars.next()? != '\'' {
            return Some(1);
        }
        (inner, '\'')
    } else {
        return None;
    };
    let (inner, end) = quote;
    let mut escaped = false;
    for (i, c) in inner.char_indices() {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            _ if c == end => return Some(1 + i + 1),
            _ => {}
        }
    }
    Some(rest.len())
}

/// The modules that a crate root declares, in order.
fn declared(root: &str) -> Vec<String> {
    let tokens = tokens(root);
    tokens
        .windows(3)
        .filter(|window| window[0].0 == "mod" && window[2].0 == ";")
        .map(|window| window[1].0.to_owned())
        .collect()
}

/// Where a path that begins at `tokens[at]` leads: the first name under the crate's root of each of its branches.
fn targets(tokens: &[Token<'_>], at: usize, module: &[String], found: &mut Vec<(String, usize)>) -> usize {
    let mut place: Vec<String> = match tokens[at].0 {
        "crate" => Vec::new(),
        "self" => module.to_vec(),
        // `super`
        _ => module[..module.len().saturating_sub(1)].to_vec(),
    };
    let mut at = at + 1;
    while at + 1 < tokens.len() && tokens[at].0 == ":" {
        match tokens[at + 1].0 {
            "super" => {
                place.pop();
            }
            "self" => {}
            "{" if place.is_empty() => return group(tokens, at + 2, found),
            "{" | "*" => break,
            name => place.push(name.to_owned()),
        }
        at += 2;
    }
    found.extend(place.first().map(|name| (name.clone(), tokens[at - 1].1)));
    at
}

/// The first names of a group `{a, b::{c, d}, e}` at the crate's root; `at` is behind its opening brace.
fn group(tokens: &[Token<'_>], mut at: usize, found: &mut Vec<(String, usize)>) -> usize {
    let (mut depth, mut first) = (1, true);
    while at < tokens.len() && depth > 0 {
        match tokens[at].0 {
            "{" => depth += 1,
            "}" => depth -= 1,
            "," if depth == 1 => first = true,
            name if first => {
                first = false;
                found.push((name.to_owned(), tokens[at].1));
            }
            _ => {}
        }
        at += 1;
    }
    at
}

/// All paths of a file that lead to a later module, or to something at the crate's root that is no module.
fn violations(order: &[String], file: &str, module: &[&str], source: &str) -> Vec<Violation> {
    let tokens = tokens(source);
    let mut module: Vec<String> = module.iter().map(|name| (*name).to_owned()).collect();
    let position = |name: &str| order.iter().position(|declared| declared == name);
    let own = position(&module[0]).unwrap_or_else(|| panic!("{file}: `{}` is not declared in lib.rs", module[0]));
    // How many braces are open, and where inline modules were opened.
    let (mut depth, mut inline, mut found, mut at) = (0usize, Vec::new(), Vec::new(), 0);
    while at < tokens.len() {
        let after_path = at > 0 && tokens[at - 1].0 == ":";
        match tokens[at].0 {
            "mod" if tokens.get(at + 2).is_some_and(|token| token.0 == "{") => {
                module.push(tokens[at + 1].0.to_owned());
                inline.push(depth);
                depth += 1;
                at += 3;
                continue;
            }
            "{" => depth += 1,
            "}" => {
                depth = depth.saturating_sub(1);
                if inline.last() == Some(&depth) {
                    inline.pop();
                    module.pop();
                }
            }
            "crate" | "super" | "self" if !after_path && tokens.get(at + 1).is_some_and(|token| token.0 == ":") => {
                at = targets(&tokens, at, &module, &mut found);
                continue;
            }
            _ => {}
        }
        at += 1;
    }
    found
        .into_iter()
        .filter(|(to, _)| position(to).is_none_or(|to| to > own))
        .map(|(to, line)| Violation { file: file.to_owned(), line, from: module[0].clone(), to })
        .collect()
}

/// All `.rs` files under a folder, in order of their names.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    let mut files = Vec::new();
    for path in entries {
        if path.is_dir() {
            files.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files
}

#[test]
fn every_module_uses_only_those_before_it() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let order = declared(&fs::read_to_string(root.join("lib.rs")).unwrap());
    assert_eq!(order[..2], ["id", "progress"], "ids and progress come first");
    let mut all = Vec::new();
    for path in sources(&root) {
        let relative = path.strip_prefix(&root).unwrap().with_extension("");
        let mut module: Vec<&str> = relative.iter().map(|name| name.to_str().unwrap()).collect();
        if module == ["lib"] {
            continue;
        }
        if module.last() == Some(&"mod") {
            module.pop();
        }
        let file = format!("src/{}.rs", relative.display());
        all.extend(violations(&order, &file, &module, &fs::read_to_string(&path).unwrap()));
    }
    let list: Vec<String> = all.iter().map(Violation::to_string).collect();
    assert!(list.is_empty(), "modules out of order:\n{}", list.join("\n"));
}

fn order() -> Vec<String> {
    declared("//! pub mod zero;\npub mod id;\n/* mod one; */ mod scene;\npub mod mesh;\npub use mesh::Mesh;")
}

/// Where the paths of a made-up file `scene/material.rs` lead against the order.
fn wrong(source: &str) -> Vec<(String, usize)> {
    violations(&order(), "scene/material.rs", &["scene", "material"], source)
        .into_iter()
        .map(|violation| (violation.to, violation.line))
        .collect()
}

#[test]
fn the_order_is_read_from_the_declarations() {
    assert_eq!(order(), ["id", "scene", "mesh"]);
}

#[test]
fn a_later_module_is_found_however_it_is_named() {
    let mesh = |line| vec![("mesh".to_owned(), line)];
    assert_eq!(wrong("use crate::mesh::Mesh;"), mesh(1));
    assert_eq!(wrong("\nfn f() { let m = crate::mesh::new(); }"), mesh(2));
    assert_eq!(wrong("use crate::{id::FaceId, mesh::{Mesh, Patch}};"), mesh(1));
    assert_eq!(wrong("use crate::{\n    id,\n    mesh,\n};"), mesh(3));
    assert_eq!(wrong("use super::super::mesh::Mesh;"), mesh(1));
    assert_eq!(wrong("mod tests { use super::super::super::mesh; }"), mesh(1));
    assert_eq!(wrong("mod a { mod b {} } use super::super::mesh;"), mesh(1));
    assert_eq!(wrong("fn f<'a>(x: &'a str) { let c = '\"'; crate::mesh::g() }"), mesh(1));
    assert_eq!(wrong("use crate::Mesh;"), [("Mesh".to_owned(), 1)], "a re-export at the root hides the order");
}

#[test]
fn what_is_in_order_is_let_through() {
    for source in [
        "use crate::id::FaceId; use crate::scene::Material; use super::Scene; use self::inner::x;",
        "mod tests { use super::*; use super::super::cornell; use crate::{id, scene::{mesh, x}}; }",
        "// crate::mesh\n/* crate::mesh /* crate::mesh */ crate::mesh */ /// [`crate::mesh`]",
        "const A: &str = \"crate::mesh \\\" crate::mesh\"; const B: &str = r#\"crate::mesh \" crate::mesh\"#;",
        "pub(crate) fn mesh() {} pub(super) struct S; use other::crate_mesh; let mesh = self.mesh;",
    ] {
        assert_eq!(wrong(source), [], "{source}");
    }
}

#[test]
fn a_violation_names_its_place() {
    let found = &violations(&order(), "src/id.rs", &["id"], "\nuse crate::scene::Scene;")[0];
    assert_eq!(found.to_string(), "src/id.rs:2: `id` uses `scene`, which comes after it or is no module");
}
