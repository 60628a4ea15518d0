//! Files that get their name only when they are complete.

use std::fs::{File, OpenOptions, Permissions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::file::open_file;

/// A file being written. Its name ends in `.part` until [`finish`](Self::finish) gives it its final name. A file that
/// is dropped before it is finished, for example because the disk is full, is removed. An earlier file with the final
/// name stays until the new file is finished.
///
/// A link with the final name is replaced; its target stays. A device or a pipe cannot be replaced, so it is written
/// directly.
#[derive(Debug)]
pub struct WholeFile {
    file: File,
    /// Temporary and final name; `None` for a device, and after completion.
    names: Option<[PathBuf; 2]>,
}

impl WholeFile {
    /// Begins the file `path`.
    ///
    /// Errors of the file system, also if an existing file of this name is not writable. A pipe that nothing reads, which
    /// could block forever.
    pub fn create(path: &Path) -> io::Result<Self> {
        let mut permissions: Option<Permissions> = None;
        match std::fs::metadata(path) {
            Ok(found) if found.is_file() => {
                if !path.is_symlink() {
                    // Opening the file for writing fails in the same cases as overwriting it.
                    OpenOptions::new().write(true).open(path)?;
                    permissions = Some(found.permissions());
                }
            }
            Ok(found) => {
                ensure_reader(path, &found)?;
                return Ok(Self { file: File::create(path)?, names: None });
            }
            Err(_) => {}
        }
        let own = path.to_path_buf();
        let mut name = own.file_name().unwrap_or_default().to_owned();
        name.push(".part");
        let part = own.with_file_name(name);
        let file = fresh_file(&part)?;
        let whole = Self { file, names: Some([part, own]) };
        if let Some(permissions) = permissions {
            whole.file.set_permissions(permissions)?;
        }
        Ok(whole)
    }

    /// Begins the file `path`, which must not exist.
    ///
    /// # Errors
    /// Errors of the file system; [`AlreadyExists`](io::ErrorKind::AlreadyExists).
    pub fn create_new(path: &Path) -> io::Result<Self> {
        if path.symlink_metadata().is_ok() {
            return Err(io::ErrorKind::AlreadyExists.into());
        }
        Self::create(path)
    }

    /// A second handle of the file, for a writer that is dropped before [`finish`](Self::finish).
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn handle(&self) -> io::Result<File> {
        self.file.try_clone()
    }

    /// Gives the file its name, after all buffers are written to the disk.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn finish(mut self) -> io::Result<()> {
        if let Some([part, own]) = &self.names {
            std::fs::rename(part, own)?;
            self.names = None;
        }
        Ok(())
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Drop for WholeFile {
    fn drop(&mut self) {
        if let Some([part, _]) = &self.names {
            // A failure here cannot be handled.
            let _ = std::fs::remove_file(part);
        }
    }
}

/// Refuses a pipe that nothing reads: to open it would wait for a reader.
#[cfg(any(target_os = "linux", target_os = "macos"))]
fn ensure_reader(path: &Path, found: &std::fs::Metadata) -> io::Result<()> {
    use std::os::unix::fs::{FileTypeExt as _, OpenOptionsExt as _};
    /// `O_NONBLOCK`: to open a pipe that nothing reads is then an error.
    const NONBLOCK: i32 = if cfg!(target_os = "linux") { 0o4000 } else { 4 };
    let is_pipe = found.file_type().is_fifo();
    if is_pipe && OpenOptions::new().write(true).custom_flags(NONBLOCK).open(path).is_err() {
        let reason = "found a pipe that nothing reads, expected a file";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
    }
    Ok(())
}

#[cfg(not(any(target_os = "linux", target_os = "macos")))]
fn ensure_reader(_: &Path, _: &std::fs::Metadata) -> io::Result<()> {
    Ok(())
}

/// Creates the file `path` for writing. Anything with this name is removed first: a link is not followed, and a pipe is
/// not opened.
///
/// # Errors
/// Errors of the file system, for example if `path` is a directory.
pub fn fresh_file(path: &Path) -> io::Result<File> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    OpenOptions::new().write(true).create_new(true).open(path)
}

/// Writes `bytes` to the file `path`, completely or not at all: see [`WholeFile`].
///
/// # Errors
/// Errors of the file system.
pub fn write_whole(path: &Path, bytes: impl AsRef<[u8]>) -> io::Result<()> {
    let mut file = WholeFile::create(path)?;
    file.write_all(bytes.as_ref())?;
    file.finish()
}

/// Copies the regular file `from` to `path`, completely or not at all: see [`WholeFile`].
///
/// # Errors
/// Errors of the file system; a pipe or a device as `from`.
pub fn copy_whole(from: &Path, path: &Path) -> io::Result<()> {
    let mut from = open_file(from, u64::MAX)?;
    let mut file = WholeFile::create(path)?;
    io::copy(&mut from, &mut file)?;
    file.finish()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// The names in a directory.
    fn names(directory: &Path) -> Vec<String> {
        let entries = fs::read_dir(directory).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_appears_under_its_name_when_it_is_whole() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a.csv");
        let mut file = WholeFile::create(&path).unwrap();
        file.write_all(b"half").unwrap();
        assert_eq!(names(place.path()), ["a.csv.part"]);
        drop(file);
        assert!(names(place.path()).is_empty());

        write_whole(&path, "whole").unwrap();
        let mut file = WholeFile::create(&path).unwrap();
        file.write_all(b"half").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        drop(file);
        assert_eq!((fs::read(&path).unwrap(), names(place.path()).len()), (b"whole".to_vec(), 1));

        let mut file = WholeFile::create(&path).unwrap();
        file.handle().unwrap().write_all(b"a new ").unwrap();
        file.write_all(b"one").unwrap();
        file.finish().unwrap();
        assert_eq!(
            (fs::read(&path).unwrap(), names(place.path()).len()),
            (b"a new one".to_vec(), 1)
        );
    }

    #[test]
    fn what_must_not_be_there_is_refused() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a.mcap");
        WholeFile::create_new(&path).unwrap().finish().unwrap();
        let error = WholeFile::create_new(&path).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::AlreadyExists);
        assert!(WholeFile::create(place.path()).is_err(), "a directory");
        assert!(WholeFile::create(&place.path().join("nowhere/a.csv")).is_err());
        assert_eq!(names(place.path()), ["a.mcap"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_replaced_and_permissions_stay() {
        use std::os::unix::fs::{PermissionsExt as _, symlink};
        let place = tempfile::tempdir().unwrap();
        let (path, link) = (place.path().join("a.csv"), place.path().join("link.csv"));
        fs::write(&path, "old").unwrap();
        fs::set_permissions(&path, Permissions::from_mode(0o640)).unwrap();
        symlink("a.csv", &link).unwrap();
        write_whole(&link, "new").unwrap();
        assert_eq!((fs::read(&link).unwrap(), link.is_symlink()), (b"new".to_vec(), false));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        write_whole(&path, "newer").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"newer");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_with_the_temporary_name_is_not_followed() {
        let place = tempfile::tempdir().unwrap();
        let (path, victim) = (place.path().join("a.csv"), place.path().join("victim"));
        fs::write(&victim, "precious").unwrap();
        std::os::unix::fs::symlink(&victim, place.path().join("a.csv.part")).unwrap();
        write_whole(&path, "new").unwrap();
        assert_eq!(fs::read(&victim).unwrap(), b"precious");
        assert_eq!((fs::read(&path).unwrap(), path.is_symlink()), (b"new".to_vec(), false));
        assert_eq!(names(place.path()), ["a.csv", "victim"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_device_is_written_to_and_reports_that_it_is_full() {
        write_whole(Path::new("/dev/null"), "gone").unwrap();
        let error = write_whole(Path::new("/dev/full"), "too much").unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
    }
}
