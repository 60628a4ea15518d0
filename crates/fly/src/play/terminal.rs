//! A pseudo-terminal with a link to it.

use std::fs::{self, Metadata};
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::os::unix::fs::{MetadataExt as _, symlink};
use std::path::{Path, PathBuf};
use std::time::Duration;

use serialport::{SerialPort as _, TTYPort};

use super::error::PlayError;

/// Number of bytes written at once: a pseudo-terminal with room for one byte has room for all of them.
const CHUNK: usize = 256;

/// Data from the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Received {
    /// Number of bytes received.
    Bytes(usize),
    /// No data.
    Nothing,
    /// The port is not open.
    Closed,
}

/// The device's end of a pseudo-terminal, with a link to the host's end. Dropping it removes both.
#[derive(Debug)]
pub(super) struct Terminal {
    device: TTYPort,
    link: PathBuf,
    target: PathBuf,
}

impl Terminal {
    /// Creates a pseudo-terminal and a link to it at `link`.
    pub fn open(link: &Path) -> Result<Self, PlayError> {
        let fails = |source| PlayError::Link { path: link.into(), source };
        match fs::symlink_metadata(link) {
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(error) => return Err(fails(error)),
            Ok(found) if found.is_symlink() && is_stale(link, &found) => {}
            Ok(_) => return Err(PlayError::Occupied { path: link.into() }),
        }
        let no_terminal = |reason: String| PlayError::NoTerminal { path: link.into(), reason };
        let (device, host) = TTYPort::pair().map_err(|error| no_terminal(error.to_string()))?;
        let target = host.name().ok_or_else(|| no_terminal("it has no name".into()))?;
        let terminal = Self { device, link: link.into(), target: target.into() };
        // Created under another name and renamed, so the link appears atomically.
        let mut beside = link.as_os_str().to_owned();
        beside.push(format!(".{}", std::process::id()));
        symlink(&terminal.target, &beside).map_err(fails)?;
        fs::rename(&beside, link).map_err(fails)?;
        Ok(terminal)
    }

    /// Sends as many bytes as the host's port accepts at once; returns their number.
    pub fn send(&mut self, bytes: &[u8]) -> Result<usize, PlayError> {
        let mut sent = 0;
        let _ = self.device.set_timeout(Duration::ZERO);
        for chunk in bytes.chunks(CHUNK) {
            match self.device.write(chunk) {
                Ok(count) => sent += count,
                Err(error) if is_passing(&error) || is_closed(&error) => break,
                Err(error) => return Err(self.failed(error)),
            }
        }
        Ok(sent)
    }

    /// Waits up to `wait` for bytes from the host.
    pub fn receive(&mut self, buffer: &mut [u8], wait: Duration) -> Result<Received, PlayError> {
        let _ = self.device.set_timeout(wait);
        match self.device.read(buffer) {
            Ok(count @ 1..) => Ok(Received::Bytes(count)),
            Err(error) if is_passing(&error) => Ok(Received::Nothing),
            Err(error) if !is_closed(&error) => Err(self.failed(error)),
            _ => Ok(Received::Closed),
        }
    }

    fn failed(&self, source: io::Error) -> PlayError {
        PlayError::Terminal { path: self.link.clone(), source }
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        // Another link may have replaced this link.
        if fs::read_link(&self.link).is_ok_and(|target| target == self.target) {
            let _ = fs::remove_file(&self.link);
        }
    }
}

/// Whether the link is stale, left by a killed process. Its terminal is gone, or a newer terminal has the same name.
fn is_stale(link: &Path, found: &Metadata) -> bool {
    let Ok(target) = fs::metadata(link) else { return true };
    let is_terminal = fs::read_link(link).is_ok_and(|target| target.starts_with("/dev/pts"));
    // The status of a terminal changes when it is created; its link is always younger.
    let changed = |of: &Metadata| (of.ctime(), of.ctime_nsec());
    is_terminal && changed(&target) > changed(found)
}

fn is_passing(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock)
}

/// Whether the other end is closed: a hang-up, or EIO, which has no `ErrorKind` of its own.
fn is_closed(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::BrokenPipe | ErrorKind::Other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stale_link_is_replaced_and_a_live_one_is_not() {
        let place = tempfile::tempdir().unwrap();
        let link = place.path().join("dmu");
        let live = Terminal::open(&link).unwrap();
        assert!(matches!(Terminal::open(&link), Err(PlayError::Occupied { .. })));
        // A process that was killed leaves its link.
        fs::remove_file(&link).unwrap();
        symlink("/dev/pts/999999", &link).unwrap();
        drop(Terminal::open(&link).unwrap());
        // Another terminal gets the name that the link points to, after the link was made.
        let (_device, name) = loop {
            let (first, host) = TTYPort::pair().unwrap();
            let name = host.name().unwrap();
            symlink(&name, &link).unwrap();
            drop((first, host));
            std::thread::sleep(Duration::from_millis(20));
            let (device, host) = TTYPort::pair().unwrap();
            if host.name().as_ref() == Some(&name) {
                break ((device, host), name);
            }
            fs::remove_file(&link).unwrap();
        };
        drop(live);
        let ours = Terminal::open(&link).unwrap();
        assert_ne!(ours.target, Path::new(&name));
        assert_eq!(fs::read_link(&link).unwrap(), ours.target);
        drop(ours);
        // A file is never replaced.
        fs::write(&link, "mine").unwrap();
        assert!(matches!(Terminal::open(&link), Err(PlayError::Occupied { .. })));
    }
}
