//! A log in memory, and faulty copies of it.

use std::fmt;
use std::path::{Path, PathBuf};

use hovernav_dataset::{LogError, Manifest};
use hovernav_toml::{copy_whole, write_whole};

use super::fault::Fault;
use super::inertial::Inertial;
use super::satellite::Satellite;
use super::table::{Table, read_text};
use super::window::Window;
use super::{aids, magnetic, setup};
use crate::noise::{Noise, Stream};

const MANIFEST: &str = "dataset.toml";
const IMU: &str = "imu.csv";
const GPS: &str = "gps.csv";
const MAG: &str = "mag.csv";
const BARO: &str = "baro.csv";
const RANGE: &str = "range.csv";
const HEADING: &str = "heading.csv";
const ROTOR: &str = "rotor.csv";
/// File with the faults of a faulty copy.
const FAULTS: &str = "faults.json";
/// Files of a dataset: one that is already in the directory would be mistaken for a file of the copy.
const OWN: [&str; 10] =
    [MANIFEST, IMU, GPS, MAG, BARO, RANGE, HEADING, ROTOR, "controls.csv", "reference.csv"];

/// Reasons why a faulty copy cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum InjectError {
    /// The log cannot be read, or the copy cannot be written.
    #[error(transparent)]
    Log(#[from] LogError),
    /// A fault in a sensor that the log lacks, or outside its time span.
    #[error("{}: fault {fault}: {reason}", log.display())]
    Unfit {
        /// The log.
        log: PathBuf,
        /// The fault.
        fault: String,
        /// Value found and value expected.
        reason: String,
    },
    /// The directory of the copy is unsuitable.
    #[error("{}: {reason}", out.display())]
    Place {
        /// The directory.
        out: PathBuf,
        /// Value found and value expected.
        reason: String,
    },
}

/// A dataset directory in memory, from which faulty copies are made.
#[derive(Clone, Debug)]
pub struct Log {
    dir: PathBuf,
    manifest_text: Option<String>,
    manifest: Manifest,
    imu: Table,
    gps: Option<Table>,
    mag: Option<Table>,
    range: Option<Table>,
    heading: Option<Table>,
}

/// An injected fault.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Made {
    /// The fault as requested.
    pub fault: String,
    /// Time window of the fault; null for the ends of the log.
    #[serde(flatten)]
    pub window: Window,
}

impl fmt::Display for Made {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Window { start_s, .. } = self.window;
        match (start_s.is_finite(), self.window.end_s()) {
            (false, _) => write!(f, "{} throughout", self.fault),
            (true, end_s) if end_s.is_finite() => {
                write!(f, "{} from {start_s:.3} s to {end_s:.3} s", self.fault)
            }
            (true, _) => write!(f, "{} from {start_s:.3} s on", self.fault),
        }
    }
}

/// A log with injected faults.
#[derive(Clone, Debug)]
pub struct FaultyLog {
    log: Log,
    /// The injected faults, in the order of the request.
    pub made: Vec<Made>,
    seed: u64,
}

impl Log {
    /// Reads the dataset in directory `dir`.
    ///
    /// # Errors
    /// [`LogError::Io`], and [`LogError::Unusable`] where the directory contains no inertial data.
    pub fn open(dir: &Path) -> Result<Self, LogError> {
        let unusable =
            |reason: &str| LogError::Unusable { path: dir.join(IMU), reason: reason.into() };
        let imu = Table::read(&dir.join(IMU))?
            .ok_or_else(|| unusable("no such file, and a dataset needs it"))?;
        let path = dir.join(MANIFEST);
        let manifest_text = path.exists().then(|| read_text(&path)).transpose();
        let manifest_text =
            manifest_text.map_err(|source| LogError::Io { path: path.clone(), source })?;
        let manifest = match &manifest_text {
            Some(text) => Manifest::parse(text, &path)?.0,
            None => Manifest::default(),
        };
        let (gps, mag) = (Table::read(&dir.join(GPS))?, Table::read(&dir.join(MAG))?);
        let (range, heading) = (Table::read(&dir.join(RANGE))?, Table::read(&dir.join(HEADING))?);
        let dir = dir.to_path_buf();
        Ok(Self { dir, manifest_text, manifest, imu, gps, mag, range, heading })
    }

    /// Time of the last inertial sample, s.
    pub(super) fn end_s(&self) -> f64 {
        self.imu.span_s().map_or(f64::NAN, |(_, last_s)| last_s)
    }

