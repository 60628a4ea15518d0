//! Flights over the lines of a flight computer, in real time.

mod campaign;
mod common;
mod excitation;
mod failsafes;
mod scenes;
mod turnaround;
