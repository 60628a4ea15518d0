//! No two source files import each other, directly or through others, by `use` at the start of a line.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::ROOT;

/// Names of a path in the source, such as `crate`, `ekf`, `gate`.
type Names = Vec<String>;

/// A source file.
struct File {
    module: Names,
    /// Paths that it imports, and whether it only hands the name on.
    imports: Vec<(Names, bool)>,
}

/// The files of the crate with the source folder `src`.
fn files(src: &Path) -> BTreeMap<PathBuf, File> {
    let mut folders = vec![(src.to_owned(), Vec::new())];
    let mut files = BTreeMap::new();
    while let Some((folder, module)) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
            let inner: Names = module.iter().cloned().chain([name.clone()]).collect();
            if path.is_dir() {
                folders.push((path, inner));
            } else if path.extension().is_some_and(|ending| ending == "rs") && name != "tests" {
                let is_face = ["lib", "main", "mod"].contains(&&*name);
                let module = if is_face { module.clone() } else { inner };
                let text = std::fs::read_to_string(&path).unwrap();
                let text = text.split("#[cfg(test)]\nmod ").next().unwrap();
                let lines: Vec<&str> = text.lines().collect();
                files.insert(path, File { imports: imported(&lines, &module), module });
            }
        }
    }
    files
}

/// The paths imported by the statements `use` at the start of a line, without those of other crates.
fn imported(lines: &[&str], module: &[String]) -> Vec<(Names, bool)> {
    let mut imports = Vec::new();
    for (number, line) in lines.iter().enumerate() {
        let Some((before, first)) = line.split_once("use ") else { continue };
        if !(before.is_empty()
            || before == "pub "
            || (before.starts_with("pub(") && before.ends_with(") ")))
        {
            continue;
        }
        let rest = lines[number + 1..].iter().copied();
        let statement: String = [first].into_iter().chain(rest).collect::<Vec<_>>().join(" ");
        let tree = statement.split(';').next().unwrap();
        let mut paths = Vec::new();
        expand("", &tree.split_whitespace().collect::<Vec<_>>().join(" "), &mut paths);
        for path in paths {
            let mut names: Names = path.split("::").map(str::to_owned).collect();
            let mut from = module.to_vec();
            match names.first().map(String::as_str) {
                Some("crate") => from.clear(),
                Some("self" | "super") => {}
                // A child of this module, or another crate: only a child is a module of this crate.
                _ => names.insert(0, "self".to_owned()),
            }
            for name in names {
                match name.as_str() {
                    "crate" | "self" => {}
                    "super" => _ = from.pop(),
                    _ => from.push(name),
                }
            }
            imports.push((from, !before.is_empty()));
        }
    }
    imports
}

/// Adds the paths of the tree `rest`, such as `a::{b, c::d as e}`, each after `prefix`.
fn expand(prefix: &str, rest: &str, paths: &mut Vec<String>) {
    let Some((head, inner)) = rest.split_once('{') else {
        let path = rest.split(" as ").next().unwrap().trim();
        paths.push(format!("{prefix}{path}").trim_end_matches("::self").to_owned());
        return;
    };
    let prefix = format!("{prefix}{}", head.trim());
    let inner = inner.trim().strip_suffix('}').unwrap();
    let (mut depth, mut start) = (0, 0);
    for (place, letter) in inner.char_indices().chain([(inner.len(), ',')]) {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                if !inner[start..place].trim().is_empty() {
                    expand(&prefix, inner[start..place].trim(), paths);
                }
                start = place + 1;
            }
            _ => {}
        }
    }
}

/// The file that defines the last name of `path`: that of the innermost module in it, or the file from which that module
/// hands the name on.
fn defined<'a>(files: &'a BTreeMap<PathBuf, File>, path: &[String]) -> Option<&'a PathBuf> {
    let in_path = files.iter().filter(|(_, file)| path.starts_with(&file.module));
    let (own, file) = in_path.max_by_key(|(_, file)| file.module.len())?;
    let Some(name) = path.get(file.module.len()) else { return Some(own) };
    let mut imports = file.imports.iter().map(|(import, _)| import);
    let handed_on = imports.find(|import| import.last() == Some(name) && import[..] != *path);
    let is_face = file.module.is_empty();
    handed_on.and_then(|import| defined(files, import)).or((!is_face).then_some(own))
}

#[test]
fn no_file_imports_itself_through_others() {
    let root = Path::new(ROOT);
    let mut sources =
        vec![root.join("src"), root.join("cli/src"), root.join("ground/src"), root.join("ffi/src")];
    let crates = std::fs::read_dir(root.join("crates")).unwrap();
    sources.extend(crates.map(|entry| entry.unwrap().path().join("src")));
    let (mut imports, mut circles) = (0, Vec::new());
    for src in sources {
        let files = files(&src);
        let mut left: BTreeMap<&PathBuf, BTreeSet<&PathBuf>> = BTreeMap::new();
        for (path, file) in &files {
            let used = file.imports.iter().filter(|(_, is_handed_on)| !is_handed_on);
            let targets = used.filter_map(|(import, _)| defined(&files, import));
            left.insert(path, targets.filter(|target| *target != path).collect());
        }
        imports += left.values().map(BTreeSet::len).sum::<usize>();
        // Removes files without imports, and files without an importer, until only circles are left.
        let count = |left: &BTreeMap<&PathBuf, BTreeSet<&PathBuf>>| {
            left.values().map(BTreeSet::len).sum::<usize>()
        };
        loop {
            let before = count(&left);
            let importing: BTreeSet<_> = left
                .iter()
                .filter(|(_, targets)| !targets.is_empty())
                .map(|(path, _)| *path)
                .collect();
            left.values_mut()
                .for_each(|targets| targets.retain(|target| importing.contains(target)));
            let imported: BTreeSet<_> = left.values().flatten().copied().collect();
            left.retain(|path, targets| !targets.is_empty() && imported.contains(path));
            if count(&left) == before {
                break;
            }
        }
        circles.extend(left.into_iter().map(|(path, targets)| format!("{path:?}: {targets:?}")));
    }
    assert!(circles.is_empty(), "these files import each other:\n{}", circles.join("\n"));
    assert!(imports > 1_000, "{imports} imports found");
}
