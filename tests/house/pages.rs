//! Claims of the pages under `docs`, of the README and of the comments: equations, links, files, dependencies, kinds of
//! findings.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use hovernav_findings::FindingKind;
use serde_json::Value;

use crate::{ROOT, cargo, sources};

/// The equations of `docs/equations.md`: number, function, file.
fn equations() -> Vec<(String, String, String)> {
    let text = fs::read_to_string(format!("{ROOT}/docs/equations.md")).unwrap();
    text.lines()
        .filter_map(|line| {
            let (number, rest) = line.strip_prefix("**(")?.split_once(")**")?;
            let mut quoted = rest.split('`').skip(1).step_by(2);
            let (function, file) = (quoted.next()?, quoted.next()?);
            Some((number.to_owned(), function.to_owned(), file.to_owned()))
        })
        .collect()
}

#[test]
fn every_equation_stands_in_the_function_it_names() {
    let equations = equations();
    assert!(equations.len() > 100, "{}", equations.len());
    let mut numbers = BTreeSet::new();
    for (number, function, file) in equations {
        let text = fs::read_to_string(format!("{ROOT}/{file}"))
            .unwrap_or_else(|_| panic!("({number}): there is no {file}"));
        let holds = [format!("fn {function}("), format!("fn {function}<")]
            .iter()
            .any(|declaration| text.contains(declaration));
        assert!(holds, "({number}): no function {function} in {file}");
        assert!(text.contains(&format!("({number})")), "({number}): {file} does not cite it");
        assert!(numbers.insert(number.clone()), "({number}) is given out twice");
    }
}

#[test]
fn every_equation_that_is_cited_exists() {
    let numbers: BTreeSet<String> = equations().into_iter().map(|(number, ..)| number).collect();
    for path in sources() {
        let text = fs::read_to_string(&path).unwrap();
        for line in text.lines().filter(|line| line.contains("of docs/equations.md")) {
            for cited in line.split('(').skip(1).filter_map(|part| part.split(')').next()) {
                let is_number = cited.starts_with(|c: char| c.is_ascii_uppercase())
                    && cited[1..].chars().all(|c| c.is_ascii_digit())
                    && cited.len() > 1;
                let place = path.display();
                assert!(!is_number || numbers.contains(cited), "{place} cites ({cited})");
            }
        }
    }
}

/// The Markdown files of a folder of the checkout.
fn markdown_in(folder: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(Path::new(ROOT).join(folder)).unwrap();
    let mut pages: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    pages.retain(|page| page.extension().is_some_and(|extension| extension == "md"));
    pages.sort();
    pages
}

/// The front page, the rules for contributors, and the pages of `docs`.
fn pages() -> Vec<PathBuf> {
    let mut pages: Vec<PathBuf> =
        ["README.md", "CONTRIBUTING.md"].map(|page| format!("{ROOT}/{page}").into()).to_vec();
    pages.extend(markdown_in("docs"));
    pages.extend(markdown_in("docs/validation"));
    pages
}

/// The lines of a page outside its blocks of code.
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut fenced = false;
    text.lines().filter(move |line| {
        let is_fence = line.starts_with("```");
        fenced ^= is_fence;
        !fenced && !is_fence
    })
}

/// The targets of the links and pictures of a page, except those on the web.
fn link_targets(text: &str) -> Vec<String> {
    let mut targets = Vec::new();
    for line in prose(text) {
        let outside_code: String = line.split('`').step_by(2).collect();
        let inline = outside_code.split("](").skip(1).filter_map(|part| part.split(')').next());
        targets.extend(inline.map(str::to_owned));
        let definition = line.strip_prefix('[').and_then(|rest| rest.split_once("]: "));
        targets.extend(definition.map(|(_, target)| target.to_owned()));
    }
    targets.retain(|target| !target.contains("://"));
    targets
}

/// The anchor that GitHub and mdBook give to a heading.
fn anchor(heading: &str) -> String {
    let letters = heading.trim().chars().filter_map(|letter| match letter {
        ' ' => Some('-'),
        '-' | '_' => Some(letter),
        _ => letter.is_alphanumeric().then_some(letter),
    });
    letters.flat_map(char::to_lowercase).collect()
}

#[test]
fn every_link_of_a_page_leads_to_a_file_and_a_heading() {
    let mut count = 0;
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        for target in link_targets(&text) {
            let (file, heading) = target.split_once('#').unwrap_or((&target, ""));
            let path = match file {
                "" => page.clone(),
                file => page.parent().unwrap().join(file),
            };
            assert!(path.exists(), "{}: no file for {target}", page.display());
            if !heading.is_empty() {
                let linked = fs::read_to_string(&path).unwrap();
                let is_there = prose(&linked)
                    .filter(|line| line.starts_with('#'))
                    .any(|line| anchor(line.trim_start_matches('#')) == heading);
                assert!(is_there, "{}: no heading for {target}", page.display());
            }
            count += 1;
        }
    }
    assert!(count > 100, "{count}");
}

