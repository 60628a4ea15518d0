//! Every loop of the flight core ends after a known number of iterations, as `docs/timing.md` claims.
//!
//! A `for` over an array, a slice or an iterator over one ends with it. Every other loop needs a comment directly
//! above that begins with `Iterations:`; people judge its content. This test finds such loops by words, not with the
//! compiler: `while`, `loop`, a range without a constant end, an iterator without an end. It does not detect a range
//! in a variable. `.ci/panic-free` proves that no linked function calls itself.

use std::fs;
use std::path::{Path, PathBuf};

/// Iterators that may be endless, and imports that would hide them.
const ENDLESS: [&str; 5] =
    ["iter::repeat", "iter::successors", "iter::from_fn", ".cycle()", "use core::iter"];

/// Reason why a loop on this line needs a `Iterations:` comment; `None` if it needs none.
fn needs_telling(line: &str) -> Option<&'static str> {
    let words: Vec<&str> = line.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
    if words.contains(&"while") {
        return Some("while");
    }
    if words.contains(&"loop") {
        return Some("loop");
    }
    if ENDLESS.iter().any(|maker| line.contains(maker)) {
        return Some("an iterator that may be endless");
    }
    // A slice from an index ends with its array, and a counter zipped with an iterator ends with it.
    let open = line.match_indices("..)").any(|(end, _)| {
        let (before, from) = line[..end].rsplit_once('(').unwrap_or_default();
        let is_number = !from.is_empty() && from.chars().all(char::is_numeric);
        is_number && !["get", "get_mut", "zip"].iter().any(|call| before.ends_with(call))
    });
    if open {
        return Some("a range without an end");
    }
    let (_, over) = line.trim_start().strip_prefix("for ")?.split_once(" in ")?;
    let (start, end) = over.trim_start_matches('(').split_once("..")?;
    if start.contains('(') {
        return None;
    }
    let end = end.trim_start_matches('=').trim_end_matches('{').trim();
    // A number or a constant, alone or in an expression, or at most one.
    let is_constant = |end: &str| {
        let end =
            end.split(" as ").next().and_then(|end| end.split(')').next()).unwrap_or_default();
        let mut parts =
            end.split([' ', '*', '/', '+', '-']).filter(|part| !part.is_empty()).peekable();
        let is_one = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit();
        parts.peek().is_some() && parts.all(|part| part.starts_with(is_one))
    };
    let least = end.split_once(".min(").map(|(_, most)| most);
    (!is_constant(end) && !least.is_some_and(is_constant) && !over.starts_with("if "))
        .then_some("a range up to no constant")
}

/// Loops of `text` without a `Iterations:` comment: line, from 1, and the reason why they need one.
fn untold(text: &str) -> Vec<(usize, &'static str)> {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let (mut found, mut is_told) = (Vec::new(), false);
    for (number, line) in code.lines().enumerate() {
        let line = line.trim();
        if line.starts_with("//") {
            is_told |= line.starts_with("// Iterations: ");
            continue;
        }
        // Quoted text is not code.
        let unquoted: String = line.split('"').step_by(2).collect();
        let code = unquoted.split("//").next().unwrap_or_default();
        match needs_telling(code) {
            Some(why) if !is_told => found.push((number + 1, why)),
            _ => {}
        }
        is_told = false;
    }
    found
}

fn sources(place: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(place).unwrap().map(|entry| entry.unwrap().path());
    let files = entries.flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] });
    files.filter(|path| !path.ends_with("tests.rs")).collect()
}

#[test]
fn every_loop_of_the_flight_core_says_after_how_many_turns_it_ends() {
    let mut loops = Vec::new();
    for path in sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src")) {
        let found = untold(&fs::read_to_string(&path).unwrap());
        let told = |(line, why)| format!("{}:{line}: {why}", path.display());
        loops.extend(found.into_iter().map(told));
    }
    let loops = loops.join("\n");
    assert!(loops.is_empty(), "no comment above begins with \"// Iterations: \":\n{loops}");
}

/// The test of this check itself.
#[test]
fn a_loop_that_may_not_end_is_found() {
    for bad in [
        "while !done {",
        "    while let Some(next) = self.next() {",
        "loop {",
        "'search: loop {",
        "for index in 0..count {",
        "for index in first..=last {",
        "for k in 0..N * count {",
        "for k in 0.. {",
        "for k in (0..count).rev() {",
        "let found = (1..).find(|n| n * n > area);",
        "for value in iter::repeat(1.0) {",
        "let all = core::iter::from_fn(|| self.next());",
        "use core::iter::{once, repeat};",
        "// the comment\n// is about another subject\nwhile waiting {",
        "// Iterations: at most 3.\nlet a = 1;\nwhile waiting {",
    ] {
        assert_eq!(untold(bad).len(), 1, "{bad}");
        let last = bad.lines().last().unwrap();
        assert_eq!(untold(&format!("// Iterations: at most 3.\n{last}")), [], "{bad}");
    }
    for good in [
        "for axis in 0..3 {",
        "for state in 0..N / 2 {",
        "for b in index + 1..MAX {",
        "for b in 0..K.min(MAX) {",
        "for h in 1..=harmonics.min(MAX as u32) {",
        "let tail = bytes.get(2..).unwrap_or_default();",
        "for axis in (0..3).rev() {",
        "for value in &self.values {",
        "for (slot, number) in slots.iter().zip(0..) {",
        "f.write_str(\"the loop is late while it waits\")",
        "let a: [f64; 3] = core::array::from_fn(|k| b[k]);",
        "// while it waits in a loop",
        "#[cfg(test)]\nmod tests { while waiting {} }",
    ] {
        assert_eq!(untold(good), [], "{good}");
    }
}
