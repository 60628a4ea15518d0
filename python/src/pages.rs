//! Report pages as files, and inside a notebook.

use std::path::Path;

use hovernav_dataset::LogError;
use hovernav_pages::{Page, PageError};

use crate::error::Result;

/// Height of a page inside a notebook, px.
const FRAME_PX: u32 = 640;

/// Writes `page` to the file at `path`.
pub fn write(page: &Page<'_>, path: &Path) -> Result<()> {
    let failed = |PageError { path, source }| LogError::Io { path, source };
    Ok(page.write(path).map_err(failed)?)
}

/// The report `page` in a frame, as HTML.
pub fn framed(page: &Page<'_>) -> Result<String> {
    Ok(page.framed(FRAME_PX).map_err(LogError::io(Path::new("page")))?)
}
