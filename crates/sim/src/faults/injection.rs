//! A log in memory, and faulty copies of it.

use std::fmt;
use std::path::{Path, PathBuf};

use hovernav_log::{LogError, Manifest, copy_whole, write_whole};

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
/// What a faulty copy says of its faults.
const FAULTS: &str = "faults.json";
/// Files of a dataset that would be taken for the copy's own if they were there before.
const OWN: [&str; 10] =
    [MANIFEST, IMU, GPS, MAG, BARO, RANGE, HEADING, ROTOR, "controls.csv", "reference.csv"];

/// Why a log has no faulty copy.
#[derive(Debug, thiserror::Error)]
pub enum InjectError {
    /// The log cannot be read, or the copy cannot be written.
    #[error(transparent)]
    Log(#[from] LogError),
    /// A fault of something the log has not, or at a time that it has not.
    #[error("{}: fault {fault}: {reason}", log.display())]
    Unfit {
        /// The log.
        log: PathBuf,
        /// The fault.
        fault: String,
        /// What was found and expected.
        reason: String,
    },
    /// The copy's place is taken.
    #[error("{}: {reason}", out.display())]
    Place {
        /// The directory.
        out: PathBuf,
        /// What was found and expected.
        reason: String,
    },
}

/// A dataset directory in memory, to make faulty copies of.
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

/// A fault as it was made.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Made {
    /// As it was asked for.
    pub fault: String,
    /// When it is there; null for the ends of the log.
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

/// A log with faults in it.
#[derive(Clone, Debug)]
pub struct FaultyLog {
    log: Log,
    /// What was made, in the order it was asked for.
    pub made: Vec<Made>,
    seed: u64,
}

impl Log {
    /// Reads the dataset in directory `dir`.
    ///
    /// # Errors
    /// [`LogError::Io`], and [`LogError::Unusable`] where there is no inertial unit in it.
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

    /// The last moment of the inertial unit, s.
    pub(super) fn end_s(&self) -> f64 {
        self.imu.span_s().map_or(f64::NAN, |(_, last_s)| last_s)
    }

    /// A copy with `faults` in it, one after the other. The same `seed` draws the same; what one
    /// fault draws does not depend on the others.
    ///
    /// # Errors
    /// [`InjectError::Unfit`] for a fault of something the log has not, or at a time that it has not.
    pub fn with_faults(&self, faults: &[Fault], seed: u64) -> Result<FaultyLog, InjectError> {
        let mut log = self.clone();
        let mut made = Vec::new();
        let mut span_s = self.imu.span_s().unwrap_or((0.0, 0.0));
        if let Some((first_s, last_s)) = self.gps.as_ref().and_then(Table::span_s) {
            span_s = (span_s.0.max(first_s), span_s.1.min(last_s));
        }
        for (place, fault) in faults.iter().enumerate() {
            // Streams of their own for the faults of one copy.
            let mut noise = Noise::new(seed ^ (place as u64) << 48, Stream::Fault);
            let window = fault.window(span_s, &mut noise);
            if window.end_s() <= span_s.0 || window.start_s > span_s.1 {
                return Err(InjectError::Unfit {
                    log: self.dir.clone(),
                    fault: fault.to_string(),
                    reason: format!(
                        "found a start at {} s, expected a time of the log, which goes from {:.3} to {:.3} s",
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
            false => unfit(self, "the log has nothing that it could be in"),
        }
    }
}

impl FaultyLog {
    /// Writes the copy to the directory `out`, which is made if need be: the faulty files anew, every
    /// other file of the log byte for byte, and `faults.json`, which tells what was done when.
    ///
    /// # Errors
    /// [`InjectError::Place`] where `out` is the log itself or holds what the log has not;
    /// [`LogError::Io`].
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
                "found {file}, which the log has not; expected a new directory"
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

    /// Writes what the estimator reads, and nothing else.
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
