//! Inertial samples that stay in their file.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use crate::clock::ordered::{self, Gathered, Passing, TimedRows as _};
use crate::clock::steps::ClockSteps;
use crate::clock::{Gaps, Order};
use crate::error::LogError;
use crate::manifest::axes::Reading;
use crate::sensors::imu::{Faults, ImuRows};
use crate::table::records::Place;
use crate::table::rows_of;
use hovernav::imu::ImuSample;

/// Inertial samples of an `imu.csv` that has been read once to its end. The rows to be skipped are in memory; each
/// pass reads the samples again.
#[derive(Clone, Debug)]
pub struct SampleFile {
    shared: Arc<Shared>,
    /// Further conversions, applied after the first one.
    turned: Vec<Reading>,
}

#[derive(Debug)]
struct Shared {
    dir: PathBuf,
    reading: Reading,
    order: Order,
    overview: Overview,
    /// First error of a later pass.
    failure: Mutex<Option<LogError>>,
}

/// Statistics of the samples.
#[derive(Clone, Debug, Default)]
pub(crate) struct Overview {
    pub count: usize,
    pub first: Option<ImuSample>,
    pub with_magnetic_field: usize,
    /// Time of the last sample, intervals between samples, and gaps.
    pub gaps: Gaps,
}

impl Overview {
    pub fn push(&mut self, sample: &ImuSample) {
        self.count += 1;
        self.first.get_or_insert(*sample);
        self.gaps.push(sample.time);
        self.with_magnetic_field += usize::from(sample.magnetic_field_gauss.is_some());
    }
}

/// The samples of an `imu.csv`, in memory if they are few.
pub(crate) enum Opened {
    InMemory(Vec<ImuSample>),
    InFile(SampleFile),
}

/// Reads `imu.csv` of `dir`; the samples stay in memory if there are no more than `most`.
pub(crate) fn open(
    dir: &Path,
    reading: Reading,
    most: usize,
    steps: &mut ClockSteps,
    warnings: &mut Vec<String>,
) -> Result<Opened, LogError> {
    let Gathered { made, order, rows } = ordered::gather(
        || ImuRows::open(dir, reading),
        |is_sorted| FirstReading::new(dir, if is_sorted { usize::MAX } else { most }),
        |made, line, sample| made.push(line, &sample),
        steps,
    )?;
    let FirstReading { samples, faults, overview, .. } = made;
    let (path, mut remarks) = (rows.path().to_path_buf(), rows.remarks);
    if overview.count == 0 {
        let reason = match remarks.summary() {
            none if none.is_empty() => "no rows below the header".to_string(),
            summary => format!("no usable row: {summary}"),
        };
        return Err(LogError::Unusable { path, reason });
    }
    faults.remark(&overview.gaps, &mut remarks);
    warnings.extend(remarks.into_warnings());
    let shared = Shared { dir: dir.into(), reading, order, overview, failure: Mutex::default() };
    Ok(match samples {
        Some(samples) => Opened::InMemory(samples),
        None => Opened::InFile(SampleFile { shared: Arc::new(shared), turned: Vec::new() }),
    })
}

/// Result of the first pass over the samples.
struct FirstReading {
    most: usize,
    /// The samples read; `None` if there are too many.
    samples: Option<Vec<ImuSample>>,
    faults: Faults,
    overview: Overview,
}

impl FirstReading {
    fn new(dir: &Path, most: usize) -> Self {
        // Memory for all samples is reserved at once, because a growing vector needs up to twice the memory. Nothing is
        // reserved if there seem to be too many samples.
        let expected =
            usize::try_from(rows_of(&dir.join(crate::sensors::imu::FILE))).unwrap_or(usize::MAX);
        let samples = (expected <= most).then(|| Vec::with_capacity(expected));
        Self { most, samples, faults: Faults::default(), overview: Overview::default() }
    }

