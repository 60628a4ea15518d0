//! Imports between the modules of the interface.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The modules of the crate that each of its modules imports.
fn imports() -> BTreeMap<String, BTreeSet<String>> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut imports: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let mut folders = vec![src.clone()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let inside = path.strip_prefix(&src).unwrap().with_extension("");
            let own = inside.iter().next().unwrap().to_str().unwrap().to_owned();
            let text = std::fs::read_to_string(&path).unwrap();
            let names = text.split("crate::").skip(1).map(|rest| {
                rest.chars().take_while(|letter| letter.is_ascii_lowercase()).collect::<String>()
            });
            let others: Vec<String> =
                names.filter(|name| *name != own && !name.is_empty()).collect();
            imports.entry(own).or_default().extend(others);
        }
    }
    imports.remove("lib");
    imports
}

#[test]
fn no_modules_import_each_other_in_a_circle() {
    let mut left = imports();
    assert!(left.len() > 10, "{left:?}");
    while !left.is_empty() {
        let free: Vec<String> = left
            .iter()
            .filter(|(_, needs)| needs.iter().all(|need| !left.contains_key(need)))
            .map(|(module, _)| module.clone())
            .collect();
        assert!(!free.is_empty(), "a circle among {left:?}");
        left.retain(|module, _| !free.contains(module));
    }
}
