//! Flights over the lines of a flight computer, by emulated time but for those that measure a machine.

mod campaign;
mod common;
mod excitation;
mod failsafes;
mod full_record;
mod repeated;
mod scenes;
mod turnaround;
