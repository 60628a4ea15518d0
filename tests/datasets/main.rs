//! Dataset directories: reading, damage, findings, scoring.

mod aids_told;
mod damage;
mod ignored;
mod manifests;
mod reading;
mod samples_in_file;
mod scoring;
mod setup_check;
mod setup_garbage;
mod setup_velocity;
