//! Reasons why a flight cannot be played.

use std::io;
use std::path::PathBuf;

/// Reasons why a flight cannot be played.
#[derive(Debug, thiserror::Error)]
pub enum PlayError {
    /// The path exists.
    #[error("{}: exists already, expected a free path for a link to a terminal", path.display())]
    Occupied {
        /// The path.
        path: PathBuf,
    },
    /// The link cannot be created.
    #[error("{}: {source}", path.display())]
    Link {
        /// The path.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// A pseudo-terminal cannot be created.
    #[error("{}: cannot create a pseudo-terminal: {reason}", path.display())]
    NoTerminal {
        /// Path of the link to it.
        path: PathBuf,
        /// Error of the operating system.
        reason: String,
    },
    /// The pseudo-terminal failed.
    #[error("{}: the pseudo-terminal failed: {source}", path.display())]
    Terminal {
        /// Path of the link to it.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// A thread cannot be started.
    #[error("cannot start a thread: {0}")]
    NoThread(io::Error),
    /// No device has data to send.
    #[error("nothing to play: no device has data to send")]
    Nothing,
}
