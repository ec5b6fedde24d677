//! The pages of the book hold what they show: commands run, messages are those of the program, scenes are scenes.
//!
//! Each page has a folder of its own, with `samples` in it, and its blocks are taken in their order:
//!
//! - of `console` blocks every line that begins with `$ microslip` is run and must succeed; lines below it must appear in what it prints,
//!   in this order, with numbers equal to three digits, counts to within two (iterations differ between processors), bounds (`< 1e-9`) of any
//!   size, and `...` for any words;
//! - `json` blocks must be scenes, or members of scenes;
//! - `python` blocks without the package of this repository are run where Python (`PYTHON`, else `python3`) has NumPy, `matlab` blocks where there is `octave`.
//!
//! A comment before a block says what else is done with it:
//!
//! | comment | block |
//! |---|---|
//! | `<!-- book: file PATH -->` | is written to a file |
//! | `<!-- book: plan PATH -->` | is written to a file, and is no scene but the plan of a study |
//! | `<!-- book: merge PATH -->` | is merged into a scene (RFC 7396) |
//! | `<!-- book: fails COMMAND -->` | is what this command says when it fails |
//! | `<!-- book: within FIELD -->` | belongs into this object of a scene |
//! | `<!-- book: skip REASON -->` | is not run, since it needs what the test does not have |
//!
//! `<!-- book: merge PATH JSON -->` needs no block. `BOOK_PAGE=docs/tutorial.md` checks one page alone.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "helpers of tests")]
#![expect(clippy::print_stdout, reason = "tests say what they skip, and this one what it did")]

use crate::common::{copy, folder, read_json, succeeds};
use boon::{Compiler, SchemaIndex, Schemas};
use serde_json::{Map, Value, json};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Commands that are not those of the program; those of a checkout are run by the gates.
const OTHERS: [&str; 5] = ["cargo ", "cd ", "pip ", "pytest ", "python "];

struct Block<'a> {
    line: usize,
    language: &'a str,
    text: String,
    /// What the comment before it says.
    directive: Option<(&'a str, &'a str)>,
}

enum Item<'a> {
    Block(Block<'a>),
    /// A scene and what is merged into it.
    Merge(&'a str, &'a str),
}

/// What a page holds beside its prose.
fn items(page: &str) -> Vec<Item<'_>> {
    let (mut items, mut directive, mut open) = (Vec::new(), None, None::<Block<'_>>);
    for (index, line) in page.lines().enumerate() {
        let trimmed = line.trim_start();
        if let Some(fence) = trimmed.strip_prefix("```") {
            match open.take() {
                Some(block) => items.push(Item::Block(block)),
                None => {
                    open = Some(Block {
                        line: index + 2,
                        language: fence,
                        text: String::new(),
                        directive: directive.take(),
                    })
                }
            }
        } else if let Some(block) = &mut open {
            block.text += line;
            block.text.push('\n');
        } else if let Some(comment) = trimmed.strip_prefix("<!-- book: ") {
            let comment = comment.strip_suffix(" -->").expect("a comment ends on its line");
            let (verb, rest) = comment.split_once(' ').expect("a comment says what about");
            assert!(directive.is_none(), "line {}: a comment without a block", index + 1);
            match rest.split_once(" {") {
                Some((path, _)) if verb == "merge" => items.push(Item::Merge(path, &rest[path.len() + 1..])),
                _ => directive = Some((verb, rest)),
            }
        }
    }
    assert!(
        open.is_none() && directive.is_none(),
        "a block or a comment without an end"
    );
    items
}

