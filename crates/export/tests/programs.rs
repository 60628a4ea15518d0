//! What is written is read by the programs that it is for: schemas of KML and GPX, evo, MCAP's reader.
//!
//! They come from the Python package index, into a virtual environment under `target/`. Where that
//! cannot be made, the test says so and is skipped.

use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::process::Command;

use hovernav_export::{Export, ExportFormat, LAYOUT};
use hovernav_log::Dataset;

const HERE: &str = env!("CARGO_MANIFEST_DIR");

/// The interpreter of an environment with those programs.
fn python() -> Option<PathBuf> {
    let environment = Path::new(HERE).join("../../target/reading-programs");
    let python = environment.join("bin/python");
    let works = |program: &Path, arguments: &[&str]| {
        let output = Command::new(program).args(arguments).output();
        output.is_ok_and(|output| output.status.success())
    };
    let packages = ["-c", "import evo, fastkml, gpx, jsonschema, lxml, mcap"];
    let install = ["evo", "fastkml", "gpx", "jsonschema", "lxml", "mcap"];
    let install = [&["-m", "pip", "install", "--quiet"][..], &install].concat();
    let is_made = works(&python, &packages)
        || works(Path::new("python3"), &["-m", "venv", environment.to_str()?])
            && works(&python, &install)
            && works(&python, &packages);
    if !is_made {
        println!("skipped: no Python environment with evo, fastkml, gpx and mcap can be made");
    }
    is_made.then_some(python)
}

#[test]
fn the_programs_that_exports_are_for_read_them() {
    let Some(python) = python() else { return };
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
    dataset.estimate_each(&config, hovernav_log::Keep::Thinned, |_| {}, each).unwrap();
    exports.into_iter().for_each(|export| export.finish().unwrap());
    fs::write(place.path().join("solution.foxglove-layout.json"), LAYOUT).unwrap();
    let script = Path::new(HERE).join("tests/programs.py");
    let output = Command::new(python).arg(script).arg(place.path()).output().unwrap();
    println!("{}", String::from_utf8_lossy(&output.stdout));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
