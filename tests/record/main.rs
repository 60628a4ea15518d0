//! Guarantees of the flight record.

mod damage;
mod disk;
mod flight;
mod killed;
mod replay;
