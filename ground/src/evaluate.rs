//! After landing: converts a record to a dataset and runs `hovernav estimate` and `hovernav identify` on it.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use hovernav::earth::{Geodetic, STANDARD_GRAVITY_MPS2};
use hovernav::frames::{EulerAngles, Vector};
use hovernav::gps::Fix;
use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;
use hovernav_dataset::utc::moment;
use hovernav_dataset::{Dataset, Manifest};
use serde::Serialize;

use crate::channel::Id;
use crate::record::{self, RecordError};
use crate::store::Store;

/// Longest error message shown, bytes.
const LONGEST: usize = 600;

/// The progress of an evaluation.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Job {
    /// Name of the record.
    pub record: String,
    /// The current or last step. An error starts with the name of the subcommand.
    pub words: String,
    /// Whether the evaluation is running.
    pub runs: bool,
    /// The finished pages: title, and path below `/results/`.
    pub pages: Vec<(String, String)>,
    /// Errors.
    pub faults: Vec<String>,
}

/// The last evaluation, for all clients.
pub type SharedJob = Arc<Mutex<Option<Job>>>;

/// The flight in a record as a dataset: the inertial samples, fixes and sticks in the telemetry.
///
/// The vehicle's estimator has already subtracted its bias from the angular rates. The attitude is that of the
/// estimator, relative to true north. `manifest` defines the mounting of the sensors.
#[must_use]
pub fn dataset(store: &Store, manifest: &Manifest) -> Dataset {
    let (from_s, _) = store.span().unwrap_or_default();
    let time = |time_s: f64| Time::ZERO + (time_s - from_s);
    let at = |id, time_s| store.at(id, time_s);
    let three = |ids: [Id; 3], time_s: f64, scale: f64| {
        let all = ids.map(|id| at(id, time_s) * scale);
        all.iter().all(|value| value.is_finite()).then(|| Vector::new(all[0], all[1], all[2]))
    };
    let mut dataset = Dataset { manifest: manifest.clone(), ..Dataset::default() };
    dataset.manifest.date = moment((1e9 * from_s) as i64);
    let (mut before, mut fix_before) = (None, f64::NEG_INFINITY);
    for (time_s, _) in store.series(Id::RateP).between(f64::NEG_INFINITY, f64::INFINITY) {
        let rates = three([Id::RateP, Id::RateQ, Id::RateR], time_s, 1f64.to_radians());
        let forces = three([Id::AccelX, Id::AccelY, Id::AccelZ], time_s, STANDARD_GRAVITY_MPS2);
        // In a cycle without a new sample, the telemetry repeats the previous sample.
        let measured =
            rates.zip(forces).filter(|measured| before.replace(*measured) != Some(*measured));
        if let Some((angular_rate_radps, specific_force_mps2)) = measured {
            let angles = three([Id::Roll, Id::Pitch, Id::Yaw], time_s, 1.0);
            let angles = angles.map(|angles: Vector<hovernav::frames::Body>| angles.to_array());
            let motion = Motion::Rates { angular_rate_radps, specific_force_mps2 };
            dataset.imu.push(ImuSample {
                attitude: angles.map(|[r, p, y]| EulerAngles::from_degrees(r, p, y)),
                magnetic_field_gauss: three([Id::MagX, Id::MagY, Id::MagZ], time_s, 1.0),
                ..ImuSample::new(time(time_s), motion)
            });
        }
        let sticks = [Id::StickLateral, Id::StickLongitudinal, Id::StickCollective, Id::StickPedal]
            .map(|id| 0.01 * at(id, time_s));
        if sticks.iter().all(|stick| stick.is_finite()) {
            dataset.controls.push((time(time_s), sticks.map(|stick| stick.clamp(-1.0, 1.0))));
        }
        // A fix is new if it arrived after the previous one.
        let arrival_s = time_s - at(Id::GpsAge, time_s);
        if arrival_s > fix_before + 0.15
            && let Some(fix) = fix(store, time_s, time(arrival_s - manifest.gps.latency_s))
        {
            fix_before = arrival_s;
            dataset.fixes.push(fix);
        }
    }
    dataset
}

