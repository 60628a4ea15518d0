//! The ground station with its links, its server and its page.

#[path = "../common/mod.rs"]
mod common;

mod aboard;
mod browser;
mod cut;
mod hostile;
mod keeping;
mod link;
mod readiness;
mod server;
mod tiles;
mod vehicles;
