#![doc = include_str!("../README.md")]

pub mod channel;
mod clock;
mod csv;
pub mod decode;
pub mod evaluate;
mod flight_record;
pub mod folder;
pub mod frames;
pub mod lamps;
pub mod link;
mod mavlink;
pub mod player;
pub mod record;
pub mod series;
pub mod server;
pub mod station;
pub mod store;
pub mod test_points;
pub mod tiles;
