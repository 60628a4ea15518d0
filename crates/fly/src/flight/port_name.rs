//! What a port is called: whose it is, its key in `fly.toml` and its path.

use std::fmt;
use std::path::Path;

use crate::serial::{PortEvent, WriteError};

/// A port as a message names it.
pub struct PortName {
    whose: &'static str,
    key: &'static str,
    path: String,
}

impl PortName {
    /// The port at `path`, which stands at `key` of `fly.toml`.
    pub fn new(whose: &'static str, key: &'static str, path: &Path) -> Self {
        Self { whose, key, path: path.display().to_string() }
    }

    /// A change of it in words. The path stands last: of a text that is too long the end is lost.
    pub fn changed(&self, event: &PortEvent) -> impl fmt::Display {
        let Self { whose, key, path } = self;
        format!("{whose}: port {event} ({key} = \"{path}\")")
    }

    /// What it did not take, in words.
    pub fn not_written(&self, error: &WriteError) -> impl fmt::Display {
        let Self { whose, key, path } = self;
        format!("{whose}: {error} ({key} = \"{path}\")")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::serial::PortFault;

    #[test]
    fn every_error_of_a_port_names_its_key_and_path() {
        let name = PortName::new("inertial unit", "[dmu] port", Path::new("/dev/ttyS7"));
        let missing = PortEvent::CannotOpen(PortFault::Missing);
        assert_eq!(
            name.changed(&missing).to_string(),
            "inertial unit: port cannot be opened: there is no such device ([dmu] port = \"/dev/ttyS7\")"
        );
        let closed = name.not_written(&WriteError::Closed).to_string();
        assert!(closed.contains("([dmu] port = \"/dev/ttyS7\")"), "{closed}");
    }
}