/// The page's text without what `//` begins, which no string of a scene has.
fn parsed(text: &str) -> Value {
    let lines: Vec<&str> = text.lines().map(|line| line.split("//").next().unwrap()).collect();
    let text = lines.join("\n");
    let text = text.trim();
    let members = match text.starts_with('{') {
        true => text.to_owned(),
        false => format!("{{ {text} }}"),
    };
    serde_json::from_str(&members).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// RFC 7396.
fn merge(target: &mut Value, patch: &Value) {
    let Value::Object(patch) = patch else {
        *target = patch.clone();
        return;
    };
    if !target.is_object() {
        *target = json!({});
    }
    let target = target.as_object_mut().unwrap();
    for (name, value) in patch {
        match value {
            Value::Null => drop(target.remove(name)),
            _ => merge(target.entry(name).or_insert(Value::Null), value),
        }
    }
}

/// Whether words of a page are those of a line: the same, numbers to three digits, `...` for any.
fn fits(expected: &[&str], found: &[&str]) -> bool {
    match (expected, found) {
        ([], []) => true,
        (["<", _, expected @ ..], ["<", _, found @ ..]) => fits(expected, found),
        (["...", rest @ ..], _) => (0..=found.len()).any(|skipped| fits(rest, &found[skipped..])),
        ([a, expected @ ..], [b, found @ ..]) => same_word(a, b) && fits(expected, found),
        _ => false,
    }
}

fn same_word(a: &str, b: &str) -> bool {
    let number = |word: &str| word.trim_matches([',', ';', '(', ')', ':']).parse::<f64>().ok();
    match (number(a), number(b)) {
        (Some(a), Some(b)) => {
            let counts = a.fract() == 0.0 && b.fract() == 0.0 && a.abs() >= 10.0;
            (a - b).abs() <= (1e-3 * b.abs()).max(if counts { 2.0 } else { 0.0 })
        }
        _ => a == b,
    }
}

/// Asserts that lines of a page are among those that were printed, in their order.
fn assert_printed(expected: &[&str], printed: &str, place: &str) {
    let mut lines = printed.lines();
    for line in expected.iter().filter(|line| !line.trim().is_empty()) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let found = lines.any(|found| fits(&words, &found.split_whitespace().collect::<Vec<_>>()));
        assert!(found, "{place}: `{line}` is not in\n{printed}");
    }
}

/// A program that finds the one under test.
fn command(folder: &Path, program: &str) -> Command {
    let ours = Path::new(crate::PROGRAM).parent().unwrap().display();
    let path = format!("{ours}:{}", std::env::var("PATH").unwrap());
    let mut command = Command::new(program);
    command
        .current_dir(folder)
        .env("PATH", path)
        .env("XDG_CACHE_HOME", folder.join("../caches"));
    command
}

/// Runs a line of a shell.
fn shell(folder: &Path, line: &str) -> Output {
    command(folder, "sh").args(["-e", "-c", line]).output().unwrap()
}

