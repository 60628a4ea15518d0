//! Maps foreign files and reads the resulting dataset.

use std::fs;

use hovernav_dataset::Dataset;
use hovernav_formats::{Options, Proposal, open};

/// The report of `init` on `files`, the mapping that it writes, and the resulting dataset.
pub fn mapped(files: &[(&str, String)]) -> (String, String, Dataset) {
    let place = tempfile::tempdir().unwrap();
    let paths = files.iter().map(|(name, text)| {
        let path = place.path().join(name);
        fs::write(&path, text).unwrap();
        path
    });
    let proposal = Proposal::of(&paths.collect::<Vec<_>>()).unwrap();
    let out = place.path().join("mapped");
    proposal.write(&out, false).unwrap();
    let mapping = fs::read_to_string(out.join("mapping.toml")).unwrap();
    (proposal.to_string(), mapping, open(&out, &Options::default()).unwrap().dataset)
}