fn fix(store: &Store, time_s: f64, valid: Time) -> Option<Fix> {
    let at = |id| store.at(id, time_s);
    let known = |value: f64| Some(value).filter(|value| value.is_finite());
    let place = [Id::GpsLatitude, Id::GpsLongitude].map(at);
    let height_m = known(at(Id::GpsHeight));
    let position = Geodetic::from_degrees(place[0], place[1], height_m.unwrap_or(0.0))?;
    let north = known(at(Id::GpsVelN)).zip(known(at(Id::GpsVelE)));
    let satellites = known(at(Id::Satellites)).map(|count| count as u8);
    let fix = Fix {
        two_dimensional: height_m.is_none(),
        horizontal_velocity_mps: north.map(|(north, east)| [north, east]),
        down_velocity_mps: known(-at(Id::GpsVelU)),
        satellites,
        ..Fix::at(valid, position)
    };
    fix.is_finite().then_some(fix)
}

/// The input of an evaluation.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// The executable `hovernav`.
    pub command: PathBuf,
    /// The record's name.
    pub name: String,
    /// The record's file.
    pub record: PathBuf,
    /// Directory of the results.
    pub results: PathBuf,
    /// Mounting of the sensors.
    pub manifest: Manifest,
}

impl Evaluation {
    /// Starts the evaluation in its own thread, unless one is running. Returns whether it started.
    pub fn spawn(self, job: &SharedJob) -> bool {
        let mut slot = job.lock().unwrap_or_else(PoisonError::into_inner);
        if slot.as_ref().is_some_and(|job| job.runs) {
            return false;
        }
        let (record, words) = (self.name.clone(), "reading the record".into());
        *slot = Some(Job { record, words, runs: true, ..Job::default() });
        drop(slot);
        let shared = Arc::clone(job);
        thread::Builder::new().name("evaluation".into()).spawn(move || self.run(&shared)).is_ok()
    }

    fn run(&self, shared: &SharedJob) {
        let tell = |change: &dyn Fn(&mut Job)| {
            if let Some(job) = &mut *shared.lock().unwrap_or_else(PoisonError::into_inner) {
                change(job);
            }
        };
        let log = match self.log() {
            Ok(log) => log,
            Err(why) => {
                return tell(&|job| {
                    job.faults.push(why.clone());
                    job.words = "cannot evaluate the record".into();
                    job.runs = false;
                });
            }
        };
        for verb in ["estimate", "identify"] {
            tell(&|job| job.words = format!("running {verb}"));
            let out = self.results.join(verb);
            let report = out.join("report.html");
            // An earlier evaluation may have left one.
            let _ = std::fs::remove_file(&report);
            let outcome = self.verb(verb, &log, &out);
            tell(&|job| {
                // A model that must not be flown is an error, and has a report.
                if report.exists() {
                    let page = format!("{}/{verb}/report.html", self.name);
                    job.pages.push((verb.to_owned(), page));
                }
                if let Err(why) = &outcome {
                    job.faults.push(format!("{verb}: {why}"));
                }
            });
        }
        tell(&|job| {
            job.words = "done".into();
            job.runs = false;
        });
    }

    /// The log to evaluate: the file itself for a flight computer's record, or a dataset for a ground station's record.
    fn log(&self) -> Result<PathBuf, String> {
        let store = match record::read(&self.record) {
            Ok((store, _)) => store,
            Err(RecordError::NotARecord { .. }) => return Ok(self.record.clone()),
            Err(error) => return Err(error.to_string()),
        };
        let manifest = Manifest { name: self.name.clone(), ..self.manifest.clone() };
        let dataset = dataset(&store, &manifest);
        if dataset.imu.is_empty() {
            return Err("found no inertial samples in the record, expected at least one".into());
        }
        let place = self.results.join("dataset");
        dataset.write(&place, &[]).map_err(|error| error.to_string())?;
        Ok(place)
    }

    fn verb(&self, verb: &str, log: &Path, out: &Path) -> Result<(), String> {
        let output = Command::new(&self.command)
            .arg(verb)
            .arg(log)
            .arg("--out")
            .arg(out)
            .stdin(Stdio::null())
            .output()
            .map_err(|error| format!("{}: {error}", self.command.display()))?;
        if output.status.success() {
            return Ok(());
        }
        let said = String::from_utf8_lossy(&output.stderr);
        let mut why = said.trim().trim_start_matches("hovernav: ").to_owned();
        if why.len() > LONGEST {
            let cut = (0..=LONGEST).rev().find(|&cut| why.is_char_boundary(cut)).unwrap_or(0);
            why.truncate(cut);
            why.push('…');
        }
        Err(why)
    }
}
