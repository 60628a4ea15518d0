//! Bounded reading of regular files.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

/// Reads the regular file `path`, at most `most` bytes.
///
/// # Errors
/// Errors of the file system. A pipe or a device, which could block forever. A file above `most` bytes, even if it
/// grows only while it is read.
pub fn read_bytes(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let file = open_file(path, most)?;
    let mut bytes = Vec::with_capacity(file.metadata()?.len() as usize);
    file.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most { Err(too_large(bytes.len() as u64, most)) } else { Ok(bytes) }
}

/// Opens the regular file `path` of at most `most` bytes for reading.
///
/// # Errors
/// Errors of the file system; a pipe or a device; a file above `most` bytes.
pub fn open_file(path: &Path, most: u64) -> io::Result<File> {
    let metadata = std::fs::metadata(path)?;
    if !metadata.is_file() {
        let found = if metadata.is_dir() { "a directory" } else { "a pipe or a device" };
        let reason = format!("found {found}, expected a file");
        return Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
    }
    if metadata.len() > most {
        return Err(too_large(metadata.len(), most));
    }
    File::open(path)
}

fn too_large(found: u64, most: u64) -> io::Error {
    let reason = format!("found {found} bytes, expected at most {most}");
    io::Error::new(io::ErrorKind::InvalidData, reason)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_file_or_too_large_is_refused() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("file");
        std::fs::write(&path, [7; 10]).unwrap();
        assert_eq!(read_bytes(&path, 10).unwrap(), [7; 10]);
        let said = |path: &Path| read_bytes(path, 9).unwrap_err().to_string();
        assert_eq!(said(&path), "found 10 bytes, expected at most 9");
        assert_eq!(said(place.path()), "found a directory, expected a file");
        if Path::new("/dev/zero").exists() {
            assert_eq!(said(Path::new("/dev/zero")), "found a pipe or a device, expected a file");
        }
    }
}
