//! Errors of any trajectory against any reference.

use std::path::Path;

use hovernav::earth::Geodetic;
use hovernav::time::Time;
use hovernav_dataset::{Alignment, Dataset, LocalAxes, LogError, Reference, Trajectory};
use hovernav_score::{AxisScore, Score, score};
use serde_json::{Map, Value, json};

/// Choices of a comparison.
#[derive(Clone, Copy, Debug)]
pub struct Scoring {
    /// Whether to rotate the trajectory about the vertical and translate it, by least squares.
    pub align: bool,
    /// Origin of trajectories in local metres. Default: the origin that a file states.
    pub origin: Option<Geodetic>,
    /// Axes of a reference in local metres.
    pub axes: LocalAxes,
    /// Duration, s, after the first solution during which errors are ignored. Default: 0, or `[reference] skip_s` of a
    /// dataset directory, from its first inertial sample.
    pub skip_s: Option<f64>,
}

/// Errors of a trajectory.
#[derive(Clone, Debug)]
pub struct Scored {
    /// The errors of each axis.
    pub score: Score,
    /// The alignment, if requested.
    pub aligned: Option<Alignment>,
    /// Defects of both files, one sentence each.
    pub warnings: Vec<String>,
}

/// Origin of local coordinates if both trajectories are local and have no origin. Any origin gives the same errors.
const NOWHERE: Geodetic = Geodetic { latitude_rad: 0.0, longitude_rad: 0.0, height_m: 0.0 };

impl Scoring {
    /// Scores `solution`, named `name` in messages, against the reference at `path`: a `reference.csv`, a directory
    /// with one, or a trajectory as of [`open_trajectory`].
    ///
    /// # Errors
    /// [`LogError`] if the reference cannot be read, has no time in common with the solution, or only one of both is in
    /// local metres.
    pub fn against(
        &self,
        solution: Trajectory,
        name: &Path,
        path: &Path,
    ) -> Result<Scored, LogError> {
        self.compare(solution, name, Against::open(path, self.axes)?, path)
    }

    /// Scores `solution` against the trajectory `reference`, named `name` and `path` in messages.
    ///
    /// # Errors
    /// As [`against`](Self::against).
    pub fn against_trajectory(
        &self,
        solution: Trajectory,
        name: &Path,
        reference: Trajectory,
        path: &Path,
    ) -> Result<Scored, LogError> {
        self.compare(solution, name, Against::Trajectory(reference), path)
    }

    fn compare(
        &self,
        mut solution: Trajectory,
        name: &Path,
        mut reference: Against,
        path: &Path,
    ) -> Result<Scored, LogError> {
        let rejected = |reason: String| LogError::Unusable { path: name.to_path_buf(), reason };
        let no_overlap = || {
            rejected(format!(
                "found no time in common with {}. Do they use the same clock?",
                path.display()
            ))
        };
        let mut aligned = None;
        if self.align {
            reference.place(&NOWHERE);
        } else if let Some(origin) = &self.origin {
            solution.place(origin);
            reference.place(origin);
        } else if solution.is_placed() && reference.is_placed() {
            solution.place_as_named();
            if let Against::Trajectory(trajectory) = &mut reference {
                trajectory.place_as_named();
            }
        } else {
            let is_local = match &reference {
                Against::Trajectory(trajectory) => trajectory.is_local(),
                Against::Dataset(..) => false,
            };
            if solution.is_local() != is_local {
                let found = if is_local {
                    "geographic positions"
                } else {
                    "local metres without an origin"
                };
                return Err(rejected(format!(
                    "found {found}, unlike the reference: expected --align, or --origin LAT,LON,HEIGHT"
                )));
            }
            solution.place(&NOWHERE);
            reference.place(&NOWHERE);
        }
        let (mut reference, mut begin) = match reference {
            Against::Dataset(reference, begin) => (reference, begin),
            Against::Trajectory(trajectory) => (Reference::of_trajectory(&trajectory), None),
        };
        if self.align {
            aligned = Some(solution.align(&reference).ok_or_else(|| {
                rejected(format!(
                    "found fewer than two times in common with {}, expected at least two to align. Do they use the \
                     same clock?",
                    path.display()
                ))
            })?);
        }
        if let Some(skip_s) = self.skip_s {
            (reference.skip_s, begin) = (skip_s, None);
        }
        let Some(first) = solution.solutions.first() else { return Err(no_overlap()) };
        let score = score(&solution.solutions, &reference, begin.unwrap_or(first.time));
        if score.axes.is_empty() {
            return Err(no_overlap());
        }
        let warnings = [solution.warnings, reference.warnings].concat();
        Ok(Scored { score, aligned, warnings })
    }
}

