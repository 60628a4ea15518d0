//! Replacement of `--export` in a build without the feature `export`.

use std::path::Path;
use std::str::FromStr;

use hovernav::ekf::Solution;
use hovernav_dataset::Manifest;

/// Export format: none exists in this build.
#[derive(Clone, Copy)]
pub enum ExportArgument {}

impl FromStr for ExportArgument {
    type Err = &'static str;

    fn from_str(_: &str) -> Result<Self, Self::Err> {
        Err("this build has no export formats, because it lacks the feature `export`")
    }
}

pub fn is_piped(_: &[ExportArgument]) -> bool {
    false
}

pub fn not_asked(_: &[ExportArgument]) -> Vec<&'static str> {
    crate::output::EXPORTED.into()
}

pub fn check(_: &[ExportArgument], _logs: usize) -> anyhow::Result<()> {
    Ok(())
}

/// Exported files: none exist in this build.
pub struct Exports;

impl Exports {
    pub fn begin(_: &[ExportArgument], _: &Manifest, _out: &Path) -> anyhow::Result<Self> {
        Ok(Self)
    }

    pub fn push(&mut self, _: &Solution) -> anyhow::Result<()> {
        Ok(())
    }

    pub fn finish(self) -> anyhow::Result<()> {
        Ok(())
    }
}
