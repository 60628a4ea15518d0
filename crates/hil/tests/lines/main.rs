//! Flights over the lines of a flight computer, with emulated time except where the machine is measured.

mod campaign;
mod common;
mod damaged;
mod excitation;
mod failsafes;
mod forward;
mod full_record;
mod hover;
mod repeated;
mod scenes;
mod turnaround;
