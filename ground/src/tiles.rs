//! A directory of map tiles, `z/x/y.png`, in the Web Mercator projection.
//!
//! Source: OpenStreetMap wiki, *Slippy map tilenames*.

use std::io;
use std::path::{Path, PathBuf};

use hovernav_toml::read_bytes;

/// Largest zoom level.
const DEEPEST: u8 = 22;
/// Largest tile, bytes.
const LARGEST: u64 = 1 << 20;
/// Extensions of tiles.
const EXTENSIONS: [&str; 4] = ["png", "jpg", "jpeg", "webp"];

/// A directory of map tiles.
#[derive(Clone, Debug)]
pub struct Tiles {
    root: PathBuf,
    zooms: Vec<u8>,
}

/// A tile: its content type and its bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tile {
    /// The content type, by the first bytes of the file.
    pub kind: &'static str,
    /// The bytes of the file.
    pub bytes: Vec<u8>,
}

impl Tiles {
    /// Opens the directory at `root`.
    ///
    /// # Errors
    /// If the directory cannot be read or has no directory of a zoom level.
    pub fn open(root: &Path) -> io::Result<Self> {
        let zooms = |entry: io::Result<std::fs::DirEntry>| {
            let name = entry.ok()?.file_name();
            (0..=DEEPEST).find(|zoom| name.to_str() == Some(&zoom.to_string()))
        };
        let mut zooms: Vec<u8> = std::fs::read_dir(root)?.filter_map(zooms).collect();
        zooms.sort_unstable();
        if zooms.is_empty() {
            let reason = format!(
                "found no zoom level, expected tiles as z/x/y.png or .jpg, with z from 0 to {DEEPEST}"
            );
            return Err(io::Error::new(io::ErrorKind::NotFound, reason));
        }
        Ok(Self { root: root.to_path_buf(), zooms })
    }

    /// The zoom levels, in ascending order.
    #[must_use]
    pub fn zooms(&self) -> &[u8] {
        &self.zooms
    }

    /// The tile of zoom level `z` in column `x`, from 180° west, and row `y`, from the north. `None` for numbers that
    /// are not plain decimal numbers of a possible tile, a missing tile, a link, and a file that is too large or not
    /// an image.
    #[must_use]
    pub fn read(&self, z: &str, x: &str, y: &str) -> Option<Tile> {
        let z = plain(z).and_then(|z| u8::try_from(z).ok()).filter(|z| *z <= DEEPEST)?;
        let within = |number: &u32| *number < 1 << z;
        let [x, y] = [plain(x).filter(within)?, plain(y).filter(within)?];
        // The path consists of numbers alone, so it cannot lead out of the directory. A link could.
        let level = unlinked_directory(self.root.join(z.to_string()))?;
        let column = unlinked_directory(level.join(x.to_string()))?;
        let files = EXTENSIONS.map(|extension| column.join(format!("{y}.{extension}")));
        let file = files.into_iter().find(|file| has(file, std::fs::Metadata::is_file))?;
        let bytes = read_bytes(&file, LARGEST).ok()?;
        Some(Tile { kind: kind(&bytes)?, bytes })
    }
}

/// A decimal number without sign or leading zeros.
fn plain(text: &str) -> Option<u32> {
    text.parse().ok().filter(|number: &u32| number.to_string() == text)
}

/// Whether the entry at `path` itself, and not the target of a link, has a property.
fn has(path: &Path, property: fn(&std::fs::Metadata) -> bool) -> bool {
    std::fs::symlink_metadata(path).is_ok_and(|metadata| property(&metadata))
}

fn unlinked_directory(path: PathBuf) -> Option<PathBuf> {
    has(&path, std::fs::Metadata::is_dir).then_some(path)
}

