//! What the flight record promises.
#![cfg(feature = "record")]

mod damage;
mod disk;
#[allow(dead_code, reason = "shared with the tests of receivers")]
#[path = "../gps_streams/encode.rs"]
mod encode;
mod flight;
mod killed;
mod replay;
