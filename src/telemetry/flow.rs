//! Flow control by the ground: `#` starts frames, `$` pauses them.

/// State of the flow control: whether frames are sent. No frame is sent until the ground requests frames.
///
/// ```
/// use hovernav::telemetry::Flow;
/// let mut flow = Flow::default();
/// flow.receive(b"#");
/// assert!(flow.is_on());
/// flow.receive(b"$");
/// assert!(!flow.is_on());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flow {
    on: bool,
    ignored: u32,
}

impl Flow {
    /// Processes bytes from the ground. The last command among them takes effect; other bytes are counted and ignored.
    pub fn receive(&mut self, bytes: &[u8]) {
        for byte in bytes {
            match byte {
                b'#' => self.on = true,
                b'$' => self.on = false,
                _ => self.ignored = self.ignored.saturating_add(1),
            }
        }
    }

    /// Whether to send frames.
    #[must_use]
    pub const fn is_on(&self) -> bool {
        self.on
    }

    /// Number of bytes that were not a command: noise on the line, or another protocol.
    #[must_use]
    pub const fn ignored(&self) -> u32 {
        self.ignored
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_flows_until_asked_and_the_last_word_counts() {
        let mut flow = Flow::default();
        assert!(!flow.is_on());
        for (bytes, on) in [(&b"\r\n"[..], false), (b"#", true), (b"", true), (b"x", true)] {
            flow.receive(bytes);
            assert_eq!(flow.is_on(), on);
        }
        flow.receive(b"#$");
        assert!(!flow.is_on());
        flow.receive(b"$#");
        assert!(flow.is_on());
        assert_eq!(flow.ignored(), 3);
    }
}