/// The content type of an image by its first bytes.
fn kind(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1A, b'\n', ..] => Some("image/png"),
        [0xFF, 0xD8, 0xFF, ..] => Some("image/jpeg"),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some("image/webp"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PNG: &[u8] = b"\x89PNG\r\n\x1a\nrest";

    fn folder() -> (tempfile::TempDir, Tiles) {
        let place = tempfile::tempdir().unwrap();
        for column in ["0/0", "3/5"] {
            std::fs::create_dir_all(place.path().join(column)).unwrap();
        }
        std::fs::write(place.path().join("0/0/0.jpg"), b"\xff\xd8\xff\xe0rest").unwrap();
        std::fs::write(place.path().join("3/5/2.png"), PNG).unwrap();
        std::fs::write(place.path().join("secret.png"), PNG).unwrap();
        let tiles = Tiles::open(place.path()).unwrap();
        (place, tiles)
    }

    #[test]
    fn a_tile_is_found_by_its_numbers_with_its_kind() {
        let (_place, tiles) = folder();
        assert_eq!(tiles.zooms(), [0, 3]);
        assert_eq!(tiles.read("0", "0", "0").unwrap().kind, "image/jpeg");
        assert_eq!(tiles.read("3", "5", "2"), Some(Tile { kind: "image/png", bytes: PNG.into() }));
        assert_eq!(tiles.read("3", "5", "3"), None);
        assert_eq!(tiles.read("4", "5", "2"), None);
    }

    #[test]
    fn what_is_no_number_of_a_tile_finds_nothing() {
        let (_place, tiles) = folder();
        for [z, x, y] in [
            ["..", "0", "0"],
            ["3", "..", "secret"],
            ["3", "5", "../../secret"],
            ["3", "5", "2.png"],
            ["3", "5", "02"],
            ["3", "+5", "2"],
            ["03", "5", "2"],
            ["3", "8", "2"],
            ["3", "5", "-1"],
            ["0", "1", "0"],
            ["23", "0", "0"],
            ["3", "5", "99999999999999999999"],
            ["3", "5", ""],
            ["3", "5", "2\0"],
            ["/", "", ""],
        ] {
            assert_eq!(tiles.read(z, x, y), None, "{z} {x} {y}");
        }
    }

    #[test]
    fn a_file_that_is_no_image_or_too_large_is_none() {
        let (place, tiles) = folder();
        std::fs::write(place.path().join("3/5/4.png"), b"<html><script>").unwrap();
        std::fs::write(place.path().join("3/5/5.png"), [PNG, &vec![0; 1 << 20]].concat()).unwrap();
        std::fs::create_dir(place.path().join("3/5/6.png")).unwrap();
        for y in ["4", "5", "6"] {
            assert_eq!(tiles.read("3", "5", y), None, "{y}");
        }
    }

    #[test]
    #[cfg(unix)]
    fn no_link_is_followed_and_no_pipe_is_opened() {
        use std::os::unix::fs::symlink;
        let (place, tiles) = folder();
        let at = |name: &str| place.path().join(name);
        symlink(at("secret.png"), at("3/5/7.png")).unwrap();
        symlink(at("3/5"), at("3/6")).unwrap();
        symlink(at("3"), at("4")).unwrap();
        for (z, x, y) in [("3", "5", "7"), ("3", "6", "2"), ("4", "5", "2")] {
            assert_eq!(tiles.read(z, x, y), None, "{z}/{x}/{y}");
        }
        let made = std::process::Command::new("mkfifo").arg(at("3/5/3.png")).status();
        if !made.is_ok_and(|status| status.success()) {
            return hovernav_testing::skip("mkfifo does not start");
        }
        assert_eq!(tiles.read("3", "5", "3"), None);
    }

    #[test]
    fn a_folder_without_tiles_is_refused_with_what_was_expected() {
        let place = tempfile::tempdir().unwrap();
        std::fs::create_dir(place.path().join("23")).unwrap();
        let message = Tiles::open(place.path()).unwrap_err().to_string();
        assert!(message.contains("expected tiles as z/x/y.png"), "{message}");
        Tiles::open(&place.path().join("absent")).unwrap_err();
    }
}
