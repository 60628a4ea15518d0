//! Satellite navigation receivers: bytes in, one fix an epoch out.
//!
//! ```text
//! bytes + arrival ──> tsip │ nmea │ ubx ──> ReceiverFix ──> quality ──> Fix ──> filter
//!                     frames, messages,     what the         what it    on the inertial
//!                     epochs                receiver said    fails      unit's clock
//! ```
//!
//! Nothing here opens a port, asks for the time or allocates. A decoder is fed whatever the line
//! gave, in any pieces, with the moment it arrived; it keeps a buffer of one message and the epoch
//! that is being put together. No input makes it panic or forget what was already good, and what it
//! leaves out it counts ([`Counts`]).
//!
//! A receiver names its epochs on its own clock ([`ReceiverTime`]), and the fix reaches us later by
//! the time it took to compute and to send. How that maps to the inertial unit's clock is the
//! caller's to know: [`ReceiverFix::at`] takes the moment, usually the arrival less the latency.
#![cfg_attr(
    not(test),
    deny(
        clippy::indexing_slicing,
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable
    )
)]

mod counts;
mod cycle;
mod fix;
pub mod nmea;
mod receiver_fix;
mod receiver_time;
pub mod tsip;
pub mod ubx;

pub use counts::Counts;
pub use fix::Fix;
pub use receiver_fix::{Correction, DilutionOfPrecision, Dimension, ReceiverFix};
pub use receiver_time::{ReceiverTime, WEEK_FLOOR, unroll_week};
