//! The ground station with its links, its server and its page.

#[path = "../common/mod.rs"]
mod common;

mod aboard;
mod browser;
mod cut;
#[cfg(target_os = "linux")]
mod export;
mod hostile;
mod keeping;
mod link;
#[cfg(target_os = "linux")]
mod memory;
mod readiness;
mod server;
mod tiles;
mod vehicles;