    /// A copy with `faults`, injected one after the other. The same `seed` gives the same result, and the random parts
    /// of a fault do not depend on the others.
    ///
    /// # Errors
    /// [`InjectError::Unfit`] for a fault in a sensor that the log lacks, or outside its time span.
    pub fn with_faults(&self, faults: &[Fault], seed: u64) -> Result<FaultyLog, InjectError> {
        let mut log = self.clone();
        let mut made = Vec::new();
        let mut span_s = self.imu.span_s().unwrap_or((0.0, 0.0));
        if let Some((first_s, last_s)) = self.gps.as_ref().and_then(Table::span_s) {
            span_s = (span_s.0.max(first_s), span_s.1.min(last_s));
        }
        for (place, fault) in faults.iter().enumerate() {
            // Each fault of a copy has its own random stream.
            let mut noise = Noise::new(seed ^ (place as u64) << 48, Stream::Fault);
            let window = fault.window(span_s, &mut noise);
            if window.end_s() <= span_s.0 || window.start_s > span_s.1 {
                return Err(InjectError::Unfit {
                    log: self.dir.clone(),
                    fault: fault.to_string(),
                    reason: format!(
                        "found a start at {} s, expected a time within the log, {:.3} to {:.3} s",
                        window.start_s, span_s.0, span_s.1
                    ),
                });
            }
            log.make(fault, window, &mut noise)?;
            made.push(Made { fault: fault.to_string(), window });
        }
        Ok(FaultyLog { log, made, seed })
    }

    fn make(
        &mut self,
        fault: &Fault,
        window: Window,
        noise: &mut Noise,
    ) -> Result<(), InjectError> {
        let unfit = |log: &Self, reason: &str| {
            let (log, fault, reason) = (log.dir.clone(), fault.to_string(), reason.to_owned());
            Err(InjectError::Unfit { log, fault, reason })
        };
        let Some(mut inertial) = Inertial::of(&mut self.imu) else {
            return unfit(self, "found no rates and forces, expected the columns of imu.csv");
        };
        if inertial.make(fault, window, noise) {
            return Ok(());
        }
        if aids::make_attitude(&mut self.imu, fault, window) {
            return Ok(());
        }
        if let Some(text) = &self.manifest_text
            && let Some(wrong) = setup::make(text, &self.manifest, fault, noise)
        {
            self.manifest_text = Some(wrong);
            return Ok(());
        }
        if let Some(mut satellite) = self.gps.as_mut().and_then(Satellite::of)
            && satellite.make(fault, window, noise)
        {
            return Ok(());
        }
        if let Some(range) = &mut self.range
            && aids::make_range(range, fault, window, noise)
        {
            return Ok(());
        }
        if let Some(heading) = &mut self.heading
            && aids::make_heading(heading, fault, window)
        {
            return Ok(());
        }
        let mut magnetic = magnetic::make(&mut self.imu, fault, window, &mut noise.clone());
        if let Some(mag) = &mut self.mag {
            magnetic |= magnetic::make(mag, fault, window, noise);
        }
        match magnetic {
            true => Ok(()),
            false => unfit(self, "the log has no data of the affected sensor"),
        }
    }
}

impl FaultyLog {
    /// Writes the copy to the directory `out`, which is created if necessary. The faulty files are written again, and
    /// every other file of the log is copied byte for byte. `faults.json` lists the faults with their times.
    ///
    /// # Errors
    /// [`InjectError::Place`] where `out` is the log itself or contains files that the log lacks; [`LogError::Io`].
    pub fn write(&self, out: &Path) -> Result<(), InjectError> {
        let io = |path: &Path| {
            let path = path.to_path_buf();
            move |source| LogError::Io { path, source }
        };
        let place = |reason| InjectError::Place { out: out.to_path_buf(), reason };
        std::fs::create_dir_all(out).map_err(io(out))?;
        let dir = &self.log.dir;
        if matches!((dir.canonicalize(), out.canonicalize()), (Ok(a), Ok(b)) if a == b) {
            return Err(place("the log itself, expected another directory".into()));
        }
        if let Some(file) = OWN.iter().find(|f| out.join(f).exists() && !dir.join(f).exists()) {
            return Err(place(format!(
                "found {file}, which is not in the log; expected a new directory"
            )));
        }
        for entry in std::fs::read_dir(dir).map_err(io(dir))? {
            let from = entry.map_err(io(dir))?.path();
            if let Some(name) = from.file_name().filter(|_| from.is_file()) {
                let to = out.join(name);
                copy_whole(&from, &to).map_err(io(&to))?;
            }
        }
        self.write_sensors(out)?;
        let told = serde_json::json!({ "seed": self.seed, "faults": self.made });
        let path = out.join(FAULTS);
        write_whole(&path, format!("{told:#}\n")).map_err(io(&path))?;
        Ok(())
    }

    /// Writes the files that the estimator reads, and no others.
    pub(super) fn write_sensors(&self, out: &Path) -> Result<(), LogError> {
        if let Some(text) = &self.log.manifest_text {
            let path = out.join(MANIFEST);
            write_whole(&path, text).map_err(|source| LogError::Io { path, source })?;
        }
        self.log.imu.write(&out.join(IMU))?;
        for file in [BARO, ROTOR] {
            let from = self.log.dir.join(file);
            if from.exists() {
                let path = out.join(file);
                copy_whole(&from, &path).map_err(|source| LogError::Io { path, source })?;
            }
        }
        let Log { gps, mag, range, heading, .. } = &self.log;
        for (table, file) in [(gps, GPS), (mag, MAG), (range, RANGE), (heading, HEADING)] {
            if let Some(table) = table {
                table.write(&out.join(file))?;
            }
        }
        Ok(())
    }
}