#[test]
fn the_book_lists_every_page_once() {
    let docs = Path::new(ROOT).join("docs");
    let mut listed = link_targets(&fs::read_to_string(docs.join("SUMMARY.md")).unwrap());
    let mut written: Vec<String> = [markdown_in("docs"), markdown_in("docs/validation")]
        .concat()
        .iter()
        .map(|page| page.strip_prefix(&docs).unwrap().to_str().unwrap().to_owned())
        .filter(|page| page != "SUMMARY.md")
        .collect();
    listed.sort_unstable();
    written.sort_unstable();
    assert_eq!(listed, written);
}

#[test]
fn every_file_that_the_documentation_names_exists() {
    let places = [
        "src/",
        "crates/",
        "cli/",
        "ffi/",
        "ground/",
        "tests/",
        "benches/",
        "examples/",
        "docs/",
        "fuzz/",
    ];
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        for quoted in text.split('`').skip(1).step_by(2) {
            if places.iter().any(|place| quoted.starts_with(place)) && !quoted.contains(' ') {
                let exists = Path::new(ROOT).join(quoted).exists();
                assert!(exists, "{} names {quoted}", page.display());
            }
        }
    }
}

/// The documentation is served from another location than the README's files. Each link to one has a definition in
/// `src/lib.rs`, which points to the same file in the repository.
#[test]
fn every_relative_link_of_the_readme_leads_somewhere_from_the_documentation() {
    let readme = fs::read_to_string(format!("{ROOT}/README.md")).unwrap();
    let lib = fs::read_to_string(format!("{ROOT}/src/lib.rs")).unwrap();
    let mut fenced = false;
    let mut count = 0;
    for line in readme.lines() {
        fenced ^= line.starts_with("```");
        if fenced {
            continue;
        }
        for target in line.split("](").skip(1).filter_map(|part| part.split(')').next()) {
            let leads_elsewhere = target.contains("://") || target.starts_with('#');
            assert!(leads_elsewhere, "write a reference and its definition for {target}");
        }
        let definition = line.strip_prefix('[').and_then(|rest| rest.split_once("]: "));
        if let Some((label, target)) = definition.filter(|(_, target)| !target.contains("://")) {
            assert!(Path::new(ROOT).join(target).exists(), "[{label}] leads to no file: {target}");
            let begins = format!("#![doc = \"[{label}]: https://");
            let ends = format!("/main/{target}\"]");
            let is_defined =
                lib.lines().any(|line| line.starts_with(&begins) && line.ends_with(&ends));
            assert!(is_defined, "src/lib.rs does not define [{label}] as {target}");
            count += 1;
        }
    }
    assert!(count > 10, "{count}");
}

/// The documentation compiles the README's program, and the example's test runs it.
#[test]
fn the_program_of_the_readme_is_that_of_the_example() {
    let readme = fs::read_to_string(format!("{ROOT}/README.md")).unwrap();
    let (_, after) = readme.split_once("```rust\n").unwrap();
    let (program, _) = after.split_once("```\n").unwrap();
    let example = fs::read_to_string(format!("{ROOT}/examples/02_own_sensors.rs")).unwrap();
    assert!(example.contains(program), "copy the beginning of the example into the README");
}

#[test]
fn every_direct_dependency_has_its_line() {
    let page = fs::read_to_string(format!("{ROOT}/docs/dependencies.md")).unwrap();
    let metadata: Value =
        serde_json::from_str(&cargo(&["metadata", "--no-deps", "--format-version", "1"])).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    for dependency in packages.iter().flat_map(|p| p["dependencies"].as_array().unwrap()) {
        let name = dependency["name"].as_str().unwrap();
        assert!(name.starts_with("hovernav") || page.contains(&format!("`{name}`")), "{name}");
    }
}

/// The kinds in the first column of the table of `docs/warnings.md`.
#[test]
fn every_kind_of_finding_has_its_line_and_every_line_is_of_kinds() {
    let page = fs::read_to_string(format!("{ROOT}/docs/warnings.md")).unwrap();
    let (_, after) = page.split_once("\n| kind |").unwrap();
    let (table, _) = after.split_once("\n\n").unwrap();
    let mut told: Vec<&str> = table
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split(" | ").next())
        .flat_map(|kinds| kinds.trim_end_matches('`').split("`, `"))
        .collect();
    let mut kinds = FindingKind::ALL.map(FindingKind::name);
    told.sort_unstable();
    kinds.sort_unstable();
    assert_eq!(told, kinds);
}
