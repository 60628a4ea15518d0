//! The bytes of a capture, piece by piece.

use crate::window::{Input, Window};
use hovernav_dataset::LogError;

/// Number of bytes passed to a decoder at a time.
pub(super) const CHUNK: usize = 4096;

/// The file after its leading comment lines.
pub(super) fn begin(input: Input<'_>) -> Result<Window<'_>, LogError> {
    let mut window = input.window()?;
    loop {
        let bytes = window.peek(CHUNK).map_err(LogError::io(input.path))?;
        if bytes.first() != Some(&b'#') {
            return Ok(window);
        }
        let line = bytes.iter().position(|byte| *byte == b'\n');
        let count = line.map_or(bytes.len(), |end| end + 1);
        window.consume(count);
    }
}

/// Passes all bytes of a capture to `take`, in pieces with their byte offsets.
pub(super) fn for_each_piece(
    input: Input<'_>,
    mut take: impl FnMut(&[u8], u64),
) -> Result<(), LogError> {
    let mut window = begin(input)?;
    loop {
        let offset = window.offset();
        let bytes = window.peek(CHUNK).map_err(LogError::io(input.path))?;
        if bytes.is_empty() {
            return Ok(());
        }
        let count = bytes.len().min(CHUNK);
        take(&bytes[..count], offset);
        window.consume(count);
    }
}
