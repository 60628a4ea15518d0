//! Names of ports in messages: owner, key in `fly.toml`, and path.

use std::fmt;
use std::path::Path;

use crate::serial::{PortEvent, WriteError};

/// The name of a port in messages.
pub struct PortName {
    whose: &'static str,
    key: &'static str,
    path: String,
}

impl PortName {
    /// The port at `path`, which is set by `key` in `fly.toml`.
    pub fn new(whose: &'static str, key: &'static str, path: &Path) -> Self {
        Self { whose, key, path: path.display().to_string() }
    }

    /// The message for a change. The path is last because long texts are truncated at the end.
    pub fn changed(&self, event: &PortEvent) -> impl fmt::Display {
        let Self { whose, key, path } = self;
        format!("{whose}: port {event} ({key} = \"{path}\")")
    }

    /// The message for a failed write.
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
            "inertial unit: port cannot be opened: there is no such device ([dmu] port = \
             \"/dev/ttyS7\")"
        );
        let closed = name.not_written(&WriteError::Closed).to_string();
        assert!(closed.contains("([dmu] port = \"/dev/ttyS7\")"), "{closed}");
    }
}