    fn push(&mut self, line: u64, sample: &ImuSample) {
        self.faults.push(line, sample, "line");
        self.overview.push(sample);
        match &mut self.samples {
            Some(samples) if samples.len() < self.most => samples.push(*sample),
            samples => *samples = None,
        }
    }
}

impl SampleFile {
    /// All samples, from the first on.
    pub(crate) fn samples(&self) -> FromFile<'_> {
        FromFile::of(&self.shared, &self.turned)
    }

    pub(crate) fn overview(&self) -> &Overview {
        &self.shared.overview
    }

    /// Adds a conversion (axes, units, rejected field) of every sample. It is applied after the earlier conversions.
    pub(crate) fn turn(&mut self, reading: Reading) {
        if reading != Reading::default() {
            self.turned.push(reading);
        }
    }

    /// Whether any sample has a magnetic field that is used.
    pub(crate) fn has_field(&self) -> bool {
        let is_passed_over = self.turned.iter().any(|reading| reading.without_field);
        self.overview().with_magnetic_field > 0 && !is_passed_over
    }

    /// Checks that all later passes found the samples of the first one.
    ///
    /// # Errors
    /// The first failure: the file has changed, or can no longer be read.
    pub(crate) fn ensure_read(&self) -> Result<(), LogError> {
        let mut failure = self.shared.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure.take().map_or(Ok(()), Err)
    }
}

/// Iterator over the samples in a file. A clone opens the file itself and continues at the same sample.
pub(crate) struct FromFile<'a> {
    shared: &'a Shared,
    turned: &'a [Reading],
    /// Reader of the file, open after the first read.
    rows: Option<ImuRows>,
    /// Start of the row that was read last.
    place: Option<Place>,
    passing: Passing,
    given: usize,
}

impl<'a> FromFile<'a> {
    fn of(shared: &'a Shared, turned: &'a [Reading]) -> Self {
        Self { shared, turned, rows: None, place: None, passing: Passing::default(), given: 0 }
    }

    /// The next sample and its line.
    fn read(&mut self) -> Result<Option<(u64, ImuSample)>, LogError> {
        if self.rows.is_none() {
            let mut rows = ImuRows::open(&self.shared.dir, self.shared.reading)?;
            if let Some(place) = self.place {
                rows.resume(place)?;
            }
            self.rows = Some(rows);
        }
        let Some(rows) = &mut self.rows else { return Ok(None) };
        while let Some((line, mut sample)) = rows.next()? {
            self.place = Some(rows.place());
            if self.passing.stays(&mut sample.time, &self.shared.order) {
                self.given += 1;
                return Ok(Some((line, sample)));
            }
        }
        Ok(None)
    }

    /// Number of samples still to come.
    pub fn remaining(&self) -> usize {
        self.shared.overview.count.saturating_sub(self.given)
    }

    /// Stores the error that ended this pass early.
    fn fail(&self, error: Option<LogError>) {
        let changed = || LogError::changed(self.shared.dir.join(crate::sensors::imu::FILE));
        let mut failure = self.shared.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure.get_or_insert_with(|| error.unwrap_or_else(changed));
    }
}

impl Iterator for FromFile<'_> {
    type Item = ImuSample;

    fn next(&mut self) -> Option<ImuSample> {
        let overview = &self.shared.overview;
        // Rows that a logger has appended since are ignored.
        if self.given == overview.count {
            return None;
        }
        let found = self.read();
        let is_as_before = |sample: &ImuSample| {
            self.given < overview.count || overview.gaps.last == Some(sample.time)
        };
        match found {
            Ok(Some((_, sample))) if is_as_before(&sample) => {
                Some(self.turned.iter().fold(sample, |sample, reading| reading.applied(sample)))
            }
            other => {
                self.fail(other.err());
                None
            }
        }
    }
}

impl Clone for FromFile<'_> {
    fn clone(&self) -> Self {
        Self { rows: None, ..*self }
    }
}

impl std::fmt::Debug for FromFile<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("FromFile")
            .field("dir", &self.shared.dir)
            .field("given", &self.given)
            .finish()
    }
}
