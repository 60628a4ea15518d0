//! The flight core behind a C interface: `include/hovernav.h` is made from this crate.
//!
//! The interface has one type of object, [`Hovernav`], in memory of the caller. Nothing is allocated, no clock is read
//! and no panic is reachable. Each function checks its pointers and values and returns a [`Status`]. The crate only
//! translates: a log replayed through it gives the same bits as the Rust core.
//!
//! Rules for every function: a pointer that is not null must point to a value of its type for the length of the call.
//! Only one thread at a time may use an object. Null pointers, misaligned pointers and memory without an object are
//! detected.
#![cfg_attr(target_os = "none", no_std)]
// Flight code must not panic.
#![deny(
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::multiple_unsafe_ops_per_block,
    clippy::panic,
    clippy::unwrap_used
)]
#![allow(clippy::result_large_err, reason = "a fault contains its texts, because there is no heap")]

#[cfg(not(any(feature = "tsip", feature = "nmea", feature = "ubx")))]
compile_error!("select at least one protocol of GPS receivers: the feature tsip, nmea or ubx");

mod access;
mod output;
mod queue;

// The modules are in the order of the header. The blank lines stop rustfmt from sorting them.
mod status;

mod object;

mod creation;

pub mod settings;

mod measurements;

mod aids;

mod solution;

mod health;

mod setup;

mod notices;

mod own;

mod autopilot;

mod lines;

pub use aids::*;
pub use autopilot::*;
pub use creation::*;
pub use health::*;
pub use lines::*;
pub use measurements::*;
pub use notices::*;
pub use object::*;
pub use own::*;
pub use setup::*;
pub use solution::*;
pub use status::*;

/// cbindgen:ignore
#[cfg(all(feature = "bare-metal", target_os = "none"))]
mod bare_metal {
    use core::panic::PanicInfo;

    unsafe extern "C" {
        /// Declared here and defined nowhere, so that a program with a reachable panic does not link.
        fn hovernav_a_panic_is_reachable() -> !;
    }

    #[panic_handler]
    fn panic(_: &PanicInfo<'_>) -> ! {
        // SAFETY: never called, because a program that calls it does not link.
        unsafe { hovernav_a_panic_is_reachable() }
    }
}
