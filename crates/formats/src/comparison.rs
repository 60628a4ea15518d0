//! Differences between trajectories of one flight.

use std::path::{Path, PathBuf};

use hovernav::earth::Geodetic;
use hovernav_dataset::{LocalAxes, LogError, Reference, Trajectory};
use hovernav_score::{RelativeError, Score, relative_error, score};
use serde_json::{Map, Value, json};

use crate::scoring::open_trajectory;

/// Origin for local coordinates if their position on Earth is unknown. Any origin gives the same differences.
const NOWHERE: Geodetic = Geodetic { latitude_rad: 0.0, longitude_rad: 0.0, height_m: 0.0 };

/// Time over which the motion of two trajectories is compared, s.
const RELATIVE_S: f64 = 1.0;

/// A trajectory and its name.
#[derive(Clone, Debug)]
pub struct NamedTrajectory {
    /// Name of the trajectory in sentences and tables, unique in its comparison.
    pub name: String,
    /// The source, as the user named it.
    pub source: PathBuf,
    /// The trajectory.
    pub trajectory: Trajectory,
}

impl NamedTrajectory {
    /// Reads the trajectory at `path`, as [`open_trajectory`] does. Its name is the file's name, or for a
    /// `solution.csv` the directory's name.
    ///
    /// # Errors
    /// [`LogError`] if the trajectory is missing or cannot be read.
    pub fn open(path: &Path, axes: LocalAxes) -> Result<Self, LogError> {
        let trajectory = open_trajectory(path, axes)?;
        let stem = |path: &Path| {
            path.file_stem()
                .map_or_else(|| "log".into(), |name| name.to_string_lossy().into_owned())
        };
        let full = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
        let name = match (stem(&full), full.parent()) {
            (name, Some(directory)) if name == "solution" => stem(directory),
            (name, _) => name,
        };
        Ok(Self { name, source: path.to_path_buf(), trajectory })
    }
}

/// The differences of trajectories: each one minus each earlier one.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The trajectories, in order, in common coordinates.
    pub trajectories: Vec<NamedTrajectory>,
    /// The differences, by the earlier trajectory and then by the later one.
    pub differences: Vec<Difference>,
    /// Whether the later trajectories are aligned with the first.
    pub aligned: bool,
}

/// The difference of two trajectories of a [`Comparison`].
#[derive(Clone, Debug)]
pub struct Difference {
    /// Index of the later trajectory.
    pub of: usize,
    /// Index of the earlier trajectory, which is subtracted.
    pub from: usize,
    /// The size of the difference, for each axis.
    pub score: Score,
    /// The difference of the motion over a second; `None` if no two poses are that far apart.
    pub relative: Option<RelativeError>,
}

impl Comparison {
    /// Compares `trajectories`; with `align`, the later ones are rotated about the vertical and translated to the
    /// first, by least squares.
    ///
    /// # Errors
    /// [`LogError::Unusable`] if two have no time in common, or one is in local metres and another is not.
    pub fn of(mut trajectories: Vec<NamedTrajectory>, align: bool) -> Result<Self, LogError> {
        place(&mut trajectories, align)?;
        let mut differences = Vec::new();
        for (from, earlier) in trajectories.iter().enumerate() {
            let reference = Reference::of_trajectory(&earlier.trajectory);
            for (of, later) in trajectories.iter().enumerate().skip(from + 1) {
                let moments = &later.trajectory.solutions;
                let Some(first) = moments.first() else { continue };
                let score = score(moments, &reference, first.time);
                if score.axes.is_empty() {
                    return Err(no_overlap(Path::new(&later.name), &earlier.name));
                }
                let relative = relative_error(moments, &reference, RELATIVE_S);
                differences.push(Difference { of, from, score, relative });
            }
        }
        Ok(Self { trajectories, differences, aligned: align })
    }

    /// Name of the trajectory at `index`.
    #[must_use]
    pub fn name(&self, index: usize) -> &str {
        self.trajectories.get(index).map_or("", |one| &one.name)
    }

    /// Defects of all trajectories, one sentence each.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        self.trajectories.iter().flat_map(|one| one.trajectory.warnings.clone()).collect()
    }

    /// First and last time of all trajectories, s.
    #[must_use]
    pub fn span_s(&self) -> (f64, f64) {
        let times = self.trajectories.iter().flat_map(|one| &one.trajectory.solutions);
        let times = times.map(|solution| solution.time.seconds());
        times.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| (low.min(t), high.max(t)))
    }

    /// The differences as one JSON object.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let input: Vec<String> =
            self.trajectories.iter().map(|one| one.source.display().to_string()).collect();
        let differences =
            self.differences.iter().map(|Difference { of, from, score, relative }| {
                let sizes =
                    score.axes.iter().map(|axis| (axis.axis.name().into(), json!(axis.statistics)));
                let sizes: Map<String, Value> = sizes.collect();
                let relative = relative.as_ref().map(|relative| {
                    json!({
                        "over_s": relative.over_s,
                        "translation_m": relative.translation_m,
                        "rotation_deg": relative.rotation_deg,
                    })
                });
                json!({
                    "solution": self.name(*of),
                    "less": self.name(*from),
                    "difference": sizes,
                    "relative": relative,
                })
            });
        let (start_s, end_s) = self.span_s();
        json!({
            "tool": "hovernav",
            "version": env!("CARGO_PKG_VERSION"),
            "input": input.join(" "),
            "duration_s": end_s - start_s,
            "imu_samples": 0,
            "gps_fixes_used": 0,
            "gps_fixes_rejected": 0,
            "aligned": self.aligned,
            "differences": differences.collect::<Vec<_>>(),
            "warnings": self.warnings(),
        })
    }
}

fn no_overlap(path: &Path, other: &str) -> LogError {
    let reason = format!(
        "found no time in common with {other}, expected solutions that overlap in time. Do they use the same clock?"
    );
    LogError::Unusable { path: path.to_path_buf(), reason }
}

/// Converts all trajectories to common coordinates, and makes their names unique.
fn place(trajectories: &mut [NamedTrajectory], align: bool) -> Result<(), LogError> {
    let all_are_placed = trajectories.iter().all(|one| one.trajectory.is_placed());
    let mut first_is_local = None;
    for index in 0..trajectories.len() {
        let (earlier, rest) = trajectories.split_at_mut(index);
        let Some(NamedTrajectory { name, source, trajectory }) = rest.first_mut() else { break };
        if all_are_placed {
            trajectory.place_as_named();
        }
        let is_local = trajectory.is_local();
        if !align && is_local != *first_is_local.get_or_insert(is_local) {
            let found = match is_local {
                true => "local metres without an origin",
                false => "geographic positions",
            };
            let reason = format!("found {found}, unlike the first solution: expected --align");
            return Err(LogError::Unusable { path: source.clone(), reason });
        }
        match earlier.first() {
            Some(first) if align => {
                let reference = Reference::of_trajectory(&first.trajectory);
                if trajectory.align(&reference).is_none() {
                    return Err(no_overlap(source, &first.name));
                }
            }
            _ => trajectory.place(&NOWHERE),
        }
        if earlier.iter().any(|one| one.name == *name) {
            *name = source.display().to_string();
        }
    }
    Ok(())
}
