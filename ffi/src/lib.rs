//! The flight core behind a C interface: `include/hovernav.h` is made from this crate.
//!
//! One object, [`Hovernav`], in memory that the caller gives; nothing is allocated, no clock is read
//! and no panic can be reached. Each function checks its pointers and values and answers with a
//! [`Status`]. The crate translates and computes nothing: a log replayed through it gives the same
//! bits as the Rust core.
//!
//! The rules for every function, stated once: a pointer that is not null must point to what its type
//! says, for the length of the call; the object is used by one thread at a time. What a pointer alone can
//! tell is checked: null, alignment, whether an object was created there.
#![cfg_attr(target_os = "none", no_std)]
// What flies cannot panic.
#![deny(
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::multiple_unsafe_ops_per_block,
    clippy::panic,
    clippy::unwrap_used
)]
#![allow(
    clippy::result_large_err,
    reason = "a fault carries its texts, for there is no heap to put them on"
)]

mod access;
mod output;
mod queue;

// The order of the header, blank lines between them to keep it.
mod status;

mod object;

mod creation;

pub mod settings;

mod measurements;

mod aids;

mod solution;

mod health;

mod notices;

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
pub use solution::*;
pub use status::*;

/// cbindgen:ignore
#[cfg(all(feature = "bare-metal", target_os = "none"))]
mod bare_metal {
    use core::panic::PanicInfo;

    unsafe extern "C" {
        /// Defined nowhere.
        fn hovernav_a_panic_is_reachable() -> !;
    }

    #[panic_handler]
    fn panic(_: &PanicInfo<'_>) -> ! {
        // SAFETY: never called, for what calls it does not link.
        unsafe { hovernav_a_panic_is_reachable() }
    }
}