impl Scored {
    /// The errors as one JSON object; `solution` and `reference` are the names of the two trajectories.
    #[must_use]
    pub fn to_json(&self, solution: &Path, reference: &Path) -> Value {
        let axes = &self.score.axes;
        let error: Map<String, Value> =
            axes.iter().map(|axis| (axis.axis.name().into(), json!(axis.statistics))).collect();
        let of_axes = |pick: fn(&AxisScore) -> Option<f64>| -> Map<String, Value> {
            let known = axes.iter().filter_map(|axis| Some((axis, pick(axis)?)));
            known.map(|(axis, value)| (axis.axis.name().into(), json!(value))).collect()
        };
        json!({
            "tool": "hovernav",
            "version": env!("CARGO_PKG_VERSION"),
            "input": solution.display().to_string(),
            "reference": reference.display().to_string(),
            "samples": axes.iter().map(|axis| axis.samples).max(),
            "from_s": self.score.from.seconds(),
            "heading_known_s": self.score.heading_known.map(|time| time.seconds()),
            "aligned": self.aligned.map(|aligned| json!({
                "yaw_deg": aligned.yaw_rad.to_degrees(),
                "moments": aligned.moments,
                "rms_m": aligned.rms_m,
            })),
            "error": error,
            "within_3_sigma": of_axes(|axis| axis.within_3_sigma),
            "error_over_sigma": of_axes(|axis| axis.error_over_sigma),
            "warnings": self.warnings,
        })
    }
}

/// Reads the trajectory in a file, in the `solution.csv` of a directory, or in the files that a mapping names.
///
/// # Errors
/// [`LogError`] if the trajectory is missing or cannot be read.
pub fn open_trajectory(path: &Path, axes: LocalAxes) -> Result<Trajectory, LogError> {
    let rejected =
        |reason: &str| Err(LogError::Unusable { path: path.to_path_buf(), reason: reason.into() });
    if !path.exists() {
        return rejected(
            "no such file or directory, expected a trajectory: solution.csv, TUM, EuRoC, or a directory with a \
             solution.csv",
        );
    }
    if !path.is_dir() {
        return Trajectory::open(path, axes);
    }
    let file = path.join("solution.csv");
    if file.exists() {
        return Trajectory::open(&file, axes);
    }
    if path.join("mapping.toml").exists() {
        return mapped_trajectory(path);
    }
    rejected(
        "found neither solution.csv nor mapping.toml, expected a directory written by estimate or by init",
    )
}

/// The trajectory in the files that the mapping in directory `path` names.
#[cfg(feature = "text")]
fn mapped_trajectory(path: &Path) -> Result<Trajectory, LogError> {
    crate::text::trajectory(path)
}

#[cfg(not(feature = "text"))]
fn mapped_trajectory(path: &Path) -> Result<Trajectory, LogError> {
    let format = "text in columns".to_owned();
    Err(LogError::MissingFeature { path: path.to_path_buf(), format, feature: "text" })
}

/// The reference side of a comparison.
#[allow(clippy::large_enum_variant, reason = "a run has only one")]
enum Against {
    /// A reference, and the start of its dataset, from which `skip_s` is counted.
    Dataset(Reference, Option<Time>),
    Trajectory(Trajectory),
}

impl Against {
    fn open(path: &Path, axes: LocalAxes) -> Result<Self, LogError> {
        let file = path.join("reference.csv");
        if !path.is_dir() || !file.exists() {
            return open_trajectory(path, axes).map(Self::Trajectory);
        }
        // The lever arms in dataset.toml identify the point whose motion the reference describes.
        let (manifest, _) = Dataset::manifest_of(path)?;
        let reference = Reference::open(path, &manifest)?;
        let reference = reference
            .ok_or_else(|| LogError::Unusable { path: file, reason: "not there".to_owned() })?;
        Ok(Self::Dataset(reference, Dataset::first_sample_of(path)?))
    }

    fn is_placed(&self) -> bool {
        match self {
            Self::Dataset(..) => true,
            Self::Trajectory(trajectory) => trajectory.is_placed(),
        }
    }

    /// Converts a trajectory in local metres to positions on Earth, at `origin`.
    fn place(&mut self, origin: &Geodetic) {
        if let Self::Trajectory(trajectory) = self {
            trajectory.place(origin);
        }
    }
}
