//! What the flight record promises.

mod damage;
mod disk;
mod flight;
mod killed;
mod replay;
