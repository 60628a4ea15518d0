//! Dataset directories: read as they were meant, damaged, judged, scored.

mod damage;
mod manifests;
mod reading;
mod samples_in_file;
mod scoring;
mod setup_check;