fn text_of(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The schema of scenes, for parts of them: nothing is required.
fn parts_of_scenes(folder: &Path) -> (Schemas, SchemaIndex) {
    fn relax(value: &mut Value) {
        match value {
            Value::Object(members) => {
                if members.get("required").is_some_and(Value::is_array) {
                    members.remove("required");
                }
                if let Some(one) = members.remove("oneOf") {
                    members.insert("anyOf".into(), one);
                }
                members.values_mut().for_each(relax);
            }
            Value::Array(values) => values.iter_mut().for_each(relax),
            _ => {}
        }
    }
    let mut schema: Value = serde_json::from_str(&succeeds(folder, &["schema", "scene"])).unwrap();
    relax(&mut schema);
    let (mut schemas, mut compiler) = (Schemas::new(), Compiler::new());
    compiler.add_resource("scene.json", schema).unwrap();
    let index = compiler.compile("scene.json", &mut schemas).unwrap();
    (schemas, index)
}

struct Book {
    root: PathBuf,
    folder: PathBuf,
    schemas: Schemas,
    part: SchemaIndex,
    python: Option<String>,
    octave: Option<String>,
}

impl Book {
    fn open() -> Self {
        let folder = folder("book");
        succeeds(&folder, &["samples", "samples"]);
        let (schemas, part) = parts_of_scenes(&folder);
        let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".into());
        let found = |program: &str, arguments: &[&str]| {
            let done = Command::new(program).args(arguments).output();
            let is_there = done.is_ok_and(|done| done.status.success());
            if !is_there {
                println!("skipped: blocks that `{program} {}` is needed for", arguments.join(" "));
            }
            is_there.then(|| program.to_owned())
        };
        Self {
            root: Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."),
            folder,
            schemas,
            part,
            python: found(&python, &["-c", "import numpy"]),
            octave: found("octave", &["--no-gui", "--version"]),
        }
    }

    /// Does what a page shows; returns how many commands were run, how many scenes were read and how many blocks were skipped.
    fn check(&self, page: &str) -> [usize; 3] {
        let text = std::fs::read_to_string(self.root.join(page)).unwrap();
        let folder = self.folder.join(page.replace(['/', '.'], "-"));
        std::fs::create_dir_all(&folder).unwrap();
        if !text.contains("$ microslip samples samples") {
            copy(&self.folder.join("samples"), &folder.join("samples"));
        }
        let mut counts = [0; 3];
        for item in items(&text) {
            match item {
                Item::Merge(path, patch) => self.merge(&folder.join(path), &parsed(patch)),
                Item::Block(block) => self.take(page, &folder, &block, &mut counts),
            }
        }
        counts
    }

    fn take(&self, page: &str, folder: &Path, block: &Block<'_>, counts: &mut [usize; 3]) {
        let place = format!("{page}:{}", block.line);
        match (block.directive, block.language) {
            (Some(("skip", _)), _) => counts[2] += 1,
            (Some(("plan", path)), "json") => std::fs::write(folder.join(path), &block.text).unwrap(),
            (Some(("file", path)), _) => {
                std::fs::write(folder.join(path), &block.text).unwrap();
                if path.ends_with(".json") {
                    self.assert_scene(&parsed(&block.text), &place);
                    counts[1] += 1;
                }
            }
            (Some(("merge", path)), "json") => {
                let patch = parsed(&block.text);
                self.assert_scene(&patch, &place);
                self.merge(&folder.join(path), &patch);
                counts[1] += 1;
            }
            (Some(("fails", command)), "text") => {
                let done = shell(folder, command);
                assert!(!done.status.success(), "{place}: `{command}` succeeds");
                let lines: Vec<&str> = block.text.lines().collect();
                assert_printed(&lines, &text_of(&done.stderr), &place);
                counts[0] += 1;
            }
            (Some(("within", field)), "json") => {
                let inner = field.rsplit('.').fold(parsed(&block.text), |inner, name| {
                    Value::Object(Map::from_iter([(name.to_owned(), inner)]))
                });
                self.assert_scene(&inner, &place);
                counts[1] += 1;
            }
            (None, "json") => {
                self.assert_scene(&parsed(&block.text), &place);
                counts[1] += 1;
            }
            (None, "console") => counts[0] += console(folder, &block.text, &place),
            // The tests of the Python package run its pages.
            (None, "python") if page.contains("guide/python") || block.text.contains("import microslip") => {}
            (None, "python" | "matlab") => {
                let (program, flags) = match block.language {
                    "python" => (&self.python, &["-c"][..]),
                    _ => (&self.octave, &["--no-gui", "--eval"][..]),
                };
                if let Some(program) = program {
                    let done = command(folder, program).args(flags).arg(&block.text).output().unwrap();
                    assert!(done.status.success(), "{place}: {}", text_of(&done.stderr));
                    counts[0] += 1;
                }
            }
            // Output, formulas and pictures; blocks of Rust are tests of the documentation.
            (None, "text" | "rust" | "rust,no_run") => {}
            (directive, language) => panic!("{place}: `{language}` with {directive:?} is not known"),
        }
    }

    fn merge(&self, path: &Path, patch: &Value) {
        let mut scene = read_json(path);
        merge(&mut scene, patch);
        std::fs::write(path, serde_json::to_string_pretty(&scene).unwrap()).unwrap();
    }

    fn assert_scene(&self, part: &Value, place: &str) {
        let valid = self.schemas.validate(part, self.part);
        valid.unwrap_or_else(|error| panic!("{place}: {error:#}"));
    }
}

/// Runs the commands of a block and returns their number.
fn console(folder: &Path, block: &str, place: &str) -> usize {
    let (mut run, mut lines) = (0, block.lines().peekable());
    while let Some(line) = lines.next() {
        let command = line
            .strip_prefix("$ ")
            .unwrap_or_else(|| panic!("{place}: `{line}` is no command"));
        let mut expected = Vec::new();
        while let Some(line) = lines.next_if(|line| !line.starts_with("$ ")) {
            expected.push(line);
        }
        if OTHERS.iter().any(|other| command.starts_with(other)) {
            continue;
        }
        assert!(
            command.starts_with("microslip "),
            "{place}: `{command}` is not a command of the program"
        );
        let done = shell(folder, command);
        assert!(done.status.success(), "{place}: `{command}`: {}", text_of(&done.stderr));
        assert_printed(&expected, &text_of(&done.stdout), place);
        run += 1;
    }
    run
}

/// Every page that the table of contents lists, and the README.
fn pages(root: &Path) -> Vec<String> {
    let contents = std::fs::read_to_string(root.join("docs/SUMMARY.md")).unwrap();
    let links = contents.split("](").skip(1).map(|rest| rest.split(')').next().unwrap());
    let pages = links.map(|page| format!("docs/{page}"));
    std::iter::once("README.md".to_owned()).chain(pages).collect()
}

#[test]
#[ignore = "a minute; `.ci/run slow` runs it"]
fn slow_every_command_and_scene_of_the_book_works() {
    let book = Book::open();
    let pages = pages(&book.root);
    let listed: Vec<PathBuf> = pages.iter().map(|page| book.root.join(page)).collect();
    assert!(pages.len() > 25, "{pages:?}");
    // No page is left out of the book.
    for folder in ["docs", "docs/guide", "docs/laws"] {
        for entry in std::fs::read_dir(book.root.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|e| e == "md") && !path.ends_with("SUMMARY.md") {
                assert!(listed.contains(&path), "{} is not in SUMMARY.md", path.display());
            }
        }
    }
    let only = std::env::var("BOOK_PAGE").ok();
    let (mut all, mut failed) = ([0; 3], Vec::new());
    for page in pages
        .iter()
        .filter(|page| only.as_ref().is_none_or(|only| *page == only))
    {
        // So that one run finds what is wrong on every page.
        match catch_unwind(AssertUnwindSafe(|| book.check(page))) {
            Ok(counts) => {
                println!(
                    "{page}: {} commands, {} scenes, {} skipped",
                    counts[0], counts[1], counts[2]
                );
                for (sum, count) in all.iter_mut().zip(counts) {
                    *sum += count;
                }
            }
            Err(_) => failed.push(page),
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
    assert!(only.is_some() || (all[0] > 30 && all[1] > 20), "{all:?}");
}

#[test]
fn lines_of_a_page_are_compared_with_what_is_printed() {
    let words = |line: &'static str| line.split_whitespace().collect::<Vec<_>>();
    assert!(fits(
        &words("stuck, 6 modes: 204.54 234.95 ..."),
        &words("stuck, 6 modes: 204.541 235.0 630.06 1.0")
    ));
    assert!(!fits(
        &words("stuck, 6 modes: 204.54"),
        &words("stuck, 7 modes: 204.54")
    ));
    assert!(fits(&words("1 < 5.9e-10 105"), &words("1 < 2e-11 106")));
    assert!(!fits(
        &words("stuck, 6 modes: 204.54"),
        &words("stuck, 6 modes: 205.54")
    ));
    assert!(!fits(
        &words("stuck, 6 modes: 204.54"),
        &words("stuck, 6 modes: 204.54 1.0")
    ));
    let mut scene = json!({ "a": { "b": 1, "c": 2 } });
    merge(&mut scene, &json!({ "a": { "b": null, "d": [3] }, "e": 4 }));
    assert_eq!(scene, json!({ "a": { "c": 2, "d": [3] }, "e": 4 }));
    let page = "<!-- book: merge a.json { \"x\": 1 } -->\n<!-- book: file b.json -->\n```json\n\"y\": 2 // why\n```\n";
    let found = items(page);
    assert!(matches!(&found[0], Item::Merge("a.json", "{ \"x\": 1 }")));
    assert!(
        matches!(&found[1], Item::Block(block) if block.directive == Some(("file", "b.json")) && parsed(&block.text) == json!({ "y": 2 }))
    );
}
