//! What the flight record promises.
#![cfg(feature = "record")]

mod damage;
mod disk;
mod flight;
mod killed;
mod replay;
