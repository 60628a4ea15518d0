//! Exports are read by the programs for which they are made: schemas of KML and GPX, evo, MCAP's reader.
//!
//! These come from the Python package index. If they are not available, the test reports that and is skipped.

use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;
use std::process::Command;

use hovernav_dataset::Dataset;
use hovernav_export::{Export, ExportFormat, LAYOUT};
use hovernav_replay::estimate_each;
use hovernav_testing::python;

const HERE: &str = env!("CARGO_MANIFEST_DIR");
const PACKAGES: [&str; 6] = ["evo", "fastkml", "gpx", "jsonschema", "lxml", "mcap"];

#[test]
fn the_programs_that_exports_are_for_read_them() {
    let Some(python) = python(&PACKAGES) else { return };
    let mut dataset = Dataset::open(&Path::new(HERE).join("../../datasets/heli-hover")).unwrap();
    let config = dataset.settings().unwrap();
    let place = tempfile::tempdir().unwrap();
    let formats = ExportFormat::ALL.into_iter().filter(|format| *format != ExportFormat::Parquet);
    let mut exports: Vec<Export<'_>> = formats
        .map(|format| {
            let file = File::create(place.path().join(format.file_name())).unwrap();
            Export::new(format, "A <flight> & more", 0, BufWriter::new(file)).unwrap()
        })
        .collect();
    let each = |solution: &_| exports.iter_mut().try_for_each(|export| export.push(solution));
    estimate_each(&dataset, &config, hovernav_replay::Keep::Thinned, |_| {}, each).unwrap();
    exports.into_iter().for_each(|export| export.finish().unwrap());
    fs::write(place.path().join("solution.foxglove-layout.json"), LAYOUT).unwrap();
    let script = Path::new(HERE).join("tests/programs.py");
    let output = Command::new(python).arg(script).arg(place.path()).output().unwrap();
    println!("{}", String::from_utf8_lossy(&output.stdout));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
